"""What a call from Python costs: training steps with optax beside the gradient of the program, calls with little data, threads,
and memory over many calls.

    cargo build --release && pip install ./pam-python jax optax && python recordings.py --count 29 --out data
    python python_calls.py --data data --out python_calls.json

A step is value and gradient over all recordings through `pam_ode.jax.loss`, clipping and Adam, under `jit`. Program, package and
step take turns; seconds are medians over all turns, the ratio is the median over the turns' own. `--pam` is the program.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]


def seconds(call) -> float:
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def of_program(program: Path, model: Path, data: Path, method: str, repeat: int) -> list[float]:
    """Seconds of value and gradient in `pam gradient`, repeat by repeat."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "gradient.npz"
        command = [program, "--quiet", "gradient", "--model", model, "--data", *sorted(data.glob("nn_*.npz"))]
        command += ["--loss", "published", "--method", method, "--input", "linear", "--repeat", repeat, "--out", out]
        subprocess.run([str(c) for c in command], check=True, capture_output=True)
        with np.load(out) as told:
            return np.ravel(told["value_and_grad_s"]).tolist()


def steps(arguments, path: Path, method: str) -> dict:
    """Times of program, package and optax step for a model."""
    import jax
    import optax

    import pam_ode as pam
    import pam_ode.jax

    jax.config.update("jax_enable_x64", True)
    model = pam.load(path)
    recordings = pam.read(sorted(arguments.data.glob("nn_*.npz")))
    problem = pam.Problem(model, recordings, method=method, input="linear")
    loss, at = pam_ode.jax.loss(problem), pam_ode.jax.parameters(model)
    optimiser = optax.chain(optax.clip_by_global_norm(1.0), optax.adam(1e-9))
    state = optimiser.init(at)

    @jax.jit
    def step(at, state):
        value, gradient = jax.value_and_grad(loss)(at)
        change, state = optimiser.update(gradient, state)
        return optax.apply_updates(at, change), state, value

    jax.block_until_ready(step(at, state))
    problem.value_and_gradient()
    found: dict[str, list[float]] = {"program_s": [], "package_s": [], "step_s": []}
    ratios = []
    for _ in range(arguments.rounds):
        program = of_program(arguments.pam, path, arguments.data, method, arguments.repeat)
        package, whole = [], []
        for _ in range(arguments.repeat):
            package.append(seconds(problem.value_and_gradient))
            whole.append(seconds(lambda: jax.block_until_ready(step(at, state))))
        for key, values in zip(found, (program, package, whole)):
            found[key] += values
        ratios.append(float(np.median(whole) / np.median(program)))
    told: dict = {key: float(np.median(values)) for key, values in found.items()}
    told |= {"step_over_program": float(np.median(ratios)), "ratios": ratios, "recordings": len(recordings)}
    told["step_over_package"] = told["step_s"] / told["package_s"]
    return told


def small_calls() -> dict:
    """Microseconds of calls with two samples, and kilobytes that 10,000 of them leave."""
    import pam_ode as pam

    time_s = np.arange(50) * 2e-3
    command = pam.Recording.at_rest(time_s, 412.0, 40 * np.sin(12 * time_s))
    two = command[:2]
    published = ROOT / "data" / "published" / "hybrid_model_puresine_16.eqx"
    told: dict = {}
    random = np.random.default_rng(0)
    widths = [4, 8, 8, 1]
    layers = [(random.normal(size=(m, n)), random.normal(size=m)) for n, m in zip(widths, widths[1:])]
    for name, model in (("width_8", pam.Model.from_layers(layers, "leaky_relu")), ("published", pam.load(published))):
        problem = pam.Problem(model, two)
        at = problem.parameters()
        for what, call in (
            ("gradient", lambda: problem.value_and_gradient(at)),
            ("value", lambda: problem.value(at)),
            ("predict", lambda: model.predict(two)),
        ):
            times = [seconds(call) for _ in range(2000)]
            told[f"{what}_{name}_us"] = 1e6 * float(np.median(times))
            told[f"{what}_{name}_least_us"] = 1e6 * min(times)
    problem = pam.Problem(pam.load(published), command)
    at = problem.parameters(per_recording=True)

    def peak_kb() -> int:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    for _ in range(500):
        problem.value_and_gradient(at)
    before = peak_kb()
    for _ in range(10_000):
        problem.value_and_gradient(at)
    told["growth_kb"] = peak_kb() - before
    return told


def threads() -> dict:
    """How much faster two threads are than one after the other: one recording each, so that one core computes it."""
    import pam_ode as pam

    model = pam.load()
    time_s = np.arange(70_000) * 1e-3
    command = pam.Recording.at_rest(time_s, 412.0, 60 * np.sin(2 * np.pi * time_s))
    problems = [pam.Problem(model, command, method="adjoint", solver="rk4", step_ms=2.0) for _ in range(2)]
    for problem in problems:
        problem.value_and_gradient()

    def together() -> None:
        workers = [threading.Thread(target=problem.value_and_gradient) for problem in problems]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()

    one, both = [], []
    for _ in range(5):
        one.append(seconds(lambda: [problem.value_and_gradient() for problem in problems]))
        both.append(seconds(together))
    return {"one_after_the_other_s": float(np.median(one)), "two_threads_s": float(np.median(both))}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=HERE / "data")
    parser.add_argument("--pam", type=Path, default=ROOT / "target" / "release" / "pam")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    told = {"small": small_calls(), "threads": threads()}
    told["leaky_relu"] = steps(arguments, arguments.data / "perturbed.eqx", "exact")
    told["silu"] = steps(arguments, ROOT / "pam-cli" / "models" / "default.safetensors", "surrogate")
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    arguments.out.write_text(json.dumps(told, indent=1) + "\n")
    json.dump(told, sys.stdout, indent=1)


if __name__ == "__main__":
    main()
