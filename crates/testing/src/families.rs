//! Families of small graphs that try a spectrum's patience: hubs, long tails, symmetries, wide weights, late joins.

use super::graphs::{self, Csr};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A graph by family name, about `n` nodes, in an order of discovery.
pub struct Family {
    pub name: &'static str,
    pub make: fn(n: usize, rng: &mut ChaCha8Rng) -> Csr,
}

/// Every family; `make` draws its details from `rng`.
pub const FAMILIES: [Family; 20] = [
    Family {
        name: "tree",
        make: |n, rng| graphs::discovered(&tree(n, rng), rng.random()),
    },
    Family {
        name: "caterpillar",
        make: |n, rng| graphs::discovered(&caterpillar(n, rng), rng.random()),
    },
    Family {
        name: "star",
        make: |n, _| graphs::star(n),
    },
    Family {
        name: "hubs",
        make: |n, rng| graphs::discovered(&hubs(n, rng), rng.random()),
    },
    Family {
        name: "complete",
        make: |n, _| graphs::complete(n),
    },
    Family {
        name: "bipartite",
        make: |n, rng| graphs::shuffled(&bipartite(n, rng), rng.random()),
    },
    Family {
        name: "hypercube",
        make: |n, rng| graphs::discovered(&hypercube(n), rng.random()),
    },
    Family {
        name: "torus",
        make: |n, rng| graphs::discovered(&torus(n, rng), rng.random()),
    },
    Family {
        name: "grid",
        make: |n, rng| graphs::discovered(&square(n), rng.random()),
    },
    Family {
        name: "rooms",
        make: |n, rng| graphs::discovered(&rooms(n), rng.random()),
    },
    Family {
        name: "maze",
        make: |n, rng| maze(n, rng),
    },
    Family {
        name: "cycles",
        make: |n, rng| graphs::shuffled(&graphs::cycle(n), rng.random()),
    },
    Family {
        name: "power law",
        make: power_law,
    },
    Family {
        name: "small world",
        make: |n, rng| graphs::discovered(&small_world(n, rng), rng.random()),
    },
    Family {
        name: "random",
        make: |n, rng| {
            graphs::discovered(
                &graphs::random(n, rng.random_range(1.0..8.0), rng.random()),
                rng.random(),
            )
        },
    },
    Family {
        name: "late joins",
        make: |n, rng| graphs::shuffled(&square(n), rng.random()),
    },
    Family {
        name: "equal parts",
        make: |n, rng| equal_parts(n, rng),
    },
    Family {
        name: "bridged parts",
        make: |n, rng| bridged_parts(n, rng),
    },
    Family {
        name: "clique chain",
        make: |n, rng| graphs::discovered(&clique_chain(n, rng), rng.random()),
    },
    Family {
        name: "wide weights",
        make: |n, rng| wide_weights(n, rng),
    },
];

/// Each node hangs on a random earlier one.
pub fn tree(n: usize, rng: &mut ChaCha8Rng) -> Csr {
    let edges: Vec<_> = (1..n).map(|i| (rng.random_range(0..i), i)).collect();
    graphs::from_edges(n, &edges)
}

/// A path with leaves: half of the nodes each.
fn caterpillar(n: usize, rng: &mut ChaCha8Rng) -> Csr {
    let spine = n / 2;
    let mut edges: Vec<_> = (1..spine).map(|i| (i - 1, i)).collect();
    edges.extend((spine..n).map(|i| (rng.random_range(0..spine), i)));
    graphs::from_edges(n, &edges)
}

/// A few hubs in a row that share all leaves among them.
fn hubs(n: usize, rng: &mut ChaCha8Rng) -> Csr {
    let count = rng.random_range(2..6);
    let mut edges: Vec<_> = (1..count).map(|i| (i - 1, i)).collect();
    edges.extend((count..n).map(|i| (i % count, i)));
    graphs::from_edges(n, &edges)
}

fn bipartite(n: usize, rng: &mut ChaCha8Rng) -> Csr {
    let left = rng.random_range(1..=n / 2);
    let edges = (0..left).flat_map(|i| (left..n).map(move |j| (i, j)));
    graphs::from_edges(n, &edges.collect::<Vec<_>>())
}

fn hypercube(n: usize) -> Csr {
    graphs::hypercube(n.ilog2() as usize)
}

/// A torus of one to three dimensions, all sides equal where there are several.
fn torus(n: usize, rng: &mut ChaCha8Rng) -> Csr {
    let dimensions = rng.random_range(1..=3u32);
    let side = (n as f64)
        .powf(1.0 / f64::from(dimensions))
        .round()
        .max(3.0) as usize;
    let edges = (0..side.pow(dimensions)).flat_map(|u| {
        (0..dimensions).map(move |d| {
            let stride = side.pow(d);
            let at = u / stride % side;
            (u, u - at * stride + (at + 1) % side * stride)
        })
    });
    graphs::from_edges(side.pow(dimensions), &edges.collect::<Vec<_>>())
}

