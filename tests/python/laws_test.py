"""Libraries of laws that quoin.load and quoin.Law load: built again, cut off, or no laws."""
import os
import shutil
import subprocess
import sys
import unittest
from unittest import mock

import quoin
from support import Folder
import numpy as np  # after support, which tells where it is missing

ELASTIC = dict(normal_stiffness=4e10, shear_stiffness=2e10)


def shipped(name):
    """Returns the file of a shipped law."""
    return next(file for folder in quoin.law.folders() if os.path.exists(file := f"{folder}/{name}.so"))


class Libraries(Folder):
    def setUp(self):
        super().setUp()
        self.law = self.path("law.so")

    def build(self, name, in_place=True):
        """Copies a shipped law to the library. In place, its inode stays."""
        if not in_place and os.path.exists(self.law):
            os.remove(self.law)
        shutil.copyfile(shipped(name), self.law)

    def refusal(self, path):
        with self.assertRaises(quoin.LawRefused) as raised:
            quoin.load(path)
        self.assertIsInstance(raised.exception, quoin.Refused)  # also of an installation with the laws alone
        self.assertIn(str(path), str(raised.exception))
        return str(raised.exception)

    def test_a_law_that_was_built_again_is_the_new_one(self):
        for in_place in (True, False):
            with self.subTest(in_place=in_place):
                self.build("elastic", in_place)
                first = quoin.Law(self.law, **ELASTIC)
                self.build("coulomb_slip", in_place)
                self.assertEqual(quoin.Law(self.law, friction_angle=30, **ELASTIC).law.id, "coulomb_slip")
                self.assertEqual(first.law.id, "elastic")
                np.testing.assert_allclose(first.drive(normal=np.array([0.0, 1e-5])).sigma, [0.0, 4e5])
                self.build("elastic", in_place)
                self.assertEqual(quoin.load(self.law)[0].id, "elastic")

    def test_the_same_file_is_loaded_once(self):
        self.build("elastic")
        quoin.load(self.law)
        before = len(os.listdir("/proc/self/fd"))
        for _ in range(20):
            quoin.load(self.law)
        self.assertEqual(len(os.listdir("/proc/self/fd")), before)

    def test_a_library_that_was_cut_off_is_refused(self):
        self.build("elastic")
        size = os.path.getsize(self.law)
        for length in (0, 30, 200, 8000, size - 1):
            with self.subTest(length=length):
                self.build("elastic")
                os.truncate(self.law, length)
                self.assertIn(f"the file has {length} bytes of" if length else "the file is empty", self.refusal(self.law))

    def test_what_is_no_law_is_refused(self):
        self.assertIn("No such file", self.refusal(self.path("none.so")))
        self.assertIn("Is a directory", self.refusal(self.folder))
        with open(self.law, "w", encoding="utf-8") as file:
            file.write("no library")
        self.assertIn("the dynamic loader says", self.refusal(self.law))
        self.assertIn("exports no quoin_library_v1", self.refusal(quoin._quoin.__file__))

    def test_a_library_that_ends_the_process_is_refused(self):
        # In a process of its own: the law would end this one, with the exit code of a test that passes.
        done = subprocess.run([sys.executable, "-c", "import quoin, sys\ntry:\n    quoin.load(sys.argv[1])\n"
                               "except quoin.LawRefused as refused:\n    print(refused)", os.environ["QUOIN_HOSTILE_LAW"]],
                              env={**os.environ, "QUOIN_HOSTILE": "_exit at load"}, capture_output=True, text=True)
        self.assertIn("called exit(0) or _exit(0) while it was loaded", done.stdout, done.stderr)

    def test_it_runs_from_its_file_for_debuggers(self):
        self.build("elastic")
        with mock.patch.dict(os.environ, QUOIN_LAW_IN_PLACE="1"):
            quoin.load(self.law)
        with open("/proc/self/maps", encoding="utf-8") as maps:
            self.assertIn(self.law, maps.read())


if __name__ == "__main__":
    unittest.main(verbosity=2)
