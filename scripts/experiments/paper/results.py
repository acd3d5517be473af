"""Reads a folder of results of the Makefile here, for figures and claims."""

import csv
import functools
import json
import pathlib

import numpy as np

SETS = ("Test-B", "Test-ZT", "Test-R")
FULL_SET = "Test-Full-B"
SAMPLINGS = {"ts-inf": "TS-infinity", "ts1": "TS1"}
# Units of the controller's gains, which the paper does not give: (head of the files, degrees of rudder per radian that a gain of 1 is)
UNITS = {"deg/rad": ("", 1.0), "deg/deg": ("per-degree-", 180.0 / np.pi)}
STATES = ("u_mps", "vm_mps", "r_degps")
ERRORS = ("u_error", "vm_error", "r_error")
QUANTITIES = (*STATES, "delta_p_deg", "delta_s_deg", "n_bt_rps")


class Results:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        text = (self.folder / "settings").read_text(encoding="utf-8")
        self.settings = dict(pair.split("=", 1) for pair in text.split())
        self.members, self.repeats = int(self.settings["MEMBERS"]), int(self.settings["REPEATS"])
        self.init_repeats = int(self.settings["INIT_REPEATS"])
        self.pool = max(self.members * self.repeats, self.init_repeats)

    @functools.cache
    def scores(self, name):
        """{data set: entry} of the metrics file NAME.json."""
        metrics = json.loads((self.folder / f"{name}.json").read_text(encoding="utf-8"))
        return {entry["name"]: entry for entry in metrics["datasets"]}

    @functools.cache
    def spreads(self, sampling):
        """{data set: (members, repeats)} of the root mean square spread of velocities."""
        table = {name: np.full((self.members, self.repeats), np.nan) for name in SETS}
        for m in range(self.members):
            for r in range(self.repeats):
                for row in read_rows(self.folder / "sampling" / f"{sampling}-{m + 1}-{r + 1}.spread.csv"):
                    table[set_of(row["set"] + "-")][m, r] = float(row["spread"])
        return table

    def fits(self, kind):
        """L_fit on Train-B of the networks trained `with` or `without` the initial-state network."""
        return np.array([self.scores(f"fit/{kind}-{k + 1}")["Train-B"]["L_fit"] for k in range(self.init_repeats)])

    @functools.cache
    def sampling(self, sampling, key):
        """{data set: (members, repeats)} of a figure; nan where it is undefined."""
        table = {name: np.full((self.members, self.repeats), np.nan) for name in SETS}
        for m in range(self.members):
            for r in range(self.repeats):
                scores = self.scores(f"sampling/{sampling}-{m + 1}-{r + 1}")
                for name in SETS:
                    value = scores[name][key]
                    table[name][m, r] = np.nan if value is None else value
        return table

    @functools.cache
    def points(self, folder, sampling):
        """{data set: {column: (points,)}} of the per-step file, k >= 1: recording and sequence, t_s, eucl, maha, position_error_m,
        position_sd_m, errors of the mean in u, v_m [m/s] and r [deg/s]; spread is the root of the trace of the particles' covariance of velocities."""
        found = {}
        with open(self.folder / folder / f"{sampling}.csv", newline="", encoding="utf-8") as stream:
            for row in csv.DictReader(stream):
                if row["step"] == "0":
                    continue
                columns = found.setdefault(set_of(row["recording"]), {})
                sd = float(row["u_sd_mps"]), float(row["vm_sd_mps"]), np.radians(float(row["r_sd_degps"]))
                columns.setdefault("sequence", []).append(f"{row['recording']} {row['sequence']}")
                columns.setdefault("spread", []).append(float(np.sqrt(np.sum(np.square(sd)))))
                for state, unit in (("u", "mps"), ("vm", "mps"), ("r", "degps")):
                    columns.setdefault(f"{state}_error", []).append(float(row[f"{state}_mean_{unit}"]) - float(row[f"{state}_truth_{unit}"]))
                for name in ("t_s", "eucl", "maha", "position_error_m", "position_sd_m"):
                    columns.setdefault(name, []).append(float(row[name]) if row[name] else np.nan)
        return {name: {key: np.array(values) for key, values in columns.items()} for name, columns in found.items()}

    def sequences(self, folder, sampling, sets):
        """For each sequence of these sets: root mean square of d_E and of the spread of velocities, error and spread of the position at
        its end, the share of its points where the bias is larger than the spread, root mean squares of the errors of u, v_m and r."""
        rows = {}
        for name in sets:
            points = self.points(folder, sampling)[name]
            for sequence in dict.fromkeys(points["sequence"]):
                at = points["sequence"] == sequence
                last = np.flatnonzero(at)[-1]
                rows[sequence] = (np.sqrt(np.mean(points["eucl"][at] ** 2)), np.sqrt(np.mean(points["spread"][at] ** 2)),
                                  points["position_error_m"][last], points["position_sd_m"][last], np.mean(points["eucl"][at] > points["spread"][at]),
                                  *(np.sqrt(np.mean(points[name][at] ** 2)) for name in ERRORS))
        columns = ("eucl", "spread", "position_error_m", "position_sd_m", "bias_beyond_spread", *ERRORS)
        return list(rows), dict(zip(columns, np.array(list(rows.values())).T))

    @functools.cache
    def truths(self, folder, name):
        """The noise-free recordings of a set: a list of {quantity: (samples,)}."""
        files = sorted((self.folder / folder / name / "truth").glob("*.csv"))
        if not files:
            raise ValueError(f"{folder}/{name}/truth holds no recording")
        return [read_columns(file, QUANTITIES) for file in files]

    def unrecorded(self):
        """{recording: physics that acted on it and that no column holds} of the full-scale test set, where the data set says it."""
        path = self.folder / "data-full" / FULL_SET / "truth" / "runs.json"
        if not path.exists():
            return {}
        runs = json.loads(path.read_text(encoding="utf-8"))["runs"]
        return {run["recording"]: list(dict.fromkeys(effect["type"] for effect in run["unrecorded"])) for run in runs if run.get("unrecorded")}

    def sweep(self, members, unit):
        """(gains K_P, gains K_D in the unit, {column: (K_D, K_P) scores}) of a sweep with the first members."""
        head, factor = UNITS[unit]
        kp, kd, tables = read_sweep(self.folder / "pd" / f"{head}sweep-{members}.csv")
        return kp / factor, kd / factor, tables

    def runs(self, gain, unit):
        """{model: {column: (samples,)}} of the controller's runs with both gains alike; the true ship is `true`."""
        head, factor = UNITS[unit]
        folder = self.folder / "pd" / f"{head}runs"
        files = [file for file in folder.glob("kp*_kd*.csv") if all(abs(float(word[2:]) - gain * factor) < 0.5 for word in file.stem.split("_"))]
        if len(files) != 1:
            raise ValueError(f"pd/{head}runs: expected one run with both gains {gain:g} {unit}, found {len(files)}")
        rows = read_rows(files[0])
        names = [name for name in rows[0] if name != "model"]
        return {model: {name: np.array([float(row[name]) for row in rows if row["model"] == model]) for name in names}
                for model in dict.fromkeys(row["model"] for row in rows)}

    def true_runs(self, unit):
        """{(K_P, K_D) in deg/rad: {state: (samples,)}} of the true ship with all pairs of gains."""
        found = {}
        for row in read_rows(self.folder / "pd" / f"{UNITS[unit][0]}true-runs.csv"):
            run = found.setdefault((float(row["kp_deg_per_rad"]), float(row["kd_deg_per_radps"])), {name: [] for name in STATES})
            for name in STATES:
                run[name].append(float(row[name]))
        return {gains: {name: np.array(values) for name, values in run.items()} for gains, run in found.items()}

    def train_seconds(self, name, members=None):
        """CPU time of a training; of the first members only, where they are a part of it."""
        total = 0.0
        for line in (self.folder / f"{name}.seconds").read_text(encoding="utf-8").splitlines():
            seconds, command = line.split("\t")
            words = command.split()
            if members is None or ("--member" in words and int(words[words.index("--member") + 1]) < members):
                total += float(seconds)
        return total


def set_of(recording):
    """The data set that a recording of the paper's sets belongs to, by its name."""
    return next(name for name in (*SETS, FULL_SET) if recording.startswith(name.lower() + "-"))


def read_rows(path):
    with open(path, newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def read_columns(path, names):
    rows = read_rows(path)
    return {name: np.array([float(row[name]) if row[name] else np.nan for row in rows]) for name in names}


def read_sweep(path):
    rows = read_rows(path)
    kp, kd = (np.unique([float(row[name]) for row in rows]) for name in ("kp_deg_per_rad", "kd_deg_per_radps"))
    tables = {name: np.full((len(kd), len(kp)), np.nan) for name in rows[0] if name.startswith("score_")}
    for row in rows:
        i, j = np.searchsorted(kd, float(row["kd_deg_per_radps"])), np.searchsorted(kp, float(row["kp_deg_per_rad"]))
        for name, table in tables.items():
            table[i, j] = float(row[name])
    return kp, kd, tables
