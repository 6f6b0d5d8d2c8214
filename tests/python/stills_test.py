"""Pictures of gnuplot for the command line: texts do not overlap or extend beyond the picture, colour bars have numbers."""
import itertools
import os
import re
import sys
import unittest
import xml.etree.ElementTree as ElementTree

import quoin
from support import SCENES, SMALL_WALL, Folder, block_scene
import numpy as np  # after support, which tells where it is missing

try:
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath
except ImportError:
    print("skipped: matplotlib, whose font measures the texts, is not installed (python3-matplotlib)")
    sys.exit(77)

SVG = "{http://www.w3.org/2000/svg}"
FONT = FontProperties(family="DejaVu Sans")  # Sans of Debian
LONG = "A title that is far longer than any picture is wide, as titles of generated scenes may be, " * 3


def texts_of(path):
    """Returns width and height of a picture, and its texts (text, left, top, right, bottom), in pixels."""
    root = ElementTree.parse(path).getroot()
    wide, tall = (float(v) for v in root.get("viewBox").split()[2:])
    found = []
    for group in root.iter(SVG + "g"):
        for text in group.findall(SVG + "text"):
            words = "".join(text.itertext()).strip()
            place = re.match(r"translate\(([\d.-]+),([\d.-]+)\)(?: rotate\(([\d.-]+)\))?", group.get("transform", ""))
            if not words or not place:
                continue
            x, y, turned = (float(v or 0) for v in place.groups())
            box = TextPath((0, 0), words, size=float(group.get("font-size")), prop=FONT).get_extents()
            shift = {"middle": box.width / 2, "end": box.width}.get(group.get("text-anchor"), 0.0)
            corners = np.array([[box.x0 - shift, -box.y0], [box.x1 - shift, -box.y1]])
            angle = np.radians(turned)
            turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            corners = corners @ turn.T + [x, y]
            found.append((words, *corners.min(axis=0), *corners.max(axis=0)))
    return wide, tall, found


def crossing(path):
    """Returns texts that overlap by more than a pixel or extend beyond the picture."""
    wide, tall, texts = texts_of(path)
    found = [f"{words!r} leaves the picture" for words, left, top, right, bottom in texts
             if left < -1 or top < -1 or right > wide + 1 or bottom > tall + 1]
    # A text with a background is written twice, before the background and on it.
    for a, b in itertools.combinations(dict.fromkeys(texts), 2):
        if min(a[3], b[3]) - max(a[1], b[1]) > 1 and min(a[4], b[4]) - max(a[2], b[2]) > 1:
            found.append(f"{a[0]!r} crosses {b[0]!r}")
    return found


