#!/usr/bin/python3
"""Tests the oracle and the ladder of scripts/proof on linear cases that can be computed by hand, and against the generator."""

import hashlib
import itertools
import json
import math
import pathlib
import statistics
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts" / "proof"))

import bayes  # noqa: E402
import blame  # noqa: E402
import campaign  # noqa: E402
import filtered  # noqa: E402
import law  # noqa: E402
import model  # noqa: E402
import physics  # noqa: E402
import rungs  # noqa: E402
import scores  # noqa: E402
import sets  # noqa: E402

PHI = statistics.NormalDist().cdf
Z99 = statistics.NormalDist().inv_cdf(0.99)
NO_HIDING = bayes.Hiding(np.zeros((0, 8)), np.zeros((1, 0)))


def log_density(y, covariance):
    return -0.5 * (y @ np.linalg.solve(covariance, y) + np.linalg.slogdet(covariance)[1])


class ByHand(unittest.TestCase):
    def test_detection_of_a_simple_hypothesis_at_one_percent(self):
        rng = np.random.default_rng(1)
        for d in (1.0, 2.0, 3.0, 4.0):
            mu = np.zeros((1, 8))
            mu[0, 3] = d
            Y = rng.standard_normal((2 * 19999, 8)) + np.repeat([[0.0], [1.0]], 19999, 0) * mu
            Q, b = NO_HIDING.inner(mu, mu)[0], NO_HIDING.inner(mu, Y)[0]
            post = np.concatenate([np.zeros((1, len(Y))), bayes.log_bayes_factors(Q, b, np.eye(1))])
            odds = bayes.answers([(), ("a",)], post, (), 0.0)["odds"]
            limit = bayes.threshold(odds[:19999])
            got = bayes.answers([(), ("a",)], post[:, 19999:], ("a",), limit)
            self.assertAlmostEqual(np.mean(odds[:19999] > limit), 0.01, 3)
            self.assertAlmostEqual(np.mean(got["detected"]), PHI(d - Z99), delta=0.02)
            self.assertAlmostEqual(bayes.separation(np.mean(got["odds"])), d, delta=0.05)

    def test_naming_among_equal_orthogonal_classes(self):
        rng, d, m = np.random.default_rng(2), 2.5, 6
        mus = d * np.eye(m, 8)
        Y = mus[0] + rng.standard_normal((40000, 8))
        post = [np.full(len(Y), -50.0)] + [bayes.log_bayes_factors(*(x[0] for x in (NO_HIDING.inner(k, k), NO_HIDING.inner(k, Y))), np.eye(1))[0] for k in mus[:, None]]
        got = bayes.answers([()] + [(f"e{k}",) for k in range(m)], np.array(post), ("e0",), -np.inf)
        x = np.linspace(-6.0, 12.0, 4001)
        wanted = np.trapz(np.exp(-0.5 * (x - d) ** 2) / math.sqrt(2.0 * math.pi) * np.array([PHI(v) for v in x]) ** (m - 1), x)
        self.assertAlmostEqual(np.mean(got["first"]), wanted, delta=0.01)
        self.assertAlmostEqual(np.mean(got["set"]), wanted, delta=0.01)

    def test_what_only_multiplies_a_coefficient_is_told_by_priors_alone(self):
        """The table of spike and slab: nats at a well-known factor."""
        g = np.zeros((1, 8))
        g[0, 0] = 1e5  # as good as no noise
        for theta, s0, nats in ((-0.41, 0.05, 30.0), (-0.36, 0.10, 4.4), (0.41, 0.20, 0.7), (0.26, 0.10, 1.6)):
            hiding = bayes.Hiding(g, [[s0**2]])
            y = theta * g
            T = math.sqrt(sets.SLAB**2 - s0**2) * np.ones((1, 1, 1))
            got = bayes.log_bayes_factors(hiding.inner(g, g)[0], hiding.inner(g, y)[0], np.zeros((1, 1)), T)[0, 0]
            self.assertAlmostEqual(got, 0.5 * theta**2 * (s0**-2 - sets.SLAB**-2) - math.log(sets.SLAB / s0), 2)
            self.assertAlmostEqual(got, nats, delta=0.06 * nats + 0.05)

    def test_the_best_detection_saturates_however_small_the_noise(self):
        s0, rng, reached = 0.2, np.random.default_rng(3), []
        for size in (100.0, 1e3, 1e5):
            g = np.zeros((1, 8))
            g[0, 0] = size
            theta = np.concatenate([s0 * rng.standard_normal(9999), sets.SLAB * rng.standard_normal(20000)])
            Y = theta[:, None] * g + rng.standard_normal((len(theta), 8))
            hiding = bayes.Hiding(g, [[s0**2]])
            odds = bayes.log_bayes_factors(hiding.inner(g, g)[0], hiding.inner(g, Y)[0], np.zeros((1, 1)), math.sqrt(sets.SLAB**2 - s0**2) * np.ones((1, 1, 1)))[0]
            reached.append(np.mean(odds[9999:] > bayes.threshold(odds[:9999])))
        wanted = 2.0 * (1.0 - PHI(statistics.NormalDist().inv_cdf(0.995) * s0 / sets.SLAB))
        self.assertLess(wanted, 0.5)
        for share in reached:
            self.assertAlmostEqual(share, wanted, delta=0.03)

    def test_hiding_is_the_dense_gaussian_by_level(self):
        rng = np.random.default_rng(4)
        U, X, Y = rng.standard_normal((3, 12)), rng.standard_normal((2, 12)), rng.standard_normal((5, 12))
        variances = [[0.0, 0.0, 0.0], [1.0, 0.3, 100.0]]
        hiding = bayes.Hiding(U, variances)
        for k, v in enumerate(variances):
            S = np.eye(12) + U.T @ np.diag(v) @ U
            np.testing.assert_allclose(hiding.inner(X, Y)[k], X @ np.linalg.solve(S, Y.T), atol=1e-10)
            np.testing.assert_allclose(hiding.log_nothing(Y)[k], [log_density(y, S) for y in Y], atol=1e-9)

    def test_a_component_with_tangents_is_the_dense_gaussian(self):
        rng = np.random.default_rng(5)
        U, N, Y = rng.standard_normal((2, 10)), rng.standard_normal((4, 10)), rng.standard_normal((3, 10))
        hiding = bayes.Hiding(U, [[2.0, 0.5]])
        C, T = rng.standard_normal((2, 4)), rng.standard_normal((2, 2, 4))
        got = bayes.log_bayes_factors(hiding.inner(N, N)[0], hiding.inner(N, Y)[0], C, T)
        S = np.eye(10) + U.T @ np.diag([2.0, 0.5]) @ U
        for k in range(2):
            V = S + (T[k] @ N).T @ (T[k] @ N)
            np.testing.assert_allclose(got[k], [log_density(y - C[k] @ N, V) - log_density(y, S) for y in Y], atol=1e-9)

    def test_all_sets_are_the_dense_gaussians_over_the_common_scale(self):
        rng = np.random.default_rng(6)
        G, Y = rng.standard_normal((len(model.FACTORS), 40)), rng.standard_normal((2, 40))
        widths = {k: 0.1 for k in model.FACTORS}
        terms = [sets.Term("a", rng.standard_normal((2, 40)), -1.0), sets.Term("b", rng.standard_normal((1, 40)), -2.0),
                 sets.Term("thrust-loss", G[model.FACTORS.index("K_T")][None], -1.5, ("K_T",), (1.0,))]
        K, Z = rng.standard_normal((2, 30)), rng.standard_normal((1, 30))
        names, silent, post = sets.posterior(terms, Y, G, widths, [sets.Term("s", Z, -0.5)], K)
        self.assertEqual(len(names), len(set(names)))
        self.assertEqual(len(names), 15)  # 2^4 less the one of four
        self.assertEqual(sum(silent), 1)
        c, w = sets.scale_nodes()
        for n, row in zip(names, post):
            for j in range(2):
                value = []
                for x, weight in zip(c, w):
                    S = np.eye(40) + (0.1 * x) ** 2 * G.T @ G
                    for t in terms:
                        if t.name in n:
                            size = t.sizes({k: 0.1 * x for k in model.FACTORS})
                            S = S + (size[:, None] * t.columns).T @ (size[:, None] * t.columns)
                    value.append(math.log(weight) + log_density(Y[j], S))
                k = log_density(K[j], np.eye(30) + ("s" in n) * Z.T @ Z) - log_density(K[j], np.eye(30))
                prior = sum(t.log_prior for t in terms if t.name in n) - 0.5 * ("s" in n)
                self.assertAlmostEqual(row[j], np.logaddexp.reduce(value) + k + prior, 6)

    def test_the_rung_that_goals_are_shares_of_is_frozen(self):
        self.assertEqual((sets.SCALE_SD, sets.NODES, sets.SLAB, sets.LARGEST, sets.P_SENSORS, sets.P_EFFECTS), (0.5, 9, 0.6, 3, 0.15, 0.35))
        priors = hashlib.sha256(json.dumps([sets.SLABS, sets.PRIORS], sort_keys=True).encode()).hexdigest()
        self.assertEqual(priors[:16], "a152ad7424bec193", "efficiencies of earlier versions are shares of what these priors reach")

    def test_a_slab_with_bounds_is_the_integral_over_one_side(self):
        rng = np.random.default_rng(7)
        x, y = rng.standard_normal((1, 20)), 0.5 * rng.standard_normal((1, 20))
        for side in (-1, 1):
            term = sets.Term("a", x, 0.0, side=side)
            got = sets.evidences([term], [(), (0,)], [x @ x.T], [x @ y.T], np.zeros((1, 1)), [1.0], [{}])
            z = np.linspace(0.0, 8.0 * side, 40001)
            integrand = np.exp(-0.5 * z**2 + z * float(x @ y.T) - 0.5 * z**2 * float(x @ x.T)) / math.sqrt(2.0 * math.pi) * 2.0
            self.assertAlmostEqual(got[1, 0] - got[0, 0], math.log(abs(np.trapz(integrand, z))), 4)


