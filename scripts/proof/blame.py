"""Where right answers are lost: tables from what ladder computed and what the tool's reports say.

    read(OUT) -> cases: key facts, rungs (shares of right answers by question), distances
    efficiency(cases, question): right answers over what the rung `priors` reaches, with intervals
    report(cases): all tables as Markdown
"""

import json

import bayes
import law
import physics
import rungs
import scores
import sets

COMPUTED = rungs.RUNGS[:4]
WORDS = {"truth": "could not be known (P*)", "forms": "forms of the tool", "priors": "priors of the tool", "noise": "noise estimated", "fitted": "not fitted",
         "ranked": "not ranked first", "chosen": "rule of decision"}
ASKED = {"detected": "detected", "first": "named first", "set": "right set", "accepted": "truth in the accepted set", "both": "both of a pair"}
BINS = ((0.0, 2.0), (2.0, 3.0), (3.0, 5.0), (5.0, 10.0), (10.0, float("inf")))


def read(out):
    """Cases whose ladder is computed; the tool's rungs where there is a report."""
    cases = []
    for file in sorted((out / "ladder").glob("*.json")):
        kept = json.loads(file.read_text(encoding="utf-8"))
        if kept["version"] != rungs.version():
            continue
        key = json.loads((out / "keys" / file.name).read_text(encoding="utf-8"))
        case = {"id": key["id"], "family": key["family"], "names": key["names"], "rungs": kept["rungs"], "cpu_s": kept["cpu_s"], "campaign": key["campaign"],
                "level": key["level"], "misstated": key.get("misstated"), "ship_file": None, "failed": False, "d_prime": min((t["d_prime"] or 0.0 for t in key["truth"].values()), default=None), "tool": None}
        drawn = kept["rungs"]["truth"]["law"]
        case["d_det"], case["d_name"] = bayes.separation(drawn["nats_detected"]), bayes.separation(drawn["nats_named"]) if "nats_named" in drawn else None
        second = kept["rungs"]["truth"].get("nats_second")
        case["d_second"] = None if second is None else bayes.separation(second)
        report, run = out / "results" / key["id"] / "report.json", out / "results" / key["id"] / "run.json"
        if run.exists():
            failed = json.loads(run.read_text(encoding="utf-8"))["exit_code"] != 0 or not report.exists()
            told = {} if failed else json.loads(report.read_text(encoding="utf-8"))
            case["tool"], case["ship_file"], case["failed"] = said(key, told), (told.get("ship_file") or {}).get("state", "not said"), failed
        cases.append(case)
    return cases


def said(key, report):
    """The tool's rungs, read from its report by the rules of scores.py: right or not (0 or 1) by question. Where nothing is missing `detected` is an alarm."""
    truth, chosen = set(rungs.truth_names(key)), scores.chosen_of(report)
    named = [n for n in chosen if n != law.UNKNOWN]
    listed = [set(scores.effects_of(h)) for h in report.get("hypotheses") or []]
    listed += [{f.get("name")} for f in (report.get("audit") or {}).get("faults") or []] + ([set(chosen)] if chosen else [])
    ranked = sorted(report.get("hypotheses") or [], key=lambda h: -(h.get("probability") or 0.0))
    top = set(scores.effects_of(ranked[0])) if ranked else set()
    claimed = set(named) if named else set(chosen)  # with a name, `unknown` says that it is not all
    if truth:
        is_detected = scores.outcome(report, tuple(truth)) in scores.DETECTED
    else:
        is_detected = report.get("verdict") == "mismatch" or bool(chosen)
    order = [n for h in ranked for n in scores.effects_of(h)]
    first = bool(truth) and next(iter(named or chosen), None) in truth
    right = bool(truth) and claimed == truth
    is_accepted = right or truth in [set(s) for s in scores.accepted_set(report)]
    out = {"fitted": {"detected": any(listed), "first": any(truth & s for s in listed), "set": truth in listed, "accepted": truth in listed, "both": truth in listed},
           "ranked": {"detected": bool(top) or bool(chosen), "first": first or bool(order) and order[0] in truth, "set": right or top == truth,
                      "accepted": is_accepted or top == truth, "both": right or top == truth},
           "chosen": {"detected": is_detected, "first": first, "set": right, "accepted": is_accepted, "both": right}}
    return {rung: {q: float(x) for q, x in r.items() if q != "both" or len(truth) > 1} for rung, r in out.items()}


