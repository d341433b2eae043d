from __future__ import annotations

import numpy as np
import pytest
from conftest import WEIGHTS, network

import pam_ode as pam

torch = pytest.importorskip("torch")

import pam_ode.torch  # noqa: E402


def test_value_and_gradient_are_the_frameworks(measured: pam.Recording) -> None:
    model = network("silu")
    expected = pam.value_and_gradient(model, measured)
    loss = pam_ode.torch.Loss(model, measured)
    weights = pam_ode.torch.parameters(model, torch.float64)
    value = loss(weights)
    (2 * value).backward()
    assert value.item() == expected.value
    for name, w in weights.items():
        assert np.array_equal(w.grad.numpy(), 2 * expected.gradient[name]), name
    with torch.no_grad():
        assert loss(weights).item() == expected.value
    single = loss(pam_ode.torch.parameters(model, torch.float32))
    assert single.dtype == torch.float32 and single.item() == pytest.approx(expected.value, rel=1e-3)


def test_a_loss_written_in_torch_trains_through_the_simulation(measured: pam.Recording) -> None:
    model = network("leaky_relu")
    simulation = pam_ode.torch.Simulation(model, [measured, measured[:100]])
    weights = pam_ode.torch.parameters(model, torch.float64)
    states, _ = simulation(weights)
    gap = states - torch.from_numpy(measured.states)
    value = torch.from_numpy(WEIGHTS) @ (gap**2).mean(dim=0)
    value.backward()
    expected = pam.value_and_gradient(model, measured)
    assert value.item() == pytest.approx(expected.value, rel=1e-12)
    for name, w in weights.items():
        scale = np.abs(expected.gradient[name]).max()
        assert np.allclose(w.grad.numpy(), expected.gradient[name], rtol=1e-9, atol=1e-10 * scale), name


def test_an_optimiser_trains_a_module(measured: pam.Recording) -> None:
    model = network("silu")
    module = pam_ode.torch.to_module(model, torch.float64)
    loss = pam_ode.torch.Loss(model, measured)
    optimiser = torch.optim.Adam(module.parameters(), lr=3e-3)
    values = []
    for _ in range(60):
        optimiser.zero_grad()
        value = loss(module)
        value.backward()
        torch.nn.utils.clip_grad_norm_(module.parameters(), 1.0)
        optimiser.step()
        values.append(value.item())
    assert min(values[-5:]) < 0.7 * values[0]
    trained = pam_ode.torch.from_module(module, mass_kg=model.physical.mass_kg)
    assert trained.activation == "silu"
    assert pam.value_and_gradient(trained, measured).value < 0.7 * values[0]


@pytest.mark.parametrize("activation", pam.names()["activation"])
def test_modules_convert_both_ways(activation: str) -> None:
    model = network(activation)
    module = pam_ode.torch.to_module(model, torch.float64)
    masses = np.array([0.07, 0.05])
    for x, v in [(0.3, -2.0), (-1.0, 4.0)]:
        force = model.linearise(x, v, masses_g=masses).force_n
        output = module(torch.tensor([*masses, x, v], dtype=torch.float64))
        assert output.item() == pytest.approx(1e3 * float(force), rel=1e-9)
    assert pam_ode.torch.from_module(module) == model


def test_the_slope_of_a_leaky_relu_is_kept() -> None:
    model = network("leaky_relu", slope=0.2)
    module = pam_ode.torch.to_module(model, torch.float64)
    force = model.linearise(-1.0, 4.0, masses_g=(0.07, 0.05)).force_n
    output = module(torch.tensor([0.07, 0.05, -1.0, 4.0], dtype=torch.float64))
    assert output.item() == pytest.approx(1e3 * float(force), rel=1e-9)
    back = pam_ode.torch.from_module(module)
    assert back == model and back.activation_parameters == {"slope": 0.2}


def test_other_modules_and_weights_are_refused(measured: pam.Recording) -> None:
    model = network("silu")
    loss = pam_ode.torch.Loss(model, measured)
    with pytest.raises(pam.SettingsError, match=r"it must be \[8, 8\]"):
        loss({"weight_1": torch.zeros(3, 3)})
    with pytest.raises(pam.SettingsError, match="no linear layer"):
        loss(torch.nn.ReLU())
    strange = torch.nn.Sequential(torch.nn.Linear(4, 8), torch.nn.Hardtanh(), torch.nn.Linear(8, 1))
    with pytest.raises(pam.SettingsError, match="no activation of the framework"):
        pam_ode.torch.from_module(strange)
    with pytest.raises(pam.SettingsError, match="not `tanh`"):
        pam_ode.torch.from_module(pam_ode.torch.to_module(model), "tanh")
