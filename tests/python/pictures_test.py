"""quoin.open, and the pictures of runs."""
import itertools
import os
import sys
import unittest
from unittest import mock

import quoin
from support import SMALL_WALL, Folder, block_scene
import numpy as np  # after support, which tells where it is missing

try:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.collections
    from matplotlib import pyplot
except ImportError:
    matplotlib = None


def small_wall():
    scene = quoin.Scene.load(SMALL_WALL)
    scene.output = dict(frames=2, frames_of="last", energy=True, plots=False)
    return scene


def resting_cube():
    """Returns a cube of 1 m and 1000 kg that comes to rest on another one, which is fixed."""
    scene = block_scene(stage=[quoin.Stage(name="weight", gravity=[0, -9.81, 0], ramp_time=0.05, duration=0.4)],
                        output=dict(frames=1, plots=False), solver=dict(damping="local", local_damping=0.8))
    scene.block[1].box = dict(lower=[0, 1, 0], size=[1, 1, 1])
    return scene


def crossing(figure):
    """Returns texts of a picture that overlap each other or extend beyond it."""
    figure.canvas.draw()
    renderer, found = figure.canvas.get_renderer(), []
    texts = [t for t in figure.findobj(matplotlib.text.Text) if t.get_text().strip() and t.get_visible()]
    boxes = [(t.get_text(), t.get_window_extent(renderer)) for t in texts]
    # Ticks beyond the ends of an axis exist but are not drawn.
    drawn = [(name, box) for name, box in boxes if any(np.allclose(box.bounds, b.bounds) for b in shown_boxes(figure, renderer))]
    paper = figure.bbox
    for name, box in drawn:
        if box.x0 < paper.x0 - 1 or box.x1 > paper.x1 + 1 or box.y0 < paper.y0 - 1 or box.y1 > paper.y1 + 1:
            found.append(f"{name!r} leaves the picture")
    for (a, first), (b, second) in itertools.combinations(drawn, 2):
        wide = min(first.x1, second.x1) - max(first.x0, second.x0)
        tall = min(first.y1, second.y1) - max(first.y0, second.y0)
        if wide > 1 and tall > 1:
            found.append(f"{a!r} crosses {b!r}")
    return found


def shown_boxes(figure, renderer):
    ticks = set()
    for axes in figure.axes:
        for axis, (low, high) in ((axes.xaxis, sorted(axes.get_xlim())), (axes.yaxis, sorted(axes.get_ylim()))):
            for tick in axis.get_major_ticks() + axis.get_minor_ticks():
                inside = low - 1e-9 * (high - low) <= tick.get_loc() <= high + 1e-9 * (high - low)
                for label in (tick.label1, tick.label2):
                    ticks.add(label)
                    if inside and label.get_visible() and axes.axison:
                        yield label.get_window_extent(renderer)
    for text in figure.findobj(matplotlib.text.Text):
        if text not in ticks and text.get_visible():
            yield text.get_window_extent(renderer)


def drawn_cracks(figure):
    """Returns the lines of cracks of a picture by the label of their kind."""
    lines = [c for c in figure.axes[0].collections if isinstance(c, matplotlib.collections.LineCollection)]
    return {c.get_label(): c.get_segments() for c in lines}


