"""Numbers of the page of a run against its files. The script of the page runs in Node, with stubs for the browser."""
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import quoin
from support import SCENES, SMALL_WALL, SOURCE, block_scene
import numpy as np  # after support, which tells where it is missing
from vtu import Vtu, history_of, times_of

# Colours of host/results/colours.h.
COLD, MIDDLE, WARM = (np.array(c) / 255 for c in ([0x2c, 0x4f, 0xa3], [0xe9, 0xe2, 0xd0], [0xa5, 0x0f, 0x15]))
TITLES = dict(damage="damage of joints [\u2013]", opening="opening of joints [mm]", slip="slip of joints [mm]",
              stress="smallest principal stress [MPa]", displacement="displacement [mm]")


def colours_of(values, most):
    """Returns colours from blue to red; the scale ends at the largest absolute value of the run, and is symmetric about 0."""
    t = np.clip(values / most, -1, 1)[:, None]
    return MIDDLE + np.abs(t) * (np.where(t < 0, COLD, WARM) - MIDDLE)


class Shown:
    """A scene, its files, and the numbers of its page. All gridpoints are vertices of the page."""

    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory(dir=os.environ.get("QUOIN_WORK"))
        cls.addClassCleanup(holder.cleanup)
        out = os.path.join(holder.name, "run")
        quoin.run(cls.scene(), out=out, report=True, threads=1)
        told = subprocess.run([NODE, os.path.join(SOURCE, "tests/python/page.js"), os.path.join(out, "report.html")],
                              capture_output=True, text=True, timeout=120, check=True)
        page = json.loads(told.stdout)
        assert page["ready"] == "yes", page["fault"]
        cls.run_, cls.times, cls.history = page["runs"][0], times_of(out), history_of(out)
        cls.blocks, cls.joints = ([Vtu(f"{out}/{kind}_{k:04}.vtu") for k in range(len(cls.times))]
                                  for kind in ("blocks", "joints"))
        assert cls.run_["vertices"] == len(cls.blocks[0]["position"])

    def test_vertices_stand_where_the_magnification_puts_them(self):
        largest = max(np.abs(b["displacement_m"]).max() for b in self.blocks)
        for look in self.run_["looks"]:
            blocks, times = self.blocks[look["frame"]], look["magnified"]
            expected = blocks["position"] + times * blocks["displacement_m"]
            np.testing.assert_allclose(np.reshape(look["position"], (-1, 3)), expected,
                                       atol=times * largest / 32767 + 1e-6)

    def assert_curve(self, x, y, labels):
        curve = self.run_["curves"][0]
        rows = self.history["stage"] == 2  # the curve is that of the last stage
        np.testing.assert_allclose(curve["xs"], x[rows], rtol=1e-12)
        np.testing.assert_allclose(curve["lines"][0]["values"], y[rows], rtol=1e-12)
        self.assertEqual(curve["labels"], labels)


