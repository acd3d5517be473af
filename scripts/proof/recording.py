"""What instruments make of a track: sampling, faults, noise, gaps, and the CSV files."""

import math

import numpy as np

PAPER = {"x0_m": 0.03, "y0_m": 0.03, "psi_deg": 0.1, "u_mps": 0.01, "vm_mps": 0.01, "r_degps": 0.1}
KINDS = ("paper", "three-times", "coloured", "quantised", "gaps", "outliers")


def noise_sd(kind, scale):
    """Standard deviation by column; at full scale the paper's, with 0.01 deg/s."""
    sd = dict(PAPER)
    if scale > 2.0:
        sd["r_degps"] = 0.01
    gain = 3.0 if kind == "three-times" else 1.0
    return {k: v * gain for k, v in sd.items()}


def columns_of(track, i):
    """Noise-free columns of recording i, by name."""
    out = {"t_s": track["t"], "u_mps": track["u"][i], "vm_mps": track["v"][i], "r_degps": np.degrees(track["r"][i]), "x0_m": track["x"][i],
           "y0_m": track["y"][i], "psi_deg": np.degrees(track["psi"][i])}
    for c in track["channels"]:
        a = track[f"a_{c}"][i]
        if c.startswith("delta"):
            out[f"{c}_deg"] = np.degrees(a)
        else:
            out[f"{c}_rps"] = a
    out["wind_speed_mps"] = np.hypot(track["wx"][i], track["wy"][i])
    out["wind_dir_deg"] = np.degrees(np.arctan2(track["wy"][i], track["wx"][i])) % 360.0
    return {k: np.array(v, float) for k, v in out.items()}


def between(t, values, at):
    """Values at times between samples, before the first one that one: by cubics, since a chord smooths as a filter does."""
    slope = np.gradient(values, t, edge_order=2)
    at = np.maximum(at, t[0])
    k = np.clip(np.searchsorted(t, at, side="right") - 1, 0, len(t) - 2)
    h = t[k + 1] - t[k]
    s = (at - t[k]) / h
    return ((1.0 + 2.0 * s) * (1.0 - s) ** 2 * values[k] + s * (1.0 - s) ** 2 * h * slope[k]
            + s * s * (3.0 - 2.0 * s) * values[k + 1] - s * s * (1.0 - s) * h * slope[k + 1])


def late(t, values, by):
    return between(t, values, t - by)


def filtered(t, values, tau):
    out, dt, sub = values.copy(), t[1] - t[0], 20
    fine = between(t, values, t[:-1, None] + dt * (np.arange(sub) + 0.5) / sub)
    y, a = values[0], 1.0 - math.exp(-dt / sub / tau)
    for k in range(1, len(values)):
        for x in fine[k - 1]:
            y += a * (x - y)
        out[k] = y
    return out


def with_faults(columns, faults):
    """Columns as faulty instruments record them; faults by the catalogue's parameter names."""
    out, t = {k: v.copy() for k, v in columns.items()}, columns["t_s"]
    psi = np.radians(columns["psi_deg"])
    if "lever_x_m" in faults:
        lx, ly = faults["lever_x_m"], faults["lever_y_m"]
        out["x0_m"] = columns["x0_m"] + lx * np.cos(psi) - ly * np.sin(psi)
        out["y0_m"] = columns["y0_m"] + lx * np.sin(psi) + ly * np.cos(psi)
    if "heading_bias_deg" in faults:
        out["psi_deg"] = out["psi_deg"] + faults["heading_bias_deg"]
    if "log_scale" in faults:
        out["u_mps"] = out["u_mps"] * (1.0 + faults["log_scale"])
    if "rate_bias_degps" in faults:
        out["r_degps"] = out["r_degps"] + faults["rate_bias_degps"]
    if "velocity_latency_s" in faults:
        for c in ("u_mps", "vm_mps"):
            out[c] = late(t, out[c], faults["velocity_latency_s"])
    if "heading_latency_s" in faults:
        out["psi_deg"] = late(t, out["psi_deg"], faults["heading_latency_s"])
    if "filter_s" in faults:
        for c in ("u_mps", "vm_mps", "r_degps"):
            out[c] = filtered(t, out[c], faults["filter_s"])
    if "anemometer_scale" in faults or "anemometer_angle_deg" in faults:  # acts on the apparent wind, from which the true one is computed
        xi = np.radians(columns["wind_dir_deg"]) - psi
        U = columns["wind_speed_mps"]
        ax, ay = U * np.cos(xi) + columns["u_mps"], U * np.sin(xi) + columns["vm_mps"]
        e, k = math.radians(faults.get("anemometer_angle_deg", 0.0)), faults.get("anemometer_scale", 1.0)
        bx, by = k * (ax * math.cos(e) - ay * math.sin(e)), k * (ax * math.sin(e) + ay * math.cos(e))
        wx, wy = bx - columns["u_mps"], by - columns["vm_mps"]
        out["wind_speed_mps"] = np.hypot(wx, wy)
        out["wind_dir_deg"] = np.degrees(np.arctan2(wy, wx) + psi) % 360.0
    if faults.get("wind_to"):
        out["wind_dir_deg"] = (out["wind_dir_deg"] + 180.0) % 360.0
    return out


def with_noise(columns, kind, scale, rng):
    out = {k: v.copy() for k, v in columns.items()}
    n, dt = len(columns["t_s"]), columns["t_s"][1] - columns["t_s"][0]
    for name, sd in noise_sd(kind, scale).items():
        e = rng.standard_normal(n)
        if kind == "coloured":
            a = math.exp(-dt / (2.0 * scale))
            for k in range(1, n):
                e[k] = a * e[k - 1] + math.sqrt(1.0 - a * a) * e[k]
        if kind == "outliers":
            e = np.where(rng.random(n) < 0.005, 10.0 * np.sign(e), e)
        out[name] = out[name] + sd * e
        if kind == "quantised":
            step = 2.0 * sd
            out[name] = np.round(out[name] / step) * step
        if kind == "gaps":
            out[name] = np.where(rng.random(n) < 0.12, np.nan, out[name])
    return out


def write_csv(file, columns, leave_out=()):
    names = [n for n in columns if n not in leave_out]
    digits = {"t_s": 3}
    with open(file, "w", encoding="utf-8") as out:
        out.write(",".join(names) + "\n")
        for row in zip(*(columns[n] for n in names)):
            out.write(",".join("" if math.isnan(x) else f"{x:.{digits.get(n, 7)}g}" if n != "t_s" else f"{x:.10g}" for n, x in zip(names, row)) + "\n")


def read_csv(file):
    with open(file, encoding="utf-8") as f:
        names = f.readline().strip().split(",")
        rows = [[float(x) if x else math.nan for x in line.rstrip("\n").split(",")] for line in f]
    data = np.array(rows)
    return {n: data[:, i] for i, n in enumerate(names)}
