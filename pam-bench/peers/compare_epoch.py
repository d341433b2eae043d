"""Times whole epochs of training, value and gradient and update, beside JAX in one run.

An epoch is one step of Adam over all recordings with the gradient cut to norm one. All programs start
from the same weights and train on the same recordings; they take turns, round after round.
"""

import argparse
import csv
import json
import statistics
import sys
import tempfile
from pathlib import Path

from compare import HERE, call
from jax_gradient import positive
from recordings import CONDITIONS
from rig import InputError

RATE = 1e-5

SOLVERS = {
    "pam": """method = "rk4"
step_ms = 5.0
input = "linear" """,
    "pam-bs3": """method = "bs3"
tolerance = 1e-3
input = "ramp" """,
}
"""The steps and input of the JAX programs, and the default of a curriculum."""

JAX = ("rk4-adjoint", "rk4-scan")

CURRICULUM = """name = "epochs"
rate = {rate}
clip = 1.0
[model]
start = {{ file = "{model}" }}
[data]
train = "all"
held_out = "none"
[coordinates]
scaled = false
physical = "softplus"
frozen = {{ gas_coefficient = false }}
[solver]
{solver}
precision = "f32"
[[stage]]
kind = "solve"
name = "epochs"
epochs = {epochs}
"""


def pam_epochs(options, program, folder):
    """Losses and seconds of the epochs of `pam train`, without the first two."""
    curriculum = folder / f"{program}.toml"
    model = (options.data / "perturbed.eqx").resolve()
    curriculum.write_text(
        CURRICULUM.format(
            rate=RATE, model=model, solver=SOLVERS[program], epochs=options.repeat + 2
        )
    )
    run = tempfile.mkdtemp(dir=folder)
    command = [options.pam, "train", curriculum, "--out", run, "--threads", options.threads]
    call([*command, "--quiet", "--data", *files(options)])
    with open(Path(run) / "metrics.csv", encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    return [float(r["loss"]) for r in rows], [float(r["seconds"]) for r in rows][2:]


def jax_epochs(options, program):
    """Losses of the epochs of a JAX program, and the median of their seconds."""
    command = [sys.executable, HERE / "jax_gradient.py", "--variant", program]
    command += ["--model", options.data / "perturbed.eqx", "--epochs-at", RATE]
    command += ["--repeat", options.repeat, "--threads", options.threads]
    told = json.loads(call([*command, "--data", *files(options)]))
    return told["losses"], [told["epoch_s"]]


def files(options):
    """The recordings."""
    return [options.data / f"nn_{code}.npz" for code in CONDITIONS[: options.count]]


def main(arguments=None):
    """Measures and prints a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True, help="folder made by recordings.py")
    parser.add_argument("--pam", type=Path, default=HERE.parents[1] / "target" / "release" / "pam")
    parser.add_argument("--count", type=positive, default=29, help="recordings")
    parser.add_argument("--threads", type=positive, default=2)
    parser.add_argument("--repeat", type=positive, default=5, help="epochs in a round")
    parser.add_argument("--rounds", type=positive, default=3)
    options = parser.parse_args(arguments)
    seconds = {program: [] for program in (*SOLVERS, *JAX)}
    losses = {}
    try:
        with tempfile.TemporaryDirectory() as folder:
            for _ in range(options.rounds):
                for program, measured in seconds.items():
                    if program in SOLVERS:
                        losses[program], timed = pam_epochs(options, program, Path(folder))
                    else:
                        losses[program], timed = jax_epochs(options, program)
                    measured.append(statistics.median(timed))
                    print(f"{program}: {measured[-1]:.3f} s", file=sys.stderr)
    except (InputError, OSError) as error:
        sys.exit(f"error: {error}")
    medians = {program: statistics.median(measured) for program, measured in seconds.items()}
    print("| program | seconds an epoch | over `pam` | over `pam-bs3` | loss, first and last epoch |")
    print("|---|---|---|---|---|")
    for program, median in medians.items():
        first, last = losses[program][0], losses[program][-1]
        print(
            f"| {program} | {median:.3f} | {median / medians['pam']:.2f} "
            f"| {median / medians['pam-bs3']:.2f} | {first:.5f}, {last:.5f} |"
        )


if __name__ == "__main__":
    main()
