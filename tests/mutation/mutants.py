#!/usr/bin/env python3
"""Random mutants of the host and of the laws' shims: do the tests fail if one token is wrong?

    tests/mutation/mutants.py --seed 1 2 --out mutants.csv         200 of each seed in one build; an hour or two on two cores
    tests/mutation/mutants.py --count 20 --seed 7 --only host/step          a part of the tree
    tests/mutation/mutants.py --list --count 10                             prints the mutants only

One mutant is one changed token: a sign, an operator, a floating constant times 1.1, an integer by one, a branch negated.
Places are drawn evenly from the code (no comments, texts or preprocessor lines), so the same seed gives the same mutants of
the same tree. All are built at once in a copy of the tree (schemata.py), without adapters and benchmarks; every
test of ctest is run once to check that it passes and which mutants it reaches; then each mutant is planted in turn and run
against the tests that reach it, quickest first and those that have killed before, until one fails, crashes or takes five times
its time on the processor, or --budget is spent (column "how": "budget"). What cannot be switched
at run time (sizes of types, constants of the compiler) is built alone with --alone, otherwise replaced by the next one, as is
what does not compile or, alone, compiles to the same bytes.
Results are written to --out row by row; a run that was stopped continues from there, and --again runs the survivors again. A
mutant killed by a time-out only (column "how") is also run again with --again, since other programs may cause a time-out.
Exit code 0: at least --goal killed, 1: fewer, 2: wrong use, 3: the unchanged tree does not build or pass.
"""
import argparse
import collections
import concurrent.futures
import csv
import hashlib
import json
import math
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import threading
import time

from schemata import CAPACITY, HEADER, Mutant, blame, code_only, matching, with_schemata

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCOPE = ("host/", "contact_models/shim/")
# Tests that build the project or read files of the source tree do not test the mutants of this build, and are slow.
LEFT_OUT = re.compile(r"consumer|mutant|abi|windows|instruction_sets|clang|demo|rebuilt|install|docs\.|headers")
TARGETS_LEFT_OUT = "(~(HWY_AVX2|HWY_EMU128|HWY_SCALAR))"  # EMU128, SCALAR: the baseline of x86-64

SWAPS = {
    " + ": " - ", " - ": " + ", " += ": " -= ", " -= ": " += ", " * ": " / ", " / ": " * ",
    " && ": " || ", " || ": " && ",
    # For integers the boundary changes. For floating-point numbers, which are rarely equal, the relation is reversed
    # (schemata.py).
    " < ": " < ::quoin_mutant::less > ", " <= ": " < ::quoin_mutant::less_equal > ",
    " > ": " < ::quoin_mutant::greater > ", " >= ": " < ::quoin_mutant::greater_equal > ",
    " == ": " != ", " != ": " == ", "std::min(": "std::max(", "std::max(": "std::min(",
}
KINDS = {" + ": "sign", " - ": "sign", " += ": "sign", " -= ": "sign"}
SWAP = re.compile("|".join(re.escape(text) for text in sorted(SWAPS, key=len, reverse=True)))
FLOATING = re.compile(r"(?<![\w.])(\d+\.\d*(?:e[-+]?\d+)?|\d+e[-+]?\d+)(?![\w.])")
INTEGER = re.compile(r"(?<![\w.'])(?<!\de[-+])(\d+)(?![\w.'>])")  # not the size of a type
BRANCH = re.compile(r"\bif \(")
# Excluded, since results of a run do not depend on these numbers:
ROUNDING, ENDLESS = 1e-8, 1e30  # tolerances of rounding; numbers that stand for infinity
IDLE = re.compile(r"reserve\(|sleep_for\(|wait_for\(|sleep_until\(|wait_until\(")  # capacity of memory, and waiting of threads


def written_before_read(code, m):
    """True for the 0 or -1 of a member's initializer, which is only a defined value until the member is set."""
    begins = re.search(r"\w(?: = |\{)(-?)\Z", code[max(0, m.start() - 8):m.start()])
    if not begins or begins.group(1) + m.group(1) not in ("0", "-1") or not re.match(r"[;,}]", code[m.end():]):
        return False
    depth, i = 0, m.start() - len(begins.group(0)) + 1
    while i > 0 and depth >= 0:
        i -= 1
        depth += (code[i] == "}") - (code[i] == "{")
    return re.search(r"\b(?:struct|class)\b[^;{}]*\Z", code[:i]) is not None


