# Sourced by scripts that try Afferent where nothing of it is installed: makes a Debian 12 with nothing but git and
# ca-certificates in $1/root, or in a temporary folder where $1 is empty, and defines in_root, which runs a command in
# it. Sets $root. Takes root and debootstrap. Packages come from where this machine takes them. A given folder is kept,
# and is emptied before each run; a temporary one is removed at the end.

if [ "$(id -u)" -ne 0 ]; then
    echo "debootstrap and chroot take root." >&2
    exit 1
fi
scripts/install-dependencies.sh release
mirror=$(apt-get indextargets --format '$(SITE) $(CODENAME)' 'Created-By: Packages' 2>/dev/null |
    sed -n 's/ bookworm$//p' | head -n 1)
mirror=${mirror:-http://deb.debian.org/debian}

given=${1:-}
root=${given:-$(mktemp -d)}/root
mounted=
leave() {
    for folder in $mounted; do umount "$folder" || true; done
    # Nothing is removed while something of this machine may still be mounted below.
    if [ -z "$given" ] && ! grep -q " $root/" /proc/mounts; then rm -rf "${root%/root}"; fi
}
trap leave EXIT
trap "exit 1" HUP INT TERM
mount_in() {
    mount "$@"
    for folder in "$@"; do :; done
    mounted="$folder $mounted"
}
in_root() {
    chroot "$root" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 \
        ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} "$@"
}

if grep -q " $root/" /proc/mounts; then
    echo "Something is mounted below $root: unmount it first." >&2
    exit 1
fi
rm -rf "$root"
mkdir -p "$root"
echo "A minimal Debian 12 from $mirror in $root"
if ! debootstrap --variant=minbase --include=git,ca-certificates bookworm "$root" "$mirror" \
    >"${root%/root}/debootstrap.log" 2>&1; then
    tail -n 20 "${root%/root}/debootstrap.log" >&2
    exit 1
fi
# This machine's way to its packages: sources, proxies, certificates, names.
for settings in /etc/apt/sources.list /etc/apt/sources.list.d /etc/apt/apt.conf.d /etc/apt/keyrings \
    /etc/resolv.conf /etc/hosts; do
    if [ -e "$settings" ]; then
        mkdir -p "$root$(dirname "$settings")"
        cp -rL "$settings" "$root$(dirname "$settings")/"
    fi
done
mount_in -t proc proc "$root/proc"
mount_in -t tmpfs -o mode=1777 tmpfs "$root/dev/shm"
mkdir -p "$root/dev/pts"
mount_in -t devpts -o newinstance,ptmxmode=0666 devpts "$root/dev/pts"
ln -sf pts/ptmx "$root/dev/ptmx"
