//! The transition matrix P of the walk that the potentials average over.
//!
//! ```text
//! P_ij = mean over the actions a tried at i of  N(i, a, j) / Σ_{k≠i} N(i, a, k)      all actions of i tried
//! P_ij = A_ij / Σ_{k≠i} A_ik                                                          some action untried
//! ```
//!
//! While a state has untried actions its undirected neighbours stand in: the way back is then assumed open, which is
//! the optimistic guess. Once every action was tried the observed moves alone count, so a door that opens one way
//! is one edge.
//!
//! **Self-transitions are left out.** A bump into a wall tells that an action is useless, not that the cell is
//! dear: with bumps counted, cells along walls would look farther from the goal than they are (a corner by ln 2 per
//! bump), and the potential would push the agent off the walls that its shortest path may follow. What waiting
//! really costs is in the rewards, hence in the step costs. The same holds for an action that slips in place.

use crate::env::Action;
use crate::graph::{StateId, SymmetricCsr, TransitionGraph};

/// A move that weighs less beside its alternatives counts as this likely: still a move, and no underflow.
const SMALLEST_PROBABILITY: f64 = 1e-30;

/// Rows of P: probabilities over the next state, without self-transitions; a row is empty where there is no way on.
#[derive(Clone, Debug, PartialEq)]
pub struct TransitionMatrix {
    /// `num_states + 1` offsets into the two arrays below.
    offsets: Vec<usize>,
    targets: Vec<u32>,
    probabilities: Vec<f64>,
}

impl TransitionMatrix {
    /// P of a world as far as it was observed. O(n + transitions).
    ///
    /// # Panics
    /// If `adjacency` has not one row per state of `graph`.
    pub fn observed(graph: &TransitionGraph, adjacency: &SymmetricCsr) -> Self {
        let n = graph.num_states();
        assert_eq!(
            adjacency.num_nodes(),
            n,
            "the adjacency must be that of the transition graph"
        );
        let mut rows = Self::with_capacity(n, adjacency.nnz());
        let mut row = Vec::new();
        for i in 0..n {
            let state = StateId(i as u32);
            if graph.untried_actions(state) == 0 {
                empirical_row(graph, state, &mut row);
            } else {
                undirected_row(adjacency, i, &mut row);
            }
            rows.push_row(&mut row);
        }
        rows
    }

    /// P of an undirected graph: its weights, normalised by row. O(n + nnz).
    pub fn undirected(adjacency: &SymmetricCsr) -> Self {
        let mut rows = Self::with_capacity(adjacency.num_nodes(), adjacency.nnz());
        let mut row = Vec::new();
        for i in 0..adjacency.num_nodes() {
            undirected_row(adjacency, i, &mut row);
            rows.push_row(&mut row);
        }
        rows
    }

    fn with_capacity(n: usize, nnz: usize) -> Self {
        let mut offsets = Vec::with_capacity(n + 1);
        offsets.push(0);
        Self {
            offsets,
            targets: Vec::with_capacity(nnz),
            probabilities: Vec::with_capacity(nnz),
        }
    }

    /// Appends the normalised row, parallel entries merged.
    fn push_row(&mut self, row: &mut Vec<(u32, f64)>) {
        row.sort_unstable_by_key(|&(target, _)| target);
        row.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1 += next.1;
            }
            same
        });
        let total: f64 = row.iter().map(|&(_, weight)| weight).sum();
        for &(target, weight) in row.iter() {
            self.targets.push(target);
            self.probabilities
                .push((weight / total).max(SMALLEST_PROBABILITY));
        }
        self.offsets.push(self.targets.len());
        row.clear();
    }

    /// Number of states.
    pub fn num_states(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Number of entries of P.
    pub fn nnz(&self) -> usize {
        self.targets.len()
    }

    /// The next states of `i`, ascending, and their probabilities.
    pub fn row(&self, i: usize) -> (&[u32], &[f64]) {
        let range = self.offsets[i]..self.offsets[i + 1];
        (&self.targets[range.clone()], &self.probabilities[range])
    }

    /// The transposed pattern: offsets, and for each state the states that lead to it, ascending.
    pub(crate) fn predecessors(&self) -> (Vec<usize>, Vec<u32>) {
        let n = self.num_states();
        let mut offsets = vec![0; n + 1];
        self.targets
            .iter()
            .for_each(|&j| offsets[j as usize + 1] += 1);
        (0..n).for_each(|j| offsets[j + 1] += offsets[j]);
        let mut next = offsets.clone();
        let mut sources = vec![0; self.nnz()];
        for i in 0..n {
            for &j in self.row(i).0 {
                sources[next[j as usize]] = i as u32;
                next[j as usize] += 1;
            }
        }
        (offsets, sources)
    }
}

