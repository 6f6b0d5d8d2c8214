#!/usr/bin/env python3
"""Faults planted into runs: each allocation fails once, each write, rename and fsync fails once (no space, broken disk,
interrupted, half written), and signals arrive at each of them. For each fault the program ends in time, with a documented
exit code and a message. Files with final names are complete, and a run with exit code 0 has the results of the undisturbed
one.

  tests/stress/planted_faults.py build/release/quoin build/release/tests/stress/planted_fault.so
  tests/stress/planted_faults.py ... --share 0.02          a sample of the faults, of each kind some: seconds
"""

import argparse
import collections
import json
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = [ROOT / "tests/cli/small_wall.toml"]
SETTINGS = ["wall.courses=2", "wall.units_per_course=2", "wall.zones=[1,1,1]", "stage.2.displacement=1e-6", "output.frames=1",
            "output.plots=false", "stage.1.record_interval=50", "stage.1.equilibrium_ratio=0.05"]
CALLS = ("malloc", "write", "rename", "fsync")
ERRORS = {"no space": 28, "broken disk": 5, "interrupted": 4, "half": 0}
SIGNALS = {"SIGTERM": -15, "SIGHUP": -1, "SIGPIPE": -13, "SIGKILL": -9}


def run(program, shim, out, fault="", counts=None, more=(), timeout=60):
    command = [program, "run", *SCENE, "--out", out, "--threads", "1", "--checkpoint-every", "0.0001", *more]
    for setting in SETTINGS:
        command += ["--set", setting]
    environment = dict(os.environ, LD_PRELOAD=str(shim), QUOIN_FAULT=fault)
    if counts:
        environment["QUOIN_FAULT_COUNTS"] = str(counts)
    return subprocess.run([str(word) for word in command], env=environment, capture_output=True, timeout=timeout)


def not_whole(folder):
    """Yields files with final names that are not complete."""
    for path in folder.rglob("*"):
        if not path.is_file() or path.name.startswith(".") or path.suffix == ".part":
            continue
        text = path.read_bytes()
        try:
            if path.suffix == ".json":
                json.loads(text)
            elif path.suffix == ".csv":
                lines = text.decode().split("\n")
                assert lines[-1] == "" and len({line.count(",") for line in lines[:-1]}) == 1
            elif path.suffix in (".vtu", ".pvd"):
                assert text.rstrip().endswith(b"</VTKFile>")
            else:
                assert text
        except (AssertionError, ValueError):
            yield f"{path.name} ({len(text)} bytes) is not whole"


def faults_of(done, out, expected, interrupted):
    """Yields faults of the end of a run."""
    code, said = done.returncode, done.stderr.decode(errors="replace") + done.stdout.decode(errors="replace")
    if code not in (0, 3, 4, 5, 130) and not (interrupted and code in (-9, -1, -13, -15)):
        yield f"exit code {code}: {said[-300:]}"
    if code in (3, 4, 5) and "quoin: " not in said:
        yield f"exit code {code} without a message"
    if "internal error" in said:
        yield f"an internal error: {said[-300:]}"
    yield from not_whole(out)
    if code == 0 and (out / "history.csv").read_bytes() != expected:
        yield "says that it is done, with another history"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("shim")
    parser.add_argument("--share", type=float, default=1.0, help="of all faults (default: all)")
    parser.add_argument("--only", nargs="+", choices=[*CALLS, "signal"], default=[*CALLS, "signal"])
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    chance = random.Random(options.seed)
    bad = []
    with tempfile.TemporaryDirectory() as temporary:
        out, counts = pathlib.Path(temporary) / "out", pathlib.Path(temporary) / "counts"
        whole = run(options.program, options.shim, out, counts=counts)
        if whole.returncode != 0:
            sys.exit(f"the run itself fails: {whole.stderr.decode()[-400:]}")
        expected = (out / "history.csv").read_bytes()
        number = dict(zip(CALLS, map(int, counts.read_text().split())))
        planted = []
        for call in CALLS:
            kinds = {"no memory": 12} if call == "malloc" else ERRORS if call == "write" else \
                {name: ERRORS[name] for name in ("no space", "broken disk")}
            planted += [(call, i, name, how) for i in range(1, number[call] + 1) for name, how in kinds.items()]
        for call in ("write", "rename", "fsync"):
            planted += [("signal", i, f"{name} at {call}", (call, how)) for i in range(1, number[call] + 1)
                        for name, how in SIGNALS.items()]
        planted = [p for p in planted if p[0] in options.only]
        by_kind = collections.defaultdict(list)
        for p in planted:
            by_kind[p[0]].append(p)
        tallies = {}
        for kind, cases in by_kind.items():
            if options.share < 1.0:
                cases = chance.sample(cases, max(min(len(cases), 8), round(options.share * len(cases))))
            tally = collections.Counter()
            for _, i, name, how in cases:
                call, errno = how if kind == "signal" else (kind, how)
                shutil.rmtree(out, ignore_errors=True)
                try:
                    done = run(options.program, options.shim, out, f"{call} {i} {errno}")
                except subprocess.TimeoutExpired:
                    bad.append(f"{kind} {i}, {name}: does not end")
                    continue
                tally[done.returncode] += 1
                bad += [f"{call} {i}, {name}: {fault}" for fault in faults_of(done, out, expected, kind == "signal")]
            tallies[kind] = tally
            print(f"{kind}: {sum(tally.values())} faults of {len(by_kind[kind])}, ended with "
                  + ", ".join(f"{code}: {n}" for code, n in sorted(tally.items())), flush=True)
    for fault in bad[:20]:
        print(fault)
    print(f"{len(bad)} ended badly" if bad else "all ended well")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
