"""What the paper says of the heading controller that an ensemble judges, with networks that were trained on port navigation."""

import dataclasses

import numpy as np

from claim import Claim, number
from claims_of_data import states_of_training
from results import UNITS

KEPT_DEG = 5.0  # a controller that works keeps the true ship's heading so close at the end; ours
MUCH = 2.0  # times what gains that work differ by; ours
QUIET = {"delta_p_deg": 5.0, "delta_s_deg": 5.0, "r_degps": 0.5}  # ranges in the second half of a run whose rudders and yaw rate are still; ours
ACCURATE = 0.1  # of the true score; ours
INSIDE = 0.01  # share of the time; ours
BEYOND = 0.05  # of the range of a state in Train-B: a state farther than that from all of it is not in the training data; ours
ERRORS = 2.0  # standard errors over the networks from which a difference is one; ours
GOOD = 1.1  # times the ship's score: not much worse; ours


class Sweeps:
    """Scores of all pairs of gains: of the true ship, of single networks, of the worst of few and of many."""

    def __init__(self, results, unit):
        self.unit, self.results = unit, results
        self.few, self.many = results.members, results.pool
        self.kp, self.kd, tables = results.sweep(self.few, unit)
        of_many = results.sweep(self.many, unit)[2]
        self.true = tables["score_true"]
        self.single = tables["score_member_00"]
        self.singles = np.array([table for name, table in of_many.items() if name.startswith("score_member_")])
        self.of_few = np.array([table for name, table in tables.items() if name.startswith("score_member_")])
        self.worst = {self.few: tables["score_worst"], self.many: of_many["score_worst"]}

    def optimism(self, tables, where=None):
        """How much better than the ship's a model's score is, in the mean; and in which share of the pairs at all."""
        gain = np.maximum(self.true - np.asarray(tables), 0.0)
        gain = gain if where is None else gain[..., where]
        return float(np.mean(gain)), float(np.mean(gain > 0.0))

    def within_training(self):
        """Pairs with which the true ship's states stay as in Train-B."""
        bounds = bounds_of_training(self.results)
        runs = list(self.results.true_runs(self.unit).items())
        kp, kd = (np.array([gains[i] for gains, _ in runs]) / UNITS[self.unit][1] for i in (0, 1))
        within = np.zeros(self.true.shape, dtype=bool)
        for i, j, (_, run) in zip(nearest(self.kd, kd), nearest(self.kp, kp), runs):
            within[i, j] = outside(run, bounds).mean() <= INSIDE
        return within

    def large(self):
        """Pairs of which both gains are in the upper half."""
        return np.outer(self.kd > np.median(self.kd), self.kp > np.median(self.kp))

    def slope(self):
        """Largest step of the true score to a neighboring pair, by the score."""
        steps = np.zeros_like(self.true)
        for axis in (0, 1):
            difference = np.abs(np.diff(self.true, axis=axis))
            before, after = ([(0, 0)] * 2 for _ in range(2))
            before[axis], after[axis] = (1, 0), (0, 1)
            steps = np.maximum(steps, np.maximum(np.pad(difference, before), np.pad(difference, after)))
        return steps / self.true


def nearest(grid, values):
    return np.abs(np.asarray(values)[:, None] - grid[None, :]).argmin(axis=1)


def bounds_of_training(results):
    """{state: (least, largest)} that still counts as in Train-B."""
    return {name: (low - BEYOND * (high - low), high + BEYOND * (high - low)) for name, (low, high) in states_of_training(results).items()}


def outside(run, bounds):
    return np.any([(run[name] < low) | (run[name] > high) for name, (low, high) in bounds.items()], axis=0)


def single_network(sweeps):
    amount, share = sweeps.optimism(sweeps.singles)
    large = sweeps.large()
    gain = np.maximum(sweeps.true - sweeps.singles, 0.0)
    inside, elsewhere = (gain[:, where].mean(axis=1) for where in (large, ~large))
    more = inside - elsewhere
    error = float(np.std(more, ddof=1) / np.sqrt(len(more)))
    yield Claim("5.4 controller, 1", "A single network predicts a better score than the ship gets, above all where both gains are large", "pd-scores",
                "it scores better than the ship with most pairs of gains, in the mean of all networks; where both gains are in their upper half by more, the "
                f"difference being beyond {ERRORS:g} standard errors over the networks (ours)",
                f"{share:.0%} of {sweeps.true.size} pairs, by {amount:.2f} rad s in the mean of all; {inside.mean():.2f} where both are large, else "
                f"{elsewhere.mean():.2f}: {more.mean():+.2f} (standard error {error:.2f} over {len(more)} networks)",
                {"optimistic": share > 0.5, "more where both are large": bool(more.mean() > ERRORS * error)})


