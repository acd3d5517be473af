"""The cases: which families, how many, with what nuisances (Latin hypercube inside each class), and their making."""

import hashlib
import json
import math
import pathlib

import numpy as np

import excitation
import model as m
import physics
import recording
import separability as sep

NULLS = {  # family: (nuisances that are not drawn, level)
    "null-noise": dict(wrong=0.0, error=0.0, noise="paper", level=1),
    "null-parameters": dict(wrong=0.10, error=0.0, noise="paper", level=1),
    "null-corrupted": dict(wrong=0.05, error=1e-4),
    "null-model-error": dict(wrong=0.10),
    "null-structure": dict(wrong=0.20),
}
# Ship files that misstate how well their coefficients are known: all by three times, or one coefficient alone off by five times what is stated of it.
MISSTATED = ("all", "one")
MISSTATED_ALL, MISSTATED_ONE = 3.0, 5.0
OFTEN_SEEN = ("X_0", "Y_v", "N_v", "N_r", "C_D", "K_T", "F_N", "m_y")
LEVELS = dict(wrong=(0.0, 0.05, 0.10, 0.20), error=(0.0, 1e-4, 5e-4, 1e-3), noise=recording.KINDS)
PRIMES = (3.0, 6.0, 12.0, 30.0)
CAMPAIGNS = ("mixed", "mixed", "mixed", "random", "zigzag", "turn", "reciprocal", "straight")
MIXED = ("zigzag", "turn", "random", "reciprocal")
SHIPS = ("vectwin-3m", "esso-osaka-3m")
TESTS = 2  # recordings of a case that are sealed with its key: what a result is worth is judged on them, the tool never sees them
DECOYS = (("fouling", "thrust-loss"), ("wake", "rudder-effectiveness"))
PAIRS = (("steady-current", "rudder-offset"), ("unmeasured-wind", "steady-current"), ("wave-drift", "rudder-effectiveness"),
         ("thrust-loss", "rudder-offset"), ("actuator-delay", "steady-current"), ("shallow-water", "steady-current"),
         ("heading-latency", "rudder-offset"), ("log-scale", "steady-current"), ("cross-flow-drag", "unmeasured-wind"), ("tug", "rudder-offset"))


# The widths that the generator draws from, without knowing how wrong a case is: the stated log-sd is PRIOR times this.
STATED = math.sqrt(sum(w * w for w in LEVELS["wrong"]) / len(LEVELS["wrong"])) / 0.15
IN_SHIP_FILE = {  # the tool's names of a coefficient, by ship
    "X_0": ("hull.resistance",), **{k: (f"hull.{k}",) for k in ("X_vr", "Y_v", "Y_r", "N_v", "N_r", "C_D", "C_rY", "C_rN")},
    **{k: (f"inertia.{k}",) for k in ("m_x", "m_y", "I_z")}, "K_T": ("propeller.K_T",), "1-w": ("propeller.1-w_P",), "1-t": ("propeller.1-t_P",),
    "a_H": ("rudder.a_H",), "l_R": ("rudder.l_R",), **{k: (f"wind.{k}",) for k in ("k_X", "k_Y", "k_N")}}
OF_SINGLE = {"F_N": ("rudder.gain",), "gamma_R": ("rudder.gamma_R_negative", "rudder.gamma_R_positive")}
OF_VECTWIN = {"F_N": ("rudder.gain_port", "rudder.gain_starboard"), "gamma_R": ("rudder.gamma_R",),
              "K_BT": ("thruster.K_T_bow_positive", "thruster.K_T_bow_negative")}


def seed_of(*words):
    return int.from_bytes(hashlib.sha256("/".join(map(str, words)).encode()).digest()[:8], "big")


def hypercube(rng, n, levels):
    """n draws of each factor, its levels as even as can be, in independent orders."""
    out = {}
    for name, values in levels.items():
        order = rng.permutation(n)
        out[name] = [values[int(k * len(values) / n)] if n >= len(values) else values[int(rng.integers(len(values)))] for k in order]
    return out


