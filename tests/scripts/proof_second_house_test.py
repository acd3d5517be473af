#!/usr/bin/python3
"""Tests scripts/proof/second_house: energy, symmetry and signs of its ship, its weather and instruments, agreement with the given ship files."""

import math
import os
import pathlib
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts" / "proof"))

import campaign  # noqa: E402
import recording  # noqa: E402
import scores  # noqa: E402
from second_house import agreement, cases, effects, separable, vessel, voyage, weather  # noqa: E402

BIN = pathlib.Path(os.environ.get("LEEWAY_BIN", ROOT / "build" / "release" / "bin"))


def state(**given):
    s = {"x": 0.0, "y": 0.0, "phi": 0.0, "psi": 0.3, "u": 0.4, "v": 0.0, "p": 0.0, "r": 0.0, "t": 0.0, **given}
    return {k: v if k in ("t", "q") else np.array([float(v)]) for k, v in s.items()}


def acting(ship, delta=0.0, n=None):
    n = next(a["initial_rps"] for a in ship.ship["actuators"] if a["channel"] == "n_p") if n is None else n
    return {**{c: np.array([delta]) for c in ship.rudders}, "n_p": np.array([n]), **({"n_bt": np.zeros(1)} if ship.is_twin else {})}


def sailed(name, orders, duration=60.0, spec=None, effect=None, wind=None, error=None, gain=0.0, dt=0.1):
    ship = vessel.Vessel(name, None, effect)
    rngs = [np.random.default_rng(k) for k in range(len(orders))]
    return voyage.sail(ship, [{"seed": 3, **o} for o in orders], duration, dt, 1.0, wind, error, voyage.Instruments(rngs, spec or {}, gain, 1.0, ship.scale))


class Frictionless(vessel.Vessel):
    """Momenta alone."""

    def forces(self, s, acting, wind, tables, u, v):
        return 0.0, 0.0, 0.0, 0.0


