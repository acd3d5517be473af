#!/usr/bin/python3
"""Runs scripts/plot/distributions on hand-made sets: figures from every kind of set, exit codes, messages."""

import json
import pathlib
import subprocess
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "plot" / "distributions"
SIGNATURES = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}


def trajectory(rudder, header="t_s,u_mps,vm_mps,r_degps,delta_deg"):
    rows = "".join(f"{k},{0.3 + 0.01 * k},{0.02 * k},{k % 7},{rudder if k % 5 else ''}\n" for k in range(40))
    return f"{header}\n{rows}"


class PlotDistributions(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)
        for name, rudder in (("Train/a.csv", 10), ("Train/b.csv", -5), ("Test/c.csv", 20)):
            (self.path / name).parent.mkdir(exist_ok=True)
            (self.path / name).write_text(trajectory(rudder), encoding="utf-8")
        sets = [{"name": "Train", "recordings": [{"file": "Train/a.csv"}, {"file": "Train/b.csv"}]},
                {"name": "Test", "recordings": [{"file": "Test/c.csv"}]}]
        (self.path / "dataset.json").write_text(json.dumps({"sets": sets}), encoding="utf-8")

    def run_script(self, *arguments):
        return subprocess.run([SCRIPT, *arguments, "--quantities", "u,vm,r,delta"], cwd=self.path, capture_output=True,
                              text=True, check=False)

    def test_figures_of_every_kind_of_set_in_every_format(self):
        for suffix, sets in ((".png", ["Train", "Test"]), (".svg", ["dataset.json"]), (".pdf", ["Train/a.csv", "dataset.json#Test"])):
            with self.subTest(suffix):
                result = self.run_script(*sets, "-o", f"pairs{suffix}")
                self.assertEqual((result.returncode, result.stderr), (0, ""))
                self.assertTrue((self.path / f"pairs{suffix}").read_bytes().startswith(SIGNATURES[suffix]))

    def test_the_legend_counts_the_samples_that_have_all_quantities(self):
        self.run_script("dataset.json", "-o", "pairs.svg")
        # Text is drawn as glyphs; the comments beside them hold it.
        text = (self.path / "pairs.svg").read_text(encoding="utf-8")
        self.assertIn("<!-- Train (64 samples) -->", text)
        self.assertIn("<!-- Test (32 samples) -->", text)

    def test_wrong_inputs_end_with_one_line_and_the_right_code(self):
        (self.path / "empty").mkdir()
        (self.path / "bare.csv").write_text("t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n1,1,0,0\n", encoding="utf-8")
        for arguments, code, message in (
            (["dataset.json#X"], 2, "has no set 'X'; it has Train, Test"),
            (["Train", "dataset.json#Train"], 2, "two sets are called 'Train'"),
            (["empty"], 3, "the folder holds no .csv file"),
            (["bare.csv"], 3, "bare.csv:1: no column for delta"),
            (["nowhere.csv"], 4, "nowhere.csv"),
        ):
            with self.subTest(arguments):
                result = self.run_script(*arguments, "-o", "pairs.png")
                self.assertEqual(result.returncode, code)
                self.assertIn(message, result.stderr)
                self.assertEqual(result.stderr.count("\n"), 1)
                self.assertFalse((self.path / "pairs.png").exists())
        self.assertEqual(self.run_script("Train", "-o", "pairs.gif").returncode, 2)


if __name__ == "__main__":
    unittest.main()
