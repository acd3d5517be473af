#!/usr/bin/python3
"""Tests the scripts of scripts/experiments/ensembles on made-up results: verdicts that are met and that are not, what has not been
computed, base ships, data sets, each member in turn, replays that diverge, and what the Makefile hands on."""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
ENSEMBLES = ROOT / "scripts" / "experiments" / "ensembles"
SHIPS = ROOT / "configs" / "ships"
SETS = ("Test-B", "Test-R", "Test-ZT")
FULL_SETS = ("Test-Full-B", "Test-Full-B, unrecorded physics", "Test-R", "Test-ZT")
RUNGS = ("plain", "physics", "disturbances", "initial-error")
SETTINGS = ("SIZE=tiny CONFIG=configs/honest.json UNITS= MEMBERS=12 SEEDS=2 BASES=4 WRONG_BASES=2 TRUE_SHIPS=3 MANY_MEMBERS=19 MANY_SHIPS=2 LOG_SD=0.15 SEED=1")


class EnsemblesTest(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="leeway-ensembles-")
        self.addCleanup(temporary.cleanup)
        self.out = pathlib.Path(temporary.name)

    def write(self, name, content):
        path = self.out / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
        return path

    def run_script(self, name, *arguments, code=0, **options):
        result = subprocess.run([ENSEMBLES / name, *map(str, arguments)], cwd=self.out, capture_output=True, text=True, check=False, **options)
        self.assertEqual(result.returncode, code, result.stderr)
        if code:
            self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        return result


