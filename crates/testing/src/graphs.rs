//! Graphs for tests and benches: closed forms, grids, rooms, mazes, orders of discovery, growth.

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sprs::{CsMatI, TriMatI};

/// Symmetric adjacency by rows.
pub type Csr = CsMatI<f64, u32>;

/// Unit-weight graph of `n` nodes.
pub fn from_edges(n: usize, edges: &[(usize, usize)]) -> Csr {
    let weighted: Vec<_> = edges.iter().map(|&(u, v)| (u, v, 1.0)).collect();
    from_weighted_edges(n, &weighted)
}

/// Weighted graph of `n` nodes; each edge is given once.
pub fn from_weighted_edges(n: usize, edges: &[(usize, usize, f64)]) -> Csr {
    let mut triplets: TriMatI<f64, u32> = TriMatI::new((n, n));
    for &(u, v, w) in edges {
        triplets.add_triplet(u, v, w);
        if u != v {
            triplets.add_triplet(v, u, w);
        }
    }
    triplets.to_csr()
}

pub fn path(n: usize) -> Csr {
    from_edges(n, &(1..n).map(|i| (i - 1, i)).collect::<Vec<_>>())
}

pub fn cycle(n: usize) -> Csr {
    from_edges(n, &(0..n).map(|i| (i, (i + 1) % n)).collect::<Vec<_>>())
}

pub fn complete(n: usize) -> Csr {
    let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (i, j)));
    from_edges(n, &pairs.collect::<Vec<_>>())
}

/// One hub, n − 1 leaves.
pub fn star(n: usize) -> Csr {
    from_edges(n, &(1..n).map(|i| (0, i)).collect::<Vec<_>>())
}

/// 2^d nodes.
pub fn hypercube(d: usize) -> Csr {
    let edges = (0..1usize << d).flat_map(|i| (0..d).map(move |b| (i, i ^ (1 << b))));
    from_edges(1 << d, &edges.filter(|(i, j)| i < j).collect::<Vec<_>>())
}

/// Cells in reading order, joined to their four neighbours.
pub fn grid(rows: usize, cols: usize) -> Csr {
    cells(rows, cols, |_, _| true)
}

/// rows × cols rooms of side × side cells with walls one cell thick and a door in the middle of
/// each shared wall.
pub fn rooms(rows: usize, cols: usize, side: usize) -> Csr {
    let pitch = side + 1;
    let open = |r: usize, c: usize| {
        let (wall_r, wall_c) = (r % pitch == side, c % pitch == side);
        match (wall_r, wall_c) {
            (false, false) => true,
            (true, true) => false,
            (true, false) => c % pitch == side / 2,
            (false, true) => r % pitch == side / 2,
        }
    };
    cells(rows * pitch - 1, cols * pitch - 1, open)
}

/// Random spanning tree of a grid, drawn by a depth-first walk, with `loops` of the remaining
/// edges added.
pub fn maze(rows: usize, cols: usize, loops: f64, seed: u64) -> Csr {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let n = rows * cols;
    let neighbors = |u: usize| {
        let (r, c) = (u / cols, u % cols);
        let mut around = Vec::new();
        if r > 0 {
            around.push(u - cols);
        }
        if r + 1 < rows {
            around.push(u + cols);
        }
        if c > 0 {
            around.push(u - 1);
        }
        if c + 1 < cols {
            around.push(u + 1);
        }
        around
    };
    let mut seen = vec![false; n];
    let mut edges = std::collections::BTreeSet::new();
    let mut stack = vec![0];
    seen[0] = true;
    while let Some(&u) = stack.last() {
        let fresh: Vec<usize> = neighbors(u).into_iter().filter(|&v| !seen[v]).collect();
        if fresh.is_empty() {
            stack.pop();
            continue;
        }
        let v = fresh[rng.random_range(0..fresh.len())];
        seen[v] = true;
        edges.insert((u.min(v), u.max(v)));
        stack.push(v);
    }
    for u in 0..n {
        for v in neighbors(u) {
            if u < v && rng.random_bool(loops) {
                edges.insert((u, v));
            }
        }
    }
    from_edges(n, &edges.into_iter().collect::<Vec<_>>())
}

