#!/usr/bin/env python3
"""Random mutants of the host and of the laws' shims: does the suite notice when one token is wrong?

    tests/mutation/mutants.py --count 200 --seed 1 --out mutants_1.csv      two to four hours on two cores
    tests/mutation/mutants.py --count 20 --seed 7 --only host/step          a part of the tree
    tests/mutation/mutants.py --list --count 10                             what would be planted

One mutant is one changed token: a sign, an operator, a floating constant times 1.1, an integer by one, a branch negated.
Places are drawn evenly from the code (no comments, texts or preprocessor lines), so the same seed gives the same mutants of
the same tree. Each is built in a copy of the tree and run against the tests of ctest, quickest first, until one fails, crashes
or takes five times its time. A mutant that does not compile, or compiles to the same bytes, is replaced by the next one.
Results go to --out row by row; a run that was stopped goes on from there. Exit code 0: at least --goal killed, 1: fewer, 2: wrong use,
3: the unchanged tree does not build or pass.
"""
import argparse
import concurrent.futures
import csv
import hashlib
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCOPE = ("host/", "contact_models/shim/")
# Tests that build the project anew or look at files of the source tree see no mutant of this build, at a high price.
LEFT_OUT = re.compile(r"consumer|mutant|abi|windows|instruction_sets|clang|demo|rebuilt|install")

SWAPS = {
    " + ": " - ", " - ": " + ", " += ": " -= ", " -= ": " += ", " * ": " / ", " / ": " * ",
    " && ": " || ", " || ": " && ", " < ": " <= ", " <= ": " < ", " > ": " >= ", " >= ": " > ",
    " == ": " != ", " != ": " == ", "std::min(": "std::max(", "std::max(": "std::min(",
}
KINDS = {" + ": "sign", " - ": "sign", " += ": "sign", " -= ": "sign"}
SWAP = re.compile("|".join(re.escape(text) for text in sorted(SWAPS, key=len, reverse=True)))
FLOATING = re.compile(r"(?<![\w.])(\d+\.\d*(?:e[-+]?\d+)?|\d+e[-+]?\d+)(?![\w.])")
INTEGER = re.compile(r"(?<![\w.'])(\d+)(?![\w.'])")
BRANCH = re.compile(r"\bif \(")


def code_only(text):
    """The text with comments, string and character literals and preprocessor lines blanked, places kept."""
    def blank(match):
        return re.sub(r"[^\n]", "\0", match.group(0))
    text = re.sub(r'R"\((?:.|\n)*?\)"|//[^\n]*|/\*(?:.|\n)*?\*/|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])*\'', blank, text)
    text = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", blank, text, flags=re.M)
    return re.sub(r"static_assert\((?:.|\n)*?\);", blank, text)


def closing(code, start):
    depth = 0
    for i in range(start, len(code)):
        depth += {"(": 1, ")": -1}.get(code[i], 0)
        if depth == 0:
            return i
    return None


def sites(file, text):
    """All changes of one token: (file, from, to, replacement, kind)."""
    code = code_only(text)
    for m in SWAP.finditer(code):
        yield file, m.start(), m.end(), SWAPS[m.group(0)], KINDS.get(m.group(0), "operator")
    for m in FLOATING.finditer(code):
        if float(m.group(1)) != 0.0:
            yield file, m.start(), m.end(), repr(float(m.group(1)) * 1.1), "constant"
    for m in INTEGER.finditer(code):
        yield file, m.start(), m.end(), str(int(m.group(1)) + 1), "off by one"
    for m in BRANCH.finditer(code):
        end = closing(code, m.end() - 1)
        if end:
            yield file, m.end(), end, f"!({text[m.end():end]})", "branch"


def draw(only, seed):
    listed = subprocess.run(["git", "ls-files", "-z", *SCOPE], cwd=ROOT, check=True, capture_output=True).stdout
    files = [f for f in listed.decode().split("\0") if f.endswith((".cpp", ".h")) and f.startswith(only)]
    found = [site for f in sorted(files) for site in sites(f, (ROOT / f).read_text())]
    random.Random(seed).shuffle(found)
    return found


