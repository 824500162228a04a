"""Pictures of results, by matplotlib.

Each function draws into the axes that it is given, or into the current ones, and returns them.
"""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from ._results import EventSet, Result

Axes = Any
Figure = Any

# The colours of Okabe and Ito, which everyone can tell apart.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
# More spikes than this are drawn as the density of their rows.
MOST_SPIKES = 200_000


def raster(events: EventSet, axes: Axes = None) -> Axes:
    """When each afferent fired; patches differ in colour."""
    axes = axes or plt.gca()
    times, addresses = events.times_s(), events.events["address"]
    patches = events.patches or ()
    if len(times) > MOST_SPIKES:
        rows = min(events.neurons, 400)
        axes.hist2d(times, addresses, bins=(800, rows), cmap="Greys", cmin=1)
    elif not patches:
        axes.scatter(times, addresses, s=_mark(events.neurons), marker="|", color=COLOURS[0], linewidths=0.6)
    else:
        for i, patch in enumerate(patches):
            own = (addresses >= patch.first) & (addresses < patch.first + patch.afferents)
            axes.scatter(times[own], addresses[own], s=_mark(events.neurons), marker="|", linewidths=0.6,
                         color=COLOURS[i % len(COLOURS)])
    if patches and len(patches) <= 12:
        axes.set_yticks([patch.first + (patch.afferents - 1) / 2 for patch in patches])
        axes.set_yticklabels([patch.name for patch in patches])
    else:
        axes.set_ylabel("address")
    axes.set_ylim(events.neurons - 0.5, -0.5)
    axes.set_xlabel("time (s)")
    return axes


def rate(events: EventSet, axes: Axes = None, *, window_s: float = 0.05) -> Axes:
    """The mean rate of the afferents of each patch, counted in windows."""
    axes = axes or plt.gca()
    times, addresses = events.times_s(), events.events["address"]
    edges = np.arange(0, max(events.end_s, window_s) + window_s, window_s)
    for i, (name, first, count) in enumerate(
        [(p.name, p.first, p.afferents) for p in events.patches] or [("", 0, max(1, events.neurons))]
    ):
        own = (addresses >= first) & (addresses < first + count)
        spikes, _ = np.histogram(times[own], edges)
        axes.stairs(spikes / window_s / count, edges, color=COLOURS[i % len(COLOURS)], label=name)
    axes.set_ylabel("rate (Hz)")
    axes.set_xlabel("time (s)")
    if 1 < len(events.patches) <= 12:
        axes.legend(frameon=False, fontsize="small")
    return axes


def estimate(result: Result, axes: Axes = None, *, part: str | None = None, sigmas: float = 2) -> Axes:
    """The estimated force, or that of a part, with a band of so many standard deviations, beside the true one."""
    axes = axes or plt.gca()
    if not len(result.force):
        raise ValueError("nobody reads the estimate in this scene: record { force: true }, and a decoder")
    time = result.force["time"] * 1e-9
    rows = result.force if part is None else result.parts[part]
    force, sigma = rows["estimate"], rows["sigma"]
    axes.fill_between(time, np.maximum(0, force - sigmas * sigma), force + sigmas * sigma, color=COLOURS[0],
                      alpha=0.2, linewidth=0, label=f"± {sigmas:g} σ")
    axes.plot(time, force, color=COLOURS[0], linewidth=1.2, label="estimate")
    if not np.isnan(rows["true"]).all():
        axes.plot(time, rows["true"], color=COLOURS[6], linewidth=1, linestyle="--", label="true")
        # What nobody knows is not what the picture is for: where nothing is heard the band is as wide as the sensor.
        axes.set_ylim(0, 1.3 * max(1e-9, np.nanmax(rows["true"]), float(force.max())))
    else:
        axes.set_ylim(0, 1.3 * max(1e-9, float(force.max())))
    axes.set_ylabel("force (N)" if part is None else f"{part} (N)")
    axes.set_xlabel("time (s)")
    axes.legend(frameon=False, fontsize="small", loc="upper right")
    return axes