class Tables(EnsemblesTest):
    def scores(self, name, sets=SETS, held=0.9, L_eucl=1e-4, ratio=1.0, inputs=()):
        entries = [{"name": data, "sequences": 5, "coverage": {"50": 0.5, "90": held, "99": 0.99}, "L_eucl": L_eucl, "L_maha": 4.0 * ratio,
                    "maha_honest": 4.0, "energy_score": 0.01} for data in sets]
        self.write(f"{name}.json", {"datasets": entries, "overall": {**entries[0], "name": "overall"}, "provenance": {"inputs": [{"file": file} for file in inputs]}})

    def over(self, folder, name, held=0.9, in_turn=0.85, replay=2e-4, L_eucl=1e-4, **scores):
        self.scores(f"{folder}/{name}", held=held, L_eucl=L_eucl, **scores)
        self.write(f"{folder}/{name}-in-turn.json", {"datasets": {data: {"held": {"90": [in_turn] * 12}, "trace": 1.2e-4} for data in SETS}})
        self.write(f"{folder}/{name}-replay.json", {"datasets": [{"name": data, "L_eucl": replay} for data in SETS]})

    def trained(self, name, members, calibration=0.0):
        self.write(f"models/{name}.trained", "")
        self.write(f"models/{name}.seconds", f"{members / 2}\tens-train --member 0\n{members / 2}\tens-train --member 1\n{calibration}\tens-train\n")

    def results(self):
        self.write("settings", SETTINGS)
        self.write("models/honest.json", {"epochs": 60})
        self.write("models/plain.json", {"epochs": 60})
        for seed in (1, 2):
            for rung in RUNGS:
                self.scores(f"ladder/model-{rung}-{seed}", L_eucl=1e-3 if rung == "plain" else 1e-4, held=0.4 if rung == "plain" else 0.88 + 0.02 * seed)
                self.scores(f"ladder/full-{rung}-{seed}", sets=FULL_SETS)
                for group in ("real", "without-zigzag"):
                    self.scores(f"ladder/{group}-{rung}-{seed}", sets=("zigzag", "random"), L_eucl=5e-4, inputs=("d/zigzag/a.csv", "d/zigzag/b.csv", "d/random/c.csv", "p.json"))
            for name in ("plain", "full-plain", "full-honest", "real-plain", "real-honest"):
                self.trained(f"{name}-{seed}", 100.0)
            self.over("misstated", f"right-{seed}", L_eucl=2.1e-4)
            self.over("misstated", f"wrong-{seed - 1:02}", held=0.72)
            self.scores(f"misstated/as-stated-{seed - 1:02}", held=0.5)
            for form in ("quadratic-hull", "other-rudder"):
                self.over("form", f"{form}-{seed}", held=0.8)
                self.scores(f"form/{form}-{seed}-physics", held=0.6)
        for base in range(4):
            self.over("bases", f"{base:02}", held=0.86 + 0.02 * base)
            self.trained(f"base-{base:02}", 190.0, 250.0)
        for ship in range(3):
            self.sweep("plain", ship, worst=(9, 9, 9, 9))
            self.sweep("honest", ship, worst=(11, 11, 11, 12) if ship else (11, 11, 11, 8))
        for ship in range(2):
            self.sweep("many", ship, worst=(11, 10.5, 11, 11))

    def sweep(self, kind, ship, worst, true=(10, 10.5, 10.2, 11)):
        rows = "".join(f"{k},5,{t},{w}\n" for k, (t, w) in enumerate(zip(true, worst)))
        self.write(f"controllers/{kind}-{ship:02}.csv", f"kp_deg_per_rad,kd_deg_per_radps,score_true,score_worst\n{rows}")

    def verdict(self, target):
        """Whether a target is met, by the tables."""
        text = self.run_script("tables", "print", ".").stdout
        lines = [line for line in text.splitlines() if line.startswith("| ") and target in line]
        self.assertEqual(len(lines), 1, f"{target}: {lines}")
        return {"yes": True, "**no**": False, "–": None}[lines[0].split(" | ")[-1].removesuffix(" |")], lines[0]

    def test_all_targets_are_met_by_honest_results(self):
        self.results()
        text = self.run_script("tables", "print", ".").stdout
        self.assertNotIn("**no**", text)
        self.assertEqual(text.count("To be computed"), 1)
        self.assertIn("*To be computed:* `make -C scripts/experiments/ensembles figures`", text)
        self.assertIn("| Test-B | plain networks | 1.0e-03 | 4 (4) | 50 | 40 (40 to 40) | 99 | 0.01 | 100 |", text)
        self.assertIn("|  | + physics | 1.0e-04 | 4 (4) | 50 | 91 (90 to 92) | 99 | 0.01 | 190 |", text)
        self.assertIn("|  | + disturbances | 1.0e-04 | 4 (4) | 50 | 91 (90 to 92) | 99 | 0.01 | 440 |", text)
        self.assertIn("held out: 3 recordings, 5 sequences", text)
        self.assertIn("| zigzag | 2 | 5 |", text)
        self.assertIn("widths as stated, S = 1 (2 of 2) | Test-B | 1.0e-04 | 4 (4) | 50 | 50 (50 to 50) |", text)

    def test_each_target_can_be_missed(self):
        for target, spoil in (
            ("Test-B: 90 % regions hold 85 to 95 %", lambda: [self.over("bases", f"{k:02}", held=0.83) for k in range(4)]),
            ("Test-R: 90 % regions hold 85 to 95 %", lambda: [self.over("bases", f"{k:02}", held=0.96) for k in range(4)]),
            ("Test-ZT: tenth percentile", lambda: self.over("bases", "00", held=0.5)),
            ("Test-B: median L_Maha", lambda: [self.over("bases", f"{k:02}", ratio=2.2) for k in range(3)]),
            ("Test-B: L_Eucl not above", lambda: [self.over("bases", f"{k:02}", L_eucl=1.1e-3, replay=2e-3) for k in range(4)]),
            ("Test-R: L_Eucl at least 3 times", lambda: [self.over("bases", f"{k:02}", L_eucl=4e-4, replay=2e-3) for k in range(4)]),
            ("Test-R: L_Eucl below", lambda: [self.over("bases", f"{k:02}", replay=0.9e-4) for k in range(4)]),
            ("Test-ZT: L_Eucl at most 1.5", lambda: [self.over("bases", f"{k:02}", replay=0.6e-4) for k in range(4)]),
            ("Test-B, misstated", lambda: self.over("misstated", "wrong-00", held=0.6)),
            ("Test-B, right base", lambda: self.over("misstated", "right-1", L_eucl=3e-4)),
            ("Test-B, side force", lambda: self.over("form", "quadratic-hull-1", held=0.6)),
            ("Test-R, rudders of", lambda: self.over("form", "other-rudder-2", held=0.6)),
            ("L_Eucl at most 5.5e-4", lambda: self.scores("ladder/real-initial-error-1", L_eucl=7e-4)),
            ("90 % regions hold 80 to 97 %", lambda: [self.scores(f"ladder/real-initial-error-{s}", held=0.98) for s in (1, 2)]),
            ("L_Maha within a factor of 2", lambda: [self.scores(f"ladder/real-initial-error-{s}", ratio=0.4) for s in (1, 2)]),
            ("at least 75 % of zigzag", lambda: self.scores("ladder/without-zigzag-initial-error-1", held=0.5, inputs=("d/zigzag/a.csv",))),
            ("12 members: the worst promises", lambda: [self.sweep("honest", k, worst=(9, 11, 11, 12)) for k in range(3)]),
            ("19 members: the gains it chooses", lambda: [self.sweep("many", k, worst=(11, 11, 11.5, 10), true=(9, 10, 10, 10)) for k in range(2)]),
            ("at most 4 minutes", lambda: [self.trained(f"base-{k:02}", 190, 300) for k in (0, 1)]),
            ("at most twice as long", lambda: self.trained("base-00", 230)),
            ("at most three times as long", lambda: [self.trained(f"base-{k:02}", 100, 250) for k in (0, 1)]),
        ):
            with self.subTest(target):
                self.results()
                self.assertEqual(self.verdict(target)[0], True)
                spoil()
                self.assertEqual(self.verdict(target)[0], False)

    def test_what_is_not_there_is_to_be_computed_and_a_part_is_called_one(self):
        self.write("settings", SETTINGS)
        text = self.run_script("tables", "print", ".").stdout
        self.assertEqual(text.count("*To be computed:*"), 8)
        self.assertNotIn("| target |", text)
        self.over("bases", "02")
        text = self.run_script("tables", "print", ".").stdout
        self.assertIn("So far 1 of 4 base ships.", text)
        self.assertEqual(text.count("*To be computed:*"), 7)
        self.sweep("honest", 1, worst=(11, 11, 11, 12))
        verdict, line = self.verdict("12 members: the worst promises")
        self.assertIsNone(verdict)  # no standard error from one ship
        self.assertIn("0.0 %", line)

    def test_a_replay_that_diverges_takes_part_in_no_comparison_with_replays(self):
        self.results()
        self.over("bases", "00", replay=None, L_eucl=1e-2)
        _, line = self.verdict("Test-B: L_Eucl below that of the base's own replay")
        self.assertIn("1.0e-04 and 2.0e-04", line)
        self.assertIn("(1 diverge)", self.run_script("tables", "print", ".").stdout)

    def test_the_page_has_a_place_for_each_table(self):
        self.results()
        self.write("figures/honest.png", "picture")
        page = (ROOT / "docs" / "ensembles.md").read_text(encoding="utf-8")
        copy = self.out / "repository" / "scripts" / "experiments" / "ensembles"
        shutil.copytree(ENSEMBLES, copy)
        (self.out / "repository" / "docs" / "figures").mkdir(parents=True)
        (self.out / "repository" / "docs" / "ensembles.md").write_text(page, encoding="utf-8")
        subprocess.run([copy / "tables", "page", "."], cwd=self.out, check=True)
        written = (self.out / "repository" / "docs" / "ensembles.md").read_text(encoding="utf-8")
        self.assertNotIn("*To be computed:*", written)
        self.assertIn("](figures/ensembles-honest.png)", written)
        self.assertEqual((self.out / "repository" / "docs" / "figures" / "ensembles-honest.png").read_text(encoding="utf-8"), "picture")
        self.assertEqual([line for line in written.splitlines() if line.startswith("#")], [line for line in page.splitlines() if line.startswith("#")])
        self.assertIn("Made by `make -C scripts/experiments/ensembles bases`: SIZE tiny, CONFIG honest, MEMBERS 12, BASES 4, LOG_SD 0.15.", written)

    def test_wrong_calls(self):
        self.run_script("tables", "show", ".", code=2)
        self.run_script("tables", "print", "nowhere", code=4)
        self.write("settings", SETTINGS)
        self.write("ladder/model-plain-1.json", "{")
        self.run_script("tables", "print", ".", code=3)