def share(case, rung, question, kind="own"):
    """Share of right answers of a rung; None where it was not computed or not asked."""
    if rung in COMPUTED or rung == "kinds":
        return case["rungs"].get(rung, {}).get(kind, {}).get(question)
    return None if case["tool"] is None else case["tool"][rung].get(question)


def acting(cases):
    return [c for c in cases if c["names"]]


def kind_of(case):
    return "out of the catalogue" if set(case["names"]) & set(physics.OUTSIDE) else "pairs" if len(case["names"]) > 1 else "sensors" if set(case["names"]) & set(
        physics.SENSORS) else "single effects"


def lost_at(case, question):
    """The first rung that is more often wrong than right in this case; None where the answer is right or the tool was not run."""
    if case["tool"] is None or share(case, "chosen", question) is None or share(case, "chosen", question) > 0.5:
        return None
    return next(r for r in rungs.RUNGS if share(case, r, question) < 0.5)


def efficiency(cases, question, against="priors"):
    """(right answers, what the rung reaches, ratio, low, high): Wilson's 95 % limits of the share of right answers, by the share that is within reach."""
    pairs = [(share(c, "chosen", question), share(c, against, question)) for c in cases]
    pairs = [(a, b) for a, b in pairs if a is not None and b is not None]
    right, reach = sum(a for a, _ in pairs), sum(b for _, b in pairs)
    if reach < 0.5:
        return right, reach, None, None, None
    low, high = scores.wilson(right, len(pairs))
    return right, reach, right / reach, low * len(pairs) / reach, high * len(pairs) / reach


def limits(case, question):
    """Which distance a question is binned by."""
    return case["d_det"] if question == "detected" else case["d_second"] if question == "both" else case["d_name"]


def efficiency_table(cases):
    lines = ["| | distance | cases | right | within reach | P* | efficiency |", "|---" * 7 + "|"]
    for kind in ("single effects", "sensors", "pairs", "out of the catalogue"):
        some = [c for c in acting(cases) if kind_of(c) == kind and c["tool"] is not None]
        for question in ASKED:
            asked = [c for c in some if share(c, "priors", question) is not None]
            bins = [(None, asked)] + [((low, high), [c for c in asked if (d := limits(c, question)) is not None and low <= d < high]) for low, high in BINS]
            for span, inside in bins if asked else []:
                if not inside:
                    continue
                against = "kinds" if kind == "out of the catalogue" else "priors"
                right, reach, ratio, low, high = efficiency(inside, question, against)
                best = sum(share(c, "truth", question) for c in inside)
                words = "all" if span is None else f"{span[0]:g} to {span[1]:g}" if span[1] < 1e9 else f"above {span[0]:g}"
                said = f"{100 * ratio:.0f} % ({100 * low:.0f} to {100 * high:.0f})" if ratio is not None else "–"
                lines.append(f"| {kind}: {ASKED[question]} | {words} | {len(inside)} | {right:.0f} | {reach:.1f} | {best:.1f} | {said} |")
    return lines


def known_table(cases):
    """What can be known, by the d' of the key; apart where an effect only multiplies what a coefficient multiplies."""
    lines = ["| single effects | d' of the key | cases | P*, of the law: detected | named first | exact inference, of the case's own: detected | named first |", "|---" * 7 + "|"]
    singles = [c for c in acting(cases) if kind_of(c) in ("single effects", "sensors")]
    for words, some in (("that multiply a coefficient", [c for c in singles if c["names"][0] in sets.SLABS]), ("all others", [c for c in singles if c["names"][0] not in sets.SLABS])):
        for low, high, label in ((0.0, 4.5, "about 3"), (4.5, 9.0, "6"), (9.0, 19.0, "12"), (19.0, float("inf"), "30")):
            inside = [c for c in some if low <= c["d_prime"] < high]
            if inside:
                mean = lambda r, q, kind: f"{100 * sum(share(c, r, q, kind) for c in inside) / len(inside):.0f} %"
                lines.append(f"| {words} | {label} | {len(inside)} | {mean('truth', 'detected', 'law')} | {mean('truth', 'first', 'law')} | "
                             f"{mean('priors', 'detected', 'own')} | {mean('priors', 'first', 'own')} |")
    return lines


