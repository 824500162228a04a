"""Files of events."""

from __future__ import annotations

import pathlib
import warnings
from typing import Any

import numpy.typing as npt

from . import _afferent
from ._results import EventSet, event_set_of
from ._scene import PathLike


def read_events(file: PathLike) -> EventSet:
    """The events of a recording (.afferent), or of what `afferent convert` writes: .csv, .es, .aedat, .nwb and
    .sonata.h5, with what the file, or one beside it, tells of their afferents. What a file lacks is a warning."""
    pieces: dict[str, Any] = _afferent.read_events(str(pathlib.Path(file)))
    for remark in pieces.pop("remarks"):
        warnings.warn(remark, stacklevel=2)
    return event_set_of(pieces)


def write_events(file: PathLike, events: EventSet | npt.NDArray[Any]) -> None:
    """Writes events as .csv, .es or .aedat, by the ending of the name."""
    content = _afferent.events_as(file, events.events if isinstance(events, EventSet) else events)
    pathlib.Path(file).write_bytes(content)
