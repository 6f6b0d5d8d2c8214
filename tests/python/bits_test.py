"""Runs from Python and from the command line are bitwise identical."""
import csv
import json
import math
import unittest

import quoin
from support import SCENES, SMALL_WALL, Folder, assert_same_history, block_scene


def rows_of(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


class Bits(Folder):
    def assert_same_history(self, history, path):
        rows = rows_of(path)
        self.assertEqual(list(history.dtype.names), list(rows[0]))
        self.assertEqual(len(history), len(rows))
        for name in history.dtype.names:
            for got, text in zip(history[name].tolist(), (row[name] for row in rows)):
                if isinstance(got, str):
                    self.assertEqual(got, text)
                elif text == "":
                    self.assertTrue(math.isnan(got), name)
                else:
                    self.assertEqual(got, type(got)(text), name)  # shortest decimals convert back to the same double

    def test_a_wall_has_the_history_and_summary_of_the_command_line(self):
        done = self.command("run", SMALL_WALL, "--out", "cli", "--set", "output.plots=false")
        self.assertEqual(done.returncode, 0, done.stderr)
        run = quoin.run(SMALL_WALL, threads=2)
        self.assert_same_history(run.history, self.path("cli/history.csv"))
        with open(self.path("cli/summary.json"), encoding="utf-8") as file:
            expected = json.load(file)
        volatile = {"set", "wall_clock_s", "threads", "settings", "scene", "provenance"}
        for key in set(expected) - volatile:
            self.assertEqual(run.summary[key], expected[key], key)
        self.assertEqual(len(run.frames), 4)  # output.frames = 3, plus the start of the stage

    def test_blocks_of_any_shape_too(self):
        arch = quoin.Scene.load(SCENES + "/arch.toml")
        arch.stage[1].collapse.rate = 0.2  # a second of work
        arch.write(self.path("arch.toml"))
        done = self.command("run", "arch.toml", "--out", "cli", "--set", "output.plots=false")
        self.assertEqual(done.returncode, 0, done.stderr)
        run = quoin.run(arch)
        self.assert_same_history(run.history, self.path("cli/history.csv"))
        with open(self.path("cli/summary.json"), encoding="utf-8") as file:
            self.assertEqual(run.summary["collapse_multiplier"], json.load(file)["collapse_multiplier"])

    def test_the_files_of_a_run_from_python_are_those_of_the_command_line(self):
        self.assertEqual(self.command("run", SMALL_WALL, "--out", "cli", "--set", "output.plots=false").returncode, 0)
        quoin.run(SMALL_WALL, out=self.path("python"))
        for name in ("history.csv", "blocks_0003.vtu", "joints_0003.vtu", "blocks.pvd"):
            with open(self.path("cli/" + name), "rb") as a, open(self.path("python/" + name), "rb") as b:
                self.assertEqual(a.read(), b.read(), name)

    def test_steps_one_by_one_are_the_run(self):
        whole, steps, chunks = (quoin.Simulation(SMALL_WALL, threads=1) for _ in range(3))
        self.assertFalse(whole.run())
        while steps.step():
            pass
        while chunks.step(37):
            pass
        self.assertGreater(whole.steps, 500)
        for other in (steps, chunks):
            self.assertEqual(other.hash, whole.hash)
            assert_same_history(other.history, whole.history)

    def test_pandas_has_the_columns(self):
        run = quoin.run(SMALL_WALL, frames=False)
        try:
            frame = run.dataframe
        except ImportError:
            self.skipTest("pandas is not installed (python3-pandas)")
        self.assertEqual(frame["horizontal_force_N"].max(), run.history["horizontal_force_N"].max())

    def test_free_fall(self):
        # Central differences are exact under constant acceleration: y = -g t (t - dt) / 2, since v = 0 half a step before.
        scene = block_scene(stage=[quoin.Stage(duration=0.2, gravity=[0, -9.81, 0], ramp_time=0.0)])
        scene.output.monitor = "cube"
        sim = quoin.Simulation(scene)
        sim.run(until=0.1)
        self.assertAlmostEqual(sim.time, 0.1, delta=sim.time_step)
        fallen, t = -sim.displacement("cube")[0, 1], sim.time
        self.assertAlmostEqual(fallen, 9.81 * t * t / 2, delta=9.81 * t * sim.time_step)  # within a step


if __name__ == "__main__":
    unittest.main(verbosity=2)
