"""The time loop of the second house: weather, vessel, engine, instruments, and pilots who see the instruments alone.

sail(vessel, orders, ...) -> {"true": columns (recordings, samples) by name, "recorded": the same as instruments wrote them}.
Each sample the instruments write a row (each channel at its own jittered time), the pilot reads that row, and his orders stand until the next.
"""

import math

import numpy as np

G = 9.80665


class Instruments:
    """Rows from states. `spec`: columns (one element per recording) of fault parameters by the catalogue's names, 0 (scale: 1) where there is none."""

    def __init__(self, rngs, spec, noise_gain, sample_s, scale):
        self.rngs, self.spec, self.gain, self.h, self.scale = rngs, spec, noise_gain, sample_s, scale
        n = len(rngs)
        big = scale > 2.0
        self.sd = {"x0_m": 0.02, "y0_m": 0.02, "psi_deg": 0.05, "u_mps": 0.008, "vm_mps": 0.008, "r_degps": 0.006 if big else 0.06}
        self.step = {"x0_m": 0.01, "y0_m": 0.01, "psi_deg": 0.1, "u_mps": 0.01, "vm_mps": 0.01, "r_degps": 0.01 if big else 0.05}
        self.drift_sd, self.drift_tau = (0.25 if big else 0.02), (240.0 if big else 40.0)  # of GNSS, or of a total station's prism
        self.drift = np.array([r.standard_normal(2) for r in rngs]).T * self.drift_sd
        self.history, self.filter, self.n = [], None, n

    def column(self, name, neutral=0.0):
        return np.asarray(self.spec.get(name, np.full(self.n, neutral)), float)

    def row(self, t, s, rate, acting, wind):
        """Recorded channels (recordings,) by name at t; s holds states, rate their rates (for the jitter of the clocks)."""
        draw = lambda: np.array([r.standard_normal() for r in self.rngs])
        jitter = lambda: np.clip(draw(), -2.0, 2.0) * min(0.02 * self.h, 0.01)  # [s]
        a = math.exp(-self.h / self.drift_tau)
        self.drift = a * self.drift + math.sqrt(1.0 - a * a) * self.drift_sd * np.stack([draw(), draw()])
        e = [jitter() for _ in range(3)]
        psi = s["psi"] + rate["psi"] * e[1]
        lx, ly = self.column("lever_x_m"), self.column("lever_y_m")
        now = {"x0_m": s["x"] + rate["x"] * e[0] + lx * np.cos(s["psi"]) - ly * np.sin(s["psi"]),
               "y0_m": s["y"] + rate["y"] * e[0] + lx * np.sin(s["psi"]) + ly * np.cos(s["psi"]),
               "psi_deg": np.degrees(psi) + self.column("heading_bias_deg"),
               "u_mps": (s["u"] + rate["u"] * e[2]) * (1.0 + self.column("log_scale")), "vm_mps": s["v"] + rate["v"] * e[2],
               "r_degps": np.degrees(s["r"] + rate["r"] * e[2]) + self.column("rate_bias_degps")}
        tau = self.column("filter_s")
        if np.any(tau > 0.0):
            self.filter = self.filter or [{k: now[k] for k in ("u_mps", "vm_mps", "r_degps")} for _ in range(2)]
            share = np.where(tau > 0.0, 1.0 - np.exp(-self.h / np.maximum(0.5 * tau, 1e-6)), 1.0)
            for k in ("u_mps", "vm_mps", "r_degps"):  # two stages of half the time constant
                value = now[k]
                for stage in self.filter:
                    stage[k] = value = stage[k] + share * (value - stage[k])
                now[k] = value
        self.history.append({k: now[k] for k in ("u_mps", "vm_mps", "psi_deg")})
        for fault, channels in (("velocity_latency_s", ("u_mps", "vm_mps")), ("heading_latency_s", ("psi_deg",))):
            by = self.column(fault) / self.h
            if np.any(by > 0.0):
                place = np.maximum(len(self.history) - 1 - by, 0.0)
                i = np.minimum(place.astype(int), max(len(self.history) - 2, 0))
                j = np.minimum(i + 1, len(self.history) - 1)
                at = np.arange(self.n)
                for k in channels:
                    table = np.stack([h[k] for h in self.history[int(i.min()):]])
                    a_, b_ = table[i - int(i.min()), at], table[j - int(i.min()), at]
                    now[k] = a_ + (b_ - a_) * np.minimum(place - i, 1.0)
        now["x0_m"], now["y0_m"] = now["x0_m"] + self.gain * self.drift[0], now["y0_m"] + self.gain * self.drift[1]
        for k, sd in self.sd.items():
            now[k] = np.round((now[k] + self.gain * sd * draw()) / self.step[k]) * self.step[k]
        for c, value in acting.items():
            if c.startswith(("delta",)):
                now[f"{c}_deg"] = np.round((np.degrees(value) + 0.1 * draw()) / 0.1) * 0.1
            else:
                now[f"{c}_rps"] = np.round(value * (1.0 + 0.002 * draw()) * 1000.0) / 1000.0
        # the anemometer sees the apparent wind; with the recorded heading and speed it becomes the true one
        psi_m = np.radians(now["psi_deg"])
        wx, wy = wind
        k = self.column("anemometer_scale", 1.0)
        ax = wx * np.cos(s["psi"]) + wy * np.sin(s["psi"]) + s["u"]
        ay = -wx * np.sin(s["psi"]) + wy * np.cos(s["psi"]) + s["v"]
        speed, angle = k * np.hypot(ax, ay) * (1.0 + 0.03 * draw()), np.arctan2(ay, ax) + math.radians(2.0) * draw()
        bx, by = speed * np.cos(angle) - now["u_mps"], speed * np.sin(angle) - now["vm_mps"]
        now["wind_speed_mps"] = np.round(np.hypot(bx, by), 2)
        turn = np.where(self.column("wind_to") > 0.0, 180.0, 0.0)
        now["wind_dir_deg"] = np.round((np.degrees(np.arctan2(by, bx) + psi_m) + turn) % 360.0)
        return now


