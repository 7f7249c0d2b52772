"""A sweep on a cluster of Ray in this machine: a node that is killed, errors, going on, and throughput.

    pip install 'eigentrail[ray]'
    python python/tests/outside/ray_cluster.py [--throughput]

It starts a head without processors and two nodes of one processor each, kills one node while the sweep goes on, and holds the result
against a sweep on one machine, byte by byte. With ``--throughput`` it measures one node and two besides.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
import threading
import time
from pathlib import Path

os.environ.setdefault("RAY_raylet_start_wait_time_s", "300")  # a busy machine is no failure

import eigentrail
import ray
from ray.cluster_utils import Cluster

GRID = {"shaping.potential": ["gcn", "heat"], "spectral.num_eigenpairs": [8, 16]}
SEEDS = range(40)
SET = {"run.episodes": 20_000}
SCENARIO = "four_rooms"


class Nodes:
    """A head without processors, and as many nodes of one processor."""

    def __init__(self, count: int) -> None:
        self.cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0})
        self.nodes = [self.cluster.add_node(num_cpus=1) for _ in range(count)]
        self.cluster.wait_for_nodes()
        ray.init(address=self.cluster.address, log_to_driver=False)

    def __enter__(self) -> Nodes:
        return self

    def __exit__(self, *_: object) -> None:
        ray.shutdown()
        self.cluster.shutdown()


def shards(out: Path) -> int:
    return len(list(out.glob("points/*/seed*.json")))


def same(here: Path, there: Path) -> None:
    for name in ("summary.json", "sweep.csv"):
        assert (here / name).read_bytes() == (there / name).read_bytes(), name


def a_node_is_killed(work: Path) -> None:
    out, killed = work / "killed", threading.Event()
    with Nodes(2) as nodes:

        def kill() -> None:
            while shards(out) < 4:
                time.sleep(0.05)
            nodes.cluster.remove_node(nodes.nodes[1], allow_graceful=False)
            killed.set()

        thread = threading.Thread(target=kill)
        thread.start()
        begun = time.perf_counter()
        swept = eigentrail.ray.sweep(SCENARIO, GRID, SEEDS, set=SET, out=out, chunk=4)
        seconds = time.perf_counter() - begun
        thread.join()
        assert killed.is_set(), "a node was killed"
        until = time.monotonic() + 60  # Ray's head hears of it late
        while sum(node["Alive"] for node in ray.nodes()) > 2:
            assert time.monotonic() < until, "head and one node are left"
            time.sleep(0.1)
    same(work / "here", out)
    assert swept == json.loads((out / "summary.json").read_text())
    print(f"a node killed after 4 shards: {len(swept.trials)} trials complete after {seconds:.1f} s, equal to one machine")


def errors_and_going_on(work: Path) -> None:
    few = {"set": {"run.episodes": 20}, "out": work / "few"}
    with Nodes(1):
        eigentrail.ray.sweep("smoke", {"env.slip": [0.0]}, range(4), **few)
        try:
            eigentrail.ray.sweep("smoke", {"env.slip": [0.0, 0.1]}, range(4), resume_unfinished=False, **few)
            raise AssertionError("what was not finished was run")
        except RuntimeError as error:
            assert "4 of 8 trials are not finished" in str(error)
        # What an earlier call has noted as failed is not run, unless it is asked for.
        noted = [{"point": point(work / "few", "0.1"), "seeds": [2, 3], "error": "it went wrong"}]
        (work / "few" / "errors.json").write_text(json.dumps(noted))
        try:
            eigentrail.ray.sweep("smoke", {"env.slip": [0.0, 0.1]}, range(4), **few)
            raise AssertionError("what had failed was run")
        except RuntimeError as error:
            assert "it went wrong" in str(error)
        assert sum(len(json.loads(path.read_text())) for path in (work / "few").glob("points/*/seed*.json")) == 6
        eigentrail.ray.sweep("smoke", {"env.slip": [0.0, 0.1]}, range(4), restart_errored=True, **few)
        assert not (work / "few" / "errors.json").exists()
    eigentrail.sweep("smoke", {"env.slip": [0.0, 0.1]}, range(4), set=few["set"], out=work / "few-here")
    same(work / "few-here", work / "few")
    print("errors and what was left unfinished: as documented")


def point(out: Path, value: str) -> str:
    points = json.loads((out / "sweep.json").read_text())["points"]
    return next(point["hash"] for point in points if point["settings"][0][1] == value)


def throughput(work: Path) -> None:
    rates = {}
    for count in (1, 2):
        with Nodes(count):
            out = work / f"nodes-{count}"
            eigentrail.ray.sweep("smoke", seeds=range(2 * count), chunk=1)  # workers have started
            begun = time.perf_counter()
            swept = eigentrail.ray.sweep(SCENARIO, GRID, SEEDS, set=SET, out=out, chunk=4)
            rates[count] = len(swept.trials) / (time.perf_counter() - begun)
        same(work / "here", out)
        print(f"{count} node(s) of one processor: {rates[count]:.1f} trials a second")
    print(f"two nodes are {rates[2] / rates[1]:.2f} times as fast as one")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--throughput", action="store_true", help="measure one node and two besides")
    wanted = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        begun = time.perf_counter()
        eigentrail.sweep(SCENARIO, GRID, SEEDS, set=SET, out=work / "here", threads=1)
        print(f"one machine, one thread: {len(GRID) ** 2 * len(SEEDS) / (time.perf_counter() - begun):.1f} trials a second")
        a_node_is_killed(work)
        errors_and_going_on(work)
        if wanted.throughput:
            throughput(work)


if __name__ == "__main__":
    main()
