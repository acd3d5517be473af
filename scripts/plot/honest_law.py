"""How far out a truth lies in the bundle of particles that predict it, as docs/eval-metrics.md defines honest regions.

`level` of a point is the share of honest truths, drawn from the law that the particles show, that lie nearer to their mean
than the truth does: the level of the smallest region that holds the truth. Levels of an honest ensemble are spread evenly
over 0 to 1; so are PITs, the shares of the particles below the truth, up to the number of different particles.

Each member can be taken for the truth in turn, the others predicting it: what an honest ensemble of that size shows on
the same sequences.
"""

import dataclasses
import functools

import numpy as np

from command_line import InputError, UsageError
from trajectory_files import Table, is_prediction

DRAWS = 2000  # for each point
DRAWS_OF_MEMBERS = 20000  # where members alone differ: one law for all points
NOTHING_WITHIN = 1e-9  # of the whole variance: rounding of particles that coincide
FULL_RANK = 1e-10  # smallest eigenvalue of the correlation matrix
SAME_TIME_S = 1e-6
UPPER = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
BLOCK = 64  # points at a time


@dataclasses.dataclass
class Sequence:
    """A predicted sequence, its first point left out; velocities (u, v_m [m/s], r [rad/s])."""
    recording: str
    number: int
    t_s: np.ndarray  # (steps,)
    nu: np.ndarray  # (steps, particles, 3)
    member: np.ndarray  # (particles,), of the first step that is kept
    keeps_member: bool


def read_sequences(file, every=1):
    """The sequences of a prediction CSV; of the steps after the first each `every`-th, beginning with that number."""
    table = Table(str(file))
    if not is_prediction(table):
        raise InputError(f"{file}:1: expected a prediction, found {', '.join(table.header)}")
    names = table.texts("recording")
    values = table.numbers(["sequence", "step", "particle", "member", "t_s", "u_mps", "vm_mps", "r_degps"])
    codes = {name: code for code, name in enumerate(sorted(set(names)))}
    code = np.array([codes[name] for name in names])
    keep = (values[:, 1] > 0) & (values[:, 1] % every == 0)
    if not keep.any():
        raise InputError(f"{file}: no step after the first whose number is a multiple of {every}")
    code, values = code[keep], values[keep]
    order = np.lexsort((values[:, 2], values[:, 1], values[:, 0], code))
    code, values = code[order], values[order]
    starts = np.flatnonzero(np.concatenate(([True], (np.diff(code) != 0) | (np.diff(values[:, 0]) != 0))))
    recordings = list(codes)
    for start, end in zip(starts, [*starts[1:], len(code)]):
        rows = values[start:end]
        steps = len(np.unique(rows[:, 1]))
        name, number = recordings[code[start]], int(rows[0, 0])
        if len(rows) % steps:
            raise InputError(f"{file}: recording '{name}', sequence {number}: steps differ in their particles")
        rows = rows.reshape(steps, -1, rows.shape[1])
        nu = rows[:, :, 5:8].copy()
        nu[:, :, 2] = np.radians(nu[:, :, 2])
        member = rows[:, :, 3].astype(int)
        yield Sequence(name, number, rows[:, 0, 4], nu, member[0], bool((member == member[0]).all()))


def truth_at(trajectory, t_s):
    """(u, v_m [m/s], r [rad/s]) of a trajectory of trajectory_files at these times, linear between samples."""
    time = trajectory["t"]
    if t_s[0] < time[0] - SAME_TIME_S or t_s[-1] > time[-1] + SAME_TIME_S:
        raise InputError(f"the prediction has points from {t_s[0]:g} to {t_s[-1]:g} s, but the truth lasts from {time[0]:g} to {time[-1]:g} s")
    nearest = np.clip(np.searchsorted(time, t_s - SAME_TIME_S), 0, len(time) - 1)
    hit = np.abs(time[nearest] - t_s) <= SAME_TIME_S
    columns = []
    for name, factor in (("u", 1.0), ("vm", 1.0), ("r", np.pi / 180.0)):
        values = factor * trajectory[name]
        columns.append(np.where(hit, values[nearest], np.interp(t_s, time, values)))
    return np.column_stack(columns)


@functools.cache
def draws_of(members, particles):
    """What the honest distances need of standard normal members and particles: scatter of the members' means (n, 9), of particles
    about them (n, 9), the mean of the members (n, 3), a truth (n, 3); and the sorted squared distances of members alone."""
    random = np.random.default_rng(1)
    count = DRAWS_OF_MEMBERS
    truth = random.standard_normal((count, 3))
    of_member = random.standard_normal((count, members, 3))
    mean = of_member.mean(axis=1)
    off = of_member - mean[:, None]
    scatter = np.einsum("nmi,nmj->nij", off, off) / members
    alone = None
    if members > 3:
        error = truth - mean
        alone = np.sort(np.einsum("ni,ni->n", error, np.linalg.solve(scatter, error[:, :, None])[:, :, 0]))
    freedom = particles - members
    factor = np.zeros((DRAWS, 3, 3))  # Bartlett's decomposition of the scatter within members
    for row in range(3):
        if freedom > row:
            factor[:, row, row] = np.sqrt(random.chisquare(freedom - row, DRAWS))
            for column in range(row):
                factor[:, row, column] = random.standard_normal(DRAWS)
    within = factor @ factor.transpose(0, 2, 1) / particles
    return scatter[:DRAWS].reshape(-1, 9), within.reshape(-1, 9), mean[:DRAWS], truth[:DRAWS], alone


def root_of(covariance):
    """Symmetric roots of covariances (n, 3, 3); what rounding made negative counts as zero."""
    values, vectors = np.linalg.eigh(covariance)
    return (vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]) @ vectors.transpose(0, 2, 1)


