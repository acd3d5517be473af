"""Command lines of all tools, mutated together with the files that they name, and what must hold of each of them."""

import collections
import csv
import io
import json
import math
import os
import random
import re
import shutil
import subprocess

import workspace

# A word with '@' is a file that is read. Outputs lie in out/, which is emptied after each command line.
TEMPLATES = """
mmg-sim zigzag --ship @esso-osaka-3m.json --rudder-deg 10 --heading-deg 5 --duration-s 20 --noise @noise.json -o out/a.csv --truth out/t.csv
mmg-sim turning --ship @vectwin-3m.json --effect @effect.json --duration-s 20 --indices out/i.json -o out/a.csv
mmg-sim random --ship @vectwin-3m.json --wind-speed-mps 1 --wind-dir-deg 40 --wind stochastic --duration-s 20 -o -
mmg-sim berthing --ship vectwin-3m --dt-s 0.1 --sample-s 1 -o out/a.csv
mmg-sim pull-out --ship esso-osaka-3m --rudder-deg 20 --hold-s 5 --duration-s 30 -o out/a.csv
mmg-sim spiral --ship esso-osaka-3m --rudder-deg 10 --step-deg 5 --hold-s 5 --duration-s 40 -o out/a.csv
mmg-sim crash-stop --ship esso-osaka-3m --approach-s 5 --duration-s 30 -o out/a.csv
mmg-sim coast-down --ship @esso-osaka-3m.json --duration-s 30 -o out/a.csv
mmg-sim thruster-pulses --ship vectwin-3m --thruster bow --pulse-s 3 --rest-s 3 --pulses 2 -o out/a.csv
mmg-sim straight --ship esso-osaka-3m --u0-mps 0.5 --duration-s 20 -o out/a.csv
mmg-sim schedule @orders.csv --ship esso-osaka-3m --duration-s 20 -o out/a.csv
mmg-sim replay --ship @esso-osaka-3m.json @esso.csv --columns @columns.json --hold -o out/a.csv
mmg-sim replay --ship vectwin-3m @data/dataset.json --prediction --restart-steps 5 -o out/p
mmg-sim dataset @spec.json -o out/d
mmg-sim show @vectwin-3m.json
mmg-sim ships
mmg-sim effects tug
ens-train @data/dataset.json#train --config @config.json -o out/m
ens-train @data/dataset.json#train --config @config.json --base @vectwin-3m.json --member 1 -o out/m
ens-train --status @model
ens-predict @model @data/test/test-t20.csv --particles 4 --steps 8 --sampling ts1 -o out/p
ens-predict @model @data/dataset.json#test --particles 4 --steps 8 --use-members 1 -o -
ens-predict --baseline hold @esso.csv --columns @columns.json --steps 5 -o -
eval-metrics @pred --truth @data/dataset.json --per-step out/s.csv -o out/m.json
eval-metrics @pred/test-t20.csv --truth @data/test/test-t20.csv -o -
pd-sweep @model --ship @vectwin-3m.json --kp 20:60:20 --kd 20,40 --particles 2 --duration-s 10 --trajectories out/runs -o out/s.csv
gap-locate --ship @esso-osaka-3m.json @esso.csv @turn.csv -o out/g
gap-locate --model @model @data/dataset.json#train --write-corrected out/c -o out/g
gap-explain --ship @esso-osaka-3m.json @esso.csv --holdout @turn.csv -o out/g
leeway-bench sim --repeats 1 --kernel none
"""
SHARE = {"gap-explain": 0.15, "leeway-bench": 0.05, "gap-locate": 0.5}  # of the share of others, which are faster
VALUES = ["0", "-1", "nan", "inf", "-inf", "1e-300", "1e300", "", "abc", "1e5x", "0x10", "3", "7", "0.5", "-0.0", "--",
          "-", "é", "x" * 5000, "1:2:0.5", "5:1:1", "1,2,,3", "18446744073709551616", "a\nb", "%s%n", "../x", "1 2"]
NAMES = ["esso.csv", "data", "no-such-file", "config.json", "model", "/dev/null", "-", "data/dataset.json#none",
         "out/none.json", ".", "model/ensemble.json", "/proc/self/mem", "x" * 300]
BYTES = [b"\0", b"\xff", b'"', b",", b"\n", b"\r", b"{", b"]", b"nan", b"1e999", b"-", b"", b"1e300", b"\xef\xbb\xbf"]
EXTREMES = [0, -1, 1e300, -1e300, 5e-324, None, True, "", "nan", [], {}, [[]], 0.5, 2**63, "../x"]
OUTPUTS = {"-o", "--output", "--truth", "--indices", "--per-step", "--trajectories", "--write-corrected"}
LIMITS = {"exit codes": (0, 1, 2, 3, 4), "seconds": 120, "bytes of a message": 2500}


def pick_template(rng):
    lines = TEMPLATES.strip().splitlines()
    return rng.choices(lines, [SHARE.get(line.split()[0], 1.0) for line in lines])[0].split()


