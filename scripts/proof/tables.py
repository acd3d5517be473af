"""The tables of docs/proof.md from judged cases (scores.judge): lists of lines of Markdown. A table of nothing says so."""

import math
import statistics
from collections import Counter

import scores

NOT_YET = ["Not computed yet."]
WORSE = 0.05  # mean ln of the errors of free runs, from which on they got worse: scatter of the sealed recordings


def nulls_of(rows):
    """Cases in which nothing acts and the file states what it is; those that misstate it are judged by `ship_file`."""
    return [r for r in rows if not r["truth"] and r["family"] not in ("berthing", "misstated")]


def rate(k, n):
    if n == 0:
        return "–"
    low, high = scores.wilson(k, n)
    return f"{k}/{n} = {100 * k / n:.0f} % ({100 * low:.0f} to {100 * high:.0f})"


def bin_of(d):
    if d is None:
        return "unknown"
    return next((label for limit, label in ((4.5, "3"), (9.0, "6"), (19.0, "12")) if d < limit), "30")


def targets(rows):
    """Rows of the table of targets: words, target, what was reached."""
    nulls = nulls_of(rows)
    singles = [r for r in rows if r["family"] == "single"]
    seen = [r for r in singles if (r["d_prime"] or 0) >= 6.0]
    mixed = [r for r in seen if r["campaign"] == "mixed"]
    pairs, outs = [r for r in rows if r["family"] == "pair"], [r for r in rows if r["family"] == "outside"]
    in_catalogue = [r for r in seen + pairs if not r["failed"]]
    lines = [("false alarms, all nulls", "<= 1 %", rate(sum(r["alarm"] for r in nulls), len(nulls)))]
    lines.append(("`undecided` there", "<= 5 %", rate(sum(r["verdict"] == "undecided" for r in nulls), len(nulls))))
    if any(r.get("error_kind") for r in nulls):
        lines.append(("model error that is no noise, and the report says so: no alarm", "", rate(sum(r["told"] for r in nulls), len(nulls))))
    lines.append(("detected, single effects at d' >= 6", ">= 95 %", rate(sum(r["detected"] for r in seen), len(seen))))
    lines.append(("named first, mixed campaigns at d' >= 6", ">= 80 %", rate(sum(r["first"] for r in mixed), len(mixed))))
    lines.append(("ranked first there, whether claimed or not", "", rate(sum(r.get("ranked_first", False) for r in mixed), len(mixed))))
    lines.append(("among the first three there", "", rate(sum(r["top3"] for r in mixed), len(mixed))))
    claimed = [r for r in mixed if r["set_size"]]
    size = f"; mean size {statistics.mean(r['set_size'] for r in claimed):.2f}" if claimed else ""
    lines.append(("truth in the accepted set, where something was named, mixed at d' >= 6", ">= 95 %, mean size <= 1.5",
                  rate(sum(r["set_ok"] for r in claimed), len(claimed)) + size))
    lines.append(("both of a pair named", ">= 60 %", rate(sum(r["both"] for r in pairs), len(pairs))))
    lines.append(("one of a pair named first", "", rate(sum(r["first"] for r in pairs), len(pairs))))
    lines.append(("out of catalogue: flagged `unknown`", ">= 80 %", rate(sum(r["unknown"] for r in outs), len(outs))))
    flagged = [r for r in outs if r["unknown"]]
    lines.append(("of these, with the right kind", ">= 60 %", rate(sum(r["kind_ok"] for r in flagged), len(flagged))))
    lines.append(("out of catalogue: detected at all", "", rate(sum(r["detected"] for r in outs), len(outs))))
    lines.append(("in the catalogue but flagged `unknown`", "<= 5 %", rate(sum(r["unknown"] for r in in_catalogue), len(in_catalogue))))
    for level, words in ((2, "95 % intervals that cover, level 2"), (1, "95 % intervals that cover, level 1")):
        covered = [q[4] for r in rows if r["level"] == level for q in r["quantities"] if q[4] is not None]
        lines.append((words, "90 to 97 %" if level == 2 else "", rate(sum(covered), len(covered))))
    relative = sorted(q[5] for r in rows if r["level"] == 2 for q in r["quantities"] if q[5] is not None)
    if relative:
        lines.append(("relative error of named parameters, median", "", f"{100 * statistics.median(relative):.0f} % of {len(relative)}"))
    error, _ = scores.calibration(rows)
    with_p = [r for r in rows if r.get("probability") is not None]
    if with_p:
        lines.append(("calibration error of the first probability (ECE)", "<= 0.08", f"{error:.3f} over {len(with_p)}, {scores.calibration_by_chance(with_p):.3f} by chance alone; Brier "
                      f"{statistics.mean(r['brier'] for r in with_p):.2f}, log score {statistics.mean(r['log_score'] for r in with_p):.2f}"))
    gains, harms, n = [], 0, 0
    for r in rows:
        i = r.get("improvement") or {}
        if i.get("before") is None or i.get("after") is None:
            continue
        n += 1
        harms += i["after"] > i["before"] + WORSE
        share = scores.gap_closed(i["before"], i["after"], i.get("oracle"))
        if share is not None and r["truth"]:
            gains.append((i["before"] - i["after"], i["before"] - i["oracle"], share))
    if gains:
        lines.append(("gap closed on sealed recordings, of the reference's (sum of gains; median)", ">= 85 %",
                      f"{100 * sum(g[0] for g in gains) / sum(g[1] for g in gains):.0f} %; {100 * statistics.median(g[2] for g in gains):.0f} % of {len(gains)}"))
    if n:
        lines.append(("free runs of sealed recordings got worse", "< 2 %", rate(harms, n)))
    lines.append(("failed runs", "0", rate(sum(r["failed"] for r in rows), len(rows))))
    walls = sorted(r["wall_s"] for r in rows if r["wall_s"])
    if walls:
        lines.append(("seconds a case, median and longest; peak memory", "", f"{statistics.median(walls):.0f}, {walls[-1]:.0f}; {max(r['peak_kB'] or 0 for r in rows) / 1024:.0f} MB"))
    return lines


