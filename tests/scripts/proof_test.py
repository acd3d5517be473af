#!/usr/bin/python3
"""Tests scripts/proof: the truth against mmg-sim and against physics, sealed keys, faults of instruments, the scorer."""

import csv
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROOF = ROOT / "scripts" / "proof"
sys.path.insert(0, str(PROOF))

import baselines  # noqa: E402
import campaign  # noqa: E402
import excitation  # noqa: E402
import model  # noqa: E402
import physics  # noqa: E402
import recording  # noqa: E402
import scores  # noqa: E402
import separability  # noqa: E402

BIN = pathlib.Path(os.environ.get("LEEWAY_BIN", ROOT / "build" / "release" / "bin"))
SHIPS = ("esso-osaka-3m", "vectwin-3m")


def state(**given):
    s = {"x": 0.0, "y": 0.0, "psi": 0.3, "u": 0.4, "v": 0.0, "r": 0.0, "q": np.zeros((3, 1)), "t": 0.0}
    s.update(given)
    return {k: v if k in ("q", "t") else np.array([v]) for k, v in s.items()}


def actuators(ship, delta=0.0, n=10.0):
    rudders = ("delta_p", "delta_s") if ship.startswith("vectwin") else ("delta",)
    return {**{c: np.array([delta]) for c in rudders}, "n_p": np.array([n]), **({"n_bt": np.zeros(1)} if ship.startswith("vectwin") else {})}


def acceleration(ship, level, delta=0.0, wind=None, effects=None, **given):
    truth = model.Model(model.read_ship(ship), level, {}, effects or {})
    return np.array([float(np.ravel(a)[0]) for a in truth.accelerations(state(**given), actuators(ship, delta), wind)])


def short_run(ship, level, effects=None, kinds=("zigzag",), duration=40.0, dt=0.1, sample_s=1.0, wind=None):
    truth = model.Model(model.read_ship(ship), level, {}, {k: np.full(len(kinds), v) for k, v in (effects or {}).items()})
    orders = [{"kind": k, "seed": 5, "heading_deg": 25.0, "rudder_deg": 15.0, "turn_by_deg": 10.0} for k in kinds]
    return excitation.simulate(truth, orders, duration, dt, sample_s, wind, None)


