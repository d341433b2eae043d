"""Makes the benchmark's data: recordings of the published joint, a perturbed model, a reference.

Each recording is the exact response of the published model to the published excitation with the
force held between samples. The reference is the same solve at the perturbed model, at which
gradients are compared: at the published weights on their own data the gradient is noise.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

from rig import LEAK, InputError, published_weights, read_model, softplus, volumes, write_model

CONDITIONS = (
    "1010 4545 8080 4050 5040 3060 6030 2070 7020 1080 8010 4530 4560 3045 6045 4520 4570 2045 "
    "7045 4510 4580 1045 8045 2020 3030 4040 5050 6060 7070"
).split()
"""The 29 training conditions in the order of training: gauge psi of flexor, then extensor."""

SUBSTEPS = 4
"""Steps of the reference solve in a sample."""

FORCE_MN_PER_A = 25.5 * 36 / 6.875e-3
"""Tendon force per ampere: torque constant times gear ratio over pulley radius."""

KPA_PER_PSI, ATMOSPHERE_KPA = 6.89476, 101.325


def excitation_a(t):
    """The published current (A) at times `t` (s): 0.5, 1 and 2 Hz, each at 1 A and at 1.5 A."""
    conditions = [t < 40.0, t < 60.0]
    start = np.select(conditions, [0.0, 40.0], 60.0)
    frequency = np.select(conditions, [0.5, 1.0], 2.0)
    middle = np.select(conditions, [20.0, 50.0], 65.0)
    amplitude = np.where(t < middle, 1.0, 1.5)
    return amplitude * np.sin(2.0 * np.pi * frequency * (t - start))


def sealed_masses_g(model, codes):
    """Air in flexor and extensor by the gas law at x = 0, [recordings, 2]."""
    gauge_psi = np.array([[float(code[:2]), float(code[2:])] for code in codes])
    pressure_kpa = gauge_psi * KPA_PER_PSI + ATMOSPHERE_KPA
    return pressure_kpa * np.stack(volumes(model, 0.0)) / softplus(model.raw[1])


class Lanes:
    """The joint in all conditions at once; masses are folded into the first bias."""

    def __init__(self, model, masses_g):
        """Lanes with the air of `masses_g`, [lanes, 2]."""
        first = model.weights[0]
        self.bias = model.biases[0][:, None] + first[:, :2] @ masses_g.T
        self.slope = first[:, 2:]
        self.layers = [(w, b[:, None]) for w, b in zip(model.weights[1:], model.biases[1:])]
        self.inverse_mass = 1.0 / softplus(model.raw[0])

    def force(self, state):
        """Restoring force (mN) for `state` [2, lanes]."""
        hidden = self.slope @ state + self.bias
        for weight, bias in self.layers:
            hidden = weight @ np.maximum(hidden, LEAK * hidden) + bias
        return hidden[0]

    def rate(self, state, external):
        """Time derivative of (x, v) under the external force (mN)."""
        return np.stack([state[1], (external - self.force(state)) * self.inverse_mass])

    def at_rest(self, reach_mm=12.0, halvings=60):
        """Displacements at which the restoring force vanishes, by bisection, as states at rest."""
        low = np.full(self.bias.shape[1], -reach_mm)
        high = -low
        still = np.zeros_like(low)
        for _ in range(halvings):
            middle = 0.5 * (low + high)
            above = self.force(np.stack([middle, still])) > 0.0
            low, high = np.where(above, low, middle), np.where(above, middle, high)
        return np.stack([0.5 * (low + high), still])

    def solve(self, start, force_mn, sample_s=1e-3):
        """States [samples, 2, lanes] from `start`, the left value of `force_mn` [samples] held.

        Classical Runge-Kutta with `SUBSTEPS` steps a sample; steps end at samples.
        """
        step = sample_s / SUBSTEPS
        states = np.empty((len(force_mn), *start.shape))
        state = states[0] = start
        for k, external in enumerate(force_mn[:-1]):
            for _ in range(SUBSTEPS):
                k1 = self.rate(state, external)
                k2 = self.rate(state + 0.5 * step * k1, external)
                k3 = self.rate(state + 0.5 * step * k2, external)
                k4 = self.rate(state + step * k3, external)
                state = state + step / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
            states[k + 1] = state
        return states


def write_recording(path, model, time_s, states, force_mn, masses_g):
    """Writes one recording; `states` is [samples, 2]."""
    x, v = states.T
    flexor, extensor = (
        softplus(model.raw[1]) * mass / volume for mass, volume in zip(masses_g, volumes(model, x))
    )
    np.savez(
        path,
        time_s=time_s,
        displacement_mm=x,
        velocity_mm_s=v,
        pressure_flexor_kpa=flexor,
        pressure_extensor_kpa=extensor,
        force_n=1e-3 * force_mn,
        mass_flexor_g=masses_g[0],
        mass_extensor_g=masses_g[1],
    )


def make(folder, count, seconds):
    """Writes `count` recordings of `seconds`, `perturbed.eqx` and `reference.npz` to `folder`."""
    model = read_model(published_weights())
    perturbed = model.perturbed().rounded()
    codes = CONDITIONS[:count]
    names = [f"nn_{code}" for code in codes]
    masses = sealed_masses_g(model, codes)
    time_s = np.arange(round(1000 * seconds) + 1) * 1e-3
    force_mn = FORCE_MN_PER_A * excitation_a(time_s)

    lanes = Lanes(model, masses)
    states = lanes.solve(lanes.at_rest(), force_mn)
    folder.mkdir(parents=True, exist_ok=True)
    for lane, name in enumerate(names):
        path = folder / f"{name}.npz"
        write_recording(path, model, time_s, states[:, :, lane], force_mn, masses[lane])
    write_model(folder / "perturbed.eqx", perturbed)
    reference = Lanes(perturbed, masses).solve(states[0], force_mn)
    np.savez(folder / "reference.npz", names=np.array(names), x=reference[:, 0, :].T)


def main(arguments=None):
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, choices=(1, 3, 29), default=29)
    parser.add_argument("--seconds", type=float, default=70.0)
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER")
    options = parser.parse_args(arguments)
    if not 0.01 <= options.seconds <= 70.0:
        parser.error("--seconds must lie between 0.01 and 70")
    try:
        make(options.out, options.count, options.seconds)
    except (InputError, OSError) as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()
