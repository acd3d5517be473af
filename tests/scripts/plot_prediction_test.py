#!/usr/bin/python3
"""Runs scripts/plot/prediction on a hand-made prediction: figures, exit codes, messages."""

import math
import pathlib
import subprocess
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "plot" / "prediction"
PREDICTION = "recording,sequence,step,t_s,particle,member,x0_m,y0_m,psi_deg,u_mps,vm_mps,r_degps\n"


class PlotPrediction(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name)
        rows = [
            f"run,{s},{k},{10 * s + k},{p},{p % 2},{0.5 * k},{0.1 * k * p},{3 * p},{0.5 + 0.01 * p},{0.02 * p},{0.3 * p}\n"
            for s in range(2) for p in range(3) for k in range(10)
        ]
        self.write("prediction.csv", PREDICTION + "".join(rows))
        head = "t_s,u_mps,vm_mps,r_degps,x0_m,y0_m,psi_deg,delta_deg,n_p_rps,app_wind_speed_mps,app_wind_dir_deg\n"
        rows = [f"{k},0.5,0.01,{math.sin(k)},{0.5 * k},0.1,{5 * k},{k % 7},9.5,1.1,{350 + k}\n" for k in range(21)]
        self.write("truth.csv", head + "".join(rows))
        foreign = "time,u,v,r [rad/s]\n" + "".join(f"{k},0.5,{'nan' if k == 3 else 0.01},0.02\n" for k in range(21))
        self.write("foreign.csv", foreign)
        self.write("map.json", '{"t_s": "time", "u_mps": "u", "vm_mps": "v", "missing": ["nan"], '
                               '"r_degps": {"from": "r [rad/s]", "unit": "radps"}}')

    def write(self, name, text):
        (self.path / name).write_text(text, encoding="utf-8")

    def run_script(self, *arguments):
        return subprocess.run([SCRIPT, *arguments], cwd=self.path, capture_output=True, text=True, check=False)

    def assert_answer(self, code, message, *arguments):
        done = self.run_script(*arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertIn(message, done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertEqual(list(self.path.glob("*figure*")) + list(self.path.glob(".*")), [])

    def test_it_writes_a_figure_and_the_same_one_again(self):
        for name in ("a.svg", "b.svg"):
            done = self.run_script("prediction.csv", "truth.csv", "--observed", "truth.csv", "--sequence", "1",
                                   "--length-m", "1", "-o", name)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual((self.path / "a.svg").read_bytes(), (self.path / "b.svg").read_bytes())

    def test_sequences_follow_one_another_in_one_figure(self):
        done = self.run_script("prediction.csv", "truth.csv", "--sequence", "0,1", "-o", "both.svg")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        drawn = (self.path / "both.svg").read_text(encoding="utf-8")
        self.assertIn("sequence 0, 1: 3 particles, 19 s", drawn)
        self.assertIn("start, restart", drawn)

    def test_it_reads_foreign_recordings_with_missing_samples_and_without_position(self):
        done = self.run_script("prediction.csv", "foreign.csv", "--columns", "map.json", "-o", "foreign.png")
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_a_wrong_command_line_is_answered_with_2(self):
        self.assert_answer(2, "must end with .png", "prediction.csv", "truth.csv", "-o", "figure.gif")
        self.assert_answer(2, "it has 0, 1", "prediction.csv", "truth.csv", "--sequence", "7", "-o", "figure.png")
        self.assert_answer(2, "it has 0, 1", "prediction.csv", "truth.csv", "--sequence", "0,7", "-o", "figure.png")
        self.assert_answer(2, "a whole number", "prediction.csv", "truth.csv", "--sequence", "0-1", "-o", "figure.png")
        self.assert_answer(2, "it holds run", "prediction.csv", "truth.csv", "--recording", "x", "-o", "figure.png")
        self.assert_answer(2, "shipped: frt-ds-esso", "prediction.csv", "truth.csv", "--columns", "x", "-o", "figure.png")

    def test_wrong_contents_are_answered_with_3_and_their_place(self):
        self.assert_answer(3, "foreign.csv:1: no column for t", "prediction.csv", "foreign.csv", "-o", "figure.png")
        self.write("bad.csv", PREDICTION + "run,0,0,0,0,0,0,0,0,0.5,x,0\n")
        self.assert_answer(3, "bad.csv:2: column 'vm_mps'", "bad.csv", "truth.csv", "-o", "figure.png")
        self.write("bad.csv", "")
        self.assert_answer(3, "bad.csv: the file is empty", "bad.csv", "truth.csv", "-o", "figure.png")

    def test_a_file_that_cannot_be_read_or_written_is_answered_with_4(self):
        self.assert_answer(4, "absent.csv: No such file", "absent.csv", "truth.csv", "-o", "figure.png")
        self.assert_answer(4, "truth.csv", "prediction.csv", "truth.csv", "-o", "truth.csv/figure.png")


if __name__ == "__main__":
    unittest.main()
