"""Whole runs: what they give is what the program writes."""
import csv
import gc
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import afferent
from afferent import Scene

PROGRAM = os.environ["AFFERENT_PROGRAM"]
PROJECT = pathlib.Path(__file__).resolve().parents[2]
PARTS = dict(duration_s=2, decoder=dict(filter={}, parts="PATCHES"), link="tcp",
             patches=[dict(name="thumb", elements=3), dict(name="index", elements=2)],
             source=dict(profile=dict(point=[dict(time_s=0, force_n=0), dict(time_s=2, force_n=12)])))


def table(file):
    with open(file, newline="") as lines:
        rows = list(csv.DictReader(lines))
    # Why the force may be larger is the one thing in words.
    of = lambda name: str if name.endswith("doubt") else lambda cell: float(cell or "nan")
    return {name: np.array([of(name)(row[name]) for row in rows]) for name in rows[0]}


class RunTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def program(self, *arguments):
        done = subprocess.run([PROGRAM, *map(str, arguments), "--json"], check=True, capture_output=True, text=True)
        return json.loads(done.stdout)

    def assert_is_what_the_program_writes(self, scene, result=None):
        file = self.folder / "scene.txtpb"
        file.write_text(scene.text())
        summary = self.program("run", file, "--out", self.folder / "out")
        result = result or afferent.run(scene)
        events, force, emg = (table(self.folder / "out" / name) for name in ("events.csv", "force.csv", "emg.csv"))
        np.testing.assert_array_equal(np.rint(events["time_s"] * 1e9).astype(np.int64), result.events["time"])
        np.testing.assert_array_equal(events["address"], result.events["address"])
        for column, field in (("true_force_n", "true"), ("estimate_n", "estimate"), ("sigma_n", "sigma"),
                              ("rate_hz", "rate"), ("gain", "gain")):
            np.testing.assert_array_equal(force[column], result.force[field], column)
        self.assertEqual(list(force["doubt"]), list(result.force["doubt"]))
        for part, rows in result.parts.items():
            self.assertEqual(list(force[f"{part}_doubt"]), list(rows["doubt"]), part)
            for field in ("true", "estimate", "sigma"):
                np.testing.assert_array_equal(force[f"{part}_{field}_n"], rows[field], part)
        for column in ("emg", "closing", "opening", "command"):
            np.testing.assert_array_equal(emg[column], result.emg[column], column)
        for name in set(result.summary) - {"run_time_s", "scene", "notes"}:
            self.assertEqual(result.summary[name], summary[name], name)
        self.assertGreater(len(result), 0)

    def test_is_what_the_program_writes(self):
        self.assert_is_what_the_program_writes(Scene(duration_s=4, decoder="inversion"))
        self.assert_is_what_the_program_writes(Scene(**PARTS))

    def test_arrays_are_views_that_outlive_the_result(self):
        result = afferent.run(Scene(**PARTS))
        self.assertEqual(result.events.dtype["time"], np.int64)
        self.assertEqual(result.events.dtype["address"], np.uint32)
        arrays = [result.events, result.force, result.emg, *result.parts.values()]
        for array in arrays:
            self.assertFalse(array.flags.owndata)
        self.assertTrue(np.may_share_memory(result.force, result.emg))
        sums = [np.nansum(array[array.dtype.names[1]]) for array in arrays]
        del result
        gc.collect()
        afferent.run(Scene(**PARTS))
        self.assertEqual(sums, [np.nansum(array[array.dtype.names[1]]) for array in arrays])

    def test_arrays_of_force_are_a_table(self):
        rng = np.random.default_rng(1)
        forces = rng.uniform(0, 2, (400, 5))
        emg = 2048 + 100 * rng.standard_normal(2000)
        with open(self.folder / "force.csv", "w") as file:
            file.write("time_s," + ",".join(f"e{i}_n" for i in range(5)) + "\n")
            for k, row in enumerate(forces):
                file.write(f"{k / 200!r}," + ",".join(map(repr, map(float, row))) + "\n")
        with open(self.folder / "emg.csv", "w") as file:
            file.write("time_s,emg_counts\n" + "".join(f"{k / 1000!r},{value!r}\n" for k, value in enumerate(map(float, emg))))
        of_tables = {**PARTS, "source": dict(table=dict(path="force.csv")), "hand": dict(emg_table=dict(path="emg.csv", column="emg_counts"))}
        self.assert_is_what_the_program_writes(Scene(**of_tables, folder=self.folder),
                                               afferent.run(Scene(**PARTS), forces, emg))

    def test_says_what_it_did_with_tables(self):
        scene = Scene(patches=[dict(name="a", elements=2)])
        self.assertNotIn("notes", afferent.run(Scene(duration_s=1)).summary)
        ends_early = afferent.run(scene, np.full((100, 2), 3.0), duration_s=2)
        self.assertTrue(any("forces" in note for note in ends_early.summary["notes"]), ends_early.summary)

    def test_a_run_lasts_as_long_as_its_forces(self):
        scene = Scene(patches=[dict(name="a", elements=2, sensor=dict(rate_hz=100))])
        forces = np.full((150, 2), 3.0)
        self.assertEqual(afferent.run(scene, forces).summary["duration_s"], 1.5)
        self.assertEqual(afferent.run(scene, forces, duration_s=1).summary["duration_s"], 1)
        self.assertEqual(afferent.run(scene, forces, times=np.arange(150) / 50).summary["duration_s"], 3)

    def test_one_grip_force_is_shared_and_counts_are_calibrated(self):
        scene = Scene(patches=[dict(name="a", elements=2, share=[0.25, 0.75])], decoder=dict(filter={}, parts="ELEMENTS"))
        result = afferent.run(scene, np.full(200, 4.0))
        self.assertEqual([rows["true"][-1] for rows in result.parts.values()], [1, 3])
        self.assertEqual(result.force["true"][-1], 4)
        counts = afferent.run(scene, np.full((200, 2), 4095), unit="counts")
        self.assertEqual(counts.force["true"][-1], 20)  # two elements at full scale

    def test_images_are_laid_over_the_skin(self):
        skin = dict(name="skin", outline=dict(rectangle=dict(width_mm=4, height_mm=4), pitch_mm=1),
                    sensor=dict(full_scale_n=1), encoder=dict(sustained=dict(gain_mv_per_n=100)))
        images = np.zeros((100, 4, 4))
        images[:, 0, 3] = 0.5  # the first row is at the top
        result = afferent.run(Scene(patches=[skin], record=dict(force=False, picture=False)), images)
        fired = result.afferents[np.unique(result.events["address"])]
        self.assertEqual([(row["x_mm"], row["y_mm"]) for row in fired], [(1.5, 1.5)])

    def test_refuses_arrays_that_do_not_fit(self):
        scene = Scene(**PARTS)
        for arguments, message in (
            (dict(forces=np.ones((10, 4))), "4 values in a scan, and the scene has 5 elements"),
            (dict(forces=np.ones((10, 5)), times=np.arange(9)), "9 times and 10 scans"),
            (dict(forces=np.ones((10, 5)), times=np.zeros(10)), "must rise"),
            (dict(forces=np.full((10, 5), np.nan)), "no number"),
            (dict(forces=np.ones((2, 2, 2, 2))), "one to three dimensions"),
            (dict(forces=np.ones((0, 5))), "the array is empty"),
            (dict(emg=np.ones((3, 2))), "one dimension"),
            (dict(emg=np.full(10, np.inf)), "sample 0 is not a number"),
            (dict(times=[1, 2]), "which are not given"),
        ):
            with self.assertRaisesRegex(ValueError, message):
                afferent.run(scene, **arguments)
        uneven = Scene(patches=[dict(name="a"), dict(name="b", sensor=dict(rate_hz=100))])
        with self.assertRaisesRegex(ValueError, "different rates"):
            afferent.run(uneven, np.ones((10, 6)))
        with self.assertRaisesRegex(OSError, "absent.csv"):
            afferent.run(Scene(source=dict(table=dict(path="absent.csv"))))

    def test_a_spike_storm_names_its_afferent(self):
        wild = dict(name="a", elements=1, encoder=dict(sustained=dict(gain_mv_per_n=1e9)))
        with self.assertRaisesRegex(afferent.SpikeStormError, "address 0 fires more often") as caught:
            unread = dict(force=False, picture=False)
            accepting = dict(accept_unreachable_limit=True)
            afferent.run(Scene(patches=[wild], record=unread, gain=accepting), np.ones((100, 1)))
        self.assertEqual(caught.exception.address, 0)

    def test_a_recording_gives_the_same_again(self):
        file = self.folder / "r.afferent"
        ran = afferent.run(Scene(**PARTS), record=file)
        replayed = afferent.read_recording(file)
        np.testing.assert_array_equal(ran.force["estimate"], replayed.force["estimate"])
        np.testing.assert_array_equal(ran.parts["index"]["sigma"], replayed.parts["index"]["sigma"])
        self.assertEqual(replayed.resolution_ns, 100_000)
        self.assertEqual(len(replayed), len(ran))
        # On the wire times are whole ticks.
        np.testing.assert_array_equal(replayed.events["time"] % 100_000, 0)
        self.assertLess(np.abs(np.sort(ran.events["time"]) - np.sort(replayed.events["time"])).max(), 100_000)
        self.assertTrue(replayed.summary["closed"])
        other = afferent.read_recording(file, decoder="sliding_window")
        self.assertGreater(np.abs(other.force["estimate"] - ran.force["estimate"]).max(), 0.1)

    def test_a_recording_is_of_packets(self):
        with self.assertRaisesRegex(ValueError, "in process"):
            afferent.run(Scene(duration_s=1), record=self.folder / "r.afferent")
        self.assertFalse((self.folder / "r.afferent").exists())
        scene = Scene(duration_s=1, link=dict(file=dict(path="own.afferent")), folder=self.folder)
        self.assertEqual(len(afferent.run(scene)), len(afferent.read_events(self.folder / "own.afferent")))

    def test_progress_rises_and_its_exceptions_end_the_run(self):
        told = []
        afferent.run(Scene(duration_s=200), progress=told.append)
        self.assertEqual(told, sorted(told))
        self.assertEqual(told[-1], 1)
        self.assertGreater(len(told), 1)

        def refuse(fraction):
            raise KeyError(fraction)

        with self.assertRaises(KeyError):
            afferent.run(Scene(duration_s=2000), progress=refuse)

    def test_other_threads_run_meanwhile(self):
        counted = [0]
        ended = threading.Event()

        def count():
            while not ended.is_set():
                counted[0] += 1
                time.sleep(0.001)

        counter = threading.Thread(target=count)
        counter.start()
        before = counted[0]
        afferent.run(Scene(duration_s=400))
        meanwhile = counted[0] - before
        ended.set()
        counter.join()
        self.assertGreater(meanwhile, 5)

    def test_interrupt_ends_a_run_and_completes_its_recording(self):
        file = self.folder / "r.afferent"
        script = """
import afferent, sys
scene = afferent.Scene(duration_s=1e6, link="tcp", hand=dict(user=dict(close_at_s=0)))
try:
    afferent.run(scene, progress=lambda fraction: print(fraction, flush=True), record=sys.argv[1])
except KeyboardInterrupt:
    sys.exit(3)
"""
        process = subprocess.Popen([sys.executable, "-c", script, file], stdout=subprocess.PIPE, text=True)
        self.assertGreater(float(process.stdout.readline()), 0)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)
        self.assertEqual(process.returncode, 3)
        replayed = afferent.read_recording(file)
        self.assertTrue(replayed.summary["closed"])
        self.assertGreater(len(replayed), 0)


if __name__ == "__main__":
    unittest.main()
