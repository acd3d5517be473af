"""Exact inference over all sets of up to three effects, linear at the truth, with the priors that the tool is meant to have.

Coefficients: spike of the stated width times a common scale, ln c ~ N(0, 0.5^2) on nine nodes; slab of log-sd 0.6. A slab within an effect's
bounds is that effect; elsewhere it speaks of the ship's file alone. Strengths else: Gaussians of PRIORS.

This rung of the ladder is frozen: efficiencies are measured against it, so that later changes of the tool must not move it.
"""

import functools
import itertools
import math

import numpy as np

import bayes
import model as m
import physics

SCALE_SD, NODES, SLAB, LARGEST = 0.5, 9, 0.6, 3
P_SENSORS, P_EFFECTS = 0.15, 0.35  # of faults and of effects; nothing is left 0.5
# Effects that are factors on coefficients: which, with what gain, and the sign within the effect's bounds (0: both).
SLABS = {"fouling": (("X_0",), (1.0,), 1), "thrust-loss": (("K_T",), (1.0,), -1), "rudder-effectiveness": (("F_N",), (1.0,), -1),
         "cross-flow-drag": (("C_D",), (1.0,), 0), "windage": (("k_X", "k_Y", "k_N"), (1.0, 1.0, 1.0), 0),
         "added-mass": (("m_x", "m_y", "I_z"), (1.0, 1.0, 0.4), 0), "thruster-gain": (("K_BT",), (1.0,), -1)}
# Standard deviations of strengths, in the units of physics.py (at 3 m).
PRIORS = {"steady-current": 0.04, "varying-current": 0.04, "sheared-current": 0.005, "shallow-water": 0.62, "bank": 0.1, "anemometer": 0.15,
          "unmeasured-wind": 2.0, "wave-drift": 0.03, "draft": 0.1, "center-of-gravity": 0.01, "trim": 0.1, "wake": 0.05, "propeller-walk": 0.2,
          "rudder-offset": 1.0, "rudder-stall": 0.4, "vectwin-interaction": 0.3, "thruster-speed-loss": 3.0, "actuator-delay": 1.0, "actuator-lag": 1.0,
          "actuator-rate": 5.0, "tug": 4.0, "mooring": 2.0, "fender": 0.5, "body-force": 2.0, "earth-force": 2.0, "convention": 1.0,
          "heading-bias": 1.0, "lever-arm": 0.2, "log-scale": 0.03, "rate-bias": 0.05, "velocity-latency": 0.5, "heading-latency": 0.5, "sensor-filter": 0.5}


class Term:
    """A member of sets: columns (m, numbers) whose coefficients are N(0, 1), or for a slab gradients with variance by node."""

    def __init__(self, name, columns, log_prior, coefficients=(), gains=(), side=0, alone=False):
        self.name, self.columns, self.log_prior = name, columns, log_prior
        self.coefficients, self.gains, self.side, self.alone = tuple(coefficients), np.asarray(gains, float), side, alone

    def sizes(self, widths):
        """Standard deviations of the columns' coefficients where the spikes have these widths by coefficient."""
        if not self.coefficients:
            return np.ones(len(self.columns))
        return np.sqrt(np.maximum(SLAB**2 - np.array([widths[k] for k in self.coefficients]) ** 2, 1e-6)) * self.gains


def slab_terms(gradients, names, log_prior):
    """Slabs: effects that are factors on coefficients, and what speaks of the ship's file alone, which shares one effect's mass."""
    row = {k: gradients[i] for i, k in enumerate(m.FACTORS)}
    terms, bare = [], [k for k in m.FACTORS if not any(k in SLABS[n][0] for n in names if n in SLABS)]
    bare += [SLABS[n][0][0] for n in names if n in SLABS and SLABS[n][2]]
    for name in names:
        if name in SLABS:
            which, gains, side = SLABS[name]
            terms.append(Term(name, np.stack([row[k] for k in which]), log_prior, which, gains, side))
    for k in bare:
        if np.sum(row[k] ** 2) > 1e-9:
            side = next((-SLABS[n][2] for n in names if n in SLABS and SLABS[n][2] and SLABS[n][0][0] == k), 0)
            terms.append(Term(f"coefficient:{k}", row[k][None], log_prior - math.log(len(bare)), (k,), (1.0,), side))
    return terms


def sets_of(terms, largest=LARGEST):
    """Tuples of indices, the empty one first; no coefficient twice, no name twice."""
    return _sets_of(tuple((t.name, t.coefficients, t.alone) for t in terms), largest)


@functools.lru_cache(maxsize=64)
def _sets_of(terms, largest):
    out = [()] + [(i,) for i in range(len(terms))]
    joining = [i for i, t in enumerate(terms) if not t[2]]
    apart = {i: {j for j in joining if terms[i][0] == terms[j][0] or set(terms[i][1]) & set(terms[j][1])} for i in joining}
    for size in range(2, largest + 1):
        out += [some for some in itertools.combinations(joining, size) if not any(b in apart[a] for a, b in itertools.combinations(some, 2))]
    return out


def log_normal_tail(x):
    """ln of the share of a standard normal below x; erf by Abramowitz & Stegun 7.1.26, 1.5e-7."""
    z = np.abs(x) / math.sqrt(2.0)
    t = 1.0 / (1.0 + 0.3275911 * z)
    tail = 0.5 * t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429)))) * np.exp(-z * z)
    return np.log(np.maximum(np.where(x < 0.0, tail, 1.0 - tail), 1e-12))


