#!/usr/bin/python3
"""Tests how scripts/proof scores: what counts as detected and accepted, times and places, sealed recordings, shards, looks, the advised maneuver."""

import argparse
import gzip
import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROOF = ROOT / "scripts" / "proof"
sys.path.insert(0, str(PROOF))

import advised  # noqa: E402
import campaign  # noqa: E402
import looks  # noqa: E402
import model  # noqa: E402
import physics  # noqa: E402
import recording  # noqa: E402
import scores  # noqa: E402
import shards  # noqa: E402
import tables  # noqa: E402
import tool  # noqa: E402

RUN = {"exit_code": 0, "wall_s": 1.0, "peak_kB": 1000}


def report(verdict="mismatch", chosen=(), hypotheses=(), **more):
    return {"verdict": verdict, "p_value": 0.001, "chosen": list(chosen),
            "hypotheses": [{"name": " + ".join(e) or "none", "effects": list(e), "probability": p, "confusable_with": c} for e, p, c in hypotheses], **more}


def key(names=(), family="single", **truth):
    return {"id": "x", "family": family, "names": list(names), "level": 2, "ship": "esso-osaka-3m", "campaign": "mixed",
            "truth": {n: {"parameters": {}, "d_prime": 12.0, **truth} for n in names}}


def judged(names, **given):
    return scores.judge(key(names), RUN, report(**given))


