"""Problems of `libraries.py`: `python -m unittest` in this folder; what needs a library is skipped without it."""

import importlib.util
import math
import unittest
from pathlib import Path

import numpy as np
from problems import SMALL, diffsl, own, small

HERE = Path(__file__).resolve().parent


class Problems(unittest.TestCase):
    def test_expressions_mean_the_same_in_numpy_and_diffsl(self):
        problem = own(str(HERE / "own.toml"))
        rates = problem.field(np, np.stack)(0.5, problem.y0, problem.p)
        damping, drag, push, stiffness = problem.p
        self.assertEqual(list(problem.start), ["angle", "speed"])
        self.assertAlmostEqual(rates[0], 0.0)
        self.assertAlmostEqual(rates[1], -stiffness * math.sin(1.0) + push * math.cos(1.0))
        self.assertEqual(diffsl("-a * (x - 1)^2 / b"), "(((-a) * ((x - 1.0) * (x - 1.0))) / b)")
        with self.assertRaisesRegex(NotImplementedError, "floor"):
            diffsl("floor(x)")

    def test_the_small_problems_have_their_rates(self):
        stiff = small("stiff")
        found = stiff.field(np, np.stack)(0.0, stiff.y0, stiff.p)
        np.testing.assert_allclose(found, [-1.5, 200 * (1.0 - 1.5)])
        trap = small("quartic")
        self.assertAlmostEqual(trap.field(np, np.stack)(0.0, trap.y0, trap.p)[0], 0.36**4)
        for name in SMALL:
            self.assertTrue(np.all(np.diff(small(name).times) > 0))

    @unittest.skipUnless(importlib.util.find_spec("pydiffsol"), "needs pydiffsol")
    def test_diffsol_has_the_closed_form_of_the_quartic_trap(self):
        from libraries import diffsol_gradient

        # The final value is ∫ (t − θ)⁴ = [(T − θ)⁵ + θ⁵]/5, its derivative −(T − θ)⁴ + θ⁴.
        value, (of_p, of_y0) = diffsol_gradient("quartic", "forward", 1e-8, None)()
        self.assertAlmostEqual(value, (0.44**5 + 0.36**5) / 5, places=7)
        self.assertAlmostEqual(of_p[0], 0.36**4 - 0.44**4, places=6)
        self.assertAlmostEqual(of_y0[0], 1.0)


if __name__ == "__main__":
    unittest.main()
