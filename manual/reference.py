"""The page REFERENCE.md: every key of scenes and studies, column of histories, command, option and name of Python, read
from the code that decides them, each with the pages that explain it.

usage: manual/reference.py            writes manual/REFERENCE.md
       manual/reference.py --check    exit code 1 if that page is old, a key is on no page, or a page has a key of no code
"""
import ast
import functools
import glob
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
KEY_SOURCES = sorted(glob.glob(f"{ROOT}/host/scene/read_*.cpp") + glob.glob(f"{ROOT}/host/scene/actions/*.cpp")) + [
    f"{ROOT}/host/ensemble/{name}.cpp" for name in ("study", "record_suite")]
DAMPING = "host/scene/damping.cpp"
KEY_PAGES = ["host/scenes/README.md", "host/scenes/BLOCKS.md", "host/ensemble/README.md", "host/records/README.md"]
COLUMN_PAGES = KEY_PAGES + ["host/python/README.md", "host/analysis/README.md", "host/step/RANKS.md"]
PYTHON = ["plugin_api/python/quoin/law.py"] + [f"host/python/quoin/{m}.py" for m in
          ("scene", "run", "simulation", "results", "analysis", "spectrum", "meshes", "shapes", "pictures", "view", "errors")]
ACCESSORS = {"number": "a number", "integer": "an integer", "boolean": "true or false", "text": "text", "choice": "one of",
             "numbers": "a list of numbers", "texts": "a list of texts", "points": "a list of points", "line": "a list of points", "list": "",
             "table": "a table", "tables": "tables", "within": "a table", "each": "tables", "velocity": "a velocity",
             "name_of": "a name of a table", "find": "", "accept": ""}
RANGES = {"kPositive": "more than 0", "kNotNegative": "0 or more", "kAny": "any finite number", "kPlace": "-1e6 to 1e6",
          "kLength": "more than 0 and at most 1e6", "kDensity": "more than 0 and at most 1e9",
          "kExtent": "more than 0 and at most 100"}
# Keys that are asked for by a name that is made, or of tables whose keys are free.
MADE = {"velocity": "a list of 3: numbers in m/s, or \"free\"", "x": "", "y": "", "z": "", "properties": "\"from_tests\"",
        "across": "a list of 3 numbers, m", "up": "a list of 3 numbers", "towards": "a list of 3 numbers",
        "part": "one of bed, head, inside", "tests": "a table", "correlation": "a list of pairs"}
# Heads of tables of keys whose first column says more than keys do.
FREE = {"anything else"}


