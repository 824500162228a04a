"""A neuron by itself, against closed forms."""
import math
import unittest

import numpy as np

import afferent
from afferent import Neuron


class NeuronTest(unittest.TestCase):
    def test_fires_as_the_closed_form_says(self):
        neuron = Neuron(delta_g=0)
        # v = −65 + 30 (1 − e^(−t/10 ms)) reaches −50 after 10 ms · ln 2, again and again; stamps are rounded up.
        interval_ns = 10e6 * math.log(30 / (30 - 15))
        spikes = neuron.spikes(30, until_ns=10**9)
        expected = np.ceil(np.arange(1, len(spikes) + 1) * interval_ns)
        self.assertEqual(len(spikes), int(1e9 // interval_ns))
        np.testing.assert_allclose(spikes["time"], expected, rtol=0, atol=1)
        self.assertAlmostEqual(neuron.rate_hz(30.0), 1e9 / interval_ns, places=9)
        self.assertEqual(neuron.rheobase_mv, 15)
        self.assertEqual(neuron.rate_hz(15), 0)

    def test_rate_and_drive_are_inverse(self):
        for neuron in (Neuron(delta_g=0.3), Neuron(delta_g=0.1, refractory_ms=1)):
            for kind in ("steady", "onset"):
                rates = np.array([[5.0, 50], [100, 200]])
                drives = neuron.drive_mv(rates, kind)
                self.assertEqual(drives.shape, (2, 2))
                np.testing.assert_allclose(neuron.rate_hz(drives, kind), rates, rtol=1e-9)

    def test_onset_rate_is_that_of_the_first_interval(self):
        neuron = Neuron(delta_g=0.3)
        times = neuron.spikes(40, until_ns=10**9)["time"]
        # Two stamps, each rounded by less than a nanosecond.
        self.assertAlmostEqual(1e9 / (times[1] - times[0]), neuron.rate_hz(40, "onset"), delta=1e-4)
        self.assertAlmostEqual(1e9 / (times[-1] - times[-2]), neuron.rate_hz(40), delta=1e-3)

    def test_trace_follows_the_membrane(self):
        at = np.arange(0, 5_000_001, 1_000_000)
        trace = Neuron().trace(30, at_ns=at)
        self.assertEqual(trace.shape, (6, 1))
        np.testing.assert_allclose(trace["v_mv"][:, 0], -65 + 30 * (1 - np.exp(-at / 10e6)), rtol=1e-12)
        self.assertTrue((trace["g"] == 0).all())

    def test_drives_may_change_and_differ(self):
        neuron = Neuron(delta_g=0)
        # A row for each time, of one drive for each of three neurons; before the first row nothing drives them.
        spikes = neuron.spikes([[0, 30, 40], [30, 0, 40]], [10**8, 5 * 10**8], until_ns=10**9)
        ranges = [spikes["time"][spikes["address"] == i] for i in range(3)]
        self.assertGreater(ranges[0].min(), 5 * 10**8)
        self.assertLess(ranges[1].max(), 5 * 10**8)
        self.assertGreater(ranges[2].min(), 10**8)
        one = neuron.spikes([0, 30], [0, 5 * 10**8], until_ns=10**9)
        np.testing.assert_array_equal(one["time"], ranges[0])

    def test_is_that_of_a_scene(self):
        scene = afferent.Scene(patches=[dict(name="a"), dict(name="b", neuron=dict(delta_g=0.5))])
        self.assertEqual(Neuron(scene, 1).rate_hz(30.0), Neuron(delta_g=0.5).rate_hz(30.0))
        self.assertEqual(Neuron(fixed_point=dict(tick_us=10)).model, "fixed_point")
        with self.assertRaises(IndexError):
            Neuron(scene, 2)

    def test_refuses_what_is_no_drive(self):
        for arguments in (dict(drive_mv=np.nan), dict(drive_mv=[1, 2], times_ns=[5, 1]), dict(drive_mv=[[1], [2], [3]])):
            with self.assertRaises(ValueError):
                Neuron().spikes(**arguments, until_ns=100)
        with self.assertRaises(afferent.SpikeStormError):
            Neuron().spikes(1e9, until_ns=10**9)
        with self.assertRaisesRegex(afferent.SceneError, "tau_m_ms"):
            Neuron(tau_m_ms=0)


if __name__ == "__main__":
    unittest.main()
