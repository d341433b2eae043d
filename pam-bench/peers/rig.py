"""The joint in NumPy: model files, recordings, gas law. What every benchmark here reads.

Units are mm, mm/s, kPa absolute, g, mN, kg, s.
"""

import dataclasses
import os
from pathlib import Path

import numpy as np

LEAK = 0.01
"""Slope of the LeakyReLU below zero."""

COLUMNS = (
    "time_s",
    "displacement_mm",
    "velocity_mm_s",
    "pressure_flexor_kpa",
    "pressure_extensor_kpa",
    "force_n",
)
"""Arrays of a recording, each with one number a sample."""


class InputError(Exception):
    """Input that cannot be used; the message says which and why."""


@dataclasses.dataclass(frozen=True)
class Model:
    """Network and raw parameters, in double precision.

    `weights` and `biases` hold one array a layer for the inputs (m_f, m_e, x, v). `raw` is
    (m, C, nu) before softplus. `radius_mm` and `length_mm` are the nominal size of a muscle.
    """

    weights: list
    biases: list
    raw: np.ndarray
    radius_mm: float
    length_mm: float

    def perturbed(self, network=1.02, mass=1.05):
        """The model with every weight and bias times `network` and raw m times `mass`."""
        return dataclasses.replace(
            self,
            weights=[network * w for w in self.weights],
            biases=[network * b for b in self.biases],
            raw=self.raw * np.array([mass, 1.0, 1.0]),
        )

    def rounded(self):
        """The model as a file holds it: float32 weights, biases and raw parameters."""
        single = lambda a: a.astype(np.float32).astype(np.float64)
        return dataclasses.replace(
            self,
            weights=[single(w) for w in self.weights],
            biases=[single(b) for b in self.biases],
            raw=single(self.raw),
        )


@dataclasses.dataclass(frozen=True)
class Recordings:
    """Recordings of equal length and rate, one row each.

    `state` is [recordings, samples, 4] with x, v, P_f, P_e; `force_mn` is [recordings, samples];
    `masses_g` is [recordings, 2], flexor and extensor.
    """

    names: list
    time_s: np.ndarray
    state: np.ndarray
    force_mn: np.ndarray
    masses_g: np.ndarray

    @property
    def count(self):
        """Number of recordings."""
        return len(self.names)

    @property
    def samples(self):
        """Samples of each."""
        return len(self.time_s)

    @property
    def seconds(self):
        """Length of each, from first to last sample."""
        return float(self.time_s[-1] - self.time_s[0])

    def part(self, first, end):
        """The recordings from `first` to before `end`."""
        return Recordings(
            self.names[first:end],
            self.time_s,
            self.state[first:end],
            self.force_mn[first:end],
            self.masses_g[first:end],
        )

    def cut(self, seconds):
        """The first `seconds` of each."""
        end = 1 + round(seconds * 1000)
        if not 2 <= end <= self.samples:
            raise InputError(f"cannot take {seconds} s of recordings of {self.seconds:.3f} s")
        return dataclasses.replace(
            self,
            time_s=self.time_s[:end],
            state=self.state[:, :end],
            force_mn=self.force_mn[:, :end],
        )


def published_weights():
    """Path of the published weights."""
    workspace = Path(__file__).resolve().parents[2]
    return workspace / "data" / "published" / "hybrid_model_puresine_16.eqx"


def softplus(z):
    """log(1 + exp(z)) without overflow."""
    return np.logaddexp(0.0, z)


def read_model(path):
    """Reads consecutive `.npy` records: W, b of each layer, raw parameters, r0, L0."""
    records = []
    try:
        with open(path, "rb") as file:
            size = os.fstat(file.fileno()).st_size
            while file.tell() < size:
                records.append(np.load(file).astype(np.float64))
    except (OSError, ValueError) as error:
        raise InputError(f"{path} is no readable model: {error}") from None
    shapes = [r.shape for r in records]
    if len(records) != 9 or shapes[0][1:] != (4,) or shapes[6:] != [(3,), (), ()]:
        raise InputError(
            f"{path} should hold W1 b1 W2 b2 W3 b3, three parameters, r0 and L0; found {shapes}"
        )
    return Model(
        weights=records[0:6:2],
        biases=records[1:6:2],
        raw=records[6],
        radius_mm=float(records[7]),
        length_mm=float(records[8]),
    )


def write_model(path, model):
    """Writes a model as `read_model` reads it, in float32 with float64 geometry."""
    with open(path, "wb") as file:
        for weight, bias in zip(model.weights, model.biases):
            np.save(file, weight.astype(np.float32))
            np.save(file, bias.astype(np.float32))
        np.save(file, model.raw.astype(np.float32))
        np.save(file, np.float64(model.radius_mm))
        np.save(file, np.float64(model.length_mm))


def volumes(model, x):
    """Volumes of flexor and extensor (mm³) at displacement `x`."""
    nu = softplus(model.raw[2])
    radius, length = model.radius_mm, model.length_mm
    slope = nu * radius / length
    flexor = np.pi * (radius + slope * x) ** 2 * (length - x)
    extensor = np.pi * (radius - slope * x) ** 2 * (length + x)
    return flexor, extensor


def read_recordings(paths):
    """Reads `.npz` recordings with masses, which must have the same 1 kHz time grid."""
    loaded = [_read_recording(Path(path)) for path in paths]
    if not loaded:
        raise InputError("no recording is given")
    time_s = loaded[0]["time_s"]
    if not np.allclose(np.diff(time_s), 1e-3, rtol=0.0, atol=1e-6):
        raise InputError(f"{paths[0]} is not sampled at 1 kHz")
    for path, columns in zip(paths, loaded):
        if not np.array_equal(columns["time_s"], time_s):
            raise InputError(f"{path} and {paths[0]} have different sample times")
    masses = [[c["mass_flexor_g"], c["mass_extensor_g"]] for c in loaded]
    return Recordings(
        names=[Path(path).stem for path in paths],
        time_s=time_s,
        state=np.array([np.stack([c[name] for name in COLUMNS[1:5]], axis=-1) for c in loaded]),
        force_mn=np.array([1e3 * c["force_n"] for c in loaded]),
        masses_g=np.array(masses, dtype=np.float64),
    )


def _read_recording(path):
    """The arrays of one recording by name."""
    columns = read_arrays(path, (*COLUMNS, "mass_flexor_g", "mass_extensor_g"))
    lengths = {name: columns[name].shape for name in COLUMNS}
    if len(set(lengths.values())) != 1 or columns["time_s"].ndim != 1:
        raise InputError(f"{path}: columns differ in length: {lengths}")
    return columns


def read_arrays(path, names):
    """The named arrays of an `.npz` file."""
    try:
        with np.load(path) as archive:
            missing = [name for name in names if name not in archive]
            if missing:
                raise InputError(f"{path} lacks the arrays {', '.join(missing)}")
            return {name: archive[name] for name in names}
    except (OSError, ValueError) as error:
        raise InputError(f"{path} is no readable .npz file: {error}") from None


def read_reference(path, recordings):
    """Reference displacements for the samples of `recordings`, by name, [recordings, samples]."""
    arrays = read_arrays(path, ("names", "x"))
    rows = {str(name): row for name, row in zip(arrays["names"], arrays["x"])}
    missing = [name for name in recordings.names if name not in rows]
    if missing or arrays["x"].shape[1] < recordings.samples:
        raise InputError(
            f"{path} does not cover {', '.join(missing) or 'all samples'} of the recordings"
        )
    return np.array([rows[name][: recordings.samples] for name in recordings.names])
