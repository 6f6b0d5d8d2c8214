"""The page of a run, opened by a browser from the disk. What the page does is asked by a script that is added to a copy."""
import base64
import json
import os
import re
import shutil
import subprocess
import tempfile
import unittest
import zlib

import quoin
from support import PROGRAM, SCENES, SMALL_WALL, Folder, block_scene
import numpy as np  # after support, which tells where it is missing

# Moves the slider, chooses every colour, and tells what was drawn: shares of pixels that are not background.
ASK = """
<script>
const faults = [];
window.addEventListener('error', e => faults.push(e.message));
window.addEventListener('unhandledrejection', e => faults.push(String(e.reason)));
for (const kind of ['error', 'warn']) { console[kind] = (...words) => faults.push(words.join(' ')); }
const pixels = run => {
  const gl = run.renderer.getContext(), [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
  const all = new Uint8Array(4 * w * h);
  gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, all);
  let drawn = 0, sum = 0;
  for (let i = 0; i < all.length; i += 4) {
    if (all[i] !== 251 || all[i + 1] !== 251 || all[i + 2] !== 250) ++drawn;
    sum = (sum * 31 + all[i] + 256 * all[i + 1] + 65536 * all[i + 2]) % 4294967291;
  }
  return [drawn / (w * h), sum];
};
const ask = () => {
  if (!document.body.dataset.ready) return setTimeout(ask, 50);
  const told = {ready: document.body.dataset.ready, frames: [], colours: [], faults};
  if (told.ready === 'yes') {
    const slider = document.getElementById('time'), colour = document.getElementById('colour');
    for (let f = 0; f <= Number(slider.max); ++f) {
      slider.value = f;
      slider.dispatchEvent(new Event('input'));
      told.frames.push(quoinRuns.map(r => [r.frame, ...pixels(r), r.curve.dots[0], r.cracked]));
    }
    for (const option of colour.options) {
      colour.value = option.value;
      colour.dispatchEvent(new Event('input'));
      told.colours.push([option.value, ...pixels(quoinRuns[0])]);
    }
  }
  const pre = document.createElement('pre');
  pre.id = 'told';
  pre.textContent = JSON.stringify(told);
  document.body.appendChild(pre);
};
ask();
</script>
"""


def told_by(page):
    """What a browser tells of the page; skips the test where there is none that draws."""
    browser = shutil.which("chromium") or shutil.which("chromium-browser")
    if not browser:
        raise unittest.SkipTest("chromium is not installed")
    with open(page, encoding="utf-8") as file:
        html = file.read()
    asked = page.replace(".html", "_asked.html")
    with open(asked, "w", encoding="utf-8") as file:
        file.write(html.replace("<body>", "<body>" + ASK, 1))
    with tempfile.TemporaryDirectory() as profile:
        done = subprocess.run([browser, "--headless", "--no-sandbox", "--disable-gpu", "--use-angle=swiftshader",
                               "--enable-unsafe-swiftshader", "--window-size=1200,900", f"--user-data-dir={profile}",
                               "--virtual-time-budget=60000", "--dump-dom", "file://" + asked],
                              capture_output=True, text=True, timeout=280)
    found = re.search(r'<pre id="told">(.*?)</pre>', done.stdout, re.S)
    if not found:
        raise AssertionError(f"the page has told nothing: {done.stdout[-500:]} {done.stderr[-2000:]}")
    return json.loads(found[1].replace("&amp;", "&").replace("&lt;", "<").replace("&gt;", ">"))


