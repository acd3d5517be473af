#!/usr/bin/python3
"""Runs scripts/plot/trajectory on hand-made files: figures of every kind of data, exit codes, messages, thinning."""

import importlib
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "plot"
SCRIPT = FOLDER / "trajectory"
SIGNATURES = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}

sys.dont_write_bytecode = True
sys.path.insert(0, str(FOLDER))
figure = importlib.import_module("figure")
trajectory_files = importlib.import_module("trajectory_files")


def circle(rows=60, extra_names="", extra_values=""):
    """A turn to starboard at 0.5 m/s and 3 deg/s, as trajectory CSV."""
    text = f"t_s,u_mps,vm_mps,r_degps,x0_m,y0_m,psi_deg{extra_names}\n"
    for k in range(rows):
        psi = math.radians(3.0 * k)
        x0, y0 = 9.55 * math.sin(psi), 9.55 * (1.0 - math.cos(psi))
        text += f"{k},0.5,-0.02,3,{x0:.4f},{y0:.4f},{(3 * k) % 360}{extra_values.format(k=k)}\n"
    return text


def prediction(particles, sequences=2, recording="run"):
    text = "recording,sequence,step,t_s,particle,member,x0_m,y0_m,psi_deg,u_mps,vm_mps,r_degps\n"
    for s in range(sequences):
        for p in range(particles):
            for k in range(10):
                text += f"{recording},{s},{k},{10 * s + k},{p},{p % 2},{0.5 * k},{0.1 * k * p},{3 * p},"
                text += f"{0.5 + 0.01 * p},{0.02 * p},{0.3 * p}\n"
    return text