def sites(file, code):
    """Returns all changes of one token: (file, from, to, replacement, kind)."""
    def drawn(m):
        return not IDLE.search(code, code.rfind("\n", 0, m.start()) + 1, code.find("\n", m.end()))
    for m in filter(drawn, SWAP.finditer(code)):
        yield file, m.start(), m.end(), SWAPS[m.group(0)], KINDS.get(m.group(0), "operator")
    for m in filter(drawn, FLOATING.finditer(code)):
        if ROUNDING <= abs(float(m.group(1))) <= ENDLESS:
            yield file, m.start(), m.end(), repr(float(m.group(1)) * 1.1), "constant"
    for m in filter(drawn, INTEGER.finditer(code)):
        if not written_before_read(code, m):
            yield file, m.start(), m.end(), str(int(m.group(1)) + 1), "off by one"
    for m in BRANCH.finditer(code):
        end = matching(code, m.end() - 1, +1)
        yield file, m.end(), end, f"!({code[m.end():end]})", "branch"


class Tree:
    """A copy of the tracked files, including changed ones, with mutants."""

    def __init__(self, root, folder, targets=()):
        self.root, self.folder, self.targets = root, folder, targets
        listed = subprocess.run(["git", "ls-files", "-z"], cwd=root, check=True, capture_output=True).stdout
        self.files = [f for f in filter(None, listed.decode().split("\0")) if (root / f).exists()]
        self.texts = {f: (root / f).read_text() for f in self.files if f.startswith(SCOPE) and f.endswith((".cpp", ".h"))}
        self.codes = {f: code_only(text) for f, text in self.texts.items()}

    def draw(self, only, seed):
        found = [site for f in sorted(self.texts) if f.startswith(only) for site in sites(f, self.codes[f])]
        random.Random(seed).shuffle(found)
        return found

    def mutant(self, number, site):
        file, begin, end, replacement, kind = site
        text = self.texts[file]
        if kind == "branch":
            replacement = f"!({text[begin:end]})"
        return Mutant(number, (file, begin, end, replacement, kind), text, self.codes[file])

    def write(self, name, text):
        to = self.folder / name
        if isinstance(text, str):
            text = text.encode()
        if not to.exists() or to.read_bytes() != text:
            to.parent.mkdir(parents=True, exist_ok=True)
            to.write_bytes(text)

    def copy(self, mutants):
        """Changes the build to be faster: host with -O1, its cold parts and tests with -O0, one instruction set beside the
        baseline. Host libraries are shared, so that a mutant built alone links only one of them. They use their own copies of
        inline functions, not those of tests."""
        for name in self.files:
            if name in self.texts:
                mine = [m for m in mutants if m.file == name]
                text = with_schemata(self.texts[name], mine) if mine else self.texts[name]
            else:
                text = (self.root / name).read_bytes()
                if name.startswith("host/") and name.endswith("CMakeLists.txt"):
                    text = text.replace(b" STATIC", b" SHARED")
                if name in ("host/CMakeLists.txt", "tests/CMakeLists.txt"):
                    text = text.replace(b"-O1>", b"-O0>")
                if name == "host/CMakeLists.txt":
                    options = f'add_compile_definitions("HWY_DISABLED_TARGETS={TARGETS_LEFT_OUT}")\n'
                    text = (options + "add_link_options(-Wl,-Bsymbolic)\n").encode() + text
                if name == "CMakeLists.txt":
                    for part, option in ((b"host", b"-O1 -D_GLIBCXX_ASSERTIONS"), (b"tests", b"-O0 -D_GLIBCXX_ASSERTIONS")):
                        adds = b"  add_subdirectory(" + part + b")"
                        # Shared libraries do not pass on their dependencies, as static ones do.
                        options = b"  add_compile_options(" + option + b")\n  add_link_options(-Wl,--copy-dt-needed-entries)\n"
                        text = text.replace(adds, options + adds)
            self.write(name, text)
            shutil.copymode(self.root / name, self.folder / name)
        for part in SCOPE:
            self.write(part + "quoin_mutant.h", HEADER)

    def configure(self):
        flags = "-Wall -Wextra -Wpedantic"  # as in the preset, so that ccache has files without mutants
        return subprocess.run(["cmake", "--preset", "release", "-DQUOIN_BUILD_ADAPTERS=OFF", "-DQUOIN_BUILD_BENCHMARKS=OFF",
                               f"-DQUOIN_DISABLED_TARGETS={TARGETS_LEFT_OUT}",
                               f"-DCMAKE_CXX_FLAGS={flags} -Wshadow -Wconversion -Wno-sign-conversion -Werror -w",
                               f"-DCMAKE_C_FLAGS={flags} -Werror -w"],
                              cwd=self.folder, capture_output=True, text=True)

    def build(self, jobs):
        targets = ["--target", *self.targets] if self.targets else []
        return subprocess.run(["cmake", "--build", "build/release", "-j", str(jobs), *targets, "--", "-k", "0"],
                              cwd=self.folder, capture_output=True, text=True, env={**os.environ, "CCACHE_IGNOREOPTIONS": "-w", "LC_ALL": "C"})

    def build_all(self, mutants, jobs):
        """Builds all mutants that can be switched. Returns the message of the compiler if the build fails."""
        self.recall(mutants)
        while True:
            self.copy(mutants)
            done = self.configure()
            if done.returncode == 0:
                done = self.build(jobs)
            if done.returncode == 0:
                return None
            (self.folder.parent / "build.log").write_text(done.stdout + done.stderr)
            taken = blame(done.stdout + done.stderr, mutants)
            if not taken:
                return (done.stdout + done.stderr)[-4000:]
            for m in taken:
                print(f"not by a switch: {m.file}:{m.line}: {m.old} -> {m.new}: {m.form}", flush=True)
            self.remember(mutants)

    # File with the compiler's messages about mutants, for the next run with the same text.
    def memory(self):
        return self.folder.parent / "not_switched.json"

    def key(self, m):
        return f"{m.file} {m.begin} {m.new} {hashlib.sha256(self.texts[m.file].encode()).hexdigest()[:16]}"

    def remember(self, mutants):
        known = json.loads(self.memory().read_text()) if self.memory().exists() else {}
        known.update({self.key(m): m.form for m in mutants if m.form != "schemata"})
        self.memory().write_text(json.dumps(known, indent=1))

    def recall(self, mutants):
        known = json.loads(self.memory().read_text()) if self.memory().exists() else {}
        for m in mutants:
            m.form = known.get(self.key(m), m.form)

    def object_hash(self):
        digest = hashlib.sha256()
        for part in ("host", "contact_models"):
            for file in sorted((self.folder / "build/release" / part).glob("**/*.o")):
                digest.update(file.read_bytes())
        return digest.hexdigest()

    def tests(self):
        listed = subprocess.run(["ctest", "--preset", "release", "--show-only=json-v1"], cwd=self.folder, check=True,
                                capture_output=True, text=True).stdout
        found = [Test(t) for t in json.loads(listed)["tests"] if "command" in t and not LEFT_OUT.search(t["name"])]
        return [t for t in found if not t.disabled and not any("NOT_BUILT" in part for part in t.command)]


