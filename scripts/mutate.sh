#!/bin/sh
# Finds out what the tests would not notice: makes small changes to the code, one at a time, and runs the tests.
#
#     scripts/mutate.sh [--since COMMIT] [--files GLOB]... [--count N] [--seed S]
#
# --since: only lines that differ from that commit; --files: only files that match, as 'nodes/*.cpp' or 'runtime';
# --count: that many changes, drawn at random (default 20), or `all` that there are; --seed: draws others (default 1).
# scripts/mutate.py --help lists the rest. The changes are made to a copy of the tree in build/mutate.
set -eu
cd "$(dirname "$0")/.."
scripts/install-dependencies.sh mutate
# Debian's own Python, whose package clang is, where another comes first in PATH.
exec /usr/bin/python3 scripts/mutate.py "$@"
