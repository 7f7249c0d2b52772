//! Knowledge of a world that explorers share.
//!
//! What actions do, where episodes end, which goals are known and how far they are, and what has to be looked at again
//! after the last goal was lost. Where one explorer stands, and what it has planned, is [`Explorer`](super::Explorer).

use super::certainty::typical_certainty;
use super::dead_reckoning::DeadReckoning;
use super::distances::{Distances, Known};
use super::expected_return::ExpectedReturn;
use super::objective::{MAX_TRIES_WANTED, SearchObjective};
use super::search_budget::SearchBudget;
use super::stale::StaleStates;
use super::{ExplorationParams, Optimism, SearchOrder};
use crate::env::Action;
use crate::graph::connectivity::UNREACHED;
use crate::graph::{StateId, TransitionGraph};
use serde::{Deserialize, Serialize};

/// Steps beyond a whole number that are none.
const ROUNDING: f64 = 1e-2;

/// After so many tries that did what those before had done, actions are believed to do the same always; of one action the first few count.
const CERTAIN: u32 = 64;
const TELLING_TRIES: u32 = 16;

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
    /// The action was not tried before, or no step was seen between the two states, either way.
    pub new_way: bool,
}

/// What decides how promising things are that were not tried: as long as it is the same, trying what is left makes nothing else more promising.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Survey {
    objective: SearchObjective,
    points: usize,
    tries_wanted: u32,
    revision: u64,
    goal_changes: u64,
    has_places: bool,
    is_stale: bool,
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
    pub(super) budget: SearchBudget,
    /// A goal not seen yet may be worth more than those seen, at any distance.
    pub(super) goals_pay: bool,
    /// Something pays: there is something to lose by looking for more.
    pub(super) something_pays: bool,
    /// Whether a short way is worth more than a long one.
    pub(super) time_counts: bool,
    /// The longest episode so far, in steps.
    pub(super) longest: u32,
    /// Some action has been seen to have two outcomes.
    pub(super) stochastic: bool,
    /// Tries that did the same as those before, the first few of each action.
    agreements: u32,
    /// While nothing is known to be worth a way, an action counts as tried after this many tries.
    pub(super) tries_wanted: u32,
    /// How often something was seen for the first time, and how often the goals changed: what explorers have found out
    /// before may not hold any more.
    pub(super) discoveries: u64,
    pub(super) goal_changes: u64,
}

impl ExplorationModel {
    /// Nothing is known yet of a world with `num_actions` actions.
    pub fn new(params: ExplorationParams, num_actions: usize) -> Self {
        let is_by_place = params.order == SearchOrder::ByPlace;
        Self {
            params,
            reckoning: DeadReckoning::new(num_actions, is_by_place),
            to_goal: Distances::default(),
            destinations: Vec::new(),
            expected: ExpectedReturn::default(),
            certainty: 1.0,
            best_goal: 0.0,
            step_cost: 0.0,
            terminal: Vec::new(),
            stale: StaleStates::default(),
            is_lost: false,
            budget: SearchBudget::default(),
            goals_pay: false,
            something_pays: false,
            time_counts: true,
            longest: 0,
            stochastic: false,
            agreements: 0,
            tries_wanted: 1,
            discoveries: 0,
            goal_changes: 0,
        }
    }

    /// Learns from a step, which `searching` says was one towards goals not seen yet. O(1), or O(actions · degree) if
    /// the outcome is new; where actions slip, amortised O(log m).
    #[inline]
    pub(super) fn learn(&mut self, graph: &TransitionGraph, step: RecordedStep, searching: bool) {
        self.budget.count(self.has_something_to_lose(), searching);
        if step.terminated {
            self.terminal
                .resize(self.terminal.len().max(step.to.index() + 1), false);
            self.terminal[step.to.index()] = true;
        } else if let Some(terminal) = self.terminal.get_mut(step.to.index()) {
            *terminal = false;
        }
        self.stale.enter(step.to);
        if step.first_time {
            self.discoveries += 1;
            self.stochastic |= graph.tries(step.from, step.action) > 1;
            match step.new_way {
                true => self.reckoning.learn(graph, step.from, step.action, step.to),
                false => self.reckoning.notice_slip(),
            }
            self.to_goal.append(step.from, step.to);
        }
        if self.agreements < CERTAIN && !self.stochastic {
            let tries = graph.tries(step.from, step.action);
            self.agreements += u32::from((2..=TELLING_TRIES).contains(&tries));
        }
        self.reckoning.count_step(graph);
    }