fn square(n: usize) -> Csr {
    let side = (n as f64).sqrt().round() as usize;
    graphs::grid(side, side)
}

fn rooms(n: usize) -> Csr {
    let count = ((n as f64 / 11.0).sqrt().round() as usize).max(1);
    graphs::rooms(count, count, 3)
}

fn maze(n: usize, rng: &mut ChaCha8Rng) -> Csr {
    let side = (n as f64).sqrt().round() as usize;
    let loops = [0.0, 0.05, 0.3][rng.random_range(0..3)];
    let whole = graphs::maze(side, side, loops, rng.random());
    graphs::discovered(&whole, rng.random())
}

/// Preferential attachment (Barabási & Albert 1999): each node joins one to three ends of random edges. Nodes
/// keep their order of arrival.
pub fn power_law(n: usize, rng: &mut ChaCha8Rng) -> Csr {
    let links = rng.random_range(1..=3);
    let mut ends = vec![0, 1];
    let mut edges = std::collections::BTreeSet::from([(0, 1)]);
    for i in 2..n {
        for _ in 0..links {
            let j = ends[rng.random_range(0..ends.len())];
            if j != i && edges.insert((j, i)) {
                ends.extend([i, j]);
            }
        }
    }
    graphs::from_edges(n, &edges.into_iter().collect::<Vec<_>>())
}

/// A ring joined to the second neighbours, a tenth of the edges led elsewhere (Watts & Strogatz 1998).
pub fn small_world(n: usize, rng: &mut ChaCha8Rng) -> Csr {
    let mut edges = std::collections::BTreeSet::new();
    for u in 0..n {
        for step in [1, 2] {
            let far = rng.random_bool(0.1);
            let v = if far {
                rng.random_range(0..n)
            } else {
                (u + step) % n
            };
            if u != v {
                edges.insert((u.min(v), u.max(v)));
            }
        }
    }
    graphs::from_edges(n, &edges.into_iter().collect::<Vec<_>>())
}

/// Copies of one graph that never meet: every eigenvalue as often as there are copies.
fn equal_parts(n: usize, rng: &mut ChaCha8Rng) -> Csr {
    let copies = rng.random_range(2..=20);
    let part = match rng.random_range(0..3) {
        0 => graphs::cycle((n / copies).max(3)),
        1 => graphs::star((n / copies).max(2)),
        _ => tree((n / copies).max(2), rng),
    };
    graphs::shuffled(&graphs::disjoint(&vec![part; copies]), rng.random())
}

/// Two equal grids, discovered one after the other, that the last nodes join.
fn bridged_parts(n: usize, rng: &mut ChaCha8Rng) -> Csr {
    let part = square(n / 2 - 2);
    let parts = graphs::disjoint(&[part.clone(), part.clone(), graphs::path(3)]);
    let m = part.rows();
    let mut edges: Vec<_> = parts
        .iter()
        .filter(|(_, (i, j))| i < j)
        .map(|(&w, (i, j))| (i as usize, j as usize, w))
        .collect();
    edges.push((rng.random_range(0..m), 2 * m, 1.0));
    edges.push((rng.random_range(m..2 * m), 2 * m + 2, 1.0));
    graphs::from_weighted_edges(2 * m + 3, &edges)
}

/// Cliques in a ring, one edge from each to the next.
fn clique_chain(n: usize, rng: &mut ChaCha8Rng) -> Csr {
    let size = rng.random_range(3..=12);
    let count = (n / size).max(3);
    let mut edges = Vec::new();
    for c in 0..count {
        let first = c * size;
        edges.extend((0..size).flat_map(|i| (0..i).map(move |j| (first + j, first + i))));
        edges.push((first, (first + size + 1) % (count * size)));
    }
    graphs::from_edges(count * size, &edges)
}

/// A grid or a small world whose weights lie anywhere within twelve powers of ten.
fn wide_weights(n: usize, rng: &mut ChaCha8Rng) -> Csr {
    let graph = if rng.random_bool(0.5) {
        square(n)
    } else {
        small_world(n, rng)
    };
    let edges: Vec<_> = graph
        .iter()
        .filter(|(_, (i, j))| i < j)
        .map(|(_, (i, j))| {
            (
                i as usize,
                j as usize,
                10f64.powf(rng.random_range(-6.0..6.0)),
            )
        })
        .collect();
    graphs::discovered(
        &graphs::from_weighted_edges(graph.rows(), &edges),
        rng.random(),
    )
}

/// The generator of one case: its own for each family and number.
pub fn rng_of(family: usize, case: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(1000 * family as u64 + case)
}
