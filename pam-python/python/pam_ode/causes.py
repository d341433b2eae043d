"""Parts of the result of a diagnosis: causes, when they act, tests and ladders."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

from ._html import table
from .effects import effects as known_effects

__all__ = [
    "Anomaly",
    "Cause",
    "Change",
    "ChannelBand",
    "CutRecording",
    "Difference",
    "Interval",
    "Ladder",
    "LateFault",
    "NullTest",
    "OnsetTest",
    "PartValue",
    "Rank",
    "RecordingTimes",
    "Refused",
    "Rung",
    "RungError",
    "Stability",
    "StabilityTest",
    "Times",
]

_Json = Mapping[str, Any]


@dataclass(frozen=True)
class Interval:
    """A fitted value with its confidence interval."""

    value: float
    ci95: tuple[float | None, float | None]

    @classmethod
    def _of(cls, j: _Json) -> Interval:
        return cls(j["value"], (j["ci95"][0], j["ci95"][1]))


def _intervals(j: _Json) -> dict[str, Interval]:
    return {name: Interval._of(i) for name, i in j.items()}


@dataclass(frozen=True)
class RecordingTimes:
    """When a cause acts in one recording."""

    recording: str
    #: ``always``, ``never``, ``begins``, ``ends``, ``grows`` or ``passes``.
    acts: str
    #: The times by their names, in the time of the recording (s); ``ramp_s`` is a duration.
    times: dict[str, Interval]


@dataclass(frozen=True)
class Times:
    """When a cause acts that does not always act."""

    #: ``shared``: the same times since the first sample of every recording; ``once``: it comes or goes once in the order of
    #: the recordings; ``each``: each recording has times of its own.
    pattern: str
    recordings: tuple[RecordingTimes, ...]

    @classmethod
    def _of(cls, j: _Json) -> Times:
        def one(r: _Json) -> RecordingTimes:
            times = {name: i for name, i in r.items() if name not in ("recording", "acts")}
            return RecordingTimes(r["recording"], r["acts"], _intervals(times))

        return cls(j["pattern"], tuple(one(r) for r in j["recordings"]))


@dataclass(frozen=True)
class Change:
    """A parameter that changes within a recording."""

    parameter: str
    recording: str
    time_s: float
    before: float
    after: float


@dataclass(frozen=True)
class Difference:
    """A parameter that differs between recordings."""

    parameter: str
    #: Its value by recording.
    values: dict[str, float]
    #: The condition with which it goes, and whether it grows with it.
    grows_with: tuple[str, bool] | None


@dataclass(frozen=True)
class StabilityTest:
    """Tests of a cause for one value at all times and in all recordings; ``None`` where nothing speaks against it."""

    in_time: Change | None
    between: Difference | None

    @classmethod
    def _of(cls, j: _Json) -> StabilityTest:
        change, difference = j.get("in_time"), j.get("between")
        between = None
        if difference is not None:
            grows = difference["grows_with"]
            values = {name: value for name, value in difference["values"]}
            between = Difference(difference["parameter"], values, None if grows is None else (grows[0], grows[1]))
        return cls(None if change is None else Change(**change), between)


@dataclass(frozen=True)
class PartValue:
    """The value of a parameter in a part of a recording."""

    recording: str
    start_s: float
    value: float


@dataclass(frozen=True)
class Stability:
    """One cause, fitted anew to parts of the recordings."""

    parameter: str
    parts: tuple[PartValue, ...]
    #: Half the distance of the quartiles of the parts over the size of the common value.
    relative_spread: float


@dataclass(frozen=True)
class Cause:
    """A named cause."""

    effect: str
    description: str
    #: Values by name, with units in the names.
    parameters: dict[str, Interval]
    #: Share of the error that it removes.
    share_of_error_removed: float
    #: By how much the mean square of the channel that needs it most rises without it, in variances of the channel's noise.
    rise_without: float
    #: How sure its name is: the probability that it belongs to the set of causes.
    inclusion: float
    #: Certain, but it removes next to nothing of the error.
    minor: bool
    #: Effects that these recordings cannot tell from it.
    confusable_with: tuple[str, ...]
    #: Parameters that ended at a limit of their range.
    at_limit: tuple[str, ...]
    #: Which excitation brings it out.
    excited_by: str
    #: Its value in parts of the recordings; ``None`` where there are too few.
    stability: Stability | None
    #: Whether it has one value at all times and in all recordings.
    stability_test: StabilityTest
    #: When it acts; ``None`` if always.
    acts: Times | None

    @classmethod
    def _of(cls, c: _Json, *, minor: bool) -> Cause:
        info, parts, acts = known_effects().get(c["effect"]), c["stability"], c.get("acts")
        stability = None
        if parts is not None:
            values = tuple(PartValue(*part) for part in parts["parts"])
            stability = Stability(parts["parameter"], values, parts["relative_spread"])
        return cls(
            c["effect"],
            "" if info is None else info.description,
            _intervals(c["parameters"]),
            c["share_of_error_removed"],
            c["rise_without"],
            c["inclusion"],
            minor,
            tuple(c["confusable_with"]),
            tuple(c["at_limit"]),
            c["excited_by"],
            stability,
            StabilityTest._of(c["stability_test"]),
            None if acts is None else Times._of(acts),
        )


@dataclass(frozen=True)
class Refused:
    """A candidate that is not named, and why."""

    effect: str
    inclusion: float
    reason: str


@dataclass(frozen=True)
class Rank:
    """A candidate alone."""

    effect: str
    #: Share of the whitened squared residual that it removes alone, 0 to 1.
    score: float
    #: Parameters that ended at a limit of their range.
    at_limit: tuple[str, ...]


@dataclass(frozen=True)
class LateFault:
    """What is there in the test data only, so that nothing is left to confirm it; it is no part of the model."""

    #: The effect that explains it best.
    effect: str
    parameters: dict[str, Interval]
    acts: Times
    #: Share of the squared error of the test data that it removes.
    share_of_error_removed: float

    @classmethod
    def _of(cls, j: _Json) -> LateFault:
        return cls(j["effect"], _intervals(j["parameters"]), Times._of(j["acts"]), j["share_of_error_removed"])


@dataclass(frozen=True)
class CutRecording:
    """A recording of which only the beginning is used, because the model diverges on the rest."""

    recording: str
    #: Length of the part that is used, s.
    used_s: float
    #: Length of the recording, s.
    recorded_s: float


@dataclass(frozen=True)
class NullTest:
    """How much of the residual the best candidate explains when none is at work."""

    #: Quantile (95 %) of the largest share that a candidate explains by chance.
    share_q95: float
    #: Largest share that a candidate explains in the recordings, to first order.
    largest_share: float
    #: Share of the draws that reach it.
    p_value: float
    draws: int
    #: Blocks of rows that are drawn.
    blocks: int
    #: Share that the named causes explain together.
    named_share: float


@dataclass(frozen=True)
class OnsetTest:
    """How much of a residual the best beginning or end of a candidate explains by chance."""

    largest_share: float
    share_by_chance: float
    p_value: float
    draws: int
    #: Beginnings and ends that were looked at, over all candidates.
    tried: int


@dataclass(frozen=True)
class ChannelBand:
    """A channel of the test set beside its noise."""

    channel: str
    #: Root mean square of the whitened residual: 1 for noise.
    ratio: float
    #: The ratio that noise rarely exceeds.
    upper: float
    #: Share of the squared residual that a flexible model removes.
    learnable_share: float
    #: Whether that is more than chance.
    learnable: bool
    #: Whether more than noise is left.
    outside: bool


@dataclass(frozen=True)
class Anomaly:
    """Something in the data that noise does not do and no cause explains."""

    #: ``step``, ``drift``, ``change``, ``event``, ``line``, ``unmodelled`` or ``start``.
    kind: str
    channel: str
    #: ``None`` for a line of the spectrum, which is one of all recordings together.
    recording: str | None
    time_s: float | None
    frequency_hz: float | None
    description: str

    @classmethod
    def _of(cls, a: _Json) -> Anomaly:
        # Absent where they mean nothing.
        recording, time_s, hz = a.get("recording"), a.get("time_s"), a.get("frequency_hz")
        return cls(a["kind"], a["channel"], recording, time_s, hz, a["description"])


@dataclass(frozen=True)
class RungError:
    """The error of a model of a ladder in a channel of the test set."""

    channel: str
    unit: str
    rmse: float
    #: Confidence interval of the reduction from the model without any rung.
    reduction_ci95: tuple[float, float]


@dataclass(frozen=True)
class Rung:
    """A fitted model of a ladder; ``none`` is the model without any rung."""

    id: str
    description: str
    parameters: dict[str, Interval]
    #: Parameters that ended at a limit of their range.
    at_limit: tuple[str, ...]
    #: Description length, bits more than the shortest.
    description_length_bits: float
    #: Normalised χ²: 1 for errors at the level of the noise.
    chi_square: float
    test_chi_square: float | None
    #: Errors on the test set.
    test: tuple[RungError, ...]

    @classmethod
    def _of(cls, j: _Json) -> Rung:
        errors = (
            RungError(e["channel"], e["unit"], e["rmse"], (e["reduction_ci95"][0], e["reduction_ci95"][1]))
            for e in j["test"]
        )
        return cls(
            j["id"],
            j["description"],
            _intervals(j["parameters"]),
            tuple(j["at_limit"]),
            j["description_length_bits"],
            j["chi_square"],
            j["test_chi_square"],
            tuple(errors),
        )


@dataclass(frozen=True)
class Ladder:
    """Models of one phenomenon, from a short one to a rich one, fitted to the same data."""

    name: str
    rungs: tuple[Rung, ...]
    #: Place of the rung of the shortest description.
    shortest: int

    @classmethod
    def _of(cls, j: _Json) -> Ladder:
        return cls(j["name"], tuple(Rung._of(r) for r in j["rungs"]), j["shortest"])

    @property
    def supported(self) -> Rung:
        """The rung of the shortest description: the one that the data support."""
        return self.rungs[self.shortest]

    def _repr_html_(self) -> str:
        rows = [(r.id, r.description_length_bits, r.chi_square, r.test_chi_square, r.description) for r in self.rungs]
        head = ["model", "bits more than the shortest", "χ²", "χ² of the test set", "description"]
        return table(head, rows, f"{self.name}: the data support {self.supported.id}")