def written(ship="esso-osaka-3m", names=("steady-current",), wind="measured", level=2, **more):
    """A short case as generate writes it: (group, case, key, track)."""
    case = {"id": "t-000", "family": "single", "names": list(names), "level": level, "seed": 77, "prime": 12.0 if names else None, "wrong": 0.1, "error": 5e-4,
            "noise": "paper", "ship": ship, "campaign": "mixed", "wind": wind, "duration_s": 80.0, "trains": 2, "sample_s": 1.0, **more}
    group = campaign.Group([case])
    track, found = group.make(0.1)
    with tempfile.TemporaryDirectory() as folder:
        at = pathlib.Path(folder)
        group.write(at / "cases", at / "keys", track, found)
        key = json.loads((at / "keys" / "t-000.json").read_text(encoding="utf-8"))
        given = json.loads((at / "cases" / "t-000" / "ship.json").read_text(encoding="utf-8"))
        with np.load(at / "keys" / "t-000" / "track.npz") as kept:
            scene = law.Scene(key, kept)
            return group, track, key, given, scene, {k: kept[k] for k in kept.files}


class Kept(dict):
    """Arrays of a track file, once it is closed."""

    files = property(lambda self: list(self))


class Law(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.group, cls.track, cls.key, cls.given, cls.scene, cls.arrays = written()

    def test_changes_are_the_generators(self):
        rng = np.random.default_rng(1)
        reach = {**{k: self.track[k] for k in ("x", "y", "psi")}, "duration": 80.0}
        for name in ("steady-current", "tug", "mooring", "wave-drift", "actuator-lag", "anemometer", "windage", "fouling", "shallow-water", "earth-force", "ice-drag"):
            with self.subTest(name):
                effect = physics.ALL[name]
                shape = {**effect.draw(rng, self.scene.ship, reach), "level": 2}
                if "slack" in shape:
                    shape["slack"] = [0.0] * 6
                wanted = self.group.change(0, self.track, name, 0.4 * effect.most, shape, range(2))
                got = self.scene.change(name, 2, [(shape, 0.4 * effect.most)], self.key["forms"])[0]
                for r in range(2):
                    np.testing.assert_allclose(got[:, r], wanted[r], rtol=1e-6, atol=1e-9 * (1.0 + np.max(np.abs(wanted[r]))))
                self.assertGreater(np.max(np.abs(got)), 0.0)

    def test_strengths_are_those_of_the_wanted_separation(self):
        for name in ("steady-current", "rudder-offset", "heading-bias"):
            deck = law.Deck(self.scene, name, campaign.PRIMES, (2,))
            d = self.scene.primes(name, self.scene.change(name, 2, deck.plans))
            wanted = np.tile(campaign.PRIMES, len(d) // 4)
            free = np.array([s < 0.99 * physics.ALL[name].most for _, s in deck.plans])
            self.assertTrue(free.any())
            np.testing.assert_allclose(np.log(d[free] / wanted[free]), 0.0, atol=0.35)

    def test_structure_is_what_members_of_the_forms_differ_by(self):
        self.assertEqual(np.shape(self.scene.structure())[0], len(model.FORMS))
        small = {k: c + 0.1 * sd * z for (k, (c, sd)), z in zip(model.FORMS.items(), self.scene.own_structure())}
        change = (self.scene.accelerations(2, forms=small) - self.scene.accelerations(2))[0]
        linear = np.tensordot(0.1 * self.scene.own_structure(), self.scene.structure(), 1)
        self.assertLess(np.std(change - linear), 0.2 * np.std(change))  # kinks, and terms beyond the linear ones

    def test_the_file_states_what_is_drawn(self):
        self.assertAlmostEqual(self.given["uncertainty"]["hull.Y_v"], campaign.STATED * model.PRIOR["Y_v"], 4)
        drawn = []
        for seed in range(200):
            for wrong in campaign.LEVELS["wrong"]:
                f = campaign.Group._factors(self.group, {"seed": seed, "wrong": wrong})
                drawn += [math.log(f[k]) / model.PRIOR[k] for k in model.FACTORS]
        self.assertAlmostEqual(np.std(drawn), campaign.STATED, delta=0.03)
        off = [campaign.Group._factors(self.group, {"seed": s, "wrong": 0.0, "misstated": "one"}) for s in range(20)]
        for f in off:
            moved = {k: abs(math.log(v)) / (campaign.STATED * model.PRIOR[k]) for k, v in f.items() if v != 1.0}
            self.assertEqual([round(x, 6) for x in moved.values()], [campaign.MISSTATED_ONE])

    def test_a_ladder_of_a_clear_effect(self):
        out = rungs.compute(self.key, Kept(self.arrays))
        for rung in blame.COMPUTED:
            self.assertGreater(out[rung]["own"]["detected"], 0.8, rung)
        self.assertGreater(out["truth"]["own"]["first"], 0.8)


class InverseCrime(unittest.TestCase):
    def test_at_level_1_the_forms_are_the_tools(self):
        key, scene, arrays = (written(names=("ice-drag",), level=1, prime=30.0)[k] for k in (2, 4, 5))
        self.assertEqual(scene.structure().shape[0], 0)
        np.testing.assert_array_equal(scene.lack, 0.0)
        bench = rungs.Bench(key, Kept(arrays))
        Y, K, parts = bench.data(np.random.default_rng(1), 199, 0, 40)
        for by_kind in (False, True):
            got = rungs.summary(*bench.generating_law(Y, K, 1, scene.truths_S, by_kind), parts, (law.UNKNOWN,))
            self.assertGreater(got["own"]["detected"], 0.5)
        # what is dropped is noise alone
        self.assertLess(bench.kept.size, scene.white(scene.lack, scene.truths_S).shape[1])


class Forces(unittest.TestCase):
    def test_forces_from_outside_add_to_all_others(self):
        scene = written("vectwin-3m", (), "measured")[4]
        for effects in ({"hs": 0.03, "wave_from": 1.0}, {"tug": 1.0, "tug_dir": 0.4, "tug_x": 1.0, "tug_start": 5.0, "tug_end": 40.0}, {"ice": 0.005}, {"earth_X": 2.0}):
            e = {k: np.array([[v]]) for k, v in effects.items()}
            whole = scene.accelerations(2, e) - scene.accelerations(2)
            np.testing.assert_allclose(scene.accelerations(2, e, raw=True), whole, atol=1e-12)


class Blame(unittest.TestCase):
    @staticmethod
    def case(computed, fitted, ranked, chosen):
        tool = {r: {"detected": x, "first": x} for r, x in (("fitted", fitted), ("ranked", ranked), ("chosen", chosen))}
        return {"names": ["fouling"], "tool": tool, "rungs": {r: {"own": {"detected": p, "first": p}} for r, p in zip(blame.COMPUTED, computed)}}

    def test_a_miss_is_blamed_on_the_first_rung_that_loses_it(self):
        self.assertEqual(blame.lost_at(self.case((0.9, 0.8, 0.3, 0.9), 1.0, 0.0, 0.0), "first"), "priors")
        self.assertEqual(blame.lost_at(self.case((0.4, 0.8, 0.3, 0.9), 1.0, 1.0, 0.0), "first"), "truth")
        self.assertEqual(blame.lost_at(self.case((0.9, 0.9, 0.9, 0.9), 1.0, 1.0, 0.0), "first"), "chosen")
        self.assertEqual(blame.lost_at(self.case((0.9, 0.9, 0.9, 0.9), 0.0, 0.0, 0.0), "first"), "fitted")
        self.assertIsNone(blame.lost_at(self.case((0.1, 0.1, 0.1, 0.1), 1.0, 1.0, 1.0), "first"))

    def test_efficiency_is_right_answers_over_what_exact_inference_reaches(self):
        cases = [self.case((1.0, 1.0, 0.8, 0.8), 1.0, 1.0, float(k < 6)) for k in range(10)]
        right, reach, ratio, low, high = blame.efficiency(cases, "detected")
        self.assertEqual(right, 6.0)
        self.assertAlmostEqual(reach, 8.0)
        self.assertAlmostEqual(ratio, 0.75)
        self.assertTrue(low < 0.6 and 0.9 < high, (low, high))
        # Where all are right, the others may still not be.
        one = blame.efficiency([self.case((1.0, 1.0, 1.0, 1.0), 1.0, 1.0, 1.0)], "detected")
        self.assertAlmostEqual(one[3], scores.wilson(1, 1)[0])

    def test_rungs_of_the_tool_follow_from_its_report(self):
        key = {"names": ["steady-current", "rudder-offset"]}
        report = {"verdict": "mismatch", "chosen": ["steady-current"], "hypotheses": [{"name": "steady-current", "effects": ["steady-current"], "probability": 0.6},
                  {"name": "steady-current + rudder-offset", "effects": ["steady-current", "rudder-offset"], "probability": 0.3}]}
        got = blame.said(key, report)
        self.assertEqual([got[r]["both"] for r in ("fitted", "ranked", "chosen")], [1.0, 0.0, 0.0])
        self.assertEqual([got[r]["first"] for r in ("fitted", "ranked", "chosen")], [1.0, 1.0, 1.0])
        wrong = blame.said({"names": ["fouling"]}, report)
        self.assertEqual([wrong["fitted"]["first"], wrong["chosen"]["detected"]], [0.0, 0.0])
        outside = blame.said({"names": ["ice-drag"]}, {"verdict": "mismatch", "chosen": ["unknown"], "hypotheses": []})
        self.assertEqual(outside["chosen"]["first"], 1.0)

    def test_rungs_of_the_tool_count_as_the_page_does(self):
        cases = {("a", "c"): 0.0, ("c", "unknown"): 0.0, ("unknown",): 1.0, ("a",): 1.0, (): 0.0}  # detected, where a acts; () is a mismatch without a name
        for chosen, detected in cases.items():
            report = {"verdict": "mismatch", "chosen": list(chosen), "hypotheses": []}
            self.assertEqual(blame.said({"names": ["a"]}, report)["chosen"]["detected"], detected, chosen)
            self.assertEqual(scores.outcome(report, ["a"]) in scores.DETECTED, bool(detected), chosen)
        said = lambda *chosen: blame.said({"names": ["a", "b"]}, {"verdict": "mismatch", "chosen": list(chosen), "hypotheses": []})["chosen"]
        self.assertEqual([said("a", "b")["both"], said("b", "a", "unknown")["both"], said("a", "b", "c")["both"]], [1.0, 1.0, 0.0])
        self.assertEqual(said("unknown", "a")["first"], 1.0)
        with_name = blame.said({"names": ["ice-drag"]}, {"verdict": "mismatch", "chosen": ["unknown", "tug"], "hypotheses": []})
        self.assertEqual(with_name["chosen"]["detected"], 0.0)

    def test_where_nothing_is_missing_a_name_is_an_alarm(self):
        for report, alarm in (({"verdict": "mismatch", "chosen": ["tug"]}, 1.0), ({"verdict": "mismatch", "chosen": []}, 1.0), ({"verdict": "undecided", "chosen": []}, 0.0)):
            got = blame.said({"names": []}, {**report, "hypotheses": []})["chosen"]
            self.assertEqual([got["detected"], got["first"]], [alarm, 0.0], report)

    def test_sets_hold_no_coefficient_twice(self):
        terms = sets.slab_terms(np.ones((len(model.FACTORS), 3)), ["fouling", "thrust-loss"], -2.0)
        names = {t.name for t in terms}
        self.assertTrue({"fouling", "thrust-loss", "coefficient:X_0", "coefficient:K_T", "coefficient:Y_v"} <= names)
        for some in sets.sets_of(terms, 2):
            used = list(itertools.chain(*(terms[i].coefficients for i in some)))
            self.assertEqual(len(used), len(set(used)))


class Feedback(unittest.TestCase):
    N, SD, ERROR = 30, np.array([0.03, 0.03, 0.002, 0.01, 0.01, 0.002]), np.array([1e-4, 2e-4, 1e-5])

    def seen(self, columns, derivatives, n=N, error=ERROR):
        t = np.arange(n, dtype=float)
        track = {"t": t, "psi": 0.02 * t, "u": np.full(n, 0.5), "v": 0.05 * np.sin(0.1 * t)}
        return track, filtered.innovations(track, np.broadcast_to(derivatives, (n, 3, 6)), columns, self.SD, error, 12.0)

    def test_innovations_have_the_energy_that_the_covariance_says(self):
        rng, n = np.random.default_rng(3), self.N
        derivatives = np.hstack([np.zeros((3, 3)), [[-0.05, 0.0, 0.01], [0.0, -0.2, -0.3], [0.0, 0.1, -0.3]]])
        columns = rng.standard_normal((2, 3, n)) * 1e-3
        track, white = self.seen(columns, derivatives)
        E, begin, end = filtered.transitions(track, np.broadcast_to(derivatives, (n, 3, 6)))
        by_start, by_acceleration = [np.eye(6)], [np.zeros((6, 3 * n))]
        for k in range(n - 1):
            by_start.append(E[k] @ by_start[-1])
            new = E[k] @ by_acceleration[-1]
            new[:, 3 * k:3 * k + 3] += begin[k]
            new[:, 3 * k + 3:3 * k + 6] += end[k]
            by_acceleration.append(new)
        start, response = np.concatenate(by_start), np.concatenate(by_acceleration)
        kept = math.exp(-1.0 / 12.0) ** np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
        covariance = np.kron(np.eye(n), np.diag(self.SD**2)) + 1e4 * start @ np.diag(self.SD**2) @ start.T + response @ np.kron(kept, np.diag(self.ERROR**2)) @ response.T
        read = response @ np.moveaxis(columns, 1, 2).reshape(2, -1).T
        np.testing.assert_allclose(white @ white.T, read.T @ np.linalg.solve(covariance, read), rtol=1e-6)

    def test_what_is_damped_shows_less(self):
        n, steady = 241, np.zeros((1, 3, 241))
        steady[0, 2] = 1e-5
        damped = np.zeros((3, 6))
        damped[2, 5] = -0.3
        free, held = (np.linalg.norm(self.seen(steady, J, n, np.full(3, 1e-9))[1]) for J in (np.zeros((3, 6)), damped))
        self.assertLess(held, 0.2 * free)


if __name__ == "__main__":
    unittest.main()
