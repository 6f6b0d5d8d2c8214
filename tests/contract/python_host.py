"""Laws through the Python package without the host. Usage: python_host.py MODULE_DIR LAW_DIR OUTPUT_DIR. Exit 77: skipped."""
import os
import shutil
import sys
import warnings

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

# A law that is built again under the same path is the new one, and the old one stays in use. One that was cut off is refused.
rebuilt = f"{output}/rebuilt_law.so"
shutil.copyfile(f"{laws}/elastic.so", rebuilt)
first = quoin.load(rebuilt)[0].material(normal_stiffness=4e10, shear_stiffness=2e10)
shutil.copyfile(f"{laws}/coulomb_slip.so", rebuilt)
assert quoin.load(rebuilt)[0].id == "coulomb_slip"
assert first.law.id == "elastic" and first.number("normal_stiffness") == 4e10
os.truncate(rebuilt, 8000)
try:
    quoin.load(rebuilt)
    raise AssertionError("loaded")
except quoin.Refused as refused:
    assert rebuilt in str(refused) and "the file has 8000 bytes of" in str(refused), refused

# The area under the tension curve of Table 1 is G1 (trapezoidal rule).
fracture = quoin.load(f"{laws}/fracture_energy.so")[0]
mortar = fracture.material(normal_stiffness=82e9, shear_stiffness=36e9, tensile_strength=0.2e6, cohesion=0.3e6,
                           friction_angle=35, compressive_strength=5e6, fracture_energy_tension=15,
                           fracture_energy_shear=125, fracture_energy_compression=8000)
path = mortar.drive(normal=np.linspace(0, 2e-4, 4000))
area = np.trapz(path.sigma, path.normal)
print(f"tension: peak {path.sigma.max():.6g} Pa, area {area:.6g} J/m2, law's own dissipation "
      f"{path.dissipated['tension'][-1]:.12g} J/m2")
assert abs(area - 15) < 0.02 and abs(path.dissipated["tension"][-1] - 15) < 1e-10

# The tangent of joints without shear is the difference quotient: open without strength, closed, crushing, crushed out. Tolerance 1e-6
# of the shear stiffness.
strong = dict(normal_stiffness=82e9, shear_stiffness=36e9, tensile_strength=0.2e6, cohesion=0.3e6, friction_angle=35)
fractures = dict(fracture_energy_tension=15, fracture_energy_shear=125, compressive_strength=1e7,
                 fracture_energy_compression=20000)
for name, more in (("coulomb_slip", {}), ("fracture_energy", fractures), ("cyclic_joint", fractures)):
    law = quoin.load(f"{laws}/{name}.so")[0]
    joint = law.material(**strong, **more)
    def sheared(opening, slip):
        tractions, entries = [np.zeros(1) for _ in range(3)], [np.zeros(1) for _ in range(9)]
        joint.evaluate(np.array([opening]), [np.array([slip]), np.zeros(1)], tractions, joint.initial_state(1, "dry"),
                       tangent=entries)
        return tractions[1][0], [entry[0] for entry in entries]
    for opening in (1e-4, -1e-5, -3e-4, -2e-2):
        tangent, step = sheared(opening, 0.0)[1], 1e-10
        quotient = (sheared(opening, step)[0] - sheared(opening, -step)[0]) / (2 * step)
        for entry in (tangent[4], tangent[8]):
            assert abs(entry - quotient) < 1e-6 * 36e9, (name, opening, tangent, quotient)
        assert opening > 0 or opening < -1e-3 or quotient > 1e9, (name, opening, quotient)

# Damage stays where another law takes over: of a broken joint that stands open, and of one that has half softened.
cyclic, fracture_joint, brittle = (
    quoin.load(f"{laws}/{name}.so")[0].material(**strong, **({} if name == "coulomb_slip" else fractures))
    for name in ("cyclic_joint", "fracture_energy", "coulomb_slip"))
def stress_of(joint, opening, state):
    tractions = [np.zeros(1) for _ in range(3)]
    joint.evaluate(np.array([opening]), [np.zeros(1)] * 2, tractions, state)
    return tractions[0][0], tractions
