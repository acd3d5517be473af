"""What the paper says of the number of members, of the two kinds of sampling, of the distances and of predictions, at model scale."""

import numpy as np

from claim import NAMES, Claim, number, per_set, rank_correlation, root_mean_square
from results import SAMPLINGS, SETS

TIMES = 10.0  # "more than 10 times", the paper's
ALIKE = 3.0  # times: L_Maha of sets that differ less count as alike; ours
LEVEL = 0.5  # of the fall of a law c/M: what L_Maha may still change in the last fifth of the members, where it comes to a limit; ours
SAME = 0.2  # of its value: what L_Eucl may change with more members; ours
FOLLOWS = 0.5  # rank correlation from which one quantity follows another; ours
MOSTLY = 0.9  # share of sequences; ours


def median(table, m):
    """Over the repeats, for m members."""
    return float(np.median(table[m - 1]))


def half_range(table, m):
    """Half the range of the repeats by their median."""
    return float(np.ptp(table[m - 1]) / median(table, m) / 2)


def bias_of_members(results, section):
    last = results.members
    for kind, name in NAMES.items():
        eucl = results.sampling(kind, "L_eucl")
        ratios = {data: (median(eucl[data], last) / median(eucl[data], 1), half_range(eucl[data], 1)) for data in SETS}
        yield Claim(section, f"{name}: more members do not change L_Eucl", "sampling",
                    f"from M = 1 to all, its median over the repeats changes by at most {SAME:.0%} (ours); beside it half the range of the repeats at M = 1",
                    f"M = {last}: {per_set({data: f'×{ratio:.2f} (±{within:.2f})' for data, (ratio, within) in ratios.items()})}",
                    {data: bool(abs(ratio - 1.0) <= SAME) for data, (ratio, _) in ratios.items()})


