"""Reactions, forces in joints, lines of thrust and frames of all stages, against statics, from the files of runs."""
import os
import unittest
from xml.etree import ElementTree

import quoin
from support import SCENES, SMALL_WALL, Folder, block_scene
import numpy as np  # after support, which tells where it is missing
from quoin.forces import thrust_lines

WEIGHT = 9810.0  # N, of a cube of block_scene
REST = dict(damping="local", local_damping=0.8)


def column(cubes, push, **output):
    """Returns cubes on each other and on a base; the uppermost has a horizontal force at its centre."""
    scene = block_scene(solver=REST, output=dict(frames=1, **output))
    scene.block[1].box = dict(lower=[0, 1, 0], size=[1, 1, 1])
    for k in range(1, cubes):
        scene.block.append(quoin.Block(name=f"cube{k}", material="stone", box=dict(lower=[0, 1 + k, 0], size=[1, 1, 1])))
    top = scene.block[-1].name
    scene.stage = [quoin.Stage(name="weight", gravity=[0, -9.81, 0], ramp_time=0.05, duration=0.4),
                   quoin.Stage(name="push", ramp_time=0.1, duration=0.5,
                               force=[dict(block=top, point=[0.5, cubes + 0.5, 0.5], force=[push, 0, 0])])]
    return scene