def evidences(terms, sets, inner, cross, null, weights, widths):
    """ln p(y | set), (sets, data), over nodes of the common scale.

    inner: F by node, (columns, columns); cross: b by node, (columns, data); null: (nodes, data); widths: by node, {coefficient: sd}.
    """
    starts = np.concatenate([[0], np.cumsum([len(t.columns) for t in terms])]).astype(int)
    columns = [list(range(starts[i], starts[i + 1])) for i in range(len(terms))]
    groups = {}
    for k, some in enumerate(sets):
        index = [c for i in some for c in columns[i]]
        groups.setdefault(len(index), []).append((k, index, [(columns[i][0], terms[i].side) for i in some if terms[i].side]))
    out = np.full((len(sets), cross[0].shape[1]), -np.inf)
    for node, (F, b) in enumerate(zip(inner, cross)):
        size = np.concatenate([t.sizes(widths[node]) for t in terms]) if terms else np.zeros(0)
        F, b = size[:, None] * F * size, size[:, None] * b
        base = null[node] + math.log(weights[node])
        for width, rows in groups.items():
            if width == 0:
                out[rows[0][0]] = np.logaddexp(out[rows[0][0]], base)
                continue
            for part in (rows[j:j + 1024] for j in range(0, len(rows), 1024)):
                index = np.array([r[1] for r in part])
                A = F[index[:, :, None], index[:, None, :]] + np.eye(width)
                K = np.linalg.inv(A)
                B = b[index]
                mean = K @ B
                value = 0.5 * np.sum(B * mean, 1) - 0.5 * np.linalg.slogdet(A)[1][:, None]
                sided = [(j, r[1].index(c), side) for j, r in enumerate(part) for c, side in r[2]]
                if sided:
                    j, c, side = (np.array(x) for x in zip(*sided))
                    tail = log_normal_tail(side[:, None] * mean[j, c] / np.sqrt(K[j, c, c])[:, None]) + math.log(2.0)
                    np.add.at(value, j, tail)
                k = [r[0] for r in part]
                out[k] = np.logaddexp(out[k], base + value)
    return out


def scale_nodes():
    """Nodes c of the common scale and their weights."""
    x, w = np.polynomial.hermite_e.hermegauss(NODES)
    return np.exp(SCALE_SD * x), w / w.sum()


def posterior(terms, Y, gradients, widths, kinematic_terms, K, largest=LARGEST):
    """(names of sets, which are silent, ln p(set, y) (sets, data)), coefficients beside the names summed over, for data Y of accelerations and K of kinematic residuals.

    gradients: rows of all coefficients, then of what else the tool frees by one sd; widths: {coefficient: stated log-sd}. The two blocks of data are independent.
    """
    c, weights = scale_nodes()
    by_node = [{k: x * w for k, w in widths.items()} for x in c]
    hiding = bayes.Hiding(gradients, [[w[k] ** 2 for k in m.FACTORS] + [x * x] * (len(gradients) - len(m.FACTORS)) for x, w in zip(c, by_node)])
    X = np.concatenate([t.columns for t in terms])
    sets = sets_of(terms, largest)
    first = evidences(terms, sets, hiding.inner(X, X), hiding.inner(X, Y), hiding.log_nothing(Y), weights, by_node)
    Z = np.concatenate([t.columns for t in kinematic_terms])
    others = sets_of(kinematic_terms, largest)
    second = evidences(kinematic_terms, others, [Z @ Z.T], [Z @ K.T], np.zeros((1, len(K))), [1.0], [{}])
    i, j, names, order, starts = _table(tuple((t.name, t.coefficients, t.alone) for t in terms), tuple((t.name, (), t.alone) for t in kinematic_terms), largest)
    prior = np.array([sum(terms[t].log_prior for t in s) for s in sets]), np.array([sum(kinematic_terms[t].log_prior for t in o) for o in others])
    post = first[i] + second[j] + (prior[0][i] + prior[1][j])[:, None]
    return list(names), [not n for n in names], np.logaddexp.reduceat(post[order], starts, 0)


@functools.lru_cache(maxsize=16)
def _table(terms, kinematic_terms, largest):
    """Rows of both lists of sets that go together; names of what is told of them (coefficients are not), rows in the names' order, where each begins."""
    sets, others = _sets_of(terms, largest), _sets_of(kinematic_terms, largest)
    i, j = np.array([(a, b) for a, s in enumerate(sets) for b, o in enumerate(others) if len(s) + len(o) <= largest]).T
    bare = [tuple(terms[t][0] for t in s if not terms[t][0].startswith("coefficient:")) for s in sets]
    extra = [tuple(kinematic_terms[t][0] for t in o) for o in others]
    place, at = {}, np.empty(len(i), int)
    for row, (a, b) in enumerate(zip(i, j)):
        at[row] = place.setdefault(tuple(sorted(bare[a] + extra[b])), len(place))
    order = np.argsort(at, kind="stable")
    return i, j, tuple(place), order, np.searchsorted(at[order], np.arange(len(place)))


def merged(names, post):
    """Classes of the same names as one."""
    place = {}
    for k, n in enumerate(names):
        place.setdefault(n, []).append(k)
    return list(place), [not n for n in place], np.stack([bayes.log_sum(post[k], 0) for k in place.values()])


def log_priors(names):
    """ln of the prior odds of an effect or fault, each alike within its kind."""
    sensors = [n for n in names if n in physics.SENSORS or n == "convention"]
    effects = [n for n in names if n not in sensors]
    return {n: math.log((P_SENSORS / len(sensors) if n in sensors else P_EFFECTS / (len(effects) + 1)) / 0.5) for n in names}
