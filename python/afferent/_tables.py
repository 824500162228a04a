"""Tables as they come: any separator, unit and time; docs/tables.md has the rules."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, Sequence

from numpy.typing import NDArray

from . import _afferent
from ._scene import PathLike, Scene
from ._suggestions import suggests

TimeUnit = Literal["s", "ms", "us", "ns", "min", "day-first", "month-first"]
Missing = Literal["refuse", "skip", "interpolate"]
Unit = Literal["n", "counts", "v"]


class Table(NamedTuple):
    """Times in ns, which begin at 0 where the table's own begin late, and a row of values for each."""

    columns: list[str]
    times: NDArray[Any]
    values: NDArray[Any]


class Column(NamedTuple):
    """What a column is taken for, and why."""

    name: str
    use: str  # "grip force", "force", "emg" or "not used"
    unit: str
    reason: str
    lowest: float
    highest: float
    median: float


@dataclass(frozen=True, eq=False, repr=False)
class Inspection:
    """What a table is taken for: print it. `scene` runs on the table; None where `why_no_scene` says why."""

    file: str
    columns: list[Column]
    sentences: list[str]
    assumptions: list[str]
    rate_hz: float
    length_s: float
    gaps: int
    longest_gaps_s: list[tuple[float, float]]
    scene: Scene | None
    why_no_scene: str
    table: Table

    def __str__(self) -> str:
        lines = [*self.sentences, *(f"assumed: {one}" for one in self.assumptions)]
        return "\n".join(lines + ([self.why_no_scene] if self.scene is None else []))

    def __repr__(self) -> str:
        return f"Inspection({self.file!r}, {len(self.table.times):,} rows, {self.rate_hz:g} Hz)"


@suggests
def read_table(
    file: PathLike,
    *,
    columns: Sequence[str] = (),
    time_column: str = "",
    time_unit: TimeUnit | None = None,
    rate_hz: float | None = None,
    begin_s: float | None = None,
    missing: Missing = "refuse",
) -> Table:
    """A table alone: its columns, or these of them. Rows that lack a value are refused, skipped, or interpolated."""
    options = _afferent.TableOptions(list(columns), time_column, time_unit or "", rate_hz, begin_s, missing)
    return Table(*_afferent.read_table(file, options)[0])


@suggests
def inspect(
    file: PathLike,
    *,
    columns: Sequence[str] = (),
    time_column: str = "",
    time_unit: TimeUnit | None = None,
    rate_hz: float | None = None,
    begin_s: float | None = None,
    missing: Missing = "refuse",
    unit: Unit | None = None,
    calibration: Sequence[tuple[float, float]] = (),
    newtons_per_volt: float | None = None,
    reference_v: float | None = None,
) -> Inspection:
    """What a table is taken for, with a scene that runs on it. Whatever is told is not guessed: the columns to use, the
    column of time and its unit, or the rate of rows that have none; the unit of columns whose names have none; and
    points of (volts or counts, newtons), or newtons for each volt. Rows that lack a value are refused, skipped, or
    interpolated."""
    options = _afferent.TableOptions(list(columns), time_column, time_unit or "", rate_hz, begin_s, missing)
    found = _afferent.inspect_table(file, options, unit or "", list(calibration), newtons_per_volt, reference_v)
    found["columns"] = [Column(*column) for column in found["columns"]]
    found["scene"] = None if found["scene"] is None else Scene._of(found["scene"])
    found["table"] = Table(*found["table"])
    return Inspection(**found)
