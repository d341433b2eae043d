"""Recordings: one run of the joint with sealed muscles."""

from __future__ import annotations

import importlib
import os
from typing import Any, Iterator, Sequence, Union

import numpy as np

from . import _pam
from ._arrays import Array, ArrayLike, as_array, pair
from ._html import sparkline, table
from ._progress import Progress, shown
from .errors import DataError, SettingsError

__all__ = ["COLUMNS", "Recording", "read"]

Path = Union[str, "os.PathLike[str]"]

#: Columns of a recording, as in CSV files.
COLUMNS = (
    "time_s",
    "displacement_mm",
    "velocity_mm_s",
    "pressure_flexor_kpa",
    "pressure_extensor_kpa",
    "force_n",
)

_LABELS = {
    "displacement_mm": "displacement x (mm)",
    "velocity_mm_s": "velocity v (mm/s)",
    "pressure_flexor_kpa": "flexor pressure (kPa abs)",
    "pressure_extensor_kpa": "extensor pressure (kPa abs)",
    "force_n": "external force (N)",
}


class Recording:
    """One run of the joint: time, the state ``[x, v, P_f, P_e]`` and the external force, sample by sample.

    Units are s, mm, mm/s, kPa absolute and N. Columns are read-only views of the recording's memory; they need no copy and
    stay valid as long as they are referenced.

    Args:
        time_s: Times (s), increasing, ``[samples]``.
        displacement_mm: Tendon displacement x (mm), ``[samples]``.
        pressure_flexor_kpa: Flexor pressure (kPa absolute), ``[samples]``.
        pressure_extensor_kpa: Extensor pressure (kPa absolute), ``[samples]``.
        force_n: External force (N), positive along +x, ``[samples]``.
        velocity_mm_s: Velocity (mm/s), ``[samples]``; the central difference of the displacement if absent.
        masses_g: Sealed air of flexor and extensor (g), if it is known.
        name: Name of the recording.

    Raises:
        SettingsError: A column has another shape or dtype.
        DataError: Times do not increase, a number is not finite, a pressure is not positive (gauge instead of absolute), or
            times look like milliseconds.
    """

    __slots__ = ("_native",)

    _native: _pam.Recording

    def __init__(
        self,
        time_s: ArrayLike,
        displacement_mm: ArrayLike,
        pressure_flexor_kpa: ArrayLike,
        pressure_extensor_kpa: ArrayLike,
        force_n: ArrayLike,
        *,
        velocity_mm_s: ArrayLike | None = None,
        masses_g: ArrayLike | None = None,
        name: str = "recording",
        notes: Sequence[str] = (),
    ) -> None:
        time = as_array("time_s", time_s, 1)
        x = as_array("displacement_mm", displacement_mm, 1)
        if velocity_mm_s is None:
            if x.shape != time.shape:
                raise SettingsError(f"`displacement_mm` has {len(x)} samples, `time_s` has {len(time)}")
            if len(time) < 2:
                raise DataError(f"recording `{name}` has {len(time)} sample(s); at least two are needed")
            with np.errstate(all="ignore"):
                velocity = np.gradient(x, time)
            if not np.all(np.diff(time) > 0):
                velocity = np.zeros_like(x)  # The times are refused below.
        else:
            velocity = as_array("velocity_mm_s", velocity_mm_s, 1)
        if len(time) > 2:
            step = float(np.median(np.diff(time)))
            if step >= 0.9:
                raise DataError(
                    f"recording `{name}`: the time between samples is {step:g} s; if times are in milliseconds, divide "
                    "them by 1000"
                )
        self._native = _pam.Recording(
            name,
            time,
            x,
            velocity,
            as_array("pressure_flexor_kpa", pressure_flexor_kpa, 1),
            as_array("pressure_extensor_kpa", pressure_extensor_kpa, 1),
            1e3 * as_array("force_n", force_n, 1),
            None if masses_g is None else pair("masses_g", masses_g),
            list(notes),
        )

    @classmethod
    def _of(cls, native: _pam.Recording) -> Recording:
        self = cls.__new__(cls)
        self._native = native
        return self

    @classmethod
    def at_rest(
        cls,
        time_s: ArrayLike,
        pressures_kpa: ArrayLike,
        force_n: ArrayLike = 0.0,
        *,
        masses_g: ArrayLike | None = None,
        name: str = "command",
    ) -> Recording:
        """A recording to predict along: at rest at x = 0 under two pressures (kPa absolute), then driven by a force (N)."""
        time = as_array("time_s", time_s, 1)
        flexor, extensor = pair("pressures_kpa", pressures_kpa)
        full = np.full_like(time, 1.0)
        force = np.broadcast_to(as_array("force_n", force_n), time.shape)
        return cls(
            time,
            0 * full,
            flexor * full,
            extensor * full,
            force,
            velocity_mm_s=0 * full,
            masses_g=masses_g,
            name=name,
        )

    @classmethod
    def from_frame(
        cls, frame: Any, *, name: str = "recording", masses_g: ArrayLike | None = None, **columns: str
    ) -> Recording:
        """A recording from a pandas or Polars frame with the columns :data:`COLUMNS`.

        Other names of columns are given as keywords: ``from_frame(frame, time_s="t", force_n="F")``. Units are those of the
        keyword; data in others must be converted before. A missing velocity is the central difference of the displacement.
        """
        unknown = set(columns) - set(COLUMNS)
        if unknown:
            raise SettingsError(f"there is no column {sorted(unknown)[0]!r}; there are {', '.join(COLUMNS)}")
        there = list(frame.columns)
        arrays: dict[str, Array] = {}
        for column in COLUMNS:
            of = columns.get(column, column)
            if of in there:
                arrays[column] = as_array(of, frame[of].to_numpy(), 1)
            elif column != "velocity_mm_s" or column in columns:
                raise DataError(f"the frame has no column `{of}`; it has {', '.join(map(str, there))}")
        return cls(
            arrays["time_s"],
            arrays["displacement_mm"],
            arrays["pressure_flexor_kpa"],
            arrays["pressure_extensor_kpa"],
            arrays["force_n"],
            velocity_mm_s=arrays.get("velocity_mm_s"),
            name=name,
            masses_g=masses_g,
        )

    def to_dict(self) -> dict[str, Array]:
        """The columns by name."""
        return {column: getattr(self, column) for column in COLUMNS}

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame`` with the columns :data:`COLUMNS`."""
        pandas = importlib.import_module("pandas")
        return pandas.DataFrame(self.to_dict())

    def to_polars(self) -> Any:
        """A ``polars.DataFrame`` with the columns :data:`COLUMNS`."""
        polars = importlib.import_module("polars")
        return polars.DataFrame(self.to_dict())

    def save(self, path: Path) -> None:
        """Writes the recording to a ``.csv`` or ``.npz`` file that :func:`read` reads back."""
        self._native.save(os.fspath(path))

    @property
    def name(self) -> str:
        """Name of the recording."""
        return self._native.name

    @property
    def source(self) -> str:
        """The file it was read from, or its name."""
        return self._native.source

    @property
    def notes(self) -> list[str]:
        """Notes for the reader: gaps, decisions, doubts."""
        return self._native.notes

    @property
    def preprocessing(self) -> str:
        """Processing between file and recording."""
        return self._native.preprocessing

    @property
    def masses_g(self) -> tuple[float, float] | None:
        """Sealed air of flexor and extensor (g), if the file gives it."""
        masses = self._native.masses_g
        return None if masses is None else (masses[0], masses[1])

    @property
    def time_s(self) -> Array:
        """Times, s, ``[samples]``."""
        return self._native.column("time_s")

    @property
    def displacement_mm(self) -> Array:
        """Tendon displacement x, mm, ``[samples]``."""
        return self._native.column("displacement_mm")

    @property
    def velocity_mm_s(self) -> Array:
        """Velocity, mm/s, ``[samples]``."""
        return self._native.column("velocity_mm_s")

    @property
    def pressure_flexor_kpa(self) -> Array:
        """Flexor pressure, kPa absolute, ``[samples]``."""
        return self._native.column("pressure_flexor_kpa")

    @property
    def pressure_extensor_kpa(self) -> Array:
        """Extensor pressure, kPa absolute, ``[samples]``."""
        return self._native.column("pressure_extensor_kpa")

    @property
    def force_mn(self) -> Array:
        """External force in the framework's own unit, mN, ``[samples]``."""
        return self._native.column("force_mn")

    @property
    def force_n(self) -> Array:
        """External force, N, ``[samples]`` (a copy: it is kept in mN)."""
        return 1e-3 * self.force_mn

    @property
    def states(self) -> Array:
        """The measured states ``[samples, 4]``: x (mm), v (mm/s), P_f and P_e (kPa absolute)."""
        return np.stack(
            [self.displacement_mm, self.velocity_mm_s, self.pressure_flexor_kpa, self.pressure_extensor_kpa], axis=1
        )

    def renamed(self, name: str) -> Recording:
        """The same recording with another name."""
        return Recording._of(self._native.renamed(name))

    def between(self, from_s: float, to_s: float) -> Recording:
        """The samples from one time (s) to another, the latter excluded."""
        start, end = np.searchsorted(self.time_s, [from_s, to_s])
        return self[int(start) : int(end)]

    def __len__(self) -> int:
        return len(self._native)

    def __getitem__(self, samples: slice) -> Recording:
        if not isinstance(samples, slice):
            raise TypeError("a recording is cut by a slice of samples, like recording[100:2000]")
        start, stop, step = samples.indices(len(self))
        if step != 1:
            raise SettingsError("a recording is cut in steps of one; resample the columns for others")
        return Recording._of(self._native.slice(start, stop))

    def __iter__(self) -> Iterator[Any]:
        raise TypeError("a recording is not a sequence; its columns are arrays, like recording.displacement_mm")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Recording):
            return NotImplemented
        return self.name == other.name and all(
            np.array_equal(self._native.column(c), other._native.column(c)) for c in (*COLUMNS[:5], "force_mn")
        )

    def __reduce__(self) -> Any:
        columns = [np.array(self._native.column(c)) for c in (*COLUMNS[:5], "force_mn")]
        return _restore, (self.name, columns, self.masses_g, self.notes)

    def __repr__(self) -> str:
        t = self.time_s
        return f"Recording({self.name!r}, {len(self)} samples, {t[0]:g} to {t[-1]:g} s)"

    def _repr_html_(self) -> str:
        rows = []
        for column, label in _LABELS.items():
            values = getattr(self, column)
            rows.append((label, float(values.min()), float(values.max())))
        text = table(["channel", "least", "most"], rows, repr(self))
        return text + sparkline(self.displacement_mm.tolist())

    def plot(self, axes: Any = None) -> Any:
        """Draws all channels over time with matplotlib; see :func:`pam_ode.plot.recording`."""
        from . import plot

        return plot.recording(self, axes=axes)


