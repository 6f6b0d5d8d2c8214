"""A model on several processes by MPI. Usage: ranks_test.py QUOIN MPIRUN CASE

Results must be bitwise identical to those of one process: every row of the history, the last state of every gridpoint and
contact point (files for ParaView), and the summary without times, threads and ranks.
"""
import atexit
import json
import mmap
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
from xml.etree import ElementTree

quoin, mpirun, case = sys.argv[1:]
root = pathlib.Path(__file__).resolve().parents[2]
folder = pathlib.Path(tempfile.mkdtemp(prefix="quoin_mpi_"))
atexit.register(shutil.rmtree, folder, ignore_errors=True)
scenes = {
    # Bricks on the lattice, a law swap, rows with energies.
    "wall": (root / "tests/cli/small_wall.toml", ["output.energy=true", "stage.precompression.duration=0.006",
                                                 "stage.shear.displacement=0.00005"]),
    # Walls around a corner, a floor pushed by a whiffletree, until a promotion.
    "building": (root / "tests/host/small_building.toml", ["stage.push.displacement=0.0002", "stage.push.record_interval=100"]),
    # Rigid blocks in large motion, with contact detections while they fall.
    "arch": (root / "host/scenes/arch.toml", ["arch.arch.voussoirs=33", "stage.push.collapse.rate=0.2", "stage.weight.duration=0.2",
                                              "stage.weight.ramp_time=0.1", "stage.push.ramp_time=0.2"]),
    # A bonded wall of rigid units whose joints break, a post and an arch that fall onto each other.
    "collapse": (root / "host/scenes/mixed.toml", ["stage.push.duration=0.3"]),
    # Open cracked joints, random stiffnesses, added inertia, a law swap in the last stage.
    "damaged": (root / "host/scenes/damaged_wall_030.toml", [
        "wall.courses=8", "wall.zones=[2, 1, 1]", "damage.1.crack=[[0.11, 0.4], [0.88, 0.07]]", "damage.1.opening=1e-6",
        "joints.unit.normal_stiffness={distribution='lognormal', mean=1000e9, cov=0.3, correlation_length=0.2}",
        "solver.selective_time_step=1.5e-5", "stage.precompression.duration=0.004", "stage.settlement.displacement=0.00001",
        "stage.settlement.ramp_time=0.001", "stage.shear.displacement=0.00001", "stage.shear.law={mortar='coulomb_slip'}"]),
    # A promotion in mid-run, with tractions and states.
    "promotion": (root / "tests/cli/small_wall.toml", ["solver.rotation_bound=1e-5", "stage.shear.displacement=0.0002"]),
    # Deformable blocks of any shape.
    "deformable": (root / "host/scenes/mixed.toml", ["wall.rigid_units=false", "wall.zones=[2, 2, 1]",
                                                     "stage.weight.duration=0.02", "stage.push.duration=0.02"]),
    # A facade with ties.
    "members": (root / "host/scenes/tied_facade.toml", ["tie.left.pretension=500", "stage.weight.duration=0.02",
                                                        "stage.weight.ramp_time=0.01", "stage.push.ramp_time=0.02",
                                                        "stage.push.duration=0.03", "stage.push.collapse.start=0.3"]),
}


def words(ranks, arguments):
    start = [mpirun, "-n", str(ranks), "--oversubscribe", "--bind-to", "none", "--allow-run-as-root"] if ranks > 1 else []
    return start + [quoin, "run", *map(str, arguments), "--threads", "1"]


def scene_of(name):
    path, settings = scenes[name]
    settings = [*settings, "output.frames=2", "output.plots=false"]
    return [path] + [word for setting in settings for word in ("--set", setting)]


def run(ranks, arguments, code=0, **more):
    done = subprocess.run(words(ranks, arguments), capture_output=True, text=True, timeout=240, **more)
    assert done.returncode == code, f"{ranks} ranks: exit code {done.returncode}, not {code}\n{done.stdout}{done.stderr}"
    return done


