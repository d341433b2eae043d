"""What the tests share: the published model and run, and small recordings made by a known joint."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import pam_ode as pam

ROOT = Path(__file__).resolve().parents[2]
PUBLISHED = ROOT / "data" / "published"

#: Half of the loss of the paper, as the published code averages: 50 mean[dx² + dv²] + ½ mean[dP_f² + dP_e²].
WEIGHTS = np.array([50.0, 50.0, 0.5, 0.5])


@pytest.fixture(scope="session")
def published() -> pam.Model:
    return pam.load(PUBLISHED / "hybrid_model_puresine_16.eqx")


@pytest.fixture(scope="session")
def run() -> pam.Recording:
    """The published measured run."""
    return pam.read(PUBLISHED / "data.mat")[0]


def network(activation: str, width: int = 8, seed: int = 0, **parameters: float) -> pam.Model:
    """A small network whose force is that of a spring, roughly, in units that its inputs have."""
    random = np.random.default_rng(seed)
    # g, g, mm, mm/s come to the order of one; the force is of 1e5 mN.
    scale = np.array([5.0, 5.0, 0.5, 0.1])
    first = random.normal(size=(width, 4)) * scale
    second = random.normal(size=(width, width)) / np.sqrt(width)
    last = random.normal(size=(1, width)) * 1e3
    # A straight path through the network: x to the force.
    first[0], second[0], last[0, 0] = [0, 0, 0.3, 0.05], 0, 4e5
    second[0, 0] = 1.0
    biases = [0.1 * random.normal(size=n) for n in (width, width, 1)]
    layers = list(zip([first, second, last], biases))
    return pam.Model.from_layers(layers, activation, activation_parameters=parameters or None)


def driven(seconds: float = 1.0, rate_hz: float = 500.0, amplitude_n: float = 40.0) -> pam.Recording:
    """A command: a sine of force at rest under 412 kPa."""
    time = np.arange(int(seconds * rate_hz)) / rate_hz
    return pam.Recording.at_rest(time, 412.0, amplitude_n * np.sin(2 * np.pi * 2.0 * time), name="driven")


@pytest.fixture(scope="session")
def measured() -> pam.Recording:
    """A recording of a joint that none of the models under test is."""
    return pam.load("spring-damper").predict(driven()).to_recording("made")