class Opened(Folder):
    def test_arrays_are_those_of_the_run(self):
        out = self.path("wall")
        run = quoin.run(small_wall(), out=out, threads=1)
        read = quoin.open(out)
        self.assertEqual(read.history.dtype.names, run.history.dtype.names)
        for name in run.history.dtype.names:
            np.testing.assert_array_equal(read.history[name], run.history[name], err_msg=name)
        self.assertEqual(read.peak, run.peak)
        self.assertEqual([f.stage for f in read.frames], [2, 2, 2])
        for moment, frame in zip(read.frames, run.frames):
            self.assertAlmostEqual(moment.time, frame.time, delta=1e-8 * frame.time)  # nine digits in the collection
            np.testing.assert_allclose(moment.blocks["displacement_m"], frame.displacement, atol=1e-7 * 5e-4 + 1e-12)
            np.testing.assert_allclose(moment.joints["traction_Pa"], frame.joints["traction"], rtol=1e-6, atol=1e-3)
        self.assertEqual([quoin.unit(n) for n in ("horizontal_force_N", "time_s", "opening_m", "block", "area_m2",
                                                        "ground_vx_m_s", "ground_ax_m_s2")],
                         ["N", "s", "m", "", "m2", "m/s", "m/s2"])

    def test_compressed_frames_are_the_same(self):
        for name, options in (("plain", []), ("packed", ["--compressed"])):
            done = self.command("run", SMALL_WALL, "--out", name, "--set", "output.frames=1", "--set", "output.plots=false",
                                *options)
            self.assertEqual(done.returncode, 0, done.stderr)
        plain, packed = (quoin.open(self.path(name)).frames[-1] for name in ("plain", "packed"))
        for kind in ("blocks", "joints"):
            for name, values in getattr(plain, kind).items():
                np.testing.assert_array_equal(getattr(packed, kind)[name], values, err_msg=name)

    def test_support_carries_the_weight(self):
        quoin.run(resting_cube(), out=self.path("cube"), threads=1)
        moment = quoin.open(self.path("cube")).frames[-1]
        # The base carries 1000 kg 9.81 m/s2. Tolerance 1 %, for motion after 0.4 s.
        np.testing.assert_allclose(moment.force_on(0), [0, -9810, 0], atol=98)
        np.testing.assert_allclose(moment.force_on(1), [0, 9810, 0], atol=98)
        with self.assertRaisesRegex(IndexError, "block: 99 is not among the blocks, 0 to 1"):
            moment.force_on(99)

    def test_faults_are_told(self):
        with self.assertRaisesRegex(quoin.BadInput, "summary.json: not found; give the folder of a run that has ended"):
            quoin.open(self.path("nowhere"))
        quoin.run(small_wall(), out=self.path("wall"), threads=1)
        with open(self.path("wall/blocks_0001.vtu"), "r+b") as file:
            file.truncate(4000)
        with self.assertRaisesRegex(quoin.BadInput, "blocks_0001.vtu: is damaged or cut off"):
            quoin.open(self.path("wall")).frames[1].blocks["displacement_m"]


