"""The libraries of Debian 12 that the compiled part and afferent-hdf5 link, by package. A wheel does not carry them, so that
they are kept up to date with the system."""

PACKAGES = (
    "libcsv3 libhdf5-103-1 libhwy1 libisal2 libmatio11 libprotobuf32 libsodium23 libssl3 libstdc++6 libtbb12 libzip4 zlib1g"
)  # fmt: skip

try:
    from . import _afferent as _afferent
except ImportError as error:
    if "cannot open shared object file" not in str(error):
        raise
    raise ImportError(f"{error}. On Debian 12: apt-get install {PACKAGES}") from error
