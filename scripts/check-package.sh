#!/bin/sh
# Installs a Debian package of Afferent, and the python3-afferent beside it, where nothing of them is; runs the
# demonstration from both, and compiles a program against the first. Takes root.
#
#     scripts/check-package.sh PACKAGE.deb VERSION [FOLDER]     FOLDER: for the bare Debian; default: a temporary one
set -eu
package=$(realpath "$1")
module=$(dirname "$package")/python3-$(basename "$package")
version=$2
folder=${3:-}
cd "$(dirname "$0")/.."
set -- "$folder"
. scripts/bare-debian.sh

cp "$package" "$root/root/afferent.deb"
cp "$module" "$root/root/python3-afferent.deb"
in_root sh -eu -c '
    export DEBIAN_FRONTEND=noninteractive
    { apt-get update && apt-get install --yes /root/afferent.deb; } >/root/install.log 2>&1 ||
        { tail -n 20 /root/install.log >&2; exit 1; }
    test "$(afferent --version)" = "$1" || { echo "afferent --version is $(afferent --version)" >&2; exit 1; }
    afferent run /usr/share/doc/afferent/examples/grasp.txtpb --out /root/grasp
    test -s /root/grasp/grasp.png || { echo "The demonstration drew no picture." >&2; exit 1; }
    apt-get install --yes --no-install-recommends gcc libc6-dev pkg-config >>/root/install.log 2>&1 ||
        { tail -n 20 /root/install.log >&2; exit 1; }
    apt-get install --yes --no-install-recommends /root/python3-afferent.deb >>/root/install.log 2>&1 ||
        { tail -n 20 /root/install.log >&2; exit 1; }
    python3 -c "import afferent; print(afferent.run(\"/usr/share/doc/afferent/examples/grasp.txtpb\"))"
    cc /usr/share/doc/afferent/examples/embed.c -o /root/embed $(pkg-config --cflags --libs afferent)
    /root/embed /usr/share/doc/afferent/examples/grasp.txtpb >/root/events.txt
    test -s /root/events.txt || { echo "The program that embeds Afferent printed no events." >&2; exit 1; }
' sh "$version"
echo "The package works where nothing else of Afferent is."
