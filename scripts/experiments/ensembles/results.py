"""Reads a folder of results of the Makefile here."""

import csv
import functools
import json
import pathlib

SETS = ("Test-B", "Test-R", "Test-ZT")
RUNGS = {"plain": "plain networks", "physics": "+ physics", "disturbances": "+ disturbances", "initial-error": "+ initial error: all"}
LAST = "initial-error"
GROUPS = {"model": SETS, "full": ("Test-Full-B", "Test-Full-B, unrecorded physics", "Test-R", "Test-ZT")}
KINDS = ("random", "zigzag", "turning", "berthing")
FORMS = {"quadratic-hull": "side force and yaw damping quadratic", "other-rudder": "rudders of `esso-osaka-3m`"}


class Results:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        text = (self.folder / "settings").read_text(encoding="utf-8")
        self.settings = dict(pair.split("=", 1) for pair in text.split() if "=" in pair)

    def count(self, name):
        return int(self.settings[name])

    def seeds(self):
        return range(1, self.count("SEEDS") + 1)

    @functools.cache
    def json(self, name):
        """A result, None where it is not there yet."""
        path = self.folder / name
        return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None

    def scores(self, name, overall=False):
        """{data set: entry} of a metrics file; overall: its entry over all. None where it is not there yet."""
        found = self.json(f"{name}.json")
        if found is None:
            return None
        return found["overall"] if overall else {entry["name"]: entry for entry in found["datasets"]}

    def over(self, folder, names):
        """[(scores, each member in turn, the base's own replay)] of those that have been computed."""
        found = [(self.scores(f"{folder}/{name}"), self.scores_in_turn(f"{folder}/{name}-in-turn"), self.scores(f"{folder}/{name}-replay")) for name in names]
        return [parts for parts in found if None not in parts]

    def scores_in_turn(self, name):
        found = self.json(f"{name}.json")
        return None if found is None else found["datasets"]

    def seconds(self, model, calibrated=True):
        """CPU time of a training that is finished, over all its runs, with what is done once all members are there, or without.
        None where it is not finished."""
        if not (self.folder / "models" / f"{model}.trained").exists():
            return None
        lines = (self.folder / "models" / f"{model}.seconds").read_text(encoding="utf-8").splitlines()
        return sum(float(line.split("\t")[0]) for line in lines if calibrated or "--member" in line.split())

    def seconds_of_member(self, model):
        """CPU time of a member that finds the base ship fitted: all but the first, in the mean. None where it is not finished."""
        if not (self.folder / "models" / f"{model}.trained").exists():
            return None
        lines = (self.folder / "models" / f"{model}.seconds").read_text(encoding="utf-8").splitlines()
        of_members = {}
        for line in lines:
            words = line.split()
            if "--member" in words:
                number = int(words[words.index("--member") + 1])
                of_members[number] = of_members.get(number, 0.0) + float(words[0])
        others = [seconds for number, seconds in of_members.items() if number > 0]
        return sum(others) / len(others)

    def epochs(self, config):
        return self.json(f"models/{config}.json")["epochs"]

    def sweep(self, kind, number):
        """[(score of the true ship, of the worst particle)] over the gains; None where it is not there yet."""
        path = self.folder / "controllers" / f"{kind}-{number:02}.csv"
        if not path.exists():
            return None
        with open(path, newline="", encoding="utf-8") as stream:
            return [(float(row["score_true"]), float(row["score_worst"])) for row in csv.DictReader(stream)]

    def recordings(self, name):
        """{data set: number of recordings} behind a metrics file of real recordings, which lie in folders by kind."""
        files = {entry["file"] for entry in self.json(f"{name}.json")["provenance"]["inputs"] if entry["file"].endswith(".csv")}
        counts = {}
        for file in files:
            kind = pathlib.Path(file).parent.name
            counts[kind] = counts.get(kind, 0) + 1
        return counts
