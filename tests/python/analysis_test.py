"""Analyses of scenes without a run, from Python: limit, modes, rest."""
import json
import math
import os
import signal
import threading
import unittest

import numpy as np
import quoin
from support import SCENES, SMALL_WALL, Folder, block_scene


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
        # The fixed blocks carry the weight vertically and the multiplier times the weight horizontally.
        self.assertEqual(found.force.shape, (expected["contact_points"], 3))

    def test_forces_are_multiplied(self):
        scene = block_scene()
        scene.block[1].box.lower = [0, 1, 0]
        scene.stage[0].gravity = [0, -10, 0]
        scene.stage[0].force = [{"block": "cube", "point": [0, 2.0, 0.5], "force": [100, 0, 0]}]
        found = quoin.limit(scene, multiply="forces", associated=True)
        self.assertAlmostEqual(found.multiplier, 10000.0 * 0.5 / 100.0, delta=0.005)  # turns over: F h = W b/2
        self.assertEqual([joint["motion"] for joint in found.summary["moving_joints"]], ["hinges"])
        with self.assertRaisesRegex(quoin.BadInput, "A displacement has no"):
            quoin.limit(scene, multiply="settlement")

    def test_an_interrupt_ends_it(self):
        timer = threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            quoin.limit(os.path.join(SCENES, "floor_box.toml"), direction=(0, 0, 1))  # takes minutes
        timer.join()

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

    def test_of_a_state_they_are_those_of_the_program(self):
        arch = os.path.join(SCENES, "arch.toml")
        self.assertEqual(self.command("modes", arch, "--count", "3", "--state", "weight", "--out", "of").returncode, 0)
        with open(self.path("of/modes.json"), encoding="utf-8") as file:
            expected = json.load(file)
        found = quoin.modes(arch, count=3, state="weight")
        self.assertEqual(found.summary["state"], "weight")
        np.testing.assert_allclose(found.frequencies, expected["frequencies_Hz"], rtol=1e-6)
        # Weight reduces stiffness.
        self.assertLess(found.frequencies[0], (1 - 1e-6) * quoin.modes(arch, count=3).frequencies[0])
        # The state at the end of a run.
        scene = quoin.Scene.load(arch)
        scene.stage = [quoin.Stage(name="weight", kind="rest", gravity=[0, -9.81, 0])]
        scene.output = dict(end_state=True, frames=0, plots=False)
        quoin.run(scene, out=self.path("end"))
        end = quoin.modes(scene, count=3, state=self.path("end"))
        np.testing.assert_allclose(end.frequencies, found.frequencies, rtol=1e-4)
        with self.assertRaises(quoin.Error):
            quoin.modes(scene, state=self.path("nowhere"))

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


class Rest(Folder):
    """A stage of kind rest has the final state of a run to equilibrium."""

    @staticmethod
    def settled(scene, rest):
        stage = scene.stage[0]
        scene.stage = [stage]
        stage.equilibrium_ratio = 1e-7
        for key in ("duration", "ramp_time") if rest else ("duration",):
            if key in stage:
                del stage[key]
        if rest:
            stage.kind = "rest"
        scene.output = dict(frames=1, plots=False)
        return quoin.run(scene)

    def assert_same_forces(self, scene, again, fewest_times):
        steps, rest = self.settled(scene, False), self.settled(again, True)
        # Tolerance 1e-4 of the largest traction; unbalanced forces of both are 1e-7 of the mean force of a point.
        expected, found = (np.asarray(run.frames[-1].joints["traction"]) for run in (steps, rest))
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-4 * np.abs(expected).max())
        self.assertLessEqual(fewest_times * rest.history["step"][-1], steps.history["step"][-1])

    def test_an_arch_of_rigid_blocks(self):
        arch = os.path.join(SCENES, "arch.toml")
        self.assert_same_forces(quoin.Scene.load(arch), quoin.Scene.load(arch), 5)

    def test_a_wall_on_the_lattice(self):
        self.assert_same_forces(quoin.Scene.load(SMALL_WALL), quoin.Scene.load(SMALL_WALL), 5)

    def test_a_wall_in_large_motion(self):
        scene = quoin.Scene.load(SMALL_WALL)
        scene.solver = dict(large_motion="always")
        stage = scene.stage[0]
        stage.kind, scene.stage = "rest", [stage]
        found = quoin.run(scene).history["vertical_force_N"][-1]
        self.assertAlmostEqual(found, 0.3e6 * 0.44 * 0.1, delta=1e-4 * found)

    def test_wrong_input(self):
        scene = block_scene()
        scene.stage[0] = quoin.Stage(kind="rest", gravity=[0, -10, 0], duration=1.0)
        with self.assertRaisesRegex(quoin.BadInput, "duration"):
            scene.check()
        scene.stage[0] = quoin.Stage(kind="rest", gravity=[0, -10, 0])
        with self.assertRaisesRegex(quoin.Error, "cube"):
            quoin.run(scene)


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
