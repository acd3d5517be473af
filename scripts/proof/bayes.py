"""Exact Bayes for linear hypotheses: a datum is a change, plus a Gaussian of low rank that hides it, plus unit white noise.

    y = mu + T z + U' x + e,   z ~ N(0, I), x ~ N(0, diag(v)), e ~ N(0, I)

mu and T belong to a component of a class, U and v to what hides all classes alike: coefficients that may be off, forms that may be others.
A class is a mixture of components, v one of several levels that are not known. All that is needed of data and components are inner
products in the metric of the inverse covariance, so that a case of thousands of numbers costs a few small matrices.
"""

import math

import numpy as np


def log_sum(a, axis=0):
    """ln sum exp along an axis; of nothing, -inf."""
    top = np.max(a, axis=axis, keepdims=True, initial=-np.inf)
    top = np.where(np.isfinite(top), top, 0.0)
    with np.errstate(divide="ignore"):
        return np.squeeze(top, axis) + np.log(np.sum(np.exp(a - top), axis=axis))


class Hiding:
    """What hides all classes: rows U with variances by level, (levels, rows). By singular values: U can be a million times the noise."""

    def __init__(self, U, variances):
        self.U, self.variances, self.kernels, self.log_dets = U, np.atleast_2d(np.asarray(variances, float)), [], []
        E, s, self.basis = np.linalg.svd(U, full_matrices=False) if len(U) else (np.zeros((0, 0)), np.zeros(0), U)
        for v in self.variances:  # Sigma^-1 = I - basis' kernel basis
            d, R = np.linalg.svd(np.sqrt(v)[:, None] * E * s, full_matrices=False)[1:] if len(U) else (s, E)
            self.kernels.append(R.T * (d * d / (1.0 + d * d)) @ R)
            self.log_dets.append(float(np.sum(np.log1p(d * d))))

    def inner(self, X, Y):
        """[X Sigma^-1 Y'] by level, of rows X and Y."""
        plain, left = X @ Y.T, X @ self.basis.T
        right = left if Y is X else Y @ self.basis.T
        return [plain - left @ K @ right.T for K in self.kernels]

    def log_nothing(self, Y):
        """(levels, data): ln p(y | nothing acts), but for a constant."""
        squares, along = np.sum(Y * Y, 1), Y @ self.basis.T
        return np.array([-0.5 * (squares - np.sum((along @ K) * along, 1)) - 0.5 * d for K, d in zip(self.kernels, self.log_dets)])

    def draw(self, rng, level, n):
        """n draws of U' x."""
        return (rng.standard_normal((n, len(self.U))) * np.sqrt(self.variances[level])) @ self.U


def log_bayes_factors(Q, b, C, T=None):
    """ln p(y | component)/p(y | nothing), (components, data).

    Q (n, n) and b (n, data): inner products of nodes with nodes and with data; C (components, n): mu from the nodes; T (components, t, n).
    """
    out = C @ b - 0.5 * np.einsum("kn,nm,km->k", C, Q, C)[:, None]
    if T is None or T.shape[1] == 0:
        return out
    TQ = T @ Q
    A = np.eye(T.shape[1]) + TQ @ np.swapaxes(T, 1, 2)
    r = T @ b - np.einsum("ktn,kn->kt", TQ, C)[:, :, None]
    return out + 0.5 * np.sum(r * np.linalg.solve(A, r), 1) - 0.5 * np.linalg.slogdet(A)[1][:, None]


def mixture(factors, weights):
    """ln of the mean Bayes factor of a class from those of its components."""
    with np.errstate(divide="ignore"):
        return log_sum(factors + np.log(np.asarray(weights, float))[:, None], 0)


def threshold(statistic, share=0.01):
    """The k-th largest of n, k = share (n + 1): a new one exceeds it with just this probability."""
    ordered = np.sort(np.asarray(statistic))[::-1]
    return float(ordered[max(round(share * (len(ordered) + 1)), 1) - 1])


def answers(names, log_post, truth, limit, is_silent=None):
    """What is reached with a posterior over sets of names, one value per datum, as floats 0 or 1.

    names: tuple of names per set; log_post (sets, data); truth: tuple of names; limit: of the log odds of something against nothing.
    is_silent: sets in which nothing is missing (the empty one; sets that speak of coefficients alone).
    """
    silent = np.array([not n for n in names]) if is_silent is None else np.asarray(is_silent)
    odds = log_sum(log_post[~silent], 0) - log_sum(log_post[silent], 0)
    seen = odds > limit
    speaking, what = log_post[~silent], [n for n, s in zip(names, silent) if not s]
    every = sorted({x for n in what for x in n})
    post = np.exp(speaking - np.max(speaking, 0))
    inclusion = np.array([[x in n for n in what] for x in every], float) @ post
    first, best = np.argmax(inclusion, 0), np.argmax(speaking, 0)
    out = {"odds": odds, "detected": seen.astype(float)}
    if truth:
        is_true = np.array([x in truth for x in every])
        exact = np.array([set(n) == set(truth) for n in what])
        out["first"] = (seen & is_true[first]).astype(float)
        out["set"] = (seen & exact[best]).astype(float)
        with np.errstate(divide="ignore"):
            whole, rest = log_sum(speaking[exact], 0), log_sum(speaking[~exact], 0) if (~exact).any() else np.full(odds.shape, -np.inf)
        out["accepted"] = (seen & (whole >= np.max(speaking, 0) - math.log(10.0))).astype(float)
        out["lead"] = whole - rest
        if len(truth) > 1:
            holds = np.array([set(truth) <= set(n) for n in what])
            out["both"] = (seen & holds[best]).astype(float)
    return out


def separation(nats):
    """The distance of two simple Gaussian hypotheses that differ by so many nats in the mean."""
    return math.sqrt(2.0 * max(float(nats), 0.0))