def gain(result: Result, axes: Axes = None) -> Axes:
    """The gain of the closing EMG."""
    axes = axes or plt.gca()
    axes.plot(result.force["time"] * 1e-9, result.force["gain"], color=COLOURS[1], linewidth=1.2)
    axes.set_ylim(-0.05, 1.05)
    axes.set_ylabel("gain")
    axes.set_xlabel("time (s)")
    return axes


def overview(result: Result) -> Figure:
    """Force, spikes, rate and gain, one under the other."""
    has_force = len(result.force) > 0
    figure, axes = plt.subplots(4 if has_force else 2, 1, sharex=True, figsize=(8, 7 if has_force else 4),
                                constrained_layout=True)
    raster(result, axes[1 if has_force else 0])
    rate(result, axes[2 if has_force else 1])
    if has_force:
        estimate(result, axes[0])
        gain(result, axes[3])
    for letter, panel in zip("ABCD", axes):
        panel.set_title(letter, loc="left", x=-0.09, y=0.98, pad=0, fontsize="medium", fontweight="bold")
    for upper in axes[:-1]:
        upper.set_xlabel("")
    axes[-1].set_xlim(0, result.end_s)
    return figure


def population(events: EventSet, axes: Axes = None, *, begin_s: float = 0, end_s: float | None = None) -> Axes:
    """The afferents where they lie, and how often each fired in that time."""
    axes = axes or plt.gca()
    known = events.afferents
    if not len(known) or np.isnan(known["x_mm"]).all():
        raise ValueError("these afferents have no places")
    times = events.times_s()
    until = events.end_s if end_s is None else end_s
    counts = np.bincount(events.events["address"][(times >= begin_s) & (times < until)], minlength=len(known))
    rates = counts / max(1e-9, until - begin_s)
    size = max(2.0, min(40.0, 8000 / len(known)))
    silent = counts == 0
    axes.scatter(known["x_mm"][silent], known["y_mm"][silent], s=size / 2, color="#cccccc", linewidths=0)
    # The busiest on top; a few that are far busier than the rest do not take all colours.
    shown = np.argsort(rates)[np.count_nonzero(silent) :]
    most = float(np.percentile(rates[shown], 98)) if len(shown) else 1.0
    drawn = axes.scatter(known["x_mm"][shown], known["y_mm"][shown], c=rates[shown], cmap="viridis", s=size, vmin=0,
                         vmax=most, linewidths=0)
    axes.figure.colorbar(drawn, ax=axes, label="rate (Hz)")
    axes.set_aspect("equal")
    axes.set_xlabel("x (mm)")
    axes.set_ylabel("y (mm)")
    return axes


def error_against_bytes(table: Any, by: str, axes: Axes = None, *, raw: bool = True) -> Axes:
    """What a byte buys: the RMS error of the estimate against the bytes per second on the link, for the rows of a sweep,
    with a line for each value of the field `by`. A line upright marks what the raw samples would take."""
    axes = axes or plt.gca()
    known = table[np.isfinite(table["force_error_rms_n"]) & (table["link_bytes"] > 0)]
    if not len(known):
        raise ValueError("a point takes a link that carries packets, and a true force; the sweep has none")
    values = list(dict.fromkeys(map(str, known[by])))
    for i, value in enumerate(values):
        rows = known[[str(one) == value for one in known[by]]]
        bytes_per_s = rows["link_bytes"] / rows["duration_s"]
        order = np.argsort(bytes_per_s)
        axes.plot(bytes_per_s[order], rows["force_error_rms_n"][order], marker="o", markersize=4, linewidth=1,
                  color=COLOURS[i % len(COLOURS)], label=value)
    if raw:
        axes.axvline(np.max(known["raw_sample_bytes"] / known["duration_s"]), color="#888888", linestyle=":",
                     label="raw samples")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("bytes per second on the link")
    axes.set_ylabel("RMS error of the force (N)")
    axes.legend(frameon=False, fontsize="small", title=by)
    return axes


def _mark(neurons: int) -> float:
    return max(1.0, min(120.0, 1500 / max(1, neurons)))