class Reactions(Folder):
    def run_scene(self, scene, name="run"):
        quoin.run(scene, out=self.path(name), threads=1)
        return quoin.open(self.path(name))

    def test_a_pressed_wall_stands_on_its_support(self):
        scene = quoin.Scene.load(SMALL_WALL)
        run = self.run_scene(scene)
        last = run.history[run.history["stage"] == 1][-1]
        load = 0.3e6 * 0.44 * 0.1  # N: pressure times the bed
        # Tolerance for the end of the stage at an unbalanced force of 1e-3 of the mean at a point.
        self.assertAlmostEqual(last["reaction_bottom_beam_y_N"], load, delta=1e-3 * load)
        self.assertEqual(last["reaction_top_beam_y_N"], 0.0)  # free along y
        self.assertAlmostEqual(last["reaction_y_N"], load, delta=1e-3 * load)
        # The load acts at the centre: the error of its line is below a thousandth of the length.
        self.assertLess(abs(last["reaction_bottom_beam_mz_Nm"]), 1e-3 * load * 0.44)
        # Moment about the origin, which is the lower left corner of the wall.
        self.assertAlmostEqual(last["reaction_mz_Nm"], 0.22 * load, delta=2e-3 * load * 0.44)

    def test_a_pushed_wall_is_held_by_both_beams(self):
        run = self.run_scene(quoin.Scene.load(SMALL_WALL))
        h = run.history[run.history["stage"] == 2]
        np.testing.assert_array_equal(h["reaction_top_beam_x_N"], h["horizontal_force_N"])
        np.testing.assert_array_equal(h["reaction_x_N"], h["reaction_top_beam_x_N"] + h["reaction_bottom_beam_x_N"])
        # The sum of the reactions of both beams is the inertia force: a small share of the peak in a quasi-static run.
        peak = h["horizontal_force_N"].max()
        self.assertLess(np.sqrt(np.mean(h["reaction_x_N"] ** 2)), 0.05 * peak)
        self.assertAlmostEqual(h["driven_top_beam_dx_m"][-1], 0.5e-3, delta=1e-5)
        self.assertNotIn("driven_bottom_beam_dx_m", h.dtype.names)

    def test_a_wall_driven_out_of_its_plane_is_shown_out_of_its_plane(self):
        scene = quoin.Scene.load(SMALL_WALL)
        scene.stage[1] = quoin.Stage(name="out", kind="custom", duration=0.005, ramp_time=0.002, control=[
            dict(body="bottom_beam", velocity=[0, 0, 0]), dict(body="top_beam", velocity=[0, 0, 0.02])])
        run = self.run_scene(scene)
        h = run.history[run.history["stage"] == 2]
        np.testing.assert_array_equal(h["displacement_m"], h["driven_top_beam_dz_m"])
        np.testing.assert_array_equal(h["horizontal_force_N"], h["reaction_top_beam_z_N"])
        self.assertGreater(h["displacement_m"][-1], 5e-5)
        self.assertGreater(h["horizontal_force_N"][-1], 0.0)
        self.assertEqual(run.summary["settings"]["stages"][1]["curve"]["along"], "z")

    def test_a_column_pushed_at_its_top(self):
        push = 0.05 * WEIGHT
        run = self.run_scene(column(3, push))
        h = run.history[-1]
        # By statics. Tolerance 1 %, for motion after half a second with damping.
        self.assertAlmostEqual(h["reaction_y_N"], 3 * WEIGHT, delta=0.01 * 3 * WEIGHT)
        self.assertAlmostEqual(h["reaction_base_x_N"], -push, delta=0.01 * WEIGHT)
        # Moments about the centre of the base, (0.5, 0.5, 0.5): the force acts 3 m above it.
        self.assertAlmostEqual(h["reaction_base_mz_Nm"], push * 3.0, delta=0.01 * WEIGHT)
        self.assertAlmostEqual(h["reaction_base_my_Nm"], 0.0, delta=0.001 * WEIGHT)

        forces = run.frames[-1].forces
        self.assertEqual(len(forces["position"]), 3)
        order = np.argsort(forces["position"][:, 1])
        above = np.array([3, 2, 1])  # cubes
        np.testing.assert_allclose(forces["normal_force_N"][order], -above * WEIGHT, rtol=0.01)
        np.testing.assert_allclose(forces["shear_force_N"][order], push, rtol=0.05)
        # The eccentricity of the resultant is the moment of the force, (0.5, 1.5, 2.5) m above the joint, over the weight.
        arm = push * np.array([2.5, 1.5, 0.5]) / (above * WEIGHT)
        np.testing.assert_allclose(forces["position"][order, 0] - 0.5, arm, atol=0.01)
        np.testing.assert_allclose(forces["force_N"][order, 0], push, rtol=0.05)  # force of the upper block on the lower one
        line = sorted(thrust_lines(run.frames[-1]), key=lambda piece: piece[0][1])
        self.assertEqual(len(line), 2)
        np.testing.assert_allclose(sorted({round(float(p[1]), 2) for piece in line for p in piece}), [1, 2, 3], atol=0.01)

    def test_a_wall_has_its_line_of_thrust_through_courses(self):
        run = self.run_scene(quoin.Scene.load(SMALL_WALL))
        line = thrust_lines(run.frames[0])  # under vertical load only: in the centre
        self.assertEqual(len(line), 2)  # three levels of bed joints
        for piece in line:
            for x, _, z in piece:
                self.assertAlmostEqual(x, 0.22, delta=1e-3)
                self.assertAlmostEqual(z, 0.05, delta=1e-3)

    def test_an_arch_thrusts_alike_to_both_sides(self):
        scene = quoin.Scene.load(SCENES + "/arch.toml")
        scene.stage = [scene.stage[0]]
        run = self.run_scene(scene)
        self.assertEqual(len(thrust_lines(run.frames[-1])), 7)  # one piece for each voussoir
        forces = run.frames[-1].forces
        x = forces["position"][:, 0]
        np.testing.assert_allclose(np.sort(x), -np.sort(x)[::-1], atol=0.05)

    def test_a_vault_in_bond_thrusts_from_abutment_to_abutment(self):
        """With rings alternately of one and two blocks there is one symmetric line, from springing to springing."""
        scene = quoin.Scene(solver=dict(damping="viscous", mass_damping=20.0, stiffness_damping=1e-4))
        scene.materials.stone = quoin.BlockMaterial(density=2000.0, young_modulus=1e10, poisson_ratio=0.2)
        scene.joints.dry = quoin.Joint(law="coulomb_slip", initial_state="dry", normal_stiffness=1e9, shear_stiffness=0.5e9,
                                       friction_angle=35.0)
        scene.block = quoin.shapes.barrel_vault(3.0, 0.5, 1.0, 15, 1, angles=(15.0, 165.0), material="stone")
        scene.stage = [quoin.Stage(name="weight", gravity=[0, -9.81, 0], ramp_time=0.1, duration=0.6)]
        scene.output = dict(frames=1, plots=False)
        run = self.run_scene(scene)
        line = thrust_lines(run.frames[-1])
        self.assertEqual(len(line), 15)  # one piece for each ring
        for (_, end), (begin, _) in zip(line, line[1:]):
            np.testing.assert_array_equal(end, begin)
        places = np.array([line[0][0]] + [end for _, end in line])
        # Tolerance 20 mm of 0.5 m, for remaining motion.
        np.testing.assert_allclose(places[:, :2], places[::-1, :2] * [-1, 1], atol=0.02)
        np.testing.assert_allclose(places[:, 2], 0.5, atol=0.02)  # m, the middle of the width
        radius = np.hypot(places[:, 0], places[:, 1])
        self.assertGreater(radius.min(), 2.75)  # m: within the vault
        self.assertLess(radius.max(), 3.25)

    def test_frames_of_all_stages(self):
        told = {}
        for name, changes in dict(none=dict(frames=0), last=dict(frames=3, frames_of="last"), all=dict(frames=3)).items():
            scene = quoin.Scene.load(SMALL_WALL)
            scene.output = changes
            run = quoin.run(scene, out=self.path(name), threads=1)
            told[name] = quoin.open(self.path(name))
            self.assertEqual(len(run.frames), len(told[name].frames))
        # An output setting changes no number.
        for name in ("last", "all"):
            np.testing.assert_array_equal(told[name].history.tobytes(), told["none"].history.tobytes())
        self.assertEqual([f.stage for f in told["last"].frames], [2, 2, 2, 2])
        # Beginning and end of the first stage, which ends at equilibrium, and thirds of the second.
        self.assertEqual([f.stage for f in told["all"].frames], [1, 1, 2, 2, 2])
        rows = told["all"].history
        self.assertEqual(rows["time_s"][told["all"].frames[1].row], rows["time_s"][rows["stage"] == 1][-1])
        moved = [np.abs(f.blocks["displacement_m"]).max() for f in told["all"].frames]
        self.assertLess(moved[0], moved[1])
        scene = quoin.Scene.load(SMALL_WALL)
        scene.stage[0].frames, scene.stage[1].frames = 1, 0
        run = self.run_scene(scene, "first")
        self.assertEqual([f.stage for f in run.frames], [1, 1])

    def test_widths_of_cracks_along_the_run(self):
        scene = quoin.Scene.load(SMALL_WALL)
        scene.output = dict(frames=3)
        run = self.run_scene(scene)
        pairs, times, widths = run.joint_histories()
        self.assertEqual(widths.shape, (len(run.frames), len(pairs)))
        joints = run.frames[-1].joints
        for (a, b), width in zip(pairs[:5], widths[-1]):
            of = np.sort(np.stack([joints["block_a"], joints["block_b"]], axis=1), axis=1) == (a, b)
            self.assertEqual(width, max(0.0, joints["opening_m"][of.all(axis=1)].max()))

    def reader_and_scene_of_xdmf(self):
        try:
            import h5py
        except ImportError:
            self.skipTest("h5py is not installed (python3-h5py)")
        scene = quoin.Scene.load(SMALL_WALL)
        scene.output = dict(frames=1)
        return h5py, scene

    def test_xdmf_has_the_arrays_of_the_frames(self):
        h5py, scene = self.reader_and_scene_of_xdmf()
        run = self.run_scene(scene)
        run.save_xdmf(self.path("wall.xdmf"))
        corners = {6: 4, 9: 8, 5: 4, 1: None, 3: None}  # by the cell types of XDMF; None: the next number has it
        with h5py.File(self.path("wall.h5")) as file:
            for collection in ElementTree.parse(self.path("wall.xdmf")).getroot().find("Domain"):
                self.assertEqual([float(grid.find("Time").get("Value")) for grid in collection], [f.time for f in run.frames])
                for grid, moment in zip(collection, run.frames):
                    arrays = getattr(moment, collection.get("Name"))
                    items = {a.get("Name"): a.find("DataItem") for a in grid.iter("Attribute")}
                    self.assertEqual(set(items), set(arrays) - {"position", "connectivity", "offsets", "types"})
                    items["position"] = grid.find("Geometry/DataItem")
                    for name, item in items.items():
                        values = file[item.text.split(":")[1]]
                        self.assertEqual(item.get("Dimensions"), " ".join(map(str, values.shape)))
                        np.testing.assert_array_equal(values, arrays[name])
                    words, cells = list(file[grid.find("Topology/DataItem").text.split(":")[1]]), []
                    while words:
                        count = corners[words.pop(0)]
                        count = words.pop(0) if count is None else count
                        cells.append(words[:count])
                        del words[:count]
                    self.assertEqual(len(cells), int(grid.find("Topology").get("NumberOfElements")))
                    np.testing.assert_array_equal(np.concatenate(cells), arrays["connectivity"])
                    np.testing.assert_array_equal(np.cumsum([len(c) for c in cells]), arrays["offsets"])

    def test_xdmf_takes_any_name_and_keeps_what_it_cannot_replace(self):
        h5py, scene = self.reader_and_scene_of_xdmf()
        scene.stage[1].name = "drücken"
        run = self.run_scene(scene)
        run.save_xdmf(self.path("a & b.xdmf"))
        with h5py.File(self.path("a & b.h5")) as file:
            self.assertEqual(set(file["history/stage_name"].asstr()[:]), {"precompression", "drücken"})
        places = [item.text for item in ElementTree.parse(self.path("a & b.xdmf")).iter("DataItem")]
        self.assertTrue(places)
        self.assertEqual({place.split(":")[0] for place in places}, {"a & b.h5"})
        with open(self.path("a & b.h5"), "rb") as file:
            whole = file.read()
        os.remove(os.path.join(run.folder, "forces_0000.vtu"))
        with self.assertRaisesRegex(quoin.BadInput, "forces_0000.vtu: No such file"):
            quoin.open(run.folder).save_xdmf(self.path("a & b.xdmf"))
        with open(self.path("a & b.h5"), "rb") as file:
            self.assertEqual(file.read(), whole)
        self.assertEqual([name for name in os.listdir(self.folder) if name.endswith(".part")], [])

    def test_a_run_that_failed_in_its_first_step_is_opened(self):
        """Its history has no row. The weight of a block of 1e300 m/s2 is beyond what numbers hold."""
        scene = block_scene(output=dict(frames=1))
        scene.stage = [quoin.Stage(name="fall", duration=1.0, gravity=[0, -1e300, 0], ramp_time=0.0)]
        with self.assertRaises(quoin.NumericalFailure):
            quoin.run(scene, out=self.path("failed"))
        run = quoin.open(self.path("failed"))
        self.assertEqual((len(run.history), [(f.stage, f.row) for f in run.frames]), (0, [(1, None)]))
        self.assertEqual(run.peak, (None, None))
        self.assertEqual(len(run.frames[0].blocks["position"]), 16)


if __name__ == "__main__":
    unittest.main()
