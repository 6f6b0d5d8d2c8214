"""Mutated meshes, PLY and gmsh's .msh, text and binary: each is read, or refused with a message. None takes a long time or
much memory, or ends the interpreter. usage: mesh_fuzz_test.py [INPUTS [SEED]]; INPUTS: number of mutations of all files."""
import collections
import os
import random
import re
import resource
import signal
import sys
import tempfile
import time

import quoin
from support import SOURCE  # noqa: F401  exits with 77 where NumPy is missing

try:
    import meshio
except ImportError:
    print("skipped: meshio is not installed (python3-meshio)")
    sys.exit(77)

SECONDS, BYTES = 10, 4 << 30  # limits for an input, as for the readers of tests/fuzz
NUMBERS = (b"0", b"-1", b"1", b"3", b"4", b"2147483647", b"-2147483648", b"4294967296", b"99999999999", b"1e308", b"nan", b"inf",
           b"0x10", b"1.5", b"")


def seeds(folder):
    """Yields two cubes, as tetrahedra and as surfaces, in every format: (name, bytes)."""
    corners = [[i & 1, i >> 1 & 1, i >> 2] for i in range(8)]
    points = [[x + shift, y, z] for shift in (0.0, 2.0) for x, y, z in corners]
    five = [[0, 1, 2, 4], [3, 1, 2, 7], [5, 1, 4, 7], [6, 2, 4, 7], [1, 2, 4, 7]]
    quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
    def twice(cells):
        return cells + [[n + 8 for n in cell] for cell in cells]
    zones = meshio.Mesh(points, [("tetra", twice(five))], cell_data={"gmsh:geometrical": [[1] * 5 + [2] * 5],
                                                                     "gmsh:physical": [[1] * 5 + [2] * 5]})
    surface = meshio.Mesh(points, [("quad", twice(quads))])
    for name, mesh, options in (("a.ply", surface, {"binary": False}), ("b.ply", surface, {"binary": True}),
                                ("2a.msh", zones, {"file_format": "gmsh22", "binary": False}),
                                ("2b.msh", zones, {"file_format": "gmsh22", "binary": True}),
                                ("4a.msh", zones, {"file_format": "gmsh", "binary": False}),
                                ("4b.msh", zones, {"file_format": "gmsh", "binary": True})):
        path = os.path.join(folder, name)
        mesh.write(path, **options)
        with open(path, "rb") as file:
            yield name, re.sub(rb"meshio v.*", b"meshio", file.read())  # without the time of day


def mutated(data, other, rng):
    """Makes one to four changes: of bytes, numbers or lines; parts are removed, repeated or taken from another file."""
    data = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 4))):
        at = rng.randrange(len(data) + 1)
        to = min(len(data), at + rng.choice((1, 2, 4, 8, 40)))
        kind = rng.randrange(7)
        if kind == 0 and at < len(data):
            data[at] = rng.randrange(256)
        elif kind == 1:
            del data[at:to]
        elif kind == 2:
            data[at:at] = data[at:to]
        elif kind == 3:
            start = rng.randrange(len(other))
            data[at:to] = other[start:start + to - at]
        elif kind == 4:
            data[at:to] = rng.choice((b"\0", b"\xff", b"\x7f")) * (to - at)
        elif kind == 5:
            del data[at:]
        else:  # the number after the next space
            begin = data.find(b" ", at) + 1
            end = begin
            while end < len(data) and data[end:end + 1] not in (b" ", b"\n"):
                end += 1
            data[begin:end] = rng.choice(NUMBERS)
    return bytes(data)


class TooLong(BaseException):
    """A BaseException, so that handlers of a reader's exceptions do not catch it."""


def fuzz(inputs, seed):
    def stop(*_):
        raise TooLong
    signal.signal(signal.SIGALRM, stop)
    resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
    rng = random.Random(seed)
    ends = collections.defaultdict(collections.Counter)
    faults, slowest, told = 0, 0.0, time.monotonic()
    with tempfile.TemporaryDirectory(dir="/dev/shm" if os.path.isdir("/dev/shm") else None) as folder:
        files = list(seeds(folder))
        for i in range(inputs):
            name, data = files[i % len(files)]
            data = mutated(data, files[rng.randrange(len(files))][1], rng)
            path = os.path.join(folder, "input" + name[-4:])
            with open(path, "wb") as file:
                file.write(data)
            start = time.monotonic()
            signal.alarm(SECONDS)
            try:
                blocks = quoin.read_blocks(path, material="stone", rigid=rng.random() < 0.5)
                end = "read" if blocks else "nothing"
            except quoin.BadInput as refused:
                end = "refused" if len(str(refused)) > len(path) + 5 else "without words"
            except BaseException as fault:  # noqa: B902  the end of the program is a fault, too
                end = type(fault).__name__
            signal.alarm(0)
            slowest = max(slowest, time.monotonic() - start)
            ends[name][end] += 1
            if end not in ("read", "refused"):
                faults += 1
                print(f"input {i}, {name}: {end}: {data[:1500]}", flush=True)
            if time.monotonic() - told > 30.0:
                told = time.monotonic()
                print(f"{i} of {inputs}, {faults} faults", file=sys.stderr, flush=True)
    for name, counts in ends.items():
        print(name, ", ".join(f"{end} {count}" for end, count in sorted(counts.items())))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    print(f"{inputs} inputs, seed {seed}: the slowest {slowest:.2f} s, at most {memory} MB, {faults} faults")
    assert not faults


if __name__ == "__main__":
    fuzz(int(sys.argv[1]) if len(sys.argv) > 1 else 1500, int(sys.argv[2]) if len(sys.argv) > 2 else 1)
