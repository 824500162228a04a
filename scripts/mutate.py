#!/usr/bin/env python3
"""Makes small changes to Afferent's code, one at a time, and reports those that no test notices.

A change is drawn from clang's syntax tree, so that it is always made to an expression that the compiler sees. It is
made in a copy of the tree in build/mutate: the tree itself is only read. The copy has a build of its own, in which the
components under test are compiled source by source. All changes of a source are compiled at once, each behind a switch
in the environment; one that does not compile so, or is in a header, recompiles what it reaches. The tests that include
the changed file's header run first, then the rest of the folder's, then those of every other folder that links the
component. A test notices a change if it fails, crashes or hangs twice in a row. A change after which the test program is
the same, bit by bit, changes nothing and is not counted.

Exit status: 0 where every change was noticed, 1 where one survived, 2 where nothing could be tried.
"""

import argparse
import collections
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
SYMMETRIC = ("min", "max", "minmax", "hypot", "midpoint", "gcd", "lcm", "swap", "tie")
NUMBER = re.compile(r"(0[xX][0-9a-fA-F']+|[0-9][0-9']*)([uUlLzZ]*|[a-z]+)|"
                    r"([0-9][0-9']*\.[0-9']*|\.[0-9]+|[0-9]+)([eE][-+]?[0-9]+)?[fFlL]?")

Change = collections.namedtuple("Change", "path line begin end new what old whole")


class Tree:
    """A source file and the changes that can be made to it."""

    def __init__(self, path, arguments):
        self.path = path
        self.text = (COPY / path).read_bytes()
        self.changes = {}
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
                                Change(self.path, line, begin, end, new, what, old, whole or (begin, end)))

    def walk(self, cursor, parent):
        kind = cursor.kind
        # Neither of them is executed.
        if kind in (Kind.STATIC_ASSERT, Kind.ENUM_DECL, Kind.TYPEDEF_DECL, Kind.TYPE_ALIAS_DECL, Kind.USING_DECLARATION,
                    Kind.CONCEPT_DECL if hasattr(Kind, "CONCEPT_DECL") else Kind.STATIC_ASSERT):
            return
        children = [c for c in cursor.get_children()]
        self.operators(cursor, children)
        self.numbers(cursor)
        self.conditions(cursor, children)
        self.calls(cursor, parent)
        for child in children:
            # The condition of a template, and the size of an array, are decided when it is compiled.
            if kind in (Kind.VAR_DECL, Kind.FIELD_DECL) and child.kind == Kind.INTEGER_LITERAL and \
                    "[" in self.source(*self.span(cursor)).split("=")[0]:
                continue
            self.walk(child, cursor)

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
            if "constexpr" in head or begin >= end:
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


# In front of a file whose changes are compiled together: which of them is made.
SWITCH = b"""#include <cstdlib>
static const int made_change = [] { const char* n = std::getenv("AFFERENT_CHANGE"); return n ? std::atoi(n) : 0; }();
#line 1
"""


