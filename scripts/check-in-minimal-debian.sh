#!/bin/sh
# Clones this repository into a Debian 12 that has nothing but git and ca-certificates, and runs ./demo.sh and
# ./test.sh there, the demonstration twice: the second time nothing is missing. Takes root.
#
#     scripts/check-in-minimal-debian.sh [folder]     default: a temporary one, removed at the end
set -eu
cd "$(dirname "$0")/.."
. scripts/bare-debian.sh

git bundle create --quiet "$root/root/afferent.bundle" HEAD
in_root git -c advice.detachedHead=false clone --quiet /root/afferent.bundle /root/afferent
for command in ./demo.sh ./demo.sh ./test.sh; do
    echo "== $command"
    begin=$(date +%s)
    in_root sh -c "cd /root/afferent && $command"
    echo "== $command took $(($(date +%s) - begin)) s"
done
