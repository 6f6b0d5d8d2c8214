"""Blocks from meshes of other programs, read by meshio: gmsh's .msh of versions 2 and 4, PLY, VTK, Abaqus, MED and others."""
import contextlib
import importlib.util
import io
import os
import re
import resource

import numpy as np

from .errors import BadInput
from .scene import Block

SURFACES = ("triangle", "quad", "polygon")


def _components(cells, nodes):
    """Numbers of cells that hang together by their nodes, by component."""
    parent = np.arange(nodes)

    def root(n):
        while parent[n] != n:
            parent[n] = parent[parent[n]]
            n = parent[n]
        return n
    for cell in cells:
        first = root(cell[0])
        for n in cell[1:]:
            parent[root(n)] = first
    found = {}
    for i, cell in enumerate(cells):
        found.setdefault(root(cell[0]), []).append(i)
    return list(found.values())


def _tags(mesh, index, count):
    """Of the cells of a section: the volume that gmsh counts them to, or its physical group, or none."""
    for name in ("gmsh:geometrical", "gmsh:physical"):
        if name in mesh.cell_data:
            return np.asarray(mesh.cell_data[name][index])
    return np.zeros(count, dtype=int)


def _corners(cell, section, points):
    """Numbers of points of a cell, each one of those that there are."""
    corners = [int(n) for n in cell]
    if len(corners) < 3 or (section.type == "tetra" and len(corners) != 4):
        raise ValueError(f"a {section.type} has {len(corners)} corners")
    for n, given in zip(corners, cell):
        if n != given or not 0 <= n < points:
            raise ValueError(f"a {section.type} has the point {given}, and there are {points}, from 0 on")
    return corners


def _groups(mesh, kinds):
    """(tag, cells) of every body: cells of these kinds, parted by their tags and where they do not hang together."""
    by_tag = {}
    for index, section in enumerate(mesh.cells):
        if section.type in kinds:
            for tag, cell in zip(_tags(mesh, index, len(section.data)), section.data):
                by_tag.setdefault(int(tag), []).append(_corners(cell, section, len(mesh.points)))
    for tag, cells in sorted(by_tag.items()):
        for part in _components(cells, len(mesh.points)):
            yield tag, [cells[i] for i in part]


def _upright(zones, points):
    """The same tetrahedra with positive volumes."""
    zones = np.array(zones)
    edges = points[zones[:, 1:]] - points[zones[:, :1]]
    with np.errstate(over="ignore", invalid="ignore"):  # of coordinates like 1e308, which the scene refuses
        turned = np.linalg.det(edges) < 0
    zones[turned, 2], zones[turned, 3] = zones[turned, 3].copy(), zones[turned, 2].copy()
    return zones.tolist()


def _boundary(zones):
    """Triangles that only one of the tetrahedra has, counter-clockwise seen from outside."""
    found = {}
    for a, b, c, d in zones:
        for face in ((a, c, b), (a, b, d), (b, c, d), (a, d, c)):
            found.setdefault(tuple(sorted(face)), []).append(list(face))
    return [faces[0] for faces in found.values() if len(faces) == 1]


@contextlib.contextmanager
def _little_memory(path):
    """Missing memory is an exception of the reader, and not the end of the machine: a few bytes can say that points go by
    numbers up to 2^31. Allowed are 200 bytes for each of the file and 500 MB."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    with open("/proc/self/statm", encoding="ascii") as file:
        used = int(file.read().split()[0]) * resource.getpagesize()
    allowed = used + 200 * os.path.getsize(path) + 500_000_000
    if soft == resource.RLIM_INFINITY or allowed < soft:
        resource.setrlimit(resource.RLIMIT_AS, (allowed, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _check_ply(path):
    """What meshio would wait for: the end of a header that has none, and elements that the file is too short for."""
    size = os.path.getsize(path)
    with open(path, "rb") as file:
        if file.read(3) != b"ply":
            return
        for line in map(bytes.strip, file):
            if line == b"end_header":
                return
            count = re.match(rb"element \w+ (\d+)", line)
            if count and int(count[1]) > size:
                raise ValueError(f"its header tells of {int(count[1])} elements, and it has {size} bytes")
    raise ValueError("its header has no end (end_header)")


def _read(path):
    """What meshio makes of a file."""
    import meshio
    _check_ply(path)
    said = io.StringIO()  # it prints what is wrong, and ends the program
    try:
        with _little_memory(path), contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            return meshio.read(path)
    except MemoryError:
        raise ValueError("it asks for more memory than a mesh of its size needs") from None
    except SystemExit:
        raise ValueError(" ".join(said.getvalue().split()) or "no reason is given") from None


def read_blocks(path, *, material, scale=1.0, name=None, **keys):
    """The bodies of a mesh file as a list of blocks for scene.block, lengths times scale: the surfaces of their tetrahedra,
    or, where the file has none, closed surfaces. Bodies are parted by gmsh's volumes, and where they do not hang together;
    each must be convex. With rigid=False the tetrahedra of the file are the zones of deformable blocks; with zone_edge
    besides, blocks are zoned anew."""
    path = os.fspath(path)
    own_zones = not keys.get("rigid", True) and not keys.keys() & {"zone_edge", "divisions"}
    if importlib.util.find_spec("meshio") is None:
        raise ImportError("read_blocks: meshio is not installed (python3-meshio)")
    if not os.path.isfile(path):
        raise BadInput(f"{path}: cannot read it: no such file")
    try:
        mesh = _read(path)
    except Exception as fault:
        raise BadInput(f"{path}: meshio cannot read it: {str(fault) or type(fault).__name__}") from None
    points = scale * np.asarray(mesh.points, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise BadInput(f"{path}: its points are not finite, or not in three dimensions")
    name = name or os.path.splitext(os.path.basename(path))[0]
    try:
        bodies, zoned = list(_groups(mesh, ("tetra",))), True
        if not bodies:
            bodies, zoned = list(_groups(mesh, SURFACES)), False
    except (ValueError, OverflowError) as fault:  # of numbers that are none
        raise BadInput(f"{path}: {fault}") from None
    if not bodies:
        raise BadInput(f"{path}: has neither tetrahedra nor a surface; it has {', '.join(c.type for c in mesh.cells)}")
    if own_zones and not zoned:
        raise BadInput(f"{path}: has no tetrahedra that could be the zones of deformable blocks; give zone_edge")
    blocks = []
    for number, (_, cells) in enumerate(bodies):
        used = sorted({n for cell in cells for n in cell})
        local = {n: i for i, n in enumerate(used)}
        block = Block(name=name if len(bodies) == 1 else f"{name}/{number}", material=material,
                      vertices=points[used].tolist(), **keys)
        cells = [[local[n] for n in cell] for cell in cells]
        if zoned:
            cells = _upright(cells, points[used])
        if own_zones:
            block.tetrahedra = cells
        else:
            block.faces = _boundary(cells) if zoned else cells
        blocks.append(block)
    return blocks
