"""How well an effect could be seen by somebody who knows everything but it: realised separability d'.

Along the simulated track the effect changes accelerations by a(t), and coefficients off by their stated uncertainty change
them by G(t). In the frequency domain both are divided by the spectrum of what hides them: model error (OU, and what the
structure of the truth differs from the tool's equations by, after the coefficients took their share), and the noise of
velocities and positions as noise of acceleration. d'^2 is the energy left of a(t) when G(t), with its prior, is projected out:
the linear d' of the hypothesis test, but that slow feedback of accelerations on the track is left out. For sensors the same is
done with the kinematic residuals x' - R(psi) nu, psi' - r.
"""

import math

import numpy as np

import model as m
import recording

STEP = 0.05  # of ln(factor)


def states(track, i):
    return {k: track[k][i][None, :] for k in ("x", "y", "psi", "u", "v", "r")} | {"q": track["q"][:, i][:, None, :], "t": track["t"][None, :]}


def acting(track, i, effects):
    """Actuators as they act, for effects that delay them."""
    t = track["t"]
    out = {}
    for c in track["channels"]:
        a = track[f"a_{c}"][i]
        if c.startswith("delta") and ("delay" in effects or "lag" in effects or "rate" in effects):
            fine = np.arange(t[0], t[-1] + 1e-9, (t[1] - t[0]) / 10.0)
            y = np.interp(fine - float(effects.get("delay", 0.0)), t, a)
            lag, rate, h = float(effects.get("lag", 0.0)), float(effects.get("rate", 1e9)), fine[1] - fine[0]
            if lag > 1e-6 or rate < 1e6:
                share = 1.0 - math.exp(-h / lag) if lag > 1e-6 else 1.0
                for k in range(1, len(y)):
                    y[k] = y[k - 1] + min(max((y[k] - y[k - 1]) * share, -rate * h), rate * h)
            a = np.interp(t, fine, y)
        out[c] = a[None, :]
    return out


def accelerations(ship, level, track, i, factors, effects, wind="recorded", forms=None):
    """(3, samples) along recording i; effects and factors are plain numbers."""
    truth = m.Model(ship, level, factors, effects, forms)
    w = None if wind is None else (track["wx"][i][None, :], track["wy"][i][None, :]) if isinstance(wind, str) else (wind[0][None, :], wind[1][None, :])
    a = truth.accelerations(states(track, i), acting(track, i, effects), w)
    return np.array([np.broadcast_to(x, (1, len(track["t"])))[0] for x in a])


def factor_gradients(ship, level, track, i, factors, forms=None):
    base = accelerations(ship, level, track, i, factors, {}, forms=forms)
    return base, np.array([(accelerations(ship, level, track, i, {**factors, k: factors.get(k, 1.0) * math.exp(STEP)}, {}, forms=forms) - base) / STEP for k in m.FACTORS])


ENDS = 0.05  # of a recording, at its begin and at its end


def seen(a):
    """Accelerations (..., samples), fading at both ends: what begins when a recording ends has moved nothing yet (an acceleration is seen
    by what it does to velocities and positions), and for the Fourier transform the end would be next to the begin."""
    n = a.shape[-1]
    k = max(int(ENDS * n), 1)
    rise = 0.5 - 0.5 * np.cos(math.pi * (np.arange(k) + 0.5) / k)
    return a * np.concatenate([rise, np.ones(n - 2 * k), rise[::-1]])


def whitened(a, omega, spectrum):
    """Columns of real numbers with unit noise, from (..., samples)."""
    n = a.shape[-1]
    A = np.fft.rfft(a, axis=-1) / np.sqrt(n * spectrum)
    A[..., 1:] *= math.sqrt(2.0)  # both signs of frequency
    return np.concatenate([A.real, A.imag], -1)


