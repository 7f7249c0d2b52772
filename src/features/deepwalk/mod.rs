//! DeepWalk: nodes that random walks pass close to each other get similar vectors.
//!
//! Walks on the visited graph are read as sentences and nodes as words: each node of a walk and each node within a
//! window around it is a pair for [skip-gram with negative sampling](SkipGram). Noise is drawn by degree^¾, the ¾ of
//! Mikolov et al. 2013 applied to how often walks visit a node.
//!
//! **A growing graph.** A new node starts as the mean of its older neighbours. A refresh walks from the nodes that are
//! new or have a new edge, and from as many others, drawn at random, so that the old vectors give way where they must;
//! walks and window make the cost, O(walks · length · window · negatives · dimensions), independent of the rest.
//! Vectors continue from where they were, so they need no alignment.
//!
//! Sequential by intention: each pair starts from the vectors that the one before has left, and equal seeds give equal
//! bits.
//!
//! B. Perozzi, R. Al-Rfou, S. Skiena, *DeepWalk: online learning of social representations*, KDD 2014 · T. Mikolov,
//! I. Sutskever, K. Chen, G. Corrado, J. Dean, *Distributed representations of words and phrases and their
//! compositionality*, NIPS 2013.

mod params;
mod saved;
mod skip_gram;
mod walks;

pub use params::DeepWalkParams;

use super::FeatureError;
use crate::graph::SymmetricCsr;
use crate::seeds::{Stream, stream};
use faer::{Mat, MatRef};
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use saved::Saved;
use serde::{Deserialize, Serialize};
use skip_gram::SkipGram;
use walks::RandomWalker;

/// Noise ∝ degree^this.
const NOISE_POWER: f64 = 0.75;

/// The step size falls to this part of where it began.
const LAST_RATE: f64 = 0.01;

/// Walks, pairs and loss of a refresh.
#[derive(Clone, Debug, PartialEq)]
pub struct EmbeddingRefresh {
    /// Nodes there are.
    pub nodes: usize,
    /// Walks drawn.
    pub walks: usize,
    /// Pairs trained on.
    pub pairs: usize,
    /// Mean J of a pair on its way; 0 without pairs.
    pub loss: f64,
}

/// Skip-gram vectors of a growing graph. A plain value.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Saved")]
pub struct DeepWalk {
    params: DeepWalkParams,
    rng: ChaCha8Rng,
    model: SkipGram,
    /// Neighbours of each node at the last refresh.
    row_lengths: Vec<usize>,
    #[serde(with = "crate::spectral::plain::maybe_matrix")]
    features: Option<Mat<f64>>,
}

impl DeepWalk {
    /// Nothing yet. `params` are checked by the first [`refresh`](Self::refresh).
    pub fn new(params: DeepWalkParams, seed: u64) -> Self {
        Self {
            model: SkipGram::new(params.dimensions),
            params,
            rng: stream(seed, Stream::Walks),
            row_lengths: Vec::new(),
            features: None,
        }
    }

    /// Fits the vectors to a graph that has grown since the last call (rows and entries only added).
    ///
    /// # Errors
    /// If a parameter is out of range, after which everything is as it was, or if the vectors diverged.
    ///
    /// # Panics
    /// If the graph has fewer nodes than at the last call.
    pub fn refresh(&mut self, adjacency: &SymmetricCsr) -> Result<EmbeddingRefresh, FeatureError> {
        self.params.validate()?;
        let walker = RandomWalker::new(adjacency);
        assert!(
            adjacency.num_nodes() >= self.model.num_nodes(),
            "a graph of {} nodes has shrunk to {}",
            self.model.num_nodes(),
            adjacency.num_nodes()
        );
        self.add_nodes(adjacency);
        let starts = self.starts(adjacency);
        let refresh = self.train(&walker, &starts);
        self.features = Some(self.scaled()?);
        Ok(refresh)
    }

