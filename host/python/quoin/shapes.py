"""Masonry as lists of blocks: bonds, curved walls, vaults, domes, bridges. Lengths in m, y up; the blocks of a list touch and
never overlap. Keys that every block gets (material="stone", rigid=False, zone_edge=0.1) are passed on:

    scene.block += quoin.shapes.dome(radius=5.0, thickness=0.5, courses=8, pieces=24, material="stone")
"""
import math

import numpy as np

from .scene import Block


def _count(name, value, lower, upper=100000):
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not lower <= value <= upper:
        raise ValueError(f"{name} = {value!r}: allowed: an integer, {lower} to {upper}")
    return int(value)


def _length(name, value, lower=0.0, upper=1e6):
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)) \
            or not lower < value <= upper:
        raise ValueError(f"{name} = {value!r}: allowed: a number, more than {lower:g} and at most {upper:g}")
    return float(value)


def _hull(name, points, keys):
    return Block(name=name, vertices=np.asarray(points, dtype=float).tolist(), **keys)


# --- walls ----------------------------------------------------------------------------------------------------------------

def _pieces(start, end, width, shift):
    """(from, to) of units of a width in a row from start to end, joints at shift + whole widths; no slivers."""
    cuts = [start]
    for k in range(math.ceil((start - shift) / width - 1e-9), math.floor((end - shift) / width + 1e-9) + 1):
        x = shift + k * width
        if cuts[-1] + 0.2 * width < x < end - 0.2 * width:
            cuts.append(x)
    return list(zip(cuts, cuts[1:] + [end]))


def _course(bond, course, length, unit):
    """(from, to, front, back) of the units of a course: along the wall and through its thickness."""
    long, wide = unit[0], unit[2]
    if bond in ("running", "third", "stack"):
        shift = {"running": 0.5 * (course % 2), "third": (course % 3) / 3, "stack": 0.0}[bond] * long
        return [(a, b, 0.0, wide) for a, b in _pieces(0.0, length, long, shift)]
    deep = 2 * wide  # of a wall that is one unit thick
    headers = [(a, b, 0.0, deep) for a, b in _pieces(0.0, length, wide, 0.5 * wide * (course % 2))]
    if bond == "header":
        return headers
    leaves = ((0.0, wide), (wide, deep))
    if bond == "english":
        return headers if course % 2 else [(a, b, *leaf) for leaf in leaves for a, b in _pieces(0.0, length, long, 0.0)]
    # Flemish: stretcher, header, stretcher; the next course has its headers over the middle of the stretchers.
    units, period = [], long + wide
    for k in range(-1, math.ceil(length / period) + 1):
        x = k * period + (course % 2) * (period / 2)
        for a, b, header in ((x, x + long, False), (x + long, x + period, True)):
            a, b = max(0.0, a), min(length, b)
            if b - a > 1e-6 * long:
                units += [(a, b, 0.0, deep)] if header else [(a, b, *leaf) for leaf in leaves]
    return units


BONDS = ("running", "third", "stack", "header", "english", "flemish")


def wall(bond, courses, length, unit, name="wall", origin=(0.0, 0.0, 0.0), **keys):
    """A straight wall along x. unit: length, height, width; header, English and Flemish bond are two widths thick, with
    stretchers in both leaves, the others one."""
    if bond not in BONDS:
        raise ValueError(f"bond = {bond!r}: allowed: {', '.join(BONDS)}")
    courses, length = _count("courses", courses, 1), _length("length", length)
    unit = [_length(f"unit[{i}]", u) for i, u in enumerate(unit)]
    blocks = []
    for course in range(courses):
        for number, (a, b, front, back) in enumerate(_course(bond, course, length, unit)):
            lower = [origin[0] + a, origin[1] + course * unit[1], origin[2] + front]
            blocks.append(Block(name=f"{name}/{course}/{number}", box=dict(lower=lower, size=[b - a, unit[1], back - front]),
                                **keys))
    return blocks


def curved_wall(radius, thickness, height, courses, pieces, angle=360.0, name="wall", **keys):
    """A wall on a circle about the y axis, mean radius; each course in so many pieces of equal angle (deg), straight
    between their ends. The joints of courses are above each other for a polygon's faces to match."""
    radius, courses, pieces = _length("radius", radius), _count("courses", courses, 1), _count("pieces", pieces, 3)
    thickness, height = _length("thickness", thickness, upper=2 * radius), _length("height", height)
    angle, rise = math.radians(_length("angle", angle, upper=360.0)), height / courses
    blocks = []
    for course in range(courses):
        for piece in range(pieces):
            points = [[r * math.cos(a), y, r * math.sin(a)]
                      for a in (angle * piece / pieces, angle * (piece + 1) / pieces)
                      for r in (radius - thickness / 2, radius + thickness / 2)
                      for y in (course * rise, (course + 1) * rise)]
            blocks.append(_hull(f"{name}/{course}/{piece}", points, keys))
    return blocks


# --- vaults ---------------------------------------------------------------------------------------------------------------

def _voussoir(radius, thickness, angles, along, centre=(0.0, 0.0, 0.0)):
    """Corners of a wedge of a ring about an axis along z, from angle to angle (rad) and from z to z."""
    return [[centre[0] + r * math.cos(a), centre[1] + r * math.sin(a), centre[2] + z]
            for a in angles for r in (radius - thickness / 2, radius + thickness / 2) for z in along]


