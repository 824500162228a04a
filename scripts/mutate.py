#!/usr/bin/env python3
"""Makes small changes to Afferent's code, one at a time, and reports those that no test notices.

A change is drawn from clang's syntax tree, so that it is always made to an expression that the compiler sees. It is
made in a copy of the tree in build/mutate: the tree itself is only read. All changes are compiled at once, each behind a
switch in the environment; only what does not compile so is made by itself. Each test is run once by itself as the tree
is, to learn how long it takes and which changes it comes to: a change is tried with those tests alone. Those that include
the changed file's header run first, then the rest of the folder's, then those of every other folder that links the
component. A test notices a change if it fails, crashes or hangs twice in a row, and passes without the change in between.
A change after which what is compiled of it is the same, bit by bit, changes nothing and is not counted.

Exit status: 0 where every change was noticed, 1 where one survived, 2 where nothing could be tried.
"""

import argparse
import collections
import concurrent.futures
import fcntl
import fnmatch
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

import clang.cindex as clang

Kind = clang.CursorKind
ROOT = pathlib.Path(__file__).resolve().parent.parent
COPY = ROOT / "build" / "mutate"
BUILD = COPY / "build" / "release"
# Folders with code that tests of their own folder run.
FOLDERS = ("runtime", "neurons", "encoders", "decoders", "io/wire", "io/links", "io/files", "hand", "scene", "engine",
           "nodes", "nodes/ranks", "studies", "studies/trial", "view")
# As a change goes on to the tests of other folders: the quick ones first. Those of whole programs are left out.
TESTED = ("runtime", "encoders", "neurons", "decoders", "hand", "scene", "engine", "view", "io_wire", "io_links",
          "io_files", "studies_trial", "studies", "nodes", "c_interface", "threads", "nodes_ranks", "faults")

OTHER_EDGE = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="}
OTHER_SIGN = {"+": "-", "-": "+", "*": "/", "/": "*", "%": "*", "+=": "-=", "-=": "+=", "*=": "/=", "/=": "*=",
              "<<": ">>", ">>": "<<", "&": "|", "|": "&"}
SYMMETRIC = ("min", "max", "minmax", "hypot", "midpoint", "gcd", "lcm", "swap", "tie", "Add", "Mul")
NUMBER = re.compile(r"(0[xX][0-9a-fA-F']+|[0-9][0-9']*)([uUlLzZ]*|[a-z]+)|"
                    r"([0-9][0-9']*\.[0-9']*|\.[0-9]+|[0-9]+)([eE][-+]?[0-9]+)?[fFlL]?")

# `context`: None where the expression is evaluated at run time, "constexpr" where it may be evaluated when it is
# compiled, and the span of the keyword where that is all that asks for it, and what may stand in its place.
Change = collections.namedtuple("Change", "path line begin end new what old whole context")
FUNCTIONS = (Kind.FUNCTION_DECL, Kind.CXX_METHOD, Kind.CONSTRUCTOR, Kind.FUNCTION_TEMPLATE, Kind.CONVERSION_FUNCTION,
             Kind.DESTRUCTOR, Kind.LAMBDA_EXPR)