def family_table(rows):
    """Where something acts: each case has one outcome."""
    rows = [r for r in rows if r["truth"]]
    lines = ["| family | cases | detected | " + " | ".join(scores.OUTCOMES) + " | in the accepted set |", "|---" * (len(scores.OUTCOMES) + 4) + "|"]
    for family in sorted({r["family"] for r in rows}):
        some = [r for r in rows if r["family"] == family]
        of = Counter(r["outcome"] for r in some)
        lines.append(f"| {family} | {len(some)} | {rate(sum(r['detected'] for r in some), len(some))} | " + " | ".join(str(of[o]) for o in scores.OUTCOMES)
                     + f" | {sum(r['set_ok'] for r in some)} |")
    return lines


def null_table(rows):
    """False alarms where nothing is missing, by family and by ship."""
    lines = ["| nothing is missing | cases | false alarms | `undecided` | free runs of sealed recordings got worse |", "|---" * 5 + "|"]
    rows = nulls_of(rows)
    groups = [(family, [r for r in rows if r["family"] == family]) for family in sorted({r["family"] for r in rows})]
    groups += [(ship, [r for r in rows if r["ship"] == ship]) for ship in sorted({r["ship"] for r in rows})]
    groups += [(f"model error: {kind}", [r for r in rows if r["error_kind"] == kind]) for kind in sorted({r.get("error_kind") for r in rows} - {None})]
    for words, some in [*groups, ("all", rows)]:
        runs = [i for i in (r.get("improvement") or {} for r in some) if None not in (i.get("before"), i.get("after"))]
        harms = sum(i["after"] > i["before"] + WORSE for i in runs)
        lines.append(f"| {words} | {len(some)} | {rate(sum(r['alarm'] for r in some), len(some))} | {rate(sum(r['verdict'] == 'undecided' for r in some), len(some))} "
                     f"| {rate(harms, len(runs))} |")
    return lines


def prime_table(rows):
    lines = ["| d' about | cases | detected | named first | ranked first | in the first three | truth in the accepted set |", "|---" * 7 + "|"]
    for label in ("3", "6", "12", "30"):
        some = [r for r in rows if r["family"] == "single" and bin_of(r["d_prime"]) == label and r["d_prime"] is not None]
        if some:
            lines.append(f"| {label} | {len(some)} | {rate(sum(r['detected'] for r in some), len(some))} | {sum(r['first'] for r in some)} "
                         f"| {sum(r.get('ranked_first', False) for r in some)} | {sum(r['top3'] for r in some)} | {sum(r['set_ok'] for r in some)} |")
    return lines


