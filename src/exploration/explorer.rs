//! One explorer: where it looks before the first goal, what is still worth a look after it.
//!
//! **Before anything worth having is known** it advises the way to the nearest untried action of the best kind: one that leads to a new
//! place; then one that shows a known place from another side; then one between known places, into a wall, or of a kind that hardly ever does anything;
//! at last one that undoes a step.
//!
//! **After the first goal**, with d₀ the hops from the start, d* the hops to the
//! goal and L = d*(start), an untried action a of s is tried only if the best that it could lead to is an
//! improvement: d₀(s) + 1 + h < L, where h is the lower bound of dead reckoning, or 0 without it (with which this is
//! the optimism of R-max). When nothing is left to try, the advice is the rise of the potential along each action,
//! if that is asked for (`potential_advice` > 0), and against untried actions that do not lead back.
//!
//! With [`Optimism::ExpectedReturn`], where actions slip, L is what the best policy known may be expected to cost, in hops. Where no time can be saved, no
//! shorter paths are looked for.
//!
//! **Where something pays** (more than 0) no bound of that kind holds for what was not seen yet: it may pay
//! more than the best that was, however far it is, unless `reward_bound` says how much there can be. Then everything never seen is worth a look, within a
//! budget of steps ([`search_budget`](super::search_budget)).
//!
//! **When the last goal is lost** (it was entered and the episode went on), the first search begins again, and known
//! states that were not entered since then are as good a place to look as untried actions: the goal may have moved
//! to any of them.
//!
//! **Several explorers** share an [`ExplorationModel`]: what one finds out the others take notice of before their next
//! step, and plan anew.

