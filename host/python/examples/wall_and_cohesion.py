"""A wall tested to failure, its curve, another law, and a loop over cohesion. usage: wall_and_cohesion.py [SCENE] [PNG]"""
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import quoin

scene = quoin.Scene.load(sys.argv[1] if len(sys.argv) > 1 else "host/scenes/solid_wall_030.toml")
picture = sys.argv[2] if len(sys.argv) > 2 else "wall_and_cohesion.png"


def plot(scene, label):
    run = quoin.run(scene, frames=False)
    plt.plot(1e3 * run.history["displacement_m"], run.history["horizontal_force_N"] / 1e3, label=label)
    print(f"{label}: peak {run.peak[0] / 1e3:.2f} kN at {run.peak[1] * 1e3:.3f} mm")


for cohesion in (0.2e6, 0.3e6, 0.4e6):
    scene.joints.mortar.cohesion = cohesion
    plot(scene, f"cohesion {cohesion / 1e6:g} MPa")
scene.joints.mortar = quoin.Joint(law="elastic", normal_stiffness=82e9, shear_stiffness=36e9)
plot(scene, "elastic")
plt.xlabel("displacement [mm]"), plt.ylabel("force [kN]"), plt.legend()
plt.savefig(picture)
