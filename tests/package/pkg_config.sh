#!/bin/sh
# Programs that are built with nothing but the flags of pkg-config, from an installed folder that has been moved:
# pkg_config.sh SOURCE PREFIX CC CXX
set -eu
source=$1
prefix=$2
cc=$3
cxx=$4
command -v pkg-config >/dev/null || exit 77

moved=$prefix.moved
rm -rf "$moved"
mv "$prefix" "$moved"
libraries=$(dirname "$(dirname "$(find "$moved" -name afferent.pc)")")
PKG_CONFIG_PATH=$libraries/pkgconfig
export PKG_CONFIG_PATH
cd "$moved"

# What pkg-config prints are lists of words.
# shellcheck disable=SC2046
flags() { pkg-config --cflags --libs "$@"; }
pkg-config --validate afferent
$cc "$source/examples/embed.c" -o embed_c $(flags afferent)
events=$(LD_LIBRARY_PATH=$libraries ./embed_c "$source/examples/grasp.txtpb")
[ -n "$events" ]

$cxx -std=c++20 "$source/tests/package/decoders/main.cpp" -o decoders $(flags afferent-decoders)
./decoders

# Each component, whole, links with what its file requires and nothing else.
echo 'int main() {}' >main.cpp
for archive in "$libraries"/libafferent_*.a; do
    [ -e "$archive" ] || continue # where the components are shared
    name=$(basename "$archive" .a)
    module=afferent-${name#libafferent_}
    pkg-config --validate "$module"
    $cxx -c main.cpp -o main.o
    $cxx main.o -Wl,--whole-archive "$archive" -Wl,--no-whole-archive $(pkg-config --libs "$module") -o whole || {
        echo "$module.pc lacks what $archive links" >&2
        exit 1
    }
done
