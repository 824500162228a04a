#!/bin/sh
# Unpacks what Afferent is built from into build/arm64-root, for Debian 12 on arm64: the libraries that cmake/arm64.cmake builds
# against. They are not installed beside this machine's own, because some of them exclude each other. Takes mmdebstrap.
set -eu
cd "$(dirname "$0")/.."
root=build/arm64-root
packages="libc6-dev libstdc++-12-dev $(scripts/install-dependencies.sh --libraries)"
# Those that are there already.
[ "$(cat $root.packages 2>/dev/null)" != "$packages" ] || exit 0
mkdir -p build
rm -rf "$root"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! mmdebstrap --variant=extract --architectures=arm64 --include="$(echo $packages | tr " " ,)" bookworm "$root" >"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "Not unpacked. mmdebstrap says why above." >&2
    exit 1
fi
echo "$packages" >$root.packages
