"""Models: a network or spring for the restoring force inside the known mechanics and gas of the joint."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Mapping, Sequence, Union, overload

import numpy as np

from . import _pam
from ._arrays import Array, ArrayLike, as_array, contiguous, pair
from ._html import table
from ._options import Path, optional_path, steps
from ._progress import Progress, shown
from .effects import ActiveEffect, as_text
from .errors import SettingsError
from .evaluation import Evaluation
from .recording import Recording, natives

__all__ = ["Linearisation", "Model", "PhysicalParameters", "Prediction", "load"]

#: Parameters or gradients by name.
Parameters = dict[str, Array]


@dataclass(frozen=True)
class PhysicalParameters:
    """The physical parameters of a joint."""

    #: Reflected mass m, kg.
    mass_kg: float
    #: Gas coefficient C = R T / m_air, kPa mm³/g.
    gas_coefficient: float
    #: Deformation coefficient ν of the braid.
    deformation: float
    #: Auxiliary damping B, kg/s; zero in a finished model.
    auxiliary_damping_kg_s: float
    #: Radius of the muscles at x = 0, mm.
    radius_mm: float
    #: Length of the muscles at x = 0, mm.
    length_mm: float


@dataclass(frozen=True)
class Prediction:
    """A predicted recording."""

    #: The recording that drove it.
    recording: Recording
    #: Predicted states ``[samples, 4]``: x (mm), v (mm/s), P_f and P_e (kPa absolute).
    states: Array
    #: Sealed air of flexor and extensor, g.
    masses_g: tuple[float, float]
    #: Accepted steps.
    accepted_steps: int
    #: Rejected steps.
    rejected_steps: int
    #: Evaluations of the vector field.
    evaluations: int

    @property
    def time_s(self) -> Array:
        """Times, s, ``[samples]``."""
        return self.recording.time_s

    @property
    def displacement_mm(self) -> Array:
        """Displacement, mm, ``[samples]``."""
        return self.states[:, 0]

    @property
    def velocity_mm_s(self) -> Array:
        """Velocity, mm/s, ``[samples]``."""
        return self.states[:, 1]

    @property
    def pressure_flexor_kpa(self) -> Array:
        """Flexor pressure, kPa absolute, ``[samples]``."""
        return self.states[:, 2]

    @property
    def pressure_extensor_kpa(self) -> Array:
        """Extensor pressure, kPa absolute, ``[samples]``."""
        return self.states[:, 3]

    @property
    def rmse(self) -> Array:
        """Root-mean-square errors of x, v, P_f, P_e: mm, mm/s, kPa, kPa."""
        squares: Array = np.mean((self.states - self.recording.states) ** 2, axis=0)
        return np.sqrt(squares)

    @property
    def r2(self) -> Array:
        """Coefficients of determination of x, v, P_f, P_e; NaN for a channel that does not vary."""
        measured = self.recording.states
        total = np.sum((measured - measured.mean(axis=0)) ** 2, axis=0)
        residual = np.sum((self.states - measured) ** 2, axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(total > 0, 1 - residual / total, np.nan)

    def to_recording(self, name: str | None = None) -> Recording:
        """The prediction as a recording: predicted channels with the measured force."""
        x, v, pf, pe = self.states.T
        r = self.recording
        return Recording(
            r.time_s,
            x,
            pf,
            pe,
            r.force_n,
            velocity_mm_s=v,
            masses_g=self.masses_g,
            name=r.name if name is None else name,
        )

    def __repr__(self) -> str:
        return f"Prediction({self.recording.name!r}, {len(self.states)} samples, R² of x {self.r2[0]:.4f})"

    def _repr_html_(self) -> str:
        names = ("x (mm)", "v (mm/s)", "P_f (kPa)", "P_e (kPa)")
        rows = [(n, float(a), float(b)) for n, a, b in zip(names, self.r2, self.rmse)]
        return table(["channel", "R²", "RMSE"], rows, repr(self))

    def plot(self, axes: Any = None) -> Any:
        """Draws measured and predicted channels with matplotlib; see :func:`pam_ode.plot.prediction`."""
        from . import plot

        return plot.prediction(self, axes=axes)


@dataclass(frozen=True)
class Linearisation:
    """The restoring force and its slopes at points; all arrays have the shape of the points."""

    #: Restoring force f, N; positive at positive x.
    force_n: Array
    #: Exact stiffness ∂f/∂x, N/mm.
    stiffness_n_mm: Array
    #: Exact damping ∂f/∂v, kg/s.
    damping_kg_s: Array
    #: The published estimate of the stiffness, from four points 2h, h, -h, -2h away, N/mm.
    four_point_n_mm: Array


class Model:
    """A joint model: m ẍ = F_e - f(x, ẋ, m_f, m_e) - B ẋ with isothermal gas in two muscles, and effects, if it has any.

    Models do not change; methods return new ones. They come from :func:`load`, :meth:`from_layers`, :func:`pam_ode.train` or
    a diagnosis.
    """

    __slots__ = ("_native",)

    _native: _pam.Model

    def __init__(self) -> None:
        raise TypeError("models come from pam_ode.load, Model.from_layers, pam_ode.train or a diagnosis")

    @classmethod
    def _of(cls, native: _pam.Model) -> Model:
        self = cls.__new__(cls)
        self._native = native
        return self

    @classmethod
    def from_layers(
        cls,
        layers: Sequence[tuple[ArrayLike, ArrayLike]],
        activation: str = "leaky_relu",
        *,
        activation_parameters: Mapping[str, Any] | None = None,
        mass_kg: float | None = None,
        gas_coefficient: float | None = None,
        deformation: float | None = None,
        auxiliary_damping_kg_s: float = 0.0,
        radius_mm: float | None = None,
        length_mm: float | None = None,
        name: str = "hybrid joint",
        trained: bool = True,
    ) -> Model:
        """A model whose force is a network of (m_f, m_e, x, v) in g, g, mm, mm/s, unscaled, with one output in mN.

        Args:
            layers: Weight ``[outputs, inputs]`` and bias ``[outputs]`` of each layer, the first with 4 inputs, the last with
                1 output.
            activation: Name of the activation between layers, one of :func:`pam_ode.names` ``["activation"]``.
            mass_kg: Reflected mass m; the data sheet's if absent. Likewise the others.
            trained: Whether the numbers were fitted; decides how masses of recordings are found by default.
        """
        arrays = [
            (as_array(f"weight_{k}", w, 2), as_array(f"bias_{k}", b, 1)) for k, (w, b) in enumerate(layers)
        ]
        return cls._of(
            _pam.Model.from_layers(
                arrays,
                activation,
                activation_parameters=None if activation_parameters is None else json.dumps(activation_parameters),
                mass_kg=mass_kg,
                gas_coefficient=gas_coefficient,
                deformation=deformation,
                damping_kg_s=auxiliary_damping_kg_s,
                radius_mm=radius_mm,
                length_mm=length_mm,
                name=name,
                trained=trained,
            )
        )

    def save(self, path: Path) -> None:
        """Writes ``.safetensors`` (everything) or ``.eqx`` (the published format: a network of two hidden layers)."""
        import os

        self._native.save(os.fspath(path))

    @property
    def name(self) -> str:
        """Name for reports."""
        return self._native.name

    @property
    def provenance(self) -> str:
        """Where its numbers come from."""
        return self._native.provenance

    @property
    def trained_on(self) -> list[str]:
        """Names of the recordings it was fitted to, if they are known."""
        return self._native.trained_on

    @property
    def force_kind(self) -> str:
        """Kind of the force: ``mlp`` or ``spring_damper``."""
        return self._native.force_kind

    @property
    def activation(self) -> str | None:
        """Name of the activation of a network."""
        return dict(self._native.settings()).get("activation")

    @property
    def activation_parameters(self) -> Any:
        """Parameters of the activation, if it has any."""
        return json.loads(dict(self._native.settings()).get("activation_parameters", "null"))

    @property
    def layers(self) -> list[tuple[Array, Array]]:
        """Weight ``[outputs, inputs]`` and bias ``[outputs]`` of each layer of a network."""
        tensors = dict(self._native.tensors())
        count = sum(name.startswith("weight_") for name in tensors)
        if self.force_kind != "mlp":
            raise SettingsError(f"the force is a {self.force_kind}, no network")
        return [(tensors[f"weight_{k}"], tensors[f"bias_{k}"]) for k in range(count)]

    @property
    def physical(self) -> PhysicalParameters:
        """The physical parameters."""
        return PhysicalParameters(*self._native.physical())

    @property
    def effects(self) -> list[ActiveEffect]:
        """The effects that extend the model, in the order in which they act."""
        return [ActiveEffect(e["effect"], e["values"]) for e in json.loads(self._native.effects())]

    def parameters(self) -> Parameters:
        """Everything that has a gradient, by name, as arrays of float64.

        - the tensors of the force: ``weight_0`` ``[outputs, inputs]``, ``bias_0`` ``[outputs]``, … of a network;
        - ``raw`` ``[3]``: mass, gas coefficient and deformation coefficient before softplus;
        - ``auxiliary_damping_kg_s`` ``[]``;
        - ``effects`` ``[k]``, the parameters of the effects in turn, if there are any.
        """
        parameters = dict(self._native.tensors())
        parameters["raw"] = np.array(self._native.raw())
        parameters["auxiliary_damping_kg_s"] = np.array(self.physical.auxiliary_damping_kg_s)
        effects = self._native.effect_parameters()
        if effects.size:
            parameters["effects"] = effects
        return parameters

    def with_parameters(self, parameters: Mapping[str, ArrayLike]) -> Model:
        """The model with other numbers; those that are not named stay."""
        own = self.parameters()
        for name, value in parameters.items():
            if name not in own:
                raise SettingsError(f"there is no parameter `{name}`; there are {', '.join(own)}")
            array = as_array(name, value)
            if array.shape != own[name].shape:
                raise SettingsError(f"`{name}` has shape {list(array.shape)}; the model's is {list(own[name].shape)}")
            own[name] = array
        raw, damping = own.pop("raw"), own.pop("auxiliary_damping_kg_s")
        effects = own.pop("effects", np.empty(0))
        a, b, c = (float(v) for v in raw)
        tensors = [contiguous(v) for v in own.values()]
        return Model._of(self._native.with_numbers(tensors, (a, b, c), float(damping), effects.tolist()))

    def with_effects(self, *effects: ActiveEffect | str) -> Model:
        """The model with these effects in place of its own: ``"coulomb_friction:force_n=20"`` or an :class:`ActiveEffect`."""
        return Model._of(self._native.with_effects([as_text(e) for e in effects]))

    def without_effects(self) -> Model:
        """The plain model that comes nearest: effects that the joint's own numbers can express stay in them."""
        return Model._of(self._native.without_effects()[0])

    def sealed_masses(self, pressures_kpa: ArrayLike, displacement_mm: float = 0.0) -> tuple[float, float]:
        """The air (g) of flexor and extensor that holds these pressures (kPa absolute), by the gas law."""
        flexor, extensor = self._native.gas_law_masses(displacement_mm, pair("pressures_kpa", pressures_kpa))
        return flexor, extensor

    def sealed_pressures(self, masses_g: ArrayLike, displacement_mm: float = 0.0) -> tuple[float, float]:
        """The pressures (kPa absolute) of sealed air (g) at a displacement (mm), by the gas law."""
        flexor, extensor = self._native.gas_law_pressures(displacement_mm, pair("masses_g", masses_g))
        return flexor, extensor

    def linearise(
        self,
        displacement_mm: ArrayLike = 0.0,
        velocity_mm_s: ArrayLike = 0.0,
        *,
        masses_g: ArrayLike | None = None,
        pressures_kpa: ArrayLike | None = None,
        h_mm: float = 1.0,
    ) -> Linearisation:
        """Force, stiffness and damping at points.

        Displacements (mm), velocities (mm/s) and the two columns of ``masses_g`` (g, ``[..., 2]``) are broadcast against each
        other. In place of masses, ``pressures_kpa`` (kPa absolute) are those at x = 0.
        """
        if (masses_g is None) == (pressures_kpa is None):
            raise SettingsError("give either `masses_g` or `pressures_kpa`")
        masses = np.array(self.sealed_masses(pressures_kpa)) if masses_g is None else as_array("masses_g", masses_g)
        if masses.ndim == 0 or masses.shape[-1] != 2:
            raise SettingsError(f"`masses_g` has shape {list(masses.shape)}; its last dimension must be 2")
        points = np.broadcast_arrays(
            as_array("displacement_mm", displacement_mm),
            as_array("velocity_mm_s", velocity_mm_s),
            masses[..., 0],
            masses[..., 1],
        )
        x, v, flexor, extensor = (np.ascontiguousarray(p).ravel() for p in points)
        columns = self._native.linearise(x, v, flexor, extensor, h_mm)
        return Linearisation(*(c.reshape(points[0].shape) for c in columns))

    def stiffness(self, displacement_mm: ArrayLike = 0.0, velocity_mm_s: ArrayLike = 0.0, **air: Any) -> Array:
        """The exact stiffness ∂f/∂x (N/mm) at points; arguments as :meth:`linearise`."""
        return self.linearise(displacement_mm, velocity_mm_s, **air).stiffness_n_mm

    def reachable_stiffness(
        self,
        displacement_mm: ArrayLike,
        velocity_mm_s: float = 0.0,
        *,
        mass_bounds_g: ArrayLike | None = None,
        h_mm: float = 1.0,
    ) -> Array:
        """Least and largest stiffness (N/mm) of unaccelerated motion at displacements (mm), ``[points, 2]``; NaN where no
        masses within the bounds hold it."""
        bounds = None if mass_bounds_g is None else pair("mass_bounds_g", mass_bounds_g)
        places = np.atleast_1d(as_array("displacement_mm", displacement_mm))
        return _pam.reachable(self._native, places, velocity_mm_s, bounds, h_mm)

    @overload
    def predict(
        self,
        recordings: Recording,
        *,
        masses_g: ArrayLike | None = ...,
        method: str = ...,
        step_ms: float | None = ...,
        rtol: float | None = ...,
        atol: float | None = ...,
        input: str = ...,
        masses: str = ...,
        surfaces: Path | None = ...,
    ) -> Prediction: ...

    @overload
    def predict(
        self,
        recordings: Sequence[Recording],
        *,
        masses_g: ArrayLike | None = ...,
        method: str = ...,
        step_ms: float | None = ...,
        rtol: float | None = ...,
        atol: float | None = ...,
        input: str = ...,
        masses: str = ...,
        surfaces: Path | None = ...,
    ) -> list[Prediction]: ...

    def predict(
        self,
        recordings: Union[Recording, Sequence[Recording]],
        *,
        masses_g: ArrayLike | None = None,
        method: str = "auto",
        step_ms: float | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        input: str = "zoh",
        masses: str = "auto",
        surfaces: Path | None = None,
    ) -> Prediction | list[Prediction]:
        """Predicts recordings from their first samples, driven by their forces alone.

        Args:
            recordings: One recording, or several, which are predicted in parallel.
            masses_g: Sealed air of flexor and extensor (g); found from the recording if absent.
            method: ``exact`` (closed form of networks of leaky_relu and relu), ``surrogate`` (steps on a piecewise polynomial of a
                smooth network), a Runge–Kutta method of ``names()["solver"]``, or ``auto``: without steps and tolerances the
                first of these that applies, with Tsit5 for the last.
            step_ms: Constant steps (ms) in place of error control.
            rtol: Relative tolerance of the error control (1e-6).
            atol: Absolute tolerance, in mm, mm/s and kPa (1e-6).
            input: How the force is read between samples: ``zoh``, ``linear``, ``ramp`` or ``cubic``.
            masses: How sealed air is found: ``auto``, ``gas-law`` or ``surfaces``.
            surfaces: File of single-muscle surfaces.

        Raises:
            SolveError: The prediction stopped early; ``time_s`` and ``partial`` say where.
        """
        native = natives(recordings)
        found = self._native.predict(
            native,
            None if masses_g is None else pair("masses_g", masses_g),
            method,
            steps(step_ms, rtol, atol, input),
            masses,
            optional_path(surfaces),
        )
        several = [recordings] if isinstance(recordings, Recording) else list(recordings)
        all_ = [Prediction(r, states, (m[0], m[1]), *counts) for r, (states, m, counts) in zip(several, found)]
        return all_[0] if isinstance(recordings, Recording) else all_

    def evaluate(
        self,
        recordings: Union[Recording, Sequence[Recording]],
        *,
        method: str = "auto",
        step_ms: float | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        input: str = "zoh",
        masses: str = "auto",
        surfaces: Path | None = None,
        progress: Progress = False,
    ) -> Evaluation:
        """Predicts recordings and scores the predictions; arguments as :meth:`predict`."""
        with shown(progress) as function:
            native = self._native.evaluate(
                natives(recordings),
                method,
                steps(step_ms, rtol, atol, input),
                masses,
                optional_path(surfaces),
                function,
            )
        return Evaluation._of(native)

    def __reduce__(self) -> Any:
        import os
        import tempfile

        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "model.safetensors")
            self.save(path)
            with open(path, "rb") as file:
                return _restore, (file.read(),)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Model):
            return NotImplemented
        own, its = self.parameters(), other.parameters()
        return (
            own.keys() == its.keys()
            and all(np.array_equal(own[k], its[k]) for k in own)
            and self._native.settings() == other._native.settings()
            and self._native.effects() == other._native.effects()
        )

    def __repr__(self) -> str:
        return f"Model({self.name!r}: {self._native.describe()})"

    def _repr_html_(self) -> str:
        p = self.physical
        rows: list[tuple[Any, ...]] = [
            ("mass m (kg)", p.mass_kg),
            ("gas coefficient C (kPa mm³/g)", p.gas_coefficient),
            ("deformation ν", p.deformation),
        ]
        rows += [(f"{e.id} {name}", value) for e in self.effects for name, value in e.values.items()]
        return table(["parameter", "value"], rows, f"{self.name}. {self._native.describe()}")


def _restore(content: bytes) -> Model:
    import os
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "model.safetensors")
        with open(path, "wb") as file:
            file.write(content)
        return load(path)


def load(path: Path = "default", *, activation: str | None = None, rig_file: Path | None = None) -> Model:
    """Loads a model: a ``.safetensors`` or ``.eqx`` file, ``"default"`` for the trained model that comes with the package, or
    ``"spring-damper"`` for the physics-only one.

    Args:
        path: The file or name.
        activation: Activation of an ``.eqx`` network, which the file does not name (``leaky_relu``).
        rig_file: For ``"spring-damper"``: the rig whose data sheet is taken.
    """
    import os

    return Model._of(_pam.Model.load(os.fspath(path), activation, optional_path(rig_file)))
