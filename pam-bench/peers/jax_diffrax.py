"""The published code path, and what diffrax does with an adaptive step on lanes.

`published`: Tsit5 at constant steps of 1 ms on the four states, the held input found by searching
the sample grid at the times of the stages, saved at all samples, the default adjoint with recursive
checkpoints; one recording after the other.

`adaptive`: Tsit5 with error control on the states (x, v), pressures from x, the force interpolated
linearly, lanes mapped by `vmap`.
"""

import diffrax
import jax
import jax.numpy as jnp

from jax_joint import lane_batch, leaky_relu, pressures, weighted_loss

TOLERANCE = 1e-4
SAMPLE_S = 1e-3


def make_batch(recordings, total, precision):
    """Forces at samples; targets as [lanes, 4, sample]."""
    target = recordings.state.transpose(0, 2, 1)
    return lane_batch(recordings, total, recordings.force_mn, target, precision)


def restoring_force(parameters, inputs):
    """The network for one lane; `inputs` are (m_f, m_e, x, v)."""
    values = inputs.astype(parameters.weights[0].dtype)
    last = len(parameters.weights) - 1
    for layer, (weight, bias) in enumerate(zip(parameters.weights, parameters.biases)):
        values = weight @ values + bias
        values = values if layer == last else leaky_relu(values)
    return values[0].astype(inputs.dtype)


def accelerate(parameters, lane, x, v, force):
    """Acceleration of one lane, mm/s²."""
    restoring = restoring_force(parameters, jnp.stack([*lane.masses_g, x, v]))
    return (force - restoring) / jax.nn.softplus(parameters.raw[0])


def sample_times(lane):
    """Times of the samples, s."""
    return jnp.arange(lane.force.shape[0]).astype(lane.force.dtype) * SAMPLE_S


def solve(field, lane, start, **settings):
    """Tsit5 from `start`, saved at all samples."""
    times = sample_times(lane)
    return diffrax.diffeqsolve(
        diffrax.ODETerm(field),
        diffrax.Tsit5(),
        times[0],
        times[-1],
        dt0=SAMPLE_S,
        y0=start,
        saveat=diffrax.SaveAt(ts=times),
        max_steps=100_000,
        **settings,
    ).ys


def published_lane(geometry, parameters, lane):
    """Four states of one lane at all samples, [4, samples], by the published path."""
    times = sample_times(lane)

    def held(t):
        index = jnp.searchsorted(times, t, side="right") - 1
        return lane.force[jnp.clip(index, 0, len(times) - 1)]

    def field(t, state, _):
        x, v = state[0], state[1]
        pressure_of = lambda x: jnp.stack(one_lane_pressures(parameters.raw, geometry, lane, x))
        _, pressure_rates = jax.jvp(pressure_of, (x,), (v,))
        rate = accelerate(parameters, lane, x, v, held(t))
        return jnp.concatenate([jnp.stack([v, rate]), pressure_rates])

    return solve(field, lane, lane.start, adjoint=diffrax.RecursiveCheckpointAdjoint()).T


def adaptive_lane(geometry, parameters, lane):
    """Four channels of one lane at all samples, [4, samples], with error control."""
    last = lane.force.shape[0] - 2

    def linear(t):
        place = t / SAMPLE_S
        index = jnp.clip(jnp.floor(place).astype(jnp.int32), 0, last)
        left, right = lane.force[index], lane.force[index + 1]
        return left + (place - index) * (right - left)

    def field(t, state, _):
        return jnp.stack([state[1], accelerate(parameters, lane, state[0], state[1], linear(t))])

    controller = diffrax.PIDController(rtol=TOLERANCE, atol=TOLERANCE)
    states = solve(field, lane, lane.start[:2], stepsize_controller=controller)
    x, v = states.T
    return jnp.stack([x, v, *one_lane_pressures(parameters.raw, geometry, lane, x)])


def one_lane_pressures(raw, geometry, lane, x):
    """Pressures of a single lane for `x` of any shape."""
    batch = jax.tree.map(lambda a: a[None], lane)
    return tuple(p[0] for p in pressures(raw, geometry, batch, x[None]))


def channels(solve_lane, geometry, parameters, batch):
    """All channels of all lanes, [lanes, 4, samples]; a single lane is faster unmapped."""
    if len(batch.weight) == 1:
        return solve_lane(geometry, parameters, jax.tree.map(lambda a: a[0], batch))[None]
    return jax.vmap(lambda lane: solve_lane(geometry, parameters, lane))(batch)


def displacement(solve_lane, geometry, parameters, batch):
    """x at all samples, [lanes, samples]."""
    return channels(solve_lane, geometry, parameters, batch)[:, 0]


def loss(solve_lane, geometry, scale, parameters, batch):
    """What the lanes give to the loss."""
    predicted = channels(solve_lane, geometry, parameters, batch)
    return weighted_loss(predicted.swapaxes(0, 1), batch, predicted.shape[2], scale)
