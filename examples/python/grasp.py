"""A grasp: a simulated hand closes on an object, holds it and lets go."""
# %% The scene of examples/grasp.txtpb, and what it comes to.
import pathlib
import sys

import afferent
from afferent import plot

HERE = pathlib.Path(__file__).resolve().parent
OUT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "out/python")
OUT.mkdir(parents=True, exist_ok=True)

scene = afferent.Scene.from_file(HERE.parent / "grasp.txtpb")
result = afferent.run(scene)
print(f"{result}: RMS error of the force {result.summary['force_error_rms_n']:.2f} N")

# %% Force with its estimate, spikes, rates and gain.
plot.overview(result).savefig(OUT / "grasp.png", dpi=110)

# %% Another decoder on the same grasp: one that knows how the neurons adapt.
better = afferent.run(scene.with_settings({"decoder": "filter"}))
print(f"with the filter {better.summary['force_error_rms_n']:.2f} N")
assert better.summary["force_error_rms_n"] < result.summary["force_error_rms_n"]
plot.overview(better).savefig(OUT / "grasp_filter.png", dpi=110)
