//! What is worth trying, by what is looked for: the eyes of the search for the nearest frontier.

use super::Destination;
use crate::env::Action;
use crate::exploration::displacement::{Displacements, Prediction};
use crate::exploration::distances::Distances;
use crate::exploration::frontier::{FrontierView, Interest};
use crate::exploration::stale::StaleStates;
use crate::graph::connectivity::UNREACHED;
use crate::graph::{StateId, TransitionGraph};

/// What the search looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quest {
    /// Any goal, when none is known.
    FirstGoal,
    /// A shorter way to the goals seen.
    ShorterPath,
    /// A goal not seen yet that is nearer than the best one seen.
    OtherGoal,
}

impl Quest {
    pub(super) const COUNT: usize = 3;
}

/// The graph through the eyes of a quest.
pub(super) struct QuestView<'a> {
    pub graph: &'a TransitionGraph,
    pub displacements: &'a mut Displacements,
    pub from_start: &'a Distances,
    pub destinations: &'a [Destination],
    pub terminal: &'a [bool],
    pub tries_wanted: u32,
    pub stale: &'a StaleStates,
    pub quest: Quest,
    /// L, the steps of the best path known from the start to a goal.
    pub best: u32,
}

impl QuestView<'_> {
    fn is_terminal(&self, state: StateId) -> bool {
        self.terminal.get(state.index()).copied().unwrap_or(false)
    }

    /// Whether as many neighbours of `state` are known as it has actions, so that trying one again shows nothing new.
    fn is_complete(&self, state: StateId) -> bool {
        self.graph.adjacency().neighbors(state.0).len() >= self.graph.num_actions()
    }

    /// Whether `action` is known to lead from `state` to one that was not entered since the goal was lost.
    fn leads_to_stale(&mut self, state: StateId, action: Action) -> bool {
        !self.stale.is_empty()
            && self
                .successor(state, action)
                .is_some_and(|next| self.stale.contains(next))
    }

    /// The fewest steps to a goal that trying `action` in `state` could turn out to leave, that step included.
    fn optimistic_steps(&mut self, state: StateId, action: Action, prediction: Prediction) -> u32 {
        match (self.quest, prediction) {
            (_, Prediction::Undo(_)) => UNREACHED,
            // A goal not seen yet is no state that is known.
            (Quest::OtherGoal, Prediction::Known(_)) => UNREACHED,
            (Quest::OtherGoal, _) => 1,
            _ => {
                let bounds = self.destinations.iter().map(|goal| {
                    goal.handicap
                        .saturating_add(self.displacements.lower_bound(state, action, goal.state))
                });
                bounds.min().unwrap_or(0).saturating_add(1)
            }
        }
    }
}

impl FrontierView for QuestView<'_> {
    fn num_actions(&self) -> usize {
        self.graph.num_actions()
    }

    fn successor(&mut self, state: StateId, action: Action) -> Option<StateId> {
        self.graph.likely_successor(state, action).or_else(|| {
            match self.displacements.predict(self.graph, state, action) {
                Prediction::Undo(next) if !self.is_terminal(state) => Some(next),
                _ => None,
            }
        })
    }

    fn interest(&mut self, state: StateId, action: Action) -> Interest {
        if self.is_terminal(state) {
            return Interest::None;
        }
        if self.leads_to_stale(state, action) {
            return Interest::Promising;
        }
        let tries = self.graph.tries(state, action);
        if tries >= self.tries_wanted || (tries > 0 && self.is_complete(state)) {
            return Interest::None;
        }
        let prediction = self.displacements.predict(self.graph, state, action);
        if self.quest == Quest::FirstGoal {
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
