"""Losses on recordings and their exact gradients."""

from __future__ import annotations

import json
import warnings
from dataclasses import dataclass
from typing import Any, Callable, Mapping, Sequence, Union

import numpy as np

from . import _pam
from ._arrays import Array, ArrayLike, as_array, contiguous
from ._html import table
from ._options import Path, optional_path, steps
from .errors import PamWarning, SettingsError, SolveError
from .model import Model
from .recording import Recording, natives

__all__ = ["Gradient", "Loss", "Problem", "Stopped", "simulate", "value_and_gradient"]

#: A loss: its name (with fields, ``"huber:thresholds=0.5/5/2/2,weights=1/1/1/1"``), a dict with ``kind`` and fields, or a
#: function of (recording, predicted ``[samples, 4]``) that returns the value and its derivative by ``predicted``.
Loss = Union[str, Mapping[str, Any], Callable[[Recording, Array], tuple[float, Array]]]


@dataclass(frozen=True)
class Stopped:
    """A recording whose prediction stopped early."""

    name: str
    time_s: float
    why: str


@dataclass(frozen=True)
class Gradient:
    """Value and gradient of the mean loss over recordings."""

    #: The mean loss.
    value: float
    #: The gradient by the name of the parameter, in the shapes of :meth:`Problem.parameters`.
    gradient: dict[str, Array]
    #: The loss of each recording; NaN where the prediction stopped early.
    values: Array
    #: Recordings whose prediction stopped early; they are left out of the mean.
    stopped: tuple[Stopped, ...]
    #: Counts of work: accepted and rejected steps, evaluations, pullbacks, stored bytes.
    work: dict[str, int]

    def __iter__(self) -> Any:
        """Value and gradient: ``value, gradient = value_and_gradient(...)``."""
        return iter((self.value, self.gradient))

    def norm(self) -> float:
        """The Euclidean norm of the whole gradient."""
        return float(np.sqrt(sum(float(np.sum(g * g)) for g in self.gradient.values())))

    def __repr__(self) -> str:
        return f"Gradient(value {self.value:.6g}, {len(self.values)} recordings, norm {self.norm():.3g})"

    def _repr_html_(self) -> str:
        rows = [(k, str(list(g.shape)), float(np.linalg.norm(g))) for k, g in self.gradient.items()]
        return table(["parameter", "shape", "norm of the gradient"], rows, repr(self))


_WORK = ("accepted_steps", "rejected_steps", "evaluations", "pullbacks", "stored_bytes")
_PER_RECORDING = ("masses_g", "initial_states")


