"""Arrays from whatever NumPy takes, with clear errors."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import SettingsError

Array = NDArray[np.float64]

#: Any object that :func:`numpy.asarray` takes.
ArrayLike = Any


def as_array(name: str, values: ArrayLike, ndim: int | None = None) -> Array:
    """``values`` as an array of float64, without a copy where they are one."""
    array = np.asarray(values)
    if array.dtype.kind not in "fiub":
        raise SettingsError(f"`{name}` has dtype {array.dtype}; real numbers are needed")
    if ndim is not None and array.ndim != ndim:
        raise SettingsError(f"`{name}` has shape {list(array.shape)}; it must have {ndim} dimension(s)")
    return array.astype(np.float64, copy=False)


def contiguous(array: Array) -> Array:
    """``array`` in C order."""
    return np.asarray(array, order="C")


def pair(name: str, values: ArrayLike) -> tuple[float, float]:
    """Two numbers, for the flexor and the extensor; one number stands for both."""
    array = as_array(name, values)
    if array.size == 1:
        value = float(array.reshape(()))
        return value, value
    if array.shape != (2,):
        raise SettingsError(f"`{name}` has shape {list(array.shape)}; it must be (flexor, extensor)")
    return float(array[0]), float(array[1])