/// Each tried action weighs the same; within one, outcomes weigh by how often they were seen.
fn empirical_row(graph: &TransitionGraph, state: StateId, row: &mut Vec<(u32, f64)>) {
    let moves = || graph.outcomes(state).filter(move |o| o.next != state);
    let seen_of = |action: Action| -> f64 {
        moves()
            .filter(|o| o.action == action)
            .map(|o| f64::from(o.count))
            .sum()
    };
    row.extend(moves().map(|o| (o.next.0, f64::from(o.count) / seen_of(o.action))));
}

fn undirected_row(adjacency: &SymmetricCsr, i: usize, row: &mut Vec<(u32, f64)>) {
    let (columns, weights) = adjacency.row(i);
    let entries = columns.iter().copied().zip(weights.iter().copied());
    row.extend(entries.filter(|&(j, _)| j as usize != i));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shaping::fixtures::any_graph;
    use proptest::prelude::*;

    /// Records `count` transitions from state 0.
    fn record(graph: &mut TransitionGraph, action: u16, to: u32, count: usize) {
        for _ in 0..count {
            graph.record(StateId(0), Action(action), -1.0, StateId(to), false);
        }
    }

    fn row(graph: &TransitionGraph) -> Vec<(u32, f64)> {
        let transitions = TransitionMatrix::observed(graph, &graph.adjacency().to_csr());
        let (targets, probabilities) = transitions.row(0);
        targets
            .iter()
            .copied()
            .zip(probabilities.iter().copied())
            .collect()
    }

    /// Actions weigh the same however often they were tried, outcomes by frequency, bumps not at all.
    #[test]
    fn rows_are_means_over_actions_of_observed_frequencies() {
        let mut graph = TransitionGraph::new(3);
        (0..4).for_each(|_| {
            graph.add_state();
        });
        record(&mut graph, 0, 1, 3);
        record(&mut graph, 0, 2, 1);
        record(&mut graph, 0, 0, 7);
        graph.record(StateId(3), Action(0), -1.0, StateId(0), false);
        assert_eq!(
            row(&graph),
            [(1, 1.0 / 3.0), (2, 1.0 / 3.0), (3, 1.0 / 3.0)],
            "untried actions: all neighbours, also the one it was entered from"
        );
        record(&mut graph, 1, 2, 50);
        record(&mut graph, 2, 0, 1);
        assert_eq!(
            row(&graph),
            [(1, 0.375), (2, 0.625)],
            "all tried: the moves there are"
        );
    }

    #[test]
    fn a_state_where_every_action_bumps_has_no_way_on() {
        let mut graph = TransitionGraph::new(2);
        graph.add_state();
        record(&mut graph, 0, 0, 1);
        record(&mut graph, 1, 0, 1);
        assert_eq!(row(&graph), []);
    }

    #[test]
    fn a_weight_beyond_comparison_is_still_a_move() {
        let mut edges = sprs::TriMatI::<f64, u32>::new((3, 3));
        for (i, weight) in [(1, 1e-200), (2, 1e200)] {
            edges.add_triplet(0, i, weight);
            edges.add_triplet(i, 0, weight);
        }
        let adjacency = SymmetricCsr::new(edges.to_csr()).unwrap();
        let transitions = TransitionMatrix::undirected(&adjacency);
        assert_eq!(transitions.row(0).1, [SMALLEST_PROBABILITY, 1.0]);
    }

    proptest! {
        #[test]
        fn rows_are_distributions_and_predecessors_transpose_them(adjacency in any_graph()) {
            let transitions = TransitionMatrix::undirected(&adjacency);
            let (offsets, sources) = transitions.predecessors();
            for i in 0..adjacency.num_nodes() {
                let (targets, probabilities) = transitions.row(i);
                prop_assert!(targets.is_sorted() && !targets.contains(&(i as u32)));
                let total: f64 = probabilities.iter().sum();
                prop_assert!(targets.is_empty() || (total - 1.0).abs() < 1e-14);
                for &j in targets {
                    let range = offsets[j as usize]..offsets[j as usize + 1];
                    prop_assert!(sources[range].contains(&(i as u32)));
                }
            }
            prop_assert_eq!(sources.len(), transitions.nnz());
        }
    }
}
