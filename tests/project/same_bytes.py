#!/usr/bin/env python3
"""Predicted spikes are the same bytes from every compiler, whatever it may do to floating point.

A usual build and one without optimisation run the same comparison in the tests of io/wire.

same_bytes.py SOURCE INCLUDE CXX LIBRARY...: what computes them is compiled each time, and the rest is in the libraries.
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile

source, include, compiler = map(pathlib.Path, sys.argv[1:4])
SOURCES = ["tests/project/same_bytes.cpp", "io/wire/spike_predictor.cpp", "io/wire/interval_law.cpp",
           "io/wire/packet_layout.cpp"]
LIBRARIES = [*sys.argv[4:], "-lhwy_contrib", "-lhwy"]
OPTIONS = ["-O3", "-march=native", "-ffp-contract=fast"]

compilers = {pathlib.Path(found).resolve(): found
             for found in map(shutil.which, (compiler, "g++", "clang++", "clang++-14")) if found}
failed = []
with tempfile.TemporaryDirectory() as folder:
    program = pathlib.Path(folder) / "same_bytes"
    for name in sorted(compilers.values()):
        built = subprocess.run([name, "-std=c++20", *OPTIONS, f"-I{source}", f"-I{include}", "-o", program,
                                *(source / path for path in SOURCES), *LIBRARIES],
                               capture_output=True, text=True, check=False)
        if built.returncode != 0:
            sys.exit(f"{name}:\n{built.stderr}")
        same = subprocess.run([program], check=False).returncode == 0
        print(name, *OPTIONS, "same" if same else "DIFFERENT")
        if not same:
            failed.append(name)
sys.exit(1 if failed else 0)
