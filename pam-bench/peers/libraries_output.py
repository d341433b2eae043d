"""Tables and figures of `libraries.py`."""

from __future__ import annotations

import csv
import json
import platform
from pathlib import Path
from typing import Any

import numpy as np
from problems import JOINTS, OWN, SMALL

#: Order of the tables.
LIBRARIES = ("pam", "diffrax", "torchdiffeq", "torchode", "diffsol")
TOLERANCES = (1e-4, 1e-6, 1e-8)
#: Accuracy at which the tables compare.
EQUAL = 1e-4


def at_equal(rows: list[dict[str, Any]], name: str, library: str, method: str):
    """The row at an error of EQUAL, its time interpolated between tolerances, or `None` and why there is none.

    Between the last tolerance that misses the error and the first that holds it, time is a power of the error. Memory and
    compile wait are those of the tolerance that holds it.
    """
    rows = [r for r in rows if (r["problem"], r["library"], r["method"]) == (name, library, method)]
    known = sorted((r for r in rows if r.get("error") is not None), key=lambda r: -r["tolerance"])
    good = [r for r in known if r["error"] <= EQUAL]
    if not good:
        if known:
            return None, f"error {min(r['error'] for r in known):.1e}"
        return None, rows[0].get("failure", "") if rows else "–"
    best = min(good, key=lambda r: r["seconds"])
    worse = [r for r in known if r["error"] > EQUAL and r["tolerance"] > best["tolerance"]]
    if not worse:
        return best, ""
    last = min(worse, key=lambda r: r["tolerance"])
    share = np.log(last["error"] / EQUAL) / np.log(last["error"] / best["error"])
    seconds = last["seconds"] ** (1 - share) * best["seconds"] ** share
    return best | {"seconds": min(float(seconds), best["seconds"])}, ""


def ordered(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows by problem and library; of those that differ in how the field is differentiated only the fastest."""
    problems = [*SMALL, OWN, *JOINTS]
    fastest: dict[tuple, dict[str, Any]] = {}
    for r in rows:
        key = (r["problem"], r["library"], r["method"], r["tolerance"])
        if key not in fastest or r.get("seconds", np.inf) < fastest[key].get("seconds", np.inf):
            fastest[key] = r
    return sorted(fastest.values(), key=lambda r: (problems.index(r["problem"]), LIBRARIES.index(r["library"])))


def series(rows: list[dict[str, Any]]) -> list[tuple[str, str]]:
    """Libraries and methods, libraries in their order."""
    found = dict.fromkeys((r["library"], r["method"]) for r in rows)
    return sorted(found, key=lambda s: LIBRARIES.index(s[0]))


def full_table(rows: list[dict[str, Any]]) -> str:
    """For each problem and method the time at an error of EQUAL, and the errors at the tolerances."""
    text = (
        f"Value and gradient: the time at a relative error of {EQUAL:g} (interpolated between tolerances), and the errors at the\n"
        "tolerances. `libraries.py` writes this file; figures are beside it.\n\n"
        "| problem | library | method | time (ms) | compile wait (s) | memory (MB) | error at 1e-4 | at 1e-6 | at 1e-8 |\n"
        "|---|---|---|---|---|---|---|---|---|\n"
    )
    for name in dict.fromkeys(r["problem"] for r in rows):
        for library, method in series([r for r in rows if r["problem"] == name]):
            own = [r for r in rows if (r["problem"], r["library"], r["method"]) == (name, library, method)]
            errors = {r["tolerance"]: r["error"] for r in own if r.get("error") is not None}
            r, why = at_equal(rows, name, library, method)
            if r:
                memory = "–" if r["memory_mb"] is None else f"{r['memory_mb']:.2f}"
                cells = [f"{1e3 * r['seconds']:.3g}", f"{r['compile_s']:.2f}", memory]
            else:
                cells = ["not reached" if errors else f"fails: {why[:70]}", "", ""]
            if method in ("exact", "surrogate"):
                cells += [f"{min(errors.values()):.1e}", "", ""]
            else:
                cells += [f"{errors[t]:.1e}" if t in errors else "–" for t in TOLERANCES]
            text += f"| {name} | {library} | {method} | {' | '.join(cells)} |\n"
    return text


def write_matrix(rows: list[dict[str, Any]], path: Path) -> None:
    """Times (ms) at an error of EQUAL by method and problem, the largest compile wait (s), and the memory (MB) of the SiLU
    joint, as CSV."""

    def cell(found) -> str:
        r, why = found
        if r:
            return f"{1e3 * r['seconds']:.2g}" if r["seconds"] < 0.1 else f"{1e3 * r['seconds']:.0f}"
        return why if why.startswith(("error", "–")) else "fails"

    names = [*SMALL, OWN, *JOINTS]
    with path.open("w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["method", *names, "compile wait", "memory, joint-silu"])
        for library, method in series(rows):
            found = {name: at_equal(rows, name, library, method) for name in names}
            cells = [cell(f) for f in found.values()]
            waits = [r["compile_s"] for r, _ in found.values() if r]
            last = found["joint-silu"][0]
            memory = f"{last['memory_mb']:.0f}" if last else "–"
            out.writerow([f"{library} {method}", *cells, f"{max(waits):.1f}" if waits else "–", memory])


def figures(rows: list[dict[str, Any]], out: Path) -> None:
    """Work and precision of each problem."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    plt.rcParams |= {"svg.hashsalt": "libraries", "svg.fonttype": "none"}
    colours = {
        "pam": "tab:red",
        "diffrax": "tab:blue",
        "torchdiffeq": "tab:green",
        "torchode": "tab:purple",
        "diffsol": "tab:orange",
    }
    for name in dict.fromkeys(r["problem"] for r in rows):
        figure, axes = plt.subplots(figsize=(7.5, 4.5), layout="constrained")
        for k, (library, method) in enumerate(series([r for r in rows if r["problem"] == name])):
            found = [r for r in rows if (r["problem"], r["library"], r["method"]) == (name, library, method)]
            points = [(r["seconds"], max(r["error"], 1e-16)) for r in found if r.get("error") is not None]
            if points:
                marker = "osD^v<>pPX*"[k % 11]
                axes.loglog(*zip(*points), marker=marker, color=colours[library], label=f"{library} {method}", lw=1)
        axes.axhline(EQUAL, color="grey", lw=0.5)
        axes.set(xlabel="time of value and gradient (s)", ylabel="relative error of the gradient", title=name)
        figure.legend(loc="outside right upper", fontsize=7)
        figure.savefig(out / f"libraries-{name}.svg", metadata={"Date": None})
        plt.close(figure)


def write(out: Path, rows: list[dict[str, Any]], libraries: list[str], wanted: list[str]) -> None:
    """`libraries.json`, `libraries.md`, `libraries.csv` and a figure for each problem."""
    from importlib.metadata import version

    names = {"pam": "pam-ode", "diffsol": "pydiffsol"}
    libraries = [x for x in LIBRARIES if x in libraries or any(r["library"] == x for r in rows)]
    out.mkdir(parents=True, exist_ok=True)
    rows = ordered(rows)
    record = {
        "command": "python pam-bench/peers/libraries.py",
        "processor": platform.processor() or platform.machine(),
        "versions": {x: version(names.get(x, x)) for x in libraries},
        "not_installed": sorted(set(wanted) - set(libraries)),
        "rows": rows,
    }
    (out / "libraries.json").write_text(json.dumps(record, indent=1) + "\n")
    (out / "libraries.md").write_text(full_table(rows))
    write_matrix(rows, out / "libraries.csv")
    figures(rows, out)
