"""Runs of `quoin run` and their errors against stored references; shared by the programs of this folder."""

import csv
import json
import pathlib
import shutil
import subprocess
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent


# Walls as variations of a scene: name, scene, options that change it.
VARIED = {
    "cantilever": ("solid_wall_121", ["--set", "stage.shear.vertical=pressure"]),
    "weak_joints": ("solid_wall_030", ["--set", "joints.mortar.tensile_strength=0.1e6",
                                       "--set", "joints.mortar.cohesion=0.15e6",
                                       "--set", "joints.mortar.fracture_energy_tension=7.5",
                                       "--set", "joints.mortar.fracture_energy_shear=62.5"]),
    "strong_joints": ("solid_wall_121", ["--set", "joints.mortar.tensile_strength=0.4e6",
                                         "--set", "joints.mortar.cohesion=0.6e6",
                                         "--set", "joints.mortar.fracture_energy_tension=30",
                                         "--set", "joints.mortar.fracture_energy_shear=250",
                                         "--set", "joints.mortar.compressive_strength=10e6",
                                         "--set", "joints.mortar.fracture_energy_compression=16000"]),
    "stiff_wall": ("solid_wall_121", ["--set", "joints.mortar.normal_stiffness=164e9",
                                      "--set", "joints.mortar.shear_stiffness=72e9",
                                      "--set", "materials.brick.young_modulus=33.4e9"]),
    "stack_bond": ("solid_wall_121", ["--set", "wall.bond=stack"]),
    "tall_wall": ("solid_wall_121", ["--set", "wall.courses=32"]),
    "coulomb_slip": ("solid_wall_121", ["--law", "coulomb_slip"]),
}
# Walls that were not used to choose the settings of the qualities: their errors are those to expect of other walls. An
# exception is ispra_isp3, which showed a fault of the time step.
HELD_BACK = ["ispra_isp1", "ispra_isp3", "wall_2m_144", *VARIED]


def run(program, wall, settings, threads=2):
    """Runs a scene or a varied wall without pictures. Returns (summary, curve): the curve has rows (mm, kN) of the last
    stage."""
    scene, words = VARIED.get(wall, (wall, []))
    folder = tempfile.mkdtemp(prefix="quoin-")
    try:
        command = [str(program), "run", str(ROOT / "host" / "scenes" / f"{scene}.toml"), "--out", folder,
                   "--threads", str(threads), *words]
        for setting in settings:
            command += ["--set", setting]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            return {"status": "failed", "message": done.stderr.strip().splitlines()[-1]}, []
        summary = json.loads((pathlib.Path(folder) / "summary.json").read_text())
        return summary, read_history(pathlib.Path(folder) / "history.csv")
    finally:
        shutil.rmtree(folder)


def read_history(path):
    rows = list(csv.DictReader(open(path)))
    last = rows[-1]["stage"]
    return [(1e3 * float(r["displacement_m"]), 1e-3 * float(r["horizontal_force_N"])) for r in rows
            if r["stage"] == last]


def read_reference(name):
    with open(HERE / "reference" / f"{name}.csv") as file:
        return [tuple(map(float, line.split(","))) for line in file if not line.startswith(("#", "displacement"))]


def at(curve, x):
    """Returns the force at a displacement, linearly interpolated between rows."""
    low, high = 0, len(curve) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if curve[middle][0] <= x:
            low = middle
        else:
            high = middle
    (x0, f0), (x1, f1) = curve[low], curve[high]
    return f0 if x1 == x0 else f0 + (f1 - f0) * min(max((x - x0) / (x1 - x0), 0.0), 1.0)


def errors(curve, reference, points=2000):
    """Returns relative errors. peak: of the largest force. curve: root mean square of the difference over that of the
    force. work: of the work up to the end, nearly equal to the dissipated energy, since a broken wall stores little."""
    end = min(curve[-1][0], reference[-1][0])
    xs = [end * (i + 0.5) / points for i in range(points)]
    a, b = [at(curve, x) for x in xs], [at(reference, x) for x in xs]
    peak = max(f for x, f in reference if x <= end)
    return {"peak": max(f for x, f in curve if x <= end) / peak - 1.0,
            "curve": (sum((p - q) ** 2 for p, q in zip(a, b)) / sum(q * q for q in b)) ** 0.5,
            "work": sum(a) / sum(b) - 1.0}