class Problem:
    """A model, recordings and a loss, to be evaluated again and again for changing parameters.

    Engines keep their memory from call to call, so a training loop makes one problem and calls it. Calls release the
    interpreter lock; calls from several threads compute at once.

    Args:
        model: The model.
        recordings: One recording or several, each predicted from its first sample.
        loss: See :data:`Loss`; the mean over the recordings is taken.
        method: ``auto`` (the closed form where it applies, else the adjoint of Tsit5), ``exact``, ``surrogate`` (steps on a
            piecewise polynomial of a smooth network, the fastest for them), or a gradient method of ``names()["method"]``.
        solver: Runge–Kutta method of ``names()["solver"]``, for methods without one of their own.
        precision: ``f64``, or ``f32`` for the network of the adjoint.
        step_ms: Constant steps (ms) in place of error control.
        rtol: Relative tolerance (1e-6).
        atol: Absolute tolerance, in mm, mm/s and kPa (1e-6).
        input: How the force is read between samples: ``zoh``, ``linear``, ``ramp`` or ``cubic``.
        masses: How sealed air is found: ``auto``, ``gas-law`` or ``surfaces``.
        surfaces: File of single-muscle surfaces.
        horizon_s: Cut recordings into windows of this length (s), each predicted from its measured start.
    """

    def __init__(
        self,
        model: Model,
        recordings: Recording | Sequence[Recording],
        loss: Loss = "published",
        *,
        method: str = "auto",
        solver: str | None = None,
        precision: str = "f64",
        step_ms: float | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        input: str = "zoh",
        masses: str = "auto",
        surfaces: Path | None = None,
        horizon_s: float | None = None,
    ) -> None:
        self.model = model
        self._native = _pam.Problem(
            model._native,
            natives(recordings),
            native_loss(loss),
            method=method,
            solver=solver,
            precision=precision,
            steps=steps(step_ms, rtol, atol, input),
            masses=masses,
            surfaces=optional_path(surfaces),
            horizon_s=horizon_s,
        )
        #: Names of the recordings, or of the recordings of the windows.
        self.names: list[str] = self._native.names()
        #: Their numbers of samples.
        self.lengths: list[int] = self._native.lengths()
        own = model.parameters()
        self._tensors = [k for k in own if k not in ("raw", "auxiliary_damping_kg_s", "effects")]
        self._own = {k: contiguous(v) for k, v in own.items()}
        self._shapes = {k: v.shape for k, v in own.items()}
        for name in _PER_RECORDING:
            self._shapes[name] = (len(self.names), 2 if name == "masses_g" else 4)

    def parameters(self, *, per_recording: bool = False) -> dict[str, Array]:
        """The parameters of the model; with ``per_recording`` also ``masses_g`` ``[recordings, 2]`` (g) and
        ``initial_states`` ``[recordings, 4]`` (mm, mm/s, kPa, kPa)."""
        found = {k: v.copy() for k, v in self._own.items()}
        if per_recording:
            found["masses_g"] = self._native.masses_g()
            found["initial_states"] = self._native.initial_states()
        return found

    def shape(self, name: str) -> tuple[int, ...]:
        """Shape of a parameter."""
        if name not in self._shapes:
            raise SettingsError(f"there is no parameter `{name}`; there are {', '.join(self._shapes)}")
        return self._shapes[name]

    def _numbers(self, parameters: Mapping[str, ArrayLike] | None) -> tuple[Any, ...]:
        own = self._own
        if not parameters:
            given: Mapping[str, Array] = own
        else:
            arrays = dict(own)
            for name, value in parameters.items():
                shape = self.shape(name)
                array = as_array(name, value)
                if array.shape != shape:
                    raise SettingsError(f"`{name}` has shape {list(array.shape)}; it must be {list(shape)}")
                arrays[name] = array
            given = arrays
        return (
            [given[k] for k in self._tensors],
            tuple(given["raw"].tolist()),
            float(given["auxiliary_damping_kg_s"]),
            given["effects"].tolist() if "effects" in given else [],
            given.get("masses_g"),
            given.get("initial_states"),
        )

    def _named(self, gradients: tuple[Any, ...]) -> dict[str, Array]:
        tensors, raw, damping, effects, masses, states = gradients
        named: dict[str, Array] = dict(zip(self._tensors, tensors))
        named["raw"] = raw
        named["auxiliary_damping_kg_s"] = np.array(damping)
        if "effects" in self._own:
            named["effects"] = effects
        named["masses_g"] = masses
        named["initial_states"] = states
        return named

    def _stopped(self, failures: list[tuple[int, float, str]]) -> tuple[Stopped, ...]:
        found = tuple(Stopped(self.names[k], time_s, why) for k, time_s, why in failures)
        if found and len(found) == len(self.names):
            first = found[0]
            error = SolveError(f"no recording could be predicted to its end; {first.name}: {first.why}")
            error.recording, error.time_s = first.name, first.time_s
            raise error
        if found:
            told = "; ".join(f"{s.name}: {s.why}" for s in found)
            warnings.warn(f"{len(found)} of {len(self.names)} recordings add nothing: {told}", PamWarning, stacklevel=3)
        return found

    def value(self, parameters: Mapping[str, ArrayLike] | None = None) -> float:
        """The mean loss at parameters; those that are not named are the model's.

        Raises:
            SolveError: No recording could be predicted to its end. If some could not, they are left out with a warning.
        """
        value, _, failures = self._native.value(self._numbers(parameters))
        self._stopped(failures)
        return value

    def value_and_gradient(self, parameters: Mapping[str, ArrayLike] | None = None) -> Gradient:
        """The mean loss and its exact gradient at parameters; those that are not named are the model's.

        The gradient has every parameter, and ``masses_g`` and ``initial_states`` of the recordings.

        Raises:
            SolveError: No recording could be predicted to its end. If some could not, they are left out with a warning.
        """
        value, values, gradients, failures, work = self._native.value_and_gradient(self._numbers(parameters))
        stopped = self._stopped(failures)
        return Gradient(value, self._named(gradients), values, stopped, dict(zip(_WORK, work)))

    def simulate(self, parameters: Mapping[str, ArrayLike] | None = None) -> list[Array]:
        """The predicted states ``[samples, 4]`` of each recording: mm, mm/s, kPa, kPa.

        Raises:
            SolveError: A prediction stopped early.
        """
        states, failures = self._native.simulate(self._numbers(parameters))
        self._complete(failures)
        return states

    def pullback(
        self, cotangents: Sequence[ArrayLike], parameters: Mapping[str, ArrayLike] | None = None
    ) -> dict[str, Array]:
        """The vector-Jacobian product of :meth:`simulate`: the derivative of Σ cotangents · states by each parameter.

        Args:
            cotangents: One array ``[samples, 4]`` for each recording.
            parameters: As :meth:`value_and_gradient`.
        """
        arrays = [as_array(f"cotangents[{k}]", c, 2) for k, c in enumerate(cotangents)]
        gradients, failures = self._native.pullback(self._numbers(parameters), arrays)
        self._complete(failures)
        return self._named(gradients)

    def _complete(self, failures: list[tuple[int, float, str]]) -> None:
        if failures:
            k, time_s, why = failures[0]
            error = SolveError(f"{self.names[k]}: {why}")
            error.recording, error.time_s = self.names[k], time_s
            raise error

    def __repr__(self) -> str:
        return f"Problem({self.model.name!r}, {len(self.names)} recordings, {sum(self.lengths)} samples)"


def native_loss(loss: Loss) -> Any:
    """A loss as the extension takes it."""
    if callable(loss):
        function = loss

        def call(recording: Recording, predicted: Array) -> tuple[float, Array]:
            value, cotangents = function(recording, predicted)
            return float(value), as_array("cotangents", cotangents, 2)

        return call
    return loss if isinstance(loss, str) else json.dumps(dict(loss))


def value_and_gradient(
    model: Model, recordings: Recording | Sequence[Recording], loss: Loss = "published", **options: Any
) -> Gradient:
    """Value and exact gradient of the mean loss of a model on recordings; options as :class:`Problem`.

    The result is value and gradient at once: ``value, gradient = value_and_gradient(model, recordings)``.
    """
    return Problem(model, recordings, loss, **options).value_and_gradient()


def simulate(model: Model, recordings: Recording | Sequence[Recording], **options: Any) -> list[Array]:
    """The predicted states ``[samples, 4]`` of each recording; options as :class:`Problem`."""
    return Problem(model, recordings, **options).simulate()
