"""Frames of a run in Python against the files of the same run, number by number, and equilibrium of its forces."""
import unittest

import quoin
from support import SCENES, SMALL_WALL, Folder
import numpy as np  # after support, which tells where it is missing
from vtu import Vtu, times_of

# Names of columns of a frame's joints, and of arrays of the files.
SAME = dict(position="position", displacement="displacement_m", traction="traction_Pa", opening="opening_m", slip="slip_m",
            damage_tension="damage_tension", damage_shear="damage_shear", crack="crack", block_a="block_a",
            block_b="block_b", joint="family")


def wall(**solver):
    scene = quoin.Scene.load(SMALL_WALL)
    scene.solver = dict(large_motion="never", past_motion_bound="warn", **solver)
    scene.stage[1].velocity = 0.2
    scene.output = dict(frames=3, frames_of="last", energy=True)
    return scene


def slab():
    """Returns the shipped arch with a short collapse: blocks of any shape, of which some slide."""
    scene = quoin.Scene.load(SCENES + "/arch.toml")
    scene.stage[1].collapse.rate = 0.2
    scene.stage[1].collapse.displacement = 0.1
    scene.output.frames, scene.output.frames_of = 2, "last"
    return scene


def displacements(blocks, points, moved):
    """Returns values by block and initial position, since a promotion changes the order of gridpoints."""
    return {(block, *np.round(x, 6)): tuple(u) for block, x, u in zip(blocks, points.astype("f4"), moved)}


class Frames(Folder):
    def run_both(self, scene):
        return quoin.run(scene, out=self.path("out"), threads=1)

    def assert_frames_are_those_of_the_files(self, run):
        out = self.path("out")
        np.testing.assert_allclose([f.time for f in run.frames], times_of(out), rtol=1e-8)
        self.assertGreater(len(run.frames), 2)
        for k, frame in enumerate(run.frames):
            blocks, joints = Vtu(f"{out}/blocks_{k:04}.vtu"), Vtu(f"{out}/joints_{k:04}.vtu")
            of_file = displacements(blocks.block_of_point(), blocks["position"], blocks["displacement_m"])
            of_frame = displacements(run.mesh["block"], run.mesh["points"], frame.displacement.astype("f4"))
            self.assertEqual(of_frame, of_file, f"frame {k}")
            self.assertEqual(set(frame.joints.dtype.names), {*SAME, "gap"})
            self.assertGreater(len(frame.joints), 20)
            for name, of_file in SAME.items():
                expected = joints[of_file]
                np.testing.assert_array_equal(frame.joints[name].astype(expected.dtype), expected, f"{name}, frame {k}")
            gap = joints["gap_m"] if "gap_m" in joints else np.zeros((len(frame.joints), 3))  # only files of large motion have it
            np.testing.assert_array_equal(frame.joints["gap"].astype("f4"), gap.astype("f4"), f"gap, frame {k}")
        # The columns are not constant, so that the comparison is significant.
        last = run.frames[-1].joints
        for name in ("position", "traction", "opening", "block_a", "block_b"):
            self.assertGreater(len(np.unique(last[name])), 3, name)

    def test_of_a_wall(self):
        run = self.run_both(wall())
        self.assert_frames_are_those_of_the_files(run)
        self.assertEqual(run.peak[0], np.abs(run.history["horizontal_force_N"]).max())

    def test_of_blocks_of_any_shape(self):
        run = self.run_both(slab())
        self.assert_frames_are_those_of_the_files(run)

    def test_of_a_wall_that_goes_over_to_large_motion(self):
        scene = wall()
        scene.solver, scene.stage[1].displacement = dict(sliding_bound=6e-3), 2e-3
        run = self.run_both(scene)
        promoted = run.summary["motion"]["promoted"]
        self.assertLess(run.frames[1].time, promoted["time_s"])
        self.assertGreater(run.frames[2].time, promoted["time_s"])
        self.assert_frames_are_those_of_the_files(run)

    def test_tractions_add_up_to_the_forces_of_the_history(self):
        """Force on the top beam at the end: sum over its contact points of area times traction along the joint's axes, which
        only the files have. Tolerance 1e-5: areas have 24 bits."""
        for kernels in ("lattice", "general"):
            run = self.run_both(wall(kernels=kernels))
            out, frame, last = self.path("out"), run.frames[-1], run.history[-1]
            self.assertEqual(frame.time, last["time_s"])
            files = Vtu(f"{out}/joints_{len(run.frames) - 1:04}.vtu")
            area, n, s = (files[name].astype(float) for name in ("area_m2", "normal", "shear_axis"))
            traction = frame.joints["traction"]
            on_a = area[:, None] * (traction[:, :1] * n + traction[:, 1:2] * s + traction[:, 2:] * np.cross(n, s))
            points, block = run.mesh["points"], run.mesh["block"]
            top = block[points[:, 1].argmax()]
            joints = frame.joints
            force = on_a[joints["block_a"] == top].sum(axis=0) - on_a[joints["block_b"] == top].sum(axis=0)
            size = abs(last["vertical_force_N"])
            self.assertGreater(size, 1e4)
            self.assertGreater(abs(last["horizontal_force_N"]), 1e3)
            self.assertAlmostEqual(-force[0], last["horizontal_force_N"], delta=1e-5 * size)
            self.assertAlmostEqual(force[1], last["vertical_force_N"], delta=1e-5 * size)
            # Each single point: an open one that has lost all strength carries no traction.
            open_cracks = (joints["opening"] > 1e-5) & (joints["damage_tension"] == 1.0) & (joints["damage_shear"] == 1.0)
            self.assertLess(np.abs(traction[open_cracks]).max(initial=0.0), 1.0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
