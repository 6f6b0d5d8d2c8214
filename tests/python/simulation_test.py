"""Simulations that are stepped, read and steered from Python."""
import gc
import json
import os
import signal
import subprocess
import sys
import threading
import time
import unittest
import warnings

import numpy as np
import quoin
from support import SMALL_WALL, Folder, assert_same_history, block_scene


def slow_scene():
    """Returns a scene that takes some seconds."""
    scene = quoin.Scene.load(SMALL_WALL)
    scene.stage[1].velocity = 1e-5
    return scene


class Views(unittest.TestCase):
    def test_they_show_the_present(self):
        sim = quoin.Simulation(SMALL_WALL)
        sigma, u = sim.sigma("mortar"), sim.displacement(0)
        self.assertEqual(sigma.shape, (sim.area("mortar").size,))
        self.assertEqual(u.shape[1], 3)
        self.assertEqual(np.abs(sigma).max(), 0.0)
        sim.run(until="precompression")
        # Every bed joint carries 0.3 MPa on 0.44 x 0.1 m. Tolerance 1 %, for the equilibrium.
        bed = np.abs(np.array(sim.contacts("mortar")["normal"])[:, 1]) > 0.5
        beds = 3
        force = np.sum(sigma[bed] * sim.area("mortar")[bed]) / beds
        self.assertAlmostEqual(force, -0.3e6 * 0.44 * 0.1, delta=0.01 * 0.3e6 * 0.044)
        self.assertGreater(np.abs(u).max(), 0.0)
        self.assertEqual((2 * sigma - sigma).max(), np.array(sigma).max())

    def test_nothing_that_they_give_outlives_a_step(self):
        sim = quoin.Simulation(SMALL_WALL)
        sim.step(300)
        part, whole = sim.sigma("mortar")[3:9], np.asarray(sim.sigma("mortar"))
        kept, kept_whole = part.copy(), whole.copy()
        sim.step(300)
        np.testing.assert_array_equal(part, kept)
        np.testing.assert_array_equal(whole, kept_whole)
        self.assertFalse(np.array_equal(sim.sigma("mortar"), kept_whole))

    def test_nothing_writes_through_them(self):
        sim = quoin.Simulation(SMALL_WALL)
        sim.step(300)
        views = [sim.sigma("mortar"), sim.tau_s("mortar"), sim.tau_t("mortar"), sim.area("mortar"),
                 sim.position("mortar"), sim.displacement(0), sim.velocity(0), sim.state("mortar", "xi_t")]
        before, hashed = [np.array(v) for v in views], sim.hash

        class Sly(np.ndarray):
            """Stores its arguments."""
            given = []

            def __array_ufunc__(self, ufunc, method, *inputs, **named):
                Sly.given += inputs
                return np.zeros(1)

        class Thief:
            def __radd__(self, number):
                Sly.given.append(number)
                return number
        for view in views:
            values = np.full(view.shape, 2.0)
            for write in (lambda v: np.add.at(v, 0, 5.0), lambda v: np.multiply.at(v, slice(None), 0.5),
                          lambda v: np.negative.at(v, 0), lambda v: np.add(v, 1.0, out=v),
                          lambda v: np.add(values, 1.0, out=v), lambda v: np.add.accumulate(values, out=v),
                          lambda v: np.copyto(v, 1.0), lambda v: np.put(v, 0, 1.0), lambda v: np.place(v, values > 0, 1.0),
                          lambda v: np.putmask(v, values > 0, 1.0), lambda v: np.frombuffer(v), lambda v: memoryview(v),
                          lambda v: v.__array_interface__, lambda v: v.data, lambda v: v.setflags(write=True)):
                with self.assertRaises((TypeError, ValueError, AttributeError)):
                    write(view)
            np.add(view, np.zeros(view.shape).view(Sly))
            np.add(np.zeros(view.shape).view(Sly), view)
            np.add(view, np.array([Thief()], dtype=object))
            for given in Sly.given:
                if isinstance(given, np.ndarray) and given.flags.writeable:
                    given[...] = 7.0
            for result in (view[...], view[:], view[None], np.positive(view), np.sum(view, axis=()), view.max(axis=()),
                           np.array(view), np.asarray(view), np.ravel(view), np.atleast_2d(view), view.copy()):
                np.add.at(result, 0, 1.0)
        for view, then in zip(views, before):
            np.testing.assert_array_equal(view, then)
        self.assertEqual(sim.hash, hashed)
        np.add.at(before[0], slice(None), views[0])  # views may be added to other arrays
        np.testing.assert_array_equal(before[0], 2 * np.array(views[0]))

    def test_one_whose_simulation_is_gone_raises(self):
        for end in ("close", "delete"):
            sim = quoin.Simulation(SMALL_WALL)
            sim.step(10)
            views = [sim.sigma("mortar"), sim.tau_s("mortar"), sim.area("mortar"), sim.position("mortar"),
                     sim.displacement(0), sim.velocity(0), sim.state("mortar", "xi_t")]
            if end == "close":
                sim.close()
            else:
                del sim
                gc.collect()
            for view in views:
                for use in (lambda v: v[0], lambda v: v + 1, np.sum, len, np.array, lambda v: v.max(), lambda v: v.shape):
                    with self.assertRaises(quoin.Gone):
                        use(view)
                self.assertIn("gone", repr(view))
            with self.assertRaises(quoin.Gone):
                views[5][...] = 0.0
            if end == "close":
                for call in (sim.step, sim.run, sim.measure, lambda: sim.time, lambda: sim.sigma("mortar"), sim.save):
                    with self.assertRaises(quoin.Gone):
                        call()

    def test_states_damage_and_contacts_agree(self):
        sim = quoin.Simulation(SMALL_WALL)
        sim.run()
        contacts = sim.contacts("mortar")
        self.assertEqual(len(contacts), len(sim.sigma("mortar")))
        np.testing.assert_array_equal(contacts["area"], sim.area("mortar"))
        np.testing.assert_array_equal(contacts["position"], sim.position("mortar"))
        tension, shear, crushing = sim.damage("mortar")
        self.assertGreater(np.nanmax(tension), 0.0)
        self.assertTrue(((tension >= 0) & (tension <= 1)).all())
        with self.assertRaisesRegex(quoin.BadInput, "state: law fracture_energy keeps no state 'rust'"):
            sim.state("mortar", "rust")
        with self.assertRaisesRegex(KeyError, "there is no joint family 'glue'; there are mortar"):
            sim.sigma("glue")

    def test_they_survive_large_motion(self):
        scene = block_scene(stage=[quoin.Stage(duration=1.0, gravity=[0, -9.81, 0])])
        sim = quoin.Simulation(scene)
        velocity, sigma = sim.velocity("cube"), sim.sigma("dry")
        self.assertEqual(velocity.shape, (1, 3))
        self.assertEqual(len(sigma), 0)
        sim.run(until=lambda s: s.time > 0.5 or len(sigma) > 0 and sigma.min() < 0.0, every=5)
        # It has fallen by 1 m onto new contacts. Tolerance 2 %, since they deform.
        self.assertAlmostEqual(sim.time, (2 / 9.81) ** 0.5, delta=0.01)
        self.assertGreater(len(sigma), 0)
        self.assertEqual(len(sigma), len(sim.contacts("dry")))


    def test_positions_follow_large_motion(self):
        # The base moves with the ground, by 0.1 m/s for 1 s, and takes the block on it along.
        scene = block_scene()
        scene.solver = dict(damping="none", large_motion="always")
        scene.block[1].box.lower = [0, 1, 0]
        scene.stage = [quoin.Stage(name="move", duration=1.0)]
        sim = quoin.Simulation(scene)
        sim.step()
        start, view = sim.position("dry").copy(), sim.position("dry")
        sim.set_velocity("base", [0.1, 0.0, 0.0])
        sim.velocity("cube")[...] = [0.1, 0.0, 0.0]
        then = sim.time
        sim.run()
        np.testing.assert_array_equal(view, sim.contacts("dry")["position"])
        # Exact but for rounding, and half a step until the velocity acts on the whole of one.
        np.testing.assert_allclose(view - start, np.tile([0.1 * (sim.time - then), 0, 0], (len(start), 1)),
                                   atol=0.1 * sim.time_step)


