"""A claim of the ensemble paper with what the experiments here say of it, and the words in which numbers are given."""

import dataclasses

import numpy as np

NAMES = {"ts-inf": "TS∞", "ts1": "TS1"}


@dataclasses.dataclass
class Claim:
    section: str  # of the paper, and the number of the bullet in its list of observations
    says: str  # what it says, in our words
    figure: str  # here
    reading: str  # what must be true of our numbers so that it holds; "ours" where the paper leaves it open
    numbers: str
    holds: object  # a bool, {part: bool}, or None where the case did not arise

    def verdict(self):
        """yes, no, which parts of several, or that the case did not arise."""
        if self.holds is None:
            return "**not put to the test**"
        parts = self.holds if isinstance(self.holds, dict) else {"": self.holds}
        if all(parts.values()):
            return "**yes**"
        if not any(parts.values()):
            return "**no**"
        listed = {word: ", ".join(name for name, held in parts.items() if held == (word == "yes")) for word in ("yes", "no")}
        return f"in part: {listed['yes']} yes; {listed['no']} no"

    def as_json(self):
        return {**{key: getattr(self, key) for key in ("section", "says", "figure", "reading", "numbers")}, "holds": self.verdict()}


def number(value):
    return f"{value:.3g}" if value == 0.0 or 1e-3 <= abs(value) < 1e4 else f"{value:.2e}"


def per_set(values):
    return "; ".join(f"{name} {value if isinstance(value, str) else number(value)}" for name, value in values.items())


def rank_correlation(x, y):
    """Spearman's, over the points where both are known."""
    known = np.isfinite(x) & np.isfinite(y)
    if np.count_nonzero(known) < 3:
        return float("nan")
    ranks = [np.argsort(np.argsort(values[known])) for values in (np.asarray(x), np.asarray(y))]
    return float(np.corrcoef(*ranks)[0, 1])


def root_mean_square(values):
    return float(np.sqrt(np.mean(np.square(values))))
