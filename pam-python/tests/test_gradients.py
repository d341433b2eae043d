from __future__ import annotations

import threading
import time

import numpy as np
import pytest
from conftest import WEIGHTS, driven, network

import pam_ode as pam

def loss_of(states: np.ndarray, measured: pam.Recording) -> float:
    return float(WEIGHTS @ np.mean((states - measured.states) ** 2, axis=0))


@pytest.mark.parametrize("activation", ["leaky_relu", "silu", "gelu", "sine"])
def test_gradients_are_those_of_differences(activation: str, measured: pam.Recording) -> None:
    model = network(activation)
    problem = pam.Problem(model, measured, method="adjoint", solver="rk4", step_ms=2.0)
    found = problem.value_and_gradient()
    at = problem.parameters(per_recording=True)
    assert found.value == pytest.approx(loss_of(problem.simulate()[0], measured), rel=1e-12)
    random = np.random.default_rng(1)
    for name, values in at.items():
        if name == "auxiliary_damping_kg_s":
            direction, h = np.array(1.0), 1e-2
        else:
            direction = random.normal(size=values.shape) * np.maximum(np.abs(values), 1e-3)
            h = 1e-6
        plus = problem.value({name: values + h * direction})
        minus = problem.value({name: values - h * direction})
        slope = (plus - minus) / (2 * h)
        exact = float(np.sum(found.gradient[name] * direction))
        assert exact == pytest.approx(slope, rel=2e-3, abs=1e-6 * found.value), name


def test_methods_agree(measured: pam.Recording) -> None:
    model = network("tanh")
    options = {"solver": "rk4", "step_ms": 2.0}
    gradients = {
        method: pam.value_and_gradient(model, measured, method=method, **options).gradient
        for method in ("adjoint", "forward", "tape")
        if method in pam.names()["method"]
    }
    assert len(gradients) >= 2
    first = gradients.pop("adjoint")
    for other in gradients.values():
        for name, values in first.items():
            assert np.allclose(other[name], values, rtol=1e-7, atol=1e-9 * np.abs(values).max(initial=0.0)), name


def test_surrogates_have_the_gradient_of_their_network(measured: pam.Recording) -> None:
    model = network("silu")
    assert "surrogate" in pam.names()["method"]
    found = pam.value_and_gradient(model, measured, method="surrogate")
    tight = pam.value_and_gradient(model, measured, method="adjoint", rtol=1e-10, atol=1e-10)
    assert found.value == pytest.approx(tight.value, rel=1e-4)
    gap = np.linalg.norm(found.gradient["weight_1"] - tight.gradient["weight_1"])
    assert gap < 1e-3 * np.linalg.norm(tight.gradient["weight_1"])
    for options in ({"rtol": 1e-6}, {"input": "cubic"}, {"precision": "f32"}, {"solver": "rk4"}):
        with pytest.raises(pam.SettingsError, match="surrogate"):
            pam.Problem(model, measured, method="surrogate", **options)


def test_a_loss_may_be_a_function_a_name_or_a_table(measured: pam.Recording) -> None:
    model = network("silu")

    def mine(recording: pam.Recording, predicted: np.ndarray) -> tuple[float, np.ndarray]:
        error = predicted - recording.states
        return float(WEIGHTS @ np.mean(error**2, axis=0)), 2 * WEIGHTS * error / len(error)

    named = pam.value_and_gradient(model, measured, "published")
    for loss in (mine, {"kind": "squared", "weights": WEIGHTS.tolist()}, "squared:weights=50/50/0.5/0.5"):
        other = pam.value_and_gradient(model, measured, loss)
        assert other.value == pytest.approx(named.value, rel=1e-12)
        assert np.allclose(other.gradient["weight_1"], named.gradient["weight_1"], rtol=1e-9)

    def raises(*_: object) -> tuple[float, np.ndarray]:
        raise ZeroDivisionError("in the loss")

    with pytest.raises(ZeroDivisionError, match="in the loss"):
        pam.value_and_gradient(model, measured, raises)
    with pytest.raises(pam.SettingsError, match=r"cotangents of shape"):
        pam.value_and_gradient(model, measured, lambda r, p: (0.0, p[:-1]))
    with pytest.raises(pam.SettingsError, match="unknown loss"):
        pam.value_and_gradient(model, measured, "cubed")


