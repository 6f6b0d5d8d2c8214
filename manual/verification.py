"""The pages manual/verification: what each comparison of tests/verification expects and measures, with curves, from what the
tests write, and the text of tests/verification/cases.toml. VERIFICATION.md lists them.

usage: manual/verification.py [RECORDS]          writes them from RECORDS, build/release/tests/verification/verification_records;
                                                 a long test (--gtest_also_run_disabled_tests) that has not run stays as it is
       manual/verification.py --pages            the text alone, from the records on the pages
       manual/verification.py --check [RECORDS]  exit code 1 if pages or figures are not those of their numbers, or the numbers
                                                 not those of RECORDS
"""
import csv
import glob
import math
import os
import re
import shutil
import sys
import tempfile
import tomllib

import figure
from law_cases import ROOT, cell

TESTS, PAGES = f"{ROOT}/tests/verification", f"{ROOT}/manual/verification"
KEPT = f"{PAGES}/records.csv"  # the records that the pages show
COLUMNS = ["test", "case", "expected", "measured", "unit", "error", "allowed", "note"]
# Of what is allowed, by which an error may differ from that on the page: other processors and compilers round otherwise.
SAME_ERROR = 0.25
# Of the range of a figure, by which a point may, and the part of the points of a curve that must not.
SAME_POINT, SAME_POINTS = 0.03, 0.9


def sources():
    """By name of the test: its file, and whether it runs only when it is asked for."""
    found = {}
    for path in sorted(glob.glob(f"{TESTS}/*_test.cpp")):
        with open(path, encoding="utf-8") as file:
            for suite, long, name in re.findall(r"^TEST\((\w+), (DISABLED_)?(\w+)\)", file.read(), re.M):
                found[f"{suite}.{name}"] = (os.path.basename(path), bool(long))
    return found


def groups():
    with open(f"{TESTS}/cases.toml", "rb") as file:
        return tomllib.load(file)["group"]


def records(folder):
    """By test: its rows, without the name of the test. Of a case that a test runs twice the last counts."""
    found = {}
    for path in sorted(glob.glob(f"{folder}/*.*.csv")):
        if not path.endswith(".figure.csv"):
            with open(path, encoding="utf-8", newline="") as file:
                found[os.path.basename(path)[:-len(".csv")]] = list({row[0]: row for row in csv.reader(file)}.values())
    return found


def kept_records():
    found = {}
    if not os.path.exists(KEPT):
        return found
    with open(KEPT, encoding="utf-8", newline="") as file:
        for row in list(csv.reader(file))[1:]:
            found.setdefault(row[0], []).append(row[1:])
    return found


def largest(rows):
    """Of errors over what is allowed."""
    return max(float(row[4]) / float(row[5]) for row in rows)


def section(case, rows, files):
    lines = ["", f"## {case['title']}", "", case["checked"], ""]
    lines += [f"*Reference:* {case['source']}", ""] if "source" in case else []
    lines += [f"*Input:* {case['input']}", ""]
    for drawn in case.get("figures", []):
        lines += [f"![{case['title']}: {drawn['name'].replace('_', ' ')}]({drawn['name']}.svg)", "",
                  f"*{drawn['caption']}* [Numbers]({drawn['name']}.csv)", ""]
    lines += ["| comparison | expected | measured | unit | error | allowed | note |", "|---|---|---|---|---|---|---|"]
    lines += ["| " + " | ".join(map(cell, row)) + " |" for row in rows]
    tests = ", ".join(f"[`{test}`](../../tests/verification/{files[test][0]}){', long' if files[test][1] else ''}" for test in case["tests"])
    return lines + ["", f"Test: {tests}"]


