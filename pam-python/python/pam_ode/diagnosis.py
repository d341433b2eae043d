"""Diagnosis: the errors of a model, their causes, and the error reduction by naming them."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import Any, Mapping, Sequence, Union

from . import _pam
from ._arrays import Array
from ._html import table
from ._options import Changes, Path, changes, optional_path
from ._progress import Progress, shown
from ._report import write
from .causes import (
    Anomaly,
    Cause,
    ChannelBand,
    CutRecording,
    Interval,
    Ladder,
    LateFault,
    NullTest,
    OnsetTest,
    Rank,
    Refused,
)
from .errors import SettingsError
from .model import Model
from .recording import Recording, natives
from .remainder import Remainder

__all__ = [
    "Anomaly",
    "Cause",
    "ChannelReduction",
    "Diagnosis",
    "Excitation",
    "Interval",
    "Ladder",
    "Refused",
    "Trace",
    "diagnose",
]


@dataclass(frozen=True)
class ChannelReduction:
    """Errors of a channel on the test set, before and after."""

    channel: str
    rmse_before: float
    rmse_after: float
    r2_before: float | None
    r2_after: float | None
    #: Confidence interval of the relative reduction.
    ci95: tuple[float, float]


@dataclass(frozen=True)
class Trace:
    """A test recording, measured, and predicted before and after."""

    name: str
    time_s: Array
    excitation: Array
    #: Arrays by channel.
    measured: dict[str, Array]
    before: dict[str, Array]
    after: dict[str, Array]


@dataclass(frozen=True)
class Excitation:
    """An experiment that separates the named cause from those it is confusable with."""

    name: str
    #: How far the causes stand apart, in multiples of the noise.
    separation: float
    #: Amplitude (N), frequency (Hz) and length (s) of each piece, ``[pieces, 3]``.
    pieces: Array


@dataclass(frozen=True)
class Diagnosis:
    """The result of a diagnosis."""

    #: The outcome in a word, like ``explained``.
    verdict: str
    #: The outcome in a sentence.
    sentence: str
    #: Named causes, the largest share of the error first.
    causes: tuple[Cause, ...]
    #: Causes that remove next to nothing of the error, or may be there by chance beside larger ones.
    minor: tuple[Cause, ...]
    #: Reasons against the verdict `explained`, in sentences.
    reasons: tuple[str, ...]
    #: Each channel of the test set beside its noise.
    bands: tuple[ChannelBand, ...]
    #: What is left that noise does not do.
    anomalies: tuple[Anomaly, ...]
    #: Candidates that are not named, the most probable first.
    refused: tuple[Refused, ...]
    #: Errors of each channel on the test set.
    channels: tuple[ChannelReduction, ...]
    #: Relative reduction of the overall error on the test set, and its confidence interval.
    error_reduction: float
    error_reduction_ci95: tuple[float, float]
    #: Every candidate alone, best first.
    ranking: tuple[Rank, ...]
    #: Logarithm of the odds of the named causes against the model without any; 0 where nothing is named.
    log_odds: float
    #: Share of the error of the test set above the noise that a flexible model without names removes.
    explainable: float
    #: Share of it that the named causes remove.
    explained: float
    #: The errors before any cause is named, in sentences.
    residual: str
    #: By how many of its samples the force acts earlier than a held one: 0 held, ½ smooth.
    force_lead_samples: float
    #: Recordings on which the model diverges, of which only the beginning is used.
    cut_recordings: tuple[CutRecording, ...]
    #: Names of the recordings that were fitted in the end.
    fitted: tuple[str, ...]
    #: The test of the best candidate against chance; ``None`` if there is no residual.
    null_test: NullTest | None
    #: The test of the best beginning or end against chance; ``None`` where none was looked for.
    onset_test: OnsetTest | None
    #: Change that the named causes make to the test set, in standard deviations, where it is too small to test them.
    untested_change: float | None
    #: What is there in the test set only.
    late_fault: LateFault | None
    #: The ladder, if one was asked for.
    ladder: Ladder | None
    #: The model of the error that remains after the named causes, if it was asked for.
    remainder: Remainder | None
    _native: _pam.Diagnosis

    @classmethod
    def _of(cls, native: _pam.Diagnosis) -> Diagnosis:
        d = json.loads(native.json())
        reduction = d["error_reduction"]
        null, onset, late = (d.get(key) for key in ("null_test", "onset_test", "late_fault"))
        ladder, remainder = d.get("ladder"), d.get("remainder")
        return cls(
            d["verdict"],
            native.sentence(),
            tuple(Cause._of(c, minor=False) for c in d["causes"]),
            tuple(Cause._of(c, minor=True) for c in d["minor"]),
            tuple(d["reasons"]),
            tuple(ChannelBand(**band) for band in d["bands"]),
            tuple(Anomaly._of(a) for a in d["anomalies"]),
            tuple(Refused(r["effect"], r["inclusion"], r["reason"]) for r in d["refused"]),
            tuple(
                ChannelReduction(
                    key, c["rmse_before"], c["rmse_after"], c["r2_before"], c["r2_after"], (c["ci95"][0], c["ci95"][1])
                )
                for key, c in ((key, reduction[key]) for key, _ in native.channels())
            ),
            reduction["overall"]["error_reduction"],
            (reduction["overall"]["ci95"][0], reduction["overall"]["ci95"][1]),
            tuple(Rank(r["effect"], r["score"], tuple(r["at_limit"])) for r in d["ranking"]),
            d["score"]["log_odds"],
            d["explainable"]["any_correction"],
            d["explainable"]["named"],
            d["residual"]["description"],
            d["force_lead_samples"],
            tuple(CutRecording(**c) for c in d["cut_recordings"]),
            tuple(d["fitted"]),
            None if null is None else NullTest(**null),
            None if onset is None else OnsetTest(**onset),
            d.get("untested_change"),
            None if late is None else LateFault._of(late),
            None if ladder is None else Ladder._of(ladder),
            None if remainder is None else Remainder._of(remainder),
            native,
        )

    @property
    def model(self) -> Model:
        """The model with the named causes, and the law or correction beside them; the given one if there are none."""
        return Model._of(self._native.model())

    @property
    def named(self) -> tuple[str, ...]:
        """Ids of the named causes."""
        return tuple(c.effect for c in self.causes)

    def to_dict(self) -> dict[str, Any]:
        """Everything as in ``diagnosis.json``."""
        found: dict[str, Any] = json.loads(self._native.json())
        return found

    def report(self, path: Path) -> None:
        """Writes the report, one self-contained HTML page."""
        write(path, self._native.report())

    def traces(self) -> list[Trace]:
        """The test recordings, measured and predicted."""
        keys = [key for key, _ in self._native.channels()]

        def named(arrays: list[Array]) -> dict[str, Array]:
            return dict(zip(keys, arrays))

        return [
            Trace(name, time, excitation, named(measured), named(before), named(after))
            for name, time, excitation, measured, before, after in self._native.traces()
        ]

    def design(self) -> list[Excitation]:
        """Experiments that separate the named cause from those it is confusable with, best first; none if it is not."""
        return [Excitation(*e) for e in self._native.design()]

    def __repr__(self) -> str:
        named = ", ".join(self.named) or "nothing"
        return f"Diagnosis({self.verdict}: {named}; error {-100 * self.error_reduction:+.0f} %)"

    def _repr_html_(self) -> str:
        rows = []
        for cause in (*self.causes, *self.minor):
            for name, interval in cause.parameters.items():
                low, high = interval.ci95
                rows.append((cause.effect, name, interval.value, low, high, cause.share_of_error_removed))
        head = ["cause", "parameter", "value", "95 % from", "to", "share of the error removed"]
        return f"<p>{self.sentence}</p>" + table(head, rows, repr(self))

    def plot(self, axes: Any = None) -> Any:
        """Draws the loops of the test recordings with matplotlib; see :func:`pam_ode.plot.diagnosis`."""
        from . import plot

        return plot.diagnosis(self, axes=axes)


def _ladder(ladder: str | Path | Sequence[str] | None) -> tuple[str, list[str]] | None:
    """The name of a ladder, and its effects where they are given by their ids."""
    if ladder is None:
        return None
    if isinstance(ladder, (str, os.PathLike)):
        return os.fspath(ladder), []
    if not ladder:
        raise SettingsError("ladder: there is no effect in it")
    return "effects", list(ladder)


def diagnose(
    model: Model,
    data: Union[Recording, Sequence[Recording]],
    *,
    held_out: Sequence[Recording] | None = None,
    baseline: Sequence[Recording] | None = None,
    effects: Sequence[str] | None = None,
    settings: Changes | None = None,
    noise: Mapping[str, float] | None = None,
    accept_implausible: bool = False,
    ladder: str | Path | Sequence[str] | None = None,
    law: bool = True,
    seed: int = 1,
    masses: str = "auto",
    surfaces: Path | None = None,
    progress: Progress = False,
) -> Diagnosis:
    """Describes the error of a model on recordings, names its causes with their sizes, and measures the error reduction.

    Args:
        model: The model.
        data: Recordings in which something may be wrong.
        held_out: Test set that no decision sees; a third of the data, or of the only recording, if absent.
        baseline: Recordings on which the model was validated: its error there counts as no fault.
        effects: Ids of the effects that may be named; all if absent.
        settings: Changes of settings, like ``{"search.max_causes": 4}``.
        noise: Known standard deviations of means over 20 ms: ``{"x": 0.004, "pf": 0.3}`` (mm, kPa).
        accept_implausible: Diagnose recordings that contradict the physics of the joint all the same.
        ladder: Models of one phenomenon that are fitted to the same data as well, from a short one to a rich one:
            ``"friction"``, a file of effects, or ids of effects.
        law: Whether to fit the error that remains after the named causes: a smooth correction, or a short formula (a law) if
            one fits as well. Without such an error it takes no time.
        seed: Seed of the null tests and the bootstrap; the setting `data.split_seed` draws the split.
        masses: How sealed air is found: ``auto``, ``gas-law`` or ``surfaces``.
        surfaces: File of single-muscle surfaces.
        progress: ``True`` for a bar, or a function of (what, share, text).

    Raises:
        DiagnoseError: There is too little data, the model diverges on them, or they contradict the physics of the joint.
    """
    known = dict(noise or {})
    deviations = tuple(known.pop(key, None) for key in ("x", "pf", "pe"))
    if known:
        raise SettingsError(f"noise: `{next(iter(known))}` is no channel; there are x, pf, pe")
    if any(d is not None and not d > 0 for d in deviations):
        raise SettingsError("noise: a standard deviation must be positive")
    with shown(progress) as function:
        native = _pam.diagnose(
            model._native,
            natives(data),
            None if held_out is None else natives(held_out),
            None if baseline is None else natives(baseline),
            effects=None if effects is None else list(effects),
            changes=changes(settings),
            noise=deviations,
            accept=accept_implausible,
            ladder=_ladder(ladder),
            law=law,
            seed=seed,
            masses=masses,
            surfaces=optional_path(surfaces),
            progress=function,
        )
    return Diagnosis._of(native)
