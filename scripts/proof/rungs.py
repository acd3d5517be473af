"""The ladder from what could be known of a case to what the tool said of it, one rung a computation on the same data.

    truth      the truth's forms with the generating law: P*, what nobody can surpass
    forms      the tool's forms (level 1, what they lack as random model error) with that law
    priors     the tool's forms with its priors, exact inference (sets.py; frozen): what efficiencies are measured against
    noise      the same, the size of the model error estimated
    fitted     what the tool fitted at all          } from report.json
    ranked     what its probabilities rank first    }
    chosen     what its rule of decision chose      }

Data are drawn: `law` with coefficients and forms of the law (this effect, shape, strength, and how wrong the case's coefficients are), `own` with those of
the case; noise is drawn in both. Alarms at 1 % on nulls of the law, of this track and noise. Functions: compute(key, track) -> rungs. Those of the tool: blame.said.
"""

import math
import pathlib

import numpy as np

import bayes
import campaign
import law
import model as m
import physics
import sets
import tool

QUESTIONS = ("detected", "first", "set", "accepted", "both")
RUNGS = ("truth", "forms", "priors", "noise", "fitted", "ranked", "chosen")
NULLS, LAW, OWN = 399, 200, 100  # data of the first two rungs
NULLS_EXACT, OWN_EXACT = 199, 40
SIZES = (1.0, 5.0)  # of an unknown thing, mm/s^2
LEVELS_OF_ERROR = (1.0 / 4.0, 1.0 / 2.0, 1.0, 2.0, 4.0)  # of the variance of the tool's model error, where it is estimated


def truth_names(key):
    """Names as answers give them: what is out of the catalogue is `unknown`."""
    return tuple(law.UNKNOWN if n in physics.OUTSIDE else n for n in key["names"])


def unknown_kinds(scene):
    """What one can say of a thing without a name: a force that depends on place, on time with a period, on the past, on states; by kind a list of
    alternatives, each (columns, 3, recordings, samples) of accelerations at 1 mm/s^2 (rms) in all."""
    rng = np.random.default_rng(campaign.seed_of("kinds", scene.key["id"]))
    s, R, n, L, T = scene.states, scene.R, scene.n, scene.L, scene.T
    shape = lambda a: np.asarray(a).reshape(R, n)
    cos, sin, t = shape(np.cos(s["psi"])), shape(np.sin(s["psi"])), shape(s["t"])
    arm = 1.0 / (0.25 * L)

    def columns(rows):
        a = np.stack(rows)
        size = np.sqrt(np.mean(np.sum((a * np.array([1.0, 1.0, 0.25 * L])[:, None, None]) ** 2, 1), (1, 2)))
        keep = size > 1e-9
        return 1e-3 * a[keep] / size[keep][:, None, None, None] / math.sqrt(max(keep.sum(), 1))

    zero = np.zeros((R, n))
    axes = lambda x: [np.stack([x, zero, zero]), np.stack([zero, x, zero]), np.stack([zero, zero, x * arm])]
    place = []
    for _ in range(8):
        kx, ky, phase = rng.normal(0.0, 1.0 / (3.0 * L)), rng.normal(0.0, 1.0 / (3.0 * L)), rng.uniform(0.0, 2.0 * math.pi)
        f = np.cos(kx * shape(s["x"]) + ky * shape(s["y"]) + phase)
        place += [np.stack([f * cos, -f * sin, zero]), np.stack([f * sin, f * cos, zero])]
    periods = []
    for period in np.geomspace(12.0, 80.0, 12) * T:
        rows = []
        for f in (np.sin, np.cos):
            rows += axes(f(2.0 * math.pi * t / period))
        periods.append(columns(rows))
    u, v, r = (shape(s[k]) for k in ("u", "v", "r"))
    memory = []
    for x in (np.abs(r), r, u * r, np.abs(v)):
        for tau in (8.0 * T, 30.0 * T):
            a, y = math.exp(-(t[0, 1] - t[0, 0]) / tau), np.empty_like(x)
            y[:, 0] = x[:, 0]
            for k in range(1, n):
                y[:, k] = a * y[:, k - 1] + (1.0 - a) * x[:, k]
            memory += axes(y)
    sign = lambda x, w: np.tanh(x / w)
    states = [np.stack([f, zero, zero]) for f in (u, u * u, np.sqrt(np.hypot(u, v)), v * v, r * r, np.abs(r))]
    for f in (v, r, v * np.abs(v), r * np.abs(r), u * v, u * r, sign(r * T, 0.01), v * np.abs(r)):
        states += [np.stack([zero, f, zero]), np.stack([zero, zero, f * arm])]
    return {"place": [columns(place)], "period": periods, "memory": [columns(memory)], "states": [columns(states)]}


