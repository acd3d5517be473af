"""The maneuver that a report advises, recorded from the truth and given to the tool with the others: does it bring the right name as promised?

    menu(ship) -> {the tool's name of a maneuver: recordings}        what the pilots are told, each for `each_s` at 3 m
    Voyage(key, menu) -> .record(folder, dt): CSV files by maneuver   the same hidden effects, coefficients and faults, weather and noise drawn anew
    trial(...) -> {"id", "missing", "menu", "promised", "advised", "random", "right_before", "right_after": {maneuver: bool}}, where "A and B" are two of them

Right is a report whose most probable hypothesis is the truth: that is what `p_right` promises. A tug that came once does not come again.
"""

import hashlib
import json
import math

import numpy as np

import campaign
import excitation
import recording
import scores
import tool


def menu(ship):
    """The tool's menu (docs/gap-explain-details.md) for this truth's pilots: {name: (recordings, seconds of each at 3 m)}."""
    rudders = [a["channel"] for a in ship["actuators"] if a["channel"].startswith("delta")]
    actuators = {a["channel"]: a for a in ship["actuators"] if not a.get("optional")}
    n, low = actuators["n_p"]["initial_rps"], 0.5
    slowly = {"n_share": low, "u_share": low}  # the resistance law makes thrust and speed go together
    both = lambda steps: {c: [(t, math.radians(d)) for t, d in steps] for c in rudders}
    T = math.sqrt(ship["particulars"]["L_pp_m"] / 3.0)
    ahead = {"n_p": [(0.0, n)]}
    scheduled = lambda **channels: {"kind": "schedule", "schedule": {**ahead, **both([(0.0, 0.0)]), **channels}}
    stop = scheduled(n_p=[(0.0, n), (5.0 * T, max(-n, actuators["n_p"]["min_rps"]))])
    if len(rudders) == 2:  # that propeller does not reverse: the rudders do
        stop = scheduled(delta_p=[(0.0, 0.0), (5.0 * T, math.radians(-105.0))], delta_s=[(0.0, 0.0), (5.0 * T, math.radians(105.0))])
    out = {
        "a straight run and its reciprocal": ([{"kind": "straight", "heading_deg": h} for h in (0.0, 180.0)], 100.0),
        "turning circles, 35 deg to both sides": ([scheduled(**both([(0.0, d)])) for d in (35.0, -35.0)], 120.0),
        "a zigzag 10/10": ([{"kind": "zigzag", "rudder_deg": 10.0, "turn_by_deg": 10.0}], 150.0),
        "a zigzag 20/20": ([{"kind": "zigzag", "rudder_deg": 20.0, "turn_by_deg": 20.0}], 150.0),
        "a coast-down with stopped propeller": ([scheduled(n_p=[(0.0, n), (5.0 * T, 0.0)])], 120.0),
        "a crash stop": ([stop], 120.0),
        "a pull-out": ([scheduled(**both([(0.0, 20.0), (60.0 * T, 0.0), (100.0 * T, -20.0), (160.0 * T, 0.0)]))], 200.0),
        "random orders to all actuators": ([{"kind": "random"}], 200.0),
    }
    turns = lambda n: [scheduled(n_p=[(0.0, n)], **both([(0.0, d)])) for d in (35.0, -35.0)]
    slow = ", at 50 % speed"
    out["a straight run and its reciprocal" + slow] = ([{"kind": "straight", "heading_deg": h, **slowly} for h in (0.0, 180.0)], 200.0)
    out["turning circles, 35 deg to both sides" + slow] = ([{**turn, "u_share": low} for turn in turns(low * n)], 240.0)
    out["a zigzag 20/20" + slow] = ([{"kind": "zigzag", "rudder_deg": 20.0, "turn_by_deg": 20.0, **slowly}], 300.0)
    if actuators["n_p"]["min_rps"] < 0.0:
        out["astern from rest, rudders amidships"] = ([{**scheduled(n_p=[(0.0, max(-n, actuators["n_p"]["min_rps"]))]), "start_share": 0.0}], 120.0)
    if "n_bt" in actuators:
        full = actuators["n_bt"]["max_rps"]
        pulses = [(0.0, 0.0), (20.0 * T, full), (45.0 * T, 0.0), (85.0 * T, -full), (110.0 * T, 0.0), (150.0 * T, full), (175.0 * T, 0.0)]
        out["thruster pulses under way"] = ([scheduled(n_bt=pulses)], 200.0)
        out["thruster pulses" + slow] = ([{**scheduled(n_p=[(0.0, low * n)], n_bt=pulses), "u_share": low}], 200.0)
        out["thruster pulses at rest"] = ([{**scheduled(n_p=[(0.0, 0.0)], n_bt=pulses), "start_share": 0.0}], 200.0)
    return out


