"""Tests of the hand-written JAX gradients; run with `python -m unittest`."""

import tempfile
import unittest
from functools import partial
from pathlib import Path

import numpy as np

import recordings
from jax_gradient import prepare_jax
from rig import read_model, read_recordings

prepare_jax("f64", threads=2, devices=1)

import jax  # noqa: E402  (number formats come first)
import jax.numpy as jnp  # noqa: E402

import jax_rk4  # noqa: E402
from jax_joint import PRECISIONS, Geometry, parameters  # noqa: E402

SECONDS = 0.4
STEP_MS = 5.0

TOLERANCE = 1e-5
"""Relative tolerance of central differences, which meet a few kinks of the network."""


class Gradient(unittest.TestCase):
    """Value and gradient at the perturbed weights on three short recordings."""

    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            recordings.make(folder, count=3, seconds=SECONDS)
            cls.data = read_recordings(sorted(folder.glob("nn_*.npz")))
            model = read_model(folder / "perturbed.eqx")
        cls.geometry = Geometry(model.radius_mm, model.length_mm)
        cls.parameters = parameters(model, PRECISIONS["f64"])

    def loss(self, method):
        """The loss as a function of the parameters."""
        grid = jax_rk4.make_grid(self.data.samples, STEP_MS, self.data.count, method)
        batch = jax_rk4.make_batch(self.data, self.data.count, grid, PRECISIONS["f64"])
        loss = partial(jax_rk4.loss, grid, method, self.geometry, 1.0)
        return jax.jit(lambda parameters: loss(parameters, batch))

    def test_all_methods_agree(self):
        first = jax.value_and_grad(self.loss("scan"))(self.parameters)
        for method in ("adjoint", "plain"):
            value = jax.value_and_grad(self.loss(method))(self.parameters)
            for one, other in zip(*map(jax.tree.leaves, (first, value))):
                scale = np.linalg.norm(one)
                self.assertLess(np.linalg.norm(one - other), 1e-10 * scale)

    def check_slope(self, along, expected, step, name):
        """Holds the slope of `along` at zero, by central differences, against the expected one."""
        difference = float((along(step) - along(-step)) / (2.0 * step))
        self.assertLess(abs(difference - expected), TOLERANCE * abs(expected), name)

    def test_adjoint_agrees_with_central_differences(self):
        loss = self.loss("adjoint")
        leaves, structure = jax.tree.flatten(self.parameters)
        slopes = jax.tree.leaves(jax.grad(loss)(self.parameters))
        random = np.random.default_rng(1)

        def along(index, direction, step):
            moved = [*leaves]
            moved[index] = leaves[index] + step * direction
            return loss(jax.tree.unflatten(structure, moved))

        for index, leaf in enumerate(leaves):
            direction = jnp.maximum(jnp.abs(leaf), 1e-3) * random.standard_normal(leaf.shape)
            expected = float(jnp.vdot(slopes[index], direction))
            self.check_slope(partial(along, index, direction), expected, 1e-6, f"array {index}")

    def test_raw_parameters_agree_one_by_one(self):
        loss = self.loss("adjoint")
        slopes = jax.grad(loss)(self.parameters).raw

        def along(index, step):
            raw = self.parameters.raw.at[index].multiply(1.0 + step)
            return loss(self.parameters._replace(raw=raw))

        for index, value in enumerate(self.parameters.raw):
            expected = float(slopes[index] * value)
            self.check_slope(partial(along, index), expected, 1e-5, f"parameter {index}")


if __name__ == "__main__":
    unittest.main()