class Truth(unittest.TestCase):
    @unittest.skipUnless((BIN / "mmg-sim").exists(), "mmg-sim is not built")
    def test_level_1_is_mmg_sim_to_the_interpolation_of_actuators(self):
        for ship in SHIPS:
            with self.subTest(ship), tempfile.TemporaryDirectory() as folder:
                wind = excitation.wind_path(np.random.default_rng(1), {"speed_mps": 1.0, "dir_deg": 50.0, "gust": 0.1}, 40.0, 0.5, 1.0)[None]
                track = short_run(ship, 1, dt=0.05, sample_s=0.1, wind=wind)
                file = pathlib.Path(folder) / "own.csv"
                recording.write_csv(file, recording.columns_of(track, 0))
                replayed = subprocess.run([BIN / "mmg-sim", "replay", "--ship", ROOT / "configs/ships" / f"{ship}.json", file, "--sample-s", "0.1", "--dt-s", "0.05",
                                           "-o", "-", "--quiet"], capture_output=True, text=True, check=True)
                rows = list(csv.DictReader(replayed.stdout.splitlines()))
                self.assertGreater(np.ptp(track["r"][0]), math.radians(2.0))  # it does zigzag
                for name, mine, tolerance in (("u_mps", track["u"][0], 1e-4), ("vm_mps", track["v"][0], 1e-4), ("r_degps", np.degrees(track["r"][0]), 5e-3)):
                    theirs = np.array([float(r[name]) for r in rows])
                    self.assertLess(np.max(np.abs(theirs - mine[:len(theirs)])), tolerance, name)

    def test_signs(self):
        for ship in SHIPS:
            for level in (1, 2):
                with self.subTest(ship=ship, level=level):
                    plain = acceleration(ship, level)
                    steered = acceleration(ship, level, 0.2) - plain
                    self.assertTrue(steered[1] < 0.0 < steered[2], steered)
                    calm = acceleration(ship, level, wind=(np.zeros(1), np.zeros(1)))
                    at = lambda angle: (np.array([2.0 * math.cos(angle)]), np.array([2.0 * math.sin(angle)]))
                    self.assertLess((acceleration(ship, level, wind=at(0.3 + 0.5 * math.pi)) - calm)[1], 0.0)  # from starboard
                    self.assertLess((acceleration(ship, level, wind=at(0.3)) - calm)[0], 0.0)  # from ahead

    def test_a_mirrored_motion_meets_the_mirrored_hull_force(self):
        for level in (1, 2):
            truth = model.Model(model.read_ship("esso-osaka-3m"), level, {}, {})
            for v, r in ((0.05, 0.02), (0.3, -0.07), (0.0, 0.05)):
                a, b = (truth._hull(np.array([0.4]), np.array([s * v]), np.array([s * r]), np.array([math.hypot(0.4, v)])) for s in (1.0, -1.0))
                self.assertAlmostEqual(a[0][0], b[0][0], 12)
                self.assertAlmostEqual(a[1][0], -b[1][0], 12)
                self.assertAlmostEqual(a[2][0], -b[2][0], 12)

    def test_a_steady_current_only_carries_the_track_along(self):
        for ship in SHIPS:
            for level in (1, 2):
                with self.subTest(ship=ship, level=level):
                    truth = short_run(ship, level)
                    carried = short_run(ship, level, {"current_x": 0.07, "current_y": -0.04})
                    for name in ("psi", "r"):
                        self.assertLess(np.max(np.abs(carried[name] - truth[name])), 1e-9)
                    self.assertLess(np.max(np.abs(carried["x"] - truth["x"] - 0.07 * truth["t"])), 1e-8)
                    self.assertLess(np.max(np.abs(carried["y"] - truth["y"] + 0.04 * truth["t"])), 1e-8)

    def test_every_effect_acts_and_none_acts_at_zero_strength(self):
        rng = np.random.default_rng(3)
        ship = model.read_ship("vectwin-3m")
        track = short_run("vectwin-3m", 2, {"memory": 1e-9, "tank": 1e-9}, ("random",), 100.0)
        reach = {**{k: track[k] for k in ("x", "y", "psi")}, "duration": 100.0}
        plain = separability.accelerations(ship, 2, track, 0, {}, {}, None)
        for name, effect in {**physics.EFFECTS, **physics.OUTSIDE}.items():
            if effect.kind in ("force", "actuator") and name != "windage":
                with self.subTest(name):
                    shape = effect.draw(rng, ship, reach)
                    shape.setdefault("level", 2)
                    moved = separability.accelerations(ship, 2, track, 0, {}, effect.at(effect.most, shape, ship)[0], None)
                    self.assertGreater(np.max(np.abs(moved - plain)), 1e-7)
                    still = separability.accelerations(ship, 2, track, 0, {}, effect.at(0.0, shape, ship)[0], None)
                    np.testing.assert_allclose(still, plain, atol=1e-9 if name != "thruster-speed-loss" else 1e-6)

    def test_a_quay_pushes_the_bow_back(self):
        ship = model.read_ship("esso-osaka-3m")
        L, mass = ship["particulars"]["L_pp_m"], physics.mass(ship)
        # The bow 0.1 m in a quay right ahead; nothing moves.
        state = {"x": 0.0, "y": 0.0, "psi": 0.5 * math.pi, "u": 0.0, "v": 0.0, "r": 0.0}
        track = {**{k: np.full((1, 2), v) for k, v in state.items()}, "t": np.array([0.0, 1.0]), "q": np.zeros((2, 1, 2)), "channels": ["delta", "n_p"],
                 "a_delta": np.zeros((1, 2)), "a_n_p": np.zeros((1, 2))}
        quay = {"fender_k": 100.0, "fender_D": 0.5 * L - 0.1, "fender_dir": 0.5 * math.pi}
        for level in (1, 2):
            free, held = (separability.accelerations(ship, level, track, 0, {}, e, None)[:, 0] for e in ({}, quay))
            points = 2 if level == 1 else 1  # the box touches with two corners
            push = 10.0 * points / mass
            self.assertTrue(-push < held[0] - free[0] < -0.7 * push)  # added mass
            self.assertAlmostEqual(held[2] - free[2], 0.0, 9)

    def test_level_2_differs_by_about_a_fifth(self):
        for ship in SHIPS:
            track = short_run(ship, 2, None, ("zigzag",), 60.0)
            data = model.read_ship(ship)
            a, b = (separability.accelerations(data, level, track, 0, {}, {}, None) for level in (1, 2))
            share = np.sqrt(np.mean((a - b) ** 2)) / np.sqrt(np.mean(b**2))
            self.assertTrue(0.03 < share < 0.4, (ship, share))


