"""The example of the README."""
import os
import re
import subprocess
import sys
import unittest

from support import SMALL_WALL, SOURCE, Folder

EXAMPLES = os.path.join(SOURCE, "host/python/examples")


class Examples(Folder):
    def test_a_wall_its_curve_another_law_and_a_loop_over_cohesion(self):
        try:
            import matplotlib  # noqa: F401
        except ImportError:
            self.skipTest("matplotlib is not installed (python3-matplotlib)")
        script = os.path.join(EXAMPLES, "wall_and_cohesion.py")
        with open(script, encoding="utf-8") as file:
            code = [line for line in file if line.strip()]
        self.assertLessEqual(len(code), 25)
        done = subprocess.run([sys.executable, script, SMALL_WALL, self.path("curve.png")], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        peaks = [float(p) for p in re.findall(r"peak ([\d.]+) kN", done.stdout)]
        self.assertEqual(len(peaks), 4)
        self.assertLess(peaks[0], peaks[2])  # a larger cohesion has a larger force
        self.assertLess(peaks[2], peaks[3])  # an infinite strength has the largest force
        self.assertGreater(os.path.getsize(self.path("curve.png")), 5000)

    def test_an_arch_is_bisected_to_its_thinnest(self):
        script = os.path.join(EXAMPLES, "thinnest_arch.py")
        done = subprocess.run([sys.executable, script, "14", "2"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        ratio = float(re.search(r"stands from ([\d.]+) of its radius", done.stdout)[1])
        # Limit analysis: 0.1075 for many voussoirs, less for few, since there is no joint at the positions of the hinges.
        # 0.0094 is the last interval of the bisection.
        self.assertLess(ratio, 0.1075 + 0.0094)
        self.assertGreater(ratio, 0.09)


if __name__ == "__main__":
    unittest.main(verbosity=2)
