"""What the paper says of the navigation data of the full-scale ship, where predictions start from observed states and are laid beside observed ones."""

import numpy as np

from claim import Claim, number
from claims_of_predictions import correlations
from results import ERRORS, FULL_SET

USUAL = 0.25  # of d_E, the paper's
NEARLY_1 = 0.75, 1.25  # of d_E: what is "nearly 1.0"; ours
STRETCH_S = 100.0, 700.0  # the paper's
BAD = 2.0  # times the usual error; ours
MOSTLY = 0.9  # share of points; ours
ALIKE = 2.0  # times: Mahalanobis distances of the two scales that differ less count as alike; ours
FARTHEST = float(np.sqrt(11.344866730144373))  # d_M that 1 % of the points exceed where spread and error agree


def distances(results):
    section = "6.2 navigation data, distances"
    yield from correlations(lambda kind: results.scores(f"full-scale/{kind}"), (FULL_SET,), f"{section}, 1", "full-scale-distances")
    full, model = results.points("full-scale", "ts-inf")[FULL_SET], results.points("distances", "ts-inf")["Test-B"]
    medians = [float(np.nanmedian(points["maha"])) for points in (full, model)]
    ratio = max(medians) / min(medians)
    yield Claim(f"{section}, 1", "The Mahalanobis distances are about those of the simulated model ship", "full-scale-distances",
                f"median of d_M, TS∞, against that of Test-B: less than {ALIKE:g} times (ours)", f"{number(medians[0])} against {number(medians[1])}", bool(ratio < ALIKE))
    share, largest = float(np.mean(full["eucl"] < USUAL)), float(np.nanmax(full["eucl"]))
    yield Claim(f"{section}, 2", f"Most Euclidean distances are below {USUAL:g}, and some reach nearly 1", "full-scale-distances",
                f"more than half of the points; the largest is from {NEARLY_1[0]:g} to {NEARLY_1[1]:g} (ours; our data are made so that this can be seen)", f"{share:.0%} of the points; largest {number(largest)}",
                {"most": share > 0.5, "some": NEARLY_1[0] <= largest <= NEARLY_1[1]})


def berthings(results):
    section = "6.2 navigation data, examples"
    names, found = results.sequences("full-scale", "ts-inf", (FULL_SET,))
    worst = int(np.argmax(found["eucl"]))
    others = np.arange(len(names)) != worst
    usual = {key: float(np.median(values[others])) for key, values in found.items()}
    recording, sequence = names[worst].rsplit(" ", 1)
    points = results.points("full-scale", "ts-inf")[FULL_SET]
    of_worst = np.array([name.rsplit(" ", 1)[0] == recording for name in points["sequence"]])
    far = points["t_s"][of_worst & (points["eucl"] >= USUAL)]
    in_time = float(np.mean((far >= STRETCH_S[0]) & (far <= STRETCH_S[1]))) if len(far) else 0.0
    when = f"d_E of {USUAL:g} and more from {far.min():.0f} to {far.max():.0f} s, {in_time:.0%} of it in the paper's stretch" if len(far) else f"d_E never {USUAL:g}"
    errors = ", ".join(f"{word} {number(found[key][worst])} ({number(usual[key])})" for word, key in zip(("u", "v_m", "r"), ERRORS))
    numbers = (f"{recording}, sequence {sequence}: d_E {number(found['eucl'][worst])} against {number(usual['eucl'])}, spread {number(found['spread'][worst])} "
               f"against {number(usual['spread'])} of the median of the other {int(others.sum())}")
    yield Claim(f"{section}, 1", "Between 100 and 700 s u, v_m and r of one berthing are predicted badly: the spread is large there, and in parts the bias is larger still",
                "full-scale-worst", "the sequence with the largest root mean square of d_E against the median of the others: errors of u, v_m and r more than "
                f"{BAD:g} times as large, the spread larger, and a larger share of points where d_E exceeds the spread; of the points of its recording with d_E of "
                f"{USUAL:g} and more at least {MOSTLY:.0%} lie between {STRETCH_S[0]:g} and {STRETCH_S[1]:g} s (ours)",
                f"{numbers}; errors (median of the others) {errors}; {when}; bias beyond the spread at {found['bias_beyond_spread'][worst]:.0%} of its points, "
                f"{usual['bias_beyond_spread']:.0%} in the median",
                {**{f"{word} is bad": bool(found[key][worst] > BAD * usual[key]) for word, key in zip(("u", "v_m", "r"), ERRORS)},
                 "100 to 700 s": in_time >= MOSTLY, "spread is large": bool(found["spread"][worst] > usual["spread"]),
                 "bias beyond it": bool(found["bias_beyond_spread"][worst] > usual["bias_beyond_spread"])})
    yield Claim(f"{section}, 2", "Elsewhere berthings are predicted accurately and with little spread", "full-scale-typical",
                f"medians of the other sequences: d_E below {USUAL:g}, which the paper gives for most distances, and a spread less than half of that sequence's "
                "(ours)", numbers, {"accurate": bool(usual["eucl"] < USUAL), "little spread": bool(usual["spread"] < found["spread"][worst] / 2.0)})