def copy_tree(tree):
    """The tracked files, changed ones included. Host libraries become shared: a mutant then links one of them."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True).stdout
    for name in filter(None, listed.decode().split("\0")):
        text = (ROOT / name).read_bytes()
        if name.startswith("host/") and name.endswith("CMakeLists.txt"):
            text = text.replace(b" STATIC", b" SHARED")
        to = tree / name
        if not to.exists() or to.read_bytes() != text:
            to.parent.mkdir(parents=True, exist_ok=True)
            to.write_bytes(text)
            shutil.copymode(ROOT / name, to)


def build(tree, timeout=3600):
    return subprocess.run(["cmake", "--build", "build/release"], cwd=tree, capture_output=True, text=True,
                          timeout=timeout)


def object_hash(tree):
    """Of the shared libraries and programs of the host, which any mutant in effect changes."""
    digest = hashlib.sha256()
    for file in sorted([*tree.glob("build/release/host/**/*.o"), *tree.glob("build/release/contact_models/**/*.o")]):
        digest.update(file.read_bytes())
    return digest.hexdigest()


class Test:
    def __init__(self, entry):
        self.name, self.command = entry["name"], entry["command"]
        properties = {p["name"]: p["value"] for p in entry.get("properties", [])}
        self.folder = properties.get("WORKING_DIRECTORY")
        self.environment = dict(v.split("=", 1) for v in properties.get("ENVIRONMENT", []))
        self.seconds = 0.0

    def run(self, timeout):
        start = time.monotonic()
        process = subprocess.Popen(self.command, cwd=self.folder, env={**os.environ, **self.environment},
                                   stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                   start_new_session=True)
        try:
            passed = process.wait(timeout) == 0
        except subprocess.TimeoutExpired:
            passed = False
        finally:
            try:
                os.killpg(process.pid, signal.SIGKILL)  # what the test has started ends with it
            except ProcessLookupError:
                pass
            process.wait()
        self.took = time.monotonic() - start
        return passed


def first_failure(tests, jobs):
    """Name of a test that fails, or None. Quickest first, `jobs` at a time."""
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        rest, running = iter(tests), {}
        failed = None
        while True:
            while failed is None and len(running) < jobs:
                test = next(rest, None)
                if test is None:
                    break
                running[pool.submit(test.run, 5 * test.seconds + 10)] = test
            if not running:
                return failed
            done, _ = concurrent.futures.wait(running, return_when=concurrent.futures.FIRST_COMPLETED)
            for future in done:
                test = running.pop(future)
                if not future.result() and failed is None:
                    failed = test.name


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=200, help="mutants that compile and change something")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="files whose path begins so")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--goal", type=float, default=0.9, help="share that must be killed")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build" / "mutation", help="folder of the copy")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("mutants.csv"))
    parser.add_argument("--list", action="store_true", help="print the mutants and stop")
    options = parser.parse_args()

    candidates = draw(options.only, options.seed)
    if not candidates:
        print(f"no code below '{options.only}' in {', '.join(SCOPE)}", file=sys.stderr)
        return 2
    def describe(site):
        file, begin, end, replacement, kind = site
        text = (ROOT / file).read_text()
        return text.count("\n", 0, begin) + 1, text[begin:end].strip(), replacement.strip()
    if options.list:
        for site in candidates[:options.count]:
            line, old, new = describe(site)
            print(f"{site[0]}:{line}: {site[4]}: {old} -> {new}")
        return 0

    tree = options.work / "tree"
    copy_tree(tree)
    print(f"{len(candidates)} places in the code; building the unchanged tree in {tree}", flush=True)
    configured = subprocess.run(["cmake", "--preset", "release"], cwd=tree, capture_output=True, text=True)
    built = build(tree) if configured.returncode == 0 else configured
    if built.returncode != 0:
        print((built.stdout + built.stderr)[-4000:], file=sys.stderr)
        return 3
    listed = subprocess.run(["ctest", "--preset", "release", "--show-only=json-v1"], cwd=tree, check=True,
                            capture_output=True, text=True).stdout
    tests = [Test(t) for t in json.loads(listed)["tests"] if "command" in t and not LEFT_OUT.search(t["name"])]
    tests = [t for t in tests if not any("NOT_BUILT" in part for part in t.command)]
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        passed = list(pool.map(lambda t: t.run(600), tests))
    for test, ok in zip(tests, passed):
        test.seconds = test.took
        if not ok:
            print(f"fails without a mutant, left out: {test.name}", flush=True)
    tests = sorted((t for t, ok in zip(tests, passed) if ok), key=lambda t: t.seconds)
    print(f"{len(tests)} tests, {sum(t.seconds for t in tests):.0f} s", flush=True)
    if not tests:
        return 3
    unchanged = object_hash(tree)

    known = {}
    if options.out.exists():
        with options.out.open() as file:
            known = {(r["file"], r["line"], r["old"], r["new"], r["place"]): r["result"] for r in csv.DictReader(file)}
    new_file = not known
    killed = survived = 0
    with options.out.open("a", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        if new_file:
            rows.writerow(["file", "line", "place", "kind", "old", "new", "result", "by", "seconds"])
        for site in candidates:
            if killed + survived >= options.count:
                break
            name, begin, end, replacement, kind = site
            line, old, new = describe(site)
            result = known.get((name, str(line), old, new, str(begin)))
            if result is None:
                start = time.monotonic()
                source = tree / name
                text = source.read_text()
                source.write_text(text[:begin] + replacement + text[end:])
                by = ""
                try:
                    if build(tree).returncode != 0:
                        result = "does not compile"
                    elif object_hash(tree) == unchanged:
                        result = "same code"
                    else:
                        by = first_failure(tests, options.jobs) or ""
                        result = "killed" if by else "survived"
                finally:
                    source.write_text(text)
                rows.writerow([name, line, begin, kind, old, new, result, by, f"{time.monotonic() - start:.0f}"])
                file.flush()
            killed += result == "killed"
            survived += result == "survived"
            if result in ("killed", "survived"):
                print(f"{killed + survived:4} {result:8} {name}:{line}: {kind}: {old} -> {new}", flush=True)
    build(tree)
    score = killed / max(1, killed + survived)
    print(f"{killed} of {killed + survived} killed: {100 * score:.1f} %")
    return 0 if score >= options.goal else 1


if __name__ == "__main__":
    sys.exit(main())
