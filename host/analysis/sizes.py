"""Time and memory of quoin limit and quoin modes by the number of blocks: a dry wall in running bond, as long as it is high.

    /usr/bin/python3 host/analysis/sizes.py out/sizes [10 100 1000 ...]

Processor time of one thread, s, and peak memory, MB, by blocks: sizes.csv and sizes.png in the folder.
"""
import os
import resource
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.environ.get("QUOIN", os.path.join(ROOT, "build/release/quoin"))
MOST_SECONDS = 600  # of processor time: what takes longer is left out

SCENE = """
[materials.stone]
density = 2000.0
young_modulus = 10e9
poisson_ratio = 0.2
[joints.dry]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e10
shear_stiffness = 0.5e10
friction_angle = 33.0
[[block]]
name = "base"
material = "stone"
fixed = true
box = {{ lower = [-1.0, -0.2, 0.0], size = [{length}, 0.2, 0.2] }}
[[dry_wall]]
name = "wall"
material = "stone"
bond = "running"
first_course = "half"
courses = {courses}
units_per_course = {units}
unit = [0.4, 0.2, 0.2]
{zones}
[[stage]]
name = "tilt"
gravity = [0.0, -9.81, 0.0]
collapse = {{ direction = [1, 0, 0] }}
[output]
frames = 0
"""
JOBS = {"limit, associated": (["limit", "--associated"], ""), "limit, without dilation": (["limit"], ""), "modes, rigid": (["modes"], ""),
        "modes, deformable": (["modes"], "rigid = false\nzone_edge = 0.2")}


def measure(words, scene):
    """Processor seconds and peak MB of a call; None: it took too long or failed."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)

    def bound():
        resource.setrlimit(resource.RLIMIT_CPU, (MOST_SECONDS, MOST_SECONDS))

    report = scene + ".time"
    status = subprocess.run(["/usr/bin/time", "-f", "%M", "-o", report, PROGRAM, words[0], scene, *words[1:]], preexec_fn=bound,
                            stdout=subprocess.DEVNULL).returncode
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if status != 0:
        return None
    with open(report, encoding="utf-8") as file:
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, float(file.read().split()[-1]) / 1024


def plot(folder):
    series = ", ".join(f"'sizes.dat' index {i} using 1:{{0}} with linespoints title '{name}'" for i, name in enumerate(JOBS))
    script = ("set terminal pngcairo size 1100,450\nset output 'sizes.png'\nset logscale xy\nset key left top\n"
              "set xlabel 'blocks'\nset format '10^{%T}'\nset multiplot layout 1,2\n"
              f"set ylabel 'processor time, s'\nplot {series.format(2)}\n"
              f"set ylabel 'peak memory, MB'\nplot {series.format(3)}\n")
    subprocess.run(["gnuplot"], input=script, text=True, cwd=folder, check=True)


def main(folder, sizes):
    os.makedirs(folder, exist_ok=True)
    rows = []
    for name, (words, zones) in JOBS.items():
        for blocks in sizes:
            courses = max(2, round((blocks / 2) ** 0.5))
            units = max(2, round(blocks / courses))
            scene = os.path.join(folder, f"wall_{blocks}.toml")
            with open(scene, "w", encoding="utf-8") as file:
                file.write(SCENE.format(length=0.4 * units + 2.0, courses=courses, units=units, zones=zones))
            found = measure(words, scene)
            if found is None:
                print(f"{name}, {blocks} blocks: none within {MOST_SECONDS} s", flush=True)
                break
            rows.append((name, courses * units, *found))
            print("{}, {} blocks: {:.2f} s, {:.0f} MB".format(*rows[-1]), flush=True)
    with open(os.path.join(folder, "sizes.csv"), "w", encoding="utf-8") as file:
        file.write("what,blocks,processor_s,peak_MB\n")
        file.writelines("\"{}\",{},{:.3f},{:.1f}\n".format(*row) for row in rows)
    with open(os.path.join(folder, "sizes.dat"), "w", encoding="utf-8") as file:
        file.write("\n\n\n".join("\n".join(f"{r[1]} {r[2]} {r[3]}" for r in rows if r[0] == name) for name in JOBS) + "\n")
    plot(folder)


if __name__ == "__main__":
    main(sys.argv[1], [int(n) for n in sys.argv[2:]] or [10, 30, 100, 300, 1000, 3000, 10000])