def _restore(name: str, columns: list[Array], masses_g: tuple[float, float] | None, notes: list[str]) -> Recording:
    time, x, v, flexor, extensor, force = columns
    return Recording._of(_pam.Recording(name, time, x, v, flexor, extensor, force, masses_g, notes))


def read(
    paths: Path | Sequence[Path],
    *,
    pressure: str = "auto",
    preprocess: bool = False,
    loader: dict[str, float] | None = None,
    rig_file: Path | None = None,
    progress: Progress = False,
) -> list[Recording]:
    """Reads the recordings of files and folders, in parallel.

    Raw logs of the rig (``nn_FFEE``), CSV and ``.npz`` files with the columns :data:`COLUMNS`, the published ``data.mat``, and,
    with a rig file, any table of a rig of your own.

    Args:
        paths: A file or folder, or several.
        pressure: The zero of pressures in CSV, ``.npz`` and ``.mat`` files: ``auto``, ``absolute`` or ``gauge``.
        preprocess: Filter CSV and ``.npz`` data like a raw log and take the velocity anew.
        loader: Constants of the loader of raw logs, like ``{"cutoff_hz": 10}``.
        rig_file: TOML file that describes columns, units and sizes of your rig.
        progress: ``True`` for a bar, or a function of (what, share, text).

    Raises:
        DataError: With ``file``, ``line`` and ``column`` where they are known.
    """
    several = [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)
    with shown(progress) as function:
        found = _pam.read(
            [os.fspath(p) for p in several],
            pressure=pressure,
            preprocess=preprocess,
            loader=[f"{key}={value}" for key, value in (loader or {}).items()],
            rig_file=None if rig_file is None else os.fspath(rig_file),
            progress=function,
        )
    return [Recording._of(r) for r in found]


def natives(recordings: Recording | Sequence[Recording]) -> list[_pam.Recording]:
    """The recordings of the extension."""
    several = [recordings] if isinstance(recordings, Recording) else list(recordings)
    for r in several:
        if not isinstance(r, Recording):
            raise SettingsError(f"a Recording is needed, not {type(r).__name__}; pam_ode.read reads files")
    return [r._native for r in several]
