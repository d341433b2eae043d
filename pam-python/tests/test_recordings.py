from __future__ import annotations

import pickle

import numpy as np
import pytest
from conftest import PUBLISHED, driven

import pam_ode as pam


def test_the_published_run_is_read_with_its_units(run: pam.Recording) -> None:
    # data.mat: 28 027 samples at 1 kHz; F in N, x in m.
    assert len(run) == 28027
    assert np.allclose(np.diff(run.time_s), 1e-3)
    assert 0.5 < np.abs(run.displacement_mm).max() < 5.0
    assert run.pressure_flexor_kpa.min() > 101.0


def test_columns_are_views_and_cannot_be_changed(run: pam.Recording) -> None:
    x = run.displacement_mm
    assert x.base is not None and not x.flags.owndata
    assert np.shares_memory(x, run.displacement_mm)
    with pytest.raises(ValueError):
        x[0] = 1.0
    with pytest.raises(ValueError):
        x.flags.writeable = True


def test_a_column_outlives_its_recording() -> None:
    recording = driven()
    x, expected = recording.force_mn, recording.force_mn.copy()
    del recording
    assert np.array_equal(x, expected)


def test_layouts_and_dtypes_give_the_same_recording() -> None:
    time = np.arange(100) * 1e-3
    x = np.sin(time)
    pressures = np.full((100, 2), 412.0)
    plain = pam.Recording(time, x, pressures[:, 0].copy(), pressures[:, 1].copy(), 10 * x)
    strided = pam.Recording(np.repeat(time, 2)[::2], x[::-1][::-1], pressures[:, 0], pressures[:, 1], 10 * x)
    lists = pam.Recording(time.tolist(), x.tolist(), [412] * 100, [412] * 100, (10 * x).tolist())
    fortran = pam.Recording(*np.asfortranarray(np.stack([time, x, *pressures.T, 10 * x])))
    big_endian = pam.Recording(time.astype(">f8"), x, *pressures.T, 10 * x)
    for other in (strided, lists, fortran, big_endian):
        assert other == plain
    single = pam.Recording(time, x.astype(np.float32), *pressures.T, 10 * x)
    assert np.allclose(single.displacement_mm, x, atol=1e-7)


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"displacement_mm": np.zeros(99)}, pam.SettingsError, "99 samples, `time_s` has 100"),
        ({"force_n": np.zeros((100, 1))}, pam.SettingsError, "1 dimension"),
        ({"force_n": np.zeros(100, complex)}, pam.SettingsError, "complex"),
        ({"force_n": ["a"] * 100}, pam.SettingsError, "real numbers"),
        ({"time_s": np.arange(100.0)}, pam.DataError, "milliseconds"),
        ({"time_s": np.zeros(100)}, pam.DataError, "does not increase"),
        ({"pressure_flexor_kpa": np.full(100, -20.0)}, pam.DataError, "gauge"),
        ({"displacement_mm": np.full(100, np.nan)}, pam.DataError, "NaN at sample 0"),
        ({"masses_g": (0.1, -0.1)}, pam.ModelError, "extensor air mass"),
        ({"masses_g": (0.1, 0.1, 0.1)}, pam.SettingsError, "flexor, extensor"),
    ],
)
def test_wrong_columns_are_refused_by_name(change: dict, error: type[Exception], words: str) -> None:
    time = np.arange(100) * 1e-3
    columns = {
        "time_s": time,
        "displacement_mm": np.sin(time),
        "pressure_flexor_kpa": np.full(100, 412.0),
        "pressure_extensor_kpa": np.full(100, 412.0),
        "force_n": np.zeros(100),
    }
    with pytest.raises(error, match=words):
        pam.Recording(**{**columns, **change})


def test_errors_of_files_say_where(tmp_path) -> None:
    with pytest.raises(pam.DataError) as missing:
        pam.read(tmp_path / "nothing.csv")
    assert missing.value.file == str(tmp_path / "nothing.csv")
    path = tmp_path / "run.csv"
    driven().save(path)
    lines = path.read_text().splitlines()
    rows = [k for k, line in enumerate(lines) if line[:1].isdigit()]
    cells = lines[rows[4]].split(",")
    cells[1] = "oops"
    lines[rows[4]] = ",".join(cells)
    path.write_text("\n".join(lines))
    with pytest.raises(pam.DataError) as wrong:
        pam.read(path)
    assert wrong.value.line == rows[4] + 1
    assert wrong.value.column == "displacement_mm"


@pytest.mark.parametrize("suffix", ["csv", "npz"])
def test_files_round_trip(tmp_path, suffix: str, measured: pam.Recording) -> None:
    path = tmp_path / f"made.{suffix}"
    measured.save(path)
    (back,) = pam.read([path])
    assert np.allclose(back.states, measured.states, rtol=1e-12)
    assert back.masses_g == pytest.approx(measured.masses_g)


def test_recordings_are_cut_compared_and_pickled(measured: pam.Recording) -> None:
    part = measured.between(0.2, 0.4)
    assert len(part) == 100 and part.time_s[0] == 0.2
    assert measured[100:200] == part
    assert pickle.loads(pickle.dumps(measured)) == measured
    assert measured.renamed("other") != measured
    with pytest.raises(pam.SettingsError):
        measured[5:6]
    with pytest.raises(TypeError):
        iter(measured)


def test_frames_go_in_and_out(measured: pam.Recording) -> None:
    pandas = pytest.importorskip("pandas")
    frame = measured.to_pandas()
    assert list(frame.columns) == list(pam.COLUMNS)
    back = pam.Recording.from_frame(frame, name="made", masses_g=measured.masses_g)
    assert np.allclose(back.states, measured.states, rtol=1e-15)
    other = frame.rename(columns={"time_s": "t", "force_n": "F"})
    named = pam.Recording.from_frame(other, time_s="t", force_n="F")
    assert np.allclose(named.force_n, measured.force_n)
    with pytest.raises(pam.DataError, match="no column `time_s`"):
        pam.Recording.from_frame(other)
    with pytest.raises(pam.SettingsError, match="there is no column 'pressure'"):
        pam.Recording.from_frame(frame, pressure="F")
    assert isinstance(frame, pandas.DataFrame)


def test_polars_frames_go_in_and_out(measured: pam.Recording) -> None:
    pytest.importorskip("polars")
    back = pam.Recording.from_frame(measured.to_polars(), name="made", masses_g=measured.masses_g)
    assert np.allclose(back.states, measured.states, rtol=1e-15)


def test_a_missing_velocity_is_the_central_difference() -> None:
    time = np.arange(200) * 1e-3
    recording = pam.Recording(time, np.sin(5 * time), np.full(200, 400.0), np.full(200, 400.0), 0 * time)
    assert np.allclose(recording.velocity_mm_s[1:-1], 5 * np.cos(5 * time)[1:-1], atol=1e-4)


def test_notebooks_show_a_table(measured: pam.Recording) -> None:
    html = measured._repr_html_()
    assert "<table>" in html and "made" in html and "<svg" in html


def test_progress_is_reported_and_its_errors_are_raised() -> None:
    seen: list[tuple[str, float, str]] = []
    pam.read(PUBLISHED / "data.mat", progress=lambda *a: seen.append(a))
    assert seen[-1][0] == "reading" and seen[-1][1] == 1.0

    def fails(*_: object) -> None:
        raise RuntimeError("from the callback")

    with pytest.raises(RuntimeError, match="from the callback"):
        pam.read(PUBLISHED / "data.mat", progress=fails)
