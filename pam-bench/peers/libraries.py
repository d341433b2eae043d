"""Gradient methods across libraries: error, time, memory and compile wait on one set of problems.

    cargo build --release -p pam-bench && pip install ./pam-python diffrax equinox jax matplotlib
    pip install torch torchdiffeq torchode                   # as far as wanted
    python pam-bench/peers/libraries.py --out results/gradients

Problems are those of `pam-bench gradients` (linear, Van der Pol, the quartic trap, slow-fast) and the hybrid joint, 2 s under
a sine of force read linearly, with LeakyReLU and with SiLU. `--field FILE.py` adds one of your own for the Python libraries:
a module with `field(t, y, p)` in terms of `jax.numpy`, `y0`, `p` and `times`; its loss is half the mean square of the states.

Each library and method runs in a process of its own. Errors are relative, of the gradient by all parameters, the largest
over parameters and start as in `pam-bench`; truths are closed forms where there are some, else solves at 1e-12 by an order 8
method. Times are medians of value and gradient after the first call; the compile wait is the first call less that. Memory is
the growth of the process over what it took after its imports; for pam on the small problems it is what was allocated.
"""

from __future__ import annotations

import argparse
import json
import platform
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Callable

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
TOLERANCES = (1e-4, 1e-6, 1e-8)
SMALL = ("linear", "van-der-pol", "quartic", "stiff")
JOINTS = ("joint-leaky_relu", "joint-silu")
DIFFRAX = ("checkpoint", "direct", "backsolve", "forward")
RUNNERS = {
    "pam": ("exact", "adjoint"),
    "diffrax": DIFFRAX,
    "torchdiffeq": ("direct", "adjoint"),
    "torchode": ("direct",),
}
#: Accuracy at which the table compares.
EQUAL = 1e-4


def evenly(count: int, end: float) -> np.ndarray:
    return end * np.arange(1, count + 1) / count


class Problem:
    """A field `f(np, t, y, p)`, in terms of NumPy, jax.numpy or torch, with its loss."""

    def __init__(self, field: Callable, y0, p, times, target: Callable, loss: str = "squares", low_order: bool = False):
        self.field, self.target, self.loss, self.low_order = field, target, loss, low_order
        self.y0, self.p, self.times = np.asarray(y0, float), np.asarray(p, float), np.asarray(times, float)


def small(name: str) -> Problem:
    """The problems of pam-bench/src/gradients/problems at its shorter horizon."""
    if name == "linear":
        return Problem(
            lambda t, y, p, stack: stack([p[0] * y[0] + p[1] * y[1], p[2] * y[0] + p[3] * y[1]]),
            [1.0, -0.4], [-0.3, 1.7, -2.1, -0.2], evenly(10, 4.0), lambda t: [0.5 + 0 * t, 0 * t],
        )  # fmt: skip
    if name == "van-der-pol":
        return Problem(
            lambda t, y, p, stack: stack([y[1], p[0] * (1.0 - y[0] * y[0]) * y[1] - p[1] * y[0]]),
            [2.0, 0.0], [1.5, 1.0], evenly(40, 4.0), lambda t: [2 * np.cos(t), -2 * np.sin(t)],
        )  # fmt: skip
    if name == "quartic":
        return Problem(
            lambda t, y, p, stack: stack([(t - p[0]) ** 4]), [0.0], [0.45 * 0.8], [0.8], lambda t: [0 * t], "end", True
        )
    if name == "stiff":
        return Problem(
            lambda t, y, p, stack: stack([-p[0] * y[0] * y[1], p[1] * (y[0] - y[1])]),
            [1.0, 1.5], [1.0, 200.0], evenly(2, 0.4), lambda t: [0.2 + 0 * t, 0.2 + 0 * t],
        )  # fmt: skip
    raise SystemExit(f"unknown problem {name}")