class Report(Folder):
    def run_scene(self, name, scene, *options):
        if isinstance(scene, quoin.Scene):
            scene.write(self.path(name + ".toml"))
            scene = self.path(name + ".toml")
        done = self.command("run", scene, "--out", name, "--set", "output.plots=false", *options)
        self.assertEqual(done.returncode, 0, done.stderr)

    def page_of(self, name):
        """Head of the page of a run, and what gives its arrays."""
        with open(self.path(name + "/report.html"), encoding="utf-8") as file:
            html = file.read()
        head = json.loads(re.search(r'class="head">(.*?)</script>', html, re.S)[1])
        data = zlib.decompress(base64.b64decode(re.search(r'class="data">(.*?)</script>', html, re.S)[1]))

        def array(name, columns=3):
            at = head["arrays"][name]
            kind = {"Float32Array": "<f4", "Int16Array": "<i2", "Uint8Array": "u1"}[at["type"]]
            return np.frombuffer(data, kind, at["count"], at["offset"]).reshape(-1, columns)
        return head, array

    def assert_works(self, told, runs=1, cracks=True):
        self.assertEqual(told["ready"], "yes", told)
        self.assertEqual(told["faults"], [])
        frames = told["frames"]
        self.assertGreater(len(frames), 2)
        for r in range(runs):
            self.assertEqual(frames[0][r][0], 0)
            for _, drawn, _, _, _ in (f[r] for f in frames):
                self.assertGreater(drawn, 0.02)  # of the picture: something is there
            self.assertGreater(len({f[r][2] for f in frames}), 1, "the slider changes the picture")
            self.assertGreater(len({tuple(f[r][3]) for f in frames}), 1, "the slider moves the dot on the curve")
            if cracks:
                self.assertGreater(frames[-1][r][4], 0)

    def test_a_wall_can_be_looked_at(self):
        self.run_scene("wall", SMALL_WALL, "--report")
        page = self.path("wall/report.html")
        with open(page, encoding="utf-8") as file:
            html = file.read()
        # Nothing is fetched: the page has no address in what loads.
        self.assertIsNone(re.search(r"""<(script|link|img)[^>]*(src|href)=""", html.split("<script>")[0]))
        told = told_by(page)
        self.assert_works(told)
        self.assertEqual([c[0] for c in told["colours"]], ["damage", "opening", "slip", "stress", "displacement"])
        self.assertGreater(len({c[2] for c in told["colours"]}), 3)  # they look different

    def test_displacements_are_those_of_the_run(self):
        self.run_scene("wall", SMALL_WALL, "--report")
        head, array = self.page_of("wall")
        # The beam on top goes by what the stage asks for, 0.5 mm; two steps of 30 us at 50 mm/s more, and
        # what 16 bits round by.
        top = array("position")[:, 1].argmax()
        step = head["range"]["moved"] / 32767
        self.assertAlmostEqual(array("moved3")[top, 0] * step, 0.5e-3, delta=2 * 0.05 * 3e-5 + step)
        self.assertEqual(abs(array("moved3")).max(), 32767)

    def test_two_runs_side_by_side(self):
        self.run_scene("wall", SMALL_WALL)
        self.run_scene("brittle", SMALL_WALL, "--law", "coulomb_slip")
        done = self.command("report", "wall", "brittle")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.strip(), "wall/report.html")
        self.assert_works(told_by(self.path("wall/report.html")), runs=2)

    def test_without_frames_it_is_refused_before_the_run(self):
        done = self.command("run", SMALL_WALL, "--out", "none", "--set", "output.frames=0", "--report")
        self.assertEqual(done.returncode, 2)
        self.assertIn("output.frames", done.stderr)
        self.assertFalse(os.path.exists(self.path("none")))
        wall = quoin.Scene.load(SMALL_WALL)
        wall.output.frames = 0
        with self.assertRaisesRegex(quoin.BadInput, "output.frames"):
            quoin.run(wall, out=self.path("none"), report=True)

    def test_blocks_that_fall(self):
        arch = quoin.Scene.load(SCENES + "/arch.toml")
        arch.stage[1].collapse.rate = 0.2
        arch.output.frames = 4
        self.run_scene("arch", arch)
        self.assertEqual(self.command("report", "arch").returncode, 0)
        self.assert_works(told_by(self.path("arch/report.html")))

    def test_cracks_of_an_arch_lie_on_its_joints(self):
        arch = quoin.Scene.load(SCENES + "/arch.toml")
        arch.stage[1].collapse.rate = 0.2
        arch.output.frames = 4
        self.run_scene("arch", arch, "--report")
        head, array = self.page_of("arch")
        cracks = 0
        for f in range(len(head["times"])):
            # At the start, where they are drawn from: corners of voussoirs of 22.5 degrees, at 9.25 and 10.75 m.
            start, moved, crack = array(f"points{f}"), array(f"points_moved{f}"), array(f"point_crack{f}", 1)
            self.assertEqual(len(start), len(moved))
            self.assertEqual(len(start), len(crack))
            cracks += len(start)
            radius, turn = np.hypot(start[:, 0], start[:, 1]), np.degrees(np.arctan2(start[:, 1], start[:, 0]))
            # But for the gap of a joint, since a point stands on one side and may be drawn with the other.
            gap = 0.32  # m: corners of neighbours are up to 0.309 m apart at the end, by the meshes of the frames
            self.assertLess(np.minimum(abs(radius - 9.25), abs(radius - 10.75)).max(initial=0.0), gap)
            off = (turn - 11.25) / 22.5
            self.assertLess(abs(off - off.round()).max(initial=0.0) * np.radians(22.5) * 10.75, gap)
            self.assertLessEqual(abs(moved).max(initial=0.0), head["range"]["moved"])
        self.assertGreater(cracks, 4)
        self.assertAlmostEqual(head["range"]["opening"][1], 0.309, delta=0.005)
        # The collapse ends when the centre of a block has moved by 0.6 m; its corners turn about it.
        self.assertGreater(head["range"]["moved"], 0.6)
        self.assertLess(head["range"]["moved"], 0.8)

    def test_what_is_missing_is_told(self):
        def fails(words, *arguments, **environment):
            done = subprocess.run([PROGRAM, "report", *arguments], capture_output=True, text=True, cwd=self.folder,
                                  env={**os.environ, **environment})
            self.assertEqual(done.returncode, 3, done.stdout)
            self.assertIn(words, done.stderr)
        self.run_scene("cubes", block_scene(stage=[quoin.Stage(duration=0.01)]))
        fails("the run wrote no frames (blocks.pvd is missing)", "cubes")
        fails("no results here (summary.json is missing)", "nowhere")
        fails("install it with `apt-get install libjs-three`", "cubes", QUOIN_THREE_JS="/nowhere")
        self.run_scene("wall", SMALL_WALL)
        with open(self.path("wall/joints_0001.vtu"), "r+b") as file:
            file.truncate(4000)
        fails("joints_0001.vtu: is cut off; run the scene again", "wall")


if __name__ == "__main__":
    if not os.path.exists("/usr/share/javascript/three/three.min.js"):
        print("skipped: three.js is not installed (libjs-three)")
        raise SystemExit(77)
    unittest.main(verbosity=2)
