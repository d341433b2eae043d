"""Losses and simulations for JAX: functions with exact derivatives that work under ``jit``, ``grad`` and ``value_and_grad``.

    import jax, optax, pam_ode as pam, pam_ode.jax

    loss = pam_ode.jax.loss(model, recordings)
    weights = pam_ode.jax.parameters(model)                # a dict of arrays; or an Equinox module
    value, gradient = jax.jit(jax.value_and_grad(loss))(weights)

The work is done by the framework on the processor, in double precision, whatever the precision of the weights; a value and
gradient take one call. ``vmap`` over weights evaluates one set after another. Forward mode (``jvp``, ``hessian``) is not there:
JAX says so.
"""

from __future__ import annotations

from typing import Any, Callable, Mapping, Sequence

import jax
import jax.numpy as jnp
import numpy as np

from ._arrays import Array
from ._pytrees import check_shapes, flatten, layer_parameters
from .errors import SettingsError
from .gradients import Loss, Problem
from .model import Model
from .recording import Recording

__all__ = ["ACTIVATIONS", "from_equinox", "loss", "parameters", "simulate", "to_equinox"]

#: The activations of the framework as functions of JAX.
ACTIVATIONS: dict[str, Callable[[Any], Any]] = {
    "leaky_relu": lambda z: jax.nn.leaky_relu(z, 0.01),
    "relu": jax.nn.relu,
    "tanh": jnp.tanh,
    "softplus": jax.nn.softplus,
    "silu": jax.nn.silu,
    "gelu": lambda z: jax.nn.gelu(z, approximate=True),
    "elu": jax.nn.elu,
    "sine": jnp.sin,
}

#: Weights: a dict of arrays by the names of :meth:`pam_ode.Model.parameters`, any part of it, or an Equinox ``MLP``.
Weights = Any


def parameters(model: Model, dtype: Any = None) -> dict[str, Any]:
    """The weights and biases of a model's network as arrays of JAX (its default precision)."""
    return {
        name: jnp.asarray(value, dtype=dtype)
        for name, value in model.parameters().items()
        if name not in ("raw", "auxiliary_damping_kg_s", "effects")
    }


def _named(weights: Weights) -> dict[str, Any]:
    if isinstance(weights, Mapping):
        return dict(weights)
    layers = getattr(weights, "layers", None)
    if layers is None:
        raise SettingsError(f"weights are a dict of arrays or an Equinox MLP, not {type(weights).__name__}")
    return layer_parameters([(layer.weight, layer.bias) for layer in layers])


def _problem(
    model: Model | Problem, recordings: Recording | Sequence[Recording] | None, loss: Loss, options: dict[str, Any]
) -> Problem:
    if isinstance(model, Problem):
        if recordings is not None or options:
            raise SettingsError("a Problem has its recordings and options; give it alone")
        return model
    if recordings is None:
        raise SettingsError("recordings are missing")
    return Problem(model, recordings, loss, **options)


def _shape(shape: tuple[int, ...], dtype: Any) -> Any:
    return jax.ShapeDtypeStruct(shape, dtype)  # type: ignore[no-untyped-call, unused-ignore]


def _shapes(values: Sequence[Any]) -> tuple[Any, ...]:
    return tuple(_shape(v.shape, v.dtype) for v in values)


def _result_dtype(arrays: Sequence[Any]) -> Any:
    return jnp.result_type(*arrays) if arrays else jnp.zeros(()).dtype


def loss(
    model: Model | Problem,
    recordings: Recording | Sequence[Recording] | None = None,
    loss: Loss = "published",
    **options: Any,
) -> Callable[[Weights], Any]:
    """The mean loss on recordings as a function of weights, with the exact gradient of the framework.

    Args:
        model: A model, or a :class:`pam_ode.Problem`.
        recordings: The recordings.
        loss: The loss; see :data:`pam_ode.gradients.Loss`.
        **options: As :class:`pam_ode.Problem`.

    Returns:
        A function of a pytree of weights (see :data:`Weights`); parameters that are not in it are the model's. Its result is a
        scalar of the precision of the weights.
    """
    problem = _problem(model, recordings, loss, options)

    def function(weights: Weights) -> Any:
        named = _named(weights)
        check_shapes(problem, named)
        names = tuple(named)
        return _loss_of(problem, names)(*(jnp.asarray(named[name]) for name in names))

    return function


def _loss_of(problem: Problem, names: tuple[str, ...]) -> Callable[..., Any]:
    def host_value(*arrays: Any) -> Array:
        return np.asarray(problem.value(flatten(names, arrays)), dtype=_numpy_dtype(arrays))

    def host_both(*arrays: Any) -> tuple[Any, ...]:
        found = problem.value_and_gradient(flatten(names, arrays))
        gradients = tuple(found.gradient[n].astype(np.asarray(a).dtype) for n, a in zip(names, arrays))
        return (np.asarray(found.value, dtype=_numpy_dtype(arrays)), *gradients)

    @jax.custom_vjp
    def value(*arrays: Any) -> Any:
        shape = _shape((), _result_dtype(arrays))
        return jax.pure_callback(host_value, shape, *arrays, vmap_method="sequential")

    def forward(*arrays: Any) -> tuple[Any, Any]:
        shapes = (_shape((), _result_dtype(arrays)), *_shapes(arrays))
        result, *gradients = jax.pure_callback(host_both, shapes, *arrays, vmap_method="sequential")
        return result, tuple(gradients)

    def backward(gradients: tuple[Any, ...], cotangent: Any) -> tuple[Any, ...]:
        return tuple((cotangent * g).astype(g.dtype) for g in gradients)

    value.defvjp(forward, backward)
    return value


