"""A wheel of this build: it holds the library, links what Debian 12 has, and works where nothing else of Afferent is."""
import os
import pathlib
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import unittest
import zipfile

import afferent
from afferent import _libraries

PROJECT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ["AFFERENT_PROGRAM"]).resolve().parents[1]
# Every Debian has these.
ALWAYS = {"libc6", "libgcc-s1"}
TRIED = """
import sys, numpy, afferent
assert afferent.__file__.startswith(sys.argv[1]), afferent.__file__
scans = afferent.Scene(patches=[dict(name="tip", elements=2)], source=dict(table=dict(path=sys.argv[3], column=["force_n"])))
print(len(afferent.run(sys.argv[2])), afferent.run(scans).summary["samples"])
"""


def run(*command, **told):
    return subprocess.run([*map(str, command)], check=True, text=True, stdout=subprocess.PIPE, **told).stdout


class WheelTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(holder.cleanup)
        cls.folder = pathlib.Path(holder.name)
        # A copy of what pip reads, so that it leaves nothing in the tree.
        source = cls.folder / "source"
        source.mkdir()
        for name in ("setup.py", "pyproject.toml", "LICENSE"):
            shutil.copy(PROJECT / name, source)
        run(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-build-isolation", "--no-deps", "--no-index",
            "--wheel-dir", cls.folder, source, env={**os.environ, "AFFERENT_BUILD": str(BUILD)})
        (cls.wheel,) = cls.folder.glob("*.whl")
        with zipfile.ZipFile(cls.wheel) as wheel:
            wheel.extractall(cls.folder / "unpacked")
        cls.package = cls.folder / "unpacked/afferent"

    def linked(self):
        return [next(self.package.glob("_afferent.*.so")), self.package / "afferent-hdf5"]

    def test_holds_the_whole_package(self):
        ours = {file.name for file in (PROJECT / "python/afferent").iterdir() if file.name != "__pycache__"}
        linked = {file.name for file in self.linked()}
        self.assertEqual({file.name for file in self.package.iterdir()}, ours | linked)

    def test_links_what_debian_has_and_says_what(self):
        packages = set()
        for file in self.linked():
            dynamic = run("readelf", "--dynamic", "--wide", file)
            self.assertNotIn("RUNPATH", dynamic)
            self.assertNotIn("RPATH", dynamic)
            for line in dynamic.splitlines():
                if "(NEEDED)" not in line:
                    continue
                library = line.split("[")[1].rstrip("]")
                if library.startswith("libafferent"):
                    self.fail(f"{library} is not in the wheel")
                found = run("dpkg-query", "--search", f"*/lib/{sysconfig.get_config_var('MULTIARCH')}/{library}")
                packages.add(found.split(":")[0])
        self.assertEqual(packages - ALWAYS, set(_libraries.PACKAGES.split()))
        self.assertIn(f"apt-get install {_libraries.PACKAGES}", (PROJECT / "docs/python.md").read_text())

    def test_says_what_to_install_where_a_library_is_missing(self):
        lacking = self.folder / "lacking"
        shutil.copytree(self.package, lacking / "afferent")
        compiled = next((lacking / "afferent").glob("_afferent.*.so"))
        compiled.write_bytes(compiled.read_bytes().replace(b"libcsv.so.3", b"libnot.so.3"))
        done = subprocess.run([sys.executable, "-c", "import afferent"], capture_output=True, text=True,
                              env={"PYTHONPATH": str(lacking)})
        self.assertIn("libnot.so.3: cannot open shared object file: No such file or directory. "
                      f"On Debian 12: apt-get install {_libraries.PACKAGES}", done.stderr)

    def test_works_in_an_environment_of_its_own(self):
        venv = self.folder / "venv"
        # With NumPy, which is Debian's.
        run(sys.executable, "-m", "venv", "--system-site-packages", venv)
        clean = {"PATH": "/usr/bin:/bin"}
        run(venv / "bin/pip", "install", "--quiet", "--no-index", "--no-deps", "--force-reinstall", self.wheel, env=clean)
        table = self.folder / "forces.h5"
        import h5py

        with h5py.File(table, "w") as file:
            file["force_n"] = [[0.5, 1.0]] * 40
            file["force_n"].attrs["rate_hz"] = 200.0
        grasp = PROJECT / "examples/grasp.txtpb"
        said = run(venv / "bin/python", "-c", TRIED, venv, grasp, table, env=clean, cwd=self.folder)
        self.assertEqual(said, f"{len(afferent.run(grasp))} 80\n")


if __name__ == "__main__":
    try:
        import h5py  # noqa: F401
        import setuptools  # noqa: F401
        import venv  # noqa: F401
        import wheel  # noqa: F401
    except ImportError as error:
        print(f"{error}: Debian has python3-h5py, python3-pip, python3-venv and python3-wheel")
        sys.exit(77)
    unittest.main()
