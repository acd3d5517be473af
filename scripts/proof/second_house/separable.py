"""d' in the second house: what is left of an effect's change of accelerations when the coefficients with their stated uncertainty are
projected out, over model error, what the tables differ by from the given ship, and noise; as separability.py, along this house's tracks."""

import math

import numpy as np

import separability as sep  # its spectra and whitening; no forces
from second_house import vessel as vs

STEP = 0.05


def along(out, i):
    """States, acting actuators and wind of recording i."""
    c = {k: v[i] for k, v in out["true"].items()}
    s = {"x": c["x0_m"], "y": c["y0_m"], "psi": np.radians(c["psi_deg"]), "phi": c["phi"], "u": c["u_mps"], "v": c["vm_mps"], "p": c["p"], "r": np.radians(c["r_degps"]),
         "t": out["t_s"]}
    xi = np.radians(c["wind_dir_deg"])
    acting = {k[7:]: c[k] for k in c if k.startswith("acting_")}
    return s, acting, (c["wind_speed_mps"] * np.cos(xi), c["wind_speed_mps"] * np.sin(xi))


def moved(acting, t, rudders, effects):
    """Rudders that act late, lag, or have play."""
    out = dict(acting)
    for c in rudders:
        a = np.interp(t - effects.get("delay", 0.0), t, acting[c])
        lag, play = effects.get("lag", 0.0), effects.get("backlash", 0.0)
        if lag > 1e-9 or play > 0.0:
            share = 1.0 - math.exp(-(t[1] - t[0]) / lag) if lag > 1e-9 else 1.0
            y = a.copy()
            for k in range(1, len(y)):
                step = a[k] - y[k - 1]
                y[k] = y[k - 1] + share * math.copysign(max(abs(step) - play, 0.0), step)
            a = y
        out[c] = a
    return out


def accelerations(name, tables, out, i, factors, effects, wind="recorded"):
    s, acting, w = along(out, i)
    ship = vs.Vessel(name, factors, effects, tables)
    if {"delay", "lag", "backlash"} & set(effects):
        acting = moved(acting, s["t"], ship.rudders, effects)
    if "tank" in ship.active:  # its state along the track, driven by the sway
        q, rate, h = np.zeros((2, len(s["t"]))), 0.9 / ship.scale, s["t"][1] - s["t"][0]
        sway = s["u"] * s["r"] + 0.3 * vs.G * s["phi"]
        for k in range(1, q.shape[1]):
            y, z = q[:, k - 1]
            for _ in range(8):
                z += h / 8.0 * (rate**2 * (15.0 * sway[k] - y) - 0.12 * rate * z)
                y += h / 8.0 * z
            q[:, k] = y, z
        s["q"] = q
    rate = ship.rates(s, acting, w if isinstance(wind, str) else wind)
    return np.array([np.broadcast_to(rate[k], s["u"].shape) for k in ("u", "v", "r")])


class Analysis:
    """Gradients and what hides effects, of the recordings (rows) that the tool is given to fit."""

    def __init__(self, name, tables, out, rows, factors, error_sd, left, scale, L):
        self.name, self.tables, self.out, self.rows, self.factors, self.scale, self.L = name, tables, out, list(rows), factors, scale, L
        base = [accelerations(name, tables, out, i, factors, {}) for i in self.rows]
        self.gradients = [np.array([(accelerations(name, tables, out, i, {**factors, k: factors.get(k, 1.0) * math.exp(STEP)}, {}) - b) / STEP for k in vs.STATED])
                          for i, b in zip(self.rows, base)]
        typical = np.std(np.concatenate(base, 1), 1)
        self.hiding = np.hypot(error_sd, np.asarray(left) * typical)
        self.base = base

    def d_prime(self, change):
        _, S = sep.spectra({"t": self.out["t_s"]}, "paper", self.scale, self.hiding, 15.0 * self.scale, self.L)
        flat = lambda a: np.concatenate([sep.whitened(sep.seen(a[..., axis, :]), None, S[axis]) for axis in range(3)], -1)
        y, X = np.concatenate([flat(c) for c in change]), np.concatenate([flat(g) for g in self.gradients], -1)
        A = X @ X.T + np.diag([1.0 / s**2 for s in vs.STATED.values()])
        b = X @ y
        return math.sqrt(max(float(y @ y - b @ np.linalg.solve(A, b)), 0.0))