def spread_of_members(results, section):
    last = results.members
    for kind, name in NAMES.items():
        maha = results.sampling(kind, "L_maha")
        defined = np.flatnonzero(np.all([np.isfinite(maha[data]).all(axis=1) for data in SETS], axis=0)) + 1
        first = int(defined[0]) if len(defined) else last
        before = max(first, last - max(1, last // 5))
        level = LEVEL * (1.0 - before / last)
        numbers, holds = {}, {}
        for data in SETS:
            values = [median(maha[data], m) for m in (first, before, last)]
            numbers[data] = " to ".join(number(value) for value in (values[0], values[2])) + f" (from M = {before}: ×{values[2] / values[1]:.2f})"
            holds[f"{data} falls"] = bool(values[2] < values[0])
            holds[f"{data} levels off"] = bool(before > first and abs(values[2] / values[1] - 1.0) <= level)
        yield Claim(section, f"{name}: with more members L_Maha falls towards a limit", "sampling",
                    f"it is less at M = {last} than at the first M where it is defined, here {first}; in the last fifth of the members it changes "
                    f"by at most {level:.0%}, {LEVEL:g} of what a law c/M would (ours)", per_set(numbers), holds if len(defined) > 1 else None)


def spread_over_members(results):
    """What the paper concludes from L_Maha: the variance of the particles."""
    last, section = results.members, "5.3 predictions, scores, 1"
    by_divisor = np.sqrt((1.0 - 1.0 / last) / (1.0 - 1.0 / 2.0))
    for kind, name in NAMES.items():
        spread = results.spreads(kind)
        ratios = {data: median(spread[data], last) / median(spread[data], 2) for data in SETS}
        yield Claim(section, f"{name}: with more members the spread of the particles grows", "sampling",
                    f"the root mean square of the spread of velocities, median over the repeats, grows by more from M = 2 to {last} than the divisor of the "
                    f"variance alone makes it grow, ×{by_divisor:.2f} (ours)",
                    f"M = 2 to {last}: {per_set({data: f'×{ratio:.2f}' for data, ratio in ratios.items()})}", {data: bool(ratio > by_divisor) for data, ratio in ratios.items()})


def spread_over_sets(results):
    last, section = results.members, "5.3 predictions, scores, 3"
    for kind, name in NAMES.items():
        spread = {data: median(results.spreads(kind)[data], last) for data in SETS}
        yield Claim(section, f"{name}: the farther a test set is from the training data, the larger is the spread", "distances",
                    f"at M = {last} the root mean square of the spread of velocities is larger in each set that is not distributed as Train-B than in Test-B (ours)",
                    per_set(spread), {data: bool(spread[data] > spread["Test-B"]) for data in SETS if data != "Test-B"})


def samplings(results):
    last = results.members
    eucl = {kind: results.sampling(kind, "L_eucl") for kind in SAMPLINGS}
    ratios = {data: (median(eucl["ts-inf"][data], last) / median(eucl["ts1"][data], last), half_range(eucl["ts-inf"][data], last)) for data in SETS}
    section = "5.3 predictions, scores, 2"
    yield Claim(section, "L_Eucl hardly differs between TS∞ and TS1", "sampling", f"at M = {last} by at most half the range of the repeats (ours)",
                per_set({data: f"×{ratio:.2f} (±{within:.2f})" for data, (ratio, within) in ratios.items()}),
                {data: bool(abs(ratio - 1.0) <= within) for data, (ratio, within) in ratios.items()})
    maha = {kind: {data: median(results.sampling(kind, "L_maha")[data], last) for data in SETS} for kind in SAMPLINGS}
    yield Claim(section, "With enough members TS∞ has the smaller L_Maha", "sampling", f"at M = {last} (ours)",
                per_set({data: f"{number(maha['ts-inf'][data])} against {number(maha['ts1'][data])}" for data in SETS}),
                {data: bool(maha["ts-inf"][data] < maha["ts1"][data]) for data in SETS})
    spread = {kind: {data: median(results.spreads(kind)[data], last) for data in SETS} for kind in SAMPLINGS}
    yield Claim(section, "With enough members TS∞ has the larger spread", "sampling", f"root mean square of the spread of velocities at M = {last} (ours)",
                per_set({data: f"{number(spread['ts-inf'][data])} against {number(spread['ts1'][data])}" for data in SETS}),
                {data: bool(spread["ts-inf"][data] > spread["ts1"][data]) for data in SETS})


def test_sets(results):
    last = results.members
    section = "5.3 predictions, scores, 3"
    for kind, name in NAMES.items():
        eucl, maha = ({data: median(results.sampling(kind, key)[data], last) for data in SETS} for key in ("L_eucl", "L_maha"))
        others = {data: eucl["Test-ZT"] / eucl[data] for data in SETS if data != "Test-ZT"}
        yield Claim(section, f"{name}: L_Eucl of Test-ZT is more than {TIMES:g} times that of the others", "sampling", f"at M = {last} (ours)",
                    f"{per_set(eucl)}; times Test-B {others['Test-B']:.3g}, Test-R {others['Test-R']:.3g}",
                    {f"against {data}": bool(ratio > TIMES) for data, ratio in others.items()})
        ratio = max(maha.values()) / min(maha.values())
        yield Claim(section, f"{name}: L_Maha does not differ much between the data sets", "sampling",
                    f"at M = {last} the largest is less than {ALIKE:g} times the least (ours)", f"{per_set(maha)}; {ratio:.3g} times", bool(ratio < ALIKE))


def correlations(scores, sets, section, figure):
    """scores: of a kind of sampling, {data set: entry of its metrics file}"""
    found = {kind: {data: scores(kind)[data]["correlation_eucl_maha"] for data in sets} for kind in SAMPLINGS}
    found = {kind: {data: np.nan if value is None else value for data, value in by_set.items()} for kind, by_set in found.items()}
    yield Claim(section, "The correlation of the two distances is smaller for TS∞ than for TS1", figure, "Pearson's, over all points with k >= 1; of the first repeat",
                "; ".join(f"{NAMES[kind]}: {per_set({data: f'{value:.2f}' for data, value in found[kind].items()})}" for kind in SAMPLINGS),
                {data: bool(found["ts-inf"][data] < found["ts1"][data]) for data in sets})


def growth_of_spread(points):
    """Median spread of the quarter of the points with the largest bias, by that of the quarter with the least."""
    low, high = np.nanquantile(points["eucl"], (0.25, 0.75))
    return float(np.median(points["spread"][points["eucl"] >= high]) / np.median(points["spread"][points["eucl"] <= low]))


def spread_follows_bias(results, folder, sets, section, figure):
    found = {kind: {data: growth_of_spread(results.points(folder, kind)[data]) for data in sets} for kind in SAMPLINGS}
    yield Claim(section, "The spread is small where the bias is small, and large where it is large; with TS∞ more than with TS1", figure,
                "first repeat: median spread in the quarter of the points with the largest d_E, by that in the quarter with the least: above 1, and larger for TS∞ (ours)",
                "; ".join(f"{NAMES[kind]}: {per_set({data: f'×{value:.2f}' for data, value in found[kind].items()})}" for kind in SAMPLINGS),
                {**{f"{data} grows": found["ts-inf"][data] > 1.0 for data in sets},
                 **{f"{data} more with TS∞": found["ts-inf"][data] > found["ts1"][data] for data in sets}})


def tracks(results):
    section = "5.3 predictions, examples"
    figure = "prediction-*"
    names, infinity = results.sequences("distances", "ts-inf", SETS)
    of_one, one = results.sequences("distances", "ts1", SETS)
    if names != of_one:
        raise ValueError("distances/ts1.csv holds other sequences than distances/ts-inf.csv")
    follows = rank_correlation(infinity["position_sd_m"], infinity["spread"])
    fits = rank_correlation(infinity["position_sd_m"], infinity["position_error_m"])
    where = f"over the {len(names)} sequences of the test sets, TS∞, first repeat; positions at the ends, velocities over the whole"
    yield Claim(f"{section}, 1", "The predicted pose varies as the predicted velocities do", figure,
                f"{where}: rank correlation of the positions' spread with that of the velocities at least {FOLLOWS:g} (ours)", f"{follows:.2f}", bool(follows >= FOLLOWS))
    yield Claim(f"{section}, 1", "Where the pose varies little the prediction is accurate, and where it varies much it is not", figure,
                f"{where}: rank correlation of spread and error of the position at least {FOLLOWS:g} (ours)", f"{fits:.2f}", bool(fits >= FOLLOWS))
    less = float(np.mean(one["position_sd_m"] < infinity["position_sd_m"]))
    slower = float(np.mean(one["spread"] < infinity["spread"]))
    yield Claim(f"{section}, 2", "TS1 varies less than TS∞: its particles keep close to their mean", figure,
                f"in at least {MOSTLY:.0%} of the sequences the positions' spread at the end, and that of the velocities, are smaller (ours)",
                f"position {less:.0%}, velocities {slower:.0%}", {"position": less >= MOSTLY, "velocities": slower >= MOSTLY})


def like_training(results, sets, section):
    """Berthings, whose states are in the training data, against zigzags and turning circles, whose are not."""
    points = results.points("distances", "ts-inf")
    eucl, spread = ({data: root_mean_square(points[data][key]) for data in sets} for key in ("eucl", "spread"))
    rest = [data for data in sets if data != "Test-B"]
    yield Claim(section, "Predictions are accurate with little spread where states are as in training (berthings), else less accurate with more spread",
                "distances", f"root mean squares of d_E and of the spread, TS∞: both least in Test-B, of {', '.join(sets)} (ours)",
                f"d_E: {per_set(eucl)}; spread: {per_set(spread)}",
                {**{f"accuracy against {data}": eucl["Test-B"] < eucl[data] for data in rest}, **{f"spread against {data}": spread["Test-B"] < spread[data] for data in rest}})


def predictions(results):
    yield from bias_of_members(results, "5.3 predictions, scores, 1")
    yield from spread_of_members(results, "5.3 predictions, scores, 1")
    yield from spread_over_members(results)
    yield from samplings(results)
    yield from test_sets(results)
    yield from spread_over_sets(results)
    section = "5.3 predictions, distances, 1"
    yield from correlations(lambda kind: results.scores(f"sampling/{kind}-{results.members}-1"), SETS, section, "distances")
    yield from spread_follows_bias(results, "distances", SETS, section, "distances")
    yield from tracks(results)
