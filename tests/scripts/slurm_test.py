#!/usr/bin/python3
"""Tests scripts/slurm against a real Slurm: munged, slurmctld and slurmd of this machine, on the loopback interface, in a
folder of their own. Ends with 77, and says why, where Slurm is not installed or does not start here."""

import filecmp
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("LEEWAY_BIN", ROOT / "build" / "release" / "bin"))
SKIPPED = 77
MEMBERS = 4

# Two processors, whatever the machine has; no cgroups, no accounting, no mail.
CONFIGURATION = """
ClusterName=leeway
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
MailProg=/bin/true
SlurmdParameters=config_overrides
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=bf_interval=1,sched_min_interval=1
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
KillWait=10
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=low Nodes={host} PriorityTier=1 Default=YES PreemptMode=REQUEUE
PartitionName=high Nodes={host} PriorityTier=10 PreemptMode=OFF
"""


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for s in sockets:
        s.bind(("127.0.0.1", 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


def output_of(*command, **options):
    return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, **options).stdout.strip()


def wait_until(condition, timeout_s, what):
    end = time.monotonic() + timeout_s
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError(f"no {what} within {timeout_s} s")
        time.sleep(0.1)


class Slurm:
    """A cluster of this machine alone."""

    def __init__(self, folder):
        self.folder = folder
        self.processes = []

    def start(self):
        folder = self.folder
        os.environ["PATH"] += ":/usr/sbin:/sbin"
        missing = [p for p in ("munged", "slurmctld", "slurmd", "sbatch", "scontrol") if shutil.which(p) is None]
        if missing:
            raise FileNotFoundError(f"not installed: {', '.join(missing)}")
        for name in ("state", "spool"):
            (folder / name).mkdir()
        key = folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)
        configuration = folder / "slurm.conf"
        configuration.write_text(
            CONFIGURATION.format(
                host=socket.gethostname().split(".")[0],
                user=output_of("id", "-un"),
                folder=folder,
                ports=free_ports(2),
            )
        )
        os.environ["SLURM_CONF"] = str(configuration)
        files = [f"--{name}-file={folder}/munge.{name}" for name in ("key", "pid", "seed", "log")]
        self.run("munged", "--foreground", "--force", f"--socket={folder}/munge.socket", *files)
        wait_until((folder / "munge.socket").exists, 10, "socket of munged")
        self.run("slurmctld", "-D", "-f", str(configuration))
        self.run("slurmd", "-D", "-f", str(configuration))
        wait_until(self.is_idle, 30, "idle node")

    def run(self, *command):
        with open(self.folder / f"{command[0]}.out", "w") as log:
            self.processes.append(
                subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT)
            )

    def is_idle(self):
        for process in self.processes:
            if process.poll() is not None:
                raise ChildProcessError(f"{process.args[0]} ended with {process.returncode}")
        answer = subprocess.run(["sinfo", "-h", "-o", "%t"], capture_output=True, text=True)
        return set(answer.stdout.split()) == {"idle"}

    def stop(self):
        if len(self.processes) == 3:
            subprocess.run(["scancel", "--user", output_of("id", "-un")], capture_output=True)
            try:
                wait_until(lambda: not self.jobs(), 30, "end of the jobs")
            except (TimeoutError, subprocess.CalledProcessError):
                pass
        for process in reversed(self.processes):
            process.terminate()
        for process in self.processes:
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def log(self):
        texts = []
        for name in ("munged.out", "munge.log", "slurmctld.log", "slurmctld.out", "slurmd.log", "slurmd.out"):
            path = self.folder / name
            if path.exists():
                texts += [f"{name}: {line}" for line in path.read_text(errors="replace").splitlines()[-12:]]
        return "\n".join(texts)

    @staticmethod
    def jobs(state=None):
        """Names of the jobs in the queue, as '12_3' and '15'."""
        states = ["-t", state] if state else []
        return output_of("squeue", "-h", "-r", "-o", "%i", *states).split()

    @staticmethod
    def field(job, name):
        return re.search(rf"\b{name}=(\S+)", output_of("scontrol", "show", "job", job))[1]


class SlurmTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.work = slurm.folder / "work"
        cls.work.mkdir()
        os.environ["PATH"] = f"{BIN}:{os.environ['PATH']}"
        cls.run_here("mmg-sim", "dataset", "demo", "-o", "data", "--quiet")
        config = '{"hidden_units": 16, "steps": 50, "batch_size": 4, "learning_rate": 1e-3, "epochs": %d}'
        (cls.work / "short.json").write_text(config % 2)
        start = time.monotonic()
        cls.run_here(*cls.train("short"), "--members", "1", "--jobs", "1", "-o", "probe", "--epochs", "50")
        seconds_per_epoch = (time.monotonic() - start) / 50
        # Long enough to be met in the middle: some five seconds for each member.
        (cls.work / "long.json").write_text(config % max(50, round(5 / seconds_per_epoch)))
        for name in ("short", "long"):
            cls.run_here(*cls.train(name), "--members", str(MEMBERS), "-o", f"whole-{name}")

    @classmethod
    def run_here(cls, *command):
        return output_of(*command, cwd=cls.work)

    @staticmethod
    def train(name):
        return ["ens-train", "--quiet", "--config", f"{name}.json", "data/dataset.json#Train", "--checkpoint-s", "1"]

    def submit(self, name, model):
        """Numbers of the array and of the closing job."""
        last = self.run_here(ROOT / "scripts/slurm/train", str(MEMBERS), "--partition=low", "--output=%j.out", "--",
                             *self.train(name)[1:], "-o", model)
        first = re.search(r"afterany:(\d+)", output_of("scontrol", "show", "job", last))[1]
        return first, last

    def check_same(self, name, model, last):
        wait_until(self.all_done, 240, f"end of the jobs of {model}")
        said = "\n".join(f"{f.name}: {f.read_text(errors='replace')}" for f in sorted(self.work.glob("*.out")))
        self.assertEqual(slurm.field(last, "JobState"), "COMPLETED", said)
        whole, other = self.work / f"whole-{name}", self.work / model
        names = sorted(f.name for f in whole.iterdir())
        self.assertEqual(names, sorted(f.name for f in other.iterdir()), said)
        self.assertEqual(filecmp.cmpfiles(whole, other, names, shallow=False)[0], names)

    @staticmethod
    def all_done():
        # Slurm lets a requeued job wait for two minutes; a test need not.
        for job in slurm.jobs("PENDING"):
            if slurm.field(job, "Reason") == "BeginTime":
                subprocess.run(["scontrol", "update", f"jobid={job}", "StartTime=now"], capture_output=True)
        return not slurm.jobs()

    def wait_for_checkpoint(self, model, member):
        path = self.work / model / f"member-{member:02}.checkpoint"
        wait_until(path.exists, 60, f"checkpoint of member {member}")

    def test_an_array_of_jobs_gives_the_bytes_of_one_process(self):
        _, last = self.submit("short", "array")
        self.check_same("short", "array", last)

    def test_a_preempted_member_is_requeued_and_goes_on(self):
        first, last = self.submit("long", "preempted")
        self.wait_for_checkpoint("preempted", 0)
        self.run_here("sbatch", "--partition=high", "--output=/dev/null", "--ntasks=2", "--wait", "--wrap", "sleep 1")
        tasks = [f"{first}_{k}" for k in range(MEMBERS)]
        wait_until(lambda: any(slurm.field(task, "Restarts") != "0" for task in tasks), 30, "requeued job")
        self.assertIn("member-00.checkpoint", os.listdir(self.work / "preempted"))
        self.check_same("long", "preempted", last)

    def test_before_its_time_limit_a_member_requeues_itself(self):
        first, last = self.submit("long", "limited")
        self.wait_for_checkpoint("limited", 1)
        job = f"{first}_1"
        # What --signal=B:TERM@120 sends in its time, to the shell of the job alone.
        processes = output_of("scontrol", "listpids", slurm.field(job, "JobId")).splitlines()[1:]
        shells = [int(line.split()[0]) for line in processes]
        shells = [p for p in shells if b"slurm_script" in pathlib.Path(f"/proc/{p}/cmdline").read_bytes()]
        self.assertTrue(shells, processes)
        os.kill(shells[0], signal.SIGTERM)
        wait_until(lambda: slurm.field(job, "Restarts") == "1", 30, "requeued job")
        self.assertIn("member-01.checkpoint", os.listdir(self.work / "limited"))
        self.check_same("long", "limited", last)

    def test_a_cancelled_member_stays_so_and_the_closing_job_trains_it(self):
        first, last = self.submit("long", "cancelled")
        job = f"{first}_1"
        self.wait_for_checkpoint("cancelled", 1)
        self.run_here("scancel", job)
        wait_until(lambda: slurm.field(job, "JobState") == "CANCELLED", 30, "cancelled job")
        self.check_same("long", "cancelled", last)
        self.assertEqual(slurm.field(job, "JobState"), "CANCELLED")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="leeway-slurm-") as temporary:
        slurm = Slurm(pathlib.Path(temporary))
        try:
            slurm.start()
        except (OSError, TimeoutError, subprocess.SubprocessError) as problem:
            print(f"SKIPPED: no Slurm here: {problem}\n{slurm.log()}", file=sys.stderr)
            slurm.stop()
            sys.exit(SKIPPED)
        try:
            program = unittest.main(exit=False, verbosity=2)
            if not program.result.wasSuccessful():
                print(slurm.log(), file=sys.stderr)
        finally:
            slurm.stop()
        sys.exit(0 if program.result.wasSuccessful() else 1)
