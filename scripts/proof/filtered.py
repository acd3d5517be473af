"""What a ship answers to accelerations, which the frequency domain of separability.py leaves out.

Changes of accelerations along the true track go through the equations of motion, linearized there (derivatives by the state, sample by sample); a Kalman filter
with the same noise and the same model error turns what sensors read of them into numbers of unit variance. Coefficients take their share as they do there.
Functions: compared(key, track) -> d' of a case's only effect, (frequency domain, with feedback).
"""

import math

import numpy as np

import law
import model as m
import recording
import separability as sep

STEPS = {"x": 0.01, "y": 0.01, "psi": 1e-3, "u": 1e-3, "v": 1e-3, "r": 1e-3}  # of derivatives: lengths of the ship, rad, m/s and rad/s of a ship of 3 m


def derivatives(scene, forms):
    """(recordings, samples, 3, 6) of accelerations by x, y, psi, u, v, r along the track."""
    own, rows = scene.states, []
    to = {"x": scene.L, "y": scene.L, "psi": 1.0, "u": scene.T, "v": scene.T, "r": 1.0 / scene.T}
    for k, step in STEPS.items():
        h = step * to[k]
        sides = []
        for side in (h, -h):
            scene.states = {**own, k: own[k] + side}
            sides.append(scene.accelerations(scene.level, forms=forms)[0])
        rows.append((sides[0] - sides[1]) / (2.0 * h))
    scene.states = own
    return np.moveaxis(np.stack(rows, 1), (0, 1), (2, 3))


def transitions(track, J):
    """Of one recording: how states follow from the sample before (samples - 1, 6, 6), and from accelerations at both samples (.., 6, 3) twice."""
    dt = track["t"][1] - track["t"][0]
    middle = lambda a: 0.5 * (a[1:] + a[:-1])
    psi, u, v = (middle(track[k]) for k in ("psi", "u", "v"))
    cos, sin = np.cos(psi), np.sin(psi)
    A = np.zeros((len(psi), 12, 12))
    A[:, 0, 2], A[:, 1, 2] = -u * sin - v * cos, u * cos - v * sin
    A[:, 0, 3], A[:, 0, 4], A[:, 1, 3], A[:, 1, 4], A[:, 2, 5] = cos, -sin, sin, cos, 1.0
    A[:, 3:6, :6] = middle(J)
    A[:, :6] *= dt
    A[:, 3:6, 6:9] = np.eye(3) * dt  # an acceleration at the begin, and its change on the way
    A[:, 6:9, 9:12] = np.eye(3)
    power = total = np.broadcast_to(np.eye(12), A.shape)
    halvings = max(0, math.ceil(math.log2(max(np.abs(A).sum(2).max(), 1e-9))) + 2)
    for k in range(1, 9):  # exp(A), scaled and squared
        power = power @ A / (k * 2.0**halvings)
        total = total + power
    for _ in range(halvings):
        total = total @ total
    end = total[:, :6, 9:12]
    return total[:, :6, :6], total[:, :6, 6:9] - end, end


def innovations(track, J, columns, sd, error_sd, tau):
    """(N, 6 samples) of (N, 3, samples): what a filter did not expect of columns of accelerations, in its own standard deviations."""
    dt = track["t"][1] - track["t"][0]
    kept = math.exp(-dt / tau)
    E, at_begin, at_end = transitions(track, J)
    Q = np.diag(np.maximum(error_sd, 1e-12) ** 2)
    R = np.diag(sd**2)
    P = np.zeros((9, 9))
    P[:6, :6], P[6:, 6:] = 1e4 * R, Q
    x, out = np.zeros((9, len(columns))), []
    for k in range(len(track["t"])):
        if k:
            F = np.zeros((9, 9))
            F[:6, :6], F[:6, 6:], F[6:, 6:] = E[k - 1], at_begin[k - 1] + kept * at_end[k - 1], kept * np.eye(3)
            new = np.vstack([at_end[k - 1], np.eye(3)])
            x, P = F @ x, F @ P @ F.T + (1.0 - kept * kept) * new @ Q @ new.T
            x[:6] += at_begin[k - 1] @ columns[:, :, k - 1].T + at_end[k - 1] @ columns[:, :, k].T
        S = P[:6, :6] + R
        out.append(np.linalg.solve(np.linalg.cholesky(S), x[:6]).T)
        K = np.linalg.solve(S, P[:6]).T
        x = x - K @ x[:6]
        keep = np.eye(9)
        keep[:, :6] -= K
        P = keep @ P @ keep.T + K @ R @ K.T
    return np.concatenate(out, 1)


def left(rows, widths):
    """d' of the first row, when the others, with standard deviations `widths`, took their share."""
    y, X = rows[0], rows[1:]
    b = X @ y
    return math.sqrt(max(float(y @ y - b @ np.linalg.solve(X @ X.T + np.diag(widths**-2.0), b)), 0.0))


def compared(key, track):
    """d' of the case's only effect: in the frequency domain, and with feedback."""
    scene, name = law.Scene(key, track), key["names"][0]
    truth, forms = key["truth"][name], key["forms"] or None
    change = scene.change(name, scene.level, [(truth["shape"], truth["strength"])], forms)
    columns = np.concatenate([change, scene.gradients[scene.level]])
    error = np.array([key["error"], key["error"], key["error"] / (0.25 * scene.L)])
    flat = lambda a: np.moveaxis(a, 1, 0).reshape(3, len(a), -1)
    hidden = np.hypot(error, sep.left_after_refit(flat(scene.lack)[:, 0], np.moveaxis(flat(scene.gradients[2]), 0, 1)) if scene.level == 2 else 0.0)
    noise = recording.noise_sd(scene.noise, scene.T)
    to = math.pi / 180.0
    dt = scene.track["t"][1] - scene.track["t"][0]
    lasting = (1.0 + 2.0 / math.expm1(dt / (2.0 * scene.T))) ** 0.5 if scene.noise == "coloured" else 1.0  # as slow noise of this density
    sd = lasting * np.array([noise["x0_m"], noise["y0_m"], noise["psi_deg"] * to, noise["u_mps"], noise["vm_mps"], noise["r_degps"] * to])
    J, widths = derivatives(scene, forms), np.array([m.PRIOR[k] for k in m.FACTORS])
    one = lambda r: {"t": scene.track["t"], **{k: scene.track[k][r] for k in ("psi", "u", "v")}}
    filtered = np.concatenate([innovations(one(r), J[r], columns[:, :, r], sd, hidden, scene.tau) for r in range(scene.R)], 1)
    return float(scene.primes(name, change)[0]), left(filtered, widths)
