#!/usr/bin/env python3
"""What other people's programs find in the files that `afferent convert` writes, as h5py shows it.

other_readers.py AFFERENT: exits with 77 where h5py is not installed.

What NWB asks for stands in NWB_TYPES: nwb-schema 2.6.0 (nwb.base.yaml, nwb.file.yaml, nwb.misc.yaml) over
hdmf-common-schema (base.yaml, table.yaml), the same from 1.5.0 to 1.8.0. How it is stored is in the former's
storage_hdf5.rst.
What SONATA asks for is from its developer guide.
"""
import csv
import datetime
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import uuid

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
KINDS = ["sustained", "sustained", "sustained"]
# Afferents of two kinds at places of their own; the edge reaches the left half of them.
SKIN_PATCHES = [("skin", 15), ("deep", 3)]
SKIN_KINDS = ["SA1", "PC"]
SKIN = """
duration_s: 0.3 record { force: false picture: false }
patch { name: "skin" kind: SA1 outline { rectangle { width_mm: 5 height_mm: 4 } pitch_mm: 0.5 }
        sensor { rate_hz: 1000 full_scale_n: 0.02 adc_bits: 20 } }
patch { name: "deep" kind: PC elements_of: "skin"
        afferents { place { x_mm: -2 y_mm: 1 } place { x_mm: 0 y_mm: 0 } place { x_mm: 2 y_mm: -1 } } }
source { edge { speed_mm_per_s: 20 begin_mm: -5 } }
link { tcp {} tick_us: 100 }
"""


def expect(holds, what):
    if not holds:
        sys.exit("not so: " + what)


def text(value):
    return value.decode() if isinstance(value, bytes) else value


# --- NWB. What each type of the schema requires. Optional parts that we write are checked where a file has them.
# An attribute is (dtype, dimensions), a member (type, dtype, dimensions); None: any.


class Type:
    def __init__(self, namespace, parent, attributes=(), datasets=(), groups=(), optional=(), dtype=None,
                 dimensions=None):
        self.namespace = namespace
        self.parent = parent
        self.attributes = dict(attributes)
        self.datasets = dict(datasets)
        self.groups = groups
        self.optional = dict(optional)
        self.dtype = dtype
        self.dimensions = dimensions


NWB_TYPES = {
    "Container": Type("hdmf-common", None),
    "Data": Type("hdmf-common", None),
    "VectorData": Type("hdmf-common", "Data", attributes={"description": ("text", 0)}, dimensions=(1, 2, 3, 4)),
    "VectorIndex": Type("hdmf-common", "VectorData", attributes={"target": ("reference to VectorData", 0)},
                        dtype="uint8", dimensions=(1,)),
    "ElementIdentifiers": Type("hdmf-common", "Data", dtype="int", dimensions=(1,)),
    "DynamicTable": Type("hdmf-common", "Container", attributes={"colnames": ("text", 1), "description": ("text", 0)},
                         datasets={"id": ("ElementIdentifiers", "int", 1)}),
    "NWBContainer": Type("core", "Container"),
    "NWBFile": Type("core", "NWBContainer", attributes={"nwb_version": ("text", 0)},
                    datasets={"file_create_date": (None, "isodatetime", 1), "identifier": (None, "text", 0),
                              "session_description": (None, "text", 0), "session_start_time": (None, "isodatetime", 0),
                              "timestamps_reference_time": (None, "isodatetime", 0)},
                    groups=("acquisition", "analysis", "processing", "stimulus", "stimulus/presentation",
                            "stimulus/templates", "general"),
                    optional={"units": ("Units", None, None)}),
    "Units": Type("core", "DynamicTable",
                  optional={"spike_times": ("VectorData", "float64", None),
                            "spike_times_index": ("VectorIndex", "uint8", 1)}),
}
# The smallest that each may be stored as; larger ones of its kind are allowed.
SMALLEST = {"int": ("i", 4), "uint8": ("u", 1), "float64": ("f", 8)}


