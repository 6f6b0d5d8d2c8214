"""What a scene answers without a run, from Python."""
import json
import math
import os
import unittest

import numpy as np
import quoin
from support import SCENES, Folder, block_scene


class Limit(Folder):
    def test_it_is_that_of_the_program(self):
        arch = os.path.join(SCENES, "arch.toml")
        self.assertEqual(self.command("limit", arch, "--facets", "4", "--out", "out").returncode, 0)
        with open(self.path("out/limit.json"), encoding="utf-8") as file:
            expected = json.load(file)
        found = quoin.limit(arch, facets=4)
        self.assertEqual(found.summary, expected)
        self.assertAlmostEqual(found.multiplier, 0.374, delta=5e-4)
        self.assertTrue(found.stands)
        self.assertEqual(found.velocity.shape, (expected["blocks"], 6))
        # All that stands on the fixed blocks is what they carry: 1 of the weight down, the multiplier of it sideways.
        self.assertEqual(found.force.shape, (expected["contact_points"], 3))

    def test_what_does_not_stand_is_an_answer(self):
        scene = block_scene()
        scene.block[1].box.lower = [0.6, 1, 0]
        scene.stage[0].gravity = [0, -10, 0]
        found = quoin.limit(scene)
        self.assertFalse(found.stands)
        self.assertIsNone(found.multiplier)
        self.assertIsNone(found.friction_scale)
        self.assertEqual(found.velocity.shape, (0, 6))

    def test_wrong_input(self):
        with self.assertRaises(ValueError):
            quoin.limit(block_scene(), direction=(1, 0))
        with self.assertRaisesRegex(quoin.BadInput, "gravity"):
            quoin.limit(block_scene())
        scene = block_scene()
        scene.stage[0].gravity = [0, -10, 0]
        with self.assertRaisesRegex(quoin.BadInput, "'cube'"):
            quoin.limit(scene)


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


class PropertiesOf(Folder):
    TESTS = {"unit": "clay", "unit_strength": 40e6, "masonry_strength": 5e6, "cohesion": 0.3e6, "friction": 0.7,
             "block_height": 0.0625}

    def test_the_rule_meets_table_1(self):
        found = quoin.properties_of(**self.TESTS)
        self.assertAlmostEqual(found["bed"]["tensile_strength"], 0.2e6, delta=1)
        self.assertAlmostEqual(found["bed"]["fracture_energy_compression"], 8000, delta=1e-6)
        self.assertTrue(all(line["from"] for line in found["derivation"]))

    def test_a_scene_from_tests_has_the_same_numbers(self):
        with open(os.path.join(SCENES, "solid_wall_030.toml"), encoding="utf-8") as file:
            text = file.read()
        stages = text[text.index("[[stage]]"):]
        joints = "".join(f'[joints.{name}]\nlaw = "fracture_energy"\nproperties = "from_tests"\npart = "{part}"\n'
                         for name, part in (("mortar", "bed"), ("unit", "inside")))
        tests = "[tests]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in self.TESTS.items()
                                      if key != "block_height")
        wall = text[text.index("[wall]"):text.index("[[stage]]")]
        with open(self.path("tested.toml"), "w", encoding="utf-8") as file:
            file.write(tests + '[materials.brick]\nproperties = "from_tests"\n' + joints + wall + stages)
        checked = self.command("check", self.path("tested.toml"))
        self.assertEqual(checked.returncode, 0, checked.stderr)
        self.assertIn("from tests: bed joint: tensile strength 2e+05 Pa", checked.stdout)
        fault = self.command("check", self.path("tested.toml"), "--set", "tests.unit=cheese")
        self.assertEqual(fault.returncode, 3)
        self.assertIn("tests.unit", fault.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