class Instruments(unittest.TestCase):
    def setUp(self):
        self.columns = recording.columns_of(short_run("esso-osaka-3m", 2, None, ("zigzag",), 60.0), 0)

    def test_measured_is_true_with_the_fault(self):
        faulty = lambda **f: recording.with_faults(self.columns, f)
        np.testing.assert_allclose(faulty(heading_bias_deg=3.0)["psi_deg"], self.columns["psi_deg"] + 3.0)
        np.testing.assert_allclose(faulty(log_scale=0.05)["u_mps"], 1.05 * self.columns["u_mps"])
        np.testing.assert_allclose(faulty(heading_latency_s=2.0)["psi_deg"][2:], self.columns["psi_deg"][:-2])
        lever = faulty(lever_x_m=1.0, lever_y_m=0.0)
        np.testing.assert_allclose(lever["x0_m"] - self.columns["x0_m"], np.cos(np.radians(self.columns["psi_deg"])))
        self.assertLess(abs(np.mean(faulty(filter_s=2.0)["r_degps"] - recording.late(self.columns["t_s"], self.columns["r_degps"], 2.0))), 0.05)

    def test_late_and_filtered_sines_are_as_computed_by_hand(self):
        t, w = np.arange(0.0, 120.0), 0.5  # 12.6 samples a period
        settled = slice(40, -2)  # the last slope is one-sided
        for tau in (0.3, 1.0, 2.6):
            late = np.sin(w * (t - tau))
            filtered = (np.sin(w * t) - w * tau * np.cos(w * t)) / (1.0 + (w * tau) ** 2)
            np.testing.assert_allclose(recording.late(t, np.sin(w * t), tau)[settled], late[settled], atol=0.006)  # chords err by 0.03
            np.testing.assert_allclose(recording.filtered(t, np.sin(w * t), tau)[settled], filtered[settled], atol=0.006)

    def test_what_begins_when_a_recording_ends_is_not_seen(self):
        n, last, middle = 241, np.zeros((3, 241)), np.zeros((3, 241))
        last[0, -2:], middle[0, 120:122] = 0.01, 0.01
        gradients = [np.zeros((len(model.FACTORS), 3, n))]
        seen = lambda change: separability.separability([change], gradients, {"t": np.arange(n, dtype=float)}, "paper", 1.0, np.full(3, 1e-4), 15.0, 3.0)
        self.assertGreater(seen(middle), 1.0)
        self.assertLess(seen(last), 0.05 * seen(middle))

    def test_separability_is_linear_in_a_small_fault_and_zero_without(self):
        small, large = (separability.sensor_separability([self.columns], {"heading_bias_deg": b}, "paper", 1.0) for b in (0.5, 1.0))
        self.assertAlmostEqual(large / small, 2.0, 2)
        self.assertEqual(separability.sensor_separability([self.columns], {}, "paper", 1.0), 0.0)

    def test_whitened_noise_has_unit_variance(self):
        rng = np.random.default_rng(2)
        energy = np.mean([np.sum(separability.whitened(rng.standard_normal(200), np.ones(101), np.full(101, 1.0)) ** 2) for _ in range(200)])
        self.assertAlmostEqual(energy / 200.0, 1.0, 1)


