"""Contact points under one Quoin law, in NumPy arrays, for any program that is driven from Python: jumps in, forces
out, swap of the law. Displacements and rotations are small: frames stay as built."""
import numpy as np


def frames(normal):
    """(N, 3, 3): rows n, s, t, right-handed; s is the axis after the one that n is nearest to, made square to n."""
    axis = np.eye(3)[(np.abs(normal).argmax(1) + 1) % 3]
    s = axis - np.sum(axis * normal, 1)[:, None] * normal
    s /= np.linalg.norm(s, axis=1)[:, None]
    return np.stack([normal, s, np.cross(normal, s)], 1)


class JointPoints:
    def __init__(self, material, area, initial_state=None):
        self.material, self.area = material, area
        count = len(area)
        self.jump, self.traction = np.zeros((3, count)), np.zeros((3, count))
        self.normal_shift, self.opening, self.slip = np.zeros(count), np.zeros(count), np.zeros((2, count))
        self.state = material.initial_state(count, initial_state)
        self.step = material.prepare(self.opening, self.slip, self.traction, self.state)

    def forces_on_a(self, jump):
        """(3, N) along n, s, t from the jumps u_B - u_A along them, now; the states go one step on."""
        np.add(jump[0], self.normal_shift, out=self.opening)
        np.subtract(jump[1:], self.jump[1:], out=self.slip)
        self.jump = jump
        batch = self.step()
        if batch.failed_count:
            raise RuntimeError(f"{self.material.law.id}: {batch.failed_count} of {len(self.area)} points failed")
        return self.traction * self.area

    def swap(self, material):
        """Another law from now on, with every traction kept; refused with the law's reason where it cannot be."""
        self.state, shift = material.take_over(self.material, self.opening, self.traction, self.state)
        self.normal_shift += shift
        self.material = material
        self.step = material.prepare(self.opening, self.slip, self.traction, self.state)