class Rules(unittest.TestCase):
    def test_each_case_in_which_something_acts_has_one_outcome(self):
        for chosen, verdict, truth, outcome, detected in (
                (["a"], "mismatch", ["a"], "right", True), (["a"], "mismatch", ["a", "b"], "some of it", True), (["b", "a"], "mismatch", ["a", "b"], "right", True),
                (["a", "c"], "mismatch", ["a"], "right and wrong", False), (["c"], "mismatch", ["a"], "wrong", False), (["c", "unknown"], "mismatch", ["a"], "wrong", False),
                (["unknown"], "mismatch", ["a"], "unknown", True), (["a", "unknown"], "mismatch", ["a"], "right", True), ([], "mismatch", ["a"], "mismatch, unnamed", False),
                ([], "undecided", ["a"], "undecided", False), ([], "no-mismatch", ["a"], "missed", False)):
            with self.subTest(chosen=chosen, verdict=verdict):
                got = judged(truth, chosen=chosen, verdict=verdict)
                self.assertEqual((got["outcome"], got["detected"]), (outcome, detected))
                self.assertIn(got["outcome"], scores.OUTCOMES)
        self.assertEqual(scores.judge(key(["a"]), {"exit_code": 1}, None)["outcome"], "failed")
        self.assertIsNone(judged([], chosen=[], verdict="no-mismatch")["outcome"])

    def test_what_is_out_of_the_catalogue_has_a_kind(self):
        self.assertEqual(set(scores.KINDS), set(physics.OUTSIDE))
        for kind, is_right in (("period", True), ("states", False), (None, False)):
            self.assertEqual(scores.judge(key(["yaw-flutter"], "outside"), RUN, report(chosen=["unknown"], unknown_kind=kind))["kind_ok"], is_right)

    def test_a_superset_is_not_accepted(self):
        wider = [(["a", "b"], 0.6, ["a + c"]), (["a", "c"], 0.4, [])]
        self.assertFalse(judged(["a"], chosen=["a", "b"], hypotheses=wider)["set_ok"])
        self.assertTrue(judged(["a", "c"], chosen=["a", "b"], hypotheses=wider)["set_ok"])
        self.assertFalse(judged(["a", "b"], chosen=["a", "b", "c"], hypotheses=[(["a", "b", "c"], 1.0, [])])["both"])
        self.assertTrue(judged(["a", "b"], chosen=["b", "a"], hypotheses=[(["a", "b"], 1.0, [])])["both"])

    def test_overlap_is_intersection_over_union(self):
        self.assertAlmostEqual(scores.overlap([(10.0, 30.0)], (20.0, 40.0)), 10.0 / 30.0)
        self.assertAlmostEqual(scores.overlap([(0.0, 10.0), (5.0, 20.0), (90.0, 100.0)], (0.0, 20.0)), 20.0 / 30.0)
        self.assertEqual(scores.overlap([], (20.0, 40.0)), 0.0)
        self.assertEqual(scores.overlap([(20.0, 40.0)], (20.0, 40.0)), 1.0)

    def test_time_axis_and_place_against_the_truth(self):
        truth = {"interval_s": [20.0, 40.0], "file": "train-1.csv", "dof": {"surge": 0.1, "sway": 0.6, "yaw": 0.3}, "x_F_over_L_pp": 0.4}
        where = {"dof": {"surge": 0.3, "sway": 0.5, "yaw": 0.2}, "line_of_action": {"x_F_over_L_pp": 0.3},
                 "intervals": [{"file": "in/train-1.csv", "t_start_s": 10.0, "t_end_s": 30.0}, {"file": "train-2.csv", "t_start_s": 20.0, "t_end_s": 40.0}]}
        got = scores.judge(key(["tug"], **truth), RUN, report(chosen=["tug"], located=where))["located"]
        self.assertAlmostEqual(got["overlap"], 1.0 / 3.0)
        self.assertTrue(got["axis"])
        self.assertAlmostEqual(got["shares_off"], 0.2)
        self.assertAlmostEqual(got["x_F_off"], 0.1)
        self.assertIsNone(got["overlap_named"])
        beside = key(["tug", "fouling"], **truth)  # axes and point of attack are of both
        beside["truth"]["fouling"].pop("interval_s", None)
        got = scores.judge(beside, RUN, report(chosen=["fouling"], located=where))["located"]
        self.assertIsNotNone(got["overlap"])
        self.assertIsNone(got["axis"])
        self.assertFalse(scores.judge(key(["tug"], **truth), RUN, report(located={"dof": {"surge": 0.9, "sway": 0.1, "yaw": 0.0}}))["located"]["axis"])

    def test_p_values_inclusion_and_ship_files(self):
        nulls = [{**judged([], chosen=[], verdict="no-mismatch"), "family": "null-noise", "p_value": p} for p in (0.004, 0.03, 0.6, 1.0)]
        self.assertEqual(scores.sizes_of_p(nulls, (0.01, 0.05, 0.5)), [(0.01, 1, 4), (0.05, 2, 4), (0.5, 2, 4)])
        got = judged(["wake"], chosen=["wake"], inclusion={"wake": 0.9, "tug": 0.1, "coefficient:hull.N_r": 0.4})
        self.assertEqual([x for x in got["inclusion"] if x[0] > 0.0], [(0.1, False), (0.9, True)])
        # What a report does not list it states with 0, and counts where it acts.
        unlisted = judged(["trim"], chosen=["wake"], inclusion={"wake": 0.9})
        self.assertEqual(len(unlisted["inclusion"]), len(got["inclusion"]))
        self.assertIn((0.0, True), unlisted["inclusion"])
        bad = {**judged([], chosen=["a"]), "family": "misstated", "ship_file": "off"}
        self.assertEqual(tables.nulls_of([*nulls, bad]), nulls)
        self.assertIn("| that misstate it, nothing missing | 1 | 1/1", "\n".join(tables.file_table([*nulls, bad])))

    def test_a_promise_is_held_against_nulls_as_well(self):
        trial = lambda missing, right: {"missing": missing, "menu": ["a", "b"], "promised": {"a": 0.5}, "advised": "a", "random": "b", "right_before": right,
                                        "right_after": {"a": right}}
        lines = tables.next_table([trial(True, False), trial(False, True)])[2:]
        self.assertEqual([line.split("|")[1].strip() for line in lines],
                         ["the maneuver that is advised" + which for which in ("", ", something missing", ", nothing missing")])
        self.assertEqual([line.split("|")[5].split("=")[0].strip() for line in lines], ["1/2", "0/1", "1/1"])

    def test_tables_of_nothing_are_told_as_such(self):
        self.assertEqual(tables.next_table([]), tables.NOT_YET)
        self.assertEqual(tables.p_table([]), tables.NOT_YET)
        self.assertIn("No report", tables.inclusion_table([judged(["a"], chosen=["a"])])[0])


