"""Cases of the second house, in the format of campaign.py: which, with what nuisances, and their making.

design(seed, n) -> list of cases; Fleet(cases of one ship and rate).make(dt) -> tracks; .write(cases, keys, ...).
"""

import hashlib
import json
import math
import sys

import numpy as np

import campaign
import recording
import separability as sep
from second_house import effects as ef
from second_house import separable, vessel, voyage, weather

SHIPS = ("esso-osaka-3m", "vectwin-3m", "kvlcc2-l7", "vectwin-150m", "kvlcc2-full")
RATES_HZ = {"3m": (1.0, 2.0, 5.0, 10.0), "l7": (1.0, 2.0, 5.0), "0m": (0.5, 1.0), "ll": (0.5, 1.0)}  # by the end of the name
LEVELS = dict(wrong=(0.0, 0.05, 0.10, 0.20), error=(0.0, 1e-4, 5e-4, 1e-3), error_kind=weather.KINDS, noise_gain=(1.0, 1.0, 2.0))
PRIMES = (3.0, 6.0, 12.0, 30.0)
CAMPAIGNS = ("mixed", "mixed", "mixed", "random", "zigzag", "turn", "speeds")
MIXED = ("zigzag", "turn", "random", "reciprocal", "speeds")
TRIES = 8  # of a case that runs away
SHARES = dict(null=0.30, single=0.45, pair=0.15, outside=0.10)


def design(seed, n=100, duration_s=None):
    """n cases; ids begin with second-."""
    sizes = {k: max(1, round(n * s)) for k, s in SHARES.items()}
    classes = {"null": [()], "single": [(k,) for k in (*ef.EFFECTS, *ef.SENSORS)], "pair": list(ef.PAIRS), "outside": [(k,) for k in ef.OUTSIDE]}
    out = []
    for family, count in sizes.items():
        rng = np.random.default_rng(campaign.seed_of(seed, "second-house", family))
        rng.shuffle(classes[family])
        cube = campaign.hypercube(rng, count, {**LEVELS, "ship": SHIPS, "campaign": CAMPAIGNS, "prime": PRIMES, "wind": ("measured", "measured", "calm")})
        for k in range(count):
            case = {"id": f"second-{family}-{k:03d}", "house": "second", "family": "null-second-house" if family == "null" else family, "level": 2,
                    "names": [str(x) for x in classes[family][k % len(classes[family])]], "seed": campaign.seed_of(seed, "second-house", family, k), "noise": "second-house"}
            case.update({f: cube[f][k] for f in (*LEVELS, "ship", "campaign", "wind", "prime")})
            needs = {ef.ALL[x].needs for x in case["names"]}
            if needs - {None} and case["ship"].startswith("kvlcc2"):  # has no wind module
                case["ship"] = str(rng.choice([s for s in SHIPS if not s.startswith("kvlcc2")]))
            if any(not case["ship"].startswith(ef.ALL[x].ships or "") for x in case["names"]):
                case["ship"] = "vectwin-3m" if k % 2 else "vectwin-150m"
            case["wind"] = "hidden" if "hidden" in needs else "measured" if "measured" in needs else "calm" if case["ship"].startswith("kvlcc2") else case["wind"]
            if family == "pair":
                case["campaign"], case["prime"] = "mixed", 12.0
            if family == "outside":
                case["prime"] = 30.0
            if family == "null":
                case["prime"] = None
            rates = RATES_HZ[case["ship"][-2:]]
            case["sample_s"] = 1.0 / rates[k % len(rates)]
            case["duration_s"], case["trains"], case["tests"] = duration_s or 240.0, 3, campaign.TESTS
            out.append(case)
    return out


def recordings_of(case):
    """What the pilots are told; roles train, held, test in this order."""
    rng = np.random.default_rng([case["seed"] & 0xFFFFFFFF, 11])
    roles = ["train"] * case["trains"] + ["held"] + ["test"] * case["tests"]
    first = ["random", *rng.permutation(("zigzag", "turn", "reciprocal", "speeds"))]
    out = []
    for k, role in enumerate(roles):
        kind = case["campaign"]
        if kind == "mixed":
            kind = str(first[k]) if role == "train" else str(rng.choice(MIXED))
        out.append({"kind": kind, "role": role, "held": role == "held", "seed": int(rng.integers(2**31)), "heading_deg": float(rng.uniform(0.0, 360.0)),
                    "rudder_deg": float(rng.choice((-1, 1)) * rng.choice((10, 15, 20, 25, 35) if kind == "turn" else (10, 15, 20))),
                    "turn_by_deg": float(rng.choice((10, 20))), "n_share": float(rng.uniform(0.8, 1.2)), "u_share": float(rng.uniform(0.8, 1.2)),
                    "start_share": float(rng.uniform(0.5, 1.0)), "gentle": bool(rng.random() < 0.4)})
    return out


