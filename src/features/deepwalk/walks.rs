//! Random walks: P(i → j) = A_ij / Σ_k A_ik.

use crate::features::FeatureError;
use crate::graph::Csr;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Draws walks on a weighted graph: O(log degree) a step.
pub struct Walker<'a> {
    adjacency: &'a Csr,
    /// Running sums of each row's weights, in the places of the weights.
    sums: Vec<f64>,
}

impl<'a> Walker<'a> {
    /// A walker on `adjacency`. O(n + nnz).
    ///
    /// # Errors
    /// [`FeatureError::Weight`] if a weight is not finite and positive.
    pub fn new(adjacency: &'a Csr) -> Result<Self, FeatureError> {
        let mut sums = Vec::with_capacity(adjacency.nnz());
        for (row, entries) in adjacency.outer_iterator().enumerate() {
            let mut sum = 0.0;
            for (column, &value) in entries.iter() {
                if !(value > 0.0 && value.is_finite()) {
                    return Err(FeatureError::Weight { row, column, value });
                }
                sum += value;
                sums.push(sum);
            }
        }
        Ok(Self { adjacency, sums })
    }

    /// Sum of the weights at `node`; 0 if it is isolated.
    pub fn degree(&self, node: usize) -> f64 {
        let range = self.adjacency.indptr().outer_inds_sz(node);
        self.sums[range].last().copied().unwrap_or(0.0)
    }

    /// A neighbour of `node`, drawn by weight; none if it is isolated.
    pub fn step(&self, node: u32, rng: &mut ChaCha8Rng) -> Option<u32> {
        let range = self.adjacency.indptr().outer_inds_sz(node as usize);
        let place = draw(&self.sums[range.clone()], rng)?;
        Some(self.adjacency.indices()[range][place])
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
        let walker = Walker::new(&graph).unwrap();
        let mut rng = stream(0, Stream::Walks);
        let mut walk = Vec::new();
        for start in 0..10 {
            walker.walk(start, 50, &mut rng, &mut walk);
            assert_eq!((walk[0], walk.len()), (start, 50));
            for pair in walk.windows(2) {
                assert!(graph.get(pair[0] as usize, pair[1] as usize).is_some());
            }
        }
    }

    #[test]
    fn a_walk_from_an_isolated_node_stays_there() {
        let graph = weighted(3, &[(0, 1, 1.0)]);
        let walker = Walker::new(&graph).unwrap();
        let mut walk = vec![9];
        walker.walk(2, 4, &mut stream(0, Stream::Walks), &mut walk);
        assert_eq!((walk, walker.degree(2)), (vec![2], 0.0));
    }

    #[test]
    fn steps_are_drawn_by_weight() {
        let graph = weighted(3, &[(0, 1, 1.0), (0, 2, 4.0)]);
        let walker = Walker::new(&graph).unwrap();
        let mut rng = stream(1, Stream::Walks);
        let draws = 10_000;
        let heavy = (0..draws).filter(|_| walker.step(0, &mut rng) == Some(2));
        let share = heavy.count() as f64 / draws as f64;
        // Four standard errors: 4 √(.8 · .2 / 10 000).
        assert!((share - 0.8).abs() < 0.016, "{share}");
    }

    #[test]
    fn weights_that_cannot_be_walked_are_an_error() {
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let graph = weighted(2, &[(0, 1, value)]);
            let error = Walker::new(&graph).err();
            assert!(matches!(
                error,
                Some(FeatureError::Weight {
                    row: 0,
                    column: 1,
                    ..
                })
            ));
        }
    }
}