for initial, opening in (("dry", 3e-4), ("bonded", 4e-5)):
    of_cyclic = cyclic.initial_state(1, initial)
    stress, tractions = stress_of(cyclic, opening, of_cyclic)
    taken, shift = fracture_joint.take_over(cyclic, np.array([opening]), tractions, of_cyclic)
    xi = of_cyclic[cyclic.law.state_ids.index("xi")][0]
    assert xi > 0.1 and [taken[k][0] for k in (0, 1)] == [xi, xi], (xi, taken)
    assert abs(stress_of(fracture_joint, opening + shift[0], taken)[0] - stress) < 1.0
    assert stress_of(fracture_joint, opening + shift[0] + 1e-4, taken)[0] <= stress
    assert initial == "bonded" or shift[0] == 0.0
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        states, shift = brittle.take_over(cyclic, np.array([opening]), tractions, of_cyclic)
    assert [len(said), states[0][0]] == ([0, 1.0] if initial == "dry" else [1, 0.0]), (initial, said, states)

# A path is bitwise identical to single steps, with sliding in both directions.
walk = np.cumsum(np.random.default_rng(7).normal(scale=2e-6, size=(3, 300)), axis=1)
walk[0] = 1e-5 * np.sin(np.arange(300) / 30)
path = mortar.drive(*walk)
point, state, stored, dissipated = ([np.zeros(1) for _ in range(3)], mortar.initial_state(1), np.zeros(1),
                                    [np.zeros(1) for _ in range(4)])
total, last = np.zeros(4), np.zeros(2)
for i, now in enumerate(walk.T):
    slip = [np.array([a - b]) for a, b in zip(now[1:], last)]
    mortar.evaluate(now[:1].copy(), slip, point, state, energy_stored=stored, dissipated=dissipated)
    last, total = now[1:], total + [d[0] for d in dissipated]
    row = [path.sigma[i], path.tau_s[i], path.tau_t[i], *(v[i] for v in path.state.values()), path.stored[i],
           *(v[i] for v in path.dissipated.values())]
    assert row == [a[0] for a in point + state] + [stored[0]] + total.tolist(), i
assert path.dissipated["friction"][-1] > 0 and path.dissipated["tension"][-1] > 0

# Prescribed stresses. Elastic: stress over stiffness.
ramp = np.linspace(0, 1e6, 11)
path = material.drive(sigma=-ramp, tau_s=ramp / 2, tau_t=ramp / 3)
for got, closed in ((path.normal, -ramp / 4e10), (path.s, ramp / 2 / 2e10), (path.t, ramp / 3 / 2e10)):
    np.testing.assert_allclose(got, closed, rtol=1e-10)  # tolerance of prescribed stresses
# A dry joint at constant pressure: elastic, then slip at mu sigma; the pressure does not change.
slide, pressure = np.linspace(0, 1e-4, 1001), 1e6
joint = {"normal_stiffness": 82e9, "shear_stiffness": 36e9, "tensile_strength": 0.2e6, "cohesion": 0.3e6,
         "friction_angle": 35}
coulomb = quoin.load(f"{laws}/coulomb_slip.so")[0].material(**joint)
path = coulomb.drive(sigma=-pressure, s=slide, initial_state="dry")
friction = np.tan(np.radians(35)) * pressure
np.testing.assert_allclose(path.tau_s, np.minimum(36e9 * slide, friction), rtol=1e-10)
np.testing.assert_allclose(path.normal, -pressure / 82e9, rtol=1e-10)
assert len(path) == 1001 and (path.t == 0).all() and (path.s == slide).all()
# Bonded mortar at this pressure: the work of the shear stress above friction is G2, less an elastic term.
path = mortar.drive(sigma=-pressure, s=np.linspace(0, 3e-3, 3001))
work = np.trapz(path.tau_s - friction, path.s)
assert abs(work - (125 - friction**2 / (2 * 36e9))) < 0.01 * 125, work  # 1000 steps over the softening
np.testing.assert_allclose(path.sigma, -pressure, rtol=1e-10)
# Displacements found for prescribed stresses give these stresses: unloading, shear with pressure, without a tangent.
for tangents in (True, False):
    mortar.law.capabilities ^= 0 if tangents else quoin.law.TANGENT
    up = np.concatenate([np.linspace(0, 1, 20), np.linspace(1, 0.2, 10)])
    pressed = mortar.drive(sigma=-4e6 * up, tau_s=2e6 * up, tau_t=1e6 * up)
    moved = mortar.drive(pressed.normal, pressed.s, pressed.t)
    np.testing.assert_allclose(moved.sigma, -4e6 * up, rtol=1e-9, atol=1e-3)
    np.testing.assert_allclose(moved.tau_s, 2e6 * up, rtol=1e-9, atol=1e-3)
    np.testing.assert_allclose(moved.tau_t, 1e6 * up, rtol=1e-9, atol=1e-3)
