#!/bin/sh
# Holds exported neurons to the emulator for longer than the tests do: 10^7 neuron ticks and more for each width and rounding in
# C on this machine, on a Cortex-M3 and a RISC-V that QEMU emulates, and in Verilog by verilator; 10^5 by iverilog. Takes one
# processor for about two hours.
#
#     scripts/check-chips.sh [PART ...]        c, cortex-m, riscv, verilator, icarus; all if none
#
# A line for each: what was compared, and "equal"; ends with 1 at the first that is not.
set -eu
cd "$(dirname "$0")/.."
afferent=$PWD/build/release/apps/afferent
[ -x "$afferent" ] || { echo "build it first: scripts/build.sh release afferent" >&2; exit 1; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
parts=${*:-c cortex-m riscv verilator icarus}

# So many neurons that an hour of silence makes 10^7 ticks of them, or that a core's ticks are short.
scene() {
    neurons=$1 tick_us=$2 bits=$3 decay=$4 rounding=$5
    shares=$(i=0; while [ $i -lt "$neurons" ]; do printf ' share: 0.001'; i=$((i + 1)); done)
    echo "duration_s: 1 source { profile { point { time_s: 0 force_n: 0 } } } link { tcp { port: 1 } }
        patch { name: 'a' elements: $neurons $shares neuron { tau_m_ms: 10 tau_g_ms: 500 delta_g: 0.03 refractory_ms: 2
        fixed_point { tick_us: $tick_us state_bits: $bits decay_bits: $decay rounding: $rounding } } }"
}

for width in '1000 8 12' '1000 12 12' '1000 16 16' '100 16 24' '1000 24 24' '100 32 24'; do
    for rounding in HALF_EVEN TRUNCATION; do
        # shellcheck disable=SC2086
        set -- $width
        scene 3 "$1" "$2" "$3" $rounding >"$folder/c.txtpb"
        scene 100 "$1" "$2" "$3" $rounding >"$folder/v.txtpb"
        "$afferent" export "$folder/c.txtpb" --c "$folder/c" >/dev/null 2>&1
        "$afferent" export "$folder/v.txtpb" --verilog "$folder/v" >/dev/null 2>&1
        for part in $parts; do
            printf '%s bits, %s us, %s, %s: ' "$2" "$1" $rounding "$part"
            case $part in
            c) make -s -C "$folder/c" check && (cd "$folder/c" && ./check) ;;
            cortex-m | riscv) make -s -C "$folder/c" "$part" ;;
            verilator)
                # The long vectors, of a core of three neurons.
                "$afferent" export "$folder/c.txtpb" --verilog "$folder/v3" >/dev/null 2>&1
                cp "$folder/c/vectors.txt" "$folder/v3/vectors.txt"
                make -s -C "$folder/v3" verilator LIMIT=3400000 | grep equal
                ;;
            icarus) make -s -C "$folder/v" icarus TICKS=1000 | grep equal ;;
            *) echo "no such part"; exit 1 ;;
            esac >"$folder/said" 2>&1 || { cat "$folder/said"; exit 1; }
            cat "$folder/said"
            grep -q ': equal' "$folder/said" || exit 1
        done
    done
done