def ancestry(name):
    """The type and those that it extends."""
    while name:
        expect(name in NWB_TYPES, "the schema has a type " + name)
        yield NWB_TYPES[name]
        name = NWB_TYPES[name].parent


def extends(name, base):
    return name == base or NWB_TYPES[base] in list(ancestry(name))


def type_of(thing):
    return text(thing.attrs.get("neurodata_type", ""))


def check_storage(where, stored, values, dtype, dimensions):
    """That a dtype of the schema is stored as it says, in as many dimensions."""
    expect(dimensions is None or len(stored.shape) == dimensions, f"{where} has {dimensions} dimensions")
    if dtype in ("text", "isodatetime"):
        kind = h5py.check_string_dtype(stored.dtype)
        expect(kind is not None and kind.length is None, where + " is a text of variable length")
        expect(kind.encoding == "utf-8" or dtype == "isodatetime", where + " is in UTF-8")
        if dtype == "isodatetime":
            for date in numpy.ravel(values):
                parsed = datetime.datetime.fromisoformat(text(date).replace("Z", "+00:00"))
                expect(parsed.tzinfo is not None, f"{where} has a time zone")
    elif dtype in SMALLEST:
        kind, bytes_at_least = SMALLEST[dtype]
        expect(stored.dtype.kind == kind and stored.dtype.itemsize >= bytes_at_least, f"{where} is {dtype} or larger")


def check_attribute(thing, name, dtype, dimensions):
    where = f"{thing.name}, attribute {name}"
    expect(name in thing.attrs, where)
    stored = thing.attrs.get_id(name)
    if dtype.startswith("reference to "):
        expect(h5py.check_ref_dtype(stored.dtype) is h5py.Reference, where + " is a reference to an object")
        base = dtype[len("reference to "):]
        expect(extends(type_of(thing.file[thing.attrs[name]]), base), f"{where} refers to {base}")
    check_storage(where, stored, thing.attrs[name], dtype, dimensions)


def check_typed(thing):
    """What the schema requires of an object that says its type."""
    name = type_of(thing)
    lineage = list(ancestry(name))
    expect(text(thing.attrs["namespace"]) == lineage[0].namespace, f"{thing.name}: the namespace of {name}")
    expect(str(uuid.UUID(text(thing.attrs["object_id"]))) == text(thing.attrs["object_id"]),
           f"{thing.name}: object_id is a UUID")
    for of in lineage:
        for attribute, (dtype, dimensions) in of.attributes.items():
            check_attribute(thing, attribute, dtype, dimensions)
        for group in of.groups:
            expect(isinstance(thing.get(group), h5py.Group), f"{thing.name} has a group {group}")
        for child, (child_type, dtype, dimensions) in list(of.datasets.items()) + list(of.optional.items()):
            if child not in thing and child in of.optional:
                continue
            expect(child in thing, f"{thing.name} has {child}")
            expect(child_type is None or extends(type_of(thing[child]), child_type), f"{child} is a {child_type}")
            if isinstance(thing[child], h5py.Dataset):
                check_storage(thing[child].name, thing[child], thing[child][()], dtype, dimensions)
        if isinstance(thing, h5py.Dataset):
            expect(of.dimensions is None or len(thing.shape) in of.dimensions,
                   f"{thing.name} has one of {of.dimensions} dimensions")
            check_storage(thing.name, thing, thing[()], of.dtype, None)


