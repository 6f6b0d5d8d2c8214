"""Contact points between rigid bodies under one Quoin law, in arrays: motions of the bodies in, forces on them out.

Knows nothing of any code that moves the bodies. Displacements and rotations are small: frames and arms stay as built.
"""
import numpy as np


def frames(normal):
    """(N, 3, 3): rows n, s, t, right-handed; s is the axis after the one that n is nearest to, made square to n."""
    axis = np.eye(3)[(np.abs(normal).argmax(1) + 1) % 3]
    s = axis - np.sum(axis * normal, 1)[:, None] * normal
    s /= np.linalg.norm(s, axis=1)[:, None]
    return np.stack([normal, s, np.cross(normal, s)], 1)


class Joints:
    """Points from body a to body b. Motions and forces are (bodies, 6): along and about x, y, z of the centre."""

    def __init__(self, material, body_a, body_b, position, normal, area, centre, initial_state=None):
        self.material, self.area = material, area
        self.body_a, self.body_b, self.bodies = body_a, body_b, len(centre)
        axes = frames(normal)

        # Axis e at the end of the arm r sees the motion (u, theta) as e.u + (r x e).theta; the transpose of this map
        # takes tractions back to forces and moments.
        def seen_from(body):
            arm = (position - centre[body])[:, None, :]
            return np.concatenate([axes, np.cross(arm, axes)], 2).transpose(1, 0, 2).copy()  # (3, N, 6)

        self.map_a, self.map_b = seen_from(body_a), seen_from(body_b)
        self.ends = np.concatenate([body_a, body_b])
        count = len(area)
        self.jump, self.traction = np.zeros((3, count)), np.zeros((3, count))
        self.normal_shift, self.opening, self.slip = np.zeros(count), np.zeros(count), np.zeros((2, count))
        self.state = material.initial_state(count, initial_state)
        self.step = material.prepare(self.opening, self.slip, self.traction, self.state)

    def forces(self, motion):
        """Forces and moments on every body; the states go one step on."""
        jump = (np.einsum("kni,ni->kn", self.map_b, motion[self.body_b]) -
                np.einsum("kni,ni->kn", self.map_a, motion[self.body_a]))
        np.add(jump[0], self.normal_shift, out=self.opening)
        np.subtract(jump[1:], self.jump[1:], out=self.slip)
        self.jump = jump
        batch = self.step()
        if batch.failed_count:
            raise RuntimeError(f"{self.material.law.id}: {batch.failed_count} of {len(self.area)} points failed")
        weighted = self.traction * self.area
        parts = np.concatenate([np.einsum("kn,kni->ni", weighted, self.map_a),
                                -np.einsum("kn,kni->ni", weighted, self.map_b)])
        return np.stack([np.bincount(self.ends, column, self.bodies) for column in parts.T], 1)

    def swap(self, material):
        """Another law from now on, with every traction kept; refused with the law's reason where it cannot be."""
        self.state, shift = material.take_over(self.material, self.opening, self.traction, self.state)
        self.normal_shift += shift
        self.material = material
        self.step = material.prepare(self.opening, self.slip, self.traction, self.state)