def options_of(tool):
    """Options that a tool and its subcommands name in their help."""
    text = workspace.run([tool, "--help"], workspace.ROOT).stdout.decode()
    subcommands = re.findall(r"^  ([a-z-]+) {2,}", text.partition("Subcommands:")[2], re.M)
    texts = [text] + [workspace.run([tool, name, "--help"], workspace.ROOT).stdout.decode() for name in subcommands]
    return sorted({option for some in texts for option in re.findall(r"(?<![\w-])--[a-z][a-z0-9-]+", some)} - {"--help"})


def mutate_words(words, options, rng):
    """Words with one mutation: of a value, a name, or what stands where."""
    if len(words) == 1:
        return [*words, rng.choice(options)]
    words, place = list(words), rng.randrange(1, len(words))
    kind = rng.randrange(6)
    if kind <= 1:
        words[place] = rng.choice(VALUES)
    elif kind == 2:
        words[place] = rng.choice(NAMES)
    elif kind == 3:
        del words[place]
    elif kind == 4:
        words[place:place] = [rng.choice(options)] + ([rng.choice(VALUES)] if rng.random() < 0.7 else [])
    else:
        words.insert(place, words[rng.randrange(1, len(words))])
    return words


def mutate_json(text, rng):
    """A value somewhere in it becomes another one, goes, or gets a neighbor that nobody knows."""
    top = json.loads(text)
    spot = top
    while True:
        keys = list(spot) if isinstance(spot, dict) else list(range(len(spot)))
        if not keys:
            return text
        key = rng.choice(keys)
        if isinstance(spot[key], (dict, list)) and spot[key] and rng.random() < 0.8:
            spot = spot[key]
            continue
        kind = rng.randrange(5)
        if kind == 0:
            del spot[key]
        elif kind == 1 and isinstance(spot, dict):
            spot["no such key"] = 1
        elif kind == 2 and isinstance(spot[key], (int, float)):
            spot[key] = spot[key] * rng.choice([0.5, -1, 1.01, 3])
        else:
            spot[key] = rng.choice(EXTREMES)
        return json.dumps(top).encode()


def mutate_csv(text, rng):
    rows = [line.split(b",") for line in text.split(b"\n")]
    row = rng.choice(rows)
    kind = rng.randrange(4)
    if kind == 0:
        row[rng.randrange(len(row))] = rng.choice([b"", b"nan", b"1e300", b"-1e12", b"0", b"abc", b'"1"', b' 2 ', b"1e-320"])
    elif kind == 1:
        row.append(b"1")
    elif kind == 2:
        rows.insert(rng.randrange(len(rows)), row)
    else:
        rows.remove(row)
    return b"\n".join(b",".join(r) for r in rows)


def mutate_bytes(text, rng):
    place = rng.randrange(len(text) + 1)
    kind = rng.randrange(3)
    if kind == 0:
        return text[:place]
    piece = rng.choice(BYTES)
    return text[:place] + piece + text[place + (len(piece) if kind == 1 else 0):]


def mutate_file(name, text, rng):
    if rng.random() < 0.3 or not text:
        return mutate_bytes(text, rng)
    return mutate_json(text, rng) if name.endswith(".json") else mutate_csv(text, rng)


def is_broken(name, text):
    """Whether any reader must refuse it: no JSON, or a row with another number of fields than the header."""
    if name.endswith(".json"):
        try:
            json.loads(text.decode("utf-8-sig"))
            return False
        except (ValueError, RecursionError):
            return True
    if any(mark in text for mark in (b'"', b"\r", b"#", b"\0")):
        return False
    widths = [line.count(b",") for line in text.split(b"\n") if line]
    return not widths or any(width != widths[0] for width in widths)


def problem_of_result(name, text):
    """What is wrong with a file that a tool wrote with exit code 0; nothing where nothing is."""
    if text[:1] in (b"{", b"["):
        try:
            json.loads(text, parse_constant=lambda word: 1 / 0)
        except (ValueError, ZeroDivisionError) as error:
            return f"{name}: no JSON: {error}"
    elif name.endswith((".csv", ".json")):
        rows = list(csv.reader(io.StringIO(text.decode())))
        if not text.endswith(b"\n") or len(rows) < 2 or any(len(row) != len(rows[0]) for row in rows):
            return f"{name}: not a whole CSV file"
        for field in (field for row in rows[1:] for field in row):
            if re.fullmatch(r"[-+]?(nan|inf|\d[\d.e+-]*)", field) and not math.isfinite(float(field)):
                return f"{name}: '{field}'"
    return ""


