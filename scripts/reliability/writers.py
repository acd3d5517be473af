"""Commands that write files, and what their outputs may look like after any fault."""

import hashlib
import json
import shutil

import workspace

# Name: the command line but for its seed, the option that changes its result, the index that comes last.
COMMANDS = {
    "data set": ("mmg-sim dataset spec.json -o out/d", "--seed 2", "d/dataset.json"),
    "replay": ("mmg-sim replay --ship vectwin-3m data/dataset.json --prediction --restart-steps 8 -o out/p", "--hold",
               "p/prediction.json"),
    "recording": ("mmg-sim random --ship vectwin-3m --duration-s 20 --noise noise.json --truth out/t.csv -o out/a.csv",
                  "--seed 2", "a.csv.provenance.json"),
    "model": ("ens-train data/dataset.json#train --config config.json --checkpoint-s 0 -o out/m", "--seed 2",
              "m/ensemble.json"),
    "prediction": ("ens-predict model data/dataset.json --steps 8 --particles 4 -o out/p", "--seed 2",
                   "p/prediction.json"),
    "metrics": ("eval-metrics pred --truth data/dataset.json --per-step out/s.csv -o out/m.json", "--sigma-u-mps 0.5",
                "m.json"),
    "sweep": ("pd-sweep model --ship vectwin-3m --kp 20:60:20 --kd 20 --particles 2 --duration-s 10 --trajectories "
              "out/runs -o out/s.csv", "--seed 2", "s.csv.provenance.json"),
    "locate": ("gap-locate --ship esso-osaka-3m esso.csv turn.csv -o out/g", "--false-alarm 0.2", "g/locate.json"),
    "explain": ("gap-explain --ship esso-osaka-3m esso.csv -o out/g", "--false-alarm 0.2", "g/report.json"),
}
REMAINS = (".tmp", ".unfinished", ".checkpoint", ".owner")  # of a run that was killed; the next one clears them up
INDEXES = ("dataset.json", "prediction.json", "locate.json", "report.json", "trajectories.json")


class Writer:
    """A command, the results of two undisturbed runs of it that differ, and the folder in which it meets faults."""

    def __init__(self, name, folder):
        line, more, self.index = COMMANDS[name]
        self.name, self.folder, self.out = name, folder, folder / "out"
        self.words = [*line.split(), "--jobs", "1", "--quiet"]
        self.other_words = [*self.words, *more.split()]
        self.other = self.undisturbed(self.other_words)
        self.whole = self.undisturbed(self.words)
        if self.other == self.whole:
            raise SystemExit(f"{name}: {more} changes nothing")

    def undisturbed(self, words):
        self.clear()
        done = workspace.run(words, self.folder)
        if done.returncode != 0:
            raise SystemExit(f"{words}: {done.stderr.decode()}")
        return workspace.files_of(self.out)

    def clear(self):
        shutil.rmtree(self.out, ignore_errors=True)
        self.out.mkdir()

    def earlier(self):
        """What may lie where the command writes: nothing, the same, or the result of other options, unless it refuses that."""
        return [{}, self.whole] if self.name == "model" else [{}, self.whole, self.other, self.other]

    def put(self, files):
        """Makes `files` what an earlier run has left."""
        self.clear()
        for name, text in files.items():
            (self.out / name).parent.mkdir(parents=True, exist_ok=True)
            (self.out / name).write_bytes(text)

    def problem(self):
        """What is torn or mixed in out/ now; nothing where nothing is."""
        return problem_of(workspace.files_of(self.out), self.index, self.whole, self.other)

    def problem_after_rerun(self):
        """The same of what the next run, undisturbed, leaves: the bytes of one in an empty folder."""
        unfinished = self.name == "model" and (self.out / self.index).exists()
        resume = unfinished and (self.out / self.index).read_bytes() == self.whole[self.index]
        if unfinished and not resume:  # another training, which is refused: to remove it is the way out
            self.clear()
        done = workspace.run([*self.words, *(["--resume"] if resume else [])], self.folder)
        if done.returncode != 0:
            return f"the next run ends with {done.returncode}: {done.stderr.decode()[-300:]}"
        now = workspace.files_of(self.out)
        if now != self.whole:
            differing = sorted(name for name in now.keys() | self.whole.keys() if now.get(name) != self.whole.get(name))
            return f"the next run leaves other bytes: {differing}"
        return ""


def problem_of(files, index, *generations):
    finished = {name: text for name, text in files.items() if not name.endswith(REMAINS)}
    for name, text in finished.items():
        if not any(generation.get(name) == text for generation in generations):
            return f"torn: {name} is that of no run"
    for generation in generations:
        if finished.get(index) != generation.get(index):
            continue
        if index == "m/ensemble.json":  # goes before its members
            mixed = [name for name, text in finished.items() if generation.get(name) != text]
        else:
            mixed = [name for name in finished.keys() | generation.keys() if finished.get(name) != generation.get(name)]
        if not mixed:
            return ""
    return f"mixed: {sorted(finished)}" if index in finished else ""


def problem_of_hashes(files):
    """Where two wrote at once: parts that are not those of their index, and no mark of it by which a reader refuses."""
    for name, text in files.items():
        folder, _, file = name.rpartition("/")
        if file not in INDEXES or name + ".unfinished" in files:
            continue
        for part, digest in json.loads(text).get("parts", {}).items():
            content = files.get(f"{folder}/{part}" if folder else part, b"")
            if hashlib.sha256(content).hexdigest() != digest:
                return f"{name}: {part} is of another run"
    return ""
