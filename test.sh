#!/bin/sh
# Installs what is missing, builds, and runs every test. With --sanitizers: the tests under AddressSanitizer and
# UndefinedBehaviorSanitizer, the runtime's under ThreadSanitizer, and clang-tidy, in place of the release build's. With --arm64:
# builds all for arm64, and runs under QEMU the unit tests of what computes, and the examples, which give the same bytes. The
# last line counts the tests; a build that fails counts as one failed test.
set -eu
cd "$(dirname "$0")"

usage() {
    cat <<'END'
Installs what is missing, builds, and runs the tests.

Usage: ./test.sh [--sanitizers | --arm64]

  --sanitizers   AddressSanitizer, UndefinedBehaviorSanitizer, ThreadSanitizer and clang-tidy in place of the release build
  --arm64        a build by the cross compiler, under QEMU, in place of the release build

Example:
  ./test.sh && ./test.sh --sanitizers
END
}

what=
case ${1:-} in
    '') ;;
    --sanitizers | --arm64) what=${1#--} ;;
    -h | --help)
        usage
        exit 0
        ;;
    *)
        usage >&2
        exit 2
        ;;
esac

if [ "$what" = arm64 ]; then
    scripts/install-dependencies.sh arm64
    scripts/unpack-arm64.sh
else
    scripts/install-dependencies.sh mpi python tests chip site
fi

# The sanitizers' shadow memory and a kernel that scatters addresses widely do not go together.
steady=
if setarch -R true 2>/dev/null; then steady='setarch -R'; fi

# Most tests wait for processes, sockets and time most of the while.
at_once=$(($(nproc) * 2))

passed=0
failed=0
skipped=0
running=

trap '[ -z "$running" ] || kill "$running"; exit 1' HUP INT TERM

# build PRESET [-DOPTION=VALUE...] [target...], with the tests of the build before beside it.
build() {
    if $steady scripts/build.sh "$@"; then
        built=yes
    else
        built=
        failed=$((failed + 1))
    fi
}

# begin_tests PRESET [ctest option...]
begin_tests() {
    preset=$1
    shift
    results=$PWD/build/$preset/results.xml
    log=build/$preset/tests.log
    [ -n "$built" ] || return 0
    rm -f "$results"
    $steady ctest --preset "$preset" --parallel "$at_once" --output-junit "$results" "$@" >"$log" 2>&1 &
    running=$!
}

count() { sed -n "1,/>/s/.*[[:space:]]$1=\"\([0-9]*\)\".*/\1/p" "$results" | head -n 1; }

end_tests() {
    [ -n "$running" ] || return 0
    complete=yes
    wait "$running" || complete=no
    running=
    preset_failed=$(count failures)
    preset_skipped=$(($(count skipped) + $(count disabled)))
    preset_passed=$(($(count tests) - preset_failed - preset_skipped))
    # What could not even be started is a failure too.
    if [ $complete = no ] && [ "$preset_failed" -eq 0 ]; then preset_failed=1; fi
    [ $complete = yes ] || grep -vE '^ *Start|Passed +[0-9.]+ sec$' "$log" || true
    echo "$preset: $preset_passed passed, $preset_failed failed, $preset_skipped skipped"
    passed=$((passed + preset_passed))
    skipped=$((skipped + preset_skipped))
    failed=$((failed + preset_failed))
}

# What clang-tidy finds in production code fails; without clang-tidy it is skipped.
tidy() {
    [ -n "$built" ] || return 0
    status=0
    scripts/tidy.sh "build/$1" || status=$?
    case $status in
        0) passed=$((passed + 1)) ;;
        77) skipped=$((skipped + 1)) ;;
        *) failed=$((failed + 1)) ;;
    esac
}

# The examples' events, estimates, packets and recordings, byte for byte as this machine has them.
same_on_arm64() {
    [ -n "$built" ] || return 0
    program=build/arm64/afferent-by-qemu
    printf '#!/bin/sh\nexec qemu-aarch64-static -L %s %s "$@"\n' "$PWD/build/arm64-root" "$PWD/build/arm64/apps/afferent" >$program
    chmod +x $program
    if AFFERENT_PROGRAM=$PWD/$program build/release/tests/apps_tests --gtest_brief=1 --gtest_filter='*ExampleOutputs*'; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
    fi
}

if [ -z "$what" ]; then
    build release -DAFFERENT_MPI=ON -DAFFERENT_PYTHON=ON
    begin_tests release
    end_tests
elif [ "$what" = arm64 ]; then
    build arm64
    # QEMU has no pseudo-terminals, by which tests make serial lines, and other memory maps and errors of new processes than Linux.
    begin_tests arm64 --exclude-regex \
        '/serial|Serial[.]|Sessions[.]|Relays[.](ReplaceNoLink|StandInForASerial)|IsNotInCoreDumps|Gnuplot[.]NeedNot'
    build release apps_tests
    end_tests
    same_on_arm64
else
    build debug
    # Tests of the project, of its package and of its manual build or read other things than the code under the sanitizers,
    # and a benchmark's own run adds nothing to the tests of its parts. In the last ones nearly all of the time goes into
    # Verilator, yosys, frama-c and compilers.
    elsewhere='^bench\.Quick|^apps[.](Manual|Documentation)|SimulatedWidth|VerilogExport[.](IsNotEqual|HasNeurons|Fits)|IsProvedNotToOverflow|FindEachChange'
    # Whole scenes again and again, by code that other tests of the same folder run under the sanitizers.
    again='^apps[.](Replay[.](With|Writes|Tells|OfTwo|OfAHand)|TrialCommand[.][^K]|TwoProcesses[.]InLockstepLose|Program[.]RunsTheCommands)|^faults[.]Over/Processes.*/(tcp|udp)( |$)'
    # (CMake's expressions have no more than nine parentheses.)
    again="$again|Literature[.]Best|Literature[.]Eleven|Noise[.]Makes|WhatSlides|Textures[.]Have|Textures[.]AreToldBy"
    again="$again|Tuning[.]HasTheBest|Tuning[.]ShowsHow|trial[.]ContactBrake|FoundGains[.]Are[^N]|FoundGains[.]Choose"
    again="$again|ClosedLoop[.]Keeps|SchemeMap[.]|ChipBench[.]|DecodingBench[.]FindsNo"
    begin_tests debug --label-exclude '^(project|package)$' --exclude-regex "$elsewhere|$again"
    build tsan runtime_tests threads_tests
    end_tests
    begin_tests tsan
    end_tests
    tidy debug
fi

echo "$passed passed, $failed failed$([ $skipped -eq 0 ] || echo ", $skipped skipped")"
[ $failed -eq 0 ]