def barrel_vault(radius, thickness, length, voussoirs, rows, angles=(0.0, 180.0), name="vault", **keys):
    """A vault along z of so many voussoirs from springing to springing (deg from x), cut along its length into so many
    rows; every other ring of voussoirs is shifted by half a row. The rings at the springings are fixed."""
    radius, length = _length("radius", radius), _length("length", length)
    thickness = _length("thickness", thickness, upper=2 * radius)
    voussoirs, rows = _count("voussoirs", voussoirs, 2), _count("rows", rows, 1)
    first, step = math.radians(angles[0]), math.radians(angles[1] - angles[0]) / voussoirs
    row, blocks = length / rows, []
    for v in range(-1, voussoirs + 1):
        springing = v in (-1, voussoirs)
        cuts = [0.0, length] if springing else sorted({0.0, length, *(row * k for k in range(1, rows))}) if v % 2 == 0 \
            else [0.0, *(row * (k + 0.5) for k in range(rows)), length]
        for number, along in enumerate(zip(cuts, cuts[1:])):
            own = dict(keys, fixed=True, rigid=True) if springing else keys
            if springing:
                own = {k: value for k, value in own.items() if k not in ("zone_edge", "divisions")}
            blocks.append(_hull(f"{name}/{v}/{number}", _voussoir(radius, thickness, (first + v * step, first + (v + 1) * step),
                                                                  along), own))
    return blocks


def dome(radius, thickness, courses, pieces, springing=0.0, oculus=80.0, name="dome", **keys):
    """A dome of mean radius about the y axis: courses of so many pieces, from the springing to the oculus (deg above the
    horizon; 90: closed by a keystone as wide as a course is high). A ring below the first course is fixed."""
    radius, courses, pieces = _length("radius", radius), _count("courses", courses, 1), _count("pieces", pieces, 4)
    thickness = _length("thickness", thickness, upper=2 * radius)
    low, high = math.radians(springing), math.radians(_length("oculus", oculus, springing, 90.0))
    closed = oculus == 90.0
    step = (high - low) / (courses + (1 if closed else 0))

    def ring(above, r):
        return lambda turn: [r * math.cos(above) * math.cos(turn), r * math.sin(above), r * math.cos(above) * math.sin(turn)]
    inner, outer, blocks = radius - thickness / 2, radius + thickness / 2, []
    turns = [2 * math.pi * k / pieces for k in range(pieces + 1)]
    for course in range(-1, courses):
        between = (low + course * step, low + (course + 1) * step)
        for piece in range(pieces):
            points = [ring(a, r)(turn) for a in between for r in (inner, outer) for turn in turns[piece:piece + 2]]
            own = keys
            if course < 0:
                own = {k: v for k, v in dict(keys, fixed=True, rigid=True).items() if k not in ("zone_edge", "divisions")}
            blocks.append(_hull(f"{name}/{course}/{piece}", points, own))
    if closed:
        points = [ring(low + courses * step, r)(turn) for r in (inner, outer) for turn in turns[:-1]]
        blocks.append(_hull(f"{name}/keystone", points, keys))
    return blocks


def arch_bridge(spans, span, rise, thickness, width, voussoirs, pier_width, pier_height, pier_courses=4, name="bridge",
                **keys):
    """Segmental arches of the same clear span and rise on piers, between two fixed abutments; along x, width along z. The
    skewbacks are blocks of their own on the piers."""
    spans, voussoirs = _count("spans", spans, 1), _count("voussoirs", voussoirs, 3)
    span, width, thickness = _length("span", span), _length("width", width), _length("thickness", thickness)
    rise, pier_width = _length("rise", rise, upper=span / 2), _length("pier_width", pier_width)
    pier_height, pier_courses = _length("pier_height", pier_height), _count("pier_courses", pier_courses, 1)
    intrados = (span * span / 4 + rise * rise) / (2 * rise)
    half = math.asin(span / 2 / intrados)
    outward = thickness * math.sin(half), thickness * math.cos(half)  # of the extrados at a springing
    if spans > 1 and pier_width < 2 * outward[0]:
        raise ValueError(f"pier_width = {pier_width}: allowed: {2 * outward[0]:.3g} m or more, so that the springings of two "
                         "arches find room on a pier")
    blocks, fixed = [], {k: v for k, v in dict(keys, fixed=True, rigid=True).items() if k not in ("zone_edge", "divisions")}

    def prism(label, outline, own):
        blocks.append(_hull(f"{name}/{label}", [[x, y, z] for x, y in outline for z in (0.0, width)], own))
    for s in range(spans):
        left = s * (span + pier_width)
        centre = left + span / 2, pier_height + rise - intrados
        for v in range(voussoirs):
            between = [math.pi / 2 + half - 2 * half * k / voussoirs for k in (v, v + 1)]
            blocks.append(_hull(f"{name}/arch_{s}/{v}", _voussoir(intrados + thickness / 2, thickness, between, (0.0, width),
                                                                  (*centre, 0.0)), keys))
    top = pier_height + outward[1]
    prism("abutment_left", [(-pier_width, 0), (0, 0), (0, pier_height), (-outward[0], top), (-pier_width, top)], fixed)
    end = spans * span + (spans - 1) * pier_width
    prism("abutment_right", [(end + pier_width, 0), (end, 0), (end, pier_height), (end + outward[0], top),
                             (end + pier_width, top)], fixed)
    for p in range(spans - 1):
        left, rise_of = p * (span + pier_width) + span, pier_height / pier_courses
        right = left + pier_width
        prism(f"pier_{p}/base", [(left, -rise_of), (right, -rise_of), (right, 0), (left, 0)], fixed)
        for course in range(pier_courses):
            y = course * rise_of
            prism(f"pier_{p}/{course}", [(left, y), (right, y), (right, y + rise_of), (left, y + rise_of)], keys)
        prism(f"pier_{p}/skewback", [(left, pier_height), (right, pier_height), (right - outward[0], top),
                                     (left + outward[0], top)], keys)
    return blocks