def own(path: str) -> Problem:
    scope: dict[str, Any] = {}
    exec(Path(path).read_text(), scope)
    field = scope["field"]
    n = len(np.atleast_1d(scope["y0"]))
    return Problem(lambda t, y, p, stack: field(t, y, p), scope["y0"], scope["p"], scope["times"], lambda t: [0 * t] * n)


def joint(activation: str):
    """Model, measured recording and a network of the joint; its motion is that of the default model pushed off."""
    import pam_ode as pam

    time_s = np.arange(2001) * 1e-3
    force_n = 60 * (np.sin(2 * np.pi * 0.7 * time_s + 0.4) + np.sin(2 * np.pi * 2.3 * time_s))
    base = pam.load()
    layers = [(w, b) for w, b in base.layers]
    model = pam.Model.from_layers(layers, activation, mass_kg=base.physical.mass_kg, auxiliary_damping_kg_s=200.0)
    masses = model.sealed_masses(412.0)
    command = pam.Recording.at_rest(time_s, 412.0, force_n, masses_g=masses, name="joint")
    measured = pam.load("spring-damper").predict(command, masses_g=masses).to_recording("joint")
    return model, measured


def largest_error(found: list[np.ndarray], truth: list[np.ndarray]) -> float:
    return max(float(np.linalg.norm(a - b) / max(np.linalg.norm(b), 1e-300)) for a, b in zip(found, truth))


def timed(call: Callable[[], Any]) -> tuple[Any, float, float]:
    """Result, median time and what the first call took more."""
    start = time.perf_counter()
    result = call()
    first = time.perf_counter() - start
    times = []
    while len(times) < 3 or (sum(times) < 0.5 and len(times) < 30):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    median = float(np.median(times))
    return result, median, max(0.0, first - median)


def memory_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def jax_value(name: str, field_file: str | None, adjoint: str, tolerance: float, order8: bool = False):
    """The loss as a function of (p, y0) through diffrax, and where to take it."""
    import diffrax
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    adjoints = {
        "checkpoint": diffrax.RecursiveCheckpointAdjoint,
        "direct": diffrax.DirectAdjoint,
        "backsolve": diffrax.BacksolveAdjoint,
        "forward": getattr(diffrax, "ForwardMode", diffrax.DirectAdjoint),
    }
    controller = diffrax.PIDController(rtol=tolerance, atol=tolerance)
    if name.startswith("joint"):
        activation = name.split("-")[1]
        model, measured = joint(activation)
        from pam_ode.jax import ACTIVATIONS

        act, mass = ACTIVATIONS[activation], model.physical.mass_kg
        force = jnp.asarray(measured.force_mn)
        masses = jnp.asarray(measured.masses_g)
        p = {k: jnp.asarray(v) for k, v in model.parameters().items() if k.startswith(("weight", "bias"))}
        count = len(model.layers)

        def field(t, y, p):
            at = jnp.clip(t * 1e3, 0, len(force) - 1)
            k = jnp.minimum(at.astype(int), len(force) - 2)
            u = force[k] + (at - k) * (force[k + 1] - force[k])
            z = jnp.concatenate([masses, y])
            for layer in range(count):
                z = p[f"weight_{layer}"] @ z + p[f"bias_{layer}"]
                z = act(z) if layer + 1 < count else z
            return jnp.stack([y[1], (u - z[0] - 200.0 * y[1]) / mass])

        times, y0 = jnp.asarray(measured.time_s), jnp.asarray(measured.states[0, :2])
        goal = jnp.asarray(measured.states[:, :2])

        def of_states(states):
            return jnp.sum(jnp.mean((states - goal) ** 2, axis=0))

        solver, t1 = diffrax.Tsit5(), float(times[-1])
    else:
        problem = own(field_file) if name == "own" else small(name)

        def field(t, y, p):
            return problem.field(t, y, p, jnp.stack)

        times, t1 = jnp.asarray(problem.times), float(problem.times[-1])
        y0, p = jnp.asarray(problem.y0), jnp.asarray(problem.p)
        goal = jnp.stack([jnp.asarray(c) for c in problem.target(problem.times)], axis=1)

        def of_states(states):
            return states[-1, 0] if problem.loss == "end" else 0.5 * jnp.mean(jnp.sum((states - goal) ** 2, axis=1))

        solver = diffrax.Bosh3() if problem.low_order else diffrax.Tsit5()
    if order8:
        solver = diffrax.Dopri8()

    def value(p, y0):
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(field), solver, 0.0, t1, None, y0, p, saveat=diffrax.SaveAt(ts=times),
            stepsize_controller=controller, adjoint=adjoints[adjoint](), max_steps=1 << 15,
        )  # fmt: skip
        return of_states(solution.ys)

    if adjoint == "forward":
        # One pass per number: for many of them no method of this kind is meant.
        value_and_gradient = jax.jit(lambda p, y0: (value(p, y0), jax.jacfwd(value, (0, 1))(p, y0)))
    else:
        value_and_gradient = jax.jit(jax.value_and_grad(value, (0, 1)))
    return value_and_gradient, p, y0


