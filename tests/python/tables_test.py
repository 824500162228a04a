"""Tables as they come: read, inspected, and run without a scene written by hand."""
import pathlib
import tempfile
import unittest
import warnings

import numpy as np

import afferent
from afferent import Scene


class TablesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def six(self, name="six.csv", begin_s=0.0):
        """Six resistors in volts at 250 Hz, with semicolons and decimal commas."""
        time_s = np.arange(0, 4, 1 / 250)
        grip = np.clip(time_s - 1, 0, 1) * np.clip(3.5 - time_s, 0, 1)
        volt = 2.5 * grip[:, None] * [1, 0.9, 0.8, 0.7, 0.6, 0.5]
        lines = ["zeit_s;" + ";".join(f"f{i}_v" for i in range(1, 7))]
        lines += [";".join(f"{value:.6f}".replace(".", ",") for value in (t, *row))
                  for t, row in zip(time_s + begin_s, volt)]
        file = self.folder / name
        file.write_text("\n".join(lines) + "\n")
        return file, time_s, volt

    def test_is_read_as_it_is(self):
        file, time_s, volt = self.six(begin_s=1000)
        table = afferent.read_table(file)
        self.assertEqual(table.columns, [f"f{i}_v" for i in range(1, 7)])
        np.testing.assert_array_equal(table.times, np.rint(time_s * 1e9))
        np.testing.assert_allclose(table.values, volt, atol=5.1e-7)  # of six decimals
        self.assertFalse(table.values.flags.owndata)
        some = afferent.read_table(file, columns=["f2_v"], begin_s=1002)
        np.testing.assert_array_equal(some.values[:, 0], table.values[500:, 1])
        self.assertEqual(some.times[0], 0)

    def test_says_what_it_is_taken_for(self):
        found = afferent.inspect(self.six()[0])
        self.assertAlmostEqual(found.rate_hz, 250, places=6)
        self.assertEqual([column.use for column in found.columns], ["force"] * 6)
        self.assertEqual({column.unit for column in found.columns}, {"volts"})
        self.assertEqual(found.gaps, 0)
        self.assertGreater(len(found.assumptions), 0)  # nobody has said the curve of the sensors
        for sentence in (*found.sentences, *found.assumptions):
            self.assertIn(sentence, str(found))
        self.assertEqual(len(found.table.times), 1000)

    def test_runs_in_five_lines(self):
        file = self.six()[0]
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            scene = Scene.for_table(file)
        self.assertGreater(len(told), 0)
        result = afferent.run(scene)
        self.assertEqual(result.neurons, 6)
        self.assertAlmostEqual(result.summary["duration_s"], 4, places=6)
        self.assertGreater(len(result), 100)
        self.assertGreater(result.force["estimate"].max(), 0.5)
        self.assertEqual(afferent.Scene(**scene.to_dict(), folder=scene.folder), scene)

    def test_what_is_told_is_not_guessed(self):
        file, _, volt = self.six()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = afferent.run(Scene.for_table(file, newtons_per_volt=2))
            by_points = afferent.run(Scene.for_table(file, calibration=[(0, 0), (5, 10)]))
        # Six decimals of a volt, through a converter of 12 bits.
        self.assertAlmostEqual(np.nanmax(result.force["true"]), 2 * volt.sum(axis=1).max(), delta=0.02)
        np.testing.assert_allclose(by_points.force["true"], result.force["true"], atol=0.02)

    def test_refuses_what_is_no_table_of_forces(self):
        (self.folder / "names.csv").write_text("time_s,note\n0,0.5\n1,2.25\n")
        self.assertIsNone(afferent.inspect(self.folder / "names.csv").scene)
        with self.assertRaisesRegex(afferent.SceneError, "names.csv"):
            Scene.for_table(self.folder / "names.csv")
        (self.folder / "torn.csv").write_text("time_s;a_n\n0;1\n1;x\n")
        with self.assertRaisesRegex(ValueError, "torn.csv:3"):
            afferent.inspect(self.folder / "torn.csv")
        with self.assertRaisesRegex(ValueError, "torn.csv:3"):
            afferent.read_table(self.folder / "torn.csv")
        with self.assertRaisesRegex((OSError, ValueError), "absent.csv"):
            afferent.read_table(self.folder / "absent.csv")
        for told in (dict(time_unit="weeks"), dict(unit="pounds")):
            with self.assertRaisesRegex(ValueError, next(iter(told))):
                afferent.inspect(self.six()[0], **told)


if __name__ == "__main__":
    unittest.main()
