//! The explorer: where to look before the first goal, what is still worth a look after it.
//!
//! **Before the first goal** it advises the way to the nearest promising untried action; one whose outcome is
//! plain, because it undoes a step, is a last resort. **After it**, with d₀ the hops from the start, d* the hops to the
//! goal and L = d*(start), an untried action a of s is tried only if the best that it could lead to is an
//! improvement: d₀(s) + 1 + h < L, where h is the lower bound of dead reckoning, or 0 without it (with which this is
//! the optimism of R-max). When nothing is left to try, the advice is the rise of the potential along each action.
//!
//! **Where goals pay** (one was seen to pay more than 0) no bound of that kind holds for goals not seen yet: one may pay
//! more than the best one seen, however far it is. Then everything never seen is worth a look, for a share of the steps.
//!
//! **When the last goal is lost** (it was entered and the episode went on), the first quest begins again, and known
//! states that were not entered since then are as good a place to look as untried actions: the goal may have moved
//! to any of them.

mod look_ahead;
mod quest;

use super::ExplorationParams;
use super::Optimism;
use super::displacement::Displacements;
use super::distances::Distances;
use super::frontier::FrontierSearch;
use super::stale::StaleStates;
use crate::env::Action;
use crate::graph::connectivity::UNREACHED;
use crate::graph::{StateId, TransitionGraph};
use crate::shaping::Potential;
use quest::{MAX_TRIES_WANTED, Quest, QuestView};
use rand_chacha::ChaCha8Rng;

/// A goal as the explorer sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Destination {
    /// Where it is.
    pub state: StateId,
    /// By how many steps it is worse than the best goal.
    pub handicap: u32,
}

/// Frontier exploration with all it has learnt. Memory O(n · actions).
#[derive(Clone, Debug)]
pub struct Explorer {
    params: ExplorationParams,
    search: FrontierSearch,
    displacements: Displacements,
    from_start: Distances,
    to_goal: Distances,
    destinations: Vec<Destination>,
    /// By state: episodes end there. Shorter than the graph if the last states are none of these.
    terminal: Vec<bool>,
    stale: StaleStates,
    /// A goal was lost and no other one found since.
    is_lost: bool,
    /// The action of the step before, within the episode.
    heading: Option<Action>,
    start: StateId,
    /// By quest: the state from which a search has found nothing. Searching again is no use until the graph or the
    /// start changes; until the next episode, if it was not the start, from where more may be in reach.
    exhausted: [Option<StateId>; Quest::COUNT],
    /// Steps since the first goal, and how many of them went into [`Quest::OtherGoal`].
    steps: u64,
    search_steps: u64,
    /// The plan is one of [`Quest::OtherGoal`].
    searching: bool,
    /// A goal not seen yet may be worth more than those seen, at any distance.
    goals_pay: bool,
    /// Some action has been seen to have two outcomes.
    stochastic: bool,
    /// An action counts as tried after this many tries.
    tries_wanted: u32,
    rng: ChaCha8Rng,
}

impl Explorer {
    /// An explorer of a world with `num_actions` actions; `rng` breaks its ties.
    pub fn new(params: ExplorationParams, num_actions: usize, rng: ChaCha8Rng) -> Self {
        Self {
            params,
            search: FrontierSearch::new(),
            displacements: Displacements::new(num_actions),
            from_start: Distances::default(),
            to_goal: Distances::default(),
            destinations: Vec::new(),
            terminal: Vec::new(),
            stale: StaleStates::default(),
            is_lost: false,
            heading: None,
            start: StateId(0),
            exhausted: [None; Quest::COUNT],
            steps: 0,
            search_steps: 0,
            searching: false,
            goals_pay: false,
            stochastic: false,
            tries_wanted: 1,
            rng,
        }
    }

    /// Begins an episode in `start`, a state of `graph`. O(n + m) if the start is not that of the last episode and a
    /// goal is known, else O(1).
    pub fn begin_episode(&mut self, graph: &TransitionGraph, start: StateId) {
        self.displacements.add_start(start);
        self.search.clear();
        self.stale.enter(start);
        self.heading = None;
        for exhausted in &mut self.exhausted {
            *exhausted = exhausted.filter(|from| *from == start);
        }
        if start != self.start {
            self.start = start;
            self.refresh(graph);
        }
    }

