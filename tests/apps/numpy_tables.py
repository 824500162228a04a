#!/usr/bin/env python3
"""Tables in NPZ, NPY and HDF5, as NumPy and h5py write them, give the events of the same table in text.

numpy_tables.py AFFERENT: exits with 77 where NumPy or h5py is not installed.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

try:
    import h5py
    import numpy
except ImportError:
    sys.exit(77)


def main(program):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)

        def events(file, *options):
            scene = folder / "scene.txtpb"
            found = subprocess.run([program, "inspect", folder / file, "--scene", scene, *options],
                                   capture_output=True, text=True)
            assert found.returncode == 0, file + ": " + found.stderr
            ran = subprocess.run([program, "run", scene, "--out", folder / "out", "--json"], capture_output=True, text=True)
            assert ran.returncode == 0, file + ": " + ran.stderr
            assert json.loads(ran.stdout)["events"] > 100, file
            return (folder / "out" / "events.csv").read_text()

        t_ms = 1000 + 4 * numpy.arange(500)
        volts = numpy.round(numpy.abs(numpy.sin(t_ms[:, None] / 700 + numpy.arange(3))) * 4 * 256) / 256
        rows = ["\t".join(map(str, (time, *row))) for time, row in zip(t_ms, volts)]
        (folder / "text.csv").write_text("\n".join(["t_ms\tv_1_v\tv_2_v\tv_3_v", *rows]) + "\n")
        expected = events("text.csv")

        numpy.savez(folder / "plain.npz", t_ms=t_ms, v_v=volts)
        numpy.savez_compressed(folder / "packed.npz", t_ms=t_ms.astype(">i4"), v_v=numpy.asfortranarray(volts),
                               names=numpy.array(["a", "b"]), things=numpy.array([{}], dtype=object))
        numpy.savez(folder / "half.npz", t_ms=t_ms.astype("u2"), v_v=volts.astype("f4"))
        for file in ("plain.npz", "packed.npz", "half.npz"):
            assert events(file) == expected, file
        numpy.savez(folder / "dates.npz", time=numpy.datetime64("2026-11-22T10:00:00", "ms") + t_ms, v_v=volts)
        assert events("dates.npz", "--begin-s", str(1795341600)) == expected
        numpy.save(folder / "table.npy", numpy.column_stack([t_ms, volts]))
        assert events("table.npy", "--time-column", "1", "--time-unit", "ms", "--unit", "volts") == expected

        with h5py.File(folder / "plain.h5", "w") as file:
            file["t_ms"] = t_ms
            file["v_1_v"], file["v_2_v"], file["v_3_v"] = volts.T
            file.create_dataset("run/v_v", data=volts, compression="gzip")
            file["run/t"] = t_ms / 1000
            file["other"] = numpy.arange(7)
        assert events("plain.h5") == expected
        assert events("plain.h5", "--columns", "run/v_v") == expected

        # A gigabyte of zeros in a megabyte ends soon, whatever it says.
        numpy.savez_compressed(folder / "bomb.npz", t_ms=numpy.zeros(1 << 27, "i1"), v_v=numpy.zeros(1 << 27, "i1"))
        bomb = subprocess.run([program, "inspect", folder / "bomb.npz"], capture_output=True, text=True, timeout=100)
        assert bomb.returncode == 1 and "bomb.npz: " in bomb.stderr, bomb.stderr


if __name__ == "__main__":
    main(sys.argv[1])
