#!/bin/sh
# The library compiles with clang 14 too: compile_with_clang.sh <build folder> <folder of hdf5.h>. Skipped (77) where
# it is absent.
set -eu
cd "$(dirname "$0")/../.."
compiler=clang++-14
command -v $compiler >/dev/null || {
    echo "$compiler is not installed"
    exit 77
}
find runtime neurons encoders decoders proto io hand scene -name '*.cpp' -print0 |
    xargs -0 -P "$(nproc)" -n 1 $compiler -std=c++20 -fsyntax-only -Wall -Wextra -Wno-unused-private-field \
        -DAFFERENT_VERSION='""' -I"$1/include" -isystem "$1/generated" -isystem "$2"
