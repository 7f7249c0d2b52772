//! Knowledge of a world that explorers share.
//!
//! What actions do, where episodes end, which goals are known and how far they are, and what has to be looked at again
//! after the last goal was lost. Where one explorer stands, and what it has planned, is [`Explorer`](super::Explorer).

use super::certainty::typical_certainty;
use super::dead_reckoning::DeadReckoning;
use super::distances::Distances;
use super::expected_return::ExpectedReturn;
use super::stale::StaleStates;
use super::{ExplorationParams, Optimism};
use crate::env::Action;
use crate::graph::{StateId, TransitionGraph};
use serde::{Deserialize, Serialize};

/// Steps beyond a whole number that are none.
const ROUNDING: f64 = 1e-2;

/// A goal as the exploration sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Destination {
    /// Where it is.
    pub state: StateId,
    /// By how many steps it is worse than the best goal.
    pub handicap: u32,
}

/// A step that the graph has recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordedStep {
    /// Where the action was taken.
    pub from: StateId,
    /// The action.
    pub action: Action,
    /// Where it led.
    pub to: StateId,
    /// The episode terminated there.
    pub terminated: bool,
    /// This outcome of the action was not seen before.
    pub first_time: bool,
}

/// Knowledge of a world that explorers share. Memory O(n · actions).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ExplorationModel {
    pub(super) params: ExplorationParams,
    pub(super) reckoning: DeadReckoning,
    pub(super) to_goal: Distances,
    pub(super) destinations: Vec<Destination>,
    /// Of the best policy known, and the chance of a step to go where it mostly does, the reward of the best goal and the mean cost of a step to reckon it
    /// in hops; with [`Optimism::ExpectedReturn`], where actions slip and steps cost.
    expected: ExpectedReturn,
    certainty: f64,
    best_goal: f64,
    pub(super) step_cost: f64,
    /// By state: episodes end there. Shorter than the graph if the last states are none of these.
    pub(super) terminal: Vec<bool>,
    pub(super) stale: StaleStates,
    /// A goal was lost and no other one found since.
    pub(super) is_lost: bool,
    /// Steps since the first goal, and how many of them went into looking for other goals.
    pub(super) steps: u64,
    pub(super) search_steps: u64,
    /// A goal not seen yet may be worth more than those seen, at any distance.
    pub(super) goals_pay: bool,
    /// Some action has been seen to have two outcomes.
    pub(super) stochastic: bool,
    /// An action counts as tried after this many tries.
    pub(super) tries_wanted: u32,
    /// How often something was seen for the first time, and how often the goals changed: what explorers have found out
    /// before may not hold any more.
    pub(super) discoveries: u64,
    pub(super) goal_changes: u64,
}

impl ExplorationModel {
    /// Nothing is known yet of a world with `num_actions` actions.
    pub fn new(params: ExplorationParams, num_actions: usize) -> Self {
        Self {
            params,
            reckoning: DeadReckoning::new(num_actions),
            to_goal: Distances::default(),
            destinations: Vec::new(),
            expected: ExpectedReturn::default(),
            certainty: 1.0,
            best_goal: 0.0,
            step_cost: 0.0,
            terminal: Vec::new(),
            stale: StaleStates::default(),
            is_lost: false,
            steps: 0,
            search_steps: 0,
            goals_pay: false,
            stochastic: false,
            tries_wanted: 1,
            discoveries: 0,
            goal_changes: 0,
        }
    }

