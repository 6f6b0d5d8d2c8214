#!/usr/bin/env python3
"""Stress of the solver's stability: each case must have right results, or a warning with the measured error, or stop with a
clear reason. No case may hang, crash or be wrong without a message.

  tests/stress/stability.py build/release/quoin                  short: a small wall, a minute or two
  tests/stress/stability.py build/release/quoin --long           all cases on the solid wall
"""

import argparse
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "host" / "scenes" / "solid_wall_030.toml"
SMALL = ["wall.courses=4", "wall.units_per_course=2", "stage.shear.displacement=0.0015"]
PEAK = 0.05  # tolerance relative to the slow run; the measured error of quality standard is 1 %
BALANCE = 1e-3  # energies are sums over all steps; the balance error is the law's first-order work

# name, settings, settings of the slow run for comparison, allowed outcomes.
SLOW = ["solver.quality=reference", "stage.shear.velocity=0.01"]


def brittle(factor):
    """Returns fracture energies as multiples of the smallest admissible ones, ft^2/(2 kn) and c0^2/(2 ks)."""
    return [f"joints.mortar.fracture_energy_tension={factor * 0.2e6**2 / (2 * 82e9)}",
            f"joints.mortar.fracture_energy_shear={factor * 0.3e6**2 / (2 * 36e9)}"]


STIFF = ["joints.unit.normal_stiffness=8.2e14", "joints.unit.shear_stiffness=8.2e14",
         "joints.unit.fracture_energy_tension=80", "joints.unit.fracture_energy_shear=550"]
SOFT = ["joints.unit.normal_stiffness=8.2e10", "joints.unit.shear_stiffness=3.6e10"]
SLIVER = ["wall.unit=[0.22, 0.01, 0.1]", "stage.shear.displacement=0.0003"]
MIXED = ["joints.mortar.normal_stiffness=5e9", "joints.mortar.shear_stiffness=9e11",
         "joints.mortar.fracture_energy_tension=40", "joints.mortar.fracture_energy_shear=15",
         "joints.unit.normal_stiffness=7e12", "joints.unit.shear_stiffness=3e10",
         "joints.unit.fracture_energy_tension=300", "joints.unit.fracture_energy_shear=900"]

CASES = [
    ("stiffness ratio 1e4", STIFF, STIFF, {"right", "warned"}),
    ("stiffness ratio 1", SOFT, SOFT, {"right", "warned"}),
    ("joints of very different kinds", MIXED, MIXED, {"right", "warned"}),
    ("energies 1.001 of the least", brittle(1.001), brittle(1.001), {"right", "warned"}),
    ("energies below the least", brittle(0.9), None, {"stopped"}),
    *[(f"time step {f} of critical", [f"solver.time_step_fraction={f}"], [], {"right", "warned"})
      for f in (0.3, 0.6, 0.8, 0.9, 0.99)],
    *[(f"eq. 1, time step {f} of critical", ["solver.damping=local", f"solver.time_step_fraction={f}"], [],
       {"right", "warned", "stopped"}) for f in (0.3, 0.7, 0.9, 0.99)],
    *[(f"rate {v} m/s", [f"stage.shear.velocity={v}", "stage.shear.ramp_time=0.0005"], [], {"right", "warned"})
      for v in (0.1, 0.3, 1.0)],
    ("sliver blocks, 1 : 11", SLIVER, SLIVER, {"right", "warned"}),
]

# Cases that take minutes on a shared machine: only with --long.
LONG = {"stiffness ratio 1e4", "joints of very different kinds", "time step 0.3 of critical", "time step 0.6 of critical",
        "eq. 1, time step 0.3 of critical", "sliver blocks, 1 : 11"}


def run(program, settings, timeout):
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "run", str(SCENE), "--out", folder, "--set", "output.plots=false",
                   "--set", "output.frames=0", "--set", "output.energy=true", "--threads", "1"]
        for setting in settings:
            command += ["--set", setting]
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
        said = done.stdout + done.stderr
        if done.returncode < 0 or done.returncode not in (0, 3, 4, 5):
            raise SystemExit(f"crashed with code {done.returncode}: {said[-400:]}")
        summary = pathlib.Path(folder) / "summary.json"
        return done.returncode, said, json.loads(summary.read_text()) if summary.exists() else {}, energy_error(folder)


def energy_error(folder):
    """Returns the largest energy balance error over the external work."""
    path = pathlib.Path(folder) / "history.csv"
    rows = list(csv.DictReader(open(path))) if path.exists() else []
    work = max((abs(float(r["external_work_J"])) for r in rows), default=0.0)
    return max(abs(float(r["energy_balance_error_J"])) for r in rows) / work if work > 0 else 0.0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--long", action="store_true", help="the whole solid wall")
    parser.add_argument("--only", help="cases whose name holds this")
    options = parser.parse_args()
    wall = [] if options.long else SMALL
    timeout = 3600 if options.long else 300

    known, failures = {}, 0
    for name, settings, slow, allowed in CASES:
        if options.only and options.only not in name or name in LONG and not options.long:
            continue
        code, said, summary, imbalance = run(options.program, wall + settings, timeout)
        warnings = [line for line in said.splitlines() if "warning:" in line]
        error = None
        if slow is not None:
            key = tuple(slow)
            if key not in known:
                known[key] = run(options.program, wall + SLOW + slow, timeout)[2]["peak_horizontal_force_N"]
            if code == 0:
                error = summary["peak_horizontal_force_N"] / known[key] - 1.0
        if code != 0:
            outcome, why = "stopped", said.strip().splitlines()[-1]
        elif warnings:
            outcome, why = "warned", warnings[0].split("warning:")[1].strip()
        else:
            outcome, why = "right", ""
            if error is not None and abs(error) > PEAK:
                outcome, why = "WRONG", "no warning"
        if outcome == "right" and imbalance > BALANCE:
            outcome, why = "WRONG", f"energies miss {imbalance:.1e} of the work"
        good = outcome in allowed and (outcome != "stopped" or len(why) > 20)
        failures += not good
        print(f"{'ok  ' if good else 'FAIL'} {name}: {outcome}"
              + (f", peak {100 * error:+.1f} % off the slow run" if error is not None else "")
              + (f"; {why[:150]}" if why else ""), flush=True)
    sys.exit(f"{failures} cases neither right nor said to be wrong" if failures else 0)


main()
