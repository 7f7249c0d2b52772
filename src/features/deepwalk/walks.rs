//! Random walks: P(i → j) = A_ij / Σ_k A_ik.

use crate::graph::SymmetricCsr;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::ops::Range;

/// Draws walks on a weighted graph: O(log degree) a step.
pub struct RandomWalker<'a> {
    adjacency: &'a SymmetricCsr,
    /// Running sums of each row's weights, in the places of the weights.
    sums: Vec<f64>,
}

impl<'a> RandomWalker<'a> {
    /// A walker on `adjacency`. O(n + nnz).
    pub fn new(adjacency: &'a SymmetricCsr) -> Self {
        let mut sums = Vec::with_capacity(adjacency.nnz());
        for i in 0..adjacency.num_nodes() {
            let mut sum = 0.0;
            for weight in adjacency.row(i).1 {
                sum += weight;
                sums.push(sum);
            }
        }
        Self { adjacency, sums }
    }

    /// Sum of the weights at `node`; 0 if it is isolated.
    pub fn degree(&self, node: usize) -> f64 {
        self.sums[self.entries(node)].last().copied().unwrap_or(0.0)
    }

    /// A neighbour of `node`, drawn by weight; none if it is isolated.
    pub fn step(&self, node: u32, rng: &mut ChaCha8Rng) -> Option<u32> {
        let place = draw(&self.sums[self.entries(node as usize)], rng)?;
        Some(self.adjacency.row(node as usize).0[place])
    }

    /// Where the entries of a row are among all.
    fn entries(&self, row: usize) -> Range<usize> {
        self.adjacency.as_csr().indptr().outer_inds_sz(row)
    }

    /// Writes a walk of `length` nodes from `start` into `walk`; shorter if it gets stuck in an isolated node.
    pub fn walk(&self, start: u32, length: usize, rng: &mut ChaCha8Rng, walk: &mut Vec<u32>) {
        walk.clear();
        walk.push(start);
        let mut at = start;
        while walk.len() < length {
            match self.step(at, rng) {
                Some(next) => at = next,
                None => return,
            }
            walk.push(at);
        }
    }
}

/// A place drawn by its share of running sums; none if there are no places or all have weight 0.
pub fn draw(sums: &[f64], rng: &mut ChaCha8Rng) -> Option<usize> {
    let total = sums.last().copied().filter(|&total| total > 0.0)?;
    let point = total * rng.random::<f64>();
    // Rounding may put the point onto the total itself.
    Some(
        sums.partition_point(|&sum| sum <= point)
            .min(sums.len() - 1),
    )
}

#[cfg(test)]
mod tests {
    use super::super::testing::{two_cliques, weighted};
    use super::*;
    use crate::seeds::{Stream, stream};

    #[test]
    fn walks_follow_edges_and_have_their_length() {
        let graph = two_cliques(5);
        let walker = RandomWalker::new(&graph);
        let mut rng = stream(0, Stream::Walks);
        let mut walk = Vec::new();
        for start in 0..10 {
            walker.walk(start, 50, &mut rng, &mut walk);
            assert_eq!((walk[0], walk.len()), (start, 50));
            for pair in walk.windows(2) {
                assert!(graph.row(pair[0] as usize).0.contains(&pair[1]));
            }
        }
    }

    #[test]
    fn a_walk_from_an_isolated_node_stays_there() {
        let graph = weighted(3, &[(0, 1, 1.0)]);
        let walker = RandomWalker::new(&graph);
        let mut walk = vec![9];
        walker.walk(2, 4, &mut stream(0, Stream::Walks), &mut walk);
        assert_eq!((walk, walker.degree(2)), (vec![2], 0.0));
    }

    #[test]
    fn steps_are_drawn_by_weight() {
        let graph = weighted(3, &[(0, 1, 1.0), (0, 2, 4.0)]);
        let walker = RandomWalker::new(&graph);
        let mut rng = stream(1, Stream::Walks);
        let draws = 10_000;
        let heavy = (0..draws).filter(|_| walker.step(0, &mut rng) == Some(2));
        let share = heavy.count() as f64 / draws as f64;
        // Four standard errors: 4 √(.8 · .2 / 10 000).
        assert!((share - 0.8).abs() < 0.016, "{share}");
    }
}
