"""Equations of motion for the truth of the proof: ships' numbers come from configs/ships, equations are written here.

Level 1 has the equations of docs/mmg-sim.md. Level 2 replaces wake, open-water curve, rudder inflow and force, cross flow,
resistance, thruster, wind force and all effects' forms by others. Arrays hold one case per element; all names of arguments
broadcast, so that (cases,) serves the simulation and (cases, samples) the analysis along a track.
"""

import json
import math
import pathlib

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
G = 9.80665

# Coefficients whose factors differ between the truth and the ship that the tool is given: log-sd at "10 %" is 0.1 times these.
FACTORS = ("X_0", "X_vr", "Y_v", "Y_r", "N_v", "N_r", "C_D", "C_rY", "C_rN", "m_x", "m_y", "I_z", "K_T", "1-w", "1-t", "F_N", "a_H",
           "gamma_R", "l_R", "k_X", "k_Y", "k_N", "K_BT")
# Stated uncertainty, as the ship's user would: log-sd.
PRIOR = dict(zip(FACTORS, (0.10, 0.3, 0.15, 0.25, 0.15, 0.15, 0.20, 0.2, 0.2, 0.3, 0.15, 0.15, 0.05, 0.05, 0.05, 0.10, 0.2, 0.2, 0.15, 0.2,
                           0.15, 0.3, 0.10)))

# Constants of the level 2 forms and their standard deviations: a truth of level 2 draws them, so that "another structure" is a law and not one ship.
FORMS = dict(  # center, sd
    wake_rate=(1.35, 0.25), wake_saturation=(2.0, 0.4), K_T_cubic=(1.0, 0.3), race=(1.0, 0.3), resistance_power=(-0.12, 0.04), side_drop=(0.7, 0.2),
    bluntness=(0.6, 0.2), rudder_curve=(1.0, 0.3), gamma_share=(1.0, 0.15), flow_share=(1.0, 0.25), wind_cross=(0.2, 0.05), wind_arm=(0.16, 0.04),
    thruster_curve=(1.0, 0.3))
FORM_CENTER = {k: center for k, (center, sd) in FORMS.items()}

# Effects that act on the ship, with the value at which they are off.
NEUTRAL = dict(
    current_x=0.0, current_y=0.0, tide_x=0.0, tide_y=0.0, tide_w=0.01, tide_phase=0.0, shear_x=0.0, shear_y=0.0,
    F=0.0, s_my=1.0, s_Iz=1.0, s_Nv=1.0, s_Yv=1.0, s_Nr=1.0, s_R=1.0,
    bank_CY=0.0, bank_CN=0.0, bank_D=10.0, bank_dir=0.0, bank_n=2.0,
    kX=1.0, kY=1.0, kN=1.0, wind_x=0.0, wind_y=0.0, hs=0.0, wave_from=0.0, fouling=0.0, draft=0.0, dx_G=0.0, trim=0.0, C_D_gain=1.0,
    k_mx=1.0, k_my=1.0, k_Jz=1.0, k_T=1.0, dw=0.0, c_Y=0.0, c_N=0.0, rudder_offset=0.0, k_R=1.0, k_P=1.0, k_S=1.0, stall=9.0,
    stall_c=0.0, k_pair=0.0, k_BT=1.0, inv_u_c=0.0, delay=0.0, rate=1e9, lag=0.0,
    tug=0.0, tug_dir=0.0, tug_x=0.0, tug_start=0.0, tug_end=0.0, moor_k=0.0, moor_x=0.0, moor_y=0.0, moor_l=1e9, fender_k=0.0,
    fender_D=1e9, fender_dir=0.0, body_X=0.0, body_Y=0.0, body_N=0.0, earth_X=0.0, earth_Y=0.0,
    # not in the catalogue
    coanda=0.0, ice=0.0, tank=0.0, memory=0.0, ventilation=0.0, magnet=0.0, magnet_x=0.0, magnet_y=0.0, flutter=0.0, stiction=0.0)


def read_ship(name):
    return json.loads((ROOT / "configs" / "ships" / f"{name}.json").read_text(encoding="utf-8"))


def quadratic(k, x):
    return k[0] + k[1] * x + k[2] * x * x


def outline(L, B, level=2):
    """Points of the hull that touch a quay, from midship: bow, shoulders, stern; a box at level 1."""
    if level == 1:
        return ((0.5 * L, 0.5 * B), (0.5 * L, -0.5 * B), (-0.5 * L, 0.5 * B), (-0.5 * L, -0.5 * B))
    return ((0.5 * L, 0.0), (0.35 * L, 0.5 * B), (0.35 * L, -0.5 * B), (-0.5 * L, 0.4 * B), (-0.5 * L, -0.4 * B))


_FITTED = {}  # constants that join the level 2 forms to a ship, by its name


