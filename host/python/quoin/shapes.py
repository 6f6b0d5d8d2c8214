"""Masonry as lists of blocks: bonds, two leaves, rubble, curved walls, vaults, domes, bridges, and the beams and ties in
them. Lengths in m, y up. Blocks of a list are in contact without overlap. Other keys (material="stone", rigid=False,
zone_edge=0.1) apply to every block:

    scene.block += quoin.shapes.dome(radius=5.0, thickness=0.5, courses=8, pieces=24, material="stone")

host/python/SHAPES.md has a picture of each.
"""
import math
import warnings

import numpy as np

from . import _quoin
from .errors import BadInput
from .scene import Block, Table, plain


def _count(name, value, lower, upper=100000):
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not lower <= value <= upper:
        raise ValueError(f"{name} = {value!r}: allowed: an integer, {lower} to {upper}")
    return int(value)


def _length(name, value, lower=0.0, upper=1e6):
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)) \
            or not lower < value <= upper:
        raise ValueError(f"{name} = {value!r}: allowed: a number, more than {lower:g} and at most {upper:g}")
    return float(value)


def _lengths(name, values, count=3):
    if isinstance(values, (str, bytes)) or not hasattr(values, "__len__") or len(values) != count:
        raise ValueError(f"{name} = {values!r}: allowed: {count} numbers")
    return [_length(f"{name}[{i}]", v) for i, v in enumerate(values)]


def _place(name, values):
    values = np.asarray(values, dtype=float)
    if values.shape != (3,) or not np.isfinite(values).all():
        raise ValueError(f"{name} = {values!r}: allowed: three finite numbers")
    return values


def _hull(name, points, keys):
    return Block(name=name, vertices=np.asarray(points, dtype=float).tolist(), **keys)


def _lower(box):
    """Lower corner of a box; the origin where it has none, as in scenes."""
    return np.array(plain(box.lower) if "lower" in box else [0.0, 0.0, 0.0], dtype=float)


def _box(name, lower, upper, keys):
    lower, upper = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    return Block(name=name, box=dict(lower=lower.tolist(), size=(upper - lower).tolist()), **keys)


def _of(block, key, default=None):
    return block[key] if key in block else default


def _support(keys):
    """Keys of a support: fixed, and rigid without zones."""
    return {k: v for k, v in dict(keys, fixed=True, rigid=True).items() if k not in ("zone_edge", "divisions")}


# --- walls ----------------------------------------------------------------------------------------------------------------

def _pieces(start, end, width, shift):
    """(from, to) of units of a width in a row from start to end, with joints at shift + whole widths, without slivers."""
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
    deep = 2 * wide  # thickness of a wall of two widths
    headers = [(a, b, 0.0, deep) for a, b in _pieces(0.0, length, wide, 0.5 * wide * (course % 2))]
    if bond == "header":
        return headers
    leaves = ((0.0, wide), (wide, deep))
    if bond == "english":
        return headers if course % 2 else [(a, b, *leaf) for leaf in leaves for a, b in _pieces(0.0, length, long, 0.0)]
    # Flemish: stretcher, header, stretcher. The next course has its headers over the middle of the stretchers.
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
    """A straight wall along x. unit: length, height, width. Header, English and Flemish bond are two widths thick, with
    stretchers in both leaves; other bonds are one width thick."""
    if bond not in BONDS:
        raise ValueError(f"bond = {bond!r}: allowed: {', '.join(BONDS)}")
    courses, length = _count("courses", courses, 1), _length("length", length)
    unit = _lengths("unit", unit)
    return _laid([_course(bond, course, length, unit) for course in range(courses)], unit[1], name, origin, keys)


def _laid(courses, height, name, origin, keys):
    """Blocks of courses of (from, to, front, back)."""
    origin, blocks = _place("origin", origin), []
    for course, units in enumerate(courses):
        for number, (a, b, front, back) in enumerate(units):
            blocks.append(_box(f"{name}/{course}/{number}", origin + [a, course * height, front],
                               origin + [b, (course + 1) * height, back], keys))
    return blocks


