"""Limit loads of a vault, a dome and a bridge of quoin.shapes: the table of host/analysis/README.md.

    PYTHONPATH=build/release/python /usr/bin/python3 host/analysis/vaults.py
"""
import time

import quoin

KEYS = dict(material="stone")
SHAPES = {
    "arch: barrel_vault(2, 0.4, 1, 9, 1)": quoin.shapes.barrel_vault(2.0, 0.4, 1.0, 9, 1, **KEYS),
    "barrel_vault(2, 0.4, 2, 9, 2)": quoin.shapes.barrel_vault(2.0, 0.4, 2.0, 9, 2, **KEYS),
    "dome(3, 0.4, 4, 12), oculus 70": quoin.shapes.dome(3.0, 0.4, 4, 12, oculus=70.0, **KEYS),
    "arch_bridge(2, 3, 0.9, 0.35, 1, 9, 0.9, 1)": quoin.shapes.arch_bridge(2, 3.0, 0.9, 0.35, 1.0, 9, 0.9, 1.0, **KEYS),
}


def scene_of(blocks):
    scene = quoin.Scene(title="limit load")
    scene.materials.stone = quoin.BlockMaterial(density=2000.0, young_modulus=1e10, poisson_ratio=0.2)
    scene.joints.dry = quoin.Joint(law="coulomb_slip", initial_state="dry", normal_stiffness=1e10, shear_stiffness=5e9,
                                   friction_angle=35.0)
    scene.block = blocks
    scene.stage.append(quoin.Stage(name="weight", gravity=[0, -9.81, 0], duration=0.1))
    return scene


if __name__ == "__main__":
    print("| shape, friction tan(35) | free blocks | along | multiplier, associated | smallest scale of friction | s |")
    print("|---|---|---|---|---|---|")
    for name, blocks in SHAPES.items():
        free = sum(1 for block in blocks if not block.keys() & {"fixed"})
        for along, direction in (("x", (1, 0, 0)), ("z", (0, 0, 1))):
            before = time.process_time()
            found = quoin.limit(scene_of(blocks), direction=direction, facets=16, associated=True)
            print(f"| {name} | {free} | {along} | {found.multiplier:.4f} | {found.friction_scale:.3f} | "
                  f"{time.process_time() - before:.2g} |", flush=True)
