"""Events, and what else a run gives."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Mapping, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._scene import Scene

if TYPE_CHECKING:
    import neo
    import pandas

Array = NDArray[Any]


class Patch(NamedTuple):
    """The addresses first, first + 1, ... of one patch."""

    name: str
    first: int
    afferents: int
    kind: str  # "SA1", or "sustained"; "" where it is not known


class Frames(NamedTuple):
    """Tables with the columns of events.csv, force.csv and emg.csv."""

    events: pandas.DataFrame
    force: pandas.DataFrame
    emg: pandas.DataFrame


@dataclass(frozen=True, eq=False, repr=False)
class EventSet:
    """Events, and what is known of the afferents that might have fired.

    events        time (int64, ns since the start) and address (uint32), sorted
    patches       in the order of their addresses; none where they are not known
    afferents     address, patch (its index), element, elements, x_mm, y_mm; NaN where a patch has no dimensions
    resolution_ns the smallest difference between two times
    """

    events: Array
    patches: tuple[Patch, ...] = ()
    afferents: Array = field(default_factory=lambda: np.empty(0))
    resolution_ns: int = 1

    def __len__(self) -> int:
        return len(self.events)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({len(self):,} events of {self.neurons:,} afferents)"

    @property
    def neurons(self) -> int:
        """How many afferents there are; where that is not known, up to the last that fired."""
        if self.patches:
            return self.patches[-1].first + self.patches[-1].afferents
        return int(self.events["address"].max()) + 1 if len(self.events) else 0

    def times_s(self) -> Array:
        """The times of the events in seconds."""
        return self.events["time"] * 1e-9

    def to_neo(self) -> neo.Block:
        """A block of Neo, with a SpikeTrain for each afferent, for Elephant, SpikeInterface and their like."""
        from ._neo import block_of

        return block_of(self)


@dataclass(frozen=True, eq=False, repr=False)
class Result(EventSet):
    """What a run gives, or the replay of a recording. The arrays hold no copies of what was computed.

    force    a row for each step of the controller: time (int64, ns); true, estimate and sigma in N; rate in Hz;
             gain; doubt, "none" or why the force may be larger than the estimate. true is NaN where it is not known. Empty where nobody reads the estimate.
    emg      of the same steps: time; emg in counts; closing and opening effort, 0 to 1; command, -1 to 1
    parts    true, estimate, sigma and doubt of each patch or element, by name, for the times of force: where the scene says
             decoder { parts }
    readouts what has been read out of skin in two dimensions, by the name of its table: "contact", "touches"; with rows where
             the scene asks for them (docs/readouts.md). patch is the index of a patch; a number that is not known is NaN
    summary  counts, bytes, and the error of the estimate
    """

    scene: Scene = field(default_factory=Scene)
    force: Array = field(default_factory=lambda: np.empty(0))
    emg: Array = field(default_factory=lambda: np.empty(0))
    parts: Mapping[str, Array] = field(default_factory=dict)
    readouts: Mapping[str, Array] = field(default_factory=dict)
    summary: Mapping[str, Any] = field(default_factory=dict)

    def to_pandas(self) -> Frames:
        """Tables of pandas with the columns that the program writes."""
        import pandas

        events = pandas.DataFrame({"time_s": self.times_s(), "address": self.events["address"]})
        time_s = self.force["time"] * 1e-9
        force = pandas.DataFrame({
            "time_s": time_s, "true_force_n": self.force["true"], "estimate_n": self.force["estimate"],
            "sigma_n": self.force["sigma"], "rate_hz": self.force["rate"], "gain": self.force["gain"],
            "doubt": self.force["doubt"]})
        for name, part in self.parts.items():
            for column in ("true", "estimate", "sigma"):
                force[f"{name}_{column}_n"] = part[column]
            force[f"{name}_doubt"] = part["doubt"]
        names = ("emg", "closing", "opening", "command")
        emg = pandas.DataFrame({"time_s": time_s, **{name: self.emg[name] for name in names}})
        return Frames(events, force, emg)


def event_set_of(pieces: dict[str, Any]) -> EventSet:
    pieces["patches"] = tuple(Patch(*patch) for patch in pieces["patches"])
    return EventSet(**pieces)


def result_of(pieces: dict[str, Any]) -> Result:
    pieces["patches"] = tuple(Patch(*patch) for patch in pieces["patches"])
    pieces["scene"] = Scene._of(pieces["scene"])
    return Result(**pieces)
