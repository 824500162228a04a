"""One's own table: six force-sensitive resistors, in volts, at 250 Hz, with semicolons and decimal commas."""
# %% Such a table, as a logger would have written it. Yours is there already.
import pathlib
import sys

import numpy as np

OUT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "out/python")
OUT.mkdir(parents=True, exist_ok=True)

time_s = np.arange(0, 6, 1 / 250)
grip_n = 8 * np.clip((time_s - 1) / 0.4, 0, 1) * np.clip((5 - time_s) / 0.3, 0, 1)
# Resistors that fall with force, each with 10 kΩ to ground at 5 V.
force_n = grip_n[:, None] * [0.3, 0.2, 0.1, 0.2, 0.15, 0.05]
ohm = 6000 / np.maximum(force_n, 1e-3) ** 0.85
volt = 5 * 10_000 / (10_000 + ohm)
lines = ["zeit;f1 [V];f2 [V];f3 [V];f4 [V];f5 [V];f6 [V]"]
lines += [";".join(f"{value:.4f}".replace(".", ",") for value in (t, *row)) for t, row in zip(time_s, volt)]
(OUT / "six.csv").write_text("\n".join(lines) + "\n")

# %% Events, force and a picture in five lines, and no scene written by hand.
import afferent
from afferent import plot

result = afferent.run(afferent.Scene.for_table(OUT / "six.csv"))
print(f"{result}; the force is at most {result.force['estimate'].max():.1f} N")
plot.overview(result).savefig(OUT / "own_table.png", dpi=110)

# %% What the table has been taken for, and what nobody has said: the curve of the resistors.
found = afferent.inspect(OUT / "six.csv")
print(found)
assert found.rate_hz == 250 and len(found.columns) == 6

# %% One's own curve, as points of volts and newtons.
curve = [(float(v), float(f)) for v, f in sorted(zip(volt[250:350, 0], force_n[250:350, 0]))]
better = afferent.run(afferent.Scene.for_table(OUT / "six.csv", calibration=curve[::10]))
print(f"by its own curve at most {np.nanmax(better.force['true']):.1f} N, and was {grip_n.max():.1f} N")
assert abs(np.nanmax(better.force["true"]) - grip_n.max()) < 0.5

# %% The same from an array, where another program has read the table: newtons for each scan and element.
again = afferent.run(better.scene, force_n)
afferent.write_events(OUT / "six_events.csv", again)
