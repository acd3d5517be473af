"""Reads a folder of results of the Makefile here, for figures and claims."""

import csv
import json
import pathlib

import numpy as np

SETS = ("Test-B", "Test-ZT", "Test-R")
SAMPLINGS = {"ts-inf": "TS-infinity", "ts1": "TS1"}


class Results:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        text = (self.folder / "settings").read_text(encoding="utf-8")
        self.settings = dict(pair.split("=", 1) for pair in text.split())
        self.members, self.repeats = int(self.settings["MEMBERS"]), int(self.settings["REPEATS"])
        self.init_repeats = int(self.settings["INIT_REPEATS"])
        self.pool = max(self.members * self.repeats, self.init_repeats)

    def scores(self, name):
        """{data set: entry} of the metrics file NAME.json."""
        metrics = json.loads((self.folder / f"{name}.json").read_text(encoding="utf-8"))
        return {entry["name"]: entry for entry in metrics["datasets"]}

    def fits(self, kind):
        """L_fit on Train-B of the networks trained `with` or `without` the initial-state network."""
        return np.array([self.scores(f"fit/{kind}-{k + 1}")["Train-B"]["L_fit"] for k in range(self.init_repeats)])

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

    def distances(self, folder, sampling):
        """{data set: {"eucl", "maha", "spread": (points,)}}, k >= 1; spread is the root of the trace of the particles' covariance."""
        found = {name: [] for name in SETS}
        with open(self.folder / folder / f"{sampling}.csv", newline="", encoding="utf-8") as stream:
            for row in csv.DictReader(stream):
                if row["step"] == "0":
                    continue
                sd = float(row["u_sd_mps"]), float(row["vm_sd_mps"]), np.radians(float(row["r_sd_degps"]))
                maha = float(row["maha"]) if row["maha"] else np.nan
                found[set_of(row["recording"])].append((float(row["eucl"]), maha, np.sqrt(np.sum(np.square(sd)))))
        return {name: dict(zip(("eucl", "maha", "spread"), np.array(rows).T)) for name, rows in found.items()}

    def sweep(self, members, trained_on="berthings"):
        """(gains K_P, gains K_D, {column: (K_D, K_P) scores}) of a sweep with the first members."""
        name = {"berthings": "sweep", "turns": "turns-sweep"}[trained_on]
        return read_sweep(self.folder / "pd" / f"{name}-{members}.csv")

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
    return next(name for name in SETS if recording.startswith(name.lower() + "-"))


def read_sweep(path):
    with open(path, newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    kp, kd = (np.unique([float(row[name]) for row in rows]) for name in ("kp_deg_per_rad", "kd_deg_per_radps"))
    tables = {name: np.full((len(kd), len(kp)), np.nan) for name in rows[0] if name.startswith("score_")}
    for row in rows:
        i, j = np.searchsorted(kd, float(row["kd_deg_per_radps"])), np.searchsorted(kp, float(row["kp_deg_per_rad"]))
        for name, table in tables.items():
            table[i, j] = float(row[name])
    return kp, kd, tables
