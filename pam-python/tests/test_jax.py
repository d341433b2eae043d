from __future__ import annotations

import numpy as np
import pytest
from conftest import WEIGHTS, network

import pam_ode as pam

jax = pytest.importorskip("jax")

import jax.numpy as jnp  # noqa: E402

import pam_ode.jax  # noqa: E402


@pytest.fixture(autouse=True)
def double_precision():
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", False)


@pytest.mark.parametrize("activation", ["leaky_relu", "silu"])
def test_value_and_gradient_are_the_frameworks(activation: str, measured: pam.Recording) -> None:
    model = network(activation)
    expected = pam.value_and_gradient(model, measured)
    loss = pam_ode.jax.loss(model, measured)
    weights = pam_ode.jax.parameters(model)
    assert set(weights) == {"weight_0", "bias_0", "weight_1", "bias_1", "weight_2", "bias_2"}
    for both in (jax.value_and_grad(loss), jax.jit(jax.value_and_grad(loss))):
        value, gradient = both(weights)
        assert float(value) == expected.value
        for name, g in gradient.items():
            assert np.array_equal(np.asarray(g), expected.gradient[name]), name
    assert float(jax.jit(loss)(weights)) == expected.value
    # The chain rule around it.
    doubled = jax.grad(lambda w: 2 * loss(jax.tree.map(lambda a: 3 * a / 3, w)))(weights)
    assert np.allclose(doubled["weight_1"], 2 * expected.gradient["weight_1"], rtol=1e-12)


def test_every_parameter_may_be_a_weight(measured: pam.Recording) -> None:
    model = network("tanh")
    problem = pam.Problem(model, [measured, measured[:200]])
    at = problem.parameters(per_recording=True)
    expected = problem.value_and_gradient(at)
    gradient = jax.jit(jax.grad(pam_ode.jax.loss(problem)))(at)
    for name, g in gradient.items():
        assert np.array_equal(np.asarray(g), expected.gradient[name]), name


def rk4_in_jax(weights, activation, masses, mass_kg: float, recording: pam.Recording, substeps: int = 1):
    """The two-state equation of motion by RK4 in a scan, with the force held between samples, and the gas by algebra."""
    force_mn = jnp.asarray(recording.force_mn)[:-1]
    h = float(recording.time_s[1] - recording.time_s[0]) / substeps

    def restoring(x, v):
        z = jnp.array([masses[0], masses[1], x, v])
        z = activation(weights["weight_0"] @ z + weights["bias_0"])
        z = activation(weights["weight_1"] @ z + weights["bias_1"])
        return (weights["weight_2"] @ z + weights["bias_2"])[0]

    def slope(y, f):
        return jnp.array([y[1], (f - restoring(y[0], y[1])) / mass_kg])

    def step(y, f):
        for _ in range(substeps):
            k1 = slope(y, f)
            k2 = slope(y + 0.5 * h * k1, f)
            k3 = slope(y + 0.5 * h * k2, f)
            k4 = slope(y + h * k3, f)
            y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return y, y

    start = jnp.array([recording.displacement_mm[0], recording.velocity_mm_s[0]])
    _, states = jax.lax.scan(step, start, force_mn)
    return jnp.concatenate([start[None], states])


def test_gradients_are_those_of_jax_through_the_same_steps(measured: pam.Recording) -> None:
    """JAX's own reverse mode through RK4 at the framework's steps."""
    model = network("silu")
    masses = measured.masses_g
    p = model.physical
    x, v = jnp.asarray(measured.displacement_mm), jnp.asarray(measured.velocity_mm_s)
    pressures = jnp.asarray(measured.states[:, 2:])

    def by_jax(weights):
        y = rk4_in_jax(weights, jax.nn.silu, masses, p.mass_kg, measured)

        def volume(x, sign):
            radius = p.radius_mm + sign * p.deformation * p.radius_mm / p.length_mm * x
            return jnp.pi * radius**2 * (p.length_mm - sign * x)

        # P(t) = P(0) + C m [1/V(x) - 1/V(x(0))].
        predicted = [
            measured.states[0, 2 + i]
            + p.gas_coefficient * masses[i] * (1 / volume(y[:, 0], sign) - 1 / volume(y[0, 0], sign))
            for i, sign in enumerate((1.0, -1.0))
        ]
        gaps = [y[:, 0] - x, y[:, 1] - v, predicted[0] - pressures[:, 0], predicted[1] - pressures[:, 1]]
        return sum(w * jnp.mean(g**2) for w, g in zip(WEIGHTS, gaps))

    weights = pam_ode.jax.parameters(model)
    ours = pam_ode.jax.loss(model, measured, method="adjoint", solver="rk4", step_ms=2.0)
    value, gradient = jax.jit(jax.value_and_grad(ours))(weights)
    its_value, its_gradient = jax.jit(jax.value_and_grad(by_jax))(weights)
    assert float(value) == pytest.approx(float(its_value), rel=1e-9)
    for name, g in gradient.items():
        scale = float(jnp.abs(its_gradient[name]).max())
        assert np.allclose(g, its_gradient[name], rtol=1e-7, atol=1e-8 * scale), name