class Tree:
    """A source file and the changes that can be made to it."""

    def __init__(self, path, arguments):
        self.path = path
        self.text = (COPY / path).read_bytes()
        self.changes = {}
        self.context = None
        self.turned = set()  # whole conditions, so that their == is not turned once more
        unit = clang.Index.create().parse(str(COPY / path), args=arguments)
        errors = [d for d in unit.diagnostics if d.severity >= clang.Diagnostic.Error]
        if errors:
            print(f"{path}: clang cannot parse it: {errors[0].spelling}", file=sys.stderr)
        for cursor in unit.cursor.get_children():
            if self.here(cursor):
                self.walk(cursor, None)

    def here(self, cursor):
        file = cursor.location.file
        return file is not None and os.path.realpath(file.name) == str(COPY / self.path)

    def span(self, cursor):
        return cursor.extent.start.offset, cursor.extent.end.offset

    def source(self, begin, end):
        return self.text[begin:end].decode()

    def add(self, begin, end, new, what, whole=None):
        """A change of begin to end. `whole` is the expression that it is in, if it is none itself."""
        old = self.source(begin, end)
        if old == new:
            return
        line = self.text.count(b"\n", 0, begin) + 1
        self.changes.setdefault((begin, end, new),
                                Change(self.path, line, begin, end, new, what, old, whole or (begin, end), self.context))

    def context_of(self, cursor, parent):
        begin, end = self.span(cursor)
        if cursor.kind in FUNCTIONS:
            head = re.split(r"[{]", self.source(begin, end), maxsplit=1)[0]
            return "constexpr" if re.search(r"\bconst(expr|eval)\b", head) else None
        if cursor.kind in (Kind.FIELD_DECL, Kind.PARM_DECL):
            return "constexpr"
        if cursor.kind == Kind.VAR_DECL:
            keyword = re.search(r"\bconstexpr\b", self.source(begin, max(begin, cursor.location.offset)))
            if keyword:
                member = parent is not None and parent.kind in (Kind.CLASS_DECL, Kind.STRUCT_DECL, Kind.CLASS_TEMPLATE)
                return begin + keyword.start(), begin + keyword.end(), b"inline const" if member else b"const"
        return self.context

    def walk(self, cursor, parent):
        kind = cursor.kind
        # Neither of them is executed.
        if kind in (Kind.STATIC_ASSERT, Kind.ENUM_DECL, Kind.TYPEDEF_DECL, Kind.TYPE_ALIAS_DECL, Kind.USING_DECLARATION,
                    Kind.CONCEPT_DECL if hasattr(Kind, "CONCEPT_DECL") else Kind.STATIC_ASSERT):
            return
        outer, self.context = self.context, self.context_of(cursor, parent)
        self.changes_of(cursor, parent)
        self.context = outer

    def changes_of(self, cursor, parent):
        kind = cursor.kind
        children = [c for c in cursor.get_children()]
        self.operators(cursor, children)
        self.numbers(cursor)
        self.conditions(cursor, children)
        self.calls(cursor, parent)
        for child in children:
            # The condition of a template, and the size of an array, are decided when it is compiled.
            if kind in (Kind.VAR_DECL, Kind.FIELD_DECL, Kind.PARM_DECL) and self.is_in_brackets(child):
                continue
            self.walk(child, cursor)

    def is_in_brackets(self, cursor):
        begin, end = self.span(cursor)
        before, after = self.text[max(0, begin - 2):begin], self.text[end:end + 2]
        return before.rstrip().endswith(b"[") and after.lstrip().startswith(b"]")

    def operator_between(self, left, right):
        """The only token between two expressions, if it is an operator."""
        begin, end = left.extent.end.offset, right.extent.start.offset
        between = self.source(begin, end) if begin <= end else ""
        token = between.strip()
        return token, begin + between.find(token), begin + between.find(token) + len(token)

    def operators(self, cursor, children):
        if cursor.kind not in (Kind.BINARY_OPERATOR, Kind.COMPOUND_ASSIGNMENT_OPERATOR, Kind.CALL_EXPR,
                               Kind.UNEXPOSED_EXPR, Kind.UNARY_OPERATOR):
            return
        if cursor.kind == Kind.UNARY_OPERATOR and len(children) == 1:
            begin, _ = self.span(cursor)
            inner, end = self.span(children[0])
            token = self.source(begin, inner).strip() if begin < inner else ""
            if token == "-":
                self.add(begin, begin + 1, "", "a sign dropped", self.span(cursor))
            elif token == "!" and self.span(cursor) not in self.turned:
                self.add(begin, begin + 1, "", "a condition turned", self.span(cursor))
            elif token in ("++", "--"):
                self.add(begin, begin + 2, {"++": "--", "--": "++"}[token], "a sign", self.span(cursor))
            return
        operands = sorted((c for c in children if not re.fullmatch(r"\W+", self.source(*self.span(c)) or "x")),
                          key=self.span)
        for left, right in zip(operands, operands[1:]):
            token, begin, end = self.operator_between(left, right)
            if token in ("==", "!=") and self.span(cursor) in self.turned or \
                    token == "+" and "basic_string" in cursor.type.get_canonical().spelling:
                continue
            if token in OTHER_EDGE:
                self.add(begin, end, OTHER_EDGE[token], "a comparison's edge", self.span(cursor))
            elif token in OTHER_SIGN:
                self.add(begin, end, OTHER_SIGN[token], "a sign", self.span(cursor))
            elif token in ("&&", "||"):
                neutral = "true" if token == "&&" else "false"
                for operand in (left, right):
                    self.add(*self.span(operand), neutral, "a condition dropped")

    def numbers(self, cursor):
        begin, end = self.span(cursor)
        if end - begin > 24 or end <= begin:
            return
        text = self.source(begin, end)
        if cursor.kind == Kind.CXX_BOOL_LITERAL_EXPR and text in ("true", "false"):
            self.add(begin, end, "false" if text == "true" else "true", "a constant")
        if cursor.kind not in (Kind.INTEGER_LITERAL, Kind.FLOATING_LITERAL, Kind.CALL_EXPR, Kind.UNEXPOSED_EXPR):
            return
        match = NUMBER.fullmatch(text)
        if not match:
            return
        if match.group(1):
            whole = match.group(1).replace("'", "")
            value = int(whole, 16 if whole[:2] in ("0x", "0X") else 10)
            larger = value + 1 if value < 8 else value + value // 2
            self.add(begin, end, str(larger) + match.group(2), "a constant")
            if value in (1, 2):
                self.add(begin, end, str(value - 1) + match.group(2), "a constant")
        else:
            number = float(text.rstrip("fFlL").replace("'", ""))
            self.add(begin, end, repr(number * 1.5 if number != 0 else 1.0) + ("L" if text[-1] in "lL" else ""),
                     "a constant")

    def conditions(self, cursor, children):
        if cursor.kind in (Kind.IF_STMT, Kind.WHILE_STMT, Kind.CONDITIONAL_OPERATOR) and children:
            condition = next((c for c in children if c.kind.is_expression()), None)
            if condition is None:
                return
            begin, end = self.span(condition)
            head = self.source(cursor.extent.start.offset, begin)
            # The condition of a macro stands in its definition, not where it is used.
            if "constexpr" in head or begin >= end or re.match(r"[A-Z][A-Z_]+\(", self.source(begin, end)):
                return
            self.turned.add((begin, end))
            self.add(begin, end, f"!({self.source(begin, end)})", "a condition turned")
            if cursor.kind == Kind.IF_STMT:
                self.add(begin, end, f"({self.source(begin, end)}) && false", "a condition's branch left out")

    def calls(self, cursor, parent):
        if cursor.kind != Kind.CALL_EXPR:
            assigned = cursor.kind in (Kind.BINARY_OPERATOR, Kind.COMPOUND_ASSIGNMENT_OPERATOR, Kind.UNARY_OPERATOR)
            if assigned and self.is_statement(cursor, parent) and self.source(*self.span(cursor)).count("\n") < 6:
                self.add(*self.span(cursor), "(void)0", "an assignment left out")
            return
        begin, end = self.span(cursor)
        if self.is_statement(cursor, parent):
            self.add(begin, end, "(void)0", "a call left out")
        name = cursor.spelling or ""
        if name in ("min", "max"):
            head = re.match(r"(std::)?(min|max)\b", self.source(begin, end))
            if head:
                self.add(begin, begin + head.end(), (head.group(1) or "") + {"min": "max", "max": "min"}[name],
                         "the larger for the smaller", (begin, end))
        if name.startswith("operator") or name in SYMMETRIC:
            return
        given = [a for a in cursor.get_arguments() if a is not None and self.here(a)]
        for first, second in zip(given, given[1:]):
            (a, b), (c, d) = self.span(first), self.span(second)
            if b <= c and self.source(b, c).strip() == "," and self.same_type(first, second):
                self.add(a, d, self.source(c, d) + self.source(b, c) + self.source(a, b), "arguments swapped",
                         (begin, end))

    @staticmethod
    def same_type(first, second):
        plain = [t.type.get_canonical().spelling.replace("const ", "").rstrip("& ") for t in (first, second)]
        return plain[0] == plain[1] and plain[0] != ""

    def is_statement(self, cursor, parent):
        """Its value is not used."""
        if parent is None:
            return False
        _, end = self.span(cursor)
        if not self.text[end:end + 40].lstrip().startswith(b";"):
            return False
        if parent.kind == Kind.COMPOUND_STMT:
            return True
        children = list(parent.get_children())
        if parent.kind == Kind.IF_STMT:
            return any(c == cursor for c in children[1:])
        return parent.kind in (Kind.FOR_STMT, Kind.CXX_FOR_RANGE_STMT, Kind.WHILE_STMT) and children[-1] == cursor