class Test:
    def __init__(self, entry):
        self.name, self.command = entry["name"], entry["command"]
        properties = {p["name"]: p["value"] for p in entry.get("properties", [])}
        self.folder = properties.get("WORKING_DIRECTORY")
        self.disabled = properties.get("DISABLED", False)
        self.environment = dict(v.split("=", 1) for v in properties.get("ENVIRONMENT", []))
        self.runs, self.kills = 0, 0  # numbers of runs with a mutant, and of kills
        self.soon = False             # --soon

    def price(self):
        """Returns the estimated seconds for a kill. One run in ten kills, and a test that reaches few mutants is more likely
        to kill each of them."""
        known = (self.seconds + 0.05) * (self.runs + 1) / (self.kills + 0.1) * math.sqrt(len(self.reached) + 1)
        return 0.0 if self.soon else known

    def run(self, allowed, **environment):
        """Runs the test. allowed: processor time of each process, s, so that a busy machine kills no mutant. Elapsed time is
        limited to eight times that, for processes that wait without end."""
        def limit():
            resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(allowed), math.ceil(allowed)))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        process = subprocess.Popen(self.command, cwd=self.folder, env={**os.environ, **self.environment, **environment},
                                   stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                   start_new_session=True, preexec_fn=limit)
        waiting = threading.Timer(8 * allowed, lambda: os.killpg(process.pid, signal.SIGKILL))
        waiting.start()
        _, status, used = os.wait4(process.pid, 0)
        timed_out = not waiting.is_alive() or used.ru_utime + used.ru_stime >= 0.99 * allowed
        waiting.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        try:
            os.killpg(process.pid, signal.SIGKILL)  # ends also processes of the test
        except ProcessLookupError:
            pass
        self.took = used.ru_utime + used.ru_stime
        if process.returncode == 0:
            return "passed"
        return "timed out" if timed_out else "failed" if process.returncode > 0 else "crashed"

    def watch(self, folder, longest, kept):
        """Runs the test without a mutant and stores its time and the mutants that it reaches. kept: earlier results."""
        if self.identity in kept:
            passed, self.seconds, reached = kept[self.identity]
            self.passed, self.reached = passed and self.seconds <= longest, set(reached)
            if passed or self.seconds > longest:
                return  # otherwise it had less time than now, or fails
        reached = folder / (hashlib.sha256(self.name.encode()).hexdigest() + ".reached")
        reached.write_bytes(bytes(CAPACITY))
        self.passed = self.run(longest, QUOIN_MUTANTS_REACHED=str(reached)) == "passed"
        self.seconds = self.took
        self.reached = {i for i, byte in enumerate(reached.read_bytes()) if byte}
        reached.unlink()


