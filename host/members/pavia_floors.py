"""What floors change of the Pavia building: none, boards, rigid in shear, under a push and under ground motion.

    /usr/bin/python3 host/members/pavia_floors.py out/pavia_floors

Runs host/scenes/pavia_floors.toml nine times, two minutes of two cores, and prints the table of host/members/README.md;
pavia_floors.csv and pavia_floors.png in the folder. Without floors their mass is on the walls that they span between.
"""
import csv
import json
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.environ.get("QUOIN", os.path.join(ROOT, "build/release/quoin"))
SCENE = os.path.join(ROOT, "host/scenes/pavia_floors.toml")
COURSES = {"first": 8, "roof": 17}
BEARINGS = {"B": [0, 3, 6, 9, 13, 15, 18, 21], "D": [0, 3, 6, 9, 14, 17, 20, 23]}
FLOORS = ("none", "boards", "rigid")
LOADS = ("push z", "shake z", "shake x")
SETTINGS = ["--set", "output.frames=2", "--set", "output.plots=false", "--set", "output.energy=true"]
PUSH = """
[[stage]]
name = "push"
ramp_time = 0.2
collapse = { direction = [0, 0, 1], start = 0.005, rate = 0.1, displacement = 0.05, limit = 0.6 }
"""


def without_floors(text):
    """Half of each floor's mass on either of the walls that it spans between."""
    beams = ""
    for floor in re.findall(r"\[\[floor\]\]\n(?:.+\n)+", text):
        name = re.search(r'name = "(\w+)"', floor).group(1)
        size = [max(map(float, re.search(key + r" = \[(.+?)\]", floor).group(1).split(",")))
                for key in ("along", "across")]
        mass = float(re.search(r"mass = ([\d.]+)", floor).group(1)) * size[0] * size[1] / 2
        text = text.replace(floor, "")
        for wall, places in BEARINGS.items():
            beams += (f'[[building.floor]]\nname = "{name}_{wall}"\nwall = "{wall}"\ncourse = {COURSES[name]}\n'
                      f"half_units = {places}\nrigid_beams = false\nmass = {mass:.1f}\n\n")
    return text.replace("[[stage]]", beams + "[[stage]]", 1)


def scene_of(text, floor, load):
    if floor == "none":
        text = without_floors(text)
    if floor == "rigid":
        text = text.replace("shear_stiffness = 1e6", "shear_stiffness = 1e9")
    if load == "push z":
        text = re.sub(r'\n\[\[stage\]\]\nname = "shake"\n(?:.+\n)+', PUSH, text)
    if load == "shake x":
        text = text.replace("direction = [0, 0, 1]", "direction = [1, 0, 0]")
    return text


def run(folder, floor, load):
    name = os.path.join(folder, f"{floor}_{load.replace(' ', '_')}")
    with open(SCENE) as file:
        text = scene_of(file.read(), floor, load)
    with open(name + ".toml", "w") as file:
        file.write(text)
    if not os.path.exists(os.path.join(name, "summary.json")):
        done = subprocess.run([PROGRAM, "run", name + ".toml", "--out", name, *SETTINGS], capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"{name}.toml: {done.stderr}")
    with open(os.path.join(name, "summary.json")) as file:
        summary = json.load(file)
    rows = {}
    for table in ("history", "monitors"):
        with open(os.path.join(name, table + ".csv")) as file:
            for row in csv.DictReader(file):
                rows.setdefault(int(row["step"]), {}).update(row)
    return summary, [row for row in rows.values() if row.get("stage") != "weight"]


def largest(rows, column):
    return max((abs(float(row[column])) for row in rows if row.get(column)), default=float("nan"))


def measured(summary, rows, load):
    along = load[-1]
    top = {wall: 1000 * largest(rows, f"{wall}_relative_d{along}_m") for wall in "BD"}
    energy = summary["energy_J"]
    shears = [c for c in rows[0] if c.endswith("_shear_N_per_m")]
    return {"multiplier": float(rows[-1]["multiplier"]) if load == "push z" else None, "B_mm": top["B"], "D_mm": top["D"],
            "shear_N_per_m": max((largest(rows, c) for c in shears), default=float("nan")),
            "joints_J": energy["dissipated"]}


def draw(folder, curves):
    """Displacement of the top of wall D over time, and over the multiplier of the push."""
    plots = {load: [] for load in LOADS}
    for (floor, load), rows in curves.items():
        data = os.path.join(folder, f"{floor}_{load.replace(' ', '_')}.dat")
        with open(data, "w") as file:
            for row in rows:
                x = row["multiplier"] if load == "push z" else row["time_s"]
                if row.get("D_relative_dz_m"):
                    file.write(f"{x} {1000 * float(row[f'D_relative_d{load[-1]}_m'])}\n")
        plots[load].append(f"'{data}' with lines lw 2 title '{floor}'")
    script = (f"set terminal pngcairo size 1200,400 font ',11'\nset output '{os.path.join(folder, 'pavia_floors.png')}'\n"
              "set multiplot layout 1,3\nset grid\nset key top left\n")
    for load in LOADS:
        across = "multiple of the weight along z" if load == "push z" else "time, s"
        script += (f"set title 'wall D, {load}'\nset xlabel '{across}'\n"
                   f"set ylabel 'top on the ground along {load[-1]}, mm'\nplot {', '.join(plots[load])}\n")
    subprocess.run(["gnuplot"], input=script, text=True, check=True)


def main(folder):
    os.makedirs(folder, exist_ok=True)
    curves, table = {}, []
    print("| load | floors | multiplier at 50 mm | top of B, mm | top of D, mm | shear in a floor, kN/m | dissipated by joints, J |")
    print("|---|---|---|---|---|---|---|")
    for load in LOADS:
        for floor in FLOORS:
            summary, rows = run(folder, floor, load)
            curves[floor, load] = rows
            found = measured(summary, rows, load)
            table.append({"load": load, "floors": floor, **found})
            multiplier = "" if found["multiplier"] is None else f"{found['multiplier']:.3f}"
            shear = "" if floor == "none" else f"{found['shear_N_per_m'] / 1000:.1f}"
            print(f"| {load} | {floor} | {multiplier} | {found['B_mm']:.2f} | {found['D_mm']:.2f} | {shear} | "
                  f"{found['joints_J']:.0f} |", flush=True)
    with open(os.path.join(folder, "pavia_floors.csv"), "w", newline="") as file:
        writer = csv.DictWriter(file, table[0].keys())
        writer.writeheader(), writer.writerows(table)
    draw(folder, curves)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "out/pavia_floors")