def results(out):
    """Returns the results of a run as bytes, by file."""
    summary = json.loads((out / "summary.json").read_text())
    for key in ("wall_clock_s", "threads", "ranks"):
        summary.pop(key, None)
    summary["provenance"].pop("threads", None)
    summary["provenance"].pop("wall_clock_s", None)
    summary["provenance"].pop("files", None)  # hashes of a start state that ranks have written
    found = {"history.csv": (out / "history.csv").read_bytes(), "summary.json": json.dumps(summary, indent=1).encode()}
    for file in sorted(out.glob("*.vtu")):
        found[file.name] = file.read_bytes()
    return found


def same(one, other, who):
    assert one.keys() == other.keys(), f"{who}: {sorted(other)} in place of {sorted(one)}"
    for name, content in one.items():
        if content == other[name]:
            continue
        lines = zip(content.splitlines(), other[name].splitlines())
        first = next((f"line {i + 1}: {a[:200]} | {b[:200]}" for i, (a, b) in enumerate(lines) if a != b), "its length")
        raise AssertionError(f"{who}: {name} differs: {first}")


def same_bits(name):
    run(1, [*scene_of(name), "--out", folder / "1"])
    alone = results(folder / "1")
    assert len(alone) > 2, "no frames: nothing is known of blocks and contact points"
    for ranks in (2, 3, 4):
        out = folder / str(ranks)
        done = run(ranks, [*scene_of(name), "--out", out])
        same(alone, results(out), f"{ranks} ranks")
        traffic = json.loads((out / "summary.json").read_text())["ranks"]
        assert traffic["count"] == ranks and len(traffic["by_rank"]) == ranks
        assert sum(r["blocks"] > 0 and r["bytes_a_step"] > 0 for r in traffic["by_rank"]) > 1, traffic
        assert f"ranks: {ranks};" in done.stdout, done.stdout
        assert name != "promotion" or json.loads((out / "summary.json").read_text())["motion"]["promoted"], "no promotion"
        print(f"{name}: {ranks} ranks, the same bits; {done.stdout.splitlines()[-1]}")


def start(ranks, arguments):
    return subprocess.Popen(words(ranks, arguments), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def wait_for_checkpoint(out, process):
    for _ in range(1200):
        if (out / "checkpoint.bin").exists():
            return
        assert process.poll() is None, f"ended before its first checkpoint:\n{process.communicate()[0]}"
        time.sleep(0.05)
    raise AssertionError("no checkpoint within 60 s")


# A run of a second on a fast machine, long enough to be stopped in the middle.
long_scene = [root / "tests/cli/small_wall.toml"] + [
    word for setting in ("stage.shear.velocity=0.0002", "output.frames=2", "output.plots=false")
    for word in ("--set", setting)]


def ranks_of(process):
    """Returns the process ids of the quoin processes of mpirun, in the order of their ranks."""
    found = {}
    for entry in pathlib.Path("/proc").iterdir():
        try:
            if not entry.name.isdigit() or int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1]) != process.pid:
                continue
            variables = dict(v.split("=", 1) for v in (entry / "environ").read_text().split("\0") if "=" in v)
            found[int(variables["OMPI_COMM_WORLD_RANK"])] = int(entry.name)
        except (OSError, KeyError):
            continue
    return [found[r] for r in sorted(found)]


def killed():
    """If a rank is killed all ranks end, and the run resumes from its last checkpoint on other numbers of ranks."""
    run(1, [*long_scene, "--out", folder / "whole"])
    for victim, others in ((1, 3), (0, 1)):
        out = folder / f"killed_{victim}"
        process = start(2, [*long_scene, "--out", out, "--checkpoint-every", "0.1"])
        wait_for_checkpoint(out, process)
        pids = ranks_of(process)
        assert len(pids) == 2, pids
        os.kill(pids[victim], signal.SIGKILL)
        killed_at = time.monotonic()
        text = process.communicate(timeout=60)[0]
        seconds = time.monotonic() - killed_at
        assert process.returncode != 0 and seconds < 20, (process.returncode, seconds)
        assert "signal 9" in text, text
        assert not (out / "summary.json").exists()
        run(others, ["--resume", out])
        same(results(folder / "whole"), results(out), f"killed on 2 ranks, resumed on {others}")
        print(f"rank {victim} killed: all ended after {seconds:.1f} s; resumed on {others}, the same bits")