def pages(kept):
    """By path: the text of each page."""
    files, out, table = sources(), {}, []
    for group in groups():
        lines, shown = [f"# {group['title']}", "", "One of the pages of [verification](../VERIFICATION.md)."], []
        for case in group["case"]:
            rows = list(dict.fromkeys(tuple(row) for test in case["tests"] for row in kept[test]))  # a long test repeats a short one
            shown += rows
            lines += section(case, rows, files)
        out[f"{PAGES}/{group['page']}.md"] = "\n".join(lines) + "\n"
        drawn = sum(len(case.get("figures", [])) for case in group["case"])
        table.append(f"| [{group['title']}](verification/{group['page']}.md) | {len(group['case'])} | {len(shown)} | {drawn} | {largest(shown):.2f} |")
    out[f"{ROOT}/manual/VERIFICATION.md"] = "\n".join([
        "# Verification, case by case", "",
        "Each case of `tests/verification`: what is checked, the input, a figure where there is a curve, and what was expected and measured.",
        "All numbers and curves are those that the tests wrote (`/usr/bin/python3 manual/verification.py` makes these pages).", "",
        "The error is the difference over the expected value, or over a scale of the problem where that is 0 or as the note says.",
        "Lines without marks are references. Marks are what the model gave. Sources and convergence are also in",
        "[Verification of the general path](../tests/verification/README.md), paths of the laws in [LAW_CASES.md](LAW_CASES.md).", "",
        "| page | cases | comparisons | figures | largest error over what is allowed |", "|---|---|---|---|---|", *table]) + "\n"
    return out


def figures():
    """By name: axes that are logarithmic."""
    return {drawn["name"]: drawn.get("log", "") for group in groups() for case in group["case"] for drawn in case.get("figures", [])}


def faults_of_lists(found):
    """Tests that stand in no case, cases without a test, and tests without a record."""
    files, listed = sources(), [test for group in groups() for case in group["case"] for test in case["tests"]]
    faults = [f"cases.toml: {test} is no test of tests/verification" for test in listed if test not in files]
    faults += [f"cases.toml: {test} is there twice" for test in sorted(set(listed)) if listed.count(test) > 1]
    faults += [f"cases.toml: {test} writes records and is in no case" for test in found if test in files and test not in listed]
    return faults + [f"{test} has no record: run it" for test in listed if test in files and test not in found]


def write_pages(kept):
    for path, text in pages(kept).items():
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)


