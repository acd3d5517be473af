"""What the paper says of the distributions of its data sets, and of the network for the initial state."""

import numpy as np

from claim import Claim, number, per_set
from results import QUANTITIES, STATES

LACKS = 0.01  # share of the samples up to which a set lacks something; ours
SPLITS = 200  # random ones of all berthings into a training and a test set


def pooled(recordings, name):
    values = np.concatenate([recording[name] for recording in recordings])
    return values[np.isfinite(values)]


def speed(recordings):
    """Of the ship: root of u^2 + v_m^2."""
    return np.hypot(pooled(recordings, "u_mps"), pooled(recordings, "vm_mps"))


def largest_gap(x, y):
    """Kolmogorov and Smirnov's distance of two samples."""
    places = np.sort(np.concatenate([x, y]))
    return float(np.max(np.abs(np.searchsorted(np.sort(x), places, "right") / len(x) - np.searchsorted(np.sort(y), places, "right") / len(y))))


def same_distribution(train, test):
    """{quantity: (distance of the two sets, 95 % quantile of that of random splits of all recordings)}"""
    random = np.random.default_rng(1)
    together = train + test
    splits = [random.permutation(len(together)) for _ in range(SPLITS)]
    found = {}
    for name in QUANTITIES:
        of_splits = [largest_gap(pooled([together[i] for i in order[:len(train)]], name), pooled([together[i] for i in order[len(train):]], name))
                     for order in splits]
        found[name] = largest_gap(pooled(train, name), pooled(test, name)), float(np.quantile(of_splits, 0.95))
    return found


def data_sets(results):
    train, berthings, turns, random = (results.truths("data", name) for name in ("Train-B", "Test-B", "Test-ZT", "Test-R"))
    where = "5.1 data sets"
    gaps = same_distribution(train, berthings)
    yield Claim(f"{where}, 1", "Train-B and Test-B are distributed alike", "pairplot",
                f"the Kolmogorov-Smirnov distance of each quantity is within the 95 % quantile of {SPLITS} random splits of all these recordings (ours)",
                per_set({name: f"{gap:.2f} ({limit:.2f})" for name, (gap, limit) in gaps.items()}),
                {name: bool(gap <= limit) for name, (gap, limit) in gaps.items()})
    beyond = {name: float(np.mean(np.abs(pooled(turns, name)) > np.abs(pooled(train, name)).max())) for name in ("vm_mps", "r_degps")}
    fast, usual, slow = (float(np.median(speed(recordings))) for recordings in (turns, train, random))
    yield Claim(f"{where}, 2", "Test-ZT lies where the ship is fast, and has sway and yaw rates that Train-B lacks", "pairplot",
                "its median speed is higher, and some v_m and r are larger, in size, than any of Train-B (ours)",
                f"median speed {number(fast)} against {number(usual)} m/s; beyond Train-B: {per_set({k: f'{v:.0%}' for k, v in beyond.items()})}",
                {"speed": fast > usual, **{name: share > 0.0 for name, share in beyond.items()}})
    astern = [float(np.mean(pooled(recordings, "u_mps") < 0.0)) for recordings in (random, train)]
    yield Claim(f"{where}, 3", "Test-R lies where the ship is slow, and has sternway that Train-B lacks", "pairplot",
                f"its median speed is lower, and it has u < 0, which at most {LACKS:.0%} of Train-B has (ours; replays with more sternway are drawn anew)",
                f"median speed {number(slow)} against {number(usual)} m/s; u < 0 in {astern[0]:.1%} against {astern[1]:.1%} of the samples",
                {"speed": slow < usual, "sternway": astern[0] > 0.0 and astern[1] <= LACKS})


def initial_state(results, section):
    without, with_net = (results.fits(kind) for kind in ("without", "with"))
    numbers = f"median {number(np.median(without))} without, {number(np.median(with_net))} with; {results.init_repeats} trainings each"
    yield Claim(section, "A network for the initial state improves the fit to Train-B", "init-state", "the median of L_fit is lower with it (ours)",
                numbers, bool(np.median(with_net) < np.median(without)))


def states_of_training(results):
    """{state: (least, largest)} in Train-B."""
    train = results.truths("data", "Train-B")
    return {name: (float(pooled(train, name).min()), float(pooled(train, name).max())) for name in STATES}
