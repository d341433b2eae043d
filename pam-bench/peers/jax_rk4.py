"""Hand-written JAX: classical Runge-Kutta in a scan, all recordings as lanes of one matrix product.

The state is (x, v); pressures follow from x. The air masses are folded into the first bias. The
force is interpolated linearly between samples, and each step is observed at its samples by the cubic
Hermite interpolant through the states and derivatives of its ends.

Three ways to the gradient share all of this:

* `scan`: reverse-mode differentiation of the scan, checkpointed in blocks of steps.
* `adjoint`: the reverse pass written by hand. The forward pass keeps the states at the steps. Going
  back block by block, the stages of all steps of a block are evaluated at once in large matrix
  products, with the slopes of the force; the recursion that remains is two numbers a lane.
* `plain`: as one writes it first. The steps are those of one recording, a layer is a matrix times a vector,
  `vmap` makes lanes of it, and each step is a checkpoint.
"""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from jax_joint import lane_batch, leaky_relu, pressures, weighted_loss
from rig import LEAK, InputError

BLOCK_ROWS = {"scan": 150, "adjoint": 200, "plain": 1}
"""Rows (steps times lanes) of a block that were fastest; `plain` has no blocks."""


class Net(NamedTuple):
    """The network of a batch: masses folded in, matrices as [inputs, outputs], and the mass m."""

    slope: jax.Array  # [2, hidden], of (x, v)
    bias: jax.Array  # [lanes, hidden]
    hidden_weight: jax.Array
    hidden_bias: jax.Array
    out_weight: jax.Array  # [hidden]
    out_bias: jax.Array
    mass: jax.Array


class Grid(NamedTuple):
    """Step length (s), steps, samples a step and steps a block."""

    step_s: float
    steps: int
    samples_a_step: int
    block: int


def make_grid(samples, step_ms, lanes, method, block=None):
    """The grid of recordings of `samples` at 1 kHz; without `block` the fastest one known."""
    width = round(step_ms)
    if width < 1 or abs(width - step_ms) > 1e-9:
        raise InputError(f"a step of {step_ms} ms does not end at samples of 1 ms")
    steps, rest = divmod(samples - 1, width)
    if rest or not steps:
        raise InputError(f"steps of {step_ms} ms do not divide recordings of {samples - 1} ms")
    if block is None:
        block = nearest_divisor(steps, BLOCK_ROWS[method] / lanes)
    if block < 1 or steps % block:
        raise InputError(f"blocks of {block} steps do not divide {steps} steps")
    return Grid(width * 1e-3, steps, width, block)


def nearest_divisor(number, wish):
    """The divisor of `number` that is nearest to `wish` by ratio."""
    divisors = [d for d in range(1, number + 1) if number % d == 0]
    return min(divisors, key=lambda d: abs(np.log(d / wish)))


