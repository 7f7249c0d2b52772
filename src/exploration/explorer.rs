//! The explorer: where to look before the first goal, what is still worth a look after it.
//!
//! **Before the first goal** it advises the way to the nearest promising untried action; one whose outcome is
//! plain, because it undoes a step, is a last resort. **After it**, with d₀ the hops from the start, d* the hops to the
//! goal and L = d*(start), an untried action a of s is tried only if the best that it could lead to is an
//! improvement: d₀(s) + 1 + h < L, where h is the lower bound of dead reckoning, or 0 without it (with which this is
//! the optimism of R-max). When nothing is left to try, the advice is the rise of the potential along each action.

use super::ExplorationParams;
use super::Optimism;
use super::displacement::{Displacements, Prediction};
use super::distances::{Distances, UNREACHED};
use super::frontier::{FrontierSearch, FrontierView, Interest};
use crate::env::Action;
use crate::graph::{StateId, TransitionGraph};
use crate::shaping::Potential;
use rand_chacha::ChaCha8Rng;

/// A goal as the explorer sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Destination {
    /// Where it is.
    pub state: StateId,
    /// By how many steps it is worse than the best goal.
    pub handicap: u32,
}

/// What the search looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quest {
    /// The first goal.
    FirstGoal,
    /// A shorter way to the goals seen.
    ShorterPath,
    /// A goal not seen yet that is nearer than the best one seen.
    OtherGoal,
}