def two_leaf_wall(courses, length, unit, gap=0.0, tie_every=3, tie_spacing=2, name="wall", origin=(0.0, 0.0, 0.0), **keys):
    """Two leaves of running bond, each a unit's width thick, with a gap between them (0: in contact). Headers tie them:
    in every tie_every-th course, in the middle of every tie_spacing-th unit, with closers beside them."""
    courses, length, unit = _count("courses", courses, 1), _length("length", length), _lengths("unit", unit)
    tie_every, tie_spacing = _count("tie_every", tie_every, 1), _count("tie_spacing", tie_spacing, 1)
    gap = 0.0 if gap == 0 else _length("gap", gap)
    long, wide = unit[0], unit[2]
    if not wide < long:
        raise ValueError(f"unit[2] = {wide}: allowed: less than the length {long}, so that headers leave room for closers")
    leaves, deep, laid = ((0.0, wide), (wide + gap, 2 * wide + gap)), 2 * wide + gap, []
    for course in range(courses):
        units = []
        for number, (a, b) in enumerate(_pieces(0.0, length, long, 0.5 * (course % 2) * long)):
            tied = (course + 1) % tie_every == 0 and (number + 1) % tie_spacing == 0 and b - a > 1.2 * wide
            middle = (a + b) / 2
            pieces = [(a, middle - wide / 2), (middle + wide / 2, b)] if tied else [(a, b)]
            units += [(*piece, *leaf) for piece in pieces for leaf in leaves]
            units += [(middle - wide / 2, middle + wide / 2, 0.0, deep)] if tied else []
        laid.append(units)
    return _laid(laid, unit[1], name, origin, keys)


def _without_short_edges(cells, seeds, room, shortest_edge):
    """Cells of slightly moved seeds without edges shorter than shortest_edge, or than the largest feasible part of it;
    otherwise the given cells."""
    for wanted in (shortest_edge, 0.7 * shortest_edge, 0.4 * shortest_edge, 0.2 * shortest_edge):
        stones, left = _quoin.stones(seeds.tolist(), room.tolist(), wanted)
        if left >= wanted:
            break
    else:
        stones, wanted = cells, 0.0
    if wanted < shortest_edge:
        warnings.warn(f"rubble: edges down to {wanted:.2g} of a mean stone are left; take another seed or more relax")
    return [np.array(stone) for stone in stones]


def rubble(size, stone, seed=1, relax=2, shortest_edge=0.15, name="rubble", origin=(0.0, 0.0, 0.0), **keys):
    """A box of irregular stones without gaps: the cells of random seeds (Voro++). The mean length, height and width of
    stones set their number. relax: number of moves of seeds to the middle of their cells; 0: random seeds, with
    splinters; 10: nearly equal sizes. shortest_edge: edges shorter than this part of a mean stone are removed, as they
    would set the time step of zones; faces remain planes shared by neighbours; 0: edges as they are. The stones depend on
    the seed alone. They are numbered from the lowest up."""
    if not hasattr(_quoin, "voronoi"):
        raise ImportError("rubble: this installation was built without Voro++ (voro++-dev)")
    size, stone, relax = _lengths("size", size), _lengths("stone", stone), _count("relax", relax, 0, 1000)
    shortest_edge = 0.0 if shortest_edge == 0 else _length("shortest_edge", shortest_edge, upper=0.25)
    count = max(1, round(math.prod(size) / math.prod(stone)))
    if count > 100000:
        raise ValueError(f"stone = {stone}: {count} stones; allowed: 100000 at most; take larger ones")
    room = np.array(size) / stone  # scaled so that stones are as high as they are long
    seeds = room * np.random.RandomState(_count("seed", seed, 0, 2**32 - 1)).random_sample((count, 3))
    for turn in range(relax + 1):
        cells, centroids = _quoin.voronoi(seeds, room.tolist())
        if turn < relax:
            seeds = centroids
    if shortest_edge > 0:
        cells = _without_short_edges(cells, seeds, room, shortest_edge)
    cells.sort(key=lambda cell: cell[:, 1].mean())
    origin = _place("origin", origin)
    return [_hull(f"{name}/{number}", origin + cell * stone, keys) for number, cell in enumerate(cells)]


def curved_wall(radius, thickness, height, courses, pieces, angle=360.0, name="wall", **keys):
    """A wall on a circle about the y axis, of mean radius; each course has `pieces` of equal angle (deg), straight
    between their ends. Joints of all courses are above each other, so that the faces of a polygon match."""
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
    """A vault along z of `voussoirs` from springing to springing (deg from x), divided along its length into `rows`;
    every other ring of voussoirs is shifted by half a row. The rings at the springings are fixed."""
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
            own = _support(keys) if springing else keys
            blocks.append(_hull(f"{name}/{v}/{number}", _voussoir(radius, thickness, (first + v * step, first + (v + 1) * step),
                                                                  along), own))
    return blocks


