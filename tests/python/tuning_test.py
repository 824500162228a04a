"""One afferent under a probe."""
import unittest

import afferent

SCENE = afferent.Scene.from_text(
    'patch { name: "skin" kind: SA1 outline { rectangle { width_mm: 3 height_mm: 3 } } '
    'afferents { place { x_mm: 0.5 } } spread { gain {} } } source { pushed {} } '
    'record { force: false picture: false }')


class TuningTest(unittest.TestCase):
    def test_tells_what_makes_it_fire(self):
        tuning = afferent.tuning(SCENE, 0, hold_mm=0.5, samples_hz=1000)
        self.assertEqual((tuning["kind"], tuning["x_mm"], tuning["samples_hz"], tuning["hold_mm"]),
                         ("SA1", 0.5, 1000, 0.5))
        self.assertEqual([row["frequency_hz"] for row in tuning["frequencies"]][-1], 250)
        rates = [row["held_hz"] for row in tuning["depths"]]
        self.assertEqual(rates, sorted(rates))
        self.assertEqual(len(tuning["field"]), 41)
        self.assertGreater(len(tuning["intervals_ms"]), 3)

    def test_tells_of_each_of_a_patch(self):
        one = afferent.tuning(SCENE, 0)
        self.assertEqual(afferent.tunings(SCENE, "skin"), [one])
        with self.assertRaisesRegex(afferent.OutsideError, 'there is no patch "nose"'):
            afferent.tunings(SCENE, "nose")

    def test_says_why_not(self):
        with self.assertRaisesRegex(afferent.OutsideError, "there is no address 7"):
            afferent.tuning(SCENE, 7)
        with self.assertRaisesRegex(TypeError, "samples_hz"):
            afferent.tuning(SCENE, 0, sample_hz=200)


if __name__ == "__main__":
    unittest.main()
