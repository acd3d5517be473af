"""A folder with one small input of every kind that the tools read, so that each command line takes milliseconds."""

import json
import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BIN = pathlib.Path(os.environ.get("LEEWAY_BIN", ROOT / "build" / "release" / "bin"))

CONFIG = {"hidden_units": 4, "hidden_layers": 1, "steps": 8, "initial_state_steps": 3, "batch_size": 4, "epochs": 3,
          "members": 2, "learning_rate": 1e-3}
SPEC = {"ship": "vectwin-3m", "noise": {"u_mps": 0.01, "r_degps": 0.1}, "sets": [
    {"name": "train", "runs": [{"maneuver": "random", "count": 2, "duration_s": 20, "wind": {"speed_mps": [0.5, 1]}}]},
    {"name": "test", "runs": [{"maneuver": "turning", "rudder_deg": 20, "duration_s": 20}]}]}
CURRENT = {"type": "steady-current", "current_speed_mps": 0.1, "current_set_deg": 90}
COLUMNS = {"missing": ["-9999"], "t_s": "t_s", "u_mps": {"from": "u_mps", "unit": "mps"}, "vm_mps": "vm_mps",
           "r_degps": "r_degps", "psi_deg": "psi_deg", "n_p_rps": "n_p_rps", "delta_deg": "delta_deg"}
SETUP = """
mmg-sim dataset spec.json -o data
ens-train data/dataset.json#train --config config.json -o model
ens-predict model data/dataset.json#test --steps 8 --particles 4 -o pred
mmg-sim zigzag --ship esso-osaka-3m --duration-s 20 --noise paper-model-scale -o esso.csv
mmg-sim turning --ship esso-osaka-3m --duration-s 20 --noise paper-model-scale -o turn.csv
"""


def run(line, folder, timeout=60, **more):
    """Runs a command line, a list of words of which the first is a tool."""
    return subprocess.run([str(BIN / line[0]), *line[1:]], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True,
                          timeout=timeout, **more)


def prepare(folder):
    """Fills an empty folder."""
    folder.mkdir(parents=True, exist_ok=True)
    texts = {"spec.json": SPEC, "config.json": CONFIG, "effect.json": CURRENT, "columns.json": COLUMNS,
             "noise.json": {"u_mps": 0.01, "psi_deg": 0.1}}
    for name, content in texts.items():
        (folder / name).write_text(json.dumps(content))
    for ship in ("vectwin-3m", "esso-osaka-3m"):
        (folder / f"{ship}.json").write_bytes((ROOT / "configs" / "ships" / f"{ship}.json").read_bytes())
    (folder / "orders.csv").write_text("t_s,delta_deg,n_p_rps\n0,10,\n5,-10,9\n")
    for line in SETUP.strip().splitlines():
        done = run([*line.split(), "--jobs", "1", "--quiet"], folder)
        if done.returncode != 0:
            raise SystemExit(f"{line}: {done.stderr.decode()}")


def files_of(folder, but=()):
    """Names of all files with their bytes; not those in the folders and files `but`."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*"))
            if path.is_file() and path.relative_to(folder).parts[0] not in but}