def like_training(results, section):
    """The paper's second summary: full scale has the same accuracy, but the bias may be large beside the spread."""
    full, model = results.points("full-scale", "ts-inf")[FULL_SET], results.points("distances", "ts-inf")["Test-B"]
    far = {name: float(np.mean(points["maha"][np.isfinite(points["maha"])] > FARTHEST)) for name, points in (("Test-B", model), (FULL_SET, full))}
    near = {key: float(np.mean(full[key] < USUAL)) for key in ("eucl", "spread")}
    yield Claim(section, "In navigation data, too, predictions are accurate with little spread, but the bias can be large beside it", "full-scale-distances",
                f"d_E, and the spread, are below {USUAL:g} at more than half of the points; more points than at model scale have d_M > {FARTHEST:.2f}, which 1 % "
                "would have where spread and error agree (ours)",
                f"d_E below {USUAL:g} at {near['eucl']:.0%}, spread at {near['spread']:.0%} of the points; d_M beyond: "
                + "; ".join(f"{name} {share:.0%}" for name, share in far.items()),
                {"accurate": near["eucl"] > 0.5, "little spread": near["spread"] > 0.5, "bias beyond it": far[FULL_SET] > far["Test-B"]})


def unrecorded(results, section):
    """The paper supposes it of its own data; ours say what acted where."""
    acting = results.unrecorded()
    names, found = results.sequences("full-scale", "ts-inf", (FULL_SET,))
    affected = np.array([name.rsplit(" ", 1)[0] in acting for name in names])
    numbers, holds = "no recording is known to be affected", None
    if affected.any() and not affected.all():
        there, elsewhere = (float(np.median(found["eucl"][which])) for which in (affected, ~affected))
        effects = ", ".join(f"{name} {'+'.join(types)}" for name, types in acting.items())
        worst = int(np.argmax(found["eucl"]))
        numbers = (f"{names[worst].rsplit(' ', 1)[0]} is the worst, {number(found['eucl'][worst])}; median {number(there)} over the {affected.sum()} sequences of "
                   f"{effects}, {number(elsewhere)} over the other {(~affected).sum()}")
        holds = {"the worst": bool(affected[worst]), "the median": there > elsewhere}
    yield Claim(section, "What is not observed (waves, currents, draft) may be behind a loss of accuracy", "full-scale-distances",
                "our data are made so that this can be seen: by the root mean square of d_E, the worst sequence is of a recording on which something acts that no column records, and the median of such "
                "sequences is larger than that of the others (ours)", numbers, holds)


def navigation(results):
    yield from distances(results)
    yield from berthings(results)