    /// Learns from a step, which `searching` says was one towards goals not seen yet. O(1), or O(actions · degree) if
    /// the outcome is new; where actions slip, amortised O(log m).
    #[inline]
    pub(super) fn learn(&mut self, graph: &TransitionGraph, step: RecordedStep, searching: bool) {
        if !self.destinations.is_empty() {
            self.steps += 1;
            self.search_steps += u64::from(searching);
        }
        if step.terminated {
            self.terminal
                .resize(self.terminal.len().max(step.to.index() + 1), false);
            self.terminal[step.to.index()] = true;
        }
        self.stale.enter(step.to);
        if step.first_time {
            self.discoveries += 1;
            self.stochastic |= graph.tries(step.from, step.action) > 1;
            self.reckoning.learn(graph, step.from, step.action, step.to);
            self.to_goal.append(step.from, step.to);
        }
        self.reckoning.count_step(graph);
    }

    /// Tells whether a goal has paid more than nothing. Where rewards are only costs the nearest goal is the best one, as
    /// far as anybody can know; where goals pay, one not seen yet may pay more, wherever it is.
    pub fn set_goals_pay(&mut self, goals_pay: bool) {
        self.goals_pay = goals_pay;
    }

    /// Tells what the best goal known pays, and what a step that ends nothing costs on average. O(1), but with
    /// [`Optimism::ExpectedReturn`] and where actions slip O(sweeps · transitions).
    pub fn set_returns(&mut self, graph: &TransitionGraph, best_goal: f64, step_cost: f64) {
        (self.best_goal, self.step_cost) = (best_goal, step_cost);
        if self.reckons_returns() {
            self.expected.update(graph, &self.terminal, step_cost);
            self.certainty = typical_certainty(graph);
        }
    }

    /// Where nothing slips the best path costs its steps.
    fn reckons_returns(&self) -> bool {
        self.params.optimism == Optimism::ExpectedReturn && self.stochastic && self.step_cost > 0.0
    }

    /// L: the hops of the best path known from `start` to a goal, or those that would cost as much as the best policy known may
    /// be expected to, if they are more.
    pub(super) fn best_steps(&self, start: StateId) -> u32 {
        let hops = self.to_goal.get(start);
        let expected = self.expected.get(start).filter(|_| self.reckons_returns());
        let steps = expected.map_or(0.0, |value| 1.0 + (self.best_goal - value) / self.step_cost);
        hops.max((steps * self.certainty - ROUNDING).ceil() as u32)
    }

    /// Tells which goals are known, and that the graph has changed enough to reckon distances anew. O(n + m).
    pub fn set_destinations(&mut self, graph: &TransitionGraph, destinations: &[Destination]) {
        self.destinations.clear();
        self.destinations.extend_from_slice(destinations);
        if !destinations.is_empty() {
            self.is_lost = false;
            self.stale.clear();
        }
        self.goal_changes += 1;
        self.update_distances(graph);
    }

    /// An agent stands in `state`, a goal until now, and the episode went on: it is none any more. If it was the last
    /// one, all other states become worth a look. O(n + m).
    pub fn forget_destination(&mut self, graph: &TransitionGraph, state: StateId) {
        if let Some(terminal) = self.terminal.get_mut(state.index()) {
            *terminal = false;
        }
        self.destinations.retain(|goal| goal.state != state);
        if self.destinations.is_empty() {
            self.is_lost = true;
            self.mark_stale(graph, state);
        }
        self.goal_changes += 1;
        self.update_distances(graph);
    }

    /// Hops from the farthest state that can reach a goal, handicaps included; 0 before the first goal.
    pub fn eccentricity(&self) -> u32 {
        self.to_goal.eccentricity()
    }

    /// All states but the one where the agent stands may have become goals.
    pub(super) fn mark_stale(&mut self, graph: &TransitionGraph, here: StateId) {
        self.stale.mark_all(graph.num_states());
        self.stale.enter(here);
    }

    /// Hops to the goals, anew; nothing without goals.
    pub(super) fn update_distances(&mut self, graph: &TransitionGraph) {
        if !self.destinations.is_empty() {
            let goals: Vec<_> = self
                .destinations
                .iter()
                .map(|goal| (goal.state, goal.handicap))
                .collect();
            self.to_goal.search_to(graph, &goals);
        }
    }
}