    /// Learns from a step that the graph has recorded; `terminal` if the episode terminated in `to`, `first_time` if
    /// this outcome was not seen before. O(1), or O(actions · degree) if it is new; where actions slip, amortised
    /// O(log m).
    pub fn learn(
        &mut self,
        graph: &TransitionGraph,
        from: StateId,
        action: Action,
        to: StateId,
        terminal: bool,
        first_time: bool,
    ) {
        self.search.advance(from, action);
        self.heading = Some(action);
        if !self.destinations.is_empty() {
            self.steps += 1;
            self.search_steps += u64::from(self.searching);
        }
        if terminal {
            self.terminal
                .resize(self.terminal.len().max(to.index() + 1), false);
            self.terminal[to.index()] = true;
        }
        self.stale.enter(to);
        if first_time {
            self.stochastic |= graph.tries(from, action) > 1;
            self.exhausted[Quest::FirstGoal as usize] = None;
            self.displacements.learn(graph, from, action, to);
            self.from_start.append(from, to);
            self.to_goal.append(from, to);
        }
        self.displacements.count_step(graph);
    }

    /// Tells whether a goal has paid more than nothing. Where rewards are only costs the nearest goal is the best one, as
    /// far as anybody can know; where goals pay, one not seen yet may pay more, wherever it is.
    pub fn set_goals_pay(&mut self, goals_pay: bool) {
        self.goals_pay = goals_pay;
    }

    /// Tells which goals are known, and that the graph has changed enough to reckon distances anew. O(n + m).
    pub fn set_destinations(&mut self, graph: &TransitionGraph, destinations: &[Destination]) {
        self.destinations.clear();
        self.destinations.extend_from_slice(destinations);
        if !destinations.is_empty() {
            self.is_lost = false;
            self.stale.clear();
        }
        self.search.clear();
        self.refresh(graph);
    }

    /// The agent stands in `state`, a goal until now, and the episode went on: it is none any more. If it was the last
    /// one, all other states become worth a look. O(n + m).
    pub fn forget_destination(&mut self, graph: &TransitionGraph, state: StateId) {
        if let Some(terminal) = self.terminal.get_mut(state.index()) {
            *terminal = false;
        }
        self.destinations.retain(|goal| goal.state != state);
        self.searching = false;
        self.search.clear();
        if self.destinations.is_empty() {
            self.is_lost = true;
            self.mark_stale(graph, state);
        }
        self.refresh(graph);
    }

    /// Hops from the farthest state that can reach a goal, handicaps included; 0 before the first goal.
    pub fn eccentricity(&self) -> u32 {
        self.to_goal.eccentricity()
    }

    /// All states but the one where the agent stands may have become goals.
    fn mark_stale(&mut self, graph: &TransitionGraph, here: StateId) {
        self.stale.mark_all(graph.num_states());
        self.stale.enter(here);
    }

    fn refresh(&mut self, graph: &TransitionGraph) {
        self.exhausted = [None; Quest::COUNT];
        if !self.destinations.is_empty() {
            self.from_start.search_from(graph, self.start);
            let goals: Vec<_> = self
                .destinations
                .iter()
                .map(|goal| (goal.state, goal.handicap))
                .collect();
            self.to_goal.search_to(graph, &goals);
        }
    }

    /// Writes the advice for `state` into `advice`, one logit per action: `frontier_advice` on the next step of the
    /// quest in hand, if there is one; else, once a goal is known, `potential_advice` times the expected rise of
    /// `potential` along each action, in units of `unit` > 0, the rise that one step towards the goal is worth on
    /// average. O(out-degree) on the way; a new plan costs a search of the states nearer than its end.
    ///
    /// # Panics
    /// If `state` is not in `graph`, or `advice` is shorter than the actions are many.
    pub fn advise(
        &mut self,
        graph: &TransitionGraph,
        state: StateId,
        potential: &impl Potential,
        unit: f64,
        advice: &mut [f64],
    ) {
        advice.fill(0.0);
        if let Some(action) = self.plan(graph, state) {
            advice[action.index()] = self.params.frontier_advice;
        } else if !self.destinations.is_empty() {
            self.advise_climb(graph, state, potential, unit, advice);
        }
    }

