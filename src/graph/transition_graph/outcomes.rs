//! Outcomes of the tried actions: questions to the model, all answered from the edges at one state.

use super::{TransitionGraph, TransitionStats, node, state_of};
use crate::env::Action;
use crate::graph::StateId;
use petgraph::Direction;
use petgraph::visit::EdgeRef;
use std::cmp::Reverse;

/// One tried (state, action) → next, with how often and with what reward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObservedOutcome {
    /// The action that was taken.
    pub action: Action,
    /// The state it led to.
    pub next: StateId,
    /// How often, at least 1.
    pub count: u32,
    /// Sum of the rewards over those times.
    pub reward_sum: f64,
    /// Whether the episode terminated on arrival (ever).
    pub terminal: bool,
}

impl TransitionGraph {
    /// Outcomes seen from `state`, most recent edge first; O(out-degree), no allocation.
    pub fn outcomes(&self, state: StateId) -> impl Iterator<Item = ObservedOutcome> + '_ {
        self.digraph.edges(node(state)).map(|edge| {
            let &TransitionStats {
                action,
                count,
                reward_sum,
                terminal,
            } = edge.weight();
            ObservedOutcome {
                action,
                next: state_of(edge.target()),
                count,
                reward_sum,
                terminal,
            }
        })
    }

    /// Outcomes of one action, most recent edge first; O(out-degree), no allocation.
    pub fn outcomes_of(
        &self,
        state: StateId,
        action: Action,
    ) -> impl Iterator<Item = ObservedOutcome> + '_ {
        self.outcomes(state)
            .filter(move |outcome| outcome.action == action)
    }

    /// Where (state, action) led most often, of equals the one seen first; `None` if it was never tried.
    /// O(1) if it never led elsewhere, else O(out-degree).
    pub fn likely_successor(&self, state: StateId, action: Action) -> Option<StateId> {
        let attempts = self.attempts[self.slot(state, action)];
        let latest = self.digraph.edge_weight(attempts.latest)?;
        if latest.count == attempts.tries {
            return self.latest_outcome(state, action);
        }
        self.digraph
            .edges(node(state))
            .filter(|edge| edge.weight().action == action)
            .max_by_key(|edge| (edge.weight().count, Reverse(edge.id())))
            .map(|edge| state_of(edge.target()))
    }

    /// The same of the times when it led elsewhere; `None` if it never did. O(out-degree).
    pub fn likely_departure(&self, state: StateId, action: Action) -> Option<StateId> {
        self.digraph
            .edges(node(state))
            .filter(|edge| edge.weight().action == action && edge.target() != node(state))
            .max_by_key(|edge| (edge.weight().count, Reverse(edge.id())))
            .map(|edge| state_of(edge.target()))
    }

    /// r̂(s, a), the mean reward of (state, action); `None` if it was never tried. O(out-degree).
    pub fn mean_reward(&self, state: StateId, action: Action) -> Option<f64> {
        mean_reward(self.outcomes_of(state, action))
    }

    /// The mean reward of a step from `state`, over all its steps so far; `None` if there was none. O(out-degree).
    pub fn mean_step_reward(&self, state: StateId) -> Option<f64> {
        mean_reward(self.outcomes(state))
    }

    /// Forgets that episodes ended in `state`, and what that paid: every way into it counts as one that pays `reward` and goes on. O(in-degree).
    ///
    /// # Panics
    /// If the state does not exist.
    pub fn forget_end(&mut self, state: StateId, reward: f64) {
        let mut ways = self
            .digraph
            .neighbors_directed(node(state), Direction::Incoming)
            .detach();
        while let Some(way) = ways.next_edge(&self.digraph) {
            let seen = &mut self.digraph[way];
            seen.reward_sum = reward * f64::from(seen.count);
            seen.terminal = false;
        }
    }

    /// States from which `state` was entered, by one entry per transition seen: a state can come up more than once,
    /// and `state` itself does if it bumps. O(in-degree), no allocation.
    pub fn predecessors(&self, state: StateId) -> impl Iterator<Item = StateId> + '_ {
        self.digraph
            .neighbors_directed(node(state), Direction::Incoming)
            .map(state_of)
    }
}

fn mean_reward(outcomes: impl Iterator<Item = ObservedOutcome>) -> Option<f64> {
    let (count, sum) = outcomes.fold((0.0, 0.0), |(count, sum), seen| {
        (count + f64::from(seen.count), sum + seen.reward_sum)
    });
    (count > 0.0).then(|| sum / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Action 0 from state 0 leads to 0 thrice, to 1 twice and to 2 once, action 1 to 2; rewards 1, 2, 3, …
    fn graph() -> TransitionGraph {
        let mut graph = TransitionGraph::new(3);
        let [zero, one, two] = [(); 3].map(|()| graph.add_state());
        let steps = [
            (0, two),
            (0, zero),
            (0, one),
            (0, one),
            (0, zero),
            (1, two),
            (0, zero),
        ];
        for (n, (action, to)) in steps.into_iter().enumerate() {
            graph.record(zero, Action(action), 1.0 + n as f64, to, false);
        }
        graph
    }

    #[test]
    fn the_likely_successor_is_the_most_frequent_one_and_the_departure_that_of_those_that_leave() {
        let graph = graph();
        let from = |action| (StateId(0), Action(action));
        let likely = |(state, action)| graph.likely_successor(state, action);
        let departure = |(state, action)| graph.likely_departure(state, action);
        assert_eq!(
            [0, 1, 2].map(|a| likely(from(a))),
            [Some(StateId(0)), Some(StateId(2)), None]
        );
        assert_eq!(
            [0, 1, 2].map(|a| departure(from(a))),
            [Some(StateId(1)), Some(StateId(2)), None]
        );
    }

    #[test]
    fn means_are_of_all_that_was_paid() {
        let graph = graph();
        let mean = |a| graph.mean_reward(StateId(0), Action(a));
        assert_eq!([0, 1, 2].map(mean), [Some(22.0 / 6.0), Some(6.0), None]);
        assert_eq!(graph.mean_step_reward(StateId(0)), Some(4.0));
        assert_eq!(graph.mean_step_reward(StateId(1)), None);
    }
}