def test_a_loss_written_in_jax_trains_through_simulate(measured: pam.Recording) -> None:
    model = network("leaky_relu")
    states = pam_ode.jax.simulate(model, measured)
    target = jnp.asarray(measured.states)

    def mine(weights):
        return jnp.asarray(WEIGHTS) @ jnp.mean((states(weights)[0] - target) ** 2, axis=0)

    weights = pam_ode.jax.parameters(model)
    value, gradient = jax.jit(jax.value_and_grad(mine))(weights)
    expected = pam.value_and_gradient(model, measured)
    assert float(value) == pytest.approx(expected.value, rel=1e-12)
    for name, g in gradient.items():
        scale = np.abs(expected.gradient[name]).max()
        assert np.allclose(g, expected.gradient[name], rtol=1e-9, atol=1e-10 * scale), name


def test_single_precision_and_vmap(measured: pam.Recording) -> None:
    jax.config.update("jax_enable_x64", False)
    model = network("silu")
    loss = pam_ode.jax.loss(model, measured)
    weights = pam_ode.jax.parameters(model)
    value, gradient = jax.jit(jax.value_and_grad(loss))(weights)
    assert value.dtype == jnp.float32 and gradient["weight_1"].dtype == jnp.float32
    assert float(value) == pytest.approx(pam.value_and_gradient(model, measured).value, rel=1e-3)
    stacked = jax.tree.map(lambda a: jnp.stack([a, 1.01 * a]), weights)
    values, gradients = jax.vmap(jax.value_and_grad(loss))(stacked)
    assert values.shape == (2,) and float(values[0]) == float(value)
    assert np.array_equal(gradients["weight_1"][0], gradient["weight_1"])


def test_wrong_weights_and_forward_mode_are_refused(measured: pam.Recording) -> None:
    model = network("silu")
    loss = pam_ode.jax.loss(model, measured)
    weights = pam_ode.jax.parameters(model)
    with pytest.raises(pam.SettingsError, match=r"it must be \[8, 8\]"):
        loss({"weight_1": jnp.zeros((8, 4))})
    with pytest.raises(pam.SettingsError, match="no parameter `w`"):
        jax.jit(loss)({"w": jnp.zeros(3)})
    with pytest.raises(TypeError, match="forward-mode"):
        jax.jvp(loss, (weights,), (weights,))
    with pytest.raises(pam.SettingsError, match="dict of arrays or an Equinox MLP"):
        loss([1.0])


def test_optax_trains(measured: pam.Recording) -> None:
    optax = pytest.importorskip("optax")
    model = network("silu")
    loss = pam_ode.jax.loss(model, measured)
    weights = pam_ode.jax.parameters(model)
    optimiser = optax.chain(optax.clip_by_global_norm(1.0), optax.adam(3e-3))

    @jax.jit
    def step(weights, state):
        value, gradient = jax.value_and_grad(loss)(weights)
        change, state = optimiser.update(gradient, state)
        return optax.apply_updates(weights, change), state, value

    state, values = optimiser.init(weights), []
    for _ in range(60):
        weights, state, value = step(weights, state)
        values.append(float(value))
    assert min(values[-5:]) < 0.7 * values[0]
    trained = model.with_parameters(weights)
    assert pam.value_and_gradient(trained, measured).value < 0.7 * values[0]


@pytest.mark.parametrize("activation", pam.names()["activation"])
def test_equinox_modules_convert_both_ways(activation: str, measured: pam.Recording) -> None:
    equinox = pytest.importorskip("equinox")
    model = network(activation)
    mlp = pam_ode.jax.to_equinox(model)
    masses = np.array([0.07, 0.05])
    for x, v in [(0.3, -2.0), (-1.0, 4.0)]:
        force = model.linearise(x, v, masses_g=masses).force_n
        assert float(mlp(jnp.array([*masses, x, v]))[0]) == pytest.approx(1e3 * float(force), rel=1e-9)
    back = pam_ode.jax.from_equinox(mlp, activation)
    assert back == model
    other = "tanh" if activation != "tanh" else "silu"
    with pytest.raises(pam.SettingsError, match="other values"):
        pam_ode.jax.from_equinox(mlp, other)
    value, gradient = equinox.filter_value_and_grad(pam_ode.jax.loss(model, measured[:100]))(mlp)
    expected = pam.value_and_gradient(model, measured[:100])
    assert float(value) == expected.value
    assert np.array_equal(gradient.layers[1].weight, expected.gradient["weight_1"])


def test_the_slope_of_a_leaky_relu_is_kept() -> None:
    pytest.importorskip("equinox")
    model = network("leaky_relu", slope=0.2)
    mlp = pam_ode.jax.to_equinox(model)
    force = model.linearise(-1.0, 4.0, masses_g=(0.07, 0.05)).force_n
    assert float(mlp(jnp.array([0.07, 0.05, -1.0, 4.0]))[0]) == pytest.approx(1e3 * float(force), rel=1e-9)
    assert pam_ode.jax.from_equinox(mlp, "leaky_relu", activation_parameters={"slope": 0.2}) == model
    with pytest.raises(pam.SettingsError, match="other values"):
        pam_ode.jax.from_equinox(mlp, "leaky_relu")
