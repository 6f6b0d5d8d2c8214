"""Every .md page that a file of the tree cites exists: usage cited_pages.py SOURCE_DIR | --self-test.

A link of a page, ](x.md), is relative to the folder of the page, as in a browser. Elsewhere, in code, messages and prose, a
name is relative to that folder, to the root of the tree, or to an include folder.
"""
import os
import re
import sys
import tempfile

INCLUDE_ROOTS = ("", "contact_models", "host")
SKIPPED_FOLDERS = {"build", "out", ".git", "approved"}  # approved: outputs of programs in other folders
SUFFIXES = (".h", ".hpp", ".c", ".cpp", ".py", ".f90", ".md", ".toml", ".txt", ".cmake", ".in", ".sh", "")
LINK = re.compile(r"\]\(([^)#\s]+\.md)(?:#[^)]*)?\)")
ANY_LINK = re.compile(r"(?:\[[^\]]*)?\]\([^)]*\)")
NAME = re.compile(r"(?<![\w./{}$*-])((?:\.\.?/|[\w-]+/)*[\w-]+\.md)\b")


def missing(root):
    """Returns (file, line, page) of each cited page that does not exist, and the number of citations."""
    found, count = [], 0
    for folder, folders, files in os.walk(root):
        folders[:] = sorted(f for f in folders if f not in SKIPPED_FOLDERS)
        for file in sorted(files):
            path = os.path.join(folder, file)
            if os.path.splitext(file)[1] not in SUFFIXES or os.path.samefile(path, __file__):
                continue
            with open(path, encoding="utf-8", errors="ignore") as text:
                for number, line in enumerate(text, 1):
                    links = set(LINK.findall(line)) if file.endswith(".md") else set()
                    names = set(NAME.findall(ANY_LINK.sub("", line)))
                    for page in sorted(links | names):
                        if "://" in page:
                            continue
                        roots = [] if page in links else [os.path.join(root, r) for r in INCLUDE_ROOTS]
                        count += 1
                        if not any(os.path.isfile(os.path.join(place, page)) for place in [folder, *roots]):
                            found.append((os.path.relpath(path, root), number, page))
    return found, count


def self_test():
    with tempfile.TemporaryDirectory() as root:
        def write(name, text):
            path = os.path.join(root, name)
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)

        write("host/README.md", "[there](sub/PAGE.md), [not from here](PAGE.md), `host/README.md`\n")
        write("host/sub/PAGE.md", "nothing\n")
        write("host/code.h", "// sub/PAGE.md, host/sub/PAGE.md, GONE.md\n")
        found, count = missing(root)
        expected = [("host/README.md", 1, "PAGE.md"), ("host/code.h", 1, "GONE.md")]
        if found != expected or count != 6:
            print(f"found {found} of {count}, expected {expected} of 6")
            return 1
    print("missing pages are told, others are not")
    return 0


def main():
    if sys.argv[1] == "--self-test":
        return self_test()
    found, count = missing(sys.argv[1])
    for file, line, page in found:
        print(f"{file}:{line}: {page} does not exist")
    print(f"{count} citations, {len(found)} of pages that do not exist")
    return 1 if found or count < 20 else 0


sys.exit(main())
