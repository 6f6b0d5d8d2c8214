"""host/scenes/cube_wall_*.toml for other programs: the scene in arrays, its loading, the law by name, the curve.

The bottom course is fixed. The top course moves along x and may rise, without rotation. All other cubes are free, with
local damping of 0.8."""
import argparse
import os
import tomllib

import numpy as np
import quoin

here = os.path.dirname(os.path.abspath(__file__))
BUILT = os.path.join(here, "../../../build/release/laws")  # of a source tree


def parser(program):
    result = argparse.ArgumentParser(prog=program)
    result.add_argument("scene")
    result.add_argument("--time-step", type=float, required=True, help="s; the host's is in its summary.json")
    result.add_argument("--laws", default=BUILT if os.path.isdir(BUILT) else None,
                        help="folder of the laws; default: build/release/laws, else the search path of quoin.Law")
    result.add_argument("--law", help="name of a law in place of the scene's")
    result.add_argument("--swap-law", help="name of a law that takes over at --swap-at")
    result.add_argument("--swap-at", type=float, default=0.0, help="displacement, m")
    result.add_argument("--csv", default="cube_wall.csv")
    return result


class CubeWall:
    damping = 0.8

    def __init__(self, options):
        with open(options.scene, "rb") as file:
            scene = tomllib.load(file)
        self.options, wall, stage = options, scene["wall"], scene["stage"][0]
        family = scene["joints"][wall["bed_joint"]]
        self.properties = {k: v for k, v in family.items() if k not in ("law", "initial_state")}
        self.material = self.make_material(options.law or family["law"])
        self.velocity = next(c["velocity"][0] for c in stage["control"] if c["body"] == "top_course")
        self.ramp, self.end = stage["ramp_time"], stage["displacement"]

        self.size, columns, courses = np.array(wall["unit"]), wall["units_per_course"], wall["courses"]
        count = columns * courses
        self.centre = np.array([(i % columns + 0.5, i // columns + 0.5, 0.5) for i in range(count)]) * self.size
        self.bottom, self.top = np.arange(columns), np.arange(count - columns, count)
        self.mass = float(scene["materials"][wall["unit_material"]]["density"] * self.size.prod())
        self.inertia = self.mass * (np.sum(self.size**2) - self.size**2) / 12
        self.make_points([(i, i + 1, 0) for i in range(count) if (i + 1) % columns] +
                         [(i, i + columns, 1) for i in range(count - columns)])
        self.rows, self.swapped = [], options.swap_law is None

    def make_points(self, pairs):
        """Returns four contact points for each face, at its corners, with a quarter of its area each."""
        points = []
        for a, b, axis in pairs:
            s, t = (axis + 1) % 3, (axis + 2) % 3
            for corner in ((-1, -1), (1, -1), (-1, 1), (1, 1)):
                half = np.zeros(3)
                half[axis], half[s], half[t] = 1, *corner
                points.append((a, b, self.centre[a] + half * self.size / 2, np.eye(3)[axis],
                               self.size[s] * self.size[t] / 4))
        self.body_a, self.body_b, self.position, self.normal, self.area = (np.array(c) for c in zip(*points))

    def make_material(self, name):
        """Returns a material of the law of that name, with those properties of the scene that the law has."""
        law = quoin.find(os.path.join(self.options.laws, name + ".so") if self.options.laws else name)
        known = {p.id.decode() for p in law.properties}
        return law.material(**{k: v for k, v in self.properties.items() if k in known})

    def speed(self, step):
        """Returns the speed of the top course between this step and the next, m/s; smooth over the ramp."""
        t = min(1.0, (step + 0.5) * self.options.time_step / self.ramp)
        return self.velocity * t * t * t * (10 + t * (-15 + 6 * t))

    def swap_when_due(self, joints, displacement):
        if not self.swapped and displacement >= self.options.swap_at:
            joints.swap(self.make_material(self.options.swap_law))
            self.swapped = True

    def record(self, displacement, resistance):
        """Records displacement and resistance of the top course. Returns True at the end of the test."""
        self.rows.append((displacement, resistance))
        return displacement >= self.end

    def write(self, seconds, joints):
        np.savetxt(self.options.csv, self.rows, delimiter=",", header="displacement_m,horizontal_force_N", comments="")
        peak = max(self.rows, key=lambda row: row[1])
        print(f"peak {peak[1] / 1e3:.3f} kN at {peak[0] * 1e3:.4f} mm; {len(self.rows)} steps in {seconds:.1f} s; law "
              f"{joints.material.law.id}")
