"""Losses and simulations for PyTorch, with exact derivatives.

    import torch, pam_ode as pam, pam_ode.torch

    network = pam_ode.torch.to_module(model)               # or a torch.nn.Sequential of your own
    loss = pam_ode.torch.Loss(model, recordings)
    value = loss(network)
    value.backward()

The work is done by the framework on the processor, in double precision, whatever precision and device the weights have.
"""

from __future__ import annotations

from typing import Any, Callable, Mapping, Sequence, Union

import numpy as np
import torch

from ._arrays import Array
from ._pytrees import check_shapes, layer_parameters
from .errors import SettingsError
from .gradients import Loss as LossChoice
from .gradients import Problem
from .model import Model
from .recording import Recording

__all__ = ["ACTIVATIONS", "Loss", "Simulation", "Sine", "from_module", "parameters", "to_module"]


class Sine(torch.nn.Module):
    """sin z."""

    def forward(self, z: torch.Tensor) -> torch.Tensor:
        """sin z, elementwise."""
        return torch.sin(z)


#: The activations of the framework as modules of PyTorch.
ACTIVATIONS: dict[str, Callable[[], torch.nn.Module]] = {
    "leaky_relu": lambda: torch.nn.LeakyReLU(0.01),
    "relu": torch.nn.ReLU,
    "tanh": torch.nn.Tanh,
    "softplus": torch.nn.Softplus,
    "silu": torch.nn.SiLU,
    "gelu": lambda: torch.nn.GELU(approximate="tanh"),
    "elu": torch.nn.ELU,
    "sine": Sine,
}

#: Weights: a dict of tensors by the names of :meth:`pam_ode.Model.parameters`, any part of it, or a module whose linear
#: layers follow each other.
Weights = Union[Mapping[str, torch.Tensor], torch.nn.Module]


def parameters(model: Model, dtype: torch.dtype | None = None) -> dict[str, torch.Tensor]:
    """The weights and biases of a model's network as leaves that require gradients."""
    found = {}
    for name, value in model.parameters().items():
        if name not in ("raw", "auxiliary_damping_kg_s", "effects"):
            tensor = torch.tensor(value, dtype=dtype or torch.get_default_dtype())
            found[name] = tensor.requires_grad_()
    return found


def _linear(module: torch.nn.Module) -> list[torch.nn.Linear]:
    return [m for m in module.modules() if isinstance(m, torch.nn.Linear)]


def _named(weights: Weights) -> dict[str, torch.Tensor]:
    if isinstance(weights, Mapping):
        return dict(weights)
    layers = _linear(weights)
    if not layers:
        raise SettingsError(f"{type(weights).__name__} has no linear layer")
    if any(layer.bias is None for layer in layers):
        raise SettingsError("every linear layer needs a bias")
    return layer_parameters([(layer.weight, layer.bias) for layer in layers])


def _array(tensor: torch.Tensor) -> Array:
    array: Array = tensor.detach().to(device="cpu", dtype=torch.float64).contiguous().numpy()
    return array


def _like(array: Array, tensor: torch.Tensor) -> torch.Tensor:
    return torch.from_numpy(np.array(array, copy=True)).to(device=tensor.device, dtype=tensor.dtype)


class _LossFunction(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, problem: Problem, names: tuple[str, ...], *tensors: torch.Tensor) -> torch.Tensor:
        given = {name: _array(t) for name, t in zip(names, tensors)}
        dtype = tensors[0].dtype if tensors else torch.get_default_dtype()
        device = tensors[0].device if tensors else torch.device("cpu")
        if not any(ctx.needs_input_grad[2:]):
            return torch.tensor(problem.value(given), dtype=dtype, device=device)
        found = problem.value_and_gradient(given)
        ctx.save_for_backward(*(_like(found.gradient[name], t) for name, t in zip(names, tensors)))
        return torch.tensor(found.value, dtype=dtype, device=device)

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, cotangent: torch.Tensor) -> tuple[torch.Tensor | None, ...]:
        return (None, None, *(cotangent.to(g) * g for g in ctx.saved_tensors))


class _StatesFunction(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any, problem: Problem, names: tuple[str, ...], *tensors: torch.Tensor
    ) -> tuple[torch.Tensor, ...]:
        ctx.problem, ctx.names = problem, names
        ctx.save_for_backward(*tensors)
        states = problem.simulate({name: _array(t) for name, t in zip(names, tensors)})
        if not tensors:
            return tuple(torch.from_numpy(s) for s in states)
        return tuple(_like(s, tensors[0]) for s in states)

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, *cotangents: torch.Tensor | None) -> tuple[torch.Tensor | None, ...]:
        tensors = ctx.saved_tensors
        given = [
            np.zeros((n, 4)) if c is None else _array(c) for c, n in zip(cotangents, ctx.problem.lengths)
        ]
        found = ctx.problem.pullback(given, {name: _array(t) for name, t in zip(ctx.names, tensors)})
        return (None, None, *(_like(found[name], t) for name, t in zip(ctx.names, tensors)))


