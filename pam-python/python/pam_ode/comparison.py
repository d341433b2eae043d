"""Comparison with baselines."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import Any, Mapping, Sequence, Union

from . import _pam
from ._html import table
from ._options import Path
from ._progress import Progress, shown
from ._report import write
from .recording import Recording, natives

__all__ = ["Comparison", "ModelScore", "compare", "comparison_example"]


@dataclass(frozen=True)
class ModelScore:
    """R² of the displacement of one model, means over recordings; cold starts know the first sample, warm ones more."""

    name: str
    train_cold: float | None
    held_out_cold: float | None
    train_warm: float | None
    held_out_warm: float | None
    #: Time of the fit, s.
    fit_s: float | None


@dataclass(frozen=True)
class Comparison:
    """The result of a comparison."""

    models: tuple[ModelScore, ...]
    _native: _pam.Comparison

    def to_dict(self) -> dict[str, Any]:
        """Everything as in ``comparison.json``."""
        found: dict[str, Any] = json.loads(self._native.json())
        return found

    def to_csv(self, path: Path) -> None:
        """Writes the table as CSV."""
        write(path, self._native.csv())

    def to_latex(self) -> str:
        """The table in LaTeX."""
        return self._native.latex()

    def report(self, path: Path) -> None:
        """Writes the report, one self-contained HTML page."""
        write(path, self._native.report())

    def __repr__(self) -> str:
        return f"Comparison({', '.join(m.name for m in self.models)})"

    def _repr_html_(self) -> str:
        rows = [(m.name, m.train_cold, m.held_out_cold, m.train_warm, m.held_out_warm, m.fit_s) for m in self.models]
        head = ["R² of x", "train, cold", "held out, cold", "train, warm", "held out, warm", "fit (s)"]
        return table(head, rows)


def comparison_example() -> str:
    """A configuration with every kind of model and its default settings, as TOML text."""
    return _pam.Comparison.example()


def compare(
    config: Union[str, Path, Sequence[Mapping[str, Any]]],
    recordings: Sequence[Recording],
    *,
    held_out: Sequence[Recording] = (),
    seed: int = 1,
    progress: Progress = False,
) -> Comparison:
    """Fits baselines beside the hybrid model to the same recordings and scores them.

    Args:
        config: Models, as a list of dicts (``[{"kind": "koopman"}, {"kind": "spring-damper"}]``), TOML text or a TOML file;
            see :func:`comparison_example`. Recordings and split of a configuration are not read.
        recordings: Recordings to fit to.
        held_out: Recordings to score on.
        seed: Seed of everything random.
        progress: ``True`` for a bar, or a function of (what, share, text).
    """
    names = {"train": [r.name for r in recordings], "held_out": [r.name for r in held_out]}
    data: dict[str, Any] = {"recordings": [], **names}
    if isinstance(config, (str, os.PathLike)):
        text = os.fspath(config)
        if "\n" not in text:
            with open(text, encoding="utf-8") as file:
                text = file.read()
    else:
        text = _pam.Comparison.toml(json.dumps({"data": data, "model": [dict(m) for m in config]}))
    with shown(progress) as function:
        native = _pam.compare(text, natives([*recordings, *held_out]), seed=seed, progress=function)
    scores, times = json.loads(native.json()), json.loads(native.times())
    return Comparison(tuple(_score(m, times) for m in scores["models"]), native)


def _score(model: dict[str, Any], times: Any) -> ModelScore:
    def mean(start: str, part: str) -> float | None:
        found: float | None = model[start][part]["displacement"]["mean"]
        return found

    fit = [t for t in times.get("models", []) if t.get("name") == model["name"]]
    return ModelScore(
        model["name"],
        mean("cold", "train"),
        mean("cold", "held_out"),
        mean("warm", "train"),
        mean("warm", "held_out"),
        fit[0].get("fit_s") if fit else None,
    )
