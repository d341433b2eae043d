"""Times value and gradient of the training loss in JAX, or whole epochs; prints one JSON line a run.

Variants: `published` (the published code path), `rk4-scan` and `rk4-adjoint` (hand-written, all
recordings as lanes), `rk4-plain` (hand-written with `vmap`, on one device), `diffrax-adaptive`.
"""

import argparse
import json
import os
import statistics
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np

from rig import InputError, read_model, read_recordings, read_reference

VARIANTS = ("published", "rk4-scan", "rk4-adjoint", "rk4-plain", "diffrax-adaptive")


def prepare_jax(precision, threads, devices):
    """Restricts the process to `threads` cores and sets number formats, before JAX starts."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:threads])
    import jax

    jax.config.update("jax_platforms", "cpu")
    jax.config.update("jax_num_cpu_devices", devices)
    jax.config.update("jax_enable_x64", precision != "f32")


class Program:
    """Compiled value-and-gradient and displacement functions of a variant, with their arguments.

    Batch `i` runs on device `i` modulo their number. Devices work at the same time, which takes no
    more than calling them in turn: JAX does not wait for results until they are asked for.
    """

    def __init__(self, loss, displacement, parameters, batches, devices):
        """Compiles for each device and shape of batch."""
        import jax

        self.calls = []
        self.compile_s = 0.0
        compiled = {}
        for i, batch in enumerate(batches):
            device = jax.devices()[i % devices]
            arguments = jax.device_put((parameters, batch), device)
            key = (device, len(batch.weight))
            if key not in compiled:
                start = time.perf_counter()
                gradient = jax.jit(jax.value_and_grad(loss)).lower(*arguments).compile()
                self.compile_s += time.perf_counter() - start
                compiled[key] = gradient, jax.jit(displacement)
            self.calls.append((*compiled[key], arguments))

    def value_and_gradient(self):
        """Loss and gradient over all recordings, computed when this returns."""
        import jax

        results = [gradient(*arguments) for gradient, _, arguments in self.calls]
        total = lambda *parts: sum(np.asarray(part) for part in parts)
        return jax.tree.map(total, *results)

    def parameters(self):
        """The parameters as arrays of the host, in double precision."""
        import jax

        return jax.tree.map(lambda a: np.asarray(a, np.float64), self.calls[0][2][0])

    def set_parameters(self, parameters):
        """Puts parameters on the devices, in the formats of those that are there."""
        import jax

        for i, (gradient, motion, (old, batch)) in enumerate(self.calls):
            like = jax.tree.map(lambda a, o: np.asarray(a, o.dtype), parameters, old)
            device = next(iter(jax.tree.leaves(old)[0].devices()))
            self.calls[i] = gradient, motion, (jax.device_put(like, device), batch)

    def displacements(self):
        """x at all samples of all recordings."""
        results = [motion(*arguments) for _, motion, arguments in self.calls]
        return np.concatenate([np.asarray(result) for result in results])


def build(options, model, recordings, devices):
    """The program of the chosen variant, and the settings worth telling."""
    import jax_diffrax
    import jax_rk4
    from jax_joint import LOSS_SCALES, PRECISIONS, Geometry, parameters

    precision = PRECISIONS[options.precision]
    geometry = Geometry(model.radius_mm, model.length_mm)
    scale = LOSS_SCALES[options.loss]
    parts = split(recordings, recordings.count if options.variant == "published" else devices)
    if options.variant.startswith("rk4"):
        method = options.variant.removeprefix("rk4-")
        grid = jax_rk4.make_grid(
            recordings.samples, options.step_ms, parts[0].count, method, options.block
        )
        loss = partial(jax_rk4.loss, grid, method, geometry, scale)
        displacement = partial(jax_rk4.displacement, grid, method)
        make_batch = partial(jax_rk4.make_batch, grid=grid)
        told = {"step_ms": options.step_ms, "block": grid.block}
    else:
        published = options.variant == "published"
        solve = jax_diffrax.published_lane if published else jax_diffrax.adaptive_lane
        loss = partial(jax_diffrax.loss, solve, geometry, scale)
        displacement = partial(jax_diffrax.displacement, solve, geometry)
        make_batch = jax_diffrax.make_batch
        told = {"step_ms": 1.0 if published else None}
    batches = [make_batch(part, recordings.count, precision=precision) for part in parts]
    return Program(loss, displacement, parameters(model, precision), batches, devices), told


def split(recordings, parts):
    """The recordings in `parts` of nearly equal size, larger ones first."""
    size, larger = divmod(recordings.count, parts)
    ends = [size * i + min(i, larger) for i in range(parts + 1)]
    return [recordings.part(*ends[i : i + 2]) for i in range(parts)]


def device_count(options, count):
    """CPU devices that share the recordings; the published path takes one after the other, and the plain
    program leaves JAX as it starts."""
    if options.variant == "published":
        return 1
    default = 1 if options.variant == "rk4-plain" else options.threads
    return min(options.devices or default, count)


def measure(program, repeat):
    """Loss and gradient, and their seconds; see `timed`."""
    return timed(program.value_and_gradient, repeat)


def timed(run, repeat):
    """Result of a program; of `repeat` runs, after a first one that is not timed, the seconds and the
    seconds of the processor, all threads together."""
    run()
    seconds, processor = [], []
    for _ in range(repeat):
        start = time.perf_counter(), time.process_time()
        result = run()
        seconds.append(time.perf_counter() - start[0])
        processor.append(time.process_time() - start[1])
    return result, seconds, processor


class Adam:
    """Adam (Kingma and Ba 2015) with the gradient cut to norm one, on the host."""

    def __init__(self, parameters, rate):
        """No steps done."""
        import jax

        self.rate = rate
        self.steps = 0
        self.mean = jax.tree.map(np.zeros_like, parameters)
        self.square = jax.tree.map(np.zeros_like, parameters)

    def step(self, parameters, gradient):
        """The parameters after one step."""
        import jax

        gradient = jax.tree.map(lambda g: np.asarray(g, np.float64), gradient)
        norm = np.sqrt(sum(float(np.sum(g * g)) for g in jax.tree.leaves(gradient)))
        cut = min(1.0, 1.0 / norm)
        self.steps += 1
        self.mean = jax.tree.map(lambda m, g: 0.9 * m + 0.1 * cut * g, self.mean, gradient)
        self.square = jax.tree.map(
            lambda v, g: 0.999 * v + 0.001 * (cut * g) ** 2, self.square, gradient
        )
        first, second = 1.0 - 0.9**self.steps, 1.0 - 0.999**self.steps
        return jax.tree.map(
            lambda p, m, v: p - self.rate * (m / first) / (np.sqrt(v / second) + 1e-8),
            parameters,
            self.mean,
            self.square,
        )


def measure_epochs(program, repeat, rate):
    """Losses and seconds of `repeat` epochs, each value, gradient and update, after two that are not
    timed."""
    parameters = program.parameters()
    adam = Adam(parameters, rate)
    losses, seconds = [], []
    for _ in range(repeat + 2):
        start = time.perf_counter()
        loss, gradient = program.value_and_gradient()
        parameters = adam.step(parameters, gradient)
        program.set_parameters(parameters)
        seconds.append(time.perf_counter() - start)
        losses.append(float(loss))
    return losses, seconds[2:]


def write_gradient(path, loss, gradient):
    """Writes loss and gradient in double precision."""
    double = lambda a: np.asarray(a, np.float64)
    arrays = {f"grad_weight_{k}": double(w) for k, w in enumerate(gradient.weights)}
    arrays |= {f"grad_bias_{k}": double(b) for k, b in enumerate(gradient.biases)}
    np.savez(path, loss=double(loss), grad_raw=double(gradient.raw), **arrays)


def run(options):
    """Reads, measures, and returns the line to print."""
    recordings = read_recordings(options.data)
    if options.seconds is not None:
        recordings = recordings.cut(options.seconds)
    model = read_model(options.model)
    reference = read_reference(options.reference, recordings) if options.reference else None
    devices = device_count(options, recordings.count)
    prepare_jax(options.precision, options.threads, devices)
    program, told = build(options, model, recordings, devices)
    if options.epochs_at is not None:
        losses, seconds = measure_epochs(program, options.repeat, options.epochs_at)
        return {
            "variant": options.variant,
            "precision": options.precision,
            "recordings": recordings.count,
            "epoch_s": statistics.median(seconds),
            "losses": losses,
        }
    (loss, gradient), seconds, processor = measure(program, options.repeat)
    _, forward, forward_processor = timed(program.displacements, options.repeat)
    if options.out:
        write_gradient(options.out, loss, gradient)
    error = None
    if reference is not None:
        error = float(np.abs(program.displacements() - reference).max())
    return {
        "variant": options.variant,
        "precision": options.precision,
        "loss_kind": options.loss,
        "recordings": recordings.count,
        "seconds": round(recordings.seconds, 3),
        **told,
        "threads": options.threads,
        "devices": devices,
        "value_and_grad_s": statistics.median(seconds),
        "fastest_s": min(seconds),
        "processor_s": min(processor),
        "forward_s": statistics.median(forward),
        "forward_processor_s": min(forward_processor),
        "compile_s": program.compile_s,
        "x_error_mm": error,
        "loss": float(loss),
    }


def positive(text):
    """A whole number above zero, for the command line."""
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is not above zero")
    return value


def parse(arguments):
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--variant", choices=VARIANTS, required=True)
    parser.add_argument("--precision", choices=("f32", "mixed", "f64"), default="f32")
    parser.add_argument("--model", type=Path, required=True, metavar="FILE.eqx")
    parser.add_argument("--data", type=Path, nargs="+", required=True, metavar="FILE.npz")
    parser.add_argument("--loss", choices=("paper", "published"), default="published")
    parser.add_argument("--seconds", type=float, help="use the first seconds only")
    parser.add_argument("--step-ms", type=float, default=5.0, help="step of the rk4 variants")
    parser.add_argument("--block", type=positive, help="steps a block of the rk4 variants")
    parser.add_argument("--threads", type=positive, default=2, help="cores to use")
    parser.add_argument(
        "--devices",
        type=positive,
        help="CPU devices that share the recordings (default: one a core; rk4-plain: one)",
    )
    parser.add_argument("--repeat", type=positive, default=5)
    parser.add_argument(
        "--epochs-at", type=float, metavar="RATE", help="time whole epochs with Adam at this rate"
    )
    parser.add_argument("--reference", type=Path, metavar="FILE.npz")
    parser.add_argument("--out", type=Path, metavar="FILE.npz", help="where the gradient goes")
    return parser.parse_args(arguments)


def main(arguments=None):
    """Runs one measurement."""
    try:
        print(json.dumps(run(parse(arguments))), flush=True)
    except (InputError, OSError) as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()
