"""Blocks from mesh files: OBJ, OFF, STL and assemblies of COMPAS by the reader of scenes, and by meshio gmsh's .msh of
versions 2 and 4, PLY, VTK, Abaqus, MED and others."""
import contextlib
import difflib
import importlib.util
import io
import os
import re
import resource

import numpy as np

from . import _quoin
from .errors import BadInput
from .scene import Block

SURFACES = ("triangle", "quad", "polygon")


def _components(cells, nodes):
    """Indices of the cells of each connected component."""
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
    """Tags of the cells of a section: gmsh's volume, or else the physical group, or 0."""
    for name in ("gmsh:geometrical", "gmsh:physical"):
        if name in mesh.cell_data:
            return np.asarray(mesh.cell_data[name][index])
    return np.zeros(count, dtype=int)


def _corners(cell, section, points):
    """Indices of the points of a cell; ValueError for one that does not exist."""
    corners = [int(n) for n in cell]
    if len(corners) < 3 or (section.type == "tetra" and len(corners) != 4):
        raise ValueError(f"a {section.type} has {len(corners)} corners")
    for n, given in zip(corners, cell):
        if n != given or not 0 <= n < points:
            raise ValueError(f"a {section.type} has the point {given}, and there are {points}, from 0 on")
    return corners


def _groups(mesh, kinds):
    """(tag, cells) of every body: connected cells of these kinds with equal tags."""
    by_tag = {}
    for index, section in enumerate(mesh.cells):
        if section.type in kinds:
            for tag, cell in zip(_tags(mesh, index, len(section.data)), section.data):
                by_tag.setdefault(int(tag), []).append(_corners(cell, section, len(mesh.points)))
    for tag, cells in sorted(by_tag.items()):
        for part in _components(cells, len(mesh.points)):
            yield tag, [cells[i] for i in part]


def _upright(zones, points):
    """The tetrahedra, numbered for positive volumes."""
    zones = np.array(zones)
    edges = points[zones[:, 1:]] - points[zones[:, :1]]
    with np.errstate(over="ignore", invalid="ignore"):  # overflow of coordinates like 1e308, which the scene refuses
        turned = np.linalg.det(edges) < 0
    zones[turned, 2], zones[turned, 3] = zones[turned, 3].copy(), zones[turned, 2].copy()
    return zones.tolist()


def _boundary(zones):
    """Triangles of only one tetrahedron, counter-clockwise seen from outside."""
    found = {}
    for a, b, c, d in zones:
        for face in ((a, c, b), (a, b, d), (b, c, d), (a, d, c)):
            found.setdefault(tuple(sorted(face)), []).append(list(face))
    return [faces[0] for faces in found.values() if len(faces) == 1]


@contextlib.contextmanager
def _little_memory(path):
    """Limits memory to 200 bytes per byte of the file and 500 MB, so that a lack of memory is an exception. A few bytes
    of a file can claim indices of points up to 2^31."""
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
    """Refuses files in which meshio would loop: headers without an end, and elements beyond the end of the file."""
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
    """The mesh of a file, as meshio reads it."""
    import meshio
    _check_ply(path)
    said = io.StringIO()  # meshio prints faults and exits
    try:
        with _little_memory(path), contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            return meshio.read(path)
    except MemoryError:
        raise ValueError("it asks for more memory than a mesh of its size needs") from None
    except SystemExit:
        raise ValueError(" ".join(said.getvalue().split()) or "no reason is given") from None


OWN_KINDS = (".obj", ".off", ".stl", ".json")  # file types that a scene reads itself


def _is_own(path):
    """Whether a scene reads the file itself. Of COMPAS this is each .json file, which meshio does not read."""
    return os.path.splitext(path)[1].lower() in OWN_KINDS


def _fixed_names(fixed):
    """True or False for all blocks, or a list of names."""
    if isinstance(fixed, (bool, np.bool_)):
        return bool(fixed), []
    names = [fixed] if isinstance(fixed, str) else list(fixed)
    if not all(isinstance(n, str) for n in names):
        raise ValueError(f"fixed = {fixed!r}: allowed: True, False or a list of names of blocks")
    return False, names


def _chosen(path, names, all_fixed, wanted, own_support):
    """Which of the blocks of these names are fixed. BadInput for a name without a block."""
    for name in wanted:
        if name not in names:
            near = difflib.get_close_matches(name, names, 1)
            raise BadInput(f"{path}: fixed: no block is called {name!r}" +
                           (f"; did you mean {near[0]!r}?" if near else f"; there are {', '.join(names[:10])}"))
    return [all_fixed or own or name in wanted for name, own in zip(names, own_support)]


def _own_blocks(path, material, scale, name, fixed, keys):
    """Blocks of a file that a scene reads itself, with the file's names, and `name` as prefix if it is given."""
    if not keys.get("rigid", True) and "zone_edge" not in keys and "divisions" not in keys:
        raise BadInput(f"{path}: has no tetrahedra that could be the zones of deformable blocks; give zone_edge")
    all_fixed, wanted = _fixed_names(fixed)
    before = f"{name}/" if name else ""

    def is_fixed(own):
        return all_fixed or own in wanted or before + own in wanted
    bodies = _quoin.read_mesh(path, scale, is_fixed)
    names = [n for n, *_ in bodies]
    _chosen(path, names, all_fixed, [w[len(before):] if w.startswith(before) else w for w in wanted],
            [support for *_, support in bodies])
    blocks = []
    for own, corners, faces, support in bodies:
        block = Block(name=name if name and len(bodies) == 1 else before + own, material=material,
                      vertices=[list(p) for p in corners], faces=faces, **keys)
        if support:
            block.fixed = True
        blocks.append(block)
    return blocks


def read_blocks(path, *, material, scale=1.0, name=None, fixed=False, **keys):
    """The bodies of a mesh file as a list of blocks for scene.block, lengths times scale; each must be convex. OBJ, OFF,
    STL and assemblies of COMPAS (.json) are read as by a scene's key `mesh`, with the names and supports of the file, and
    `name` as prefix if it is given. Other files give the surfaces of their tetrahedra, or else their closed surfaces.
    Bodies are separated by gmsh's volumes and by connectivity. Their names are `name` (or that of the file) and a number.
    fixed: True, or the names of fixed blocks. With rigid=False the tetrahedra of the file are the zones of deformable
    blocks; with zone_edge, blocks have zones of their own."""
    path = os.fspath(path)
    if _is_own(path):
        return _own_blocks(path, material, scale, name, fixed, keys)
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
    except (ValueError, OverflowError) as fault:  # a value that is no number
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
    all_fixed, wanted = _fixed_names(fixed)
    for block, held in zip(blocks, _chosen(path, [b.name for b in blocks], all_fixed, wanted, [False] * len(blocks))):
        if held:
            block.fixed = True
    return blocks
