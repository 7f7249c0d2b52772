//! Objectives of a search: what is worth trying, by what is looked for.

use super::SearchOrder;
use super::dead_reckoning::{Place, Prediction};
use super::distances::Distances;
use super::frontier::{FrontierView, Interest};
use super::model::ExplorationModel;
use crate::env::Action;
use crate::graph::connectivity::UNREACHED;
use crate::graph::{StateId, TransitionGraph};
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::collections::HashMap;

/// Beyond this many tries an action has shown what it can do: a slip of 0.3 hides a door with probability 0.3^16.
pub(super) const MAX_TRIES_WANTED: u32 = 16;
/// An action that mostly stays counts as a way if so many tries lead on once.
const MOST_REPETITIONS: u32 = 5;
/// Up to these `tries_wanted` the map is believed.
pub(super) const MAPPED_ROUNDS: u32 = 4;
/// A wall is believed when an open way would have gone unnoticed with this probability, to the power of `tries_wanted`.
const DOUBT: f64 = 0.2;

/// What the search looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum SearchObjective {
    /// Any goal, when none is known.
    FirstGoal,
    /// A shorter way to the goals seen.
    ShorterPath,
    /// A goal not seen yet that is nearer than the best one seen, or, where goals pay, one that may pay more.
    OtherGoal,
}

impl SearchObjective {
    pub(super) const COUNT: usize = 3;
    pub(super) const ALL: [Self; Self::COUNT] =
        [Self::FirstGoal, Self::ShorterPath, Self::OtherGoal];
}

/// The graph as an objective sees it.
pub(super) struct ObjectiveView<'a> {
    graph: &'a TransitionGraph,
    model: &'a ExplorationModel,
    from_start: &'a Distances,
    tries_wanted: u32,
    objective: SearchObjective,
    /// L, in hops ([`ExplorationModel::best_steps`]), or what is worth it for another goal ([`ExplorationModel::worthwhile_steps`]).
    best: u32,
    /// Places where a state is expected that is not known yet.
    expected: RefCell<ExpectedPlaces>,
    /// Whether all outcomes seen of an action count as ways, besides the likely one.
    trusts_luck: bool,
}

impl<'a> ObjectiveView<'a> {
    /// What `model` and `graph` show to an explorer that began in `start`, from where the hops are `from_start`.
    pub fn new(
        model: &'a ExplorationModel,
        graph: &'a TransitionGraph,
        objective: SearchObjective,
        start: StateId,
        from_start: &'a Distances,
    ) -> Self {
        Self {
            graph,
            model,
            from_start,
            tries_wanted: match objective {
                SearchObjective::FirstGoal => model.tries_wanted,
                _ => 1,
            },
            objective,
            best: match objective {
                SearchObjective::OtherGoal => model.worthwhile_steps(start),
                _ => model.best_steps(start),
            },
            expected: RefCell::new(ExpectedPlaces::beyond(graph.num_states())),
            trusts_luck: false,
        }
    }

    /// The same where all that has ever happened may happen again.
    pub fn trusting_to_luck(mut self) -> Self {
        self.trusts_luck = true;
        self
    }

    /// The state that `action` leads to, if that is known well enough to walk there.
    fn successor(&self, state: StateId, action: Action) -> Option<StateId> {
        if self.has_map() {
            let next = self
                .model
                .reckoning
                .neighbor_towards(self.graph, state, action);
            return next.filter(|_| !self.is_terminal(state));
        }
        if self.graph.tries(state, action) > 0 {
            return self.likely_step(state, action);
        }
        match self.model.reckoning.predict(self.graph, state, action) {
            _ if self.is_terminal(state) => None,
            Prediction::Undo(next) | Prediction::Turn(next) => Some(next),
            Prediction::Known(next) if self.objective == SearchObjective::FirstGoal => {
                self.is_by_place().then_some(next)
            }
            Prediction::OtherHeading if self.objective == SearchObjective::FirstGoal => {
                let place = self.model.reckoning.place(state)?;
                self.expected_successor(&place, action)
            }
            _ => None,
        }
    }

    /// Where `action`, which was tried, mostly leads. Where it mostly stays, it goes on if it is taken again and again, unless that takes too long.
    fn likely_step(&self, state: StateId, action: Action) -> Option<StateId> {
        let likely = self.graph.likely_successor(state, action)?;
        if likely != state {
            return Some(likely);
        }
        let next = self.graph.likely_departure(state, action)?;
        let outcomes = self.graph.outcomes_of(state, action);
        let times: u32 = outcomes
            .filter(|seen| seen.next == next)
            .map(|seen| seen.count)
            .sum();
        let patience = times.saturating_mul(MOST_REPETITIONS);
        (patience >= self.graph.tries(state, action)).then_some(next)
    }

