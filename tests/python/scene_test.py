"""The scene and its plan."""
import pathlib
import pickle
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import afferent
from afferent import Scene, SceneError

PROJECT = pathlib.Path(__file__).resolve().parents[2]


class SceneTest(unittest.TestCase):
    def wrong(self, **fields):
        with self.assertRaises(SceneError) as caught:
            Scene(**fields)
        return caught.exception.messages

    def test_fields_are_those_of_the_text(self):
        built = Scene(name="a \"b\" ü", duration_s=2, seed=2**63, decoder=dict(inversion={}, parts="PATCHES"),
                      patches=[dict(name="thumb", elements=2, share=np.array([0.25, 0.5]), neuron=dict(delta_g=0.3))],
                      source=dict(profile=dict(point=[dict(time_s=0, force_n=1), dict(time_s=2, force_n=3)])),
                      record=dict(picture=False), link="tcp")
        read = Scene.from_text("""name: "a \\"b\\" ü" duration_s: 2 seed: 9223372036854775808
            decoder { inversion {} parts: PATCHES }
            patch { name: "thumb" elements: 2 share: [0.25, 0.5] neuron { delta_g: 0.3 } }
            source { profile { point { time_s: 0 force_n: 1 } point { time_s: 2 force_n: 3 } } }
            record { picture: false } link { tcp {} }""")
        self.assertEqual(built.text(), read.text())
        self.assertEqual((built.name, built.duration_s, built.seed), ("a \"b\" ü", 2, 2**63))

    def test_every_example_is_the_same_by_its_fields(self):
        for file in sorted((PROJECT / "examples").glob("*.txtpb")):
            scene = Scene.from_file(file)
            self.assertEqual(Scene(**scene.to_dict(), folder=scene.folder), scene, file)
            self.assertEqual(Scene.from_text(str(scene), folder=scene.folder), scene, file)
            self.assertEqual(pickle.loads(pickle.dumps(scene)), scene, file)

    def test_names_every_wrong_field(self):
        self.assertEqual(self.wrong(duration_s=-1), ["duration_s must be > 0 and at most 1e9, is -1"])
        self.assertEqual(self.wrong(patches=[dict(name="a", neuron=dict(tau_m_ms=-10))]),
                         ['patch "a": neuron.tau_m_ms must be 1e-6 to 1e6, is -10'])
        self.assertEqual(self.wrong(patches=[dict(elments=3)]),
                         ['Patch has no field "elments": did you mean "elements"?'])
        self.assertEqual(len(self.wrong(duration_s=-1, gain=dict(lambda_n=0))), 2)

    def test_refuses_values_of_another_type(self):
        for fields, message in (
            (dict(duration_s="long"), "duration_s must be a number, is 'long'"),
            (dict(seed=1.5), "seed must be a whole number, is 1.5"),
            (dict(record=dict(events=1)), "record.events must be a boolean, is 1"),
            (dict(decoder="fliter"), "decoder must be a dict, or one of sliding_window, exponential, interval, "
                                     "inversion, filter, is 'fliter'"),
            (dict(decoder=dict(curve="steddy")), "decoder.curve must be one of STEADY, ONSET, is 'steddy'"),
            (dict(gain=3), "gain must be a dict with the fields of Gain, is 3"),
            (dict(patches=[{}, dict(elements="x")]), "patches[1].elements must be a whole number, is 'x'"),
        ):
            self.assertEqual(self.wrong(**fields), [message])

    def test_a_file_is_named_with_line_and_column(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "wrong.txtpb"
            file.write_text("duration_s: 1\nseed: x\n")
            with self.assertRaisesRegex(SceneError, r"wrong\.txtpb:2:7: "):
                Scene.from_file(file)
            with self.assertRaisesRegex(SceneError, "No such file"):
                Scene.from_file(pathlib.Path(folder) / "absent.txtpb")

    def test_scene_errors_are_value_errors(self):
        with self.assertRaises(ValueError) as caught:
            Scene(duration_s=0)
        self.assertEqual(str(pickle.loads(pickle.dumps(caught.exception))), str(caught.exception))

    def test_plan_says_what_is_built_and_what_is_not(self):
        plan = afferent.plan(Scene(patches=[dict(name="thumb", elements=3, neuron=dict(delta_g=0))]))
        self.assertEqual((plan.elements, plan.neurons, plan.threads), (3, 3, 1))
        reasons = {part.name: (part.built, part.reason) for part in plan.items}
        self.assertEqual(reasons['patch "thumb": adaptation'], (False, "delta_g is 0"))
        self.assertIn("packets and codec", str(plan).split("Left out")[1])
        self.assertEqual(list(plan.population()["afferents"]["element"]), [0, 1, 2])

    def test_types_of_the_fields_are_current(self):
        with tempfile.TemporaryDirectory() as folder:
            written = pathlib.Path(folder) / "fields.py"
            subprocess.run([sys.executable, PROJECT / "python/write_fields.py", written], check=True)
            self.assertEqual(written.read_text(), (PROJECT / "python/afferent/fields.py").read_text(),
                             "run python/write_fields.py python/afferent/fields.py")


if __name__ == "__main__":
    unittest.main()