    /// x of every node, n × dimensions, scaled to entries of mean square 1. `None` before the first refresh.
    pub fn features(&self) -> Option<MatRef<'_, f64>> {
        self.features.as_ref().map(Mat::as_ref)
    }

    fn add_nodes(&mut self, adjacency: &SymmetricCsr) {
        for i in self.model.num_nodes()..adjacency.num_nodes() {
            let neighbors = adjacency.row(i).0;
            // On the very first graph means of means would be all alike.
            let older = match self.row_lengths.is_empty() {
                true => 0,
                false => neighbors.partition_point(|&j| (j as usize) < i),
            };
            self.model.push(&neighbors[..older], &mut self.rng);
        }
    }

    /// Nodes with new edges, each `walks_per_node` times, and as many others; in random order.
    fn starts(&mut self, adjacency: &SymmetricCsr) -> Vec<u32> {
        let n = adjacency.num_nodes();
        let lengths: Vec<usize> = (0..n).map(|i| adjacency.row(i).0.len()).collect();
        let changed: Vec<u32> = (0..n)
            .filter(|&i| self.row_lengths.get(i) != Some(&lengths[i]))
            .map(|i| i as u32)
            .collect();
        let others = changed.len().min(n - changed.len());
        self.row_lengths = lengths;
        let mut starts = Vec::with_capacity((changed.len() + others) * self.params.walks_per_node);
        for _ in 0..self.params.walks_per_node {
            starts.extend_from_slice(&changed);
            starts.extend((0..others).map(|_| self.rng.random_range(0..n) as u32));
        }
        starts.shuffle(&mut self.rng);
        starts
    }

    fn train(&mut self, walker: &RandomWalker<'_>, starts: &[u32]) -> EmbeddingRefresh {
        let mut total = 0.0;
        let noise: Vec<f64> = (0..self.model.num_nodes())
            .map(|i| {
                total += libm::pow(walker.degree(i), NOISE_POWER);
                total
            })
            .collect();
        let mut refresh = EmbeddingRefresh {
            nodes: self.model.num_nodes(),
            walks: starts.len(),
            pairs: 0,
            loss: 0.0,
        };
        let mut walk = Vec::with_capacity(self.params.walk_length);
        for (number, &start) in starts.iter().enumerate() {
            let left = 1.0 - number as f64 / starts.len() as f64;
            let rate = self.params.learning_rate * left.max(LAST_RATE);
            walker.walk(start, self.params.walk_length, &mut self.rng, &mut walk);
            self.train_on(&walk, &noise, rate, &mut refresh);
        }
        refresh.loss /= refresh.pairs.max(1) as f64;
        refresh
    }

    /// All pairs of one walk. The window is drawn anew around each node, up to its full width, so that near nodes
    /// count more.
    fn train_on(&mut self, walk: &[u32], noise: &[f64], rate: f64, refresh: &mut EmbeddingRefresh) {
        let mut negatives = Vec::with_capacity(self.params.negatives);
        for (place, &centre) in walk.iter().enumerate() {
            let reach = self.rng.random_range(1..=self.params.window);
            let window = place.saturating_sub(reach)..(place + reach + 1).min(walk.len());
            for other in window.filter(|&other| walk[other] != centre) {
                negatives.clear();
                for _ in 0..self.params.negatives {
                    negatives.extend(walks::draw(noise, &mut self.rng).map(|k| k as u32));
                }
                refresh.loss += self.model.step(centre, walk[other], &negatives, rate);
                refresh.pairs += 1;
            }
        }
    }

    fn scaled(&self) -> Result<Mat<f64>, FeatureError> {
        let x = self.model.centres();
        let mean_square = x.iter().map(|v| v * v).sum::<f64>() / x.len().max(1) as f64;
        if !mean_square.is_finite() {
            return Err(FeatureError::Diverged);
        }
        let scale = if mean_square > 0.0 {
            mean_square.sqrt().recip()
        } else {
            0.0
        };
        let (n, d) = (self.model.num_nodes(), self.params.dimensions);
        Ok(Mat::from_fn(n, d, |i, c| scale * x[i * d + c]))
    }
}

#[cfg(test)]
pub(super) mod testing {
    use crate::graph::SymmetricCsr;

    pub fn weighted(n: usize, edges: &[(usize, usize, f64)]) -> SymmetricCsr {
        let mut triplets = sprs::TriMatI::<f64, u32>::new((n, n));
        for &(i, j, weight) in edges {
            triplets.add_triplet(i, j, weight);
            triplets.add_triplet(j, i, weight);
        }
        SymmetricCsr::new(triplets.to_csr()).unwrap()
    }

    /// Two complete graphs of `size` nodes, joined by the edge between nodes 0 and `size`.
    pub fn two_cliques(size: usize) -> SymmetricCsr {
        let mut edges = vec![(0, size, 1.0)];
        for first in [0, size] {
            for i in 0..size {
                edges.extend((0..i).map(|j| (first + j, first + i, 1.0)));
            }
        }
        weighted(2 * size, &edges)
    }
}