fn cells(rows: usize, cols: usize, open: impl Fn(usize, usize) -> bool) -> Csr {
    let mut number = vec![usize::MAX; rows * cols];
    let mut n = 0;
    let mut edges = Vec::new();
    for r in 0..rows {
        for c in 0..cols {
            if !open(r, c) {
                continue;
            }
            number[r * cols + c] = n;
            if r > 0 && number[(r - 1) * cols + c] != usize::MAX {
                edges.push((number[(r - 1) * cols + c], n));
            }
            if c > 0 && number[r * cols + c - 1] != usize::MAX {
                edges.push((number[r * cols + c - 1], n));
            }
            n += 1;
        }
    }
    from_edges(n, &edges)
}

/// Erdős–Rényi graph with weights in (0.5, 1.5), a few loops included: often disconnected.
pub fn random(n: usize, mean_degree: f64, seed: u64) -> Csr {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let p = (mean_degree / n as f64).min(1.0);
    let mut edges = Vec::new();
    for i in 0..n {
        for j in 0..=i {
            if rng.random_bool(if i == j { p / 4.0 } else { p }) {
                edges.push((i, j, 0.5 + rng.random::<f64>()));
            }
        }
    }
    from_weighted_edges(n, &edges)
}

/// The graphs side by side.
pub fn disjoint(parts: &[Csr]) -> Csr {
    let n = parts.iter().map(Csr::rows).sum();
    let mut edges = Vec::new();
    let mut first = 0;
    for part in parts {
        for (i, row) in part.outer_iterator().enumerate() {
            edges.extend(
                row.iter()
                    .filter(|&(j, _)| j <= i)
                    .map(|(j, &w)| (first + i, first + j, w)),
            );
        }
        first += part.rows();
    }
    from_weighted_edges(n, &edges)
}

/// The graph with node `order[i]` renamed `i`.
pub fn renumber(graph: &Csr, order: &[usize]) -> Csr {
    let mut name = vec![0; order.len()];
    for (i, &u) in order.iter().enumerate() {
        name[u] = i;
    }
    let mut edges = Vec::new();
    for (i, row) in graph.outer_iterator().enumerate() {
        edges.extend(
            row.iter()
                .filter(|&(j, _)| j <= i)
                .map(|(j, &w)| (name[i], name[j], w)),
        );
    }
    from_weighted_edges(order.len(), &edges)
}

/// The graph in random-frontier order of discovery: from node 0, next any node that borders on the
/// known ones, all equally likely. Components follow one another.
pub fn discovered(graph: &Csr, seed: u64) -> Csr {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let n = graph.rows();
    let mut seen = vec![false; n];
    let mut order = Vec::with_capacity(n);
    for root in 0..n {
        if seen[root] {
            continue;
        }
        seen[root] = true;
        let mut frontier = vec![root];
        while !frontier.is_empty() {
            let at = rng.random_range(0..frontier.len());
            let u = frontier.swap_remove(at);
            order.push(u);
            for (v, _) in graph.outer_view(u).expect("node in range").iter() {
                if !seen[v] {
                    seen[v] = true;
                    frontier.push(v);
                }
            }
        }
    }
    renumber(graph, &order)
}

/// The graph with its nodes in random order: prefixes are mostly isolated nodes that join later.
pub fn shuffled(graph: &Csr, seed: u64) -> Csr {
    let mut order: Vec<usize> = (0..graph.rows()).collect();
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    renumber(graph, &order)
}

/// The subgraph of the first `m` nodes.
pub fn prefix(graph: &Csr, m: usize) -> Csr {
    let mut edges = Vec::new();
    for (i, row) in graph.outer_iterator().enumerate().take(m) {
        edges.extend(row.iter().filter(|&(j, _)| j <= i).map(|(j, &w)| (i, j, w)));
    }
    from_weighted_edges(m, &edges)
}

/// Sizes of a growing graph: `start`, each time `growth` more, `n`.
pub fn sizes(start: usize, growth: f64, n: usize) -> Vec<usize> {
    let mut sizes = vec![start.min(n)];
    while let Some(&m) = sizes.last() {
        if m == n {
            break;
        }
        sizes.push(
            ((m as f64 * (1.0 + growth)).ceil() as usize)
                .max(m + 1)
                .min(n),
        );
    }
    sizes
}