class Steering(Folder):
    def test_a_force_accelerates_as_newton_says(self):
        sim = quoin.Simulation(block_scene())
        sim.step()
        sim.set_force("cube", [100.0, None, -50.0])
        n, dt = 500, sim.time_step
        sim.step(n)
        # Exact in central differences but for rounding: n additions of F dt / m. 1000 kg.
        np.testing.assert_allclose(sim.velocity("cube")[0], np.array([100.0, 0.0, -50.0]) / 1000 * n * dt, rtol=1e-10)
        sim.set_force("cube", [0.0, 0.0, 0.0])
        before = sim.velocity("cube").copy()
        sim.step(10)
        np.testing.assert_array_equal(sim.velocity("cube"), before)

    def test_a_force_replaces_what_the_stage_loads_the_block_with(self):
        # A cube of 1000 kg on elastic joints, pushed by 4000 N and pressed by 1000 Pa on 1 m2, both along x.
        def scene(**solver):
            made = block_scene()
            made.solver = dict(damping="local", **solver)
            made.joints["dry"] = quoin.Joint(law="elastic", normal_stiffness=1e7, shear_stiffness=1e6)
            made.block[1].box.lower = [0, 1, 0]
            made.stage = [quoin.Stage(name="push", duration=3.0,
                                      force=[dict(block="cube", point=[0.5, 1.5, 0.5], force=[4000.0, 0, 300.0])],
                                      pressure=[dict(block="cube", normal=[-1.0, 0, 0], pressure=1000.0)])]
            made.output.monitor = "cube"
            return made

        def at_rest(sim):
            sim.run()
            return [sim.measure()[f"monitor_f{axis}_N"] for axis in "xz"]

        never = dict(large_motion="never", rotation_bound=0.3, sliding_bound=0.5)
        for solver in (dict(kernels="lattice", **never), dict(kernels="general")):
            # Reaction at rest. Tolerance 1e-6 of it: what local damping leaves of the motion after 3 s.
            np.testing.assert_allclose(np.abs(at_rest(quoin.Simulation(scene(**solver)))), [5000.0, 300.0], rtol=1e-6)
            sim = quoin.Simulation(scene(**solver))
            sim.step()
            sim.set_force("cube", [8000.0, None, None])
            state = sim.save()
            np.testing.assert_allclose(np.abs(at_rest(sim)), [8000.0, 300.0], rtol=1e-6, err_msg=str(solver))
            self.assertEqual(sim.large_motion, "never" not in solver.values())
            bits = sim.hash
            sim.restore(state)
            sim.run()
            self.assertEqual(sim.hash, bits)
            sim = quoin.Simulation(scene(**solver))
            sim.restore(state)
            sim.run()
            self.assertEqual(sim.hash, bits)

    def test_a_pressure_on_an_inclined_face_goes_as_a_whole(self):
        scene = block_scene()
        scene.block[1].rotation = [0.0, 0.0, 30.0]
        face = [-np.cos(np.pi / 6), -0.5, 0.0]
        scene.stage[0].pressure = [dict(block="cube", normal=face, pressure=1000.0)]
        sim = quoin.Simulation(scene)
        sim.step()
        with self.assertRaisesRegex(quoin.BadInput, "an inclined face of 'cube'.*give all three"):
            sim.set_force("cube", [8000.0, None, None])
        sim.set_force("cube", [None, None, 10.0])  # the face has no part of this
        before, then = sim.velocity("cube").copy(), sim.time
        sim.step(10)
        # Exact but for rounding of the rotation: 1000 Pa on 1 m2, and 1000 kg.
        gained = (sim.velocity("cube")[0] - before[0]) / (sim.time - then)
        np.testing.assert_allclose(gained, [np.cos(np.pi / 6), 0.5, 0.01], rtol=1e-9)
        sim.set_force("cube", [500.0, 0.0, 0.0])
        before, then = sim.velocity("cube").copy(), sim.time
        sim.step(10)
        gained = (sim.velocity("cube")[0] - before[0]) / (sim.time - then)
        np.testing.assert_allclose(gained, [0.5, 0.0, 0.0], rtol=1e-9, atol=1e-9)

    def test_velocities_that_are_written_move_blocks(self):
        sim = quoin.Simulation(block_scene())
        sim.step()
        sim.velocity("cube")[...] = [0.5, 0.0, 0.25]
        start = sim.time
        sim.step(100)
        np.testing.assert_allclose(sim.displacement("cube")[0], np.array([0.5, 0, 0.25]) * (sim.time - start), rtol=1e-9,
                                   atol=1e-12)
        with self.assertRaisesRegex(ValueError, "velocity: every value must be finite"):
            sim.velocity("cube")[0, 1] = np.nan
        with self.assertRaisesRegex(ValueError, "sigma: can be read only"):
            sim.sigma("dry")[...] = 1.0

    def test_velocities_of_congruent_blocks_are_written_too(self):
        # Three or more deformable blocks of one shape keep their velocities in lanes.
        cubes = [quoin.Block(name=f"cube {i}", material="stone", rigid=False, divisions=[2, 2, 2],
                             box={"lower": [2.0 * i, 1.5, 0.0], "size": [1.0, 1.0, 1.0]}) for i in range(4)]
        sim = quoin.Simulation(block_scene(block=[block_scene().block[0], *cubes]))
        velocity = sim.velocity("cube 1")
        for speed in (0.5, -0.25):  # at the start, and between steps
            velocity[...] = [speed, 0.0, 0.0]
            before, start = sim.displacement("cube 1").copy(), sim.time
            sim.step(100)
            moved = sim.displacement("cube 1") - before
            np.testing.assert_allclose(moved[:, 0], speed * (sim.time - start), rtol=1e-9)
            np.testing.assert_allclose(sim.velocity("cube 2"), 0.0, atol=1e-12)

    def test_a_velocity_moves_what_the_stage_holds(self):
        # The base of the blocks and the beam of the wall are fixed.
        sim = quoin.Simulation(block_scene())
        sim.set_velocity("base", [0.0, 0.0, 0.1])
        sim.step(100)
        self.assertAlmostEqual(sim.displacement("base")[0, 2], 0.1 * 100 * sim.time_step, delta=1e-12)
        wall = quoin.Simulation(SMALL_WALL)
        wall.run(until="precompression")
        wall.step()
        wall.set_velocity("top_beam", [-0.02, None, None])
        there = wall.measure()["displacement_m"]
        wall.step(200)
        # Exact but for rounding, and for one step with the velocity of the stage.
        self.assertAlmostEqual(wall.measure()["displacement_m"] - there, -0.02 * 200 * wall.time_step,
                               delta=0.02 * 2 * wall.time_step)

    def test_ground_that_is_steered_is_still_the_ground(self):
        blocks = block_scene()
        blocks.joints["dry"] = quoin.Joint(law="elastic", normal_stiffness=1e7, shear_stiffness=1e7)
        blocks.block[1].box.lower = [0, 1, 0]
        blocks.output.monitor = "cube"
        wall = quoin.Scene.load(SMALL_WALL)
        wall.solver.large_motion = "never"
        for scene, base, lasts, more in ((blocks, "base", 1.0, {}),
                                         (wall, "bottom_beam", 4e-3, dict(kind="custom", monitor="top_beam"))):
            shake = dict(direction=[1, 0, 0], time=[0, lasts / 2, lasts], acceleration=[0, 1.0, 0])
            scene.stage = [quoin.Stage(name="shake", duration=lasts, ground_motion=shake, **more),
                           quoin.Stage(name="after", duration=lasts / 10, **more)]
            plain, steered = (quoin.Simulation(scene, threads=1) for _ in range(2))
            self.assertEqual(plain.large_motion, scene is blocks)
            for sim in (plain, steered):
                sim.run(until=0.3 * lasts)
            steered.set_velocity(base, [None, None, 0.1])
            then, state = steered.time, steered.save()
            plain.run(until=0.8 * lasts)
            for _ in range(2):
                steered.run(until=0.8 * lasts)
                row, reference = steered.measure(), plain.measure()
                self.assertGreater(row["ground_dx_m"], 0.1 * lasts**2)
                self.assertEqual(row["ground_dx_m"], reference["ground_dx_m"])
                self.assertEqual(row["monitor_relative_dx_m"], row["monitor_dx_m"] - row["ground_dx_m"])
                # Exact but for rounding and for the steps at both ends.
                self.assertAlmostEqual(row["ground_dz_m"], 0.1 * (steered.time - then), delta=0.1 * 2 * steered.time_step)
                steered.restore(state)
            # In the next stage what was set is at rest.
            steered.run(until="shake")
            steered.step(3)
            before = steered.displacement(base).copy()
            steered.step(10)
            np.testing.assert_array_equal((steered.displacement(base) - before)[:, 2], 0.0)
            # It stands, exactly, at the velocity that was set: 0.
            steered.restore(state)
            steered.set_velocity(base, [0.0, 0.0, 0.0])
            steered.step(2)
            there = steered.measure()
            steered.run(until="shake")
            for column in ("ground_dx_m", "ground_dz_m"):
                self.assertEqual(steered.measure()[column], there[column])
            self.assertGreater(there["ground_dx_m"], 0.0)

    def test_what_cannot_be_steered_is_told(self):
        sim = quoin.Simulation(SMALL_WALL)
        sim.step()
        with self.assertRaisesRegex(quoin.BadInput, "force: the stage holds or moves 'bottom_beam' along x"):
            sim.set_force("bottom_beam", [1.0, None, None])
        with self.assertRaisesRegex(quoin.BadInput, "velocity: the stage leaves free 'top_beam' along y; give None"):
            sim.set_velocity("top_beam", [None, 1.0, None])
        with self.assertRaisesRegex(quoin.BadInput, "body: nothing is called 'roof'.*top_beam"):
            sim.set_force("roof", [1.0, 0, 0])
        with self.assertRaisesRegex(ValueError, "velocity: three numbers are needed"):
            sim.set_velocity("top_beam", [1.0, 2.0])
        with self.assertRaisesRegex(ValueError, "force: nan is not finite"):
            sim.set_force("top_beam", [float("nan"), 0, 0])
        with self.assertRaisesRegex(ValueError, "n = 100000000000000000000: allowed: 1 to"):
            sim.step(10**20)

    def test_blocks_are_given_by_number_or_by_a_name_of_one(self):
        scene = block_scene()
        scene.block.append(quoin.Block(name="cube", material="stone", box=dict(lower=[0, 4, 0], size=[1, 1, 1])))
        sim = quoin.Simulation(scene)
        sim.velocity(np.int32(2))[...] = [0.0, 0.5, 0.0]
        np.testing.assert_array_equal(sim.velocity(2), sim.velocity(np.int64(2)))
        with self.assertRaisesRegex(KeyError, "2 blocks are called 'cube': give the number of one: 1, 2"):
            sim.velocity("cube")
        with self.assertRaisesRegex(IndexError, "block: 3 is not among the 3 blocks"):
            sim.displacement(np.int64(3))
        with self.assertRaisesRegex(TypeError, "a number or a name"):
            sim.displacement(np.True_)

    def test_a_swapped_law_keeps_the_tractions(self):
        sim = quoin.Simulation(SMALL_WALL)
        sim.run(until="precompression")
        sim.step()
        before = sim.sigma("mortar").copy()
        swap = sim.swap_law("mortar", "coulomb_slip")
        self.assertEqual((swap["from"], swap["to"], swap["points"]), ("fracture_energy", "coulomb_slip", len(before)))
        np.testing.assert_array_equal(sim.sigma("mortar"), before)
        sim.step(2)
        np.testing.assert_allclose(sim.sigma("mortar"), before, rtol=1e-3, atol=300.0)  # two steps of 0.3 MPa at rest
        state = sim.save()
        sim.step(100)
        end = sim.hash
        sim.restore(state)
        sim.step(100)
        self.assertEqual(sim.hash, end)
        with self.assertRaisesRegex(quoin.LawRefused, "no_such_law"):
            sim.swap_law("mortar", "no_such_law")

    def test_until(self):
        sim = quoin.Simulation(SMALL_WALL)
        self.assertIsNone(sim.stage)
        self.assertTrue(sim.run(until=1e-4))
        self.assertAlmostEqual(sim.time, 1e-4, delta=sim.time_step)
        self.assertTrue(sim.run(until="precompression"))
        self.assertEqual(sim.stage, "precompression")
        self.assertEqual(sim.history["stage"][-1], 1)
        self.assertTrue(sim.run(until=lambda s: s.stage == "shear" and s.measure()["displacement_m"] > 1e-4, every=10))
        self.assertAlmostEqual(sim.measure()["displacement_m"], 1e-4, delta=0.05 * 11 * sim.time_step)
        self.assertFalse(sim.run())
        self.assertFalse(sim.step())
        for until in (None, "shear", "precompression", 1e-4, lambda s: True):
            self.assertFalse(sim.run(until=until))
        reference = quoin.Simulation(SMALL_WALL)
        reference.run()
        self.assertEqual(sim.hash, reference.hash)
        with self.assertRaisesRegex(quoin.BadInput, "until = 'tea'.*precompression, shear"):
            sim.run(until="tea")

    def test_the_end_of_a_stage_is_reached_once(self):
        sim = quoin.Simulation(SMALL_WALL)
        sim.run(until="precompression")
        there, state = sim.steps, sim.save()
        for _ in range(2):
            self.assertTrue(sim.run(until="precompression"))
            self.assertEqual((sim.steps, sim.stage), (there, "precompression"))
        sim.step()
        self.assertTrue(sim.run(until="precompression"))
        self.assertEqual((sim.steps, sim.stage), (there + 1, "shear"))
        other = quoin.Simulation(SMALL_WALL)
        for restored in (sim, other):
            restored.restore(state)
            self.assertEqual(restored.stage, "precompression")
            self.assertTrue(restored.run(until="precompression"))
            self.assertEqual(restored.steps, there)
            self.assertFalse(restored.run(until="shear"))
            self.assertFalse(restored.run(until="shear"))
        self.assertEqual(sim.hash, other.hash)


