"""What a scene answers without a run, from Python."""
import json
import math
import os
import unittest

import numpy as np
import quoin
from support import SCENES, Folder, block_scene


class Modes(Folder):
    def test_they_are_those_of_the_program(self):
        arch = os.path.join(SCENES, "arch.toml")
        self.assertEqual(self.command("modes", arch, "--out", "out").returncode, 0)
        with open(self.path("out/modes.json"), encoding="utf-8") as file:
            expected = json.load(file)
        found = quoin.modes(arch)
        np.testing.assert_allclose(found.frequencies, expected["frequencies_Hz"], rtol=1e-9)
        self.assertEqual(found.effective_mass.shape, (10, 3))
        self.assertEqual(len(found.shapes[0]), expected["blocks"])
        self.assertAlmostEqual(max(np.linalg.norm(u, axis=1).max() for u in found.shapes[2]), 1.0, places=12)

    def test_a_cube_on_a_joint(self):
        # sqrt(kn A/m) with 1e9 Pa/m, 1 m2 and 1000 kg.
        scene = block_scene()
        scene.block[1].box.lower = [0, 1, 0]
        found = quoin.modes(scene)
        bounce = found.frequencies[found.effective_mass[:, 1].argmax()]
        self.assertAlmostEqual(bounce, math.sqrt(1e6) / (2 * math.pi), delta=1e-6 * bounce)

    def test_wrong_input(self):
        with self.assertRaisesRegex(quoin.BadInput, "no such stage"):
            quoin.modes(block_scene(), stage="nowhere")
        with self.assertRaises(ValueError):
            quoin.modes(block_scene(), ratios=(1, 2, 3))


if __name__ == "__main__":
    unittest.main(verbosity=2)
