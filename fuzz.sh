#!/bin/sh
# Fuzzes everything that reads bytes from outside, each target for that many seconds (default 60), and counts:
#   ./fuzz.sh [seconds] [target...]
# A finding is left in build/fuzz/findings; once mended it belongs into tests/fuzz/corpus.
set -eu
cd "$(dirname "$0")"
seconds=${1:-60}
[ $# -eq 0 ] || shift
scripts/build.sh fuzz
mkdir -p build/fuzz/findings
failed=0
for program in build/fuzz/tests/fuzz/*_fuzz; do
    target=$(basename "$program" _fuzz)
    [ $# -eq 0 ] || case " $* " in *" $target "*) ;; *) continue ;; esac
    # New inputs are kept beside the corpus, so that the next run begins where this one ends.
    mkdir -p "build/fuzz/grown/$target"
    log=build/fuzz/$target.log
    if "$program" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 \
        -artifact_prefix="build/fuzz/findings/$target-" "build/fuzz/grown/$target" "tests/fuzz/corpus/$target" \
        >"$log" 2>&1; then
        echo "$target: $(sed -n 's/^stat::number_of_executed_units: //p' "$log") executions, no finding"
    else
        echo "$target: a finding, see $log"
        failed=1
    fi
done
exit $failed