class Ships(EnsemblesTest):
    def setUp(self):
        super().setUp()
        self.draws = self.write("draws.json", {"draws": [{"coefficient_factors": {"hull.Y_v": 1.1, "rudder.k_x": 0.9, "wind.k_X": 1.0}}]})

    def ship(self, *arguments):
        self.run_script("base-ships", *arguments, "-o", "ship.json")
        return json.loads((self.out / "ship.json").read_text(encoding="utf-8"))

    def test_a_law_is_stated_for_each_coefficient(self):
        self.assertEqual(self.ship("stated", "vectwin-3m", "draws.json", "--log-sd", "0.2")["uncertainty"], {"hull.Y_v": 0.2, "rudder.k_x": 0.2, "wind.k_X": 0.2})

    def test_a_wrong_ship_is_wrong_in_everything_and_states_nothing(self):
        self.ship("stated", "vectwin-3m", "draws.json")
        for number in range(20):
            wrong = self.ship("wrong", "ship.json", "draws.json", "--number", number)
            self.assertNotIn("uncertainty", wrong)
            self.assertTrue(all(0.0999 <= abs(factor - 1.0) <= 0.2001 for factor in wrong["coefficient_factors"].values()))
            self.assertEqual(list(wrong["coefficient_factors"]), ["hull.Y_v", "rudder.k_x", "wind.k_X"])
        self.assertEqual(self.ship("wrong", "vectwin-3m", "draws.json", "--number", 3), self.ship("wrong", "vectwin-3m", "draws.json", "--number", 3))
        self.assertNotEqual(self.ship("wrong", "vectwin-3m", "draws.json", "--number", 3), self.ship("wrong", "vectwin-3m", "draws.json", "--number", 4))

    def test_the_quadratic_hull_has_the_forces_of_the_linear_one_at_one_motion_each(self):
        true = json.loads((SHIPS / "vectwin-3m.json").read_text(encoding="utf-8"))["hull"]
        hull = self.ship("quadratic-hull", "vectwin-3m")["hull"]
        self.assertEqual((hull["Y_v"], hull["N_r"], hull["N_v"], hull["Y_r"]), (0.0, 0.0, true["N_v"], true["Y_r"]))

        def side(h, v):
            return h["Y_v"] * v - h["C_D"] * v * abs(v)

        def yaw(h, r):  # |a x| a x x integrated from -1/2 to 1/2 is a |a| / 32
            return h["N_r"] * r - h["C_D"] * (h["C_rN"] * r) * abs(h["C_rN"] * r) / 32.0

        self.assertAlmostEqual(side(hull, 0.15), side(true, 0.15), places=12)
        self.assertAlmostEqual(yaw(hull, 0.3), yaw(true, 0.3), places=12)
        self.assertGreater(abs(side(hull, 0.05) / side(true, 0.05) - 1.0), 0.3)
        self.assertAlmostEqual(hull["C_D"] * hull["C_rY"] ** 2, true["C_D"] * true["C_rY"] ** 2)

    def test_another_ship_has_rudders_to_lend(self):
        other = json.loads((SHIPS / "esso-osaka-3m.json").read_text(encoding="utf-8"))["rudder"]
        rudder = self.ship("other-rudder", "vectwin-3m", "--of", "esso-osaka-3m")["rudder"]
        self.assertEqual((rudder["type"], rudder["k_x"], rudder["A_R_m2"]), ("vectwin-kang-2008", other["k_x"], other["A_R_m2"]))
        self.assertIn("esso-osaka-3m", rudder["source"])

    def test_wrong_calls(self):
        self.run_script("base-ships", "stated", "no-ship", "draws.json", "-o", "s.json", code=4)
        self.write("empty.json", {"draws": []})
        self.run_script("base-ships", "stated", "vectwin-3m", "empty.json", "-o", "s.json", code=3)
        self.assertFalse((self.out / "s.json").exists())


