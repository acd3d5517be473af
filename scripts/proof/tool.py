"""Calls of the tool: kept where the inputs and the tool are those of before, with time, peak memory and exit code."""

import hashlib
import json
import pathlib
import signal
import subprocess
import threading
import time


def hash_of(files):
    total = hashlib.sha256()
    for f in files:
        total.update(f.name.encode() + b"\0" + f.read_bytes())
    return total.hexdigest()


# By these somebody else ends a call: it says nothing of the tool, and is made again.
ENDED_BY_OTHERS = {-signal.SIGHUP, -signal.SIGINT, -signal.SIGTERM, -signal.SIGKILL}


def kept(mark):
    """A record; None where there is none, or half of one."""
    try:
        return json.loads(mark.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None


def write_bytes(file, content):
    """Whole or not at all."""
    part = file.with_name(file.name + ".part")
    part.write_bytes(content)
    part.replace(file)


def write(file, value):
    """JSON, whole or not at all."""
    write_bytes(file, json.dumps(value, indent=1).encode())


def explain(binaries, ship, trains, held, result, limit_s, options=()):
    """The record of one call, and whether it is new. A call that fails or takes longer than limit_s is kept as well."""
    files = [pathlib.Path(ship)] if pathlib.Path(ship).exists() else []
    hashed = hash_of([*files, *trains, *held, binaries / "gap-explain"])
    mark = result / "run.json"
    before = kept(mark)
    if before and before["inputs_sha256"] == hashed and (before["exit_code"] != 0 or (result / "report.json").exists()):
        return before, False
    result.mkdir(parents=True, exist_ok=True)
    command = [str(binaries / "gap-explain"), "--ship", str(ship), *map(str, trains), *(["--holdout", *map(str, held)] if held else []), *options,
               "-o", str(result), "--quiet", "--jobs", "1"]
    start = time.monotonic()
    peak, said, is_late = 0, [], False
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    reader = threading.Thread(target=lambda: said.append(process.stderr.read()))
    reader.start()
    while process.poll() is None:
        try:
            status = pathlib.Path(f"/proc/{process.pid}/status").read_text(encoding="ascii")
            peak = max([peak] + [int(line.split()[1]) for line in status.split("\n") if line.startswith("VmHWM")])
        except (OSError, ValueError):
            pass
        if time.monotonic() - start > limit_s:
            is_late = True
            process.kill()
        time.sleep(0.1)
    reader.join()
    process.stderr.close()
    record = {"inputs_sha256": hashed, "tool_sha256": hash_of([binaries / "gap-explain"]), "exit_code": process.returncode,
              "wall_s": round(time.monotonic() - start, 2), "peak_kB": peak, "stderr": said[0][-2000:]}
    if is_late or process.returncode not in ENDED_BY_OTHERS:
        write(mark, record)
    return record, True
