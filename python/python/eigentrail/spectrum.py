"""The lowest eigenvectors of graphs that grow."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from . import _eigentrail
from .engine import Floats


class EigenTracker:
    """The ``k`` lowest eigenpairs of a graph's Laplacian, kept up to date while the graph grows.

    Instead of calling ``eigsh`` anew each time: an update starts from the last vectors. Rows may only be appended;
    edges may join any two nodes. A graph of fewer than ``k`` nodes has as many pairs as nodes.

    - ``tol``: largest residual ‖Lv − λv‖ relative to λ_k. Eigenvalues are accurate to about its square.
    - ``laplacian``: ``"sym"``, I − D^-1/2 W D^-1/2, or ``"unnormalised"``, D − W.
    - ``method``: ``"warm"``, or for comparison ``"cold"`` (from nothing each time) and ``"full"`` (dense).
    - ``certify``: prove by an inertia count that no pair was missed, for one more factorisation.
    - ``threads``: the result does not depend on it.

    >>> from eigentrail import EigenTracker
    >>> tracker = EigenTracker(2)
    >>> triangle = ([0, 2, 4, 6], [1, 2, 0, 2, 0, 1], (3, 3))
    >>> tracker.update(triangle).eigenvalues.round(6).tolist()
    [0.0, 1.5]
    >>> tracker.eigenvectors.shape, tracker.certified
    ((3, 2), True)
    """

    def __init__(
        self,
        k: int,
        tol: float = 1e-2,
        *,
        laplacian: str = "sym",
        method: str = "warm",
        certify: bool = True,
        threads: int = 1,
        seed: int = 0,
    ) -> None:
        self._core = _eigentrail.EigenTracker(k, tol, laplacian, method, certify, threads, seed)
        self._values = np.empty(0)
        self._values.flags.writeable = False
        self._vectors: Floats | None = None
        self._facts: dict[str, Any] = {}

    def update(self, graph: Any) -> EigenTracker:
        """Follows the graph to its present size, and returns the tracker itself.

        ``graph`` is a symmetric matrix of weights: a SciPy sparse matrix or array, a NetworkX or rustworkx graph
        (undirected), or ``(indptr, indices, shape)`` or ``(indptr, indices, data, shape)``.
        """
        self._values, self._facts = self._core.update(*_rows(graph))
        self._vectors = None
        return self

    @property
    def eigenvalues(self) -> Floats:
        """Ascending; empty before the first update."""
        return self._values

    @property
    def eigenvectors(self) -> Floats:
        """n × k, orthonormal columns, each with its entry of largest magnitude positive."""
        if self._vectors is None:
            self._vectors = self._core.eigenvectors()
        return self._vectors

    @property
    def certified(self) -> bool:
        """Whether the pairs are proven to be the lowest, none missed."""
        return self._facts.get("certified", False)

    @property
    def converged(self) -> bool:
        """Whether every pair is within the tolerance."""
        return self._facts.get("converged", False)

    @property
    def facts(self) -> dict[str, Any]:
        """What the last update took and how good its pairs are."""
        return dict(self._facts)

    def __getstate__(self) -> tuple[Any, ...]:
        return (self._core.to_bytes(), self._values, self._facts)

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        saved, self._values, self._facts = state
        self._values.flags.writeable = False
        self._core = _eigentrail.EigenTracker.from_bytes(saved)
        self._vectors = None


class Tracked:
    """What :func:`track` found.

    ``eigenvalues`` and ``eigenvectors`` are those of the whole graph; ``updates`` has a dictionary for each step of the
    growth, with the fields of ``eigentrail track --json``; ``total_seconds`` is what the updates took.
    """

    def __init__(self, eigenvalues: Floats, eigenvectors: Floats, record: dict[str, Any]) -> None:
        self.eigenvalues = eigenvalues
        self.eigenvectors = eigenvectors
        self.updates: list[dict[str, Any]] = record["updates"]
        self.total_seconds: float = record["total_seconds"]

    @property
    def certified(self) -> bool:
        """Whether the last pairs are proven to be the lowest."""
        return bool(self.updates[-1]["certified"])

    def __repr__(self) -> str:
        n, k = self.eigenvectors.shape
        return f"<eigentrail.Tracked: {k} pairs of {n} nodes, {len(self.updates)} updates in {self.total_seconds:.3f} s>"


def track(
    graph: Any,
    k: int = 16,
    tol: float = 1e-2,
    *,
    growth: float = 0.05,
    start_nodes: int = 64,
    laplacian: str = "sym",
    method: str = "warm",
    certify: bool = True,
    threads: int = 1,
    seed: int = 0,
) -> Tracked:
    """Follows the ``k`` lowest eigenpairs of a graph while it is discovered: prefixes of its rows, from ``start_nodes``
    nodes, each by the share ``growth`` larger than the last, to all of them. Other parameters are those of
    :class:`EigenTracker`.

    >>> from eigentrail import track
    >>> path = ([0, 1, 3, 5, 6], [1, 0, 2, 1, 3, 2], (4, 4))
    >>> track(path, k=3).eigenvalues.round(6).tolist()
    [0.0, 0.5, 1.5]
    """
    values, vectors, record = _eigentrail.track(
        *_rows(graph), k, tol, growth, start_nodes, laplacian, method, certify, threads, seed
    )
    return Tracked(values, vectors, json.loads(record))


def _rows(graph: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """Offsets, columns, weights and the number of rows."""
    if isinstance(graph, tuple):
        return _from_arrays(graph)
    if hasattr(graph, "tocsr"):
        matrix = graph.tocsr()
        return _from_arrays((matrix.indptr, matrix.indices, matrix.data, matrix.shape))
    if hasattr(graph, "adjacency") and hasattr(graph, "is_directed"):
        return _from_networkx(graph)
    if hasattr(graph, "weighted_edge_list"):
        return _from_rustworkx(graph)
    raise TypeError(
        f"a graph is a SciPy sparse matrix, a NetworkX or rustworkx graph, or (indptr, indices, data, shape), not "
        f"{type(graph).__qualname__}"
    )


def _from_arrays(graph: tuple[Any, ...]) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    if len(graph) == 3:
        indptr, indices, shape = graph
        data = np.ones(len(indices))
    elif len(graph) == 4:
        indptr, indices, data, shape = graph
    else:
        raise TypeError("a graph as arrays is (indptr, indices, shape) or (indptr, indices, data, shape)")
    rows, columns = shape
    if rows != columns:
        raise ValueError(f"matrix is {rows} × {columns}: an adjacency matrix must be square")
    if np.iscomplexobj(data):
        raise ValueError("edge weights are complex: weights must be finite and positive")
    weights = np.ascontiguousarray(data, dtype=np.float64)
    return _short(indptr, "indptr"), _short(indices, "indices"), weights, int(rows)


def _short(numbers: Any, name: str) -> np.ndarray:
    """As 32-bit integers, which is what SciPy has as well."""
    array = np.asarray(numbers)
    if array.size == 0:
        return np.empty(0, dtype=np.int32)
    if array.dtype == np.int32:
        return np.ascontiguousarray(array)
    if array.dtype.kind not in "iu":
        raise ValueError(f"{name} holds numbers of type {array.dtype}: must be integers")
    if int(array.max()) >= 2**31 or int(array.min()) < -(2**31):
        raise ValueError(f"{name} holds {array.max()}: must be below 2147483648")
    return np.ascontiguousarray(array, dtype=np.int32)


def _from_networkx(graph: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """In the order in which its nodes were added."""
    if graph.is_directed():
        raise ValueError("the graph is directed: its spectrum is that of graph.to_undirected()")
    number = {node: i for i, node in enumerate(graph)}
    edges = ((number[u], number[v], weight) for u, v, weight in graph.edges(data="weight", default=1.0))
    return _from_edges(len(number), edges)


def _from_rustworkx(graph: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """In the order of its node indices; an edge whose payload is no number weighs 1."""
    if not type(graph).__name__.endswith("PyGraph"):
        raise ValueError("the graph is directed: its spectrum is that of graph.to_undirected()")
    number = {node: i for i, node in enumerate(graph.node_indices())}
    edges = ((number[u], number[v], _weight(payload)) for u, v, payload in graph.weighted_edge_list())
    return _from_edges(len(number), edges)


def _weight(payload: Any) -> float:
    is_number = isinstance(payload, (int, float, np.integer, np.floating)) and not isinstance(payload, bool)
    return float(payload) if is_number else 1.0


def _from_edges(nodes: int, edges: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """By rows, each edge both ways and a loop once; parallel edges are added up where the rows are read."""
    listed = list(edges)
    # The smaller node first: parallel edges are then added up in one order in both rows.
    u = np.array([min(edge[:2]) for edge in listed], dtype=np.int32)
    v = np.array([max(edge[:2]) for edge in listed], dtype=np.int32)
    w = np.array([edge[2] for edge in listed], dtype=np.float64)
    proper = u != v
    rows, columns = np.concatenate([u, v[proper]]), np.concatenate([v, u[proper]])
    weights = np.concatenate([w, w[proper]])
    order = np.lexsort((columns, rows))
    offsets = np.zeros(nodes + 1, dtype=np.int32)
    np.cumsum(np.bincount(rows, minlength=nodes), out=offsets[1:])
    return offsets, columns[order], weights[order], nodes