def class_table(rows):
    """Confusion: truth against what was chosen."""
    lines = ["| truth | cases | d' | detected | named first | chosen (cases) |", "|---" * 6 + "|"]
    groups = {}
    for r in rows:
        if r["family"] in ("single", "outside", "berthing", "inverse-crime", "pair", "decoy") and r["truth"]:
            groups.setdefault(" + ".join(sorted(r["truth"])) + (" (level 1)" if r["level"] == 1 else ""), []).append(r)
    for truth, some in sorted(groups.items()):
        picks = Counter("failed" if r["failed"] else " + ".join(sorted(r["chosen"])) or f"none, {r['verdict']}" for r in some)
        primes = sorted(r["d_prime"] for r in some if r["d_prime"] is not None)
        span = f"{primes[0]:.0f} to {primes[-1]:.0f}" if primes else "–"
        lines.append(f"| {truth} | {len(some)} | {span} | {sum(r['detected'] for r in some)} | {sum(r['first'] for r in some)} | "
                     + "; ".join(f"{name} ({n})" for name, n in picks.most_common(6)) + " |")
    return lines


def alarm_table(rows):
    lines = ["| case | ship | maneuvers | chosen | p |", "|---" * 5 + "|"]
    for r in nulls_of(rows):
        if r["alarm"]:
            lines.append(f"| {r['id']} | {r['ship']} | {r['campaign']} | {' + '.join(r['chosen']) or '–'} | {r.get('p_value') or 0:.2g} |")
    return lines if len(lines) > 2 else ["None."]


def reliability_table(rows):
    lines = ["| stated | cases | mean stated | right |", "|---" * 4 + "|"]
    return lines + [f"| {low:.1f} to {high:.1f} | {n} | {said:.2f} | {was:.2f} |" for low, high, n, said, was in scores.calibration(rows)[1]]


def p_table(rows):
    """p-values of nulls against their level: how far below a composite null leaves them."""
    sizes = scores.sizes_of_p(nulls_of(rows))
    if not sizes[0][2]:
        return NOT_YET
    return ["| level | nulls with p up to it | of the level |", "|---" * 3 + "|"] + [f"| {a:g} | {rate(k, n)} | {k / n / a:.2f} |" for a, k, n in sizes]


def where_table(rows):
    """Where and when, against the truth, of single effects that the report speaks of."""
    lines = ["| | cases | reached |", "|---" * 3 + "|"]
    given = lambda key: [r["located"][key] for r in rows if r["located"].get(key) is not None]
    for words, key in (("overlap in time of what was located, intersection over union, mean", "overlap"), ("the same of an effect that was named", "overlap_named")):
        values = given(key)
        lines.append(f"| {words} | {len(values)} | {f'{statistics.mean(values):.2f}' if values else '–'} |")
    axis = given("axis")
    lines.append(f"| axis with most of the effect | {len(axis)} | {rate(sum(axis), len(axis))} |")
    for words, key, unit in (("difference of the axes' shares, median", "shares_off", ""), ("point of attack, median error", "x_F_off", " L")):
        values = given(key)
        lines.append(f"| {words} | {len(values)} | {f'{statistics.median(values):.2f}{unit}' if values else '–'} |")
    return lines


def inclusion_table(rows):
    """Stated probability of every effect and fault that there is (0 where a report does not list it), against whether it acts."""
    pairs = [{"probability": p, "right": acts} for r in rows for p, acts in r["inclusion"]]
    if not pairs:
        return ["No report has inclusion probabilities yet."]
    error, bins = scores.calibration(pairs)
    return ["| stated | effects | mean stated | act |", "|---" * 4 + "|"] + [f"| {low:.1f} to {high:.1f} | {n} | {said:.3f} | {was:.3f} |" for low, high, n, said, was in bins] + [
        "", f"Calibration error {error:.3f} over {len(pairs)} effects of {sum(bool(r['inclusion']) for r in rows)} cases."]


def coverage_table(rows):
    """95 % intervals by class, level 2."""
    by = {}
    for q in (q for r in rows if r["level"] == 2 for q in r["quantities"]):
        by.setdefault(q[0], []).append(q)
    if not by:
        return NOT_YET
    lines = ["| effect | parameters | 95 % intervals that cover | relative error, median |", "|---" * 4 + "|"]
    for name, some in sorted(by.items()):
        covered, off = [q[4] for q in some if q[4] is not None], [q[5] for q in some if q[5] is not None]
        lines.append(f"| {name} | {len(some)} | {rate(sum(covered), len(covered))} | {f'{100 * statistics.median(off):.0f} %' if off else '–'} |")
    return lines