def spectra(track, kind, scale, error_sd, tau, L):
    """Spectral density (per sampling) of what hides accelerations u', v_m', r'."""
    t = track["t"]
    dt, n = t[1] - t[0], len(t)
    omega = np.maximum(2.0 * math.pi * np.fft.rfftfreq(n, dt), 1.7 / (t[-1] - t[0]))
    sd = recording.noise_sd(kind, scale)
    colour = (1.0 + 2.0 * math.exp(-dt / (2.0 * scale)) / (1.0 - math.exp(-dt / (2.0 * scale)))) if kind == "coloured" else 1.0
    out = []
    for axis, (velocity, position) in enumerate((("u_mps", "x0_m"), ("vm_mps", "y0_m"), ("r_degps", "psi_deg"))):
        to = math.pi / 180.0 if axis == 2 else 1.0
        S_v, S_x = omega**2 * (sd[velocity] * to) ** 2 * colour, omega**4 * (sd[position] * to) ** 2 * colour
        measured = S_v * S_x / (S_v + S_x)
        error = error_sd[axis] ** 2 * 2.0 * tau / dt / (1.0 + (omega * tau) ** 2)
        out.append(measured + error)
    return omega, out


def separability(change, gradients, track, kind, scale, error_sd, tau, L):
    """d' from changes and gradients of accelerations, one pair per recording."""
    omega, S = spectra(track, kind, scale, error_sd, tau, L)
    flat = lambda a: np.concatenate([whitened(seen(a[..., axis, :]), omega, S[axis]) for axis in range(3)], -1)
    y = np.concatenate([flat(c) for c in change])
    X = np.concatenate([flat(g) for g in gradients], -1)
    A = X @ X.T + np.diag([1.0 / m.PRIOR[k] ** 2 for k in m.FACTORS])
    b = X @ y
    return math.sqrt(max(float(y @ y - b @ np.linalg.solve(A, b)), 0.0))


def structural_error(ship, level, track, rows, factors, gradients, wind="recorded", forms=None):
    """Root mean square of what the tool's equations lack at the true coefficients, after coefficients took their share.
    A wind that is itself what is missing is left out (wind=None)."""
    if level == 1:
        return np.zeros(3)
    lack = np.concatenate([(accelerations(ship, level, track, i, factors, {}, wind, forms) - accelerations(ship, 1, track, i, factors, {}, wind)) for i in rows], -1)
    return left_after_refit(lack, np.concatenate(gradients, -1))


def left_after_refit(lack, G):
    """Root mean square by axis of (3, samples), after coefficients with gradients G took their share."""
    size = np.sqrt(np.mean(lack**2, -1)) + 1e-12
    X = np.concatenate([G[:, a] / size[a] for a in range(3)], -1)
    y = np.concatenate([lack[a] / size[a] for a in range(3)])
    weight = 0.05  # samples are not independent
    beta = np.linalg.solve(weight * X @ X.T + np.diag([1.0 / m.PRIOR[k] ** 2 for k in m.FACTORS]), weight * X @ y)
    left = (y - beta @ X).reshape(3, -1) * size[:, None]
    return np.sqrt(np.mean(left**2, -1))


def kinematic_residuals(c):
    """x' - R(psi) nu and psi' - r of the columns of a recording, (3, samples)."""
    psi, dt = np.radians(c["psi_deg"]), c["t_s"][1] - c["t_s"][0]
    rate = lambda a: np.gradient(a, dt)
    return np.array([rate(c["x0_m"]) - c["u_mps"] * np.cos(psi) + c["vm_mps"] * np.sin(psi),
                     rate(c["y0_m"]) - c["u_mps"] * np.sin(psi) - c["vm_mps"] * np.cos(psi), rate(psi) - np.radians(c["r_degps"])])


def kinematic_spectra(t, kind, scale):
    """Spectral density (per sampling) of the noise of kinematic residuals."""
    sd, to = recording.noise_sd(kind, scale), math.pi / 180.0
    omega = np.maximum(2.0 * math.pi * np.fft.rfftfreq(len(t), t[1] - t[0]), 1.7 / (t[-1] - t[0]))
    track = (omega * sd["x0_m"]) ** 2 + sd["u_mps"] ** 2
    return omega, [track, track, (omega * sd["psi_deg"] * to) ** 2 + (sd["r_degps"] * to) ** 2]


def sensor_separability(columns, faults, kind, scale):
    """d' of sensor faults from kinematic residuals of noise-free columns, one dict per recording."""
    total = 0.0
    for clean in columns:
        omega, S = kinematic_spectra(clean["t_s"], kind, scale)
        change = kinematic_residuals(recording.with_faults(clean, faults)) - kinematic_residuals(clean)
        total += float(sum(np.sum(whitened(change[axis], omega, S[axis]) ** 2) for axis in range(3)))
    return math.sqrt(total)