def watch_all(tests, tree, planted, longest, jobs):
    """Runs every test once, or uses the stored result if neither its program nor the code with mutants has changed."""
    code = hashlib.sha256(repr((sorted(tree.texts.items()), [(site, m.form) for site, m in planted.items()])).encode()).hexdigest()
    programs = {}
    for t in tests:
        program = t.command[0]
        if program not in programs:
            programs[program] = hashlib.sha256(pathlib.Path(program).read_bytes()).hexdigest()
        t.identity = f"{t.name} {programs[program]} {code}"
    memory = tree.folder.parent / "tests.json"
    kept = json.loads(memory.read_text()) if memory.exists() else {}
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        list(pool.map(lambda t: t.watch(tree.folder.parent, longest, kept), tests))
    memory.write_text(json.dumps({t.identity: (t.passed, t.seconds, sorted(t.reached)) for t in tests}))


def first_failure(tests, jobs, budget, **environment):
    """Runs tests, `jobs` at a time. Returns (name of a test that fails, how it ends), ("", "budget") when the time is used up,
    or None."""
    start = time.monotonic()
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        rest, running = iter(sorted(tests, key=Test.price)), {}
        failed = None
        while True:
            while failed is None and len(running) < jobs:
                test = next(rest, None)
                if test is None:
                    break
                if time.monotonic() - start > budget:
                    failed = "", "budget"
                    break
                running[pool.submit(test.run, 5 * test.seconds + 10, **environment)] = test
            if not running:
                return failed
            done, _ = concurrent.futures.wait(running, return_when=concurrent.futures.FIRST_COMPLETED)
            for future in done:
                test = running.pop(future)
                test.runs += 1
                if future.result() != "passed":
                    test.kills += 1
                    failed = test.name, future.result()


