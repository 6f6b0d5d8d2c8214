"""A run in a pair of files for other programs: XDMF, with the names of arrays, and HDF5, with their values."""
import os
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from .errors import BadInput, Error

XDMF_OF_VTK = {1: (1, True), 7: (3, True), 9: (5, False), 10: (6, False), 12: (9, False)}  # number; whether corners are counted
PART = ".part"  # of the names of files that are not whole yet
GRID = ("position", "connectivity", "offsets", "types")


def _topology(grid):
    """Cells in XDMF's format Mixed: kind, number of corners where it varies, corners."""
    corners, ends, types = grid["connectivity"], grid["offsets"], grid["types"]
    begins = np.r_[0, ends[:-1]]
    if len(types) and np.all(types == types[0]):
        number, counted = XDMF_OF_VTK[int(types[0])]
        count = int(ends[0])
        if np.all(ends - begins == count):
            rows = corners.reshape(-1, count)
            head = [np.full((len(rows), 1), number), np.full((len(rows), 1), count)][:2 if counted else 1]
            return np.hstack([*head, rows]).astype(np.int64).ravel()
    parts = []
    for kind, begin, end in zip(types, begins, ends):
        number, counted = XDMF_OF_VTK[int(kind)]
        parts.append([number, end - begin] if counted else [number])
        parts.append(corners[begin:end])
    return np.concatenate(parts).astype(np.int64) if parts else np.empty(0, np.int64)


def _item(data, name, values):
    packed = dict(compression="gzip", compression_opts=1, shuffle=True) if values.size else {}
    data.create_dataset(name, data=values, **packed)
    kind = "Int" if np.issubdtype(values.dtype, np.integer) else "Float"
    shape = " ".join(map(str, values.shape))
    place = escape(os.path.basename(data.file.filename).removesuffix(PART) + ":" + data.name.rstrip("/") + "/" + name)
    return f'<DataItem Format="HDF" NumberType="{kind}" Precision="{values.dtype.itemsize}" Dimensions="{shape}">{place}</DataItem>'


def _grid(data, moment, arrays):
    topology, position = _topology(arrays), arrays["position"]
    points, cells = len(position), len(arrays["types"])
    lines = [f'<Grid Name="{moment.number}"><Time Value="{moment.time!r}"/>',
             f'<Topology TopologyType="Mixed" NumberOfElements="{cells}">{_item(data, "topology", topology)}</Topology>',
             f'<Geometry GeometryType="XYZ">{_item(data, "position", position)}</Geometry>']
    for name, values in arrays.items():
        if name in GRID:
            continue
        if len(values) not in (points, cells):
            raise BadInput(f"frame {moment.number}: {name} has {len(values)} rows, {points} points, {cells} cells; run the scene again")
        on_points = len(values) == points and not (len(values) == cells and name in ("stress_Pa", "block", "unit", "course"))
        rank = {1: "Scalar", 3: "Vector"}.get(1 if values.ndim == 1 else values.shape[1], "Matrix")
        lines.append(f'<Attribute Name={quoteattr(name)} AttributeType="{rank}" Center="{"Node" if on_points else "Cell"}">'
                     f'{_item(data, name, values)}</Attribute>')
    return "\n".join([*lines, "</Grid>"])


def _write_arrays(file, run, kinds, string_dtype):
    """Writes frames and history; returns the parts of the .xdmf file."""
    parts = []
    for kind in kinds:
        grids = [_grid(file.create_group(f"{kind}/{moment.number:04}"), moment, getattr(moment, kind)) for moment in run.frames]
        parts.append(f'<Grid Name="{kind}" GridType="Collection" CollectionType="Temporal">\n' + "\n".join(grids) + "\n</Grid>")
    history = file.create_group("history")
    for name in run.history.dtype.names:
        values = run.history[name]
        if values.dtype.kind == "U":
            values = np.char.encode(values, "utf-8")
            values = values.astype(string_dtype("utf-8", values.dtype.itemsize))
        history.create_dataset(name.replace("/", "_"), data=values)
    return parts


def save_xdmf(run, path, kinds=("blocks", "joints", "forces")):
    """Writes all frames of a run to PATH (.xdmf) and their arrays to a file .h5 next to it, for ParaView, VisIt and other
    readers of HDF5. Requires h5py."""
    try:
        import h5py
    except ImportError:
        raise Error("save_xdmf needs h5py, which is not installed for this Python: apt-get install python3-h5py") from None
    path = os.fspath(path)
    if not path.endswith(".xdmf"):
        raise BadInput(f"{path}: the name of the file ends in .xdmf")
    if not run.frames:
        raise BadInput(f"{run.folder}: has no frames; run the scene with output.frames = 20")
    arrays = path[:-len("xdmf")] + "h5"
    try:
        with h5py.File(arrays + PART, "w") as file:
            parts = _write_arrays(file, run, kinds, h5py.string_dtype)
        with open(path + PART, "w", encoding="utf-8") as file:
            file.write('<?xml version="1.0"?>\n<Xdmf Version="2.0"><Domain>\n' + "\n".join(parts) + "\n</Domain></Xdmf>\n")
        for name in (arrays, path):
            os.replace(name + PART, name)
    finally:
        for name in (arrays, path):
            if os.path.exists(name + PART):
                os.remove(name + PART)
    return path
