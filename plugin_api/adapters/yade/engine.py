"""A Quoin law as an engine of Yade, between ForceResetter and NewtonIntegrator:

    joints = QuoinEngine(O, Joints(...), ids)
    O.engines = [ForceResetter(), PyRunner(command="joints()", iterPeriod=1, initRun=True),
                 NewtonIntegrator(damping=0.8)]
"""
import numpy as np


class QuoinEngine:
    """`joints` numbers its bodies from 0; `ids` are their numbers in Yade."""

    def __init__(self, omega, joints, ids):
        self.joints, self.ids, self.container = joints, ids, omega.forces
        self.states = [omega.bodies[i].state for i in ids]
        self.force = np.zeros((len(ids), 6))  # forces and moments of the last step, N, N m

    def motion(self):
        return np.array([(u[0], u[1], u[2], w[0], w[1], w[2])
                         for u, w in ((s.displ(), s.rot()) for s in self.states)])

    def apply(self, force):
        for i, f in zip(self.ids, force.tolist()):
            self.container.addF(i, f[:3])
            self.container.addT(i, f[3:])

    def __call__(self):
        self.force = self.joints.forces(self.motion())
        self.apply(self.force)
