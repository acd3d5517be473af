#!/usr/bin/python3
"""Tests the scripts of scripts/experiments/paper on made-up results: what is said of a claim that holds, that does not, that
holds in part; the settings of the Makefile; the CPU clock; ensembles of some members."""

import json
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PAPER = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "experiments" / "paper"
SETS = ("Test-B", "Test-ZT", "Test-R")
MEMBERS, REPEATS = 4, 2
SETTINGS = f"SIZE=quick MEMBERS={MEMBERS} REPEATS={REPEATS} INIT_REPEATS=2"


class PaperTest(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="leeway-paper-")
        self.addCleanup(temporary.cleanup)
        self.out = pathlib.Path(temporary.name)

    def write(self, name, content):
        path = self.out / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")

    def scores(self, name, **values):
        """A metrics file; a value is one for all sets or one for each."""
        entries = [{"name": data, "coverage": {"50": 0.1, "90": 0.2, "99": 0.3},
                    **{key: value[i] if isinstance(value, tuple) else value for key, value in values.items()}} for i, data in enumerate(SETS)]
        self.write(f"{name}.json", {"datasets": entries})

    def points(self, name, spreads):
        """A per-step file of two sequences for each set: the second has thrice the error and spread of the first."""
        rows = ("recording,sequence,step,t_s,u_sd_mps,vm_sd_mps,r_sd_degps,position_error_m,position_sd_m,eucl,maha,"
                "u_mean_mps,vm_mean_mps,r_mean_degps,u_truth_mps,vm_truth_mps,r_truth_degps\n")
        for data, spread in spreads.items():
            for sequence in (0, 1):
                rows += f"{data.lower()}-z10,{sequence},0,0,0,0,0,0,0,,,0,0,0,0,0,0\n"
                rows += "".join(f"{data.lower()}-z10,{sequence},{k},{350 * sequence + k},{spread * k * 3 ** sequence},0,0,{k * 3 ** sequence},{spread * k * 3 ** sequence},"
                                f"{0.1 * k * 3 ** sequence},2.0,{0.1 * k * 3 ** sequence},0.01,0,0,0,0\n" for k in (1, 2))
        self.write(f"{name}.csv", rows)

    def controller(self, head, factor, swing_of_90):
        """Sweeps of two by two gains in a unit of `factor` deg/rad, the true ship's runs, in one of which it is too fast, and those with both gains 60 and 90."""
        columns = "kp_deg_per_rad,kd_deg_per_radps,score_true,score_worst,score_member_00,score_member_01\n"
        low, high = 5 * factor, 10 * factor
        for members, worst in ((MEMBERS, 11), (MEMBERS * REPEATS, 12)):
            self.write(f"pd/{head}sweep-{members}.csv", columns + f"{low},{low},10,{worst},8,8\n{low},{high},10,9,9,9\n"
                       f"{high},{low},10,{worst},9,9\n{high},{high},9,12,12,12\n")
        self.write(f"pd/{head}true-runs.csv", "kp_deg_per_rad,kd_deg_per_radps,u_mps,vm_mps,r_degps\n"
                   + "".join(f"{kp},{kd},{0.9 if kp == kd else 0.4},0,0\n" for kp in (low, high) for kd in (low, high) for _ in range(3)))
        for gain, swing in ((60, 0.1), (90, swing_of_90)):
            rows = [f"{model},{t},0,0,{90 + (error if t > 20 else -90)},0.2,0,{swing * (-1) ** t},{swing * (-1) ** t},{swing * (-1) ** t}\n"
                    for model, error in (("true", 0), ("00", 0.1 * swing)) for t in range(101)]
            self.write(f"pd/{head}runs/kp{gain * factor:.10g}_kd{gain * factor:.10g}.csv",
                       "model,t_s,x0_m,y0_m,psi_deg,u_mps,vm_mps,r_degps,delta_p_deg,delta_s_deg\n" + "".join(rows))

    def results(self):
        self.write("settings", SETTINGS)
        for kind, loss in (("with", 1.0), ("without", 2.0)):
            for k in (1, 2):
                self.write(f"fit/{kind}-{k}.json", {"datasets": [{"name": "Train-B", "L_fit": loss * k}]})
        for kind, correlation in (("ts-inf", (0.1, 0.5, 0.1)), ("ts1", 0.3)):
            for m in range(1, MEMBERS + 1):
                for r in range(1, REPEATS + 1):
                    undefined = kind == "ts-inf" and m <= 3 or m == 1
                    self.scores(f"sampling/{kind}-{m}-{r}", L_eucl=(1e-3 * r, 2e-2 * r, 1.9e-3 * r), L_maha=None if undefined else 100.0 / m,
                                correlation_eucl_maha=correlation, against="truth", initial_state="truth")
                    self.write(f"sampling/{kind}-{m}-{r}.spread.csv", "set,spread\n" + "".join(
                        f"{data.lower()},{(0.01 if kind == 'ts-inf' else 0.02) * (place + 1) * (m if place else 1)}\n" for place, data in enumerate(SETS)))
            self.points(f"distances/{kind}", {data: sd * (1.0 if kind == "ts-inf" else 0.5) for data, sd in zip(SETS, (0.1, 0.3, 0.05))})
            self.points(f"full-scale/{kind}", {"Test-Full-B": 0.2})
            self.write(f"full-scale/{kind}.json", {"datasets": [{
                "name": "Test-Full-B", "L_eucl": 1e-3, "correlation_eucl_maha": 0.4 if kind == "ts-inf" else None, "against": "observations",
                "initial_state": "observations"}]})
        self.controller("", 1.0, 3.0)
        self.controller("per-degree-", 57.29577951, 0.2)
        for name, u in (("Train-B", (-0.01, 0.4)), ("Test-B", (-0.01, 0.4)), ("Test-ZT", (0.3, 0.6)), ("Test-R", (-0.2, 0.1))):
            steps = [f"{k},{u[0] + (u[1] - u[0]) * k / 20},{0.01 * (k % 3) * u[1] ** 2},{k % 2 * 2 - 1},0,0,0\n" for k in range(21)]
            for recording in range(3):
                self.write(f"data/{name}/truth/{name.lower()}-{recording}.csv", "t_s,u_mps,vm_mps,r_degps,delta_p_deg,delta_s_deg,n_bt_rps\n" + "".join(steps))
        for model in ("hold", "start", "fitted", "linear", "residual", "true"):
            self.scores(f"comparison/{model}-scores", L_eucl=5e-4, L_maha=None)
        for name in ("models/pool", "models/residual", "comparison/fitted", "comparison/linear"):
            self.write(f"{name}.seconds", "".join(f"1.5\tens-train --member {k}\n" for k in range(8)))

    def claims(self, *arguments):
        return subprocess.run([PAPER / "claims", *arguments], capture_output=True, text=True, check=False)

    def rows(self):
        """(section, claim, figure, reading, numbers, verdict) of each."""
        self.assertEqual(self.claims("save", self.out, "-o", self.out / "claims.json").stderr, "")
        done = self.claims("print", self.out / "claims.json")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("model scale: from truth, against truth; full scale: from observations, against observations", done.stdout)
        return [tuple(cell.strip() for cell in line.strip("|").split(" | ")) for line in done.stdout.splitlines() if line.startswith("| ")][1:]

    def test_a_claim_holds_or_does_not_or_holds_in_part(self):
        self.results()
        rows = self.rows()
        self.assertEqual({len(row) for row in rows}, {6})

        def row(section, *texts):
            found = [row for row in rows if row[0].startswith(section) and all(text in row[1] for text in texts)]
            self.assertEqual(len(found), 1, (section, texts, rows))
            return found[0][4:]

        self.assertEqual(row("5.1", "distributed alike")[1], "**yes**")
        self.assertEqual(row("5.1", "Test-ZT lies"), ("median speed 0.45 against 0.195 m/s; beyond Train-B: vm_mps 67%; r_degps 0%", "in part: speed, vm_mps yes; r_degps no"))
        self.assertEqual(row("5.1", "sternway")[1], "in part: speed yes; sternway no")  # one sample of 21 of Train-B
        self.assertEqual(row("5.2", "initial state")[1], "**yes**")
        self.assertIn("Test-B 50 to 25 (from M = 3: ×0.75)", row("5.3", "TS1: with more members L_Maha")[0])
        self.assertIn("Test-B falls, Test-ZT falls, Test-R falls yes; Test-B levels off", row("5.3", "TS1: with more members L_Maha")[1])
        self.assertEqual(row("5.3", "TS∞: with more members L_Maha")[1], "**not put to the test**")  # defined at M = 4 only
        self.assertIn("times Test-B 20, Test-R 10.5", row("5.3", "TS∞: L_Eucl of Test-ZT")[0])
        self.assertEqual(row("5.3", "TS1: L_Maha does not differ")[1], "**yes**")
        self.assertEqual(row("5.3", "TS1: with more members the spread"),
                         ("M = 2 to 4: Test-B ×1.00; Test-ZT ×2.00; Test-R ×2.00", "in part: Test-ZT, Test-R yes; Test-B no"))
        self.assertEqual(row("5.3", "TS1: the farther")[1], "**yes**")
        self.assertEqual(row("5.3", "TS∞ has the larger spread")[1], "**no**")
        self.assertEqual(row("5.3", "correlation of the two")[1], "in part: Test-B, Test-R yes; Test-ZT no")
        self.assertEqual(row("5.3", "The spread is small where"), ("TS∞: Test-B ×6.00; Test-ZT ×6.00; Test-R ×6.00; TS1: Test-B ×6.00; Test-ZT ×6.00; Test-R ×6.00",
                         "in part: Test-B grows, Test-ZT grows, Test-R grows yes; Test-B more with TS∞, Test-ZT more with TS∞, Test-R more with TS∞ no"))
        self.assertEqual(row("5.3", "TS1 varies less"), ("position 100%, velocities 100%", "**yes**"))
        for unit in ("gains in deg/rad", "gains in deg/deg"):
            self.assertIn("0.00 where both are large, else 1.33: -1.33 (standard error 0.00 over 2 networks)", row("5.4", "A single network", unit)[0])
            self.assertEqual(row("5.4", "A single network", unit)[1], "in part: optimistic yes; more where both are large no")
            self.assertEqual(row("5.4", "The worst of the particles, M = 4", unit)[0],
                             "75% of the pairs for a single network, 25% for the worst; 1.00 and 0.25 rad s")
            self.assertEqual(row("5.4", "(60, 60)", unit)[1], "**yes**")
            self.assertEqual(row("7 discussion, 4", "Where states", unit), ("1.00 with 2 pairs; 1.22 with the others", "**yes**"))
        self.assertEqual(row("5.4", "(90, 90)", "deg/rad")[1], "in part: swings, leaves Train-B yes; less accurate, differs much no")
        self.assertEqual(row("5.4", "(90, 90)", "deg/deg")[1], "**not put to the test**")  # it swings little
        self.assertEqual(row("6.2", "correlation of the two"), ("TS∞: Test-Full-B 0.40; TS1: Test-Full-B nan", "**no**"))
        self.assertEqual(row("6.2", "Between 100 and 700 s")[1], "in part: u is bad, 100 to 700 s, spread is large yes; v_m is bad, r is bad, bias beyond it no")
        self.assertEqual(row("6.2", "Elsewhere")[1], "**yes**")
        self.assertEqual(row("6.2", "Most Euclidean"), ("50% of the points; largest 0.6", "**no**"))
        for section in ("7 discussion, 1", "7 discussion, 2", "7 discussion, 3", "7 discussion, 4", "8 conclusion, 1", "8 conclusion, 2", "8 conclusion, 3", "8 conclusion, 4"):
            self.assertTrue([row for row in rows if row[0] == section], section)

    def test_what_no_column_records_is_set_against_the_rest(self):
        self.results()
        self.assertEqual([row[5] for row in self.rows() if "What is not observed" in row[1]], ["**not put to the test**"])
        for kind in ("ts-inf", "ts1"):
            path = self.out / f"full-scale/{kind}.csv"
            text = path.read_text(encoding="utf-8")
            path.write_text(text + "".join(f"test-full-b-b-03,0,{k},{100 * k},0.1,0,0,1,1,0.9,2.0,0.9,0.02,0,0,0,0\n" for k in (1, 2)), encoding="utf-8")
        self.write("data-full/Test-Full-B/truth/runs.json", {"runs": [{"recording": "test-full-b-b-03", "unrecorded": [{"type": "tug"}]},
                                                                      {"recording": "test-full-b-z10", "unrecorded": []}]})
        found = [row[4:] for row in self.rows() if "What is not observed" in row[1]]
        self.assertEqual(found, [("test-full-b-b-03 is the worst, 0.9; median 0.9 over the 1 sequences of test-full-b-b-03 tug, 0.316 over the other 2", "**yes**")])

    def test_sizes_stand_side_by_side(self):
        self.results()
        self.claims("save", self.out, "-o", self.out / "a.json")
        other = json.loads((self.out / "a.json").read_text(encoding="utf-8"))
        other["settings"]["SIZE"], other["claims"] = "medium", other["claims"][1:]
        self.write("b.json", other)
        lines = self.claims("print", self.out / "a.json", self.out / "b.json").stdout.splitlines()
        self.assertIn("| From | the paper observes | figure | holds if | quick | holds | medium | holds |", lines)
        first = next(line for line in lines if "distributed alike" in line)
        self.assertTrue(first.endswith("| **yes** |  |  |"), first)

    def test_examples_are_chosen_by_their_error(self):
        self.results()
        for example, name in (("berthing", "test-b-z10"), ("zigzag", "test-zt-z10"), ("full-scale-worst", "test-full-b-z10")):
            chosen = subprocess.run([PAPER / "chosen", self.out, example], capture_output=True, text=True, check=False)
            self.assertEqual((chosen.stdout, chosen.stderr), (f"{name} 0,1\n", ""))
        self.assertEqual(subprocess.run([PAPER / "chosen", self.out, "x"], capture_output=True, check=False).returncode, 2)

    def test_an_undefined_distance_is_no_number_in_the_comparison(self):
        self.results()
        lines = self.claims("comparison", self.out).stdout
        self.assertIn("ensemble, M = 4, TS1 | Test-B | 0.001 | 25 | 10% | 20% | 30% | 6 |", lines)
        self.assertIn("initial velocity held | Test-B | 5.00e-04 | – | – | – | – | – |", lines)

    def test_a_missing_result_is_named(self):
        self.write("settings", SETTINGS)
        done = self.claims("save", self.out, "-o", self.out / "claims.json")
        self.assertEqual(done.returncode, 4)
        self.assertIn("sampling/ts-inf-4-1.json: No such file", done.stderr)

    def make(self, *arguments):
        return subprocess.run(["make", "-n", "-C", PAPER, f"OUT={self.out}", *arguments, "data"], capture_output=True, text=True, check=False)

    def test_a_wrong_size_and_a_folder_of_other_settings_are_refused(self):
        done = self.make("SIZE=huge")
        self.assertEqual(done.returncode, 2)
        self.assertIn("SIZE='huge' is not known; known: quick medium paper", done.stderr)
        self.assertEqual(self.make("SIZE=quick").returncode, 0)
        self.write("settings", "SIZE=paper")
        done = self.make("SIZE=quick")
        self.assertEqual(done.returncode, 2)
        self.assertIn("holds a run of other settings (SIZE=paper)", done.stderr)

    def test_the_clock_keeps_exit_codes_and_passes_signals_on(self):
        clock = self.out / "clock"
        self.assertEqual(subprocess.run([PAPER.parent / "timed", clock, "bash", "-c", "exit 3"], check=False).returncode, 3)
        script = "import signal, sys, time; signal.signal(signal.SIGTERM, lambda *_: sys.exit(7)); print('up', flush=True); time.sleep(60)"
        process = subprocess.Popen([PAPER.parent / "timed", clock, sys.executable, "-c", script], stdout=subprocess.PIPE)
        process.stdout.readline()
        begun = time.monotonic()
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(), 7)
        process.stdout.close()
        self.assertLess(time.monotonic() - begun, 30)
        self.assertEqual(len(clock.read_text(encoding="utf-8").splitlines()), 2)

    def test_a_config_of_other_numbers_does_not_follow_the_paper(self):
        def follows(*values):
            subprocess.run([PAPER / "training-config", *values, "-o", self.out / "config.json"], check=True)
            return json.loads((self.out / "config.json").read_text(encoding="utf-8")).get("follows")
        self.assertEqual(follows("model-scale", "hidden_units=256", "epochs=20000"), "paper")
        self.assertEqual(follows("model-scale", "--scale-of", "full-scale", "epochs=100000"), "paper")
        self.assertIsNone(follows("model-scale", "epochs=5000"))
        self.assertIsNone(follows("fast", "epochs=150"))

    def test_some_members_make_an_ensemble(self):
        self.write("model/ensemble.json", {"members": ["member-00.json", "member-01.json", "member-02.json"]})
        for k in range(3):
            self.write(f"model/member-{k:02}.json", f'{{"format":"leeway member 1","member":{k},"weights":[0.{k}]}}')
        subset = [PAPER / "subset", self.out / "model"]
        self.assertEqual(subprocess.run([*subset, "1", "2", self.out / "part"], check=False).returncode, 0)
        self.assertEqual((self.out / "part/member-01.json").read_text(encoding="utf-8"), '{"format":"leeway member 1","member":1,"weights":[0.2]}')
        self.assertEqual(len(json.loads((self.out / "part/ensemble.json").read_text(encoding="utf-8"))["members"]), 2)
        self.assertEqual(subprocess.run([*subset, "2", "2", self.out / "other"], capture_output=True, check=False).returncode, 2)


if __name__ == "__main__":
    unittest.main()
