"""Plans: air masses and pressures for a motion and a stiffness."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _pam
from ._arrays import Array, ArrayLike, as_array, pair
from ._html import table
from ._options import Path
from ._report import write
from .errors import SettingsError
from .model import Model

__all__ = ["Plan", "PlanSummary", "plan"]


@dataclass(frozen=True)
class PlanSummary:
    """A plan in a few numbers."""

    samples: int
    #: Samples whose motion and stiffness are met.
    reached: int
    #: Samples that hold the nearest stiffness instead.
    nearest_stiffness: int
    #: Largest miss of the equation of motion, mN.
    largest_residual_mn: float
    largest_stiffness_error_n_mm: float
    #: Least and largest stiffness, air and pressure.
    stiffness_n_mm: tuple[float, float]
    mass_g: tuple[float, float]
    pressure_kpa: tuple[float, float]
    #: Samples whose air lies outside what the model was trained on.
    extrapolated: int


@dataclass(frozen=True)
class Plan:
    """A planned trajectory; arrays are ``[samples]`` or ``[samples, 2]`` (flexor, extensor)."""

    time_s: Array
    displacement_mm: Array
    velocity_mm_s: Array
    acceleration_mm_s2: Array
    #: The stiffness that was wanted, and the one that the air has, N/mm.
    wanted_stiffness_n_mm: Array
    stiffness_n_mm: Array
    #: The load that was expected, N.
    load_n: Array
    masses_g: Array
    #: Pressure commands, kPa absolute.
    pressures_kpa: Array
    #: Whether the wanted stiffness is reached.
    reached: NDArray[np.bool_]
    #: Whether the air lies outside what the model was trained on.
    extrapolates: NDArray[np.bool_]
    #: Whether a sample is proven to be the global optimum; ``None`` for the fast method.
    certified: NDArray[np.bool_] | None
    summary: PlanSummary
    _native: _pam.Plan

    @classmethod
    def _of(cls, native: _pam.Plan) -> Plan:
        t, x, v, a, k, load = np.ascontiguousarray(native.targets().T)
        s = json.loads(native.summary())
        for key in ("stiffness_n_mm", "mass_g", "pressure_kpa"):
            s[key] = tuple(s[key])
        return cls(
            t,
            x,
            v,
            a,
            k,
            native.stiffness_n_mm(),
            load,
            native.masses_g(),
            native.pressures_kpa(),
            native.reached(),
            native.extrapolates(),
            native.certified(),
            PlanSummary(**s),
            native,
        )

    def to_csv(self, path: Path) -> None:
        """Writes the lookup table as CSV."""
        write(path, self._native.csv())

    def to_c_header(self, path: Path) -> None:
        """Writes the lookup table as a C header."""
        write(path, self._native.c_header())

    def to_binary(self, path: Path) -> None:
        """Writes the lookup table in the binary format for microcontrollers."""
        write(path, self._native.table_bytes())

    def report(self, path: Path, title: str = "Plan") -> None:
        """Writes the report, one self-contained HTML page."""
        write(path, self._native.report(title))

    def __len__(self) -> int:
        return len(self.time_s)

    def __repr__(self) -> str:
        s = self.summary
        return f"Plan({s.samples} samples, {s.reached} reached, {s.pressure_kpa[0]:.0f} to {s.pressure_kpa[1]:.0f} kPa)"

    def _repr_html_(self) -> str:
        s = self.summary
        rows = [
            ("stiffness (N/mm)", *s.stiffness_n_mm),
            ("air (g)", *s.mass_g),
            ("pressure (kPa abs)", *s.pressure_kpa),
        ]
        return table(["quantity", "least", "most"], rows, repr(self))

    def plot(self, axes: Any = None) -> Any:
        """Draws motion, stiffness and pressures with matplotlib; see :func:`pam_ode.plot.plan`."""
        from . import plot

        return plot.plan(self, axes=axes)


def plan(
    model: Model,
    motion: str | ArrayLike,
    stiffness: float | str | ArrayLike | None = None,
    *,
    time_s: ArrayLike | None = None,
    velocity_mm_s: ArrayLike | None = None,
    acceleration_mm_s2: ArrayLike | None = None,
    load_n: ArrayLike = 0.0,
    rate_hz: float = 1000.0,
    method: str = "auto",
    mass_bounds_g: ArrayLike | None = None,
    stiffness_step_mm: float = 1.0,
) -> Plan:
    """Plans air masses and pressures that give a motion and a stiffness.

    Args:
        model: A model without effects.
        motion: A motion in words (``sine:A=1,f=0.1``, ``triangle:A=1,f=0.1``, ``minimum-jerk:from=0,to=1,T=0.5``,
            ``hold:x=0``; mm, Hz, s), a CSV file, or displacements (mm) ``[samples]``.
        stiffness: N/mm: a number, words (``sine:mean=150,A=10,f=0.1``), or, with displacements, ``[samples]``.
        time_s: Times (s) of the displacements; from ``rate_hz`` if absent.
        velocity_mm_s: Velocities of the displacements; their derivative if absent.
        acceleration_mm_s2: Accelerations of the displacements; the derivative of the velocities if absent.
        load_n: External force that is expected, N.
        rate_hz: Samples per second.
        method: ``auto``, or ``exact``: every sample the proven global optimum (leaky_relu and relu).
        mass_bounds_g: Least and most air in a muscle, g; what 10 and 80 psi gauge hold at x = 0 if absent.
        stiffness_step_mm: Step h of the stiffness estimate, mm.

    Raises:
        ControlError: The motion cannot be reached; ``time_s`` says where.
    """
    if method not in ("auto", "exact"):
        raise SettingsError(f"method `{method}`: auto or exact")
    bounds = None if mass_bounds_g is None else pair("mass_bounds_g", mass_bounds_g)
    options: dict[str, Any] = {
        "exact": method == "exact",
        "mass_bounds_g": bounds,
        "stiffness_step_mm": stiffness_step_mm,
    }
    if isinstance(motion, str):
        if any(v is not None for v in (time_s, velocity_mm_s, acceleration_mm_s2)):
            raise SettingsError("times, velocities and accelerations go with displacements, not with a motion in words")
        told = stiffness if stiffness is None or isinstance(stiffness, str) else repr(float(stiffness))
        native = _pam.plan_motion(
            model._native, motion, told, load_n=float(np.asarray(load_n)), rate_hz=rate_hz, **options
        )
        return Plan._of(native)
    x = as_array("motion", motion, 1)
    if stiffness is None or isinstance(stiffness, str):
        raise SettingsError("with displacements, `stiffness` is a number or an array (N/mm)")
    time = np.arange(len(x)) / rate_hz if time_s is None else as_array("time_s", time_s, 1)
    if time.shape != x.shape:
        raise SettingsError(f"`time_s` has {len(time)} samples, `motion` has {len(x)}")
    v = np.gradient(x, time) if velocity_mm_s is None else as_array("velocity_mm_s", velocity_mm_s, 1)
    a = np.gradient(v, time) if acceleration_mm_s2 is None else as_array("acceleration_mm_s2", acceleration_mm_s2, 1)
    columns = (time, x, v, a, as_array("stiffness", stiffness), as_array("load_n", load_n))
    for name, column in zip(("velocity_mm_s", "acceleration_mm_s2", "stiffness", "load_n"), columns[2:]):
        if column.shape not in ((), x.shape):
            raise SettingsError(f"`{name}` has shape {list(column.shape)}; it must be [{len(x)}]")
    targets = np.stack(np.broadcast_arrays(*columns), axis=1)
    return Plan._of(_pam.plan_targets(model._native, targets, **options))
