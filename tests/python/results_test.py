"""What is asked of events, and how results show themselves."""
import pathlib
import re
import unittest

import numpy as np

import afferent
from afferent import EventSet, Patch, Scene

PROJECT = pathlib.Path(__file__).resolve().parents[2]
GRASP = PROJECT / "examples/grasp.txtpb"
MS = 1_000_000
# Two patches; address 2 is silent.
ROWS = [(0, 0), (3 * MS, 1), (7 * MS, 0), (7 * MS, 3), (14 * MS, 0), (19 * MS, 3)]
EVENTS = EventSet(np.array(ROWS, afferent.event_dtype), (Patch("thumb", 0, 2, "SA1"), Patch("index", 2, 2, "RA")))


class EventsTest(unittest.TestCase):
    def test_counts_by_afferent_and_by_patch(self):
        # An event at the edge of a bin belongs to the one that begins there: 0.007 s is no binary number.
        np.testing.assert_array_equal(EVENTS.counts(0.007), [[1, 1, 1], [1, 0, 0], [0, 0, 0], [0, 1, 1]])
        np.testing.assert_array_equal(EVENTS.counts(0.007, by="patch"), [[2, 1, 1], [0, 1, 1]])
        np.testing.assert_array_equal(EVENTS.counts(0.01, begin_s=0.003, end_s=0.013), [[1], [1], [0], [1]])

    def test_rates_over_all_and_in_bins(self):
        np.testing.assert_allclose(EVENTS.rates_hz(end_s=0.02), [150, 50, 0, 100])
        np.testing.assert_allclose(EVENTS.rates_hz(by="patch", end_s=0.02), [100, 50])
        np.testing.assert_allclose(EVENTS.rates_hz(0.01, by="patch", end_s=0.02), [[150, 50], [50, 50]])

    def test_trains_and_intervals(self):
        trains = EVENTS.trains_s()
        self.assertEqual(len(trains), 4)
        for train, expected in zip(trains, [[0, 0.007, 0.014], [0.003], [], [0.007, 0.019]]):
            np.testing.assert_allclose(train, expected)
        np.testing.assert_allclose(EVENTS.intervals_s(0), [0.007, 0.007])
        np.testing.assert_allclose(EVENTS.intervals_s(), [0.007, 0.007, 0.012])
        self.assertEqual(len(EVENTS.intervals_s(2)), 0)

    def test_no_events_have_empty_answers(self):
        none = EventSet(np.empty(0, afferent.event_dtype))
        self.assertEqual(none.counts(0.1).shape, (0, 0))
        self.assertEqual(none.trains_s(), [])
        self.assertEqual(len(none.intervals_s()), 0)
        self.assertIn("0 events", none._repr_html_())
        with self.assertRaisesRegex(ValueError, "span of time"):
            none.rates_hz()

    def test_what_cannot_be_counted_is_refused(self):
        for width in (0, -1, float("nan"), float("inf")):
            with self.assertRaisesRegex(ValueError, "bin_s must be"):
                EVENTS.counts(width)
        with self.assertRaisesRegex(ValueError, "begin_s must be at most end_s"):
            EVENTS.counts(0.1, begin_s=2, end_s=1)
        with self.assertRaisesRegex(ValueError, "must be .afferent. or .patch., is 'element'"):
            EVENTS.counts(0.1, by="element")
        with self.assertRaisesRegex(ValueError, "patches of these events are not known"):
            EventSet(EVENTS.events).counts(0.1, by="patch")


class ResultsTest(unittest.TestCase):
    def test_arrays_are_read_only(self):
        scene = Scene(duration_s=3, decoder=dict(filter={}, parts="PATCHES"))
        result = afferent.run(scene)
        for array in (result.events, result.force, result.emg, *result.parts.values(), *result.readouts.values()):
            with self.assertRaises(ValueError):
                array["time" if "time" in array.dtype.names else "true"][:] = 0
        np.copyto(result.events.copy()["time"], 0)

    def test_every_column_has_a_unit(self):
        result = afferent.run(GRASP, duration_s=1)
        without = {"doubt", "address", "patch", "contact", "afferents", "events"}
        for array in (result.events, result.force, result.emg, *result.readouts.values()):
            for column in set(array.dtype.names) - without:
                in_name = re.search(r"_(n|mm|mm2|deg|mm_per_s|hz)$", column)
                self.assertTrue(in_name or column in result.units, column)

    def test_bins_hold_all_events_of_a_run(self):
        result = afferent.run(GRASP)
        self.assertEqual(result.counts(0.25).shape, (9, 40))
        self.assertEqual(result.counts(0.25).sum(), len(result))

    def test_show_themselves_in_a_notebook(self):
        scene = Scene(name="<b>", duration_s=2)
        self.assertIn("&lt;b&gt;", scene._repr_html_())
        self.assertNotIn("<b><b>", scene._repr_html_())
        plan = afferent.plan(scene)._repr_html_()
        self.assertIn("9 elements", plan)
        self.assertIn("left out", plan)
        result = afferent.run(scene)._repr_html_()
        self.assertIn(">thumb<", result)
        self.assertIn("force_error_rms_n", result)


class ArgumentsTest(unittest.TestCase):
    def test_a_path_stands_for_its_scene(self):
        self.assertEqual(len(afferent.run(str(GRASP))), len(afferent.run(Scene.from_file(GRASP))))
        self.assertEqual(afferent.plan(GRASP).neurons, 9)
        self.assertEqual(len(afferent.sweep(GRASP, {"duration_s": [0.1, 0.2]})), 2)

    def test_what_is_no_scene_is_answered_with_what_to_do(self):
        table = str(PROJECT / "examples/data/grip.csv")
        with self.assertRaisesRegex(afferent.SceneError, r"afferent\.run\(afferent\.Scene\.for_table\('"):
            afferent.run(table)
        with self.assertRaisesRegex(TypeError, "a scene is an afferent.Scene, or the path"):
            afferent.run(dict(duration_s=2))

    def test_a_wrong_keyword_is_answered_with_the_nearest(self):
        for call in (lambda: Scene(durations=2), lambda: afferent.run(GRASP, durations=2)):
            with self.assertRaisesRegex(TypeError, 'no argument "durations": did you mean "duration_s"'):
                call()
        with self.assertRaisesRegex(TypeError, 'did you mean "patches"'):
            Scene(patch=[])
        with self.assertRaisesRegex(TypeError, 'inspect has no argument "units": did you mean "unit"'):
            Scene.for_table("grip.csv", units="v")
        with self.assertRaisesRegex(TypeError, 'no argument "xyzzy"$'):
            afferent.run(GRASP, xyzzy=1)

    def test_empty_arrays_are_refused_by_name(self):
        for forces in ([], np.empty((0, 9)), np.empty((9, 0))):
            with self.assertRaisesRegex(ValueError, "^forces: the array is empty"):
                afferent.run(GRASP, forces)
        with self.assertRaisesRegex(ValueError, "^emg: the array is empty"):
            afferent.run(GRASP, emg=[])

    def test_a_unit_that_there_is_not_is_refused(self):
        with self.assertRaisesRegex(ValueError, 'unit must be "n"'):
            afferent.run(GRASP, [1.0], unit="pounds")


if __name__ == "__main__":
    unittest.main()