def flat(tree: Any) -> np.ndarray:
    if isinstance(tree, dict):
        return np.concatenate([np.ravel(np.asarray(tree[k])) for k in sorted(tree)])
    return np.ravel(np.asarray(tree))


def truth(name: str, field_file: str | None) -> list[np.ndarray]:
    if name == "joint-leaky_relu":
        # From kink to kink in closed form.
        return pam_gradient(name, "exact", 1e-8)()[1]
    call, p, y0 = jax_value(name, field_file, "checkpoint", 1e-12, order8=not name.startswith("joint"))
    _, (gp, gy) = call(p, y0)
    return [flat(gp), flat(gy)]


def pam_gradient(name: str, method: str, tolerance: float) -> Callable[[], tuple[float, list[np.ndarray]]]:
    import pam_ode as pam

    model, measured = joint(name.split("-")[1])
    options: dict[str, Any] = {"input": "linear"}
    if method != "exact":
        options |= {"solver": "tsit5", "rtol": tolerance, "atol": tolerance}
    loss = {"kind": "squared", "weights": [1.0, 1.0, 0.0, 0.0]}
    problem = pam.Problem(model, measured, loss, method=method, **options)

    def call() -> tuple[float, list[np.ndarray]]:
        found = problem.value_and_gradient()
        weights = {k: g for k, g in found.gradient.items() if k.startswith(("weight", "bias"))}
        return found.value, [flat(weights), found.gradient["initial_states"][0, :2]]

    return call


def torch_gradient(name: str, library: str, method: str, tolerance: float):
    import torch

    torch.set_default_dtype(torch.float64)
    problem = small(name)
    times = torch.tensor(np.concatenate([[0.0], problem.times]))
    goal = torch.tensor(np.stack(problem.target(problem.times), axis=1))
    p = torch.tensor(problem.p, requires_grad=True)
    y0 = torch.tensor(problem.y0, requires_grad=True)

    def of_states(states):
        return states[-1, 0] if problem.loss == "end" else 0.5 * ((states - goal) ** 2).sum(dim=1).mean()

    if library == "torchdiffeq":
        import torchdiffeq

        solve = torchdiffeq.odeint_adjoint if method == "adjoint" else torchdiffeq.odeint
        extra = {"adjoint_params": (p,)} if method == "adjoint" else {}

        def states():
            field = torch.nn.Module()
            field.forward = lambda t, y: problem.field(t, y, p, torch.stack)
            solver = "bosh3" if problem.low_order else "dopri5"
            return solve(field, y0, times, rtol=tolerance, atol=tolerance, method=solver, **extra)[1:]

    else:
        import torchode

        def f(t, y):
            return problem.field(t[0], y[0], p, torch.stack)[None]

        term = torchode.ODETerm(f)
        step = torchode.Tsit5(term=term)
        control = torchode.IntegralController(atol=tolerance, rtol=tolerance, term=term)
        solver = torchode.AutoDiffAdjoint(step, control)

        def states():
            return solver.solve(torchode.InitialValueProblem(y0=y0[None], t_eval=times[None])).ys[0, 1:]

    def call():
        value = of_states(states())
        gp, gy = torch.autograd.grad(value, (p, y0))
        return value.item(), [gp.numpy(), gy.numpy()]

    return call


