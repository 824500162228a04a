#!/bin/sh
# A grasp, from force samples to EMG gain: installs what is missing, builds, runs, and says where the picture is.
#
#     ./demo.sh [--python]     --python: builds the module for Python, too, and says how to import it
set -eu
cd "$(dirname "$0")"
case ${1:-} in
    '') python= ;;
    --python) python=python ;;
    *)
        echo "usage: ./demo.sh [--python]" >&2
        exit 2
        ;;
esac
[ -x build/release/apps/afferent ] || echo "The first time this takes two to six minutes on two cores, most of them to compile."
if [ -n "$python" ]; then
    scripts/install-dependencies.sh python
    scripts/build.sh release -DAFFERENT_PYTHON=ON afferent afferent_python
else
    scripts/install-dependencies.sh
    scripts/build.sh release afferent
fi
build/release/apps/afferent run examples/grasp.txtpb --out out/grasp
if [ -f out/grasp/grasp.png ]; then
    echo "The picture of it: $PWD/out/grasp/grasp.png (and .svg)"
fi
echo "The program: $PWD/build/release/apps/afferent"
echo "To call it afferent in this shell: PATH=$PWD/build/release/apps:\$PATH"
echo "To install it: cmake --install build/release"
if [ -n "$python" ]; then
    echo "The module for Python: PYTHONPATH=$PWD/build/release/python /usr/bin/python3 examples/python/grasp.py"
    echo "To install that: cmake --install build/release --component python"
fi