def cross_vault(span, thickness, courses, springing=20.0, name="vault", **keys):
    """A groin vault over a square bay: two half barrels of mean diameter `span` that meet in the diagonals, above the
    middle of the bay. Each of the four webs has `courses` (an odd number, with one along the crown), from the springing
    (deg above the horizontal) up, mitred along the groins. The stones below the springing are fixed."""
    span, thickness = _length("span", span), _length("thickness", thickness, upper=span)
    courses, low = _count("courses", courses, 3), math.radians(_length("springing", springing, upper=80.0))
    step = (math.pi - 2 * low) / courses
    if courses % 2 == 0:
        raise ValueError(f"courses = {courses}: allowed: an odd number, so that one runs along the crown")
    if low < step:
        raise ValueError(f"springing = {springing}: allowed: {math.degrees(math.pi / (courses + 2)):.4g} deg or more with "
                         f"{courses} courses, so that the stones below it find room")
    inner, outer, blocks = (span - thickness) / 2, (span + thickness) / 2, []
    for web in range(4):
        turn = [(1, 0), (0, 1), (-1, 0), (0, -1)][web]
        for course in range(-1, courses + 1):
            points = []
            for r in (inner, outer):
                for a in (low + course * step, low + (course + 1) * step):
                    x, y = r * math.cos(a), r * math.sin(a)
                    points += [(x, y, abs(x)), (x, y, outer)]
                if course == courses // 2:
                    points.append((0.0, points[-1][1], 0.0))  # meeting point of the four crowns
            turned = [(turn[0] * x - turn[1] * z, y, turn[1] * x + turn[0] * z) for x, y, z in points]
            blocks.append(_hull(f"{name}/{web}/{course}", turned, keys if 0 <= course < courses else _support(keys)))
    return blocks


def dome(radius, thickness, courses, pieces, springing=0.0, oculus=80.0, name="dome", **keys):
    """A dome of mean radius about the y axis: courses of `pieces`, from the springing to the oculus (deg above the
    horizontal; 90: closed by a keystone as wide as a course is high). A ring below the first course is fixed."""
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
            blocks.append(_hull(f"{name}/{course}/{piece}", points, _support(keys) if course < 0 else keys))
    if closed:
        points = [ring(low + courses * step, r)(turn) for r in (inner, outer) for turn in turns[:-1]]
        blocks.append(_hull(f"{name}/keystone", points, keys))
    return blocks


def arch_bridge(spans, span, rise, thickness, width, voussoirs, pier_width, pier_height, pier_courses=4, name="bridge",
                **keys):
    """Segmental arches of equal clear span and rise on piers, between two fixed abutments; along x, width along z. The
    skewbacks are separate blocks on the piers. Semicircular arches stand on the piers without."""
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
    blocks, fixed = [], _support(keys)

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
        if outward[1] < 1e-6 * span:
            continue
        prism(f"pier_{p}/skewback", [(left, pier_height), (right, pier_height), (right - outward[0], top),
                                     (left + outward[0], top)], keys)
    return blocks


def _outline(block):
    """Corners in the plane x, y, and the extent along z."""
    points = np.array([np.add(_lower(block.box), np.multiply(block.box.size, corner)) for corner in np.ndindex(2, 2, 2)]
                      if "box" in block else plain(block.vertices))
    if "rotation" in block or "mesh" in block:
        raise ValueError(f"blocks: {_of(block, 'name')!r} is turned or a mesh; allowed: boxes and prisms along z")
    points = points + np.array(plain(block.position) if "position" in block else [0.0, 0.0, 0.0])
    ends = points[:, 2].min(), points[:, 2].max()
    if not np.isclose(points[:, 2, None], ends, atol=1e-9 * np.ptp(points)).any(axis=1).all():
        raise ValueError(f"blocks: {_of(block, 'name')!r} is no prism along z, and its fill cannot be told")
    return points[:, :2], ends


def _top(corners, x):
    """Height of the upper side of the corners' hull at x; None: outside of the hull."""
    left, right = corners[corners[:, 0] <= x], corners[corners[:, 0] >= x]
    if not len(left) or not len(right):
        return None
    heights = [a[1] if a[0] == b[0] else a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0])
               for a in left for b in right if a[0] < b[0] or a[0] == x == b[0]]
    return max(heights)