class Data(EnsemblesTest):
    def test_recordings_with_unrecorded_physics_are_a_set_of_their_own(self):
        self.write("dataset.json", {"sets": [{"name": "Test", "recordings": [{"file": "Test/a.csv"}, {"file": "Test/b.csv"}]},
                                             {"name": "Train", "recordings": [{"file": "Train/c.csv"}]}]})
        self.write("Test/truth/runs.json", {"runs": [{"recording": "a"}, {"recording": "b", "unrecorded": [{"type": "tug"}]}]})
        self.run_script("data-spec", "split", "dataset.json", "-o", "split.json")
        sets = json.loads((self.out / "split.json").read_text(encoding="utf-8"))["sets"]
        self.assertEqual([(entry["name"], [r["file"] for r in entry["recordings"]]) for entry in sets],
                         [("Test", ["Test/a.csv"]), ("Test, unrecorded physics", ["Test/b.csv"]), ("Train", ["Train/c.csv"])])
        self.run_script("data-spec", "split", "nowhere.json", "-o", "split.json", code=4)
        self.run_script("data-spec", "split", code=2)

    def test_navigations_are_of_the_ship_and_as_long_as_those_that_it_cannot_follow(self):
        self.run_script("data-spec", "navigations", "draw-03.json", "-o", "spec.json")
        spec = json.loads((self.out / "spec.json").read_text(encoding="utf-8"))
        self.assertEqual(spec["ship"], str(self.out / "draw-03.json"))
        self.assertEqual([entry["name"] for entry in spec["sets"]], ["Train-B"])
        self.assertEqual((spec["sets"][0]["runs"][0]["count"], spec["sets"][0]["runs"][0]["total_duration_s"]), (27, 4770))

    def test_noise_is_what_the_calibration_found(self):
        (self.out / "model").mkdir()
        self.assertEqual(self.run_script("noise-of", "model").stdout, "")
        self.write("model/calibration.json", {"sensor_sd": {"u_mps": 0.004, "vm_mps": 0.002, "r_degps": 0.03}})
        self.assertEqual(self.run_script("noise-of", "model").stdout, "--noise-u-mps 0.004 --noise-vm-mps 0.002 --noise-r-degps 0.03\n")
        self.write("model/calibration.json", {"sensor_sd": {}})
        self.assertIn("expected an object", self.run_script("noise-of", "model", code=3).stderr)
        self.run_script("noise-of", code=2)

    def test_a_plain_config_keeps_networks_and_schedule_alone(self):
        self.run_script("training-config", "fast", "base_spread=\"auto\"", "hidden_units=32", "-o", "honest.json")
        self.run_script("training-config", "fast", "--plain", "--scale-of", "full-scale", "epochs=3", "-o", "plain.json")
        honest, plain = (json.loads((self.out / f"{name}.json").read_text(encoding="utf-8")) for name in ("honest", "plain"))
        self.assertEqual((honest["base_spread"], honest["hidden_units"]), ("auto", 32))
        self.assertEqual((plain["time_step_s"], plain["epochs"], plain["optimizer"]), (7.0, 3, "muon"))
        self.assertNotIn("base_spread", plain)
        self.run_script("training-config", "no-such-config", "-o", "c.json", code=4)


