"""Messages of the build by pip, with a stand-in for CMake, since the build itself takes minutes."""
import importlib.util
import os
import subprocess
import sys
import unittest
from unittest import mock

from support import SOURCE, Folder


class Wheel(Folder):
    def setUp(self):
        super().setUp()
        spec = importlib.util.spec_from_file_location("wheel_by_cmake", SOURCE + "/host/python/wheel_by_cmake.py")
        self.backend = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(self.backend)

    def stand_in(self, script):
        """Writes a cmake that records its arguments. Returns the environment in which it is found first."""
        with open(self.path("cmake"), "w", encoding="utf-8") as file:
            file.write(f'#!/bin/sh\necho "$@" >> {self.path("asked")}\n{script}\n')
        os.chmod(self.path("cmake"), 0o755)
        return dict(os.environ, PATH=self.folder + os.pathsep + os.environ["PATH"])

    def asked(self):
        with open(self.path("asked"), encoding="utf-8") as file:
            return file.read().splitlines()

    def test_compilers_are_as_many_as_cores_or_as_told(self):
        for told, jobs in (({}, self.backend.side_by_side()), ({"CMAKE_BUILD_PARALLEL_LEVEL": "3"}, 3)):
            environment = self.stand_in("")
            environment.pop("CMAKE_BUILD_PARALLEL_LEVEL", None)
            with mock.patch.dict(os.environ, {**environment, **told}, clear=True):
                self.backend.compile_package()
            self.assertIn(f"--parallel {jobs} --target quoin_python", self.asked()[-1])
        self.assertGreaterEqual(self.backend.side_by_side(), 1)
        self.assertLessEqual(self.backend.side_by_side(), len(os.sched_getaffinity(0)))

    def test_what_is_missing_is_told_before_anything_is_compiled(self):
        with mock.patch.dict(os.environ, self.stand_in("exit 1"), clear=True):
            for ask in (self.backend.prepare_metadata_for_build_wheel, self.backend.build_wheel):
                with self.assertRaisesRegex(SystemExit, "something is missing.*pybind11-dev, python3-dev"):
                    ask(self.folder)
        self.assertFalse([line for line in self.asked() if "--build" in line])
        with mock.patch.dict(os.environ, PATH=self.path("nothing")):
            with self.assertRaisesRegex(SystemExit, "cmake is not installed"):
                self.backend.prepare_metadata_for_build_wheel(self.folder)

    def test_pip_looks_for_numpy_before_it_compiles(self):
        # An empty target and no index, so that NumPy is not available.
        if subprocess.run([sys.executable, "-m", "pip", "--version"], capture_output=True).returncode != 0:
            self.skipTest("pip is not installed (python3-pip)")
        done = subprocess.run([sys.executable, "-m", "pip", "install", "--no-index", "--no-build-isolation",
                               "--disable-pip-version-check", "--target", self.path("target"), SOURCE],
                              env=self.stand_in(""), capture_output=True, text=True, timeout=120)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("No matching distribution found for numpy", done.stderr)
        self.assertTrue(self.asked())
        self.assertFalse([line for line in self.asked() if "--build" in line])


if __name__ == "__main__":
    unittest.main(verbosity=2)
