"""The Rust half of the package; use the classes and functions of ``eigentrail`` instead."""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

_Floats = npt.NDArray[np.float64]
_Integers = npt.NDArray[np.int64]
_Short = npt.NDArray[np.int32]
_Flags = npt.NDArray[np.bool_]
_Progress = Callable[[int, int], Any] | None
_Seen = tuple[int, float, float, bool, bool, bool, float, bool]

class Engine:
    num_nodes: int
    num_edges: int
    num_actions: int
    num_walkers: int
    steps: int
    gamma: float
    def __new__(cls, num_actions: int, gamma: float, seed: int, walkers: int, params: str) -> Engine: ...
    def begin_episode(self, key: bytes, walker: int) -> int: ...
    def observe(
        self, action: int, key: bytes, reward: float, terminated: bool, truncated: bool, walker: int
    ) -> tuple[_Seen, tuple[int, int] | None]: ...
    def advice(self, walker: int) -> _Floats: ...
    def look_ahead(self) -> _Floats: ...
    def node_of(self, key: bytes) -> int | None: ...
    def key_of(self, node: int) -> bytes: ...
    def keys(self) -> list[bytes]: ...
    def walker_node(self, walker: int) -> int | None: ...
    def in_episode(self, walker: int) -> bool: ...
    def phi(self, node: int) -> float: ...
    def potential(self) -> _Floats: ...
    def eigenvalues(self) -> _Floats: ...
    def eigenvectors(self) -> _Floats: ...
    def refresh(self) -> None: ...
    def refit(self) -> None: ...
    def adjacency(self) -> tuple[_Integers, _Integers, _Floats]: ...
    def transitions(self) -> tuple[_Integers, _Integers, _Integers, _Integers, _Floats, _Flags]: ...
    def goals(self) -> list[int]: ...
    def spurious_maxima(self) -> list[int]: ...
    def to_bytes(self) -> bytes: ...
    @staticmethod
    def from_bytes(bytes: bytes) -> Engine: ...

class Learner:
    num_nodes: int
    def __new__(
        cls, num_actions: int, gamma: float, seed: int, step_limit: int | None, params: str, agent: str
    ) -> Learner: ...
    def begin_episode(self, key: bytes) -> int: ...
    def act(self) -> int: ...
    def learn(self, key: bytes, reward: float, terminated: bool, truncated: bool) -> _Seen: ...
    def greedy(self, key: bytes) -> int | None: ...

class EigenTracker:
    def __new__(
        cls, k: int, tol: float, laplacian: str, method: str, certify: bool, threads: int, seed: int
    ) -> EigenTracker: ...
    def update(self, offsets: _Short, columns: _Short, weights: _Floats, nodes: int) -> tuple[_Floats, dict[str, Any]]: ...
    def eigenvectors(self) -> _Floats: ...
    def to_bytes(self) -> bytes: ...
    @staticmethod
    def from_bytes(bytes: bytes) -> EigenTracker: ...

def track(
    offsets: _Short,
    columns: _Short,
    weights: _Floats,
    nodes: int,
    k: int,
    tol: float,
    growth: float,
    start_nodes: int,
    laplacian: str,
    method: str,
    certify: bool,
    threads: int,
    seed: int,
) -> tuple[_Floats, _Floats, str]: ...
def solve(
    num_states: int,
    num_actions: int,
    pair: _Integers,
    next: _Integers,
    probability: _Floats,
    reward: _Floats,
    ends: _Flags,
    gamma: float,
    tol: float,
) -> tuple[_Floats, _Floats]: ...
def after_fork() -> None: ...
def run(
    path: str,
    sets: list[str],
    seeds: list[int],
    alone: bool,
    out: str | None,
    arguments: list[str],
    threads: int | None,
    progress: _Progress,
) -> str: ...
def compare(
    path: str,
    sets: list[str],
    arms: list[str],
    seeds: list[int],
    tuned: bool,
    out: str | None,
    arguments: list[str],
    threads: int | None,
    progress: _Progress,
) -> str: ...
def sweep(
    path: str,
    sets: list[str],
    grid: list[tuple[str, list[str]]],
    arms: list[str],
    seeds: list[int],
    out: str | None,
    arguments: list[str],
    threads: int | None,
    progress: _Progress,
) -> tuple[str, str]: ...

class SweepFolder:
    was_begun: bool
    num_trials: int
    num_finished: int
    def __new__(
        cls,
        path: str,
        sets: list[str],
        grid: list[tuple[str, list[str]]],
        arms: list[str],
        seeds: list[int],
        out: str | None,
        arguments: list[str],
    ) -> SweepFolder: ...
    def unfinished(self) -> list[tuple[int, list[int]]]: ...
    def task(self, point: int) -> tuple[str, str]: ...
    def put(self, shard: str) -> None: ...
    def finish(self) -> tuple[str, str] | None: ...

def run_shard(task: str, seeds: list[int], threads: int | None) -> str: ...
