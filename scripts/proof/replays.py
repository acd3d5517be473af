"""Free runs of ship files over noise-free sealed recordings, by mmg-sim: the same for the ship as it was, the tool's and a reference's."""

import csv
import json
import math
import pathlib
import subprocess
import tempfile

import numpy as np

import physics
import recording

HORIZONS_S = (30, 100, 300)
STRENGTHS = (0.7, 1.0, 1.4)  # of the true one: the truth has other formulas
FLOOR = {"u_mps": 1e-3, "vm_mps": 1e-3, "r_degps": 1e-2, "position_m": 1e-2}  # errors below are none


def with_effects(ship, truth, gain=1.0):
    """The ship file with the true effects at `gain` times their strength; None where the catalogue's file format has none."""
    out = json.loads(json.dumps(ship))
    out.setdefault("effects", [])
    for name, t in truth.items():
        if name not in physics.EFFECTS or name in ("tug", "anemometer"):
            return None
        p = dict(t["parameters"])
        for k, v in p.items():
            if v is None or k in ("wall_direction_deg",) or k.endswith("_set_deg") or k in ("wind_dir_deg", "wave_from_deg", "direction_deg"):
                continue
            if k.startswith("k_") or k in ("kX", "kY", "kN", "C_D_gain"):
                p[k] = 1.0 + gain * (v - 1.0) if k != "k_interaction" else gain * v
            elif k == "h_over_T":
                p[k] = 1.0 + (v - 1.0) / gain
            elif k in ("rate_degps", "u_c_mps"):
                p[k] = v / gain
            elif k not in ("anchor_x_m", "anchor_y_m", "stall_angle_deg", "wall_distance_m"):
                p[k] = gain * v
        out["effects"].append({"type": name, **p})
    return out


def errors(bin_folder, ship_file, files, scale=1.0):
    """Mean log error over channels and horizons, from free runs of the ship over the files; None where mmg-sim refuses."""
    total, n = 0.0, 0
    with tempfile.TemporaryDirectory() as folder:
        for horizon in HORIZONS_S:
            span = horizon * round(scale)
            squares, count = dict.fromkeys(FLOOR, 0.0), 0
            for file in files:
                truth = recording.read_csv(file)
                dt = truth["t_s"][1] - truth["t_s"][0]
                if truth["t_s"][-1] - truth["t_s"][0] < span - 1e-6:
                    continue
                K = int(round(span / dt)) + 1
                result = subprocess.run([str(bin_folder / "mmg-sim"), "replay", "--ship", str(ship_file), str(file), "--restart-steps", str(K), "--sample-s",
                                         f"{dt:g}", "--prediction", "-o", folder, "--quiet"], capture_output=True, text=True, check=False)
                if result.returncode != 0:
                    return None
                place = {round(t, 3): i for i, t in enumerate(truth["t_s"])}
                with open(pathlib.Path(folder) / pathlib.Path(file).name, encoding="utf-8") as f:
                    rows = [r for r in csv.DictReader(f) if r["step"] != "0"]
                if not rows:
                    continue
                at = np.array([place[round(float(r["t_s"]), 3)] for r in rows])
                value = lambda name: np.array([float(r[name]) for r in rows])
                for c in ("u_mps", "vm_mps", "r_degps"):
                    squares[c] += float(np.sum((value(c) - truth[c][at]) ** 2))
                squares["position_m"] += float(np.sum((value("x0_m") - truth["x0_m"][at]) ** 2 + (value("y0_m") - truth["y0_m"][at]) ** 2))
                count += len(rows)
            if count:
                for c, floor in FLOOR.items():
                    total += 0.5 * math.log(squares[c] / count + floor**2)
                    n += 1
    return total / n if n else None


def fitted(bin_folder, ship, recordings):
    """The ship file with its coefficients fitted to the recordings by gap-locate, and the likelihood; None where the tool refuses it."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "ship.json"
        file.write_text(json.dumps(ship), encoding="utf-8")
        command = [str(bin_folder / "gap-locate"), "--ship", str(file), *map(str, recordings), "-o", folder, "--quiet", "--jobs", "1"]
        if subprocess.run(command, capture_output=True, check=False).returncode:
            return None
        fit = json.loads((pathlib.Path(folder) / "locate.json").read_text(encoding="utf-8"))["null_fit"]
    given = ship.get("coefficient_factors") or {}
    factors = {k: p["factor"] * (given.get(k) or 1.0) for k, p in fit["parameters"].items() if p.get("factor")}
    return {**ship, "coefficient_factors": {**given, **factors}}, fit["log_likelihood"]


def improvement(bin_folder, case, secret, key, ship_after, scale):
    """Mean log errors over the sealed test recordings (which no tool was given) with the ship as it was, the tool's, and a reference who knows
    which effects act: the true ones in the tool's formulas, at the strength and with the coefficients that fit the given recordings best."""
    tests, given = sorted(secret.glob("test-*.csv")), sorted(case.glob("train-*.csv"))
    out = {"before": errors(bin_folder, case / "ship.json", tests, scale), "after": None, "oracle": None}
    if ship_after.exists():
        out["after"] = errors(bin_folder, ship_after, tests, scale)
    if not key["names"]:
        return out
    ship = json.loads((case / "ship.json").read_text(encoding="utf-8"))
    best = None
    for gain in STRENGTHS:
        candidate = with_effects(ship, key["truth"], gain)
        fit = fitted(bin_folder, candidate, given) if candidate is not None else None
        if fit is not None and (best is None or fit[1] > best[1]):
            best = (*fit, gain)
    if best is not None:
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "oracle.json"
            file.write_text(json.dumps(best[0]), encoding="utf-8")
            out["oracle"], out["oracle_gain"] = errors(bin_folder, file, tests, scale), best[2]
    return out