class Predictions(EnsemblesTest):
    def predictions(self, members=8, points=300):
        import random

        draw = random.Random(5)
        text = "recording,sequence,step,t_s,particle,member,x0_m,y0_m,psi_deg,u_mps,vm_mps,r_degps\n"
        for step in range(points):
            for member in range(members):
                text += f"test-1,0,{step},{step},{member},{member},0,0,0," + ",".join(str(draw.gauss(0.0, 1.0)) for _ in range(3)) + "\n"
        self.write("prediction.csv", text)
        self.write("dataset.json", {"sets": [{"name": "Test", "recordings": [{"file": "Test/test-1.csv"}]}]})

    def test_each_member_in_turn_is_held_as_often_as_its_region_promises(self):
        self.predictions()
        self.run_script("in-turn", "prediction.csv", "dataset.json", "--every", "1", "-o", "found.json")
        found = json.loads((self.out / "found.json").read_text(encoding="utf-8"))["datasets"]["Test"]
        self.assertEqual({level: len(shares) for level, shares in found["held"].items()}, {"50": 8, "90": 8, "99": 8})
        self.assertAlmostEqual(sum(found["held"]["90"]) / 8, 0.9, delta=0.03)
        self.assertAlmostEqual(found["trace"], 7 / 8 * (2.0 + (3.14159 / 180) ** 2), delta=0.1)

    def test_few_members_have_no_turn_and_unknown_recordings_no_set(self):
        self.predictions(members=4, points=3)
        self.run_script("in-turn", "prediction.csv", "dataset.json", "--every", "1", "-o", "found.json")
        self.assertEqual(json.loads((self.out / "found.json").read_text(encoding="utf-8"))["datasets"]["Test"]["held"]["90"], [])
        self.write("dataset.json", {"sets": []})
        self.assertIn("'test-1' is not in", self.run_script("in-turn", "prediction.csv", "dataset.json", "--every", "2", "-o", "x.json", code=3).stderr)
        self.assertIn("multiple of 9", self.run_script("in-turn", "prediction.csv", "dataset.json", "--every", "9", "-o", "x.json", code=3).stderr)

    def test_a_replay_that_diverges_is_a_result_and_another_error_is_not(self):
        self.write("data/dataset.json", {"sets": [{"name": name, "recordings": [{"file": f"{name}/a.csv", "truth": f"{name}/truth/a.csv"}]} for name in ("good", "bad", "odd")]})
        folder = self.out / "data"
        self.write("bin/mmg-sim", f"""#!/bin/bash
case "$*" in
  *bad/truth/a.csv*) echo "mmg-sim: error: {folder}/bad/truth/a.csv: the simulation diverged at 3 s" >&2; exit 1 ;;
  *odd/truth/a.csv*) echo "mmg-sim: error: odd" >&2; exit 3 ;;
esac
""").chmod(0o755)
        self.write("bin/eval-metrics", "#!/bin/bash\necho '{\"datasets\": [{\"name\": \"good\", \"L_eucl\": 0.25}]}'\n").chmod(0o755)
        dataset = folder / "dataset.json"
        self.run_script("replayed", self.out / "bin", "ship", dataset, "good", "bad", "-o", "scores.json")
        good, bad = json.loads((self.out / "scores.json").read_text(encoding="utf-8"))["datasets"]
        self.assertEqual((good["L_eucl"], bad["L_eucl"]), (0.25, None))
        self.assertEqual(bad["diverged"], "mmg-sim: error: bad/truth/a.csv: the simulation diverged at 3 s")
        self.assertEqual(self.run_script("replayed", self.out / "bin", "ship", dataset, "odd", "-o", "x.json", code=3).stderr, "mmg-sim: error: odd\n")
        self.run_script("replayed", self.out / "bin", "ship", dataset, "none", "-o", "x.json", code=3)
        self.run_script("replayed", self.out / "bin", code=2)
        self.assertFalse((self.out / "x.json").exists())