def worst_of(sweeps, section, few):
    single, other = sweeps.optimism(sweeps.singles), sweeps.optimism(sweeps.worst[few])
    yield Claim(section, f"The worst of the particles, M = {few}, is too optimistic less often", "pd-scores",
                "share of the pairs of gains, and amount in the mean of all, are less than a single network's (ours)",
                f"{single[1]:.0%} of the pairs for a single network, {other[1]:.0%} for the worst; {single[0]:.2f} and {other[0]:.2f} rad s",
                {"share": other[1] < single[1], "amount": other[0] < single[0]} if single[1] > 0.0 else None)


def more_members(sweeps):
    few, many = (sweeps.optimism(sweeps.worst[count]) for count in (sweeps.few, sweeps.many))
    yield Claim("7 discussion, text", f"The worst of {sweeps.many} is too optimistic less often than that of {sweeps.few}", "pd-scores",
                f"share of the pairs of gains and amount are less; the {sweeps.few} are among the {sweeps.many}, so that only equality fails, and the size counts (ours)",
                f"{few[1]:.0%} and {many[1]:.0%} of the pairs; {few[0]:.3f} and {many[0]:.3f} rad s",
                {"share": many[1] < few[1], "amount": many[0] < few[0]} if few[1] > 0.0 else None)
    left = sweeps.worst[sweeps.many] < sweeps.true
    slope = sweeps.slope()
    there, usual = (float(np.median(slope[left])) if left.any() else float("nan"), float(np.median(slope)))
    yield Claim("7 discussion, text", f"Even the worst of {sweeps.many} is too optimistic at the border where small changes of gain cost much", "pd-scores",
                "some pairs are left, and there the ship's score changes more from pair to pair than at the median pair (ours)",
                f"{left.sum()} pairs left" + (f"; step to a neighbor {there:.1%} of the score, median {usual:.1%}" if left.any() else ""),
                there > usual if left.any() else None)


