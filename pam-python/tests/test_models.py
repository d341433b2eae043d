from __future__ import annotations

import pickle

import numpy as np
import pytest
from conftest import PUBLISHED, driven, network

import pam_ode as pam


def eqx_weights() -> list[np.ndarray]:
    """The published weights, read with NumPy alone: consecutive .npy records."""
    with open(PUBLISHED / "hybrid_model_puresine_16.eqx", "rb") as file:
        return [np.load(file) for _ in range(7)]


def force(weights: list[np.ndarray], x: np.ndarray) -> np.ndarray:
    """The published network, written once more."""
    w1, b1, w2, b2, w3, b3 = (w.astype(np.float64) for w in weights[:6])

    def leaky(z: np.ndarray) -> np.ndarray:
        return np.where(z > 0, z, 0.01 * z)

    return (leaky(leaky(x @ w1.T + b1) @ w2.T + b2) @ w3.T + b3)[:, 0]


def test_the_published_weights_are_the_files(published: pam.Model) -> None:
    weights = eqx_weights()
    for (w, b), k in zip(published.layers, (0, 2, 4)):
        assert np.array_equal(w, weights[k]) and np.array_equal(b, weights[k + 1])
    assert published.activation == "leaky_relu"
    p = published.physical
    # softplus of (304.64828, 8.47e7, 3.6657095) in single precision.
    assert p.mass_kg == pytest.approx(304.648, abs=1e-3)
    assert p.deformation == pytest.approx(3.690974, abs=1e-6)


def test_force_and_stiffness_are_those_of_the_network(published: pam.Model) -> None:
    random = np.random.default_rng(3)
    x, v = random.uniform(-2, 2, (2, 5, 4))
    masses = random.uniform(0.03, 0.12, (5, 4, 2))
    found = published.linearise(x, v, masses_g=masses)
    inputs = np.stack([masses[..., 0], masses[..., 1], x, v], axis=-1).reshape(-1, 4)
    weights = eqx_weights()
    assert np.allclose(found.force_n.ravel(), 1e-3 * force(weights, inputs), rtol=1e-9)
    h = 1e-7
    moved = inputs + [0, 0, h, 0]
    slope = 1e-3 * (force(weights, moved) - force(weights, inputs)) / h
    assert np.allclose(found.stiffness_n_mm.ravel(), slope, rtol=1e-4)
    # The published range, with its estimate: 127.3 N/mm at 170 kPa, 175.3 N/mm at 653 kPa.
    low = published.linearise(0.0, masses_g=(0.0315272, 0.0315272)).four_point_n_mm
    high = published.linearise(0.0, masses_g=(0.1211015, 0.1211015)).four_point_n_mm
    assert float(low) == pytest.approx(127.3, abs=0.1) and float(high) == pytest.approx(175.3, abs=0.1)


def test_sealed_air_is_isothermal(published: pam.Model) -> None:
    masses = published.sealed_masses((412.0, 300.0), displacement_mm=0.7)
    assert published.sealed_pressures(masses, 0.7) == pytest.approx((412.0, 300.0))
    p = published.physical
    volume = np.pi * (p.radius_mm + p.deformation * p.radius_mm / p.length_mm * 0.7) ** 2 * (p.length_mm - 0.7)
    assert masses[0] == pytest.approx(412.0 * volume / p.gas_coefficient, rel=1e-12)


def test_a_spring_settles_where_hookes_law_says() -> None:
    spring = pam.load("spring-damper")
    time = np.arange(6000) * 1e-3
    command = pam.Recording.at_rest(time, 412.0, 50.0)
    stiffness = spring.stiffness(0.0, masses_g=spring.sealed_masses(412.0))
    final = spring.predict(command).displacement_mm[-1]
    assert final == pytest.approx(50.0 / float(stiffness), rel=1e-3)


def test_methods_agree_and_options_are_checked(published: pam.Model) -> None:
    command = driven()
    exact = published.predict(command, method="exact").states
    stepped = published.predict(command, method="dp5", rtol=1e-9, atol=1e-9)
    assert np.abs(exact[:, 0] - stepped.states[:, 0]).max() < 1e-5
    assert stepped.evaluations > 1000
    assert np.abs(published.predict(command, method="rk4", step_ms=1.0).states - exact)[:, 0].max() < 1e-3
    for options, words in [
        ({"method": "nope"}, "unknown"),
        ({"rtol": -1.0}, "`rtol` must be positive"),
        ({"step_ms": 1.0, "rtol": 1e-3}, "not both"),
        ({"method": "rk4"}, "step_ms"),
        ({"input": "spline"}, "zoh"),
        ({"masses": "guess"}, "gas-law"),
    ]:
        with pytest.raises((pam.SettingsError, pam.ModelError), match=words):
            published.predict(command, **options)
    with pytest.raises(pam.SettingsError, match="leaky_relu or relu"):
        network("tanh").predict(command, method="exact")


