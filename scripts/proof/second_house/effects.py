"""What can be left out in the second house: strength and shape to numbers of the vessel, and to the catalogue's parameters for the key.

The forms stand in vessel.py and are this house's own; what a parameter means is the catalogue's, so that estimates can be judged."""

import math

import numpy as np


class Effect:
    """at(strength, shape, vessel) -> (numbers of the vessel, parameters by the catalogue's names). kind: force, actuator, wind, sensor."""

    def __init__(self, at, most, draw="sign", kind="force", needs=None, ships=None, about=None):
        self.at, self.most, self.kind, self.needs, self.ships, self.about = at, most, kind, needs, ships, about
        self.shape = draw

    def fits(self, vessel):
        return (self.ships is None or vessel.name.startswith(self.ships)) and (self.needs is None or "wind" in vessel.ship)

    def draw(self, rng, vessel, duration, track):
        """Shape of an effect; what needs no number of it draws it all the same, so that classes do not shift one another's draws."""
        sign, angle = float(rng.choice((-1.0, 1.0))), float(rng.uniform(0.0, 2.0 * math.pi))
        start = float(rng.uniform(0.15, 0.5)) * duration
        i = int(rng.integers(len(track["x0_m"])))
        return {"sign": sign, "angle": angle, "x": float(rng.choice((-0.4, 0.4))) * vessel.L, "start": round(start),
                "end": round(start + float(rng.uniform(0.15, 0.3)) * duration), "w": 2.0 * math.pi / float(rng.uniform(120.0, 320.0)),
                "phase": float(rng.uniform(0.0, 6.28)), "px": float(track["x0_m"][i]), "py": float(track["y0_m"][i]), "duration": float(duration)}


def mass(v):
    return v.ship["inertia"]["m"] * v.q * v.L


def deg(angle):
    return math.degrees(angle) % 360.0


def same(key, name, value):
    def at(s, h, v):
        x = value(s, h, v)
        return {key: x}, {name: x}
    return at


def fault(name, value):
    return lambda s, h, v: ({}, {name: value(s, h, v)})