class Pilot:
    """Orders from recorded rows; recordings are dicts with `kind` and the kind's numbers."""

    def __init__(self, vessel, recordings, duration):
        ship, self.T, self.duration = vessel.ship, vessel.scale, duration
        self.vessel = vessel
        column = lambda key, default=0.0: np.array([float(r.get(key, default)) for r in recordings])
        self.actuators = {a["channel"]: a for a in ship["actuators"] if not a.get("optional")}
        self.kind = np.array([r["kind"] for r in recordings])
        self.heading, self.rudder, self.turn_by = np.radians(column("heading_deg")), np.radians(column("rudder_deg")), np.radians(column("turn_by_deg", 10.0))
        initial = next(a["initial_rps"] for a in ship["actuators"] if a["channel"] == "n_p")
        self.n = initial * column("n_share", 1.0)
        self.u0 = ship["u0_mps"] * column("u_share", 1.0)
        self.side = np.where(self.rudder < 0.0, -1.0, 1.0)
        self.interval = ship["random_interval_s"]
        steps = int(duration / self.interval) + 2
        self.table = {}
        for c, a in self.actuators.items():
            unit, to = ("deg", math.pi / 180.0) if c.startswith("delta") else ("rps", 1.0)
            low, high = a[f"min_{unit}"] * to, a[f"max_{unit}"] * to
            draws = np.empty((len(recordings), steps))
            for i, r in enumerate(recordings):
                rng = np.random.default_rng([r["seed"], 100 + sum(c.encode())])
                mean, sd = a.get(f"random_mean_{unit}"), a.get(f"random_sd_{unit}", 0.0)
                value = mean * to + sd * to * rng.standard_normal(steps) if mean is not None else self.n[i] * rng.uniform(0.8, 1.1, steps) if c == "n_p" else np.zeros(steps)
                if c.startswith("delta") and len(vessel.rudders) == 2 and r.get("gentle"):  # both alike
                    value = np.clip(np.random.default_rng([r["seed"], 9]).normal(0.0, math.radians(15.0), steps), -0.55, 0.55)
                draws[i] = np.clip(value, low, high)
            self.table[c] = (low, high, draws)

    def start(self):
        out = {c: np.zeros(len(self.kind)) for c in self.actuators}
        out["n_p"] = self.n.copy()
        for c, (_, _, draws) in self.table.items():
            out[c] = np.where(self.kind == "random", draws[:, 0], out[c])
        return out

    def orders(self, t, row):
        is_ = lambda kind: self.kind == kind
        psi, r = np.radians(row["psi_deg"]) - self.heading, np.radians(row["r_degps"])
        self.side = np.where(is_("zigzag") & (self.side * psi >= self.turn_by), -self.side, self.side)
        target = np.where(is_("reciprocal") & (t > 0.5 * self.duration), np.pi, 0.0)
        keep = np.clip(-(1.0 * (psi - target) + 5.0 * self.T * r), -0.44, 0.44)
        turn = np.where(t < 8.0 * self.T, 0.0, np.where(t > 0.55 * self.duration, -1.0, 1.0)) * self.rudder
        delta = np.select([is_("zigzag"), is_("turn")], [self.side * np.abs(self.rudder), turn], keep)
        # speeds: a course held at revolutions that step down and up
        level = np.where(t < 0.33 * self.duration, 1.0, np.where(t < 0.66 * self.duration, 0.55, 1.15))
        n = self.n * np.where(is_("speeds"), level, 1.0)
        index = min(int(t / self.interval), next(iter(self.table.values()))[2].shape[1] - 1)
        out = {}
        for c, (low, high, draws) in self.table.items():
            order = delta if c.startswith("delta") else n if c == "n_p" else np.zeros(len(self.kind))
            out[c] = np.clip(np.where(is_("random"), draws[:, index], order), low, high)
        return out