class Motion(unittest.TestCase):
    def test_without_forces_the_energy_stays(self):
        ship = Frictionless("vectwin-3m")
        ship.GM, ship.roll_damping = 0.0, 0.0

        def energy(s):
            u, v, p, r = (s[k][0] for k in "uvpr")
            return 0.5 * ((ship.m + ship.m_x) * u * u + (ship.m + ship.m_y) * v * v + ship.I_x * p * p + ship.I_z * r * r
                          + 2.0 * ship.m * v * (ship.x_G * r - ship.z_G * p))

        s = state(u=0.5, v=-0.2, p=0.3, r=0.25, phi=0.1)
        before, dt = energy(s), 0.01
        for _ in range(1000):
            k1 = ship.rates(s, {}, None)
            k2 = ship.rates({k: s[k] + 0.5 * dt * k1[k] if k in k1 else s[k] for k in s}, {}, None)
            k3 = ship.rates({k: s[k] + 0.5 * dt * k2[k] if k in k2 else s[k] for k in s}, {}, None)
            k4 = ship.rates({k: s[k] + dt * k3[k] if k in k3 else s[k] for k in s}, {}, None)
            s = {k: s[k] + dt / 6.0 * (k1[k] + 2.0 * (k2[k] + k3[k]) + k4[k]) if k in k1 else s[k] for k in s}
        self.assertGreater(abs(s["r"][0] - 0.25), 0.02)  # it does move
        self.assertAlmostEqual(energy(s) / before, 1.0, 9)

    def test_a_mirrored_motion_meets_the_mirrored_hull_force(self):
        for name in cases.SHIPS:
            ship = vessel.Vessel(name)
            for v, r, p, phi in ((0.05, 0.02, 0.1, -0.05), (0.3, -0.07, -0.2, 0.02), (0.0, 0.05, 0.0, 0.1)):
                a, b = (ship.hull(np.array([0.4]), np.array([k * v]), np.array([k * r]), np.array([k * p]), np.array([k * phi]), ship.tables) for k in (1.0, -1.0))
                for x, y, sign in zip(a, b, (1.0, -1.0, -1.0)):
                    self.assertAlmostEqual(x[0] / ship.q, sign * y[0] / ship.q, 12)

    def test_tables_are_alike_on_both_sides_and_of_a_size_that_ships_have(self):
        for name in cases.SHIPS:
            with self.subTest(name):
                ship = vessel.Vessel(name)
                t = ship.tables
                self.assertGreater(min(t["R"]), 0.3 * max(t["R"]))
                self.assertTrue(0.2 < t["C0"] + t["C2"] / 3.0 < 2.0)  # drag across, mean over the length
                for axis, sign in (("X", 1.0), ("Y", -1.0), ("N", -1.0)):
                    sides = [np.array(t[f"{axis}_{c}"]) for c in ship.rudders]
                    if ship.is_twin:  # each has the gain and the neutral angle of the file
                        self.assertLess(np.max(np.abs(sides[0] - sign * sides[1][::-1])), 0.5 * np.max(np.abs(sides[0])))
                    else:
                        np.testing.assert_allclose(sides[0], sign * sides[0][::-1], atol=2e-4)
                if "wind" in ship.ship:
                    self.assertEqual([t[f"wind_{axis}"][k] for axis in "YN" for k in (0, -1)], [0.0] * 4)

    def test_an_even_current_only_carries_the_track_along(self):  # of a ship that no air meets
        class Carried(vessel.Vessel):
            def water(self, s):
                return 0.07, -0.04, 0.0, 0.0

        tracks = [voyage.sail(kind("kvlcc2-l7"), [{"kind": "random", "seed": 5}], 40.0, 0.1, 1.0, None, None, agreement.Exact())["true"] for kind in (vessel.Vessel, Carried)]
        self.assertLess(np.max(np.abs(tracks[0]["psi_deg"] - tracks[1]["psi_deg"])), 1e-7)
        self.assertLess(np.max(np.abs(tracks[1]["x0_m"] - tracks[0]["x0_m"] - 0.07 * np.arange(41))), 1e-8)
        self.assertGreater(np.ptp(tracks[0]["psi_deg"]), 5.0)

    def test_signs(self):
        for name in cases.SHIPS:
            with self.subTest(name):
                ship = vessel.Vessel(name)
                u = ship.u_design
                rates = lambda wind=None, delta=0.0, **s: ship.rates(state(u=u, **s), acting(ship, delta), wind)
                plain, steered = rates(), rates(delta=0.2)
                self.assertLess(steered["v"][0], plain["v"][0])
                self.assertGreater(steered["r"][0], plain["r"][0])
                self.assertLess(rates(phi=0.05)["p"][0], plain["p"][0])  # a heel rights itself
                if "wind" in ship.ship:
                    at = lambda a: (np.array([2.0 * u * math.cos(a)]), np.array([2.0 * u * math.sin(a)]))
                    calm = rates((np.zeros(1), np.zeros(1)))
                    self.assertLess(rates(at(0.3 + 0.5 * math.pi))["v"][0], calm["v"][0])  # from starboard
                    self.assertLess(rates(at(0.3))["u"][0], calm["u"][0])  # from ahead

    def test_an_engine_slows_under_load(self):
        true = sailed("esso-osaka-3m", [{"kind": "turn", "rudder_deg": 35}, {"kind": "straight"}], 100.0)["true"]
        self.assertLess(true["n_p_rps"][0, 54], true["n_p_rps"][1, 54] - 0.05)

    def test_every_effect_acts_and_none_acts_at_zero_strength(self):
        out = sailed("vectwin-3m", [{"kind": "random", "heading_deg": 20.0}], 100.0)
        ship, rng = vessel.Vessel("vectwin-3m"), np.random.default_rng(1)
        wind = (np.full(101, 1.0), np.full(101, 0.5))
        change = lambda numbers: separable.accelerations("vectwin-3m", ship.tables, out, 0, {}, numbers, wind)
        plain = change({})
        for name, effect in {**effects.EFFECTS, **effects.OUTSIDE}.items():
            if effect.kind not in ("force", "actuator"):
                continue
            with self.subTest(name):
                shape = effect.draw(rng, ship, 100.0, {k: out["true"][k][0] for k in ("x0_m", "y0_m")})
                if name == "shifted-cargo":  # shows as a heel, along a track that has it
                    self.assertGreater(np.max(np.abs(sailed("vectwin-3m", [{"kind": "straight"}], 30.0, effect={"cargo": 0.2})["true"]["phi"])), 0.05)
                else:
                    self.assertGreater(np.max(np.abs(change(effect.at(effect.most, shape, ship)[0]) - plain)), 1e-6)
                np.testing.assert_allclose(change(effect.at(0.0, shape, ship)[0]), plain, atol=1e-9)


