"""Grid, multi-room and maze graphs as Matrix Market files whose rows are in order of discovery."""

from pathlib import Path

import numpy as np
import scipy.io
import scipy.sparse as sp

SIZES = {"1e4": 10_000, "1e5": 100_000, "1e6": 1_000_000}
FAMILIES = ("grid", "rooms", "maze")
ORDERS = ("frontier", "breadth")

ROOM_SIDE = 9
LOOPS = 0.05


def path_of(folder: Path, family: str, size: str, order: str) -> Path:
    """The file of one graph, written unless it is there."""
    path = folder / "graphs" / f"{family}-{size}-{order}.mtx"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        graph = discovered(FAMILY[family](SIZES[size]), order, seed=1)
        unfinished = path.with_suffix(".part.mtx")
        scipy.io.mmwrite(unfinished, sp.tril(graph), field="pattern", symmetry="symmetric")
        # mmwrite calls the lower triangle "general" unless told that the rest is implied.
        unfinished.rename(path)
    return path


def from_edges(n: int, u: np.ndarray, v: np.ndarray) -> sp.csr_array:
    ones = np.ones(2 * len(u))
    both = (np.concatenate([u, v]), np.concatenate([v, u]))
    return sp.csr_array((ones, both), shape=(n, n))


def grid_edges(rows: int, cols: int) -> tuple[np.ndarray, np.ndarray]:
    cell = np.arange(rows * cols).reshape(rows, cols)
    across = (cell[:, :-1].ravel(), cell[:, 1:].ravel())
    down = (cell[:-1].ravel(), cell[1:].ravel())
    return np.concatenate([across[0], down[0]]), np.concatenate([across[1], down[1]])


def grid(n: int) -> sp.csr_array:
    """The square grid of about n cells."""
    side = round(n**0.5)
    return from_edges(side * side, *grid_edges(side, side))


def rooms(n: int) -> sp.csr_array:
    """A square of rooms of 9 × 9 cells, a door in the middle of each shared wall."""
    per_room = ROOM_SIDE**2 + 2
    count = round((n / per_room) ** 0.5)
    pitch = ROOM_SIDE + 1
    side = count * pitch - 1
    row, col = np.divmod(np.arange(side * side), side)
    wall_row, wall_col = row % pitch == ROOM_SIDE, col % pitch == ROOM_SIDE
    middle = ROOM_SIDE // 2
    cell_open = ~wall_row & ~wall_col
    door = (wall_row & (col % pitch == middle)) | (wall_col & (row % pitch == middle))
    is_open = cell_open | door
    number = np.cumsum(is_open) - 1
    u, v = grid_edges(side, side)
    kept = is_open[u] & is_open[v]
    return from_edges(int(is_open.sum()), number[u[kept]], number[v[kept]])


def maze(n: int) -> sp.csr_array:
    """A random depth-first spanning tree of the square grid, and 5 % of all other edges."""
    side = round(n**0.5)
    rng = np.random.default_rng(2)
    tree = depth_first_tree(side, rng)
    u, v = grid_edges(side, side)
    code = u * (side * side) + v
    kept = np.isin(code, tree) | (rng.random(len(u)) < LOOPS)
    return from_edges(side * side, u[kept], v[kept])


def depth_first_tree(side: int, rng: np.random.Generator) -> np.ndarray:
    """Edges (u, v), u < v, of the tree, each coded as u n + v."""
    n = side * side
    seen = bytearray(n)
    seen[0] = 1
    stack, tree = [0], []
    draws = iter(())
    while stack:
        u = stack[-1]
        r, c = divmod(u, side)
        fresh = []
        if r and not seen[u - side]:
            fresh.append(u - side)
        if r + 1 < side and not seen[u + side]:
            fresh.append(u + side)
        if c and not seen[u - 1]:
            fresh.append(u - 1)
        if c + 1 < side and not seen[u + 1]:
            fresh.append(u + 1)
        if not fresh:
            stack.pop()
            continue
        draw = next(draws, None)
        if draw is None:
            draws = iter(rng.random(65536).tolist())
            draw = next(draws)
        v = fresh[int(draw * len(fresh))]
        seen[v] = 1
        tree.append(min(u, v) * n + max(u, v))
        stack.append(v)
    return np.array(tree)


FAMILY = {"grid": grid, "rooms": rooms, "maze": maze}


def discovered(graph: sp.csr_array, order: str, seed: int) -> sp.csr_array:
    """The graph renumbered from node 0 on: next any node that borders on the known ones, all equally
    likely (`frontier`), or the one that has waited longest (`breadth`)."""
    starts, neighbors = graph.indptr.tolist(), graph.indices.tolist()
    n = graph.shape[0]
    draws = np.random.default_rng(seed).random(n).tolist()
    seen = bytearray(n)
    seen[0] = 1
    frontier, head, found = [0], 0, []
    for draw in draws:
        if order == "breadth":
            u = frontier[head]
            head += 1
        else:
            at = int(draw * len(frontier))
            u = frontier[at]
            frontier[at] = frontier[-1]
            frontier.pop()
        found.append(u)
        for v in neighbors[starts[u] : starts[u + 1]]:
            if not seen[v]:
                seen[v] = 1
                frontier.append(v)
    found = np.array(found)
    return graph[found][:, found]
