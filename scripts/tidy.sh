#!/bin/sh
# Runs clang-tidy 14 by .clang-tidy over all production code, in the compile commands of a build, and prints what it
# finds. Takes some ten minutes of CPU.
#
#     scripts/tidy.sh [build folder]     default: build/release
set -eu
cd "$(dirname "$0")/.."
folder=${1:-build/release}
if ! command -v run-clang-tidy-14 >/dev/null; then
    echo "clang-tidy 14 is not installed: scripts/install-dependencies.sh tests" >&2
    exit 77
fi
log=$(mktemp)
trap 'rm -f "$log"' EXIT
# Names in nameless namespaces hide each other where several sources are compiled at once, which is no error.
if ! run-clang-tidy-14 -quiet -p "$folder" -extra-arg=-Wno-shadow -extra-arg=-Wno-sign-conversion \
    -extra-arg=-Wno-unknown-warning-option '^(?!.*/(tests|examples|generated)/).*$' >"$log" 2>&1; then
    grep -vE '^clang-tidy-14|warnings generated|^$' "$log" >&2
    exit 1
fi