class Wild(campaign.Group):
    """Two cases of two recordings; in the first the ship is lost with an effect stronger than 6 and far too fast with one above 3."""

    def __init__(self):
        self.ship_name, self.per, self.cases, self.ship = "ship", 2, [{"id": "a"}, {"id": "b"}], {"u0_mps": 1.0}
        self.plans = [{"tug": ({}, 10.0)}, {"tug": ({}, 5.0)}]

    def simulate(self, with_effects, dt):
        u = np.ones((4, 5))
        strength = self.plans[0]["tug"][1]
        u[1, 3:] = np.nan if strength > 6.0 else 2.1 if strength > 3.0 else 1.9
        return {"u": u, "v": np.zeros((4, 5))}


class Runaways(unittest.TestCase):
    def test_effects_with_which_a_ship_runs_away_are_halved_until_she_does_not(self):
        wild = Wild()
        self.assertTrue(np.isfinite(wild.sail(0.1)["u"]).all())
        self.assertEqual([plan["tug"][1] for plan in wild.plans], [2.5, 5.0])
        wild.plans[0]["tug"] = ({}, 1e6)
        with self.assertRaisesRegex(RuntimeError, "ship: a: "):
            wild.sail(0.1)


class Seals(unittest.TestCase):
    def test_a_changed_an_added_and_a_lost_key_are_noticed(self):
        with tempfile.TemporaryDirectory() as folder:
            keys = pathlib.Path(folder) / "keys"
            keys.mkdir()
            for name in ("a", "b"):
                (keys / f"{name}.json").write_text("{}", encoding="utf-8")
            campaign.seal(keys)
            self.assertEqual(campaign.broken_seals(keys), [])
            (keys / "a.json").write_text("[]", encoding="utf-8")
            (keys / "b.json").unlink()
            (keys / "c.json").write_text("{}", encoding="utf-8")
            self.assertEqual(campaign.broken_seals(keys), ["a.json", "b.json", "c.json"])

    def test_nothing_is_run_before_the_keys_are_sealed(self):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "keys").mkdir()
            result = subprocess.run([PROOF / "run", folder], capture_output=True, text=True, check=False)
            self.assertEqual((result.returncode, "not sealed" in result.stderr), (4, True))

    def test_what_needs_the_wind_has_it(self):
        cases = [c for c in campaign.design("full", "s") if {"convention", "anemometer", "windage"} & set(c["names"])]
        self.assertGreater(len(cases), 40)
        self.assertEqual({c["wind"] for c in cases}, {"measured"})

    def test_cases_follow_the_seed_alone(self):
        one, same, other = (json.dumps(campaign.design("nightly", seed)) for seed in ("s", "s", "t"))
        self.assertEqual(one, same)
        self.assertNotEqual(one, other)


def report(verdict="mismatch", chosen=(), hypotheses=(), faults=()):
    return {"verdict": verdict, "p_value": 0.001, "chosen": list(chosen), "audit": {"faults": list(faults)},
            "hypotheses": [{"name": " + ".join(e) or "none", "effects": list(e), "probability": p, "confusable_with": c, "parameters": q}
                           for e, p, c, q in hypotheses]}


def key(names=(), family="single", level=2, **parameters):
    return {"id": "x", "family": family, "names": list(names), "level": level, "ship": "vectwin-3m", "campaign": "mixed",
            "truth": {n: {"parameters": parameters, "d_prime": 12.0} for n in names}}


