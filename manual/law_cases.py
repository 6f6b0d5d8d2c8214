"""The page LAW_CASES.md: each path of tests/law/paths with its law, its checks and its largest error, and the curves of some of
them beside their closed forms, as `quoin path` computes and draws them.

usage: manual/law_cases.py [QUOIN]    writes manual/LAW_CASES.md and manual/law_cases; QUOIN: build/release/quoin, with all laws
       manual/law_cases.py --check    exit code 1 if a path is missing on the page, or has another title, law or picture there
"""
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PAGE, PICTURES = f"{ROOT}/manual/LAW_CASES.md", f"{ROOT}/manual/law_cases"
# One a branch of each law.
DRAWN = ["tension_linear", "couplet", "cyclic_tension_growing", "shear_linear_high_pressure", "shear_exponential", "triplet_0_6MPa",
         "cyclic_shear_reversal_linear", "crushing_linear", "prism", "dilation_fixed_normal", "coulomb_shear",
         "cyclic_joint_residual_opening", "cyclic_joint_crushing", "cyclic_joint_seat"]


def cases():
    """By name of the file: what it says."""
    found = {}
    for path in sorted(glob.glob(f"{ROOT}/tests/law/paths/*.toml")):
        with open(path, "rb") as file:
            found[os.path.basename(path)[:-len(".toml")]] = tomllib.load(file)
    return found


def cell(text):
    return text.replace("|", "\\|")


def begin_of_row(name, case):
    return f"| [{cell(case['title'])}](../tests/law/paths/{name}.toml) | `{case['law']}` |"


def number(value):
    return f"{value:g}" if isinstance(value, float) else str(value)


def curve(name, case):
    """Input, closed form in words, and the picture of a case."""
    properties = ", ".join(f"{key} = {number(value)}" for key, value in case.get("properties", {}).items())
    lines = ["", f"### {case['title']}", "", f"`{properties}`, SI units and degrees; [{name}.toml](../tests/law/paths/{name}.toml)", ""]
    if case.get("about"):
        lines += ["```text", case["about"].strip(), "```", ""]
    return lines + [f"![{case['title']}](law_cases/{name}.png)"]


def write(quoin):
    with tempfile.TemporaryDirectory() as plots:
        done = subprocess.run([quoin, "path", *sorted(glob.glob("tests/law/paths/*.toml", root_dir=ROOT)), "--plot", plots], cwd=ROOT,
                              capture_output=True, text=True, check=True)
        numbers = {m[1]: m.groups()[1:] for m in (re.match(
            r"pass  .*/(\w+)\.toml: .* \((\d+) checks, (\d+) steps, largest error (\S+) of its tolerance\)$", line)
            for line in done.stdout.splitlines()) if m}
        shutil.rmtree(PICTURES, ignore_errors=True)
        os.makedirs(PICTURES)
        for name in DRAWN:
            shutil.copy(f"{plots}/{name}.png", PICTURES)
    known = cases()
    lines = ["# Laws, case by case", "",
             f"{len(known)} paths of one contact point, each held against a closed form: `build/release/quoin path FILE --verbose`.",
             "An error is the largest of all checks, over the tolerance of its check. Each file has the tolerance and its reason.",
             "`python3 manual/law_cases.py` makes this page. How paths are written: `host/law/path_file.h`.", "",
             "| case | law | checks | steps | error over tolerance |", "|---|---|---|---|---|"]
    for name, case in known.items():
        lines.append(f"{begin_of_row(name, case)} {' | '.join(numbers[name])} |")
    lines += ["", "## Curves", "", "Lines with dots are the law, step by step. Circles are the closed form where it is checked."]
    for name in DRAWN:
        lines += curve(name, known[name])
    with open(PAGE, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


def check():
    with open(PAGE, encoding="utf-8") as file:
        page = file.read()
    known = cases()
    faults = [f"{PAGE}: no row begins with {begin_of_row(n, c)}" for n, c in known.items() if begin_of_row(n, c) not in page]
    faults += [f"{PAGE}: {n} is no path of tests/law/paths" for n in re.findall(r"^\| \[.*\]\(\.\./tests/law/paths/(\w+)\.toml\)", page, re.M) if n not in known]
    for name in DRAWN:
        faults += [f"{PAGE}: another input or title of {name}"] if "\n".join(curve(name, known[name])) not in page else []
        faults += [] if os.path.exists(f"{PICTURES}/{name}.png") else [f"{PICTURES}/{name}.png is missing"]
    print("\n".join(faults) or f"{len(known)} paths, {len(DRAWN)} of them drawn")
    return 1 if faults else 0


if __name__ == "__main__":
    if "--check" in sys.argv:
        sys.exit(check())
    write(os.path.abspath(sys.argv[1]) if len(sys.argv) > 1 else f"{ROOT}/build/release/quoin")