class Wall(Shown, unittest.TestCase):
    """The small wall, cracked, in small displacements."""

    @staticmethod
    def scene():
        scene = quoin.Scene.load(SMALL_WALL)
        scene.solver = dict(large_motion="never", past_motion_bound="warn")
        scene.stage[1].velocity = 0.2
        scene.output = dict(frames=3, frames_of="last", energy=True)
        return scene

    def values(self, what, k):
        """Returns values at the vertices in frame k, from the files only."""
        blocks, joints = self.blocks[k], self.joints[k]
        if what == "displacement":
            return np.linalg.norm(blocks["displacement_m"].astype(float), axis=1)
        if what == "stress":
            xx, yy, zz, xy, yz, zx = blocks["stress_Pa"].astype(float).T
            tensors = np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]).transpose(2, 0, 1)
            least = np.linalg.eigvalsh(tensors)[:, 0]
            cells = np.repeat(np.arange(len(least)), np.diff(blocks["offsets"], prepend=0))
            total, count = np.zeros((2, self.run_["vertices"]))
            np.add.at(total, blocks["connectivity"], least[cells])
            np.add.at(count, blocks["connectivity"], 1.0)
            return total / count
        given = {"damage": np.maximum(joints["damage_tension"], joints["damage_shear"]), "opening": joints["opening_m"],
                 "slip": np.abs(joints["slip_m"])}[what]
        place = {(b, *x): v for v, (b, x) in enumerate(zip(blocks.block_of_point(), blocks["position"].tolist()))}
        result = np.zeros(self.run_["vertices"])
        beams = set(blocks["block"][blocks["unit"] < 0])
        for value, x, *sides in zip(given, joints["position"].tolist(), joints["block_a"], joints["block_b"]):
            for block in set(sides) - beams:
                v = place[(block, *x)]
                result[v] = max(result[v], value)
        return result

    def test_colours_are_those_of_the_values(self):
        """Checks every vertex, frame and colour. Tolerance 0.012: values have 8 bits, and colours have a range of 0.82."""
        for what in TITLES:
            values = [self.values(what, k) for k in range(len(self.times))]
            low, high = min(0.0, min(v.min() for v in values)), max(0.0, max(v.max() for v in values))
            if what == "damage":
                low, high = 0.0, 1.0
            most = max(-low, high)
            self.assertGreater(most, 0.0, what)
            looks = [look for look in self.run_["looks"] if look["what"] == what]
            self.assertEqual(len(looks), 2 * len(self.times))
            for look in looks:
                expected = colours_of(values[look["frame"]], most)
                np.testing.assert_allclose(np.reshape(look["colour"], (-1, 3)), expected, atol=0.012,
                                           err_msg=f"{what}, frame {look['frame']}")
                self.assertEqual(look["quantity"], TITLES[what])
                np.testing.assert_allclose(look["range"], (low, high), rtol=1e-4)
            # The largest value has the last colour, half of it the colour in the middle.
            last = np.reshape(looks[len(self.times) - 1]["colour"], (-1, 3))
            v = np.abs(values[-1]).argmax()
            end = WARM if values[-1][v] > 0 else COLD
            share = abs(values[-1][v]) / most
            np.testing.assert_allclose(last[v], MIDDLE + min(1.0, share) * (end - MIDDLE), atol=0.012, err_msg=what)

    def test_robust_range_is_that_of_98_percent(self):
        """The range of the scale is that of the values other than 0 in the frame with the largest ones, rounded up to two
        digits. A single point does not determine it."""
        for what in ("opening", "slip", "displacement"):
            moments = [np.sort(v[v > 0]) for v in (self.values(what, k) for k in range(len(self.times))) if np.any(v > 0)]
            low, high = self.run_["robust"][what]
            self.assertEqual(low, 0.0)
            for values in moments:
                self.assertGreater((values <= high).mean(), 0.95)  # 98 % of about 20 values is rounded to a number of values
            bound = max(values[int(0.98 * (len(values) - 1))] for values in moments)
            self.assertLess(high, 1.12 * bound, what)  # two digits: at most 10 %, plus rounding to 16 bits
            self.assertGreater(high, 0.98 * bound, what)
        low, high = self.run_["robust"]["stress"]
        self.assertLess(low, 0.0)  # compression
        self.assertLess(abs(high), 0.2 * -low)
        self.assertEqual(self.run_["robust"]["damage"], [0, 1])

    def test_cracks_are_drawn_along_the_rims_of_joints(self):
        """Cracks are edges of a single quad whose ends have both cracked, in the colour of the legend."""
        for look in self.run_["looks"]:
            if look["what"] != "damage":
                continue
            joints, times = self.joints[look["frame"]], look["magnified"]
            crack, edges = joints["crack"], {}
            for quad in joints["connectivity"].reshape(-1, 4):
                for a, b in zip(quad, np.roll(quad, -1)):
                    edges[min(a, b), max(a, b)] = edges.get((min(a, b), max(a, b)), 0) + 1
            legend = [None] + [colour for text, colour in look["legend"]]
            self.assertEqual(len(legend), 6)
            place = joints["position"] + times * joints["displacement_m"].astype(float)
            expected = [(place[[a, b]].ravel(), legend[max(crack[a], crack[b])])
                        for (a, b), count in edges.items() if count == 1 and crack[a] and crack[b]]
            self.assertEqual(look["cracked"], len(expected))
            rim, paint = np.reshape(look["rim"], (-1, 6)), np.reshape(look["rim_colour"], (-1, 6))
            for line, colour in expected:
                off = np.minimum(abs(rim - line).max(axis=1), abs(rim[:, [3, 4, 5, 0, 1, 2]] - line).max(axis=1))
                k = off.argmin()
                self.assertLess(off[k], times * 1e-7 + 1e-6)  # rounding to 16 bits of half a millimetre, and to 24 bits
                for end in (paint[k, :3], paint[k, 3:]):
                    self.assertEqual("#" + "".join(f"{round(255 * c):02x}" for c in end), colour)
        self.assertGreater(look["cracked"], 10)

    def test_curves_are_drawn_from_the_history(self):
        h, (curve, energies) = self.history, self.run_["curves"]
        np.testing.assert_array_equal(energies["xs"], h["time_s"])
        columns = dict(kinetic="kinetic_energy_J", strain="strain_energy_J", joints="contact_energy_J",
                       tension="dissipated_tension_J", cohesion="dissipated_cohesion_J", friction="dissipated_friction_J",
                       crushing="dissipated_crushing_J", damping="damping_work_J")
        columns["external work"] = "external_work_J"
        # A quantity that is always 0 has no line.
        self.assertEqual([line["name"] for line in energies["lines"]], [name for name, c in columns.items() if np.any(h[c] != 0)])
        self.assertGreater(len(energies["lines"]), 5)
        for line in energies["lines"]:
            np.testing.assert_array_equal(line["values"], h[columns[line["name"]]], line["name"])
        self.assert_curve(1e3 * h["displacement_m"], 1e-3 * h["horizontal_force_N"],
                          ["horizontal displacement of top beam [mm]", "horizontal force [kN]"])
        # Drawing area: from 62 pixels at the left to 14 at the right, from 42 pixels at the bottom to the top, including 0.
        for drawn in (curve, energies):
            xs = np.array(drawn["xs"])
            all_values = np.concatenate([line["values"] for line in drawn["lines"]])
            (left, right), (low, high) = ((min(0.0, v.min()), max(0.0, v.max())) for v in (xs, all_values))
            for line, stroke in zip(drawn["lines"], drawn["strokes"]):
                path = np.array(stroke)
                x = 62 + (xs - left) / (right - left) * (drawn["width"] - 62 - 14)
                np.testing.assert_allclose(path[:, 0], x, atol=0.006)
                y = 193 - (np.array(line["values"]) - low) / (high - low) * (193 - drawn["top"])
                np.testing.assert_allclose(path[:, 1], y, atol=0.006)

    def test_dots_stand_at_the_moment_of_the_frame(self):
        h, (curve, energies) = self.history, self.run_["curves"]
        paths = [np.array(path) for path in curve["strokes"]]
        before = np.count_nonzero(h["stage"] == 1)  # rows that are not in this curve
        for look in self.run_["looks"]:
            row = np.abs(h["time_s"] - self.times[look["frame"]]).argmin() - before
            np.testing.assert_allclose(look["dots"][0][0], paths[0][min(max(row, 0), len(paths[0]) - 1)], atol=4)
            self.assertEqual(len(look["dots"][1]), len(energies["lines"]))
        last = self.run_["looks"][-1]
        np.testing.assert_allclose(last["dots"][0][0], paths[0][-1], atol=0.006)
        np.testing.assert_allclose(last["dots"][1], [path[-1] for path in energies["strokes"]], atol=0.006)

    def test_texts_are_those_of_the_run(self):
        h, texts = self.history, self.run_["texts"]
        row = np.abs(h["horizontal_force_N"]).argmax()
        peak = f"{abs(h['horizontal_force_N'][row]) / 1e3:.2f} kN at {1e3 * abs(h['displacement_m'][row]):.3f} mm"
        self.assertEqual(texts[texts.index("peak") + 1], peak)
        blocks = len(np.unique(self.blocks[0]["block"][self.blocks[0]["unit"] >= 0]))  # without the beams
        zones, points = (self.blocks[0]["types"] == 10).sum(), len(self.joints[0]["position"])
        self.assertEqual(texts[texts.index("model") + 1], f"{blocks} blocks, {zones} zones, {points} contact points")
        self.assertTrue(texts[texts.index("run") + 1].startswith(f"{h['step'][-1]:.0f} steps of "), texts)


