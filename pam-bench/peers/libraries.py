"""Gradient methods across libraries: error, time, memory and compile wait on one set of problems.

    cargo build --release -p pam-bench && pip install ./pam-python diffrax equinox jax matplotlib
    pip install torch torchdiffeq torchode pydiffsol         # as far as wanted
    python pam-bench/peers/libraries.py --field pam-bench/peers/own.toml

Problems are those of `pam-bench gradients` (linear, Van der Pol, the quartic trap, slow-fast), a field of your own (`--field`, see
`problems.py`), and the hybrid joint, 2 s under a sine of force read linearly, with LeakyReLU and with SiLU.

Each library and method runs in a process of its own, on one core and one thread. Errors are relative, of the gradient by all
parameters and by the start, the larger of the two; truths are closed forms where there are some, else solves at 1e-12. Times are
medians of value and gradient after the first call; the compile wait is the first call less that, with what was compiled before
it. Memory is the growth of the process over what it took after its imports; for pam on the small problems it is what was
allocated.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Callable

import numpy as np
from libraries_output import TOLERANCES, full_table, write
from problems import JOINTS, OWN, SMALL, diffsl, joint, joint_field, problem

ROOT = Path(__file__).resolve().parents[2]
#: Methods of each library; those of `pam` on small problems are those of `pam-bench gradients`.
METHODS = {
    "pam": ("exact", "surrogate", "adjoint", "interpolating"),
    "diffrax": ("checkpoint", "direct", "backsolve", "forward"),
    "torchdiffeq": ("direct", "adjoint"),
    "torchode": ("direct",),
    "diffsol": ("forward", "adjoint"),
}
PAM_SMALL = ("adjoint", "forward", "backsolve", "interpolating", "quadrature", "tape")
#: Longest time of a library and method on a problem, s.
PATIENCE_S = 300


def why_not(library: str, method: str, name: str) -> str | None:
    """Why a method has no row for a problem; `None` if it has."""
    of_joint = name in JOINTS
    if library == "pam":
        if not of_joint:
            return "the rows of pam-bench"
        if method == "exact" and name != "joint-leaky_relu":
            return "for piecewise linear networks"
        if method == "surrogate" and name != "joint-silu":
            return "for smooth networks"
    if of_joint and method == "forward":
        return "one solve per parameter, of which there are ten thousand"
    if of_joint and library == "diffsol":
        return "DiffSL has no force given by samples"
    return None


def largest_error(found: list[np.ndarray], truth: list[np.ndarray]) -> float:
    return max(float(np.linalg.norm(a - b) / max(np.linalg.norm(b), 1e-300)) for a, b in zip(found, truth))


def timed(call: Callable[[], Any]) -> tuple[Any, float, float]:
    """Result, median time and what the first call took more."""
    start = time.perf_counter()
    result = call()
    first = time.perf_counter() - start
    times = []
    while len(times) < 3 or (sum(times) < 0.3 and len(times) < 100):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
        if times[-1] > 20:
            break
    median = float(np.median(times))
    return result, median, max(0.0, first - median)


def memory_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def flat(tree: Any) -> np.ndarray:
    if isinstance(tree, dict):
        return np.concatenate([np.ravel(np.asarray(tree[k])) for k in sorted(tree)])
    return np.ravel(np.asarray(tree))


def weights_of(model) -> dict[str, np.ndarray]:
    return {k: v for k, v in model.parameters().items() if k.startswith(("weight", "bias"))}


def jax_value(name: str, field_file: str | None, adjoint: str, tolerance: float, max_steps: int = 1 << 15, order8: bool = False):
    """Value and gradient as a function of (p, y0) through diffrax, and where to take it."""
    import diffrax
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    adjoints = {
        "checkpoint": diffrax.RecursiveCheckpointAdjoint,
        "direct": diffrax.DirectAdjoint,
        "backsolve": diffrax.BacksolveAdjoint,
        "forward": diffrax.ForwardMode,
    }
    controller = diffrax.PIDController(rtol=tolerance, atol=tolerance)
    if name in JOINTS:
        from pam_ode.jax import ACTIVATIONS

        model, measured = joint(name.split("-")[1])
        field = joint_field(model, measured, jnp, ACTIVATIONS[model.activation], jnp.asarray)
        p = {k: jnp.asarray(v) for k, v in weights_of(model).items()}
        times, y0 = jnp.asarray(measured.time_s), jnp.asarray(measured.states[0, :2])
        goal = jnp.asarray(measured.states[:, :2])

        def of_states(states):
            return jnp.sum(jnp.mean((states - goal) ** 2, axis=0))

        solver, t1 = diffrax.Tsit5(), float(times[-1])
    else:
        this = problem(name, field_file)
        field = this.field(jnp, jnp.stack)
        times, t1 = jnp.asarray(this.times), float(this.times[-1])
        y0, p = jnp.asarray(this.y0), jnp.asarray(this.p)

        def of_states(states):
            if this.target is None:
                return states[-1, 0]
            return 0.5 * jnp.mean(jnp.sum((states - this.goal()) ** 2, axis=1))

        solver = diffrax.Bosh3() if this.low_order else diffrax.Tsit5()
    if order8:
        solver = diffrax.Dopri8()

    def value(p, y0):
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(field), solver, 0.0, t1, None, y0, p, saveat=diffrax.SaveAt(ts=times),
            stepsize_controller=controller, adjoint=adjoints[adjoint](), max_steps=max_steps,
        )  # fmt: skip
        return of_states(solution.ys)

    if adjoint == "forward":
        return jax.jit(lambda p, y0: (value(p, y0), jax.jacfwd(value, (0, 1))(p, y0))), p, y0
    return jax.jit(jax.value_and_grad(value, (0, 1))), p, y0


def diffrax_gradient(name: str, method: str, tolerance: float, field_file: str | None):
    function, p, y0 = jax_value(name, field_file, method, tolerance)

    def call():
        value, gradient = function(p, y0)
        return float(value), [flat(g) for g in gradient]

    return call


def pam_gradient(name: str, method: str, tolerance: float, _: str | None = None):
    import pam_ode as pam

    model, measured = joint(name.split("-")[1])
    options: dict[str, Any] = {"input": "linear"}
    if method not in ("exact", "surrogate"):
        options |= {"solver": "tsit5", "rtol": tolerance, "atol": tolerance}
    loss = {"kind": "squared", "weights": [1.0, 1.0, 0.0, 0.0]}
    this = pam.Problem(model, measured, loss, method=method, **options)

    def call():
        found = this.value_and_gradient()
        weights = {k: g for k, g in found.gradient.items() if k.startswith(("weight", "bias"))}
        return found.value, [flat(weights), found.gradient["initial_states"][0, :2]]

    return call


def torch_problem(name: str, field_file: str | None):
    """Field `f(t, y)`, leaves (parameters, start), times from zero on, and the loss of the states at the others."""
    import torch

    torch.set_default_dtype(torch.float64)
    torch.set_num_threads(1)
    if name in JOINTS:
        import pam_ode.torch

        model, measured = joint(name.split("-")[1])
        activation = pam_ode.torch.ACTIVATIONS[model.activation]()
        of_weights = joint_field(model, measured, torch, activation, lambda a: torch.tensor(np.asarray(a)))
        weights = {k: torch.tensor(v, requires_grad=True) for k, v in sorted(weights_of(model).items())}
        times = torch.tensor(measured.time_s)
        y0 = torch.tensor(measured.states[0, :2], requires_grad=True)
        goal = torch.tensor(measured.states[:, :2])

        def of_states(states):
            # The first sample, at which nothing is solved, counts too.
            return ((torch.cat([y0[None], states]) - goal) ** 2).mean(dim=0).sum()

        return (lambda t, y: of_weights(t, y, weights)), [*weights.values()], y0, times, of_states, False
    this = problem(name, field_file)
    field = this.field(torch, torch.stack)
    p, y0 = torch.tensor(this.p, requires_grad=True), torch.tensor(this.y0, requires_grad=True)
    times = torch.tensor(np.concatenate([[0.0], this.times]))
    goal = None if this.target is None else torch.tensor(this.goal())

    def of_states(states):
        return states[-1, 0] if goal is None else 0.5 * ((states - goal) ** 2).sum(dim=1).mean()

    return (lambda t, y: field(t, y, p)), [p], y0, times, of_states, this.low_order


def torchdiffeq_gradient(name: str, method: str, tolerance: float, field_file: str | None):
    import torch
    import torchdiffeq

    f, p, y0, times, of_states, low_order = torch_problem(name, field_file)
    field = torch.nn.Module()
    field.forward = f
    solve = torchdiffeq.odeint_adjoint if method == "adjoint" else torchdiffeq.odeint
    extra = {"adjoint_params": tuple(p)} if method == "adjoint" else {}
    solver = "bosh3" if low_order else "dopri5"

    def call():
        states = solve(field, y0, times, rtol=tolerance, atol=tolerance, method=solver, **extra)[1:]
        value = of_states(states)
        *of_p, of_y0 = torch.autograd.grad(value, (*p, y0))
        return value.item(), [np.concatenate([g.numpy().ravel() for g in of_p]), of_y0.numpy()]

    return call


def torchode_gradient(name: str, method: str, tolerance: float, field_file: str | None):
    import torch
    import torchode

    f, p, y0, times, of_states, _ = torch_problem(name, field_file)
    term = torchode.ODETerm(lambda t, y: f(t[0], y[0])[None])
    control = torchode.IntegralController(atol=tolerance, rtol=tolerance, term=term)
    solver = torchode.AutoDiffAdjoint(torchode.Tsit5(term=term), control, backprop_through_step_size_control=False)

    def call():
        start = torchode.InitialValueProblem(y0=y0[None], t_eval=times[None])
        value = of_states(solver.solve(start).ys[0, 1:])
        *of_p, of_y0 = torch.autograd.grad(value, (*p, y0))
        return value.item(), [np.concatenate([g.numpy().ravel() for g in of_p]), of_y0.numpy()]

    return call


def diffsol_gradient(name: str, method: str, tolerance: float, field_file: str | None):
    """With the implicit BDF where the problem is stiff, else Tsit5, for the trap the third-order ESDIRK3(4)."""
    import pydiffsol

    this = problem(name, field_file)
    numbers = {**this.parameters, **{f"{state}0": v for state, v in this.start.items()}}
    code = "in_i { " + ", ".join(f"{k} = {v!r}" for k, v in numbers.items()) + " }\n"
    code += "u_i { " + ", ".join(f"{state} = {state}0" for state in this.start) + " }\n"
    code += "F_i { " + ", ".join(diffsl(rate) for rate in this.rates.values()) + " }\n"
    solver = {"stiff": "bdf", "quartic": "esdirk34"}.get(name, "tsit45")
    ode = pydiffsol.Ode(code, ode_solver=getattr(pydiffsol, solver), matrix_type=pydiffsol.nalgebra_dense)
    for key in ("rtol", "atol", "sens_rtol", "sens_atol", "param_rtol", "param_atol", "out_rtol", "out_atol"):
        setattr(ode, key, tolerance)
    at, times, count = np.array([*numbers.values()]), this.times, len(this.p)

    def of_states(states):
        """Value and cotangents of states, [states, times]."""
        if this.target is None:
            return states[0, -1], np.eye(len(this.y0), 1) * (np.arange(len(times)) == len(times) - 1)
        gap = states - this.goal().T
        return 0.5 * (gap**2).sum(axis=0).mean(), gap / len(times)

    def call():
        if method == "forward":
            solution = ode.solve_fwd_sens(at, times)
            value, cotangents = of_states(solution.ys)
            gradient = np.array([(cotangents * s).sum() for s in solution.sens])
        else:
            solution, checkpoint = ode.solve_adjoint_fwd(at, times)
            value, cotangents = of_states(solution.ys)
            gradient = ode.solve_adjoint_bkwd(solution, checkpoint, cotangents).ravel()
        return float(value), [gradient[:count], gradient[count:]]

    return call


GRADIENTS = {
    "pam": pam_gradient,
    "diffrax": diffrax_gradient,
    "torchdiffeq": torchdiffeq_gradient,
    "torchode": torchode_gradient,
    "diffsol": diffsol_gradient,
}


def truth(name: str, field_file: str | None) -> list[np.ndarray]:
    if name == "joint-leaky_relu":
        # From kink to kink in closed form.
        return pam_gradient(name, "exact", 1e-8)()[1]
    call, p, y0 = jax_value(name, field_file, "checkpoint", 1e-12, 1 << 20, order8=name not in JOINTS)
    return [flat(g) for g in call(p, y0)[1]]


def reason(error: Exception) -> str:
    """An error in a line; in errors of JAX the cause stands last."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    causes = [line for line in lines if "Error: " in line]
    return (causes[-1] if causes else f"{type(error).__name__}: {lines[0] if lines else ''}")[:120]


