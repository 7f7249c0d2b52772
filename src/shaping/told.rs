//! Numbers that potentials are told about states, one by one as the states are discovered.

use crate::graph::StateId;
use serde::{Deserialize, Serialize};

/// A number for each state that somebody told one about.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct ToldNumbers(Vec<Option<f64>>);

impl ToldNumbers {
    /// Takes `number` down, in the place of what was told before. One that is not finite says that there is none.
    pub fn tell(&mut self, state: StateId, number: f64) {
        if self.0.len() <= state.index() {
            self.0.resize(state.index() + 1, None);
        }
        self.0[state.index()] = number.is_finite().then_some(number);
    }

    /// What was told about a state, by its number.
    pub fn get(&self, state: usize) -> Option<f64> {
        self.0.get(state).copied().flatten()
    }
}