def switched(text, changes):
    """The text with all these changes, each of which is made where AFFERENT_CHANGE is its number, from 1 on."""
    wholes = collections.defaultdict(list)
    for number, change in enumerate(changes, 1):
        wholes[change.whole].append((number, change))

    def rendered(begin, end, left):
        out, at = b"", begin
        while left and left[0][0] < end:
            whole = left.pop(0)
            inner = []
            while left and left[0][1] <= whole[1]:
                inner.append(left.pop(0))
            out += text[at:whole[0]] + chosen(whole, inner)
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
            arms += b"made_change == %d ? %s : " % (number, made)
        return b"(" + arms + cast + b"(" + rendered(begin, end, inner) + b"))"

    outermost_first = sorted(wholes, key=lambda span: (span[0], -span[1]))
    return SWITCH + rendered(0, len(text), outermost_first)


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
        self.baseline = {}
        self.made = None
        self.child = None

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
            wanted[path] = since[path] if since is not None else None
        return wanted

    def arguments_for(self, path):
        """How clang compiles the file; a header as a source of its folder is compiled."""
        units = json.loads((BUILD / "compile_commands.json").read_text())
        own = [u for u in units if u["file"] == str(COPY / path)]
        near = own or [u for u in units if u["file"].startswith(str(COPY / folder_of(path)) + "/")] or \
            [u for u in units if f"tests/CMakeFiles/{tests_of(folder_of(path))}.dir" in u["command"]]
        words = near[0]["command"].split()
        kept, skip = [], False
        for word in words:
            if skip or re.match(r"-(D|I|isystem|std)", word) or word == "-isystem":
                kept.append(word)
                skip = word == "-isystem" and not skip
        return ["-x", "c++", "-w", *kept]

    def draw(self, files):
        """Changes in the order in which they are tried: files by their length, and within one all alike."""
        wanted = None if self.options.count == "all" else int(self.options.count)
        dice = random.Random(self.options.seed)
        trees = {}

        def changes_of(path):
            if path not in trees:
                found = Tree(path, self.arguments_for(path)).changes.values()
                of = files[path]
                kind = self.options.kind or ""
                trees[path] = sorted((c for c in found if kind in c.what and (of is None or c.line in of)),
                                     key=lambda c: c[2:5])
            return trees[path]

        if wanted is None:
            for path in files:
                yield from changes_of(path)
            return
        weights = {path: len((ROOT / path).read_bytes()) for path in files}
        drawn = set()
        for _ in range(20 * wanted):
            if len(drawn) == wanted or not weights:
                return
            path = dice.choices(list(weights), list(weights.values()))[0]
            left = [c for c in changes_of(path) if c not in drawn]
            if not left:
                del weights[path]
                continue
            change = dice.choice(left)
            drawn.add(change)
            yield change

    # Building and testing

    def configure(self, folders):
        # What has been compiled so once stays so.
        cache = BUILD / "CMakeCache.txt"
        known = re.search(r"^AFFERENT_APART:STRING=(.*)$", cache.read_text(), re.M) if cache.exists() else None
        folders = sorted({*folders, *(known.group(1).split(";") if known else [])} - {""})
        command = ["scripts/build.sh", "release", "-DAFFERENT_MPI=ON", "-DAFFERENT_PYTHON=OFF",
                   "-DCMAKE_GTEST_DISCOVER_TESTS_DISCOVERY_MODE=PRE_TEST", f"-DAFFERENT_APART={';'.join(folders)}"]
        self.checked(command + ["help"])

    def build(self, targets):
        return self.call(["cmake", "--build", str(BUILD), "--target", *targets], 1800)[0] == 0

    def checked(self, command):
        status, output = self.call(command, 7200)
        if status != 0:
            print(output[-4000:], file=sys.stderr)
            sys.exit(2)

    def call(self, command, limit, cwd=COPY, environment=None):
        """The status (None: it hung) and what was said. With children, all of which end with it."""
        with tempfile.TemporaryFile() as said:
            self.child = subprocess.Popen(command, cwd=cwd, stdin=subprocess.DEVNULL, stdout=said,
                                          stderr=subprocess.STDOUT, start_new_session=True,
                                          env={**os.environ, **(environment or {})})
            try:
                status = self.child.wait(limit)
            except subprocess.TimeoutExpired:
                status = None
            finally:
                self.end_child()
            said.seek(0)
            return status, said.read().decode(errors="replace")

    def end_child(self):
        if self.child:
            try:
                os.killpg(self.child.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
            self.child.wait()
            self.child = None

    def program(self, tests):
        return BUILD / "tests" / tests

    def filters_of(self, path):
        """The suites of tests that are called like the file, that include its header, and that include a header of its
        folder that includes it."""
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
        return [":".join(f"{s}.*:{s}/*.*:*/{s}.*" for s in sorted(of)) for of in suites if of]

    def test(self, tests, only, limit, environment=None):
        """The first test that fails, `hangs`, `crashes`, or nothing."""
        with tempfile.TemporaryDirectory() as folder:
            said = str(pathlib.Path(folder) / "said.json")
            command = [str(self.program(tests)), "--gtest_brief=1", "--gtest_fail_fast", f"--gtest_output=json:{said}",
                       f"--gtest_filter={only}"]
            status, output = self.call(command, limit, self.program(tests).parent, environment)
            if status == 0:
                return None
            failed = re.findall(r"^\[  FAILED  \] ([\w/]+\.[\w/]+)", output, re.M)
            begun = re.findall(r"^\[ RUN      \] ([\w/]+\.[\w/]+)", output, re.M)
            return failed[0] if failed else ("hangs" if status is None else "crashes") + \
                (f" in {begun[-1]}" if begun else "")

    def prepare(self, tests, path):
        """The tests on the unchanged code: how long they take, and what they fail anyway."""
        only = ":".join(self.filters_of(path)) if self.options.tests == "near" else ""
        if (tests, only) in self.baseline:
            return self.baseline[tests, only]
        if not self.build([tests]):
            print(f"{tests} cannot be built as the tree is", file=sys.stderr)
            sys.exit(2)
        begin = time.monotonic()
        left_out = list(self.options.without)
        while failed := self.test(tests, self.except_for(left_out, only or "*"), 1800):
            if "." not in failed:
                print(f"{tests} {failed} as the tree is", file=sys.stderr)
                sys.exit(2)
            print(f"left out, since it fails without any change: {failed}", file=sys.stderr)
            left_out.append(failed)
            begin = time.monotonic()
        limit = 20 + 4 * (time.monotonic() - begin)
        known = {"left_out": left_out, "limit": limit, "bytes": self.program(tests).read_bytes()}
        self.baseline[tests, only] = known
        return known

    @staticmethod
    def except_for(left_out, only="*"):
        return only + ("-" + ":".join(left_out) if left_out else "")

    def notices(self, tests, path, known, environment=None):
        """What of these tests notices the change that has been made, if anything."""
        near = self.filters_of(path) if tests == tests_of(folder_of(path)) else []
        for only in near if near and self.options.tests == "near" else [*near, "*"]:
            found = self.test(tests, self.except_for(known["left_out"], only), known["limit"], environment)
            if not found:
                continue
            again = found if re.fullmatch(r"[\w/]+\.[\w/]+", found) else self.except_for(known["left_out"], only)
            if self.test(tests, again, known["limit"], environment):
                return found
        return None

    def others(self, path):
        """The tests of other folders that link the file's component; a header counts as one of its folder's first."""
        if self.options.tests != "all":
            return []
        own = tests_of(folder_of(path))
        units = json.loads((BUILD / "compile_commands.json").read_text())
        near = [u for u in units if u["file"] == str(COPY / path)] or \
            [u for u in units if u["file"].startswith(str(COPY / folder_of(path)) + "/")]
        target = near and re.search(r" -o (\S+)/CMakeFiles/(\w+)\.dir/", near[0]["command"])
        if not target:
            return [t + "_tests" for t in TESTED if t + "_tests" != own]
        linked = run(["ninja", "-C", str(BUILD), "-t", "query", f"{target.group(1)}/lib{target.group(2)}.a"]).split()
        return [t + "_tests" for t in TESTED if f"tests/{t}_tests" in linked and t + "_tests" != own]

    def write(self, path, text):
        file = COPY / path
        if not self.made:
            self.made = (file, file.read_bytes())
        file.write_bytes(text)

    def make(self, change):
        text = self.made[1] if self.made else (COPY / change.path).read_bytes()
        self.write(change.path, text[:change.begin] + change.new.encode() + text[change.end:])

    def undo(self):
        if self.made:
            self.made[0].write_bytes(self.made[1])
            self.made = None

    def compiled_together(self, path, changes):
        """Those of the changes that can be compiled together, which is then done."""
        text = (COPY / path).read_bytes()
        kept = [c for c in changes if not text[c.whole[0]:c.whole[1]].startswith(b"{")]
        for _ in range(8):
            if len(kept) < 2:
                break
            self.write(path, switched(text, kept))
            status, said = self.call(["cmake", "--build", str(BUILD), "--target", tests_of(folder_of(path))], 1800)
            if status == 0:
                return kept
            lines = {int(n) for n in re.findall(re.escape(path) + r":(\d+):\d+: (?:error|  required)", said)}
            spans = [(text.count(b"\n", 0, c.whole[0]) + 1, text.count(b"\n", 0, c.whole[1]) + 1) for c in kept]
            fewer = [c for c, (first, last) in zip(kept, spans) if not any(first <= n <= last for n in lines)]
            if len(fewer) == len(kept):
                break
            kept = fewer
        self.undo()
        return []

    def outcomes(self, path, changes):
        """Tries changes of one file, and yields each with what came of it."""
        folder = folder_of(path)
        own = tests_of(folder)
        self.prepare(own, path)
        left = []
        together = self.compiled_together(path, changes) if path.endswith(".cpp") else []
        try:
            for number, change in enumerate(together, 1):
                with_change = {"AFFERENT_CHANGE": str(number)}
                if found := self.notices(own, path, self.prepare(own, path), with_change):
                    yield change, "noticed", found
                else:
                    left.append(change)
        finally:
            self.undo()
        for change in changes:
            if change in left or change not in together:
                yield change, *self.outcome(change, change in left)

    def outcome(self, change, unnoticed):
        """Of a change by itself; `unnoticed`: the tests of its folder have been run and have not noticed it."""
        own = tests_of(folder_of(change.path))
        known = self.prepare(own, change.path)
        self.make(change)
        try:
            if not self.build([own]):
                return "does not compile", None
            same = self.program(own).read_bytes() == known["bytes"]
            if not same and not unnoticed and (found := self.notices(own, change.path, known)):
                return "noticed", found
            if same and change.path.endswith(".cpp"):
                return "changes nothing", None
        finally:
            self.undo()
        for tests in self.others(change.path):
            known = self.prepare(tests, change.path)
            self.make(change)
            try:
                if not self.build([tests]):
                    return "does not compile", None
                if self.program(tests).read_bytes() == known["bytes"]:
                    continue
                same = False
                if found := self.notices(tests, change.path, known):
                    return "noticed elsewhere", f"{tests}: {found}"
            finally:
                self.undo()
        return ("changes nothing" if same else "survived"), None

    def run(self):
        copy_tree()
        files = self.choose_files()
        if not files:
            print("nothing there to change", file=sys.stderr)
            return 2
        self.configure(sorted({folder_of(path) for path in files}))
        self.build(["afferent_proto"])
        counts = collections.Counter()
        kept = []
        try:
            drawn = collections.defaultdict(list)
            for change in self.draw(files):
                drawn[change.path].append(change)
                if self.options.list:
                    print(describe(change))
            for path, changes in () if self.options.list else drawn.items():
                begin = time.monotonic()
                for change, outcome, by in self.outcomes(path, changes):
                    counts[outcome] += 1
                    said = f"{describe(change)}: {outcome}{' by ' + by if by else ''}"
                    print(f"{said} ({time.monotonic() - begin:.0f} s)", flush=True)
                    begin = time.monotonic()
                    if outcome in ("survived", "noticed elsewhere"):
                        kept.append(said)
        finally:
            self.undo()
            self.end_child()
            print_summary(counts, kept)
        return 1 if counts["survived"] else 0


def describe(change):
    def shortened(text):
        words = re.sub(r"\s+", " ", text)
        return words if len(words) < 90 else words[:60] + " ... " + words[-24:]
    return f"{change.path}:{change.line}: {change.what}: `{shortened(change.old)}` -> `{shortened(change.new)}`"


def print_summary(counts, kept):
    behaviour = counts["noticed"] + counts["noticed elsewhere"] + counts["survived"]
    if not behaviour and not counts:
        return
    print()
    for said in kept:
        print(said)
    print(f"{behaviour} changes of behaviour: {counts['noticed']} noticed by tests of their folder, "
          f"{counts['noticed elsewhere']} elsewhere, {counts['survived']} survived; "
          f"{counts['changes nothing']} changed nothing, {counts['does not compile']} did not compile")


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
    parser.add_argument("--kind", metavar="WORD", help="only changes of which this is said, as `condition`")
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