class Interruptions(Folder):
    def test_checkpoints_go_on_with_the_same_bits(self):
        sim = quoin.Simulation(SMALL_WALL)
        sim.step(700)
        state = sim.save()
        sim.checkpoint(self.path("then.bin"))
        sim.run()
        resumed = quoin.Simulation.resume(SMALL_WALL, self.path("then.bin"))
        self.assertEqual((resumed.steps, resumed.stage), (700, "shear"))
        resumed.run()
        self.assertEqual(resumed.hash, sim.hash)
        assert_same_history(resumed.history, sim.history)
        sim.restore(state)
        self.assertEqual(sim.steps, 700)
        sim.run()
        assert_same_history(resumed.history, sim.history)
        other = quoin.Scene.load(SMALL_WALL)
        other.joints.mortar.cohesion = 0.2e6
        with self.assertRaisesRegex(quoin.BadInput, "scene"):
            quoin.Simulation.resume(other, self.path("then.bin"))
        with self.assertRaisesRegex(quoin.BadInput, "checkpoint"):
            sim.restore(b"rubbish")

    def test_a_state_of_another_scene_is_refused(self):
        state = quoin.Simulation(block_scene()).save()
        for key, change in (("joints", lambda s: setattr(s.joints.dry, "friction_angle", 30.0)),
                            ("block", lambda s: setattr(s.block[1].box, "size", [1, 0.9, 1])),
                            ("stage", lambda s: s.stage.append(quoin.Stage(duration=1.0))),
                            ("monitor", lambda s: s.monitor.append(quoin.Monitor(name="m", block="cube")))):
            other = block_scene()
            change(other)
            sim = quoin.Simulation(other)
            before = sim.hash
            with self.assertRaisesRegex(quoin.BadInput, f"state: is of another value of '{key}' in the scene"):
                sim.restore(state)
            self.assertEqual(sim.hash, before)

    def test_files_are_complete_at_the_end_and_after_a_restart(self):
        scene = quoin.Scene.load(SMALL_WALL)
        scene.output.frames = 2
        scene.monitor.append(quoin.Monitor(name="top", block="top_beam"))

        def contents(out):
            names = sorted(os.listdir(self.path(out)))
            self.assertFalse([name for name in names if name.endswith(".part")], names)
            with open(self.path(f"{out}/summary.json"), encoding="utf-8") as file:
                self.assertEqual(json.load(file)["status"], "done")
            kept = [name for name in names if name.endswith((".csv", ".vtu", ".pvd")) or name == "monitors.json"]
            self.assertGreater(len(kept), 8)
            return {name: open(self.path(f"{out}/{name}"), "rb").read() for name in kept}

        quoin.run(scene, out=self.path("whole"))
        whole = contents("whole")
        sim = quoin.Simulation(scene, out=self.path("stepped"))
        sim.step(700)
        state = sim.save()
        sim.checkpoint(self.path("then.bin"))
        sim.run()
        self.assertEqual(contents("stepped"), whole)
        sim.restore(state)
        sim.step(100)
        sim.restore(state)
        sim.run()
        self.assertEqual(contents("stepped"), whole)
        sim.close()
        self.assertEqual(contents("stepped"), whole)
        quoin.Simulation.resume(scene, self.path("then.bin"), out=self.path("resumed")).run()
        restored = quoin.Simulation(scene, out=self.path("restored"))
        restored.restore(state)
        restored.run()
        for out in ("resumed", "restored"):
            of_out = contents(out)
            for name in ("history.csv", "monitors.csv", "monitors.json"):
                self.assertEqual(of_out[name], whole[name], (out, name))

    def test_a_simulation_that_is_closed_early_has_whole_files(self):
        def summary():
            self.assertFalse([name for name in os.listdir(self.path("out")) if name.endswith(".part")])
            with open(self.path("out/summary.json"), encoding="utf-8") as file:
                return json.load(file)

        with quoin.Simulation(SMALL_WALL, out=self.path("out")) as sim:
            sim.step(700)
            rows = len(sim.history)
        self.assertEqual((summary()["status"], summary()["message"]),
                         ("interrupted", "left at step 700, before the end of its last stage"))
        with open(self.path("out/history.csv"), encoding="utf-8") as file:
            self.assertEqual(len(file.readlines()), rows + 1)
        with self.assertRaisesRegex(ArithmeticError, "mine"):
            with quoin.Simulation(SMALL_WALL, out=self.path("out")) as sim:
                sim.step(700)
                raise ArithmeticError("mine")
        self.assertEqual((summary()["status"], summary()["message"]), ("failed", "mine"))

    def test_a_law_is_swapped_after_resume_as_without(self):
        straight = quoin.Simulation(SMALL_WALL)
        straight.run(until="precompression")
        straight.step(50)
        straight.checkpoint(self.path("then.bin"))
        resumed = quoin.Simulation.resume(SMALL_WALL, self.path("then.bin"))
        for sim in (straight, resumed):
            before = sim.sigma("mortar").copy()
            self.assertEqual(sim.swap_law("mortar", "coulomb_slip")["to"], "coulomb_slip")
            np.testing.assert_array_equal(sim.sigma("mortar"), before)
            sim.step(100)
        self.assertEqual(resumed.hash, straight.hash)
        # A run resumed from a checkpoint after the swap has the new law.
        straight.checkpoint(self.path("later.bin"))
        later = quoin.Simulation.resume(SMALL_WALL, self.path("later.bin"))
        for sim in (straight, resumed, later):
            sim.run()
            self.assertEqual(sim.hash, straight.hash)
        assert_same_history(later.history, straight.history)
        # A run resumed from a checkpoint before the swap has the old law.
        sim = quoin.Simulation(SMALL_WALL)
        sim.step(300)
        state = sim.save()
        sim.swap_law("mortar", "coulomb_slip")
        sim.step(50)
        sim.restore(state)
        sim.run()
        plain = quoin.Simulation(SMALL_WALL)
        plain.run()
        self.assertNotEqual(plain.hash, straight.hash)
        self.assertEqual(sim.hash, plain.hash)

    def test_ctrl_c_stops_cleanly_and_the_run_can_go_on(self):
        sim = quoin.Simulation(slow_scene())
        threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
        before = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            sim.run()
        self.assertLess(time.monotonic() - before, 30.0)  # not only at the end of the run
        there = sim.steps
        self.assertGreater(there, 0)
        sim.step(100)
        straight = quoin.Simulation(slow_scene())
        straight.step(there + 100)
        self.assertEqual(sim.hash, straight.hash)
        assert_same_history(sim.history, straight.history)

    def test_an_interrupted_run_keeps_what_it_has(self):
        threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt) as raised:
            quoin.run(slow_scene(), out=self.path("out"))
        run = raised.exception.run
        self.assertEqual(run.summary["status"], "interrupted")
        self.assertGreater(len(run.history), 0)
        self.assertTrue(os.path.exists(self.path("out/history.csv")))

    def test_all_warnings_of_the_summary_are_told(self):
        scene = quoin.Scene.load(SMALL_WALL)
        scene.stage[1].displacement, scene.stage[1].velocity = 1e-4, 0.5  # far too fast for rest

        def run(how):
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always")
                how()
            with open(self.path("out/summary.json"), encoding="utf-8") as file:
                listed = [warning["text"] for warning in json.load(file)["warnings"]]
            self.assertEqual(sorted(str(w.message) for w in told), sorted(listed))
            self.assertTrue(any("quasi-static" in text for text in listed), listed)

        def stepped():
            sim = quoin.Simulation(scene, out=self.path("out"))
            while sim.step(100):
                pass
            self.assertFalse(sim.step())
            sim.close()

        def closed():
            with quoin.Simulation(scene, out=self.path("out")) as sim:
                sim.run(until="precompression")
                sim.step(50)

        for how in (stepped, closed, lambda: quoin.run(scene, out=self.path("out")), lambda: quoin.run(scene)):
            run(how)

    def test_other_threads_run_meanwhile_but_not_in_the_same_simulation(self):
        sim, told = quoin.Simulation(slow_scene(), threads=1), []
        runner = threading.Thread(target=lambda: sim.step(3000))
        runner.start()
        while runner.is_alive() and len(told) < 5:  # this loop needs the lock of the interpreter
            try:
                sim.sigma("mortar")
            except RuntimeError as error:
                told.append(str(error))
        runner.join()
        self.assertIn("being stepped by another thread", told[0])
        self.assertEqual(sim.steps, 3000)

    def test_a_numerical_failure_is_raised_with_what_was_computed(self):
        scene = quoin.Scene.load(SMALL_WALL)
        scene.stage[0].max_steps = 100
        with self.assertRaisesRegex(quoin.NumericalFailure, "'precompression' has not ended after 100 steps") as raised:
            quoin.run(scene)
        self.assertEqual(raised.exception.exit_code, 5)
        self.assertEqual(raised.exception.run.summary["status"], "failed")