def family_cases(family, seed, n, classes, draw, **fixed):
    """n cases in a family, classes in turn."""
    rng = np.random.default_rng(seed_of(seed, family))
    cube = hypercube(rng, n, {**LEVELS, "ship": SHIPS, "campaign": CAMPAIGNS, "prime": PRIMES, "wind": ("measured", "measured", "calm")})
    cases = []
    for k in range(n):
        case = {"id": f"{family}-{k:03d}", "family": family, "names": [], "level": 2, "seed": seed_of(seed, family, k), "prime": None}
        case.update({f: cube[f][k] for f in ("wrong", "error", "noise", "ship", "campaign", "wind")})
        case.update(fixed)
        if draw is not None:
            names = classes[k % len(classes)]
            case["names"] = list(names)
            case["prime"] = fixed.get("prime") or (PRIMES[(k // len(classes) + k) % len(PRIMES)] if n > 4 * len(classes) else cube["prime"][k])
            for name in names:
                if name == "convention":  # of the wind's direction
                    case["wind"] = "measured"
                effect = physics.ALL.get(name)
                if effect is None:
                    continue
                if not effect.fits(case["ship"]):
                    case["ship"] = next(s for s in SHIPS if effect.fits(s))
                if effect.needs == "wind":
                    case["wind"] = "measured"
                if effect.needs == "hidden":
                    case["wind"] = "hidden"
                if effect.prefer and case["campaign"] not in effect.prefer and fixed.get("campaign") is None:
                    case["campaign"] = "mixed"
        cases.append(case)
    return cases


def design(which, seed, cases=None, duration_s=None):
    """All cases of a set: smoke, development, nightly, full."""
    single = [(n,) for n in (*physics.EFFECTS, *physics.SENSORS, "convention")]
    np.random.default_rng(seed_of(seed, "classes")).shuffle(single)  # a small set shows some of all kinds
    outside = [(n,) for n in physics.OUTSIDE]
    sizes = {"smoke": (8, 10, 2, 2, 1, 1, 0, 0), "development": (10, 38, 6, 8, 3, 3, 2, 2), "nightly": (50, 96, 16, 16, 10, 8, 4, 8),
             "full": (500, 600, 200, 200, 60, 40, 40, 60)}[which]
    if cases is not None:
        sizes = [max(1, round(n * cases / sum(sizes))) for n in sizes]
    nulls, singles, pairs, outs, berthing, crime, decoys, misstated = sizes
    out = []
    families = list(NULLS)
    for i, family in enumerate(families):
        n = nulls // len(families) + (i < nulls % len(families))
        out += family_cases(family, seed, n, [()], None, **NULLS[family]) if n else []
    if which == "smoke":
        easy = [(n,) for n in ("steady-current", "rudder-offset", "actuator-delay", "unmeasured-wind", "log-scale", "heading-latency", "earth-force",
                               "tug", "lever-arm", "heading-bias")]
        out += family_cases("single", seed, singles, easy, True, prime=30.0, campaign="mixed", error=1e-4, wrong=0.05, noise="paper")
    else:
        out += family_cases("single", seed, singles, single, True)
    out += family_cases("pair", seed, pairs, PAIRS, True, prime=12.0, campaign="mixed")
    out += family_cases("outside", seed, outs, outside, True, prime=30.0)
    out += family_cases("berthing", seed, berthing, [("steady-current",), ("thruster-gain",), ("unmeasured-wind",), ("rudder-offset",), ()], True,
                        campaign="berthing")
    out += family_cases("inverse-crime", seed, crime, single, True, level=1, campaign="mixed")
    out += family_cases("decoy", seed, decoys, DECOYS, True, prime=12.0, campaign="mixed", decoy=True) if decoys else []
    unkept = family_cases("misstated", seed, misstated, [()], None) if misstated else []
    for k, case in enumerate(unkept):
        case["misstated"] = MISSTATED[k % len(MISSTATED)]
    out += unkept
    for case in out:
        if not case["names"]:
            case["prime"] = None
        case["duration_s"] = duration_s or {"smoke": 100.0, "full": 500.0}.get(which, 240.0)
        case["trains"] = 2 if which == "smoke" else 3
        case["sample_s"] = 1.0
    return out


def recordings_of(case):
    """Recordings of a case: what the pilots are told. Those that are fitted to, one for --holdout, and the sealed ones (`role`)."""
    rng = np.random.default_rng([case["seed"] & 0xFFFFFFFF, 1])
    ship = m.read_ship(case["ship"])
    out = []
    mixed = ["random", *rng.permutation(("zigzag", "turn")), "reciprocal"]
    for k, role in enumerate(["train"] * case["trains"] + ["held"] + ["test"] * TESTS):
        kind = case["campaign"]
        if kind == "mixed":
            kind = str(mixed[k]) if role == "train" else str(rng.choice(MIXED))
        out.append({"kind": kind, "role": role, "seed": int(rng.integers(2**31)), "heading_deg": float(rng.uniform(0.0, 360.0)) if kind != "straight" else float(rng.uniform(-20.0, 20.0)),
                    "rudder_deg": float(rng.choice((-1, 1)) * rng.choice((10, 15, 20, 25, 35) if kind == "turn" else (10, 15, 20))),
                    "turn_by_deg": float(rng.choice((10, 20))), "n_share": float(rng.uniform(0.8, 1.3)), "u_share": float(rng.uniform(0.8, 1.2)),
                    "start_share": float(rng.uniform(0.5, 1.0)), "gentle": bool(rng.random() < 0.4)})
    del ship
    return out


def names_of(recordings):
    """File names: train-1.csv ..., held-1.csv, test-1.csv ..."""
    count, out = {}, []
    for r in recordings:
        count[r["role"]] = count.get(r["role"], 0) + 1
        out.append(f"{r['role']}-{count[r['role']]}.csv")
    return out


def split_of(changes, ship):
    """Of an effect's change of accelerations (by recording): how its energy divides between the axes, yaw as sway over a quarter of a length, and where
    the side force acts, by the regression of moment on force: {"dof": {...}, "x_F_over_L_pp": ...}."""
    p, inertia = ship["particulars"], ship["inertia"]
    L, a = p["L_pp_m"], np.concatenate([np.asarray(c) for c in changes], -1)
    energy = np.mean((a * np.array([1.0, 1.0, 0.25 * L])[:, None]) ** 2, 1)
    Y = (inertia["m"] + inertia["m_y"]) * a[1] + inertia["m"] * inertia["x_G"] * L * a[2]
    N = (inertia["I_zG_plus_J_z"] + inertia["m"] * inertia["x_G"] ** 2) * L * L * a[2] + inertia["m"] * inertia["x_G"] * L * a[1]
    Y_is_there = float(np.sum(Y * Y)) > 1e-30
    return {"dof": {k: float(x) for k, x in zip(("surge", "sway", "yaw"), energy / max(float(np.sum(energy)), 1e-30))},
            "x_F_over_L_pp": float(np.sum(N * Y) / np.sum(Y * Y) / L) if Y_is_there else None}


HALVINGS = 6  # of effects with which a ship runs away
WILD = 2.0  # times her design speed: no order and no wind here drives her as fast


class Group:
    """Cases that are simulated together: one ship, level and length."""

    def __init__(self, cases):
        self.cases, self.ship_name, self.level = cases, cases[0]["ship"], cases[0]["level"]
        self.ship = m.read_ship(self.ship_name)
        self.T, self.L = physics.scale(self.ship), self.ship["particulars"]["L_pp_m"]
        self.duration, self.sample_s = cases[0]["duration_s"] * round(self.T), cases[0]["sample_s"]
        self.recordings = [recordings_of(c) for c in cases]
        self.per = len(self.recordings[0])
        self.factors = [self._factors(c) for c in cases]
        self.forms = [self._forms(c) for c in cases]
        self.knot = excitation.KNOT_S * self.T
        rngs = [np.random.default_rng([c["seed"] & 0xFFFFFFFF, 2]) for c in cases]
        self.tau = [float(r.uniform(10.0, 30.0)) * self.T for r in rngs]
        self.error_sd = [np.array([c["error"], c["error"], c["error"] / (0.25 * self.L)]) for c in cases]
        self.error = np.stack([np.stack([excitation.ou_path(r, sd, tau, self.duration, self.knot) for sd in sds], 1)
                               for r, sds, tau in zip(rngs, self.error_sd, self.tau) for _ in range(self.per)])
        self.winds, unit = [], []
        for c, r in zip(cases, rngs):
            wind = {"speed_mps": float(r.uniform(0.5, 1.5)) * self.T, "dir_deg": float(r.uniform(0.0, 360.0)), "gust": float(r.uniform(0.08, 0.15))}
            self.winds.append(wind)
            hidden = c["wind"] == "hidden"
            for _ in range(self.per):
                unit.append(np.zeros((int(self.duration / self.knot) + 3, 2)) if c["wind"] == "calm" else
                            excitation.wind_path(r, {**wind, "speed_mps": self.T} if hidden else wind, self.duration, self.knot, self.T))
        self.unit_wind = np.stack(unit)
        self.plans = [{} for _ in cases]  # name: (shape, strength)

    def _factors(self, case):
        rng = np.random.default_rng([case["seed"] & 0xFFFFFFFF, 3])
        drawn = {k: math.exp(case["wrong"] * m.PRIOR[k] / 0.15 * rng.standard_normal()) if case["wrong"] else 1.0 for k in m.FACTORS}
        if case.get("misstated") == "all":  # three times as far from the file as others are
            drawn = {k: math.exp(MISSTATED_ALL * STATED * m.PRIOR[k] * rng.standard_normal()) for k in m.FACTORS}
        if case.get("misstated") == "one":
            name = str(rng.choice(OFTEN_SEEN))
            drawn[name] = math.exp(float(rng.choice((-1.0, 1.0))) * MISSTATED_ONE * STATED * m.PRIOR[name])
        return drawn

    def _forms(self, case):
        """Constants of the level 2 forms: one member of the law of model.FORMS."""
        rng = np.random.default_rng([case["seed"] & 0xFFFFFFFF, 6])
        return {k: center + sd * float(np.clip(rng.standard_normal(), -2.5, 2.5)) for k, (center, sd) in m.FORMS.items()} if self.level == 2 else {}

    def fitted(self, i):
        """Rows of the recordings of a case that the tool is fitted to."""
        return range(i * self.per, i * self.per + self.cases[i]["trains"])

    def splits(self, i, track):
        """By effect, for the key: axis and point of attack of what it does along the fitted recordings."""
        out = {}
        for name in self.cases[i]["names"]:
            if name not in physics.SENSORS and name not in ("anemometer", "convention"):  # these move no ship
                shape, strength = self.plans[i][name]
                out[name] = split_of(self.change(i, track, name, strength, shape, self.fitted(i)), self.ship)
        return out

    def effects_of(self, i, only=None):
        numbers = {}
        for name, (shape, strength) in self.plans[i].items():
            if name in physics.ALL and physics.ALL[name].kind in ("force", "actuator") and (only is None or name == only):
                numbers.update(physics.ALL[name].at(strength, shape, self.ship)[0])
        return numbers

    def faults_of(self, i):
        faults = {}
        for name, (shape, strength) in self.plans[i].items():
            if name == "anemometer" or name in physics.SENSORS:
                faults.update(physics.ALL[name].at(strength, shape, self.ship)[1])
            if name == "convention":
                faults["wind_to"] = True
        return faults

    def wind_gain(self, i):
        return self.plans[i]["unmeasured-wind"][1] if "unmeasured-wind" in self.plans[i] else 0.0 if self.cases[i]["wind"] == "hidden" else 1.0

    def simulate(self, with_effects, dt):
        numbers = {}
        for i in range(len(self.cases)):
            for k, v in (self.effects_of(i) if with_effects else {}).items():
                numbers.setdefault(k, np.full(len(self.cases) * self.per, m.NEUTRAL[k]))[i * self.per:(i + 1) * self.per] = v
                if k == "tug":  # one recording only
                    numbers[k][i * self.per + 1:(i + 1) * self.per] = 0.0
        factors = {k: np.repeat([f[k] for f in self.factors], self.per) for k in m.FACTORS}
        forms = {k: np.repeat([f[k] for f in self.forms], self.per) for k in self.forms[0]}
        truth = m.Model(self.ship, self.level, factors, numbers, forms)
        if any(set(c["names"]) & {"wake-memory", "swinging-tank"} for c in self.cases):
            truth.active |= {"memory", "tank"}
        hidden = np.repeat([self.wind_gain(i) if with_effects else (0.0 if c["wind"] == "hidden" else 1.0) for i, c in enumerate(self.cases)], self.per)
        flat = [r for rs in self.recordings for r in rs]
        track = excitation.simulate(truth, flat, self.duration, dt, self.sample_s, self.unit_wind * hidden[:, None, None], self.error)
        return track

    def runaways(self, track):
        """Cases with a track along which the ship runs away."""
        speed = np.hypot(track["u"], track["v"])
        return sorted({int(row) // self.per for row in np.flatnonzero(~(speed < WILD * self.ship["u0_mps"]).all(1))})

    def finite(self, track):
        """The track; a RuntimeError where a ship runs away."""
        if wild := self.runaways(track):
            raise RuntimeError(f"{self.ship_name}: {', '.join(self.cases[i]['id'] for i in wild)}: tracks are not finite")
        return track

    def sail(self, dt):
        """With effects; those with which a ship runs away are halved until she does not."""
        for _ in range(HALVINGS):
            track = self.simulate(True, dt)
            wild = self.runaways(track)
            if not wild:
                return track
            for i in wild:
                self.plans[i] = {name: (shape, 0.5 * strength) for name, (shape, strength) in self.plans[i].items()}
        return self.finite(self.simulate(True, dt))

    def change(self, i, track, name, strength, shape, rows):
        """Change of accelerations by an effect, by recording."""
        effect, out = physics.ALL.get(name), []
        for row in rows:
            if name == "unmeasured-wind":
                k = track["t"] / self.knot
                at = np.minimum(k.astype(int), self.unit_wind.shape[1] - 2)
                w = self.unit_wind[row, at].T * strength
                a, b = (sep.accelerations(self.ship, self.level, track, row, self.factors[i], {}, w, self.forms[i]),
                        sep.accelerations(self.ship, self.level, track, row, self.factors[i], {}, (0.0 * w[0], 0.0 * w[1]), self.forms[i]))
            elif name in ("anemometer", "convention"):
                clean = recording.columns_of(track, row)
                faulty = recording.with_faults(clean, {"wind_to": True} if name == "convention" else effect.at(strength, shape, self.ship)[1])
                xi = np.radians(faulty["wind_dir_deg"])
                a = sep.accelerations(self.ship, self.level, track, row, self.factors[i], {}, forms=self.forms[i])
                b = sep.accelerations(self.ship, self.level, track, row, self.factors[i], {},
                                      (faulty["wind_speed_mps"] * np.cos(xi), faulty["wind_speed_mps"] * np.sin(xi)), self.forms[i])
            else:
                numbers = effect.at(strength, shape, self.ship)[0]
                if name == "tug" and row % self.per:
                    numbers = {}
                a, b = (sep.accelerations(self.ship, self.level, track, row, self.factors[i], n, forms=self.forms[i]) for n in (numbers, {}))
            out.append(a - b)
        return out

    def analyse(self, i, track):
        """Gradients and the errors that hide effects, of the recordings that the tool is fitted to."""
        rows = self.fitted(i)
        gradients = [sep.factor_gradients(self.ship, self.level, track, row, self.factors[i], self.forms[i])[1] for row in rows]
        structural = sep.structural_error(self.ship, self.level, track, rows, self.factors[i], gradients, None if self.cases[i]["wind"] == "hidden" else "recorded",
                                          self.forms[i])
        return rows, gradients, np.hypot(self.error_sd[i], structural)

    def prime(self, i, track, name, strength, shape, analysis):
        rows, gradients, hiding = analysis
        if name in physics.SENSORS:
            faults = physics.SENSORS[name].at(strength, shape, self.ship)[1]
            return sep.sensor_separability([recording.columns_of(track, r) for r in rows], faults, self.cases[i]["noise"], self.T)
        return sep.separability(self.change(i, track, name, strength, shape, rows), gradients, track, self.cases[i]["noise"], self.T, hiding, self.tau[i], self.L)

    def plan(self, track):
        """Shapes, and strengths that reach the wanted d' on the track without effects."""
        for i, case in enumerate(self.cases):
            if not case["names"]:
                continue
            rng = np.random.default_rng([case["seed"] & 0xFFFFFFFF, 4])
            rows = range(i * self.per, (i + 1) * self.per)
            reach = {**{k: track[k][rows.start:rows.stop] for k in ("x", "y", "psi")}, "duration": self.duration, "fitted": case["trains"]}
            analysis = self.analyse(i, track)
            for name in case["names"]:
                if name == "convention":
                    self.plans[i][name] = ({}, 1.0)
                    continue
                effect = physics.ALL[name]
                shape = effect.draw(rng, self.ship, reach)
                if name == "unmeasured-wind":  # the one that blows
                    shape["angle"] = math.radians(self.winds[i]["dir_deg"])
                if name == "shallow-water":
                    shape["level"] = self.level
                    if self.level == 1:
                        shape["slack"] = [0.0] * 6
                low, high = effect.most * 1e-4, effect.most
                if name == "actuator-rate":
                    low = 1.0
                for _ in range(14):
                    middle = math.sqrt(low * high)
                    if self.prime(i, track, name, middle, shape, analysis) < case["prime"]:
                        low = middle
                    else:
                        high = middle
                self.plans[i][name] = (shape, high)

    def realised(self, track, adjust=()):
        """d' on the tracks with the effects; strengths of the cases in `adjust` are rescaled towards what is wanted. Returns [{name: d'}]."""
        out = []
        for i, case in enumerate(self.cases):
            found = {}
            if case["names"]:
                analysis = self.analyse(i, track)
                for name in case["names"]:
                    shape, strength = self.plans[i][name]
                    d = found[name] = self.prime(i, track, name, strength, shape, analysis)
                    if i in adjust and name != "convention" and d > 1e-6:
                        most = physics.ALL[name].most
                        self.plans[i][name] = (shape, min(most, strength * min(max(case["prime"] / d, 0.3), 3.0)))
            out.append(found)
        return out

    def make(self, dt):
        base = self.finite(self.simulate(False, dt))
        self.plan(base)
        if not any(c["names"] for c in self.cases):
            return base, [{} for _ in self.cases]
        track = self.sail(dt)
        found = self.realised(track)
        off = {i for i, c in enumerate(self.cases) for n, d in found[i].items()
               if n != "convention" and abs(math.log(max(d, 1e-3) / c["prime"])) > 0.3 and self.plans[i][n][1] < 0.99 * physics.ALL[n].most}
        if off:  # these alone: what a case is does not depend on those that are simulated beside it
            self.realised(track, off)
            track = self.sail(dt)
            found = self.realised(track)
        return track, found

    def stated(self, case):
        """What the given file says of its coefficients: the log-sd that the generator draws from, and that one draw stands for both sides."""
        names = {**IN_SHIP_FILE, **(OF_VECTWIN if self.ship["rudder"]["type"].startswith("vectwin") else OF_SINGLE)}
        sds = {k: round(STATED * m.PRIOR[k], 4) for k in names}
        both = [(name, k) for k, all_ in names.items() for name in all_ if len(all_) > 1]
        return {"uncertainty": {name: sds[k] for k, all_ in names.items() for name in all_},
                "coefficient_covariance": {"names": [name for name, _ in both],
                                           "matrix": [[sds[k] ** 2 if k == other else 0.0 for _, other in both] for _, k in both]}}

    def write(self, folder, keys, track, found):
        for i, case in enumerate(self.cases):
            to, secret = folder / case["id"], keys / case["id"]
            to.mkdir(parents=True, exist_ok=True)
            secret.mkdir(parents=True, exist_ok=True)
            given = {**json.loads(json.dumps(self.ship)), **self.stated(case)}
            (to / "ship.json").write_text(json.dumps(given, indent=1), encoding="utf-8")
            faults, rng = self.faults_of(i), np.random.default_rng([case["seed"] & 0xFFFFFFFF, 5])
            # Free runs take the wind as it is recorded: a ship file with an anemometer's fault corrects it.
            of_wind = {k: v for k, v in faults.items() if k.startswith("anemometer")}
            leave = () if case["wind"] == "measured" else ("wind_speed_mps", "wind_dir_deg")
            names, truths = names_of(self.recordings[i]), {}
            for k, (r, name) in enumerate(zip(self.recordings[i], names)):
                clean = recording.columns_of(track, i * self.per + k)
                noisy = recording.with_noise(recording.with_faults(clean, faults), case["noise"], self.T, rng)
                if r["role"] != "test":  # those stay with the key
                    recording.write_csv(to / name, noisy, leave)
                recording.write_csv(secret / name, recording.with_faults(clean, of_wind), leave)
                truths[name] = hashlib.sha256((secret / name).read_bytes()).hexdigest()
            truth, splits = {}, self.splits(i, track)
            for name in case["names"]:
                shape, strength = self.plans[i][name]
                parameters = physics.ALL[name].at(strength, shape, self.ship)[1] if name in physics.ALL else {}
                truth[name] = {"parameters": parameters, "strength": strength, "d_prime": found[i].get(name), "at_most": name in physics.ALL and strength >= 0.99 * physics.ALL[name].most}
                truth[name].update({"shape": shape, **splits.get(name, {})})
                if name == "tug":
                    truth[name].update({"file": "train-1.csv", "interval_s": [shape["start"], shape["end"]]})
            key = {**case, "seed": str(case["seed"]), "truth": truth, "wind_truth": self.winds[i] if case["wind"] == "measured" else None, "tau_s": self.tau[i],
                   "factors": {k: round(v, 6) for k, v in self.factors[i].items()}, "forms": self.forms[i], "stated": STATED, "recordings": [{**r, "file": n} for r, n in zip(self.recordings[i], names)],
                   "noise_free": truths}
            mine = slice(i * self.per, (i + 1) * self.per)
            whole = {k: track[k][..., mine, :] for k in track if k not in ("t", "channels")}
            np.savez_compressed(secret / "track.npz", t=track["t"], channels=np.array(track["channels"]), **whole)
            key["noise_free"]["track.npz"] = hashlib.sha256((secret / "track.npz").read_bytes()).hexdigest()
            (keys / f"{case['id']}.json").write_text(json.dumps(key, indent=1, sort_keys=True), encoding="utf-8")


def seal(keys):
    lines = [f"{hashlib.sha256(f.read_bytes()).hexdigest()}  {f.name}" for f in sorted(keys.glob("*.json"))]
    (keys.parent / "keys.sha256").write_text("\n".join(lines) + "\n", encoding="utf-8")


def broken_seals(keys):
    """Names of keys that are not those that were sealed, and of sealed recordings that are not those of their key."""
    lines = [line.split("  ") for line in (keys.parent / "keys.sha256").read_text(encoding="utf-8").split("\n") if line]
    if any(len(line) != 2 for line in lines):
        return ["keys.sha256 itself"]
    sealed = {name: digest for digest, name in lines}
    there = {f.name: hashlib.sha256(f.read_bytes()).hexdigest() for f in keys.glob("*.json")}
    broken = [n for n in sealed.keys() | there.keys() if sealed.get(n) != there.get(n)]
    for f in keys.glob("*.json"):
        if f.name not in broken:
            for name, digest in json.loads(f.read_text(encoding="utf-8")).get("noise_free", {}).items():
                file = f.with_suffix("") / name
                if not file.exists() or hashlib.sha256(file.read_bytes()).hexdigest() != digest:
                    broken.append(f"{f.stem}/{name}")
    return sorted(broken)


