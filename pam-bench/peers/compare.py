"""Compares `pam gradient` with the JAX programs on the same data in one run.

The programs take turns, round after round, so that a change of the machine's speed meets all of
them. Prints a table and, with `--json`, writes all that was measured.
"""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from jax_gradient import positive
from recordings import CONDITIONS
from rig import InputError, read_arrays

HERE = Path(__file__).resolve().parent
COUNTS = (1, 3, 29)
GRADIENTS = [f"grad_{kind}_{layer}" for kind in ("weight", "bias") for layer in range(3)]
GRADIENTS.append("grad_raw")
YARDSTICK = ("rk4-adjoint", "f64")
"""Program and precision whose gradient the others are held against."""

ADJOINT = ("--method", "adjoint", "--solver")

PAM = {
    "pam": lambda step_ms: [*ADJOINT, "rk4", "--input", "linear", "--step-ms", step_ms],
    "pam-bs3": lambda _: [*ADJOINT, "bs3", "--input", "ramp", "--rtol", 1e-3, "--atol", 1e-3],
    "pam-exact": lambda _: ["--method", "exact", "--input", "zoh"],
}
"""The steps and input of the JAX programs, the fewest evaluations at no more error than theirs, and the
closed form."""

FAST = (
    ("pam", "f32"),
    ("pam-bs3", "f32"),
    ("rk4-adjoint", "f32"),
    ("rk4-scan", "f32"),
    ("rk4-plain", "f32"),
    ("rk4-adjoint", "mixed"),
    ("rk4-scan", "mixed"),
    ("pam-exact", "f64"),
    ("pam", "f64"),
    ("pam-bs3", "f64"),
    ("rk4-adjoint", "f64"),
    ("rk4-scan", "f64"),
)
"""Measured in every round."""

SLOW = (("diffrax-adaptive", "f32"), ("diffrax-adaptive", "f64"), ("published", "f32"))
"""Measured in the first round only; the published path on one recording, and scaled."""


@dataclass
class Case:
    """A program at a precision on some recordings, and what was measured of it."""

    program: str
    precision: str
    count: int
    seconds: list = field(default_factory=list)
    x_error_mm: float = None
    loss: float = None
    gradient: dict = None

    @property
    def key(self):
        """Program and precision."""
        return self.program, self.precision

    @property
    def measured_count(self):
        """Recordings that the program is really given."""
        return 1 if self.program == "published" else self.count

    @property
    def median_s(self):
        """Median over the rounds of seconds a value and gradient, scaled to all recordings."""
        return statistics.median(self.seconds) * self.count / self.measured_count

    @property
    def name(self):
        """The program for the table."""
        scaled = self.measured_count < self.count
        return self.program + (f" (one recording x {self.count})" if scaled else "")


def call(command):
    """Runs a command and returns its standard output."""
    try:
        done = subprocess.run(
            [str(c) for c in command], capture_output=True, text=True, check=False
        )
    except OSError as error:
        raise InputError(f"{command[0]} cannot be run: {error}") from None
    if done.returncode:
        words = " ".join(str(c) for c in command[:3])
        raise InputError(f"`{words} …` failed ({done.returncode}):\n{done.stderr.strip()}")
    return done.stdout


class Bench:
    """Paths and settings shared by all cases."""

    def __init__(self, options, folder):
        """Checks the data; `folder` is for files in passing."""
        self.options = options
        self.folder = folder
        self.model = options.data / "perturbed.eqx"
        self.files = [options.data / f"nn_{code}.npz" for code in CONDITIONS[: max(options.counts)]]
        missing = [
            p for p in (self.model, options.data / "reference.npz", *self.files) if not p.is_file()
        ]
        if missing:
            raise InputError(
                f"{missing[0]} is missing; make the data with "
                f"`python recordings.py --count {max(options.counts)} --out {options.data}`"
            )
        if not options.without_pam and not options.pam.is_file():
            raise InputError(
                f"{options.pam} is missing; build it with `cargo build --release`, name it with "
                "--pam, or leave it out with --without-pam"
            )

    def reference(self, count):
        """A reference file with the rows of the first `count` recordings only."""
        path = self.folder / f"reference_{count}.npz"
        if not path.is_file():
            arrays = read_arrays(self.options.data / "reference.npz", ("names", "x"))
            if [f"nn_{code}" for code in CONDITIONS[:count]] != list(arrays["names"][:count]):
                raise InputError("reference.npz holds other recordings; make the data anew")
            np.savez(path, names=arrays["names"][:count], x=arrays["x"][:count])
        return path

    def measure(self, case):
        """Runs a case once more and adds what it measured."""
        out = self.folder / "gradient.npz"
        out.unlink(missing_ok=True)
        count = case.measured_count
        shared = ["--model", self.model, "--loss", self.options.loss, "--out", out]
        shared += ["--threads", self.options.threads, "--reference", self.reference(count)]
        shared += ["--precision", case.precision, "--data", *self.files[:count]]
        measure = self.measure_pam if case.program in PAM else self.measure_jax
        seconds, case.x_error_mm = measure(case, shared, out)
        case.seconds.append(seconds)
        arrays = read_arrays(out, ("loss", *GRADIENTS))
        case.loss = float(arrays.pop("loss"))
        case.gradient = arrays
        print(f"{case.count:3} {case.program} {case.precision}: {seconds:.3f} s", file=sys.stderr)

    def measure_pam(self, case, shared, out):
        """Seconds and error of the Rust program."""
        options = self.options
        settings = ["--repeat", options.repeat]
        settings += PAM[case.program](options.step_ms)
        call([options.pam, "gradient", *shared, *settings])
        told = read_arrays(out, ("value_and_grad_s", "x_error_mm"))
        return float(np.median(told["value_and_grad_s"])), float(np.max(told["x_error_mm"]))

    def measure_jax(self, case, shared, _):
        """Seconds and error of a JAX program."""
        repeat = 1 if case.key in SLOW else self.options.repeat
        settings = ["--variant", case.program, "--repeat", repeat]
        if case.program.startswith("rk4"):
            settings += ["--step-ms", self.options.step_ms]
        told = json.loads(call([sys.executable, HERE / "jax_gradient.py", *shared, *settings]))
        return told["value_and_grad_s"], told["x_error_mm"]


