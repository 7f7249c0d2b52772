"""What is asked of every contender: prefixes of a file's rows, one Laplacian, one residual, one list check."""

import math

import numpy as np
import scipy.io
import scipy.sparse as sp

START = 64


def load(path) -> sp.csr_array:
    graph = sp.csr_array(scipy.io.mmread(path).tocsr())
    graph.sort_indices()
    return graph


def sizes(n: int, growth: float, start: int = START) -> list[int]:
    """Nodes at each update, by the rule of `eigentrail track`."""
    result = [min(start, n)]
    while result[-1] < n:
        m = result[-1]
        result.append(min(max(math.floor(m * (1 + growth) + 0.5), m + 1), n))
    return result


def prefix(graph: sp.csr_array, m: int) -> sp.csr_array:
    """The graph among the first m nodes, rows sorted."""
    end = graph.indptr[m]
    inside = graph.indices[:end] < m
    before = np.concatenate([[0], np.cumsum(inside)])
    return sp.csr_array(
        (graph.data[:end][inside], graph.indices[:end][inside], before[graph.indptr[: m + 1]].astype(np.int32)),
        shape=(m, m),
    )


def coupling(graph: sp.csr_array) -> sp.csc_array:
    """−D^{-1/2} W D^{-1/2} = L − I for a graph without loops: the part of L that must be computed.

    Symmetric, so that its rows are its columns."""
    d = 1.0 / np.sqrt(np.add.reduceat(graph.data, graph.indptr[:-1]))
    data = graph.data * d[graph.indices]
    data *= np.repeat(-d, np.diff(graph.indptr))
    return sp.csc_array((data, graph.indices, graph.indptr), shape=graph.shape)


def residuals(graph: sp.csr_array, values: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """‖L v − λ v‖ ÷ ‖v‖ of each pair."""
    off = coupling(graph)
    product = off @ vectors + vectors
    return np.linalg.norm(product - vectors * values, axis=0) / np.linalg.norm(vectors, axis=0)


def list_error(found: np.ndarray, exact: np.ndarray) -> float:
    """Largest distance between two ascending lists, entry by entry with repetitions, relative to λ_k."""
    exact = exact[: len(found)]
    return float(np.max(np.abs(np.sort(found) - exact)) / exact[-1])


def list_tolerance(tau: float) -> float:
    """A residual of τ λ_k gives eigenvalues to about τ² λ_k where gaps are of the order of λ_k; ten times that is
    allowed, and what rounding costs where λ_k is small beside ‖L‖."""
    return max(10 * tau * tau, 1e-6)
