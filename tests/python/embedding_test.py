"""Coprocessor, controller and decoder as a program embeds them."""
import threading
import unittest

import numpy as np

import afferent
from afferent import Scene

FRAME = 5_000_000
SCENE = Scene(patches=[dict(name="thumb", elements=3)], source="pushed", hand=dict(emg_rate_hz=200),
              decoder=dict(filter={}, parts="ELEMENTS"), duration_s=2)


def forces_at(time_ns):
    return np.array([1.2, 1.0, 0.8]) * time_ns * 1e-9


class SidesTest(unittest.TestCase):
    def test_together_they_do_what_a_run_does(self):
        coprocessor, controller, decoder = (of(SCENE) for of in
                                            (afferent.Coprocessor, afferent.Controller, afferent.Decoder))
        events = []
        for now in range(0, 2 * 10**9, FRAME):
            coprocessor.push(now, forces_at(now))
            end = now + FRAME
            events.append(coprocessor.advance(end - 1))
            controller.observe(now, end, events[-1])
            step = controller.step(end, 2300)
            decoder.observe(now, end, events[-1])
            estimate = decoder.estimate(end)
            self.assertEqual((estimate.force_n, estimate.sigma_n, estimate.doubt),
                             (step.force_n, step.sigma_n, step.estimate.doubt))
            self.assertEqual(len(step.parts), 3)
        self.assertGreater(step.force_n, 3)
        self.assertLess(step.gain, 1)
        self.assertLess(step.parts[2].force_n, step.parts[0].force_n)
        self.assertEqual(coprocessor.now_ns, 2 * 10**9 - 1)
        ran = afferent.run(SCENE, np.array([forces_at(now) for now in range(0, 2 * 10**9, FRAME)]))
        np.testing.assert_array_equal(np.concatenate(events), ran.events)

    def test_an_estimate_says_why_the_force_may_be_larger(self):
        decoder = afferent.Decoder(Scene(patches=[dict(name="thumb", elements=3)], source="pushed",
                                         decoder=dict(inversion={})))
        self.assertEqual(decoder.estimate(0).doubt, "unknown")
        # More often than any sensor could make them fire.
        events = np.array([(k * 10**5, address) for k in range(5000) for address in range(3)],
                          dtype=[("time", "i8"), ("address", "u4")])
        decoder.observe(0, 5 * 10**8, events)
        self.assertEqual(decoder.estimate(5 * 10**8).doubt, "saturated")
        self.assertIn("doubt='saturated'", repr(decoder.estimate(5 * 10**8)))

    def test_events_stay_when_more_are_computed(self):
        coprocessor = afferent.Coprocessor(SCENE)
        coprocessor.push(0, [9, 9, 9])
        events = coprocessor.advance(10**9)
        copy = events.copy()
        coprocessor.advance(2 * 10**9)
        np.testing.assert_array_equal(events, copy)
        coprocessor.reset()
        coprocessor.push(0, (9, 9, 9))
        np.testing.assert_array_equal(coprocessor.advance(10**9), copy)

    def test_a_snapshot_continues_bit_for_bit(self):
        for of in (afferent.Controller, afferent.Decoder):
            coprocessor, one = afferent.Coprocessor(SCENE), of(SCENE)

            def advance(decoding, begin, events):
                decoding.observe(begin, begin + 10**9, events)
                return decoding.step(begin + 10**9).estimate if of is afferent.Controller else decoding.estimate(
                    begin + 10**9)

            coprocessor.push(0, [3, 3, 3])
            advance(one, 0, coprocessor.advance(10**9 - 1))
            snapshot = one.snapshot()
            events = coprocessor.advance(2 * 10**9 - 1)
            other = of(SCENE)
            other.resume(snapshot)
            self.assertEqual(advance(one, 10**9, events).force_n, advance(other, 10**9, events).force_n)

    def test_says_what_does_not_fit(self):
        coprocessor, controller, decoder = (of(SCENE) for of in
                                            (afferent.Coprocessor, afferent.Controller, afferent.Decoder))
        with self.assertRaisesRegex(ValueError, "the scene has 3 elements"):
            coprocessor.push(0, [1, 2, 3, 4])
        with self.assertRaisesRegex(ValueError, "the scene has 3 elements"):
            coprocessor.push(0, [1], first=3)
        coprocessor.push(0, [np.nan, 1], first=1)
        self.assertEqual(coprocessor.refused_samples, 1)
        for decoding in (controller, decoder):
            for begin, end, events, message in (
                (10, 5, [], "not be before begin_ns"),
                (0, 10, [(5, 3)], "address 3"),
                (0, 10, [(5, 0), (4, 0)], "sorted"),
                (0, 10, [(10, 0)], "within"),
                (0, 10, [(-1, 0)], "within"),
            ):
                with self.assertRaisesRegex(ValueError, message):
                    decoding.observe(begin, end, np.array(events, afferent.event_dtype))
            decoding.lose(0, 10)
            with self.assertRaisesRegex(ValueError, "where the last span ended"):
                decoding.observe(5, 20, np.empty(0, afferent.event_dtype))
            self.assertEqual(decoding.heard_until_ns, 10)
        with self.assertRaisesRegex(ValueError, "operating, frozen or safe"):
            controller.state = "asleep"
        controller.state = "frozen"
        self.assertEqual(controller.state, "frozen")
        with self.assertRaises(ValueError):
            decoder.estimate(5)
        with self.assertRaisesRegex(ValueError, "last step"):
            controller.step(20)
            controller.step(10)
        with self.assertRaises(OSError):  # this link carries no packets
            controller.receive(b"abc")
        with self.assertRaises(ValueError):
            afferent.Controller(Scene(link="tcp")).receive(b"abc")

    def test_takes_events_of_any_layout(self):
        packed = np.array([(10, 0), (20, 1)], [("address", "u2"), ("time", "u8")][::-1])
        strided = np.zeros(4, afferent.event_dtype)
        strided["time"] = [10, 0, 20, 0]
        for events in (packed, strided[::2]):
            decoder = afferent.Decoder(SCENE)
            decoder.observe(0, 30, events)
            self.assertEqual(decoder.heard_until_ns, 30)

    def test_two_threads_cannot_use_one_at_once(self):
        # 2,000 neurons at 100 Hz take long enough for another thread to come.
        scene = Scene(patches=[dict(name="a", elements=2000)], source="pushed", record=dict(force=False, picture=False))
        coprocessor = afferent.Coprocessor(scene)
        coprocessor.push(0, np.full(2000, 20 / 2000))
        thread = threading.Thread(target=coprocessor.advance, args=(5 * 10**9,))
        refused = 0
        thread.start()
        while thread.is_alive():
            try:
                coprocessor.push(0, [1.0])
            except RuntimeError as error:
                self.assertIn("another thread", str(error))
                refused += 1
        thread.join()
        self.assertGreater(refused, 0)


if __name__ == "__main__":
    unittest.main()
