"""host/scenes/cube_wall_*.toml in Yade:  yade -n -x cube_wall.py SCENE.toml --time-step SECONDS [options]

The law comes from its library by name; --law runs another one on the properties that it knows, --swap-law changes it
while the wall is loaded. Writes displacement and resistance of the top course, step by step.
"""
import argparse
import os
import sys
import time
import timeit
import tomllib

import numpy as np
from yade import *  # Yade gives scripts its names anyway; this line says so

here = os.path.dirname(os.path.abspath(sys.argv[0]))  # __file__ is Yade's own
sys.dont_write_bytecode = True
sys.path[:0] = [here, os.path.join(here, "../../python")]
import quoin
from engine import QuoinEngine
from joints import Joints


def arguments():
    parser = argparse.ArgumentParser(prog="cube_wall.py")
    parser.add_argument("scene")
    parser.add_argument("--time-step", type=float, required=True, help="s; the host's is in its summary.json")
    parser.add_argument("--laws", default=os.path.join(here, "../../../build/release/laws"), help="folder of the laws")
    parser.add_argument("--law", help="name of a law in place of the scene's")
    parser.add_argument("--swap-law", help="name of a law that takes over at --swap-at")
    parser.add_argument("--swap-at", type=float, default=0.0, help="displacement, m")
    parser.add_argument("--damping", choices=["yade", "host"], default="yade",
                        help="local damping by the sign of the velocity of now (yade), or of half a step ago (host)")
    parser.add_argument("--csv", default="cube_wall.csv")
    return parser.parse_args()


def make_material(folder, name, properties):
    """The law of that name, with those of the properties that it knows."""
    law = quoin.load(os.path.join(folder, name + ".so"))[0]
    known = {p.id.decode() for p in law.properties}
    return law.material(**{k: v for k, v in properties.items() if k in known})


def smooth_step(t):
    t = min(1.0, t)
    return t * t * t * (10 + t * (-15 + 6 * t))


class Wall:
    """The scene's cubes in stack bond, as bodies of Yade and points of the law."""

    def __init__(self, scene, material):
        wall = scene["wall"]
        self.size, self.rows, self.columns = np.array(wall["unit"]), wall["courses"], wall["units_per_course"]
        density = scene["materials"][wall["unit_material"]]["density"]
        cells = [(row, column) for row in range(self.rows) for column in range(self.columns)]
        self.centre = np.array([(column + 0.5, row + 0.5, 0.5) for row, column in cells]) * self.size
        self.ids = [self.add_body(centre, density) for centre in self.centre]
        self.bottom, self.top = self.ids[:self.columns], self.ids[-self.columns:]
        self.joints = self.make_joints(material)

    def add_body(self, centre, density):
        body, (x, y, z) = Body(), self.size
        body.state.mass = density * x * y * z
        body.state.inertia = Vector3(y * y + z * z, z * z + x * x, x * x + y * y) * body.state.mass / 12
        body.state.pos = body.state.refPos = Vector3(*centre)
        return O.bodies.append(body)

    def make_joints(self, material):
        """Four points a face: its corners, a quarter of the area each."""
        pairs = ([(i, i + 1, 0) for i in range(len(self.ids)) if (i + 1) % self.columns] +
                 [(i, i + self.columns, 1) for i in range(len(self.ids) - self.columns)])
        points = []
        for a, b, axis in pairs:
            s, t = (axis + 1) % 3, (axis + 2) % 3
            for corner in ((-1, -1), (1, -1), (-1, 1), (1, 1)):
                half = np.zeros(3)
                half[axis], half[s], half[t] = 1, *corner
                points.append((a, b, self.centre[a] + half * self.size / 2, np.eye(3)[axis],
                               self.size[s] * self.size[t] / 4))
        body_a, body_b, position, normal, area = (np.array(column) for column in zip(*points))
        return Joints(material, body_a, body_b, position, normal, area, self.centre)


class HostDampedEngine(QuoinEngine):
    """Local damping as Quoin's host has it."""
    gamma = 0.8

    def apply(self, force):
        velocity = np.array([(v[0], v[1], v[2], w[0], w[1], w[2])
                             for v, w in ((s.vel, s.angVel) for s in self.states)])
        super().apply(force - self.gamma * np.abs(force) * np.where(velocity < 0, -1.0, 1.0))


class Test:
    """The scene's stage: bottom course held, top course moved along x and free to rise."""

    def __init__(self, scene, options):
        self.options, stage = options, scene["stage"][0]
        family = scene["joints"][scene["wall"]["bed_joint"]]
        self.properties = {k: v for k, v in family.items() if k not in ("law", "initial_state")}
        self.wall = Wall(scene, make_material(options.laws, options.law or family["law"], self.properties))
        self.top = [O.bodies[i].state for i in self.wall.top]
        for i in self.wall.bottom:
            O.bodies[i].state.blockedDOFs = "xyzXYZ"
        for state in self.top:
            state.blockedDOFs = "xzXYZ"
        self.velocity = next(c["velocity"][0] for c in stage["control"] if c["body"] == "top_course")
        self.ramp, self.end = stage["ramp_time"], stage["displacement"]
        engine = HostDampedEngine if options.damping == "host" else QuoinEngine
        self.engine = engine(O, self.wall.joints, self.wall.ids)
        self.swapped = options.swap_law is None
        self.rows = []

    def displacement(self):
        return sum(state.displ()[0] for state in self.top) / len(self.top)

    def drive(self):
        speed = self.velocity * smooth_step((O.iter + 0.5) * O.dt / self.ramp)
        for state in self.top:
            state.vel = Vector3(speed, state.vel[1], 0)
        if not self.swapped and self.displacement() >= self.options.swap_at:
            self.wall.joints.swap(make_material(self.options.laws, self.options.swap_law, self.properties))
            self.swapped = True

    def record(self):
        displacement = self.displacement()
        self.rows.append((displacement, -self.engine.force[self.wall.top, 0].sum()))
        if displacement >= self.end:
            O.pause()

    def run(self):
        O.dt = self.options.time_step
        O.engines = [ForceResetter(), *(PyRunner(command=f"test.{each}()", iterPeriod=1, initRun=True)
                                        for each in ("drive", "engine", "record")),
                     NewtonIntegrator(damping=0.8 if self.options.damping == "yade" else 0.0)]
        start = time.perf_counter()
        O.run(wait=True)
        seconds = time.perf_counter() - start
        np.savetxt(self.options.csv, self.rows, delimiter=",", header="displacement_m,horizontal_force_N", comments="")
        peak = max(self.rows, key=lambda row: row[1])
        print(f"peak {peak[1] / 1e3:.3f} kN at {peak[0] * 1e3:.4f} mm; {len(self.rows)} steps in {seconds:.1f} s; law "
              f"{self.wall.joints.material.law.id}")

    def print_cost(self):
        """Of the adapter's parts, ns a point and step."""
        engine, joints = self.engine, self.wall.joints
        motion = engine.motion()
        cost = {name: min(timeit.repeat(part, number=100, repeat=5)) / 100 / len(joints.area) * 1e9
                for name, part in (("read", engine.motion), ("arrays", lambda: joints.forces(motion)),
                                   ("law", joints.step), ("write", lambda: engine.apply(engine.force)))}
        print(f"adapter, ns a point and step: motions read from Yade {cost['read']:.0f}, arrays "
              f"{cost['arrays'] - cost['law']:.0f}, law {cost['law']:.1f}, forces written to Yade {cost['write']:.0f}")


options = arguments()
with open(options.scene, "rb") as file:
    test = Test(tomllib.load(file), options)
test.run()
test.print_cost()
