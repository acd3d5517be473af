#!/usr/bin/python3
"""Runs scripts/plot/calibration on made-up scores and predictions: figures, exit codes, messages; and holds the levels that it
draws to what they are of an honest ensemble, a narrow one and a wide one."""

import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "scripts" / "plot" / "calibration"
sys.path.insert(0, str(ROOT / "scripts" / "plot"))
SIGNATURES = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}
MEMBERS, PARTICLES, STEPS = 8, 16, 4


def entry(name="Test", **changes):
    return {"name": name, "sequences": 20, "coverage": {"50": 0.4, "90": 0.8, "99": 0.9},
            "pit": {channel: [0.1] * 10 for channel in ("u", "vm", "r")}, **changes}


def simulated(random, points=3000, members=8, particles=16, of_member=1.0, of_particle=0.0, of_truth=1.0, noise=0.0):
    """(nu, member, truth) of points with a truth from the particles' law, its deviation `of_truth` times theirs."""
    import numpy as np

    mix = np.array([[1.0, 0.0, 0.0], [0.6, 0.5, 0.0], [-0.3, 0.2, 0.01]])  # correlated channels of different size
    member = np.arange(particles) % members
    nu = of_member * random.standard_normal((points, members, 3))[:, member] + of_particle * random.standard_normal((points, particles, 3))
    truth = of_truth * (of_member * random.standard_normal((points, 3)) + of_particle * random.standard_normal((points, 3)))
    return nu @ mix.T + 0.4, member, truth @ mix.T + 0.4 + noise * random.standard_normal((points, 3))


class HonestLaw(unittest.TestCase):
    def setUp(self):
        import honest_law
        import numpy

        self.law, self.np = honest_law, numpy
        self.random = numpy.random.default_rng(7)

    def levels(self, noise=0.0, **simulation):
        nu, member, truth = simulated(self.random, noise=noise, **simulation)
        return self.law.levels(nu, member, truth, [noise] * 3)

    def held(self, at, **simulation):
        return float(self.np.mean(self.levels(**simulation) <= at))

    def test_an_honest_ensemble_holds_what_its_regions_promise(self):
        # 3000 points: 3 standard deviations of a share are at most 0.027; the simulated law adds 0.01.
        for simulation in ({}, {"members": 24, "particles": 48}, {"of_particle": 0.7, "particles": 40}, {"noise": 0.5},
                           {"of_member": 0.0, "of_particle": 1.0, "particles": 40}, {"particles": 21}):
            levels = self.levels(**simulation)
            for at in (0.2, 0.5, 0.9):
                with self.subTest(simulation=simulation, at=at):
                    self.assertAlmostEqual(float(self.np.mean(levels <= at)), at, delta=0.04)

    def test_a_narrow_ensemble_holds_less_and_a_wide_one_more(self):
        self.assertLess(self.held(0.9, of_truth=2.0), 0.7)
        self.assertGreater(self.held(0.5, of_truth=0.5), 0.7)
        self.assertLess(self.held(0.9, of_truth=2.0, of_particle=1.0, particles=40), 0.6)

    def test_three_members_or_a_channel_that_does_not_vary_have_no_region(self):
        nu, member, truth = simulated(self.random, points=5, members=3, particles=12)
        self.assertTrue(self.np.isnan(self.law.levels(nu, member, truth)).all())
        nu, member, truth = simulated(self.random, points=5)
        nu[2, :, 1] = 0.3
        truth[4, 0] = self.np.nan
        self.assertEqual(self.np.isnan(self.law.levels(nu, member, truth)).tolist(), [False, False, True, False, True])

    def test_the_level_does_not_depend_on_units_or_on_where_the_ship_is(self):
        nu, member, truth = simulated(self.random, points=50, of_particle=0.5, particles=24)
        scale, shift = self.np.array([1e-3, 20.0, 5.0]), self.np.array([3.0, -1.0, 0.2])
        self.np.testing.assert_allclose(self.law.levels(scale * nu + shift, member, scale * truth + shift), self.law.levels(nu, member, truth), atol=2e-3)

    def test_members_in_turn_hold_what_they_promise(self):
        nu, member, _ = simulated(self.random, points=2000, members=10, particles=20, of_particle=0.3)
        found = self.law.in_turn(self.law.Sequence("a", 0, self.np.arange(2000.0), nu, member, True))
        self.assertEqual(sorted(found), list(range(10)))
        levels = self.np.concatenate([levels for levels, _ in found.values()])
        self.assertAlmostEqual(float(self.np.mean(levels <= 0.9)), 0.9, delta=0.03)

    def test_pit_counts_half_of_those_that_equal_the_truth(self):
        nu = self.np.array([[[1.0, 0.0, 5.0], [2.0, 0.0, 6.0], [3.0, 1.0, 7.0], [4.0, 2.0, 8.0]]])
        self.assertEqual(self.law.pits(nu, self.np.array([[2.5, 0.0, 9.0]])).tolist(), [[0.5, 0.25, 1.0]])


