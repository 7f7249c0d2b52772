"""`eigentrail track` as a contender."""

import json
import os
import subprocess
import time
from pathlib import Path

import numpy as np

import problem


def measure(job: dict) -> dict:
    """Runs the whole sequence once.

    `track` reports the wall time of each update without reading and cutting prefixes. Its CPU time is that times the
    share of the CPU which the process had over its life: 1 on a machine with nothing else to do. Its peak memory
    counts from that of this small process, some 60 MB.
    """
    vectors = Path(job["file"]).with_suffix(f".{os.getpid()}.npy")
    command = [job["binary"], "track", job["file"], "--k", job["k"], "--growth", job["growth"], "--tol", job["tau"]]
    command += ["--from", job["sizes"][0], "--threads", job["threads"], "--vectors", vectors, "--json", *job["flags"]]
    environment = dict(os.environ, RAYON_NUM_THREADS=str(job["threads"]))
    began = time.perf_counter()
    process = subprocess.Popen([str(c) for c in command], stdout=subprocess.PIPE, env=environment)
    report = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - began
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        return dict(failed=f"exit code {process.returncode}")
    cpu = usage.ru_utime + usage.ru_stime
    share = min(cpu / wall, 1.0) if job["threads"] == 1 else 1.0
    updates = [dict(update, wall=update["seconds"], cpu=update["seconds"] * share) for update in json.loads(report)["updates"]]
    assert [u["nodes"] for u in updates] == job["sizes"], "both sides cut the same prefixes"
    for update in updates:
        update["residual"] = update["max_relative_residual"]
    graph = problem.load(job["file"])
    last = np.array(updates[-1]["eigenvalues"])
    updates[-1]["residual"] = float(problem.residuals(graph, last, np.load(vectors)).max() / last[-1])
    vectors.unlink()
    return dict(updates=updates, peak_gb=usage.ru_maxrss / 2**20, process_cpu=cpu, share=share)