def run_cell(library: str, method: str, name: str, field_file: str | None, truth_file: str) -> None:
    """One library and method on one problem at all tolerances; rows as JSON lines."""
    with np.load(truth_file) as stored:
        exact = [stored["p"], stored["y0"]]
    for tolerance in TOLERANCES:
        row: dict[str, Any] = {"library": library, "method": method, "problem": name, "tolerance": tolerance}
        try:
            start = time.perf_counter()
            call = GRADIENTS[library](name, method, tolerance, field_file)
            # diffsol compiles where a problem is made; what the others do there is short.
            made_s = time.perf_counter() - start if library == "diffsol" else 0.0
            before = memory_mb()
            (_, gradient), seconds, wait = timed(call)
            row |= {
                "seconds": seconds,
                "compile_s": wait + made_s,
                "memory_mb": memory_mb() - before,
                "error": largest_error(gradient, exact),
            }
            if not np.isfinite(row["error"]):
                row |= {"error": None, "failure": "the gradient is not finite"}
        except Exception as error:  # noqa: BLE001 - what a library cannot do is a result
            row["failure"] = reason(error)
        print(json.dumps(row), flush=True)
        if method in ("exact", "surrogate"):
            # Their accuracy is their own.
            return


def installed(library: str) -> bool:
    import importlib.util

    return importlib.util.find_spec({"pam": "pam_ode", "diffsol": "pydiffsol"}.get(library, library)) is not None


