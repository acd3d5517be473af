"""What simpler methods reach under the same scores.

Residual accelerations by finite differences of the recorded velocities (smoothed over five samples), the ship's equations at
their published coefficients, and a library of columns: each effect's change of acceleration along the recorded track at a
small and usual strength, and each coefficient's. STLSQ is sequentially thresholded least squares (Brunton, Proctor & Kutz
2016); the stepwise choice adds columns by BIC over samples. Both name the effect with the largest share of the explained
variance, and alarm where an effect is kept. They know nothing of sensors.
"""

import math

import numpy as np

import model
import physics
import recording
import separability as sep
import tables

COMMON = "rudder-offset"


def usual(name):
    """Columns of an effect: numbers of the truth at a usual strength, one per direction."""
    e = physics.EFFECTS[name]
    return e.most * 0.1


def track_of(columns):
    """A recording as a track of one, gaps filled."""
    t = columns["t_s"]
    fill = lambda a: np.interp(t, t[np.isfinite(a)], a[np.isfinite(a)])
    smooth = lambda a: np.convolve(np.pad(fill(a), 2, mode="edge"), np.ones(5) / 5.0, "valid")
    psi = np.unwrap(np.radians(fill(columns["psi_deg"])))
    out = {"t": t, "x": smooth(columns["x0_m"])[None], "y": smooth(columns["y0_m"])[None], "psi": smooth(np.degrees(psi))[None] * math.pi / 180.0,
           "u": smooth(columns["u_mps"])[None], "v": smooth(columns["vm_mps"])[None], "r": np.radians(smooth(columns["r_degps"]))[None], "q": np.zeros((3, 1, len(t)))}
    names = [c for c in ("delta", "delta_p", "delta_s", "n_p", "n_bt") if f"{c}_deg" in columns or f"{c}_rps" in columns]
    for c in names:
        out[f"a_{c}"] = (np.radians(fill(columns[f"{c}_deg"])) if f"{c}_deg" in columns else fill(columns[f"{c}_rps"]))[None]
    out["channels"] = tuple(names)
    if "wind_speed_mps" in columns:
        xi = np.radians(columns["wind_dir_deg"])
        out["wx"], out["wy"] = (columns["wind_speed_mps"] * np.cos(xi))[None], (columns["wind_speed_mps"] * np.sin(xi))[None]
    else:
        out["wx"] = out["wy"] = np.zeros((1, len(t)))
    return out


def library(ship, ship_name, files):
    """Residuals, columns and their names (None: a coefficient) over all recordings."""
    y, columns = [], {}
    T, L = physics.scale(ship), ship["particulars"]["L_pp_m"]
    weight = np.array([1.0, 1.0, 0.25 * L])[:, None]
    names = [n for n in physics.EFFECTS if physics.EFFECTS[n].fits(ship_name) and n not in ("bank", "fender", "mooring", "tug", "anemometer", "varying-current")]
    for file in files:
        track = track_of(recording.read_csv(file))
        t = track["t"]
        base, gradients = sep.factor_gradients(ship, 1, track, 0, {})
        measured = np.array([np.gradient(track[k][0], t) for k in ("u", "v", "r")])
        y.append(((measured - base) * weight)[:, 3:-3].ravel())
        for k, g in zip(model.FACTORS, gradients):
            columns.setdefault((None, k), []).append((g * weight)[:, 3:-3].ravel())
        for name in names:
            effect = physics.EFFECTS[name]
            shapes = [{"angle": 0.0}, {"angle": 0.5 * math.pi}] if effect.draw is physics.direction else [
                {"sign": 1.0, "angle": 15.0, "slack": [0.0] * 6, "level": 1, "which": "k_R"}]
            for j, shape in enumerate(shapes):
                s = max(usual(name), 2.0 if name == "actuator-rate" else 0.0) * (0.5 / 0.083 if name == "shallow-water" else 1.0)
                if name == "unmeasured-wind":
                    w = np.array([math.cos(shape["angle"]), math.sin(shape["angle"])]) * T
                    a = sep.accelerations(ship, 1, track, 0, {}, {}, (track["wx"][0] + w[0], track["wy"][0] + w[1])) - base
                else:
                    a = sep.accelerations(ship, 1, track, 0, {}, effect.at(s, shape, ship)[0]) - base
                columns.setdefault((name, j), []).append((a * weight)[:, 3:-3].ravel())
    keys = list(columns)
    X = np.stack([np.concatenate(columns[k]) for k in keys], 1)
    y = np.concatenate(y)
    good = np.isfinite(X).all(1) & np.isfinite(y)
    X, y = X[good], y[good]
    size = np.sqrt(np.mean(X**2, 0))
    keep = size > 1e-9
    return y, X[:, keep] / size[keep], [k for k, is_kept in zip(keys, keep) if is_kept]


