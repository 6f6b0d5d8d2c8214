"""Contact points with one Quoin law, in NumPy arrays, for any program with a Python interface: forces from jumps, and law
swaps. Displacements and rotations are small: frames do not rotate."""
import numpy as np


def frames(normal):
    """Returns (N, 3, 3): rows n, s, t, right-handed. s is the part perpendicular to n of the axis after the one that is
    nearest to n."""
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
        """Returns forces (3, N) along n, s, t from the current jumps u_B - u_A, and updates the states by one step."""
        np.add(jump[0], self.normal_shift, out=self.opening)
        np.subtract(jump[1:], self.jump[1:], out=self.slip)
        self.jump = jump
        batch = self.step()
        if batch.failed_count:
            raise RuntimeError(f"{self.material.law.id}: {batch.failed_count} of {len(self.area)} points failed")
        return self.traction * self.area

    def swap(self, material):
        """Changes to another law at constant traction. Raises with the law's reason where it cannot keep a traction."""
        self.state, shift = material.take_over(self.material, self.opening, self.traction, self.state)
        self.normal_shift += shift
        self.material = material
        self.step = material.prepare(self.opening, self.slip, self.traction, self.state)
