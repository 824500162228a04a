"""Settings by path, and sweeps over them."""
import os
import signal
import threading
import time
import unittest

import numpy as np

import afferent
from afferent import Scene, SceneError

RISING = dict(profile=dict(point=[dict(time_s=0, force_n=0), dict(time_s=1, force_n=10)]))
SCENE = Scene(duration_s=1, source=RISING, patches=[dict(name="thumb", elements=2), dict(name="index", elements=2)])


class SettingsTest(unittest.TestCase):
    def test_take_values_of_every_kind(self):
        scene = SCENE.with_settings({
            "decoder": "filter", "neuron.delta_g": np.float64(0.25), "patch[thumb].share": [0.25, 0.25], "seed": 7,
            "link": dict(tcp=dict(port=1)), "record.picture": False, "name": "a b", "decoder.parts": "PATCHES",
            "duration_s": None})
        fields = scene.to_dict()
        self.assertEqual(fields["patches"][0]["share"], [0.25, 0.25])
        self.assertEqual([patch["neuron"]["delta_g"] for patch in fields["patches"]], [0.25, 0.25])
        self.assertEqual(fields["link"], {"tcp": {"port": 1}})
        self.assertEqual((scene.seed, scene.name, scene.duration_s), (7, "a b", 10))
        self.assertEqual(fields["decoder"], {"filter": {}, "parts": "PATCHES"})
        self.assertEqual(fields["record"], {"picture": False})

    def test_say_what_is_wrong(self):
        for settings, message in (
            ({"decoder": "fliter"}, "fliter"),
            ({"neuron.delta": 1}, "no field \"delta\""),
            ({"neuron.delta_g": -1}, "neuron.delta_g"),
            ({"neuron.delta_g": "much"}, "must be a number"),
            ({"patch[palm].elements": 1}, "palm"),
            ({"duration_s": [1, 2]}, "takes one value"),
        ):
            with self.assertRaisesRegex(SceneError, message):
                SCENE.with_settings(settings)


class SweepTest(unittest.TestCase):
    def test_has_a_row_for_each_combination_as_a_run_has_it(self):
        over = {"decoder": ["inversion", "filter"], "neuron.delta_g": [0.0, 0.1, 0.3]}
        table = afferent.sweep(SCENE, over)
        self.assertEqual(len(table), 6)
        self.assertEqual(list(table["decoder"]), ["inversion"] * 3 + ["filter"] * 3)
        np.testing.assert_array_equal(table["neuron.delta_g"], [0, 0.1, 0.3] * 2)
        for row in table:
            scene = SCENE.with_settings({path: row[path] for path in over})
            summary = afferent.run(scene).summary
            self.assertEqual(row["events"], summary["events"])
            self.assertAlmostEqual(row["force_error_rms_n"], summary["force_error_rms_n"], places=12)
            self.assertEqual(row["refusal"], "")

    def test_keeps_what_is_no_scene_in_its_place(self):
        table = afferent.sweep(SCENE, {"gain.limit_n": [5, 0, 10]})
        self.assertEqual([bool(refusal) for refusal in table["refusal"]], [False, True, False])
        self.assertTrue(np.isnan(table["force_error_rms_n"][1]))
        with self.assertRaises(SceneError):
            afferent.sweep(SCENE, {})
        with self.assertRaises(SceneError):
            afferent.sweep(SCENE, {"seed": []})

    def test_values_may_be_messages(self):
        table = afferent.sweep(SCENE, {"link": ["tcp", dict(tcp={}, tick_us=1000)], "decoder": ["filter"]})
        self.assertGreater(table["link_bytes"][0], table["link_bytes"][1])
        self.assertEqual(table["link"][1], dict(tcp={}, tick_us=1000))

    def test_can_be_interrupted_and_tells_its_progress(self):
        threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
        began = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            afferent.sweep(SCENE.with_settings({"duration_s": 1000}), {"seed": range(1000)})
        self.assertGreater(time.monotonic() - began, 0.4)
        told = []
        afferent.sweep(SCENE, {"seed": range(3)}, progress=told.append)
        self.assertEqual(told[-1], 1)


if __name__ == "__main__":
    unittest.main()