def make_batch(recordings, total, grid, precision):
    """Forces at the start, middle and end of each step; targets as [lanes, 4, sample, step]."""
    width, force = grid.samples_a_step, recordings.force_mn
    at = lambda offset: force[:, offset : offset + 1 + (grid.steps - 1) * width : width]
    middle = 0.5 * (at(width // 2) + at((width + 1) // 2))
    stages = np.stack([at(0), middle, at(width)], axis=-1)
    target = recordings.state[:, 1:].reshape(recordings.count, grid.steps, width, 4)
    return lane_batch(recordings, total, stages, target.transpose(0, 3, 2, 1), precision)


def fold(parameters, masses_g):
    """The network for the masses of the lanes. The barrier keeps transposes out of the loop."""
    first, hidden, out = parameters.weights
    bias = masses_g.astype(first.dtype) @ first[:, :2].T + parameters.biases[0]
    net = Net(
        slope=first[:, 2:].T,
        bias=bias,
        hidden_weight=hidden.T,
        hidden_bias=parameters.biases[1],
        out_weight=out[0],
        out_bias=parameters.biases[2][0],
        mass=jax.nn.softplus(parameters.raw[0]),
    )
    return jax.lax.optimization_barrier(net)


def first_layer(net, x, v):
    """Values before the first activation for x, v of shape [..., lanes]."""
    x, v = (a.astype(net.slope.dtype)[..., None] for a in (x, v))
    return x * net.slope[0] + v * net.slope[1] + net.bias


def acceleration(net, x, v, force):
    """Acceleration of the lanes, mm/s²."""
    hidden = leaky_relu(first_layer(net, x, v)) @ net.hidden_weight + net.hidden_bias
    restoring = leaky_relu(hidden) @ net.out_weight + net.out_bias
    return (force - restoring.astype(x.dtype)) / net.mass


def stages(accelerate, x, v, force, h):
    """The four stages: lists of stage velocities and of what `accelerate(x, v, force)` gives.

    `accelerate` returns the acceleration first.
    """
    velocities, results = [v], [accelerate(x, v, force[0])]
    for fraction, at in ((0.5, 1), (0.5, 1), (1.0, 2)):
        x_stage = x + fraction * h * velocities[-1]
        v_stage = v + fraction * h * results[-1][0]
        velocities.append(v_stage)
        results.append(accelerate(x_stage, v_stage, force[at]))
    return velocities, results


def mix(h, k):
    """The weighted sum of four stage derivatives."""
    return h / 6.0 * (k[0] + 2.0 * (k[1] + k[2]) + k[3])


def advance(accelerate, h, state, force):
    """One step of `state` (x, v) under the forces at its start, middle and end, [3, lanes], with the
    acceleration that `accelerate(x, v, force)` gives.

    Returns the new state and (x, v, acceleration) at the start.
    """
    x, v = state
    velocities, results = stages(lambda *at: (accelerate(*at),), x, v, force, h)
    rates = [a for (a,) in results]
    return (x + mix(h, velocities), v + mix(h, rates)), (x, v, rates[0])


def blocks(grid, tree):
    """Arrays of one entry a step, cut into blocks."""
    cut = lambda a: a.reshape(grid.steps // grid.block, grid.block, *a.shape[1:])
    return jax.tree.map(cut, tree)


def join(parts, end):
    """Step values [steps, lanes] with the value at the end appended."""
    return jnp.concatenate([parts, end[None]])


def scan_steps(grid, net, x, v, force):
    """States at all steps, [steps + 1, lanes], and accelerations at their starts; checkpointed."""

    @jax.checkpoint
    def block(state, forces):
        return jax.lax.scan(partial(advance, partial(acceleration, net), grid.step_s), state, forces)

    end, starts = jax.lax.scan(block, (x, v), blocks(grid, force))
    xs, vs, accelerations = (a.reshape(grid.steps, -1) for a in starts)
    return join(xs, end[0]), join(vs, end[1]), accelerations


@partial(jax.custom_vjp, nondiff_argnums=(0,))
def adjoint_steps(grid, net, x, v, force):
    """As `scan_steps`, with the reverse pass of `adjoint_backward`."""
    step = partial(advance, partial(acceleration, net), grid.step_s)
    end, starts = jax.lax.scan(step, (x, v), force)
    xs, vs, accelerations = starts
    return join(xs, end[0]), join(vs, end[1]), accelerations


def adjoint_forward(grid, net, x, v, force):
    """Forward pass; keeps the states at the starts of steps."""
    xs, vs, accelerations = adjoint_steps(grid, net, x, v, force)
    return (xs, vs, accelerations), (net, xs[:-1], vs[:-1], force)


class Evaluation(NamedTuple):
    """A stage of all steps of a block; rows are steps times lanes."""

    x: jax.Array  # [steps, lanes]
    v: jax.Array  # [steps, lanes]
    first: jax.Array  # [rows, hidden], after the first activation
    second: jax.Array  # [rows, hidden], after the second activation
    first_slope: jax.Array  # [rows, hidden], d force / d value before the first activation
    second_slope: jax.Array  # [rows, hidden], d force / d value before the second activation


def evaluate(net, x, v, force):
    """Acceleration, its slopes in x and v, and the `Evaluation`; `x` is [steps, lanes]."""
    slope_of = lambda z: jnp.where(z > 0.0, 1.0, LEAK).astype(z.dtype)
    backward_weight = jax.lax.optimization_barrier(net.hidden_weight.T)
    before_first = first_layer(net, x, v).reshape(x.size, -1)
    first = leaky_relu(before_first)
    before_second = first @ net.hidden_weight + net.hidden_bias
    second = leaky_relu(before_second)
    second_slope = slope_of(before_second) * net.out_weight
    first_slope = (second_slope @ backward_weight) * slope_of(before_first)
    restoring = (second @ net.out_weight + net.out_bias).reshape(x.shape).astype(x.dtype)
    slopes = (first_slope @ net.slope.T).reshape(*x.shape, 2).astype(x.dtype)
    return (
        (force - restoring) / net.mass,
        (-slopes[..., 0] / net.mass, -slopes[..., 1] / net.mass),
        Evaluation(x, v, first, second, first_slope, second_slope),
    )


def pull_step(h, adjoint, step):
    """The adjoint of one step: from that of its end to that of its start.

    `step` holds the slopes of the four stage accelerations and what the loss adds at the start to
    x, v and the acceleration. Returns also the adjoints of the four accelerations.
    """
    (to_x, to_v), (slopes, add_x, add_v, add_a) = adjoint, step
    from_x = from_v = 0.0
    sum_x, sum_v = to_x + add_x, to_v + add_v
    of_accelerations = []
    for stage, (weight, reach) in enumerate(((1, 0.0), (2, 1.0), (2, 0.5), (1, 0.5))):
        in_x, in_v = slopes[3 - stage]
        of_v = weight * h / 6.0 * to_x + reach * h * from_x
        of_a = weight * h / 6.0 * to_v + reach * h * from_v
        if stage == 3:
            of_a = of_a + add_a
        from_x, from_v = in_x * of_a, of_v + in_v * of_a
        sum_x, sum_v = sum_x + from_x, sum_v + from_v
        of_accelerations.insert(0, of_a)
    return (sum_x, sum_v), of_accelerations


def stage_gradient(net, evaluation, acceleration, of_acceleration):
    """The gradient of the network and the mass that one stage of a block gives."""
    of_force = (-of_acceleration / net.mass).astype(net.slope.dtype)
    rows = of_force.reshape(-1)
    scaled = jax.lax.optimization_barrier((evaluation.second_slope * rows[:, None]).T)
    inputs = jnp.stack([evaluation.x, evaluation.v]).astype(rows.dtype)
    first_slope = evaluation.first_slope.reshape(*of_force.shape, -1)
    return Net(
        slope=(of_force * inputs).reshape(2, -1) @ evaluation.first_slope,
        bias=jnp.sum(of_force[..., None] * first_slope, axis=0),
        hidden_weight=(scaled @ evaluation.first).T,
        hidden_bias=rows @ evaluation.second_slope,
        out_weight=rows @ evaluation.second,
        out_bias=jnp.sum(rows),
        mass=-jnp.sum(of_acceleration * acceleration) / net.mass,
    )


def adjoint_backward(grid, kept, cotangents):
    """Reverse pass in blocks of steps; see the head of this file."""
    net, xs, vs, force = kept
    of_x, of_v, of_a = cotangents

    def block(carry, step):
        adjoint, gradient = carry
        x, v, force, *additions = step
        accelerate = partial(evaluate, net)
        _, results = stages(accelerate, x, v, jnp.moveaxis(force, 1, 0), grid.step_s)
        accelerations, slopes, evaluations = zip(*results)
        pull = partial(pull_step, grid.step_s)
        adjoint, of_rates = jax.lax.scan(pull, adjoint, (slopes, *additions), reverse=True)
        for stage in zip(evaluations, accelerations, of_rates):
            gradient = jax.tree.map(jnp.add, gradient, stage_gradient(net, *stage))
        return (adjoint, gradient), None

    at_end = (of_x[-1], of_v[-1])
    nothing = jax.tree.map(jnp.zeros_like, net)
    steps = blocks(grid, (xs, vs, force, of_x[:-1], of_v[:-1], of_a))
    (at_start, gradient), _ = jax.lax.scan(block, (at_end, nothing), steps, reverse=True)
    return gradient, *at_start, None


adjoint_steps.defvjp(adjoint_forward, adjoint_backward)


def as_lanes(steps):
    """The method that takes all recordings through `steps` together."""

    def solve(grid, parameters, batch):
        net = fold(parameters, batch.masses_g)
        force = jnp.moveaxis(batch.force, 0, -1)
        xs, vs, rates = steps(grid, net, batch.start[:, 0], batch.start[:, 1], force)
        return xs, vs, join(rates, acceleration(net, xs[-1], vs[-1], force[-1, 2]))

    return solve


def plain(grid, parameters, batch):
    """The method that is written for one recording; see the head of this file."""
    mass = jax.nn.softplus(parameters.raw[0])

    def accelerate(masses_g, x, v, force):
        values = jnp.concatenate([masses_g, jnp.stack([x, v])]).astype(parameters.weights[0].dtype)
        for weight, bias in zip(parameters.weights[:-1], parameters.biases[:-1]):
            values = jax.nn.leaky_relu(weight @ values + bias, LEAK)
        restoring = parameters.weights[-1] @ values + parameters.biases[-1]
        return (force - restoring[0].astype(x.dtype)) / mass

    def recording(masses_g, start, forces):
        own = partial(accelerate, masses_g)
        step = jax.checkpoint(partial(advance, own, grid.step_s))
        (x, v), (xs, vs, rates) = jax.lax.scan(step, (start[0], start[1]), forces)
        return join(xs, x), join(vs, v), join(rates, own(x, v, forces[-1, 2]))

    return jax.vmap(recording, out_axes=1)(batch.masses_g, batch.start, batch.force)


METHODS = {"scan": as_lanes(scan_steps), "adjoint": as_lanes(adjoint_steps), "plain": plain}
"""States and accelerations at all steps, [steps + 1, lanes], of `(grid, parameters, batch)`."""


def observe(grid, start, end, start_rate, end_rate):
    """Hermite interpolant [lanes, sample, step] at the samples of each step after its start."""
    theta = jnp.arange(1, grid.samples_a_step + 1, dtype=start.dtype) / grid.samples_a_step
    theta = theta[:, None]
    to_end = theta**2 * (3.0 - 2.0 * theta)
    rates = grid.step_s * theta * (1.0 - theta)
    across = lambda a: a[:, None, :]
    return (
        across(start)
        + to_end * across(end - start)
        + rates * ((1.0 - theta) * across(start_rate) - theta * across(end_rate))
    )


def motion(grid, method, parameters, batch):
    """x and v at all samples but the first, [lanes, sample, step]."""
    xs, vs, rates = METHODS[method](grid, parameters, batch)
    ends = lambda a: (a.T[:, :-1], a.T[:, 1:])
    return observe(grid, *ends(xs), *ends(vs)), observe(grid, *ends(vs), *ends(rates))


def displacement(grid, method, parameters, batch):
    """x at all samples, [lanes, samples]."""
    x, _ = motion(grid, method, parameters, batch)
    in_order = jnp.swapaxes(x, 1, 2).reshape(len(x), -1)
    return jnp.concatenate([batch.start[:, :1], in_order], axis=1)


def loss(grid, method, geometry, scale, parameters, batch):
    """What the lanes give to the loss."""
    x, v = motion(grid, method, parameters, batch)
    predicted = (x, v, *pressures(parameters.raw, geometry, batch, x))
    samples = grid.steps * grid.samples_a_step + 1
    return weighted_loss(predicted, batch, samples, scale)
