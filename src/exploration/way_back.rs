//! Ways back: which of a state's untried actions undoes a step that was seen.
//!
//! An agent that plans with steps back does not know which action takes one; dead reckoning does, where actions undo each other.

use super::dead_reckoning::Prediction;
use super::model::ExplorationModel;
use super::params::Optimism;
use crate::env::Action;
use crate::graph::{StateId, TransitionGraph};
use crate::shaping::Potential;

impl ExplorationModel {
    /// Advises against the untried actions of `state` but the one that leads back to where `potential` is largest, if one is known to lead back
    /// at all: for an agent that is told what to try. Nothing with search by path length. O(untried actions · degree).
    pub(super) fn point_out_way_back(
        &self,
        graph: &TransitionGraph,
        state: StateId,
        potential: &impl Potential,
        advice: &mut [f64],
    ) {
        if self.params.optimism != Optimism::ExpectedReturn || graph.untried_actions(state) < 2 {
            return;
        }
        let actions = (0..advice.len() as u16).map(Action);
        let untried = actions.filter(|&action| graph.tries(state, action) == 0);
        let back = untried.clone().filter_map(|action| {
            match self.reckoning.predict(graph, state, action) {
                Prediction::Undo(next) => Some((action, potential.value(next))),
                _ => None,
            }
        });
        let Some((best, _)) = back.reduce(|a, b| if b.1 > a.1 { b } else { a }) else {
            return;
        };
        for action in untried.filter(|&action| action != best) {
            advice[action.index()] -= self.params.frontier_advice;
        }
    }
}
