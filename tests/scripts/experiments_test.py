#!/usr/bin/python3
"""Runs the experiments of the ensemble paper with the tools, from the data sets to the claims, on shorter data and with smaller
networks than size `quick`: every claim and every model of docs/paper.md must come out of it. What it finds of claims says nothing."""

import json
import math
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAPER = ROOT / "scripts" / "experiments" / "paper"
BIN = pathlib.Path(os.environ.get("LEEWAY_BIN", ROOT / "build" / "release" / "bin"))
SETTINGS = {"SIZE": "quick", "UNITS": "8", "EPOCHS": "4", "MEMBERS": "5", "REPEATS": "2", "INIT_REPEATS": "2", "PARTICLES": "10", "GAINS": "30:60:30"}
TESTS = ("Test-B", "Test-ZT", "Test-R")


def shortened(name, keep):
    """The shipped specification with the sets in `keep`, whose runs are changed by them."""
    spec = json.loads((ROOT / "configs" / "datasets" / f"{name}.json").read_text(encoding="utf-8"))
    spec["sets"] = [{**data, "runs": [keep[data["name"]](run) for run in data["runs"]]} for data in spec["sets"] if data["name"] in keep]
    return spec


def of_page(text):
    """A claim's words, whatever number of members they name."""
    return re.sub(r"(M = |worst of |that of )\d+", r"\1M", text)


def rows_of(lines):
    """The cells of a table, without its head."""
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")][1:]


def rows_of_page(name):
    page = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    return rows_of(page.split(f"<!-- {name}: begin -->")[1].split(f"<!-- {name}: end -->")[0].splitlines())


def models_of(rows):
    return [of_page(row[0]) for row in rows if row[0]]


class ExperimentsTest(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="leeway-experiments-")
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def write_specifications(self):
        full = shortened("paper-full-scale", {
            "Train-Full-B": lambda run: {**run, "count": 3, "total_duration_s": 2998},
            "Test-Full-B": lambda run: {**run, "count": 2, "total_duration_s": 2001,
                                        "unrecorded": [{**run["unrecorded"][0], "run": 2}]}})
        (self.folder / "full.json").write_text(json.dumps(full), encoding="utf-8")
        replay = lambda run: {**run, "of": str(self.folder / "full.json")}  # noqa: E731
        model = shortened("paper-model-scale", {
            "Train-B": replay, "Test-B": replay, "Test-ZT": lambda run: {**run, "rudder_deg": [10]}, "Test-R": lambda run: {**run, "count": 2}})
        (self.folder / "model.json").write_text(json.dumps(model), encoding="utf-8")

    def make(self, *arguments):
        settings = {**SETTINGS, "DATA": self.folder / "model.json", "FULL_DATA": self.folder / "full.json", "BIN": BIN, "OUT": self.folder / "out"}
        return subprocess.run(["make", "-s", "-C", PAPER, *arguments, *(f"{name}={value}" for name, value in settings.items())], text=True,
                              capture_output=True, check=False)

    def test_every_claim_of_the_page_is_computed(self):
        self.write_specifications()
        claims_file = self.folder / "out" / "claims.json"
        made = self.make(str(claims_file))
        self.assertEqual(made.returncode, 0, made.stderr)
        saved = json.loads(claims_file.read_text(encoding="utf-8"))

        rows = rows_of_page("claims")
        self.assertGreater(len(rows), 40)
        self.assertEqual([(claim["section"], of_page(claim["says"])) for claim in saved["claims"]], [(row[0], of_page(row[1])) for row in rows])

        compared = [models_of(table) for table in (rows_of(saved["comparison"]), rows_of_page("comparison"))]
        self.assertEqual(compared[0], compared[1][:len(compared[0])])
        self.assertEqual(len(compared[0]), 8)

        # What the numbers come from has the networks, the members and the sets that were asked for.
        members = json.loads((self.folder / "out/models/pool/ensemble.json").read_text(encoding="utf-8"))["members"]
        self.assertEqual(len(members), 10)
        for kind in ("ts-inf", "ts1"):
            scores = {entry["name"]: entry for entry in json.loads((self.folder / f"out/sampling/{kind}-5-1.json").read_text(encoding="utf-8"))["datasets"]}
            self.assertEqual(set(scores), set(TESTS))
            for data in TESTS:
                self.assertTrue(math.isfinite(scores[data]["L_eucl"]), data)
                self.assertGreater(scores[data]["L_maha"], 0.0)
        self.assertEqual(saved["states"], {"model scale": {"initial_state": "truth", "against": "truth"},
                                           "full scale": {"initial_state": "observations", "against": "observations"}})
        # The true ship, replayed, is better than one of wrong coefficients and than no model: the scores are of the right files.
        errors = {}
        for model in ("hold", "start", "fitted", "linear", "residual", "true"):
            scores = json.loads((self.folder / f"out/comparison/{model}-scores.json").read_text(encoding="utf-8"))["datasets"]
            errors[model] = {entry["name"]: entry["L_eucl"] for entry in scores}
        for data in TESTS:
            self.assertLess(errors["true"][data], errors["start"][data])
            self.assertLess(errors["true"][data], errors["hold"][data])

        again = self.make("--question", str(claims_file))
        self.assertEqual(again.returncode, 0, "made once, nothing is made again")

    def write(self, name, content):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")

    def test_schedules_of_as_many_members_stand_together(self):
        for run, trained, seconds in (("model-scale-1", 2, "600.0\tens-train\n1200.0\tens-train\n"), ("model-scale-40-1", 4, "100.0\tens-train\n"),
                                    ("fast-1", 5, "150.0\tens-train\n")):
            self.write(f"{run}/model/ensemble.json", {"members": [f"member-{k:02}.json" for k in range(trained)],
                                                      "training": {"config": {"epochs": 10 * trained}}})
            self.write(f"{run}/seconds", seconds)
        files = []
        for name, maha in (("fast-1.5", 12.4), ("fast-1.2", None), ("model-scale-40-1.4", 12.4), ("model-scale-1.2", None)):
            scores = [{"name": data, "L_eucl": 1e-4, "L_maha": maha, "coverage": {"90": None if maha is None else 0.25}} for data in TESTS]
            self.write(f"{name}.json", {"datasets": scores})
            self.write(f"{name}.fitted.json", {"datasets": [{"name": "Train-B", "L_fit": 0.5}]})
            files.append(self.folder / f"{name}.json")
        table = subprocess.run([PAPER.parent / "schedules" / "table", "--print", *files], text=True, capture_output=True, check=True).stdout
        rows = rows_of(table.splitlines())
        self.assertEqual([row[:6] for row in rows], [["`model-scale`", "1", "2", "20", "900", "0.50"], ["`fast`", "1", "first 2 of 5", "50", "30", "0.50"],
                                                     ["`model-scale`", "1", "4", "40", "25", "0.50"], ["`fast`", "1", "5", "50", "30", "0.50"]])
        self.assertEqual([row[6:9] for row in rows], 2 * [["1.00e-04", "", ""]] + 2 * [["1.00e-04", "12", "25"]])


if __name__ == "__main__":
    unittest.main()
