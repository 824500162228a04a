"""Error against run time: the exact neuron beside Euler's method in NumPy, on the same drives."""
# %% Two hundred adapting neurons under steps of drive.
import pathlib
import sys
import time

import matplotlib.pyplot as plt
import numpy as np

import afferent

OUT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "out/python")
OUT.mkdir(parents=True, exist_ok=True)

NEURONS, END_S = 200, 1.0
TAU_M, TAU_G, V_R, V_TH, E_K, DELTA_G = 0.01, 0.1, -65.0, -50.0, -70.0, 0.3
rng = np.random.default_rng(1)
times_s = np.arange(0, END_S, 0.05)
drives_mv = rng.uniform(0, 60, (len(times_s), NEURONS))

# %% Exactly: each spike is predicted, to the nanosecond.
neuron = afferent.Neuron(delta_g=DELTA_G)
began = time.perf_counter()
events = neuron.spikes(drives_mv, (times_s * 1e9).astype(np.int64), until_ns=int(END_S * 1e9))
exact_run_time_s = time.perf_counter() - began
exact = [events["time"][events["address"] == i] * 1e-9 for i in range(NEURONS)]


# %% By Euler's method, at steps of the user's choice.
def euler(step_s: float) -> list[list[float]]:
    v, g = np.full(NEURONS, V_R), np.zeros(NEURONS)
    spikes: list[list[float]] = [[] for _ in range(NEURONS)]
    for k in range(round(END_S / step_s)):
        drive = drives_mv[min(len(times_s) - 1, int((k + 0.5) * step_s / 0.05))]
        v += step_s / TAU_M * (V_R - v + drive - g * (v - E_K))
        g -= step_s / TAU_G * g
        for i in np.flatnonzero(v >= V_TH):
            spikes[i].append((k + 1) * step_s)
            v[i] = V_R
            g[i] += DELTA_G
    return spikes


points = []
for step_ms in (1.0, 0.5, 0.2, 0.1, 0.05, 0.02):
    began = time.perf_counter()
    found = euler(step_ms * 1e-3)
    run_time_s = time.perf_counter() - began
    errors = [abs(a - b) for one, other in zip(exact, found) for a, b in zip(one, other)]
    missed = sum(abs(len(one) - len(other)) for one, other in zip(exact, found))
    points.append((run_time_s, float(np.median(errors)), step_ms))
    print(f"step {step_ms:g} ms: median error {np.median(errors) * 1e6:.0f} µs, {missed} spikes too many or too few, "
          f"{run_time_s * 1e3:.0f} ms")
print(f"exact: {len(events)} spikes in {exact_run_time_s * 1e3:.1f} ms")
# Halving the step halves the error.
assert points[-1][1] < points[0][1] / 10

# %% The picture.
figure, axes = plt.subplots(figsize=(6, 4), constrained_layout=True)
run_times, medians, steps = zip(*points)
axes.loglog(run_times, medians, "o-", color="#0072B2", label="Euler, by its step")
for run_time, median, step in points:
    axes.annotate(f"{step:g} ms", (run_time, median), textcoords="offset points", xytext=(6, 4), fontsize="small")
axes.loglog([exact_run_time_s], [0.5e-9], "*", markersize=12, color="#D55E00", label="afferent.Neuron, which is taken for the truth: its rounding to 1 ns")
axes.set_xlabel(f"run time for {NEURONS} neurons and {END_S:g} s (s)")
axes.set_ylabel("median error of a spike's time (s)")
axes.margins(x=0.15)
axes.legend(frameon=False, loc="center", fontsize="small")
figure.savefig(OUT / "error_against_run_time.png", dpi=110)
