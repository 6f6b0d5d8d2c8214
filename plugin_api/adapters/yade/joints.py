"""Contact points between rigid bodies: forces and moments on the bodies from their motions. Independent of Yade."""
import numpy as np

from joint_points import JointPoints, frames


class Joints(JointPoints):
    """Contact points from body a to body b. Motions and forces are (bodies, 6): along and about x, y, z at the centre."""

    def __init__(self, material, body_a, body_b, position, normal, area, centre, initial_state=None):
        super().__init__(material, area, initial_state)
        self.body_a, self.body_b, self.bodies = body_a, body_b, len(centre)
        self.ends = np.concatenate([body_a, body_b])
        axes = frames(normal)

        # The displacement along axis e at the arm r by the motion (u, theta) is e.u + (r x e).theta. The transpose of
        # this map gives forces and moments from tractions.
        def seen_from(body):
            arm = (position - centre[body])[:, None, :]
            return np.concatenate([axes, np.cross(arm, axes)], 2).transpose(1, 0, 2).copy()  # (3, N, 6)

        self.map_a, self.map_b = seen_from(body_a), seen_from(body_b)

    def forces(self, motion):
        """Returns forces and moments on every body and updates the states by one step."""
        force = self.forces_on_a(np.einsum("kni,ni->kn", self.map_b, motion[self.body_b]) -
                                 np.einsum("kni,ni->kn", self.map_a, motion[self.body_a]))
        parts = np.concatenate([np.einsum("kn,kni->ni", force, self.map_a),
                                -np.einsum("kn,kni->ni", force, self.map_b)])
        return np.stack([np.bincount(self.ends, column, self.bodies) for column in parts.T], 1)
