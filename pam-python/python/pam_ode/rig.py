"""The virtual rig: recordings whose truth is known."""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass
from typing import Any, Sequence, Union

import numpy as np

from . import _pam
from ._arrays import Array, ArrayLike, as_array, pair
from ._options import Path
from ._progress import Progress, shown
from .effects import ActiveEffect, as_text
from .errors import SettingsError
from .recording import Recording, read

__all__ = ["Rig", "Samples", "record"]

_COLUMNS = (
    "time_s",
    "angle_deg",
    "current_a",
    "reservoir_psi",
    "pressure_flexor_psi",
    "pressure_extensor_psi",
    "valve_flexor",
    "valve_extensor",
    "true_displacement_mm",
    "true_velocity_mm_s",
    "true_pressure_flexor_kpa",
    "true_pressure_extensor_kpa",
    "true_mass_flexor_g",
    "true_mass_extensor_g",
    "true_temperature_flexor_k",
    "true_temperature_extensor_k",
    "true_force_n",
    "true_friction_n",
)

_Effect = Union[ActiveEffect, str]


@dataclass(frozen=True)
class Samples:
    """Samples of the rig: what its sensors read, and the truth behind it. All arrays are ``[samples]``."""

    time_s: Array
    #: Encoder, degrees; x = -angle · 6.875 mm.
    angle_deg: Array
    #: Measured current, A; positive current pushes along -x.
    current_a: Array
    reservoir_psi: Array
    #: Measured pressures, psi gauge.
    pressure_flexor_psi: Array
    pressure_extensor_psi: Array
    #: -1 shut, 1 inflating, 2 exhausting.
    valve_flexor: Array
    valve_extensor: Array
    true_displacement_mm: Array
    true_velocity_mm_s: Array
    #: True pressures, kPa absolute.
    true_pressure_flexor_kpa: Array
    true_pressure_extensor_kpa: Array
    true_mass_flexor_g: Array
    true_mass_extensor_g: Array
    true_temperature_flexor_k: Array
    true_temperature_extensor_k: Array
    #: True force of the motor and dry friction, N.
    true_force_n: Array
    true_friction_n: Array

    def __len__(self) -> int:
        return len(self.time_s)


class Rig:
    """A rig in operation, one sample at a time, for closed loops.

    Args:
        parameters: ``default``, ``measured`` (as rough as the published real run), a TOML file, or TOML text.
        effects: Hidden effects; see :func:`pam_ode.hidden_effects`.
        ideal: Parts without errors, like ``["encoder", "pressure-noise"]`` or ``["all"]``.
        pressures_kpa: Pressures (kPa absolute) in the muscles at the start; room pressure if absent.
        seed: Seed of the noise.
        start_s: Time of the first sample, s.
    """

    def __init__(
        self,
        parameters: str = "default",
        *,
        effects: Sequence[_Effect] = (),
        ideal: Sequence[str] = (),
        pressures_kpa: ArrayLike | None = None,
        seed: int = 1,
        start_s: float = 0.0,
    ) -> None:
        filled = None if pressures_kpa is None else pair("pressures_kpa", pressures_kpa)
        told = [as_text(e) for e in effects]
        self._native = _pam.Rig(parameters, told, list(ideal), seed, start_s, filled)

    @property
    def time_s(self) -> float:
        """Time of the next sample, s."""
        return self._native.time_s

    def tick(
        self, current_a: float = 0.0, *, servo_kpa: ArrayLike | None = None, valves: ArrayLike | None = None
    ) -> dict[str, float]:
        """One sample: reads the sensors, then carries out the command until the next sample.

        Args:
            current_a: Motor current that pushes along +x, A.
            servo_kpa: Pressures (kPa absolute) to which the servo drives the muscles.
            valves: -1 (exhaust), 0 (shut) or 1 (inflate) for flexor and extensor. Without either the muscles are sealed.
        """
        air, flexor, extensor = "sealed", 0.0, 0.0
        if servo_kpa is not None and valves is not None:
            raise SettingsError("give either `servo_kpa` or `valves`")
        if servo_kpa is not None:
            air, (flexor, extensor) = "servo", pair("servo_kpa", servo_kpa)
        elif valves is not None:
            air, (flexor, extensor) = "valves", pair("valves", valves)
        row = self._native.run(np.array([[current_a, flexor, extensor]]), air)[0]
        return dict(zip(_COLUMNS, row.tolist()))

    def run(
        self, current_a: ArrayLike, *, servo_kpa: ArrayLike | None = None, valves: ArrayLike | None = None
    ) -> Samples:
        """Many samples: currents (A) ``[samples]``, with pressures or valves ``[2]`` or ``[samples, 2]`` as in :meth:`tick`."""
        current = np.atleast_1d(as_array("current_a", current_a))
        if current.ndim != 1:
            raise SettingsError(f"`current_a` has shape {list(current.shape)}; it must be [samples]")
        if servo_kpa is not None and valves is not None:
            raise SettingsError("give either `servo_kpa` or `valves`")
        air, values = "sealed", np.zeros(2)
        if servo_kpa is not None:
            air, values = "servo", as_array("servo_kpa", servo_kpa)
        elif valves is not None:
            air, values = "valves", as_array("valves", valves)
        if values.shape not in ((2,), (len(current), 2)):
            raise SettingsError(f"the command of the air has shape {list(values.shape)}; it must be [2] or [samples, 2]")
        commands = np.column_stack([current, np.broadcast_to(values, (len(current), 2))])
        rows = self._native.run(commands, air)
        return Samples(*(np.ascontiguousarray(c) for c in rows.T[: len(_COLUMNS)]))


def record(
    protocol: str = "paper",
    *,
    conditions: str | Sequence[tuple[int, int]] | None = None,
    rig: str = "default",
    effects: Sequence[_Effect] = (),
    ideal: Sequence[str] = (),
    seed: int = 1,
    folder: Path | None = None,
    truth: bool = True,
    overwrite: bool = False,
    progress: Progress = False,
) -> list[Recording]:
    """Records a protocol on the virtual rig and reads the logs as those of the real one are read.

    Args:
        protocol: A built-in protocol, a TOML file, or TOML text.
        conditions: Sealed pressures in place of the protocol's: ``"30/60,45/45"`` or pairs (flexor, extensor), psi gauge.
        rig: Parameters, as for :class:`Rig`.
        effects: Hidden effects.
        ideal: Parts without errors.
        seed: Seed of the noise.
        folder: Folder for the logs and their sealed truth; logs are not kept if absent.
        truth: Whether the truth is written beside the logs.
        overwrite: Replace recordings that were made with other settings.
        progress: ``True`` for a bar, or a function of (what, share, text).
    """
    if conditions is not None and not isinstance(conditions, str):
        conditions = ",".join(f"{flexor}/{extensor}" for flexor, extensor in conditions)
    with tempfile.TemporaryDirectory(prefix="pam-rig-") as temporary:
        with shown(progress) as function:
            logs = _pam.rig_record(
                temporary if folder is None else os.fspath(folder),
                rig=rig,
                protocol=protocol,
                conditions=conditions,
                effects=[as_text(e) for e in effects],
                ideal=list(ideal),
                seed=seed,
                truth=truth and folder is not None,
                overwrite=overwrite,
                progress=function,
            )
        found: list[Any] = read(logs)
        return found