class Voyage(campaign.Group):
    """One case, sailing other maneuvers than those of its campaign."""

    def __init__(self, key, chosen):
        case = {**key, "seed": int(key["seed"]), "duration_s": max(each for _, each in chosen.values())}
        super().__init__([case])
        self.key, self.chosen = key, chosen
        rng = np.random.default_rng([case["seed"] & 0xFFFFFFFF, 31])
        self.recordings = [[{"n_share": 1.0, "u_share": 1.0, "start_share": 1.0, "seed": int(rng.integers(2**31)), **r, "maneuver": name}
                            for name, (runs, _) in chosen.items() for r in runs]]
        self.per = len(self.recordings[0])
        self.tau = [key["tau_s"]]
        self.error = np.stack([np.stack([excitation.ou_path(rng, sd, self.tau[0], self.duration, self.knot) for sd in self.error_sd[0]], 1) for _ in range(self.per)])
        self.plans = [{n: (t["shape"], t["strength"]) for n, t in key["truth"].items() if n != "tug"}]
        hidden = key["truth"].get("unmeasured-wind")
        wind = key.get("wind_truth") or {"speed_mps": self.T, "gust": 0.12, "dir_deg": math.degrees(hidden["shape"]["angle"]) if hidden else 0.0}
        knots = int(self.duration / self.knot) + 3
        self.unit_wind = np.stack([np.zeros((knots, 2)) if case["wind"] == "calm" else excitation.wind_path(rng, wind, self.duration, self.knot, self.T)
                                   for _ in range(self.per)])

    def record(self, folder, dt):
        """Writes the recordings; {maneuver: [files]}."""
        track, out = self.finite(self.simulate(True, dt)), {}
        folder.mkdir(parents=True, exist_ok=True)
        rng, faults = np.random.default_rng([self.cases[0]["seed"] & 0xFFFFFFFF, 32]), self.faults_of(0)
        leave = () if self.key["wind"] == "measured" else ("wind_speed_mps", "wind_dir_deg")
        for k, r in enumerate(self.recordings[0]):
            files = out.setdefault(r["maneuver"], [])
            length = int(round(self.chosen[r["maneuver"]][1] * round(self.T) / self.sample_s)) + 1
            noisy = recording.with_noise(recording.with_faults(recording.columns_of(track, k), faults), self.key["noise"], self.T, rng)
            files.append(folder / f"next-{list(self.chosen).index(r['maneuver']) + 1}-{len(files) + 1}.csv")
            recording.write_csv(files[-1], {c: a[:length] for c, a in noisy.items()}, leave)
        return out


def advice(report):
    """(the maneuvers that are advised, one or two, {maneuver: promised share of right names}); none where nothing is, or something else is to be recorded."""
    plan = report.get("next") or {}
    promised, advised = {m["maneuver"]: m["p_right"] for m in plan.get("maneuvers") or []}, plan.get("advised") or {}
    names = () if advised.get("record") else tuple(advised.get("maneuvers") or ())
    if names:
        promised[" and ".join(names)] = advised["p_right"]
    return names, promised


def is_right(report, truth):
    hypotheses = sorted(report.get("hypotheses") or [], key=lambda h: -(h.get("probability") or 0.0))
    return bool(hypotheses) and set(scores.effects_of(hypotheses[0])) == set(truth)


def trial(binaries, output, key, report, dt, limit_s, with_all):
    """One case; None where its report advises nothing, or nothing that this truth's pilots can do."""
    names, promised = advice(report)
    whole = {n: m for n, m in menu(json.loads((output / "cases" / key["id"] / "ship.json").read_text(encoding="utf-8"))).items() if n in promised}
    if not names or not set(names) <= set(whole):
        return None
    advised = " and ".join(names)
    rng = np.random.default_rng(int.from_bytes(hashlib.sha256(key["id"].encode()).digest()[:4], "big"))
    at_random = sorted(whole)[int(rng.integers(len(whole)))]
    wanted = whole if with_all else {n: whole[n] for n in dict.fromkeys((*names, at_random))}
    case, folder = output / "cases" / key["id"], output / "next" / key["id"]
    files, after = Voyage(key, wanted).record(folder, dt), {}
    tried = {name: files[name] for name in (wanted if with_all else (at_random,))}
    tried[advised] = [file for name in names for file in files[name]]
    for k, (name, more) in enumerate(tried.items()):
        result = folder / f"result-{k + 1}"
        record, _ = tool.explain(binaries, case / "ship.json", [*sorted(case.glob("train-*.csv")), *more], sorted(case.glob("held-*.csv")), result, limit_s)
        found = json.loads((result / "report.json").read_text(encoding="utf-8")) if record["exit_code"] == 0 else {}
        after[name] = is_right(found, key["names"])
    return {"id": key["id"], "missing": bool(key["names"]), "menu": sorted(whole), "promised": promised, "advised": advised, "random": at_random,
            "right_before": is_right(report, key["names"]), "right_after": after}