    /// The state, known or expected, to which `action` leads from a place, if that is a point where some state lies.
    fn expected_successor(&self, place: &Place, action: Action) -> Option<StateId> {
        match self.model.reckoning.predict_from(place, action) {
            (Prediction::Turn(next) | Prediction::Known(next), _) => Some(next),
            (Prediction::OtherHeading, next) if !self.may_end_at(&next) => {
                Some(self.expected.borrow_mut().intern(&next))
            }
            _ => None,
        }
    }

    /// Whether episodes have ended at the point of `place`, with some heading.
    fn may_end_at(&self, place: &Place) -> bool {
        let mut states = self.model.reckoning.states_at(place);
        states.any(|state| self.is_terminal(state))
    }

    /// Whether `action` leads from `state` to a point where episodes have ended.
    fn may_end_ahead(&self, state: StateId, action: Action) -> bool {
        let reckoning = &self.model.reckoning;
        let place = reckoning.place(state);
        place.is_some_and(|place| self.may_end_at(&reckoning.predict_from(&place, action).1))
    }

    /// Where a state lies that is expected and not known.
    fn place_of_expected(&self, state: StateId) -> Option<Place> {
        self.expected.borrow().get(state)
    }

    fn is_terminal(&self, state: StateId) -> bool {
        self.model
            .terminal
            .get(state.index())
            .copied()
            .unwrap_or(false)
    }

    /// Whether as many neighbours of `state` are known as it has actions, so that trying one again shows nothing new.
    fn is_complete(&self, state: StateId) -> bool {
        self.graph.adjacency().neighbors(state.0).len() >= self.graph.num_actions()
    }

    /// Whether to go by what actions do elsewhere. Not any more if that leaves nothing to try and there must be something.
    fn has_map(&self) -> bool {
        self.tries_wanted <= MAPPED_ROUNDS && self.model.reckoning.noise().is_some()
    }

    /// Whether trying `action` in `state` again is no use.
    fn is_tried(&self, state: StateId, action: Action) -> bool {
        let tries = self.graph.tries(state, action);
        if self.has_map() {
            tries >= MAX_TRIES_WANTED || self.is_open(state, action) || self.is_wall(state, action)
        } else {
            tries >= self.tries_wanted || (tries > 0 && self.is_complete(state))
        }
    }

    fn is_open(&self, state: StateId, action: Action) -> bool {
        let next = self
            .model
            .reckoning
            .neighbor_towards(self.graph, state, action);
        next.is_some()
    }

    /// Where actions slip: whether `action` went nowhere so often that it cannot be for want of luck. A try of an open
    /// way comes to nothing only if it slips into a wall, with the chance q of the sides where no way is known.
    fn is_wall(&self, state: StateId, action: Action) -> bool {
        let outcomes = self.graph.outcomes(state);
        let bumps: u32 = outcomes
            .filter(|outcome| outcome.action == action && outcome.next == state)
            .map(|outcome| outcome.count)
            .sum();
        if bumps == 0 {
            return false;
        }
        let sides = (0..self.num_actions() as u16).map(Action);
        let chance = |side| match self.is_open(state, side) {
            true => 0.0,
            false => self
                .model
                .reckoning
                .noise()
                .map_or(0.0, |noise| noise.share(action, side)),
        };
        let q: f64 = sides.filter(|&side| side != action).map(chance).sum();
        libm::pow(q, f64::from(bumps)) <= libm::pow(DOUBT, f64::from(self.tries_wanted))
    }

    fn is_by_place(&self) -> bool {
        self.model.params.order == SearchOrder::ByPlace
    }

    /// Of things that may be anywhere: new points first, then new headings, then what is most likely known already.
    fn rank(&self, prediction: Prediction) -> Interest {
        match prediction {
            Prediction::Fresh | Prediction::Unknown => Interest::Promising,
            Prediction::OtherHeading => Interest::Incidental,
            Prediction::Known(_) if !self.is_by_place() => Interest::Promising,
            Prediction::Known(_) | Prediction::Wall | Prediction::Idle => Interest::Doubtful,
            Prediction::Undo(_) | Prediction::Turn(_) => Interest::LastResort,
        }
    }

    /// Whether `action` is known to lead from `state` to one that was not entered since the goal was lost.
    fn leads_to_stale(&self, state: StateId, action: Action) -> bool {
        !self.model.stale.is_empty()
            && match self.graph.tries(state, action) {
                0 => self.successor(state, action),
                _ => self.graph.likely_successor(state, action),
            }
            .is_some_and(|next| self.model.stale.contains(next))
    }