# In front of a file whose changes are compiled together: which of them is made, and which of them a program came to.
SWITCH = b"""#ifndef AFFERENT_CHANGES
#define AFFERENT_CHANGES
#include <atomic>
#include <cstdio>
#include <cstdlib>
namespace afferent_changes {
inline const int made = [] { const char* n = std::getenv("AFFERENT_CHANGE"); return n ? std::atoi(n) : 0; }();
inline const char* const log = std::getenv("AFFERENT_CHANGES_SEEN");
inline constinit std::atomic<bool> seen[%d]{};
inline const struct Teller {
    ~Teller() {
        std::FILE* file = log ? std::fopen(log, "a") : nullptr;
        if (!file) return;
        for (int n = 0; n < %d; ++n) if (seen[n]) std::fprintf(file, "%%d\\n", n);
        std::fclose(file);
    }
} teller;
inline bool is_made(int n) {
    seen[n].store(true, std::memory_order_relaxed);
    return made == n;
}
}
#endif
#line 1
"""


def switched(text, changes, highest):
    """The text with all these changes, each of which is made where AFFERENT_CHANGE is its number; no file's is higher
    than `highest`."""
    wholes = collections.defaultdict(list)
    keywords = {}
    for number, change in changes.items():
        wholes[change.whole].append((number, change))
        if isinstance(change.context, tuple):
            keywords[change.context[:2]] = change.context[2]

    def rendered(begin, end, left):
        out, at = b"", begin
        while left and left[0][0] < end:
            whole = left.pop(0)
            inner = []
            while left and left[0][1] <= whole[1]:
                inner.append(left.pop(0))
            out += text[at:whole[0]] + (keywords[whole] if whole in keywords else chosen(whole, inner))
            at = whole[1]
        return out + text[at:end]

    def chosen(whole, inner):
        begin, end = whole
        cast = b""  # so that all arms have one type
        if any(change.what.startswith("a condition") for _, change in wholes[whole]):
            cast = b"bool"
        if any(change.new == "(void)0" for _, change in wholes[whole]):
            cast = b"(void)"
        arms = b""
        for number, change in wholes[whole]:
            made = text[begin:change.begin] + change.new.encode() + text[change.end:end]
            # No line ends: what follows stays in its line.
            made = b"(void)0" if change.new == "(void)0" else cast + b"(" + made.replace(b"\n", b" ") + b")"
            runs = b"!__builtin_is_constant_evaluated() && " if change.context == "constexpr" else b""
            arms += b"%s::afferent_changes::is_made(%d) ? %s : " % (runs, number, made)
        return b"(" + arms + cast + b"(" + rendered(begin, end, inner) + b"))"

    outermost_first = sorted([*wholes, *keywords], key=lambda span: (span[0], -span[1]))
    return SWITCH % (highest + 1, highest + 1) + rendered(0, len(text), outermost_first)


