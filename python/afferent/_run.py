"""Whole scenes: run in virtual time, or replayed from a recording."""

from __future__ import annotations

from typing import Any, Callable, Literal

import numpy as np
import numpy.typing as npt

from . import _afferent, fields
from ._results import Result, result_of
from ._scene import PathLike, Scene, SceneLike, scene_of
from ._scene_text import fields_of
from ._suggestions import suggests

Progress = Callable[[float], Any]


@suggests
def run(
    scene: SceneLike,
    forces: npt.ArrayLike | None = None,
    emg: npt.ArrayLike | None = None,
    *,
    times: npt.ArrayLike | None = None,
    emg_times: npt.ArrayLike | None = None,
    unit: Literal["n", "counts"] = "n",
    duration_s: float | None = None,
    progress: Progress | None = None,
    record: PathLike | None = None,
) -> Result:
    """Runs a scene in virtual time, and returns all that it gave.

    scene    a Scene, or the path of a file of one
    forces   in place of the scene's source: an array of scans × elements, in newtons or in the converter's counts;
             one grip force for each scan; or images, scans × rows × columns, laid over all outlines. The run lasts as
             long as they do.
    times    the time of each scan in s, which rise; without them, scans come at the rate of the scene's sensors
    emg      in place of the scene's user: what the closing electrode reads, in counts, at emg_times or at the rate
             of the scene's EMG
    progress is called with the fraction that is done, some twenty times a second
    record   a file (.afferent) for what the hand receives

    Other threads of Python run meanwhile. Ctrl-C ends the run; what has been recorded up to there is complete.
    """
    whole = scene_of(scene)
    if unit not in ("n", "counts"):
        raise ValueError(f'unit must be "n" (newtons) or "counts" (of the converter), is {unit!r}')
    force_times, force_array, end_s = None, None, None
    if forces is not None:
        force_array = _samples("forces", forces)
        force_times = _times(times, force_array, lambda: _sensor_rate_hz(whole))
        end_s = _end_s(force_times)
    elif times is not None:
        raise ValueError("times are those of forces, which are not given")
    emg_array, emg_time_array = None, None
    if emg is not None:
        emg_array = _samples("emg", emg)
        emg_time_array = _times(emg_times, emg_array, lambda: _emg_rate_hz(whole))
    return result_of(_afferent.run(
        whole, force_array, force_times, unit == "counts", emg_array, emg_time_array,
        end_s if duration_s is None else duration_s, progress, record))


@suggests
def read_recording(
    file: PathLike,
    *,
    decoder: fields.Decoder | fields.DecoderName | None = None,
    progress: Progress | None = None,
) -> Result:
    """What a hand received and did, replayed from its recording; with `decoder`, what that one estimates from it."""
    decoding = None if decoder is None else Scene(decoder=decoder)
    return result_of(_afferent.read_recording(file, decoding, progress))


def _samples(name: str, given: npt.ArrayLike) -> npt.NDArray[Any]:
    samples = np.ascontiguousarray(given, dtype=float)
    if not samples.size:
        raise ValueError(f"{name}: the array is empty, of shape {samples.shape}; without {name}, leave the argument out")
    return samples


def _times(
    times: npt.ArrayLike | None, samples: npt.NDArray[Any], rate_hz: Callable[[], float]
) -> npt.NDArray[Any]:
    if times is not None:
        return np.ascontiguousarray(times, dtype=float)
    return np.arange(len(samples) if samples.ndim else 0) / rate_hz()


def _end_s(times_s: npt.NDArray[Any]) -> float | None:
    """When the last of them has lasted as long as the one before."""
    if len(times_s) == 0:
        return None
    return float(times_s[-1] + (times_s[-1] - times_s[-2] if len(times_s) > 1 else 0.005))


def _sensor_rate_hz(scene: _afferent.Scene) -> float:
    patches = fields_of(scene.text()).get("patch", [{}])
    rates = {patch.get("sensor", {}).get("rate_hz", 200.0) for patch in patches if "elements_of" not in patch}
    if len(rates) != 1:
        raise ValueError("the sensors of the patches have different rates: forces take times")
    return float(rates.pop())


def _emg_rate_hz(scene: _afferent.Scene) -> float:
    return float(fields_of(scene.text()).get("hand", {}).get("emg_rate_hz", 1000.0))