use super::Optimism;
use super::barren_starts::BarrenStarts;
use super::distances::Distances;
use super::frontier::{FrontierSearch, FrontierView, Interest};
use super::model::{ExplorationModel, RecordedStep, Survey};
use super::objective::{MAPPED_ROUNDS, ObjectiveView, SearchObjective};
use crate::env::Action;
use crate::graph::{StateId, TransitionGraph};
use crate::shaping::Potential;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// One explorer: where it began, what it has planned, and its own random stream. Memory O(n).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Explorer {
    search: FrontierSearch,
    /// Hops from a start, and from which.
    from_start: Distances,
    hops_from: Option<StateId>,
    start: StateId,
    barren: BarrenStarts,
    /// The action of the step before, within the episode.
    last_action: Option<Action>,
    /// Steps of the episode so far.
    age: u32,
    /// By objective: the state from which a search has found nothing. Searching again is no use until the graph or the
    /// start changes; until the next episode, if it was not the start, from where more may be in reach.
    exhausted: [Option<StateId>; SearchObjective::COUNT],
    /// The best that was left at the last search, and what was known then: nothing better is left while that is all.
    best_left: Option<(Survey, Interest)>,
    /// No number of tries has anything left to show, as far as can be seen from here.
    is_closed: bool,
    /// The plan is not one for a shorter path to what is known.
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
            hops_from: None,
            start: StateId(0),
            barren: BarrenStarts::default(),
            last_action: None,
            age: 0,
            exhausted: [None; SearchObjective::COUNT],
            best_left: None,
            is_closed: false,
            searching: false,
            discoveries: 0,
            goal_changes: 0,
            rng,
        }
    }

    /// Begins an episode in `start`, a state of `graph`. O(1); but the first search from another start than that of the last episode costs
    /// O(n + m) more, unless it is known to find nothing.
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
        self.last_action = None;
        self.age = 0;
        self.best_left = None;
        self.is_closed = false;
        for exhausted in &mut self.exhausted {
            *exhausted = exhausted.filter(|from| *from == start);
        }
        if start != self.start {
            self.start = start;
            self.is_closed = false;
            for objective in SearchObjective::ALL {
                let is_barren = self.barren.is_barren(model, objective, start);
                self.exhausted[objective as usize] = is_barren.then_some(start);
            }
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
        self.age = self.age.saturating_add(1);
        model.longest = model.longest.max(self.age);
        self.last_action = Some(step.action);
        if step.first_time {
            self.exhausted[SearchObjective::FirstGoal as usize] = None;
            self.is_closed = false;
            self.from_start.append(step.from, step.to);
        }
        model.learn(graph, step, self.searching);
        if self.search.awaits_place()
            && let Some(place) = model.reckoning.place(step.to)
        {
            self.search.arrive(step.to, &place);
        }
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
            self.search_anew();
        }
        if self.discoveries != model.discoveries {
            self.discoveries = model.discoveries;
            self.exhausted[SearchObjective::FirstGoal as usize] = None;
            self.is_closed = false;
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

    /// Nothing is known to be out of reach.
    fn search_anew(&mut self) {
        self.exhausted = [None; SearchObjective::COUNT];
        self.is_closed = false;
        self.hops_from = None;
    }

    /// Hops from the start, once a goal is known, and to the goals. O(n + m) if the start or the goals have changed, else O(1).
    fn reckon_hops(&mut self, model: &mut ExplorationModel, graph: &TransitionGraph) {
        if !model.destinations.is_empty() && self.hops_from != Some(self.start) {
            if self.hops_from.is_some() {
                model.update_distances(graph); // or else they have just been, with the goals
            }
            self.from_start.search_from(model.known(graph), self.start);
            self.hops_from = Some(self.start);
        }
    }

    /// Whether no shorter path is looked for from this start.
    #[cfg(test)]
    pub(super) fn expects_nothing(&self) -> bool {
        self.exhausted[SearchObjective::ShorterPath as usize] == Some(self.start)
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
        let objectives: &[SearchObjective] = match model.destinations.is_empty() {
            true => &[SearchObjective::FirstGoal],
            false => &[SearchObjective::ShorterPath, SearchObjective::OtherGoal],
        };
        for &objective in objectives {
            if self.is_wanted(model, graph, objective, state)
                && self.finds(model, graph, objective, state)
            {
                self.searching = objective != SearchObjective::ShorterPath;
                return self.search.planned(state);
            }
        }
        self.searching = false;
        None
    }

    /// Looks for something to try, if need be closer or again.
    fn finds(
        &mut self,
        model: &mut ExplorationModel,
        graph: &TransitionGraph,
        objective: SearchObjective,
        state: StateId,
    ) -> bool {
        if self.look(model, graph, state, objective) {
            return true;
        }
        objective == SearchObjective::FirstGoal
            && (self.look_closer(model, graph, state)
                || (model.is_lost && self.look_again(model, graph, state)))
    }

    /// Everything was tried often enough, but where actions slip a door may have been missed, or an outcome that is worth more than
    /// all that were seen: asks for one more try of everything, or as many as it takes to find something that can be tried again.
    fn look_closer(
        &mut self,
        model: &mut ExplorationModel,
        graph: &TransitionGraph,
        state: StateId,
    ) -> bool {
        if self.is_closed {
            return false;
        }
        let objective = SearchObjective::FirstGoal;
        let before = model.tries_wanted;
        for _ in 0..=MAPPED_ROUNDS {
            if !model.may_look_closer(graph) {
                return false;
            }
            model.tries_wanted += 1;
            self.exhausted[objective as usize] = None;
            if self.look(model, graph, state, objective) {
                return true;
            }
        }
        model.tries_wanted = before;
        self.is_closed = true;
        false
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

    /// While nothing is known that is worth having, everything is looked for. Then what may be gained has to be worth the steps
    /// ([`SearchBudget`](super::search_budget)): a search begins at the start of an episode, so that what is near is found first, once there is
    /// enough for a trip as long as the best path, or the longest episode where no path ends anywhere.
    fn is_wanted(
        &self,
        model: &ExplorationModel,
        graph: &TransitionGraph,
        objective: SearchObjective,
        state: StateId,
    ) -> bool {
        let (params, budget) = (&model.params, &model.budget);
        let best = f64::from(model.best_steps(self.start));
        let known = graph.num_states();
        let episode = f64::from(model.longest).min(known as f64);
        let (trip, share) = match objective {
            SearchObjective::FirstGoal if !model.something_pays => return true,
            _ if params.optimism == Optimism::None => return false,
            SearchObjective::FirstGoal => (episode, params.reward_search_share),
            SearchObjective::ShorterPath => return model.time_counts,
            SearchObjective::OtherGoal if params.optimism == Optimism::AnyGoal => return true,
            SearchObjective::OtherGoal if model.goals_pay => (best, params.reward_search_share),
            SearchObjective::OtherGoal => (best, params.search_share),
        };
        let left = budget.left(trip, share, known);
        match self.searching {
            true => left > 0.0,
            false => left >= trip && (state == self.start || self.age as usize > 2 * known),
        }
    }

    /// Plans a step of `objective` from `state`; whether there is one.
    fn look(
        &mut self,
        model: &mut ExplorationModel,
        graph: &TransitionGraph,
        state: StateId,
        objective: SearchObjective,
    ) -> bool {
        if self.exhausted[objective as usize].is_some() {
            return false;
        }
        self.reckon_hops(model, graph);
        let model = &*model;
        let view = ObjectiveView::new(model, graph, objective, self.start, &self.from_start);
        let survey = model.survey(graph, objective);
        let known_best = match self.best_left {
            Some((as_of, kind)) if as_of == survey => kind,
            _ => Interest::Promising,
        };
        let (search, rng) = (&mut self.search, &mut self.rng);
        let mut found = search.search(&view, state, self.last_action, known_best, rng);
        self.best_left = found.map(|kind| (survey, kind));
        // What is in reach by good luck only comes last.
        if found.is_none() && model.stochastic && objective == SearchObjective::FirstGoal {
            let view = view.trusting_to_luck();
            found = search.search(&view, state, self.last_action, Interest::Promising, rng);
        }
        if found.is_none() {
            self.exhausted[objective as usize] = Some(state);
            if objective != SearchObjective::FirstGoal && state == self.start {
                self.barren.note(model, objective, state);
            }
        }
        found.is_some()
    }
}
