#!/bin/sh
# Every test: release, then debug with AddressSanitizer and UndefinedBehaviorSanitizer, then the runtime's with
# ThreadSanitizer. Its last line counts them; a build that fails counts as one failed test.
set -eu
cd "$(dirname "$0")"
scripts/install-dependencies.sh mpi

# The sanitizers' shadow memory and a kernel that scatters addresses widely do not go together.
steady=
if setarch -R true 2>/dev/null; then steady='setarch -R'; fi

passed=0
failed=0
skipped=0

count() { sed -n "1,/>/s/.*[[:space:]]$1=\"\([0-9]*\)\".*/\1/p" "$2" | head -n 1; }

# run_tests PRESET [-DOPTION=VALUE...] [target...]
run_tests() {
    preset=$1
    results=$PWD/build/$preset/results.xml
    log=build/$preset/tests.log
    rm -f "$results"
    preset_failed=1
    if $steady scripts/build.sh "$@"; then
        complete=yes
        $steady ctest --preset "$preset" --parallel "$(nproc)" --output-junit "$results" >"$log" 2>&1 || complete=no
        preset_failed=$(count failures "$results")
        preset_skipped=$(($(count skipped "$results") + $(count disabled "$results")))
        preset_passed=$(($(count tests "$results") - preset_failed - preset_skipped))
        # What could not even be started is a failure too.
        if [ $complete = no ] && [ "$preset_failed" -eq 0 ]; then preset_failed=1; fi
        [ $complete = yes ] || grep -vE '^ *Start|Passed +[0-9.]+ sec$' "$log" || true
        echo "$preset: $preset_passed passed, $preset_failed failed, $preset_skipped skipped"
        passed=$((passed + preset_passed))
        skipped=$((skipped + preset_skipped))
    fi
    failed=$((failed + preset_failed))
}

run_tests release -DAFFERENT_MPI=ON
run_tests debug
run_tests tsan runtime_tests threads_tests

echo "$passed passed, $failed failed$([ $skipped -eq 0 ] || echo ", $skipped skipped")"
[ $failed -eq 0 ]
