"""A ship of the second house: four degrees of freedom, cross flow by strips, tables in place of formulas.

Data flow: `ships/NAME.json` (tables, identified by `identify` from free runs of the shipped ship) -> Vessel(name, factors, effects)
-> rates(state, acting, wind) -> the time loop of voyage.py. Nothing here comes from the first house's model.py.

Momenta (Kirchhoff, heave and pitch held, G at (x_G, 0, z_G), z down, origin midship at the waterline):
    p_x = (m + m_x) u,  p_y = (m + m_y) v + m (x_G r - z_G p),  h_x = I_x p - m z_G v,  h_z = I_z r + m x_G v
    p_x' = r p_y + X;  p_y' = -r p_x + Y;  h_x' = m z_G u r + K;  h_z' = v p_x - u p_y - m z_G u p + N
so that without forces the kinetic energy stays, and the Munk moment is in the momenta, not in N_v.
Forces are linear in the tables: hull by 12 strips with C_D(x) = c0 + c1 xi + c2 xi^2, lift and cubic cross terms; resistance by a
table over speed; rudder forces X, Y, N each by a table over the local angle; wind by tables over its direction; propeller by a table
of K_T over J, with an engine that slows under load (voyage.py). Arrays hold one recording per element.
"""

import json
import math
import pathlib

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
SHIPS = HERE.parents[2] / "configs" / "ships"
G = 9.80665
BY_FROUDE = {"vectwin-150m": "vectwin-3m"}  # nondimensional numbers alike, so the tables are, too
SPEED_KNOTS = np.array([0.0, 0.3, 0.6, 0.85, 1.1, 1.5])  # of the design speed
WIND_KNOTS = np.radians([0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0])
SINGLE_KNOTS = np.radians([-90.0, -60.0, -40.0, -28.0, -18.0, -9.0, 0.0, 9.0, 18.0, 28.0, 40.0, 60.0, 90.0])
TWIN_KNOTS = np.radians([-125.0, -105.0, -85.0, -65.0, -45.0, -30.0, -15.0, 0.0, 15.0, 30.0, 45.0, 65.0, 85.0, 105.0, 125.0])
TWIST_KNOTS = np.radians([0.0, 40.0, 80.0, 120.0, 160.0, 210.0])
STRIPS = (np.arange(12) + 0.5) / 6.0 - 1.0  # xi = 2 x / L
SCALARS = ("X_vr", "X_vv", "X_rr", "X_vvvv", "Y_v", "Y_r", "Y_vvr", "Y_vrr", "N_v", "N_r", "N_vvr", "N_vrr", "C0", "C1", "C2",
           "X_back", "X_back_u", "Y_back", "N_back")

# Standard deviation of the logarithm with which a coefficient may be off: missing-physics numbers, as the tools take unless a file states others.
STATED = dict(resistance=0.10, X_vr=0.3, Y_v=0.15, Y_r=0.25, N_v=0.15, N_r=0.15, C_D=0.20, m_x=0.3, m_y=0.15, I_z=0.15, K_T=0.05, wake=0.05,
              thrust_share=0.05, rudder=0.10, rudder_aft=0.1, gamma=0.2, wind_X=0.2, wind_Y=0.15, wind_N=0.3, thruster=0.10)

NEUTRAL = dict(
    current=0.0, current_dir=0.0, tide=0.0, tide_w=0.01, tide_phase=0.0, hs=0.0, wave_from=0.0, fouling=0.0, thrust_loss=0.0, rudder_loss=0.0,
    rudder_offset=0.0, delay=0.0, lag=0.0, F=0.0, tug=0.0, tug_dir=0.0, tug_x=0.0, tug_start=0.0, tug_end=0.0, body_X=0.0, body_Y=0.0, earth_X=0.0,
    earth_Y=0.0, C_D_gain=1.0, draft=0.0, walk=0.0, windage=1.0, wake=0.0, thruster=1.0,
    # not in the catalogue
    cargo=0.0, seiche=0.0, seiche_dir=0.0, seiche_w=0.1, weed=0.0, weed_time=1.0, backlash=0.0, shoal=0.0, shoal_x=0.0, shoal_y=0.0, shoal_R=1.0,
    tank=0.0)


def table(knots, values, x):
    """Linear between the knots, level outside."""
    return np.interp(x, knots, values)


