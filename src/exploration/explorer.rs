//! One explorer: where it looks before the first goal, what is still worth a look after it.
//!
//! **Before the first goal** it advises the way to the nearest promising untried action; one whose outcome is
//! plain, because it undoes a step, is a last resort. **After it**, with d₀ the hops from the start, d* the hops to the
//! goal and L = d*(start), an untried action a of s is tried only if the best that it could lead to is an
//! improvement: d₀(s) + 1 + h < L, where h is the lower bound of dead reckoning, or 0 without it (with which this is
//! the optimism of R-max). When nothing is left to try, the advice is the rise of the potential along each action,
//! if that is asked for (`potential_advice` > 0), and against untried actions that do not lead back.
//!
//! With [`Optimism::ExpectedReturn`], where actions slip, L is what the best policy known may be expected to cost, in hops.
//!
//! **Where goals pay** (one was seen to pay more than 0) no bound of that kind holds for goals not seen yet: one may pay
//! more than the best one seen, however far it is. Then everything never seen is worth a look, for a share of the steps.
//!
//! **When the last goal is lost** (it was entered and the episode went on), the first search begins again, and known
//! states that were not entered since then are as good a place to look as untried actions: the goal may have moved
//! to any of them.
//!
//! **Several explorers** share an [`ExplorationModel`]: what one finds out the others take notice of before their next
//! step, and plan anew.

use super::Optimism;
use super::distances::Distances;
use super::frontier::{FrontierSearch, FrontierView, Interest};
use super::model::{ExplorationModel, RecordedStep};
use super::objective::{MAX_TRIES_WANTED, ObjectiveView, SearchObjective};
use crate::env::Action;
use crate::graph::{StateId, TransitionGraph};
use crate::shaping::Potential;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// One explorer: where it began, what it has planned, and its own random stream. Memory O(n).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Explorer {
    search: FrontierSearch,
    from_start: Distances,
    start: StateId,
    /// The action of the step before, within the episode.
    heading: Option<Action>,
    /// By objective: the state from which a search has found nothing. Searching again is no use until the graph or the
    /// start changes; until the next episode, if it was not the start, from where more may be in reach.
    exhausted: [Option<StateId>; SearchObjective::COUNT],
    /// The plan is one of [`SearchObjective::OtherGoal`].
    searching: bool,
    /// What of the model it has taken notice of.
    discoveries: u64,
    goal_changes: u64,
    rng: ChaCha8Rng,
}

impl Explorer {
    /// An explorer that stands nowhere yet; `rng` breaks its ties.
    pub fn new(rng: ChaCha8Rng) -> Self {
        Self {
            search: FrontierSearch::new(),
            from_start: Distances::default(),
            start: StateId(0),
            heading: None,
            exhausted: [None; SearchObjective::COUNT],
            searching: false,
            discoveries: 0,
            goal_changes: 0,
            rng,
        }
    }

    /// Begins an episode in `start`, a state of `graph`. O(n + m) if the start is not that of the last episode and a
    /// goal is known, else O(1).
    pub fn begin_episode(
        &mut self,
        model: &mut ExplorationModel,
        graph: &TransitionGraph,
        start: StateId,
    ) {
        self.take_notice(model, graph);
        model.reckoning.add_start(start);
        model.stale.enter(start);
        self.search.clear();
        self.heading = None;
        for exhausted in &mut self.exhausted {
            *exhausted = exhausted.filter(|from| *from == start);
        }
        if start != self.start {
            self.start = start;
            model.update_distances(graph);
            self.search_anew(model, graph);
        }
    }

    /// Learns from a step of its own, and tells the model. O(1), or O(actions · degree) if the outcome is new; where
    /// actions slip, amortised O(log m).
    #[inline]
    pub fn learn(
        &mut self,
        model: &mut ExplorationModel,
        graph: &TransitionGraph,
        step: RecordedStep,
    ) {
        self.take_notice(model, graph);
        self.search.advance(step.from, step.action);
        self.heading = Some(step.action);
        if step.first_time {
            self.exhausted[SearchObjective::FirstGoal as usize] = None;
            self.from_start.append(step.from, step.to);
        }
        model.learn(graph, step, self.searching);
        self.discoveries = model.discoveries;
    }

    /// It stands on a goal that is none any more. The model has to be told, too
    /// ([`forget_destination`](ExplorationModel::forget_destination)).
    pub fn lose_goal(&mut self) {
        self.searching = false;
    }

    /// Catches up with what others have found and with goals that came or went. O(1) if nothing did; O(n + m) if the
    /// goals changed.
    #[inline]
    pub fn take_notice(&mut self, model: &ExplorationModel, graph: &TransitionGraph) {
        if self.goal_changes != model.goal_changes {
            self.goal_changes = model.goal_changes;
            self.search.clear();
            self.search_anew(model, graph);
        }
        if self.discoveries != model.discoveries {
            self.discoveries = model.discoveries;
            self.exhausted[SearchObjective::FirstGoal as usize] = None;
            if !self.is_plan_wanted(model, graph) {
                self.search.clear();
            }
        }
    }

