"""One's own table: six force-sensitive resistors, in volts, at 250 Hz, with semicolons and decimal commas."""
# %% Such a table, as a logger would have written it. Yours is there already.
import pathlib
import sys

import numpy as np

import afferent
from afferent import plot

OUT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "out/python")
OUT.mkdir(parents=True, exist_ok=True)

time_s = np.arange(0, 6, 1 / 250)
grip_n = 8 * np.clip((time_s - 1) / 0.4, 0, 1) * np.clip((5 - time_s) / 0.3, 0, 1)
shares = np.array([0.3, 0.2, 0.1, 0.2, 0.15, 0.05])
# A resistor that falls with force, in a divider at 5 V.
ohm = 500 + 19_500 / (1 + grip_n[:, None] * shares / 0.8)
volt = 5 * 4700 / (4700 + ohm)
lines = ["zeit;f1;f2;f3;f4;f5;f6"]
lines += [";".join(f"{value:.4f}".replace(".", ",") for value in (t, *row)) for t, row in zip(time_s, volt)]
(OUT / "six.csv").write_text("\n".join(lines) + "\n")

# %% Read by NumPy, from volts to newtons by the curve of the sensors.
table = np.loadtxt((OUT / "six.csv").read_text().replace(",", ".").splitlines(), delimiter=";", skiprows=1)
newtons = 0.8 * (19_500 / (4700 * (5 / table[:, 1:] - 1) - 500) - 1)

# %% A scene of two patches with sensors of that rate, on this array.
scene = afferent.Scene(
    patches=[dict(name="thumb", elements=3, share=shares[:3]), dict(name="finger", elements=3, share=shares[3:])],
    every_patch=dict(sensor=dict(rate_hz=250)),
    decoder=dict(filter={}, parts="PATCHES"),
)
result = afferent.run(scene, np.maximum(newtons, 0))
print(f"{result}: RMS error of the force {result.summary['force_error_rms_n']:.2f} N")
assert result.summary["force_error_rms_n"] < 0.5

# %% The picture, and the events for other programs.
plot.overview(result).savefig(OUT / "own_table.png", dpi=110)
afferent.write_events(OUT / "six_events.csv", result)
