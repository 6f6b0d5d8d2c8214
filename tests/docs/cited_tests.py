"""Every test in backquotes on a page, `Suite.Test`, `Suite.*` or `Test`, exists. Usage: cited_tests.py SOURCE_DIR PAGE"""
import fnmatch
import os
import re
import sys

DEFINED = re.compile(r"^TEST(?:_F|_P)?\((\w+),\s*(\w+)\)", re.MULTILINE)
CITED = re.compile(r"`((?:[A-Z]\w*[*]?\.)?[A-Z][\w*]*[a-z][\w*]*|[A-Z]\w+\.\*)`")

root, page = sys.argv[1:]
tests = set()
for folder, _, files in os.walk(os.path.join(root, "tests")):
    for file in files:
        if file.endswith(".cpp"):
            with open(os.path.join(folder, file), encoding="utf-8") as text:
                tests |= {f"{suite}.{name}" for suite, name in DEFINED.findall(text.read())}
with open(os.path.join(root, page), encoding="utf-8") as text:
    cited = [(number, name) for number, line in enumerate(text, 1) for name in CITED.findall(line)]
missing = [(number, name) for number, name in cited
           if not fnmatch.filter(tests, name if "." in name else f"*.{name}")]
for number, name in missing:
    print(f"{page}:{number}: there is no test {name}")
print(f"{len(cited)} tests cited of {len(tests)}, {len(missing)} that do not exist")
sys.exit(1 if missing or len(cited) < 10 else 0)