def blame_table(cases):
    """Misses by the first rung that loses them."""
    lines = ["| | cases | right | " + " | ".join(WORDS[r] for r in rungs.RUNGS) + " |", "|---" * (3 + len(rungs.RUNGS)) + "|"]
    for kind in ("single effects", "sensors", "pairs", "out of the catalogue"):
        for question, words in ASKED.items():
            some = [c for c in acting(cases) if kind_of(c) == kind and share(c, "chosen", question) is not None]
            if some:
                lost = [lost_at(c, question) for c in some]
                lines.append(f"| {kind}: {words} | {len(some)} | {sum(x is None for x in lost)} | " + " | ".join(str(lost.count(r)) for r in rungs.RUNGS) + " |")
    return lines


def expected_table(cases):
    """Expected right answers, rung by rung: what each step costs (below zero: wins)."""
    lines = ["| | cases | P*, law | " + " | ".join(rungs.RUNGS) + " |", "|---" * (3 + len(rungs.RUNGS)) + "|"]
    for kind in ("single effects", "sensors", "pairs", "out of the catalogue"):
        for question, words in ASKED.items():
            some = [c for c in acting(cases) if kind_of(c) == kind and share(c, "truth", question) is not None]
            if some:
                cells = [f"{sum(share(c, 'truth', question, 'law') for c in some):.1f}"]
                for r in rungs.RUNGS:
                    known = [c for c in some if share(c, r, question) is not None]
                    cells.append("–" if not known else f"{sum(share(c, r, question) for c in known):.1f}" + (f" of {len(known)}" if len(known) < len(some) else ""))
                lines.append(f"| {kind}: {words} | {len(some)} | " + " | ".join(cells) + " |")
    return lines


def null_table(cases):
    """Alarms where nothing is missing: by construction 1 % over the law, here of the cases' own coefficients and forms."""
    lines = ["| nothing is missing | cases | " + " | ".join(COMPUTED) + " | the tool |", "|---" * 7 + "|"]
    groups = sorted({c["family"] for c in cases if not c["names"]})  # files that misstate are among them: there an alarm tells a wrong file from no missing physics
    for family in groups:
        some = [c for c in cases if c["family"] == family and not c["names"]]
        cells = [f"{100 * sum(share(c, r, 'detected') for c in some) / len(some):.1f} %" for r in COMPUTED]
        run = [c for c in some if c["tool"] is not None]
        lines.append(f"| {family} | {len(some)} | " + " | ".join(cells) + f" | {sum(share(c, 'chosen', 'detected') for c in run):.0f} of {len(run)} |")
    return lines


def ship_file_table(cases):
    """What the tool says of the ship's file, where it misstates how well its coefficients are known and where it does not."""
    words = {"all": "all widths a third of the true ones", "one": "one coefficient off by five widths", None: "as drawn"}
    lines = ["| the ship's file | cases | `off` | `cannot-tell` | `as-stated` | names something missing or at fault |", "|---" * 6 + "|"]
    for kind in ("all", "one", None):
        some = [c for c in cases if c["misstated"] == kind and c["tool"] is not None and (kind or not c["names"])]
        if some:
            said = [c["ship_file"] for c in some]
            lines.append(f"| {words[kind]} | {len(some)} | {said.count('off')} | {said.count('cannot-tell')} | {said.count('as-stated')} | "
                         f"{sum(share(c, 'chosen', 'detected') for c in some):.0f} |")
    return lines


def parts(cases):
    """Tables by the names of their places in docs/proof.md."""
    if not cases:
        return {}
    exact = sum(max(c["rungs"]["priors"]["own"]["se"].values()) for c in cases) / len(cases)
    of_law = sum(max(c["rungs"]["truth"]["own"]["se"].values()) for c in cases) / len(cases)
    head = [f"{len(cases)} cases, {sum(c['tool'] is not None and not c['failed'] for c in cases)} of them with a report. Monte Carlo error of a case's share: {of_law:.3f} (generating law), "
            f"{exact:.3f} (exact inference) at most, in the mean. {sum(c['cpu_s'] for c in cases) / len(cases):.0f} s a case."]
    return {"ladder": head, "what can be known": known_table(cases), "blame": blame_table(cases), "expected answers": expected_table(cases), "efficiency": efficiency_table(cases),
            "nulls of the ladder": null_table(cases), "ship files": ship_file_table(cases)}


def report(cases):
    if not cases:
        return ["No case has a ladder yet."]
    return [line for name, lines in parts(cases).items() for line in (f"## {name}", "", *lines, "")]
