#!/usr/bin/env python3
"""What other people's programs find in the files that `afferent convert` writes, as h5py shows it.

other_readers.py AFFERENT: exits with 77 where h5py is not installed.

What NWB asks for is from its published schema (nwb-schema 2.6.0: nwb.file.yaml, nwb.misc.yaml; hdmf-common-schema 1.6.0:
table.yaml); what SONATA asks for, from its developer guide.
"""
import datetime
import pathlib
import subprocess
import sys
import tempfile

try:
    import h5py
    import numpy
except ImportError:
    sys.exit(77)

TICK_S = 1e-4
PATCHES = [("thumb", 3), ("index", 2), ("palm", 4)]
# The palm feels nothing: its afferents are silent.
SCENE = """
duration_s: 2 record { picture: false }
patch { name: "thumb" elements: 3 }
patch { name: "index" elements: 2 }
patch { name: "palm" elements: 4 share: [0, 0, 0, 0] encoder { sustained { gain_mv_per_n: 1 } } }
source { profile { point { time_s: 0 force_n: 1 } point { time_s: 2 force_n: 12 } } }
link { tcp {} tick_us: 100 }
decoder { patch: "thumb" }
"""


def expect(holds, what):
    if not holds:
        sys.exit("not so: " + what)


def text(value):
    return value.decode() if isinstance(value, bytes) else value


def check_type(thing, namespace, name):
    expect(text(thing.attrs["namespace"]) == namespace, f"{thing.name}: namespace {namespace}")
    expect(text(thing.attrs["neurodata_type"]) == name, f"{thing.name}: neurodata_type {name}")
    expect(len(text(thing.attrs["object_id"])) == 36, f"{thing.name}: object_id is a UUID")


def check_column(dataset, name):
    check_type(dataset, "hdmf-common", name)
    expect(text(dataset.attrs["description"]), f"{dataset.name}: description")


def check_session(file):
    check_type(file, "core", "NWBFile")
    expect(text(file.attrs["nwb_version"]).startswith("2."), "nwb_version")
    for group in ("acquisition", "analysis", "processing", "stimulus", "stimulus/presentation", "stimulus/templates",
                  "general"):
        expect(isinstance(file[group], h5py.Group), "group " + group)
    for scalar in ("identifier", "session_description", "session_start_time", "timestamps_reference_time"):
        expect(file[scalar].shape == () and text(file[scalar][()]), scalar + " is a text")
    dates = [text(date) for date in file["file_create_date"][:]]
    for date in dates + [text(file["session_start_time"][()]), text(file["timestamps_reference_time"][()])]:
        parsed = datetime.datetime.fromisoformat(date.replace("Z", "+00:00"))
        expect(parsed.tzinfo is not None, date + " has a time zone")


def check_nwb(path, patches, events):
    with h5py.File(path) as file:
        check_session(file)
        units = file["units"]
        check_type(units, "core", "Units")
        expect(text(units.attrs["description"]), "units has a description")
        names = [text(name) for name in units.attrs["colnames"]]
        expect(names == ["patch", "spike_times"], f"colnames are {names}")
        check_type(units["id"], "hdmf-common", "ElementIdentifiers")
        check_column(units["patch"], "VectorData")
        check_column(units["spike_times"], "VectorData")
        check_column(units["spike_times_index"], "VectorIndex")
        index = units["spike_times_index"]
        expect(index.dtype.kind == "u", "spike_times_index is unsigned")
        expect(file[index.attrs["target"]] == units["spike_times"], "the index names its target")
        resolution = units["spike_times"].attrs["resolution"]
        expect(resolution == TICK_S, f"resolution is {resolution}")
        count = sum(size for _, size in patches)
        expect(list(units["id"][:]) == list(range(count)), "every afferent has a unit, silent or not")
        expected = [name for name, size in patches for _ in range(size)]
        expect([text(name) for name in units["patch"][:]] == expected, "the units' patches")
        ends = index[:].astype(int)
        begins = numpy.concatenate(([0], ends[:-1]))
        found = sorted((round(time / TICK_S), unit) for unit in range(count)
                       for time in units["spike_times"][begins[unit]:ends[unit]])
        expect(found == events, "the events in NWB")


def check_sonata(path, patches, events):
    with h5py.File(path) as file:
        expect(file.attrs["magic"] == 0x0A7A, "magic")
        expect(list(file.attrs["version"]) == [0, 1], "version")
        found = []
        first = 0
        for name, size in patches:
            population = file["spikes"][name]
            times = population["timestamps"]
            expect(text(times.attrs["units"]) == "ms", "timestamps are in ms")
            expect(bool((numpy.diff(times[:]) >= 0).all()), "spikes are sorted by time")
            sorting = h5py.check_enum_dtype(population.attrs.get_id("sorting").dtype)
            expect(population.attrs["sorting"] == sorting["by_time"], "and say so")
            nodes = file["nodes"][name]
            for column in ("node_id", "node_type_id", "node_group_id", "node_group_index"):
                expect(len(nodes[column]) == size, f"{column} of {name} has every node")
            found += [(round(time / 1e3 / TICK_S), first + int(node))
                      for time, node in zip(times[:], population["node_ids"][:])]
            first += size
        expect(set(file["spikes"]) == {name for name, _ in patches}, "a population for each patch")
        expect(sorted(found) == events, "the events in SONATA")


def main(program):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)

        def afferent(*arguments):
            subprocess.run([program, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)

        (folder / "scene.txtpb").write_text(SCENE)
        afferent("run", folder / "scene.txtpb", "--record", folder / "r.afferent")
        for ending in ("csv", "nwb", "sonata.h5"):
            afferent("convert", folder / "r.afferent", folder / ("r." + ending))
        rows = (folder / "r.csv").read_text().splitlines()[1:]
        events = sorted((round(float(time) / TICK_S), int(address)) for time, address in (row.split(",") for row in rows))
        check_nwb(folder / "r.nwb", PATCHES, events)
        check_sonata(folder / "r.sonata.h5", PATCHES, events)
        print(f"{len(events)} events, as written")


if __name__ == "__main__":
    main(*sys.argv[1:])
