//! The absorbing Markov chain P, laid out in memory in the order in which values flow away from the goals.
//!
//! ```text
//! position:   0 … g−1 | g  g+1  …                 m−1
//!             goals   | nearest first … farthest last          states that reach no goal: left out
//! row i:      [ near: columns < i | far: columns > i ]
//! ```
//!
//! A sweep over the rows is then one pass through contiguous memory, and every row past the goals has at least one
//! near column: the successor through which it was first reached.

use super::cost_to_go::cost_to_go;
use super::transition_matrix::TransitionMatrix;
use std::ops::Range;

/// An absorbing chain: P restricted to the states that can reach a goal, rows and columns by position.
#[derive(Clone, Debug)]
pub struct AbsorbingChain {
    num_states: usize,
    num_goals: usize,
    /// State at each position.
    order: Vec<u32>,
    /// `order.len() + 1` offsets; rows of goals are empty, since goals absorb.
    offsets: Vec<usize>,
    /// For each row the offset of its first far column.
    first_far: Vec<usize>,
    columns: Vec<u32>,
    probabilities: Vec<f64>,
}

impl AbsorbingChain {
    /// The chain of `transitions`, absorbed by `goals`, nearest first by hops. O((n + nnz) log n).
    ///
    /// # Panics
    /// If a goal is out of range.
    pub fn by_hops(transitions: &TransitionMatrix, goals: &[u32]) -> Self {
        let (steps, ends) = (vec![1.0; transitions.num_states()], vec![0.0; goals.len()]);
        let order = cost_to_go(transitions, &steps, goals, &ends).order;
        Self::new(transitions, order, goals.len())
    }

    /// Lays out `transitions` along `order`, of which the first `num_goals` are goals (see [`cost_to_go`]).
    /// O(nnz log degree).
    ///
    /// # Panics
    /// If a state past the goals has no successor before it: the order is then not one of reachability.
    pub(super) fn new(transitions: &TransitionMatrix, order: Vec<u32>, num_goals: usize) -> Self {
        let mut position = vec![u32::MAX; transitions.num_states()];
        order
            .iter()
            .enumerate()
            .for_each(|(p, &s)| position[s as usize] = p as u32);
        let mut chain = Self {
            num_states: transitions.num_states(),
            num_goals,
            offsets: vec![0; num_goals + 1],
            first_far: vec![0; num_goals],
            columns: Vec::with_capacity(transitions.nnz()),
            probabilities: Vec::with_capacity(transitions.nnz()),
            order,
        };
        let mut row = Vec::new();
        for p in num_goals..chain.order.len() {
            let (targets, probabilities) = transitions.row(chain.order[p] as usize);
            let placed = targets
                .iter()
                .map(|&t| position[t as usize])
                .zip(probabilities.iter().copied());
            row.extend(placed.filter(|&(column, _)| column != u32::MAX));
            row.sort_unstable_by_key(|&(column, _)| column);
            chain.push_row(p as u32, &row);
            row.clear();
        }
        chain
    }

    fn push_row(&mut self, p: u32, row: &[(u32, f64)]) {
        let near = row.partition_point(|&(column, _)| column < p);
        assert!(near > 0, "position {p} has no successor before it");
        self.first_far.push(self.columns.len() + near);
        self.columns.extend(row.iter().map(|&(column, _)| column));
        self.probabilities
            .extend(row.iter().map(|&(_, probability)| probability));
        self.offsets.push(self.columns.len());
    }

    /// Number of states of the whole graph.
    pub fn num_states(&self) -> usize {
        self.num_states
    }

    /// Number of positions: goals, and states that can reach one.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Whether there is not even a goal.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// Number of goals, which take the first positions.
    pub fn num_goals(&self) -> usize {
        self.num_goals
    }

    /// The state at each position.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// `by_state` in the order of positions.
    pub fn gather(&self, by_state: &[f64]) -> Vec<f64> {
        self.order.iter().map(|&s| by_state[s as usize]).collect()
    }

    /// `by_position` by state number, `elsewhere` for states that reach no goal.
    pub fn scatter(&self, by_position: &[f64], elsewhere: f64) -> Vec<f64> {
        let mut by_state = vec![elsewhere; self.num_states];
        for (&state, &value) in self.order.iter().zip(by_position) {
            by_state[state as usize] = value;
        }
        by_state
    }

    pub(crate) fn range(&self, p: usize) -> Range<usize> {
        self.offsets[p]..self.offsets[p + 1]
    }

    /// The positions that a move from `p` may lead to, ascending; none for goals.
    pub fn columns_of(&self, p: usize) -> &[u32] {
        &self.columns[self.range(p)]
    }

    /// How likely each of them is. The sum is below 1 where a move leads out of reach of the goals.
    pub fn probabilities_of(&self, p: usize) -> &[f64] {
        &self.probabilities[self.range(p)]
    }
}
