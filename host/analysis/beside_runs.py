"""Limit loads beside runs of the same scenes: the tables of host/analysis/README.md.

    PYTHONPATH=build/release/python /usr/bin/python3 host/analysis/beside_runs.py [word ...]

Every scene of host/scenes with a dry joint, and vaults, a dome and a bridge of quoin.shapes; words: only what has one in
its name. A run starts from what limit analysis finds (start = "limit"), along the direction of the scene's collapse stage,
else along x. CPU s: processor time of both.
"""
import copy
import glob
import os
import sys
import time

import quoin

SCENES = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "scenes")
KEYS = dict(material="stone")
ARCH = quoin.shapes.barrel_vault(2.0, 0.4, 1.0, 9, 1, **KEYS)
VAULT = quoin.shapes.barrel_vault(2.0, 0.4, 2.0, 9, 2, **KEYS)
DOME = quoin.shapes.dome(3.0, 0.4, 4, 12, oculus=70.0, **KEYS)
BRIDGE = quoin.shapes.arch_bridge(2, 3.0, 0.9, 0.35, 1.0, 9, 0.9, 1.0, **KEYS)
SHAPES = {"arch: barrel_vault(2, 0.4, 1, 9, 1), x": (ARCH, (1, 0, 0)),
          "barrel_vault(2, 0.4, 2, 9, 2), x": (VAULT, (1, 0, 0)), "barrel_vault(2, 0.4, 2, 9, 2), z": (VAULT, (0, 0, 1)),
          "dome(3, 0.4, 4, 12, oculus=70), x": (DOME, (1, 0, 0)),
          "arch_bridge(2, 3, 0.9, 0.35, 1, 9, 0.9, 1), x": (BRIDGE, (1, 0, 0)),
          "arch_bridge(2, 3, 0.9, 0.35, 1, 9, 0.9, 1), z": (BRIDGE, (0, 0, 1))}


def scene_of(blocks, direction):
    scene = quoin.Scene(title="limit load")
    scene.materials.stone = quoin.BlockMaterial(density=2000.0, young_modulus=1e10, poisson_ratio=0.2)
    scene.joints.dry = quoin.Joint(law="coulomb_slip", initial_state="dry", normal_stiffness=1e10, shear_stiffness=5e9,
                                   friction_angle=35.0)
    scene.block = blocks
    scene.stage.append(quoin.Stage(name="weight", gravity=[0, -9.81, 0], ramp_time=0.1, duration=0.2))
    scene.stage.append(quoin.Stage(name="push", collapse=dict(direction=list(direction))))
    return scene


def is_dry(scene):
    joints = [scene.joints[name] for name in scene.joints]
    return any("initial_state" in joint and joint.initial_state == "dry" for joint in joints)


def pushed(scene, direction):
    """The scene at rest under its weight, then pushed along the direction as limit analysis has it."""
    scene = copy.deepcopy(scene)
    stages = [stage for stage in scene.stage if "collapse" not in stage]
    push = quoin.Stage(name="push", collapse=dict(direction=list(direction), start="limit"))
    scene.stage = [stages[0], push]
    scene.output = dict(frames=0, plots=False, energy=False)
    return scene


def row_of(name, scene, **facets):
    before = time.process_time()
    try:
        found = quoin.limit(scene, **facets)
    except quoin.Error as error:
        return f"| {name} | refused: {' '.join(str(error).split(': ')[-1].split())} | | | | | |"
    direction = found.summary["direction"] or [1.0, 0.0, 0.0]
    if found.multiplier is None:
        found = quoin.limit(scene, direction=direction, **facets)
    limit = time.process_time() - before
    try:
        simulation = quoin.Simulation(pushed(scene, direction), threads=1)
        simulation.run()
        run, lag = simulation.collapse_multiplier, simulation.collapse_lag
    except quoin.Error as error:
        run, lag = None, str(error)
    seconds = time.process_time() - before - limit
    best = found.multiplier_without_dilation or found.multiplier
    without = "not settled" if found.multiplier_without_dilation is None else f"{found.multiplier_without_dilation:.4f}"
    along = ", ".join(f"{c:g}" for c in direction)
    ran = f"{run:.4f} (-{lag:.4f}) | {100 * (run / best - 1):+.1f} %" if run is not None else f"{lag} |"
    return (f"| {name} | {along} | {found.multiplier:.4f} | {without} | {ran} | {found.friction_scale:.3f} | "
            f"{limit:.1f}, {seconds:.1f} |")


if __name__ == "__main__":
    words = sys.argv[1:]
    print("| scene | along | associated | without dilation | run (lag) | run against it | least friction | CPU s |")
    print("|---|---|---|---|---|---|---|---|")
    for file in sorted(glob.glob(os.path.join(SCENES, "*.toml"))):
        name = os.path.basename(file)
        if words and not any(word in name for word in words):
            continue
        scene = quoin.Scene.load(file)
        if is_dry(scene):
            print(row_of(name, scene), flush=True)
    for name, (blocks, direction) in SHAPES.items():
        if not words or any(word in name for word in words):
            print(row_of(name, scene_of(blocks, direction), facets=16), flush=True)
