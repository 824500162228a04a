#!/bin/sh
# Builds a preset: scripts/build.sh release [-DOPTION=VALUE...] [target...]. Says little while all is well, and what is
# wrong otherwise. An option holds until it is given again.
set -eu
cd "$(dirname "$0")/.."
preset=$1
shift
folder=build/$preset
log=$folder/build.log
mkdir -p "$folder"

launcher=
if command -v ccache >/dev/null; then
    launcher='-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache'
fi
# Warnings are errors where they are known: with the compiler that decides. Another may have new ones.
strict=OFF
[ "$preset" != fuzz ] && [ "$(c++ -dumpversion)" = 12 ] && strict=ON

failed() {
    tail -n 40 "$log" >&2
    echo "The build of $preset failed; all of it is in $log." >&2
    exit 1
}

options=
while case ${1:-} in -D*) ;; *) false ;; esac; do
    options="$options $1"
    shift
done
# $launcher and $options are lists of words.
# shellcheck disable=SC2086
cmake --preset "$preset" $launcher $options -DAFFERENT_WERROR=$strict >"$log" 2>&1 || failed
[ $# -eq 0 ] || set -- --target "$@"
begin=$(date +%s)
if [ -t 1 ]; then
    # One line that counts the files. Where it fails, ninja has shown the errors.
    NINJA_STATUS="Building $preset: %f of %t " cmake --build --preset "$preset" "$@" || exit 1
else
    # A line for each tenth, so that nobody who reads a pipe takes a build of minutes for one that hangs. A build of seconds has none.
    status=$folder/build.status
    {
        built=0
        NINJA_STATUS='[%f/%t %e] ' cmake --build --preset "$preset" "$@" 2>&1 || built=$?
        echo $built >"$status"
    } | while IFS= read -r line; do
        printf '%s\n' "$line" >>"$log"
        counted=${line%%] *}  # [12/99 3.456
        case $counted in
            *[!0-9./\ \[]*) continue ;;  # a message
            \[[0-9]*/[0-9]*\ [0-9]*.[0-9]*) ;;
            *) continue ;;
        esac
        files=${counted#[}
        of=${files#*/}
        after=${of#* }
        tenth=$((10 * ${files%%/*} / ${of%% *}))
        if [ "$tenth" -gt "${said:-0}" ] && [ "$tenth" -lt 10 ] && [ "${after%.*}" -gt 5 ]; then
            said=$tenth
            echo "Building $preset: ${tenth}0 % after ${after%.*} s"
        fi
    done
    [ "$(cat "$status")" = 0 ] || failed
fi
took=$(($(date +%s) - begin))
[ $took -lt 2 ] || echo "Built $preset in $took s."
