"""The hybrid model in JAX: parameters, pressures, loss, and recordings as lanes of a batch."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from rig import LEAK

LOSS_SCALES = {"paper": 1.0, "published": 0.5}
"""The published code averages over both columns of a pair at once: half of the paper's loss."""

SQUARE_WEIGHTS = (100.0, 100.0, 1.0, 1.0)
"""Weights of the squared errors of x, v, P_f, P_e."""


class Precision(NamedTuple):
    """Number formats of the state (and raw parameters) and of the network."""

    state: type
    network: type


PRECISIONS = {
    "f32": Precision(jnp.float32, jnp.float32),
    "mixed": Precision(jnp.float64, jnp.float32),
    "f64": Precision(jnp.float64, jnp.float64),
}


class Parameters(NamedTuple):
    """What the gradient is of: weights and biases by layer, (m, C, nu) before softplus."""

    weights: list
    biases: list
    raw: jax.Array


class Batch(NamedTuple):
    """Some of the recordings as lanes, the first axis of each array."""

    weight: jax.Array  # [lanes], one over the number of all recordings
    masses_g: jax.Array  # [lanes, 2]
    start: jax.Array  # [lanes, 4]
    force: jax.Array  # [lanes, ...], as the variant reads it
    target: jax.Array  # [lanes, 4, ...], as the variant observes it


class Geometry(NamedTuple):
    """Nominal radius and length of a muscle, mm."""

    radius_mm: float
    length_mm: float


def parameters(model, precision):
    """The parameters of a `rig.Model` in the wanted number formats."""
    network = lambda arrays: [jnp.asarray(a, precision.network) for a in arrays]
    return Parameters(
        network(model.weights), network(model.biases), jnp.asarray(model.raw, precision.state)
    )


def leaky_relu(z):
    """LeakyReLU as a maximum, which needs no branch."""
    return jnp.maximum(z, LEAK * z)


def pressures(raw, geometry, batch, x):
    """Pressures (flexor, extensor) for displacements `x` [lanes, ...] of sealed muscles.

    The closed chamber integrates exactly: P(t) = P(0) + C m [1/V(x(t)) - 1/V(x(0))].
    """
    gas, nu = jax.nn.softplus(raw[1]), jax.nn.softplus(raw[2])
    slope = nu * (geometry.radius_mm / geometry.length_mm)
    column = lambda a: a.reshape(a.shape + (1,) * (x.ndim - 1))
    x0 = column(batch.start[:, 0])

    def pressure(index, sign):
        inverse_volume = lambda x: (
            1.0
            / (
                jnp.pi
                * (geometry.radius_mm + sign * slope * x) ** 2
                * (geometry.length_mm - sign * x)
            )
        )
        rise = inverse_volume(x) - inverse_volume(x0)
        return column(batch.start[:, 2 + index]) + gas * column(batch.masses_g[:, index]) * rise

    return pressure(0, 1.0), pressure(1, -1.0)


def weighted_loss(predicted, batch, samples, scale):
    """The part of the loss that the predicted channels (x, v, P_f, P_e), each [lanes, ...], give.

    `samples` is the number of samples of a recording. Samples left out of `predicted` count as
    exact, which the first one is.
    """
    total = 0.0
    for channel, (weight, values) in enumerate(zip(SQUARE_WEIGHTS, predicted)):
        squares = jnp.square(values - batch.target[:, channel])
        total += weight * jnp.sum(squares, axis=tuple(range(1, squares.ndim)))
    return scale / samples * jnp.dot(batch.weight, total)


def lane_batch(recordings, total, force, target, precision):
    """A batch of `recordings`, some of `total`; the variant lays out `force` and `target`."""
    state = lambda a: np.asarray(a, precision.state)
    return Batch(
        weight=state(np.full(recordings.count, 1.0 / total)),
        masses_g=state(recordings.masses_g),
        start=state(recordings.state[:, 0]),
        force=state(force),
        target=state(target),
    )