def of_pam_bench(names: list[str], field_file: str | None) -> list[dict[str, Any]]:
    """The rows of the program `pam-bench` on the problems without a joint."""
    names = [name for name in names if name not in JOINTS]
    if not names:
        return []
    program = ROOT / "target" / "release" / "pam-bench"
    with tempfile.TemporaryDirectory() as folder:
        arguments = [program, "gradients", "--problems", ",".join(names), "--methods", ",".join(PAM_SMALL)]
        arguments += ["--threads", "1", "--json", "--out", folder]
        arguments += ["--field", field_file] if field_file else []
        found = json.loads(subprocess.run(arguments, check=True, capture_output=True, text=True).stdout)
    horizons = {name: float(problem(name, field_file).times[-1]) for name in names}
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


def measure(
    arguments: argparse.Namespace, names: list[str], libraries: list[str], known: list[dict[str, Any]]
) -> list[dict[str, Any]]:
    """All rows, the known ones among them, and the files after each problem, in case the rest is interrupted."""
    rows = known + (of_pam_bench(names, arguments.field) if "pam" in libraries else [])
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false"}
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            gp, gy = truth(name, arguments.field)
            np.savez(Path(folder) / "truth.npz", p=gp, y0=gy)
            for library in libraries:
                for method in METHODS[library]:
                    if why_not(library, method, name):
                        continue
                    print(f"{name}: {library} {method}", file=sys.stderr, flush=True)
                    command = [sys.executable, __file__, "--cell", library, method, name, f"{folder}/truth.npz"]
                    command += ["--field", arguments.field] if arguments.field else []
                    row = {"library": library, "method": method, "problem": name, "tolerance": None}
                    limit = {"capture_output": True, "text": True, "timeout": PATIENCE_S, "env": environment}
                    try:
                        done = subprocess.run(command, **limit)
                        out, failure = done.stdout, f"ended with {done.returncode}" if done.returncode else None
                    except subprocess.TimeoutExpired as late:
                        out = late.stdout or ""
                        out = out.decode() if isinstance(out, bytes) else out
                        failure = f"more than {PATIENCE_S} s"
                    rows += [json.loads(line) for line in out.splitlines() if line.startswith("{")]
                    rows += [row | {"failure": failure}] if failure else []
            write(arguments.out, rows, libraries, arguments.libraries.split(","))
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "gradients")
    parser.add_argument("--problems", default=",".join((*SMALL, *JOINTS)))
    parser.add_argument("--libraries", default=",".join(METHODS))
    parser.add_argument("--field", help="a field of your own, FILE.toml")
    parser.add_argument("--update", action="store_true", help="keep what --out has of other problems and libraries")
    parser.add_argument("--cell", nargs=4, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    # One core for all, the programs that this one starts included.
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    if arguments.cell:
        library, method, name, truth_file = arguments.cell
        run_cell(library, method, name, arguments.field, truth_file)
        return
    names = [name for name in arguments.problems.split(",") if name]
    if arguments.field and OWN not in names:
        names.insert(len([name for name in names if name in SMALL]), OWN)
    libraries = [x for x in arguments.libraries.split(",") if installed(x)]
    known = []
    if arguments.update:
        known = json.loads((arguments.out / "libraries.json").read_text())["rows"]
        known = [r for r in known if r["library"] not in libraries or r["problem"] not in names]
    print(full_table(measure(arguments, names, libraries, known)))


if __name__ == "__main__":
    main()