def fill_load(blocks, top, unit_weight):
    """Weight of a fill (N/m3) between the upper sides of blocks and its level top. The blocks are boxes and prisms along
    z, as of arch bridges and barrel vaults. Returns forces for stage.force, on each movable block below open sky. They
    act down, at the centre of the fill's column above the block. The fill's stiffness and its thrust on adjacent blocks
    are neglected."""
    unit_weight = _length("unit_weight", unit_weight, upper=1e9)
    seen = [(block, *_outline(block)) for block in blocks]
    levels = sorted({round(z, 9) for _, _, ends in seen for z in ends})
    loads = {}  # name: force, and its moments about x = 0 and z = 0
    for front, back in zip(levels, levels[1:]):
        here = [(b, corners) for b, corners, (z0, z1) in seen if z0 < (front + back) / 2 < z1]
        cuts = sorted({x for _, corners in here for x in corners[:, 0].round(9)})
        for a, b in zip(cuts, cuts[1:]):
            middle, highest = (a + b) / 2, None
            for block, corners in here:
                height = _top(corners, middle)
                if height is not None and (highest is None or height > highest[0]):
                    highest = height, block, corners
            if highest is None or _of(highest[1], "fixed"):
                continue
            inset = 1e-6 * (b - a)  # inside the sides of blocks, where heights jump
            depths = [top - _top(highest[2], x) for x in (a + inset, b - inset)]
            if min(depths) < -1e-9 * abs(b - a):
                raise BadInput(f"top = {top}: block {highest[1].name!r} reaches {-min(depths):.3g} m above it")
            weight = unit_weight * (back - front) * (b - a) * sum(depths) / 2
            if weight > 0:
                arm = (b - a) * (depths[0] + 2 * depths[1]) / (3 * sum(depths))  # centroid of a trapezoid
                total = loads.setdefault(highest[1].name, np.zeros(4))
                total += np.array([1.0, a + arm, (front + back) / 2, highest[0]]) * weight
    return [Table(block=name, point=[x / f, y / f, z / f], force=[0.0, -f, 0.0]) for name, (f, x, z, y) in loads.items()]


# --- beams and ties -------------------------------------------------------------------------------------------------------

def cut(blocks, lower, size, needed=True):
    """The blocks without the parts in a box. Boxes are divided around it into parts NAME/a, NAME/b ... of one unit (key
    `unit`), which a joint rule with inside_units can bond. Rotated or displaced boxes cannot be cut."""
    lower = _place("lower", lower)
    upper, left, met = lower + _lengths("size", size), [], False
    for block in blocks:
        if "box" not in block or "rotation" in block or "position" in block:
            points = _hull_of(block)
            if points is not None and ((points.max(axis=0) <= lower + 1e-9) | (points.min(axis=0) >= upper - 1e-9)).any():
                left.append(block)
                continue
            raise ValueError(f"blocks: {_of(block, 'name')!r} may reach into what is cut; allowed: boxes, not turned or moved")
        low = _lower(block.box)
        high = low + plain(block.box.size)
        tiny = 1e-6 * (high - low).min()
        if ((high <= lower + tiny) | (low >= upper - tiny)).any():
            left.append(block)
            continue
        met, parts = True, []
        for axis in range(3):  # parts before and after the hole along an axis; then the rest, along the next axis
            for end, at in ((0, lower[axis]), (1, upper[axis])):
                if low[axis] + tiny < at < high[axis] - tiny:
                    a, b = low.copy(), high.copy()
                    (b if end == 0 else a)[axis] = at
                    parts.append((a, b))
                    (low if end == 0 else high)[axis] = at
        own = {k: v for k, v in block.items() if k not in ("name", "box", "divisions")}
        if len(parts) > 1:
            own.setdefault("unit", block.name)
        names = [block.name] if len(parts) == 1 else [f"{block.name}/{chr(97 + i)}" for i in range(len(parts))]
        left += [_box(part_name, a, b, own) for part_name, (a, b) in zip(names, parts)]
    if needed and not met:
        raise ValueError(f"lower = {lower.tolist()}: nothing of the blocks lies in what is cut")
    return left