HOSTILE = os.environ.get("QUOIN_HOSTILE_LAW", "")  # tests/plugins: a law with the fault of QUOIN_HOSTILE

WATCHED = """
import sys, quoin
scene = quoin.Scene.load(sys.argv[1])
for joint in scene.joints:
    scene.joints[joint] = quoin.Joint(law=sys.argv[2], normal_stiffness=82e9, shear_stiffness=36e9)
options = eval(sys.argv[4])
try:
    quoin.run(scene, out=sys.argv[3], **options)
except quoin.NumericalFailure as failure:
    print("raised:", failure, "rows:", len(failure.run.history), failure.run.summary["status"])
"""


class Laws(Folder):
    """Faulty laws, and the monitoring of laws by keyword arguments of run and Simulation."""

    def watched(self, fault, options, library=HOSTILE):
        """Runs another interpreter with a law of that fault. Returns its exit code, output and errors."""
        done = subprocess.run([sys.executable, "-c", WATCHED, SMALL_WALL, library, self.path("out"), repr(options)],
                              env=dict(os.environ, QUOIN_HOSTILE=fault, QUOIN_BAD_LAW=fault), capture_output=True, text=True,
                              timeout=120)
        return done.returncode, done.stdout, done.stderr

    def test_isolated_laws_give_the_same_bits(self):
        isolated = quoin.run(SMALL_WALL, isolate_law=True, threads=1, frames=False)
        assert_same_history(isolated.history, quoin.run(SMALL_WALL, threads=1, frames=False).history)
        one, other = quoin.Simulation(SMALL_WALL, isolate_law=True), quoin.Simulation(SMALL_WALL)
        for sim in (one, other):
            sim.run(until="precompression")
            sim.swap_law("mortar", "elastic")
            sim.step(100)
        self.assertEqual(one.hash, other.hash)

    def test_an_isolated_law_that_crashes_or_hangs_is_an_exception(self):
        for fault, options, words in (("crash", dict(isolate_law=True), "(?s)raised: .*hostile_law"),
                                      ("exit", dict(isolate_law=True), "(?s)raised: .*hostile_law"),
                                      ("hang", dict(isolate_law=True, law_seconds=1.0), "(?s)raised: .*hostile_law")):
            with self.subTest(fault):
                code, out, errors = self.watched(fault, options)
                self.assertEqual(code, 0, errors)
                self.assertRegex(out, words)
                self.assertRegex(out, "(?s)rows: [1-9].* failed")
                self.assertTrue(os.path.exists(self.path("out/summary.json")))

    def test_a_law_that_throws_is_an_exception(self):
        code, out, errors = self.watched("throw words", dict(threads=2), os.environ["QUOIN_BAD_LAW_LIBRARY"])
        self.assertEqual(code, 0, errors)
        self.assertRegex(out, '(?s)raised: .*the law \'bad_law\' of .* threw an exception.*"words of a law".* failed')
        self.assertTrue(os.path.exists(self.path("out/summary.json")))

    def test_a_law_that_hangs_ends_the_program_as_the_command_line_does(self):
        code, out, errors = self.watched("hang", dict(law_seconds=1.0))
        self.assertEqual(code, 5, out + errors)
        self.assertRegex(errors, "quoin: the law 'hostile_law' .* has not returned from a batch within 1 s.*law_seconds")
        self.assertIn("what was computed is kept", errors)
        with open(self.path("out/summary.json"), encoding="utf-8") as file:
            self.assertEqual(json.load(file)["status"], "failed")
        with open(self.path("out/history.csv"), encoding="utf-8") as file:
            self.assertGreater(len(file.readlines()), 1)

    def test_what_is_no_time_is_refused(self):
        for given, kind, words in (("soon", TypeError, "law_seconds: a number"), (-1, ValueError, "law_seconds = -1"),
                                   (float("nan"), ValueError, "law_seconds = nan")):
            with self.assertRaisesRegex(kind, words):
                quoin.Simulation(SMALL_WALL, law_seconds=given)

    def test_pieces_are_told_to_be_without_effect(self):
        scene = quoin.Scene.load(SMALL_WALL)
        scene.output.pieces = True
        with self.assertWarnsRegex(UserWarning, "output.pieces: without effect in one process"):
            quoin.Simulation(scene, out=self.path("out"))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            quoin.Simulation(scene)  # writes no frames

    def test_a_run_writes_its_page(self):
        with self.assertRaisesRegex(quoin.BadInput, "report:.*out="):
            quoin.run(SMALL_WALL, report=True)
        try:
            quoin.run(SMALL_WALL, out=self.path("out"), report=True)
        except quoin.BadInput as missing:
            self.assertIn("three.js", str(missing))
            self.skipTest(f"no page: {missing}")
        self.assertEqual(self.command("report", "out").returncode, 0)  # the page again, from the files
        self.assertGreater(os.path.getsize(self.path("out/report.html")), 1e5)


