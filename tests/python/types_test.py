"""The stubs say what the compiled part has, and the package and the examples fit their types."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import afferent

PROJECT = pathlib.Path(__file__).resolve().parents[2]
PACKAGES = pathlib.Path(afferent.__file__).absolute().parents[1]
WRONG = """
import afferent
afferent.Scene(decoder="fliter")
afferent.Scene(patches=[dict(name="thumb", elements="three")])
afferent.Scene(patches=[{"elments": 3}])
afferent.run(afferent.Scene(), unit="pounds")
"""


class TypesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        # Of numpy, which all runs of mypy read.
        holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(holder.cleanup)
        cls.cache = holder.name

    def run_quietly(self, *command):
        return subprocess.run([*map(str, command)], capture_output=True, text=True, cwd=self.cache,
                              env={**os.environ, "MYPYPATH": str(PACKAGES), "MYPY_CACHE_DIR": self.cache})

    def test_stubs_are_those_of_the_compiled_part(self):
        done = self.run_quietly(shutil.which("stubtest", path="/usr/bin:" + os.environ["PATH"]), "afferent._afferent",
                                "--allowlist", PROJECT / "tests/python/stubtest_allowlist.txt",
                                "--mypy-config-file", PROJECT / "pyproject.toml")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_version_is_the_library_s(self):
        self.assertIn(f'\nversion = "{afferent.__version__}"\n', (PROJECT / "pyproject.toml").read_text())

    def mypy(self, *arguments):
        return self.run_quietly(sys.executable, "-m", "mypy", "--config-file", PROJECT / "pyproject.toml", *arguments)

    def test_the_package_and_the_examples_fit(self):
        done = self.mypy("-p", "afferent")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        done = self.mypy(*sorted((PROJECT / "examples/python").glob("*.py")))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_wrong_fields_are_found_before_a_run(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "wrong.py"
            file.write_text(WRONG)
            found = self.mypy(file).stdout
        for line in (3, 4, 5, 6):
            self.assertIn(f"wrong.py:{line}: error", found)


if __name__ == "__main__":
    if not shutil.which("stubtest", path="/usr/bin:" + os.environ["PATH"]):
        print("mypy, with its stubtest, is not installed")
        sys.exit(77)
    unittest.main()