class Vessel:
    """A ship with its tables; `factors` and `effects` map names to numbers or arrays, one element per recording."""

    def __init__(self, name, factors=None, effects=None, tables=None):
        self.ship = json.loads((SHIPS / f"{name}.json").read_text(encoding="utf-8"))
        self.name = name
        file = HERE / "ships" / f"{BY_FROUDE.get(name, name)}.json"
        self.tables = tables if tables is not None else json.loads(file.read_text(encoding="utf-8"))["tables"]
        p = self.ship["particulars"]
        self.L, self.B, self.d, self.rho = p["L_pp_m"], p["B_m"], p["d_m"], p["rho_kgpm3"]
        self.f = {k: (factors or {}).get(k, 1.0) for k in STATED}
        self.e = {**NEUTRAL, **(effects or {})}
        self.active = {k for k, v in NEUTRAL.items() if np.any(np.asarray(self.e[k]) != v)}
        self.scale = math.sqrt(self.L / 3.0)
        self.u_design = self.ship["u0_mps"]
        self.q = 0.5 * self.rho * self.L * self.d
        self.is_twin = self.ship["rudder"]["type"].startswith("vectwin")
        self.rudders = ("delta_p", "delta_s") if self.is_twin else ("delta",)
        self.knots = TWIN_KNOTS if self.is_twin else SINGLE_KNOTS
        self.D = self.ship["propeller"]["D_P_m"]
        rd = self.ship["rudder"]
        self.A_R = rd["A_R_m2"]
        self.eta = min(1.0, self.D / (rd["H_R_m"] if "H_R_m" in rd else math.sqrt(self.A_R * rd["aspect_ratio"])))
        pr = self.ship["propeller"]
        k = pr["K_T_ahead"] if self.is_twin else pr["K_T"]
        self.J_knots = np.linspace(-0.6, 1.2, 13)
        curve = k[0] + k[1] * self.J_knots + k[2] * self.J_knots**2
        self.K_T = curve + 0.012 * np.sin(7.0 * self.J_knots) * (np.abs(self.J_knots) < 0.9)  # another open-water test of the same propeller
        self.K_Q_slope = 0.6  # torque falls with J less steeply than thrust
        i = self.ship["inertia"]
        mass = self.q * self.L
        gain = 1.0 + self.e["draft"]
        shoal = np.asarray(self.e["F"], float)
        self.m = i["m"] * mass * gain
        self.m_x = i["m_x"] * mass * gain * self.f["m_x"]
        self.m_y = i["m_y"] * mass * gain * self.f["m_y"] * (1.0 + 1.9 * shoal**2.6)
        self.x_G, self.z_G = i["x_G"] * self.L, 0.08 * self.d
        self.I_z = i["I_zG_plus_J_z"] * mass * self.L**2 * gain * self.f["I_z"] * (1.0 + 0.8 * shoal**2.6) + self.m * self.x_G**2
        self.I_x = self.m * ((0.36 * self.B) ** 2 * 1.2 + self.z_G**2)
        self.GM = 0.06 * self.B
        self.roll_damping = 2.0 * 0.08 * np.sqrt(self.m * G * self.GM * self.I_x)
        self.munk = i["m_y"] - i["m_x"]

    # --- forces, linear in the tables -----------------------------------------------------------------------------
    def hull(self, u, v, r, p, phi, tables):
        t, f, e, L = tables, self.f, self.e, self.L
        U = np.sqrt(u * u + v * v) + 1e-9
        lr = L * r
        F = np.asarray(e["F"], float)
        share = np.abs(u) / self.u_design
        R = table(SPEED_KNOTS, t["R"], share) * f["resistance"] * (1.0 + e["fouling"] * (0.7 + 0.3 * np.minimum(share, 2.0))) * (1.0 + 0.4 * F**2)
        X = -R * u * np.abs(u) + t["X_vr"] * f["X_vr"] * v * lr + t["X_vv"] * v * v + t["X_rr"] * lr * lr + t["X_vvvv"] * v**4 / (U * U)
        # the file's N_v holds the Munk moment, which is in the momenta here
        N_v = (t["N_v"] - self.munk) * f["N_v"] * (1.0 + 2.2 * F**2.8) + self.munk * (1.0 + 1.9 * F**2.6)
        Y = t["Y_v"] * f["Y_v"] * (1.0 + 2.0 * F**2.8) * np.abs(u) * v + t["Y_r"] * f["Y_r"] * u * lr
        N = N_v * u * v + t["N_r"] * f["N_r"] * (1.0 + 0.5 * F**2) * np.abs(u) * lr
        Y = Y + t["Y_vvr"] * v * v * lr / U + t["Y_vrr"] * v * lr * lr / U
        N = N + t["N_vvr"] * v * v * lr / U + t["N_vrr"] * v * lr * lr / U
        for xi in STRIPS:
            w = v + 0.5 * xi * lr
            C = (t["C0"] + t["C1"] * xi + t["C2"] * xi * xi) * f["C_D"] * (1.0 + (e["C_D_gain"] - 1.0) * (1.0 - 0.25 * xi))
            side = -C * np.abs(w) * w / len(STRIPS)
            Y, N = Y + side, N + 0.5 * xi * side
        # heel: a hull that leans sails a curve
        Y = Y + t["Y_phi"] * phi * u * u
        N = N + t["N_phi"] * phi * u * u
        gain = (1.0 + e["draft"]) * self.q
        return gain * X, gain * Y, gain * L * N

    def propeller(self, u, v, r, n, tables):
        """X, Y, N, n^2 K_T, u_P."""
        f, e, D = self.f, self.e, self.D
        U = np.sqrt(u * u + v * v) + 1e-9
        drift = np.abs(v - 0.48 * self.L * r) / U
        ahead = u > 0.0
        w0 = tables["w0"] - tables["w_drift"] * np.minimum(drift, 0.6)  # straight line, not an exponential
        open_ = np.clip((1.0 - w0) * f["wake"] - e["wake"] * (1.0 - 0.5 * np.minimum(drift, 1.0)) - 0.02 * e["fouling"], 0.05, 1.0)
        u_P = np.where(ahead, open_, 1.0) * u
        running = np.where(np.abs(n) > 1e-6, n, 1e-6)
        J = np.clip(u_P / (running * D), -0.6, 1.2)
        n2K = np.where(n > 0.0, n * n * table(self.J_knots, self.K_T, J), 0.0)
        stopped = self.K_T[-1] / 1.44 * u_P * np.abs(u_P) / (D * D)  # of a propeller that hardly turns
        n2K = np.where((n > 1e-6) & (u_P <= 1.2 * n * D), n * n * table(self.J_knots, self.K_T, J), stopped)
        n2K = n2K * f["K_T"] * (1.0 - e["thrust_loss"] * (0.8 + 0.4 * np.clip(J, 0.0, 1.0)))
        scale = self.rho * D**4
        X = (1.0 - tables["t0"]) * f["thrust_share"] * scale * n2K
        back = np.minimum(n, 0.0)
        X = X + scale * (tables["X_back"] * back * back + tables["X_back_u"] * back * u / D)
        Y, N = scale * tables["Y_back"] * back * back, scale * self.L * tables["N_back"] * back * back
        if "walk" in self.active:
            side = e["walk"] * scale * n * np.abs(n) * np.where(n < 0.0, 1.2, 0.8 + 0.3 * np.clip(J, 0.0, 1.0))
            Y, N = Y + 0.6 * side, N - 0.3 * self.L * side
        return X, Y, N, n2K, u_P

    def rudder_flow(self, u, v, r, p, n2K, u_P, tables):
        race = tables["k_race"] * 8.0 * n2K * self.D**2 / np.pi
        along2 = np.where(u_P < 0.0, -1.0, 1.0) * u_P * u_P + self.eta * np.maximum(race, -0.6 * u_P * u_P)
        along = np.sign(along2) * np.sqrt(np.abs(along2))
        drift = v + tables["l"] * self.L * r - 0.5 * self.d * p
        side = tables["gamma_lopsided"] * np.tanh(drift / (0.05 * self.u_design))  # straightens one side more than the other
        across = -tables["gamma"] * self.f["gamma"] * (1.0 + side) * drift
        return along, across

    def rudder(self, u, v, r, p, n2K, u_P, acting, tables):
        along, across = self.rudder_flow(u, v, r, p, n2K, u_P, tables)
        q = 0.5 * self.rho * self.A_R * (along * along + across * across) * self.f["rudder"]
        lean = np.arctan2(across, np.where(np.abs(along) < 1e-6, 1e-6, np.abs(along)))
        X = Y = N = 0.0
        for c in self.rudders:
            delta = acting[c] + self.e["rudder_offset"] + tables["neutral"]
            alpha = delta - lean
            loss = 1.0 - self.e["rudder_loss"] * (1.0 - 0.3 * np.abs(np.sin(alpha)))
            force = -q * loss * np.where(along < 0.0, -0.7, 1.0)
            X = X + np.abs(force) * -1.0 * table(self.knots, tables[f"X_{c}"], alpha)
            Y = Y + force * table(self.knots, tables[f"Y_{c}"], alpha)
            N = N + force * self.L * self.f["rudder_aft"] * table(self.knots, tables[f"N_{c}"], alpha)
        if self.is_twin:  # blades that open towards one another choke the race
            twist = acting["delta_s"] - acting["delta_p"]
            X = X - q * table(TWIST_KNOTS, tables["X_twist"], twist)
        return X, Y, N

    def thruster(self, u, n_bt):
        t = self.ship["thrusters"][0]
        T = self.rho * t["D_m"] ** 4 * np.where(n_bt < 0.0, t["K_T_negative"], t["K_T_positive"]) * n_bt * n_bt * self.f["thruster"] * self.e["thruster"]
        speeds = np.linspace(0.0, 1.1, 9)
        Fr = np.minimum(speeds, 1.0) * t["u_max_mps"] / math.sqrt(G * self.L)
        left = [np.where(speeds > 1.05, 0.0, 1.0 + a[0] + a[1] * Fr + a[2] * Fr * Fr) for a in (t["a_Y"], t["a_N"])]
        at = np.abs(u) / t["u_max_mps"]
        return T * table(speeds, left[0], at), T * t["x_m"] * table(speeds, left[1], at)

    def wind(self, ax, ay, tables):
        """Apparent wind (ax, ay): to where it comes from, in ship axes."""
        w, f, gain = self.ship["wind"], self.f, self.e["windage"]
        q = 0.5 * w["rho_air_kgpm3"] * w["A_L_m2"] * (ax * ax + ay * ay)
        gamma = np.arctan2(ay, ax)
        side, a = np.sign(gamma), np.abs(gamma)
        return (q * gain * f["wind_X"] * table(WIND_KNOTS, tables["wind_X"], a), q * gain * f["wind_Y"] * side * table(WIND_KNOTS, tables["wind_Y"], a),
                q * gain * f["wind_N"] * self.L * side * table(WIND_KNOTS, tables["wind_N"], a))

    def forces(self, s, acting, wind, tables, u, v):
        """X, Y, K, N of the ship's own parts; (u, v) through the water."""
        r, p, phi = s["r"], s["p"], s["phi"]
        n = acting["n_p"]
        H = self.hull(u, v, r, p, phi, tables)
        P = self.propeller(u, v, r, n, tables)
        R = self.rudder(u, v, r, p, P[3], P[4], acting, tables)
        X, Y, N = H[0] + P[0] + R[0], H[1] + P[1] + R[1], H[2] + P[2] + R[2]
        K = -0.45 * self.d * H[1] - 0.6 * self.d * R[1]
        if "n_bt" in acting:
            T = self.thruster(u, acting["n_bt"])
            Y, N, K = Y + T[0], N + T[1], K - 0.6 * self.d * T[0]
        if wind is not None and "wind" in self.ship:
            cos, sin = np.cos(s["psi"]), np.sin(s["psi"])
            A = self.wind(wind[0] * cos + wind[1] * sin + s["u"], -wind[0] * sin + wind[1] * cos + s["v"], tables)
            X, Y, N, K = X + A[0], Y + A[1], N + A[2], K + 0.7 * self.d * A[1]
        return X, Y, K, N

    # --- motion -----------------------------------------------------------------------------------------------------
    def water(self, s):
        """Velocity of the water over ground, in earth axes, and its rate with time."""
        e = self.e
        Vx = Vy = ax = ay = 0.0
        if "current" in self.active:  # a little uneven over some forty lengths
            gain = e["current"] * (1.0 + 0.08 * np.sin((s["x"] + 0.6 * s["y"]) * 2.0 * np.pi / (40.0 * self.L)))
            Vx, Vy = gain * np.cos(e["current_dir"]), gain * np.sin(e["current_dir"])
        if "tide" in self.active:
            for k, (gain, rate, turn) in enumerate(((1.0, 1.0, 0.0), (0.6, 1.83, 2.1), (0.4, 3.1, 4.0))):
                phase = e["tide_w"] * rate * s["t"] + e["tide_phase"] * (1.0 + 0.7 * k)
                Vx, Vy = Vx + e["tide"] * gain * np.sin(phase), Vy + e["tide"] * gain * np.cos(phase + turn)
                ax, ay = ax + e["tide"] * gain * e["tide_w"] * rate * np.cos(phase), ay - e["tide"] * gain * e["tide_w"] * rate * np.sin(phase + turn)
        return Vx, Vy, ax, ay

    def outside_forces(self, s, acting, u, v, cos, sin):
        e, L, on, t = self.e, self.L, self.active, s["t"]
        mass = self.ship["inertia"]["m"] * self.q * L
        X = Y = K = N = 0.0
        if "hs" in on:
            mu = e["wave_from"] - s["psi"]
            group = e["hs"] ** 2 * self.rho * G * (1.0 + 0.4 * np.sin(2.0 * np.pi * t / (55.0 * self.scale)))
            X, Y = -group * self.B**2 / L / 9.0 * np.cos(mu), -group * L / 16.0 * 0.62 * np.sin(mu) * (1.0 - 0.35 * np.cos(2.0 * mu)) / 1.35
            N = -group * L * L / 16.0 * 0.05 * np.sin(mu) * np.cos(mu)
        if "tug" in on:
            ramp = 8.0 * self.scale
            inside = np.clip(np.minimum((t - e["tug_start"]) / ramp + 0.5, (e["tug_end"] - t) / ramp + 0.5), 0.0, 1.0)
            F = e["tug"] * inside
            X, Y, N = X + F * np.cos(e["tug_dir"]), Y + F * np.sin(e["tug_dir"]), N + e["tug_x"] * F * np.sin(e["tug_dir"])
        pull_x, pull_y = e["earth_X"] + 0.0, e["earth_Y"] + 0.0
        if "seiche" in on:
            F = e["seiche"] * mass * np.sin(e["seiche_w"] * t)
            pull_x, pull_y = pull_x + F * np.cos(e["seiche_dir"]), pull_y + F * np.sin(e["seiche_dir"])
        X, Y = X + e["body_X"] + pull_x * cos + pull_y * sin, Y + e["body_Y"] - pull_x * sin + pull_y * cos
        if "cargo" in on:
            K = K + e["cargo"] * mass * G * self.GM
        if "weed" in on:
            grown = e["weed"] * mass * np.minimum(t / e["weed_time"], 1.0) / (self.u_design * self.scale)
            X, Y = X - grown * u, Y - grown * v
        if "shoal" in on:
            near = np.exp(-(((s["x"] - e["shoal_x"]) ** 2 + (s["y"] - e["shoal_y"]) ** 2) / e["shoal_R"] ** 2))
            drag = e["shoal"] * mass * near
            X, N = X - drag * np.tanh(3.0 * u / self.u_design), N + 0.3 * L * drag * np.tanh(3.0 * u / self.u_design)
        if "tank" in on:
            Y, K = Y - e["tank"] * mass * s["q"][0], K + 0.5 * self.d * e["tank"] * mass * s["q"][0]
        return X, Y, K, N

    def rates(self, s, acting, wind, extra=(0.0, 0.0, 0.0)):
        """Rates of (x, y, phi, psi, u, v, p, r); s holds velocities over ground, `extra` accelerations of model error."""
        cos, sin = np.cos(s["psi"]), np.sin(s["psi"])
        Vx, Vy, ax, ay = self.water(s)
        u_c, v_c = Vx * cos + Vy * sin, -Vx * sin + Vy * cos
        u, v, p, r = s["u"] - u_c, s["v"] - v_c, s["p"], s["r"]
        X, Y, K, N = self.forces(s, acting, wind, self.tables, u, v)
        A = self.outside_forces(s, acting, u, v, cos, sin)
        X, Y, K, N = X + A[0], Y + A[1], K + A[2], N + A[3]
        K = K - self.m * G * self.GM * np.sin(s["phi"]) - self.roll_damping * p
        # in velocities through the water; a water that gets faster pushes by the displaced mass
        bx, by = ax * cos + ay * sin, -ax * sin + ay * cos
        p_x, p_y = (self.m + self.m_x) * u, (self.m + self.m_y) * v + self.m * (self.x_G * r - self.z_G * p)
        X, Y = X - self.m * bx, Y - self.m * by
        du = (r * p_y + X) / (self.m + self.m_x)
        R1, R2, R3 = -r * p_x + Y, self.m * self.z_G * u * r + K, v * p_x - u * p_y - self.m * self.z_G * u * p + N
        a, b, c = self.m + self.m_y, -self.m * self.z_G, self.m * self.x_G
        # [a b c; b I_x 0; c 0 I_z] (v', p', r') = (R1, R2, R3)
        dv = (R1 - b * R2 / self.I_x - c * R3 / self.I_z) / (a - b * b / self.I_x - c * c / self.I_z)
        dp, dr = (R2 - b * dv) / self.I_x, (R3 - c * dv) / self.I_z
        out = {"x": s["u"] * cos - s["v"] * sin, "y": s["u"] * sin + s["v"] * cos, "phi": p, "psi": r, "u": du + r * v_c + bx + extra[0],
               "v": dv - r * u_c + by + extra[1], "p": dp, "r": dr + extra[2]}
        if "q" in s:
            w = 0.9 / self.scale
            sway = s["u"] * r + 0.3 * G * s["phi"]
            out["q"] = np.stack([s["q"][1], w * w * (15.0 * sway - s["q"][0]) - 0.12 * w * s["q"][1]])
        return out
