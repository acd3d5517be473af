"""What the paper says of the navigation data of the full-scale ship, where predictions start from observed states and are laid beside observed ones."""

import numpy as np

from claim import Claim, number
from claims_of_predictions import correlations
from results import FULL_SET

USUAL = 0.25  # of d_E, the paper's
NEARLY_1 = 0.75, 1.25  # of d_E: what is "nearly 1.0"; ours
ALIKE = 2.0  # times: Mahalanobis distances of the two scales that differ less are not told apart; ours
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
                f"more than half of the points; the largest is from {NEARLY_1[0]:g} to {NEARLY_1[1]:g} (ours)", f"{share:.0%} of the points; largest {number(largest)}",
                {"most": share > 0.5, "some": NEARLY_1[0] <= largest <= NEARLY_1[1]})


def berthings(results):
    section = "6.2 navigation data, examples"
    names, found = results.sequences("full-scale", "ts-inf", (FULL_SET,))
    worst = int(np.argmax(found["eucl"]))
    others = np.arange(len(names)) != worst
    usual = {key: float(np.median(found[key][others])) for key in ("eucl", "spread", "bias_beyond_spread")}
    recording, sequence = names[worst].rsplit(" ", 1)
    numbers = (f"{recording}, sequence {sequence}: d_E {number(found['eucl'][worst])} against {number(usual['eucl'])}, spread {number(found['spread'][worst])} "
               f"against {number(usual['spread'])} of the median of the other {int(others.sum())}")
    yield Claim(f"{section}, 1", "A stretch of 700 s is predicted badly: the spread is large there, and in parts the bias is larger still", "full-scale-worst",
                "the sequence with the largest root mean square of d_E: its spread is above the median of the others, and so is the share of its points where d_E "
                "exceeds the spread (ours)",
                f"{numbers}; bias beyond the spread at {found['bias_beyond_spread'][worst]:.0%} of its points, {usual['bias_beyond_spread']:.0%} in the median",
                {"spread is large": bool(found["spread"][worst] > usual["spread"]),
                 "bias beyond it": bool(found["bias_beyond_spread"][worst] > usual["bias_beyond_spread"])})
    yield Claim(f"{section}, 2", "Elsewhere berthings are predicted accurately and with little spread", "full-scale-typical",
                f"medians of the other sequences: d_E and spread below {USUAL:g}, which the paper gives for most distances (ours)", numbers,
                {key: bool(usual[key] < USUAL) for key in ("eucl", "spread")})


def like_training(results, section):
    """The paper's second summary: full scale has the same accuracy, but the bias may be large beside the spread."""
    far = {name: float(np.mean(points["maha"][np.isfinite(points["maha"])] > FARTHEST)) for name, points in
           (("Test-B", results.points("distances", "ts-inf")["Test-B"]), (FULL_SET, results.points("full-scale", "ts-inf")[FULL_SET]))}
    yield Claim(section, "In navigation data the bias can be large beside the spread", "full-scale-distances",
                f"more points than at model scale have d_M > {FARTHEST:.2f}, which 1 % would have where spread and error agree (ours)",
                "; ".join(f"{name} {share:.0%}" for name, share in far.items()), far[FULL_SET] > far["Test-B"])


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
                "by the root mean square of d_E, the worst sequence is of a recording on which something acts that no column records, and the median of such "
                "sequences is larger than that of the others (ours)", numbers, holds)


def navigation(results):
    yield from distances(results)
    yield from berthings(results)