def run_cell(library: str, method: str, name: str, field_file: str | None, truth_file: str) -> None:
    """One library and method on one problem at all tolerances; rows as JSON lines."""
    with np.load(truth_file) as stored:
        exact = [stored["p"], stored["y0"]]
    for tolerance in TOLERANCES:
        row: dict[str, Any] = {"library": library, "method": method, "problem": name, "tolerance": tolerance}
        try:
            if library == "pam":
                call = pam_gradient(name, method, tolerance)
            elif library == "diffrax":
                function, p, y0 = jax_value(name, field_file, method, tolerance)

                def call(function=function, p=p, y0=y0):
                    value, gradient = function(p, y0)
                    return float(value), [flat(g) for g in gradient]

            else:
                call = torch_gradient(name, library, method, tolerance)
            before = memory_mb()
            (_, gradient), seconds, wait = timed(call)
            row |= {
                "seconds": seconds,
                "compile_s": wait,
                "memory_mb": memory_mb() - before,
                "error": largest_error(gradient, exact),
            }
        except Exception as error:  # noqa: BLE001 - what a library cannot do is a result
            row["failure"] = f"{type(error).__name__}: {str(error).splitlines()[0][:200] if str(error) else ''}"
        print(json.dumps(row), flush=True)
        if method == "exact":
            return


def installed(library: str) -> bool:
    import importlib.util

    return importlib.util.find_spec({"pam": "pam_ode"}.get(library, library)) is not None


def of_pam_bench() -> list[dict[str, Any]]:
    """The rows of the program `pam-bench` on the small problems."""
    program = ROOT / "target" / "release" / "pam-bench"
    with tempfile.TemporaryDirectory() as folder:
        arguments = [str(program), "gradients", "--problems", ",".join(SMALL), "--json", "--out", folder]
        found = json.loads(subprocess.run(arguments, check=True, capture_output=True, text=True).stdout)
    horizons = {name: float(small(name).times[-1]) for name in SMALL}
    rows = []
    for r in found["rows"]:
        if r["part"] != "grid" or abs(r["horizon_s"] - horizons[r["problem"]]) > 1e-9 or r["rtol"] is None:
            continue
        row = {"library": "pam", "method": r["method"], "problem": r["problem"], "tolerance": r["rtol"]}
        if r["failure"]:
            row["failure"] = r["failure"]
        else:
            row |= {"seconds": r["seconds"], "compile_s": 0.0, "error": r["gradient_error"]}
            row["memory_mb"] = None if r["peak_bytes"] is None else r["peak_bytes"] / 2**20
        rows.append(row)
    return rows


def table(rows: list[dict[str, Any]]) -> str:
    """For each problem and method the cheapest row within the error of EQUAL."""
    text = (
        f"Cheapest value and gradient with a relative error of at most {EQUAL:g}.\n\n"
        "| problem | library | method | tolerance | error | time (ms) | compile wait (s) | memory (MB) |\n"
        "|---|---|---|---|---|---|---|---|\n"
    )
    for key in dict.fromkeys((r["problem"], r["library"], r["method"]) for r in rows):
        own_rows = [r for r in rows if (r["problem"], r["library"], r["method"]) == key]
        good = [r for r in own_rows if r.get("error") is not None and r["error"] <= EQUAL]
        if good:
            r = min(good, key=lambda r: r["seconds"])
            memory = "–" if r["memory_mb"] is None else f"{r['memory_mb']:.2f}"
            cells = f"{r['tolerance']:.0e} | {r['error']:.1e} | {1e3 * r['seconds']:.3g} | {r['compile_s']:.2f} | {memory}"
        else:
            errors = [r["error"] for r in own_rows if r.get("error") is not None]
            why = f"smallest error {min(errors):.1e}" if errors else own_rows[0].get("failure", "")
            cells = f"not reached: {why} | | | | ".replace("|  |", "| |")
        text += "| " + " | ".join(key) + f" | {cells} |\n"
    return text