@unittest.skipUnless(matplotlib, "matplotlib is not installed (python3-matplotlib)")
class Drawn(Folder):
    def assert_fine(self, figure, *words):
        self.assertEqual(crossing(figure), [])
        texts = " ".join(t.get_text() for t in figure.findobj(matplotlib.text.Text))
        for word in words:
            self.assertIn(word, texts)

    def test_a_wall_is_drawn(self):
        quoin.run(small_wall(), out=self.path("wall"), threads=1)
        run = quoin.open(self.path("wall"))
        self.assert_fine(run.plot(file=self.path("curve.png")), "horizontal force [kN]", "displacement of top beam [mm]", " kN at ")
        self.assert_fine(run.plot_cracks(file=self.path("cracks.svg")), "sliding begun", "times larger", "x [m]", "stage 2")
        self.assert_fine(run.plot_histories(), "time [s]", "force [kN]", "energy [J]")
        self.assert_fine(run.plot_field("stress"), "smallest principal stress [MPa]")
        self.assert_fine(run.plot_field(), "displacement [mm]")
        for name in ("curve.png", "cracks.svg"):
            self.assertGreater(os.path.getsize(self.path(name)), 5000)
        with self.assertRaisesRegex(ValueError, "displacement or stress"):
            run.plot_field("colour")

    def test_a_run_in_memory_is_drawn(self):
        run = quoin.run(small_wall(), threads=1)
        self.assert_fine(run.plot(), "horizontal force [kN]")
        with self.assertRaisesRegex(quoin.BadInput, "out="):
            run.plot_cracks()

    def test_blocks_that_stand_are_drawn(self):
        quoin.run(resting_cube(), out=self.path("cube"), threads=1)
        run = quoin.open(self.path("cube"))
        for figure in (run.plot(), run.plot_cracks(), run.plot_field(), run.plot_histories()):
            self.assert_fine(figure)

    def test_an_earthquake_is_drawn_against_the_ground(self):
        scene = resting_cube()
        scene.stage[0].duration = 0.1
        scene.solver = dict(damping="viscous", mass_damping=2.0)
        scene.stage.append(quoin.Stage(name="shake", duration=0.05))
        scene.output.monitor = "cube"
        for axis, direction in (("z", [0, 0, 1]), ("y", [0, 1, 0]), ("(0.6, 0, 0.8)", [0.6, 0, 0.8])):
            with self.subTest(direction=direction):
                scene.stage[1].ground_motion = dict(direction=direction, time=[0.0, 0.025, 0.05], acceleration=[0.0, 2.0, 0.0])
                run = quoin.run(scene, threads=1)
                self.assertEqual(run.summary["response"]["axis"], axis)  # as curve.png
                figure = run.plot(file=self.path("curve.svg"))
                self.assert_fine(figure, f"relative displacement along {axis} of cube [mm]", "time [s]")
                rows = run.history["stage"] == 2
                moved = sum(d * run.history[f"monitor_relative_d{c}_m"][rows] for d, c in zip(direction, "xyz"))
                np.testing.assert_allclose(figure.axes[0].lines[0].get_ydata(), 1e3 * moved, rtol=1e-12)
                self.assertGreater(os.path.getsize(self.path("curve.svg")), 5000)

    def test_cracks_of_a_wall_are_those_of_cracks_png(self):
        """The run writes the data of cracks.png, a closed line for each piece of a joint."""
        changes = ("wall.courses=3", "wall.units_per_course=3", "joints.mortar.cohesion=1e6", "output.frames=1",
                   "joints.mortar.tensile_strength=0.1e6")
        done = self.command("run", SMALL_WALL, "--out", "out", *(word for change in changes for word in ("--set", change)))
        self.assertEqual(done.returncode, 0, done.stderr)
        pieces = drawn_cracks(quoin.open(self.path("out")).plot_cracks())
        for kind, (label, _) in list(enumerate(quoin._quoin.colours()["cracks"]))[1:]:
            with open(self.path(f"out/plots/joints_{kind}.dat"), encoding="utf-8") as file:
                self.assertEqual(len(pieces[label]), file.read().count("\n\n"), label)
        self.assertGreater(len(pieces["opening begun"]), 5)

    def test_a_joint_of_blocks_is_a_line(self):
        scene = resting_cube()
        scene.joints["dry"].friction_angle = 12.0
        scene.solver.kernels = "general"  # else cubes that conform are on the lattice
        scene.stage.append(quoin.Stage(name="slope", gravity=[4.0, -9.81, 0], ramp_time=0.05, duration=0.2))
        quoin.run(scene, out=self.path("cube"), threads=1)
        lines = drawn_cracks(quoin.open(self.path("cube")).plot_cracks(magnified=1.0))
        self.assertEqual([label for label in lines if len(lines[label])], ["slipped"])
        self.assertLessEqual(len(lines["slipped"]), 2)  # one, or one for each of two blocks that have parted
        for line in lines["slipped"]:
            np.testing.assert_allclose(np.sort(line[:, 0]), [0.0, 1.0], atol=0.05)
            np.testing.assert_allclose(line[:, 1], 1.0, atol=1e-3)

    def test_a_block_behind_others_is_hidden(self):
        scene = resting_cube()
        scene.block.append(quoin.Block(name="back", material="stone", fixed=True,
                                       box=dict(lower=[0, 1.25, -4], size=[1, 0.5, 0.5])))
        quoin.run(scene, out=self.path("cube"), threads=1)
        figure = quoin.open(self.path("cube")).plot_cracks()
        figure.canvas.draw()
        picture, axes = np.asarray(figure.canvas.buffer_rgba()), figure.axes[0]
        columns, rows = axes.transData.transform([(0.5, 1.1), (0.5, 1.9)]).astype(int).T
        strip = picture[picture.shape[0] - rows[1]:picture.shape[0] - rows[0], columns[0]]
        self.assertGreater(len(strip), 50)
        self.assertEqual(len(np.unique(strip, axis=0)), 1)  # the colour of the face alone

    def test_a_label_that_crosses_another_is_seen(self):
        figure = pyplot.figure()
        figure.text(0.5, 0.5, "first")
        figure.text(0.52, 0.5, "second")
        self.assertEqual(len(crossing(figure)), 1)

    def test_without_matplotlib_the_reason_is_told(self):
        run = quoin.run(small_wall(), threads=1)
        with mock.patch.dict(sys.modules, {"matplotlib": None}):
            with self.assertRaisesRegex(quoin.Error, "apt-get install python3-matplotlib"):
                run.plot()


if __name__ == "__main__":
    unittest.main(verbosity=2)