class Fleet:
    """Cases that are sailed together: one ship, rate and length."""

    def __init__(self, cases):
        self.cases, self.name = cases, cases[0]["ship"]
        nominal = vessel.Vessel(self.name)
        self.nominal, self.T, self.L = nominal, nominal.scale, nominal.L
        self.sample_s = cases[0]["sample_s"]
        self.duration = cases[0]["duration_s"] * round(self.T)
        self.recordings = [recordings_of(c) for c in cases]
        self.per = len(self.recordings[0])
        self.left = [json.loads((vessel.HERE / "ships" / f"{vessel.BY_FROUDE.get(self.name, self.name)}.json").read_text(encoding="utf-8"))["left_rms"][a] for a in "XYN"]
        self.rngs = [np.random.default_rng([c["seed"] & 0xFFFFFFFF, 12]) for c in cases]
        self.factors = [self.drawn(i) for i in range(len(cases))]
        self.winds = [{"speed_mps": float(r.uniform(0.5, 1.5)) * self.T, "dir_deg": float(r.uniform(0.0, 360.0))} for r in self.rngs]
        self.plans = [{} for _ in cases]

    def drawn(self, i):
        """Coefficients of a case by those of the nominal ship."""
        return {k: math.exp(self.cases[i]["wrong"] * s / 0.15 * self.rngs[i].standard_normal()) for k, s in vessel.STATED.items()}

    def lost(self, out):
        """Cases that run away."""
        is_lost = ~np.isfinite(out["true"]["u_mps"]).all(1)
        return [i for i in range(len(self.cases)) if is_lost[i * self.per:(i + 1) * self.per].any()]

    def numbers(self, i):
        out = {}
        for name, (shape, strength) in self.plans[i].items():
            out.update(ef.ALL[name].at(strength, shape, self.nominal)[0])
        return out

    def faults(self, i):
        out = {}
        for name, (shape, strength) in self.plans[i].items():
            if name in ef.SENSORS or name == "anemometer":
                out.update(ef.ALL[name].at(strength, shape, self.nominal)[1])
        return out

    def wind_speed(self, i, with_effects):
        c = self.cases[i]
        if c["wind"] == "hidden":
            plan = self.plans[i].get("unmeasured-wind")
            return plan[1] * self.T if plan and with_effects else 0.0
        return 0.0 if c["wind"] == "calm" else self.winds[i]["speed_mps"]

    def sail(self, with_effects, dt_s):
        n, per = len(self.cases), self.per
        spread = lambda values: np.repeat(np.asarray(values, float), per)
        numbers = {}
        for i in range(n):
            for k, v in (self.numbers(i) if with_effects else {}).items():
                numbers.setdefault(k, np.full(n * per, vessel.NEUTRAL[k]))[i * per:(i + 1) * per] = v
                if k == "tug":  # one recording only
                    numbers[k][i * per + 1:(i + 1) * per] = 0.0
        ship = vessel.Vessel(self.name, {k: spread([f[k] for f in self.factors]) for k in vessel.STATED}, numbers)
        flat = [r for rs in self.recordings for r in rs]
        rng = lambda purpose: [np.random.default_rng([r["seed"], purpose]) for r in flat]
        wind = weather.Wind(rng(21), spread([self.wind_speed(i, with_effects) for i in range(n)]), np.radians(spread([w["dir_deg"] for w in self.winds])), self.T)
        error = weather.ModelError(rng(22), spread([c["error"] for c in self.cases]), [c["error_kind"] for c in self.cases for _ in range(per)], self.duration, self.T, self.L)
        spec = {}
        for i in range(n):
            for k, v in (self.faults(i) if with_effects else {}).items():
                spec.setdefault(k, np.full(n * per, 1.0 if k == "anemometer_scale" else 0.0))[i * per:(i + 1) * per] = v
        instruments = voyage.Instruments(rng(23), spec, spread([c["noise_gain"] for c in self.cases]), self.sample_s, self.T)
        every = max(1, math.ceil(self.sample_s / (dt_s * self.T) - 1e-9))
        return voyage.sail(ship, flat, self.duration, self.sample_s / every, self.sample_s, wind, error, instruments)

    def sail_all(self, with_effects, dt_s, otherwise):
        """All tracks; cases that run away are sailed otherwise(case) instead."""
        for _ in range(TRIES):
            out = self.sail(with_effects, dt_s)
            lost = self.lost(out)
            if not lost:
                return out
            for i in lost:
                print(f"{self.cases[i]['id']}: runs away, {'weaker effects' if with_effects else 'other coefficients'}", file=sys.stderr)
                otherwise(i)
        raise RuntimeError(f"{self.name}: {', '.join(self.cases[i]['id'] for i in lost)} run away")

    def fitted(self, i):
        return range(i * self.per, i * self.per + self.cases[i]["trains"])

    def change(self, i, out, name, strength, shape):
        effect, changes = ef.ALL[name], []
        for row in self.fitted(i):
            a = lambda numbers, wind="recorded": separable.accelerations(self.name, self.nominal.tables, out, row, self.factors[i], numbers, wind)
            if name == "unmeasured-wind":
                xi = math.radians(self.winds[i]["dir_deg"]) + np.zeros(len(out["t_s"]))
                changes.append(a({}, (strength * self.T * np.cos(xi), strength * self.T * np.sin(xi))) - a({}, (0.0 * xi, 0.0 * xi)))
            elif name == "anemometer":
                _, _, (wx, wy) = separable.along(out, row)
                k = effect.at(strength, shape, self.nominal)[1]["anemometer_scale"]
                changes.append(a({}) - a({}, (k * wx, k * wy)))
            else:
                numbers = effect.at(strength, shape, self.nominal)[0]
                changes.append(a({} if name == "tug" and row % self.per else numbers) - a({}))
        return changes

    def prime(self, i, out, name, strength, shape, analysis):
        if name in ef.SENSORS:
            faults = ef.SENSORS[name].at(strength, shape, self.nominal)[1]
            return sep.sensor_separability([self.columns(out, "true", row) for row in self.fitted(i)], faults, "paper", self.T)
        return analysis.d_prime(self.change(i, out, name, strength, shape))

    def columns(self, out, which, row):
        names = [k for k in out["recorded"]]
        return {"t_s": out["t_s"], **{k: out[which][k][row] for k in names}}

    def make(self, dt_s):
        def redraw(i):
            self.factors[i] = self.drawn(i)

        def weaken(i):
            self.plans[i] = {name: (shape, 0.5 * strength) for name, (shape, strength) in self.plans[i].items()}

        out = self.sail_all(False, dt_s, redraw)
        for i, case in enumerate(self.cases):
            rng = np.random.default_rng([case["seed"] & 0xFFFFFFFF, 14])
            analysis = self.analysis(i, out)
            for name in case["names"]:
                track = {k: out["true"][k][i * self.per] for k in ("x0_m", "y0_m")}
                shape = ef.ALL[name].draw(rng, self.nominal, self.duration, track)
                low, high = ef.ALL[name].most * 1e-3, ef.ALL[name].most
                for _ in range(9):
                    middle = math.sqrt(low * high)
                    low, high = (middle, high) if self.prime(i, out, name, middle, shape, analysis) < case["prime"] else (low, middle)
                if name == "unmeasured-wind":
                    shape["angle"] = math.radians(self.winds[i]["dir_deg"])
                self.plans[i][name] = (shape, high)
        if any(c["names"] for c in self.cases):
            out = self.sail_all(True, dt_s, weaken)
        found = []
        for i, case in enumerate(self.cases):
            analysis = self.analysis(i, out)
            found.append({name: {"d_prime": self.prime(i, out, name, self.plans[i][name][1], self.plans[i][name][0], analysis),
                                 **({} if name in ef.SENSORS else campaign.split_of(self.change(i, out, name, self.plans[i][name][1], self.plans[i][name][0]), self.nominal.ship))}
                          for name in case["names"]})
        return out, found

    def analysis(self, i, out):
        if not self.cases[i]["names"]:
            return None
        sd = self.cases[i]["error"]
        return separable.Analysis(self.name, self.nominal.tables, out, self.fitted(i), self.factors[i], np.array([sd, sd, 4.0 * sd / self.L]), self.left, self.T, self.L)

    def write(self, folder, keys, out, found):
        for i, case in enumerate(self.cases):
            to, secret = folder / case["id"], keys / case["id"]
            to.mkdir(parents=True, exist_ok=True)
            secret.mkdir(parents=True, exist_ok=True)
            (to / "ship.json").write_text(json.dumps(self.nominal.ship, indent=1), encoding="utf-8")
            leave = () if case["wind"] == "measured" else ("wind_speed_mps", "wind_dir_deg")
            names, truths = campaign.names_of(self.recordings[i]), {}
            for k, name in enumerate(names):
                row = i * self.per + k
                if self.recordings[i][k]["role"] != "test":  # sealed: the tool never sees it
                    recording.write_csv(to / name, self.columns(out, "recorded", row), leave)
                of_wind = {k: v for k, v in self.faults(i).items() if k.startswith("anemometer")}  # a ship file with that fault corrects it
                recording.write_csv(secret / name, recording.with_faults(self.columns(out, "true", row), of_wind), leave)
                truths[name] = hashlib.sha256((secret / name).read_bytes()).hexdigest()
            truth = {}
            for name in case["names"]:
                shape, strength = self.plans[i][name]
                truth[name] = {"parameters": ef.ALL[name].at(strength, shape, self.nominal)[1], "strength": strength, "shape": shape, **found[i][name],
                               "at_most": strength >= 0.99 * ef.ALL[name].most, "about": ef.ALL[name].about}
                if name == "tug":
                    truth[name].update({"file": "train-1.csv", "interval_s": [shape["start"], shape["end"]]})
            key = {**case, "seed": str(case["seed"]), "truth": truth, "wind_truth": self.winds[i] if case["wind"] == "measured" else None,
                   "factors": {k: round(v, 6) for k, v in self.factors[i].items()}, "recordings": [{**r, "file": n} for r, n in zip(self.recordings[i], names)],
                   "noise_free": truths}
            (keys / f"{case['id']}.json").write_text(json.dumps(key, indent=1, sort_keys=True), encoding="utf-8")
