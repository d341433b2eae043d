"""The problems of `libraries.py`: those of `pam-bench gradients`, a field of your own, and the hybrid joint.

A field of your own is a TOML file; expressions are written as in `pam` (see docs/own-effects.md), states and parameters are
taken in alphabetical order, and the loss is half the mean square of the states:

    end_s = 10.0
    observations = 50
    start = { predator = 0.5, prey = 1.0 }
    parameters = { birth = 1.1, catch = 0.4, death = 0.4, growth = 0.1 }
    [rates]
    predator = "growth * prey * predator - death * predator"
    prey = "birth * prey - catch * prey * predator"
"""

from __future__ import annotations

import ast
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable

import numpy as np

SMALL = ("linear", "van-der-pol", "quartic", "stiff")
OWN = "own"
JOINTS = ("joint-leaky_relu", "joint-silu")

#: Damping that keeps the joint from ringing, kg/s.
DAMPING_KG_S = 200.0


def evenly(count: int, end: float) -> np.ndarray:
    """`count` times up to `end`."""
    return end * np.arange(1, count + 1) / count


@dataclass
class Problem:
    """A field, its start and parameters, when it is observed, and what the observations are compared with.

    `rates` are expressions of the states, `t` and the parameters, by state. The loss is half the mean square of what the states
    differ from `target(times)`, or the final value of the first state where there is no target.
    """

    start: dict[str, float]
    parameters: dict[str, float]
    rates: dict[str, str]
    times: np.ndarray
    target: Callable[[np.ndarray], list[Any]] | None
    #: The trap shows with steps of low order only.
    low_order: bool = False
    y0: np.ndarray = field(init=False)
    p: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.y0 = np.array(list(self.start.values()), float)
        self.p = np.array(list(self.parameters.values()), float)

    def field(self, library: Any, stack: Callable) -> Callable:
        """`f(t, y, p)` with the functions of `library`: `jax.numpy` or `torch`."""
        code = [compile(_python(rate), "<rate>", "eval") for rate in self.rates.values()]
        known = functions(library)

        def f(t, y, p):
            names = known | {"t": t}
            names |= {name: y[k] for k, name in enumerate(self.start)}
            names |= {name: p[k] for k, name in enumerate(self.parameters)}
            return stack([eval(c, {"__builtins__": {}}, names) for c in code])

        return f

    def goal(self) -> np.ndarray:
        """The target at the times, [times, states]."""
        assert self.target is not None
        columns = [np.broadcast_to(c, self.times.shape) for c in self.target(self.times)]
        return np.stack(columns, axis=1)


def small(name: str) -> Problem:
    """The problems of pam-bench/src/gradients/problems at its shorter horizon."""
    if name == "linear":
        return Problem(
            {"x": 1.0, "y": -0.4},
            {"a": -0.3, "b": 1.7, "c": -2.1, "d": -0.2},
            {"x": "a * x + b * y", "y": "c * x + d * y"},
            evenly(10, 4.0),
            lambda t: [0.5, 0.0],
        )
    if name == "van-der-pol":
        return Problem(
            {"x": 2.0, "y": 0.0},
            {"mu": 1.5, "k": 1.0},
            {"x": "y", "y": "mu * (1 - x * x) * y - k * x"},
            evenly(40, 4.0),
            lambda t: [2 * np.cos(t), -2 * np.sin(t)],
        )
    if name == "quartic":
        return Problem({"x": 0.0}, {"theta": 0.45 * 0.8}, {"x": "(t - theta)^4"}, np.array([0.8]), None, low_order=True)
    if name == "stiff":
        return Problem(
            {"x": 1.0, "y": 1.5},
            {"a": 1.0, "k": 200.0},
            {"x": "-a * x * y", "y": "k * (x - y)"},
            evenly(2, 0.4),
            lambda t: [0.2, 0.2],
        )
    raise SystemExit(f"unknown problem {name}")


def own(path: str) -> Problem:
    """The field of a TOML file."""
    told = tomllib.loads(Path(path).read_text())
    start, parameters = (dict(sorted(told.get(key, {}).items())) for key in ("start", "parameters"))
    rates = {name: told["rates"][name] for name in start}
    times = evenly(told["observations"], told["end_s"])
    return Problem(start, parameters, rates, times, lambda t: [0.0] * len(start))


def problem(name: str, field_file: str | None) -> Problem:
    """A problem without a joint, by its name."""
    return own(field_file) if name == OWN and field_file else small(name)


