"""A population: the afferents of a fingertip under an edge, and those of a whole hand in a grasp."""
# %% Some 250 afferents of three kinds, while an edge slides over them.
import pathlib
import sys

import matplotlib.pyplot as plt
import numpy as np

import afferent
from afferent import plot

HERE = pathlib.Path(__file__).resolve().parent
OUT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "out/python")
OUT.mkdir(parents=True, exist_ok=True)

finger = afferent.run(afferent.Scene.from_file(HERE.parent / "fingertip.txtpb"))
for patch in finger.patches:
    own = np.arange(patch.first, patch.first + patch.afferents)
    print(f"{patch.kind}: {np.isin(own, finger.events['address']).sum()} of {patch.afferents} fired")

# %% The edge reaches one afferent after another: spikes by the place along its way.
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), constrained_layout=True)
x_mm = finger.afferents["x_mm"][finger.events["address"]]
for i, patch in enumerate(finger.patches):
    own = finger.afferents["patch"][finger.events["address"]] == i
    left.scatter(finger.times_s()[own], x_mm[own], s=4, color=plot.COLOURS[i], label=patch.kind, linewidths=0)
left.set_xlabel("time (s)")
left.set_ylabel("place along the edge's way (mm)")
left.legend(frameon=False, markerscale=3)
plot.population(finger, right)
figure.savefig(OUT / "fingertip.png", dpi=110)
# The edge reaches afferents that lie further along later, at 20 mm/s.
sustained = finger.afferents["patch"][finger.events["address"]] == 0
speed_mm_per_s = np.polyfit(finger.times_s()[sustained], x_mm[sustained], 1)[0]
print(f"the edge moves at {speed_mm_per_s:.1f} mm/s, by the spikes of the SA1")
assert abs(speed_mm_per_s - 20) < 2

# %% The 17,000 afferents of a hand, in the first second of a grasp.
hand = afferent.run(afferent.Scene.from_file(HERE.parent / "hand_17k.txtpb"), duration_s=1)
print(f"{hand}, computed in {hand.summary['run_time_s']:.2f} s")
figure, axes = plt.subplots(figsize=(7, 6), constrained_layout=True)
plot.population(hand, axes)
figure.savefig(OUT / "hand.png", dpi=110)
