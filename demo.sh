#!/bin/sh
# A grasp, from force samples to EMG gain: installs what is missing, builds, runs, and says where the picture is.
set -eu
cd "$(dirname "$0")"
scripts/install-dependencies.sh
scripts/build.sh release afferent
build/release/apps/afferent run examples/grasp.txtpb --out out/grasp
if [ -f out/grasp/grasp.png ]; then
    echo "The picture of it: $PWD/out/grasp/grasp.png (and .svg)"
fi
