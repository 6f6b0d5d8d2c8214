"""Colours of states: one header defines them, and they can be distinguished with any colour blindness and in grey."""
import itertools
import os
import re
import unittest

import quoin
from support import SOURCE
import numpy as np  # after support, which tells where it is missing

# Machado, Oliveira and Fernandes (2009), severity 1: linear RGB without one kind of cones.
CONES = {"all": np.eye(3),
         "no red": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
         "no green": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
         "no blue": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]}
LUMINANCE = [0.2126729, 0.7151522, 0.0721750]
TO_XYZ = np.array([[0.4124564, 0.3575761, 0.1804375], LUMINANCE, [0.0193339, 0.1191920, 0.9503041]])
WHITE = np.array([0.95047, 1.0, 1.08883])  # D65
APART, APART_IN_GREY = 15.0, 7.0  # 2.3 is just visible side by side; thin lines far from a legend need several times that


def linear(colour):
    c = np.array([int(colour[i:i + 2], 16) for i in (1, 3, 5)]) / 255.0
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def lab(rgb):
    x = TO_XYZ @ np.clip(rgb, 0.0, 1.0) / WHITE
    f = np.where(x > (6 / 29) ** 3, np.cbrt(x), x / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def seen(colour, cones):
    rgb = linear(colour)
    return lab(np.full(3, np.dot(LUMINANCE, rgb))) if cones == "grey" else lab(np.array(CONES[cones]) @ rgb)


def ciede2000(one, other):
    """Returns the CIEDE2000 difference, CIE 142-2001, by the formulas of Sharma, Wu and Dalal (2005)."""
    (l1, a1, b1), (l2, a2, b2) = one, other
    c = (np.hypot(a1, b1) + np.hypot(a2, b2)) / 2
    g = 0.5 * (1 - np.sqrt(c ** 7 / (c ** 7 + 25.0 ** 7)))
    a1, a2 = (1 + g) * a1, (1 + g) * a2
    c1, c2 = np.hypot(a1, b1), np.hypot(a2, b2)
    h1, h2 = np.degrees(np.arctan2(b1, a1)) % 360, np.degrees(np.arctan2(b2, a2)) % 360
    turn = h2 - h1
    if c1 * c2 == 0:
        turn, h = 0.0, h1 + h2
    elif abs(turn) <= 180:
        h = (h1 + h2) / 2
    else:
        turn -= np.copysign(360, turn)
        h = ((h1 + h2 + 360) / 2) % 360
    d_l, d_c, d_h = l2 - l1, c2 - c1, 2 * np.sqrt(c1 * c2) * np.sin(np.radians(turn / 2))
    l, c = (l1 + l2) / 2, (c1 + c2) / 2
    cos = [np.cos(np.radians(k * h - at)) for k, at in ((1, 30), (2, 0), (3, -6), (4, 63))]
    t = 1 + np.dot([-0.17, 0.24, 0.32, -0.20], cos)
    s_l, s_c, s_h = 1 + 0.015 * (l - 50) ** 2 / np.sqrt(20 + (l - 50) ** 2), 1 + 0.045 * c, 1 + 0.015 * c * t
    r_t = -2 * np.sqrt(c ** 7 / (c ** 7 + 25.0 ** 7)) * np.sin(np.radians(60 * np.exp(-((h - 275) / 25) ** 2)))
    return np.sqrt((d_l / s_l) ** 2 + (d_c / s_c) ** 2 + (d_h / s_h) ** 2 + r_t * (d_c / s_c) * (d_h / s_h))


class Colours(unittest.TestCase):
    def setUp(self):
        self.colours = quoin._quoin.colours()
        self.states = dict(self.colours["cracks"])

    def test_distance_is_that_of_the_published_pairs(self):
        # Pairs 1, 7, 17 and 25 of Sharma, Wu and Dalal's table 1, printed to four decimals.
        for one, other, distance in (((50, 2.6772, -79.7751), (50, 0, -82.7485), 2.0425), ((50, 0, 0), (50, -1, 2), 2.3669),
                                     ((50, 2.5, 0), (73, 25, -18), 27.1492), ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644)):
            self.assertAlmostEqual(ciede2000(one, other), distance, delta=5e-5)

    def test_states_stay_apart(self):
        for cones in (*CONES, "grey"):
            least = APART_IN_GREY if cones == "grey" else APART
            for (a, first), (b, second) in itertools.combinations(self.states.items(), 2):
                self.assertGreater(ciede2000(seen(first, cones), seen(second, cones)), least, f"{a} and {b}, cones: {cones}")
            for state, colour in self.states.items():
                self.assertGreater(ciede2000(seen(colour, cones), seen(self.colours["face"], cones)), least, f"{state} on a block, {cones}")

    def test_pairs_that_were_alike_are_found(self):
        """A bad pair, blue and violet of one lightness, is detected."""
        self.assertLess(ciede2000(seen("#08519c", "no green"), seen("#7b1fa2", "no green")), 2.0)

    def test_quantities_grow_darker_both_ways(self):
        light = {name: np.dot(LUMINANCE, linear(self.colours[name])) for name in ("middle", "warm", "cold")}
        self.assertGreater(light["middle"], 0.6)
        self.assertLess(max(light["warm"], light["cold"]), 0.15)

    def test_one_header_has_them(self):
        with open(os.path.join(SOURCE, "host/results/colours.h"), encoding="utf-8") as file:
            header = re.findall(r'"(#[0-9a-f]{6})"', file.read())
        given = [*self.states.values(), *(self.colours[k] for k in ("face", "edge", "middle", "warm", "cold")), *self.colours["pens"]]
        self.assertEqual([c for c in header if c in given], given)
        # No other file of the program, its pages or its package contains one of these colours.
        for folder, _, files in os.walk(os.path.join(SOURCE, "host")):
            for name in files:
                if name == "colours.h" or not name.endswith((".h", ".cpp", ".js", ".css", ".html", ".py")):
                    continue
                with open(os.path.join(folder, name), encoding="utf-8") as file:
                    text = file.read().lower()
                for state, colour in self.states.items():
                    self.assertNotIn(colour, text, f"{os.path.join(folder, name)}: {state}")


if __name__ == "__main__":
    unittest.main(verbosity=2)