def congruence(root):
    """(n, 6, 9): what takes a symmetric matrix D, written as 9 numbers, to the upper triangle of root D root."""
    return np.stack([np.einsum("nk,nl->nkl", root[:, i], root[:, j]).reshape(-1, 9) for i, j in UPPER], axis=1)


def distances(Sigma, error):
    """error' Sigma^-1 error with Sigma by its upper triangle; both as sequences of arrays of one shape."""
    a, b, c, d, e, f = Sigma
    x, y, z = error
    A, B, C = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * A + b * B + c * C
    D, E, F = a * f - c * c, b * c - a * e, a * d - b * b
    return (A * x * x + D * y * y + F * z * z + 2.0 * (B * x * y + C * x * z + E * y * z)) / determinant


def levels(nu, member, truth, noise=(0.0, 0.0, 0.0)):
    """The level of each point: (points,), nan where the covariance has no full rank.

      nu     (points, particles, 3) [m/s, m/s, rad/s]
      member (particles,)
      truth  (points, 3)
      noise  standard deviations of what the truth was measured with, where it is a recording
    """
    points, P, _ = nu.shape
    noise = np.diag(np.square(np.asarray(noise, dtype=float)))
    known = np.isfinite(truth).all(axis=1)
    particles = nu - nu[:, :1]  # the spread may be a millionth of the velocity
    error = truth - nu[:, 0] - particles.mean(axis=1)
    groups, group_of = np.unique(member, return_inverse=True)
    counts = np.bincount(group_of)
    shares = counts / P
    means = np.stack([particles[:, group_of == g].mean(axis=1) for g in range(len(groups))], axis=1)
    about = particles - means[:, group_of]
    within = np.einsum("npi,npj->nij", about, about) / max(P - len(groups), 1)
    off = means - particles.mean(axis=1)[:, None]
    of_means = np.einsum("g,ngi,ngj->nij", shares, off, off)
    if len(groups) > 1:
        of_means /= 1.0 - np.sum(shares**2)
    between = root_of(of_means - np.mean(1.0 / counts) * within)
    between = between @ between
    centered = particles - particles.mean(axis=1)[:, None]
    Sigma = np.einsum("npi,npj->nij", centered, centered) / P + noise

    sd = np.sqrt(np.einsum("nii->ni", Sigma))
    known &= (sd > 0.0).all(axis=1)
    result = np.full(points, np.nan)
    if not known.any():
        return result
    scale = np.where(sd > 0.0, sd, 1.0)  # correlations instead of covariances: rounding has less to spoil
    by = 1.0 / (scale[:, :, None] * scale[:, None, :])
    correlation, between, within = Sigma * by, between * by, within * by
    noise = noise * by
    known &= np.linalg.eigvalsh(np.where(known[:, None, None], correlation, np.eye(3)))[:, 0] > FULL_RANK
    index = np.flatnonzero(known)
    z = error[index] / scale[index]
    found = np.einsum("ni,ni->n", z, np.linalg.solve(correlation[index], z[:, :, None])[:, :, 0])

    M = int(round(1.0 / np.sum(shares**2)))
    whole = between[index] + within[index] + noise[index]
    trace = np.einsum("nii->n", whole)
    alone = np.einsum("nii->n", within[index]) <= NOTHING_WITHIN * trace
    alone &= ~np.einsum("nii->n", noise[index]).astype(bool)
    *_, of_members = draws_of(M, P)
    if alone.any() and of_members is not None:
        result[index[alone]] = np.searchsorted(of_members, found[alone]) / len(of_members)
    drawn = np.flatnonzero(~alone)
    members_scatter, particles_scatter, mean, one = draws_of(M, P)[:4]
    for start in range(0, len(drawn), BLOCK):
        rows = drawn[start : start + BLOCK]
        at = index[rows]
        of_member = root_of(between[at] + M / P * within[at])
        of_truth = root_of(whole[rows])
        law = congruence(of_member) @ members_scatter.T + congruence(root_of(within[at])) @ particles_scatter.T
        law += np.stack([noise[at][:, i, j] for i, j in UPPER], axis=1)[:, :, None]
        errors = of_truth @ one.T - of_member @ mean.T
        simulated = distances(law.transpose(1, 0, 2), errors.transpose(1, 0, 2))
        result[at] = (simulated < found[rows, None]).mean(axis=1)
    return result


def pits(nu, truth, noise=(0.0, 0.0, 0.0), random=None):
    """Share of the particles below the truth, of those that equal it half: (points, 3). Each particle has a draw of the noise."""
    if np.any(noise):
        nu = nu + random.standard_normal(nu.shape) * noise
    below = (nu < truth[:, None]).mean(axis=1)
    equal = (nu == truth[:, None]).mean(axis=1)
    return np.where(np.isfinite(truth), below + 0.5 * equal, np.nan)


def in_turn(sequence, noise=(0.0, 0.0, 0.0)):
    """{member: (levels, PITs)}: a particle of the member is the truth, those of all others predict it."""
    if not sequence.keeps_member:
        raise UsageError("particles that change their member (TS1) have no member to take for the truth: predict with --sampling ts-inf")
    result = {}
    random = np.random.default_rng(sequence.number)
    for member in np.unique(sequence.member):
        others = sequence.member != member
        if len(np.unique(sequence.member[others])) < 4:
            continue  # three members and fewer have no covariance
        truth = sequence.nu[:, np.flatnonzero(~others)[0]]
        if np.any(noise):
            truth = truth + random.standard_normal(truth.shape) * noise
        result[int(member)] = (levels(sequence.nu[:, others], sequence.member[others], truth, noise),
                               pits(sequence.nu[:, others], truth, noise, random))
    return result