    /// What is known that decides how promising things are for `objective`.
    pub(super) fn survey(&self, graph: &TransitionGraph, objective: SearchObjective) -> Survey {
        Survey {
            objective,
            points: self.reckoning.num_points(graph),
            tries_wanted: self.tries_wanted,
            revision: self.reckoning.revision(),
            goal_changes: self.goal_changes,
            has_places: self.reckoning.trusted(),
            is_stale: !self.stale.is_empty(),
        }
    }

    /// Whether another round of tries may show something new, and is worth it.
    pub(super) fn may_look_closer(&self, graph: &TransitionGraph) -> bool {
        let may_show = self.stochastic || self.agreements < CERTAIN;
        let rounds = match self.has_something_to_lose() {
            true => self.budget.rounds(graph.num_states()),
            false => MAX_TRIES_WANTED,
        };
        may_show && self.tries_wanted < rounds
    }

    /// Tells whether a goal has paid more than nothing. Where rewards are only costs the nearest goal is the best one, as
    /// far as anybody can know; where goals pay, one not seen yet may pay more, wherever it is.
    pub fn set_goals_pay(&mut self, goals_pay: bool) {
        self.goals_pay = goals_pay;
    }

    /// Tells that something pays, until the last goal is lost.
    pub fn set_something_pays(&mut self) {
        self.something_pays = true;
    }

    /// Tells whether episodes can be made shorter at all. Where they cannot no shorter path is looked for.
    pub fn set_time_counts(&mut self, time_counts: bool) {
        if self.time_counts != time_counts {
            self.time_counts = time_counts;
            self.goal_changes += 1;
        }
    }

    /// Whether anything is known that is worth more than to look around.
    pub(super) fn has_something_to_lose(&self) -> bool {
        self.something_pays || !self.destinations.is_empty()
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

    /// The hops within which a goal not seen yet may be worth more than the best policy known from `start`.
    pub(super) fn worthwhile_steps(&self, start: StateId) -> u32 {
        let best = self.best_steps(start);
        if !self.goals_pay {
            return best;
        }
        let gain = self.params.reward_bound.map(|bound| bound - self.best_goal);
        match gain {
            Some(gain) if gain <= 0.0 => best,
            Some(gain) if self.step_cost > 0.0 => {
                best.saturating_add((gain / self.step_cost).ceil() as u32)
            }
            _ => UNREACHED,
        }
    }

    /// Tells which goals are known, and that the graph has changed enough to reckon distances anew. O(n + m).
    pub fn set_destinations(&mut self, graph: &TransitionGraph, destinations: &[Destination]) {
        self.destinations.clear();
        self.destinations.extend_from_slice(destinations);
        self.tries_wanted = 1;
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
        self.tries_wanted = 1;
        if self.destinations.is_empty() {
            self.is_lost = true;
            self.something_pays = false;
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
            let mut to_goal = std::mem::take(&mut self.to_goal);
            to_goal.search_to(self.known(graph), &goals);
            self.to_goal = to_goal;
        }
    }

    /// What decides which steps are possible.
    pub(super) fn known<'a>(&'a self, graph: &'a TransitionGraph) -> Known<'a> {
        Known {
            graph,
            reckoning: &self.reckoning,
            ends: &self.terminal,
        }
    }
}
