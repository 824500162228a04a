#!/bin/sh
# The program's Debian package holds no module for Python, and python3-afferent works by itself:
# debian_packages.sh CPACK BUILD FOLDER PYTHON, where PYTHON is empty without the module. Skipped without dpkg-dev.
set -eu
cpack=$1 build=$2 folder=$3 python=$4
command -v dpkg-shlibdeps >/dev/null || { echo "no dpkg-dev" && exit 77; }
rm -rf "$folder"
mkdir -p "$folder"
"$cpack" -G DEB --config "$build/CPackConfig.cmake" -B "$folder" >"$folder/log" 2>&1 || { tail "$folder/log" && exit 1; }

fail() {
    echo "$1" >&2
    exit 1
}
dpkg-deb --contents "$folder"/afferent_*.deb >"$folder/program"
grep -q ' \./usr/bin/afferent$' "$folder/program" || fail "The package afferent has no program."
! grep -q '_afferent\..*\.so' "$folder/program" || fail "The package afferent has the module for Python."
if [ -z "$python" ]; then
    [ ! -e "$(echo "$folder"/python3-afferent_*.deb)" ] || fail "There is a python3-afferent without the module."
    exit 0
fi
depends=$(dpkg-deb --field "$folder"/python3-afferent_*.deb Depends)
for package in python3-numpy libprotobuf32 libhdf5-103-1; do
    case $depends in *$package*) ;; *) fail "python3-afferent does not depend on $package, but on: $depends" ;; esac
done
dpkg-deb --extract "$folder"/python3-afferent_*.deb "$folder/root"
module=$(find "$folder/root" -name '_afferent.*.so')
[ -e "$(dirname "$module")/afferent-hdf5" ] || fail "python3-afferent has no afferent-hdf5."
cd "$folder"
PYTHONPATH=$(dirname "$(dirname "$module")") "$python" -c 'import afferent; assert len(afferent.run(afferent.Scene(duration_s=3)))'
