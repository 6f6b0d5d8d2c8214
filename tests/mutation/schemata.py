"""All random mutants in one build, each switched on by an environment variable.

The expression E around a changed token becomes `(on(17) ? (E changed) : (E))`. E begins and ends at a bracket, comma,
semicolon, assignment, `? :` or `return` of the text. Mutants that do not compile so are removed by the compiler's messages.
on() reads one byte for each mutant: 0 not reached, 1 reached, 2 planted. With QUOIN_MUTANTS_REACHED the bytes are a mapped
file, which has the mutants that a test reaches, also if its programs crash. QUOIN_MUTANT plants one.
"""
import re
import subprocess

HEADER = r"""#ifndef QUOIN_MUTANT_H
#define QUOIN_MUTANT_H
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <type_traits>
namespace quoin_mutant {
// a < less > b: what a < b becomes. The boundary moves where both are whole numbers; of floating-point numbers, of which
// hardly two are equal, the other side is taken.
template <int relation>
struct Relation {};
inline constexpr Relation<0> less;
inline constexpr Relation<1> less_equal;
inline constexpr Relation<2> greater;
inline constexpr Relation<3> greater_equal;
template <class A, int relation>
struct Left {
  const A& a;
};
template <class A, int relation>
constexpr Left<A, relation> operator<(const A& a, Relation<relation>) {
  return {a};
}
template <class A, int relation, class B>
constexpr auto operator>(Left<A, relation> left, const B& b) {
  constexpr bool floating = std::is_floating_point_v<A> || std::is_floating_point_v<B>;
  if constexpr (relation == 0) return floating ? left.a >= b : left.a <= b;
  if constexpr (relation == 1) return floating ? left.a > b : left.a < b;
  if constexpr (relation == 2) return floating ? left.a <= b : left.a >= b;
  if constexpr (relation == 3) return floating ? left.a < b : left.a > b;
}
inline constexpr int capacity = 4096;
inline unsigned char own[capacity];
inline unsigned char* state = own;
[[gnu::constructor(101), gnu::used]] static void read_environment() {
  if (state != own) return;
  if (const char* planted = std::getenv("QUOIN_MUTANT")) own[std::atoi(planted)] = 2;
  if (const char* name = std::getenv("QUOIN_MUTANTS_REACHED")) {
    const int file = open(name, O_RDWR | O_CLOEXEC);
    void* bytes = file < 0 ? MAP_FAILED : mmap(nullptr, capacity, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (bytes != MAP_FAILED) state = static_cast<unsigned char*>(bytes);
    if (file >= 0) close(file);
  }
}
[[gnu::noinline, gnu::cold]] inline bool decide(int id) {
  if (state[id] == 2) return true;
  state[id] = 1;
  return false;
}
[[gnu::always_inline]] inline bool on(int id) { return state[id] != 1 && decide(id); }
}  // namespace quoin_mutant
#endif
"""
CAPACITY = 4096

COMMENT = r"//[^\n]*|/\*(?:.|\n)*?\*/"
LITERAL = r'R"(?P<raw>\w*)\((?:.|\n)*?\)(?P=raw)"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])*\''
OPENS, CLOSES = dict(zip(")]}", "([{")), dict(zip("([{", ")]}"))
STOP_LEFT = re.compile(r"(?:[;,{}]|[^:]:| \? | (?:[-+*/|&^]|<<|>>)?=\s|\b(?:return|else|throw|do|case)\s)\Z")
STOP_RIGHT = re.compile(r"[;,)\]}]| \? |(?<!:):(?!:)")
SIZE_LEFT = re.compile(r"\b(?!return|else|throw|case)\w+[>*&]? \w+(?:\[\w+\])*(?:, \w+(?:\[\w+\])*)*\[\Z")
CONTROL = re.compile(r"\b(?:if|for|while|switch|constexpr)\s*\Z")


def code_only(text):
    """Returns the text with equal positions, with comments and preprocessor lines as \\0, literals as \\1."""
    def blank(match):
        return re.sub(r"[^\n]", "\1" if match.group(0)[0] in "R\"'" else "\0", match.group(0))
    text = re.sub(f"{LITERAL}|{COMMENT}", blank, text)
    text = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", blank, text, flags=re.M)
    return re.sub(r"static_assert\((?:.|\n)*?\);", blank, text)


def matching(code, i, step):
    """Returns the position of the bracket that matches the one at i."""
    pairs = CLOSES if step > 0 else OPENS
    wanted = []
    while 0 <= i < len(code):
        if code[i] in pairs:
            wanted.append(pairs[code[i]])
        elif wanted and code[i] == wanted[-1]:
            wanted.pop()
            if not wanted:
                return i
        i += step
    raise ValueError("bracket without its answer")