def write(folder):
    found, files = records(folder), sources()
    for test, rows in kept_records().items():
        if test not in found and files.get(test, ("", False))[1]:
            found[test] = rows
    shown = figures()
    missing = [f"{name}.figure.csv is neither in {folder} nor on a page" for name in shown
               if not os.path.exists(f"{folder}/{name}.figure.csv") and not os.path.exists(f"{PAGES}/{name}.csv")]
    if faults := faults_of_lists(found) + missing:
        sys.exit("\n".join(faults))
    os.makedirs(PAGES, exist_ok=True)
    for old in set(os.listdir(PAGES)) - {f"{name}.csv" for name in shown}:
        os.remove(f"{PAGES}/{old}")
    with open(KEPT, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows([test, *row] for test, rows in sorted(found.items()) if test in files for row in rows)
    for name, log in shown.items():
        if os.path.exists(f"{folder}/{name}.figure.csv"):
            shutil.copy(f"{folder}/{name}.figure.csv", f"{PAGES}/{name}.csv")
        figure.draw(f"{PAGES}/{name}.csv", f"{PAGES}/{name}.svg", log)
    write_pages(kept_records())


def drawing(path):
    """An SVG without the names of its clip paths: hashes of places, whose last bits depend on the processor."""
    with open(path, encoding="utf-8") as file:
        return re.sub(r'(?<=["#])p[0-9a-f]{10}(?=[")])', "p", file.read())


def faults_of_pages(kept):
    """Pages and figures that are not those of the numbers beside them."""
    faults = []
    for path, text in pages(kept).items():
        with open(path, encoding="utf-8") as file:
            faults += [] if file.read() == text else [f"{path} is not that of its numbers and of cases.toml"]
    expected = {f"{name}.{end}" for name in figures() for end in ("csv", "svg")}
    faults += [f"{PAGES}/{name} is missing" for name in sorted(expected - set(os.listdir(PAGES)))]
    faults += [f"{PAGES}/{name} is no figure of cases.toml" for name in sorted(os.listdir(PAGES))
               if name.endswith(".svg") and name not in expected]
    with tempfile.TemporaryDirectory() as folder:
        for name, log in [] if faults else figures().items():
            with open(f"{PAGES}/{name}.svg", encoding="utf-8") as file:
                if f"<dc:title>{figure.version()}," not in file.read():
                    continue  # drawn by another version, which writes other bytes
            figure.draw(f"{PAGES}/{name}.csv", f"{folder}/{name}.svg", log)
            if drawing(f"{PAGES}/{name}.svg") != drawing(f"{folder}/{name}.svg"):
                faults.append(f"{PAGES}/{name}.svg is not that of {name}.csv")
    return faults


def differs(kept, now):
    """Whether a row is not that on the page."""
    same_texts = [kept[i] == now[i] for i in (0, 3, 5, 6)]
    expected = abs(float(kept[1]) - float(now[1])) <= 1e-3 * abs(float(kept[1]))
    return not all(same_texts) or not expected or abs(float(kept[4]) - float(now[4])) > SAME_ERROR * float(now[5])


def figure_differs(kept, now, log):
    """Whether a curve has other names or points than on the page; points as they stand on its axes."""
    kept, now = figure.read(kept), figure.read(now)
    if kept[:2] != now[:2] or [(*c[:2], len(c[2])) for c in kept[2]] != [(*c[:2], len(c[2])) for c in now[2]]:
        return True
    same = [[True] * len(c[2]) for c in kept[2]]
    for axis, at in (("x", 2), ("y", 3)):
        scale = math.log10 if axis in log else float
        places = [[scale(v) for v in c[at]] for c in kept[2]]
        span = max(map(max, places)) - min(map(min, places))
        for curve, old, new in zip(same, places, (c[at] for c in now[2])):
            curve[:] = [was and abs(a - scale(b)) <= SAME_POINT * span for was, a, b in zip(curve, old, new)]
    return any(sum(curve) < SAME_POINTS * len(curve) for curve in same)


def faults_of_numbers(kept, folder):
    """Numbers on the pages that are not those of the records in the folder. Long tests need not have run."""
    found, files = records(folder), sources()
    faults = [f"{test} has no record in {folder}: run it" for test in kept if test in files and not files[test][1] and test not in found]
    for test, rows in found.items():
        if test in kept and [row[0] for row in kept[test]] != [row[0] for row in rows]:
            faults.append(f"{test}: other comparisons than on its page")
        elif test in kept:
            faults += [f"{test}, {now[0]}: {', '.join(now[1:])}; its page has {', '.join(row[1:])}"
                       for row, now in zip(kept[test], rows) if differs(row, now)]
    for name, log in figures().items():
        now = f"{folder}/{name}.figure.csv"
        if os.path.exists(now) and figure_differs(f"{PAGES}/{name}.csv", now, log):
            faults.append(f"{PAGES}/{name}.csv is not {now}")
    return faults


def check(folder):
    kept = kept_records()
    faults = faults_of_lists({**records(folder), **kept}) or faults_of_pages(kept) + faults_of_numbers(kept, folder)
    print("\n".join(faults) or f"{sum(map(len, kept.values()))} comparisons, {len(figures())} figures")
    if faults:
        print("/usr/bin/python3 manual/verification.py writes the pages anew.")
    return 1 if faults else 0


if __name__ == "__main__":
    words = [word for word in sys.argv[1:] if not word.startswith("--")]
    records_folder = words[0] if words else f"{ROOT}/build/release/tests/verification/verification_records"
    if "--check" in sys.argv:
        sys.exit(check(records_folder))
    if "--pages" in sys.argv:
        write_pages(kept_records())
    else:
        write(records_folder)