class Loss:
    """The mean loss on recordings as a function of weights, with the exact gradient of the framework.

    Args:
        model: A model, or a :class:`pam_ode.Problem`.
        recordings: The recordings.
        loss: The loss; see :data:`pam_ode.gradients.Loss`.
        **options: As :class:`pam_ode.Problem`.
    """

    def __init__(
        self,
        model: Model | Problem,
        recordings: Recording | Sequence[Recording] | None = None,
        loss: LossChoice = "published",
        **options: Any,
    ) -> None:
        #: The problem.
        self.problem: Problem = _problem(model, recordings, loss, options)

    def __call__(self, weights: Weights) -> torch.Tensor:
        """The loss at weights (see :data:`Weights`); parameters that are not in them are the model's."""
        named = _named(weights)
        check_shapes(self.problem, named)
        result: torch.Tensor = _LossFunction.apply(self.problem, tuple(named), *named.values())
        return result


class Simulation:
    """The predicted states of recordings as a function of weights: a list of tensors ``[samples, 4]`` (mm, mm/s, kPa, kPa).

    It has an exact reverse derivative for any cotangents, so that a loss of your own, written in PyTorch, trains through the
    framework's solver. The backward pass solves once more. Arguments as :class:`Loss`.
    """

    def __init__(
        self,
        model: Model | Problem,
        recordings: Recording | Sequence[Recording] | None = None,
        **options: Any,
    ) -> None:
        #: The problem.
        self.problem: Problem = _problem(model, recordings, "published", options)

    def __call__(self, weights: Weights) -> list[torch.Tensor]:
        """The states at weights (see :data:`Weights`); parameters that are not in them are the model's."""
        named = _named(weights)
        check_shapes(self.problem, named)
        return list(_StatesFunction.apply(self.problem, tuple(named), *named.values()))


def _problem(
    model: Model | Problem,
    recordings: Recording | Sequence[Recording] | None,
    loss: LossChoice,
    options: dict[str, Any],
) -> Problem:
    if isinstance(model, Problem):
        if recordings is not None or options:
            raise SettingsError("a Problem has its recordings and options; give it alone")
        return model
    if recordings is None:
        raise SettingsError("recordings are missing")
    return Problem(model, recordings, loss, **options)


def to_module(model: Model, dtype: torch.dtype | None = None) -> torch.nn.Sequential:
    """The network of a model as a ``torch.nn.Sequential`` of (m_f, m_e, x, v) in g, g, mm, mm/s with the force in mN."""
    name = model.activation
    if name not in ACTIVATIONS:
        raise SettingsError(f"the activation `{name}` has no equal in PyTorch; there are {', '.join(ACTIVATIONS)}")
    parts: list[torch.nn.Module] = []
    for weight, bias in model.layers:
        if parts:
            slope = model.activation_parameters["slope"] if name == "leaky_relu" else None
            parts.append(ACTIVATIONS[name]() if slope is None else torch.nn.LeakyReLU(slope))
        layer = torch.nn.Linear(weight.shape[1], weight.shape[0], dtype=dtype or torch.get_default_dtype())
        with torch.no_grad():
            layer.weight.copy_(torch.from_numpy(np.array(weight)))
            layer.bias.copy_(torch.from_numpy(np.array(bias)))
        parts.append(layer)
    return torch.nn.Sequential(*parts)


def from_module(module: torch.nn.Module, activation: str | None = None, **physical: Any) -> Model:
    """A model whose force is the network of a module: linear layers with one activation between them.

    Args:
        module: The network, 4 inputs and 1 output; weights of single precision become double.
        activation: Name of its activation in the framework; found from the module if absent.
        **physical: As :meth:`pam_ode.Model.from_layers`.
    """
    own = [m for m in module.modules() if not isinstance(m, (torch.nn.Linear, torch.nn.Sequential)) and m is not module]
    z = torch.linspace(-3, 3, 13)
    values = [ACTIVATIONS[name]()(z) for name in ACTIVATIONS]
    found: set[str] = set()
    slopes = {part.negative_slope for part in own if isinstance(part, torch.nn.LeakyReLU)}
    if len(slopes) > 1:
        raise SettingsError(f"the module has leaky ReLUs of several slopes: {', '.join(map(str, sorted(slopes)))}")
    for part in own:
        if isinstance(part, torch.nn.LeakyReLU):
            found.add("leaky_relu")
            continue
        same = [n for n, v in zip(ACTIVATIONS, values) if torch.allclose(part(z), v, atol=1e-6)]
        if not same:
            raise SettingsError(f"{part} is no activation of the framework; there are {', '.join(ACTIVATIONS)}")
        found.add(same[0])
    if len(found) > 1:
        raise SettingsError(f"the module has several activations: {', '.join(sorted(found))}")
    if activation is None:
        if not found:
            raise SettingsError("the module shows no activation; name it")
        activation = found.pop()
    elif found and activation not in found:
        raise SettingsError(f"the module's activation is `{found.pop()}`, not `{activation}`")
    if slopes:
        physical = {"activation_parameters": {"slope": slopes.pop()}} | physical
    named = _named(module)
    count = len(named) // 2
    layers = [(_array(named[f"weight_{k}"]), _array(named[f"bias_{k}"])) for k in range(count)]
    return Model.from_layers(layers, activation, **physical)
