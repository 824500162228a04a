"""Afferent: an event-driven spiking runtime for touch.

    import afferent

    scene = afferent.Scene(patches=[dict(name="thumb", elements=3)], decoder="filter", duration_s=10)
    result = afferent.run(scene)
    result.events["time"], result.events["address"], result.force["estimate"]
"""

from . import _libraries as _libraries  # first: where one is missing, it says what to install
from . import errors, fields
from ._afferent import (
    Controller,
    ControllerSnapshot,
    Coprocessor,
    Decoder,
    DecoderSnapshot,
    Estimate,
    PlanItem,
    Step,
    event_dtype,
)
from ._afferent import version as __version__
from ._files import read_events, write_events
from ._neuron import Neuron
from ._results import EventSet, Frames, Patch, Result
from ._run import read_recording, run
from ._scene import Plan, Scene, plan
from ._sweep import sweep
from ._tables import Column, Inspection, Table, inspect, read_table
from ._tuning import tuning, tunings
from .errors import DataError, OutsideError, SceneError, SpikeStormError

__all__ = [
    "Column", "Controller", "ControllerSnapshot", "Coprocessor", "DataError", "Decoder", "DecoderSnapshot", "Estimate",
    "EventSet", "Frames", "Inspection", "Neuron", "OutsideError", "Patch", "Plan", "PlanItem", "Result", "Scene",
    "SceneError", "SpikeStormError", "Step", "Table", "__version__", "errors", "event_dtype", "fields", "inspect",
    "plan", "read_events", "read_recording", "read_table", "run", "sweep", "tuning", "tunings", "write_events",
]  # fmt: skip
