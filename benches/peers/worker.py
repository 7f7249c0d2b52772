"""One contender in a process of its own: reads a job from standard input, prints what it measured.

Times are taken around each update only; reading the file, cutting prefixes and checking results are outside.
"""

import json
import sys
import time
import traceback
import warnings

import ours
import problem


def measure(job: dict) -> dict:
    if job["peer"] == "eigentrail":
        return ours.measure(job)
    import peers

    graph = problem.load(job["file"])
    peer = peers.PEERS[job["peer"]](job["k"], job["tau"], job["settings"], job["unit"])
    updates = []
    for nodes in job["sizes"]:
        prefix = problem.prefix(graph, nodes)
        cpu, wall = time.process_time(), time.perf_counter()
        values, vectors = peer.update(prefix)
        cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
        residual = problem.residuals(prefix, values, vectors).max() / values[-1]
        updates.append(
            dict(nodes=nodes, cpu=cpu, wall=wall, residual=float(residual), eigenvalues=values.tolist())
        )
    return dict(updates=updates, peak_gb=peak_memory())


def peak_memory() -> float:
    """In GB, of this program only: `ru_maxrss` would begin with the memory of the process that started it."""
    line = next(line for line in open("/proc/self/status") if line.startswith("VmHWM"))
    return int(line.split()[1]) / 2**20


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    try:
        result = measure(json.load(sys.stdin))
    except Exception as error:  # a peer that fails is a result, and the others go on
        traceback.print_exc()
        result = dict(failed=f"{type(error).__name__}: {error}"[:300])
    print(json.dumps(result))
