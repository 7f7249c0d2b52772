"""What to measure: the rows of the table."""

import os
from dataclasses import dataclass

ALL_CORES = os.cpu_count() or 1

CHOLMOD = ("cholmod", "cholmod-warm")
EVERY = (*CHOLMOD, "cholmod-supernodal", "superlu", "primme", "lobpcg-amg")


@dataclass(frozen=True)
class Row:
    kind: str  # "sequence": 64 nodes to all; "update": the last 5 % of the nodes
    size: str
    family: str
    order: str
    k: int
    tau: float
    threads: int
    peers: tuple[str, ...]
    repeats: int

    def name(self) -> str:
        cores = "1 thread" if self.threads == 1 else f"{self.threads} threads"
        return f"{self.kind} {self.size} {self.family} {self.order} k={self.k} tau={self.tau:g} {cores}"


def block(kind, sizes, orders, ks, taus, threads, peers, repeats) -> list[Row]:
    return [
        Row(kind, size, family, order, k, tau, cores, peers, repeats)
        for size in sizes
        for tau in taus
        for k in ks
        for cores in threads
        for order in orders
        for family in ("grid", "rooms", "maze")
    ]


def quick() -> list[Row]:
    rows = block("sequence", ["1e4"], ["frontier"], [16], [1e-2], [1], CHOLMOD, 3)
    return rows + block("sequence", ["1e5"], ["frontier"], [16], [1e-2], [1], CHOLMOD, 1)


def full() -> list[Row]:
    both, first = ["frontier", "breadth"], ["frontier"]
    return [
        *block("sequence", ["1e4"], both, [16], [1e-2], [1], EVERY, 5),
        *block("sequence", ["1e4"], first, [16], [1e-6], [1], EVERY, 5),
        *block("sequence", ["1e5"], both, [16], [1e-2], [1], CHOLMOD, 3),
        *block("sequence", ["1e5"], first, [16], [1e-6], [1], CHOLMOD, 3),
        *block("sequence", ["1e5"], first, [32], [1e-2], [1], CHOLMOD, 3),
        *block("sequence", ["1e5"], first, [16], [1e-2], [ALL_CORES], (*CHOLMOD, "cholmod-supernodal"), 3),
        *block("update", ["1e6"], first, [16], [1e-2], [1, ALL_CORES], ("cholmod",), 3),
    ]


def all_peers() -> list[Row]:
    return block("update", ["1e4", "1e5"], ["frontier"], [16], [1e-2], [1], EVERY, 3)


PRESETS = {"quick": quick, "full": full, "peers": all_peers}