def test_a_pullback_is_the_transposed_derivative(measured: pam.Recording) -> None:
    problem = pam.Problem(network("tanh"), [measured, measured[100:300]], solver="rk4", step_ms=2.0)
    random = np.random.default_rng(5)
    cotangents = [random.normal(size=(n, 4)) for n in problem.lengths]
    back = problem.pullback(cotangents)
    weights = problem.parameters()["weight_1"]
    direction = random.normal(size=weights.shape)
    h = 1e-6
    plus = problem.simulate({"weight_1": weights + h * direction})
    minus = problem.simulate({"weight_1": weights - h * direction})
    forward = sum(float(np.sum(c * (p - m))) / (2 * h) for c, p, m in zip(cotangents, plus, minus))
    assert float(np.sum(back["weight_1"] * direction)) == pytest.approx(forward, rel=1e-5)
    with pytest.raises(pam.SettingsError, match="states have"):
        problem.pullback([c[:-1] for c in cotangents])


def test_effects_have_gradients(measured: pam.Recording) -> None:
    model = network("tanh").with_effects("viscous_damping:coefficient_ns_m=500", "constant_load:force_n=2")
    problem = pam.Problem(model, measured)
    found = problem.value_and_gradient()
    at, h = problem.parameters()["effects"], np.array([1e-2, 1e-4])
    for k in range(2):
        step = np.eye(2)[k] * h
        slope = (problem.value({"effects": at + step}) - problem.value({"effects": at - step})) / (2 * h[k])
        assert found.gradient["effects"][k] == pytest.approx(slope, rel=1e-3)


def test_recordings_that_stop_are_left_out_with_a_warning() -> None:
    # A force that pushes away at positive x, and nothing at negative x: what is pushed along +x explodes.
    layers = [(np.array([[0.0, 0.0, 1.0, 0.0]]), np.zeros(1)), (np.array([[-1e12]]), np.zeros(1))]
    model = pam.Model.from_layers(layers, "relu")
    time_s = np.arange(200) * 2e-3
    calm = pam.Recording.at_rest(time_s, 412.0, -1.0, name="calm")
    wild = pam.Recording.at_rest(time_s, 412.0, np.where(time_s > 0.1, 1.0, 0.0), name="wild")
    options = {"method": "adjoint", "solver": "tsit5"}
    alone = pam.value_and_gradient(model, calm, **options)
    with pytest.warns(pam.PamWarning, match="wild"):
        both = pam.value_and_gradient(model, [calm, wild], **options)
    assert both.value == pytest.approx(alone.value, rel=1e-12)
    assert both.stopped[0].name == "wild" and 0.1 < both.stopped[0].time_s < 0.2
    assert np.isnan(both.values[1])
    with pytest.raises(pam.SolveError) as stopped:
        pam.value_and_gradient(model, wild, **options)
    assert stopped.value.recording == "wild" and stopped.value.time_s == both.stopped[0].time_s
    with pytest.raises(pam.SolveError, match="wild"):
        pam.simulate(model, [calm, wild], **options)


def test_wrong_arguments_are_refused(measured: pam.Recording) -> None:
    model = network("silu")
    problem = pam.Problem(model, measured)
    with pytest.raises(pam.SettingsError, match="no parameter `weights`"):
        problem.value({"weights": 0})
    with pytest.raises(pam.SettingsError, match=r"shape \[8\]; it must be \[8, 8\]"):
        problem.value({"weight_1": np.zeros(8)})
    with pytest.raises(pam.SettingsError, match="object"):
        problem.value({"weight_1": np.full((8, 8), None)})
    with pytest.raises(pam.SettingsError, match="`bias_1` holds NaN"):
        problem.value({"bias_1": np.full(8, np.nan)})
    with pytest.raises(pam.SettingsError, match="unknown method `backprop`; known: auto"):
        pam.Problem(model, measured, method="backprop")
    with pytest.raises(pam.SettingsError, match="no recording"):
        pam.Problem(model, [])
    with pytest.raises(pam.SettingsError, match="a Recording is needed"):
        pam.Problem(model, ["data.mat"])
    with pytest.raises(pam.SettingsError, match="horizon_s"):
        pam.Problem(model, measured, horizon_s=0.0)
    with pytest.raises(pam.SettingsError, match="leaky_relu or relu"):
        pam.Problem(model, measured, method="exact")
    assert len(pam.Problem(model, measured, horizon_s=0.25).names) == 4


