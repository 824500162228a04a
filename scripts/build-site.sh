#!/bin/sh
# Builds the documentation as a site that needs neither a server nor a network:
#
#     scripts/build-site.sh [folder]     default: build/site/html
#
# Installs from Debian what that takes. The help of the commands is on it where the program is built: AFFERENT_PROGRAM, or
# build/release/apps/afferent.
set -eu
cd "$(dirname "$0")/.."
scripts/install-dependencies.sh site

site=${1:-build/site/html}
work=build/site
# What an earlier build left there would still be found.
[ ! -e "$site/.buildinfo" ] || rm -rf "$site"
mkdir -p "$site" "$work"
site=$(cd "$site" && pwd)
AFFERENT_VERSION=$(sed -n 's/^  VERSION //p' CMakeLists.txt)
program=${AFFERENT_PROGRAM:-build/release/apps/afferent}
[ -x "$program" ] || { echo "Without the commands: the program is not built." >&2 && program=; }
export AFFERENT_VERSION

# Debian's own Python, whose packages these are, where another comes first in PATH.
python=/usr/bin/python3
[ -x $python ] || python=python3
$python docs/site/prepare.py . $work/source ${program:+"$program"}
# A page that is wrong, or a link within the site that leads nowhere, is an error.
$python -m sphinx -b html -W --keep-going -q -j auto -d $work/doctrees $work/source "$site"

# Debian has taken the theme apart: its script is a module that imports another, which no browser does from a file, and its
# style sheet imports another by its place on a Debian web server.
scripts=$site/_static/scripts
if grep -q '^import Gumshoe from' "$scripts/furo.js"; then
    { cat "$scripts/gumshoe-patched.js" && sed '/^import Gumshoe from/d' "$scripts/furo.js"; } >$work/furo.js
    mv $work/furo.js "$scripts/furo.js"
fi
normalize=/usr/share/javascript/normalize.css/normalize.css
furo=$site/_static/styles/furo.css
if grep -q '^@import url(/javascript/normalize.css/normalize.css);' "$furo"; then
    { cat $normalize && sed 's|^@import url(/javascript/normalize.css/normalize.css);||' "$furo"; } >$work/furo.css
    mv $work/furo.css "$furo"
fi

# Headers are found as they are included: <afferent/runtime/event.hpp>.
AFFERENT_HEADERS=$PWD/$work/headers
AFFERENT_FILTER=$PWD/docs/site/as_doxygen.sh
AFFERENT_SITE=$site
export AFFERENT_HEADERS AFFERENT_FILTER AFFERENT_SITE
rm -rf "$AFFERENT_HEADERS"
mkdir -p "$AFFERENT_HEADERS/afferent"
# Those of every component.
find runtime neurons encoders decoders io hand scene engine nodes studies view '(' -name '*.hpp' -o -name '*.h' ')' \
    -exec cp --parents -t "$AFFERENT_HEADERS/afferent" {} +
doxygen docs/site/Doxyfile
# It links to a list of nested classes on pages that have none, as those are private.
grep -L 'id="nested-classes"' "$site"/interfaces/*.html | xargs -r sed -i '\|^<a href="#nested-classes">|d'
echo "The site: $site/index.html"
