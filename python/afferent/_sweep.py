"""A scene with every combination of some of its fields' values."""

from __future__ import annotations

from typing import Any, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from . import _afferent
from ._run import Progress
from ._scene import SceneLike, scene_of
from ._scene_text import setting_text
from ._suggestions import suggests


@suggests
def sweep(
    scene: SceneLike,
    over: Mapping[str, Sequence[Any]],
    *,
    threads: int = 0,
    progress: Progress | None = None,
) -> NDArray[Any]:
    """Runs every combination over the cores, the last field fastest, and returns a row for each:

        table = afferent.sweep(scene, {"neuron.delta_g": [0, 0.1, 0.3], "decoder": ["inversion", "filter"]})
        table["neuron.delta_g"], table["decoder"], table["force_error_rms_n"]

    Fields are named by their paths, as in Scene.with_settings. Each has a column with its values; then come duration_s,
    events, packets, link_bytes, raw_sample_bytes, force_error_rms_n, force_error_max_n, within_two_sigmas (the part of
    the steps whose error is), lowest_gain and run_time_s, with NaN for what is not known; and refusal, why a
    combination was not run, or "". pandas.DataFrame(table) takes it.
    """
    values = {path: list(column) for path, column in over.items()}
    rows, refusals = _afferent.sweep(
        scene_of(scene), [(path, [setting_text(path, value) for value in column]) for path, column in values.items()], threads,
        progress)
    counted = np.unravel_index(np.arange(len(rows)), [len(column) for column in values.values()])
    columns = {path: _column(column)[index] for (path, column), index in zip(values.items(), counted)}
    columns.update({name: rows[name] for name in rows.dtype.names or ()})
    columns["refusal"] = np.array(refusals, dtype=object)
    table = np.empty(len(rows), [(name, column.dtype) for name, column in columns.items()])
    for name, column in columns.items():
        table[name] = column
    return table


def _column(values: list[Any]) -> NDArray[Any]:
    """Numbers and texts as such, all else as objects."""
    for kind in ((bool, np.bool_), (int, float, np.integer, np.floating), (str,)):
        if all(isinstance(value, kind) for value in values):
            return np.array(values)
    column = np.empty(len(values), dtype=object)
    column[:] = values
    return column
