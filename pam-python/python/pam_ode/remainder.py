"""What a diagnosis learns of the error that no listed cause explains."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

from .causes import ChannelBand, Interval

__all__ = ["Correction", "Dependence", "Law", "RankedLaw", "Remainder"]

_Json = Mapping[str, Any]


@dataclass(frozen=True)
class Dependence:
    """Whether a correction depends on some variables."""

    #: The variables, or ``memory``.
    on: str
    #: Error of data that were not fitted without any term of them, over that with all terms: 1 where they do not matter.
    error_ratio: float
    ci95: tuple[float, float]
    p_value: float


@dataclass(frozen=True)
class Correction:
    """A smooth correction of the model."""

    #: Where it acts.
    acts: tuple[str, ...]
    #: Its terms, of a typical size of one, and their coefficients; the largest first.
    terms: dict[str, float]
    #: The most important first.
    depends_on: tuple[Dependence, ...]
    #: Share of the squared error of the validation data that it removes, and the probability of that by chance.
    validation_share: float
    p_value: float
    #: Whether the test set proves that the error is smaller.
    confirmed: bool

    @classmethod
    def _of(cls, j: _Json) -> Correction:
        depends = (
            Dependence(d["on"], d["error_ratio"], (d["ci95"][0], d["ci95"][1]), d["p_value"]) for d in j["depends_on"]
        )
        return cls(
            tuple(j["acts"]),
            {term: coefficient for term, coefficient in j["terms"]},
            tuple(depends),
            j["validation_share"],
            j["p_value"],
            j["confirmed"],
        )


@dataclass(frozen=True)
class Law:
    """A short expression in the place of a correction."""

    #: What it adds and where: ``force_n = c1_n_per_mm3 * x^3``.
    expression: str
    #: The variables that it depends on.
    variables: tuple[str, ...]
    #: Whether it depends on the past.
    remembers: bool
    parameters: dict[str, Interval]
    #: Named causes that stay beside it.
    beside: tuple[str, ...]
    #: Named causes in whose place it stands.
    replaces: tuple[str, ...]
    #: Share of what the correction removes of the squared error that the law removes.
    share_of_correction: float
    #: What it leaves of each channel of the test set.
    bands: tuple[ChannelBand, ...]
    #: The file that defines it, for :func:`pam_ode.define_effects`.
    definition: str

    @classmethod
    def _of(cls, j: _Json) -> Law:
        return cls(
            j["expression"],
            tuple(j["variables"]),
            j["remembers"],
            {name: Interval._of(i) for name, i in j["parameters"].items()},
            tuple(j["beside"]),
            tuple(r["effect"] for r in j["replaces"]),
            j["share_of_correction"],
            tuple(ChannelBand(**band) for band in j["bands"]),
            j["definition"],
        )


@dataclass(frozen=True)
class RankedLaw:
    """A law that was fitted."""

    expression: str
    beside: tuple[str, ...]
    #: Length of its description, nats.
    description_length: float
    #: Logarithm of its odds against the best one.
    log_odds: float


@dataclass(frozen=True)
class Remainder:
    """A model of the error that remains after the named causes."""

    #: ``nothing_left``, ``not_learned``, ``correction`` or ``law``; the last two are parts of the diagnosis' model.
    outcome: str
    sentence: str
    correction: Correction | None
    law: Law | None
    #: The laws that were fitted, best first.
    ranking: tuple[RankedLaw, ...]

    @classmethod
    def _of(cls, j: _Json) -> Remainder:
        correction, law = j["correction"], j["law"]
        ranking = (
            RankedLaw(r["expression"], tuple(r["beside"]), r["description_length"], r["log_odds"]) for r in j["ranking"]
        )
        return cls(
            j["outcome"],
            j["sentence"],
            None if correction is None else Correction._of(correction),
            None if law is None else Law._of(law),
            tuple(ranking),
        )
