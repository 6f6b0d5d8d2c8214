"""Results of a run, read from its folder."""
import csv
import json
import os
import re
import struct
import zlib

import numpy as np

from .errors import BadInput
from .pictures import Pictures
from .xdmf import save_xdmf

KINDS = {"Float32": "<f4", "Int32": "<i4", "Int64": "<i8", "UInt8": "u1"}
UNITS = {"m": "m", "m2": "m2", "N": "N", "Pa": "Pa", "s": "s", "J": "J", "kg": "kg", "rad": "rad",
         "Nm": "N m"}
CELLS = {7: None, 9: None, 10: ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
         12: ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))}


def unit(name):
    """Unit of a column or array, from the end of its name: unit("horizontal_force_N") is "N"; "" without a unit."""
    whole = {"_N_per_m": "N/m", "_m_s2": "m/s2", "_m_s": "m/s"}
    return next((u for end, u in whole.items() if name.endswith(end)), UNITS.get(name.rsplit("_", 1)[-1], ""))


class _Grid:
    """Arrays of a VTU file of Quoin by name, rows by components."""

    def __init__(self, path):
        try:
            with open(path, "rb") as file:
                self._bytes = file.read()
        except OSError as fault:
            raise BadInput(f"{path}: {fault.strerror}; run the scene again, without output.pieces") from None
        self._path = path
        mark = b'<AppendedData encoding="raw">\n_'
        begin = self._bytes.find(mark) + len(mark)
        head = self._bytes[:begin].decode(errors="replace")
        self._packed = "vtkZLibDataCompressor" in head
        self.arrays = {}
        for tag in re.findall(r"<DataArray ([^>]*)/>", head):
            of = dict(re.findall(r'(\w+)="([^"]*)"', tag))
            self.arrays[of["Name"]] = (KINDS[of["type"]], int(of["NumberOfComponents"]), begin + int(of["offset"]))

    def __getitem__(self, name):
        kind, columns, place = self.arrays[name]
        try:
            values = np.frombuffer(self._unpacked(place), kind)
            return values.reshape(-1, columns) if columns > 1 else values
        except (ValueError, struct.error, zlib.error):
            raise BadInput(f"{self._path}: is damaged or cut off; run the scene again") from None

    def _unpacked(self, place):
        first, = struct.unpack_from("<Q", self._bytes, place)
        if not self._packed:
            values = self._bytes[place + 8:place + 8 + first]
            if len(values) < first:
                raise ValueError("too short")
            return values
        sizes = struct.unpack_from(f"<{first}Q", self._bytes, place + 24)
        at, parts = place + 24 + 8 * first, []
        for size in sizes:
            parts.append(zlib.decompress(self._bytes[at:at + size]))
            at += size
        return b"".join(parts)


class Moment:
    """A frame of a run, read on first access. time, s; stage, from 1; row, of the history (None without rows). blocks and joints: arrays by
    name, as in the files for ParaView, with units at the end of their names: position, displacement_m, stress_Pa (xx yy
    zz xy yz zx), block ...; position, displacement_m, traction_Pa (normal, two shears, tension positive), opening_m,
    slip_m, damage_tension, area_m2, block_a, block_b ... forces: one row per pair of blocks with a present or former
    joint: position (centre of compression, in its current place), force_N (on block_a), normal (from block_a to block_b),
    normal_force_N (tension positive), shear_force_N, eccentricity (over the depth of the joint; 0.5 is an edge), area_m2
    (in contact), opening_m, slip_m, damage, crack. Where half of the thickness is modelled, forces are those of the
    half."""

    def __init__(self, folder, number, time, stage, row):
        self.number, self.time, self.stage, self.row = number, time, stage, row
        self._folder, self._grids = folder, {}

    def _grid(self, kind):
        if kind not in self._grids:
            self._grids[kind] = _Grid(os.path.join(self._folder, f"{kind}_{self.number:04}.vtu"))
        return self._grids[kind]

    def _all(self, kind):
        grid = self._grid(kind)
        return {name: grid[name] for name in grid.arrays}

    blocks = property(lambda self: self._all("blocks"))
    joints = property(lambda self: self._all("joints"))
    forces = property(lambda self: self._all("forces"))

    def faces(self):
        """Surface of the model: (corners as indices of points, block), counter-clockwise from outside."""
        grid = self._grid("blocks")
        corners, ends, types, block = grid["connectivity"], grid["offsets"], grid["types"], grid["block"]
        once, result = {}, []
        for c, (begin, end) in enumerate(zip(np.r_[0, ends[:-1]], ends)):
            cell = corners[begin:end].tolist()
            table = CELLS.get(int(types[c]))
            for face in ([cell] if table is None else [[cell[k] for k in f] for f in table]):
                if types[c] != 10:
                    result.append((face, int(block[c])))
                elif once.pop(key := tuple(sorted(face)), None) is None:
                    once[key] = (face, int(block[c]))
        return result + list(once.values())

    def joint_forces(self):
        """Forces by contact point, N, on block_a; those on block_b are opposite."""
        grid = self._grid("joints")
        n, s, traction = (grid[name].astype(float) for name in ("normal", "shear_axis", "traction_Pa"))
        force = traction[:, :1] * n + traction[:, 1:2] * s + traction[:, 2:3] * np.cross(n, s)
        force *= grid["area_m2"].astype(float)[:, None]
        if "gap_m" in grid.arrays:
            force[np.any(grid["gap_m"] != 0, axis=1)] = 0.0  # parted
        return force

    def force_on(self, block):
        """Sum of the forces of joints on a block, N. At rest the reaction of a support is its opposite, less the
        support's own weight."""
        grid, force = self._grid("joints"), self.joint_forces()
        if block not in self._grid("blocks")["block"]:
            raise IndexError(f"block: {block} is not among the blocks, 0 to {self._grid('blocks')['block'].max()}")
        return force[grid["block_a"] == block].sum(axis=0) - force[grid["block_b"] == block].sum(axis=0)

    def __repr__(self):
        return f"<moment {self.number}: stage {self.stage}, {self.time:.6g} s>"


