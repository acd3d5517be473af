#!/usr/bin/python3
"""Tests scripts/members.mk and the documented command for GNU parallel: the bytes of one process, also after a kill."""

import filecmp
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("LEEWAY_BIN", ROOT / "build" / "release" / "bin"))
CONFIG = '{"hidden_units": 8, "steps": 20, "initial_state_steps": 5, "batch_size": 4, "learning_rate": 1e-3, "epochs": %d}'
TRAIN = "--quiet --config {}.json data/dataset.json#Train --checkpoint-s 0.1"


class MembersTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="leeway-members-")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.work = pathlib.Path(cls.temporary.name)
        os.environ["PATH"] = f"{BIN}:{os.environ['PATH']}"
        cls.run_here("mmg-sim", "dataset", "demo", "-o", "data", "--quiet")
        for name, epochs in (("short", 3), ("long", 150)):
            (cls.work / f"{name}.json").write_text(CONFIG % epochs)
            cls.run_here("ens-train", *TRAIN.format(name).split(), "--members", "3", "-o", f"whole-{name}")

    @classmethod
    def run_here(cls, *command):
        subprocess.run(command, cwd=cls.work, check=True, stdout=subprocess.DEVNULL)

    @staticmethod
    def make(name, model):
        return ["make", "-j", "2", "-f", str(ROOT / "scripts/members.mk"), "MEMBERS=3", f"MODEL={model}",
                f"TRAIN={TRAIN.format(name)}"]

    def check_same(self, name, model):
        whole, other = self.work / f"whole-{name}", self.work / model
        names = sorted(f.name for f in whole.iterdir())
        self.assertEqual(names, sorted(f.name for f in other.iterdir()))
        self.assertEqual(filecmp.cmpfiles(whole, other, names, shallow=False)[0], names)

    def test_make_trains_each_member_in_a_process_of_its_own(self):
        self.run_here(*self.make("short", "made"))
        self.check_same("short", "made")

    def test_make_goes_on_after_an_interruption(self):
        process = subprocess.Popen(self.make("long", "interrupted"), cwd=self.work, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL, start_new_session=True,
                                   preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        while not list(self.work.glob("interrupted/*.checkpoint")):
            self.assertIsNone(process.poll(), "done before it could be interrupted")
            time.sleep(0.01)
        os.killpg(process.pid, signal.SIGINT)  # as Ctrl-C on a terminal
        self.assertNotEqual(process.wait(), 0)
        self.assertFalse(list(self.work.glob("interrupted/*.owner")))
        self.run_here(*self.make("long", "interrupted"))
        self.check_same("long", "interrupted")

    @unittest.skipIf(shutil.which("parallel") is None, "GNU parallel is not installed")
    def test_parallel_trains_each_member_in_a_process_of_its_own(self):
        command = f"seq 0 2 | parallel -j 2 ens-train {TRAIN.format('short')} --members 3 -o parallel" \
                  " --member {} --jobs 1 --resume"
        self.run_here("bash", "-c", command)
        self.check_same("short", "parallel")


if __name__ == "__main__":
    unittest.main()
