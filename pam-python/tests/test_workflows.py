"""From data to a trained, diagnosed and planned joint, on small problems."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from conftest import driven

import pam_ode as pam


@pytest.fixture(scope="module")
def made() -> list[pam.Recording]:
    """Recordings of a spring and a damper at three frequencies."""
    plant = pam.load("spring-damper")
    time_s = np.arange(500) * 2e-3

    def one(hz: float) -> pam.Recording:
        force = 100 * np.sin(2 * np.pi * hz * time_s)
        return plant.predict(pam.Recording.at_rest(time_s, 412.0, force)).to_recording(f"{hz} Hz")

    return [one(1.0), one(2.0), one(1.5)]


QUICK = {"model.hidden": [16], "stage.1.matching.steps": 300, "stage.2.epochs": 10}


def test_training_recovers_a_spring(made: list[pam.Recording]) -> None:
    epochs: list[pam.Epoch] = []
    shares: list[float] = []
    trained = pam.train(
        made[:2],
        QUICK,
        held_out=made[2:],
        callback=epochs.append,
        progress=lambda what, share, text: shares.append(share),
    )
    assert trained.finished and len(trained.stages) == 3
    assert trained.stages[-1].r2_held_out[0] > 0.9
    assert [e.total_epoch for e in epochs] == list(range(1, len(epochs) + 1)) and len(epochs) == len(trained.epochs)
    assert shares[-1] == 1.0 and sorted(shares) == shares
    # Scored once more, by the trained model itself.
    assert trained.model.predict(made[2]).r2[0] == pytest.approx(trained.stages[-1].r2_held_out[0], abs=0.02)
    assert trained.model.trained_on == ["1 Hz", "2 Hz"] or trained.model.trained_on == ["1.0 Hz", "2.0 Hz"]
    assert "recommended" in trained.model.provenance
    again = pam.train(made[:2], QUICK, held_out=made[2:])
    assert again.model == trained.model
    other = pam.train(made[:2], QUICK, held_out=made[2:], seed=2)
    assert other.model != trained.model


def test_training_is_stopped_resumed_and_starts_from_a_model(made: list[pam.Recording], tmp_path) -> None:
    whole = pam.train(made[:2], QUICK)
    half = pam.train(made[:2], QUICK, folder=tmp_path, callback=lambda e: e.total_epoch < len(whole.epochs) - 3)
    assert not half.finished
    rest = pam.train(made[:2], QUICK, folder=tmp_path)
    assert rest.finished and rest.model == whole.model
    further = pam.train(made[:2], QUICK, start=whole.model)
    assert further.epochs[-1].loss < 2 * whole.epochs[-1].loss


def test_training_refuses_what_makes_no_sense(made: list[pam.Recording]) -> None:
    with pytest.raises(pam.SettingsError, match="both trained on and held out"):
        pam.train(made, QUICK, held_out=made[2:])
    with pytest.raises((pam.SettingsError, pam.DataError), match="speed"):
        pam.train(made, {"speed": 3})
    with pytest.raises(pam.SettingsError, match="recommended"):
        pam.train(made, "published-by-nobody")

    def fails(epoch: pam.Epoch) -> None:
        raise RuntimeError("from the callback")

    with pytest.raises(RuntimeError, match="from the callback"):
        pam.train(made[:2], QUICK, callback=fails)


@pytest.fixture(scope="module")
def diagnosis() -> pam.Diagnosis:
    """Recordings of a spring under 12 N more than the recorded force."""
    rng = np.random.default_rng(0)
    spring = pam.load("spring-damper")
    time_s = np.arange(8000) * 2e-3
    recordings = []
    for k, kpa in enumerate((300.0, 412.0, 520.0)):
        force = 80 * np.sin(2 * np.pi * 0.5 * time_s) + 40 * np.sin(2 * np.pi * 1.3 * time_s + k)
        states = spring.predict(pam.Recording.at_rest(time_s, kpa, force + 12)).states
        states = states + rng.normal(size=states.shape) * [0.002, 0.05, 0.05, 0.05]
        x, v, pf, pe = states.T
        recordings.append(
            pam.Recording(time_s, x, pf, pe, force, velocity_mm_s=v, masses_g=spring.sealed_masses(kpa), name=f"run {k}")
        )
    seen: list[float] = []
    found = pam.diagnose(
        spring,
        recordings,
        effects=["constant_load", "viscous_damping"],
        ladder=["constant_load", "viscous_damping"],
        progress=lambda w, share, t: seen.append(share),
    )
    assert seen[-1] == pytest.approx(1.0, abs=0.11)
    return found


def test_a_diagnosis_names_a_hidden_load(diagnosis: pam.Diagnosis, tmp_path) -> None:
    assert diagnosis.named == ("constant_load",)
    (cause,) = diagnosis.causes
    interval = cause.parameters["force_n"]
    assert interval.value == pytest.approx(12.0, abs=1.0)
    assert diagnosis.error_reduction > 0.5
    assert diagnosis.model.effects[0].id == "constant_load"
    x = diagnosis.channels[0]
    assert x.channel == "x" and x.rmse_after < x.rmse_before
    trace = diagnosis.traces()[0]
    before = np.sqrt(np.mean((trace.before["x"] - trace.measured["x"]) ** 2))
    after = np.sqrt(np.mean((trace.after["x"] - trace.measured["x"]) ** 2))
    assert after < before
    diagnosis.report(tmp_path / "report.html")
    assert "constant" in (tmp_path / "report.html").read_text()
    assert "constant_load" in diagnosis._repr_html_() and "constant_load" in repr(diagnosis)
    assert diagnosis.to_dict()["verdict"] == diagnosis.verdict
    assert cause.acts is None and cause.stability_test.in_time is None and "force_n" not in cause.at_limit
    assert diagnosis.null_test is not None and diagnosis.null_test.p_value < 0.05
    assert [band.channel for band in diagnosis.bands] == ["x", "pf", "pe"] and not diagnosis.bands[0].outside
    assert diagnosis.ranking[0].effect == "constant_load" and diagnosis.log_odds > 10
    assert diagnosis.fitted and diagnosis.late_fault is None
    # Of the two models the one with the hidden load is supported.
    assert diagnosis.ladder is not None and diagnosis.ladder.supported.id == "constant_load"
    assert [rung.id for rung in diagnosis.ladder.rungs] == ["none", "constant_load", "viscous_damping"]
    assert "constant_load" in diagnosis.ladder._repr_html_()
    # The load is all that was hidden.
    assert diagnosis.remainder is not None and diagnosis.remainder.outcome == "nothing_left"
    assert diagnosis.remainder.law is None


def test_a_diagnosis_refuses_what_makes_no_sense() -> None:
    model = pam.load("spring-damper")
    with pytest.raises(pam.EffectError, match="there is no effect `fricton`"):
        pam.diagnose(model, driven(), effects=["fricton"])
    with pytest.raises(pam.SettingsError, match="x, pf, pe"):
        pam.diagnose(model, driven(), noise={"y": 1.0})
    with pytest.raises(pam.SettingsError, match="search"):
        pam.diagnose(model, driven(), settings={"search.nothing": 1})
    with pytest.raises(pam.SettingsError, match="there is no ladder `fricton`"):
        pam.diagnose(model, driven(), ladder="fricton")
    with pytest.raises(pam.SettingsError, match="no effect in it"):
        pam.diagnose(model, driven(), ladder=[])


def test_every_part_of_a_diagnosis_is_read() -> None:
    """Parts that only some diagnoses have, as `diagnosis.json` writes them."""
    from pam_ode import causes

    interval = {"value": 3.0, "ci95": [2.9, 3.1]}
    acts = {"pattern": "once", "recordings": [{"recording": "a", "acts": "begins", "onset_s": interval}]}
    late = causes.LateFault._of(
        {"effect": "backlash", "parameters": {"gap_mm": interval}, "acts": acts, "share_of_error_removed": 0.5}
    )
    assert late.acts.recordings[0].times["onset_s"].ci95 == (2.9, 3.1)
    change = {"parameter": "p", "recording": "a", "time_s": 1.0, "before": 2.0, "after": 3.0}
    between = {"parameter": "p", "values": [["a", 1.0], ["b", 2.0]], "grows_with": ["mean pressure", True]}
    test = causes.StabilityTest._of({"in_time": change, "between": between})
    assert test.in_time is not None and test.in_time.time_s == 1.0
    assert test.between is not None and test.between.values["b"] == 2.0 and test.between.grows_with[1]
    from pam_ode.remainder import Remainder

    band = {"channel": "x", "ratio": 1.0, "upper": 1.1, "learnable_share": 0.0, "learnable": False, "outside": False}
    law = {
        "expression": "force_n = c1_n_per_mm3 * x^3", "variables": ["x"], "remembers": False,
        "parameters": {"c1_n_per_mm3": interval}, "beside": [], "replaces": [{"effect": "backlash"}],
        "share_of_correction": 0.9, "similarity": 0.9, "bands": [band], "definition": "[cubic]",
    }  # fmt: skip
    correction = {
        "acts": ["force"], "terms": [["x^3", 2.0]], "prior_deviation": 1.0, "validation_share": 0.5, "p_value": 0.01,
        "depends_on": [{"on": "x", "error_ratio": 2.0, "ci95": [1.5, 2.5], "p_value": 0.0}], "confirmed": True,
    }  # fmt: skip
    ranked = {"expression": "x^3", "beside": [], "description_length": 3.0, "parameters": 1, "validation": 1.0, "log_odds": 0.0}
    found = Remainder._of(
        {"outcome": "law", "sentence": "A law.", "correction": correction, "law": law, "ranking": [ranked]}
    )
    assert found.law is not None and found.law.parameters["c1_n_per_mm3"].value == 3.0
    assert found.law.replaces == ("backlash",) and found.ranking[0].expression == "x^3"
    assert found.correction is not None and found.correction.depends_on[0].ci95 == (1.5, 2.5)
    # A line of the spectrum belongs to no recording.
    line = causes.Anomaly._of({"kind": "line", "channel": "x", "frequency_hz": 50.0, "description": "a line"})
    assert line.recording is None and line.frequency_hz == 50.0


def test_a_plan_holds_motion_and_stiffness(tmp_path) -> None:
    model = pam.load()
    plan = pam.plan(model, "sine:A=0.5,f=0.5", 150, rate_hz=100)
    # The equation of motion and the gas law, once more.
    found = model.linearise(plan.displacement_mm, plan.velocity_mm_s, masses_g=plan.masses_g)
    residual_n = model.physical.mass_kg * plan.acceleration_mm_s2 * 1e-3 + found.force_n - plan.load_n
    assert np.abs(residual_n).max() < 1e-5
    assert np.allclose(found.four_point_n_mm[plan.reached], 150, atol=1e-5)
    k = 37
    expected = model.sealed_pressures(plan.masses_g[k], plan.displacement_mm[k])
    assert plan.pressures_kpa[k] == pytest.approx(expected)
    same = pam.plan(
        model,
        plan.displacement_mm,
        150.0,
        velocity_mm_s=plan.velocity_mm_s,
        acceleration_mm_s2=plan.acceleration_mm_s2,
        rate_hz=100,
    )
    assert np.allclose(same.masses_g, plan.masses_g, rtol=1e-6)
    plan.to_csv(tmp_path / "table.csv")
    assert len((tmp_path / "table.csv").read_text().splitlines()) >= len(plan)
    plan.to_c_header(tmp_path / "table.h")
    plan.to_binary(tmp_path / "table.bin")
    plan.report(tmp_path / "report.html")
    with pytest.raises(pam.ControlError) as unreachable:
        pam.plan(model, "sine:A=40,f=2", 150)
    assert unreachable.value.time_s is not None
    with pytest.raises(pam.ControlError, match="known are sine"):
        pam.plan(model, "circle:A=1", 150)
    with pytest.raises(pam.SettingsError, match=r"shape \[3\]"):
        pam.plan(model, np.zeros(10), np.zeros(3))
    with pytest.raises(pam.SettingsError, match="without effects"):
        pam.plan(model.with_effects("constant_load:force_n=1"), "hold:x=0", 150)
    low, high = model.reachable_stiffness(0.0)[0]
    assert low < 150 < high


def test_a_rig_runs_sample_by_sample_and_by_protocol(tmp_path) -> None:
    by_tick, at_once = pam.Rig(pressures_kpa=412.0, seed=3), pam.Rig(pressures_kpa=412.0, seed=3)
    rows = [by_tick.tick(1.0) for _ in range(200)]
    samples = at_once.run(np.ones(200))
    assert [r["angle_deg"] for r in rows] == samples.angle_deg.tolist()
    assert samples.true_displacement_mm[-1] > 0.3
    # 1 A is 0.918 N m on a pulley of 6.875 mm: 133.5 N.
    assert samples.true_force_n[-1] == pytest.approx(133.5, abs=0.2)
    closed = pam.Rig()
    for _ in range(3000):
        row = closed.tick(servo_kpa=(300.0, 250.0))
    assert row["true_pressure_flexor_kpa"] == pytest.approx(300.0, abs=15.0)
    with pytest.raises(pam.SettingsError, match="-1"):
        closed.tick(valves=(2, 0))
    with pytest.raises(pam.SettingsError, match="must be"):
        closed.run(np.zeros(5), servo_kpa=np.zeros((4, 2)))

    protocol = (
        'name = "short"\nconditions = [[30, 60]]\n'
        '[[current]]\nkind = "sine"\namplitude_a = 1.0\nfrequency_hz = 1.0\nduration_s = 2.0\n'
    )
    (recording,) = pam.record(protocol, effects=["coulomb_friction:force_n=20"], folder=tmp_path / "logs")
    assert recording.name == "nn_3060" and len(recording) == pytest.approx(2000, abs=50)
    assert (tmp_path / "logs" / "truth.json").exists()
    (other,) = pam.record(protocol, conditions=[(45, 45)])
    assert other.name == "nn_4545"
    with pytest.raises((pam.RigError, pam.DataError)):
        pam.record("no-such-protocol")
    with pytest.raises(pam.PamError, match="fricton"):
        pam.record(protocol, effects=["fricton:force_n=1"])


def test_baselines_are_compared(made: list[pam.Recording], tmp_path) -> None:
    found = pam.compare([{"kind": "koopman"}, {"kind": "koopman", "name": "again"}], made[:2], held_out=made[2:])
    assert len(found.models) == 2
    for model in found.models:
        assert model.held_out_cold is not None
    found.report(tmp_path / "report.html")
    assert "tabular" in found.to_latex()
    assert "koopman" in found._repr_html_().lower()
    assert "[[model]]" in pam.comparison_example()


def test_the_program_is_in_the_package(tmp_path) -> None:
    def program(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([sys.executable, "-m", "pam_ode", *arguments], capture_output=True, text=True)

    assert program("--version").stdout.startswith("pam ")
    wrong = program("evaluate", "--nothing")
    assert wrong.returncode == 2 and "--nothing" in wrong.stderr
    missing = program("inspect", str(tmp_path / "nothing.csv"))
    assert missing.returncode == 1 and "nothing.csv" in missing.stderr


def test_optional_packages_are_imported_lazily() -> None:
    code = (
        "import sys, pam_ode\n"
        "late = {'jax', 'torch', 'pandas', 'polars', 'matplotlib', 'tqdm', 'equinox', 'optax'}\n"
        "assert not late & set(sys.modules), late & set(sys.modules)\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_figures_are_drawn(made: list[pam.Recording], diagnosis: pam.Diagnosis) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    from pam_ode import plot

    model = pam.load()
    made[0].plot()
    axes = model.predict(made[0]).plot()
    assert axes[0].lines[0].get_ydata() == pytest.approx(made[0].displacement_mm)
    plot.force_curves(model)
    pam.plan(model, "hold:x=0.2", 150, rate_hz=50).plot()
    diagnosis.plot()
    model.evaluate(made[0]).plot()
    matplotlib.pyplot.close("all")
