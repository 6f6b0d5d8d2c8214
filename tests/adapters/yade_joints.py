"""Joints of the Yade adapter, without Yade: usage yade_joints.py PLUGIN_API LAW_DIR. Exit 77: skipped."""
import sys

try:
    import numpy as np
except ImportError:
    print("skipped: NumPy is not installed")
    sys.exit(77)
sys.dont_write_bytecode = True
sys.path[:0] = [sys.argv[1] + folder for folder in ("/python", "/adapters/shared", "/adapters/yade")]
import quoin
from joint_points import frames
from joints import Joints

laws = sys.argv[2]
elastic = quoin.load(f"{laws}/elastic.so")[0].material(normal_stiffness=82e9, shear_stiffness=36e9)
mortar = quoin.load(f"{laws}/fracture_energy.so")[0].material(
    normal_stiffness=82e9, shear_stiffness=36e9, tensile_strength=0.2e6, cohesion=0.3e6, friction_angle=35,
    fracture_energy_tension=15, fracture_energy_shear=125)
random = np.random.default_rng(1)

# Frames are right-handed and orthonormal; along the axes s is the next axis.
normal = random.normal(size=(50, 3))
normal /= np.linalg.norm(normal, axis=1)[:, None]
square = frames(normal)
np.testing.assert_allclose(np.einsum("nij,nkj->nik", square, square), np.broadcast_to(np.eye(3), (50, 3, 3)), atol=1e-14)
np.testing.assert_allclose(np.linalg.det(square), 1, rtol=1e-14)
np.testing.assert_allclose(frames(np.eye(3))[:, 1], np.eye(3)[[1, 2, 0]], atol=1e-16)

# Five bodies, points anywhere, normals oblique.
body_a, body_b = random.integers(0, 3, 50), random.integers(3, 5, 50)
position, centre = random.uniform(size=(50, 3)), random.uniform(size=(5, 3))
area = random.uniform(0.001, 0.01, 50)


def net(material):
    return Joints(material, body_a, body_b, position, normal, area, centre)


# A common rigid motion of all bodies causes no jumps. For other motions the sum of forces and of moments is 0.
u, theta = random.normal(size=3) * 1e-6, random.normal(size=3) * 1e-6
together = np.hstack([u + np.cross(theta, centre), np.broadcast_to(theta, (5, 3))])
assert np.abs(net(elastic).forces(together)).max() < 1e-6
motion = random.normal(size=(5, 6)) * 1e-6
force = net(mortar).forces(motion)
assert np.abs(force).max() > 100
scale = np.abs(force).sum()
assert np.abs(force[:, :3].sum(0)).max() < 1e-12 * scale
assert np.abs((force[:, 3:] + np.cross(centre, force[:, :3])).sum(0)).max() < 1e-12 * scale

# Elastic forces are minus the gradient of the stored energy.
def energy(motion):
    joints = net(elastic)
    joints.forces(motion)
    return 0.5 * np.sum(joints.traction * joints.jump * area)


difference, step = np.zeros((5, 6)), 1e-9
for i in np.ndindex(5, 6):
    ahead, behind = motion.copy(), motion.copy()
    ahead[i] += step
    behind[i] -= step
    difference[i] = -(energy(ahead) - energy(behind)) / (2 * step)
np.testing.assert_allclose(net(elastic).forces(motion), difference, rtol=1e-6, atol=1e-6 * scale)

# A law swap keeps every traction; a law that cannot carry a traction refuses.
joints = net(mortar)
before = joints.forces(motion)
joints.swap(elastic)
np.testing.assert_allclose(joints.forces(motion), before, rtol=1e-9, atol=1e-9 * scale)
brittle = quoin.load(f"{laws}/coulomb_slip.so")[0].material(
    normal_stiffness=82e9, shear_stiffness=36e9, tensile_strength=10.0, cohesion=10.0, friction_angle=35)
try:
    joints.swap(brittle)
    raise AssertionError("tractions beyond the strength were taken over")
except quoin.Refused as refused:
    print(refused)
assert joints.material is elastic
