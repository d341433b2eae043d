"""Exceptions of the framework.

All are a :class:`PamError`. Messages say what is wrong, where, and what to do; attributes carry the place.
"""

from __future__ import annotations

from numpy.typing import NDArray
import numpy as np

__all__ = [
    "ComparisonError",
    "ControlError",
    "DataError",
    "DiagnoseError",
    "EffectError",
    "ModelError",
    "PamError",
    "PamWarning",
    "RigError",
    "SettingsError",
    "SolveError",
    "TrainingError",
]


class PamError(Exception):
    """Base class of all errors of the framework."""


class DataError(PamError, ValueError):
    """A file or a recording cannot be read, understood or used."""

    #: The file, if there is one.
    file: str | None = None
    #: Line, counted from one.
    line: int | None = None
    #: Name of the column.
    column: str | None = None


class ModelError(PamError, ValueError):
    """A model cannot be built as asked."""


class SettingsError(PamError, ValueError):
    """An argument is out of range, of the wrong shape, or names something that does not exist."""


class EffectError(PamError, ValueError):
    """An effect is not known, or its values are wrong."""


class SolveError(PamError):
    """A recording could not be predicted to its end."""

    #: Name of the recording.
    recording: str | None = None
    #: The last time that was reached, s.
    time_s: float | None = None
    #: The states until then, ``[samples, 4]``: mm, mm/s, kPa, kPa.
    partial: NDArray[np.float64] | None = None


class TrainingError(PamError):
    """A training cannot begin or go on."""

    #: Name of the stage.
    stage: str | None = None
    #: Its epoch.
    epoch: int | None = None


class DiagnoseError(PamError):
    """A diagnosis cannot be made of these data."""


class ControlError(PamError):
    """A motion or stiffness cannot be planned."""

    #: The first time (s) at which the motion cannot be reached.
    time_s: float | None = None


class RigError(PamError, ValueError):
    """The virtual rig cannot do what is asked."""


class ComparisonError(PamError):
    """A comparison cannot be made."""


class PamWarning(UserWarning):
    """Something that does not stop the work but changes what its result means."""
