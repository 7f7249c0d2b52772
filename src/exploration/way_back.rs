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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exploration::{ExplorationParams, RecordedStep};
    use crate::shaping::PotentialTable;

    /// Action 1 undoes action 0, as was seen along a corridor; action 2 was never tried. Advice at its end, entered by action 0.
    fn advice(optimism: Optimism) -> Vec<f64> {
        let params = ExplorationParams {
            optimism,
            ..Default::default()
        };
        let mut model = ExplorationModel::new(params, 3);
        let mut graph = TransitionGraph::new(3);
        (0..12).for_each(|_| {
            graph.add_state();
        });
        model.reckoning.add_start(StateId(0));
        let mut step = |from, action, to| {
            let (from, to, action) = (StateId(from), StateId(to), Action(action));
            let first_time = graph.tries(from, action) == 0;
            graph.record(from, action, -1.0, to, false);
            let terminated = false;
            model.learn(
                &graph,
                RecordedStep {
                    from,
                    action,
                    to,
                    terminated,
                    first_time,
                    new_way: first_time,
                },
                false,
            );
        };
        for place in 0..10 {
            step(place, 0, place + 1);
            step(place + 1, 1, place);
            step(place, 0, place + 1);
        }
        step(10, 0, 11);
        let mut advice = vec![0.0; 3];
        let flat = PotentialTable::new();
        model.point_out_way_back(&graph, StateId(11), &flat, &mut advice);
        advice
    }

    #[test]
    fn of_what_is_untried_only_the_way_back_is_not_advised_against() {
        let strength = ExplorationParams::default().frontier_advice;
        assert_eq!(
            advice(Optimism::ExpectedReturn),
            [-strength, 0.0, -strength]
        );
        assert_eq!(advice(Optimism::SeenGoals), [0.0; 3]);
    }
}