EFFECTS = {
    "steady-current": Effect(lambda s, h, v: ({"current": s * v.scale, "current_dir": h["angle"]},
                                              {"current_speed_mps": s * v.scale, "current_set_deg": deg(h["angle"])}), 0.15),
    "varying-current": Effect(lambda s, h, v: ({"tide": s * v.scale, "tide_w": h["w"] / v.scale, "tide_phase": h["phase"]}, {"current_sd_mps": 0.87 * s * v.scale}), 0.12),
    "unmeasured-wind": Effect(lambda s, h, v: ({}, {"wind_speed_mps": s * v.scale, "wind_dir_deg": deg(h["angle"])}), 4.0, kind="wind", needs="hidden"),
    "wave-drift": Effect(lambda s, h, v: ({"hs": s * v.scale**2, "wave_from": h["angle"]}, {"hs_m": s * v.scale**2, "wave_from_deg": deg(h["angle"])}), 0.1),
    "fouling": Effect(same("fouling", "resistance_increase", lambda s, h, v: s), 0.8),
    "thrust-loss": Effect(lambda s, h, v: ({"thrust_loss": s}, {"k_T": 1.0 - s}), 0.5),
    "rudder-effectiveness": Effect(lambda s, h, v: ({"rudder_loss": s}, {"k_R": 1.0 - s}), 0.7),
    "rudder-offset": Effect(lambda s, h, v: ({"rudder_offset": math.radians(s * h["sign"])}, {"rudder_offset_deg": s * h["sign"]}), 6.0),
    "actuator-delay": Effect(lambda s, h, v: ({"delay": s * v.scale}, {"delay_s": s * v.scale}), 3.0, kind="actuator"),
    "actuator-lag": Effect(lambda s, h, v: ({"lag": s * v.scale}, {"lag_s": s * v.scale}), 3.0, kind="actuator"),
    "shallow-water": Effect(lambda s, h, v: ({"F": s}, {"h_over_T": 1.0 / max(s, 1e-3)}), 0.8),
    "tug": Effect(lambda s, h, v: ({"tug": 1e-3 * s * mass(v), "tug_dir": h["angle"], "tug_x": h["x"], "tug_start": h["start"], "tug_end": h["end"]},
                                   {"force_N": 1e-3 * s * mass(v), "direction_deg": deg(h["angle"]), "x_m": h["x"], "t_start_s": h["start"], "t_end_s": h["end"]}), 15.0),
    "body-force": Effect(lambda s, h, v: ({"body_X": 1e-3 * s * mass(v) * math.cos(h["angle"]), "body_Y": 1e-3 * s * mass(v) * math.sin(h["angle"])},
                                          {"X_N": 1e-3 * s * mass(v) * math.cos(h["angle"]), "Y_N": 1e-3 * s * mass(v) * math.sin(h["angle"])}), 8.0),
    "earth-force": Effect(lambda s, h, v: ({"earth_X": 1e-3 * s * mass(v) * math.cos(h["angle"]), "earth_Y": 1e-3 * s * mass(v) * math.sin(h["angle"])},
                                           {"force_N": 1e-3 * s * mass(v), "direction_deg": deg(h["angle"])}), 8.0),
    "cross-flow-drag": Effect(lambda s, h, v: ({"C_D_gain": math.exp(s * h["sign"])}, {"C_D_gain": math.exp(s * h["sign"])}), 0.9),
    "draft": Effect(same("draft", "draft_change", lambda s, h, v: s * h["sign"]), 0.4),
    "propeller-walk": Effect(lambda s, h, v: ({"walk": s * h["sign"]}, {"c_Y": 0.6 * s * h["sign"], "c_N": -0.3 * s * h["sign"]}), 0.4),
    "windage": Effect(lambda s, h, v: ({"windage": math.exp(s * h["sign"])}, {"kX": math.exp(s * h["sign"]), "kY": math.exp(s * h["sign"])}), 0.9, needs="measured"),
    "wake": Effect(same("wake", "wake_fraction_increase", lambda s, h, v: s * h["sign"]), 0.25),
    "thruster-gain": Effect(lambda s, h, v: ({"thruster": 1.0 - s}, {"k_BT": 1.0 - s}), 0.9, ships="vectwin"),
    "anemometer": Effect(fault("anemometer_scale", lambda s, h, v: 1.0 + s * h["sign"]), 0.45, kind="wind", needs="measured"),
}
SENSORS = {
    "heading-bias": Effect(fault("heading_bias_deg", lambda s, h, v: s * h["sign"]), 8.0, kind="sensor"),
    "lever-arm": Effect(lambda s, h, v: ({}, {"lever_x_m": s * v.scale**2 * math.cos(h["angle"]), "lever_y_m": s * v.scale**2 * math.sin(h["angle"])}), 1.5, kind="sensor"),
    "log-scale": Effect(fault("log_scale", lambda s, h, v: s * h["sign"]), 0.3, kind="sensor"),
    "rate-bias": Effect(fault("rate_bias_degps", lambda s, h, v: s * h["sign"] / v.scale), 0.5, kind="sensor"),
    "velocity-latency": Effect(fault("velocity_latency_s", lambda s, h, v: s * v.scale), 4.0, kind="sensor"),
    "heading-latency": Effect(fault("heading_latency_s", lambda s, h, v: s * v.scale), 4.0, kind="sensor"),
    "sensor-filter": Effect(fault("filter_s", lambda s, h, v: s * v.scale), 4.0, kind="sensor"),
}
OUTSIDE = {  # no name in the catalogue; `about` says what kind of thing it is
    "shifted-cargo": Effect(same("cargo", "heel", lambda s, h, v: s * h["sign"]), 0.35, about="states"),
    "seiche": Effect(lambda s, h, v: ({"seiche": 1e-3 * s, "seiche_dir": h["angle"], "seiche_w": 2.0 * h["w"] / v.scale}, {"seiche": 1e-3 * s}), 15.0, about="period"),
    "weed": Effect(lambda s, h, v: ({"weed": 1e-3 * s, "weed_time": 0.8 * h["duration"]}, {"weed": 1e-3 * s}), 20.0, about="time"),
    "backlash": Effect(lambda s, h, v: ({"backlash": math.radians(s)}, {"backlash_deg": s}), 12.0, kind="actuator", about="memory"),
    "shoal": Effect(lambda s, h, v: ({"shoal": 1e-3 * s, "shoal_x": h["px"], "shoal_y": h["py"], "shoal_R": 3.0 * v.L}, {"shoal": 1e-3 * s}), 20.0, about="place"),
    "roll-tank": Effect(same("tank", "tank", lambda s, h, v: s), 1.0, about="memory"),
}
ALL = {**EFFECTS, **SENSORS, **OUTSIDE}
PAIRS = (("steady-current", "rudder-offset"), ("unmeasured-wind", "steady-current"), ("thrust-loss", "rudder-offset"), ("actuator-delay", "steady-current"),
         ("heading-latency", "rudder-offset"), ("log-scale", "steady-current"), ("wave-drift", "rudder-effectiveness"), ("tug", "rudder-offset"))