class Scores(unittest.TestCase):
    RUN = {"exit_code": 0, "wall_s": 1.0, "peak_kB": 1000}

    def test_a_right_name_with_its_interval(self):
        r = report(chosen=["steady-current"], hypotheses=[
            (["steady-current"], 0.9, ["wave-drift"], {"current_speed_mps": {"effect": "steady-current", "estimate": 0.04, "ci95": [0.035, 0.045]},
                                                        "current_set_deg": {"effect": "steady-current", "estimate": 359.0, "ci95": [355.0, 363.0]}}),
            (["wave-drift"], 0.1, [], {})])
        got = scores.judge(key(["steady-current"], current_speed_mps=0.042, current_set_deg=1.0), self.RUN, r)
        self.assertTrue(got["alarm"] and got["first"] and got["exact"] and got["set_ok"] and got["right"])
        self.assertEqual(got["set_size"], 2)
        covered = {q[1]: q[4] for q in got["quantities"]}
        self.assertEqual(covered, {"current_speed_mps": True, "current_set_deg": True})

    def test_a_look_alike_is_no_first_name_but_may_be_in_the_set(self):
        r = report(chosen=["wave-drift"], hypotheses=[(["wave-drift"], 0.6, ["steady-current"], {}), (["steady-current"], 0.4, [], {})])
        got = scores.judge(key(["steady-current"]), self.RUN, r)
        self.assertEqual((got["first"], got["set_ok"], got["set_size"], got["right"]), (False, True, 2, False))

    def test_sensor_faults_come_from_the_audit(self):
        r = report("mismatch", ["heading-bias"], [(["heading-bias"], 0.9, ["log-bias"], {}), ([], 0.0, [], {}), (["log-bias"], 0.1, [], {})],
                   [{"name": "heading-bias", "parameters": {"heading_bias_deg": {"estimate": 3.0, "sd": 0.1}}}])
        got = scores.judge(key(["heading-bias"], heading_bias_deg=3.1), self.RUN, r)
        self.assertTrue(got["alarm"] and got["first"] and got["set_ok"] and got["right"])
        self.assertEqual(got["set_size"], 2)
        self.assertTrue(scores.judge(key(["log-bias"]), self.RUN, r)["set_ok"])
        self.assertEqual(got["quantities"][0][4], True)

    def test_pairs_nulls_abstention_and_failures(self):
        pair = report(chosen=["a", "b"], hypotheses=[(["a", "b"], 1.0, [], {})])
        self.assertTrue(scores.judge(key(["b", "a"], "pair"), self.RUN, pair)["both"])
        null = scores.judge(key([], "null-noise"), self.RUN, report("no-mismatch", [], [([], 0.95, [], {})]))
        self.assertEqual((null["alarm"], null["right"]), (False, True))
        self.assertTrue(scores.judge(key(["ice-drag"], "outside"), self.RUN, report(chosen=["unknown"]))["unknown"])
        failed = scores.judge(key(["a"]), {"exit_code": 1}, None)
        self.assertEqual((failed["failed"], failed["alarm"]), (True, False))

    def test_a_report_may_lack_what_it_does_not_give(self):
        got = scores.judge(key(["a"]), self.RUN, {"verdict": "mismatch", "chosen": ["a"]})
        self.assertTrue(got["alarm"] and got["first"])
        self.assertIsNone(got["probability"])

    def test_limits_calibration_and_gaps(self):
        low, high = scores.wilson(0, 500)
        self.assertTrue(low == 0.0 and high < 0.01)
        error, table = scores.calibration([{"probability": 0.9, "right": True}] * 9 + [{"probability": 0.9, "right": False}])
        self.assertAlmostEqual(error, 0.0, 9)
        self.assertEqual(table[0][2], 10)
        # The mean of |share - 1/2| over 100 tosses is sqrt(1/(2 pi 100)).
        self.assertAlmostEqual(scores.calibration_by_chance([{"probability": 0.5, "right": False}] * 100), math.sqrt(1.0 / (200.0 * math.pi)), 2)
        self.assertAlmostEqual(scores.gap_closed(2.0, 1.0, 0.0), 0.5)
        self.assertIsNone(scores.gap_closed(2.0, 1.0, 1.95))


class Baselines(unittest.TestCase):
    def test_both_find_a_column_that_is_there(self):
        rng = np.random.default_rng(1)
        X = rng.standard_normal((300, 6))
        keys = [("a", 0), ("a", 1), ("b", 0), ("c", 0), (None, "Y_v"), (None, "N_v")]
        y = 0.8 * X[:, 2] + 0.3 * X[:, 4] + 0.1 * rng.standard_normal(300)
        self.assertEqual(baselines.stlsq(y, X, keys)[:1], ["b"])
        self.assertEqual(baselines.stepwise(y, X, keys)[:1], ["b"])


if __name__ == "__main__":
    unittest.main()