def stopped():
    """On Ctrl-C, or SIGUSR1 through mpirun, all ranks stop at one step and the results so far are kept."""
    out = folder / "stopped"
    process = start(3, [*long_scene, "--out", out])
    for _ in range(1200):
        if (out / "history.csv.partial").exists() or list(out.glob("history*")):
            break
        time.sleep(0.05)
    time.sleep(0.5)
    for pid in ranks_of(process)[1:2]:  # one of them is enough
        os.kill(pid, signal.SIGTERM)
    text = process.communicate(timeout=60)[0]
    assert process.returncode == 130, (process.returncode, text)
    assert json.loads((out / "summary.json").read_text())["status"] == "interrupted", text
    checkpoint = out / "checkpoint.bin"
    whole = checkpoint.read_bytes()
    half = len(whole) // 2
    checkpoint.write_bytes(whole[:half] + bytes([whole[half] ^ 1]) + whole[half + 1:])
    done = run(2, ["--resume", out], code=3)
    assert done.stderr.count("is damaged") == 1 and "refused by rank 0" not in done.stderr, done.stderr
    checkpoint.write_bytes(whole)
    run(1, ["--resume", out])
    run(1, [*long_scene, "--out", folder / "whole"])
    same(results(folder / "whole"), results(out), "stopped on 3 ranks, resumed on 1")

    out = folder / "handed_on"
    frames = ["--set", "output.frames=40"]
    process = start(2, [*long_scene, *frames, "--out", out])
    for _ in range(1200):
        if (out / "blocks_0001.vtu").exists():
            break
        time.sleep(0.05)
    process.send_signal(signal.SIGUSR1)
    text = process.communicate(timeout=60)[0]
    assert process.returncode == 130, (process.returncode, text)
    assert json.loads((out / "summary.json").read_text())["status"] == "interrupted", text
    assert (out / "checkpoint.bin").exists()
    run(3, ["--resume", out])
    run(1, [*long_scene, *frames, "--out", folder / "whole"])
    same(results(folder / "whole"), results(out), "stopped on 2 ranks by mpirun, resumed on 3")
    for file in sorted((folder / "whole").glob("*.vtu")):
        assert file.read_bytes() == (out / file.name).read_bytes(), file


def vanished():
    """If the output folder is removed during a run all ranks end at the next checkpoint, with a message."""
    out = folder / "vanished"
    process = start(2, [*long_scene, "--out", out, "--checkpoint-every", "0.1"])
    wait_for_checkpoint(out, process)
    while out.exists():
        shutil.rmtree(out, ignore_errors=True)
    text = process.communicate(timeout=60)[0]
    assert process.returncode == 3, (process.returncode, text)
    assert text.count("the folder has gone") == 1 and "MPI Error" not in text and "rank 1" not in text, text


def memory():
    """If a rank has too little memory all ranks end, with a message."""
    starve = ["sh", "-c", 'ulimit -v "$1"; shift; exec "$@"', "sh"]
    program = [quoin, "run", str(root / "tests/cli/small_wall.toml"), "--out", str(folder / "memory"), "--threads", "1",
               "--force"]
    for setting in ("wall.courses=300", "wall.units_per_course=40", "stage.precompression.duration=0.0003",
                    "stage.shear.displacement=1e-7", "output.frames=0", "output.plots=false"):
        program += ["--set", setting]
    host = ["--oversubscribe", "--bind-to", "none", "--allow-run-as-root"]
    # The memory of MPI itself depends on the machine: with less, MPI fails; with more, the model has enough. MPI may also
    # wait without end if its shared memory is too small (Open MPI 4.1, status 124 of timeout).
    for kilobytes in range(150000, 400000, 25000):
        done = subprocess.run(["timeout", "--kill-after=5", "15", mpirun, *host, "-n", "1", *program, ":",
                               "-n", "1", *starve, str(kilobytes), *program],
                              capture_output=True, text=True, timeout=120)
        text = done.stdout + done.stderr
        assert done.returncode != 0, f"enough memory with {kilobytes} kB, and no word of too little with less"
        if "rank 1: out of memory" in text:
            break
    assert done.returncode == 5, (done.returncode, text)
    print(f"{kilobytes} kB:", next(line for line in text.splitlines() if "out of memory" in line))


