"""The judged cases of one folder: all that tables are made from, small enough to be kept when recordings and reports are not.

    judge(folder, ...) -> Part          of what generate, ladder, run and next left
    Part.keep(folder), read(file)       docs/proof-cases/COMMIT/shard-3-of-16.json.gz, the same bytes for the same part
"""

import gzip
import hashlib
import json
import pathlib
import zlib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass

import baselines
import blame
import campaign
import model
import physics
import replays
import scores
from tool import hash_of, kept, write, write_bytes

VERSION = 1  # of the file; another one is not read
ENDING = ".json.gz"


class Broken(ValueError):
    """A folder or file that is not what it should be."""


@dataclass
class Part:
    design: dict
    duration_s: float  # of each recording
    builds: list  # SHA-256 of the programs whose reports are there; None: of before they were noted
    waiting: int  # cases that were not run
    rows: list  # scores.judge of each case, with `improvement` and `baselines` where they were asked for
    ladder: list  # blame.read
    trials: list  # of next

    def keep(self, folder):
        """Writes the part into a folder, whole or not at all; returns the file."""
        of = self.design.get("shard")
        file = pathlib.Path(folder) / ((f"shard-{of.replace('/', '-of-')}" if of else self.design["set"]) + ENDING)
        file.parent.mkdir(parents=True, exist_ok=True)
        text = json.dumps({"version": VERSION, **asdict(self)}, separators=(",", ":"), sort_keys=True)
        write_bytes(file, gzip.compress(text.encode(), mtime=0))
        return file


def read(file):
    """A part that was kept. Broken where the file is none."""
    try:
        found = json.loads(gzip.decompress(file.read_bytes()))
        if found.pop("version") != VERSION:
            raise Broken(f"{file}: expected a part of version {VERSION}; judge its folder again with score --keep")
        return Part(**found)
    except (OSError, EOFError, KeyError, TypeError, AttributeError, zlib.error, UnicodeDecodeError, json.JSONDecodeError) as problem:
        raise Broken(f"{file}: expected judged cases as score --keep writes them: {problem}") from None


def judge(folder, tool=None, jobs=1, with_baselines=False):
    """The part of a folder; None where nothing was made there. tool: the programs of the free runs, None for no free runs. Broken where the seals are."""
    if not (folder / "keys.sha256").exists():
        return None
    if broken := campaign.broken_seals(folder / "keys"):
        raise Broken(f"{folder}: keys differ from what was sealed: {', '.join(broken[:5])}")
    keys, rows, builds, waiting = {}, [], set(), 0
    for file in sorted((folder / "keys").glob("*.json")):
        key = kept(file)
        result = folder / "results" / key["id"]
        run = kept(result / "run.json")
        if run is None:
            waiting += 1
            continue
        keys[key["id"]] = key
        builds.add(run.get("tool_sha256"))
        rows.append(scores.judge(key, run, kept(result / "report.json") if run["exit_code"] == 0 else None))
    if tool is not None:
        add_improvements(folder, keys, rows, tool, jobs)
    if with_baselines:
        baselines.add(folder, keys, rows)
    duration = keys[rows[0]["id"]]["duration_s"] if rows else 0.0
    return Part(kept(folder / "design.json"), duration, sorted(builds, key=str), waiting, rows, blame.read(folder), kept(folder / "next.json") or [])


def add_improvements(folder, keys, rows, tool, jobs):
    """Free runs of each case, from a cache that knows the ship file and the programs that run it."""
    simulator = hash_of([tool / "mmg-sim", tool / "gap-locate"])

    def one(row):
        key, result = keys[row["id"]], folder / "results" / row["id"]
        ship, mark = result / "ship.json", result / "improvement.json"
        state = hashlib.sha256(b"sealed recordings, fitted reference\0" + simulator.encode() + (ship.read_bytes() if ship.exists() else b"")).hexdigest()
        cached = kept(mark)
        if cached is None or cached["ship_sha256"] != state:
            scale = physics.scale(model.read_ship(key["ship"]))
            cached = {"ship_sha256": state, **replays.improvement(tool, folder / "cases" / row["id"], folder / "keys" / row["id"], key, ship, scale)}
            write(mark, cached)
        row["improvement"] = cached

    with ThreadPoolExecutor(jobs) as pool:
        list(pool.map(one, [r for r in rows if not r["failed"] and not set(r["truth"]) & set(physics.SENSORS) and r["family"] != "outside"]))