class Arch(Shown, unittest.TestCase):
    """Blocks of any shape at the beginning of their fall."""

    @staticmethod
    def scene():
        scene = quoin.Scene.load(SCENES + "/arch.toml")
        scene.stage[1].collapse = dict(rate=0.2, displacement=0.1)
        scene.output.frames, scene.output.frames_of = 2, "last"
        return scene

    def test_curve_is_that_of_the_multiplier(self):
        h = self.history
        self.assert_curve(1e3 * h["largest_displacement_m"], h["multiplier"],
                          ["largest displacement [mm]", "multiplier of the weight"])

    def test_colours_of_displacement_are_those_of_the_values(self):
        most = max(np.linalg.norm(b["displacement_m"].astype(float), axis=1).max() for b in self.blocks)
        self.assertGreater(most, 0.1)
        for look in (look for look in self.run_["looks"] if look["what"] == "displacement"):
            moved = np.linalg.norm(self.blocks[look["frame"]]["displacement_m"].astype(float), axis=1)
            np.testing.assert_allclose(np.reshape(look["colour"], (-1, 3)), colours_of(moved, most), atol=0.001)

    def test_cracks_are_drawn_where_their_points_stand(self):
        drawn = 0
        for look in (look for look in self.run_["looks"] if look["magnified"] == 1 and look["what"] == "damage"):
            joints, legend = self.joints[look["frame"]], [colour for text, colour in look["legend"]]
            points, paint = (np.reshape(look[name], (-1, 3)) for name in ("points", "point_colour"))
            expected = []
            for place, gap, crack in zip(joints["position"], joints["gap_m"], joints["crack"]):
                if crack == 0:
                    continue
                for side in (place, place + gap) if gap.any() else (place,):  # both sides, where blocks have separated
                    k = np.abs(points - side).max(axis=1).argmin()
                    self.assertLess(np.abs(points[k] - side).max(), 1e-5)
                    expected.append(legend[crack - 1])
                drawn += 1
            colours = ["#" + "".join(f"{round(255 * c):02x}" for c in colour) for colour in paint]
            self.assertEqual(sorted(colours), sorted(expected))
        self.assertGreater(drawn, 4)  # four hinges


