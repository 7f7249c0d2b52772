"""Eigenvalues that nobody doubts: tight solves, each list proved complete by an inertia count, kept on disk.

L − μI = P L̃ D L̃ᵀ Pᵀ has as many negative entries in D as L has eigenvalues below μ (Sylvester). Where the count is
larger than the list, the search goes on orthogonally to what is known.
"""

import hashlib
from pathlib import Path

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as sla
from sksparse.cholmod import analyze

import problem

KEPT = 36
PROVED = 32
DENSE = 400


def lists(file: Path, sizes: list[int], folder: Path, note=lambda text: None) -> np.ndarray:
    """One row of 36 lowest eigenvalues per prefix, of which 32 and more are proved to be all."""
    tag = hashlib.sha256(f"{file.stat().st_size} {sizes}".encode()).hexdigest()[:12]
    stored = folder / "reference" / f"{file.stem}-{tag}.npy"
    if stored.exists():
        return np.load(stored)
    stored.parent.mkdir(parents=True, exist_ok=True)
    note(f"reference for {file.stem}: {len(sizes)} updates")
    graph, rows, scale = problem.load(file), [], None
    for nodes in sizes:
        rows.append(lowest(problem.prefix(graph, nodes), scale))
        scale = rows[-1][-1]
    table = np.array(rows)
    np.save(stored, table)
    return table


def lowest(graph: sp.csr_array, scale: float | None) -> np.ndarray:
    off = sp.csc_matrix(problem.coupling(graph))
    n = off.shape[0]
    if n <= DENSE:
        return scipy.linalg.eigh(off.toarray() + np.eye(n), eigvals_only=True)[:KEPT]
    symbolic = analyze(off, mode="simplicial", ordering_method="amd")
    if scale is None:
        scale = rough_scale(off, symbolic)
    solve = symbolic.cholesky(off, beta=1 + 1e-3 * scale)
    nothing, kept = np.zeros((n, 0)), KEPT
    values, vectors = search(solve, n, 1e-3 * scale, nothing, kept)
    for _ in range(8):
        # Counted in the widest gap behind the 32nd, so that rounding cannot move a value across.
        gaps = np.diff(values[PROVED - 1 :])
        gap = PROVED - 1 + int(np.argmax(gaps))
        if gaps.max() < 1e-7 * values[gap]:  # equal values up to the end of the list: no place to count in
            kept *= 2
            values, vectors = search(solve, n, 1e-3 * scale, nothing, kept)
            continue
        mu = (values[gap] + values[gap + 1]) / 2
        below = int((symbolic.cholesky(off, beta=1 - mu).D() < 0).sum())
        if below == gap + 1:
            return values[:KEPT]
        more, added = search(solve, n, 1e-3 * scale, vectors, 4)
        values, vectors = np.concatenate([values, more]), np.hstack([vectors, added])
        order = np.argsort(values)
        values, vectors = values[order], vectors[:, order]
    raise RuntimeError(f"{n} nodes: {below} eigenvalues below {mu}, found {gap + 1}")


def rough_scale(off: sp.csc_matrix, symbolic) -> float:
    """About λ_8, by shifts that shrink until they are small beside it."""
    sigma = 1e-3
    while True:
        operator = sla.LinearOperator(off.shape, matvec=symbolic.cholesky(off, beta=1 + sigma), dtype=float)
        nu = sla.eigsh(operator, 8, which="LA", tol=0.1, return_eigenvectors=False, ncv=24, v0=np.cos(np.arange(off.shape[0])))
        scale = 1 / nu.min() - sigma
        if sigma <= scale:
            return scale
        sigma /= 100


def search(solve, n: int, sigma: float, known: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The `count` lowest pairs orthogonal to `known`."""

    def inverse(x):
        x = x - known @ (known.T @ x)
        y = solve(x)
        return y - known @ (known.T @ y)

    start = np.random.default_rng(known.shape[1]).uniform(-1, 1, n)
    operator = sla.LinearOperator((n, n), matvec=inverse, dtype=float)
    nu, vectors = sla.eigsh(operator, count, which="LA", tol=1e-11, v0=start)
    return (1 / nu - sigma)[::-1], vectors[:, ::-1]
