"""What can be left out of the tool's ship: for each class how strength becomes numbers of the truth and of the answer key."""

import math

import numpy as np

import model as m


class Effect:
    """draw(rng, ship, track) gives the shape; at(strength, shape, ship) the numbers of the truth, and the parameters by
    the catalogue's names; `most` is the largest strength that is still plausible; kind is force, actuator, wind or sensor."""

    def __init__(self, at, most, draw=None, kind="force", ships=None, needs=None, prefer=None):
        self.at, self.most, self.kind, self.ships, self.needs = at, most, kind, ships, needs
        self.draw = draw or (lambda rng, ship, track: {"sign": float(rng.choice((-1.0, 1.0)))})
        self.prefer = prefer  # kinds of maneuvers that show it

    def fits(self, ship_name):
        return self.ships is None or any(ship_name.startswith(s) for s in self.ships)


def scale(ship):
    return math.sqrt(ship["particulars"]["L_pp_m"] / 3.0)


def mass(ship):
    p = ship["particulars"]
    return ship["inertia"]["m"] * 0.5 * p["rho_kgpm3"] * p["L_pp_m"] ** 2 * p["d_m"]


def direction(rng, ship, track):
    return {"angle": float(rng.uniform(0.0, 2.0 * math.pi))}


def deg(angle):
    return math.degrees(angle) % 360.0


def shallow(F, shape, ship):
    p = ship["particulars"]
    if F < 1e-6:
        return {}, {"h_over_T": None}
    C_b = ship["inertia"]["m"] * p["L_pp_m"] / (2.0 * p["B_m"])
    gains = m.shallow_factors(1.0 / F, p["B_m"], p["d_m"], p["L_pp_m"], C_b, shape["level"], shape["slack"])
    return gains, {"h_over_T": 1.0 / F}


def bank_shape(rng, ship, track):
    """A wall beside the track, just outside of it."""
    angle = float(rng.uniform(0.0, 2.0 * math.pi))
    reach = float(np.max(track["x"] * math.cos(angle) + track["y"] * math.sin(angle)))
    return {"angle": angle, "D": reach + 0.25 * ship["particulars"]["L_pp_m"]}


def tug_shape(rng, ship, track):
    start = float(rng.uniform(0.15, 0.5)) * track["duration"]
    return {"angle": float(rng.uniform(0.0, 2.0 * math.pi)), "x": float(rng.choice((-0.4, 0.4))) * ship["particulars"]["L_pp_m"],
            "start": round(start), "end": round(start + float(rng.uniform(0.15, 0.3)) * track["duration"])}


def anchor_shape(rng, ship, track):
    """A line that goes taut where the ship is farthest from its anchor; how far before that is its strength."""
    L, angle = ship["particulars"]["L_pp_m"], float(rng.uniform(0.0, 2.0 * math.pi))
    x, y = float(np.mean(track["x"])) + L * math.cos(angle), float(np.mean(track["y"])) + L * math.sin(angle)
    return {"x": x, "y": y, "farthest": float(np.max(np.hypot(track["x"] - x, track["y"] - y))), "stiffness": float(rng.uniform(0.5, 2.0))}


