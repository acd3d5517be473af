"""Scores of docs/proof.md from reports, ship files and keys. A report's absent fields count as not given."""

import math
import random

import physics

# What a report says of a case in which something acts; each case has one.
OUTCOMES = ("right", "some of it", "right and wrong", "wrong", "unknown", "mismatch, unnamed", "undecided", "missed", "failed")
DETECTED = ("right", "some of it", "unknown")  # a wrong name is no detection, and a mismatch without any is counted apart
# On what depends what the catalogue does not hold (physics.OUTSIDE), as report.json's `unknown_kind` says it.
KINDS = {"coanda-jet": "states", "ice-drag": "states", "swinging-tank": "memory", "wake-memory": "memory", "ventilation": "states", "magnetic-tether": "place",
         "yaw-flutter": "period", "stiction": "states"}
# The same of model errors that are not noise: a report that says so of a null is right, and no alarm. A step is a tug that comes and stays.
ERROR_KINDS = {"limit-cycle": ("period",), "step": ("time", "tug"), "all": ("period", "time", "tug")}
CAN_BE_NAMED = {*physics.EFFECTS, *physics.SENSORS}
ANGLES = ("current_set_deg", "wind_dir_deg", "wave_from_deg", "direction_deg", "wall_direction_deg")


def wilson(k, n, z=1.959963985):
    """95 % limits of a rate."""
    if n == 0:
        return 0.0, 1.0
    p, q = k / n, z * z / n
    middle, half = (p + 0.5 * q) / (1.0 + q), z * math.sqrt(p * (1.0 - p) / n + q / (4.0 * n)) / (1.0 + q)
    return max(0.0, middle - half), min(1.0, middle + half)


def effects_of(hypothesis):
    """Names of the effects of a hypothesis."""
    if "effects" in hypothesis:
        return list(hypothesis["effects"])
    name = hypothesis.get("name", "none")
    return [] if name == "none" else name.split(" + ")


def chosen_of(report):
    return list(report.get("chosen") or [])


def leading(report):
    """The hypothesis that was chosen, else the most probable one."""
    hypotheses = report.get("hypotheses") or []
    wanted = set(chosen_of(report)) - {"unknown"}
    for h in hypotheses:
        if wanted and set(effects_of(h)) == wanted:
            return h
    return hypotheses[0] if hypotheses else None


def ranking(report):
    """Names, most believed first: what was chosen, then the effects of the hypotheses."""
    out = [n for n in chosen_of(report)]
    for h in sorted(report.get("hypotheses") or [], key=lambda h: -(h.get("probability") or 0.0)):
        out += [n for n in effects_of(h) if n not in out]
    return [n for n in out if n != "unknown"]


def accepted_set(report):
    """Hypotheses that the report does not tell from the first: list of lists of names."""
    h = leading(report)
    if not chosen_of(report) or h is None or not effects_of(h):
        return []
    names = {g.get("name"): effects_of(g) for g in report.get("hypotheses") or []}
    out = [effects_of(h)]
    for other in h.get("confusable_with") or []:
        members = names.get(other, [] if other == "none" else other.split(" + "))
        if members and members not in out:
            out.append(members)
    return out


def stated(report, name):
    """Parameters that the report states for an effect or fault: {parameter: (estimate, low, high)}."""
    out = {}
    h = leading(report)
    if h is not None and name in effects_of(h):
        for key, p in (h.get("parameters") or {}).items():
            if p.get("effect", name) == name and p.get("estimate") is not None:
                low, high = (p.get("ci95") or (None, None))[:2]
                out[key.split("/")[-1]] = (p["estimate"], low, high)
    for f in (report.get("audit") or {}).get("faults") or []:
        if f.get("name") == name:
            for key, p in (f.get("parameters") or {}).items():
                if p.get("estimate") is not None and p.get("sd") is not None:
                    out[key] = (p["estimate"], p["estimate"] - 1.96 * p["sd"], p["estimate"] + 1.96 * p["sd"])
    return out


def difference(name, a, b):
    return (a - b + 180.0) % 360.0 - 180.0 if name in ANGLES else a - b


def outcome(report, truth):
    """One of OUTCOMES, where `truth` acts."""
    chosen = chosen_of(report)
    named = set(chosen) - {"unknown"}
    if named:
        if named <= set(truth):
            return "right" if named == set(truth) else "some of it"
        return "right and wrong" if named & set(truth) else "wrong"
    if chosen:
        return "unknown"
    return {"mismatch": "mismatch, unnamed", "undecided": "undecided"}.get(report.get("verdict"), "missed")