class Loaded(Shown, unittest.TestCase):
    """A cube on another one, with a load at a corner."""

    @staticmethod
    def scene():
        scene = block_scene(solver=dict(damping="local", local_damping=0.8), output=dict(frames=2, plots=False), stage=[
            quoin.Stage(name="press", gravity=[0, -9.81, 0], duration=0.2, ramp_time=0.05,
                        force=[dict(block="cube", point=[1, 2, 0], force=[0, -2e4, 0])])])
        scene.block[1].box = dict(lower=[0, 1, 0], size=[1, 1, 1])
        return scene

    def test_a_load_goes_with_its_block(self):
        for look in self.run_["looks"]:
            blocks = self.blocks[look["frame"]]
            corner = np.linalg.norm(blocks["position"] - np.array([1, 2, 0]), axis=1).argmin()
            tip = np.array([1, 2, 0]) + look["magnified"] * blocks["displacement_m"][corner]
            self.assertEqual(len(look["loads"]), 2)  # shaft and head
            np.testing.assert_allclose(look["loads"][1], tip, atol=1e-4)
        moved = np.abs(self.blocks[-1]["displacement_m"]).max()
        self.assertGreater(50 * moved, 1e-3, "beside the 1e-4 above")


NODE = shutil.which("node") or shutil.which("nodejs")
if __name__ == "__main__":
    if not NODE or not os.path.exists("/usr/share/javascript/three/three.min.js"):
        print("skipped: Node (nodejs) or three.js (libjs-three) is not installed")
        sys.exit(77)
    unittest.main(verbosity=2)