class Model:
    """A ship at a level; `factors`, `effects` and `forms` (constants of level 2) map names to arrays, one element per case."""

    def __init__(self, ship, level, factors, effects, forms=None):
        self.ship, self.level = ship, level
        self.c = {**FORM_CENTER, **(forms or {})}
        p = ship["particulars"]
        self.L, self.B, self.d, self.rho = p["L_pp_m"], p["B_m"], p["d_m"], p["rho_kgpm3"]
        self.f = {k: factors.get(k, 1.0) for k in FACTORS}
        self.e = {k: effects.get(k, v) for k, v in NEUTRAL.items()}
        self.active = {k for k, v in NEUTRAL.items() if np.any(np.asarray(self.e[k]) != v)}
        self.h, self.pr, self.rd, self.wind = ship["hull"], ship["propeller"], ship["rudder"], ship.get("wind")
        self.is_vectwin = self.rd["type"].startswith("vectwin")
        self.scale = math.sqrt(self.L / 3.0)  # of times and speeds
        self.q_Y = 0.5 * self.rho * self.L * self.d
        self.C_b = ship["inertia"]["m"] * self.L / (2.0 * self.B)
        self.u_design = ship["u0_mps"]
        if level == 2:
            kept = _FITTED.setdefault(ship["name"], {})
            if not kept:
                before = set(self.__dict__)
                self._fit_other_forms()
                kept.update({k: v for k, v in self.__dict__.items() if k not in before})
            self.__dict__.update(kept)

    def _fit_other_forms(self):
        """Constants of the level 2 forms, from the ship's numbers."""
        J = np.linspace(0.0, 0.9, 40)
        k = self.pr["K_T_ahead"] if self.is_vectwin else self.pr["K_T"]
        self.K_T_cubic = np.linalg.lstsq(np.stack([np.ones_like(J), J, J**3], 1), quadratic(k, J), rcond=None)[0]
        aspect = self.rd["aspect_ratio"]
        self.lindenburg = 0.41 * (1.0 - math.exp(-17.0 / aspect))
        # The other form of the rudders' normal force, through the angles that are ordered: those of VecTwin rudders reach
        # beyond 90 deg, where a form fitted up to 35 deg would have half as much force again.
        if self.is_vectwin:
            alpha = np.radians(np.arange(1.0, 126.0))
            self.C_N_terms = np.linalg.lstsq(self._other_normal_forces(alpha), vectwin_normal_force(alpha), rcond=None)[0]
        else:
            alpha = np.radians(np.linspace(1.0, 35.0, 35))
            curve, plain = self._other_normal_forces(alpha)[:, 0], self.rd["f_alpha"] * np.sin(alpha)
            self.C_N_terms = np.array([0.5 * (plain @ curve) / (curve @ curve), 0.5 * self.rd["f_alpha"], 0.0])
        self.thruster_fit = []
        for t in self.ship.get("thrusters", []):
            Fr = np.linspace(0.0, t["u_max_mps"] / math.sqrt(G * self.L), 60)
            pair = []
            for a in (t["a_Y"], t["a_N"]):
                best = None
                for c in np.linspace(0.1, 1.0, 19) * Fr[-1]:
                    A = np.stack([np.ones_like(Fr), np.exp(-(Fr / c) ** 2)], 1)
                    y = 1.0 + quadratic(a, Fr)
                    x = np.linalg.lstsq(A, y, rcond=None)[0]
                    error = float(np.sum((A @ x - y) ** 2))
                    if best is None or error < best[0]:
                        best = (error, x[0], x[1], c)
                pair.append(best[1:])
            self.thruster_fit.append(pair)
        if self.wind:
            gamma = np.radians([0.001, 90.0])
            CX, CY, CN = self._fujiwara(gamma)
            A_T, A_L = self.wind["A_T_m2"], self.wind["A_L_m2"]
            self.wind_lateral, self.wind_along = -CY[1], -CX[0] * A_T / A_L
            self.wind_arm = CN[1] / CY[1]

    # --- forces -----------------------------------------------------------------------------------------------
    def _fujiwara(self, gamma):
        w, L = self.wind, self.L
        B, A_T, A_L, A_OD, C, C_BR, H_BR, H_C = (w[k] for k in ("B_m", "A_T_m2", "A_L_m2", "A_OD_m2", "C_m", "C_BR_m", "H_BR_m", "H_C_m"))
        X0 = -0.330 + 0.293 * B * H_BR / A_T + 0.0193 * C / H_C + 0.682 * A_OD / L**2
        X1 = (-1.353 + 1.700 * A_L / (L * B) + 2.870 * L * H_C / A_L - 0.463 * L * H_BR / A_L - 0.570 * A_OD / A_L - 6.640 * A_T / (L * B)
              - 0.0123 * L**2 / A_T + 0.0202 * L / H_C)
        X3 = (0.830 - 0.413 * A_L / (L * H_BR) - 0.0827 * A_L / A_T - 0.563 * L * H_C / A_L + 0.804 * A_OD / A_L - 5.670 * A_OD / L**2
              + 0.0401 * C / H_C - 0.132 * C_BR / L)
        X5 = 0.0372 - 0.0075 * A_L / A_OD - 0.103 * C_BR / L + 0.0921 * A_L / (L * B)
        Y1 = 0.684 + 0.717 * C_BR / L - 3.220 * C / L + 0.0281 * A_L / A_OD + 0.0661 * C / H_C + 0.298 * A_T / (B * H_BR)
        Y3 = -0.400 + 0.282 * A_L / (L * B) + 0.307 * L * H_C / A_L + 0.0519 * C_BR / L + 0.0526 * B / H_BR - 0.0814 * A_OD / A_L + 0.0582 * A_T / (B * H_BR)
        Y5 = 0.122 - 0.166 * A_L / (L * B) - 0.0054 * L / H_BR - 0.0481 * C_BR / L - 0.0136 * B**2 / A_T + 0.0864 * C / L - 0.0297 * C * H_C / A_L
        N1 = (0.299 + 1.710 * C / L + 0.183 * L * H_C / A_L - 1.09 * A_T / A_L - 0.0442 * C / H_C - 0.289 * A_L / (L * B) + 4.24 * A_T / L**2
              - 0.0646 * B**2 / A_T + 0.0306 * C_BR / L)
        N2 = (0.117 + 0.123 * C_BR / L - 0.323 * C / L + 0.0041 * A_L / A_OD - 0.166 * A_T / B**2 - 0.0109 * L / H_BR + 0.174 * A_T / (B * H_BR)
              + 0.214 * A_L / (L * B) - 1.06 * A_L / L**2)
        N3 = 0.0230 + 0.0385 * C_BR / L - 0.0339 * A_T / (B * H_BR) + 0.0023 * A_L / A_T
        A = -gamma
        return (X0 + X1 * np.cos(A) + X3 * np.cos(3 * A) + X5 * np.cos(5 * A), Y1 * np.sin(A) + Y3 * np.sin(3 * A) + Y5 * np.sin(5 * A),
                N1 * np.sin(A) + N2 * np.sin(2 * A) + N3 * np.sin(3 * A))

    def _wind_force(self, ax, ay):
        """Apparent wind (ax, ay): vector to where it comes from, in ship axes."""
        w, e = self.wind, self.e
        q = 0.5 * w["rho_air_kgpm3"] * (ax * ax + ay * ay)
        gamma = np.arctan2(ay, ax)
        A_T, A_L = w["A_T_m2"], w["A_L_m2"]
        if "draft" in self.active:
            A_T, A_L = A_T - self.B * self.d * e["draft"], A_L - self.L * self.d * e["draft"]
        if self.level == 1:
            CX, CY, CN = self._fujiwara(gamma)
            X, Y, N = q * A_T * CX, q * A_L * CY, q * A_L * self.L * CN
        else:  # form of Blendermann (1994), with cross-force parameter 0.4 at the center of the forms
            below = 1.0 - self.c["wind_cross"] * (1.0 - self.wind_along / self.wind_lateral) * np.sin(2.0 * gamma) ** 2
            CY = -self.wind_lateral * np.sin(gamma) / below
            X = -q * A_L * self.wind_along * np.cos(gamma) / below
            Y = q * A_L * CY
            N = q * A_L * self.L * CY * (self.wind_arm - self.c["wind_arm"] * (np.abs(gamma) - 0.5 * np.pi))
        return X * e["kX"] * self.f["k_X"], Y * e["kY"] * self.f["k_Y"], N * e["kN"] * self.f["k_N"]

    def _cross_flow(self, v, k):
        """Integrals of |v + k x|(v + k x) and of the same times x over the length: (force/L, moment/L^2)."""
        L = self.L
        if self.level == 2:  # strips, blunter at the ends
            Y = N = 0.0
            for x in (np.arange(10) + 0.5) / 10.0 - 0.5:
                w = v + k * (x * L)
                f = (1.0 + self.c["bluntness"] * (4.0 * x * x - 1.0 / 3.0)) * np.abs(w) * w * 0.1
                Y, N = Y + f, N + f * x
            return Y, N
        half = 0.5 * k * L
        cross = np.abs(v) < np.abs(half)
        safe = np.where(cross, k, 1.0)
        a, b = v + half, v - half
        Y = np.where(cross, (np.abs(a) ** 3 - np.abs(b) ** 3) / (3.0 * safe * L), np.sign(v) * (v * v + half * half / 3.0))
        N = np.where(cross, ((np.abs(a) ** 3 * a - np.abs(b) ** 3 * b) / 4.0 - v * (np.abs(a) ** 3 - np.abs(b) ** 3) / 3.0) / (safe * safe * L * L),
                     np.sign(v) * v * half / 3.0)
        return Y, N

    def _hull(self, u, v, r, U):
        h, f, e, L = self.h, self.f, self.e, self.L
        beta = np.arctan2(v, u)
        X_0 = (h["X_0F"] + (h["X_0A"] - h["X_0F"]) * np.abs(beta) / np.pi) * f["X_0"] * (1.0 + e["fouling"]) * e["s_R"]
        Y_v, N_v, N_r = h["Y_v"] * f["Y_v"] * e["s_Yv"], h["N_v"] * f["N_v"] * e["s_Nv"], h["N_r"] * f["N_r"] * e["s_Nr"]
        Y_r = h["Y_r"] * f["Y_r"]
        if "trim" in self.active:
            t = e["trim"]
            if self.level == 1:
                Y_v, Y_r = Y_v * (1 + 0.667 * t), Y_r * (1 + 0.8 * t)
                N_v, N_r = N_v * (1 - 0.27 * t * Y_v / N_v), N_r * (1 + 0.3 * t)
            else:
                Y_v, Y_r, N_v, N_r = Y_v * np.exp(0.6 * t), Y_r * np.exp(0.7 * t), N_v * (1 - 0.8 * t), N_r * (1 + 0.35 * t)
        gain = 1.0
        if "draft" in self.active:
            gain = 1.0 + e["draft"]
            if self.level == 1:
                k0 = 2.0 * self.d / L
                k, c = k0 * gain, 1.4 * self.C_b * self.B / L
                Y_v = Y_v * (0.5 * np.pi * k + c) / (0.5 * np.pi * k0 + c)
                N_v, N_r = N_v * gain, N_r * (-0.54 * k + k * k) / (-0.54 * k0 + k0 * k0)
            else:
                Y_v, N_v, N_r = Y_v * gain**0.5, N_v * gain**0.9, N_r * gain**0.7
        if self.level == 1:
            X = X_0 * u * U
            Y, N = Y_v * v * np.abs(u), N_v * v * u
        else:  # resistance falls with Reynolds' number; side force levels off at large drift
            X = X_0 * u * U * (np.maximum(U, 0.05 * self.u_design) / self.u_design) ** self.c["resistance_power"]
            drop = 1.0 / (1.0 + self.c["side_drop"] * v * v / (U * U + 1e-12))
            Y, N = Y_v * v * np.abs(u) * drop, N_v * v * u * drop
        C_D = h["C_D"] * f["C_D"] * e["C_D_gain"]
        X = X + h["X_vr"] * f["X_vr"] * L * v * r
        Y = Y + Y_r * L * r * u - C_D * self._cross_flow(v, h["C_rY"] * f["C_rY"] * r)[0]
        N = N + N_r * L * r * np.abs(u) - C_D * self._cross_flow(v, h["C_rN"] * f["C_rN"] * r)[1]
        return gain * self.q_Y * X, gain * self.q_Y * Y, gain * self.q_Y * L * N

    def _propeller(self, u, v, r, U, n, memory):
        """X, Y, N, 1-w, u_P, J, n^2 K_T."""
        p, f, e, L = self.pr, self.f, self.e, self.L
        D = p["D_P_m"]
        ahead = (u > 0.0) & (U > 1e-6)
        sign = -1.0 if self.is_vectwin and p.get("v_P", "").startswith("v - ") else 1.0
        v_P = (v + sign * p["x_P"] * L * r) / np.maximum(U, 1e-6)
        dw = e["dw"] + 0.03 * e["fouling"] + memory
        running = np.where(np.abs(n) > 1e-9, n, 1.0)
        Y = N = 0.0
        if self.is_vectwin:
            n = np.maximum(n, 0.0)
            running = np.where(n > 1e-9, n, 1.0)
            J_s = u / (running * D)
            oblique = lambda k: k[0] * (k[1] * v_P + (v_P + k[2] * v_P * np.abs(v_P)) ** 2)
            if self.level == 1:
                wake = quadratic(p["a"], J_s) + oblique(p["b"])
            else:
                wake = quadratic(p["a"], J_s) + p["b"][0] / self.c["wake_saturation"] * (1.0 - np.exp(-self.c["wake_saturation"] * v_P * v_P))
            wake = np.clip(wake * f["1-w"] - dw, 0.0, 1.0)
            wake = np.where(ahead, np.where(n > 1e-9, wake, 0.0), 1.0)
            u_P = u * wake
            J = np.where(n > 1e-9, u_P / (running * D), np.where(u < 0.0, -100.0, 0.0))
            thrust_share = np.where(ahead, np.clip((quadratic(p["c"], J) + oblique(p["d"]) if self.level == 1 else
                                                    quadratic(p["c"], J) + p["d"][0] * v_P * v_P / (1.0 + v_P * v_P)) * f["1-t"], 0.0, 1.0), 1.0)
            w = u_P / D
            k_ahead, k_astern = p["K_T_ahead"], p["K_T_astern"]
            n2K = np.where(u < 0.0, k_astern[0] * n * n + k_astern[1] * n * w + k_astern[2] * w * w,
                           k_ahead[0] * n * n + k_ahead[1] * n * w + k_ahead[2] * w * w)
            if self.level == 2:
                c, share = self.K_T_cubic, self.c["K_T_cubic"]
                n2K = np.where((u >= 0.0) & (J < 0.95) & (n > 1e-9), share * n * n * (c[0] + c[1] * J + c[2] * J**3) + (1.0 - share) * n2K, n2K)
        else:
            a = np.abs(v_P)
            w_P = quadratic(p["w_P"], a) if self.level == 1 else p["w_P"][0] * np.exp(-self.c["wake_rate"] * a)
            wake = np.where(ahead, np.clip((1.0 - w_P) * f["1-w"] - dw, 0.0, 1.0), 1.0)
            u_P = u * wake
            w, u_D = u_P / D, u / D
            J = np.where(np.abs(n) > 1e-9, u_P / (running * D), 0.0)
            k = p["K_T"]
            n2K = k[0] * n * n + k[1] * n * w + k[2] * w * w
            if self.level == 2:
                c, share = self.K_T_cubic, self.c["K_T_cubic"]
                n2K = np.where((n > 1e-9) & (J > 0.0) & (J < 0.95), share * n * n * (c[0] + c[1] * J + c[2] * J**3) + (1.0 - share) * n2K, n2K)
            back = n < 0.0
            reversed_ = np.where(u_D <= p["J_s_reversed"] * n, p["K_T_reversed"][0] * n * n + p["K_T_reversed"][1] * n * u_D,
                                 p["K_T_reversed_low"] * n * n)
            n2K = np.where(back, reversed_, n2K)
            thrust_share = np.where(back, 1.0, (1.0 - p["t_P"]) * f["1-t"])
            q_N = self.q_Y * L
            P2 = (p["pitch_ratio"] * D) ** 2
            poly = lambda c: c[0] * n * n + c[1] * n * u_D + (c[2] * u_D * u_D if len(c) > 2 else 0.0)
            low, high = back & (u_D > p["J_s_walk"][0] * n), back & (u_D < p["J_s_walk"][1] * n)
            for axis in "YN":
                walk = np.where(low, poly(p[f"{axis}_walk_low"]), np.where(high, p[f"{axis}_walk_high"] * n * n, poly(p[f"{axis}_walk_middle"])))
                force = (self.q_Y if axis == "Y" else q_N) * np.where(
                    back, D * D * walk, np.where(u < 0.0, P2 * poly(p[f"{axis}_backing"]), 0.0))
                Y, N = (force, N) if axis == "Y" else (Y, force)
        n2K = n2K * f["K_T"] * e["k_T"]
        if "ventilation" in self.active:  # draws air when lightly advancing and turning fast
            n2K = n2K * (1.0 - e["ventilation"] / (1.0 + np.exp(-(np.abs(r) * L / self.scale - 0.12) / 0.02)))
        q = self.rho * D**4
        X = thrust_share * q * n2K
        if "c_Y" in self.active or "c_N" in self.active:
            loading = n * np.abs(n) * (1.0 if self.level == 1 else np.where(n < 0.0, 1.3, 0.9))
            Y, N = Y + e["c_Y"] * q * loading, N + e["c_N"] * q * L * loading
        return X, Y, N, wake, u_P, J, n2K

    def _other_normal_forces(self, alpha):
        """Terms of C_N: a plate's curve (Lindenburg), and two harmonics."""
        s = np.sin(alpha)
        return np.stack([1.98 * s * (1.0 / (0.56 + 0.44 * np.abs(s)) - self.lindenburg), s, np.sin(2.0 * alpha)], -1)

    def _normal_force(self, u_R, v_R, delta):
        """C_N U_R^2."""
        alpha = delta - np.arctan2(v_R, u_R)
        if self.level == 2 or "stall" in self.active:
            alpha = np.arctan2(np.sin(alpha), np.cos(alpha))
        if self.is_vectwin:
            C = vectwin_normal_force(alpha if self.level == 2 else delta - np.arctan2(v_R, u_R))
        else:
            C = self.rd["f_alpha"] * np.sin(alpha)
        if self.level == 2:
            C = C + self.c["rudder_curve"] * (self._other_normal_forces(alpha) @ self.C_N_terms - C)
        if "stall" in self.active:
            over = np.maximum(np.abs(alpha) - self.e["stall"], 0.0)
            drop = 1.0 - np.exp(-over / 0.2) if self.level == 1 else over / (over + 0.15)
            C = C * (1.0 - self.e["stall_c"] * drop)
        return C * (u_R * u_R + v_R * v_R)

    def _race(self, eta, a, b):
        """Mean square of the inflow, a in the slipstream and b beside it; level 2 averages speeds instead of squares."""
        squares = eta * a * a + (1.0 - eta) * b * b
        if self.level == 1:
            return squares
        return np.maximum(squares - self.c["race"] * eta * (1.0 - eta) * (a - b) ** 2, 0.0)

    def _rudder(self, u, v, r, flow, n, act):
        rd, f, e, L = self.rd, self.f, self.e, self.L
        wake, u_P, J, n2K = flow
        D = self.pr["D_P_m"]
        eta = min(1.0, D / math.sqrt(rd["A_R_m2"] * rd["aspect_ratio"]))
        q = 0.5 * self.rho * rd["A_R_m2"] * f["F_N"]
        race = np.sqrt(np.maximum(u_P * u_P + 8.0 * n2K * D * D / np.pi, 0.0))
        if self.is_vectwin:
            d_p, d_s = act["delta_p"] + e["rudder_offset"], act["delta_s"] + e["rudder_offset"]
            s = np.where(n > 1e-9, np.clip(1.0 - J / self.pr["pitch_ratio"], 0.0, 1.2), 1.2)
            ds1, dp1 = d_s - (0.015 - 0.164 * s), d_p - (-0.008 + 0.114 * s)
            dsp = (0.088 - 0.11 * s + 0.162 * s * s + (0.129 - 0.259 * s + 0.343 * s * s) * d_p) * d_p
            dps = (0.14 + (-0.18 + 0.085 * s - 0.226 * s * s) * d_s) * d_s
            ds2 = ds1 - dsp * np.where(ds1 > 0.0, np.abs(np.cos(ds1)), 1.0)
            dp2 = dp1 - dps * np.where(dp1 < 0.0, np.abs(np.cos(dp1)), 1.0)
            w_s = 0.665 + (0.19 + (0.051 - 0.095 * d_s) * d_s) * d_s
            w_p = 0.665 + (-0.19 + (0.051 + 0.095 * d_p) * d_p) * d_p
            f_s = np.where(ds2 > 0.0, np.minimum(1.0, 1.791 - 1.861 * s + 1.348 * s * s + (-2.489 + 5.243 * s - 4.159 * s * s +
                           (1.399 - 3.239 * s + 2.598 * s * s) * ds2) * ds2), 1.0)
            f_p = np.where(dp2 < 0.0, np.minimum(1.0, 1.0 + (0.343 - 0.151 * s + 0.657 * s * s + (0.011 + 0.176 * s + 0.38 * s * s) * dp2) * dp2), 1.0)
            gain = rd["k_x"] * (race - u_P)

            def slipstream(b):
                a = b + gain
                q2 = self._race(eta, a, b)
                return np.where(n2K > 0.0, np.sqrt(q2), 0.0)

            u_s, u_p = f_s * slipstream(w_s * u), f_p * slipstream(w_p * u)
            beta = np.arctan2(-v, u)
            gammas = []
            tables = (((0.615, -1.068, -7.823, 11.07, 0.8), (2.66, -3.611, 2.971, -2.602, 0.8), (-0.864, 2.719, 15.43, -44.18, 0.8),
                       (2.781, -3.55, -3.787, 4.834, 1.0)),
                      ((6.256, -12.3, 8.759, -18.38, 1.0), (10.07, -30.62, 13.36, -43.29, 0.8), (6.559, -13.77, -8.238, 20.25, 0.8),
                       (9.064, -24.76, -4.256, 25.31, 0.8)))
            b = np.abs(beta)
            for table, d2 in zip(tables, (ds2, dp2)):
                g = [np.clip((k[0] + k[1] * b + (k[2] + k[3] * b) * d2) * b, 0.0, k[4]) for k in table]
                if self.level == 1:
                    gamma = np.where(d2 < 0.0, np.where(beta < 0.0, g[1], g[0]), np.where(beta < 0.0, g[3], g[2]))
                else:  # quadrants pass into each other
                    a, c = 0.5 + 0.5 * np.tanh(d2 / 0.08), 0.5 + 0.5 * np.tanh(beta / 0.04)
                    gamma = 0.85 * ((1.0 - a) * ((1.0 - c) * g[1] + c * g[0]) + a * ((1.0 - c) * g[3] + c * g[2])) + 0.1 * np.tanh(4.0 * b)
                    gamma = self.c["gamma_share"] * gamma
                gammas.append(f["gamma_R"] * gamma)
            right = r >= 0.0
            if self.level == 1:
                l_s = np.where(right, np.where(ds2 < 0.0, 0.2, 0.0), np.where(ds2 < 0.0, 0.4, 0.6))
                l_p = np.where(right, np.where(dp2 < 0.0, 0.6, 0.4), np.where(dp2 < 0.0, 0.0, 0.2))
            else:
                a, c, e2 = (0.5 + 0.5 * np.tanh(x) for x in (r * self.scale / 0.01, ds2 / 0.08, dp2 / 0.08))
                k = 0.25 * self.c["flow_share"]
                l_s = k * 0.3 + (1.0 - k) * (a * 0.2 * (1.0 - c) + (1.0 - a) * (0.4 + 0.2 * c))
                l_p = k * 0.3 + (1.0 - k) * (a * (0.6 - 0.2 * e2) + (1.0 - a) * 0.2 * e2)
            F_s = q * e["k_R"] * e["k_S"] * self._normal_force(u_s, -gammas[0] * v - l_s * rd["x_R_m"] * f["l_R"] * r, ds2)
            F_p = q * e["k_R"] * e["k_P"] * self._normal_force(u_p, -gammas[1] * v - l_p * rd["x_R_m"] * f["l_R"] * r, dp2)
            if "k_pair" in self.active:
                twist = d_s - d_p
                shade = np.abs(np.sin(twist)) if self.level == 1 else np.sin(np.clip(0.5 * twist, -1.57, 1.57)) ** 2
                F_s, F_p = F_s * (1.0 - e["k_pair"] * shade), F_p * (1.0 - e["k_pair"] * shade)
            across, along = F_s * np.cos(d_s) + F_p * np.cos(d_p), F_s * np.sin(d_s) + F_p * np.sin(d_p)
            a_H = np.clip(0.016 + 1.69 * J - 1.179 * J * J, 0.016, 0.60556) * f["a_H"]
            x_H = L * np.clip(-0.159 - 1.065 * J + 1.01 * J * J, -0.4344, -0.159)
        else:
            delta = act["delta"] + e["rudder_offset"]
            b = rd["epsilon"] * u_P
            a = b + rd["k_x"] * (race - u_P)
            q2 = self._race(eta, a, b)
            pushing = (n >= 0.0) & (n2K > 0.0)
            suction = rd["k_reversed"] * D * np.sqrt(8.0 * np.abs(n2K) / np.pi)
            c = b + np.where(n < 0.0, -suction, suction)
            back2 = eta * np.sign(c) * c * c + (1.0 - eta) * b * b - rd["k_hull_wake"] * u * u
            u_R = np.where(pushing, np.sqrt(q2), np.where(u < 0.0, u, np.where(suction > 0.0, np.sign(back2) * np.sqrt(np.abs(back2)), b)))
            inflow = v + rd["x_R_m"] * r
            if self.level == 1:
                gamma = np.where(inflow < 0.0, rd["gamma_R_negative"], rd["gamma_R_positive"])
            else:
                mean, half = 0.5 * (rd["gamma_R_negative"] + rd["gamma_R_positive"]), 0.5 * (rd["gamma_R_negative"] - rd["gamma_R_positive"])
                gamma = (mean - half * np.tanh(inflow / (0.02 * self.scale))) * (0.92 + 0.15 * self.c["flow_share"] * np.tanh(np.abs(inflow) / (0.1 * self.scale)))
                gamma = self.c["gamma_share"] * gamma
            v_R = -gamma * f["gamma_R"] * (v + rd["l_R"] * f["l_R"] * L * r)
            F = q * e["k_R"] * e["k_P"] * self._normal_force(u_R, v_R, delta)
            across, along = F * np.cos(delta), F * np.sin(delta)
            a_H, x_H = rd["a_H"] * f["a_H"], rd["x_H"] * L
        return -(1.0 - rd["t_R"]) * along, -(1.0 + a_H) * across, -(rd["x_R_m"] + a_H * x_H) * across

    def _thrusters(self, u, v, act):
        X = Y = N = 0.0
        Fr = np.abs(u) / math.sqrt(G * self.L)
        for i, t in enumerate(self.ship.get("thrusters", [])):
            if t["channel"] not in act:
                continue
            n = act[t["channel"]]
            T = self.rho * t["D_m"] ** 4 * np.where(n < 0.0, t["K_T_negative"], t["K_T_positive"]) * n * n * self.f["K_BT"]
            if t["channel"] == "n_bt":
                T = T * self.e["k_BT"]
            if "inv_u_c" in self.active:
                x = np.abs(u) * self.e["inv_u_c"]
                T = T * (np.exp(-x * x) if self.level == 1 else 1.0 / (1.0 + 1.2 * x * x))
            if "coanda" in self.active:  # the jet clings to the hull: a pull ahead or astern with the ship's way, less to the side
                X = X + self.e["coanda"] * np.abs(T) * np.tanh(u / (0.2 * self.scale))
                T = T * (1.0 - self.e["coanda"] * (n > 0.0) * 0.5)
            if self.level == 1:
                near = np.abs(u) < t["u_max_mps"]
                Y = Y + np.where(near, (1.0 + quadratic(t["a_Y"], Fr)) * T, 0.0)
                N = N + np.where(near, (1.0 + quadratic(t["a_N"], Fr)) * T * t["x_m"], 0.0)
            else:
                fade = 1.0 / (1.0 + np.exp(np.clip((np.abs(u) / t["u_max_mps"] - 1.0) / 0.03, -50, 50)))
                plain = [1.0 + quadratic(a, Fr) for a in (t["a_Y"], t["a_N"])]
                k = [p + self.c["thruster_curve"] * (c[0] + c[1] * np.exp(-(Fr / c[2]) ** 2) - p) for p, c in zip(plain, self.thruster_fit[i])]
                Y, N = Y + fade * k[0] * T, N + fade * k[1] * T * t["x_m"]
        return X, Y, N

    # --- motion ------------------------------------------------------------------------------------------------
    def water(self, x, y, t):
        """Velocity of the water and its rate of change with time, in earth axes."""
        e = self.e
        Vx, Vy, ax, ay = e["current_x"] + 0.0, e["current_y"] + 0.0, 0.0, 0.0
        if "tide_x" in self.active or "tide_y" in self.active:
            phase = e["tide_w"] * t + e["tide_phase"]
            c, s = np.sin(phase) + 0.5 * np.sin(0.37 * phase), np.cos(0.71 * phase) + 0.4 * np.sin(1.9 * phase)
            dc = e["tide_w"] * (np.cos(phase) + 0.185 * np.cos(0.37 * phase))
            ds = e["tide_w"] * (-0.71 * np.sin(0.71 * phase) + 0.76 * np.cos(1.9 * phase))
            Vx, Vy, ax, ay = Vx + e["tide_x"] * c, Vy + e["tide_y"] * s, e["tide_x"] * dc, e["tide_y"] * ds
        if "shear_x" in self.active or "shear_y" in self.active:  # Vx changes with y, Vy with x
            Vx, Vy = Vx + e["shear_x"] * y, Vy + e["shear_y"] * x
        return Vx, Vy, ax, ay

    def accelerations(self, s, act, wind):
        """Accelerations (u', v_m', r') over ground. s: dict of u, v, r, psi, x, y, t, q (memories); act: acting actuators;
        wind: earth vector to where the true wind comes from."""
        e, f, L = self.e, self.f, self.L
        cos, sin = np.cos(s["psi"]), np.sin(s["psi"])
        Vx, Vy, Ax, Ay = self.water(s["x"], s["y"], s["t"])
        u_c, v_c = Vx * cos + Vy * sin, -Vx * sin + Vy * cos
        r = s["r"]
        u, v = s["u"] - u_c, s["v"] - v_c
        r_hull = r
        if "shear_x" in self.active or "shear_y" in self.active:
            Ax, Ay = Ax + e["shear_x"] * (s["u"] * sin + s["v"] * cos), Ay + e["shear_y"] * (s["u"] * cos - s["v"] * sin)
            r_hull = r - (e["shear_y"] * cos * cos - e["shear_x"] * sin * sin)
        U = np.sqrt(u * u + v * v)
        n = act["n_p"]
        memory = e["memory"] * s["q"][0] if "memory" in self.active else 0.0
        X, Y, N = self._hull(u, v, r_hull, U)
        P = self._propeller(u, v, r, U, n, memory)
        R = self._rudder(u, v, r, P[3:], n, act)
        T = self._thrusters(u, v, act)
        X, Y, N = X + P[0] + R[0] + T[0], Y + P[1] + R[1] + T[1], N + P[2] + R[2] + T[2]
        if self.wind and wind is not None:
            wx, wy = wind[0] + e["wind_x"], wind[1] + e["wind_y"]
            A = self._wind_force(wx * cos + wy * sin + s["u"], -wx * sin + wy * cos + s["v"])
            X, Y, N = X + A[0], Y + A[1], N + A[2]
        X, Y, N = self._outside(s, act, u, v, r, U, cos, sin, X, Y, N)

        m, m_x, m_y, x_G, I = self._inertia()
        ax, ay = Ax * cos + Ay * sin, -Ax * sin + Ay * cos  # of the water, in ship axes
        # in velocities through the water; those over ground follow
        du, dv, dr = self._solved(X + (m + m_y) * v * r + x_G * m * r * r - m * ax, Y - (m + m_x) * u * r - m * ay, N - x_G * m * u * r - x_G * m * ay)
        return du + r * v_c + ax, dv - r * u_c + ay, dr

    def _inertia(self):
        i, f, e = self.ship["inertia"], self.f, self.e
        mass = 0.5 * self.rho * self.L * self.L * self.d
        gain = 1.0 + e["draft"]
        m, m_x, m_y = i["m"] * mass * gain, i["m_x"] * mass * gain * f["m_x"] * e["k_mx"], i["m_y"] * mass * gain * f["m_y"] * e["k_my"] * e["s_my"]
        x_G = i["x_G"] * self.L + e["dx_G"]
        I = i["I_zG_plus_J_z"] * mass * self.L * self.L * gain * f["I_z"]
        # the added part is taken as half of the sum
        return m, m_x, m_y, x_G, I * (1.0 + 0.4 * (e["k_Jz"] * e["s_Iz"] - 1.0)) + x_G * x_G * m

    def _solved(self, bx, by, bn):
        """(u', v_m', r') of the right-hand sides of the equations of motion."""
        m, m_x, m_y, x_G, I = self._inertia()
        det = (m + m_y) * I - (x_G * m) ** 2
        return bx / (m + m_x), (I * by - x_G * m * bn) / det, ((m + m_y) * bn - x_G * m * by) / det

    def change_by_outside(self, s, act):
        """Change of the accelerations by the forces of _outside, which add to all others: far cheaper than two whole evaluations."""
        cos, sin = np.cos(s["psi"]), np.sin(s["psi"])
        U = np.sqrt(s["u"] ** 2 + s["v"] ** 2)
        return self._solved(*self._outside(s, act, s["u"], s["v"], s["r"], U, cos, sin, 0.0, 0.0, 0.0))

    def _outside(self, s, act, u, v, r, U, cos, sin, X, Y, N):
        """Forces from outside the ship's own modules."""
        e, L, on = self.e, self.L, self.active
        mass = self.ship["inertia"]["m"] * 0.5 * self.rho * L * L * self.d
        if "hs" in on:
            mu = e["wave_from"] - s["psi"]
            cm, sm = np.cos(mu), np.sin(mu)
            q = self.rho * G * e["hs"] ** 2
            if self.level == 1:
                X, Y, N = X - q * self.B**2 / L / 8.0 * cm, Y - q * L / 16.0 * 0.6 * sm * np.abs(sm), N - q * L * L / 16.0 * 0.025 * 2.0 * sm * cm
            else:
                X = X - q * self.B**2 / L / 8.0 * cm * (1.0 + 1.5 * np.abs(u) / math.sqrt(G * L))
                Y = Y - q * L / 16.0 * 0.6 * sm * np.sqrt(np.abs(sm) + 1e-12)
                N = N - q * L * L / 16.0 * (0.05 * sm * cm + 0.01 * sm)
        if "bank_CY" in on or "bank_CN" in on:
            wx, wy = np.cos(e["bank_dir"]), np.sin(e["bank_dir"])
            D = np.maximum(e["bank_D"] - (s["x"] * wx + s["y"] * wy), 0.55 * self.B)
            side = -sin * wx + cos * wy
            near = (self.B / (2.0 * D)) ** e["bank_n"] if self.level == 1 else 0.5 * (self.B / (2.0 * D)) ** (0.8 * e["bank_n"])
            q = self.q_Y * near * side
            Y, N = Y + q * u * u * e["bank_CY"], N - q * L * u * np.abs(u) * e["bank_CN"]
        if "tug" in on:
            inside = (s["t"] >= e["tug_start"]) & (s["t"] < e["tug_end"])
            F = e["tug"] * inside
            Fy = F * np.sin(e["tug_dir"])
            X, Y, N = X + F * np.cos(e["tug_dir"]), Y + Fy, N + e["tug_x"] * Fy
        pull_x = pull_y = 0.0
        if "moor_k" in on:
            dx, dy = e["moor_x"] - s["x"], e["moor_y"] - s["y"]
            far = np.sqrt(dx * dx + dy * dy) + 1e-9
            T = e["moor_k"] * np.maximum(far - e["moor_l"], 0.0)
            pull_x, pull_y = pull_x + T * dx / far, pull_y + T * dy / far
        if "fender_k" in on:
            wx, wy = np.cos(e["fender_dir"]), np.sin(e["fender_dir"])
            for px, py in outline(L, self.B, self.level):
                ax, ay = cos * px - sin * py, sin * px + cos * py  # from midship
                depth = np.maximum((s["x"] + ax) * wx + (s["y"] + ay) * wy - e["fender_D"], 0.0)
                push = e["fender_k"] * depth
                slide = (v * cos + u * sin + r * ax) * wx - (u * cos - v * sin - r * ay) * wy  # along the wall
                rub = 0.1 * push * np.tanh(slide / (0.02 * self.scale)) if self.level == 2 else 0.0
                fx, fy = -push * wx + rub * wy, -push * wy - rub * wx
                pull_x, pull_y, N = pull_x + fx, pull_y + fy, N + ax * fy - ay * fx
        if "magnet" in on:
            dx, dy = e["magnet_x"] - s["x"], e["magnet_y"] - s["y"]
            far2 = (dx * dx + dy * dy) / (2.0 * L) ** 2
            pull_x, pull_y = pull_x + e["magnet"] * mass * dx / L * np.exp(-far2), pull_y + e["magnet"] * mass * dy / L * np.exp(-far2)
        pull_x, pull_y = pull_x + e["earth_X"], pull_y + e["earth_Y"]
        X, Y, N = X + e["body_X"] + pull_x * cos + pull_y * sin, Y + e["body_Y"] - pull_x * sin + pull_y * cos, N + e["body_N"]
        if "ice" in on:
            drag = e["ice"] * mass * np.sqrt(U / self.scale) / (U + 1e-3)
            X, Y = X - drag * u, Y - drag * v
        if "tank" in on:  # water in a tank that swings athwart
            Y = Y - e["tank"] * mass * s["q"][1]
            N = N - e["tank"] * mass * 0.25 * L * s["q"][1]
        if "flutter" in on:
            N = N + e["flutter"] * mass * L * np.sin(2.0 * np.pi * s["t"] / (37.0 * self.scale)) * np.tanh(3.0 * U / self.scale)
        if "stiction" in on:
            N = N - e["stiction"] * mass * L * np.tanh(r * self.scale / 0.01)
        return X, Y, N

    def memories(self, s, act):
        """Rates of the memory states: wake that lags the yaw rate, free-surface tank (acceleration, its rate)."""
        q = s["q"]
        T = self.scale
        w = 1.1 / T
        sway = s["u"] * s["r"]
        return np.stack([(np.abs(s["r"]) * self.scale * 4.0 - q[0]) / (40.0 * T) + 0.0 * q[0], q[2], w * w * (sway * 20.0 - q[1]) - 2.0 * 0.05 * w * q[2]])


