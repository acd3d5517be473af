"""Maneuvers, wind, model error and the time loop, many recordings at once."""

import math

import numpy as np

KNOT_S = 0.5  # wind and model error are linear between such times (at 3 m)


def ou_path(rng, sd, tau, duration, knot):
    n = int(duration / knot) + 3
    a = math.exp(-knot / tau)
    noise = rng.standard_normal(n)
    path = np.empty(n)
    path[0] = noise[0]
    for k in range(1, n):
        path[k] = a * path[k - 1] + math.sqrt(1.0 - a * a) * noise[k]
    return sd * path


def wind_path(rng, wind, duration, knot, scale):
    """Earth vectors to where the true wind comes from, at the knots: (n, 2)."""
    n = int(duration / knot) + 3
    if wind is None:
        return np.zeros((n, 2))
    U = wind["speed_mps"] * (1.0 + ou_path(rng, wind["gust"], 12.0 * scale, duration, knot))
    gamma = math.radians(wind["dir_deg"]) + ou_path(rng, math.radians(8.0), 30.0 * scale, duration, knot)
    return np.stack([np.maximum(U, 0.0) * np.cos(gamma), np.maximum(U, 0.0) * np.sin(gamma)], 1)


class Pilot:
    """Orders of all recordings of one ship; each recording is a dict with `kind`, `seed` and the kind's numbers."""

    def __init__(self, model, recordings, duration):
        self.model, self.recordings, self.duration = model, recordings, duration
        ship, N, T = model.ship, len(recordings), model.scale
        self.actuators = {a["channel"]: a for a in ship["actuators"] if not a.get("optional")}
        self.kind = np.array([r["kind"] for r in recordings])
        column = lambda key, default=0.0: np.array([float(r.get(key, default)) for r in recordings])
        self.heading = np.radians(column("heading_deg"))
        self.rudder, self.turn_by = np.radians(column("rudder_deg")), np.radians(column("turn_by_deg", 10.0))
        initial = next(a["initial_rps"] for a in ship["actuators"] if a["channel"] == "n_p")
        self.n = initial * column("n_share", 1.0)
        self.u0 = ship["u0_mps"] * column("u_share", 1.0)
        self.side = np.sign(self.rudder) + (self.rudder == 0.0)
        self.is_ = {k: self.kind == k for k in ("straight", "reciprocal", "zigzag", "turn", "random", "berthing")}
        self.scheduled = [(i, r["schedule"]) for i, r in enumerate(recordings) if r["kind"] == "schedule"]  # {channel: [(from [s], order), ...]}
        self.interval = ship["random_interval_s"]
        steps = int(duration / self.interval) + 2
        self.orders = {}
        for c, a in self.actuators.items():
            unit, to = ("deg", math.pi / 180.0) if c.startswith("delta") else ("rps", 1.0)
            low, high = a[f"min_{unit}"] * to, a[f"max_{unit}"] * to
            table = np.empty((N, steps))
            for i, r in enumerate(recordings):
                rng = np.random.default_rng([r["seed"], sum(c.encode())])
                draws = rng.standard_normal(steps)
                mean, sd = a.get(f"random_mean_{unit}"), a.get(f"random_sd_{unit}", 0.0)
                table[i] = np.clip(mean * to + sd * to * draws, low, high) if mean is not None else self.n[i] if c == "n_p" else 0.0
            self.orders[c] = (low, high, table)
        if self.model.is_vectwin:  # wide rudders in half of the random recordings, small angles both alike in the others
            gentle = np.array([bool(r.get("gentle")) for r in recordings])
            rng_table = np.array([np.random.default_rng([r["seed"], 7]).normal(0.0, math.radians(15.0), steps) for r in recordings])
            for c in ("delta_p", "delta_s"):
                low, high, table = self.orders[c]
                self.orders[c] = (low, high, np.where(gentle[:, None], np.clip(rng_table, -0.6, 0.6), table))

    def initial(self):
        out = {c: np.zeros(len(self.recordings)) for c in self.actuators}
        out["n_p"] = self.n.copy()
        for c, (_, _, table) in self.orders.items():
            out[c] = np.where(self.is_["random"], table[:, 0], out[c])
        return out

    def command(self, t, s):
        T, is_ = self.model.scale, self.is_
        psi = s["psi"] - self.heading
        # zigzag
        flip = is_["zigzag"] & (self.side * psi >= self.turn_by)
        self.side = np.where(flip, -self.side, self.side)
        target = np.where(is_["reciprocal"] & (t > 0.5 * self.duration), np.pi, 0.0)
        target = np.where(is_["berthing"], 0.6 * np.sin(2.0 * np.pi * t / (0.8 * self.duration)), target)
        pd = np.clip(-(1.2 * (psi - target) + 6.0 * T * s["r"]), -0.44, 0.44)
        turn = np.where(t < 10.0 * T, 0.0, np.where(t > 0.5 * self.duration, -1.0, 1.0)) * self.rudder
        delta = np.select([is_["zigzag"], is_["turn"]], [self.side * np.abs(self.rudder), turn], pd)
        n = self.n.copy()
        u_ref = self.u0 * np.clip(1.0 - t / (0.7 * self.duration), 0.0, 1.0)
        slow = np.clip(u_ref / self.u0, 0.0, 1.0)
        error = (u_ref - s["u"]) / self.u0
        index = min(int(t / self.interval), next(iter(self.orders.values()))[2].shape[1] - 1)
        out = {}
        bow = np.clip(-(20.0 * (psi - target) + 60.0 * T * s["r"]), -25.0, 25.0) / T
        for c, (low, high, table) in self.orders.items():
            if c in ("delta", "delta_p", "delta_s"):
                order = delta
                if c != "delta":  # clamshell to slow down
                    open_ = np.clip(1.31 * (1.0 - slow) - 1.0 * error, 0.0, 1.6)
                    order = np.where(is_["berthing"], delta + (open_ if c == "delta_s" else -open_), delta)
            elif c == "n_p":
                order = n if self.model.is_vectwin else np.where(is_["berthing"], self.n * (slow + 2.0 * error), n)
            else:
                order = np.where(is_["berthing"], bow, 0.0)
            out[c] = np.clip(np.where(is_["random"], table[:, index], order), low, high)
        for i, schedule in self.scheduled:
            for c, steps in schedule.items():
                low, high, _ = self.orders[c]
                out[c][i] = min(max(next(value for start, value in reversed(steps) if start <= t), low), high)
        return out


