"""What a byte buys: the error of the force against the bytes on the link, for events and for raw samples."""
# %% The grip force of examples/grasp.txtpb, felt again by its sensors and neurons.
import pathlib
import sys

import matplotlib.pyplot as plt
import numpy as np

import afferent
from afferent import plot

HERE = pathlib.Path(__file__).resolve().parent
OUT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "out/python")
OUT.mkdir(parents=True, exist_ok=True)

grasp = afferent.Scene.from_file(HERE.parent / "grasp.txtpb")
felt = afferent.run(grasp).force
time_s, force_n = felt["time"][::10] * 1e-9, felt["true"][::10]
# In open loop, so that every decoder has the same force to find.
scene = grasp.with_settings({
    "source": dict(profile=dict(point=[dict(time_s=t, force_n=f) for t, f in zip(time_s, force_n)])),
    "sensor.hysteresis": 0,
})

# %% More spikes take more bytes: what do they buy, by each decoder?
table = afferent.sweep(scene, {
    "decoder": ["sliding_window", "inversion", "filter"],
    "neuron.tuning.rate_hz": [25, 50, 100, 200, 400],
})
for row in table:
    print(f"{row['decoder']:>14} {row['neuron.tuning.rate_hz']:4.0f} Hz: {row['link_bytes'] / row['duration_s']:5.0f} "
          f"bytes/s, {row['force_error_rms_n']:.3f} N")


# %% The raw samples at some rates, each held until the next, and as late as packets are. Their bytes are those of
# packed frames. They are spared the noise and the steps of the converter.
def held_error_n(rate_hz: float) -> float:
    steps = np.arange(0, 10, 1e-3)
    held = np.interp(np.floor((steps - 0.002) * rate_hz + 1e-9) / rate_hz, time_s, force_n)
    return float(np.sqrt(np.mean((np.interp(steps, time_s, force_n) - held) ** 2)))


raw = afferent.sweep(scene, {"sensor.rate_hz": [5, 10, 20, 50, 100, 200]})
raw_bytes = raw["raw_sample_bytes"] / raw["duration_s"]
raw_errors = [held_error_n(rate) for rate in raw["sensor.rate_hz"]]

# %% The picture.
figure, axes = plt.subplots(figsize=(6.5, 4.5), constrained_layout=True)
axes.plot(raw_bytes, raw_errors, "s--", color="#888888", markersize=4, linewidth=1, label="raw samples, held")
plot.error_against_bytes(table, "decoder", axes, raw=False)
figure.savefig(OUT / "what_a_byte_buys.png", dpi=110)
best = table[table["decoder"] == "filter"]
assert (best["force_error_rms_n"] < table[table["decoder"] == "sliding_window"]["force_error_rms_n"]).all()