def _python(text: str) -> str:
    return re.sub(r"\bif\s*\(", "where(", text.replace("^", "**"))


def functions(library: Any) -> dict[str, Any]:
    """The functions of expressions in `jax.numpy` or `torch`."""
    one = "abs sign exp expm1 log log1p sqrt sin cos tan sinh cosh tanh floor".split()
    found = {name: getattr(library, name) for name in one}
    for name in ("asin", "acos", "atan", "atan2"):
        found[name] = getattr(library, name, None) or getattr(library, name.replace("a", "arc", 1))

    def of_two(function):
        def reduced(first, *others):
            for other in others:
                first = function(first, other + 0 * first)
            return first

        return reduced

    lower, upper = of_two(library.minimum), of_two(library.maximum)
    found |= {
        "min": lower,
        "max": upper,
        "clamp": lambda a, low, high: lower(upper(a, low), high),
        "where": lambda condition, a, b: library.where(condition != 0, a, b),
        "step": lambda a: library.where(a >= 0, 1.0, 0.0),
        "pi": np.pi,
        "p_atm": 101.325,
    }
    return found


def diffsl(text: str) -> str:
    """An expression in DiffSL, the language of diffsol."""
    known = "abs exp log sqrt sin cos tan sinh cosh tanh asin acos atan".split()

    def of(node: ast.expr) -> str:
        match node:
            case ast.Constant(value=value):
                return repr(float(value))
            case ast.Name(id="pi"):
                return repr(np.pi)
            case ast.Name(id=name):
                return name
            case ast.UnaryOp(op=ast.USub(), operand=a):
                return f"(-{of(a)})"
            case ast.BinOp(op=ast.Pow(), left=a, right=ast.Constant(value=int(n))) if 0 < n < 9:
                # pow(a, n) has no derivative at zero.
                return "(" + " * ".join([of(a)] * n) + ")"
            case ast.BinOp(op=ast.Pow(), left=a, right=b):
                return f"pow({of(a)}, {of(b)})"
            case ast.BinOp(op=op, left=a, right=b):
                sign = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}[type(op)]
                return f"({of(a)} {sign} {of(b)})"
            case ast.Call(func=ast.Name(id="step"), args=[a]):
                return f"heaviside({of(a)})"
            case ast.Call(func=ast.Name(id=name), args=arguments) if name in [*known, "min", "max"]:
                name = name.replace("a", "arc", 1) if name in ("asin", "acos", "atan") else name
                return f"{name}({', '.join(map(of, arguments))})"
        raise NotImplementedError(f"DiffSL has no equal of {ast.unparse(node)}")

    return of(ast.parse(_python(text), mode="eval").body)


def joint(activation: str):
    """Model, measured recording and a network of the joint; its motion is that of the default model pushed off."""
    import pam_ode as pam

    time_s = np.arange(2001) * 1e-3
    force_n = 60 * (np.sin(2 * np.pi * 0.7 * time_s + 0.4) + np.sin(2 * np.pi * 2.3 * time_s))
    base = pam.load()
    model = pam.Model.from_layers(
        base.layers, activation, mass_kg=base.physical.mass_kg, auxiliary_damping_kg_s=DAMPING_KG_S
    )
    masses = model.sealed_masses(412.0)
    command = pam.Recording.at_rest(time_s, 412.0, force_n, masses_g=masses, name="joint")
    measured = pam.load("spring-damper").predict(command, masses_g=masses).to_recording("joint")
    return model, measured


def joint_field(model, measured, library: Any, activation: Callable, arrays: Callable) -> Callable:
    """`f(t, y, p)` of (x, v) with `jax.numpy` or `torch`; `p` are weights and biases by their names, the force is linear
    between its samples."""
    force, masses = arrays(measured.force_mn), arrays(measured.masses_g)
    count, mass = len(model.layers), model.physical.mass_kg
    last = len(measured.force_mn) - 1
    whole = {"torch": lambda a: a.long()}.get(library.__name__, lambda a: a.astype(int))
    join = getattr(library, "concatenate", None) or library.cat

    def f(t, y, p):
        at = library.clip(t * 1e3, 0, last)
        k = library.clip(whole(at), 0, last - 1)
        u = force[k] + (at - k) * (force[k + 1] - force[k])
        z = join([masses, y])
        for layer in range(count):
            z = p[f"weight_{layer}"] @ z + p[f"bias_{layer}"]
            z = activation(z) if layer + 1 < count else z
        return library.stack([y[1], (u - z[0] - DAMPING_KG_S * y[1]) / mass])

    return f
