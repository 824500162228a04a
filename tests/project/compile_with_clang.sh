#!/bin/sh
# The library compiles with clang 14 too: compile_with_clang.sh <build folder> <folder of hdf5.h>. Skipped (77) where
# it is absent. What needs MPI is left out. What the build compiles together is compiled together here.
set -eu
cd "$(dirname "$0")/../.."
compiler=clang++-14
command -v $compiler >/dev/null || {
    echo "$compiler is not installed"
    exit 77
}
folders='runtime|neurons|encoders|decoders|proto|io|hand|scene|engine|nodes|studies|view'
build=$(realpath "$1")
units=$(sed -n "s#.*\"file\": \"\(.*\)\".*#\1#p" "$build/compile_commands.json" |
    grep -E "^($build|$PWD)/($folders)/.*[.](cpp|cxx)$" | grep -v /nodes/ranks/ | sort -u)
[ "$(echo "$units" | wc -l)" -gt 15 ] || {
    echo "$build/compile_commands.json does not name the library's sources"
    exit 1
}
echo "$units" |
    xargs -P "$(nproc)" -n 1 $compiler -std=c++20 -fsyntax-only -Wall -Wextra -Wno-unused-private-field \
        -DAFFERENT_VERSION='""' -DBOOST_ASIO_SEPARATE_COMPILATION -I"$build/include" -isystem "$build/generated" -isystem "$2"
