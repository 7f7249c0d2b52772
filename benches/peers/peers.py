"""The peers: each brings k pairs up to date with a larger prefix, in its best known setting.

Every update method receives the prefix W and is timed from there: Laplacian, ordering, factorisation, iteration and
vectors. L = I + C with C = −D^{-1/2} W D^{-1/2}; in shift-invert mode ARPACK needs no product with L, and CHOLMOD adds
(1 + σ) I by itself, so that neither is built.
"""

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as sla

import problem

# Shift, relative to the last λ_k: small beside the wanted eigenvalues, so that they stand apart after inversion.
SHIFT = 0.01


class Peer:
    """One method following one graph; `settings` are its tolerance and size of Krylov space, `unit` is about λ_k."""

    def __init__(self, k: int, tau: float, settings: dict, unit: float, seed: int = 0):
        self.k, self.tau, self.settings, self.unit = k, tau, settings, unit
        self.rng = np.random.default_rng(seed)
        self.values = self.vectors = None

    def update(self, graph: sp.csr_array):
        off = problem.coupling(graph)
        k = min(self.k, graph.shape[0])
        values, vectors = self.solve(off, k, SHIFT * self.unit)
        order = np.argsort(values)
        self.values, self.vectors = values[order], vectors[:, order]
        self.unit = self.values[-1]
        return self.values, self.vectors

    def extended(self, off: sp.csc_array) -> np.ndarray:
        """The old vectors, continued to new nodes by one product with I − L, which averages over neighbours."""
        old = self.vectors
        start = np.zeros((off.shape[0], old.shape[1]))
        start[: len(old)] = old
        new = off[:, len(old) :].T @ start
        start[len(old) :] = -new
        return start


class ShiftInvert(Peer):
    """scipy's eigsh (ARPACK) on (L + σI)⁻¹."""

    warm = False

    def solve(self, off, k, sigma):
        n = off.shape[0]
        inverse = sla.LinearOperator((n, n), matvec=self.factor(off, sigma), dtype=float)
        ncv = min(n - 1, max(k + 2, round(self.settings["ncv"] * k)))
        return sla.eigsh(off, k, sigma=-sigma, OPinv=inverse, which="LM", ncv=ncv, tol=self.settings["tol"], v0=self.start(off))

    def start(self, off):
        if self.warm and self.vectors is not None:
            return self.extended(off).sum(axis=1)
        return self.rng.uniform(-1, 1, off.shape[0])

    def factor(self, off, sigma):
        raise NotImplementedError


class Cholmod(ShiftInvert):
    """Sparse Cholesky by CHOLMOD: simplicial, ordered by AMD."""

    mode = "simplicial"

    def factor(self, off, sigma):
        from sksparse.cholmod import analyze

        factor = analyze(sp.csc_matrix(off), mode=self.mode, ordering_method="amd")
        factor.cholesky_inplace(sp.csc_matrix(off), beta=1 + sigma)
        return factor


class CholmodWarm(Cholmod):
    """The same from the sum of the old vectors."""

    warm = True


class Supernodal(Cholmod):
    """The same by supernodes, on BLAS."""

    mode = "supernodal"


class SuperLu(ShiftInvert):
    """Sparse LU by SuperLU, scipy's own, with its symmetric settings."""

    def factor(self, off, sigma):
        shifted = (off + (1 + sigma) * sp.eye_array(off.shape[0], format="csc")).tocsc()
        options = dict(SymmetricMode=True)
        return sla.splu(shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options).solve


class Primme(Peer):
    """PRIMME from the old vectors, a fresh Cholesky factor as preconditioner."""

    factor = Cholmod.factor
    mode = "simplicial"

    def solve(self, off, k, sigma):
        import primme

        n = off.shape[0]
        operator = (off + sp.eye_array(n, format="csc")).tocsr()
        factor = self.factor(off, sigma)
        inverse = sla.LinearOperator((n, n), matvec=factor, matmat=factor, dtype=float)
        start = None if self.vectors is None else self.extended(off)
        return primme.eigsh(
            operator,
            k,
            which="SA",
            tol=self.settings["tol"] * self.tau * self.unit,
            OPinv=inverse,
            v0=start,
            maxBlockSize=self.settings["block"],
            method=self.settings["method"],
        )


class Lobpcg(Peer):
    """scipy's lobpcg from the old vectors, preconditioned by pyamg's smoothed aggregation."""

    def solve(self, off, k, sigma):
        import pyamg

        n = off.shape[0]
        operator = (off + sp.eye_array(n, format="csc")).tocsr()
        shifted = (operator + sigma * sp.eye_array(n, format="csr")).tocsr()
        hierarchy = pyamg.smoothed_aggregation_solver(sp.csr_matrix(shifted))
        if self.vectors is None:
            start = self.rng.standard_normal((n, k))
        else:
            start = self.extended(off)
        return sla.lobpcg(
            operator,
            start,
            M=hierarchy.aspreconditioner(),
            largest=False,
            tol=self.settings["tol"] * self.tau * self.unit,
            maxiter=self.settings["maxiter"],
        )


PEERS = {
    "cholmod": Cholmod,
    "cholmod-warm": CholmodWarm,
    "cholmod-supernodal": Supernodal,
    "superlu": SuperLu,
    "primme": Primme,
    "lobpcg-amg": Lobpcg,
}