class Campaign:
    """Runs mutated command lines over a workspace and counts how they end."""

    def __init__(self, folder, seed):
        self.folder, self.rng = folder, random.Random(seed)
        workspace.prepare(folder)
        (folder / "out").mkdir()
        self.before = workspace.files_of(folder)
        self.stamps = self.stamps_now()
        self.options = {tool: options_of(tool) for tool in {line.split()[0] for line in TEMPLATES.strip().splitlines()}}
        self.counts, self.failures = collections.Counter(), []

    def stamps_now(self):
        """Size, time and number of every file but those in out/, by its name."""
        stamps = {}
        for folder, folders, files in os.walk(self.folder):
            prefix = os.path.relpath(folder, self.folder) + "/"
            if prefix == "./":
                folders.remove("out")
                prefix = ""
            for name in files:
                status = os.lstat(f"{folder}/{name}")
                stamps[prefix + name] = (status.st_size, status.st_mtime_ns, status.st_ino)
        return stamps

    def step(self):
        """One command line."""
        template, rng = pick_template(self.rng), self.rng
        words = [word.removeprefix("@") for word in template]
        inputs = [word[1:].split("#")[0] for word in template if word.startswith("@")]
        named = [name for word in inputs for name in self.before if name == word or name.startswith(word + "/")]
        mutated = None
        if named and rng.random() < 0.6:
            mutated = rng.choice(named)
            (self.folder / mutated).write_bytes(mutate_file(mutated, self.before[mutated], rng))
            self.stamps = self.stamps_now()
        for _ in range(rng.choice([0, 0, 1, 1, 2]) if mutated else rng.choice([0, 1, 1, 2, 3])):
            words = mutate_words(words, self.options[words[0]], rng)
        words += [] if "--jobs" in words else ["--jobs", "1"]
        words = [word.replace("\0", "") for word in words]
        self.last = words
        kind, problem = self.run(words, mutated if mutated in inputs else None)
        self.counts["tried"] += 1
        if kind:
            self.counts[kind] += 1
            self.keep(kind, problem, words, mutated)
        self.restore(mutated)

    def run(self, words, mutated):
        """(kind of failure, what is wrong); ("", "") where all is as it should be."""
        try:
            done = workspace.run(words, self.folder, LIMITS["seconds"])
        except subprocess.TimeoutExpired:
            return "hang", f"not done after {LIMITS['seconds']} s"
        code, err = done.returncode, done.stderr.decode(errors="replace")
        self.counts[f"exit code {code}"] += 1
        if code not in LIMITS["exit codes"]:
            return "crash", f"exit code {code}: {err[-500:]}"
        now = self.stamps_now()
        changed = {name for name in now.keys() | self.stamps.keys() if now.get(name) != self.stamps.get(name)}
        if changed & self.inputs_of(words):
            return "misread", f"an input was changed: {sorted(changed & self.inputs_of(words))}"
        outputs = workspace.files_of(self.folder / "out")
        if any(name.endswith((".tmp", ".unfinished")) for name in [*outputs, *changed]):
            return "misread", f"left behind: {sorted([*outputs, *changed])}"
        if code != 0:
            lines = err.splitlines()
            if not lines or not lines[-1].startswith(f"{words[0]}: error: ") or len(lines[-1].encode()) > LIMITS["bytes of a message"]:
                return "misread", f"exit code {code} with the message: {err[-500:]}"
            # A training keeps the members that are done; gap-explain says by its exit code what it found.
            if done.stdout or (outputs and words[0] != "ens-train" and "--fail-on-mismatch" not in words):
                return "misread", f"exit code {code}, and results: {sorted(outputs)} {done.stdout[:100]}"
            return "", ""
        problems = [problem_of_result(name, text) for name, text in outputs.items()]
        if any(problems):
            return "misread", "; ".join(filter(None, problems))
        text = (self.folder / mutated).read_bytes() if mutated else b""
        if mutated and any(word.split("#")[0] == mutated for word in words) and is_broken(mutated, text):
            if not {"--help", "--version"} & set(words):
                return "misread", f"{mutated} is broken, and accepted"
        return "", ""

    def inputs_of(self, words):
        """Names of all files that the words name or whose folders they name, but as outputs."""
        outputs = OUTPUTS - ({"--truth"} if words[0] == "eval-metrics" else set())
        names = {word.split("#")[0].rstrip("/") for before, word in zip(words, words[1:]) if before not in outputs}
        return {name for name in self.before for word in names if name == word or name.startswith(word + "/")}

    def keep(self, kind, problem, words, mutated):
        self.failures.append({"kind": kind, "problem": problem, "words": words, "file": mutated,
                              "text": (self.folder / mutated).read_bytes().decode("latin-1") if mutated else None})

    def restore(self, mutated):
        shutil.rmtree(self.folder / "out", ignore_errors=True)
        (self.folder / "out").mkdir(exist_ok=True)
        now = workspace.files_of(self.folder, but=("out",)) if self.stamps_now() != self.stamps else None
        changed = [mutated] if mutated else []
        if now is not None:
            changed += [name for name, text in self.before.items() if now.get(name) != text]
            for name in now.keys() - self.before.keys():
                (self.folder / name).unlink()
        for name in changed:
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            (self.folder / name).write_bytes(self.before[name])
        self.stamps = self.stamps_now()