    /// As [`Self::advise`] without quests: the part of the advice that lasts. All 0 before the first goal.
    ///
    /// # Panics
    /// As [`Self::advise`].
    pub fn look_ahead(
        &mut self,
        graph: &TransitionGraph,
        state: StateId,
        potential: &impl Potential,
        unit: f64,
        advice: &mut [f64],
    ) {
        advice.fill(0.0);
        if !self.destinations.is_empty() {
            self.advise_climb(graph, state, potential, unit, advice);
        }
    }

    /// The next step of the quest in hand, if there is one.
    fn plan(&mut self, graph: &TransitionGraph, state: StateId) -> Option<Action> {
        if let Some(action) = self.search.planned(state) {
            return Some(action);
        }
        if self.destinations.is_empty() {
            let found = self.look(graph, state, Quest::FirstGoal)
                || (self.stochastic && self.look_closer(graph, state))
                || (self.is_lost && self.look_again(graph, state));
            return self.search.planned(state).filter(|_| found);
        }
        for quest in [Quest::ShorterPath, Quest::OtherGoal] {
            if self.is_wanted(quest, state) && self.look(graph, state, quest) {
                self.searching = quest == Quest::OtherGoal;
                return self.search.planned(state);
            }
        }
        self.searching = false;
        None
    }

    /// Everything was tried often enough, but where actions slip a door may have been missed: asks for one more try.
    fn look_closer(&mut self, graph: &TransitionGraph, state: StateId) -> bool {
        if self.tries_wanted == MAX_TRIES_WANTED {
            return false;
        }
        self.tries_wanted += 1;
        self.exhausted[Quest::FirstGoal as usize] = None;
        self.look(graph, state, Quest::FirstGoal)
    }

    /// Everything in reach was entered since the goal was lost, and it is nowhere: it may have moved meanwhile. Stale
    /// states that are out of reach here may not be so from the start.
    fn look_again(&mut self, graph: &TransitionGraph, state: StateId) -> bool {
        if !self.stale.is_empty() && state != self.start {
            return false;
        }
        self.mark_stale(graph, state);
        self.exhausted[Quest::FirstGoal as usize] = None;
        self.look(graph, state, Quest::FirstGoal)
    }

    /// Looking for other goals may cost one best path, and `search_share` of the steps on top. It begins at the start
    /// of an episode, so that near goals are found first, once there is enough for a trip as long as the best path.
    fn is_wanted(&self, quest: Quest, state: StateId) -> bool {
        match (quest, self.params.optimism) {
            (_, Optimism::None) => false,
            (Quest::OtherGoal, Optimism::SeenGoals) => {
                let trip = f64::from(self.to_goal.get(self.start));
                let share = if self.goals_pay {
                    self.params.reward_search_share
                } else {
                    self.params.search_share
                };
                let left = trip + share * self.steps as f64 - self.search_steps as f64;
                if self.searching {
                    left > 0.0
                } else {
                    state == self.start && left >= trip
                }
            }
            _ => true,
        }
    }

    /// Plans a step of `quest` from `state`; whether there is one.
    fn look(&mut self, graph: &TransitionGraph, state: StateId, quest: Quest) -> bool {
        if self.exhausted[quest as usize].is_some() {
            return false;
        }
        let mut view = QuestView {
            graph,
            displacements: &mut self.displacements,
            from_start: &self.from_start,
            destinations: &self.destinations,
            terminal: &self.terminal,
            tries_wanted: if quest == Quest::FirstGoal {
                self.tries_wanted
            } else {
                1
            },
            stale: &self.stale,
            quest,
            best: match quest {
                Quest::OtherGoal if self.goals_pay => UNREACHED,
                _ => self.to_goal.get(self.start),
            },
        };
        let found = self
            .search
            .search(&mut view, state, self.heading, &mut self.rng);
        if !found {
            self.exhausted[quest as usize] = Some(state);
        }
        found
    }
}

#[cfg(test)]
mod follower;
#[cfg(test)]
mod tests;
