"""Common parts of the tests of the package. Exit code 77, with the reason: skipped."""
import os
import subprocess
import sys
import tempfile
import unittest

try:
    import numpy as np  # noqa: F401
except ImportError:
    print("skipped: NumPy is not installed (python3-numpy)")
    sys.exit(77)
import quoin

SOURCE, PROGRAM = os.environ["QUOIN_SOURCE"], os.environ["QUOIN_PROGRAM"]
SMALL_WALL = os.path.join(SOURCE, "tests/cli/small_wall.toml")
SCENES = os.path.join(SOURCE, "host/scenes")


class Folder(unittest.TestCase):
    """Tests with a separate folder."""

    def setUp(self):
        holder = tempfile.TemporaryDirectory(dir=os.environ.get("QUOIN_WORK"))
        self.addCleanup(holder.cleanup)
        self.folder = holder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def command(self, *arguments):
        return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, cwd=self.folder)


def assert_same_history(a, b):
    """Compares bit by bit; NaN is equal to NaN."""
    assert a.dtype == b.dtype, (a.dtype, b.dtype)
    for name in a.dtype.names:
        np.testing.assert_array_equal(a[name], b[name], err_msg=name)


def block_scene(**changes):
    """Returns two rigid cubes of 1 m and 1000 kg, one fixed, one 1 m above it, without contact and damping."""
    scene = quoin.Scene(title="two cubes")
    scene.solver = dict(damping="none")
    scene.materials["stone"] = quoin.BlockMaterial(density=1000.0, young_modulus=1e10, poisson_ratio=0.2)
    scene.joints["dry"] = quoin.Joint(law="coulomb_slip", initial_state="dry", normal_stiffness=1e9,
                                      shear_stiffness=1e9, friction_angle=35.0)
    for name, y, fixed in (("base", 0.0, True), ("cube", 2.0, False)):
        scene.block.append(quoin.Block(name=name, material="stone", fixed=fixed,
                                       box=dict(lower=[0, y, 0], size=[1, 1, 1])))
    scene.stage.append(quoin.Stage(name="wait", duration=10.0))
    scene.output = dict(frames=0)
    for key, value in changes.items():
        scene[key] = value
    return scene
