"""Scenes: built, written, read, and refused."""
import glob
import os
import unittest

import numpy as np
import quoin
from support import SCENES, SMALL_WALL, Folder, block_scene


class Scenes(Folder):
    def test_a_scene_written_and_read_back_is_the_same(self):
        paths = glob.glob(SCENES + "/*.toml")
        self.assertGreater(len(paths), 15)
        for path in paths:
            with self.subTest(path):
                scene = quoin.Scene.load(path)
                scene.write(self.path("copy.toml"))
                self.assertEqual(quoin.Scene.load(self.path("copy.toml")), scene)

    def test_and_makes_the_same_model(self):
        for path in (SMALL_WALL, SCENES + "/arch.toml"):
            scene = quoin.Scene.load(path)
            scene.write(self.path("copy.toml"))
            sims = [quoin.Simulation(s) for s in (path, scene, self.path("copy.toml"))]
            for sim in sims:
                sim.step(200)
            self.assertEqual(len({sim.hash for sim in sims}), 1)

    def test_numbers_keep_every_bit(self):
        scene = block_scene()
        scene.joints.dry.normal_stiffness = np.nextafter(1e9, 2e9)
        scene.block[1].position = np.array([0.1 + 0.2, np.float32(0.1), 0])
        scene.write(self.path("scene.toml"))
        again = quoin.Scene.load(self.path("scene.toml"))
        self.assertEqual(again.joints.dry.normal_stiffness, np.nextafter(1e9, 2e9))
        self.assertEqual(again.block[1].position, [0.1 + 0.2, float(np.float32(0.1)), 0])

    def test_a_scene_built_in_code_is_that_of_the_file(self):
        scene = quoin.Scene(title="small wall")
        scene.materials.brick = quoin.BlockMaterial(young_modulus=16.7e9, poisson_ratio=0.15, density=1900.0)
        scene.joints.mortar = quoin.Joint(
            law="fracture_energy", normal_stiffness=82e9, shear_stiffness=36e9, tensile_strength=0.2e6, cohesion=0.3e6,
            friction_angle=35.0, compressive_strength=5e6, fracture_energy_tension=15.0, fracture_energy_shear=125.0,
            fracture_energy_compression=8000.0)
        scene.wall = quoin.Wall(courses=2, units_per_course=2, unit=[0.22, 0.0625, 0.1], zones=[2, 1, 1],
                                mid_unit_joints=False, unit_material="brick", bed_joint="mortar", head_joint="mortar",
                                beam_joint="mortar")
        scene.stage = [quoin.Stage(name="precompression", kind="pressure", pressure=0.3e6),
                       quoin.Stage(name="shear", kind="shear", velocity=0.05, displacement=0.0005)]
        scene.output = dict(frames=3, frames_of="last")
        self.assertEqual(scene, quoin.Scene.load(SMALL_WALL))

    def test_files_that_a_scene_names_are_found_from_where_it_is_written(self):
        os.mkdir(self.path("a"))
        os.mkdir(self.path("b"))
        with open(self.path("a/cube.off"), "w", encoding="utf-8") as file:
            file.write("OFF\n8 6 0\n" + "".join(f"{x} {y} {z}\n" for z in (0, 1) for y in (0, 1) for x in (0, 1)) +
                       "4 0 4 6 2\n4 1 3 7 5\n4 0 1 5 4\n4 2 6 7 3\n4 0 2 3 1\n4 4 5 7 6\n")
        scene = block_scene()
        scene.block = [quoin.Block(name="cube", material="stone", mesh="cube.off")]
        with open(self.path("a/scene.toml"), "w", encoding="utf-8") as file:
            file.write(scene.text())
        loaded = quoin.Scene.load(self.path("a/scene.toml"))
        loaded.write(self.path("b/scene.toml"))
        again = quoin.Scene.load(self.path("b/scene.toml"))
        self.assertEqual(again.block[0].mesh, "../a/cube.off")
        self.assertEqual(again, loaded)
        self.assertEqual(quoin.Simulation(again).blocks, 1)

    def test_records_of_supports_are_found_too(self):
        os.mkdir(self.path("c"))
        with open(self.path("rec.csv"), "w", encoding="utf-8") as file:
            file.write("time_s,x_m_s2\n0,0\n1,1\n")
        scene = block_scene()
        scene.stage[0].ground_motion = dict(support=[dict(blocks=["base"], direction=[1, 0, 0], file="rec.csv")])
        with open(self.path("scene.toml"), "w", encoding="utf-8") as file:
            file.write(scene.text())
        loaded = quoin.Scene.load(self.path("scene.toml"))
        loaded.write(self.path("c/scene.toml"))
        again = quoin.Scene.load(self.path("c/scene.toml"))
        self.assertEqual(again.stage[0].ground_motion.support[0].file, "../rec.csv")
        self.assertEqual(again, loaded)

    def test_faults_are_those_of_the_command_line(self):
        with open(SMALL_WALL, encoding="utf-8") as file:
            right = file.read()
        with open(self.path("wrong.toml"), "w", encoding="utf-8") as file:
            file.write(right.replace("courses = 2", "courses = -2").replace("density", "densty"))
        told = self.command("run", self.path("wrong.toml")).stderr
        with self.assertRaises(quoin.BadInput) as raised:
            quoin.Scene.load(self.path("wrong.toml"))
        self.assertEqual(told, f"quoin: {raised.exception}\n")
        self.assertEqual(raised.exception.exit_code, 3)
        self.assertIn("wrong.toml:22: wall.courses = -2", str(raised.exception))
        with open(self.path("wrong.toml"), "w", encoding="utf-8") as file:
            file.write(right.replace("cohesion = 0.3e6", "cohesion = -0.3e6"))
        told = self.command("run", self.path("wrong.toml")).stderr
        with self.assertRaises(quoin.LawRefused) as raised:
            quoin.Simulation(self.path("wrong.toml"))
        self.assertEqual(told, f"quoin: {raised.exception}\n")

    def test_what_a_scene_cannot_hold_is_refused_by_its_key(self):
        for change, words in (
                (lambda s: setattr(s.joints.dry, "friction_angle", float("nan")), "joints.dry.friction_angle"),
                (lambda s: setattr(s.block[1], "position", [0, float("inf"), 0]), "block.2.position"),
                (lambda s: setattr(s.block[1], "colour", "red"), "block.2.colour"),
                (lambda s: setattr(s.block[1], "material", 3), "block.2.material"),
                (lambda s: s.stage.clear(), "stage")):
            scene = block_scene()
            change(scene)
            with self.assertRaisesRegex(quoin.BadInput, words):
                quoin.Simulation(scene)
        scene = block_scene()
        scene.block[0].box.size = object()
        with self.assertRaisesRegex(TypeError, "block.1.box.size: a value of type object"):
            quoin.Simulation(scene)
        with self.assertRaisesRegex(ValueError, "stage.1.duration: an integer beyond 64 bits"):
            quoin.Simulation(block_scene(stage=[quoin.Stage(duration=2**70)]))
        scene = block_scene()
        scene.title = "bell \x07"
        with self.assertRaisesRegex(ValueError, "title: the text holds a control character"):
            scene.write(self.path("bell.toml"))
        self.assertFalse(glob.glob(self.path("bell*")))
        with self.assertRaisesRegex(quoin.BadInput, "nowhere.toml"):
            quoin.Scene.load(self.path("nowhere.toml"))
        with self.assertRaisesRegex(TypeError, "scene: "):
            quoin.run(7)

    def test_a_run_is_that_of_the_scene_that_was_loaded(self):
        with open(SMALL_WALL, encoding="utf-8") as file:
            right = file.read()
        path = self.path("wall.toml")

        def write(text):
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
        write(right)
        scene = quoin.Scene.load(path)
        peak = quoin.run(scene, frames=False, threads=1).peak
        for edited in (right.replace("0.3e6", "0.1e6"), "no scene"):
            write(edited)
            for loaded in (scene, scene.copy()):
                loaded.check()
                self.assertEqual(quoin.run(loaded, frames=False, threads=1).peak, peak)
        os.remove(path)
        self.assertEqual(quoin.run(scene, frames=False, threads=1).peak, peak)
        with open(SMALL_WALL, encoding="utf-8") as file:
            write(file.read().replace("0.3e6", "0.1e6"))
        self.assertLess(quoin.run(quoin.Scene.load(path), frames=False, threads=1).peak[0], 0.8 * peak[0])

    def test_a_mesh_that_has_changed_since_is_refused(self):
        def cube(height):
            with open(self.path("cube.off"), "w", encoding="utf-8") as file:
                file.write("OFF\n8 6 0\n" + "".join(f"{x} {y * height} {z}\n" for z in (0, 1) for y in (0, 1)
                                                    for x in (0, 1)) +
                           "4 0 4 6 2\n4 1 3 7 5\n4 0 1 5 4\n4 2 6 7 3\n4 0 2 3 1\n4 4 5 7 6\n")
        scene = block_scene(block=[quoin.Block(name="cube", material="stone", mesh="cube.off")])
        with open(self.path("scene.toml"), "w", encoding="utf-8") as file:
            file.write(scene.text())
        cube(1)
        loaded = quoin.Scene.load(self.path("scene.toml"))
        sim = quoin.Simulation(loaded)
        sim.checkpoint(self.path("then.bin"))
        cube(2)
        for changed in (False, True):
            if changed:
                loaded.joints.dry.friction_angle = 30.0
            for use in (quoin.Simulation, quoin.run, quoin.Scene.check):
                with self.assertRaisesRegex(quoin.BadInput, "cube.off: has changed since the scene"):
                    use(loaded)
        with self.assertRaisesRegex(quoin.BadInput, "is of another file cube.off"):
            quoin.Simulation.resume(self.path("scene.toml"), self.path("then.bin"))
        # A mesh that has not been loaded is read when it is needed.
        scene.block[0].mesh = self.path("cube.off")
        for height in (1, 2):
            cube(height)
            self.assertEqual(quoin.Simulation(scene).mesh()["points"][:, 1].max(), height)

    def test_copies_are_apart(self):
        scene = quoin.Scene.load(SMALL_WALL)
        other = scene.copy()
        other.joints.mortar.cohesion = 0.1e6
        self.assertEqual(scene.joints.mortar.cohesion, 0.3e6)
        self.assertNotEqual(scene, other)


if __name__ == "__main__":
    unittest.main(verbosity=2)