    /// The fewest steps to a goal that trying `action` in `state` could turn out to leave, that step included.
    fn optimistic_steps(&self, state: StateId, action: Action, prediction: Prediction) -> u32 {
        match (self.objective, prediction) {
            (_, Prediction::Undo(_)) => UNREACHED,
            // Left to whoever learns: it would be one action of four in every state of a world with tools.
            (SearchObjective::ShorterPath, Prediction::Idle) => UNREACHED,
            (SearchObjective::ShorterPath, Prediction::Turn(next)) => {
                self.model.to_goal.get(next).saturating_add(1)
            }
            // A goal not seen yet is no state that is known.
            (SearchObjective::OtherGoal, Prediction::Turn(_) | Prediction::Known(_)) => UNREACHED,
            (SearchObjective::OtherGoal, _) => 1,
            _ => {
                let bounds = self.model.destinations.iter().map(|goal| {
                    goal.handicap
                        .saturating_add(self.model.reckoning.lower_bound(state, action, goal.state))
                });
                bounds.min().unwrap_or(0).saturating_add(1)
            }
        }
    }
}

/// Places that are expected to be entered on the way of one search, numbered from the first state that is not known.
struct ExpectedPlaces {
    first: usize,
    places: Vec<Place>,
    numbers: HashMap<Vec<i32>, StateId, foldhash::fast::FixedState>,
}

impl ExpectedPlaces {
    fn beyond(num_states: usize) -> Self {
        Self {
            first: num_states,
            places: Vec::new(),
            numbers: HashMap::default(),
        }
    }

    fn get(&self, state: StateId) -> Option<Place> {
        let place = state.index().checked_sub(self.first)?;
        Some(self.places[place])
    }

    fn intern(&mut self, place: &Place) -> StateId {
        if let Some(&known) = self.numbers.get(&**place) {
            return known;
        }
        let number = StateId((self.first + self.places.len()) as u32);
        self.places.push(*place);
        self.numbers.insert(place.to_vec(), number);
        number
    }
}

impl FrontierView for ObjectiveView<'_> {
    fn num_actions(&self) -> usize {
        self.graph.num_actions()
    }

    fn successors(&self, state: StateId, action: Action) -> impl Iterator<Item = StateId> {
        let likely = match self.place_of_expected(state) {
            Some(place) => self.expected_successor(&place, action),
            None => self.successor(state, action),
        };
        let outcomes = self.graph.outcomes_of(state, action);
        let lucky = outcomes.filter(|_| self.trusts_luck).map(|seen| seen.next);
        likely.into_iter().chain(lucky)
    }

    fn expected_place(&self, state: StateId) -> Option<Vec<i32>> {
        self.place_of_expected(state).map(|place| place.to_vec())
    }

    /// Before the first goal: new places before known ones, and places among known ones before those in the open, so that
    /// no holes are left behind.
    fn preference(&self, state: StateId, action: Action) -> u32 {
        if self.objective != SearchObjective::FirstGoal {
            return 0;
        }
        let reckoning = &self.model.reckoning;
        let place = self.place_of_expected(state);
        let Some(place) = place.or_else(|| reckoning.place(state)) else {
            return 1;
        };
        match reckoning.predict_from(&place, action) {
            (Prediction::Known(_) | Prediction::OtherHeading, _) => 0,
            (_, target) => 1 + reckoning.known_sides(&target),
        }
    }

    fn interest(&self, state: StateId, action: Action) -> Interest {
        if let Some(place) = self.place_of_expected(state) {
            return match self.model.reckoning.predict_from(&place, action).0 {
                Prediction::Fresh => Interest::Promising,
                _ => Interest::None,
            };
        }
        if self.is_terminal(state) {
            return Interest::None;
        }
        if self.leads_to_stale(state, action) {
            return Interest::Promising;
        }
        if self.is_tried(state, action) {
            return Interest::None;
        }
        let prediction = self.model.reckoning.predict(self.graph, state, action);
        if self.objective == SearchObjective::FirstGoal {
            return match prediction {
                Prediction::OtherHeading if self.may_end_ahead(state, action) => Interest::Doubtful,
                _ => self.rank(prediction),
            };
        }
        let through = self
            .from_start
            .get(state)
            .saturating_add(self.optimistic_steps(state, action, prediction));
        // A turn that is known to be on a best path is taken once, so that everybody knows.
        let is_on_path = matches!(prediction, Prediction::Turn(_)) && through == self.best;
        match through < self.best || (is_on_path && through < UNREACHED) {
            // All of it is to be seen in the end, and least in as many trips as it takes.
            true if prediction == Prediction::Idle => Interest::Doubtful,
            true => Interest::Promising,
            false => Interest::None,
        }
    }
}
