"""Has CMake build and install the package: pyproject.toml says the rest."""
import os
import pathlib
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext


class CMakeBuild(build_ext):
    def run(self):
        source = pathlib.Path(__file__).parent.resolve()
        build = pathlib.Path(self.build_temp).resolve()
        destination = pathlib.Path(self.build_lib).resolve()
        subprocess.check_call([
            "cmake", "-S", source, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DAFFERENT_PYTHON=ON",
            "-DAFFERENT_BUILD_APPS=ON", "-DAFFERENT_BUILD_TESTS=OFF", f"-DPython3_EXECUTABLE={sys.executable}",
            f"-DAFFERENT_PYTHON_DESTINATION={destination}", *os.environ.get("CMAKE_ARGS", "").split()])
        subprocess.check_call(["cmake", "--build", build, "--target", "afferent_python"])
        subprocess.check_call(["cmake", "--install", build, "--component", "python"])


# All files come from CMake; the extension makes the wheel one of this machine.
setup(packages=[], ext_modules=[Extension("afferent._afferent", [])], cmdclass={"build_ext": CMakeBuild})
