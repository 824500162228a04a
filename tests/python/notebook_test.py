"""The notebook of examples/python runs from top to bottom, and shows what it is for."""
import os
import pathlib
import sys
import unittest

try:
    import ipykernel  # noqa: F401
    import matplotlib  # noqa: F401
    import nbclient
    import nbformat
except ImportError as error:
    print(f"{error}: Debian has python3-nbclient, python3-ipykernel and python3-matplotlib")
    sys.exit(77)

NOTEBOOK = pathlib.Path(__file__).resolve().parents[2] / "examples/python/fingertip.ipynb"
# Longer than a busy machine takes for any cell.
PATIENCE_S = 300


class NotebookTest(unittest.TestCase):
    def test_runs_and_shows_tables_and_pictures(self):
        notebook = nbformat.read(NOTEBOOK, as_version=4)
        for cell in notebook.cells:
            self.assertFalse(cell.get("outputs"), "the notebook is kept without outputs")
        nbclient.NotebookClient(notebook, timeout=PATIENCE_S, kernel_name="python3",
                                resources={"metadata": {"path": str(NOTEBOOK.parent)}}).execute()
        shown = [output.get("data", {}) for cell in notebook.cells for output in cell.get("outputs", [])]
        self.assertEqual(sum("text/html" in data for data in shown), 3)  # scene, plan and result
        self.assertEqual(sum("image/png" in data for data in shown), 5)
        said = "".join(output.get("text", "") for cell in notebook.cells for output in cell.get("outputs", []))
        self.assertRegex(said, r"filter +0\.\d\d N RMS")


if __name__ == "__main__":
    os.environ["MPLBACKEND"] = "module://matplotlib_inline.backend_inline"
    unittest.main()