def test_non_contiguous_parameters_are_read_in_their_order(measured: pam.Recording) -> None:
    problem = pam.Problem(network("silu"), measured)
    w = problem.parameters()["weight_1"]
    expected = problem.value_and_gradient({"weight_1": w + 0.01})
    for layout in (np.asfortranarray(w + 0.01), np.repeat(w + 0.01, 2, axis=1)[:, ::2], (w + 0.01).T.copy().T):
        other = problem.value_and_gradient({"weight_1": layout})
        assert other.value == expected.value
        assert np.array_equal(other.gradient["weight_1"], expected.gradient["weight_1"])


def test_the_command_gives_the_same_gradient(tmp_path, measured: pam.Recording) -> None:
    """The program `pam gradient`, which goes another way through the framework."""
    from pam_ode import _pam

    model = network("leaky_relu")
    model.save(tmp_path / "model.safetensors")
    measured.save(tmp_path / "made.npz")
    out = tmp_path / "gradient.npz"
    arguments = ["pam", "--quiet", "gradient", "--model", str(tmp_path / "model.safetensors"), "--loss", "published"]
    assert _pam.run_program([*arguments, "--data", str(tmp_path / "made.npz"), "--out", str(out)]) == 0
    found = pam.value_and_gradient(model, pam.read(tmp_path / "made.npz"))
    theirs = np.load(out)
    assert found.value == theirs["loss"]
    for name in ("weight_0", "bias_1", "weight_2", "raw", "masses"):
        own = found.gradient["masses_g" if name == "masses" else name]
        assert np.array_equal(own, theirs[f"grad_{name}"]), name


def test_calls_do_not_hold_memory(measured: pam.Recording) -> None:
    resource = pytest.importorskip("resource")
    problem = pam.Problem(network("leaky_relu"), measured[:50])
    at = problem.parameters(per_recording=True)

    def peak() -> int:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    for _ in range(500):
        problem.value_and_gradient(at)
    before = peak()
    for _ in range(10_000):
        problem.value_and_gradient(at)
    # Kilobytes: a leak of one gradient per call would be 20 MB.
    assert peak() - before < 4096


def test_a_call_with_little_data_is_short(measured: pam.Recording) -> None:
    model = network("leaky_relu")
    problem = pam.Problem(model, measured[:2])
    at = problem.parameters()

    def shortest(call) -> float:
        times = []
        for _ in range(400):
            start = time.perf_counter()
            call()
            times.append(time.perf_counter() - start)
        return min(times)

    assert shortest(lambda: problem.value_and_gradient(at)) < 50e-6
    assert shortest(lambda: model.predict(measured[:2])) < 50e-6


def test_two_threads_compute_at_once() -> None:
    """While one thread computes, another one runs Python and computes too."""
    model = pam.load("default")
    command = driven(seconds=5.0, rate_hz=1000.0)
    problem = pam.Problem(model, [command.renamed(str(k)) for k in range(4)])
    problem.value_and_gradient()
    started, results, ticks = threading.Barrier(3), [], 0

    def work() -> None:
        started.wait()
        results.append(problem.value_and_gradient())

    threads = [threading.Thread(target=work) for _ in range(2)]
    for t in threads:
        t.start()
    started.wait()
    while any(t.is_alive() for t in threads):
        ticks += 1
        time.sleep(1e-3)
    assert ticks > 3
    assert np.array_equal(results[0].gradient["weight_1"], results[1].gradient["weight_1"])


def test_an_interrupt_ends_a_long_call() -> None:
    import signal
    import subprocess
    import sys

    # A training that would take hours.
    code = (
        # A process that was started in the background may have inherited to ignore the signal.
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "import numpy as np, pam_ode as pam\n"
        "time = np.arange(500) * 2e-3\n"
        "m = pam.load('spring-damper')\n"
        "r = m.predict(pam.Recording.at_rest(time, 412.0, 40 * np.sin(9 * time))).to_recording()\n"
        "settings = {'model.hidden': [8], 'stage.1.matching.steps': 100, 'stage.2.epochs': 1_000_000}\n"
        "try:\n"
        "    pam.train([r], settings, callback=lambda e: print('epoch', e.stage, flush=True))\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted', flush=True)\n"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    for line in process.stdout:
        if line == "epoch 2\n":
            break
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=100)
    assert out.endswith("interrupted\n") and process.returncode == 0
