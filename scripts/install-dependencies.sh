#!/bin/sh
# Installs the Debian 12 packages that Afferent is built from and drawn with. Does nothing where all are there.
#
#     scripts/install-dependencies.sh [mpi] [python] [tests] [chip] [site] [mutate] [release] [arm64]
#     scripts/install-dependencies.sh --libraries    prints the packages of what is linked, and installs nothing
#
# mpi: with what runs in several processes take; python: with what the module for Python takes; tests: with what the
# tests compare with and drive; chip: with what exported neurons are simulated, run and synthesised by; site: with what the
# documentation as a site is made by; mutate: with what scripts/mutate.sh finds changes by; release: with what packages
# are made and tried by; arm64: with what compiles and runs for that machine.
set -eu
list=
if [ "${1:-}" = --libraries ]; then
    list=yes
    shift
fi
for group in "$@"; do
    case $group in
        mpi | python | tests | chip | site | mutate | release | arm64) ;;
        *)
            echo "usage: scripts/install-dependencies.sh [mpi] [python] [tests] [chip] [site] [mutate] [release] [arm64]" >&2
            exit 2
            ;;
    esac
done
groups=" $* "
wanted() {
    case $groups in *" $1 "*) true ;; *) false ;; esac
}

# A package, what it is for, and, where something else may stand in for it, the command that says it is not needed.
dependencies() {
    cat <<'END'
g++                 compiler
cmake               build
ninja-build         build
ccache              builds faster the second time
libboost-dev        numerics, sockets
libcsv-dev          tables
libcli11-dev        arguments of the program
libhdf5-dev         events in other programs' files
libmatio-dev        tables of MATLAB
libhwy-dev          vector instructions
libisal-dev         checksums of packets
libprotobuf-dev     scenes and packets
librandom123-dev    random numbers
libsodium-dev       sealed links
libssl-dev          links over TLS
libtbb-dev          threads
libzip-dev          tables of NumPy
zlib1g-dev          compressed tables
nlohmann-json3-dev  results of the program
protobuf-compiler   scenes and packets
libgtest-dev        tests
python3-h5py        tests with other readers
gnuplot-nox         pictures                        gnuplot
fonts-liberation    text in pictures
END
    ! wanted mpi || cat <<'END'
libopenmpi-dev      runs in several processes
openmpi-bin         runs in several processes
END
    ! wanted python || cat <<'END'
pybind11-dev        module for Python
python3-dev         module for Python
python3-numpy       module for Python
python3-matplotlib  pictures in Python
END
    ! wanted tests || cat <<'END'
chromium            tests of the live view
chromium-driver     tests of the live view
python3-selenium    tests of the live view
mypy                tests of the module's types
pkg-config          tests of what is installed
python3-pip         tests of the wheel
python3-venv        tests of the wheel
python3-wheel       tests of the wheel
python3-nbclient    test of the notebook
python3-ipykernel   test of the notebook
groff-base          tests of man pages
make                tests of exported neurons
zsh                 tests of completions
fish                tests of completions
clang-format-14     test of the sources' format
clang-tidy-14       checks of the sources
python3-neo         tests with other readers
python3-pandas      tests with other readers
END
    ! wanted chip || cat <<'END'
gcc-arm-none-eabi   compiler for exported neurons
gcc-riscv64-unknown-elf  compiler for exported neurons
frama-c-base        proof of exported neurons
iverilog            simulation of exported neurons
libnewlib-arm-none-eabi  check of exported neurons
nextpnr-ice40       place and route of exported neurons
picolibc-riscv64-unknown-elf  check of exported neurons
qemu-system-arm     Cortex-M for exported neurons
qemu-system-misc    RISC-V for exported neurons
verilator           fast simulation of exported neurons
yosys               synthesis and proof of exported neurons
END
    ! wanted site || cat <<'END'
doxygen             site of the documentation
furo                site of the documentation
libjs-katex         equations on the site
python3-myst-parser site of the documentation
python3-protobuf    scene reference
python3-sphinx      site of the documentation
END
    ! wanted mutate || cat <<'END'
python3-clang       changes that tests should notice
END
    ! wanted release || cat <<'END'
debootstrap         a bare Debian for packages to be tried in
dpkg-dev            what a package depends on
END
    ! wanted arm64 || cat <<'END'
g++-aarch64-linux-gnu  compiler for arm64
mmdebstrap          libraries for arm64
qemu-user-static    runs programs for arm64
END
}

if [ -n "$list" ]; then
    dependencies | sed -n 's/^\([^ ]*-dev\) .*/\1/p'
    exit 0
fi

installed() {
    [ "$(dpkg-query --show --showformat='${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "This is no Debian, so nothing is installed here. Afferent needs what Debian 12 calls:" >&2
    dependencies | cut -c 1-51 | sed 's/^/  /; s/ *$//' >&2
    exit 0
fi

missing=
while read -r package purpose; do
    case $purpose in
        *' gnuplot') command -v gnuplot >/dev/null && continue ;;
    esac
    installed "$package" || missing="$missing $package"
done <<END
$(dependencies)
END
[ -n "$missing" ] || exit 0

echo "Installing from Debian:"
for package in $missing; do
    dependencies | grep -F "$package " | cut -c 1-51 | sed 's/^/  /; s/ *$//'
done
as_root=
if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
        echo "That takes root, and there is no sudo. As root, run:" >&2
        echo "  apt-get update && apt-get install --no-install-recommends$missing" >&2
        exit 1
    fi
    as_root='sudo'
fi
log=$(mktemp)
trap 'rm -f "$log"' EXIT
# Quiet, unless it fails. Waits for another installation to end. $missing is a list of words.
# shellcheck disable=SC2086
wait_for_others='-o DPkg::Lock::Timeout=300'
if ! { $as_root apt-get $wait_for_others update && $as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get $wait_for_others install --yes --no-install-recommends $missing; } \
    >"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "Not installed. apt-get says why above." >&2
    exit 1
fi