def check_table(table):
    """What the schema says in words: columns have a row for each id; those of several cells a row are indexed."""
    columns = [text(name) for name in table.attrs["colnames"]]
    for name, dataset in table.items():
        expect(name == "id" or name in columns or name[:-len("_index")] in columns, f"colnames tells of {name}")
        expect(name == "id" or extends(type_of(dataset), "VectorData"), f"{name} is a column")
    for name in columns:
        expect(name in table, f"{table.name} has the column {name}")
        rows = table[name]
        if name + "_index" in table:
            index = table[name + "_index"]
            expect(table.file[index.attrs["target"]] == rows, f"{index.name} names its target")
            ends = index[:].astype(int)
            expect((numpy.diff(ends, prepend=0) >= 0).all(), f"{index.name} does not fall")
            expect((ends[-1] if len(ends) else 0) == len(rows), f"{index.name} ends with its column")
            rows = index
        expect(len(rows) == len(table["id"]), f"{name} has a row for each id")


def check_schema(file):
    """Everything in the file that has a type; returns the types that were found."""
    found = set()

    def visit(thing):
        if "neurodata_type" in thing.attrs:
            check_typed(thing)
            found.add(type_of(thing))
            if extends(type_of(thing), "DynamicTable"):
                check_table(thing)

    visit(file)
    file.visititems(lambda _, thing: visit(thing))
    expect(type_of(file) == "NWBFile", "the file is an NWBFile")
    expect(text(file.attrs["nwb_version"]) == "2.6.0", "the version that the schema fixes")
    return found


def afferent_rows(path):
    """What the table of afferents says, by address."""
    with open(path, newline="") as table:
        rows = list(csv.DictReader(table))
    expect([int(row["address"]) for row in rows] == list(range(len(rows))), "a row for each address")
    expect({int(row["resolution_ns"]) for row in rows} == {round(TICK_S * 1e9)}, "the tick of the events")
    return rows


def same_place(written, found):
    # In micrometres and back a double is rounded twice: by 2^-53 each time.
    return math.isnan(found) if written == "" else math.isclose(float(written), found, rel_tol=2.3e-16)


def check_columns(table, rows, first=0, x="x_mm", y="y_mm", per_mm=1):
    """That columns of a table say of its afferents what the rows do."""
    here = rows[first:first + len(table["element"])]
    for name in ("element", "elements"):
        expect([int(value) for value in table[name][:]] == [int(row[name]) for row in here], name)
    has_positions = any(row["x_mm"] != "" for row in here)
    expect((x in table) == has_positions, "places where there are any")
    for name, column in ((x, "x_mm"), (y, "y_mm")) if has_positions else ():
        expect(all(same_place(row[column], value / per_mm) for row, value in zip(here, table[name][:])), name)


def check_nwb(path, patches, kinds, rows, events):
    with h5py.File(path) as file:
        found = check_schema(file)
        expect(found == {"NWBFile", "Units", "ElementIdentifiers", "VectorData", "VectorIndex"}, f"types are {found}")
        units = file["units"]
        names = [text(name) for name in units.attrs["colnames"]]
        places = ["x_mm", "y_mm"] if rows and rows[0]["x_mm"] else []
        told = ["patch", "kind", *places, "element", "elements"] if patches else []
        expect(names == told + ["spike_times"], f"colnames are {names}")
        resolution = units["spike_times"].attrs["resolution"]
        expect(resolution.dtype == numpy.float64, "resolution is float64")
        ids = [int(id) for id in units["id"][:]]
        if patches:
            expect(resolution == TICK_S, f"resolution is {resolution}")
            count = sum(size for _, size in patches)
            expect(ids == list(range(count)), "every afferent has a unit, silent or not")
            expected = [name for name, size in patches for _ in range(size)]
            expect([text(name) for name in units["patch"][:]] == expected, "the units' patches")
            expected = [kind for kind, (_, size) in zip(kinds, patches) for _ in range(size)]
            expect([text(name) for name in units["kind"][:]] == expected, "the units' kinds")
            check_columns(units, rows)
        else:
            expect(ids == sorted({address for _, address in events}), "each afferent that fired has a unit")
        ends = units["spike_times_index"][:].astype(int)
        begins = numpy.concatenate(([0], ends[:-1])).astype(int)
        found = sorted((round(time / TICK_S), ids[row]) for row in range(len(ids))
                       for time in units["spike_times"][begins[row]:ends[row]])
        expect(found == events, "the events in NWB")


