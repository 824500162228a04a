"""A neuron by itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from . import _afferent, fields
from ._scene import Scene


class Neuron(_afferent.Neuron):
    """The neuron of a scene's patch, or one of these parameters: the fields of `neuron { }` in a scene.

        Neuron(delta_g=0.3).rate_hz([20, 30, 40])
        Neuron(scene, patch=1).spikes(30, until_ns=10**9)
    """

    def __init__(self, scene: _afferent.Scene | None = None, patch: int = 0, **parameters: Any) -> None:
        if scene is None:
            neuron: fields.Neuron = parameters  # type: ignore[assignment]
            # No hand moves by it.
            scene = Scene(
                patches=[dict(name="neuron", elements=1, neuron=neuron)], gain=dict(accept_unreachable_limit=True)
            )
        elif parameters:
            raise TypeError("either a scene or parameters")
        super().__init__(scene, patch)

    def rate_hz(self, drive_mv: npt.ArrayLike, kind: str = "steady") -> Any:
        """How often it fires under a held drive: "steady", after adaptation, or at the "onset"."""
        return super().rate_hz(np.asarray(drive_mv, dtype=float), kind)

    def drive_mv(self, rate_hz: npt.ArrayLike, kind: str = "steady") -> Any:
        """The lowest drive at which it fires so often; infinite where none does."""
        return super().drive_mv(np.asarray(rate_hz, dtype=float), kind)

    def spikes(
        self, drive_mv: npt.ArrayLike, times_ns: npt.ArrayLike = 0, *, until_ns: int
    ) -> npt.NDArray[Any]:
        """The spikes from rest on, as events. Drives, in mV, are held from their times on: one; a row of drives for
        neurons alike; or a row for each time, of one drive or of one for each neuron."""
        return self.run(*_rows(times_ns, drive_mv), until_ns)[0]

    def trace(
        self, drive_mv: npt.ArrayLike, times_ns: npt.ArrayLike = 0, *, at_ns: npt.ArrayLike
    ) -> npt.NDArray[Any]:
        """v_mv and g at each of these times, by neuron."""
        at = np.ascontiguousarray(at_ns, dtype=np.int64).reshape(-1)
        until = int(at[-1]) if len(at) else 0
        return self.run(*_rows(times_ns, drive_mv), until, at)[1]


def _rows(times_ns: npt.ArrayLike, drive_mv: npt.ArrayLike) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    times = np.ascontiguousarray(times_ns, dtype=np.int64).reshape(-1)
    drives = np.ascontiguousarray(drive_mv, dtype=float)
    if drives.ndim < 2:
        drives = drives.reshape(len(times), -1) if len(times) > 1 or drives.ndim == 0 else drives.reshape(1, -1)
    return times, drives
