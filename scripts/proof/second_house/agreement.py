#!/usr/bin/python3
"""How well the nominal ships of the second house agree with the ship files that the tool is given: the same turns and zigzags by both, one table.

The shipped file is driven by the actuators that the house's pilot moved (mmg-sim replay), so that only the ships differ."""

import argparse
import csv
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

import recording  # noqa: E402
from second_house import cases, vessel, voyage  # noqa: E402

BEGIN, END = "<!-- agreement: begin -->", "<!-- agreement: end -->"
MANEUVERS = ({"kind": "turn", "rudder_deg": 35}, {"kind": "turn", "rudder_deg": -35}, {"kind": "turn", "rudder_deg": 15}, {"kind": "zigzag", "rudder_deg": 20, "turn_by_deg": 20},
             {"kind": "zigzag", "rudder_deg": 10, "turn_by_deg": 10})


class Exact:
    """Instruments that see what is."""

    def row(self, t, s, rate, acting, wind):
        return {"psi_deg": np.degrees(s["psi"]), "r_degps": np.degrees(s["r"]), "u_mps": s["u"]}


def both(binaries, name, maneuvers=MANEUVERS, seconds=260):
    """[(the house's columns, the shipped file's)] by maneuver, calm, without model error."""
    ship = vessel.Vessel(name)
    h = round(ship.scale, 1)
    out = voyage.sail(ship, [{"seed": 1, **m} for m in maneuvers], h * seconds, h / 10.0, h, None, None, Exact())
    names = [c for c in out["true"] if c.endswith(("_deg", "_rps", "_mps", "_degps", "_m")) and not c.startswith(("acting", "wind"))]
    result = []
    for i in range(len(maneuvers)):
        own = {"t_s": out["t_s"], **{c: out["true"][c][i] for c in names}}
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "own.csv"
            recording.write_csv(file, own)
            done = subprocess.run([str(binaries / "mmg-sim"), "replay", "--ship", str(vessel.SHIPS / f"{name}.json"), str(file), "--sample-s", f"{h:g}", "--dt-s", f"{h / 10:g}",
                                   "-o", "-", "--quiet"], capture_output=True, text=True, check=True)
        rows = list(csv.DictReader(done.stdout.splitlines()))
        result.append((own, {c: np.array([float(r[c]) for r in rows]) for c in ("x0_m", "y0_m", "psi_deg", "u_mps", "vm_mps", "r_degps")}))
    return result


def circle(columns, L, start, end):
    """Advance and tactical diameter in lengths; None where the turn is not far enough."""
    x, y, psi = (columns[c][start:end] for c in ("x0_m", "y0_m", "psi_deg"))
    psi = np.abs(np.radians(psi - psi[0]))
    at = lambda angle: int(np.argmax(psi >= angle)) if (psi >= angle).any() else None
    quarter, half = at(0.5 * math.pi), at(math.pi)
    return (None if quarter is None else abs(x[quarter] - x[0]) / L), (None if half is None else abs(y[half] - y[0]) / L)


def lines_of(binaries, name):
    L = vessel.Vessel(name).L
    for maneuver, (own, theirs) in zip(MANEUVERS, both(binaries, name)):
        words = f"| {name} | {maneuver['kind']} {maneuver['rudder_deg']} |"
        rms = lambda c: 100.0 * np.sqrt(np.mean((own[c][:len(theirs[c])] - theirs[c]) ** 2)) / np.sqrt(np.mean(theirs[c] ** 2))
        turned = "– | – |"
        if maneuver["kind"] == "turn":  # from where the rudder is put over to where it is put back
            (a, d), (b, e) = (circle(c, L, 8, len(own["t_s"]) // 2) for c in (own, theirs))
            pair = lambda x, y: "–" if x is None or y is None else f"{x:.2f}, {y:.2f}"
            turned = f"{pair(a, b)} | {pair(d, e)} |"
        yield f"{words} {turned} {rms('u_mps'):.0f} % | {rms('vm_mps'):.0f} % | {rms('r_degps'):.0f} % |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, default=HERE.parents[2] / "build/release/bin")
    parser.add_argument("--page", action="store_true", help="write the table into README.md beside this file")
    o = parser.parse_args()
    lines = ["| ship | maneuver | advance [L]: house, file | tactical diameter [L]: house, file | u differs, rms | v_m | r |", "|---" * 7 + "|"]
    for name in cases.SHIPS:
        lines += list(lines_of(o.bin.resolve(), name))
    print("\n".join(lines))
    if o.page:
        page = HERE / "README.md"
        before, rest = page.read_text(encoding="utf-8").split(BEGIN)
        page.write_text(before + BEGIN + "\n" + "\n".join(lines) + "\n" + END + rest.split(END)[1], encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
