#!/bin/sh
# What scripts/build.sh says into a pipe while it builds, and of a build that fails: build_progress.sh SOURCE
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/scripts" "$folder/bin"
cp "$1/scripts/build.sh" "$folder/scripts"
# In place of CMake: ten steps of three seconds each, as ninja counts them.
cat >"$folder/bin/cmake" <<'END'
#!/bin/sh
[ "$1" = --build ] || exit 0
for step in 1 2 3 4 5 6 7 8 9 10; do
    echo "[$step/10 $((3 * step)).125] Building CXX object"
    # It goes on once what is said of the fifth is read, and fails if that is held back.
    [ "$step" != 5 ] || [ "$4" != afferent ] || timeout 60 sh -c "until [ -e read ]; do sleep 0.02; done" || exit 4
done
[ "$4" = afferent ] || { echo "error: no such thing"; exit 3; }
END
chmod +x "$folder/bin/cmake"
expect() {
    [ "$1" = "$2" ] || { printf '%s\ninstead of\n%s\n' "$1" "$2" >&2; exit 1; }
}

expect "$(PATH=$folder/bin:$PATH "$folder/scripts/build.sh" release afferent | while read -r line; do
    echo "$line"
    [ "${line#*50 %}" = "$line" ] || touch "$folder/read"
done)" 'Building release: 20 % after 6 s
Building release: 30 % after 9 s
Building release: 40 % after 12 s
Building release: 50 % after 15 s
Building release: 60 % after 18 s
Building release: 70 % after 21 s
Building release: 80 % after 24 s
Building release: 90 % after 27 s'
expect "$(grep -c Building "$folder/build/release/build.log")" 10

if PATH=$folder/bin:$PATH "$folder/scripts/build.sh" release other >"$folder/out" 2>"$folder/err"; then exit 1; fi
grep -q 'error: no such thing' "$folder/err"
grep -q 'build.log' "$folder/err"