/// Frontier exploration with all it has learnt.
#[derive(Clone, Debug)]
pub struct Explorer {
    params: ExplorationParams,
    search: FrontierSearch,
    displacements: Displacements,
    from_start: Distances,
    to_goal: Distances,
    destinations: Vec<Destination>,
    terminal: Vec<bool>,
    heading: Option<Action>,
    start: StateId,
    /// Nothing is left of this quest until the graph or the start changes.
    exhausted: [bool; 2],
    /// Steps since the first goal, and how many of them went into [`Quest::OtherGoal`].
    steps: u64,
    search_steps: u64,
    searching: bool,
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
            heading: None,
            start: StateId(0),
            exhausted: [false; 2],
            steps: 0,
            search_steps: 0,
            searching: false,
            stochastic: false,
            tries_wanted: 1,
            rng,
        }
    }

    /// Begins an episode in `start`. O(n + m) if the start is not that of the last episode and a goal is known.
    pub fn begin_episode(&mut self, graph: &TransitionGraph, start: StateId) {
        self.displacements.add_start(start);
        self.search.clear();
        self.heading = None;
        if start != self.start {
            self.start = start;
            self.refresh(graph);
        }
    }

    /// Learns from a step that the graph has recorded; `first_time` if this outcome was not seen before.
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
        if first_time {
            self.stochastic |= graph.tries(from, action) > 1;
            self.displacements.learn(graph, from, action, to);
            self.from_start.append(from, to);
            self.to_goal.append(from, to);
        }
    }

    /// Tells which goals are known, and that the graph has changed enough to reckon distances anew. O(n + m).
    pub fn set_destinations(&mut self, graph: &TransitionGraph, destinations: &[Destination]) {
        self.destinations.clear();
        self.destinations.extend_from_slice(destinations);
        self.search.clear();
        self.refresh(graph);
    }

    /// Hops from the farthest state that can reach a goal; 0 before the first goal.
    pub fn eccentricity(&self) -> u32 {
        self.to_goal.eccentricity()
    }

    fn refresh(&mut self, graph: &TransitionGraph) {
        self.exhausted = [false; 2];
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

    /// Writes the advice for `state` into `advice`, one logit per action. `unit` is the rise of the potential that
    /// one step towards the goal is worth on average.
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
            self.advise_potential(graph, state, potential, unit, advice);
        }
    }

    /// The next step of the quest in hand, if there is one.
    fn plan(&mut self, graph: &TransitionGraph, state: StateId) -> Option<Action> {
        if let Some(action) = self.search.planned(state) {
            return Some(action);
        }
        if self.destinations.is_empty() {
            if !self.look(graph, state, Quest::FirstGoal) && self.stochastic {
                self.tries_wanted += 1;
                self.look(graph, state, Quest::FirstGoal);
            }
            return self.search.planned(state);
        }
        for (i, quest) in [Quest::ShorterPath, Quest::OtherGoal]
            .into_iter()
            .enumerate()
        {
            if !self.exhausted[i] && self.is_wanted(quest, state) {
                self.exhausted[i] = !self.look(graph, state, quest);
                if !self.exhausted[i] {
                    self.searching = quest == Quest::OtherGoal;
                    return self.search.planned(state);
                }
            }
        }
        self.searching = false;
        None
    }

    /// Looking for other goals may cost one best path, and `search_share` of the steps on top. It begins at the start
    /// of an episode, so that near goals are found first, once there is enough for a trip as long as the best path.
    fn is_wanted(&self, quest: Quest, state: StateId) -> bool {
        match (quest, self.params.optimism) {
            (_, Optimism::None) => false,
            (Quest::OtherGoal, Optimism::SeenGoals) => {
                let trip = f64::from(self.to_goal.get(self.start));
                let left =
                    trip + self.params.search_share * self.steps as f64 - self.search_steps as f64;
                if self.searching {
                    left > 0.0
                } else {
                    state == self.start && left >= trip
                }
            }
            _ => true,
        }
    }

    fn look(&mut self, graph: &TransitionGraph, state: StateId, quest: Quest) -> bool {
        let best = self.to_goal.get(self.start);
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
            quest,
            best,
        };
        self.search
            .search(&mut view, state, self.heading, &mut self.rng)
    }

    /// Look-ahead advice: the expected rise of the potential along each action whose outcome is known.
    fn advise_potential(
        &mut self,
        graph: &TransitionGraph,
        state: StateId,
        potential: &impl Potential,
        unit: f64,
        advice: &mut [f64],
    ) {
        let here = potential.value(state);
        let weight = self.params.potential_advice / unit;
        for (i, logit) in advice.iter_mut().enumerate() {
            let action = Action(i as u16);
            if graph.tries(state, action) == 0 {
                if let Prediction::Undo(next) = self.displacements.predict(graph, state, action) {
                    *logit = weight * (potential.value(next) - here);
                }
            }
        }
        for outcome in graph.outcomes(state) {
            let tries = f64::from(graph.tries(state, outcome.action)) + self.doubt();
            let share = f64::from(outcome.count) / tries;
            advice[outcome.action.index()] +=
                weight * share * (potential.value(outcome.next) - here);
        }
        if self.stochastic {
            self.add_doubt(graph, state, potential, weight, advice);
        }
    }

    /// Outcomes not seen that count beside those seen: where actions slip, one bad try must not rule an action out.
    fn doubt(&self) -> f64 {
        if self.stochastic { 1.0 } else { 0.0 }
    }

    /// The unseen outcome of every tried action might be the best neighbour of `state`.
    fn add_doubt(
        &self,
        graph: &TransitionGraph,
        state: StateId,
        potential: &impl Potential,
        weight: f64,
        advice: &mut [f64],
    ) {
        let here = potential.value(state);
        let neighbors = graph.adjacency().neighbors(state.0).iter();
        let best = neighbors
            .map(|&next| potential.value(StateId(next)) - here)
            .fold(0.0, f64::max);
        for (i, logit) in advice.iter_mut().enumerate() {
            let tries = graph.tries(state, Action(i as u16));
            if tries > 0 {
                *logit += weight * best * self.doubt() / (f64::from(tries) + self.doubt());
            }
        }
    }
}

/// The graph through the eyes of a quest.
struct QuestView<'a> {
    graph: &'a TransitionGraph,
    displacements: &'a mut Displacements,
    from_start: &'a Distances,
    destinations: &'a [Destination],
    terminal: &'a [bool],
    tries_wanted: u32,
    quest: Quest,
    best: u32,
}

impl QuestView<'_> {
    fn is_terminal(&self, state: StateId) -> bool {
        self.terminal.get(state.index()).copied().unwrap_or(false)
    }

    /// Whether as many neighbours of `state` are known as it has actions, so that trying one again shows nothing new.
    fn is_complete(&self, state: StateId) -> bool {
        self.graph.adjacency().neighbors(state.0).len() >= self.graph.num_actions()
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
        let tries = self.graph.tries(state, action);
        if tries >= self.tries_wanted
            || self.is_terminal(state)
            || (tries > 0 && self.is_complete(state))
        {
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