class Stills(Folder):
    def run_scene(self, name, scene, *options):
        if isinstance(scene, quoin.Scene):
            scene.write(self.path(name + ".toml"))
            scene = self.path(name + ".toml")
        done = self.command("run", scene, "--out", name, "--svg", "--threads", "1", *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def assert_fine(self, name, pictures):
        """Checks that each picture exists and has no faults. Returns the words of all."""
        words = []
        for picture in pictures:
            path = self.path(f"{name}/{picture}.svg")
            self.assertTrue(os.path.exists(path), path)
            self.assertEqual(crossing(path), [], path)
            words += [t[0] for t in texts_of(path)[2]]
        self.assertGreater(len(words), 3)
        return words

    def test_a_text_that_crosses_another_is_found(self):
        with open(self.path("planted.svg"), "w", encoding="utf-8") as file:
            file.write('<svg viewBox="0 0 200 100" xmlns="http://www.w3.org/2000/svg">' + "".join(
                f'<g transform="translate({x},{y}){turned}" font-size="20" text-anchor="{anchor}"><text>{words}</text></g>'
                for x, y, turned, anchor, words in ((10, 50, "", "start", "first"), (40, 50, "", "start", "second"),
                                                    (195, 80, "", "start", "outside"), (150, 95, " rotate(270)", "start", "up"),
                                                    (150, 85, "", "middle", "over"))) + "</svg>")
        self.assertEqual(crossing(self.path("planted.svg")),
                         ["'outside' leaves the picture", "'first' crosses 'second'", "'up' crosses 'over'"])

    def test_a_wall(self):
        self.run_scene("wall", SMALL_WALL, "--set", "output.frames=0", "--set", "output.energy=true", "--histories")
        words = self.assert_fine("wall", ("curve", "cracks", "histories"))
        for one in ("small wall", "small wall: motion of top beam", "displacement (mm)", "energy (J)", "external work", "along x", "horizontal force (kN)", "horizontal displacement of the top beam (mm)", "mean vertical stress (MPa)",
                    "stage 2 shear, 0.0547 s; displacements drawn 20 times larger", "crushed"):
            self.assertIn(one, words)

    def test_a_wall_with_a_long_title_and_many_warnings(self):
        self.run_scene("wall", SMALL_WALL, "--law", "elastic", "--set", "joints.mortar.normal_stiffness=5e7", "--set",
                       "joints.mortar.shear_stiffness=2e7", "--set", "output.frames=0", "--set", f"title={LONG}")
        words = self.assert_fine("wall", ("curve", "cracks"))
        self.assertTrue(any(w.startswith("Warnings, see summary.json: ") for w in words), words)
        self.assertTrue(any(w.endswith("...") and LONG.startswith(w[:-3]) for w in words), words)

    def test_a_wall_in_cycles(self):
        with open(SMALL_WALL, encoding="utf-8") as file:
            text = file.read()
        with open(self.path("cycle.toml"), "w", encoding="utf-8") as file:
            file.write(text.replace("[output]", '[[stage]]\nname = "back"\nkind = "shear"\nvelocity = -0.05\ndisplacement = 0.0015\n'
                                                "[output]"))
        self.run_scene("cycle", self.path("cycle.toml"), "--set", "output.frames=0")
        self.assert_fine("cycle", ("curve", "cracks"))

    def test_a_collapse(self):
        self.run_scene("arch", os.path.join(SCENES, "arch.toml"), "--set", "output.frames=0", "--histories")
        words = self.assert_fine("arch", ("curve", "cracks", "mechanism", "histories"))
        for one in ("multiplier of the weight", "displacement (mm)", "x (m)", "open crack"):
            self.assertIn(one, words)

    def test_blocks_at_rest(self):
        scene = block_scene(title=LONG, stage=[quoin.Stage(name="weight", gravity=[0, -9.81, 0], ramp_time=0.05, duration=0.2)])
        scene.block[1].box = dict(lower=[0, 1, 0], size=[0.4, 0.4, 0.4])
        scene.block.append(quoin.Block(name="behind", material="stone", box=dict(lower=[0, 1, 0.6], size=[0.4, 0.4, 0.4])))  # in no plane
        self.run_scene("cube", scene)
        words = self.assert_fine("cube", ("curve", "cracks", "mechanism"))
        self.assertIn("largest displacement of a block (mm)", words)
        self.assertTrue(any(re.fullmatch(r"[\d.]+ m", w) for w in words), "a scale bar")

    def test_joints_are_drawn_where_they_are_seen(self):
        """Two cubes slide on a larger one: the front and the right edge of each joint are visible, but no edge behind a cube."""
        scene = block_scene(title="sliding", stage=[quoin.Stage(name="tilt", gravity=[9.81, -9.81, 0], duration=0.1)])
        scene.block[0].box = dict(lower=[0, 0, 0], size=[1, 1, 1])
        scene.block[1].box = dict(lower=[0.1, 1, 0.1], size=[0.2, 0.2, 0.2])
        scene.block.append(quoin.Block(name="front", material="stone", box=dict(lower=[0.1, 1, 0.6], size=[0.2, 0.2, 0.2])))
        self.run_scene("cube", scene)
        self.assert_fine("cube", ("cracks",))
        with open(self.path("cube/plots/cracks.gp"), encoding="utf-8") as file:
            lines = re.findall(r"polygon from (\S+) to (\S+) to \S+ fillstyle empty border", file.read())
        # 0.2 m along x and along z, seen from (0.55, 0.45, 1).
        towards = np.array([0.55, 0.45, 1.0]) / np.linalg.norm([0.55, 0.45, 1.0])
        right = np.cross([0, 1, 0], towards)
        right /= np.linalg.norm(right)
        up = np.cross(towards, right)
        sides = sorted(0.2 * np.hypot(right[k], up[k]) for k in (0, 2))
        lengths = sorted(np.linalg.norm(np.subtract(*(np.array(p.split(","), float) for p in line))) for line in lines)
        np.testing.assert_allclose(lengths, np.repeat(sides, 2), rtol=0.01)

    def test_ground_that_moves_along_z(self):
        """A cube moves with a rough base: the picture has its displacement relative to the ground, not the 20 mm of both."""
        scene = block_scene(title="shaken")
        scene.solver = dict(damping="viscous", mass_damping=2.0)
        scene.block[1].box = dict(lower=[0, 1, 0], size=[1, 1, 1])
        scene.stage = [quoin.Stage(name="weight", gravity=[0, -9.81, 0], ramp_time=0.05, duration=0.2),
                       quoin.Stage(name="shake", duration=0.4, ground_motion=dict(
                           direction=[0, 0, 1], time=[0.0, 0.1, 0.2, 0.4], acceleration=[0.0, 1.0, -1.0, 0.0]))]
        scene.output = dict(frames=0, monitor="cube")
        scene.monitor = [quoin.Monitor(name="foot", block="base"), quoin.Monitor(name="head", block="cube", below="foot")]
        done = self.run_scene("cube", scene, "--histories")
        words = self.assert_fine("cube", ("curve", "cracks", "mechanism", "histories", "base_shear", "drifts"))
        for one in ("base shear along z (kN)", "displacement of cube along z, relative to the ground (mm)", "along z",
                    "least and largest drift between monitors (%)", "height (m)",
                    "shaken: motion of cube, relative to the ground", "displacement relative to the ground (mm)", "displacement along z (mm)", "of cube, relative to the ground"):
            self.assertIn(one, words)
        _, _, texts = texts_of(self.path("cube/mechanism.svg"))
        bar = max(left for word, left, *_ in texts if word == "displacement relative to the ground (mm)")
        numbers = [float(word) for word, left, *_ in texts if bar - 120 < left < bar and re.fullmatch(r"[-\d.e+]+", word)]
        self.assertGreater(len(numbers), 2, "the colour bar has numbers")

        history = quoin.open(self.path("cube")).history
        last, shaken = history[-1], history["stage"] == 2
        self.assertGreater(abs(last["ground_dz_m"]), 1e-3)
        with open(self.path("cube/plots/mechanism.gp"), encoding="utf-8") as file:
            script = file.read()
        drawn = sorted({float(v) for v in re.findall(r"palette cb ([-\d.e+]+) fill", script)})
        relative = np.linalg.norm([last[f"monitor_relative_d{c}_m"] * 1e3 for c in "xyz"])
        self.assertEqual(drawn[0], 0.0, "the base is the ground")
        self.assertAlmostEqual(drawn[-1], relative, delta=0.05 * relative)  # the row is one step before
        self.assertLess(drawn[-1], 0.1 * abs(last["ground_dz_m"]) * 1e3)
        # The history and the output are then along z, as in a stage with velocities along z.
        np.testing.assert_array_equal(history["displacement_m"][shaken], history["monitor_dz_m"][shaken])
        np.testing.assert_array_equal(history["horizontal_force_N"][shaken], -history["monitor_fz_N"][shaken])
        np.testing.assert_array_equal(history["displacement_m"][~shaken], history["monitor_dx_m"][~shaken])
        relative, base = (1e3 * abs(history["monitor_relative_dz_m"]), 1e-3 * abs(history["base_shear_z_N"]))
        far, sheared = (k[shaken].argmax() for k in (relative, base))
        self.assertIn(f"earthquake: cube moves {relative[shaken][far]:.3f} mm along z against the ground (at "
                      f"{history['time_s'][shaken][far]:.3f} s), base shear {base[shaken][sheared]:.2f} kN (at "
                      f"{history['time_s'][shaken][sheared]:.3f} s)", done.stdout)
        self.assertIn(f"stage 2/2 done after {int(last['step'])} steps: {last['displacement_m'] * 1e3:.3f} mm", done.stderr)

    def test_spectra(self):
        done = self.command("spectrum", os.path.join(SCENES, "synthetic_record.csv"), "--damping", "0.02", "0.05", "0.2", "--svg",
                            "--out", "spectra")
        self.assertEqual(done.returncode, 0, done.stderr)
        words = self.assert_fine("spectra", ("spectrum",))
        for one in ("period (s)", "acceleration (m/s2)", "5 % damping", "20 % damping"):
            self.assertIn(one, words)


if __name__ == "__main__":
    unittest.main(verbosity=2)