def refused():
    """Options that do not work with ranks have a message; the fault of a scene is printed once."""
    done = run(2, [*long_scene, "--out", folder / "isolated", "--isolate-law"], code=2)
    assert done.stderr.count("--isolate-law: not with several ranks") == 1, done.stderr
    done = run(2, [root / "no_such_scene.toml", "--out", folder / "none"], code=3)
    assert done.stderr.count("no_such_scene.toml") == 1, done.stderr
    scene = (root / "tests/cli/small_wall.toml").read_text()
    (folder / "rest.toml").write_text(scene.replace("[output]", '[[stage]]\nname = "rest"\nkind = "rest"\n[output]', 1))
    done = run(2, [folder / "rest.toml", "--out", folder / "rest"], code=3)  # one rank waited for the other for ever
    assert done.stderr.count("a stage of rest runs in one process") == 1, done.stderr


def started():
    """A run that starts from the end of another one, each on another number of ranks."""
    scene = (root / "tests/cli/small_wall.toml").read_text()
    first, rest = scene.rindex("[[stage]]"), scene.index("[output]")
    (folder / "first.toml").write_text(scene[:first] + scene[rest:] + "end_state = true\nplots = false\n")
    (folder / "second.toml").write_text('start = "first"\n' + scene + "plots = false\n")
    for ranks, other in ((2, 3), (3, 1), (1, 2)):
        run(ranks, [folder / "first.toml", "--out", folder / "first"])
        run(other, [folder / "second.toml", "--out", folder / f"second_{other}"])
    for other in (2, 3):
        same(results(folder / "second_1"), results(folder / f"second_{other}"), f"started on {other} ranks")
    (folder / "first" / "end_state.bin").unlink()
    done = run(2, [folder / "second.toml", "--out", folder / "none"], code=3)
    assert "does not exist" in done.stderr, done.stderr


def balanced():
    """Load balancing: ranks with higher cost than estimated get fewer blocks, and results are bitwise identical.

    Costs are prescribed (QUOIN_DEAR_BLOCKS of step/state/rank_load.h), since times on a shared machine are not reliable. A
    run that begins above the bound of step/rank_balance.h must end below it. A run with costs as estimated must not change
    the partition. The numbers of blocks of the ranks must change.
    """
    bound = 1.15
    larger = [root / "tests/cli/small_wall.toml"] + [
        word for setting in ("wall.courses=12", "wall.units_per_course=6", "stage.shear.displacement=0.0001",
                             "output.frames=2", "output.plots=false") for word in ("--set", setting)]
    in_motion = [*larger, "--set", "solver.large_motion=always"]
    for name, scene, ranks, dear in (("lattice", larger, 2, "8x100"), ("lattice", larger, 3, "8x100"),
                                     ("large motion", in_motion, 2, "30x8")):
        if not (folder / name).exists():
            run(1, [*scene, "--out", folder / name])
        seen = {}
        for pretended in ("0x1", dear):
            out = folder / f"{name}_{ranks}_{pretended}"
            done = run(ranks, [*scene, "--out", out], env=os.environ | {"QUOIN_DEAR_BLOCKS": pretended})
            same(results(folder / name), results(out), f"{name}, {ranks} ranks, {pretended}")
            seen[pretended] = json.loads((out / "summary.json").read_text())["ranks"]
        even, uneven = seen["0x1"], seen[dear]
        assert even["divided_anew"] == 0 and even["most_over_mean_before"] is None and even["most_over_mean"] < bound, even
        assert uneven["divided_anew"] >= 1 and uneven["most_over_mean_before"] > bound > uneven["most_over_mean"], uneven
        assert [r["blocks"] for r in even["by_rank"]] != [r["blocks"] for r in uneven["by_rank"]], uneven
        assert "times by measured cost" in done.stdout, done.stdout
        print(f"{name}: {ranks} ranks, the same bits; {done.stdout.splitlines()[-1]}")
    # Too few blocks for an even load, and contact detections while they fall: blocks change ranks with their whole state.
    run(1, [*scene_of("collapse"), "--out", folder / "collapse"])
    out = folder / "collapse_3"
    run(3, [*scene_of("collapse"), "--out", out], env=os.environ | {"QUOIN_DEAR_BLOCKS": "10x8"})
    same(results(folder / "collapse"), results(out), "collapse")
    ranks = json.loads((out / "summary.json").read_text())["ranks"]
    assert ranks["divided_anew"] >= 1, ranks
    print(f"collapse: 3 ranks, the same bits; divided anew {ranks['divided_anew']:.0f} times")


