#!/bin/sh
# Two programs say the same, and something: same_output.sh PROGRAM PROGRAM [argument...]
set -eu
one=$1
other=$2
shift 2
expected=$("$one" "$@")
[ -n "$expected" ]
[ "$("$other" "$@")" = "$expected" ]
