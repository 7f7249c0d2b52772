//! Objectives of a search: what is worth trying, by what is looked for.

use super::dead_reckoning::Prediction;
use super::distances::Distances;
use super::frontier::{FrontierView, Interest};
use super::model::ExplorationModel;
use crate::env::Action;
use crate::graph::connectivity::UNREACHED;
use crate::graph::{StateId, TransitionGraph};

/// Beyond this many tries an action has shown what it can do: a slip of 0.3 hides a door with probability 0.3^16.
pub(super) const MAX_TRIES_WANTED: u32 = 16;
/// Up to these `tries_wanted` the map is believed.
const MAPPED_ROUNDS: u32 = 4;
/// A wall is believed when an open way would have gone unnoticed with this probability, to the power of `tries_wanted`.
const DOUBT: f64 = 0.2;

/// What the search looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
}

/// The graph as an objective sees it.
pub(super) struct ObjectiveView<'a> {
    graph: &'a TransitionGraph,
    model: &'a ExplorationModel,
    from_start: &'a Distances,
    tries_wanted: u32,
    objective: SearchObjective,
    /// L, in hops ([`ExplorationModel::best_steps`]); unbounded where a longer path may be worth more.
    best: u32,
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
                SearchObjective::OtherGoal if model.goals_pay => UNREACHED,
                _ => model.best_steps(start),
            },
        }
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

    /// Whether `action` is known to lead from `state` to one that was not entered since the goal was lost.
    fn leads_to_stale(&self, state: StateId, action: Action) -> bool {
        !self.model.stale.is_empty()
            && self
                .successor(state, action)
                .is_some_and(|next| self.model.stale.contains(next))
    }

    /// The fewest steps to a goal that trying `action` in `state` could turn out to leave, that step included.
    fn optimistic_steps(&self, state: StateId, action: Action, prediction: Prediction) -> u32 {
        match (self.objective, prediction) {
            (_, Prediction::Undo(_)) => UNREACHED,
            // A goal not seen yet is no state that is known.
            (SearchObjective::OtherGoal, Prediction::Known(_)) => UNREACHED,
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

impl FrontierView for ObjectiveView<'_> {
    fn num_actions(&self) -> usize {
        self.graph.num_actions()
    }

    fn successor(&self, state: StateId, action: Action) -> Option<StateId> {
        if self.has_map() {
            let next = self
                .model
                .reckoning
                .neighbor_towards(self.graph, state, action);
            return next.filter(|_| !self.is_terminal(state));
        }
        self.graph.likely_successor(state, action).or_else(|| {
            match self.model.reckoning.predict(self.graph, state, action) {
                Prediction::Undo(next) if !self.is_terminal(state) => Some(next),
                _ => None,
            }
        })
    }

    /// Before the first goal: new places before known ones, and places among known ones before those in the open, so that
    /// no holes are left behind.
    fn preference(&self, state: StateId, action: Action) -> u32 {
        if self.objective != SearchObjective::FirstGoal {
            return 0;
        }
        match self.model.reckoning.predict(self.graph, state, action) {
            Prediction::Known(_) => 0,
            _ => 1 + self.model.reckoning.known_sides(state, action),
        }
    }

    fn interest(&self, state: StateId, action: Action) -> Interest {
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
                Prediction::Undo(_) => Interest::LastResort,
                _ => Interest::Promising,
            };
        }
        let through = self
            .from_start
            .get(state)
            .saturating_add(self.optimistic_steps(state, action, prediction));
        if through < self.best {
            Interest::Promising
        } else {
            Interest::None
        }
    }
}
