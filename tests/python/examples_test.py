"""The five scripts of examples/python run, check what they say, and draw."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

try:
    import matplotlib  # noqa: F401
except ImportError:
    print("python3-matplotlib is not installed")
    sys.exit(77)

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples/python"
PICTURES = {
    "grasp": ["grasp.png", "grasp_filter.png"],
    "own_table": ["own_table.png"],
    "error_against_run_time": ["error_against_run_time.png"],
    "what_a_byte_buys": ["what_a_byte_buys.png"],
    "population": ["fingertip.png", "hand.png"],
}


class ExamplesTest(unittest.TestCase):
    def test_there_are_no_others(self):
        self.assertEqual({file.stem for file in EXAMPLES.glob("*.py")}, set(PICTURES))

    def test_each_runs_and_draws(self):
        for name, pictures in PICTURES.items():
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                done = subprocess.run([sys.executable, EXAMPLES / f"{name}.py", folder], capture_output=True, text=True,
                                      env={**os.environ, "MPLBACKEND": "Agg"})
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                self.assertTrue(done.stdout)
                for picture in pictures:
                    content = (pathlib.Path(folder) / picture).read_bytes()
                    self.assertTrue(content.startswith(b"\x89PNG"))
                    self.assertGreater(len(content), 10_000)


if __name__ == "__main__":
    unittest.main()