def fender_shape(rng, ship, track):
    """A quay that the hull would reach into well before the end; how far is its strength."""
    p, best = ship["particulars"], (math.inf, 0.0, 0.0)
    for _ in range(200):
        angle = float(rng.uniform(0.0, 2.0 * math.pi))
        wx, wy = math.cos(angle), math.sin(angle)
        points = [track["x"] * wx + track["y"] * wy + a * np.cos(track["psi"] - angle) - b * np.sin(track["psi"] - angle) for a, b in m.outline(p["L_pp_m"], p["B_m"])]
        reach = np.max(points, 0)
        n = reach.shape[1]
        farthest, amid = float(np.max(reach)), float(np.max(reach[:track.get("fitted", len(reach)), n // 5:4 * n // 5]))
        best = min(best, (farthest - amid, angle, farthest))
        if best[0] <= 0.0:  # farthest amid a recording that is fitted to
            break
    _, angle, farthest = best
    return {"angle": angle, "reach": farthest, "stiffness": float(rng.uniform(0.5, 2.0))}


def walk(s, h, ship):
    return {"c_Y": 0.6 * s * h["sign"], "c_N": -0.3 * s * h["sign"]}, {"c_Y": 0.6 * s * h["sign"], "c_N": -0.3 * s * h["sign"]}


def one(key, name, value):
    """A single number under the truth's and the catalogue's name."""

    def at(s, h, ship):
        x = value(s, h)
        return {key: x}, {name: x}

    return at


def rudder_loss(s, h, ship):
    which = h["which"]
    return {which: 1.0 - s}, {which: 1.0 - s}


def polar(kx, ky, speed, angle, size=lambda ship: 1.0):
    def at(s, h, ship):
        v = s * size(ship)
        return {kx: v * math.cos(h["angle"]), ky: v * math.sin(h["angle"])}, {speed: v, angle: deg(h["angle"])}

    return at


EFFECTS = {
    "steady-current": Effect(polar("current_x", "current_y", "current_speed_mps", "current_set_deg", scale), 0.15, direction),
    "varying-current": Effect(lambda s, h, ship: (
        {"tide_x": s * scale(ship), "tide_y": s * scale(ship), "tide_w": h["w"] / scale(ship), "tide_phase": h["phase"]},
        {"current_sd_mps": s * scale(ship) * 0.75}), 0.15,
        lambda rng, ship, track: {"w": 2.0 * math.pi / float(rng.uniform(100.0, 300.0)), "phase": float(rng.uniform(0.0, 6.28))}),
    "sheared-current": Effect(lambda s, h, ship: (
        {"shear_x": s * h["sign"] / scale(ship), "shear_y": 0.3 * s * h["sign"] / scale(ship)},
        {"dVx_dy_1ps": s * h["sign"] / scale(ship), "dVy_dx_1ps": 0.3 * s * h["sign"] / scale(ship)}), 0.05),
    "shallow-water": Effect(shallow, 0.83, lambda rng, ship, track: {"slack": [float(x) for x in rng.normal(0.0, 0.1, 6)]}, prefer=("zigzag", "turn", "random")),
    "bank": Effect(lambda s, h, ship: ({"bank_CY": s, "bank_CN": 0.2 * s, "bank_D": h["D"], "bank_dir": h["angle"]},
                                       {"C_Y": s, "C_N": 0.2 * s, "wall_direction_deg": deg(h["angle"])}), 2.0, bank_shape),
    "windage": Effect(lambda s, h, ship: ({k: math.exp(h["sign"] * s) for k in ("kX", "kY", "kN")}, {k: math.exp(h["sign"] * s) for k in ("kX", "kY")}), 0.9,
                      needs="wind"),
    "anemometer": Effect(lambda s, h, ship: ({}, {"anemometer_scale": 1.0 + s * h["sign"]}), 0.45, kind="wind", needs="wind"),
    "unmeasured-wind": Effect(lambda s, h, ship: ({}, {"wind_speed_mps": s * scale(ship), "wind_dir_deg": deg(h["angle"])}), 5.0, direction, kind="wind", needs="hidden"),
    "wave-drift": Effect(lambda s, h, ship: ({"hs": s * scale(ship) ** 2, "wave_from": h["angle"]},
                                             {"hs_m": s * scale(ship) ** 2, "wave_from_deg": deg(h["angle"])}), 0.1, direction),
    "fouling": Effect(lambda s, h, ship: ({"fouling": s}, {"resistance_increase": s}), 0.8),
    "draft": Effect(one("draft", "draft_change", lambda s, h: s * h["sign"]), 0.4),
    "center-of-gravity": Effect(lambda s, h, ship: ({"dx_G": s * h["sign"] * ship["particulars"]["L_pp_m"]},
                                                    {"x_g_change_m": s * h["sign"] * ship["particulars"]["L_pp_m"]}), 0.06),
    "trim": Effect(one("trim", "trim_over_draft", lambda s, h: s * h["sign"]), 0.5),
    "cross-flow-drag": Effect(one("C_D_gain", "C_D_gain", lambda s, h: math.exp(s * h["sign"])), 0.9),
    "added-mass": Effect(lambda s, h, ship: ({k: math.exp(s * h["sign"]) for k in ("k_mx", "k_my", "k_Jz")},
                                             {k: math.exp(s * h["sign"]) for k in ("k_mx", "k_my", "k_Jz")}), 0.8),
    "thrust-loss": Effect(one("k_T", "k_T", lambda s, h: 1.0 - s), 0.5),
    "wake": Effect(one("dw", "wake_fraction_increase", lambda s, h: s * h["sign"]), 0.25),
    "propeller-walk": Effect(walk, 0.5),
    "rudder-offset": Effect(lambda s, h, ship: ({"rudder_offset": math.radians(s * h["sign"])}, {"rudder_offset_deg": s * h["sign"]}), 6.0),
    "rudder-effectiveness": Effect(rudder_loss, 0.8, lambda rng, ship, track: {
        "which": str(rng.choice(("k_R", "k_P", "k_S"))) if ship["rudder"]["type"].startswith("vectwin") else "k_R"}),
    "rudder-stall": Effect(lambda s, h, ship: ({"stall": math.radians(h["angle"]), "stall_c": s}, {"stall_angle_deg": h["angle"]}), 0.8,
                           lambda rng, ship, track: {"angle": float(rng.uniform(12.0, 22.0))}, prefer=("turn", "random")),
    "vectwin-interaction": Effect(one("k_pair", "k_interaction", lambda s, h: s), 0.9, ships=("vectwin",), prefer=("random", "berthing")),
    "thruster-gain": Effect(one("k_BT", "k_BT", lambda s, h: 1.0 - s), 0.9, ships=("vectwin",), prefer=("random", "berthing")),
    "thruster-speed-loss": Effect(lambda s, h, ship: ({"inv_u_c": s / scale(ship)}, {"u_c_mps": scale(ship) / max(s, 1e-9)}), 12.0, ships=("vectwin",),
                                  prefer=("random", "berthing")),
    "actuator-delay": Effect(lambda s, h, ship: ({"delay": s * scale(ship)}, {"delay_s": s * scale(ship)}), 3.0, kind="actuator", prefer=("zigzag", "random")),
    "actuator-lag": Effect(lambda s, h, ship: ({"lag": s * scale(ship)}, {"lag_s": s * scale(ship)}), 3.0, kind="actuator", prefer=("zigzag", "random")),
    "actuator-rate": Effect(lambda s, h, ship: ({"rate": math.radians(20.0 / max(s, 1.0) / scale(ship))}, {"rate_degps": 20.0 / max(s, 1.0) / scale(ship)}),
                            20.0, kind="actuator", prefer=("zigzag", "random")),
    "tug": Effect(lambda s, h, ship: (
        {"tug": s * 1e-3 * mass(ship), "tug_dir": h["angle"], "tug_x": h["x"], "tug_start": h["start"], "tug_end": h["end"]},
        {"force_N": s * 1e-3 * mass(ship), "direction_deg": deg(h["angle"]), "x_m": h["x"], "t_start_s": h["start"], "t_end_s": h["end"]}), 20.0, tug_shape),
    "mooring": Effect(lambda s, h, ship: (
        {"moor_k": 1e-3 * h["stiffness"] * mass(ship) / scale(ship) ** 2, "moor_x": h["x"], "moor_y": h["y"], "moor_l": max(h["farthest"] - s * scale(ship) ** 2, 0.0)},
        {"anchor_x_m": h["x"], "anchor_y_m": h["y"], "stiffness_npm": 1e-3 * h["stiffness"] * mass(ship) / scale(ship) ** 2,
         "slack_length_m": max(h["farthest"] - s * scale(ship) ** 2, 0.0)}), 20.0, anchor_shape, prefer=("turn", "random", "zigzag")),
    "fender": Effect(lambda s, h, ship: (  # natural period of a ship on one fender: 5 to 9 s at 3 m
        {"fender_k": h["stiffness"] * mass(ship) / scale(ship) ** 2, "fender_D": h["reach"] - s * scale(ship) ** 2, "fender_dir": h["angle"]},
        {"wall_distance_m": h["reach"] - s * scale(ship) ** 2, "wall_direction_deg": deg(h["angle"]), "stiffness_npm": h["stiffness"] * mass(ship) / scale(ship) ** 2}),
        2.0, fender_shape, prefer=("turn", "random", "zigzag")),
    "body-force": Effect(lambda s, h, ship: (
        {"body_X": s * 1e-3 * mass(ship) * math.cos(h["angle"]), "body_Y": s * 1e-3 * mass(ship) * math.sin(h["angle"])},
        {"X_N": s * 1e-3 * mass(ship) * math.cos(h["angle"]), "Y_N": s * 1e-3 * mass(ship) * math.sin(h["angle"])}), 10.0, direction),
    "earth-force": Effect(lambda s, h, ship: (
        {"earth_X": s * 1e-3 * mass(ship) * math.cos(h["angle"]), "earth_Y": s * 1e-3 * mass(ship) * math.sin(h["angle"])},
        {"force_N": s * 1e-3 * mass(ship), "direction_deg": deg(h["angle"])}), 10.0, direction),
}

SENSORS = {  # the recorded channel differs, the ship does not
    "heading-bias": Effect(one("heading_bias_deg", "heading_bias_deg", lambda s, h: s * h["sign"]), 10.0, kind="sensor"),
    "lever-arm": Effect(lambda s, h, ship: ({"lever_x_m": s * scale(ship) ** 2 * math.cos(h["angle"]), "lever_y_m": s * scale(ship) ** 2 * math.sin(h["angle"])},
                                            {"lever_x_m": s * scale(ship) ** 2 * math.cos(h["angle"]), "lever_y_m": s * scale(ship) ** 2 * math.sin(h["angle"])}),
                        2.0, direction, kind="sensor"),
    "log-scale": Effect(one("log_scale", "log_scale", lambda s, h: s * h["sign"]), 0.3, kind="sensor"),
    "rate-bias": Effect(lambda s, h, ship: ({"rate_bias_degps": s * h["sign"] / scale(ship)}, {"rate_bias_degps": s * h["sign"] / scale(ship)}), 0.5, kind="sensor"),
    "velocity-latency": Effect(lambda s, h, ship: ({"velocity_latency_s": s * scale(ship)}, {"velocity_latency_s": s * scale(ship)}), 4.0, kind="sensor"),
    "heading-latency": Effect(lambda s, h, ship: ({"heading_latency_s": s * scale(ship)}, {"heading_latency_s": s * scale(ship)}), 4.0, kind="sensor"),
    "sensor-filter": Effect(lambda s, h, ship: ({"filter_s": s * scale(ship)}, {"filter_s": s * scale(ship)}), 4.0, kind="sensor"),
}

OUTSIDE = {  # no name in the catalogue
    "coanda-jet": Effect(one("coanda", "coanda", lambda s, h: s), 0.95, ships=("vectwin",), prefer=("random", "berthing")),
    "ice-drag": Effect(one("ice", "ice", lambda s, h: s * 1e-3), 30.0),
    "swinging-tank": Effect(one("tank", "tank", lambda s, h: s), 1.0),
    "wake-memory": Effect(one("memory", "memory", lambda s, h: s), 1.5),
    "ventilation": Effect(one("ventilation", "ventilation", lambda s, h: s), 0.9, prefer=("turn", "zigzag", "random")),
    "magnetic-tether": Effect(lambda s, h, ship: ({"magnet": s * 1e-3, "magnet_x": h["x"], "magnet_y": h["y"]}, {"magnet": s * 1e-3}), 30.0, anchor_shape),
    "yaw-flutter": Effect(one("flutter", "flutter", lambda s, h: s * 1e-3), 10.0),
    "stiction": Effect(one("stiction", "stiction", lambda s, h: s * 1e-3), 10.0),
}

ALL = {**EFFECTS, **SENSORS, **OUTSIDE}
