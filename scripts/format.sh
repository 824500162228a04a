#!/bin/sh
# Formats the C and C++ files of the tree by .clang-format: scripts/format.sh. With --check it changes nothing, and
# shows what differs. Other versions of clang-format than 14 format differently; without it, --check exits with 77.
set -eu
cd "$(dirname "$0")/.."
check=
case ${1:-} in
    '') ;;
    --check) check='--dry-run --Werror' ;;
    *)
        echo "usage: scripts/format.sh [--check]" >&2
        exit 2
        ;;
esac
if ! command -v clang-format-14 >/dev/null; then
    echo "clang-format-14 is not installed: scripts/install-dependencies.sh tests" >&2
    exit 77
fi
# $check is a list of words.
# shellcheck disable=SC2086
find . \( -path ./build -o -path ./out -o -name '.?*' \) -prune -o -type f -name '*.[ch]pp' -print0 -o -type f -name '*.[ch]' -print0 |
    xargs -0 -n 50 -P "$(nproc)" clang-format-14 ${check:--i} --style=file