def simulate(model, recordings, duration, dt, sample_s, wind, error):
    """Tracks of all recordings: dict of (recordings, samples) arrays.

    wind: (recordings, knots, 2) or None; error: (recordings, knots, 3) accelerations or None; knots every KNOT_S sqrt(L/3 m).
    """
    N, knot = len(recordings), KNOT_S * model.scale
    pilot = Pilot(model, recordings, duration)
    column = lambda key, default=0.0: np.array([float(r.get(key, default)) for r in recordings])
    s = {"x": column("x0_m"), "y": column("y0_m"), "psi": np.radians(column("heading_deg")), "u": pilot.u0 * column("start_share", 1.0),
         "v": np.zeros(N), "r": np.zeros(N), "q": np.zeros((3, N)), "t": 0.0}
    V = model.water(s["x"], s["y"], 0.0)
    cos, sin = np.cos(s["psi"]), np.sin(s["psi"])
    s["u"], s["v"] = s["u"] + V[0] * cos + V[1] * sin, s["v"] - V[0] * sin + V[1] * cos
    indicated = pilot.initial()
    rudders = [c for c in indicated if c.startswith("delta")]
    steps, every = int(round(duration / dt)), int(round(sample_s / dt))
    history = {c: np.empty((steps + 1, N)) for c in rudders}
    for c in rudders:
        history[c][0] = indicated[c]
    acting = {c: a.copy() for c, a in indicated.items()}
    delay, lag, rate = (np.broadcast_to(np.asarray(model.e[k], float).reshape(-1), (N,)) for k in ("delay", "lag", "rate"))
    late = bool({"delay", "lag", "rate"} & model.active)
    share = np.where(lag > 1e-9, 1.0 - np.exp(-dt / np.maximum(lag, 1e-9)), 1.0)
    columns = np.arange(N)
    samples = steps // every + 1
    keep = {k: np.empty((N, samples)) for k in ("x", "y", "psi", "u", "v", "r", "wx", "wy")}
    keep["q"] = np.empty((3, N, samples))
    keep.update({f"a_{c}": np.empty((N, samples)) for c in indicated})
    keep.update({f"acting_{c}": np.empty((N, samples)) for c in indicated})
    remembers = bool({"memory", "tank"} & model.active)

    def at(path, t):
        k = t / knot
        i = int(k)
        return path[:, i] * (1.0 - (k - i)) + path[:, i + 1] * (k - i)

    def rates(state, act, w, extra):
        du, dv, dr = model.accelerations(state, act, w)
        cos, sin = np.cos(state["psi"]), np.sin(state["psi"])
        out = {"x": state["u"] * cos - state["v"] * sin, "y": state["u"] * sin + state["v"] * cos, "psi": state["r"],
               "u": du + extra[0], "v": dv + extra[1], "r": dr + extra[2]}
        if remembers:
            out["q"] = model.memories(state, act)
        return out

    keys = ("x", "y", "psi", "u", "v", "r") + (("q",) if remembers else ())
    zero = (0.0, 0.0, 0.0)
    for k in range(steps + 1):
        t = k * dt
        w0 = at(wind, t).T if wind is not None else None
        if k % every == 0:
            j = k // every
            for name in ("x", "y", "psi", "u", "v", "r"):
                keep[name][:, j] = s[name]
            keep["q"][:, :, j] = s["q"]
            keep["wx"][:, j], keep["wy"][:, j] = w0 if w0 is not None else (0.0, 0.0)
            for c in indicated:
                keep[f"a_{c}"][:, j], keep[f"acting_{c}"][:, j] = indicated[c], acting[c]
        if k == steps:
            break
        orders = pilot.command(t, s)
        after, acts = {}, {}
        for c, y in indicated.items():
            a = pilot.actuators[c]
            K, unit = (math.radians(a["rate_degps"]), 0) if c in rudders else (a["rate_rpsps"], 0)
            step = np.clip((orders[c] - y) * (1.0 - math.exp(-dt / a["time_constant_s"])), -K * dt, K * dt)
            after[c] = y + step
            acts[c] = after[c]
        if late:
            for c in rudders:
                history[c][k + 1] = after[c]
                place = np.maximum((k + 1) - delay / dt, 0.0)
                i = np.minimum(place.astype(int), k)
                target = history[c][i, columns] * (1.0 - (place - i)) + history[c][i + 1, columns] * (place - i)
                acts[c] = acting[c] + np.clip((target - acting[c]) * share, -rate * dt, rate * dt)
        middle = {c: 0.5 * (acting[c] + acts[c]) for c in acting}
        w1, w2 = (at(wind, t + 0.5 * dt).T, at(wind, t + dt).T) if wind is not None else (None, None)
        e0, e1, e2 = (at(error, t).T, at(error, t + 0.5 * dt).T, at(error, t + dt).T) if error is not None else (zero, zero, zero)
        k1 = rates(s, acting, w0, e0)
        mid = {n: s[n] + 0.5 * dt * k1[n] for n in keys}
        k2 = rates({**s, **mid, "t": t + 0.5 * dt}, middle, w1, e1)
        mid = {n: s[n] + 0.5 * dt * k2[n] for n in keys}
        k3 = rates({**s, **mid, "t": t + 0.5 * dt}, middle, w1, e1)
        end = {n: s[n] + dt * k3[n] for n in keys}
        k4 = rates({**s, **end, "t": t + dt}, acts, w2, e2)
        for n in keys:
            s[n] = s[n] + dt / 6.0 * (k1[n] + 2.0 * (k2[n] + k3[n]) + k4[n])
        s["t"] = t + dt
        indicated, acting = after, acts
    keep["t"] = np.arange(samples) * sample_s
    keep["channels"] = tuple(indicated)
    return keep
