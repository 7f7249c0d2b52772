#!/usr/bin/env python3
"""Seconds of a fit of the graph network beside PyTorch's, on one thread, from the same weights, with T̂X taken once on both sides.

    cargo build --release --locked && python gcn_fit.py [--rounds 5] [--epochs 40]

Needs PyTorch (CPU) and NumPy. Four ways of PyTorch: T̂ as COO and as CSR, in single precision and in double; ratios are to the fastest.
Ours computes in double precision.
"""

import argparse
import json
import statistics
import subprocess
import time
from pathlib import Path

import numpy as np
import torch

BINARY = Path(__file__).parent / "target/release/gcn_fit"
SIDES = (100, 316)
FEATURES = 16


def grid_edges(side):
    """(row, column) of both directions of every edge."""
    numbers = np.arange(side * side).reshape(side, side)
    pairs = [(numbers[:, :-1], numbers[:, 1:]), (numbers[:-1], numbers[1:])]
    first = np.concatenate([a.ravel() for a, _ in pairs])
    second = np.concatenate([b.ravel() for _, b in pairs])
    return np.concatenate([first, second]), np.concatenate([second, first])


def cosines(side):
    at = (np.arange(side) + 0.5) / side
    wave = np.cos(np.pi * np.arange(4)[:, None] * at)  # order × place
    return np.stack([2 * np.outer(wave[j // 4], wave[j % 4]).ravel() for j in range(FEATURES)], axis=1)


class TorchFit:
    """The classifier's fit with autograd and torch's Adam."""

    def __init__(self, side, form, dtype):
        n = side * side
        rows, columns = grid_edges(side)
        degree = np.bincount(rows, minlength=n).astype(float)
        root = 1 / np.sqrt(degree + 1)
        diagonal = np.arange(n)
        at = np.stack([np.concatenate([rows, diagonal]), np.concatenate([columns, diagonal])])
        matrix = torch.sparse_coo_tensor(at, root[at[0]] * root[at[1]], (n, n), dtype=dtype).coalesce()
        self.propagation = matrix.to_sparse_csr() if form == "csr" else matrix
        self.adjacency = torch.sparse_coo_tensor(np.stack([rows, columns]), np.ones(len(rows)), (n, n), dtype=dtype).coalesce()
        if form == "csr":
            self.adjacency = self.adjacency.to_sparse_csr()
        self.degree = torch.tensor(degree, dtype=dtype)[:, None]
        self.features = torch.tensor(cosines(side), dtype=dtype)
        self.edges, self.nodes, self.dtype = len(rows) // 2, n, dtype

    def run(self, start, epochs, rate, smoothness):
        """Seconds, and the loss at the end."""
        weights = []
        for name in ("hidden", "output"):
            layer = start[name]
            weight = torch.tensor(layer["weight"], dtype=self.dtype).reshape(layer["inputs"], layer["outputs"])
            weights += [weight.requires_grad_(), torch.tensor(layer["bias"], dtype=self.dtype).requires_grad_()]
        begun = time.perf_counter()
        tx = self.propagation @ self.features
        adam = torch.optim.Adam(weights, lr=rate)
        for _ in range(epochs):
            adam.zero_grad()
            self.loss(tx, weights, smoothness).backward()
            adam.step()
        with torch.no_grad():
            loss = self.loss(tx, weights, smoothness).item()
        return time.perf_counter() - begun, loss

    def loss(self, tx, weights, smoothness):
        w0, b0, w1, b1 = weights
        z = self.propagation @ (torch.relu(tx @ w0 + b0) @ w1) + b1
        log_p = torch.log_softmax(z, dim=1)
        p = log_p.exp()
        laplacian = self.degree * p - self.adjacency @ p
        return -(log_p[0, 0] + log_p[self.nodes - 1, 1]) / 2 + smoothness / self.edges * 0.5 * (p * laplacian).sum()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--epochs", type=int, default=40)
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    print(f"{arguments.epochs} epochs, medians of {arguments.rounds}, one thread, PyTorch {torch.__version__}\n")
    print("| nodes | " + "ours, f64 | COO f32 | CSR f32 | COO f64 | CSR f64 | ours ÷ fastest | losses |\n|---|---|---|---|---|---|---|---|")
    for side in SIDES:
        forms = [(form, dtype) for dtype in (torch.float32, torch.float64) for form in ("coo", "csr")]
        fits = [TorchFit(side, form, dtype) for form, dtype in forms]
        seconds, losses = [[] for _ in range(1 + len(fits))], []
        for _ in range(arguments.rounds):
            command = [BINARY, str(side), str(arguments.epochs)]
            ours = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
            seconds[0].append(ours["seconds"])
            losses = [ours["loss"]]
            for fit, of_fit in zip(fits, seconds[1:]):
                took, loss = fit.run(ours["start"], arguments.epochs, ours["learning_rate"], ours["smoothness"])
                of_fit.append(took)
                losses.append(loss)
        ours, *theirs = map(statistics.median, seconds)
        spread = max(abs(loss / losses[0] - 1) for loss in losses)
        row = [f"{side * side}", *(f"{s:.3f} s" for s in (ours, *theirs)), f"{ours / min(theirs):.2f}", f"within {spread:.0e}"]
        print("| " + " | ".join(row) + " |", flush=True)


if __name__ == "__main__":
    main()