def judge(mutant, tree, tests, jobs, budget, alone):
    """Returns (result, name of the test that fails, how it ends, number of tests that reach the mutant)."""
    if mutant.form == "does not compile" or (mutant.form == "alone" and not alone):
        return mutant.form, "", "", 0
    if mutant.form == "schemata":
        mine = [t for t in tests if mutant.number in t.reached]
        by = first_failure(mine, jobs, budget, QUOIN_MUTANT=str(mutant.number)) or ("", "")
        return "killed" if by[0] else "survived", *by, len(mine)
    kept = (tree.folder / mutant.file).read_text()
    before = tree.object_hash()
    text = tree.texts[mutant.file]
    tree.write(mutant.file, text[:mutant.begin] + mutant.replacement + text[mutant.end:])
    try:
        if tree.build(jobs).returncode != 0:
            return "does not compile", "", "", 0
        if tree.object_hash() == before:
            return "same code", "", "", 0
        by = first_failure(tests, jobs, budget) or ("", "")
        return "killed" if by[0] else "survived", *by, len(tests)
    finally:
        tree.write(mutant.file, kept)
        tree.build(jobs)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=200, help="mutants of each seed that compile and change something")
    parser.add_argument("--first", type=int, help="of --count, which are built, judge so many of each seed for now")
    parser.add_argument("--seed", type=int, nargs="+", default=[1])
    parser.add_argument("--only", default="", help="files whose path begins so")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--goal", type=float, default=0.9, help="share that must be killed")
    parser.add_argument("--tree", type=pathlib.Path, default=ROOT, help="the tree to look at, this one or another")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build" / "mutation", help="folder of the copy")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("mutants.csv"))
    parser.add_argument("--part", default="", help="of the drawn ones, those in files that this regular expression begins")
    parser.add_argument("--targets", nargs="+", default=[], help="test programs to be built, instead of all")
    parser.add_argument("--longest", type=float, default=300, help="seconds; tests that take longer are left out")
    parser.add_argument("--learn", type=pathlib.Path, nargs="+", default=[], help="--out of other runs: tests that killed there first")
    parser.add_argument("--budget", type=float, default=3600, help="seconds of tests that a mutant may cost")
    parser.add_argument("--without", default="(?!)", help="tests to be left out, a regular expression")
    parser.add_argument("--soon", default="(?!)", help="tests that are run before all others, a regular expression: new ones")
    parser.add_argument("--again", action="store_true", help="survivors of --out are run once more")
    parser.add_argument("--alone", action="store_true", help="build what cannot be switched at run time, one by one")
    parser.add_argument("--list", action="store_true", help="print the mutants and stop")
    options = parser.parse_args()

    tree = Tree(options.tree.resolve(), options.work.resolve() / "tree", options.targets)
    spare = options.count + options.count // 6 + 5  # the last ones replace mutants that do not compile
    drawn = {seed: tree.draw(options.only, seed)[:options.count if options.list else spare] for seed in options.seed}
    planted = {}
    for site in [site for sites_drawn in drawn.values() for site in sites_drawn]:
        planted.setdefault(site[:3], tree.mutant(len(planted), site))
    if not planted:
        print(f"no code below '{options.only}' in {', '.join(SCOPE)}", file=sys.stderr)
        return 2
    if options.list:
        for m in planted.values():
            print(f"{m.number}: {m.file}:{m.line}: {m.kind}: {m.old} -> {m.new}")
        return 0
    if len(planted) > CAPACITY:
        print(f"{len(planted)} mutants are more than one build holds: {CAPACITY}", file=sys.stderr)
        return 2

    mutants = list(planted.values())
    print(f"building {len(mutants)} mutants in {tree.folder}", flush=True)
    failure = tree.build_all(mutants, options.jobs)
    if failure:
        print(failure, file=sys.stderr)
        return 3
    tests = [t for t in tree.tests() if not re.search(options.without, t.name)]
    watch_all(tests, tree, planted, options.longest, options.jobs)
    for test in tests:
        if not test.passed:
            print(f"fails without a mutant or takes more than {options.longest:g} s, left out: {test.name}", flush=True)
    tests = [t for t in tests if t.passed]
    print(f"{len(tests)} tests, {sum(t.seconds for t in tests):.0f} s", flush=True)
    if not tests:
        return 3

    killers = collections.Counter()
    for learnt in filter(pathlib.Path.exists, [*options.learn, options.out]):
        with learnt.open() as file:
            killers.update(r["by"] for r in csv.DictReader(file) if r["by"])
    for t in tests:
        t.runs = t.kills = killers[t.name]
        t.soon = re.search(options.soon, t.name) is not None

    def key(m):
        return m.file, str(m.line), m.kind, m.old, m.new, str(m.begin)
    def key_of(r):
        return tuple(r[column] for column in ("file", "line", "kind", "old", "new", "place"))
    known = {}
    if options.out.exists():
        with options.out.open() as file:
            last = {key_of(r): r for r in csv.DictReader(file)}
        known = {k: r["result"] for k, r in last.items()
                 if not (options.again and (r["result"] == "survived" or r["how"] == "timed out"))}
    new_file = not options.out.exists()
    reached_goal = True
    with options.out.open("a", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        if new_file:
            rows.writerow(["seed", "file", "line", "place", "kind", "old", "new", "result", "by", "how", "seconds", "form", "tests"])
        for seed, sites_drawn in drawn.items():
            count = {"killed": 0, "survived": 0}
            for m in [planted[site[:3]] for site in sites_drawn if re.match(options.part, site[0])]:
                if sum(count.values()) >= min(options.count, options.first or options.count):
                    break
                result = known.get(key(m))
                if result is None:
                    start = time.monotonic()
                    result, by, how, reaching = judge(m, tree, tests, options.jobs, options.budget, options.alone)
                    known[key(m)] = result
                    rows.writerow([seed, m.file, m.line, m.begin, m.kind, m.old, m.new, result, by, how,
                                   f"{time.monotonic() - start:.1f}", m.form, reaching])
                    file.flush()
                if result in count:
                    count[result] += 1
                    print(f"{sum(count.values()):4} {result:8} {m.file}:{m.line}: {m.kind}: {m.old} -> {m.new}", flush=True)
            total = sum(count.values())
            print(f"seed {seed}: {count['killed']} of {total} killed: {100 * count['killed'] / max(1, total):.1f} %", flush=True)
            reached_goal = reached_goal and total > 0 and count["killed"] >= options.goal * total
    return 0 if reached_goal else 1


if __name__ == "__main__":
    sys.exit(main())