#[cfg(test)]
mod tests {
    use super::testing::{two_cliques, weighted};
    use super::*;

    fn similarity(x: MatRef<'_, f64>, i: usize, j: usize) -> f64 {
        let dot = |i: usize, j: usize| (0..x.ncols()).map(|c| x[(i, c)] * x[(j, c)]).sum::<f64>();
        dot(i, j) / (dot(i, i) * dot(j, j)).sqrt()
    }

    /// The nearest node of every node is one of its own clique.
    #[test]
    fn cliques_joined_by_an_edge_come_apart() {
        let size = 10;
        let mut deepwalk = DeepWalk::new(DeepWalkParams::default(), 0);
        let refresh = deepwalk.refresh(&two_cliques(size)).unwrap();
        assert_eq!((refresh.nodes, refresh.walks), (20, 200));
        // Telling nothing apart costs ln 2 for each of 1 + 5 nodes.
        assert!(refresh.loss > 0.0 && refresh.loss < 6.0 * 2_f64.ln());
        let x = deepwalk.features().unwrap();
        assert!((x.squared_norm_l2() / 320.0 - 1.0).abs() < 1e-12);
        for i in 0..2 * size {
            let nearest = (0..2 * size)
                .filter(|&j| j != i)
                .max_by(|&a, &b| similarity(x, i, a).total_cmp(&similarity(x, i, b)));
            assert_eq!(nearest.map(|j| j < size), Some(i < size), "node {i}");
        }
    }

    #[test]
    fn equal_seeds_give_equal_bits() {
        let embed = |seed| {
            let mut deepwalk = DeepWalk::new(DeepWalkParams::default(), seed);
            deepwalk.refresh(&two_cliques(4)).unwrap();
            deepwalk.features().unwrap().to_owned()
        };
        assert_eq!(embed(5), embed(5));
        assert_ne!(embed(5), embed(6));
    }

    /// A path that grows by one node in twenty: old vectors keep their direction, the new node joins its neighbour.
    #[test]
    fn vectors_continue_when_the_graph_grows() {
        let path = |n: usize| weighted(n, &(1..n).map(|i| (i - 1, i, 1.0)).collect::<Vec<_>>());
        let mut deepwalk = DeepWalk::new(DeepWalkParams::default(), 2);
        deepwalk.refresh(&path(60)).unwrap();
        let before = deepwalk.features().unwrap().to_owned();
        let refresh = deepwalk.refresh(&path(61)).unwrap();
        assert_eq!(
            refresh.walks, 40,
            "from nodes 59 and 60 and two others, ten each"
        );
        let after = deepwalk.features().unwrap();
        let both = Mat::from_fn(120, 16, |i, c| {
            if i < 60 {
                before[(i, c)]
            } else {
                after[(i - 60, c)]
            }
        });
        let mean = (0..60)
            .map(|i| similarity(both.as_ref(), i, 60 + i))
            .sum::<f64>()
            / 60.0;
        assert!(mean > 0.95, "{mean}");
        assert!(similarity(after, 60, 59) > similarity(after, 60, 20));
    }

    #[test]
    fn nothing_new_costs_nothing_and_nothing_connected_is_no_error() {
        let mut deepwalk = DeepWalk::new(DeepWalkParams::default(), 0);
        let lonely = deepwalk.refresh(&weighted(3, &[])).unwrap();
        assert_eq!((lonely.pairs, lonely.loss), (0, 0.0));
        let before = deepwalk.features().unwrap().to_owned();
        assert_eq!(deepwalk.refresh(&weighted(3, &[])).unwrap().walks, 0);
        assert_eq!(deepwalk.features().unwrap(), before);
    }

    #[test]
    fn errors_leave_the_vectors_as_they_were() {
        let mut deepwalk = DeepWalk::new(DeepWalkParams::default(), 0);
        deepwalk.refresh(&two_cliques(3)).unwrap();
        let before = deepwalk.features().unwrap().to_owned();
        deepwalk.params.dimensions = 0;
        assert!(deepwalk.refresh(&two_cliques(4)).is_err());
        assert_eq!(deepwalk.features().unwrap(), before);
        let params = DeepWalkParams {
            learning_rate: 1e200,
            ..DeepWalkParams::default()
        };
        let wild = DeepWalk::new(params, 0).refresh(&two_cliques(4));
        assert_eq!(wild, Err(FeatureError::Diverged));
    }
}