class Weather(unittest.TestCase):
    def test_model_error_has_its_size_and_its_kind(self):
        for kind in weather.KINDS:
            rngs = [np.random.default_rng(k) for k in range(40)]
            error = weather.ModelError(rngs, np.full(40, 1e-3), [kind] * 40, 400.0, 1.0, 3.0)
            path = np.stack([error.at(t) for t in np.arange(0.0, 400.0, 0.5)])  # (time, axis, recording)
            self.assertTrue(3e-4 < np.sqrt(np.mean(path[:, 1] ** 2)) < 2e-3, kind)
            if kind == "step":
                self.assertEqual(len(np.unique(path[:, 0, 0])), 2)
            if kind == "limit-cycle":  # two amplitudes back, near where it was
                self.assertLess(np.mean(np.abs(path[:, 0])), 1e-12)
        calm = weather.ModelError(rngs[:1], np.zeros(1), ["all"], 400.0, 1.0, 3.0)
        self.assertEqual(np.max(np.abs(calm.at(100.0))), 0.0)


class Scores(unittest.TestCase):
    def test_a_model_error_that_is_named_is_no_alarm(self):
        def alarm(kind, chosen, unknown_kind=None, error=1e-3):
            key = {"id": "x", "family": "null-second-house", "names": [], "truth": {}, "level": 2, "ship": "vectwin-3m", "campaign": "mixed", "error_kind": kind, "error": error}
            return scores.judge(key, {"exit_code": 0}, {"verdict": "mismatch", "chosen": chosen, "unknown_kind": unknown_kind})["alarm"]

        self.assertFalse(alarm("limit-cycle", ["unknown"], "period"))
        self.assertFalse(alarm("step", ["tug", "body-force"]))
        self.assertFalse(alarm("all", ["tug"]))
        self.assertTrue(alarm("limit-cycle", ["unknown"], "period", error=0.0))
        self.assertTrue(alarm("limit-cycle", ["unknown"], "states"))
        self.assertTrue(alarm("limit-cycle", ["tug"]))
        self.assertTrue(alarm("step", ["tug", "rudder-offset"]))
        self.assertTrue(alarm("gusts", ["unknown"], "period"))