class Starts(Folder):
    """Initial damage, and runs that start from the end of others."""

    def whole(self):
        scene = quoin.Scene.load(SMALL_WALL)
        scene.output = dict(frames=0)
        scene.damage.append(quoin.Damage(to=[0.3, 0.01, 1.0], xi=0.5))
        return scene

    def first(self):
        scene = self.whole()
        del scene.stage[1]
        scene.output.end_state = True
        return scene

    def second(self, **changes):
        scene = self.whole()
        del scene["damage"]
        scene.start = self.path("first")
        for key, value in changes.items():
            scene.joints.mortar[key] = value
        return scene

    def test_a_run_goes_on_with_the_bits_of_one_run(self):
        whole = quoin.run(self.whole(), threads=1)
        driven = whole.history[whole.history["stage"] == 2]
        self.assertGreater(len(driven), 100)
        quoin.run(self.first(), threads=1, out=self.path("first"))
        for scene in (self.second(), self.moved()):
            rest = quoin.run(scene, threads=1)
            assert_same_history(rest.history, driven.astype(rest.history.dtype))  # widths of names differ

    def moved(self):
        """A scene that is written to another folder still finds its start."""
        os.makedirs(self.path("elsewhere/deep"))
        self.second().write(self.path("elsewhere/deep/second.toml"))
        return quoin.Scene.load(self.path("elsewhere/deep/second.toml"))

    def test_what_does_not_fit_is_refused(self):
        with self.assertRaisesRegex(quoin.BadInput, "does not exist"):
            quoin.Simulation(self.second())
        quoin.run(self.first(), threads=1, out=self.path("first"))
        with self.assertRaisesRegex(quoin.BadInput, "set of materials, joints"):
            quoin.Simulation(self.second(cohesion=0.2e6))
        with self.assertRaisesRegex(quoin.BadInput, "give another one"):
            quoin.run(self.second(), out=self.path("first"))
        # The program on the command line counts as another one, since its results may differ.
        self.second().write(self.path("second.toml"))
        done = self.command("run", "second.toml", "--out", "second")
        self.assertEqual(done.returncode, 3)
        self.assertIn("is of another build of quoin", done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
