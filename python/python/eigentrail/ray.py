"""Sweeps on a Ray cluster: one task is a chunk of the seeds of one point.

Tasks need no files but those that the scenario names, which must be at the same place on every node, and eigentrail in the same version.
Only the process that calls writes to ``out``: a task returns its shard, which is kept there as soon as it comes. Shards say what they
are of, so that a chunk may be computed twice, in chunks of another size, or on one machine, and nothing changes in the result.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from typing import Any

from . import _eigentrail
from .documents import Sweep
from .experiments import Grid, Path, Seeds, Settings, assignments, axes, distinct, folder
from .progress import Progress

# Tasks for each that can go on at a time, so that no node waits long for the last one.
_TASKS_EACH = 4
_ERRORS = "errors.json"


def sweep(
    scenario: Path,
    grid: Grid | None = None,
    seeds: Seeds = range(20),
    *,
    arms: Iterable[str] = (),
    set: Settings | None = None,
    out: Path | None = None,
    chunk: int | None = None,
    num_cpus: int = 1,
    max_retries: int = 3,
    resume_unfinished: bool = True,
    restart_errored: bool = False,
    progress: bool | None = None,
) -> Sweep:
    """:func:`eigentrail.sweep` on the cluster that Ray is connected to, or else on one that it starts here. The result, and
    ``summary.json`` and ``sweep.csv`` in ``out``, are the same to the byte.

    - ``chunk``: how many seeds of a point are one task, by default as many as make four tasks for each that can go on at a time.
    - ``num_cpus``: processors of a task, which runs as many seeds at a time.
    - ``max_retries``: how often Ray runs a task again whose node or process was lost.
    - ``resume_unfinished``: whether what an earlier call has left unfinished in ``out`` is run; if not, that is an error.
    - ``restart_errored``: whether chunks whose task raised in an earlier call are run again. All others are finished first, then their
      error is raised again.
    """
    ray = _ray()
    path = os.fspath(scenario)
    opened = _eigentrail.SweepFolder(
        # Workers are elsewhere; a name of ours stays one.
        os.path.abspath(path) if os.path.exists(path) else path,
        assignments(set),
        axes(grid),
        distinct([arms] if isinstance(arms, str) else arms, None),
        distinct(seeds, "seeds"),
        folder(out),
        ["eigentrail.ray.sweep"],
    )
    if not resume_unfinished and opened.was_begun and opened.num_finished < opened.num_trials:
        raise RuntimeError(
            f"{out}: {opened.num_trials - opened.num_finished} of {opened.num_trials} trials are not finished, "
            "and resume_unfinished=False"
        )
    errors = _Errors(out, restart_errored)
    if not ray.is_initialized():
        ray.init()
    waiting = _chunks(opened, errors, chunk, max(1, int(ray.cluster_resources().get("CPU", 1)) // num_cpus))
    remote = ray.remote(_run_chunk).options(num_cpus=num_cpus, max_retries=max_retries, scheduling_strategy="SPREAD")
    with Progress(progress, "trials") as shown:
        running = {remote.remote(task, chunk, num_cpus): (digest, chunk) for task, digest, chunk in waiting}
        try:
            while running:
                ready, _ = ray.wait(list(running), timeout=1.0)
                for reference in ready:
                    digest, chunk_seeds = running.pop(reference)
                    try:
                        opened.put(ray.get(reference))
                    except ray.exceptions.RayTaskError as error:
                        errors.note(digest, chunk_seeds, str(error.cause))
                if shown.told:
                    shown.told(opened.num_finished, opened.num_trials)
        finally:
            for reference in running:
                ray.cancel(reference)
    errors.raise_first()
    document, trials = opened.finish()
    return Sweep(json.loads(document), trials)


def _ray() -> Any:
    try:
        import ray
        import ray.exceptions
    except ModuleNotFoundError as error:
        raise ImportError("eigentrail.ray needs Ray: pip install eigentrail[ray]") from error
    return ray


def _run_chunk(task: str, seeds: list[int], threads: int) -> str:
    return _eigentrail.run_shard(task, seeds, threads)


def _chunks(opened: Any, errors: _Errors, size: int | None, at_once: int) -> list[tuple[str, str, list[int]]]:
    """What is not finished and has not failed: task, its hash, seeds."""
    missing = []
    for point, seeds in opened.unfinished():
        task, digest = opened.task(point)
        seeds = [seed for seed in seeds if not errors.has(digest, seed)]
        missing.append((task, digest, seeds))
    if size is None:
        trials = sum(len(seeds) for _, _, seeds in missing)
        size = max(1, trials // (_TASKS_EACH * at_once))
    return [
        (task, digest, seeds[begin : begin + size])
        for task, digest, seeds in missing
        for begin in range(0, len(seeds), size)
    ]


class _Errors:
    """Chunks whose task raised, kept in ``out`` from one call to the next."""

    def __init__(self, out: Path | None, forget: bool) -> None:
        self._path = None if out is None else os.path.join(os.fspath(out), _ERRORS)
        self._noted: list[dict[str, Any]] = []
        if self._path is not None and os.path.exists(self._path) and not forget:
            with open(self._path, encoding="utf-8") as file:
                self._noted = json.load(file)
        self._write()

    def has(self, digest: str, seed: int) -> bool:
        return any(error["point"] == digest and seed in error["seeds"] for error in self._noted)

    def note(self, digest: str, seeds: list[int], text: str) -> None:
        self._noted.append({"point": digest, "seeds": seeds, "error": text})
        self._write()

    def _write(self) -> None:
        if self._path is None:
            return
        if self._noted:
            beside = f"{self._path}.{os.getpid()}.tmp"
            with open(beside, "w", encoding="utf-8") as file:
                json.dump(self._noted, file, indent=1)
            os.replace(beside, self._path)
        elif os.path.exists(self._path):
            os.remove(self._path)

    def raise_first(self) -> None:
        if self._noted:
            first, count = self._noted[0], len(self._noted)
            raise RuntimeError(
                f"{count} chunks of the sweep failed, the first at point {first['point']}, seeds {first['seeds']}: "
                f"{first['error']}; restart_errored=True runs them again"
            )
