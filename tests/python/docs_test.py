"""The code that docs/python.md shows runs, from top to bottom."""
import os
import pathlib
import re
import tempfile
import types
import unittest
import warnings

import numpy as np

PROJECT = pathlib.Path(__file__).resolve().parents[2]

try:
    import matplotlib
    import pandas  # noqa: F401

    matplotlib.use("Agg")
except ImportError:
    import sys

    print("python3-matplotlib or python3-pandas is not installed")
    sys.exit(77)

# What the page takes as given: arrays of a reader's own, and a motor.
GIVEN = dict(
    forces=np.full((200, 5), 1.0), seconds=np.arange(200) / 100, grip=np.full(200, 5.0), counts=np.full((200, 5), 500),
    emg=np.full(1000, 2100.0), forces_n=np.full(5, 1.0), motor=types.SimpleNamespace(drive=lambda command: None))


class DocsTest(unittest.TestCase):
    def test_code_runs_as_it_stands_there(self):
        page = (PROJECT / "docs/python.md").read_text()
        blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
        self.assertGreater(len(blocks), 5)
        names = dict(GIVEN)
        before = os.getcwd()
        with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            os.symlink(PROJECT / "examples", os.path.join(folder, "examples"))
            rows = [f"{k / 250};" + ";".join([str(k % 100 / 50)] * 6) for k in range(500)]
            (pathlib.Path(folder) / "six.csv").write_text("t_s;" + ";".join(f"f{i}_v" for i in range(6)) + "\n"
                                                          + "\n".join(rows) + "\n")
            os.chdir(folder)
            try:
                for block in blocks:
                    exec(compile(block, "docs/python.md", "exec"), names)
            finally:
                os.chdir(before)
        self.assertEqual(len(names["table"]), 6)
        self.assertEqual(names["step"].time_ns, 2_000_000_000)


if __name__ == "__main__":
    unittest.main()