def _table(path):
    """history.csv or monitors.csv as a structured array; empty cells are NaN."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    if not rows:
        raise BadInput(f"{path}: is empty; run the scene again")
    names, rows = rows[0], rows[1:]
    if any(len(row) != len(names) for row in rows):
        raise BadInput(f"{path}: rows differ in length; run the scene again")
    kinds, columns = [], []
    for k, name in enumerate(names):
        cells = [row[k] for row in rows]
        if name == "stage_name":
            columns.append(np.array(cells, dtype=str) if cells else np.empty(0, "U1"))
        else:
            columns.append(np.array([float(c) if c else np.nan for c in cells]).astype(int if name in ("stage", "step") else float))
        kinds.append((name, columns[-1].dtype))
    table = np.empty(len(rows), dtype=kinds)
    for name, column in zip(names, columns):
        table[name] = column
    return table


class Results(Pictures):
    """Results of a run in a folder. history, monitors: structured arrays with the names and units of history.csv and
    monitors.csv; monitors is None in a run without [[monitor]]. summary: contents of summary.json; frames: its moments."""

    def __init__(self, folder):
        self.folder = os.fspath(folder)
        path = os.path.join(self.folder, "summary.json")
        try:
            with open(path, encoding="utf-8") as file:
                self.summary = json.load(file)
            path = os.path.join(self.folder, "history.csv")
            self.history = _table(path)
            path = os.path.join(self.folder, "monitors.csv")
            self.monitors = _table(path) if os.path.exists(path) else None
        except FileNotFoundError as fault:
            raise BadInput(f"{fault.filename}: not found; give the folder of a run that has ended, as quoin run SCENE.toml "
                           f"--out {self.folder} makes it") from None
        except ValueError:
            raise BadInput(f"{path}: is damaged or cut off; run the scene again") from None
        self.frames = []
        collection = os.path.join(self.folder, "blocks.pvd")
        if not os.path.exists(collection):
            return
        with open(collection, encoding="utf-8") as file:
            times = [float(t) for t in re.findall(r'timestep="([^"]*)"', file.read())]
        for k, time in enumerate(times):
            if not len(self.history):  # the run failed in its first step
                self.frames.append(Moment(self.folder, k, time, 1, None))
                continue
            row = min(np.searchsorted(self.history["time_s"], time * (1 - 1e-8)), len(self.history) - 1)
            self.frames.append(Moment(self.folder, k, time, int(self.history["stage"][row]), int(row)))

    unit = staticmethod(unit)
    save_xdmf = save_xdmf

    def joint_histories(self, name="opening_m"):
        """An array of `forces` along the run: (pairs of blocks, times in s, values by frame and pair); NaN where a pair
        has not been in contact so far. joint_histories() returns crack widths."""
        tables = []
        for moment in self.frames:
            forces = moment.forces
            tables.append(dict(zip(zip(forces["block_a"].tolist(), forces["block_b"].tolist()), forces[name].astype(float))))
        pairs = sorted(set().union(*tables)) if tables else []
        values = np.array([[table.get(pair, np.nan) for pair in pairs] for table in tables]).reshape(len(tables), len(pairs))
        return np.array(pairs, int).reshape(-1, 2), np.array([moment.time for moment in self.frames]), values

    @property
    def title(self):
        return self.summary.get("title") or os.path.basename(os.path.normpath(self.folder))

    @property
    def peak(self):
        """Largest force, N, and its displacement, m: magnitudes; the history has the signs."""
        upright = self.summary["peak_vertical_force_N"]
        return self.summary["peak_horizontal_force_N"] if upright is None else upright, self.summary["displacement_at_peak_m"]

    def __repr__(self):
        return f"<results in {self.folder}: {len(self.history)} rows, {len(self.frames)} frames>"


def open_results(folder):
    """Results in a folder written by `quoin run --out` or quoin.run(out=...)."""
    return Results(folder)