class PlotCalibration(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)
        self.write("metrics.json", {"datasets": [entry("Test-B"), entry("Test-R", coverage={"50": 0.7, "90": 0.97, "99": 1.0})]})

    def write(self, name, content):
        (self.path / name).parent.mkdir(parents=True, exist_ok=True)
        (self.path / name).write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")

    def predictions(self, folder="pred", changes_member=False, members=MEMBERS):
        """Two sets of two recordings each, with their truths."""
        import numpy as np

        random = np.random.default_rng(3)
        for data in ("Test-B", "Test-R"):
            for number in (1, 2):
                name = f"{data.lower()}-{number}"
                text = "recording,sequence,step,t_s,particle,member,x0_m,y0_m,psi_deg,u_mps,vm_mps,r_degps\n"
                truth = "t_s,u_mps,vm_mps,r_degps\n"
                for k in range(STEPS):
                    truth += f"{k}," + ",".join(map(str, random.standard_normal(3))) + "\n"
                    for p in range(PARTICLES):
                        member = (p + k * changes_member) % members
                        text += f"{name},0,{k},{k},{p},{member},0,0,0," + ",".join(map(str, random.standard_normal(3))) + "\n"
                self.write(f"{folder}/{name}.csv", text)
                self.write(f"{data}/truth/{name}.csv", truth)

    def run_script(self, *arguments):
        return subprocess.run([SCRIPT, *arguments], cwd=self.path, capture_output=True, text=True, check=False)

    def legend(self, file="figure.svg"):
        """Texts are drawn as glyphs; the comments beside them hold them."""
        return re.findall(r"<!-- (.*?) -->", (self.path / file).read_text(encoding="utf-8"))

    def test_figures_of_scores_alone_in_every_format(self):
        for suffix, signature in SIGNATURES.items():
            with self.subTest(suffix):
                result = self.run_script("metrics.json", "-o", f"figure{suffix}")
                self.assertEqual((result.returncode, result.stderr), (0, ""))
                self.assertTrue((self.path / f"figure{suffix}").read_bytes().startswith(signature))
        self.assertIn("Test-B: 90 % regions hold 80 % (20 sequences)", self.legend())
        self.assertIn("too narrow:", self.legend())
        self.assertIn("Does the bundle hold the truth as often as it promises?", self.legend())

    def test_predictions_add_recordings_and_an_honest_ensemble(self):
        self.predictions()
        for truths in (["Test-B/truth", "Test-R/truth"], [f"{data}/truth/{data.lower()}-{n}.csv" for data in ("Test-B", "Test-R") for n in (1, 2)]):
            result = self.run_script("metrics.json", "--prediction", "pred", "--truth", *truths, "--every", "1", "--title", "a title", "-o", "figure.svg")
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            self.assertIn("Test-R: 90 % regions hold 97 % (2 recordings)", self.legend())
            self.assertIn("an honest ensemble of this size (nine cases of ten)", self.legend())
            self.assertIn("a title", self.legend())

    def test_a_data_set_says_where_its_truths_are(self):
        self.predictions()
        self.write("dataset.json", {"sets": [{"name": data, "recordings": [
            {"file": f"{data}/{data.lower()}-{n}.csv", "truth": f"{data}/truth/{data.lower()}-{n}.csv"} for n in (1, 2)]} for data in ("Test-B", "Test-R")]})
        result = self.run_script("metrics.json", "--set", "Test-B", "--prediction", "pred", "--truth", "dataset.json", "--every", "1", "-o", "figure.svg")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertIn("Test-B: 90 % regions hold 80 % (2 recordings)", self.legend())
        self.assertFalse([text for text in self.legend() if "Test-R" in text])

    def test_particles_that_change_their_member_have_no_band(self):
        self.predictions(changes_member=True)
        result = self.run_script("metrics.json", "--prediction", "pred", "--truth", "Test-B/truth", "Test-R/truth", "--every", "1", "-o", "figure.svg")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertFalse([text for text in self.legend() if "of this size" in text])

    def test_few_members_have_no_region(self):
        self.write("metrics.json", {"datasets": [entry(coverage={"50": None, "90": None, "99": None})]})
        self.assertEqual(self.run_script("metrics.json", "-o", "figure.svg").returncode, 0)
        self.assertIn("Test: no region (too few members)", self.legend())

    def test_equal_inputs_give_equal_bytes(self):
        self.predictions()
        for name in ("a.png", "b.png"):
            self.run_script("metrics.json", "--prediction", "pred", "--truth", "Test-B/truth", "Test-R/truth", "--every", "1", "-o", name)
        self.assertEqual((self.path / "a.png").read_bytes(), (self.path / "b.png").read_bytes())

    def test_wrong_inputs_end_with_one_line_and_the_right_code(self):
        self.predictions()
        self.write("old.json", {"datasets": [{"name": "Test", "sequences": 3, "coverage": {"50": 0, "90": 0, "99": 0}}]})
        self.write("beyond.json", {"datasets": [entry(coverage={"50": 0.4, "90": 1.2, "99": 0.9})]})
        self.write("short.json", {"datasets": [entry(pit={"u": [0.1], "vm": [0.1] * 10, "r": [0.1] * 10})]})
        self.write("none.json", {"datasets": []})
        self.write("many.json", {"datasets": [entry(f"set {k}") for k in range(7)]})
        self.write("broken.json", '{"datasets": [}')
        self.write("late/test-b-1.csv", (self.path / "pred/test-b-1.csv").read_text(encoding="utf-8").replace(",0,3,3,", ",0,3,30,"))
        (self.path / "empty").mkdir()
        both = ["--truth", "Test-B/truth", "Test-R/truth", "--every", "1"]
        for arguments, code, message in (
            (["metrics.json", "--set", "Test-X"], 2, "metrics.json has no data set 'Test-X'; it has Test-B, Test-R"),
            (["many.json"], 2, "has 7 data sets; choose up to 6 with --set"),
            (["metrics.json", "--prediction", "pred"], 2, "--prediction and --truth belong together"),
            (["metrics.json", "--noise-u-mps", "-1"], 2, "expected a number >= 0, got -1"),
            (["metrics.json", "--every", "0"], 2, "expected a whole number > 0"),
            (["metrics.json", "--prediction", "pred", "--truth", "Test-B/truth"], 2, "recording 'test-r-1' has no file among --truth"),
            (["metrics.json", "--prediction", "pred/test-b-1.csv", *both], 2, "hold nothing of the data set 'Test-R'"),
            (["old.json"], 3, "old.json: /datasets/0/pit: expected an object with u, vm, r"),
            (["beyond.json"], 3, "beyond.json: /datasets/0/coverage/90: expected a share or null"),
            (["short.json"], 3, "short.json: /datasets/0/pit/u: expected 10 shares"),
            (["none.json"], 3, "none.json: /datasets: expected an array of data sets"),
            (["broken.json"], 3, "broken.json:1:15: not valid JSON"),
            (["metrics.json", "--prediction", "empty", *both], 3, "empty: the folder holds no .csv file"),
            (["metrics.json", "--prediction", "Test-B/truth/test-b-1.csv", *both], 3, "expected a prediction"),
            (["metrics.json", "--prediction", "late", *both], 3, "test-b-1.csv: the prediction has points from 1 to 30 s, but the truth lasts from 0 to 3 s"),
            (["nowhere.json"], 4, "nowhere.json"),
        ):
            with self.subTest(arguments):
                result = self.run_script(*arguments, "-o", "wrong.png")
                self.assertEqual((result.returncode, result.stderr.count("\n")), (code, 1), result.stderr)
                self.assertIn(message, result.stderr)
                self.assertFalse((self.path / "wrong.png").exists())
        self.assertEqual(self.run_script("metrics.json", "-o", "figure.gif").returncode, 2)


if __name__ == "__main__":
    unittest.main()