def _hull_of(block):
    """Corners of a block that has vertices, without position or rotation; None: of other blocks."""
    return np.array(plain(block.vertices)) if "vertices" in block and not block.keys() & {"rotation", "position"} else None


def beam(lower, size, name="beam", zone_edge=None, **keys):
    """An elastic beam, a box along the axes. Edges of its zones are as long as the smallest side of its section (or
    zone_edge)."""
    lower, size = _place("lower", lower), _lengths("size", size)
    return _box(name, lower, lower + size, dict(keys, rigid=False, zone_edge=zone_edge or sorted(size)[0]))


def opening(blocks, start, end, sill, head, bearing=0.0, lintel_height=0.0, lintel_material=None, name="lintel", **keys):
    """A wall of boxes along x with an opening through its thickness, from start to end along x and from sill to head (m,
    in the coordinates of the blocks). bearing > 0: an elastic lintel above it with this bearing in the wall on both
    sides, in place of the blocks there. Levels of courses suit best."""
    boxes = [b.box for b in blocks if "box" in b and not _of(b, "fixed")]
    if not boxes:
        raise ValueError("blocks: there is no box among them that could be cut")
    front, back = min(_lower(b)[2] for b in boxes), max(_lower(b)[2] + b.size[2] for b in boxes)
    left = cut(blocks, [start, sill, front], [end - start, head - sill, back - front])
    if bearing == 0:
        return left
    lower = [start - _length("bearing", bearing), head, front]
    size = [end - start + 2 * bearing, _length("lintel_height", lintel_height), back - front]
    if lintel_material is None:
        raise ValueError("lintel_material = None: allowed: the name of the lintel's material")
    return cut(left, lower, size) + [beam(lower, size, name, material=lintel_material, **keys)]


def ring_beam(lower, length, width, section, name="ring", **keys):
    """A rectangular ring of elastic beams, length along x and width along z outside; section: its height and breadth. The
    two beams along x include the corners. The ring is monolithic with a rule such as JointRule(family="cast",
    between=["ring/", "ring/"]) of an elastic family."""
    (x, y, z), (height, breadth) = _place("lower", lower), _lengths("section", section, 2)
    length, width = _length("length", length, 2 * breadth), _length("width", width, 2 * breadth)
    inside = width - 2 * breadth
    return [beam([x, y, z], [length, height, breadth], f"{name}/0", **keys),
            beam([x, y, z + width - breadth], [length, height, breadth], f"{name}/1", **keys),
            beam([x, y, z + breadth], [breadth, height, inside], f"{name}/2", **keys),
            beam([x + length - breadth, y, z + breadth], [breadth, height, inside], f"{name}/3", **keys)]


def tie(blocks, start, end, bar, plate, clearance=0.01, name="tie", **keys):
    """The blocks with an elastic tie along x or z, from start to end, the outer faces of the masonry. bar: side of its
    square section; its hole is wider by the clearance on every side. plate: (side, thickness) of anchor plates that bear
    on the masonry from outside. A rule such as JointRule(family="steel", between=["tie/", "tie/"]) of an elastic family
    bonds bar and plates."""
    start, end, bar = _place("start", start), _place("end", end), _length("bar", bar)
    side, thick = _lengths("plate", plate, 2)
    clearance = 0.0 if clearance == 0 else _length("clearance", clearance)
    along = np.flatnonzero(np.abs(end - start) > 0)
    if len(along) != 1 or along[0] == 1 or end[along[0]] < start[along[0]]:
        raise ValueError(f"end = {end.tolist()}: allowed: further than start along x or along z, and level with it")
    if side <= bar + 2 * clearance:
        raise ValueError(f"plate = {plate}: allowed: a side of more than {bar + 2 * clearance:g} m, the hole of the bar")
    across = np.ones(3)
    across[along[0]] = 0.0
    out = thick * (1.0 - across)
    hole = cut(blocks, start - across * (bar / 2 + clearance), end - start + across * (bar + 2 * clearance))
    keys = dict(keys, rigid=False)
    return hole + [_box(f"{name}/bar", start - across * bar / 2, end + across * bar / 2, dict(keys, zone_edge=bar)),
                   _box(f"{name}/plate_0", start - out - across * side / 2, start + across * side / 2,
                        dict(keys, zone_edge=side / 2)),
                   _box(f"{name}/plate_1", end - across * side / 2, end + out + across * side / 2,
                        dict(keys, zone_edge=side / 2))]