class PlotTrajectory(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)
        self.write("turn.csv", circle())

    def write(self, name, text):
        (self.path / name).parent.mkdir(exist_ok=True)
        (self.path / name).write_text(text, encoding="utf-8")

    def run_script(self, *arguments, given=None):
        return subprocess.run([SCRIPT, *arguments], cwd=self.path, capture_output=True, input=given, text=True, check=False)

    def assert_figure(self, *arguments, name="figure.svg", given=None):
        """Runs the script without complaint; the figure's bytes."""
        done = self.run_script(*arguments, "-o", name, given=given)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        figure_bytes = (self.path / name).read_bytes()
        self.assertTrue(figure_bytes.startswith(SIGNATURES[pathlib.Path(name).suffix]))
        self.assertEqual(list(self.path.glob(".*")), [])
        return figure_bytes

    def assert_drawn(self, text, figure_bytes, expected=True):
        """Whether a text stands in a figure: SVG keeps it as a comment beside its outlines."""
        self.assertEqual(text.encode() in figure_bytes, expected, text)

    def assert_answer(self, code, message, *arguments):
        done = self.run_script(*arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertIn(message, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)
        self.assertEqual(done.stdout, "")
        self.assertEqual(list(self.path.glob("*figure*")) + list(self.path.glob(".*")), [])

    def assert_wrong(self, message, text):
        """A file of this text is refused with its place."""
        self.write("bad.csv", text)
        self.assert_answer(3, message, "bad.csv", "-o", "figure.png")

    def test_a_figure_comes_out_in_all_three_formats_and_again_the_same(self):
        for suffix in SIGNATURES:
            first = self.assert_figure("turn.csv", "--ship", "esso-osaka-3m", name=f"new/folder{suffix}")
            again = self.assert_figure("turn.csv", "--ship", "esso-osaka-3m", name=f"again{suffix}")
            self.assertEqual(first, again)

    def test_panels_without_data_disappear(self):
        bare = self.assert_figure("turn.csv")
        for text in ("delta", "n_P", "wind"):
            self.assert_drawn(text, bare, False)
        self.write("all.csv", circle(60, ",delta_p_deg,delta_s_deg,n_p_rps,n_bt_rps,n_st_rps,i_bt,wind_speed_mps,wind_dir_deg",
                                     ",{k},-{k},10,5,-5,0.3,1.5,35{k}"))
        full = self.assert_figure("all.csv")
        for text in ("\\delta_P", "\\delta_S", "n_P", "n_{BT}", "n_{ST}", "i_{BT}", "true wind", "from [deg]"):
            self.assert_drawn(text, full)
        self.assert_drawn("apparent", full, False)

    def test_the_apparent_wind_is_drawn_where_there_is_no_other_or_it_is_asked_for(self):
        apparent = ",app_wind_speed_mps,app_wind_dir_deg", ",1,350"
        self.write("apparent.csv", circle(60, *apparent))
        self.assert_drawn("apparent wind", self.assert_figure("apparent.csv"))
        self.write("both.csv", circle(60, apparent[0] + ",wind_speed_mps,wind_dir_deg", apparent[1] + ",2,90"))
        self.assert_drawn("apparent wind", self.assert_figure("both.csv"), False)
        chosen = self.assert_figure("both.csv", "--wind", "apparent")
        self.assert_drawn("apparent wind", chosen)
        self.assert_drawn("true wind", chosen, False)

    def test_overlaid_files_are_named_by_as_much_of_their_paths_as_tells_them_apart(self):
        self.write("truth/turn.csv", circle(30))
        self.write("other.csv", circle(20, ",delta_deg", ",{k}"))
        drawn = self.assert_figure("turn.csv", "truth/turn.csv", "other.csv", "turn.csv", "--title", "Cost $5")
        for text in ("turn (1)", "truth/turn", "other", "turn (4)", "Cost $5"):
            self.assert_drawn(f"<!-- {text} -->", drawn)
        drawn = self.assert_figure("turn.csv", "other.csv", "--label", "measured", "--label", "_simulated")
        for text in ("measured", " _simulated"):
            self.assert_drawn(f"<!-- {text} -->", drawn)

    def test_predictions_are_drawn_alone_and_over_their_truth(self):
        self.write("prediction.csv", prediction(30))
        drawn = self.assert_figure("prediction.csv", "turn.csv", "--ship", "vectwin-3m")
        self.assert_drawn("5 to 95 % of its 30 particles", drawn)
        self.write("single.csv", prediction(1))
        self.assert_drawn("particles", self.assert_figure("single.csv"), False)
        self.assert_figure("single.csv", "--sequence", "1", "--to-s", "15")

    def test_a_foreign_recording_is_overlaid_with_one_of_ours(self):
        rows = "".join(f"{k},0.5,{'nan' if k == 3 else 0.01},0.02,0.1\n" for k in range(21))
        self.write("foreign.csv", "# a comment\ntime,u,v,r [rad/s],helm\n" + rows)
        columns = {"t_s": "time", "u_mps": "u", "vm_mps": "v", "r_degps": {"from": "r [rad/s]", "unit": "radps"},
                   "delta_deg": {"from": "helm", "unit": "rad"}, "missing": ["nan"]}
        self.write("map.json", json.dumps(columns))
        self.assert_drawn("delta", self.assert_figure("foreign.csv", "turn.csv", "--columns", "map.json"))

    def test_recordings_with_gaps_without_positions_and_of_one_row_are_drawn(self):
        lines = circle().split("\n")
        lines[7] = lines[7].replace(",0.5,", ",,")  # a missing sample
        lines[20] = "," * 6  # a row of missing samples
        del lines[30:40]  # a hole in time
        self.write("gaps.csv", "\r\n".join(lines))
        self.assert_figure("gaps.csv", "--outline-interval-s", "5")
        self.write("bare.csv", "t_s,u_kn,vm_mps,r_radps\n0,1,0,0\n1,1,0,0\n")
        self.assert_figure("bare.csv", "--length-m", "3")
        self.write("one.csv", circle(1))
        self.assert_figure("one.csv", "--length-m", "3", "--beam-m", "0.5")
        self.assert_figure("-", given=circle())

    def test_a_wrong_command_line_is_answered_with_2(self):
        self.assert_answer(2, "must end with .png, .svg, .pdf, got 'figure.gif'", "turn.csv", "-o", "figure.gif")
        self.assert_answer(2, "required: -o", "turn.csv")
        self.assert_answer(2, "shipped: esso-osaka-3m", "turn.csv", "--ship", "titanic", "-o", "figure.png")
        self.assert_answer(2, "shipped: frt-ds-esso", "turn.csv", "--columns", "x", "-o", "figure.png")
        self.assert_answer(2, "1 --label for 2 files", "turn.csv", "turn.csv", "--label", "x", "-o", "figure.png")
        self.assert_answer(2, "it has 0 to 59 s", "turn.csv", "--from-s", "70", "-o", "figure.png")
        self.assert_answer(2, "--from-s 7 is not before --to-s 6", "turn.csv", "--from-s", "7", "--to-s", "6", "-o", "figure.png")
        self.assert_answer(2, "expected a number > 0, got -3", "turn.csv", "--length-m", "-3", "-o", "figure.png")
        self.assert_answer(2, "finite number, got 'nan'", "turn.csv", "--beam-m", "nan", "-o", "figure.png")
        self.assert_answer(2, "--beam-m needs", "turn.csv", "--beam-m", "2", "-o", "figure.png")
        self.assert_answer(2, "more than 10000 outlines", "turn.csv", "--outline-interval-s", "1e-6", "-o", "figure.png")
        self.write("two.csv", prediction(1) + prediction(1, recording="other").split("\n", 1)[1])
        self.assert_answer(2, "choose one with --recording: run, other", "two.csv", "-o", "figure.png")
        self.assert_answer(2, "has no sequence 7; it has 0, 1", "two.csv", "--recording", "run", "--sequence", "7", "-o", "figure.png")

    def test_wrong_contents_are_answered_with_3_and_their_place(self):
        head = "t_s,u_mps,vm_mps,r_degps\n"
        self.assert_wrong("bad.csv: the file is empty", "")
        self.assert_wrong("bad.csv: no data row", head)
        self.assert_wrong("bad.csv:1: no column for t; found time, u_mps", "time,u_mps\n0,1\n")
        self.assert_wrong("bad.csv:1: column 'u_mps' stands twice", "t_s,u_mps,u_mps,vm_mps,r_degps\n0,0,0,0,0\n")
        self.assert_wrong("bad.csv:1: column 'u_kn': holds the same", "t_s,u_mps,u_kn,vm_mps,r_degps\n0,0,0,0,0\n")
        self.assert_wrong("bad.csv:3: expected 4 fields, found 3", head + "0,0,0,0\n1,0,0\n")
        self.assert_wrong("bad.csv:3: column 'u_mps': expected a finite number, got 'nan'", head + "0,0,0,0\n1,nan,0,0\n")
        self.assert_wrong("bad.csv:2: column 'r_degps': expected a finite number, got 'fast'", head + "0,0,0,fast\n")
        self.assert_wrong("bad.csv:4: column 't_s': time must increase", head + "0,0,0,0\n2,0,0,0\n2,0,0,0\n")
        self.assert_wrong("bad.csv:3: column 't_s': expected a finite number [s]", head + "0,0,0,0\n,0,0,0\n")
        lines = prediction(2).split("\n")
        self.assert_wrong("bad.csv:42: sequence 0, step 0, particle 0: stands twice", "\n".join(lines[:41] + lines[1:2]))
        for ship, message in (("{", "ship.json:1:2: not valid JSON"), ("[]", "ship.json: expected an object"),
                              ('{"particulars": {"L_pp_m": -7}}', "/particulars/L_pp_m: expected a number > 0 [m], got -7"),
                              ('{"particulars": {"L_pp_m": 7}}', "/particulars/B_m: expected a number > 0 [m], missing")):
            self.write("ship.json", ship)
            self.assert_answer(3, message, "turn.csv", "--ship", "ship.json", "-o", "figure.png")
        self.write("map.json", '{"t_s": {"from": "t_s", "unit": "min"}}')
        self.assert_answer(3, "/t_s/unit: unknown unit 'min'; known: s", "turn.csv", "--columns", "map.json", "-o", "figure.png")

    def test_a_file_that_cannot_be_read_or_written_is_answered_with_4(self):
        self.assert_answer(4, "absent.csv: No such file", "absent.csv", "-o", "figure.png")
        self.assert_answer(4, "turn.csv/figure.png: a file stands", "turn.csv", "-o", "turn.csv/figure.png")
        (self.path / "folder.png").mkdir()
        self.assert_answer(4, "folder.png: Is a directory", "turn.csv", "-o", "folder.png")

    def test_a_link_keeps_pointing_to_its_target(self):
        (self.path / "link.png").symlink_to("target.png")
        self.assert_figure("turn.csv", name="link.png")
        self.assertTrue((self.path / "link.png").is_symlink())
        self.assertTrue((self.path / "target.png").is_file())


class Thinning(unittest.TestCase):
    def test_extremes_ends_and_gaps_survive(self):
        time = np.arange(100_003) * 0.1
        curve = np.sin(time / 70.0)
        curve[31_415] = 9.0
        curve[27_182] = -8.0
        curve[50_000:50_003] = np.nan
        curve[60_000::1000] = np.nan
        kept = figure.thinned(time, curve)
        self.assertLess(len(kept), 20_000)
        self.assertTrue((np.diff(kept) > 0).all())
        self.assertTrue({0, 31_415, 27_182, 100_002} <= set(kept.tolist()))
        for i, j in zip(kept[:-1], kept[1:]):
            if np.isfinite(curve[[i, j]]).all():
                self.assertTrue(np.isfinite(curve[i:j]).all())

    def test_a_short_curve_stays_whole(self):
        self.assertEqual(len(figure.thinned(np.arange(8000.0))), 8000)


class Reading(unittest.TestCase):
    def read(self, text):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "run.csv"
            file.write_text(text, encoding="utf-8")
            return trajectory_files.read_trajectory(trajectory_files.Table(str(file)))

    def test_units_become_those_of_figures_and_the_heading_is_unwrapped(self):
        values = self.read("\ufeff# note\nt_s, u_kn ,vm_mps,r_radps,psi_deg,note\n0,1,0.1,0.1,350,a\n\n1, 2 ,0.1,0.2,10,\"b,c\"\n")
        np.testing.assert_allclose(values["u"], [1852 / 3600, 2 * 1852 / 3600])
        np.testing.assert_allclose(values["r"], np.degrees([0.1, 0.2]))
        np.testing.assert_allclose(values["psi"], [350.0, 370.0])
        self.assertNotIn("note", values)

    def test_a_missing_sample_is_never_read_as_a_number(self):
        values = self.read("t_s,u_mps,vm_mps,r_degps\n0,1,,3\n,,,\n2,1,2,3\n")
        np.testing.assert_array_equal(values["t"], [0.0, 2.0])
        np.testing.assert_array_equal(values["vm"], [np.nan, 2.0])


if __name__ == "__main__":
    unittest.main()
