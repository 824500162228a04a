"""Afferents of a scene under a probe."""

from __future__ import annotations

from typing import Any, Optional

from . import _afferent
from ._scene import SceneLike, scene_of
from ._suggestions import suggests


@suggests
def tuning(
    scene: SceneLike,
    address: int,
    *,
    radius_mm: float = 0.5,
    hold_mm: float = 1,
    samples_hz: Optional[float] = None,
) -> dict[str, Any]:
    """What makes one afferent fire, as `afferent tuning` has it: the entries of its summary.json.

    A flat probe of that radius presses and vibrates at the afferent's place: `threshold_um`; `field_mm2` at
    `field_depth_um` and `field`, its profiles; `frequencies` with thresholds and what fires once a cycle; `depths` with
    rates; and `intervals_ms` of a hold at `hold_mm`. Amplitudes that are not reached at 3 mm are None. Sensors read
    `samples_hz` times a second, by default as often as the scene's.

    Raises SceneError, and OutsideError for an address that is not there or a patch without an outline.
    """
    return _afferent.tuning(scene_of(scene), address, radius_mm, hold_mm, samples_hz)


@suggests
def tunings(
    scene: SceneLike,
    patch: str,
    *,
    radius_mm: float = 0.5,
    hold_mm: float = 1,
    samples_hz: Optional[float] = None,
) -> list[dict[str, Any]]:
    """`tuning` of each afferent of a patch, by address; some half a second each.

    Raises SceneError, and OutsideError for a patch that is not there or has no outline.
    """
    return _afferent.tunings(scene_of(scene), patch, radius_mm, hold_mm, samples_hz)