def arrays_of(file):
    """Returns sizes and arrays of one raw file for ParaView: {section: {name: rows}}; positions under Points."""
    content = file.read_bytes()
    head, _, data = content.partition(b'<AppendedData encoding="raw">\n_')
    piece = ElementTree.fromstring(head + b"</VTKFile>").find(".//Piece")
    types = {"Float32": "<f4", "Int32": "<i4", "UInt8": "u1", "Int64": "<i8"}
    found = {}
    for section in piece:
        found[section.tag] = {}
        for array in section:
            at, components = int(array.get("offset")), int(array.get("NumberOfComponents"))
            size = int.from_bytes(data[at:at + 8], "little")
            kind = types[array.get("type")]
            code, width = {"<f4": ("f", 4), "<i4": ("i", 4), "u1": ("B", 1), "<i8": ("q", 8)}[kind]
            values = struct.unpack(f"<{size // width}{code}", data[at + 8:at + 8 + size])
            found[section.tag][array.get("Name")] = [values[i:i + components] for i in range(0, len(values), components)]
    return found


def content_of(files):
    """Returns all points and all cells of files together, each with its values, sorted, for any distribution to files.

    Numbers are as in the file, NaN as one word, so that the comparison is bitwise.
    """
    points, cells = [], []
    for file in files:
        arrays = arrays_of(file)
        named = sorted(arrays["PointData"].items())
        at = list(zip(arrays["Points"]["position"], *(values for _, values in named)))
        points += map(repr, at)
        values = sorted(arrays["CellData"].items())
        begin = 0
        corners, ends = arrays["Cells"]["connectivity"], arrays["Cells"]["offsets"]
        for i, (end,) in enumerate(ends):
            cells.append(repr((arrays["Cells"]["types"][i], [at[c] for (c,) in corners[begin:end]], [v[i] for _, v in values])))
            begin = end
        names = {section: sorted(arrays[section]) for section in ("PointData", "CellData")}
    return {"names": names, "points": sorted(points), "cells": sorted(cells)}


def frames_of(out, kind):
    """Returns the files of each frame in the collection: one file, or all pieces."""
    frames = []
    for dataset in ElementTree.parse(out / f"{kind}.pvd").iter("DataSet"):
        file = out / dataset.get("file")
        if file.suffix != ".pvtu":
            frames.append([file])
            continue
        index = ElementTree.parse(file)
        frames.append([out / piece.get("Source") for piece in index.iter("Piece")])
        for section in ("PointData", "CellData"):
            declared = [array.attrib for array in index.find(f".//P{section}")]
            for piece in frames[-1]:
                head = piece.read_bytes().partition(b"<AppendedData")[0] + b"</VTKFile>"
                there = [dict(array.attrib) for array in ElementTree.fromstring(head).find(f".//{section}")]
                for array in there:
                    array.pop("format"), array.pop("offset")
                assert declared == there, (piece, declared, there)
    return frames