class Instruments(unittest.TestCase):
    def test_a_pilot_steers_by_the_sensors(self):
        out = sailed("esso-osaka-3m", [{"kind": "straight", "heading_deg": 40.0}], 150.0, {"heading_bias_deg": np.array([6.0])})
        self.assertAlmostEqual(out["recorded"]["psi_deg"][0, -1], 40.0, delta=1.0)  # he believes to be on course
        self.assertAlmostEqual(out["true"]["psi_deg"][0, -1], 34.0, delta=1.0)

    def test_channels_are_quantized_late_and_scaled_as_the_faults_say(self):
        late = np.array([3.0])
        out = sailed("esso-osaka-3m", [{"kind": "zigzag", "rudder_deg": 20.0}], 80.0, {"heading_latency_s": late, "log_scale": np.array([0.1])}, gain=0.0)
        true, recorded = (out[k]["psi_deg"][0] for k in ("true", "recorded"))
        np.testing.assert_allclose(recorded[10:], true[7:-3], atol=0.3)  # a tenth of a degree, and the clock's jitter
        np.testing.assert_allclose(recorded * 10.0, np.round(recorded * 10.0), atol=1e-6)
        np.testing.assert_allclose(out["recorded"]["u_mps"], 1.1 * out["true"]["u_mps"], atol=0.008)

    def test_noise_of_positions_is_correlated(self):
        out = sailed("kvlcc2-full", [{"kind": "straight"}], 200.0, gain=1.0, dt=0.5)
        e = out["recorded"]["x0_m"][0] - out["true"]["x0_m"][0]
        self.assertGreater(np.corrcoef(e[:-1], e[1:])[0, 1], 0.25)  # white noise: sd 0.07


class Agreement(unittest.TestCase):
    @unittest.skipUnless((BIN / "mmg-sim").exists(), "mmg-sim is not built")
    def test_the_nominal_ship_is_the_given_one_to_a_fifth_and_another_one(self):
        for name in ("esso-osaka-3m", "vectwin-3m", "kvlcc2-full"):
            maneuvers = ({"kind": "turn", "rudder_deg": 35}, {"kind": "zigzag", "rudder_deg": 20, "turn_by_deg": 20})
            for maneuver, (own, theirs) in zip(maneuvers, agreement.both(BIN, name, maneuvers, 80)):
                with self.subTest(name, maneuver=maneuver["kind"]):
                    n = len(theirs["r_degps"])
                    off = np.sqrt(np.mean((own["r_degps"][:n] - theirs["r_degps"]) ** 2) / np.mean(theirs["r_degps"] ** 2))
                    self.assertTrue(0.005 < off < 0.2, off)


class Cases(unittest.TestCase):
    def test_a_set_follows_its_seed_and_has_all_kinds(self):
        some = cases.design("s", 100)
        self.assertEqual(some, cases.design("s", 100))
        self.assertNotEqual([c["names"] for c in some], [c["names"] for c in cases.design("t", 100)])
        self.assertEqual(len(some), 100)
        self.assertEqual({c["ship"] for c in some}, set(cases.SHIPS))
        self.assertEqual({c["error_kind"] for c in some}, set(weather.KINDS))
        self.assertTrue(all(0.1 <= c["sample_s"] <= 2.0 for c in some))
        for c in some:
            if c["ship"].startswith("kvlcc2"):
                self.assertEqual(c["wind"], "calm")

    def test_what_is_written_is_what_was_hidden(self):
        case = {**cases.design("s", 30, 30.0)[0], "names": ["log-scale"], "family": "single", "prime": 12.0, "ship": "esso-osaka-3m", "sample_s": 1.0, "wind": "calm",
                "campaign": "zigzag", "error": 0.0, "wrong": 0.0}
        fleet = cases.Fleet([case])
        out, found = fleet.make(0.1)
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            fleet.write(folder / "cases", folder / "keys", out, found)
            given, sealed = folder / "cases" / case["id"], folder / "keys" / case["id"]
            self.assertEqual({f.name for f in sealed.glob("*.csv")} - {f.name for f in given.glob("*.csv")}, {f"test-{k + 1}.csv" for k in range(campaign.TESTS)})
            recorded, true = (recording.read_csv(f / "train-1.csv") for f in (given, sealed))
            self.assertEqual([c for c in recorded if c.startswith("wind")], [])
            scale = fleet.plans[0]["log-scale"][1] * fleet.plans[0]["log-scale"][0]["sign"]
            self.assertAlmostEqual(float(np.mean(recorded["u_mps"] / true["u_mps"])) - 1.0, scale, delta=0.02)
            self.assertGreater(found[0]["log-scale"]["d_prime"], 3.0)


if __name__ == "__main__":
    unittest.main()