def overlap(intervals, truth):
    """Intersection over union of a union of intervals and one interval."""
    merged = []
    for low, high in sorted(intervals):
        if merged and low <= merged[-1][1]:
            merged[-1][1] = max(merged[-1][1], high)
        else:
            merged.append([low, high])
    inside = sum(max(0.0, min(high, truth[1]) - max(low, truth[0])) for low, high in merged)
    union = sum(high - low for low, high in merged) + truth[1] - truth[0] - inside
    return inside / union if union > 0.0 else 0.0


def located(report, key):
    """Where effects act against where the report says: overlap in time of the one that acts for a time (of what was located without a name, and of its own times
    where it is named); of a single effect whether the axis with the most of it is right, half the sum of the differences of the axes' shares, error of the point
    of attack [L]. None where not asked or not said."""
    out = {"overlap": None, "overlap_named": None, "axis": None, "shares_off": None, "x_F_off": None}
    found = report.get("located") or {}
    bound = [n for n in key["names"] if key["truth"].get(n, {}).get("interval_s")]
    if len(bound) == 1:
        name, truth = bound[0], key["truth"][bound[0]]
        stem = str(truth.get("file", "")).removesuffix(".csv")
        mine = [i for i in found.get("intervals") or [] if str(i.get("file", "")).rsplit("/", 1)[-1].removesuffix(".csv") == stem]
        out["overlap"] = overlap([(i["t_start_s"], i["t_end_s"]) for i in mine], truth["interval_s"])
        given = stated(report, name) if name in chosen_of(report) else {}
        if {"t_start_s", "t_end_s"} <= set(given):
            out["overlap_named"] = overlap([(given["t_start_s"][0], given["t_end_s"][0])], truth["interval_s"])
    if len(key["names"]) != 1:
        return out
    truth = key["truth"].get(key["names"][0], {})
    shares, true = found.get("dof"), truth.get("dof")
    if shares and true:
        out["axis"] = max(shares, key=shares.get) == max(true, key=true.get)
        out["shares_off"] = 0.5 * sum(abs(shares.get(k, 0.0) - v) for k, v in true.items())
    line = found.get("line_of_action")
    if line and line.get("x_F_over_L_pp") is not None and truth.get("x_F_over_L_pp") is not None and true and true["sway"] > 0.1:
        out["x_F_off"] = abs(line["x_F_over_L_pp"] - truth["x_F_over_L_pp"])
    return out


def quantities(report, key):
    """Rows (name, parameter, truth, estimate, covered or None, relative error or None) of what was named rightly."""
    rows = []
    for name in set(key["truth"]) & set(chosen_of(report)):
        given = stated(report, name)
        for parameter, true in key["truth"][name]["parameters"].items():
            if parameter not in given or true is None:
                continue
            estimate, low, high = given[parameter]
            covered = None
            if low is not None and high is not None:
                covered = difference(parameter, low, true) <= 0.0 <= difference(parameter, high, true)
            relative = None if parameter in ANGLES or abs(true) < 1e-9 else abs(estimate - true) / abs(true)
            rows.append((name, parameter, true, estimate, covered, relative))
    return rows


def inclusion_of(report, key):
    """(stated probability, whether it acts) of every effect and fault that there is: what a report does not list is stated with 0."""
    listed = {n: p for n, p in (report.get("inclusion") or {}).items() if p is not None and not n.startswith("coefficient:")}
    if not listed:
        return []
    acting = {"unknown" if key["family"] == "outside" else n for n in key["names"]}
    return [(listed.get(n, 0.0), n in acting) for n in sorted(CAN_BE_NAMED | set(listed) | acting)]


def kinds_of(key):
    """On what that depends which no name says."""
    return {KINDS.get(n) or key["truth"].get(n, {}).get("about") for n in key["names"]} - {None}


