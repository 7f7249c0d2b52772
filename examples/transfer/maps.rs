//! Random maps of a family, as graphs whose node order is an order of discovery.

use eigentrail::env::{Cell, Direction, Doors, Layout, Tile};
use eigentrail::graph::{Adjacency, StateId, SymmetricCsr};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;

/// Worlds that are alike.
#[derive(Clone, Copy, Debug)]
pub enum Family {
    Rooms,
    Maze,
    Caves,
}

impl Family {
    pub const ALL: [Family; 3] = [Family::Rooms, Family::Maze, Family::Caves];

    /// A map of some 400 cells.
    pub fn map(self, rng: &mut ChaCha8Rng) -> SymmetricCsr {
        let layout = match self {
            Family::Rooms => Layout::rooms(4, 4, [5, 5], Doors::Random, rng),
            Family::Maze => Layout::maze(29, 29, 0.05, rng),
            Family::Caves => Layout::caves(26, 26, 0.4, 4, rng),
        };
        discovered(&layout.expect("sizes are legal"), rng)
    }
}

/// The free cells that can be reached from a random one, numbered in order of breadth-first discovery.
fn discovered(layout: &Layout, rng: &mut ChaCha8Rng) -> SymmetricCsr {
    let free: Vec<Cell> = layout.free_cells().collect();
    let first = free[rng.random_range(0..free.len())];
    let mut number = vec![None; layout.num_cells()];
    let mut graph = Adjacency::new();
    number[first.index()] = Some(graph.add_node());
    let mut queue = VecDeque::from([first]);
    while let Some(cell) = queue.pop_front() {
        let from = number[cell.index()].expect("queued cells are numbered");
        for direction in Direction::ALL {
            let Some(next) = layout.neighbor(cell, direction) else {
                continue;
            };
            if layout.tile(next) == Tile::Wall {
                continue;
            }
            let to = *number[next.index()].get_or_insert_with(|| {
                queue.push_back(next);
                graph.add_node()
            });
            graph.add_edge(from, to, 1.0);
        }
    }
    graph.to_csr()
}

/// The edges i < j.
fn edges(graph: &SymmetricCsr) -> Vec<(u32, u32)> {
    let from = |i: usize| graph.row(i).0.iter().map(move |&j| (i as u32, j));
    let all = (0..graph.num_nodes()).flat_map(from);
    all.filter(|(i, j)| i < j).collect()
}

fn from_edges(nodes: usize, edges: impl IntoIterator<Item = (u32, u32)>) -> SymmetricCsr {
    let mut graph = Adjacency::with_nodes(nodes);
    for (i, j) in edges {
        graph.add_edge(i, j, 1.0);
    }
    graph.to_csr()
}

/// `graph` as an agent knows it that has not tried every door: a share of its edges is missing, never the one by
/// which a node was discovered.
pub fn with_missing_edges(graph: &SymmetricCsr, share: f64, rng: &mut ChaCha8Rng) -> SymmetricCsr {
    let mut found = vec![false; graph.num_nodes()];
    let mut kept = Vec::new();
    for (i, j) in edges(graph) {
        // The smallest neighbour of a node in this order is the one it was discovered from.
        let discovers = !std::mem::replace(&mut found[j as usize], true);
        if discovers || rng.random::<f64>() >= share {
            kept.push((i, j));
        }
    }
    from_edges(graph.num_nodes(), kept)
}

/// `graph` as an agent knows it that now and then takes one state for another: edges between random nodes are added,
/// a share of those there are.
pub fn with_false_edges(graph: &SymmetricCsr, share: f64, rng: &mut ChaCha8Rng) -> SymmetricCsr {
    let mut all = edges(graph);
    let nodes = graph.num_nodes() as u32;
    for _ in 0..(share * all.len() as f64).round() as usize {
        let (i, j) = (rng.random_range(0..nodes), rng.random_range(0..nodes));
        if i != j {
            all.push((i.min(j), i.max(j)));
        }
    }
    from_edges(graph.num_nodes(), all)
}

/// Any node.
pub fn random_node(nodes: usize, rng: &mut ChaCha8Rng) -> StateId {
    StateId(rng.random_range(0..nodes as u32))
}
