#!/usr/bin/env python3
"""Scans in HDF5, as h5py writes them, give the events of the same scans in a CSV table.

recorded_scans.py AFFERENT: exits with 77 where h5py is not installed.
"""
import pathlib
import subprocess
import sys
import tempfile

try:
    import h5py
    import numpy
except ImportError:
    sys.exit(77)

SCENE = """
duration_s: 1 record { force: false picture: false }
patch { name: "a" elements: 5 } patch { name: "b" elements: 3 }
source { table { %s } }
"""


def main(program):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)

        def run(what, table):
            scene = folder / (what + ".txtpb")
            scene.write_text(SCENE % table)
            return subprocess.run([program, "run", scene, "--out", folder / what], capture_output=True, text=True)

        time_s = numpy.arange(200) / 200
        force_n = numpy.abs(numpy.sin(3 * time_s[:, None] + numpy.arange(8))) * 4
        rows = [",".join(map(repr, map(float, (time, *forces)))) for time, forces in zip(time_s, force_n)]
        head = "time_s," + ",".join(f"e{i}_n" for i in range(8))
        (folder / "scans.csv").write_text("\n".join([head, *rows]) + "\n")
        with h5py.File(folder / "scans.h5", "w") as file:
            # Compressed in pieces, as recorders write them.
            file.create_dataset("run/force_n", data=force_n, chunks=(16, 8), compression="gzip")
            file["run/time_s"] = time_s
            file["rate/force_n"] = force_n
            file["rate/force_n"].attrs["rate_hz"] = 200
            file["raw"] = force_n
        expected = run("csv", 'path: "scans.csv"')
        assert expected.returncode == 0, expected.stderr
        events = (folder / "csv" / "events.csv").read_text()
        assert events.count("\n") > 100, "there are events to compare"
        for column in ("run/force_n", "rate/force_n"):
            found = run("hdf5", f'path: "scans.h5" column: "{column}"')
            assert found.returncode == 0, found.stderr
            assert (folder / "hdf5" / "events.csv").read_text() == events, column
        refused = run("refused", 'path: "scans.h5" column: "raw"')
        assert refused.returncode != 0
        assert "raw has no attribute rate_hz, and time_s is missing" in refused.stderr, refused.stderr
        (folder / "scans.h5").write_bytes(b"no HDF5")
        assert "is not an HDF5 file" in run("broken", 'path: "scans.h5" column: "raw"').stderr


if __name__ == "__main__":
    main(*sys.argv[1:])