def changes_of(path, arguments):
    """All that can be changed in a file, in a fixed order."""
    return sorted(Tree(path, arguments).changes.values(), key=lambda change: change[2:5])


def run(command, **options):
    return subprocess.run(command, check=True, capture_output=True, text=True, **options).stdout


def copy_tree():
    """Makes the copy what the tree is now, and leaves alone what is the same, so that it need not be rebuilt."""
    listed = run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT).split("\0")
    wanted = {name for name in listed if name and (ROOT / name).is_file()}
    for name in wanted:
        source, target = ROOT / name, COPY / name
        if not target.exists() or target.read_bytes() != source.read_bytes():
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, target)
    for folder, folders, files in os.walk(COPY):
        at = pathlib.Path(folder).relative_to(COPY)
        if str(at) == ".":
            folders[:] = [f for f in folders if f != "build"]
        for file in files:
            if str(at / file) not in wanted:
                (COPY / at / file).unlink()


def folder_of(path):
    return next((f for f in sorted(FOLDERS, key=len, reverse=True) if path.startswith(f + "/")), None)


def tests_of(folder):
    return folder.replace("/", "_") + "_tests"


def changed_lines(commit):
    """path -> lines that differ from the commit, also where they are not committed yet."""
    lines = collections.defaultdict(set)
    path = None
    for row in run(["git", "diff", "-U0", commit, "--", *FOLDERS], cwd=ROOT).splitlines():
        if row.startswith("+++ "):
            path = row[6:]
        elif match := re.match(r"@@ -\S+ \+(\d+)(?:,(\d+))? @@", row):
            first = int(match.group(1))
            lines[path] |= set(range(first, first + int(match.group(2) or 1)))
    return lines