class Recipe(EnsemblesTest):
    def make(self, *arguments):
        return subprocess.run(["make", "-n", "-C", ENSEMBLES, f"OUT={self.out / 'out'}", *arguments], capture_output=True, text=True, check=False)

    def test_the_rungs_differ_by_what_is_switched_off(self):
        commands = self.make("SIZE=tiny", "SEEDS=1", "ladder").stdout.replace("\\\n", " ").splitlines()

        def switches(rung):
            command = next(text for text in commands if f"model-{rung}-1.json" in text)
            self.assertIn("ens-predict", command)
            return [word for word in command.split() if word.startswith("--no-")]

        self.assertEqual(switches("physics"), ["--no-calibration"])
        self.assertEqual(switches("disturbances"), ["--no-initial-error"])
        self.assertEqual(switches("initial-error"), [])

    def test_another_folder_is_asked_for_where_settings_differ(self):
        self.write("out/settings", "SIZE=tiny MEMBERS=3")
        self.assertIn("holds a run of other settings (SIZE=tiny MEMBERS=3); name another folder", self.make("SIZE=tiny").stderr)

    def test_what_cannot_be_is_refused(self):
        for arguments, message in ((["SIZE=huge"], "SIZE='huge' is not known; known: tiny full"), (["BASES=1", "SEEDS=3"], "BASES=1 is less than SEEDS=3"),
                                   ([f"DATA={self.out}"], "expected the folders random zigzag turning berthing")):
            result = self.make(*arguments)
            self.assertEqual(result.returncode, 2)
            self.assertIn(message, result.stderr)


if __name__ == "__main__":
    unittest.main()
