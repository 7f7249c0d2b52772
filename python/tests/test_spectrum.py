"""Eigenpairs of growing graphs, against NumPy's and SciPy's of the same Laplacian."""

from __future__ import annotations

import copy
import pickle
import threading

import eigentrail
import networkx as nx
import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import eigsh


def graph(n: int, seed: int = 0) -> sparse.csr_array:
    """Connected, with weights, in an order of discovery: each node is joined to some before it."""
    rng = np.random.default_rng(seed)
    rows, columns, weights = [], [], []
    for i in range(1, n):
        for j in {i - 1, int(rng.integers(max(0, i - 30), i))}:
            rows += [i, j]
            columns += [j, i]
            weights += [float(rng.integers(1, 5))] * 2
    return sparse.csr_array((weights, (rows, columns)), shape=(n, n))


def laplacian(matrix: sparse.csr_array, kind: str = "sym") -> np.ndarray:
    dense = matrix.toarray()
    degrees = dense.sum(axis=1)
    if kind == "unnormalised":
        return np.diag(degrees) - dense
    with np.errstate(divide="ignore"):
        scale = np.where(degrees > 0, 1 / np.sqrt(degrees), 0.0)
    return np.diag((degrees > 0).astype(float)) - scale[:, None] * dense * scale


@pytest.mark.parametrize("kind", ["sym", "unnormalised"])
def test_a_growing_graph_has_the_eigenpairs_of_its_laplacian(kind):
    whole = graph(900)
    tracker = eigentrail.EigenTracker(6, tol=1e-4, laplacian=kind)
    for n in (4, 40, 500, 800, 900):
        tracker.update(whole[:n, :n])
        matrix = laplacian(whole[:n, :n], kind)
        k = min(6, n)
        exact = np.linalg.eigvalsh(matrix)[:k]
        np.testing.assert_allclose(tracker.eigenvalues, exact, atol=1e-6 * exact[-1] + 1e-12)
        vectors = tracker.eigenvectors
        assert vectors.shape == (n, k) and vectors.dtype == np.float64
        np.testing.assert_allclose(vectors.T @ vectors, np.eye(k), atol=1e-9)
        residuals = np.linalg.norm(matrix @ vectors - vectors * tracker.eigenvalues, axis=0)
        assert residuals.max() <= 1.01e-4 * exact[-1]
        assert tracker.converged and tracker.certified
    assert tracker.facts["nodes"] == 900 and not tracker.facts["cold_start"]


def test_a_loop_of_eigsh_finds_the_same():
    whole = graph(700, seed=3)
    tracker = eigentrail.EigenTracker(5, tol=1e-5, laplacian="unnormalised")
    for n in (600, 650, 700):
        found = tracker.update(whole[:n, :n]).eigenvalues
        matrix = sparse.csgraph.laplacian(whole[:n, :n]).tocsc()
        expected = np.sort(eigsh(matrix, k=5, sigma=-1e-3, which="LM", return_eigenvectors=False))
        np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-10)


def test_track_is_the_tracker_on_prefixes():
    whole = graph(500, seed=1)
    tracked = eigentrail.track(whole, k=4, tol=1e-3, growth=0.5)
    assert tracked.updates[0]["nodes"] == 64 and tracked.updates[-1]["nodes"] == 500
    assert tracked.eigenvectors.shape == (500, 4) and tracked.certified
    exact = np.linalg.eigvalsh(laplacian(whole))[:4]
    np.testing.assert_allclose(tracked.eigenvalues, exact, atol=1e-5 * exact[-1])


def test_every_way_to_give_a_graph_is_the_same_graph():
    matrix = graph(120)
    dense = matrix.toarray()
    expected = eigentrail.EigenTracker(4).update(matrix).eigenvectors
    named = nx.Graph()
    named.add_nodes_from(range(120))
    named.add_weighted_edges_from((i, j, dense[i, j]) for i, j in zip(*np.nonzero(np.triu(dense)), strict=True))
    wide = sparse.csr_array(matrix)
    wide.indices, wide.indptr = wide.indices.astype(np.int64), wide.indptr.astype(np.int64)
    doubled = matrix.tocoo()
    halves = sparse.coo_array(
        (np.tile(doubled.data / 2, 2), (np.tile(doubled.coords[0], 2), np.tile(doubled.coords[1], 2))), shape=(120, 120)
    )
    shuffled = matrix.copy()
    for row in range(120):
        part = slice(shuffled.indptr[row], shuffled.indptr[row + 1])
        shuffled.indices[part] = shuffled.indices[part][::-1].copy()
        shuffled.data[part] = shuffled.data[part][::-1].copy()
    ways = [
        matrix.tocoo(),
        matrix.tocsc(),
        sparse.csr_matrix(matrix),
        wide,
        halves,
        (shuffled.indptr, shuffled.indices, shuffled.data, (120, 120)),
        (matrix.indptr.tolist(), matrix.indices.tolist(), matrix.data.tolist(), (120, 120)),
        named,
    ]
    for way in ways:
        np.testing.assert_array_equal(eigentrail.EigenTracker(4).update(way).eigenvectors, expected)


