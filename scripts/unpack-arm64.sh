#!/bin/sh
# Unpacks what Afferent is built from into build/arm64-root, for Debian 12 on arm64: the libraries that cmake/arm64.cmake builds
# against. They are not installed beside this machine's own, because some of them exclude each other. Takes mmdebstrap.
set -eu
cd "$(dirname "$0")/.."
root=build/arm64-root
[ ! -e "$root/usr/include/gtest" ] || exit 0
packages=libboost-dev,libc6-dev,libcli11-dev,libcsv-dev,libgtest-dev,libhdf5-dev,libhwy-dev,libisal-dev,libprotobuf-dev
packages=$packages,librandom123-dev,libsodium-dev,libssl-dev,libstdc++-12-dev,libtbb-dev,libzip-dev,nlohmann-json3-dev,zlib1g-dev
mkdir -p build
rm -rf "$root"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! mmdebstrap --variant=extract --architectures=arm64 --include="$packages" bookworm "$root" >"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "Not unpacked. mmdebstrap says why above." >&2
    exit 1
fi