def file_table(rows):
    """What is said of ship files, where coefficients are drawn from what the file states and where it misstates them."""
    lines = ["| ship files | cases | `off` | `as-stated` | `cannot-tell` | false alarms of the verdict |", "|---" * 6 + "|"]
    for words, some in (("that state what was drawn, nothing missing", nulls_of(rows)), ("that misstate it, nothing missing", [r for r in rows if r["family"] == "misstated"])):
        of = Counter(r["ship_file"] for r in some)
        lines.append(f"| {words} | {len(some)} | {rate(of['off'], len(some))} | {of['as-stated']} | {of['cannot-tell']} | {sum(r['alarm'] for r in some)} |")
    return lines


def next_table(trials):
    """Right names after one more maneuver: as promised, and as it came; trials as advised.py writes them. A promise is over everything that may be,
    so that it is held against cases with and without something missing together."""
    if not trials:
        return NOT_YET
    lines = ["| one more recording | cases | right before | promised | right after |", "|---" * 5 + "|"]
    of = {"": trials, ", something missing": [t for t in trials if t["missing"]], ", nothing missing": [t for t in trials if not t["missing"]]}
    for words, pick in (("the maneuver that is advised", lambda t: t["advised"]), ("one of the menu at random", lambda t: t["random"]), ("the best of all", None)):
        for which, some in of.items():
            rows = []
            for t in some:
                after = t["right_after"]
                if pick is None:
                    if set(t["menu"]) <= set(after):
                        rows.append((t["right_before"], None, any(after[m] for m in t["menu"])))
                elif pick(t) in after:
                    rows.append((t["right_before"], t["promised"].get(pick(t)), after[pick(t)]))
            if rows:
                said = [r[1] for r in rows if r[1] is not None]
                lines.append(f"| {words}{which} | {len(rows)} | {rate(sum(r[0] for r in rows), len(rows))} | {f'{statistics.mean(said):.2f}' if said else '–'} "
                             f"| {rate(sum(r[2] for r in rows), len(rows))} |")
    return lines


def rely_lines(rows):
    """What a user can rely on, from the same rows as the tables."""
    nulls, single = nulls_of(rows), [r for r in rows if r["family"] == "single"]
    strong = [r for r in single if (r["d_prime"] or 0.0) >= 12.0]
    named = [r for r in rows if r["truth"] and r["family"] != "outside" and set(r["chosen"]) - {"unknown"}]
    pairs, outs = [r for r in rows if r["family"] == "pair"], [r for r in rows if r["family"] == "outside"]
    covered = [q[4] for r in rows if r["level"] == 2 for q in r["quantities"] if q[4] is not None]
    runs = [i for i in (r.get("improvement") or {} for r in rows) if None not in (i.get("before"), i.get("after"))]
    some = lambda which, of: rate(sum(which(r) for r in of), len(of))
    lines = [f"Where nothing is missing, something is claimed in {some(lambda r: r['alarm'], nulls)} of the cases, and `undecided` said in {some(lambda r: r['verdict'] == 'undecided', nulls)}.",
             f"Where something in the catalogue acts, a name that is given is the right one, or one of two right ones, in {some(lambda r: r['outcome'] in ('right', 'some of it'), named)}.",
             f"An effect that stands out (d' >= 12) is detected in {some(lambda r: r['detected'], strong)} and named first in {some(lambda r: r['first'], strong)}.",
             f"A weaker one (d' below 6) is detected in {some(lambda r: r['detected'], [r for r in single if (r['d_prime'] or 0.0) < 6.0])}: no answer there is no proof of absence.",
             f"Of two effects one is named first in {some(lambda r: r['first'], pairs)}, both and no other in {some(lambda r: r['both'], pairs)}.",
             f"What the catalogue lacks is flagged `unknown` in {some(lambda r: r['unknown'], outs)} and given a wrong name in {some(lambda r: r['outcome'] in ('wrong', 'right and wrong'), outs)}.",
             f"A 95 % interval of a rightly named effect covers in {rate(sum(covered), len(covered))}.",
             f"With ship.json free runs of recordings that the tool has never seen get worse in {rate(sum(i['after'] > i['before'] + 0.05 for i in runs), len(runs))}.",
             f"A run fails in {some(lambda r: r['failed'], rows)}.",
             "What recordings could show at all, and what the method loses of it, is in the tables of efficiencies below."]
    return ["- " + line for line in lines]