def test_rustworkx_graphs_are_taken():
    rx = pytest.importorskip("rustworkx")
    matrix = graph(60)
    dense = matrix.toarray()
    other = rx.PyGraph()
    other.add_nodes_from(range(60))
    other.add_edges_from([(int(i), int(j), dense[i, j]) for i, j in zip(*np.nonzero(np.triu(dense)), strict=True)])
    expected = eigentrail.EigenTracker(3).update(matrix).eigenvalues
    np.testing.assert_array_equal(eigentrail.EigenTracker(3).update(other).eigenvalues, expected)


def test_weights_left_out_are_one_and_zeros_are_no_edges():
    path = ([0, 1, 3, 4], [1, 0, 2, 1], (3, 3))
    with_zeros = sparse.csr_array(([1.0, 0.0, 1.0, 1.0, 1.0, 0.0], [1, 2, 0, 2, 1, 0], [0, 2, 4, 6]), shape=(3, 3))
    found = [eigentrail.EigenTracker(3).update(way).eigenvalues for way in (path, with_zeros)]
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_allclose(found[0], [0.0, 1.0, 2.0], atol=1e-12)


def test_arrays_are_snapshots_that_nobody_writes_to():
    tracker = eigentrail.EigenTracker(3).update(graph(80))
    values, vectors = tracker.eigenvalues, tracker.eigenvectors
    for array in (values, vectors):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    before = vectors.copy()
    tracker.update(graph(90))
    np.testing.assert_array_equal(vectors, before)
    assert tracker.eigenvectors.shape == (90, 3)


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda tracker: pickle.loads(pickle.dumps(tracker))])
def test_a_copy_goes_on_to_the_same_bits(copied):
    whole = graph(800, seed=2)
    tracker = eigentrail.EigenTracker(5).update(whole[:700, :700])
    other = copied(tracker)
    np.testing.assert_array_equal(other.eigenvectors, tracker.eigenvectors)
    assert other.certified == tracker.certified
    np.testing.assert_array_equal(other.update(whole).eigenvectors, tracker.update(whole).eigenvectors)


def one_way(matrix):
    matrix = matrix.tolil()
    matrix[3, 70] = 9.0
    return matrix.tocsr()


def weighted(weight):
    def change(matrix):
        matrix = matrix.tolil()
        matrix[3, 2] = matrix[2, 3] = weight
        return matrix.tocsr()

    return change


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (one_way, "matrix is not symmetric: entry at row 3, column 70"),
        (weighted(-1.0), "edge weight at row 2, column 3 is -1: weights must be finite and positive"),
        (weighted(np.nan), "edge weight at row 2, column 3 is NaN"),
        (weighted(np.inf), "edge weight at row 2, column 3 is inf"),
        (lambda matrix: matrix[:, :50], "matrix is 80 × 50: an adjacency matrix must be square"),
        (lambda matrix: ([0, 1], [5], (1, 1)), "indices holds 5: columns are 0 to 0"),
        (lambda matrix: ([0, 2], [0], (1, 1)), "indptr must rise from 0 to 1"),
        (lambda matrix: ([0], [0], (1, 1)), "indptr has 1 entries: a matrix of 1 rows needs 2"),
        (lambda matrix: ([0, 1], [0], [1.0, 2.0], (1, 1)), "data has 2 entries and indices 1"),
        (lambda matrix: matrix[:40, :40], "the graph has 40 nodes and had 60 at the last update: a tracked graph only grows"),
        (lambda matrix: nx.DiGraph([(0, 1)]), "the graph is directed"),
    ],
)
def test_graphs_that_are_none_are_refused_in_one_sentence(change, told):
    tracker = eigentrail.EigenTracker(3).update(graph(60))
    before = tracker.eigenvalues
    with pytest.raises(ValueError, match=told.replace("(", r"\(")):
        tracker.update(change(graph(80)))
    np.testing.assert_array_equal(tracker.eigenvalues, before)


@pytest.mark.parametrize(
    ("parameters", "told"),
    [
        ({"k": 0}, "k = 0: must be at least 1"),
        ({"k": -3}, "k = -3: must be at least 1"),
        ({"k": 3, "tol": 0.0}, "tol = 0: must be above 0 and below 1"),
        ({"k": 3, "laplacian": "random-walk"}, "laplacian"),
        ({"k": 3, "method": "hot"}, "method"),
        ({"k": 3, "threads": 0}, "threads = 0"),
    ],
)
def test_parameters_out_of_range_are_refused(parameters, told):
    with pytest.raises(ValueError, match=told):
        eigentrail.EigenTracker(**parameters)


def test_more_pairs_than_nodes_are_refused_by_track_only():
    assert eigentrail.EigenTracker(9).update(graph(5)).eigenvectors.shape == (5, 5)
    with pytest.raises(ValueError, match="k = 9 eigenpairs asked of a graph of 5 nodes"):
        eigentrail.track(graph(5), k=9)


def test_something_else_is_no_graph():
    with pytest.raises(TypeError, match="a graph is a SciPy sparse matrix"):
        eigentrail.EigenTracker(2).update("graph")


def test_other_threads_run_during_an_update():
    tracker = eigentrail.EigenTracker(16, method="cold")
    matrix = graph(6000)
    done, ticks = threading.Event(), [0]

    def update():
        tracker.update(matrix)
        done.set()

    thread = threading.Thread(target=update)
    thread.start()
    while not done.wait(0.0005):
        ticks[0] += 1
    thread.join()
    assert ticks[0] >= 2