def test_a_prediction_that_stops_says_where_and_keeps_what_it_has(published: pam.Model) -> None:
    time = np.arange(1000) * 1e-3
    command = pam.Recording.at_rest(time, 412.0, np.where(time > 0.5, 1e7, 0.0), name="pushed")
    with pytest.raises(pam.SolveError) as stopped:
        published.predict(command)
    e = stopped.value
    assert e.recording == "pushed" and 0.5 <= e.time_s < 0.7
    assert e.partial is not None and 500 < len(e.partial) < 700


def test_models_are_built_saved_compared_and_pickled(tmp_path) -> None:
    for activation in pam.names()["activation"]:
        model = network(activation)
        path = tmp_path / f"{activation}.safetensors"
        model.save(path)
        assert pam.load(path) == model
        assert pickle.loads(pickle.dumps(model)) == model
        assert model.activation == activation
    changed = model.with_parameters({"bias_2": model.layers[2][1] + 1})
    assert changed != model and changed.layers[2][1] == model.layers[2][1] + 1


def test_wrong_layers_are_refused() -> None:
    w, b = np.zeros((8, 4)), np.zeros(8)
    last = (np.zeros((1, 8)), np.zeros(1))
    with pytest.raises(pam.SettingsError, match=r"weights are \[outputs, inputs\]"):
        pam.Model.from_layers([(w.T, b), last])
    with pytest.raises(pam.ModelError, match="layer 0 has 8 outputs"):
        pam.Model.from_layers([(w, b), (np.zeros((1, 7)), np.zeros(1))])
    with pytest.raises(pam.ModelError, match="maps 4 inputs"):
        pam.Model.from_layers([(np.zeros((8, 3)), b), last])
    with pytest.raises(pam.ModelError, match="unknown activation"):
        pam.Model.from_layers([(w, b), last], "swish")
    with pytest.raises(pam.ModelError, match="positive"):
        pam.Model.from_layers([(w, b), last], mass_kg=-1)
    # Non-contiguous weights are read in their logical order.
    first = np.arange(32.0).reshape(4, 8).T
    assert np.array_equal(pam.Model.from_layers([(first, b), last]).layers[0][0], first)


def test_wrong_parameters_are_refused(published: pam.Model) -> None:
    with pytest.raises(pam.SettingsError, match="no parameter `weight_9`"):
        published.with_parameters({"weight_9": 0})
    with pytest.raises(pam.SettingsError, match=r"shape \[4, 96\]; the model's is \[96, 4\]"):
        published.with_parameters({"weight_0": np.zeros((4, 96))})


def test_effects_extend_a_model(published: pam.Model) -> None:
    with_friction = published.with_effects(pam.effect("coulomb_friction", force_n=20), "constant_load:force_n=-3")
    assert [e.id for e in with_friction.effects] == ["coulomb_friction", "constant_load"]
    assert with_friction.effects[0].values == {"force_n": 20.0}
    assert with_friction.parameters()["effects"].tolist() == [20.0, -3.0]
    assert with_friction.with_parameters({"effects": [10, -3]}).effects[0].values == {"force_n": 10.0}
    with pytest.raises(pam.EffectError, match="there is no effect `fricton`"):
        published.with_effects("fricton:force_n=1")
    with pytest.raises(pam.EffectError, match="force_n"):
        published.with_effects(pam.effect("coulomb_friction", force=1))
    # A push below dry friction moves nothing that stands still.
    command = driven(amplitude_n=5.0)
    load = published.predict(command).displacement_mm[0] * 0
    still = published.with_effects("coulomb_friction:force_n=200").predict(command)
    assert np.ptp(still.displacement_mm) < 1e-3 + load
    assert "coulomb_friction" in pam.effects()
    assert set(pam.effects()) <= set(pam.hidden_effects())


def test_an_evaluation_scores_the_published_run(published: pam.Model, run: pam.Recording, tmp_path) -> None:
    evaluation = published.evaluate([run])
    (score,) = evaluation.recordings
    states = published.predict(run)
    # R² and RMSE, computed once more with NumPy.
    assert score.r2.x == pytest.approx(states.r2[0], abs=1e-9)
    assert score.rmse.x == pytest.approx(states.rmse[0], rel=1e-9)
    assert score.r2.x == pytest.approx(0.70, abs=0.01)
    evaluation.report(tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text().startswith("<!DOCTYPE html>")
    assert "0.70" in evaluation._repr_html_()
    recording, predicted = evaluation.trajectory(0)
    assert recording == run and np.array_equal(predicted, states.states)