def expression(code, begin, end):
    """Returns the range [from, to) of the expression around a token."""
    i = begin
    while i > 0:
        before = code[i - 1]
        if before == ")" or before == "]" or (before == "}" and code[i] != "\n"):
            i = matching(code, i - 1, -1)
            if before == ")" and CONTROL.search(code, max(0, i - 20), i):
                i = matching(code, i, +1) + 1
                break
        elif before in "([" or (STOP_LEFT.search(code, max(0, i - 8), i) and code[i - 1:i + 1] != "::"):
            break
        else:
            i -= 1
    while code[i].isspace() or code[i] == "\0":
        i += 1
    j = end
    if code[end - 1] == "(":
        j -= 1
    while j < len(code):
        if code[j] in "([{":
            j = matching(code, j, +1)
        elif STOP_RIGHT.match(code, j):
            break
        j += 1
    return i, j


class Mutant:
    """One changed token of one file. form: how it is built; why: message of the compiler."""

    def __init__(self, number, site, text, code):
        self.number = number
        self.file, self.begin, self.end, self.replacement, self.kind = site
        self.line = text.count("\n", 0, self.begin) + 1
        self.old, self.new = text[self.begin:self.end].strip(), re.sub("< ::quoin_mutant::(.*) >", r"\1", self.replacement).strip()
        self.form = "schemata"
        try:
            self.lo, self.hi = (self.begin, self.end) if self.kind == "branch" else expression(code, self.begin, self.end)
        except (ValueError, IndexError):
            self.form = "alone"
            return
        self.lines = range(text.count("\n", 0, self.lo) + 1, text.count("\n", 0, self.hi) + 2)
        if re.search(r'^\s*#|\bR"', text[self.lo:self.hi], flags=re.M):
            self.form = "alone"
        if SIZE_LEFT.search(code, max(0, self.begin - 120), self.begin) and code[self.end] == "]":
            self.form = "alone"  # the size of an array, for which messages have the place of use
        if self.kind == "branch" and re.search(r"\w[*&]* \w+ = |;", code[self.lo:self.hi]):
            self.form = "does not compile"


def strip_comments(text):
    return re.sub(f"({LITERAL})|{COMMENT}", lambda m: m.group(1) or "", text)


def with_schemata(text, mutants):
    """Returns the text with all mutants, without a change of line numbers."""
    def render(lo, hi, inside):
        out, i = "", lo
        while inside:
            first = min(inside, key=lambda m: (m.lo, -m.hi))
            same = [m for m in inside if (m.lo, m.hi) == (first.lo, first.hi)]
            within = [m for m in inside if m not in same and m.hi <= first.hi]
            inside = [m for m in inside if m not in same and m not in within]
            body = render(first.lo, first.hi, within)
            for m in same:
                changed = strip_comments(text[m.lo:m.begin]) + m.replacement + strip_comments(text[m.end:m.hi])
                body = f"(::quoin_mutant::on({m.number}) ? ({' '.join(changed.split(chr(10)))}) : ({body}))"
            out += text[i:first.lo] + body
            i = first.hi
        return out + text[i:hi]
    code = code_only(text)
    changed = render(0, len(text), [m for m in mutants if m.form == "schemata"])
    for m in mutants:  # a constant that a mutant may change is not constexpr
        if m.form == "schemata":
            at = code.rfind("constexpr ", 0, m.lo)
            head = code[at:m.lo]
            if at >= 0 and ";" not in head and "(" not in re.split("[={]", head)[0]:
                line = text[text.rfind("\n", 0, at) + 1:text.find("\n", at)]
                inside = line.startswith(" ") and "static " in line  # a member of a class
                changed = changed.replace(line[line.find("constexpr"):], line[line.find("constexpr"):].replace(
                    "constexpr ", "inline const " if inside else "const "), 1)
    return '#include "' + "quoin_mutant.h" + '"\n#line 1\n' + changed


def blame(output, mutants):
    """Removes the mutants of the compiler's messages from the schemata and returns them."""
    found = set()
    for message in re.split(r"\n(?=[^\n]*: In |[^\n]*: error: )", output):
        error = re.search(r"^\S*?([^\s:]+):(\d+):\d+: error: (.*)", message, flags=re.M)
        if not error:
            continue
        places = [(error.group(1), int(error.group(2)))]
        places += [(f, int(n)) for f, n in re.findall(r"^(?:In file included from )?([^\s:]+):(\d+):\d+:", message, flags=re.M)]
        for i, (file, line) in enumerate(places):
            hits = [m for m in mutants if m.form != "does not compile" and file.endswith(m.file) and line in m.lines]
            wrong = re.search(r"(?:no match for|invalid operands of types .* to binary) .operator(\S+?)['’]", error.group(3))
            nonsense = [m for m in hits if wrong and wrong.group(1) == m.new]
            for m in nonsense or hits:
                m.form = "does not compile" if nonsense else "alone"
                found.add(m)
            if hits and i == 0:
                break
    return found
