"""Results as Neo has them."""

from __future__ import annotations

from typing import Any

import neo
import numpy as np
import quantities as pq

from ._results import EventSet, Result


def block_of(events: EventSet) -> neo.Block:
    """One segment, with a SpikeTrain for each afferent, silent or not, and an AnalogSignal for each force."""
    result = events if isinstance(events, Result) else None
    name = (result.scene.name or result.scene.file) if result else "events"
    block = neo.Block(name=name, description="Afferent")
    segment = neo.Segment(name=name)
    block.segments.append(segment)
    times_ns = events.events["time"]
    end_s = result.summary["duration_s"] if result else (times_ns[-1] * 1e-9 if len(times_ns) else 0.0)
    if len(times_ns):
        end_s = max(end_s, times_ns[-1] * 1e-9)
    by_address = np.argsort(events.events["address"], kind="stable")
    ends = np.searchsorted(events.events["address"][by_address], np.arange(events.neurons), side="right")
    for address, spikes in enumerate(np.split(times_ns[by_address], ends)[:-1]):
        train = neo.SpikeTrain(spikes * 1e-9, units="s", t_start=0 * pq.s, t_stop=end_s * pq.s,
                               name=f"afferent {address}", **_annotations(events, address))
        train.segment = segment
        segment.spiketrains.append(train)
    if result is not None and len(result.force) > 1:
        rate_hz = (len(result.force) - 1) / float(result.force["time"][-1] - result.force["time"][0]) * 1e9
        start = result.force["time"][0] * 1e-9 * pq.s

        def add(values: Any, units: Any, name: str, **annotations: Any) -> None:
            signal = neo.AnalogSignal(np.asarray(values), units=units, sampling_rate=rate_hz * pq.Hz, t_start=start,
                                      name=name, **annotations)
            signal.segment = segment
            segment.analogsignals.append(signal)

        for quantity in ("true", "estimate", "sigma"):
            add(result.force[quantity], pq.N, f"force {quantity}", quantity=quantity, part="grip")
        add(result.force["rate"], pq.Hz, "rate", quantity="rate", part="grip")
        add(result.force["gain"], pq.dimensionless, "gain", quantity="gain", part="grip")
        for part, rows in result.parts.items():
            for quantity in ("true", "estimate", "sigma"):
                add(rows[quantity], pq.N, f"{part} force {quantity}", quantity=quantity, part=part)
    return block


def _annotations(events: EventSet, address: int) -> dict[str, Any]:
    annotations: dict[str, Any] = {"address": address}
    for patch in events.patches:
        if patch.first <= address < patch.first + patch.afferents:
            annotations.update(patch=patch.name, kind=patch.kind)
    if address < len(events.afferents):
        row = events.afferents[address]
        annotations.update(element=int(row["element"]), x_mm=float(row["x_mm"]), y_mm=float(row["y_mm"]))
    return annotations
