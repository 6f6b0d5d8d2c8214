"""quoin.py drives the laws: usage python_host.py MODULE_DIR LAW_DIR OUTPUT_DIR. Exit 77: skipped."""
import sys

try:
    import numpy as np
except ImportError:
    print("skipped: NumPy is not installed")
    sys.exit(77)
sys.dont_write_bytecode = True
sys.path.insert(0, sys.argv[1])
import quoin

laws, output = sys.argv[2], sys.argv[3]
elastic = quoin.load(f"{laws}/elastic.so")[0]
print(elastic)
material = elastic.material(normal_stiffness=4e10, shear_stiffness=2e10)
assert material.number("normal_stiffness") == 4e10

# Arrays in place: a record array, and a view with negative stride.
points = np.zeros(1000, dtype=[("area", float), ("d_n", float), ("sigma", float), ("tau_s", float), ("tau_t", float)])
points["d_n"] = np.linspace(-1e-5, 1e-5, 1000)
traction = [points[f] for f in ("sigma", "tau_s", "tau_t")]
slip = [np.full(1000, 1e-6), np.zeros(1000)]
batch = material.evaluate(points["d_n"], slip, traction, material.initial_state(1000))
assert batch.failed_count == 0
np.testing.assert_allclose(points["sigma"], 4e10 * points["d_n"], rtol=1e-14)
np.testing.assert_allclose(points["tau_s"], 2e4, rtol=1e-14)
back = [a[::-1] for a in (np.zeros(1000), np.zeros(1000), np.zeros(1000))]
material.evaluate(points["d_n"][::-1], slip, back, material.initial_state(1000))
np.testing.assert_array_equal(back[0], points["sigma"][::-1])
try:
    elastic.material(normal_stiffness=-1, shear_stiffness=-2)
    raise AssertionError("accepted")
except quoin.Refused as refused:
    assert "normal_stiffness" in str(refused) and "shear_stiffness" in str(refused), refused

# The tension curve of Table 1 encloses G1 (trapezoid over the curve).
fracture = quoin.load(f"{laws}/fracture_energy.so")[0]
mortar = fracture.material(normal_stiffness=82e9, shear_stiffness=36e9, tensile_strength=0.2e6, cohesion=0.3e6,
                           friction_angle=35, compressive_strength=5e6, fracture_energy_tension=15,
                           fracture_energy_shear=125, fracture_energy_compression=8000)
path = mortar.drive(normal=np.linspace(0, 2e-4, 4000))
area = np.trapz(path.sigma, path.normal)
print(f"tension: peak {path.sigma.max():.6g} Pa, area {area:.6g} J/m2, law's own dissipation "
      f"{path.dissipated['tension'][-1]:.12g} J/m2")
assert abs(area - 15) < 0.02 and abs(path.dissipated["tension"][-1] - 15) < 1e-10
# A law swapped half-way down the softening curve keeps every traction.
normal, none = np.linspace(0, 1e-4, 11), [np.zeros(11), np.zeros(11)]
traction, state = [np.zeros(11) for _ in range(3)], mortar.initial_state(11)
mortar.evaluate(normal, none, traction, state)
before = traction[0].copy()
successor = quoin.load(f"{laws}/elastic.so")[0].material(normal_stiffness=82e9, shear_stiffness=36e9)
state, shift = successor.take_over(mortar, normal, traction, state)
successor.evaluate(normal + shift, none, traction, state)
assert before.max() > 0.1e6
np.testing.assert_allclose(traction[0], before, rtol=1e-9, atol=1e-6)
try:
    import matplotlib
    path.plot(f"{output}/tension.png")
    print(f"plotted {output}/tension.png")
except ImportError:
    print("not plotted: matplotlib is not installed")