def check_that_losses_are_noticed(path):
    """Whatever is taken out of a file, but what is optional, check_schema misses."""
    optional = {("/units", None), ("/units/spike_times", "resolution")}
    parts = [("/", attribute) for attribute in ("namespace", "neurodata_type", "object_id", "nwb_version")]
    with h5py.File(path) as file:
        file.visititems(lambda name, thing: parts.extend(
            [("/" + name, None)] + [("/" + name, attribute) for attribute in thing.attrs]))
    copy = path.with_suffix(".less.nwb")
    for name, attribute in parts:
        if (name, attribute) in optional:
            continue
        shutil.copy(path, copy)
        with h5py.File(copy, "r+") as file:
            if attribute is None:
                del file[name]
            else:
                del file[name].attrs[attribute]
            try:
                check_schema(file)
            except (SystemExit, KeyError):
                continue
        expect(False, f"a file without {name} {attribute or ''} is refused")
    return len(parts) - len(optional)


def check_sonata(path, patches, kinds, rows, events):
    stem = path.name[:-len(".sonata.h5")]
    with open(path.with_name(stem + ".node_types.csv"), newline="") as table:
        types = list(csv.DictReader(table, delimiter=" "))
    expect([row["population"] for row in types] == [name for name, _ in patches], "a node type for each patch")
    expect([row["kind"] for row in types] == kinds, "node types have kinds")
    expect({row["model_type"] for row in types} == {"virtual"}, "nodes are not simulated by their readers")
    with h5py.File(path) as file, h5py.File(path.with_name(stem + ".nodes.h5")) as nodes_file:
        expect(nodes_file.attrs["magic"] == 0x0A7A, "magic of the nodes")
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
            nodes = nodes_file["nodes"][name]
            for column in ("node_id", "node_type_id", "node_group_id", "node_group_index"):
                expect(len(nodes[column]) == size, f"{column} of {name} has every node")
            node_type = types[patches.index((name, size))]["node_type_id"]
            expect({int(id) for id in nodes["node_type_id"][:]} == {int(node_type)}, f"nodes of {name} have its type")
            check_columns(nodes["0"], rows, first, "x", "y", 1000)
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

        for scene, patches, kinds in ((SCENE, PATCHES, KINDS), (SKIN, SKIN_PATCHES, SKIN_KINDS)):
            (folder / "scene.txtpb").write_text(scene)
            afferent("run", folder / "scene.txtpb", "--record", folder / "r.afferent")
            for ending in ("csv", "nwb", "sonata.h5"):
                afferent("convert", folder / "r.afferent", folder / ("r." + ending))
            lines = (folder / "r.csv").read_text().splitlines()[1:]
            events = sorted((round(float(time) / TICK_S), int(address))
                            for time, address in (line.split(",") for line in lines))
            expect(len(events) > 20, "there are events to compare")
            rows = afferent_rows(folder / "r.afferents.csv")
            check_nwb(folder / "r.nwb", patches, kinds, rows, events)
            parts = check_that_losses_are_noticed(folder / "r.nwb")
            check_sonata(folder / "r.sonata.h5", patches, kinds, rows, events)
            # By way of another format each file is the same, to the tick.
            for other in ("r.csv", "r.nwb", "r.sonata.h5"):
                afferent("convert", folder / other, folder / "again.nwb")
                check_nwb(folder / "again.nwb", patches, kinds, rows, events)
            (folder / "r.afferents.csv").unlink()
            afferent("convert", folder / "r.csv", folder / "of_csv.nwb")  # which knows no patches
            check_nwb(folder / "of_csv.nwb", [], [], [], events)
            print(f"{len(events)} events, as written; {parts} parts that NWB requires")


if __name__ == "__main__":
    main(*sys.argv[1:])
