"""What somebody gains who knows what is missing: the likelihood of the recordings by gap-locate, which fits the coefficients, with the true effects
in the ship file in the tool's own formulas, over that with the ship as it is. d' of separability.py is what could be seen if all that hides an
effect were random; this is what can be."""

import json
import math
import subprocess
import tempfile
from pathlib import Path

import replays
import tool

STRENGTHS = (0.7, 1.0, 1.4)  # of the true one: the truth has other formulas


def log_likelihood(binaries, ship, recordings):
    """ln p(recordings | ship), coefficients fitted; None where the tool refuses the ship file."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "ship.json"
        file.write_text(json.dumps(ship), encoding="utf-8")
        command = [str(binaries / "gap-locate"), "--ship", str(file), *map(str, recordings), "-o", folder, "--quiet", "--jobs", "1"]
        if subprocess.run(command, capture_output=True, check=False).returncode:
            return None
        return json.loads((Path(folder) / "locate.json").read_text(encoding="utf-8"))["null_fit"]["log_likelihood"]


def gain(binaries, case, key, result):
    """Nats, at the best of STRENGTHS; None for what the ship file cannot say, as faults of sensors. Kept beside the result."""
    mark, hashed = result / "oracle.json", tool.hash_of([binaries / "gap-locate"])
    if mark.exists() and (kept := json.loads(mark.read_text(encoding="utf-8")))["tool_sha256"] == hashed:
        return kept["gain_nats"]
    ship, recordings = json.loads((case / "ship.json").read_text(encoding="utf-8")), sorted(case.glob("train-*.csv"))
    ships = [replays.with_effects(ship, key["truth"], strength) for strength in STRENGTHS]
    found = None
    if key["truth"] and None not in ships:
        without = log_likelihood(binaries, ship, recordings)
        values = [v for v in (log_likelihood(binaries, s, recordings) for s in ships) if v is not None]
        found = max(values) - without if values and without is not None else None
    mark.write_text(json.dumps({"tool_sha256": hashed, "gain_nats": found}), encoding="utf-8")
    return found


def d_prime(nats):
    """The distance of two hypotheses whose likelihoods differ by so much; None where that is not known."""
    return None if nats is None else math.sqrt(2.0 * max(nats, 0.0))