    /// Whether what the plan ends with is still worth a try: others may have tried it.
    fn is_plan_wanted(&self, model: &ExplorationModel, graph: &TransitionGraph) -> bool {
        let objective = match (model.destinations.is_empty(), self.searching) {
            (true, _) => SearchObjective::FirstGoal,
            (false, true) => SearchObjective::OtherGoal,
            (false, false) => SearchObjective::ShorterPath,
        };
        let view = ObjectiveView::new(model, graph, objective, self.start, &self.from_start);
        let end = self.search.end();
        end.is_some_and(|(state, action)| view.interest(state, action) != Interest::None)
    }

    /// Nothing is known to be out of reach; hops from the start anew, once a goal is known.
    fn search_anew(&mut self, model: &ExplorationModel, graph: &TransitionGraph) {
        self.exhausted = [None; SearchObjective::COUNT];
        if !model.destinations.is_empty() {
            self.from_start.search_from(graph, self.start);
        }
    }

    /// What the plan ends with: the state and action it is made for.
    #[cfg(test)]
    pub(super) fn planned_end(&self) -> Option<(StateId, Action)> {
        self.search.end()
    }

    /// Writes the advice for `state` into `advice`, one logit per action: `frontier_advice` on the next step of the
    /// search in hand, if there is one; else, once a goal is known, the [look-ahead](ExplorationModel::look_ahead).
    /// O(out-degree) on the way; a new plan costs a search of the states nearer than its end.
    ///
    /// # Panics
    /// If `state` is not in `graph`, or `advice` is shorter than the actions are many.
    pub fn advise(
        &mut self,
        model: &mut ExplorationModel,
        graph: &TransitionGraph,
        state: StateId,
        potential: &impl Potential,
        unit: f64,
        advice: &mut [f64],
    ) {
        self.take_notice(model, graph);
        match self.plan(model, graph, state) {
            Some(action) => {
                advice.fill(0.0);
                advice[action.index()] = model.params.frontier_advice;
            }
            None => {
                model.look_ahead(graph, state, potential, unit, advice);
                model.point_out_way_back(graph, state, potential, advice);
            }
        }
    }

    /// The next step of the search in hand, if there is one.
    pub(super) fn plan(
        &mut self,
        model: &mut ExplorationModel,
        graph: &TransitionGraph,
        state: StateId,
    ) -> Option<Action> {
        if let Some(action) = self.search.planned(state) {
            return Some(action);
        }
        if model.destinations.is_empty() {
            let found = self.look(model, graph, state, SearchObjective::FirstGoal)
                || (model.stochastic && self.look_closer(model, graph, state))
                || (model.is_lost && self.look_again(model, graph, state));
            return self.search.planned(state).filter(|_| found);
        }
        for objective in [SearchObjective::ShorterPath, SearchObjective::OtherGoal] {
            if self.is_wanted(model, objective, state) && self.look(model, graph, state, objective)
            {
                self.searching = objective == SearchObjective::OtherGoal;
                return self.search.planned(state);
            }
        }
        self.searching = false;
        None
    }

    /// Everything was tried often enough, but where actions slip a door may have been missed: asks for one more try.
    fn look_closer(
        &mut self,
        model: &mut ExplorationModel,
        graph: &TransitionGraph,
        state: StateId,
    ) -> bool {
        if model.tries_wanted == MAX_TRIES_WANTED {
            return false;
        }
        model.tries_wanted += 1;
        self.exhausted[SearchObjective::FirstGoal as usize] = None;
        self.look(model, graph, state, SearchObjective::FirstGoal)
    }

    /// Everything in reach was entered since the goal was lost, and it is nowhere: it may have moved meanwhile. Stale
    /// states that are out of reach here may not be so from the start.
    fn look_again(
        &mut self,
        model: &mut ExplorationModel,
        graph: &TransitionGraph,
        state: StateId,
    ) -> bool {
        if !model.stale.is_empty() && state != self.start {
            return false;
        }
        model.mark_stale(graph, state);
        self.exhausted[SearchObjective::FirstGoal as usize] = None;
        self.look(model, graph, state, SearchObjective::FirstGoal)
    }

    /// Looking for other goals may cost one best path, and `search_share` of the steps on top. It begins at the start
    /// of an episode, so that near goals are found first, once there is enough for a trip as long as the best path.
    fn is_wanted(
        &self,
        model: &ExplorationModel,
        objective: SearchObjective,
        state: StateId,
    ) -> bool {
        match (objective, model.params.optimism) {
            (_, Optimism::None) => false,
            (SearchObjective::OtherGoal, Optimism::SeenGoals | Optimism::ExpectedReturn) => {
                let trip = f64::from(model.best_steps(self.start));
                let share = if model.goals_pay {
                    model.params.reward_search_share
                } else {
                    model.params.search_share
                };
                let left = trip + share * model.steps as f64 - model.search_steps as f64;
                if self.searching {
                    left > 0.0
                } else {
                    state == self.start && left >= trip
                }
            }
            _ => true,
        }
    }

    /// Plans a step of `objective` from `state`; whether there is one.
    fn look(
        &mut self,
        model: &ExplorationModel,
        graph: &TransitionGraph,
        state: StateId,
        objective: SearchObjective,
    ) -> bool {
        if self.exhausted[objective as usize].is_some() {
            return false;
        }
        let view = ObjectiveView::new(model, graph, objective, self.start, &self.from_start);
        let found = self
            .search
            .search(&view, state, self.heading, &mut self.rng);
        if !found {
            self.exhausted[objective as usize] = Some(state);
        }
        found
    }
}
