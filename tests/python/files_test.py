"""Files of events, and other libraries' views of a result."""
import os
import pathlib
import subprocess
import tempfile
import unittest
import warnings

import numpy as np

import afferent
from afferent import Scene

PROGRAM = os.environ["AFFERENT_PROGRAM"]
SKIN = dict(duration_s=0.5, record=dict(picture=False), link="tcp", decoder=dict(patch="tip"), patches=[
    dict(name="zone", outline=dict(rectangle=dict(width_mm=3, height_mm=2)), sensor=dict(full_scale_n=1)),
    dict(name="tip", elements=2), dict(name="deep", kind="RA", elements_of="zone", afferents=dict(per_cm2=100))])


def importable(*names):
    try:
        for name in names:
            __import__(name)
        return True
    except ImportError:
        return False


class FilesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.holder.name)
        forces = np.linspace(0, 1, 100)[:, None] * np.ones(8)
        cls.result = afferent.run(Scene(**SKIN), forces, record=cls.folder / "r.afferent")
        cls.recorded = afferent.read_events(cls.folder / "r.afferent")

    @classmethod
    def tearDownClass(cls):
        cls.holder.cleanup()

    def converted(self, ending):
        to = self.folder / ("r." + ending)
        subprocess.run([PROGRAM, "convert", self.folder / "r.afferent", to], check=True, stdout=subprocess.DEVNULL)
        return afferent.read_events(to)

    def assert_same_afferents(self, events):
        self.assertEqual(events.patches, self.result.patches)
        for column in ("address", "patch", "element", "elements", "x_mm", "y_mm"):
            np.testing.assert_allclose(events.afferents[column], self.result.afferents[column], rtol=1e-15)
        self.assertEqual(events.resolution_ns, 100_000)

    def test_a_recording_has_the_events_and_the_afferents(self):
        self.assertGreater(len(self.recorded), 20)
        self.assertEqual(len(self.recorded), len(self.result))
        self.assert_same_afferents(self.recorded)

    def test_tables_of_events_with_their_afferents(self):
        events = self.converted("csv")
        np.testing.assert_array_equal(events.events, self.recorded.events)
        self.assert_same_afferents(events)

    def test_address_event_files(self):
        for ending in ("es", "aedat"):
            events = self.converted(ending)
            np.testing.assert_array_equal(events.events, self.recorded.events)
            self.assertEqual(events.patches, ())
            afferent.write_events(self.folder / ("again." + ending), events)
            self.assertEqual((self.folder / ("again." + ending)).read_bytes(),
                             (self.folder / ("r." + ending)).read_bytes())

    def test_hdf5(self):
        for ending in ("nwb", "sonata.h5"):
            events = self.converted(ending)
            np.testing.assert_array_equal(events.events, self.recorded.events)
            self.assert_same_afferents(events)

    def test_hdf5_of_events_alone(self):
        afferent.write_events(self.folder / "alone.csv", self.recorded)
        for ending in ("nwb", "sonata.h5"):
            to = self.folder / ("alone." + ending)
            subprocess.run([PROGRAM, "convert", self.folder / "alone.csv", to], check=True, stdout=subprocess.DEVNULL)
            np.testing.assert_array_equal(afferent.read_events(to).events, self.recorded.events)

    def test_what_a_recording_lacks_is_a_warning(self):
        cut = self.folder / "cut.afferent"
        cut.write_bytes((self.folder / "r.afferent").read_bytes()[:-40])
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            events = afferent.read_events(cut)
        self.assertTrue(any("was not closed" in str(one.message) for one in told))
        self.assertLessEqual(len(events), len(self.recorded))

    def test_refuses_wrong_files(self):
        (self.folder / "wrong.csv").write_text("time_s,address\n1,2\n0,x\n")
        with self.assertRaisesRegex(afferent.DataError, "wrong.csv"):
            afferent.read_events(self.folder / "wrong.csv")
        with self.assertRaisesRegex(OSError, "absent.csv"):
            afferent.read_events(self.folder / "absent.csv")
        with self.assertRaises(OSError):
            afferent.read_events(self.folder / "absent.nwb")
        (self.folder / "wrong.nwb").write_bytes(b"no HDF5")
        with self.assertRaisesRegex(afferent.DataError, "wrong.nwb"):
            afferent.read_events(self.folder / "wrong.nwb")
        with self.assertRaisesRegex(OSError, "ending|csv"):
            afferent.read_events(self.folder / "what.xyz")
        with self.assertRaises(afferent.DataError):
            afferent.read_recording(self.folder / "wrong.csv")

    @unittest.skipUnless(importable("pandas"), "python3-pandas is not installed")
    def test_tables_of_pandas_are_the_program_s(self):
        frames = self.result.to_pandas()
        self.assertEqual(list(frames.events), ["time_s", "address"])
        self.assertEqual(list(frames.force), ["time_s", "true_force_n", "estimate_n", "sigma_n", "rate_hz", "gain", "doubt"])
        self.assertEqual(list(frames.emg), ["time_s", "emg", "closing", "opening", "command"])
        self.assertEqual(len(frames.events), len(self.result))

    @unittest.skipUnless(importable("neo"), "python3-neo is not installed")
    def test_a_block_of_neo(self):
        parts = afferent.run(Scene(duration_s=2, decoder=dict(filter={}, parts="PATCHES"), source=dict(
            profile=dict(point=[dict(time_s=0, force_n=0), dict(time_s=2, force_n=10)]))))
        block = parts.to_neo()
        trains = block.segments[0].spiketrains
        self.assertEqual(len(trains), 9)
        for address, train in enumerate(trains):
            own = parts.events["time"][parts.events["address"] == address]
            np.testing.assert_allclose(train.rescale("ns").magnitude, own, rtol=1e-12)
            self.assertEqual(float(train.t_stop.rescale("s")), 2)
            self.assertEqual(train.annotations["address"], address)
        self.assertEqual([train.annotations["patch"] for train in trains[::3]], ["thumb", "index", "middle"])
        self.assertEqual(trains[0].annotations["kind"], "sustained")
        signals = {signal.name: signal for signal in block.segments[0].analogsignals}
        estimate = signals["force estimate"]
        np.testing.assert_array_equal(estimate.magnitude[:, 0], parts.force["estimate"])
        self.assertEqual(estimate.units.dimensionality.string, "N")
        self.assertAlmostEqual(float(estimate.sampling_rate.rescale("Hz")), 1000, places=6)
        self.assertIn("index force sigma", signals)
        placed = self.recorded.to_neo().segments[0].spiketrains
        self.assertEqual(len(placed), self.recorded.neurons)
        self.assertEqual(placed[0].annotations["x_mm"], self.recorded.afferents["x_mm"][0])


if __name__ == "__main__":
    unittest.main()