def sizes_by_vtk(file):
    """Reads a file with the reader of ParaView; None: python3-vtk9 is not installed."""
    code = ("import sys\n"
            "try:\n from vtkmodules.vtkIOXML import vtkXMLPUnstructuredGridReader as R\n"
            "except ImportError:\n sys.exit(77)\n"
            "r = R(); r.SetFileName(sys.argv[1]); r.Update(); g = r.GetOutput()\n"
            "print(g.GetNumberOfPoints(), g.GetNumberOfCells(), r.GetErrorCode())\n"
            "print(*(d.GetArrayName(i) for d in (g.GetPointData(), g.GetCellData()) for i in range(d.GetNumberOfArrays())))\n")
    done = subprocess.run(["/usr/bin/python3", "-c", code, str(file)], capture_output=True, text=True)
    if done.returncode == 77:
        return None
    assert done.returncode == 0 and not done.stderr, (file, done.stdout, done.stderr)
    sizes, names = done.stdout.splitlines()
    return [int(n) for n in sizes.split()], names.split()


def same_frames(alone, out, who):
    for kind in ("blocks", "joints"):
        one, other = frames_of(alone, kind), frames_of(out, kind)
        assert len(one) == len(other) > 0, who
        for frame, (whole, pieces) in enumerate(zip(one, other)):
            expected, found = content_of(whole), content_of(pieces)
            for what in expected:
                assert expected[what] == found[what], f"{who}: {kind} {frame}: {what} differ"
            by_vtk = sizes_by_vtk(out / f"{kind}_{frame:04}.pvtu") if len(pieces) > 1 else None
            if by_vtk:
                assert by_vtk[0] == [len(expected["points"]), len(expected["cells"]), 0], (who, by_vtk)
                assert sorted(by_vtk[1]) == sorted(expected["names"]["PointData"] + expected["names"]["CellData"]), by_vtk


def large():
    """A state that is gathered in rounds, since it is larger than the 4 MiB of a round (base/rank_rows.h)."""
    scene = [root / "tests/cli/small_wall.toml"] + [
        word for setting in ("wall.courses=70", "wall.units_per_course=70", "stage.precompression.duration=0.0003",
                             "stage.shear.displacement=1e-7", "output.frames=1", "output.plots=false")
        for word in ("--set", setting)]
    run(1, [*scene, "--out", folder / "1"])
    run(3, [*scene, "--out", folder / "3"])
    same(results(folder / "1"), results(folder / "3"), "3 ranks")
    summary = json.loads((folder / "3" / "summary.json").read_text())
    gridpoints = 12  # of a block of 2 x 1 x 1 hexahedra
    state = 8 * (3 * summary["contact_points"] + 6 * gridpoints * summary["blocks"])  # tractions; displacement, velocity
    assert state > 4 * 2**20, state
    for rank in summary["ranks"]["by_rank"]:  # between the size of the state and the memory of a machine
        assert state < rank["peak_memory_bytes"] < 1e9, rank
    print(f"3 ranks, {summary['blocks']} blocks: the same bits; {state / 1e6:.1f} MB of state")


