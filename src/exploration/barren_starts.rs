//! Starts from which a search has found nothing to try.
//!
//! Where each episode begins somewhere else, what is worth a try has to be asked anew for each start; but as long as nothing new was seen and no
//! goal came or went, the answer for a start that was asked about before is what it was.

use super::model::ExplorationModel;
use super::objective::SearchObjective;
use crate::graph::StateId;
use serde::{Deserialize, Serialize};

/// By start and objective: whether there was nothing, as of the last discovery and change of goals. Memory: a byte a state.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct BarrenStarts {
    discoveries: u64,
    goal_changes: u64,
    /// A bit for each objective.
    by_state: Vec<u8>,
}

impl BarrenStarts {
    /// Notes that a search for `objective` from `start` has found nothing.
    pub fn note(&mut self, model: &ExplorationModel, objective: SearchObjective, start: StateId) {
        if !self.holds(model) {
            (self.discoveries, self.goal_changes) = (model.discoveries, model.goal_changes);
            self.by_state.clear();
        }
        if self.by_state.len() <= start.index() {
            self.by_state.resize(start.index() + 1, 0);
        }
        self.by_state[start.index()] |= 1 << objective as u8;
    }

    /// Whether it would find nothing again. Where actions slip nobody knows: frequencies change with every step.
    pub fn is_barren(
        &self,
        model: &ExplorationModel,
        objective: SearchObjective,
        start: StateId,
    ) -> bool {
        let found_nothing = self.by_state.get(start.index()).copied().unwrap_or(0);
        !model.stochastic && self.holds(model) && found_nothing & 1 << objective as u8 != 0
    }

    fn holds(&self, model: &ExplorationModel) -> bool {
        (self.discoveries, self.goal_changes) == (model.discoveries, model.goal_changes)
    }
}