class Axes(unittest.TestCase):
    def test_a_force_at_a_place_is_found_again(self):
        ship = model.read_ship("esso-osaka-3m")
        i, L, x_F = ship["inertia"], 3.0, 0.37
        # Accelerations of a side force of 1 at x_F L, in the units of the file.
        M = np.array([[i["m"] + i["m_y"], i["m"] * i["x_G"] * L], [i["m"] * i["x_G"] * L, (i["I_zG_plus_J_z"] + i["m"] * i["x_G"] ** 2) * L * L]])
        a = np.linalg.solve(M, np.array([1.0, x_F * L]))
        history = np.sin(np.arange(50.0))
        got = campaign.split_of([np.stack([0.0 * history, a[0] * history, a[1] * history])], ship)
        self.assertAlmostEqual(got["x_F_over_L_pp"], x_F)
        self.assertAlmostEqual(sum(got["dof"].values()), 1.0)
        self.assertEqual(got["dof"]["surge"], 0.0)


class Shards(unittest.TestCase):
    def test_shards_part_the_cases_and_each_has_some_of_all(self):
        cases = campaign.design("full", "s")
        parts = [shards.part(cases, (k, 8)) for k in range(1, 9)]
        self.assertEqual(sorted(c["id"] for p in parts for c in p), sorted(c["id"] for c in cases))
        self.assertLessEqual(max(map(len, parts)) - min(map(len, parts)), 1)
        for p in parts:
            self.assertLessEqual({"single", "pair", "outside", "null-noise"}, {c["family"] for c in p})
        self.assertEqual(shards.part(cases, None), cases)
        outside = {name for c in shards.part(cases, (1, 8)) if c["family"] == "outside" for name in c["names"]}
        self.assertGreaterEqual(len(outside), 5)  # eight things follow each other in turn

    def test_what_is_no_shard_is_refused(self):
        self.assertEqual(shards.parsed("3/8"), (3, 8))
        for text in ("0/8", "9/8", "3", "a/b", ""):
            with self.assertRaises(argparse.ArgumentTypeError):
                shards.parsed(text)

    def test_sizes_are_those_of_the_closing_table(self):
        count = lambda begin: sum(c["family"].startswith(begin) for c in campaign.design("full", "s"))
        self.assertEqual([count(f) for f in ("null", "single", "pair", "outside")], [500, 600, 200, 200])

    def test_the_array_has_a_task_for_each_shard_and_scores_after_it(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            (folder / "sbatch").write_text('#!/bin/bash\necho "$@" >>"$LOG"\necho 77\n', encoding="utf-8")
            (folder / "sbatch").chmod(0o755)
            environment = {**os.environ, "PATH": f"{folder}:{os.environ['PATH']}", "LOG": str(folder / "log")}
            done = subprocess.run([ROOT / "scripts/slurm/proof", "nightly", "4", folder / "out", "--time=1:00:00"], env=environment, capture_output=True, text=True, check=True)
            first, second = (folder / "log").read_text(encoding="utf-8").splitlines()
            self.assertEqual(done.stdout.strip(), "77")
            self.assertIn("--time=1:00:00 --array=1-4", first)
            self.assertTrue(first.endswith(f"proof nightly {folder.resolve()}/out 4"), first)
            self.assertIn("--dependency=afterany:77", second)
            refused = subprocess.run([ROOT / "scripts/slurm/proof", "weekly", "4", folder], env=environment, capture_output=True, text=True, check=False)
            self.assertEqual((refused.returncode, "unknown set 'weekly'" in refused.stderr), (2, True))


class Looks(unittest.TestCase):
    def test_a_family_is_spent_once_it_is_seen(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "looks.json"
            self.assertEqual(looks.next_family(file), 1)
            looks.spend(1, "abc", ["one"], 30, 100, file)
            looks.spend(1, "abc", ["one", "of another machine"], 100, 100, file)
            self.assertEqual(looks.next_family(file), 2)
            self.assertEqual([look["cases"] for look in looks.spent(file)], [100])
            with self.assertRaisesRegex(looks.Spent, "family 1 .* is spent"):
                looks.spend(1, "abc", ["later"], 100, 100, file)


class Parts(unittest.TestCase):
    @staticmethod
    def shard(out, name, **design):
        (out / name).mkdir(parents=True)
        (out / name / "design.json").write_text(json.dumps({"commit": "abc", "duration_s": 240.0, "shard": "/".join(name.split("-")[1::2]), **design}), encoding="utf-8")

    def test_shards_of_one_set_are_taken_together_and_no_others(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder)
            self.shard(out, "shard-1-of-3")
            self.shard(out, "shard-2-of-3")
            self.assertEqual([f.name for f in shards.parts(out)], ["shard-1-of-3", "shard-2-of-3"])
            self.shard(out, "shard-3-of-3", commit="def", duration_s=60.0)
            with self.assertRaisesRegex(ValueError, "differ in commit, duration_s"):
                shards.parts(out)
            (out / "shard-3-of-3" / "design.json").unlink()
            self.shard(out, "shard-1-of-6")
            with self.assertRaisesRegex(ValueError, "differ in shard"):
                shards.parts(out)
            (out / "keys.sha256").write_text("", encoding="utf-8")
            with self.assertRaisesRegex(ValueError, "a set of its own beside shards"):
                shards.parts(out)


class Calls(unittest.TestCase):
    """Of a program that ends as it is told to."""

    def explained(self, folder, script, limit_s=60.0):
        program = folder / "bin" / "gap-explain"
        program.parent.mkdir(exist_ok=True)
        program.write_text(f"#!/bin/bash\n{script}\n", encoding="utf-8")
        program.chmod(0o755)
        (folder / "ship.json").write_text("{}", encoding="utf-8")
        return tool.explain(folder / "bin", folder / "ship.json", [], [], folder / "result", limit_s)

    def test_a_call_that_somebody_else_ends_is_made_again(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            for signal, is_kept in (("INT", False), ("TERM", False), ("SEGV", True)):
                script = f"kill -{signal} $$"
                first, _ = self.explained(folder, script)
                self.assertLess(first["exit_code"], 0)
                self.assertEqual((folder / "result" / "run.json").exists(), is_kept, signal)
                self.assertEqual(self.explained(folder, script)[1], not is_kept, signal)

    def test_one_that_takes_too_long_has_failed(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            record, _ = self.explained(folder, "exec sleep 30", limit_s=0.3)
            self.assertNotEqual(record["exit_code"], 0)
            self.assertFalse(self.explained(folder, "exec sleep 30", limit_s=0.3)[1])

    def test_half_a_record_is_none(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "result").mkdir()
            (folder / "result" / "run.json").write_text('{"inputs_sha', encoding="utf-8")
            self.assertTrue(self.explained(folder, "exit 3")[1])
            self.assertEqual(tool.kept(folder / "result" / "run.json")["exit_code"], 3)


class Sealed(unittest.TestCase):
    """One short case, made and run with a program that writes down what it was called with."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.out = pathlib.Path(cls.folder.name)
        case = next(c for c in campaign.design("smoke", "s", 12, 40.0) if c["names"] == ["rudder-offset"] or c["family"] == "single")
        cls.case = {**case, "names": ["rudder-offset"], "wind": "calm"}
        group = campaign.Group([cls.case])
        track, found = group.make(0.2)
        (cls.out / "keys").mkdir()
        group.write(cls.out / "cases", cls.out / "keys", track, found)
        campaign.seal(cls.out / "keys")
        cls.key = json.loads(next((cls.out / "keys").glob("*.json")).read_text(encoding="utf-8"))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_test_recordings_are_sealed_and_never_given(self):
        program = self.out / "bin" / "gap-explain"
        program.parent.mkdir()
        program.write_text('#!/bin/bash\nprintf "%s\\n" "$@" >>"$LOG"\nwhile [[ $1 != -o ]]; do shift; done\necho "{}" >"$2/report.json"\n', encoding="utf-8")
        program.chmod(0o755)
        log = self.out / "log"
        subprocess.run([PROOF / "run", "--bin", program.parent, "--jobs", "1", self.out], env={**os.environ, "LOG": str(log)}, capture_output=True, check=True)
        given = log.read_text(encoding="utf-8").splitlines()
        self.assertEqual(sum(f.endswith(".csv") for f in given), self.case["trains"] + 1)
        self.assertFalse([f for f in given if "test-" in f or "/keys" in f])
        self.assertEqual(list((self.out / "cases").glob("*/test-*")), [])
        sealed = sorted((self.out / "keys" / self.key["id"]).glob("test-*.csv"))
        self.assertEqual(len(sealed), campaign.TESTS)
        for file in sealed:  # the key, which is sealed, has their hash
            self.assertEqual(self.key["noise_free"][file.name], hashlib.sha256(file.read_bytes()).hexdigest())
        self.assertEqual(campaign.broken_seals(self.out / "keys"), [])
        for file in (sealed[0], sealed[0].with_name("track.npz")):
            as_sealed = file.read_bytes()
            file.write_bytes(as_sealed + b" ")
            self.assertEqual(campaign.broken_seals(self.out / "keys"), [f"{self.key['id']}/{file.name}"])
            file.write_bytes(as_sealed)

    def test_judged_cases_that_are_kept_make_the_same_tables(self):
        """Of a shard that is kept and one that is not; what is no such file is refused."""
        with tempfile.TemporaryDirectory() as name:
            out = pathlib.Path(name) / "set"
            design = {"set": "full", "is_sealed": True, "commit": "c0ffee" * 6, "seed": "s", "cases": None}
            for k in (1, 2):
                shard = out / f"shard-{k}-of-3"
                shutil.copytree(self.out / "cases", shard / "cases")
                shutil.copytree(self.out / "keys", shard / "keys")
                shutil.copy(self.out / "keys.sha256", shard)
                (shard / "design.json").write_text(json.dumps({**design, "shard": f"{k}/3"}), encoding="utf-8")
                result = shard / "results" / self.key["id"]
                result.mkdir(parents=True)
                (result / "run.json").write_text(json.dumps({**RUN, "tool_sha256": "one"}), encoding="utf-8")
                (result / "report.json").write_text(json.dumps(report(chosen=["rudder-offset"], hypotheses=[(["rudder-offset"], 0.9 + 1e-9, [])], inclusion={"rudder-offset": 1.0 / 3.0})),
                                                    encoding="utf-8")
            score = lambda *options: subprocess.run([PROOF / "score", "--no-replay", *options], capture_output=True, text=True, check=False)
            kept = pathlib.Path(name) / "kept"
            judged_now = score("--keep", kept, out)
            self.assertEqual((judged_now.returncode, sorted(f.name for f in kept.iterdir())), (0, ["shard-1-of-3.json.gz", "shard-2-of-3.json.gz"]), judged_now.stderr)
            self.assertIn("2 of 2 cases of the set `full` (sealed: SHA-256 of commit c0ffeec0ffee, 2 of 3 shards)", judged_now.stdout)
            as_kept = (kept / "shard-1-of-3.json.gz").read_bytes()
            self.assertEqual(score(kept).stdout, judged_now.stdout)
            self.assertEqual(score("--keep", kept, out).stdout, judged_now.stdout)
            self.assertEqual((kept / "shard-1-of-3.json.gz").read_bytes(), as_kept)
            # A shard that is kept stands beside one that is still to be judged, but not beside itself.
            shutil.copy(kept / "shard-2-of-3.json.gz", out)
            twice = score(out)
            self.assertEqual((twice.returncode, "are the same shard" in twice.stderr), (3, True), twice.stderr)
            (out / "shard-2-of-3.json.gz").unlink()
            run = out / "shard-2-of-3" / "results" / self.key["id"] / "run.json"
            run.write_text(json.dumps({**RUN, "tool_sha256": "other"}), encoding="utf-8")
            mixed = score(out)
            self.assertEqual((mixed.returncode, "several builds" in mixed.stderr), (3, True), mixed.stderr)
            shutil.rmtree(out / "shard-2-of-3")
            shutil.copy(kept / "shard-2-of-3.json.gz", out)
            self.assertEqual(score(out).stdout, judged_now.stdout)
            refused = score("--keep", out / "shard-2-of-3.json.gz", kept)
            self.assertEqual((refused.returncode, refused.stderr.count("\n")), (4, 1), refused.stderr)
            self.assertEqual(score(out / "nothing").returncode, 4)
            for content in (b"", b"{}", gzip.compress(b"[]"), gzip.compress(json.dumps({"version": 0, "design": {**design, "shard": "2/3"}}).encode()), as_kept[:-9]):
                (kept / "shard-2-of-3.json.gz").write_bytes(content)
                refused = score(kept)
                self.assertEqual((refused.returncode, "shard-2-of-3.json.gz" in refused.stderr, "Traceback" in refused.stderr), (3, True, False), refused.stderr)

    def test_the_key_says_where_the_effect_acts(self):
        truth = self.key["truth"]["rudder-offset"]
        self.assertAlmostEqual(sum(truth["dof"].values()), 1.0)
        self.assertLess(truth["x_F_over_L_pp"], -0.3)  # at the stern

    def test_the_advised_maneuver_is_sailed_with_the_same_hidden_effect(self):
        ship = model.read_ship(self.case["ship"])
        slow_turns = "turning circles, 35 deg to both sides, at 50 % speed"
        chosen = {n: m for n, m in advised.menu(ship).items() if n in ("a coast-down with stopped propeller", "a zigzag 10/10", slow_turns)}
        voyage = advised.Voyage(self.key, chosen)
        self.assertEqual(voyage.effects_of(0)["rudder_offset"], np.radians(self.key["truth"]["rudder-offset"]["parameters"]["rudder_offset_deg"]))
        self.assertEqual(voyage.factors[0], campaign.Group([self.case]).factors[0])
        files = voyage.record(self.out / "next", 0.2)
        down, zigzag = (recording.read_csv(files[n][0]) for n in ("a coast-down with stopped propeller", "a zigzag 10/10"))
        self.assertEqual((len(down["t_s"]), len(zigzag["t_s"])), (121, 151))
        self.assertAlmostEqual(down["n_p_rps"][-1], 0.0)
        self.assertGreater(np.max(zigzag["psi_deg"]), 8.0)
        slow = recording.read_csv(files[slow_turns][0])
        self.assertAlmostEqual(slow["u_mps"][0], 0.5 * ship["u0_mps"], delta=0.05)
        self.assertLess(np.max(slow["u_mps"]), 0.6 * ship["u0_mps"])

    def test_what_is_advised_and_what_is_right(self):
        listed = [{"maneuver": n, "p_right": q, "duration_s": d} for n, q, d in (("a", 0.9, 200.0), ("b", 0.8, 120.0))]
        plan = lambda record=None, *names: {"next": {"p_right_now": 0.4, "maneuvers": listed, "advised": {"maneuvers": list(names), "record": record, "p_right": 0.95}}}
        self.assertEqual(advised.advice(plan(None, "b")), (("b",), {"a": 0.9, "b": 0.95}))
        self.assertEqual(advised.advice(plan(None, "b", "a")), (("b", "a"), {"a": 0.9, "b": 0.8, "b and a": 0.95}))
        self.assertEqual(advised.advice(plan("positions", "b"))[0], ())  # other instruments, no maneuver
        self.assertEqual(advised.advice(plan())[0], ())
        self.assertEqual(advised.advice({"next": {"maneuvers": [], "advised": None}}), ((), {}))
        self.assertTrue(advised.is_right(report(hypotheses=[(["a"], 0.3, []), (["b"], 0.6, [])]), ["b"]))
        self.assertFalse(advised.is_right(report(hypotheses=[(["a", "b"], 0.6, [])]), ["b"]))
        trial = {"missing": True, "menu": ["a", "b"], "promised": {"a": 0.9, "b": 0.5}, "advised": "a", "random": "b", "right_before": False, "right_after": {"a": False, "b": True}}
        text = "\n".join(tables.next_table([trial]))
        self.assertIn("| the maneuver that is advised | 1 | 0/1", text)
        self.assertIn("| 0.90 | 0/1", text)
        self.assertIn("| the best of all | 1 | 0/1 = 0 % (0 to 79) | – | 1/1", text)


if __name__ == "__main__":
    unittest.main()
