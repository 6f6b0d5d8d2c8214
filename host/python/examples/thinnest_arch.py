"""How thick must an arch be to stand? Bisection on the thickness of a semicircular arch under its own weight; limit analysis
says 0.1075 of the mean radius (Heyman's, corrected by Milankovitch) for an arch of many voussoirs without sliding.

usage: thinnest_arch.py [VOUSSOIRS] [DIGITS of the ratio that are wanted]"""
import sys

import quoin

voussoirs = int(sys.argv[1]) if len(sys.argv) > 1 else 28
width = 10.0 ** -(int(sys.argv[2]) if len(sys.argv) > 2 else 3)
RADIUS = 1.0  # m, mean


def arch(thickness):
    scene = quoin.Scene(title=f"arch of {thickness:.4f} of its radius")
    scene.solver = dict(damping="local", local_damping=0.5)
    scene.materials.stone = quoin.BlockMaterial(density=2000.0, young_modulus=1e10, poisson_ratio=0.2)
    scene.joints.dry = quoin.Joint(law="coulomb_slip", initial_state="dry", normal_stiffness=1e11, shear_stiffness=1e11,
                                   friction_angle=45.0)
    scene.arch.append(quoin.Arch(name="arch", material="stone", radius=RADIUS, thickness=thickness * RADIUS, depth=0.2,
                                 voussoirs=voussoirs))
    scene.stage.append(quoin.Stage(name="weight", gravity=[0.0, -9.81, 0.0], ramp_time=0.05, duration=2.0))
    scene.output = dict(frames=0, record_interval=0.01)
    return scene


def stands(thickness):
    with quoin.Simulation(arch(thickness), threads=1) as sim:  # small models do not gain by more
        # Collapse: once anything has moved by a hundredth of the radius, the motion accelerates.
        sim.run(until=lambda s: s.time > 0 and s.measure()["largest_displacement_m"] > 0.01 * RADIUS, every=500)
        return sim.measure()["largest_displacement_m"] <= 0.01 * RADIUS


falls, holds = 0.05, 0.20
while holds - falls > width:
    middle = 0.5 * (falls + holds)
    falls, holds = (falls, middle) if stands(middle) else (middle, holds)
    print(f"thickness over radius between {falls:.4f} and {holds:.4f}", flush=True)
print(f"an arch of {voussoirs} voussoirs stands from {holds:.4f} of its radius on; limit analysis of many: 0.1075")