def takes_room_where_written():
    """Whether this system counts memory where it is written to, by small pages: some virtual machines do not."""
    def in_use():
        lines = pathlib.Path("/proc/self/status").read_text().splitlines()
        return sum(1024 * int(line.split()[1]) for line in lines if line.startswith("RssAnon:"))

    size, page, other = 2**25, mmap.PAGESIZE, 2**20
    memory = mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    memory.madvise(mmap.MADV_NOHUGEPAGE)
    before = in_use()
    assert not any(memory[i] for i in range(0, size, page))
    read = in_use() - before
    for i in range(0, size // 2, page):
        memory[i] = 1
    written = in_use() - before
    return read < other and abs(written - size / 2) < other


def parts():
    """The memory of a rank is that of its share of the model. The memory of the program, by a model of six blocks, is
    subtracted.

    A rank has a quarter of the blocks, borders, the outline of the whole and buffers of MPI. That is 0.61 to 0.68 of one
    process for these 10,000 blocks, and less for larger models, also for rank 0, without pictures. A rank with the whole
    model would have 1.3.
    """
    def scene(side):
        return [root / "tests/cli/small_wall.toml"] + [
            word for setting in (f"wall.courses={side}", f"wall.units_per_course={side}", "stage.precompression.duration=0.0003",
                                 "stage.shear.displacement=1e-7", "output.frames=0", "output.plots=false")
            for word in ("--set", setting)]

    def alone(side):
        process = subprocess.Popen(words(1, [*scene(side), "--out", folder / f"1_{side}"]), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        assert status == 0, status
        return 1024 * usage.ru_maxrss

    def by_rank(side):
        out = folder / f"4_{side}"
        run(4, [*scene(side), "--out", out, "--checkpoint-every", "0"])
        return [r["peak_memory_bytes"] for r in json.loads((out / "summary.json").read_text())["ranks"]["by_rank"]]

    whole = alone(100) - alone(2)
    shares = [large - small for large, small in zip(by_rank(100), by_rank(2))]
    same(results(folder / "1_100"), results(folder / "4_100"), "4 ranks")
    if not takes_room_where_written():
        print("4 ranks: the same bits; memory not compared, as this system does not count it by where it is written to")
        return
    assert all(0 < share < 0.8 * whole for share in shares), (shares, whole)
    print(f"4 ranks: {', '.join(f'{share / whole:.2f}' for share in shares)} of {whole / 1e6:.0f} MB")


def every_file_is_listed(out):
    listed = {name for manifest in out.glob(".quoin-manifest*") for name in manifest.read_text().split("\n")}
    missing = {file.name for file in out.glob("*vtu")} - listed
    assert not missing, missing


def wait_for(file, process):
    while not file.exists():
        assert process.poll() is None, process.communicate()[0]
        time.sleep(0.005)


def pieces_of_dead_ranks():
    """All ranks are killed at once: what each wrote is of the run, which resumes on any number of ranks.

    Members are in one file a frame, which rank 0 writes. Ranks that all wrote it took it from each other, and rank 0 gave up
    its frames. A folder in the place of such a file does the same: the pieces of rank 1 go on without those of rank 0.
    """
    scene = [*scene_of("members"), "--set", "output.frames=6"]
    run(1, [*scene, "--out", folder / "members"])
    for others, faulty in ((2, False), (1, False), (2, True)):
        out = folder / f"members_{others}_{faulty}"
        process = start(2, [*scene, "--set", "output.pieces=true", "--out", out, "--checkpoint-every", "0.02"])
        wait_for(out / "run.json", process)
        in_the_way = out / "members_0005.vtu"
        if faulty:
            in_the_way.mkdir()
        wait_for(out / f"joints_{7 if faulty else 2:04}_r1.vtu", process)
        for pid in ranks_of(process):
            os.kill(pid, signal.SIGKILL)
        text = process.communicate(timeout=60)[0]
        assert ("no more frames" in text) == faulty, text
        if faulty:
            in_the_way.rmdir()
        every_file_is_listed(out)
        (out / "notes.txt").write_text("mine")
        run(others, ["--resume", out])
        if faulty:
            continue
        same_frames(folder / "members", out, f"members, killed on 2 ranks, resumed on {others}")
        for file in sorted((folder / "members").glob("members*")):
            assert file.read_bytes() == (out / file.name).read_bytes(), file
        assert (out / "notes.txt").exists()
        every_file_is_listed(out)


def pieces():
    """Each rank writes its blocks of a frame; together they are those of one process."""
    in_pieces = ["--set", "output.pieces=true"]
    for name, ranks in (("wall", 3), ("building", 2), ("collapse", 3), ("promotion", 2)):
        run(1, [*scene_of(name), "--out", folder / name])
        out = folder / f"{name}_{ranks}"
        run(ranks, [*scene_of(name), *in_pieces, "--out", out])
        same_frames(folder / name, out, f"{name}, {ranks} ranks")
        assert (folder / name / "history.csv").read_bytes() == (out / "history.csv").read_bytes(), name
        files = sorted(file.name for file in out.glob("blocks_0001*"))
        assert files == ["blocks_0001.pvtu"] + [f"blocks_0001_r{r}.vtu" for r in range(ranks)], files
        gridpoints = [len(arrays_of(out / f"blocks_0001_r{r}.vtu")["Points"]["position"]) for r in range(ranks)]
        assert sum(n > 0 for n in gridpoints) > 1, gridpoints
        every_file_is_listed(out)
        print(f"{name}: {ranks} ranks: {gridpoints} gridpoints of blocks, the same frames")
    # Frames gather nothing, neither in pieces nor in one file, which is equal to that of one process. Costs are prescribed,
    # so that the load of the machine does not cause load balancing.
    even = {"env": os.environ | {"QUOIN_DEAR_BLOCKS": "1x1"}}
    run(3, [*scene_of("wall"), "--out", folder / "whole"], **even)
    run(3, [*scene_of("wall"), *in_pieces, "--out", folder / "parted"], **even)
    run(3, [*scene_of("wall"), "--set", "output.frames=0", "--out", folder / "none"], **even)
    gathers = [json.loads((folder / place / "summary.json").read_text())["ranks"]["gathers"]
               for place in ("whole", "parted", "none")]
    assert len(set(gathers)) == 1, gathers
    run(3, [*scene_of("collapse"), "--out", folder / "whole_collapse"])
    for name, whole in (("wall", "whole"), ("collapse", "whole_collapse")):
        files = sorted(file.name for file in (folder / name).glob("*.vtu"))
        assert len(files) >= 4, files
        for file in files:
            assert (folder / name / file).read_bytes() == (folder / whole / file).read_bytes(), file
    # A run on fewer ranks in the same folder removes the pieces of the first run, but no other files.
    (folder / "wall_3" / "notes.txt").write_text("mine")
    run(2, [*scene_of("wall"), *in_pieces, "--out", folder / "wall_3"])
    assert not list((folder / "wall_3").glob("*_r2.vtu")) and (folder / "wall_3" / "notes.txt").exists()
    same_frames(folder / "wall", folder / "wall_3", "wall, 2 ranks where 3 were")
    # One process: a message that pieces have no effect, and one file for each frame.
    done = run(1, [*scene_of("wall"), *in_pieces, "--out", folder / "wall_3"])
    assert "output.pieces: without effect" in done.stdout + done.stderr, done.stderr
    assert not list((folder / "wall_3").glob("*_r*.vtu")) and not list((folder / "wall_3").glob("*.pvtu"))
    same_frames(folder / "wall", folder / "wall_3", "wall, one process, pieces asked for")
    # A rank is killed between frames: the run resumes on fewer ranks, without old pieces.
    frames = [*long_scene, "--set", "output.frames=12", "--set", "output.frames_at_damage=0.02"]
    run(1, [*frames, "--out", folder / "long"])
    out = folder / "long_3"
    process = start(3, [*frames, *in_pieces, "--out", out, "--checkpoint-every", "0.1"])
    for _ in range(1200):
        if (out / "checkpoint.bin").exists() and (out / "blocks_0001.pvtu").exists():
            break
        assert process.poll() is None, process.communicate()[0]
        time.sleep(0.05)
    os.kill(ranks_of(process)[1], signal.SIGKILL)
    process.communicate(timeout=60)
    run(2, ["--resume", out])
    same_frames(folder / "long", out, "killed on 3 ranks, resumed on 2")
    by_count = [len(pieces) for pieces in frames_of(out, "blocks")]
    assert by_count == sorted(by_count, reverse=True) and by_count[-1] == 2, by_count
    named = {file.name for pieces in frames_of(out, "blocks") + frames_of(out, "joints") for file in pieces}
    assert {file.name for file in out.glob("*_r*.vtu")} == named, (named, list(out.iterdir()))
    print(f"killed on 3 ranks, resumed on 2: {by_count.count(3)} frames of 3 pieces, {by_count.count(2)} of 2")
    pieces_of_dead_ranks()
    done = run(2, [*scene_of("wall"), *in_pieces, "--report", "--out", folder / "refused"], code=2)
    assert done.stderr.count("--report: not with output.pieces") == 1, done.stderr


if case in scenes:
    same_bits(case)
else:
    {"balanced": balanced, "killed": killed, "large": large, "stopped": stopped, "memory": memory, "pieces": pieces, "parts": parts, "refused": refused, "started": started,
     "vanished": vanished}[case]()