def stlsq(y, X, keys, threshold=0.2, rounds=10):
    """Columns left after thresholds on standardised coefficients (in units of the residual's rms)."""
    active = np.ones(X.shape[1], bool)
    limit = threshold * math.sqrt(float(np.mean(y**2)))
    w = np.zeros(X.shape[1])
    for _ in range(rounds):
        if not active.any():
            break
        w[:] = 0.0
        w[active] = np.linalg.solve(X[:, active].T @ X[:, active] + 1e-3 * len(y) * np.eye(int(active.sum())), X[:, active].T @ y)
        before = active.copy()
        active &= np.abs(w) > limit
        if (active == before).all():
            break
    return rank(w, active, keys)


def rank(w, active, keys):
    power = {}
    for k, weight, on in zip(keys, w, active):
        if on and k[0] is not None:
            power[k[0]] = power.get(k[0], 0.0) + weight * weight
    return sorted(power, key=lambda n: -power[n])


def stepwise(y, X, keys, most=8):
    """Forward choice by BIC over samples, effects as blocks of their columns."""
    blocks = {}
    for j, k in enumerate(keys):
        blocks.setdefault(k if k[0] is None else (k[0],), []).append(j)
    n, chosen, order = len(y), [], []
    rss = float(y @ y)
    bic = n * math.log(rss / n)
    while len(order) < most:
        best = None
        for b, js in blocks.items():
            if b in order:
                continue
            A = X[:, chosen + js]
            w = np.linalg.lstsq(A, y, rcond=None)[0]
            value = n * math.log(float(np.sum((y - A @ w) ** 2)) / n) + (len(chosen) + len(js)) * math.log(n)
            if best is None or value < best[0]:
                best = (value, b, js)
        if best is None or best[0] >= bic:
            break
        bic, chosen = best[0], chosen + best[2]
        order.append(best[1])
    return [b[0] for b in order if b[0] is not None]


def seen(rows):
    """Single effects that can be found."""
    return [r for r in rows if r["family"] == "single" and (r["d_prime"] or 0.0) >= 6.0]


def add(folder, keys, rows):
    """What each method names, most of it first, as `baselines` of the rows that the table is of."""
    for r in tables.nulls_of(rows) + seen(rows):
        key = keys[r["id"]]
        y, X, names = library(model.read_ship(key["ship"]), key["ship"], sorted((folder / "cases" / r["id"]).glob("train-*.csv")))
        r["baselines"] = {"STLSQ": stlsq(y, X, names), "stepwise BIC": stepwise(y, X, names), "most common class": [COMMON]}


def table(rows):
    """Of rows whose baselines were computed."""
    lines = ["| method | false alarms | detected, single at d' >= 6 | named first | in the first three |", "|---" * 5 + "|"]
    rows = [r for r in rows if "baselines" in r]
    if not rows:
        return tables.NOT_YET
    nulls, found = tables.nulls_of(rows), seen(rows)
    lines.append(f"| gap-explain | {sum(r['alarm'] for r in nulls)}/{len(nulls)} | {sum(r['detected'] for r in found)}/{len(found)} | {sum(r['first'] for r in found)} | {sum(r['top3'] for r in found)} |")
    for method in ("STLSQ", "stepwise BIC", "most common class"):
        at = lambda r: r["baselines"][method]
        lines.append(f"| {method} | {sum(bool(at(r)) for r in nulls)}/{len(nulls)} | {sum(bool(at(r)) for r in found)}/{len(found)} "
                     f"| {sum(bool(at(r)) and at(r)[0] in r['truth'] for r in found)} | {sum(bool(set(at(r)[:3]) & set(r['truth'])) for r in found)} |")
    return lines
