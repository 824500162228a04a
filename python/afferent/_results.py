"""Events, and what else a run gives."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, Mapping, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _html
from ._scene import Scene

if TYPE_CHECKING:
    import neo
    import pandas

Array = NDArray[Any]
By = Literal["afferent", "patch"]

# Of the columns whose names have no unit; "" is a number without one.
UNITS: Mapping[str, str] = {
    "time": "ns", "told": "ns", "true": "N", "estimate": "N", "sigma": "N", "rate": "Hz", "gain": "", "emg": "counts",
    "closing": "", "opening": "", "command": "",
}  # fmt: skip


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

    The arrays are read-only: take a copy() to change one.
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

    @property
    def units(self) -> Mapping[str, str]:
        """The unit of each column that has none in its name: {"time": "ns", "estimate": "N", ...}."""
        return UNITS

    @property
    def end_s(self) -> float:
        """Until when there could have been events; of events alone, a moment after the last."""
        return (int(self.events["time"][-1]) + self.resolution_ns) * 1e-9 if len(self.events) else 0.0

    def times_s(self) -> Array:
        """The times of the events in seconds."""
        return self.events["time"] * 1e-9

    def counts(self, bin_s: float, *, by: By = "afferent", begin_s: float = 0, end_s: float | None = None) -> Array:
        """How many events are in each bin of time: an array with a row for each afferent, or for each patch, and a column
        for each bin of [begin_s, end_s), all rounded to nanoseconds. The last bin may reach beyond the end."""
        end_s = self.end_s if end_s is None else end_s
        if not (bin_s >= 1e-9 and math.isfinite(bin_s)):
            raise ValueError(f"bin_s must be at least a nanosecond, is {bin_s!r}")
        if not (math.isfinite(begin_s) and math.isfinite(end_s) and begin_s <= end_s):
            raise ValueError(f"begin_s must be at most end_s, and both finite; they are {begin_s!r} and {end_s!r}")
        begin, end, width = (round(1e9 * each_s) for each_s in (begin_s, end_s, bin_s))
        bins = -((begin - end) // width)
        bin_of = (self.events["time"] - begin) // width
        row_of, rows = self._rows(by)
        inside = (bin_of >= 0) & (bin_of < bins)
        flat = row_of[inside] * bins + bin_of[inside]
        return np.bincount(flat, minlength=rows * bins).reshape(rows, bins)

    def rates_hz(
        self, bin_s: float | None = None, *, by: By = "afferent", begin_s: float = 0, end_s: float | None = None
    ) -> Array:
        """Events per second of each afferent, or the mean of the afferents of each patch: over [begin_s, end_s), or in each
        bin of it, with a row for each as counts() has them."""
        end_s = self.end_s if end_s is None else end_s
        if bin_s is None and not end_s > begin_s:
            raise ValueError(f"rates take a span of time, and end_s is {end_s!r} where begin_s is {begin_s!r}")
        counts = self.counts(end_s - begin_s if bin_s is None else bin_s, by=by, begin_s=begin_s, end_s=end_s)
        afferents = np.array([patch.afferents for patch in self.patches]) if by == "patch" else np.ones(len(counts))
        rates: Array = counts / (end_s - begin_s if bin_s is None else bin_s) / afferents[:, np.newaxis]
        return rates.ravel() if bin_s is None else rates

    def trains_s(self) -> list[Array]:
        """The times in s at which each afferent fired: one array for each address."""
        order = np.argsort(self.events["address"], kind="stable")
        ends = np.searchsorted(self.events["address"][order], range(1, self.neurons + 1))
        return np.split(self.times_s()[order], ends)[: self.neurons]

    def intervals_s(self, address: int | None = None) -> Array:
        """The intervals in s from each event of an afferent to its next; without an address, those of all afferents, one
        afferent after the other."""
        if address is not None:
            return np.diff(self.times_s()[self.events["address"] == address])
        order = np.argsort(self.events["address"], kind="stable")
        same = np.diff(self.events["address"][order].astype(np.int64)) == 0
        intervals: Array = np.diff(self.times_s()[order])[same]
        return intervals

    def raster(self, axes: Any = None) -> Any:
        """Draws when each afferent fired, by matplotlib; returns the axes."""
        from . import plot

        return plot.raster(self, axes)

    def _rows(self, by: By) -> tuple[Array, int]:
        """The row of each event, and how many rows there are."""
        address = self.events["address"].astype(np.int64)
        if by == "afferent":
            return address, self.neurons
        if by != "patch":
            raise ValueError(f'by must be "afferent" or "patch", is {by!r}')
        if not self.patches:
            raise ValueError("the patches of these events are not known")
        return np.searchsorted([patch.first for patch in self.patches], address, side="right") - 1, len(self.patches)

    def _repr_html_(self) -> str:
        row_of, patches = self._rows("patch") if self.patches else (np.empty(0, np.int64), 0)
        counts = np.bincount(row_of, minlength=patches)
        rows = [
            (patch.name, patch.kind, f"{patch.afferents:,}", f"{counts[i]:,}",
             f"{counts[i] / patch.afferents / self.end_s:.4g}" if self.end_s > 0 and patch.afferents else "")
            for i, patch in enumerate(self.patches)
        ]  # fmt: skip
        return _html.table(repr(self), ("patch", "kind", "afferents", "events", "mean rate (Hz)"), rows)

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
    parts    true, estimate and sigma in N and doubt of each patch or element, by name, for the times of force: where the scene says
             decoder { parts }
    readouts what has been read out of skin in two dimensions, by the name of its table: "contact", "touches", "texture"; with rows where
             the scene asks for them (docs/readouts.md). patch is the index of a patch; a number that is not known is NaN
    summary  counts, bytes, and the error of the estimate
    """

    scene: Scene = field(default_factory=Scene)
    force: Array = field(default_factory=lambda: np.empty(0))
    emg: Array = field(default_factory=lambda: np.empty(0))
    parts: Mapping[str, Array] = field(default_factory=dict)
    readouts: Mapping[str, Array] = field(default_factory=dict)
    summary: Mapping[str, Any] = field(default_factory=dict)

    @property
    def end_s(self) -> float:
        return float(self.summary["duration_s"])

    def _repr_html_(self) -> str:
        rows = [(name, f"{value:,.6g}" if isinstance(value, float) else value) for name, value in self.summary.items()]
        return super()._repr_html_() + _html.table("Summary", ("", ""), rows)

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
