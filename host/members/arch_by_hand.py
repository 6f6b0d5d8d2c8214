"""The arch of bare_arch.toml without Quoin: /usr/bin/python3 host/members/arch_by_hand.py

1. Thrust line: the largest load for which some line of thrust lies within the joints. Tensile strength acts over a whole
   joint at once, so that a joint carries the moment N t/2 + ft b t^2/2: a linear programme.
2. Joints of fibres with softening, rigid bricks, small displacements: the point under the load goes down step by step.
Both have neither contact points, nor inertia, nor Quoin's laws. Needs numpy and scipy.
"""
import numpy as np
from scipy.optimize import linprog

COURSES, RADIUS, THICKNESS, DEPTH = 59, 0.775, 0.05, 0.45  # -, m
FIRST, LAST, DENSITY, LOADED = np.radians(12.0), np.radians(168.0), 1900.0, 40  # kg/m3, course below the load
STEP = (LAST - FIRST) / COURSES
JOINT = FIRST + STEP * np.arange(COURSES + 1)
MIDDLE = FIRST + STEP * (np.arange(COURSES) + 0.5)
INNER, OUTER = RADIUS - THICKNESS / 2, RADIUS + THICKNESS / 2
WEIGHT = DENSITY * 9.81 * DEPTH * 0.5 * np.sin(STEP) * (OUTER**2 - INNER**2)  # N, a course with plane faces
CENTROID = np.cos(STEP / 2) * 2 / 3 * (OUTER**3 - INNER**3) / (OUTER**2 - INNER**2)


def radial(angle):
    return np.array([np.cos(angle), np.sin(angle)])


def thrust_line(ft):
    """Largest load, N. Unknowns: force and moment on the first joint, and the load."""
    rows, bounds = [], []
    start, load_x = RADIUS * radial(JOINT[0]), RADIUS * np.cos(MIDDLE[LOADED])
    for k, angle in enumerate(JOINT):
        at, along = RADIUS * radial(angle), np.array([-np.sin(angle), np.cos(angle)])
        d, after = start - at, float(LOADED < k)
        normal = np.array([along[0], along[1], 0.0, -along[1] * after])
        moment = np.array([-d[1], d[0], 1.0, -after * (load_x - at[0])])
        dead_moment = -WEIGHT * sum(CENTROID * np.cos(MIDDLE[:k]) - at[0])
        for sign in (1.0, -1.0):
            rows.append(sign * moment - normal * THICKNESS / 2)
            bounds.append(ft * DEPTH * THICKNESS**2 / 2 - sign * dead_moment - along[1] * WEIGHT * k * THICKNESS / 2)
    return linprog([0, 0, 0, -1], A_ub=rows, b_ub=bounds, bounds=[(None, None)] * 4, method="highs").x[3]


def joint_rows():
    """Opening at mid-thickness, turning and slip of each joint, by displacements and rotations of the courses."""
    rows = np.zeros((COURSES + 1, 3, 3 * COURSES))
    for k, angle in enumerate(JOINT):
        out, along = radial(angle), np.array([-np.sin(angle), np.cos(angle)])
        for course, sign in ((k - 1, -1.0), (k, 1.0)):
            if not 0 <= course < COURSES:
                continue
            d = RADIUS * (out - radial(MIDDLE[course]))
            turn = np.array([-d[1], d[0]])
            rows[k, 0, 3 * course:3 * course + 3] = sign * np.array([*along, turn @ along])
            rows[k, 1, 3 * course + 2] = sign * (out[0] * along[1] - out[1] * along[0])
            rows[k, 2, 3 * course:3 * course + 3] = sign * np.array([*out, turn @ out])
    return rows


def softening(ft, g1, kn, fc, steps=50, most=1.0e-3, fibres=200):
    """Largest load, N, and how far the load has gone then, m."""
    rows, height = joint_rows(), THICKNESS * ((np.arange(fibres) + 0.5) / fibres - 0.5)
    area, slip = THICKNESS / fibres * DEPTH, kn / 2.4 * THICKNESS * DEPTH
    first, last = ft / kn, 2 * g1 / ft  # openings at which softening begins and ends
    opened = np.full((COURSES + 1, fibres), first)
    dead = np.zeros(3 * COURSES)
    dead[1::3] = -WEIGHT
    driven, u, found = 3 * LOADED + 1, np.zeros(3 * COURSES), []
    free = np.delete(np.arange(3 * COURSES), driven)
    for step in range(steps + 1):
        for _ in range(400):  # secants, until they stay
            strain = rows @ u
            opening = strain[:, :1] + strain[:, 1:2] * height
            worst = np.maximum(opened, opening)
            secant = np.where(opening > 0, ft * np.clip((last - worst) / (last - first), 0, 1) / worst,
                              np.minimum(kn, fc / np.maximum(-opening, 1e-30)))
            own = np.zeros((COURSES + 1, 3, 3))
            own[:, 0, 0], own[:, 1, 1], own[:, 2, 2] = secant.sum(1) * area, (secant * height**2).sum(1) * area, slip
            own[:, 0, 1] = own[:, 1, 0] = (secant * height).sum(1) * area
            k = np.einsum("jka,jkl,jlb->ab", rows, own, rows, optimize=True)
            if step == 0:
                then = np.linalg.solve(k, dead)
            else:
                then = np.zeros_like(u)
                then[driven] = rest - most * step / steps
                then[free] = np.linalg.solve(k[np.ix_(free, free)], dead[free] - k[free, driven] * then[driven])
            change, u = abs(then - u).max(), then
            if change < 1e-9:
                break
        opened = worst
        if step == 0:
            rest = u[driven]
        else:
            found.append((dead[driven] - k[driven] @ u, most * step / steps))
    return max(found)


if __name__ == "__main__":
    print(f"weight {WEIGHT * COURSES:.0f} N")
    for ft in (0.0, 0.02e6, 0.05e6, 0.1e6, 0.167e6, 0.2e6):
        print(f"thrust line, ft {ft / 1e6:.3f} MPa: {thrust_line(ft):.0f} N")
    for mortar, fvk, fm in (("M1", 0.1, 1.0), ("M5", 0.2, 5.0), ("M10", 0.3, 10.0)):  # the rule of host/validate
        fc, ft = 1.2 * 0.55 * 10**0.7 * fm**0.3, fvk / 0.8 * 2 / 3
        load, way = softening(1e6 * ft, min(max(75.0 * ft, 5.0), 20.0), 550e6 * fc / 0.0358, 1e6 * fc)
        print(f"softening, mortar {mortar}, ft {ft:.3f} MPa, fc {fc:.2f} MPa: {load:.0f} N at {1e3 * way:.2f} mm")
    for kn, g1 in ((2e10, 5.0), (2e10, 12.5), (8.24e10, 5.0)):
        load, way = softening(0.167e6, g1, kn, 5.36e6)
        print(f"softening, ft 0.167 MPa, kn {kn:.3g} Pa/m, G1 {g1} J/m2: {load:.0f} N at {1e3 * way:.2f} mm")
