"""The live page of a run: quoin run --serve."""
import contextlib
import http.client
import io
import json
import os
import re
import socket
import subprocess
import sys
import time
import types
import unittest
import unittest.mock
import warnings

import quoin
from support import PROGRAM, SMALL_WALL, Folder

SLOW = ["--set", "stage.shear.velocity=0.00003", "--set", "output.plots=false", "--set", "output.frames_of=all", "--threads", "1"]


class Live(Folder):
    def served(self, *options):
        """Starts a run and returns it with the port of its page."""
        run = subprocess.Popen([PROGRAM, "run", SMALL_WALL, "--out", "live", *SLOW, *options], cwd=self.folder,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        told = []
        for line in run.stderr:
            told.append(line)
            found = re.search(r"http://127\.0\.0\.1:(\d+)/", line)
            if found:
                return run, int(found[1])
        self.fail("".join(told))

    def get(self, port, path, method="GET", host=None):
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
        connection.request(method, path, headers={} if host is None else {"Host": host})
        answer = connection.getresponse()
        body = answer.read()
        connection.close()
        return answer.status, answer.getheader("Content-Type"), body

    def test_the_page_of_a_run_that_goes_on(self):
        run, port = self.served("--serve", "0")
        status, kind, page = self.get(port, "/")
        self.assertEqual((status, kind), (200, "text/html; charset=utf-8"))
        self.assertIn(b'class="live"', page)
        self.assertEqual(self.get(port, "/../run.json")[0], 404)
        self.assertEqual(self.get(port, "/state", method="POST")[0], 405)
        self.assertEqual(self.get(port, "/state", host="elsewhere.example")[0], 403)
        states, parts = [], []
        while run.poll() is None:
            try:
                states.append(json.loads(self.get(port, "/state")[2]))
                if states[-1]["frames"] > len(parts[-1]["head"]["times"] if parts else []):
                    parts.append(json.loads(self.get(port, "/run")[2]))
            except (OSError, http.client.HTTPException):
                break  # the run has ended
            time.sleep(0.05)
        words = run.communicate(timeout=120)
        self.assertEqual(run.returncode, 0, words)
        self.assertGreater(len(parts), 1)
        known = [s for s in states if "stage" in s]
        self.assertGreater(len(known), 1)
        self.assertGreaterEqual(known[-1]["rows"], known[0]["rows"])
        for state in known:
            self.assertGreaterEqual(abs(state["peak_N"]), abs(state["force_N"]))
            self.assertTrue(0.0 <= state["cracked"] <= 1.0)
        head = parts[-1]["head"]
        self.assertEqual(head["summary"]["status"], "running")
        self.assertGreaterEqual(len(head["history"]["time_s"]), 2)
        self.assertIn(f"moved{len(head['times']) - 1}", head["arrays"])
        # Bitwise identical to a run without a page.
        done = self.command("run", SMALL_WALL, "--out", "alone", *SLOW)
        self.assertEqual(done.returncode, 0, done.stderr)
        names = sorted(n for n in os.listdir(self.path("alone")) if n.endswith((".csv", ".vtu", ".pvd")))
        self.assertGreater(len(names), 6)
        for name in names:
            with open(self.path("alone/" + name), "rb") as one, open(self.path("live/" + name), "rb") as other:
                self.assertEqual(one.read(), other.read(), name)

    def test_a_port_that_is_taken_is_told(self):
        done = self.command("run", SMALL_WALL, "--out", "other", *SLOW)
        self.assertEqual(done.returncode, 0, done.stderr)
        before = sorted(os.listdir(self.path("other")))
        run, port = self.served("--live")
        done = self.command("run", SMALL_WALL, "--out", "other", "--serve", str(port))
        self.assertEqual(sorted(os.listdir(self.path("other"))), before)  # results of the earlier run
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn(f"--serve {port}: the port cannot be had", done.stderr)
        run.terminate()
        run.communicate(timeout=120)

    def test_idle_connections_keep_nobody_waiting(self):
        run, port = self.served("--serve", "0", "--set", "stage.shear.velocity=0.000001")  # it must not end meanwhile
        idle = [socket.create_connection(("127.0.0.1", port)) for _ in range(70)]  # more than are kept open
        begin = time.monotonic()
        self.assertEqual(self.get(port, "/state")[0], 200)
        self.assertLess(time.monotonic() - begin, 4.0)  # s; each idle one alone had 5 s
        for connection in idle:
            connection.close()
        run.terminate()
        run.communicate(timeout=120)

    def test_without_frames_it_is_refused_before_the_run(self):
        done = self.command("run", SMALL_WALL, "--out", "none", "--serve", "0", "--set", "output.frames=0")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("output.frames", done.stderr)
        self.assertFalse(os.path.exists(self.path("none")))


class Progress(unittest.TestCase):
    """Output of quoin.run(progress=True), which changes no number."""

    def run_wall(self):
        told, plain = io.StringIO(), quoin.run(SMALL_WALL, threads=1)
        with contextlib.redirect_stderr(told), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            run = quoin.run(SMALL_WALL, threads=1, progress=True)
        self.assertEqual(run.history.tobytes(), plain.history.tobytes())
        return run, told.getvalue()

    def assert_tells_the_end(self, run, text):
        self.assertRegex(text, r"^stage 2 of 2 \w+: 100 %; 0\.5\d* mm, ")
        self.assertIn(f"peak so far {run.peak[0] / 1e3:.3g} kN at {1e3 * run.peak[1]:.3g} mm; kinetic energy ", text)
        share = float(re.search(r"([0-9.]+) % of contact points damaged", text)[1])
        self.assertTrue(0 < share < 100, text)

    def test_on_a_terminal(self):
        run, told = self.run_wall()
        self.assert_tells_the_end(run, told.strip().split("\r")[-1].strip())

    def test_in_a_notebook(self):
        shown, module, parts = [], types.ModuleType("IPython"), types.ModuleType("IPython.display")
        module.get_ipython = lambda: types.SimpleNamespace(kernel=True)
        parts.HTML = lambda text: text
        parts.display = lambda _, display_id: types.SimpleNamespace(update=shown.append)
        with unittest.mock.patch.dict(sys.modules, {"IPython": module, "IPython.display": parts}):
            run, told = self.run_wall()
        self.assertEqual(told, "")
        self.assertGreater(len(shown), 1)
        self.assert_tells_the_end(run, re.sub("</?code>", "", shown[-1]))


if __name__ == "__main__":
    unittest.main()
