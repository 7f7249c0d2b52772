//! A table of one number per (state, action), row-major, that grows with the states.

use crate::graph::StateId;
use serde::{Deserialize, Serialize};

/// Rows are states in order of discovery, `num_actions` wide.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ActionTable {
    num_actions: usize,
    initial: f64,
    values: Vec<f64>,
}

impl ActionTable {
    /// An empty table whose rows begin filled with `initial`.
    pub fn new(num_actions: usize, initial: f64) -> Self {
        ActionTable {
            num_actions,
            initial,
            values: Vec::new(),
        }
    }

    /// Number of rows.
    pub fn num_states(&self) -> usize {
        self.values.len() / self.num_actions
    }

    /// Appends rows until `state` has one. Amortised O(actions) a row.
    #[inline]
    pub fn grow_to(&mut self, state: StateId) {
        let end = (state.index() + 1) * self.num_actions;
        if end > self.values.len() {
            self.values.resize(end, self.initial);
        }
    }

    /// The row of `state`.
    ///
    /// # Panics
    /// If the table does not reach that far.
    #[inline]
    pub fn row(&self, state: StateId) -> &[f64] {
        &self.values[state.index() * self.num_actions..][..self.num_actions]
    }

    /// The row of `state`, if there is one.
    pub fn get_row(&self, state: StateId) -> Option<&[f64]> {
        (state.index() < self.num_states()).then(|| self.row(state))
    }

    /// The row of `state`, to be changed.
    ///
    /// # Panics
    /// If the table does not reach that far.
    #[inline]
    pub fn row_mut(&mut self, state: StateId) -> &mut [f64] {
        &mut self.values[state.index() * self.num_actions..][..self.num_actions]
    }

    /// The largest number in the row of `state`.
    #[inline]
    pub fn max(&self, state: StateId) -> f64 {
        largest(self.row(state))
    }
}

/// The largest of `values`; −∞ if there are none.
#[inline]
pub(crate) fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_fills_new_rows_and_keeps_old_ones() {
        let mut table = ActionTable::new(3, 2.0);
        table.grow_to(StateId(0));
        table.row_mut(StateId(0))[1] = 5.0;
        table.grow_to(StateId(4));
        table.grow_to(StateId(2));
        assert_eq!(table.num_states(), 5);
        assert_eq!(table.row(StateId(0)), [2.0, 5.0, 2.0]);
        assert_eq!(table.row(StateId(4)), [2.0; 3]);
        assert_eq!(table.max(StateId(0)), 5.0);
        assert_eq!(table.get_row(StateId(5)), None);
    }
}
