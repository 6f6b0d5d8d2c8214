"""host/scenes/cube_wall_*.toml in Yade:  yade -n -x cube_wall.py SCENE.toml --time-step SECONDS [options]"""
import os
import sys
import time
import timeit

import numpy as np
from yade import *  # Yade defines its names in scripts also without this line

here = os.path.dirname(os.path.abspath(sys.argv[0]))  # __file__ is a file of Yade
sys.dont_write_bytecode = True
sys.path[:0] = [os.path.join(here, p) for p in (".", "../shared", "../../python")]  # an installed quoin is found by itself
import cube_scene
from engine import QuoinEngine
from joints import Joints


class HostDampedEngine(QuoinEngine):
    """Local damping as in Quoin's host: by the sign of the velocity half a step before."""

    def apply(self, force):
        velocity = np.array([(v[0], v[1], v[2], w[0], w[1], w[2])
                             for v, w in ((s.vel, s.angVel) for s in self.states)])
        super().apply(force - cube_scene.CubeWall.damping * np.abs(force) * np.where(velocity < 0, -1.0, 1.0))


class Test:
    def __init__(self, options):
        self.wall = wall = cube_scene.CubeWall(options)
        ids = [self.add_body(wall, centre) for centre in wall.centre]
        self.top = [O.bodies[ids[i]].state for i in wall.top]
        for i in wall.bottom:
            O.bodies[ids[i]].state.blockedDOFs = "xyzXYZ"
        for state in self.top:
            state.blockedDOFs = "xzXYZ"
        self.joints = Joints(wall.material, wall.body_a, wall.body_b, wall.position, wall.normal, wall.area,
                             wall.centre)
        engine = HostDampedEngine if options.damping == "host" else QuoinEngine
        self.engine = engine(O, self.joints, ids)
        O.dt = options.time_step
        O.engines = [ForceResetter(), *(PyRunner(command=f"test.{each}()", iterPeriod=1, initRun=True)
                                        for each in ("drive", "engine", "record")),
                     NewtonIntegrator(damping=wall.damping if options.damping == "yade" else 0.0)]

    @staticmethod
    def add_body(wall, centre):
        body = Body()
        body.state.mass, body.state.inertia = wall.mass, Vector3(*wall.inertia)
        body.state.pos = body.state.refPos = Vector3(*centre)
        return O.bodies.append(body)

    def displacement(self):
        return sum(state.displ()[0] for state in self.top) / len(self.top)

    def drive(self):
        speed = self.wall.speed(O.iter)
        for state in self.top:
            state.vel = Vector3(speed, state.vel[1], 0)
        self.wall.swap_when_due(self.joints, self.displacement())

    def record(self):
        if self.wall.record(self.displacement(), -self.engine.force[self.wall.top, 0].sum()):
            O.pause()

    def print_cost(self):
        """Measures the cost of the adapter's parts, ns for each point and step."""
        motion = self.engine.motion()
        cost = {name: min(timeit.repeat(part, number=100, repeat=5)) / 100 / len(self.joints.area) * 1e9
                for name, part in (("read", self.engine.motion), ("arrays", lambda: self.joints.forces(motion)),
                                   ("law", self.joints.step), ("write", lambda: self.engine.apply(self.engine.force)))}
        print(f"adapter, ns a point and step: motions read from Yade {cost['read']:.0f}, arrays "
              f"{cost['arrays'] - cost['law']:.0f}, law {cost['law']:.1f}, forces written to Yade {cost['write']:.0f}")


parser = cube_scene.parser("cube_wall.py")
parser.add_argument("--damping", choices=["yade", "host"], default="yade",
                    help="local damping by the sign of the velocity of now (yade), or of half a step ago (host)")
test = Test(parser.parse_args())
start = time.perf_counter()
O.run(wait=True)
test.wall.write(time.perf_counter() - start, test.joints)
test.print_cost()