def _numpy_dtype(arrays: Sequence[Any]) -> Any:
    return np.result_type(*(np.asarray(a).dtype for a in arrays)) if arrays else np.float32


def simulate(
    model: Model | Problem, recordings: Recording | Sequence[Recording] | None = None, **options: Any
) -> Callable[[Weights], list[Any]]:
    """The predicted states of recordings as a function of weights: a list of arrays ``[samples, 4]`` (mm, mm/s, kPa, kPa).

    It has an exact reverse derivative for any cotangents, so that a loss of your own, written in JAX, trains through the
    framework's solver. The backward pass solves once more.

    Args and weights as :func:`loss`; ``masses_g`` and ``initial_states`` may be among the weights.
    """
    problem = _problem(model, recordings, "published", options)
    lengths = problem.lengths

    def function(weights: Weights) -> list[Any]:
        named = _named(weights)
        check_shapes(problem, named)
        names = tuple(named)
        return list(_states_of(problem, names, lengths)(*(jnp.asarray(named[name]) for name in names)))

    return function


def _states_of(problem: Problem, names: tuple[str, ...], lengths: Sequence[int]) -> Callable[..., Any]:
    def host_states(*arrays: Any) -> tuple[Any, ...]:
        dtype = _numpy_dtype(arrays)
        return tuple(s.astype(dtype) for s in problem.simulate(flatten(names, arrays)))

    def host_pullback(arrays: Sequence[Any], cotangents: Sequence[Any]) -> tuple[Any, ...]:
        given = [np.asarray(c, dtype=np.float64) for c in cotangents]
        found = problem.pullback(given, flatten(names, arrays))
        return tuple(found[n].astype(np.asarray(a).dtype) for n, a in zip(names, arrays))

    @jax.custom_vjp
    def states(*arrays: Any) -> Any:
        dtype = _result_dtype(arrays)
        shapes = tuple(_shape((n, 4), dtype) for n in lengths)
        return jax.pure_callback(host_states, shapes, *arrays, vmap_method="sequential")

    def forward(*arrays: Any) -> tuple[Any, Any]:
        return states(*arrays), arrays

    def backward(arrays: tuple[Any, ...], cotangents: Any) -> Any:
        return jax.pure_callback(host_pullback, _shapes(arrays), arrays, cotangents, vmap_method="sequential")

    states.defvjp(forward, backward)
    return states


def to_equinox(model: Model, *, dtype: Any = None) -> Any:
    """The network of a model as an ``equinox.nn.MLP`` of (m_f, m_e, x, v) in g, g, mm, mm/s with the force ``[1]`` in mN."""
    import equinox

    layers = model.layers
    hidden = {len(bias) for _, bias in layers[:-1]}
    if len(hidden) > 1:
        raise SettingsError(f"equinox.nn.MLP has hidden layers of one width; the model's are {sorted(hidden)}")
    activation = _activation(model)
    width = hidden.pop() if hidden else 1
    mlp = equinox.nn.MLP(4, 1, width, len(layers) - 1, activation=activation, key=jax.random.PRNGKey(0))
    arrays = [(jnp.asarray(w, dtype=dtype), jnp.asarray(b, dtype=dtype)) for w, b in layers]
    flat = [a for pair in arrays for a in pair]
    return equinox.tree_at(lambda m: [a for layer in m.layers for a in (layer.weight, layer.bias)], mlp, flat)


def _activation(model: Model) -> Callable[[Any], Any]:
    name = model.activation
    if name not in ACTIVATIONS:
        raise SettingsError(f"the activation `{name}` has no equal in JAX; there are {', '.join(ACTIVATIONS)}")
    return _with_parameters(name, model.activation_parameters)


def _with_parameters(name: str, parameters: Mapping[str, Any] | None) -> Callable[[Any], Any]:
    if name == "leaky_relu" and parameters is not None:
        slope = float(parameters["slope"])
        return lambda z: jax.nn.leaky_relu(z, slope)
    return ACTIVATIONS[name]


def from_equinox(mlp: Any, activation: str, **physical: Any) -> Model:
    """A model whose force is an ``equinox.nn.MLP`` with 4 inputs and 1 output.

    Args:
        mlp: The network; weights of single precision become double.
        activation: Name of its activation in the framework, which must be the same function; it is compared at points.
        **physical: As :meth:`pam_ode.Model.from_layers`, ``activation_parameters`` among them: ``{"slope": 0.1}``.
    """
    if activation not in ACTIVATIONS:
        raise SettingsError(f"unknown activation `{activation}`; known: {', '.join(ACTIVATIONS)}")
    own = getattr(mlp, "activation", None)
    if own is not None and len(mlp.layers) > 1:
        z = jnp.linspace(-3.0, 3.0, 13)
        values = jax.vmap(own)(z)
        expected = _with_parameters(activation, physical.get("activation_parameters"))(z)
        if not bool(jnp.allclose(values, expected, atol=1e-5)):
            raise SettingsError(f"the module's activation is not `{activation}`: it has other values")
    layers = [(np.asarray(layer.weight, np.float64), np.asarray(layer.bias, np.float64)) for layer in mlp.layers]
    return Model.from_layers(layers, activation, **physical)
