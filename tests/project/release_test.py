"""What scripts/cut_release.py makes of a tree's version and changelog. Arguments: the source folder."""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(sys.argv.pop(1))
NAMES = ("CMakeLists.txt", "pyproject.toml", "CHANGELOG.md")


class CutRelease(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)
        for name in NAMES:
            shutil.copy(SOURCE / name, self.folder)
        self.write("CHANGELOG.md", "# Changelog\n\n## Unreleased\n\n### Added\n\n- A finger.\n\n## [0.4.0] - 2020-02-02\n\n- Old.\n")

    def write(self, name, text):
        (self.folder / name).write_text(text)

    def text(self, name):
        return (self.folder / name).read_text()

    def cut(self, version):
        return subprocess.run([sys.executable, SOURCE / "scripts/cut_release.py", version, "2021-01-31", self.folder],
                              capture_output=True, text=True)

    def test_sets_the_version_and_dates_the_notes(self):
        self.assertEqual(self.cut("0.5.0").returncode, 0)
        self.assertIn("\n  VERSION 0.5.0\n", self.text("CMakeLists.txt"))
        self.assertIn('\nversion = "0.5.0"\n', self.text("pyproject.toml"))
        self.assertEqual(self.text("CHANGELOG.md"), "# Changelog\n\n## Unreleased\n\n## [0.5.0] - 2021-01-31\n\n### Added\n\n"
                         "- A finger.\n\n## [0.4.0] - 2020-02-02\n\n- Old.\n")

    def assert_refused(self, version, reason):
        before = [self.text(name) for name in NAMES]
        cut = self.cut(version)
        self.assertEqual(cut.returncode, 1)
        self.assertIn(reason, cut.stderr)
        self.assertEqual([self.text(name) for name in NAMES], before)

    def test_refuses_a_version_that_is_no_later(self):
        self.assert_refused("0.4.0", "later than 0.4.0")
        self.assert_refused("0.3.9", "later than 0.4.0")
        self.assert_refused("0.5", "three numbers")

    def test_refuses_a_release_without_notes(self):
        self.write("CHANGELOG.md", "# Changelog\n\n## Unreleased\n\n## [0.4.0] - 2020-02-02\n\n- Old.\n")
        self.assert_refused("0.5.0", "no notes")

    def test_the_tree_has_notes_for_its_next_release(self):
        shutil.copy(SOURCE / "CHANGELOG.md", self.folder)
        self.assertEqual(self.cut("99.0.0").returncode, 0)


unittest.main()