@functools.cache
def read(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return file.read()


def arguments_at(text, begin):
    """Of the call whose parenthesis opens at text[begin]: what lies between its commas, strings kept whole."""
    depth, parts, part, i = 0, [], "", begin
    while i < len(text):
        c = text[i]
        if c == '"':
            end = i + 1
            while text[end] != '"':
                end += 2 if text[end] == "\\" else 1
            part += text[i:end + 1]
            i = end + 1
            continue
        depth += c in "([{"
        depth -= c in ")]}"
        if depth == 0:
            return [p.strip() for p in parts + [part[1:] if not parts else part]]
        if c == "," and depth == 1:
            parts.append(part[1:] if not parts else part)
            part = ""
        else:
            part += c
        i += 1
    return parts


def allowed_of(accessor, arguments):
    """What a message would say is allowed, as far as the call has it in words."""
    words = [ACCESSORS[accessor]] if ACCESSORS[accessor] else []
    if accessor == "name_of":
        return f"a name of a table [{arguments[3][1:-1]}.NAME]"
    if accessor == "each":
        return arguments[-1][1:-1] if arguments[-1].startswith('"tables') else tables_of(arguments[0][1:-1])
    for a in arguments[1:]:
        if a in RANGES:
            words.append(RANGES[a])
        a = re.sub(r"\bk[A-Z]\w+", lambda name: constant(name[0]), a.replace("kPlace.upper", "1e6"))
        for kind, lower in (("between", "{} to {}"), ("above_to", "more than {} and at most {}")):
            found = re.fullmatch(kind + r"\((.+?), (.+)\)", a)
            if found:
                words.append(lower.format(*found.groups()))
        if re.fullmatch(r"k[A-Z]\w+", a):
            a = named(a)
        if a.startswith("{{"):  # names with their values
            words.append(", ".join(re.findall(r'\{"([^"]*)"', a)))
        elif a.startswith("{\""):
            words.append(", ".join(re.findall(r'"([^"]*)"', a)))
        elif re.fullmatch(r'"[^"]+"', a):
            words.append(a[1:-1])
    if accessor == "integer" and len(arguments) >= 4:
        limits = [re.sub(r"\bk[A-Z]\w+", lambda name: constant(name[0]), a) for a in arguments[2:4]]
        if all(re.fullmatch(r"-?\d+", a) for a in limits):
            words.append(" to ".join(limits))
    if any("list of" in w for w in words[1:]):  # said again, in more words
        words = words[1:]
    text = ", ".join(w for w in words if w).replace("one of, ", "one of ").replace("a table, a table", "a table")
    return re.sub(r"one of$", "a name that the scene or the page has", text).replace("tables, tables", "tables")


def tables_of(key):
    """Heads of these tables, as the pages write them."""
    heads = {head for page in KEY_PAGES for head in re.findall(r"\[\[((?:[a-z_]+\.)*%s)\]\]" % key, read(page))}
    return "; or ".join(f"tables [[{head}]]" for head in sorted(heads or {key}))


def constant(name):
    """The number that a constexpr of the readers stands for, or its name."""
    for path in KEY_SOURCES + [f"{ROOT}/host/scene/reader.h", f"{ROOT}/host/scene/scene.h", f"{ROOT}/host/scene/cyclic_motion.h"]:
        found = re.search(r"\b%s = ([\d.e+-]+)" % name, read(path))
        if found:
            return found[1]
    return name


def named(name):
    """The names, with their values, that a constant of the readers stands for, or its name."""
    found = [re.search(r"\b%s = (\{\{.*?\}\});" % name, read(path), re.S) for path in KEY_SOURCES]
    return next((f[1] for f in found if f), name)


def keys_of_code():
    keys = {key: {text} - {""} for key, text in MADE.items()}
    for path in KEY_SOURCES:
        text = read(path)
        helpers = set(re.findall(r"auto (\w+) = \[[^\]]*\]\((?:Table& \w+, )?const (?:char\*|std::string&) (?:key|kind)\b", text))
        helpers |= set(re.findall(r"\b(\w+)\(Table& \w+, const (?:char\*|std::string&) (?:key|kind)\b", text))
        for found in re.finditer(r"\.(%s)\(|\b(%s)\((?!Table&)" % ("|".join(ACCESSORS), "|".join(helpers) or "$^"), text):
            arguments = arguments_at(text, found.end() - 1)
            if found[2] and arguments and not arguments[0].startswith('"'):
                arguments = arguments[1:]
            if not arguments or not re.fullmatch(r'"[a-z_0-9]+"', arguments[0]):
                continue
            entry = keys.setdefault(arguments[0][1:-1], set())
            accessor = "each" if found[2] == "read_kind" else found[1]
            allowed = allowed_of(accessor, arguments) if accessor else ""
            if allowed:
                entry.add(allowed)
        for listed in re.findall(r'const char\* (?:key|other) : \{("[^}]*")\}', text):
            for key in re.findall(r'"([a-z_]+)"', listed):
                keys.setdefault(key, set())
    for row in re.finditer(r'\{"\w+", &Settings::', read(DAMPING)):
        name, member, limits, unit = arguments_at(read(DAMPING), row.start())[:4]
        kind = "numbers" if name == '"maxwell_band"' else "number" if limits != "{}" else "boolean"
        keys.setdefault(name[1:-1], set()).add(allowed_of(kind, [name, member, limits.replace("reader::", ""), unit]))
    keys["damping"] = {"one of " + ", ".join(re.findall(r'\n    \{"(\w+)",\n     \{', read(DAMPING)))}
    return keys


@functools.cache
def headings(page):
    """(line, heading) of a page, headings as its links have them."""
    heading, lines = "", []
    for line in read(page).splitlines():
        if line.startswith("#") and re.match(r"#+ ", line):
            heading = line.lstrip("# ")
        lines.append((line, heading))
    return lines


def lists_keys(line):
    """Whether a line is no row of a table, or its first cell lists keys rather than says something."""
    if not line.startswith("|"):
        return True
    cell = re.sub(r"\(.*?\)|\".*?\"|\{.*?\}", " ", line.split("|")[1])
    return all(len(part.split()) <= 3 for part in re.split(r",| or ", cell))


def places(word, pages):
    """Where pages name it as code: `word`, the first cell of a row, or a line of TOML."""
    w = r"\b%s\b" % re.escape(word)
    shown = re.compile(w if "_" in word else
                       "|".join((f"`[^`]*{w}[^`]*`", rf"^\|[^|]*{w}[^|]*\|", rf"\{{[^}}]*{w}[^}}]*\}}", f"^ +#? ?{w} *=",
                                 rf"^ +\[+{w}", f"^    .*{w} = ")))
    if not any(shown.search(line) for page in pages for line, _ in headings(page)):
        shown = re.compile(rf"^\|.*{w}|^`\[\[.*{w}")
    found = []
    for page in pages:
        seen = []
        for line, heading in headings(page):
            if heading not in seen and lists_keys(line) and shown.search(line):
                seen.append(heading)
        first = [h for h in seen if any(re.match(r"\|[^|]*\b%s\b[^|]*\|" % re.escape(word), l)
                                        for l, at in headings(page) if at == h and lists_keys(l))]
        found += [(page, h) for h in (first or seen)[:2]]
    return found


def anchor(heading):
    return re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")


def links(found):
    return "; ".join(f"[{os.path.basename(page)}: {heading.replace('[', '').replace(']', '')}](../{page}#{anchor(heading)})"
                     for page, heading in found)


def keys_of_pages():
    """Words of the first column of tables of keys."""
    result = {}
    for page in KEY_PAGES[:2]:
        in_keys = False
        for line, _ in headings(page):
            if not line.startswith("|"):
                in_keys = False
            elif re.match(r"\| key\b", line):
                in_keys = True
            elif in_keys and not line.startswith("|---"):
                cell = line.split("|")[1]
                if cell.strip() in FREE:
                    continue
                for word in re.findall(r"[a-z_]{2,}", re.sub(r"\(.*?\)|\".*?\"|[A-Z]+| or ", " ", cell)):
                    result.setdefault(word, page)
    return result


def columns():
    names = re.findall(r'(?:columns\{\s*|add\(|\n\s+)\{?"([a-z_A-Z0-9]+)"', read("host/results/history.cpp"))
    of_damage = re.findall(r'\{"(\w+)"\}', read("host/step/columns/damage.cpp"))
    return [n for n in dict.fromkeys(names)] + of_damage + reaction_columns() + member_columns()


def reaction_columns():
    of_all = [f"reaction_{c}_N" for c in "xyz"] + [f"reaction_m{c}_Nm" for c in "xyz"]
    return of_all + ["reaction_NAME_x_N", "reaction_NAME_mz_Nm"] + [f"driven_NAME_d{c}_m" for c in "xyz"]


def member_columns():
    names = []
    for kind in ("ties", "beds", "strips", "floors", "beams", "dowels", "fills"):  # as kKinds of members/members.h
        code = read(f"host/members/{kind}.cpp")
        body = code[code.index("column_names(const"):]
        for form in re.findall(r'"([a-z]+_\{\}_[^"]*)"', body[:body.index("\n}\n")]):
            name = form.replace("{}", "NAME", 1)
            names += [name.replace("{}", axis) for axis in "xyz"] if "{}" in name else [name]
    return names


def monitor_columns():
    """Columns of monitors.csv: of the ground, of a monitor NAME, and against the ground."""
    code = read("host/results/monitors.cpp")
    relative, drift = re.search(r'm\.name \+ "(_relative)"', code)[1], re.search(r'"\{\}(_drift_)\{\}"', code)[1]
    motions = [f"_{q}{c}_{unit}" for q, unit in (("d", "m"), ("v", "m_s"), ("a", "m_s2")) for c in "xyz"]
    names = [of + motion for of in ("ground", "NAME", "NAME" + relative) for motion in motions]
    return names + [f"NAME{drift}{axis}" for axis in "xz"]


def exported_names():
    """Names that the package gives to functions of other names, and functions of the compiled part: {module.name: name}."""
    found = {}
    for node in ast.walk(ast.parse(read("plugin_api/python/quoin/__init__.py"))):
        if isinstance(node, ast.ImportFrom) and node.level == 1:
            found.update({(node.module, name.name): name.asname for name in node.names if name.asname})
    return found


def python_names():
    exported = exported_names()
    yield "quoin", "add_law_folder(folder)", "", "Adds a folder in which laws are searched"
    for path in PYTHON:
        tree = ast.parse(read(path))
        module = os.path.basename(path)[:-3]
        for node in tree.body:
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.name.startswith("_"):
                shown = exported.get((module, node.name), node.name)
                yield module, shown, signature(node), first_line(node)
                for member in node.body if isinstance(node, ast.ClassDef) else []:
                    if isinstance(member, ast.FunctionDef) and not member.name.startswith("_"):
                        yield module, f"{node.name}.{member.name}", signature(member), first_line(member)
                    elif is_property(member) and not member.targets[0].id.startswith("_"):
                        yield module, f"{node.name}.{member.targets[0].id}", "", doc_of(member.value)


def is_property(node):
    """Whether a statement is name = property(...)."""
    return (isinstance(node, ast.Assign) and isinstance(node.value, ast.Call) and isinstance(node.targets[0], ast.Name) and
            getattr(node.value.func, "id", "") == "property")


def doc_of(call):
    return next((k.value.value for k in call.keywords if k.arg == "doc"), "")


def signature(node):
    if isinstance(node, ast.ClassDef):
        return ""
    decorators = {getattr(d, "id", getattr(d, "attr", "")) for d in node.decorator_list}
    if "property" in decorators or "cached_property" in decorators:
        return ""
    names = [a.arg for a in node.args.posonlyargs + node.args.args + node.args.kwonlyargs if a.arg not in ("self", "cls")]
    return f"({', '.join(names)})"


def first_line(node):
    text = ast.get_docstring(node) or ""
    sentence = re.split(r"(?<=[.;:]) |\n\n", " ".join(text.split("\n\n")[0].split()))[0]
    return sentence.rstrip(".:;").replace("|", "\\|")


def commands():
    """(command, option, type, meaning) as `quoin COMMAND --help` says, from the text that the tests approve."""
    command = ""
    lines = read("tests/cli/approved/help.txt").splitlines()
    for i, line in enumerate(lines):
        found = re.fullmatch(r"quoin ?(\w*) --help", line)
        if found:
            command = found[1]
        option = re.match(r"  (?:-h,)?(--[a-z-]+)(.*)", line)
        if option and option[1] != "--help" and not line.startswith("  quoin"):
            kind, _, meaning = (option[2] + "  ").partition("  ")
            below = lines[i + 1] if lines[i + 1].startswith(" " * 8) else ""
            if not meaning.strip() and not below:  # a range that just reaches the column of meanings
                kind, _, meaning = option[2].partition("] ")
                kind += "]"
            yield command, option[1], kind.strip(), meaning.strip() or below.strip()


def page():
    keys = keys_of_code()
    out = ["# Reference", "",
           "Every key, column, option and name of Python, read from the code by `python3 manual/reference.py`. A test holds this",
           "page against the code. The pages in the last column say what each is for, with defaults and units.", "",
           "## Keys of scenes and studies", "", "| key | allowed | explained in |", "|---|---|---|"]
    lost = []
    for key in sorted(keys):
        found = places(key, KEY_PAGES)
        if not found:
            lost.append(key)
        out.append(f"| `{key}` | {'; or '.join(sorted(keys[key])).replace('|', chr(92) + '|')} | {links(found)} |")
    out += ["", "Properties of joints are those of their law: `quoin models LAW`.", "",
            "## Columns of history.csv", "", "| column | explained in |", "|---|---|"]
    for name in columns():
        found = places(name, COLUMN_PAGES)
        if not found:
            lost.append(name)
        out.append(f"| `{name}` | {links(found)} |")
    out += ["", "## Columns of monitors.csv", "", "NAME: of a `[[monitor]]`.", "", "| column | explained in |", "|---|---|"]
    for name in monitor_columns():
        found = places(re.sub(r"(_relative)?_([dva])[xyz]_", r"_\2x_", name), KEY_PAGES[1:2])
        if not found:
            lost.append(name)
        out.append(f"| `{name}` | {links(found)} |")
    out += ["", "## Commands and options", "", "| command | option | value | meaning |", "|---|---|---|---|"]
    for command, option, kind, meaning in commands():
        out.append(f"| quoin {command} | `{option}` | {kind} | {meaning} |".replace("{", "(").replace("}", ")"))
    out += ["", "## Names of Python", "", "[python](../host/python/README.md) has examples.", "",
            "| module | name | |", "|---|---|---|"]
    for module, name, arguments, meaning in python_names():
        out.append(f"| {module} | `{name}{arguments}` | {meaning} |")
    return "\n".join(out) + "\n", lost, [f"{k} ({p})" for k, p in keys_of_pages().items() if k not in keys]


def main():
    text, lost, strange = page()
    target = f"{ROOT}/manual/REFERENCE.md"
    if "--check" not in sys.argv:
        with open(target, "w", encoding="utf-8") as file:
            file.write(text)
    faults = [f"in the code and on no page: {', '.join(lost)}"] if lost else []
    faults += [f"on a page and in no code: {', '.join(strange)}"] if strange else []
    if not os.path.exists(target) or read("manual/REFERENCE.md") != text:
        faults.append("manual/REFERENCE.md is old; run python3 manual/reference.py")
    print("\n".join(faults) or "the reference agrees with the code")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