def difference(one, other):
    """Norm of the difference of two gradients over the norm of the second, all arrays together."""
    flat = lambda gradient: np.concatenate([gradient[name].ravel() for name in GRADIENTS])
    return float(np.linalg.norm(flat(one) - flat(other)) / np.linalg.norm(flat(other)))


def differences(one, other):
    """The same, array by array."""
    return {
        name: float(np.linalg.norm(one[name] - other[name]) / np.linalg.norm(other[name]))
        for name in GRADIENTS
    }


def run(bench):
    """All cases, measured in turns."""
    options = bench.options
    cases = []
    for count in options.counts:
        wanted = [key for key in FAST if key[0] not in PAM or not options.without_pam]
        fast = [Case(*key, count) for key in wanted]
        slow = [] if options.without_slow else [Case(*key, count) for key in SLOW]
        for turn in range(options.rounds):
            for case in fast + (slow if turn == 0 else []):
                bench.measure(case)
        cases += fast + slow
    return cases


def summarise(cases):
    """One dictionary a case, with ratios to pam and differences to the yardstick."""
    by_key = {(*case.key, case.count): case for case in cases}
    rows = []
    for case in cases:
        own = [
            by_key.get((program, "f64" if case.precision == "f64" else "f32", case.count))
            for program in PAM
        ]
        yardstick = by_key[(*YARDSTICK, case.count)]
        comparable = case.measured_count == case.count
        rows.append(
            {
                "recordings": case.count,
                "program": case.name,
                "precision": case.precision,
                "value_and_grad_s": case.median_s,
                "rounds_s": case.seconds,
                "ratio_to_pam": case.median_s / own[0].median_s if own[0] else None,
                "ratio_to_pam_bs3": case.median_s / own[1].median_s if own[1] else None,
                "x_error_mm": case.x_error_mm,
                "loss": case.loss,
                "gradient_difference": (
                    difference(case.gradient, yardstick.gradient) if comparable else None
                ),
                "gradient_differences": (
                    differences(case.gradient, yardstick.gradient) if comparable else None
                ),
            }
        )
    return rows


def print_table(rows):
    """The summary as a Markdown table."""
    print(
        "| recordings | program | precision | seconds | ratio to pam | to pam-bs3 | x error, mm "
        "| gradient difference |"
    )
    print("|---|---|---|---|---|---|---|---|")
    show = lambda value, form: "–" if value is None else format(value, form)
    for row in rows:
        cells = [
            str(row["recordings"]),
            row["program"],
            row["precision"],
            show(row["value_and_grad_s"], ".3f"),
            show(row["ratio_to_pam"], ".2f"),
            show(row["ratio_to_pam_bs3"], ".2f"),
            show(row["x_error_mm"], ".4f"),
            show(row["gradient_difference"], ".1e"),
        ]
        print("| " + " | ".join(cells) + " |")


def parse(arguments):
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True, help="folder made by recordings.py")
    parser.add_argument("--pam", type=Path, default=HERE.parents[1] / "target" / "release" / "pam")
    parser.add_argument("--without-pam", action="store_true", help="time the JAX programs alone")
    parser.add_argument(
        "--without-slow", action="store_true", help="leave the diffrax programs out"
    )
    parser.add_argument("--counts", type=int, nargs="+", choices=COUNTS, default=COUNTS)
    parser.add_argument("--loss", choices=("paper", "published"), default="published")
    parser.add_argument(
        "--step-ms", type=float, default=5.0, help="step of pam and the rk4 programs"
    )
    parser.add_argument("--threads", type=positive, default=2)
    parser.add_argument("--repeat", type=positive, default=5, help="runs in a round")
    parser.add_argument("--rounds", type=positive, default=3)
    parser.add_argument("--json", type=Path, metavar="FILE", help="where all numbers go")
    return parser.parse_args(arguments)


def main(arguments=None):
    """Measures, prints, writes."""
    options = parse(arguments)
    try:
        with tempfile.TemporaryDirectory() as folder:
            rows = summarise(run(Bench(options, Path(folder))))
        print_table(rows)
        if options.json:
            settings = {
                "step_ms": options.step_ms,
                "threads": options.threads,
                "loss": options.loss,
            }
            options.json.write_text(json.dumps({**settings, "rows": rows}, indent=2) + "\n")
    except (InputError, OSError) as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()
