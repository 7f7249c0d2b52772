"""EigenTracker beside scipy.sparse.linalg.eigsh (shift-invert) in a loop over a growing graph, copies included.

    python python/benches/eigsh_loop.py [NODES] [UPDATES]

The graph is a square grid in order of discovery (breadth first), which grows by a hundredth at a time. Both find the eight
lowest pairs of the unnormalised Laplacian, to a residual of 1e-2 of the largest of them.
"""

from __future__ import annotations

import sys
import time

import eigentrail
import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import breadth_first_order, laplacian
from scipy.sparse.linalg import eigsh

K = 8
TOL = 1e-2


def grid(nodes: int) -> sparse.csr_array:
    side = int(np.ceil(np.sqrt(nodes)))
    path = sparse.diags_array([np.ones(side - 1)] * 2, offsets=[-1, 1])
    whole = sparse.csr_array(sparse.kron(path, sparse.eye_array(side)) + sparse.kron(sparse.eye_array(side), path))
    order = breadth_first_order(whole, 0, return_predecessors=False)[:nodes]
    return whole[order][:, order].tocsr()


def by_eigsh(graph: sparse.csr_array) -> np.ndarray:
    matrix = laplacian(graph).tocsc()
    return np.sort(eigsh(matrix, k=K, sigma=-1e-6, which="LM", tol=TOL)[0])


def main(nodes: int, updates: int) -> None:
    whole = grid(nodes)
    sizes = [int(nodes * 1.01 ** (step - updates)) for step in range(updates + 1)]
    prefixes = [whole[:n, :n] for n in sizes]
    for certify in (False, True):
        tracker = eigentrail.EigenTracker(K, tol=TOL, laplacian="unnormalised", certify=certify)
        tracker.update(prefixes[0])
        ours, theirs = [], []
        for prefix in prefixes[1:]:
            begin = time.perf_counter()
            tracker.update(prefix).eigenvectors  # noqa: B018 (they are made when they are asked for)
            ours.append(time.perf_counter() - begin)
            begin = time.perf_counter()
            expected = by_eigsh(prefix)
            theirs.append(time.perf_counter() - begin)
            assert np.allclose(tracker.eigenvalues, expected, rtol=1e-2, atol=1e-9)
        one, other = np.median(ours), np.median(theirs)
        told = "with a proof" if certify else "without"
        print(f"{nodes} nodes, {told}: {one:.3f} s an update, eigsh {other:.3f} s, ratio {one / other:.2f}")


if __name__ == "__main__":
    numbers = [int(argument) for argument in sys.argv[1:]]
    main(*(numbers + [100_000, 5][len(numbers) :]))
