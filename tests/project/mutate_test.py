"""What scripts/mutate.py changes, and that changes which are compiled together are those that are made one by one.
Skipped (77) without python3-clang."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
sys.dont_write_bytecode = True
try:
    import mutate
except ImportError:
    sys.exit(77)

SOURCE = b"""#include <cstdio>
static int total;
void add(int value, int times) { total += value * times; }
int limited(int value, int most) {
    if (value < 0 || value > most) return -1;
    add(value, 3);
    return most - value;
}
int main() {
    for (int value = -1; value <= 6; ++value) std::printf("%d ", limited(value, 5));
    std::printf("%d", total);
}
"""


class Changes(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        mutate.COPY = pathlib.Path(folder.name).resolve()
        (mutate.COPY / "a.cpp").write_bytes(SOURCE)
        self.changes = list(mutate.Tree("a.cpp", ["-x", "c++", "-std=c++20"]).changes.values())

    def program(self, text):
        source, program = mutate.COPY / "b.cpp", mutate.COPY / "b"
        source.write_bytes(text)
        subprocess.run(["c++", "-std=c++20", "-w", "-O0", "-o", program, source], check=True)
        return program

    def said(self, program, number=0, **environment):
        return subprocess.run([program], env={"AFFERENT_CHANGE": str(number), **environment}, capture_output=True,
                              timeout=10).stdout

    def test_are_of_every_kind(self):
        found = {(c.line, c.what, c.old, c.new) for c in self.changes}
        for expected in ((3, "a sign", "*", "/"), (3, "an assignment left out", "total += value * times", "(void)0"),
                         (5, "a comparison's edge", "<", "<="), (5, "a comparison's edge", ">", ">="),
                         (5, "a condition dropped", "value < 0", "false"),
                         (5, "a condition turned", "value < 0 || value > most", "!(value < 0 || value > most)"),
                         (5, "a constant", "0", "1"), (5, "a sign dropped", "-", ""),
                         (6, "a call left out", "add(value, 3)", "(void)0"),
                         (6, "arguments swapped", "value, 3", "3, value"), (7, "a sign", "-", "+")):
            self.assertIn(expected, found)

    def test_compiled_together_are_those_made_one_by_one(self):
        changes = dict(enumerate((c for c in self.changes if c.line in (5, 6)), 1))
        together = self.program(mutate.switched(SOURCE, changes, len(changes))).rename(mutate.COPY / "together")
        self.assertEqual(self.said(together), b"-1 5 4 3 2 1 0 -1 45")
        for number, change in changes.items():
            alone = self.program(SOURCE[:change.begin] + change.new.encode() + SOURCE[change.end:])
            self.assertEqual(self.said(together, number), self.said(alone), change)

    def test_are_told_by_who_comes_to_them(self):
        source = SOURCE.replace(b"value <= 6", b"value <= -1")  # which is limited before the call in line 6
        (mutate.COPY / "a.cpp").write_bytes(source)
        changes = dict(enumerate(mutate.changes_of("a.cpp", ["-x", "c++", "-std=c++20"]), 1))
        seen = mutate.COPY / "seen"
        self.said(self.program(mutate.switched(source, changes, len(changes))), AFFERENT_CHANGES_SEEN=str(seen))
        lines = {changes[int(number)].line for number in seen.read_text().split()}
        self.assertIn(5, lines)
        self.assertFalse(lines & {3, 6})

    def test_leave_the_sizes_of_arrays(self):
        source = b"constexpr int most = 2;\nint sum(const int (&of)[most + 1][most]);\n" \
                 b"int first() {\n    int all[most + 1][most] = {{3}};\n    return sum(all) + all[0][1];\n}\n"
        (mutate.COPY / "a.cpp").write_bytes(source)
        changes = mutate.changes_of("a.cpp", ["-x", "c++", "-std=c++20"])
        self.assertFalse([c for c in changes if c.line in (2, 4) and c.old != "3"])
        self.assertTrue({("0", "1"), ("1", "2")} <= {(c.old, c.new) for c in changes if c.line == 5})

    def test_not_noticed_are_found_again_wherever_their_line_is(self):
        tried = [change for change in self.changes if change.line == 6]
        said = "".join(f"{mutate.describe(change)}: {outcome}\n" for change, outcome in
                       zip(tried, ("not noticed so far", "survived", "noticed by Any.Test")))
        moved = [change._replace(line=change.line + 20) for change in self.changes]
        further = [change._replace(line=change.line + 30) for change in self.changes]
        found = mutate.nearest(mutate.unnoticed(said), further + moved)
        self.assertEqual(sorted(found), sorted(change._replace(line=26) for change in tried[:2]))


if __name__ == "__main__":
    unittest.main()
