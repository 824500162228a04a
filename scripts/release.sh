#!/bin/sh
# Makes a release of the newest commit: cuts the changelog, builds a source archive and two Debian packages of it, the
# program and the module for Python, installs both in a bare Debian and runs the demonstration from them. Only then the repository gets the release's commit
# and tag. Takes root, for the bare Debian. Run ./test.sh and ./test.sh --sanitizers first.
#
#     scripts/release.sh VERSION [FOLDER]     scripts/release.sh 0.2.0; FOLDER for the files, default: out/release
set -eu
cd "$(dirname "$0")/.."
if [ $# -lt 1 ] || [ $# -gt 2 ]; then
    echo "usage: scripts/release.sh VERSION [FOLDER]" >&2
    exit 2
fi
version=$1
folder=${2:-out/release}
tag=v$version
name=afferent-$version
if [ -n "$(git status --porcelain)" ]; then
    echo "There are changes that are not committed: commit or discard them first." >&2
    exit 1
fi
if git rev-parse --quiet --verify "refs/tags/$tag" >/dev/null; then
    echo "The tag $tag is there already." >&2
    exit 1
fi
scripts/install-dependencies.sh python release

# All of it happens to a clone.
here=$PWD
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM
git clone --quiet --no-hardlinks "$here" "$work/clone"
python3 scripts/cut_release.py "$version" "$(date +%Y-%m-%d)" "$work/clone"
(
    cd "$work/clone"
    git config user.name "$(git -C "$here" log -1 --format=%an)"
    git config user.email "$(git -C "$here" log -1 --format=%ae)"
    git commit --quiet --all --message "Release $version"
    git tag --annotate --message "Afferent $version" "$tag"
    git archive --format=tar.gz --prefix="$name/" --output="$work/$name.tar.gz" "$tag"
)
echo "Building the package from $name.tar.gz"
tar -xzf "$work/$name.tar.gz" -C "$work"
(
    cd "$work/$name"
    scripts/build.sh release -DCMAKE_INSTALL_PREFIX=/usr -DAFFERENT_PYTHON=ON \
        -DAFFERENT_PYTHON_DESTINATION=lib/python3/dist-packages afferent afferent_python
    (cd build/release && cpack --config CPackConfig.cmake) >"$work/cpack.log" 2>&1 || {
        tail -n 20 "$work/cpack.log" >&2
        exit 1
    }
)
mkdir -p "$folder"
cp "$work/$name.tar.gz" "$work/$name"/build/release/*.deb "$folder/"
package=$(cd "$work/$name/build/release" && ls afferent_*.deb)

scripts/check-package.sh "$folder/$package" "$version"

git fetch --quiet "$work/clone" "refs/tags/$tag:refs/tags/$tag"
git merge --quiet --ff-only "$tag"
echo "Afferent $version is tagged $tag. To publish: git push origin HEAD $tag"
echo "$folder: $name.tar.gz $package python3-$package"