def sail(vessel, recordings, duration, dt, sample_s, wind, error, instruments):
    """Tracks and rows; wind, error: functions of time (weather.py) or None."""
    n = len(recordings)
    pilot = Pilot(vessel, recordings, duration)
    column = lambda key, default=0.0: np.array([float(r.get(key, default)) for r in recordings])
    s = {k: np.zeros(n) for k in ("x", "y", "phi", "v", "p", "r")}
    s.update({"psi": np.radians(column("heading_deg")), "u": pilot.u0 * column("start_share", 1.0), "t": 0.0, "q": np.zeros((2, n))})
    Vx, Vy, _, _ = vessel.water(s)
    cos, sin = np.cos(s["psi"]), np.sin(s["psi"])
    s["u"], s["v"] = s["u"] + Vx * cos + Vy * sin, s["v"] - Vx * sin + Vy * cos
    indicated = pilot.start()
    acting = {c: a.copy() for c, a in indicated.items()}
    every = int(round(sample_s / dt))
    steps = int(round(duration / sample_s)) * every
    delay, lag, play = (np.broadcast_to(np.asarray(vessel.e[k], float), (n,)) for k in ("delay", "lag", "backlash"))
    late = bool({"delay", "lag", "backlash"} & vessel.active)
    past = {c: [indicated[c]] for c in vessel.rudders}
    keys = ("x", "y", "phi", "psi", "u", "v", "p", "r") + (("q",) if "tank" in vessel.active else ())
    if "tank" not in vessel.active:
        s.pop("q")
    n_ref = np.maximum(np.abs(pilot.n), 1e-6)
    orders = indicated
    true, recorded = {}, {}
    calm = (np.zeros(n), np.zeros(n))
    for k in range(steps + 1):
        t = k * dt
        w = wind.at(t) if wind is not None else calm
        if k % every == 0:
            rate = vessel.rates(s, acting, w, error.at(t) if error is not None else (0.0, 0.0, 0.0))
            clean = {"x0_m": s["x"], "y0_m": s["y"], "psi_deg": np.degrees(s["psi"]), "u_mps": s["u"], "vm_mps": s["v"], "r_degps": np.degrees(s["r"]), "phi": s["phi"]}
            for c, a in indicated.items():
                clean[f"{c}_deg" if c.startswith("delta") else f"{c}_rps"] = np.degrees(a) if c.startswith("delta") else a
                clean[f"acting_{c}"] = acting[c]
            clean["wind_speed_mps"], clean["wind_dir_deg"] = np.hypot(*w), np.degrees(np.arctan2(w[1], w[0])) % 360.0
            clean["p"] = s["p"]
            for name, value in clean.items():
                true.setdefault(name, []).append(np.array(value, float) * np.ones(n))
            row = instruments.row(t, s, rate, indicated, w)
            for name, value in row.items():
                recorded.setdefault(name, []).append(np.array(value, float) * np.ones(n))
            orders = pilot.orders(t, row)
        if k == steps:
            break
        after = {}
        for c, y in indicated.items():
            a = pilot.actuators[c]
            limit = math.radians(a["rate_degps"]) if c.startswith("delta") else a["rate_rpsps"]
            order = orders[c]
            if c == "n_p":  # an engine that slows under load: the more so the slower the water meets its propeller
                Vx, Vy, _, _ = vessel.water(s)
                u_P = 0.6 * (s["u"] - Vx * np.cos(s["psi"]) - Vy * np.sin(s["psi"]))
                J = np.clip(u_P / np.maximum(np.abs(y) * vessel.D, 1e-6), -0.2, 1.2)
                J_ref = np.clip(pilot.u0 * 0.6 / (n_ref * vessel.D), 0.0, 1.2)
                order = order * (1.0 - 0.10 * np.clip((J_ref - J) / 0.4, -1.0, 1.0))
            after[c] = y + np.clip((order - y) * (1.0 - math.exp(-dt / max(a["time_constant_s"], 1e-3 * vessel.scale))), -limit * dt, limit * dt)
        acts = dict(after)
        if late:
            for c in vessel.rudders:
                past[c].append(after[c])
                place = np.maximum(len(past[c]) - 1 - delay / dt, 0.0)
                i = np.minimum(place.astype(int), len(past[c]) - 2)
                low = int(i.min())
                table = np.stack(past[c][low:])
                at = np.arange(n)
                target = table[i - low, at] + (table[i + 1 - low, at] - table[i - low, at]) * (place - i)
                target = acting[c] + np.sign(target - acting[c]) * np.maximum(np.abs(target - acting[c]) - play, 0.0)
                acts[c] = acting[c] + (target - acting[c]) * np.where(lag > 1e-9, 1.0 - np.exp(-dt / np.maximum(lag, 1e-9)), 1.0)
        middle = {c: 0.5 * (acting[c] + acts[c]) for c in acting}
        at = lambda time: ((wind.at(time) if wind is not None else calm), (error.at(time) if error is not None else (0.0, 0.0, 0.0)))
        (w0, e0), (w1, e1), (w2, e2) = (w, error.at(t) if error is not None else (0.0, 0.0, 0.0)), at(t + 0.5 * dt), at(t + dt)
        k1 = vessel.rates(s, acting, w0, e0)
        k2 = vessel.rates({**s, **{m: s[m] + 0.5 * dt * k1[m] for m in keys}, "t": t + 0.5 * dt}, middle, w1, e1)
        k3 = vessel.rates({**s, **{m: s[m] + 0.5 * dt * k2[m] for m in keys}, "t": t + 0.5 * dt}, middle, w1, e1)
        k4 = vessel.rates({**s, **{m: s[m] + dt * k3[m] for m in keys}, "t": t + dt}, acts, w2, e2)
        for m in keys:
            s[m] = s[m] + dt / 6.0 * (k1[m] + 2.0 * (k2[m] + k3[m]) + k4[m])
        s["t"] = t + dt
        indicated, acting = after, acts
    stack = lambda rows: {k: np.stack(v, 1) for k, v in rows.items()}
    return {"t_s": np.arange(steps // every + 1) * sample_s, "true": stack(true), "recorded": stack(recorded)}
