#!/bin/sh
# Builds the site and looks at all of it: build_site.sh ROOT PROGRAM. Skipped where its tools are missing.
set -eu
cd "$1"
export AFFERENT_PROGRAM="$2"
for tool in doxygen protoc git; do
    command -v $tool >/dev/null || { echo "no $tool" && exit 77; }
done
[ -e /usr/share/javascript/katex/katex.min.js ] || { echo "no libjs-katex" && exit 77; }
/usr/bin/python3 -c 'import furo, google.protobuf, myst_parser, sphinx' 2>/dev/null || { echo "no Sphinx" && exit 77; }
scripts/build-site.sh build/site/tested
exec /usr/bin/python3 tests/project/check_site.py . build/site/tested