mortar.law.capabilities |= quoin.law.TANGENT
# Without a slope, where steps with the stiffness are far too short, bisection finds the root; at a discontinuity none.
visited = []


def cube(x):
    visited.append(x)
    return x**3 - 8, np.nan


assert quoin.law._solve(cube, lambda: abs(visited[-1]**3 - 8) < 1e-9, 0.0, 1e4) and abs(visited[-1] - 2) < 1e-10
assert not quoin.law._solve(lambda x: (visited.append(x) or (-1 if x < 2 else 1), np.nan), lambda: False, 0.0, 1e4)


def fails(kind, words, call, *arguments, **named):
    try:
        call(*arguments, **named)
    except kind as error:
        assert words in str(error), (words, str(error))
    else:
        raise AssertionError(f"accepted: {words}")


# An error has the parameter and the value at fault, and the path does not return old stresses.
fails(ValueError, "s[2] is nan", mortar.drive, normal=np.zeros(4), s=[0, 0, np.nan, 0])
fails(ValueError, "sigma[1] is -inf", mortar.drive, sigma=[0, -np.inf])
fails(ValueError, "s has 3 values, where normal has 5", mortar.drive, normal=np.zeros(5), s=np.zeros(3))
fails(ValueError, "normal and sigma", mortar.drive, normal=[0.0], sigma=[0.0])
fails(ValueError, "nothing is prescribed", mortar.drive)
fails(ValueError, "normal: a number or a one-dimensional array", mortar.drive, normal=np.zeros((2, 2)))
fails(KeyError, "'wet'", mortar.drive, normal=[0.0], initial_state="wet")
fails(ArithmeticError, "fails in step 1", mortar.drive, normal=[0.0, 1e308])  # its stress is not finite
fails(quoin.NotReached, "sigma[2] = 210000 Pa", mortar.drive, sigma=[0, 1.9e5, 2.1e5])
fails(quoin.NotReached, "sigma[0] = -6e+06 Pa", mortar.drive, sigma=-6e6)
fails(quoin.NotReached, "tau_s[3] = 1.5e+06 Pa", mortar.drive, sigma=-pressure, tau_s=np.linspace(0, 2e6, 5))
five, three = np.zeros(5), [np.zeros(5) for _ in range(3)]
fails(ValueError, "slip[1] has 4 values", mortar.prepare, five, [five, np.zeros(4)], three, mortar.initial_state(5))
fails(ValueError, "state: 0 arrays", mortar.prepare, five, three[:2], three, [])
fails(ValueError, "slip: 3 arrays, where 2", mortar.prepare, five, three, three, mortar.initial_state(5))
fails(TypeError, "traction[0]: a column", mortar.prepare, five, three[:2], [[0.0] * 5] * 3, mortar.initial_state(5))
fails(ValueError, "state: 0 arrays, where 5", material.take_over, mortar, five, three, [])
fails(KeyError, "'stiffness'", mortar.number, "stiffness")

# repr of laws and materials.
assert repr(mortar.law).startswith("<law fracture_energy 0.1.0: "), repr(mortar.law)
assert repr(material) == "elastic(normal_stiffness=40000000000.0, shear_stiffness=20000000000.0)", repr(material)
assert "path of 3001 steps under law fracture_energy" in repr(path), repr(path)
assert repr(batch) == "<batch of 1000 points: 0 failed, 0 clamped, elastic>", repr(batch)
for shown in (mortar.law, mortar, path, batch):
    print(repr(shown))

# A law swap in the middle of the softening branch keeps every traction.
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