def vectwin_normal_force(alpha):
    """C_N of the published curve, also beyond 35 deg."""
    a = np.abs(alpha)
    return np.where(a <= 0.654498469, 2.6252 * np.sin(alpha), np.sign(alpha) * (-0.8449 * a * a + 2.0621 * a + 0.6387))


def shallow_factors(h_over_T, B, d, L, C_b, level, slack):
    """Gains of the shallow-water effect. Level 2: power laws through the level 1 values at h/T = 1.5, each off by its slack."""

    def published(hT):
        y, F = hT - 1.0, 1.0 / hT
        b = C_b * B * (1.0 + B / L) ** 2 / d
        K0 = 1.0 + 0.0775 / y**2 - 0.011 / y**3 + 0.000068 / y**5
        K1 = -0.0643 / y + 0.0724 / y**2 - 0.0113 / y**3 + 0.0000767 / y**5
        K2 = 0.0342 / y if B / d <= 4.0 else 0.137 * d / B / y
        return dict(s_my=K0 + 2 / 3 * K1 * b + 8 / 15 * K2 * b * b, s_Iz=K0 + 8 / 15 * K1 * b + 40 / 105 * K2 * b * b, s_Nv=K0 + K1 * b + K2 * b * b,
                    s_Yv=-F + (1.0 - F) ** (-0.4 * C_b * B / d), s_Nr=-F + (1.0 - F) ** (14.28 * d / L - 1.5), s_R=1.0 + 0.388 * F * F)

    if level == 1:
        return published(h_over_T)
    at = published(1.5)
    return {k: 1.0 + (at[k] - 1.0) * (1.5 / h_over_T) ** 2.5 * math.exp(slack[i]) for i, k in enumerate(at)}