def figures(rows: list[dict[str, Any]], out: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    colours = {"pam": "tab:red", "diffrax": "tab:blue", "torchdiffeq": "tab:green", "torchode": "tab:purple"}
    for name in dict.fromkeys(r["problem"] for r in rows):
        figure, axes = plt.subplots(figsize=(6.5, 4.5), layout="constrained")
        series = dict.fromkeys((r["library"], r["method"]) for r in rows if r["problem"] == name)
        for k, (library, method) in enumerate(series):
            found = [r for r in rows if (r["problem"], r["library"], r["method"]) == (name, library, method)]
            points = [(r["seconds"], max(r["error"], 1e-16)) for r in found if r.get("error") is not None]
            if points:
                marker = "osD^v<>pPX*"[k % 11]
                axes.loglog(*zip(*points), marker=marker, color=colours[library], label=f"{library} {method}", lw=1)
        axes.set(xlabel="time of value and gradient (s)", ylabel="relative error of the gradient", title=name)
        axes.legend(fontsize=7, ncols=2)
        figure.savefig(out / f"{name}.svg")
        plt.close(figure)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "gradients")
    parser.add_argument("--problems", default=",".join((*SMALL, *JOINTS)))
    parser.add_argument("--libraries", default=",".join(RUNNERS))
    parser.add_argument("--field", help="a field of your own, FILE.py")
    parser.add_argument("--cell", nargs=4, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.cell:
        library, method, name, truth_file = arguments.cell
        run_cell(library, method, name, arguments.field, truth_file)
        return
    problems = [p for p in arguments.problems.split(",") if p] + (["own"] if arguments.field else [])
    libraries = [x for x in arguments.libraries.split(",") if installed(x)]
    missing = sorted(set(arguments.libraries.split(",")) - set(libraries))
    rows = [r for r in of_pam_bench() if r["problem"] in problems] if "pam" in libraries else []
    with tempfile.TemporaryDirectory() as folder:
        for name in problems:
            gp, gy = truth(name, arguments.field)
            np.savez(Path(folder) / "truth.npz", p=gp, y0=gy)
            for library in libraries:
                for method in RUNNERS[library]:
                    of_joint = name in JOINTS
                    if (library == "pam" and not of_joint) or (library.startswith("torch") and name not in SMALL):
                        continue
                    if (method == "exact" and name != "joint-leaky_relu") or (method == "forward" and of_joint):
                        continue
                    print(f"{name}: {library} {method}", file=sys.stderr, flush=True)
                    command = [sys.executable, __file__, "--cell", library, method, name, f"{folder}/truth.npz"]
                    command += ["--field", arguments.field] if arguments.field else []
                    try:
                        done = subprocess.run(command, capture_output=True, text=True, timeout=300)
                        rows += [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
                    except subprocess.TimeoutExpired:
                        rows.append({"library": library, "method": method, "problem": name, "tolerance": None,
                                     "failure": "more than 300 s"})  # fmt: skip
            # What is there counts if the rest is interrupted.
            write(arguments.out, rows, missing)
    print(table(rows))


def write(out: Path, rows: list[dict[str, Any]], missing: list[str]) -> None:
    """`libraries.json`, `table.md` and a figure for each problem."""
    out.mkdir(parents=True, exist_ok=True)
    record = {
        "command": "python pam-bench/peers/libraries.py",
        "processor": platform.processor() or platform.machine(),
        "not_installed": missing,
        "rows": rows,
    }
    (out / "libraries.json").write_text(json.dumps(record, indent=1) + "\n")
    (out / "table.md").write_text(table(rows))
    figures(rows, out)


if __name__ == "__main__":
    main()
