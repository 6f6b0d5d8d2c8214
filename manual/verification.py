"""The page VERIFICATION.md: what every comparison of tests/verification expects and measures, from the lines that the tests
write: python3 manual/verification.py [build/release/tests/verification/verification.csv]. Of a case run twice the last counts."""
import csv
import os
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FILE = sys.argv[1] if len(sys.argv) > 1 else f"{ROOT}/build/release/tests/verification/verification.csv"

cases = {}
with open(FILE, encoding="utf-8", newline="") as file:
    for row in csv.reader(file):
        cases.pop(row[0], None)
        cases[row[0]] = row[1:]
lines = ["# Verification, case by case", "",
         "Each line is a comparison in `tests/verification`, as the tests wrote it (`python3 manual/verification.py` makes this page).",
         "The error is the difference over the expected value, or over a scale of the problem where that is 0 or as the note says.",
         "Sources and convergence are in [Verification of the general path](../tests/verification/README.md).",
         "Paths of the laws are in [LAW_CASES.md](LAW_CASES.md).", "",
         f"{len(cases)} cases.", "", "| case | expected | measured | unit | error | allowed | note |", "|---|---|---|---|---|---|---|"]
for what, rest in sorted(cases.items()):
    lines.append("| " + " | ".join(field.replace("|", "\\|") for field in [what, *rest]) + " |")
with open(f"{ROOT}/manual/VERIFICATION.md", "w", encoding="utf-8") as file:
    file.write("\n".join(lines) + "\n")
