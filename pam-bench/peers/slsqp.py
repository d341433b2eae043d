"""Compares `pam plan` with SciPy's SLSQP on the same samples in one run.

For each sample SLSQP minimises (K - K_d)^2 over the two air masses subject to the joint's dynamics, with
masses scaled to the unit square, forces in newtons, and exact Jacobians of objective and constraint: once
from the middle of the bounds ("cold"; every twentieth sample), once from the solution before ("warm", which
only trajectories allow). `pam plan` solves the same motion on one thread, in turns with SLSQP. Of repeated
measurements the least counts, for both, so that other work on the machine disturbs little: for SLSQP the median
over the samples of each sample's least time over the rounds, for pam the least time a sample of all runs. The
ratios are printed.
"""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from rig import published_weights

SLOPE = 0.01
BOUNDS_G = (0.0315272, 0.1211015)
STEP_MM = 1.0
OFFSETS = np.array([0.0, 1.0, -1.0, 2.0, -2.0]) * STEP_MM
SIGNS = np.array([0.0, 1.0, -1.0, 1.0, -1.0]) / (6.0 * STEP_MM)


def load(path):
    """Weights of a published network in double precision, and its mass (kg)."""
    with open(path, "rb") as file:
        arrays = [np.load(file).astype(float) for _ in range(7)]
    *weights, raw = arrays
    return weights, float(np.logaddexp(0.0, raw[0]))


def forces(weights, masses, displacement, velocity):
    """Forces (N) at the five points of the stencil, and their slopes along both masses."""
    w1, b1, w2, b2, w3, b3 = weights
    points = np.empty((5, 4))
    points[:, 0], points[:, 1] = masses
    points[:, 2] = displacement + OFFSETS
    points[:, 3] = velocity
    z1 = points @ w1.T + b1
    g1 = np.where(z1 > 0, 1.0, SLOPE)
    z2 = (g1 * z1) @ w2.T + b2
    g2 = np.where(z2 > 0, 1.0, SLOPE)
    value = (g2 * z2) @ w3[0] + b3[0]
    back = (((g2 * w3[0]) @ w2) * g1) @ w1[:, :2]
    return 1e-3 * value, 1e-3 * back


class Sample:
    """Objective and constraint of one sample over masses in the unit square; the last point is kept."""

    def __init__(self, weights, mass, target):
        self.weights, self.mass, self.target = weights, mass, target
        self.last = None

    def at(self, u):
        """Constraint (N), stiffness (N/mm), and their slopes."""
        if self.last is None or not np.array_equal(u, self.last[0]):
            x, v, a, _ = self.target
            width = BOUNDS_G[1] - BOUNDS_G[0]
            force, slope = forces(self.weights, BOUNDS_G[0] + width * u, x, v)
            balance = 1e-3 * self.mass * a + force[0]
            known = balance, SIGNS @ force, width * slope[0], width * (SIGNS @ slope)
            self.last = u.copy(), known
        return self.last[1]

    def solve(self, start):
        """SLSQP from a start."""
        wanted = self.target[3]
        return minimize(
            lambda u: (self.at(u)[1] - wanted) ** 2,
            start,
            jac=lambda u: 2.0 * (self.at(u)[1] - wanted) * self.at(u)[3],
            bounds=[(0.0, 1.0)] * 2,
            constraints={
                "type": "eq",
                "fun": lambda u: self.at(u)[0],
                "jac": lambda u: self.at(u)[2],
            },
            method="SLSQP",
            options={"ftol": 1e-14, "maxiter": 200},
        )


def main():
    """Runs both and prints a table, or JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    here = Path(__file__).resolve().parent
    parser.add_argument("--pam", default=here.parents[1] / "target/release/pam")
    parser.add_argument("--amplitude", type=float, default=1.0, help="mm")
    parser.add_argument("--frequency", type=float, default=0.1, help="Hz")
    parser.add_argument("--stiffness", type=float, default=150.0, help="N/mm")
    parser.add_argument("--rate", type=float, default=1000.0, help="samples per second")
    parser.add_argument("--periods", type=float, default=1.0)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()

    model = published_weights()
    weights, mass = load(model)
    count = int(round(arguments.periods / arguments.frequency * arguments.rate)) + 1
    times = np.arange(count) / arguments.rate
    omega = 2 * np.pi * arguments.frequency
    x = arguments.amplitude * np.sin(omega * times)
    v = arguments.amplitude * omega * np.cos(omega * times)
    a = -(omega**2) * x
    targets = np.stack([x, v, a, np.full(count, arguments.stiffness)], axis=1)

    slsqp_us = {"cold": {}, "warm": {}}
    residuals = {"cold": 0.0, "warm": 0.0}
    errors = {"cold": 0.0, "warm": 0.0}
    pam_us = []

    def peer(kind, k, target, start):
        sample = Sample(weights, mass, target)
        begin = time.perf_counter()
        found = sample.solve(start)
        us = 1e6 * (time.perf_counter() - begin)
        slsqp_us[kind][k] = min(us, slsqp_us[kind].get(k, us))
        balance, stiffness, _, _ = sample.at(found.x)
        residuals[kind] = max(residuals[kind], 1e3 * abs(balance))
        errors[kind] = max(errors[kind], abs(stiffness - target[3]))
        return found.x

    with tempfile.TemporaryDirectory() as folder:
        motion = Path(folder) / "motion.csv"
        header = "time_s,displacement_mm,velocity_mm_s,acceleration_mm_s2,stiffness_n_mm"
        np.savetxt(motion, np.column_stack([times, targets]), "%.17g", ",", header=header, comments="")
        command = [arguments.pam, "plan", "--model", model, "--motion", motion, "--json", "--threads", "1"]
        command += ["--rate", str(arguments.rate), "--out", Path(folder) / "plan"]
        command += ["--mass-bounds", ",".join(map(str, BOUNDS_G))]
        middle = np.array([0.5, 0.5])
        for _ in range(arguments.rounds):
            start = middle
            for k, target in enumerate(targets):
                start = peer("warm", k, target, start)
                if k % 20 == 0:
                    peer("cold", k, target, middle)
            for _ in range(5):
                done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
                if done.returncode not in (0, 3):
                    sys.exit(done.stderr)
                plan = json.loads(done.stdout)
                pam_us.append(plan["microseconds_a_sample"])
    pam = min(pam_us)
    result = {"samples": count, "pam plan": {
        "us": pam,
        "largest_residual_mn": plan["summary"]["largest_residual_mn"],
        "largest_error_n_mm": plan["summary"]["largest_stiffness_error_n_mm"],
        "ratio": 1.0,
    }}
    for kind, us in slsqp_us.items():
        result[f"SLSQP, {kind}"] = {
            "us": statistics.median(us.values()),
            "largest_residual_mn": residuals[kind],
            "largest_error_n_mm": errors[kind],
            "ratio": statistics.median(us.values()) / pam,
        }
    if arguments.json:
        print(json.dumps(result, indent=2))
        return
    print(f"{count} samples, time a sample, one core")
    for name, row in result.items():
        if name == "samples":
            continue
        print(
            f"  {name:12} {row['us']:9.1f} µs   residual {row['largest_residual_mn']:.1e} mN   "
            f"stiffness {row['largest_error_n_mm']:.1e} N/mm   {row['ratio']:6.0f} times pam"
        )


if __name__ == "__main__":
    main()