class Mutator:
    def __init__(self, options):
        self.options = options
        self.learned = {}  # tests -> test -> how long it takes as the tree is, and the changes that it comes to
        self.learning = threading.Lock()
        self.children = set()
        self.ending = False
        self.originals = {}  # path -> text

    # What there is to change

    def choose_files(self):
        wanted = {}
        since = changed_lines(self.options.since) if self.options.since else None
        for path in sorted(run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT).split()):
            folder = folder_of(path)
            if folder is None or not path.endswith((".cpp", ".hpp")) or not (ROOT / path).is_file():
                continue
            if since is not None and path not in since:
                continue
            globs = self.options.files
            if globs and not any(fnmatch.fnmatch(path, g) or path.startswith(g.rstrip("/") + "/") for g in globs):
                continue
            if self.options.again and not any(change.startswith(path + ":") for change in self.options.again):
                continue
            wanted[path] = since[path] if since is not None else None
        return wanted

    def arguments_for(self, path):
        """How clang compiles the file: as another source of its folder is compiled, or of its tests."""
        units = json.loads((BUILD / "compile_commands.json").read_text())
        near = [u for u in units if f" -o {folder_of(path)}/CMakeFiles/" in u["command"]] or \
            [u for u in units if f"tests/CMakeFiles/{tests_of(folder_of(path))}.dir" in u["command"]]
        words = near[0]["command"].split()
        kept, skip = [], False
        for word in words:
            if skip or re.match(r"-(D|I|isystem|std)", word) or word == "-isystem":
                kept.append(word)
                skip = word == "-isystem" and not skip
        return ["-x", "c++", "-w", *kept]

    def draw(self, files):
        """Changes: files by their length, and within one all alike."""
        dice = random.Random(self.options.seed)
        wanted = None if self.options.count == "all" or self.options.again else int(self.options.count)
        weights = [len((ROOT / path).read_bytes()) for path in files]
        chosen = list(files) if wanted is None else dice.choices(list(files), weights, k=wanted)
        with concurrent.futures.ProcessPoolExecutor() as pool:
            paths = sorted(set(chosen))
            found = pool.map(changes_of, paths, map(self.arguments_for, paths))
            left = {path: [c for c in changes if (self.options.kind or "") in c.what
                           and (files[path] is None or c.line in files[path])] for path, changes in zip(paths, found)}
        if self.options.again:
            return nearest(self.options.again, [change for path in files for change in left[path]])
        if wanted is None:
            return [change for path in files for change in left[path]]
        drawn = []
        for path in chosen:
            if left[path]:
                drawn.append(left[path].pop(dice.randrange(len(left[path]))))
        return drawn

    # Building and testing

    def configure(self):
        # All is compiled once: -O1 takes less time in all. A constant that has become a choice may narrow. With
        # assertions, reading an empty optional or container crashes instead of returning whatever is in memory.
        launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
        self.checked(["cmake", "--preset", "release", "-DAFFERENT_MPI=ON", "-DCMAKE_CXX_FLAGS=-Wno-narrowing",
                      "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -D_GLIBCXX_ASSERTIONS",
                      "-DCMAKE_GTEST_DISCOVER_TESTS_DISCOVERY_MODE=PRE_TEST", *launcher])

    def build(self, targets):
        """What the compiler says, if it fails."""
        status, said = self.call(["cmake", "--build", str(BUILD), "--target", *targets, "--", "-k", "0"], 7200)
        return None if status == 0 else said

    def checked(self, command):
        status, output = self.call(command, 7200)
        if status != 0:
            print(output[-4000:], file=sys.stderr)
            sys.exit(2)
        return output

    def call(self, command, limit, cwd=COPY, environment=None):
        """The status (None: it hung) and what was said. With children, all of which end with it."""
        if self.ending:
            raise KeyboardInterrupt
        with tempfile.TemporaryFile() as said:
            child = subprocess.Popen(command, cwd=cwd, stdin=subprocess.DEVNULL, stdout=said, stderr=subprocess.STDOUT,
                                     start_new_session=True, env={**os.environ, **(environment or {})})
            self.children.add(child)
            try:
                status = child.wait(limit)
            except subprocess.TimeoutExpired:
                status = None
            finally:
                self.end(child)
            said.seek(0)
            return status, said.read().decode(errors="replace")

    def end(self, child):
        try:
            os.killpg(child.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        child.wait()
        self.children.discard(child)

    def end_all(self):
        self.ending = True
        for child in list(self.children):
            self.end(child)

    def program(self, tests):
        return BUILD / "tests" / tests

    def near(self, path):
        """Patterns of the suites of tests that are called like the file, that include its header, and that include a
        header of its folder that includes it."""
        header = f"afferent/{path.rsplit('.', 1)[0]}.hpp"
        around = {f"afferent/{h.relative_to(COPY)}" for h in (COPY / path).parent.glob("*.hpp") if header in h.read_text()}
        suites = [set(), set(), set()]
        for file in (COPY / "tests" / folder_of(path)).rglob("*_test.cpp"):
            text = file.read_text()
            own = set(re.findall(r"^(?:TYPED_)?TEST(?:_F|_P)?\((\w+),", text, re.M))
            if file.stem == pathlib.Path(path).stem + "_test":
                suites[0] |= own
            elif header in text:
                suites[1] |= own
            elif any(h in text for h in around):
                suites[2] |= own
        return [re.compile(r"(\w+/)?(" + "|".join(sorted(of)) + r")[./]") for of in suites if of]

    def learn(self, tests):
        """The tests of a program, without those that fail or are slow as the tree is."""
        with self.learning:
            if tests not in self.learned:
                names, suite = [], ""
                for row in self.checked([str(self.program(tests)), "--gtest_list_tests"]).splitlines():
                    word = row.split("#")[0].strip()
                    if not row.startswith(" "):
                        suite = word
                    elif not any(fnmatch.fnmatch(suite + word, pattern) for pattern in self.options.without):
                        names.append(suite + word)
                print(f"{tests}: each of {len(names)} tests is run once, without any change", file=sys.stderr)
                with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
                    found = pool.map(lambda name: self.tried_alone(tests, name), names)
                    self.learned[tests] = {name: one for name, one in zip(names, found) if one}
            return self.learned[tests]

    def tried_alone(self, tests, name):
        """How long a test takes as the tree is, and the changes that it comes to; nothing where it is left out."""
        with tempfile.NamedTemporaryFile("r") as seen:
            begin = time.monotonic()
            status, _ = self.call([str(self.program(tests)), "--gtest_brief=1", f"--gtest_filter={name}"],
                                  self.options.slowest, self.program(tests).parent,
                                  {"AFFERENT_CHANGE": "0", "AFFERENT_CHANGES_SEEN": seen.name})
            if status != 0:
                why = f"takes more than {self.options.slowest:g} s" if status is None else "fails without any change"
                print(f"left out, since it {why}: {name}", file=sys.stderr)
                return None
            return time.monotonic() - begin, {int(number) for number in seen}

    def turns(self, tests, path, number):
        """The tests of a program that come to the change, in the order in which they run: those near the file first."""
        left = [name for name, (_, seen) in self.learn(tests).items() if number is None or number in seen]
        turns = []
        near = self.near(path) if tests == tests_of(folder_of(path)) else []
        for pattern in near:
            turns.append([name for name in left if pattern.match(name)])
            left = [name for name in left if not pattern.match(name)]
        if not near or self.options.tests != "near":
            turns.append(left)
        return [turn for turn in turns if turn]

    def fails(self, tests, names, number):
        """The first of these tests that fails; `hangs`, `crashes`, or nothing."""
        limit = 30 + 6 * sum(self.learned[tests][name][0] for name in names)
        # Too many for one argument become a file of flags.
        with tempfile.NamedTemporaryFile("w", suffix=".flags") as flags:
            flags.write("--gtest_brief=1\n--gtest_fail_fast\n--gtest_filter=" + ":".join(names) + "\n")
            flags.flush()
            status, output = self.call([str(self.program(tests)), f"--gtest_flagfile={flags.name}"], limit,
                                       self.program(tests).parent, {"AFFERENT_CHANGE": str(number or 0)})
        if status == 0:
            return None
        failed = re.findall(r"^\[  FAILED  \] ([\w/]+\.[\w/]+)", output, re.M)
        return failed[0] if failed else "hangs" if status is None else "crashes"

    def notices(self, tests, path, number):
        """What of these tests notices the change of that number (None: it is made for good), if anything."""
        for names in self.turns(tests, path, number):
            found = self.fails(tests, names, number)
            again = [found] if found in names else names
            if found and self.fails(tests, again, number) and (number is None or not self.fails(tests, again, 0)):
                return found
        return None

    def others(self, path):
        """The tests of other folders that link the file's component; a header counts as one of its folder's first."""
        if self.options.tests != "all":
            return []
        own = tests_of(folder_of(path))
        units = json.loads((BUILD / "compile_commands.json").read_text())
        target = next((m for u in units if (m := re.search(rf" -o ({folder_of(path)})/CMakeFiles/(\w+)\.dir/", u["command"]))),
                      None)
        if not target:
            return [t + "_tests" for t in TESTED if t + "_tests" != own]
        linked = run(["ninja", "-C", str(BUILD), "-t", "query", f"{target.group(1)}/lib{target.group(2)}.a"]).split()
        return [t + "_tests" for t in TESTED if f"tests/{t}_tests" in linked and t + "_tests" != own]

    def programs(self, path):
        return [tests_of(folder_of(path)), *self.others(path)]

    def outcome_in_folder(self, number, change):
        found = self.notices(tests_of(folder_of(change.path)), change.path, number)
        return ("noticed", found) if found else ("survived", None)

    def outcome_elsewhere(self, number, change):
        for tests in self.others(change.path):
            if found := self.notices(tests, change.path, number):
                return "noticed elsewhere", f"{tests}: {found}"
        return "survived", None

    def outcomes(self, outcome, changes):
        """Tries changes that are compiled together, as many at once as there are processors."""
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            trials = {pool.submit(outcome, n, c): n for n, c in changes.items()}
            try:
                for trial in concurrent.futures.as_completed(trials):
                    yield trials[trial], *trial.result()
            except KeyboardInterrupt:
                self.end_all()
                pool.shutdown(cancel_futures=True)
                raise

    def compile_together(self, changes):
        """The numbers of the changes that are now compiled, each behind its switch."""
        # Where C++20 turns the operands of an == around, clang has the end of the expression before its begin.
        kept = {n: c for n, c in changes.items() if not c.old.startswith("{") and c.whole[0] < c.whole[1]}
        self.originals = {c.path: (COPY / c.path).read_bytes() for c in changes.values()}
        originals = self.originals
        targets = sorted({t for c in kept.values() for t in self.programs(c.path)})
        while True:
            for path, text in originals.items():
                of = {n: c for n, c in kept.items() if c.path == path}
                made = switched(text, of, max(changes)) if of else text
                if (COPY / path).read_bytes() != made:
                    (COPY / path).write_bytes(made)
            said = self.build(targets)
            if said is None:
                return kept
            wrong = {(os.path.relpath(os.path.realpath(BUILD / path), COPY), int(line))
                     for path, line in re.findall(r"([\w./]+):(\d+):\d+: (?:error|  required)", said)}
            places = {n: {(c.path, originals[c.path].count(b"\n", 0, at) + 1) for at in range(*c.whole)}
                      for n, c in kept.items()}
            unexplained = wrong - set().union(*places.values())
            # A constant that is none any more fails where it is used.
            fewer = {n: c for n, c in kept.items() if not wrong & places[n] and not
                     (isinstance(c.context, tuple) and (c.path.endswith(".hpp") and unexplained or
                                                        c.path in {path for path, _ in unexplained}))}
            if len(fewer) == len(kept):
                print(said[-4000:], file=sys.stderr)
                sys.exit(2)
            kept = fewer

    def made_alone(self, change, tried):
        """What comes of a change by itself. Where it was `tried` behind its switch, only whether it changes anything."""
        file, text = COPY / change.path, self.originals[change.path]
        compiled = self.compiled_of(change.path)

        def built(text):
            file.write_bytes(text)
            return not self.build(compiled) and [(BUILD / target).read_bytes() for target in compiled]

        before = built(text)
        try:
            after = built(text[:change.begin] + change.new.encode() + text[change.end:])
            if not after:
                return "does not compile", None
            if after == before:
                return "changes nothing", None
            if tried:
                return "survived", None
            for outcome, programs in ((self.outcome_in_folder, [tests_of(folder_of(change.path))]),
                                      (self.outcome_elsewhere, self.others(change.path))):
                if self.build(programs):
                    return "does not compile", None
                found = outcome(None, change)
                if found[0] != "survived":
                    break
            return found
        finally:
            file.write_bytes(text)

    def compiled_of(self, path):
        """What a change of a file changes: its own object, or the tests of its folder where it is a header."""
        units = json.loads((BUILD / "compile_commands.json").read_text())
        own = next((u for u in units if u["file"] == str(COPY / path)), None)
        return [re.search(r" -o (\S+)", own["command"]).group(1)] if own else ["tests/" + tests_of(folder_of(path))]

    def run(self):
        copy_tree()
        files = self.choose_files()
        if not files:
            print("nothing there to change", file=sys.stderr)
            return 2
        self.configure()
        self.build(["afferent_proto"])
        changes = dict(enumerate(self.draw(files), 1))
        if self.options.list:
            print("\n".join(describe(change) for change in changes.values()))
            return 0
        counts, kept = collections.Counter(), []

        def report(change, outcome, by):
            counts[outcome] += 1
            said = f"{describe(change)}: {outcome}{' by ' + by if by else ''}"
            print(said, flush=True)
            if outcome in ("survived", "noticed elsewhere"):
                kept.append(said)

        try:
            compiled = together = self.compile_together(changes)
            print(f"{len(together)} of {len(changes)} changes are compiled together", flush=True)
            for outcome in (self.outcome_in_folder, self.outcome_elsewhere):
                tried, together = together, {}
                for number, result, by in self.outcomes(outcome, tried):
                    if result == "survived":
                        together[number] = changes[number]
                        if outcome == self.outcome_in_folder:
                            print(f"{describe(changes[number])}: not noticed so far", flush=True)
                    else:
                        report(changes[number], result, by)
            # A switch does nothing to what has been evaluated by the compiler.
            for number, change in together.items():
                report(change, *self.made_alone(change, change.context != "constexpr"))
            for number, change in changes.items():
                if number not in compiled:
                    report(change, *self.made_alone(change, False))
        finally:
            self.end_all()
            print_summary(counts, kept, len(changes) - sum(counts.values()))
        return 1 if counts["survived"] else 0


def describe(change):
    def shortened(text):
        words = re.sub(r"\s+", " ", text)
        return words if len(words) < 90 else words[:60] + " ... " + words[-24:]
    return f"{change.path}:{change.line}: {change.what}: `{shortened(change.old)}` -> `{shortened(change.new)}`"


def unnoticed(text):
    """The changes that a run has printed as not noticed."""
    return re.findall(r"^(\S+:\d+: .*`): (?:not noticed so far|survived)$", text, re.M)


def timeless(described):
    """Without the line, which may have moved since."""
    return re.sub(r"^(\S+?):\d+:", r"\1:", described)


def nearest(described, changes):
    """Of the changes that read alike, for each that is described the one that is nearest to its line."""
    alike, found = collections.defaultdict(list), []
    for change in changes:
        alike[timeless(describe(change))].append(change)
    for one in sorted(set(described)):
        line = int(one.split(":")[1])
        if left := alike[timeless(one)]:
            found.append(min(left, key=lambda change: abs(change.line - line)))
            left.remove(found[-1])
    return found


def print_summary(counts, kept, left):
    behaviour = counts["noticed"] + counts["noticed elsewhere"] + counts["survived"]
    if not behaviour and not counts:
        return
    print()
    for said in kept:
        print(said)
    print(f"{behaviour} changes of behaviour: {counts['noticed']} noticed by tests of their folder, "
          f"{counts['noticed elsewhere']} elsewhere, {counts['survived']} survived; "
          f"{counts['changes nothing']} changed nothing, {counts['does not compile']} did not compile"
          + (f"; {left} were not tried to their end" if left else ""))


def main():
    parser = argparse.ArgumentParser(prog="scripts/mutate.sh", description=__doc__.split("\n\n")[0])
    parser.add_argument("--since", metavar="COMMIT", help="only lines that differ from that commit")
    parser.add_argument("--files", metavar="GLOB", action="append", default=[], help="only files that match")
    parser.add_argument("--count", metavar="N", default="20", help="how many changes (default 20), or `all`")
    parser.add_argument("--seed", metavar="S", type=int, default=1, help="draws other changes (default 1)")
    parser.add_argument("--tests", choices=("near", "folder", "all"), default="all",
                        help="near: those that include the file's header, or one that does; folder: its folder's; "
                             "default all")
    parser.add_argument("--without", metavar="TEST", action="append", default=[],
                        help="a test to leave out because it is slow, as `HandNode.KeepsTo*`")
    parser.add_argument("--slowest", metavar="S", type=float, default=10,
                        help="leave out tests that take longer, in seconds (default 10): what they alone notice wants a "
                             "quick test")
    parser.add_argument("--kind", metavar="WORD", help="only changes of which this is said, as `condition`")
    parser.add_argument("--again", metavar="FILE", type=lambda file: unnoticed(pathlib.Path(file).read_text()), default=[],
                        help="only changes that an earlier run, whose output is in FILE, printed as not noticed")
    parser.add_argument("--list", action="store_true", help="list the changes, and try none")
    options = parser.parse_args()
    if options.count != "all" and not options.count.isdigit():
        parser.error("--count takes a number, or `all`")
    # What has been begun is ended and undone; in the background of a script SIGINT would be ignored.
    for name in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(name, signal.default_int_handler)
    COPY.mkdir(parents=True, exist_ok=True)
    lock = open(COPY.with_suffix(".lock"), "w")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        print("it is running already", file=sys.stderr)
        return 2
    try:
        return Mutator(options).run()
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