class Run:
    """The controller with both gains alike: on the true ship and on every member."""

    def __init__(self, results, gain, unit):
        models = dict(results.runs(gain, unit))
        self.true, self.members, bounds = models.pop("true"), list(models.values()), bounds_of_training(results)
        half = self.true["t_s"] >= self.true["t_s"][-1] / 2
        self.ranges = {name: float(np.ptp(self.true[name][half])) for name in QUIET}
        self.works = bool(np.abs(self.true["psi_deg"][-len(half) // 5:] - 90.0).max() <= KEPT_DEG)
        self.outside, self.members_outside = (float(np.mean([outside(run, bounds) for run in runs])) for runs in ([self.true], self.members))
        score = score_of(self.true)
        scores = np.array([score_of(run) for run in self.members])
        self.error = abs(float(scores.mean()) - score) / score
        self.spread = float(np.ptp(scores)) / score

    def numbers(self):
        ranges = ", ".join(f"{name} {number(value)}" for name, value in self.ranges.items())
        return (f"{'works' if self.works else 'does not work'}; ranges of the ship in the second half: {ranges}; beyond the states of Train-B "
                f"{self.outside:.0%} of the ship's time, {self.members_outside:.0%} of the members'; mean score off by {self.error:.0%}, members differ by {self.spread:.0%}")


def score_of(run):
    """L_PD of a run as sampled."""
    values = np.abs(np.radians(run["psi_deg"] - 90.0)) + np.abs(np.radians(run["r_degps"]))
    return float(np.sum((values[1:] + values[:-1]) / 2 * np.diff(run["t_s"])))


def gains_that_work(results, unit):
    good, bad = (Run(results, gain, unit) for gain in (60, 90))
    quiet = all(value <= QUIET[name] for name, value in good.ranges.items())
    yield Claim("5.4 controller, 3", "(60, 60): where the gains work, rudders and yaw rate move little, no states beyond Train-B are reached, and the score is accurate",
                "pd-runs", f"second half: ranges up to {QUIET['delta_p_deg']:g} deg, {QUIET['r_degps']:g} deg/s; whole run: at most {INSIDE:.0%} of its time more than "
                f"{BEYOND:.0%} of their range beyond the states of Train-B; members' mean score within {ACCURATE:.0%} (ours)", good.numbers(),
                {"still": quiet, "within Train-B": good.outside <= INSIDE, "accurate": good.error <= ACCURATE} if good.works else None)
    loud = all(value > QUIET[name] for name, value in bad.ranges.items())
    yield Claim("5.4 controller, 4", "(90, 90): where the gains do not work, rudders and yaw rate swing, states beyond Train-B are reached, the score is less "
                "accurate and differs much between particles", "pd-runs", "what (60, 60) is measured by, the other way round: ranges, states and accuracy beyond those "
                f"limits; members' scores differ by more than {MUCH:g} times as much; put to the test where the true ship does not keep its heading within {KEPT_DEG:g} deg at "
                f"the end, or its yaw rate swings by more than {QUIET['r_degps']:g} deg/s (ours)", bad.numbers(),
                {"swings": loud, "leaves Train-B": bad.outside > INSIDE, "less accurate": bad.error > ACCURATE, "differs much": bad.spread > MUCH * good.spread}
                if not bad.works or bad.ranges["r_degps"] > QUIET["r_degps"] else None)


def accuracy_of_the_worst(sweeps):
    within = sweeps.within_training()
    ratio = sweeps.worst[sweeps.few] / sweeps.true
    numbers, holds = f"with none of the {within.size} pairs does the ship stay there", None
    if within.any():
        there, elsewhere = (float(np.median(ratio[which])) if which.any() else float("nan") for which in (within, ~within))
        numbers, holds = f"{there:.2f} with {within.sum()} pairs; {elsewhere:.2f} with the others", there <= GOOD
    yield Claim("7 discussion, 4", "Where states that suit the control are in the training data, the worst case is not much worse than the ship", "pd-scores",
                f"pairs with which the ship leaves the states of Train-B by more than {BEYOND:.0%} of their range for at most {INSIDE:.0%} of the time: median "
                f"ratio of the worst particle's score to the ship's at most {GOOD:g} (ours)", numbers, holds)


def chosen_gains(sweeps):
    chosen = {"a single network": sweeps.single, **{f"the worst of {count}": table for count, table in sweeps.worst.items()}}
    scored = {name: float(sweeps.true.flat[np.argmin(table)]) for name, table in chosen.items()}
    by_single, *by_worst = scored.values()
    yield Claim("not in the paper", "Gains chosen by the worst particle do better on the ship than those chosen by one network", "pd-scores", "score of the true ship",
                "; ".join(f"by {name} {value:.2f}" for name, value in scored.items()) + f"; the ship's best {sweeps.true.min():.2f} rad s",
                {name: value < by_single for name, value in zip(list(scored)[1:], by_worst)})


def in_units(results, rows):
    """The rows of each reading of the gains' unit side by side; rows: of (Sweeps)."""
    for claims in zip(*(list(rows(Sweeps(results, unit))) for unit in UNITS), strict=True):
        for claim, unit in zip(claims, UNITS):
            yield dataclasses.replace(claim, says=f"{claim.says}; gains in {unit} (ours)")


def control(results):
    def rows(sweeps):
        yield from single_network(sweeps)
        yield from worst_of(sweeps, "5.4 controller, 2", sweeps.few)
        yield from gains_that_work(results, sweeps.unit)
    yield from in_units(results, rows)


def summary(results, section):
    """What the discussion says of the controller."""
    def rows(sweeps):
        yield from worst_of(sweeps, section, sweeps.few)
        yield from accuracy_of_the_worst(sweeps)
        yield from more_members(sweeps)
    yield from in_units(results, rows)


def final(results, section):
    def rows(sweeps):
        yield from worst_of(sweeps, section, sweeps.few)
        yield from chosen_gains(sweeps)
    yield from in_units(results, rows)
