"""Events in HDF5, as `afferent convert` and others write them, read by h5py."""

from __future__ import annotations

import csv
import pathlib
from typing import Any, Sequence

import h5py
import numpy as np

from . import _afferent
from ._results import EventSet, Patch
from .errors import DataError

AFFERENT = np.dtype([("address", "u4"), ("patch", "u4"), ("element", "u4"), ("elements", "u4"), ("x_mm", "f8"),
                     ("y_mm", "f8")])


def read_nwb(file: str) -> EventSet:
    """The table /units of NWB 2; patches are runs of equal names."""
    with _open(file) as nwb:
        if "units" not in nwb:
            raise DataError(f"{file}: has no table of units")
        units = nwb["units"]
        ids = units["id"][:].astype(np.int64)
        ends = units["spike_times_index"][:].astype(np.int64)
        times = units["spike_times"][:]
        if len(ends) != len(ids) or (np.diff(ends, prepend=0) < 0).any() or (ends[-1] if len(ends) else 0) != len(times):
            raise DataError(f"{file}: spike_times_index does not fit its units")
        addresses = np.repeat(ids, np.diff(ends, prepend=0))
        names = [_text(name) for name in units["patch"][:]] if "patch" in units else []
        kinds = [_text(kind) for kind in units["kind"][:]] if "kind" in units else [""] * len(names)
        patches: list[Patch] = []
        if len(names) == len(ids) and (ids == np.arange(len(ids))).all():
            for row, name in enumerate(names):
                if not patches or patches[-1].name != name:
                    patches.append(Patch(name, row, 0, kinds[row]))
                patches[-1] = patches[-1]._replace(afferents=patches[-1].afferents + 1)
        afferents = _afferents(patches, [units], ("x_mm", "y_mm"), 1.0)
        tick_s = float(units["spike_times"].attrs.get("resolution", 1e-9))
        return EventSet(_events(file, times, 1e9, addresses), tuple(patches), afferents, max(1, round(tick_s * 1e9)))


def read_sonata(file: str) -> EventSet:
    """The populations of /spikes, in the order of their addresses, with their nodes from the file beside it."""
    path = pathlib.Path(file)
    stem = path.name[: -len(".sonata.h5")]
    nodes_path = path.with_name(stem + ".nodes.h5")
    with _open(file) as sonata:
        if "spikes" not in sonata:
            raise DataError(f"{file}: has no spikes")
        spikes = sonata["spikes"]
        names = sorted(spikes, key=lambda name: int(spikes[name].attrs.get("first_address", 0)))
        firsts = [int(spikes[name].attrs.get("first_address", 0)) for name in names]
        times = [spikes[name]["timestamps"][:] for name in names]
        nodes = [spikes[name]["node_ids"][:].astype(np.int64) + first for name, first in zip(names, firsts)]
        ticks = [float(spikes[name]["timestamps"].attrs.get("resolution", 1e-6)) for name in names]
    patches: list[Patch] = []
    afferents = np.empty(0, AFFERENT)
    if nodes_path.exists():
        kinds = _node_types(path.with_name(stem + ".node_types.csv"))
        with _open(str(nodes_path)) as known:
            for name, first in zip(names, firsts):
                patches.append(Patch(name, first, len(known["nodes"][name]["node_id"]), kinds.get(name, "")))
            groups = [known["nodes"][name].get("0", {}) for name in names]
            afferents = _afferents(patches, groups, ("x", "y"), 1e-3)
    events = _events(file, np.concatenate([*times, []]), 1e6, np.concatenate([*nodes, []]).astype(np.int64))
    return EventSet(events, tuple(patches), afferents, max(1, round(min(ticks, default=1e-6) * 1e6)))


def _open(file: str) -> Any:
    try:
        return h5py.File(file, "r")
    except FileNotFoundError:
        raise
    except OSError as error:
        raise DataError(f"{file}: is not HDF5, or is damaged: {error}") from None


def _text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


def _events(file: str, times: Any, ns: float, addresses: Any) -> Any:
    if not np.isfinite(times).all() or (times < 0).any():
        raise DataError(f"{file}: a spike's time is not a time since the start")
    if len(addresses) and not (0 <= addresses.min() and addresses.max() < 2**32):
        raise DataError(f"{file}: the number of a unit must be below 2^32")
    events = np.empty(len(times), _afferent.event_dtype)
    events["time"] = np.rint(times * ns)
    events["address"] = addresses
    return events[np.lexsort((events["address"], events["time"]))]


def _afferents(patches: Sequence[Patch], groups: Sequence[Any], places: tuple[str, str], mm: float) -> Any:
    rows = np.zeros(sum(patch.afferents for patch in patches), AFFERENT)
    rows["address"] = np.arange(len(rows))
    rows["patch"] = np.repeat(np.arange(len(patches)), [patch.afferents for patch in patches])

    def column(name: str, empty: float) -> Any:
        columns = [group[name][:] if name in group else None for group in groups]
        if len(groups) == 1 and columns[0] is not None:
            return columns[0]
        return np.concatenate([np.full(patch.afferents, empty) if values is None else values
                               for patch, values in zip(patches, columns)] or [[]])

    if len(rows):
        rows["element"], rows["elements"] = column("element", 0), column("elements", 0)
        for name, place in zip(("x_mm", "y_mm"), places):
            rows[name] = column(place, np.nan) * mm
    return rows


def _node_types(file: pathlib.Path) -> dict[str, str]:
    if not file.exists():
        return {}
    with open(file, newline="") as table:
        return {row["population"]: row.get("kind", "") for row in csv.DictReader(table, delimiter=" ")}
