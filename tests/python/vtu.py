"""Reads the files of frames of a run without the package and without VTK."""
import re
import struct

import numpy as np

KINDS = {"Float32": "<f4", "Int32": "<i4", "Int64": "<i8", "UInt8": "u1"}


class Vtu:
    """Arrays of an uncompressed VTU file by name, rows by components."""

    def __init__(self, path):
        with open(path, "rb") as file:
            self._bytes = file.read()
        mark = b'<AppendedData encoding="raw">\n_'
        begin = self._bytes.index(mark) + len(mark)
        head = self._bytes[:begin].decode()
        self._arrays = {}
        for tag in re.findall(r"<DataArray ([^>]*)/>", head):
            of = dict(re.findall(r'(\w+)="([^"]*)"', tag))
            self._arrays[of["Name"]] = (KINDS[of["type"]], int(of["NumberOfComponents"]), begin + int(of["offset"]))

    def __getitem__(self, name):
        kind, columns, place = self._arrays[name]
        size, = struct.unpack_from("<Q", self._bytes, place)
        values = np.frombuffer(self._bytes, kind, size // np.dtype(kind).itemsize, place + 8)
        return values.reshape(-1, columns) if columns > 1 else values

    def __contains__(self, name):
        return name in self._arrays

    def block_of_point(self):
        """Returns the block of each point of a frame, by the cells of the point."""
        block = np.full(len(self["position"]), -1)
        sizes = np.diff(self["offsets"], prepend=0)
        block[self["connectivity"]] = np.repeat(self["block"], sizes)
        return block


def times_of(folder, kind="blocks"):
    """Returns the times of the frames of a run, s."""
    with open(f"{folder}/{kind}.pvd", encoding="utf-8") as file:
        return [float(t) for t in re.findall(r'timestep="([^"]*)"', file.read())]


def history_of(folder):
    """Returns history.csv by column; empty cells are NaN."""
    with open(f"{folder}/history.csv", encoding="utf-8") as file:
        names, *rows = (line.rstrip("\n").split(",") for line in file)
    columns = {}
    for k, name in enumerate(names):
        cells = [row[k] for row in rows]
        columns[name] = (np.array([cell.strip('"') for cell in cells]) if name == "stage_name" else
                         np.array([float(cell) if cell else np.nan for cell in cells]))
    return columns