class Bench:
    """A scene with its decks, and whitened data; `ratio` turns numbers that are white for the truth into those of another spectrum."""

    def __init__(self, key, track):
        self.key, self.scene = key, law.Scene(key, track)
        scene = self.scene
        self.levels = tuple(sorted({1, scene.level}))
        self.weights = {n: w * 40.0 for n in (*physics.EFFECTS, *physics.SENSORS, "convention") if (w := scene.eligible(n)) > 0.0}
        self.outside = {n: w * 25.0 for n in physics.OUTSIDE if (w := scene.eligible(n)) > 0.0}
        truth = key["truth"]
        self.decks = {n: law.Deck(scene, n, campaign.PRIMES, self.levels, truth.get(n)) for n in self.weights}
        self.decks.update({n: law.Deck(scene, n, (30.0,), (scene.level,), truth.get(n)) for n in self.outside})
        self.pairs = {p: 30.0 if p in campaign.PAIRS else 20.0 for p in (*campaign.PAIRS, *campaign.DECOYS) if set(p) <= set(self.weights)}
        if len(key["names"]) == 2 and tuple(key["names"]) not in self.pairs and set(key["names"]) <= set(self.weights):
            self.pairs[tuple(key["names"])] = 30.0
        white = lambda a: scene.white(a, scene.truths_S)
        for deck in self.decks.values():
            deck.nodes = {level: scene.white(a, scene.kin_S) if deck.is_sensor else white(a) for level, a in deck.nodes.items()}
        self.kinds = {kind: [white(a) for a in alternatives] for kind, alternatives in unknown_kinds(scene).items()}
        self.gradients = {level: white(a) for level, a in scene.gradients.items()}
        self.freed, self.structure, self.lack = white(scene.freed()), white(scene.structure()), white(scene.lack)
        self._truth_change()
        self._drop_what_says_nothing()


    def _drop_what_says_nothing(self, energy=0.005):
        """Leaves out numbers (high frequencies above all) in which everything together has less than this energy (d'^2)."""
        blocks = {True: [d for d in self.decks.values() if d.is_sensor], False: [d for d in self.decks.values() if not d.is_sensor]}
        sd = np.array([1.4 * m.PRIOR[k] for k in m.FACTORS])[:, None]
        others = {True: [self.residual], False: [self.acceleration, self.lack, self.freed, self.structure, *(sd * g for g in self.gradients.values()),
                                                 *(SIZES[-1] * a for alternatives in self.kinds.values() for a in alternatives)]}
        keep = {}
        for is_sensor, decks in blocks.items():
            top = np.max([np.max(a * a, 0) for a in (*others[is_sensor], *(n for d in decks for n in d.nodes.values())) if len(a)], 0)
            order = np.argsort(top)
            keep[is_sensor] = np.sort(order[np.cumsum(top[order]) > energy])
            for d in decks:
                d.nodes = {level: n[:, keep[is_sensor]] for level, n in d.nodes.items()}
        at = self.kept = keep[False]
        self.gradients = {level: g[:, at] for level, g in self.gradients.items()}
        self.freed, self.structure, self.lack, self.acceleration = (a[:, at] for a in (self.freed, self.structure, self.lack, self.acceleration))
        self.kinds = {kind: [a[:, at] for a in alternatives] for kind, alternatives in self.kinds.items()}
        self.residual = self.residual[:, keep[True]]

    def _truth_change(self):
        """What the case's own effects change, in the truth's forms: (accelerations, kinematic residuals)."""
        scene, key = self.scene, self.key
        forms = key["forms"] or None
        a, k = np.zeros((3, scene.R, scene.n)), np.zeros((3, scene.R, scene.n))
        for name in key["names"]:
            t = key["truth"][name]
            if name == "unmeasured-wind":  # with its gusts
                shape = (1, scene.R * scene.n)
                wind = tuple(scene.track[w][:scene.R].reshape(shape) for w in ("wx", "wy"))
                a += (scene.accelerations(scene.level, wind=wind, forms=forms) - scene.accelerations(scene.level, forms=forms))[0]
            else:
                change = scene.change(name, scene.level, [(t["shape"], t["strength"])], forms)[0]
                if name in physics.SENSORS:
                    k += change
                else:
                    a += change
        self.acceleration, self.residual = scene.white(a[None], scene.truths_S), scene.white(k[None], scene.kin_S)

    def ratio(self, S):
        layout = lambda x: np.tile(np.concatenate([x, x]), self.scene.R)
        return np.concatenate([layout(np.sqrt(s / other)) for s, other in zip(self.scene.truths_S, S)])[self.kept]

    def data(self, rng, nulls, by_law, own):
        """White accelerations and kinematic residuals of all data, and slices of the kinds."""
        key = self.key
        G, S = self.gradients[self.scene.level], self.structure
        sd = np.array([m.PRIOR[k] / 0.15 for k in m.FACTORS])
        wrong = np.concatenate([rng.choice(campaign.LEVELS["wrong"], nulls), np.full(by_law, key["wrong"])])
        theta = wrong[:, None] * sd * rng.standard_normal((nulls + by_law, len(sd)))
        theta = np.concatenate([theta, np.tile(np.log([key["factors"][k] for k in m.FACTORS]), (own, 1))])
        z = np.concatenate([rng.standard_normal((nulls + by_law, len(S))), np.tile(self.scene.own_structure(), (own, 1))])
        acts = np.concatenate([np.zeros(nulls), np.ones(by_law + own)])[:, None]
        Y = theta @ G + z @ S + acts * self.acceleration + rng.standard_normal((len(acts), G.shape[1]))
        K = acts * self.residual + rng.standard_normal((len(acts), self.residual.shape[1]))
        return Y, K, {"nulls": slice(0, nulls), "law": slice(nulls, nulls + by_law), "own": slice(nulls + by_law, None)}

    # --- rungs 1 and 2 -----------------------------------------------------------------------------------------------
    def generating_law(self, Y, K, level, S, by_kind=False):
        """Posterior over the classes of the law, in the forms of a level: (names, which are silent, ln p (classes, data)).
        by_kind: of what is out of the catalogue only the kind is known, as it must be in the tool's forms."""
        scene, ratio = self.scene, self.ratio(S)
        own_forms = level == scene.level and S is scene.truths_S
        if not own_forms:
            Y = (Y + self.lack) * ratio
        U = np.concatenate([self.gradients[level], self.structure]) if own_forms else np.concatenate([self.gradients[level], self.freed]) * ratio
        extra = [1.0] * (len(U) - len(m.FACTORS))
        hiding = bayes.Hiding(U, [[(w * m.PRIOR[k] / 0.15) ** 2 for k in m.FACTORS] + extra for w in campaign.LEVELS["wrong"]])
        prior_of_level = -math.log(len(campaign.LEVELS["wrong"]))
        nothing = hiding.log_nothing(Y) + prior_of_level
        UY = Y @ hiding.basis.T
        # Nothing is as probable as all that may act: odds then are those of the data.
        everything = sum(self.weights.values()) + sum(self.pairs.values()) + sum(self.outside.values())
        names, post = [()], [bayes.log_sum(nothing, 0) + math.log(everything)]

        def products(N, is_sensor):
            if is_sensor:
                return [(N @ N.T, N @ K.T)]
            N = N * ratio
            left, gram, along = N @ hiding.basis.T, N @ N.T, N @ Y.T
            return [(gram - left @ k @ left.T, along - left @ k @ UY.T) for k in hiding.kernels]

        def add(name, weight, factors, is_sensor):
            """factors: ln Bayes factor of the class by level of coefficients (one for a sensor)."""
            joint = nothing + (factors[0] if is_sensor else np.array(factors))
            names.append(name)
            post.append(bayes.log_sum(joint, 0) + math.log(weight))

        kept = {}
        for name, weight in self.weights.items():
            deck = self.decks[name]
            inner = products(deck.nodes[level], deck.is_sensor)
            if any(name in p for p in self.pairs):
                kept[name] = inner
            add((name,), weight, [bayes.mixture(bayes.log_bayes_factors(Q, b, deck.C, deck.T), deck.weights) for Q, b in inner], deck.is_sensor)
        for (one, other), weight in self.pairs.items():
            a, b = self.decks[one], self.decks[other]
            if a.is_sensor or b.is_sensor:
                parts = [[bayes.mixture(bayes.log_bayes_factors(Q, x, d.C[i], d.T[i]), d.weights[i] / d.weights[i].sum()) for Q, x in kept[d.name]]
                         for d, i in ((a, twelves(a)), (b, twelves(b)))]
                force = parts[1] if a.is_sensor else parts[0]
                sensor = parts[0][0] if a.is_sensor else parts[1][0]
                add((one, other), weight, [f + sensor for f in force], False)
                continue
            both = products(np.concatenate([a.nodes[level], b.nodes[level]]), False)
            C, T, weights = product(a, b)
            add((one, other), weight, [bayes.mixture(bayes.log_bayes_factors(Q, x, C, T), weights) for Q, x in both], False)
        if own_forms and not by_kind:
            for name, weight in self.outside.items():
                deck = self.decks[name]
                add((law.UNKNOWN,), weight, [bayes.mixture(bayes.log_bayes_factors(Q, b, deck.C, deck.T), deck.weights)
                                             for Q, b in products(deck.nodes[level], False)], False)
        else:  # kinds of things
            total = sum(self.outside.values())
            for alternatives in self.kinds.values():
                factors = []
                for raw in alternatives:
                    inner = products(raw, False)
                    n = len(raw)
                    factors.append([bayes.mixture(np.concatenate([bayes.log_bayes_factors(Q, b, np.zeros((1, n)), size * np.eye(n)[None]) for size in SIZES]),
                                                  np.full(len(SIZES), 1.0 / len(SIZES))) for Q, b in inner])
                add((law.UNKNOWN,), total / len(self.kinds), bayes.log_sum(np.array(factors), 0) - math.log(len(alternatives)), False)
        return sets.merged(names, np.stack(post))

    # --- rungs 3 and 4 -----------------------------------------------------------------------------------------------
    def terms(self, S):
        """Terms of the tool's forms for accelerations and for kinematic residuals."""
        ratio = self.ratio(S)
        prior = sets.log_priors(list(self.weights))
        gradients = self.gradients[1] * ratio
        terms = sets.slab_terms(gradients, list(self.weights), prior[next(n for n in prior if n in physics.EFFECTS)])
        kinematic = []
        for name in self.weights:
            if name in sets.SLABS:
                continue
            deck, truth = self.decks[name], self.key["truth"].get(name)
            scaled = lambda k, p: deck.nodes[1][k] * (sets.PRIORS[name] / max(p[1], 1e-9)) ** max(deck.slopes[k], 0.5)
            P = len(deck.primes)
            mass, columns = 0.0, None
            if truth is not None and name in law.DRAWN:  # its own shape, with the prior mass of shapes about it
                K = len(deck.plans)
                own = deck.nodes[1][K:]
                slope = float(np.median(deck.slopes))
                columns = [own[0] * (sets.PRIORS[name] / max(truth["strength"], 1e-9)) ** max(slope, 0.5)]
                columns += [x - own[0] for x in own[1:]]
                mass = math.log(max(law.near(name, truth["shape"], self.scene)[1], 1e-12))
            elif deck.ring > 1:  # two directions at right angles
                at = [2 % P, (deck.ring // 4) * P + 2 % P]
                columns = [scaled(k, deck.plans[k]) for k in at]
            else:
                k = 2 % P if truth is None else int(np.argmin([abs(math.log(max(s, 1e-9) / max(truth["strength"], 1e-9))) + (10.0 if sh != truth["shape"] and len(
                    deck.plans) > P and sh.get("sign") != truth["shape"].get("sign") else 0.0) for sh, s in deck.plans]))
                columns = [scaled(k, deck.plans[k]) if name != "convention" else deck.nodes[1][0]]
            raw = np.stack(columns)
            if deck.is_sensor:
                kinematic.append(sets.Term(name, raw, prior[name] + mass))
            else:
                terms.append(sets.Term(name, raw * ratio, prior[name] + mass))
        p = prior[next(n for n in prior if n in physics.EFFECTS)]
        for alternatives in self.kinds.values():
            for raw in alternatives:
                for size in SIZES:
                    terms.append(sets.Term(law.UNKNOWN, size * raw * ratio, p - math.log(len(self.kinds) * len(SIZES) * len(alternatives)), alone=True))
        return terms, kinematic, gradients

    def exact(self, Y, K, S, largest):
        Y = (Y + self.lack) * self.ratio(S)
        terms, kinematic, gradients = self.terms(S)
        widths = {k: campaign.STATED * m.PRIOR[k] for k in m.FACTORS}
        return sets.posterior(terms, Y, np.concatenate([gradients, self.freed * self.ratio(S)]), widths, kinematic, K, largest)

    def level_of_error(self, Y, K):
        """Index of the likeliest size of the model error for each datum, over nothing and all single terms."""
        best = []
        for factor in LEVELS_OF_ERROR:
            S = self.spectrum(factor)
            post = self.exact(Y, K, S, 1)[2]
            jacobian = float(np.sum(np.log(self.ratio(S))))
            best.append(np.max(post, 0) + jacobian)
        return np.argmax(best, 0)

    def spectrum(self, factor):
        scene = self.scene
        return [measured + factor * (tools - measured) for measured, tools in zip(scene.measured_S, scene.tools_S)]


def twelves(deck):
    """Components of a class at d' = 12, as pairs are made, and the cell of the truth."""
    P = len(deck.primes)
    base = len(deck.plans)
    return np.array([k for k in range(base) if k % P == P // 2] + list(range(base, len(deck.C))))


def product(a, b, most=72):
    """Components of two classes that act together."""
    i, j = twelves(a), twelves(b)
    pairs = [(x, y) for x in i for y in j]
    weights = np.array([a.weights[x] * b.weights[y] for x, y in pairs])
    if len(pairs) > most:  # evenly, but never without the truth's own
        own = [k for k, (x, y) in enumerate(pairs) if x >= len(a.plans) or y >= len(b.plans)]
        keep = np.unique(np.concatenate([np.linspace(0, len(pairs) - 1, most).astype(int), np.array(own, int)]))
        pairs, weights = [pairs[k] for k in keep], weights[keep]
    x, y = (np.array(k) for k in zip(*pairs))
    na, nb = a.C.shape[1], b.C.shape[1]
    C = np.hstack([a.C[x], b.C[y]])
    T = np.concatenate([np.pad(a.T[x], ((0, 0), (0, 0), (0, nb))), np.pad(b.T[y], ((0, 0), (0, 0), (na, 0)))], 1)
    return C, T, weights / weights.sum()


def summary(names, silent, post, parts, truth):
    """Shares of right answers of law and own data, with the limit that lets 1 % of the nulls alarm."""
    odds = bayes.answers(names, post[:, parts["nulls"]], (), 0.0, silent)["odds"]
    limit = bayes.threshold(odds)
    out = {"nulls": len(odds), "limit": limit}
    for kind in ("law", "own"):
        some = post[:, parts[kind]]
        if not some.shape[1]:
            continue
        got = bayes.answers(names, some, truth, limit, silent)
        n = some.shape[1]
        out[kind] = {"n": n, "nats_detected": float(np.mean(got["odds"]))}
        if "lead" in got:
            out[kind]["nats_named"] = float(np.mean(np.clip(got["lead"], -1e3, 1e3)))
        out[kind].update({q: float(np.mean(got[q])) for q in QUESTIONS if q in got})
        out[kind]["se"] = {q: math.sqrt(max(out[kind][q] * (1.0 - out[kind][q]), 0.25 / n) / n) for q in QUESTIONS if q in out[kind]}
    return out


def second_given_first(names, post, truth):
    """Nats by which both of a pair lead the better of the two alone, mean."""
    place = {frozenset(n): k for k, n in enumerate(names)}
    both = place.get(frozenset(truth))
    if both is None:
        return None
    alone = [post[place[frozenset([n])]] for n in truth if frozenset([n]) in place]
    return float(np.mean(post[both] - np.max(alone, 0))) if alone else None


def compute(key, track):
    """The computed rungs of a case."""
    bench = Bench(key, track)
    scene, truth = bench.scene, truth_names(key)
    rng = np.random.default_rng(campaign.seed_of("ladder", key["id"], key["seed"]))
    Y, K, parts = bench.data(rng, NULLS, LAW, OWN)
    out = {}
    names, silent, post = bench.generating_law(Y, K, scene.level, scene.truths_S)
    out["truth"] = summary(names, silent, post, parts, truth)
    if len(truth) == 2:
        out["truth"]["nats_second"] = second_given_first(names, post[:, parts["law"]], truth)
    if law.UNKNOWN in truth:  # what can be told of it by somebody who knows no more than kinds of things
        out["kinds"] = summary(*bench.generating_law(Y, K, scene.level, scene.truths_S, by_kind=True), parts, truth)
    names, silent, post = bench.generating_law(Y, K, 1, scene.tools_S)
    out["forms"] = summary(names, silent, post, parts, truth)
    few = {"nulls": slice(0, NULLS_EXACT), "law": slice(0, 0), "own": slice(NULLS_EXACT, NULLS_EXACT + OWN_EXACT)}
    own = parts["own"].start
    pick = np.r_[0:NULLS_EXACT, own:own + OWN_EXACT]
    Y, K = Y[pick], K[pick]
    # A third effect adds next to nothing to what nulls say, whose threshold is asked here.
    names, silent, post = exact_on(bench, Y, K, scene.tools_S)
    out["priors"] = summary(names, silent, post, few, truth)
    level = bench.level_of_error(Y, K)
    whole = np.full(post.shape, -np.inf)
    place = {n: k for k, n in enumerate(names)}
    for k in np.unique(level):
        at = np.flatnonzero(level == k)
        if LEVELS_OF_ERROR[k] == 1.0:
            whole[:, at] = post[:, at]
            continue
        some_names, _, some = exact_on(bench, Y[at], K[at], bench.spectrum(LEVELS_OF_ERROR[k]), at < NULLS_EXACT)
        whole[np.ix_([place[n] for n in some_names], at)] = some
    out["noise"] = summary(names, silent, whole, few, truth)
    return out


def exact_on(bench, Y, K, S, is_null=None):
    """All sets of up to three for data with an effect, of up to two for nulls."""
    is_null = np.arange(len(Y)) < NULLS_EXACT if is_null is None else is_null
    parts = [(np.flatnonzero(is_null == flag), largest) for flag, largest in ((True, 2), (False, 3))]
    done = [(at, bench.exact(Y[at], K[at], S, largest)) for at, largest in parts if len(at)]
    names = done[-1][1][0]
    place = {n: k for k, n in enumerate(names)}
    post = np.full((len(names), len(Y)), -np.inf)
    for at, (some, _, values) in done:
        post[np.ix_([place[n] for n in some], at)] = values
    return names, [not n for n in names], post


def version():
    """Hash of what the computed rungs are computed with."""
    here = pathlib.Path(__file__).resolve().parent
    return tool.hash_of([here / f"{name}.py" for name in ("bayes", "law", "sets", "rungs", "model", "physics", "separability", "recording", "campaign")])
