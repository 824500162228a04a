"""Pictures."""
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import afferent
from afferent import Scene

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    from afferent import plot
except ImportError:
    print("python3-matplotlib is not installed")
    sys.exit(77)

RISING = dict(profile=dict(point=[dict(time_s=0, force_n=0), dict(time_s=1, force_n=10)]))


class PlotTest(unittest.TestCase):
    def tearDown(self):
        plt.close("all")

    def saved(self, figure):
        with tempfile.NamedTemporaryFile(suffix=".png") as file:
            figure.savefig(file.name)
            return len(file.read())

    def test_nobody_else_imports_matplotlib(self):
        loaded = "import sys, afferent; print([m for m in sys.modules if m.split('.')[0] in " \
                 "('matplotlib', 'pandas', 'neo', 'h5py')])"
        told = subprocess.run([sys.executable, "-c", loaded], check=True, capture_output=True, text=True).stdout
        self.assertEqual(told.strip(), "[]")

    def test_draws_a_run(self):
        result = afferent.run(Scene(duration_s=1, source=RISING, decoder=dict(filter={}, parts="PATCHES")))
        overview = plot.overview(result)
        self.assertEqual([axes.get_title(loc="left") for axes in overview.axes], list("ABCD"))
        self.assertGreater(self.saved(overview), 10_000)
        axes = plot.raster(result, plt.figure().gca())
        marks = np.concatenate([drawn.get_offsets() for drawn in axes.collections])
        self.assertEqual(len(marks), len(result))
        self.assertEqual([label.get_text() for label in axes.get_yticklabels()], ["thumb", "index", "middle"])
        line = plot.estimate(result, plt.figure().gca(), part="index").lines[0]
        np.testing.assert_array_equal(line.get_ydata(), result.parts["index"]["estimate"])

    def test_the_rate_counts_every_spike(self):
        result = afferent.run(Scene(duration_s=1, source=RISING))
        patches = plot.rate(result, plt.figure().gca(), window_s=0.1).patches
        spikes = sum(float(np.sum(steps.get_data().values)) for steps in patches) * 0.1 * 3
        self.assertAlmostEqual(spikes, len(result), places=6)

    def test_draws_events_alone_and_none(self):
        events = afferent.EventSet(np.array([(10, 0), (20, 4)], afferent.event_dtype))
        plot.raster(events, plt.figure().gca())
        plot.rate(events, plt.figure().gca())
        silent = afferent.run(Scene(duration_s=0.5, source=RISING, record=dict(force=False, picture=False)))
        self.assertGreater(self.saved(plot.overview(silent)), 5_000)
        with self.assertRaisesRegex(ValueError, "nobody reads the estimate"):
            plot.estimate(silent)

    def test_error_against_bytes_takes_packets(self):
        scene = Scene(duration_s=1, source=RISING, decoder="filter", link="tcp")
        table = afferent.sweep(scene, {"decoder": ["filter", "inversion"], "link.tick_us": [100, 1000]})
        axes = plot.error_against_bytes(table, "decoder", plt.figure().gca())
        self.assertEqual([line.get_label() for line in axes.lines], ["filter", "inversion", "raw samples"])
        np.testing.assert_array_equal(axes.lines[0].get_xdata(), np.sort(table["link_bytes"][:2]))
        in_process = scene.with_settings({"link": "in_process"})
        with self.assertRaisesRegex(ValueError, "carries packets"):
            plot.error_against_bytes(afferent.sweep(in_process, {"decoder": ["filter"]}), "decoder")

    def test_a_population_takes_places(self):
        with self.assertRaisesRegex(ValueError, "no places"):
            plot.population(afferent.run(Scene(duration_s=0.1)))


if __name__ == "__main__":
    unittest.main()
