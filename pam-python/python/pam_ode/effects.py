"""Effects: known ways in which a joint differs from its model."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from typing import Any, Mapping, Union

from . import _pam
from ._html import table
from .errors import EffectError

__all__ = ["ActiveEffect", "EffectInfo", "ParameterInfo", "define_effects", "effect", "effects", "hidden_effects"]


@dataclass(frozen=True)
class ParameterInfo:
    """A parameter of an effect; its unit is part of its name."""

    name: str
    meaning: str
    #: Smallest and largest physical value.
    range: tuple[float, float]
    #: The value at which it contributes nothing; ``None`` for a scale.
    off: float | None


@dataclass(frozen=True)
class EffectInfo:
    """The description of an effect."""

    id: str
    group: str
    description: str
    excited_by: str
    parameters: tuple[ParameterInfo, ...]
    #: Names of the numbers that select a variant.
    switches: tuple[str, ...]
    #: The TOML text that defines it, if it is an expression.
    definition: str | None = None

    def _repr_html_(self) -> str:
        rows = [(p.name, p.meaning, p.range[0], p.range[1]) for p in self.parameters]
        return table(["parameter", "meaning", "least", "most"], rows, f"{self.id}: {self.description}")


@dataclass(frozen=True)
class ActiveEffect:
    """An effect with its values."""

    id: str
    #: Values by name, with units in the names.
    values: dict[str, float] = field(default_factory=dict)

    def __str__(self) -> str:
        return as_text(self)


def effect(id: str, /, **values: float) -> ActiveEffect:
    """An effect with values: ``effect("coulomb_friction", force_n=20)``."""
    return ActiveEffect(id, {name: float(value) for name, value in values.items()})


def as_text(effect: Union[ActiveEffect, str, Mapping[str, Any]]) -> str:
    """``ID:NAME=VALUE,…``."""
    if isinstance(effect, str):
        return effect
    if isinstance(effect, ActiveEffect):
        return f"{effect.id}:" + ",".join(f"{k}={v!r}" for k, v in effect.values.items())
    raise EffectError(f"an effect is an ActiveEffect or a text like 'coulomb_friction:force_n=20', not {effect!r}")


def _infos(text: str) -> tuple[EffectInfo, ...]:
    return tuple(
        EffectInfo(
            e["id"],
            e["group"],
            e["description"],
            e["excited_by"],
            tuple(
                ParameterInfo(p["name"], p["meaning"], (p["range"][0], p["range"][1]), p["off"])
                for p in e["parameters"]
            ),
            tuple(s["name"] for s in e["switches"]),
            e["definition"],
        )
        for e in json.loads(text)
    )


def define_effects(source: Union[str, "os.PathLike[str]"]) -> dict[str, EffectInfo]:
    """Makes effects that are defined by expressions known by their ids, like the built-in ones: to models, diagnoses, training
    and the virtual rig, in this process. Models that are saved with them hold their definitions.

    Args:
        source: A TOML file, or its text (with more than one line); the page "Your own effects" has the format.

    Returns:
        The descriptions of the effects, by id. To define the same effect twice is no error.

    Raises:
        EffectError: An expression cannot be read, with file, line and column, or another effect has the id.
    """
    if isinstance(source, str) and "\n" in source:
        return {info.id: info for info in _infos(_pam.define_effects(source, None))}
    return {info.id: info for info in _infos(_pam.define_effects(None, os.fspath(source)))}


def effects() -> dict[str, EffectInfo]:
    """The effects that models can have and diagnoses can name, by id: the built-in ones, and those of :func:`define_effects`."""
    return {info.id: info for info in _infos(_pam.effect_list())}


def hidden_effects() -> dict[str, EffectInfo]:
    """The effects that the virtual rig can hide, by id: those of the vocabulary, phenomena outside it, and those of
    :func:`define_effects`."""
    return {info.id: info for info in _infos(_pam.hidden_effect_list())}