def judge(key, run, report):
    """One case in numbers that can be counted."""
    truth = list(key["names"])
    primes = [key["truth"].get(n, {}).get("d_prime") for n in truth]
    known = [d for d in primes if d is not None and math.isfinite(d)]
    out = {"id": key["id"], "family": key["family"], "truth": truth, "d_prime": min(known) if known else None, "level": key["level"], "ship": key["ship"],
           "campaign": key["campaign"], "error_kind": key.get("error_kind"), "failed": run.get("exit_code") != 0 or report is None, "wall_s": run.get("wall_s"), "peak_kB": run.get("peak_kB")}
    if out["failed"]:
        out.update({"alarm": False, "told": False, "verdict": None, "chosen": [], "outcome": "failed" if truth else None, "detected": False, "first": False, "ranked": None, "top3": False,
                    "set_ok": False, "set_size": 0, "both": False, "unknown": False, "kind_ok": False, "quantities": [], "probability": None, "right": None, "inclusion": [],
                    "located": {}, "ship_file": None})
        return out
    chosen = chosen_of(report)
    ranked, accepted = ranking(report), accepted_set(report)
    hypotheses = sorted(report.get("hypotheses") or [], key=lambda g: -(g.get("probability") or 0.0))
    h = hypotheses[0] if hypotheses else None
    out["verdict"], out["chosen"], out["p_value"] = report.get("verdict"), chosen, report.get("p_value")
    said = report.get("unknown_kind") if chosen == ["unknown"] else "tug" if "tug" in chosen and set(chosen) <= {"tug", "body-force"} else None
    out["told"] = not truth and key.get("error", 0.0) > 0.0 and said in ERROR_KINDS.get(key.get("error_kind"), ())
    out["alarm"] = (report.get("verdict") == "mismatch" or bool(chosen)) and not out["told"]
    out["outcome"] = outcome(report, truth) if truth else None
    out["detected"] = out["outcome"] in DETECTED
    named = [n for n in chosen if n != "unknown"]
    out["first"] = bool(truth) and bool(named) and named[0] in truth
    out["exact"] = set(named) == set(truth)
    out["ranked"] = ranked[:3]
    out["ranked_first"] = bool(truth) and bool(ranked) and ranked[0] in truth
    out["top3"] = bool(truth) and bool(set(ranked[:3]) & set(truth))
    out["both"] = len(truth) > 1 and set(truth) == set(named)
    out["set_ok"] = bool(truth) and any(set(truth) == set(members) for members in accepted)  # one with more in it is another hypothesis
    out["set_size"] = len(accepted)
    out["unknown"] = "unknown" in chosen
    out["kind_ok"] = report.get("unknown_kind") in kinds_of(key)
    out["located"] = located(report, key)
    out["ship_file"] = (report.get("ship_file") or {}).get("state")
    out["inclusion"] = inclusion_of(report, key)
    out["quantities"] = quantities(report, key)
    in_catalogue = key["family"] != "outside"
    wanted = set(truth)
    if h is not None and h.get("probability") is not None and in_catalogue:
        out["probability"], out["right"] = h["probability"], set(effects_of(h)) == wanted
        true_p = sum(g.get("probability") or 0.0 for g in hypotheses if set(effects_of(g)) == wanted)
        out["brier"] = sum(((g.get("probability") or 0.0) - (set(effects_of(g)) == wanted)) ** 2 for g in hypotheses)
        out["brier"] += 0.0 if any(set(effects_of(g)) == wanted for g in hypotheses) else 1.0
        out["log_score"] = -math.log(max(true_p, 1e-6))
    else:
        out["probability"] = out["right"] = None
    return out


def sizes_of_p(nulls, levels=(0.01, 0.05, 0.1, 0.2, 0.5)):
    """Share of nulls with a p-value up to a level: (level, how many, of). At most the level where the p-value is one; less where it is conservative."""
    known = [r["p_value"] for r in nulls if r.get("p_value") is not None]
    return [(level, sum(p <= level for p in known), len(known)) for level in levels]


def calibration(rows, bins=10):
    """Expected calibration error and its table: (low, high, cases, mean stated, share right)."""
    rows = [r for r in rows if r.get("probability") is not None]
    table, error = [], 0.0
    for b in range(bins):
        inside = [r for r in rows if b / bins <= r["probability"] < (b + 1) / bins or (b == bins - 1 and r["probability"] >= 1.0)]
        if inside:
            said, was = sum(r["probability"] for r in inside) / len(inside), sum(bool(r["right"]) for r in inside) / len(inside)
            table.append((b / bins, (b + 1) / bins, len(inside), said, was))
            error += len(inside) / len(rows) * abs(said - was)
    return (error if rows else None), table


def calibration_by_chance(rows, draws=1000):
    """The error that so few cases show on average of a tool whose stated probabilities are right."""
    rng, rows = random.Random(1), [r for r in rows if r.get("probability") is not None]
    return sum(calibration([{**r, "right": rng.random() < r["probability"]} for r in rows])[0] for _ in range(draws)) / draws


def gap_closed(before, after, oracle, least=0.1):
    """Share of the oracle's gain in mean log error that was won; None where the oracle wins less than `least`."""
    if None in (before, after, oracle) or before - oracle < least:
        return None
    return (before - after) / (before - oracle)
