"""Evaluations of models on data sets."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from . import _pam
from ._arrays import Array
from ._html import table
from ._options import Path
from ._report import write
from .recording import Recording

__all__ = ["Channels", "Evaluation", "Failure", "RecordingScore", "SegmentScore"]


@dataclass(frozen=True)
class Channels:
    """A number for each channel: x (mm), v (mm/s), P_f, P_e (kPa); ``None`` where it is not defined."""

    x: float | None
    v: float | None
    pf: float | None
    pe: float | None


@dataclass(frozen=True)
class SegmentScore:
    """Scores of a stretch of one excitation frequency."""

    frequency_hz: float | None
    from_s: float
    to_s: float
    r2: Channels
    rmse: Channels
    #: Work of the force a cycle on the measured and on the predicted motion, mJ.
    loop_work_measured_mj: float | None
    loop_work_predicted_mj: float | None


@dataclass(frozen=True)
class RecordingScore:
    """Scores of one recording."""

    name: str
    samples: int
    masses_g: tuple[float, float]
    mass_origin: str
    r2: Channels
    rmse: Channels
    segments: tuple[SegmentScore, ...]
    #: The force that the model lacks on the measured motion: ``rms_n``, ``direction_n``, …
    force_balance: dict[str, Any]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Failure:
    """A recording whose prediction stopped early."""

    name: str
    why: str
    reached_s: float | None


def _score(r: dict[str, Any]) -> RecordingScore:
    segments = tuple(
        SegmentScore(
            s["frequency_hz"],
            s["from_s"],
            s["to_s"],
            Channels(**s["r2"]),
            Channels(**s["rmse"]),
            s["loop_work_measured_mj"],
            s["loop_work_predicted_mj"],
        )
        for s in r["segments"]
    )
    return RecordingScore(
        r["name"],
        r["samples"],
        (r["mass_flexor_g"], r["mass_extensor_g"]),
        r["mass_origin"],
        Channels(**r["r2"]),
        Channels(**r["rmse"]),
        segments,
        r["force_balance"],
        tuple(r["notes"]),
    )


@dataclass(frozen=True)
class Evaluation:
    """How a model predicts recordings."""

    #: Predicted recordings, in the order in which they were given.
    recordings: tuple[RecordingScore, ...]
    #: Recordings whose prediction stopped early.
    failed: tuple[Failure, ...]
    #: Channel-wise mean R² over the predicted recordings.
    r2: Channels
    #: Channel-wise mean RMSE: mm, mm/s, kPa, kPa.
    rmse: Channels
    _native: _pam.Evaluation

    @classmethod
    def _of(cls, native: _pam.Evaluation) -> Evaluation:
        data = json.loads(native.json())
        return cls(
            tuple(_score(r) for r in data["recordings"]),
            tuple(Failure(**f) for f in data["failed"]),
            Channels(**data["mean"]["r2"]),
            Channels(**data["mean"]["rmse"]),
            native,
        )

    def to_dict(self) -> dict[str, Any]:
        """Everything as in ``evaluation.json``."""
        found: dict[str, Any] = json.loads(self._native.json())
        return found

    def trajectory(self, index: int) -> tuple[Recording, Array]:
        """The ``index``-th recording and its predicted states ``[samples, 4]``."""
        return self._native.trajectory(index)

    def report(self, path: Path) -> None:
        """Writes the report, one self-contained HTML page."""
        write(path, self._native.report())

    def __repr__(self) -> str:
        x = self.r2.x
        text = "undefined" if x is None else f"{x:.4f}"
        return f"Evaluation({len(self.recordings)} recordings, {len(self.failed)} failed, mean R² of x {text})"

    def _repr_html_(self) -> str:
        head = ["recording", "R² x", "R² v", "R² P_f", "R² P_e", "RMSE x (mm)", "v (mm/s)", "P_f (kPa)", "P_e (kPa)"]

        def row(name: str, r2: Channels, rmse: Channels) -> tuple[Any, ...]:
            return (name, r2.x, r2.v, r2.pf, r2.pe, rmse.x, rmse.v, rmse.pf, rmse.pe)

        rows = [row(r.name, r.r2, r.rmse) for r in self.recordings[:30]]
        rows.append(row("mean", self.r2, self.rmse))
        return table(head, rows, repr(self))

    def plot(self, index: int = 0, axes: Any = None) -> Any:
        """Draws a measured and predicted recording with matplotlib; see :func:`pam_ode.plot.trajectory`."""
        from . import plot

        recording, states = self.trajectory(index)
        return plot.trajectory(recording, states, axes=axes)
