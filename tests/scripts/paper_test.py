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
        entries = [{"name": data, "coverage": {"0.5": 0.1, "0.9": 0.2, "0.99": 0.3},
                    **{key: value[i] if isinstance(value, tuple) else value for key, value in values.items()}} for i, data in enumerate(SETS)]
        self.write(f"{name}.json", {"datasets": entries})

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
                                correlation_eucl_maha=correlation)
            rows = [f"{data.lower()}-1,1,{sd},0,0,1.0,2.0\n" for data, sd in zip(SETS, (0.1, 0.3, 0.05))]
            header = "recording,step,u_sd_mps,vm_sd_mps,r_sd_degps,eucl,maha\n"
            for folder in ("distances", "full-scale"):
                self.write(f"{folder}/{kind}.csv", header + "test-b-1,0,9,9,9,,\n" + "".join(rows))
            self.scores(f"full-scale/{kind}", L_eucl=1e-3, correlation_eucl_maha=correlation)
        columns = "kp_deg_per_rad,kd_deg_per_radps,score_true,score_worst,score_member_00\n"
        for members, worst in ((MEMBERS, 11), (MEMBERS * REPEATS, 12)):
            self.write(f"pd/sweep-{members}.csv", columns + f"5,5,10,{worst},8\n5,10,10,9,9\n10,5,10,{worst},9\n10,10,9,12,12\n")
            self.write(f"pd/turns-sweep-{members}.csv", columns + f"5,5,10,{worst},11\n5,10,10,11,12\n")  # never better than the ship
        for model in ("hold", "start", "fitted", "linear", "residual", "true"):
            self.scores(f"comparison/{model}-scores", L_eucl=5e-4, L_maha=None)
        for name in ("models/pool", "models/residual", "comparison/fitted", "comparison/linear"):
            self.write(f"{name}.seconds", "".join(f"1.5\tens-train --member {k}\n" for k in range(8)))

    def claims(self, *arguments):
        return subprocess.run([PAPER / "claims", self.out, *arguments], capture_output=True, text=True, check=False)

    def row(self, text):
        done = self.claims("--print")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        found = [line for line in done.stdout.splitlines() if text in line]
        self.assertEqual(len(found), 1, done.stdout)
        return found[0]

    def test_a_claim_holds_or_does_not_or_holds_in_part(self):
        self.results()
        self.assertTrue(self.row("The initial-state network lowers").endswith("| **yes** |"))
        self.assertIn("undefined for M = 1, 2, 3 | **yes**", self.row("is undefined for M"))
        self.assertTrue(self.row("TS1: increasing M lowers L_Maha").endswith("from M = 2, the first where it is defined, to M = 4: "
                        "Test-B 50 to 25; Test-ZT 50 to 25; Test-R 50 to 25 | **yes** |"))
        self.assertTrue(self.row("| TS∞: increasing M lowers L_Maha").endswith("| **no** |"))  # defined at M = 4 only: nothing falls
        self.assertIn("20 times Test-B and 10.5 times Test-R", self.row("| L_Eucl(Test-ZT) is more than 10"))
        self.assertTrue(self.row("Full scale: L_Eucl(Test-ZT) is more than 10").endswith("| **no** |"))
        self.assertIn("in part: Test-B, Test-R yes; Test-ZT no", self.row("| The correlation of the two distances"))
        self.assertIn("in part: Test-ZT yes; Test-R no", self.row("| TS1: uncertainty is high"))
        self.assertTrue(self.row("berthings: More members reduce it further").endswith("| **yes** |"))
        self.assertIn("single network (mean of 1) 75%, worst of M = 4 25%", self.row("berthings: Considering the worst case"))
        self.assertTrue(self.row("turns: Considering the worst case").endswith("| **not put to the test** |"))

    def test_an_undefined_distance_is_no_number_in_the_comparison(self):
        self.results()
        self.assertIn("| Test-B | 0.001 | 25 | 10% | 20% | 30% | 6 |", self.row("ensemble, M = 4, TS1"))
        self.assertIn("| Test-B | 5.00e-04 | – | – | – | – | – |", self.row("initial velocity held"))

    def test_a_missing_result_is_named(self):
        self.write("settings", SETTINGS)
        done = self.claims("--print")
        self.assertEqual(done.returncode, 4)
        self.assertIn("fit/without-1.json: No such file", done.stderr)

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
