#!/usr/bin/env python3
"""Kills runs with SIGKILL at random times and resumes them: a wall, a building and two collapses. history.csv, summary.json
(without times) and the frames must be equal, byte for byte, to those of the uninterrupted run. After each kill files with
final names must be complete.

  tests/stress/kill_and_resume.py build/release/quoin                   50 moments of each kind, some minutes
  tests/stress/kill_and_resume.py build/release/quoin --moments 5 --seed 2 --only arch
"""

import argparse
import json
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

from planted_faults import not_whole

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = {
    "wall": [ROOT / "tests/cli/small_wall.toml", "--set", "output.energy=true", "--set",
             "stage.shear.displacement=0.005"],
    "building": [ROOT / "tests/host/small_building.toml", "--set", "stage.push.displacement=0.02",
                 "--set", "stage.weight.equilibrium_ratio=0.1"],
    "arch": [ROOT / "host/scenes/arch.toml", "--set", "output.energy=true"],
    # Pushed until it falls: cracks on the lattice, then large motion.
    "falling_wall": [ROOT / "tests/cli/small_wall.toml", "--set", "stage.shear.velocity=0.5", "--set",
                     "stage.shear.displacement=0.3"],
}
COMMON = ["--set", "output.plots=false"]


def results(folder):
    """Returns the results that must be equal: name -> bytes, or the summary without its time."""
    summary = json.loads((folder / "summary.json").read_text())
    del summary["wall_clock_s"]
    found = {"summary.json": summary}
    for path in sorted(folder.iterdir()):
        if path.suffix in (".csv", ".vtu", ".vtp", ".pvd"):
            found[path.name] = path.read_bytes()
    return found


def start(program, scene, folder, every):
    """Starts a new run, or resumes the run of the folder."""
    what = ["--resume", folder] if (folder / "run.json").exists() else [*scene, *COMMON, "--out", folder]
    command = [program, "run", *what, "--checkpoint-every", every, "--threads", "1"]
    return subprocess.Popen([str(word) for word in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--moments", type=int, default=50, help="kills of each kind")
    parser.add_argument("--every", type=float, default=0.02, help="s between checkpoints")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=SCENES)
    options = parser.parse_args()
    chance, faults = random.Random(options.seed), 0
    for name, scene in SCENES.items():
        if options.only not in (None, name):
            continue
        with tempfile.TemporaryDirectory() as temporary:
            whole = pathlib.Path(temporary) / "whole"
            begin = time.monotonic()
            if start(options.program, scene, whole, 0).wait() != 0:
                sys.exit(f"{name}: the run itself fails")
            seconds = time.monotonic() - begin
            expected = results(whole)
            killed = resumed = runs = 0
            while killed < options.moments:
                folder = pathlib.Path(temporary) / f"run_{runs}"
                runs += 1
                while True:
                    process = start(options.program, scene, folder, options.every)
                    try:
                        process.wait(chance.uniform(0.0, 1.3 * seconds) if killed < options.moments else None)
                    except subprocess.TimeoutExpired:
                        process.kill()
                        killed += 1
                    said = process.communicate()[1].decode()
                    resumed += "resumed at step" in said
                    if process.returncode == 0:
                        break
                    if process.returncode > 0:
                        sys.exit(f"{name}: stopped with code {process.returncode}: {said[-400:]}")
                    for fault in not_whole(folder):
                        print(f"{name}: run {runs}: after a kill {fault}")
                        faults += 1
                got = results(folder)
                for file in sorted(expected.keys() | got.keys()):
                    if expected.get(file) != got.get(file):
                        print(f"{name}: run {runs}: {file} differs")
                        faults += 1
                shutil.rmtree(folder)
            print(f"{name}: {killed} kills in {runs} runs of {seconds:.1f} s, gone on from a checkpoint {resumed} times, "
                  f"{len(expected)} files compared a run", flush=True)
    print("all the same, and whole after each kill" if faults == 0 else f"{faults} files differ or are not whole")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
