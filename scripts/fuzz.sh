#!/bin/sh
# Fuzzes everything that reads bytes from outside, on all processors, and counts:
#   scripts/fuzz.sh [seconds] [target...]              each target for that many seconds (default 60)
#   scripts/fuzz.sh --executions NUMBER [target...]    until there are so many in all, those before an interruption included
#   scripts/fuzz.sh --count                            how many there are, without fuzzing
# What is counted was executed by the programs as they are: for one that has changed the count begins at 0.
# A finding is left in build/fuzz/findings; once mended it belongs into tests/fuzz/corpus.
set -eu
cd "$(dirname "$0")/.."
programs=build/fuzz/tests/fuzz

# The counts of a program, one line for each run.
counts_of() { echo "build/fuzz/counts/$1-$(sha256sum "$programs/${1}_fuzz" | cut -c 1-16)"; }
executed() { cat "$(counts_of "$1")" /dev/null 2>/dev/null | awk '{ n += $1 } END { printf "%d", n }'; }
total() {
    sum=0
    for target in "$@"; do sum=$((sum + $(executed "$target"))); done
    echo $sum
}

# Longer inputs are slower, and find nothing that shorter ones do not.
longest() {
    case $1 in
        recording) echo 6144 ;;
        scene | session) echo 2048 ;;
        *) echo 1024 ;;
    esac
}

# fuzz TARGET SECONDS EXECUTIONS TARGETS: nothing where the targets have been executed that often (0: any number)
fuzz() {
    target=$1
    # shellcheck disable=SC2086
    if [ "$3" -gt 0 ] && [ "$(total $4)" -ge "$3" ]; then return 0; fi
    # New inputs are kept beside the corpus, so that the next run begins where this one ends.
    mkdir -p "build/fuzz/grown/$target"
    log=build/fuzz/$target.log
    status=0
    steady=
    # The sanitizers' shadow memory and a kernel that scatters addresses widely do not go together.
    if setarch -R true 2>/dev/null; then steady='setarch -R'; fi
    # -entropic=0: to weigh inputs by what is rare about them takes three times as long as to run them.
    ASAN_OPTIONS=quarantine_size_mb=8:malloc_context_size=4 \
        $steady "$programs/${target}_fuzz" -max_total_time="$2" -timeout=10 -rss_limit_mb=2048 -entropic=0 \
        -print_final_stats=1 -max_len="$(longest "$target")" -artifact_prefix="build/fuzz/findings/$target-" \
        "build/fuzz/grown/$target" "tests/fuzz/corpus/$target" >"$log" 2>&1 || status=1
    sed -n 's/^stat::number_of_executed_units: //p' "$log" >>"$(counts_of "$target")"
    [ $status -eq 0 ] || echo "$target: a finding, see $log"
    return $status
}

if [ "${1:-}" = --one ]; then
    shift
    fuzz "$@"
    exit
fi

seconds=60
executions=0
only_count=
case ${1:-} in
    --executions)
        executions=$2
        shift 2
        ;;
    --count)
        only_count=yes
        shift
        ;;
    [0-9]*)
        seconds=$1
        shift
        ;;
esac
scripts/build.sh fuzz
mkdir -p build/fuzz/findings build/fuzz/counts
if [ $# -gt 0 ]; then targets=$*; else targets=$(cd $programs && echo *_fuzz | sed 's/_fuzz//g'); fi

status=0
# shellcheck disable=SC2086
while [ -z "$only_count" ]; do
    printf '%s\n' $targets | xargs -P "$(nproc)" -I '{}' scripts/fuzz.sh --one '{}' "$seconds" "$executions" "$targets" ||
        status=1
    if [ $status -ne 0 ] || [ "$executions" -eq 0 ] || [ "$(total $targets)" -ge "$executions" ]; then break; fi
    echo "$(total $targets) of $executions executions"
done

for target in $targets; do echo "$target: $(executed "$target") executions"; done
# shellcheck disable=SC2086
echo "$(total $targets) executions in all, $([ $status -eq 0 ] && echo 'no finding' || echo 'with findings')"
exit $status
