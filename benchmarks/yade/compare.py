"""Time of a step of the cube walls in Quoin's host and in Yade.  python3 benchmarks/yade/compare.py --build build/release

Time is processor time (user and system) with one thread, on which other programs have little influence; the median of
three runs. Exit code 77, with the reason: skipped.
"""
import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile

here = os.path.dirname(os.path.abspath(__file__))
root = os.path.abspath(os.path.join(here, "../.."))

if not shutil.which("yade"):
    print("skipped: Yade is not installed (apt-get install yade: 0.8 to 1.1 GB)")
    sys.exit(77)


def run(command):
    """Runs a command. Returns its output and processor time, s."""
    with tempfile.TemporaryFile("w+") as output:
        process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(process.pid, 0)
        output.seek(0)
        text = output.read()
    if status:
        sys.exit(f"{' '.join(command)}\nended with {os.waitstatus_to_exitcode(status)}\n{text}")
    return text, usage.ru_utime + usage.ru_stime


def host(build, scene, displacement):
    """Returns points, steps and processor time (s) of a run of Quoin."""
    with tempfile.TemporaryDirectory() as folder:
        _, seconds = run([os.path.join(build, "quoin"), "run", scene, "--threads", "1", "--out", folder, "--set",
                          f"stage.shear.displacement={displacement}", "--set", "stage.shear.record_interval=1000",
                          "--set", "output.frames=0", "--set", "output.plots=false"])
        with open(os.path.join(folder, "summary.json")) as file:
            summary = json.load(file)
    return summary["contact_points"], summary["steps"], seconds


def host_step(build, n):
    """Returns the difference of a long and a short run, which excludes the time to start."""
    scene = os.path.join(root, f"host/scenes/cube_wall_{n}.toml")
    points, many, long = host(build, scene, 0.002)
    _, few, short = host(build, scene, 0.0002)
    return points, (long - short) / (many - few) * 1e6


def yade_step(n, kind, steps):
    text, _ = run(["yade", "-n", "-x", os.path.join(here, "native.py"), str(n), kind, str(steps)])
    lines = [line.split() for line in text.splitlines() if line.startswith("native")]
    if not lines:  # Yade has exit code 0 after an error in a script
        sys.exit(text)
    return int(lines[0][2]), float(lines[0][3])


def median(measure, *arguments):
    results = [measure(*arguments) for _ in range(3)]
    return results[0][0], statistics.median(r[1] for r in results)


parser = argparse.ArgumentParser()
parser.add_argument("--build", default=os.path.join(root, "build/release"))
options = parser.parse_args()
print("| bodies | code | points | us a step | ns a point |\n|---|---|---|---|---|")
for n in (10, 20):
    for name, case in ((f"Quoin, cube_wall_{n}", (host_step, options.build, n)),
                       ("Yade, spheres, CPM bonds", (yade_step, n, "spheres", 2000)),
                       ("Yade, polyhedra, unbonded", (yade_step, n, "polyhedra", 20))):
        points, step = median(*case)
        print(f"| {n * n} | {name} | {points} | {step:.1f} | {step / points * 1e3:.1f} |", flush=True)
