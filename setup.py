"""Has CMake build and install the package: pyproject.toml says the rest.

AFFERENT_BUILD names a folder that it is built in already, as build/release is after ./demo.sh --python.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import sysconfig
import tempfile

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext


class CMakeBuild(build_ext):
    def run(self):
        source = pathlib.Path(__file__).parent.resolve()
        build = os.environ.get("AFFERENT_BUILD")
        if not build:
            build = str(pathlib.Path(self.build_temp).resolve())
            subprocess.check_call([
                "cmake", "-S", source, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DAFFERENT_PYTHON=ON",
                "-DAFFERENT_BUILD_APPS=ON", "-DAFFERENT_BUILD_TESTS=OFF", f"-DPython3_EXECUTABLE={sys.executable}",
                *os.environ.get("CMAKE_ARGS", "").split()])
        subprocess.check_call(["cmake", "--build", build, "--target", "afferent_python"])
        # Wherever it would be installed, it is found there and put into the wheel.
        with tempfile.TemporaryDirectory() as root:
            subprocess.check_call(["cmake", "--install", build, "--component", "python", "--strip"],
                                  env={**os.environ, "DESTDIR": root})
            (installed,) = pathlib.Path(root).rglob("_afferent.*.so")
            if not installed.name.endswith(sysconfig.get_config_var("EXT_SUFFIX")):
                sys.exit(f"{build} has the module for another interpreter, {installed.name}; this one is {sys.executable}")
            shutil.copytree(installed.parent, pathlib.Path(self.build_lib) / "afferent", dirs_exist_ok=True)


# All files come from CMake; the extension makes the wheel one of this machine.
setup(packages=[], ext_modules=[Extension("afferent._afferent", [])], cmdclass={"build_ext": CMakeBuild})
