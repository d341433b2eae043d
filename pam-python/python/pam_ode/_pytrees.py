"""What the interfaces to JAX and PyTorch share."""

from __future__ import annotations

from typing import Any, Mapping, Sequence

import numpy as np

from ._arrays import Array
from .errors import SettingsError
from .gradients import Problem


def flatten(names: Sequence[str], arrays: Sequence[Any]) -> dict[str, Array]:
    """Parameters as float64 by name; single precision comes in from JAX and PyTorch."""
    return {name: np.asarray(a, dtype=np.float64) for name, a in zip(names, arrays)}


def check_shapes(problem: Problem, parameters: Mapping[str, Any]) -> None:
    """Refuses names and shapes that are not those of the problem, before anything is compiled."""
    for name, value in parameters.items():
        shape = tuple(np.shape(value))
        if shape != problem.shape(name):
            raise SettingsError(f"`{name}` has shape {list(shape)}; it must be {list(problem.shape(name))}")


def layer_parameters(layers: Sequence[tuple[Any, Any]]) -> dict[str, Any]:
    """``weight_k`` and ``bias_k`` of layers."""
    named: dict[str, Any] = {}
    for k, (weight, bias) in enumerate(layers):
        named[f"weight_{k}"] = weight
        named[f"bias_{k}"] = bias
    return named
