//! Displacements of actions, learnt from what they did: which action undoes which, and where a path has led.
//!
//! Suppose every action a moves by a fixed displacement δ_a of an abelian group, or not at all (a wall). Then
//! positions follow by dead reckoning, pos(s′) = pos(s) + δ_a, and two facts come for free: where an untried
//! action would lead, and a lower bound Σ|pos(s) − pos(g)| on the steps from s to g. Grid worlds are like that,
//! most other worlds are not, and nobody tells the agent: the hypothesis is built from the transitions seen
//! (pairs of actions that undo one another share an axis with opposite signs) and tested on every loop that
//! closes. While it is not confirmed, or once loops contradict it, no places are predicted and the bound is 0.
//!
//! Where actions turn, a place has a heading, too, and what an action does to a place depends on it ([`chart`], [`headings`]).
//!
//! Where actions slip, one step tells little; [`relocation`] then takes all steps together, and [`action_noise`] says how an
//! action's outcomes are spread.

pub mod action_noise;
mod chart;
mod headings;
mod moves;
mod placement;
pub mod relocation;

pub use action_noise::ActionNoise;

use crate::env::Action;
use crate::graph::{StateId, TransitionGraph};
pub(super) use chart::Place;
use chart::{AxisDirection, Chart, Effect, MIN_AGREEMENT};
use headings::Cycles;
use serde::{Deserialize, Serialize};

/// Tests of "b undoes a" before it is believed.
const MIN_UNDO_TESTS: u32 = 2;
/// With more actions than this the table of pairs is not worth its cost.
const MAX_ACTIONS: usize = 16;
/// An action that has moved in less than one of so many states is not expected to.
const RARE: u32 = 64;

/// Expected outcome of an untried action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prediction {
    /// It undoes the step by which the state was entered from this neighbour, or goes a way that is known: as good as
    /// known itself.
    Undo(StateId),
    /// It turns to the place of this state.
    Turn(StateId),
    /// It leads to the place of this state, if nothing stands in between.
    Known(StateId),
    /// It leads to a point where states are known, with other headings.
    OtherHeading,
    /// It hardly ever moves anything.
    Idle,
    /// It leads to a position into which some action bumped from another side.
    Wall,
    /// It leads to a position where no state is known, if nothing stands in between.
    Fresh,
    /// Nothing is known about it.
    Unknown,
}

/// The learnt displacements. Memory O(n · axes + bumps); an update is O(actions · degree), and O(transitions) when the chart is drawn anew.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct DeadReckoning {
    num_actions: usize,
    is_thorough: bool,
    /// `tests[a · A + b]`: transitions a then b, both moving, that could show b undoing a; `undone` of them did.
    tests: Vec<u32>,
    undone: Vec<u32>,
    inverse: Vec<Option<Action>>,
    /// By action: in how many ways it was seen to lead to another state, and in how many states to lead nowhere.
    moves_of: Vec<u32>,
    bumps_of: Vec<u32>,
    chart: Chart,
    cycles: Cycles,
    /// How often what is predicted has changed as a whole.
    revision: u64,
    /// How each state was first entered, in order of discovery; `None` for starts.
    entry: Vec<Option<(StateId, Action)>>,
    /// Steps that led nowhere.
    bumps: Vec<(StateId, Action)>,
    /// Some action has led to two places.
    stochastic: bool,
    noise: Option<ActionNoise>,
    steps: u64,
    /// When to reckon anew, in steps.
    due: u64,
}

impl DeadReckoning {
    /// Nothing known yet; `is_thorough`: walls, headings and idle actions are learnt, too.
    pub fn new(num_actions: usize, is_thorough: bool) -> Self {
        let own_axis = |axis| Effect::Shift(AxisDirection { axis, sign: 1 });
        Self {
            num_actions,
            is_thorough,
            tests: vec![0; num_actions * num_actions],
            undone: vec![0; num_actions * num_actions],
            inverse: vec![None; num_actions],
            moves_of: vec![0; num_actions],
            bumps_of: vec![0; num_actions],
            chart: Chart::new((0..num_actions.min(MAX_ACTIONS)).map(own_axis).collect(), 1),
            cycles: Cycles::new(num_actions),
            revision: 0,
            entry: Vec::new(),
            bumps: Vec::new(),
            stochastic: false,
            noise: None,
            steps: 0,
            due: 0,
        }
    }

    /// Whether places have been confirmed by closed loops.
    pub fn trusted(&self) -> bool {
        self.chart.trusted()
    }

    /// Whether places have headings, and have been confirmed.
    pub fn turns(&self) -> bool {
        self.chart.has_headings() && self.trusted()
    }

    /// Untried turns of `state` that lead to a state that is known. None before places with headings are trusted. O(actions).
    pub fn known_turns(
        &self,
        graph: &TransitionGraph,
        state: StateId,
    ) -> impl Iterator<Item = StateId> {
        let actions = (0..self.num_actions as u16).map(Action);
        let untried = actions
            .filter(move |&action| {
                self.turns() && state.index() < self.chart.len() && self.chart.is_turn(action)
            })
            .filter(move |&action| graph.tries(state, action) == 0);
        untried.filter_map(move |action| self.at(&self.chart.target(state, action)))
    }

    /// States an untried turn of which leads to `state`. None before places with headings are trusted. O(actions).
    pub fn known_turns_to(
        &self,
        graph: &TransitionGraph,
        state: StateId,
    ) -> impl Iterator<Item = StateId> {
        let turns = self.turns().then(|| self.chart.turned_from(state));
        let untried = turns
            .into_iter()
            .flatten()
            .filter(|&(from, action)| graph.tries(from, action) == 0);
        untried.map(|(from, _)| from)
    }

    fn at(&self, place: &Place) -> Option<StateId> {
        self.chart.occupied.get(&**place).copied()
    }

    /// The action that undoes `action`, once believed.
    #[cfg(test)]
    fn inverse(&self, action: Action) -> Option<Action> {
        self.inverse[action.index()]
    }

    /// A state at which an episode began. Only the first start is the origin: further ones have no position
    /// of their own until they are reached, so they stand at the origin and loops will contradict them.
    pub fn add_start(&mut self, start: StateId) {
        if self.num_actions <= MAX_ACTIONS && start.index() == self.entry.len() {
            self.entry.push(None);
            self.append_position(start);
        }
    }

    /// Learns from the first step of `action` in `from`, and from the first one between `from` and `to`. Call after the graph has recorded it.
    pub fn learn(&mut self, graph: &TransitionGraph, from: StateId, action: Action, to: StateId) {
        if self.num_actions > MAX_ACTIONS {
            return;
        }
        if to.index() == self.entry.len() {
            self.entry.push(Some((from, action)));
            self.append_position(to);
        } else if to != from && !self.stochastic {
            self.chart.close_loop(from, action, to);
        }
        if !self.stochastic && graph.tries(from, action) > 1 {
            self.expect_slips();
        }
        if to != from {
            self.moves_of[action.index()] += 1;
            self.test_undoing(graph, from, action, to);
            if self.is_thorough && !self.stochastic {
                self.cycles.learn(graph, from, action, to);
                self.try_headings(graph);
            }
        } else {
            self.bumps_of[action.index()] += 1;
            if self.is_thorough && !self.stochastic {
                self.bumps.push((from, action));
                self.chart.mark_wall(from, action);
            }
        }
    }

    /// What the untried `action` in `from` is expected to do. O(degree).
    pub fn predict(&self, graph: &TransitionGraph, from: StateId, action: Action) -> Prediction {
        if self.stochastic {
            if let Some(next) = self.neighbor_towards(graph, from, action) {
                return Prediction::Undo(next);
            }
        } else if let Some(back) = self.inverse[action.index()] {
            for &neighbor in graph.adjacency().neighbors(from.0) {
                if graph.likely_successor(StateId(neighbor), back) == Some(from) {
                    return Prediction::Undo(StateId(neighbor));
                }
            }
        }
        if self.is_idle(action) {
            return Prediction::Idle;
        }
        if !self.trusted() || from.index() >= self.entry.len() {
            return Prediction::Unknown;
        }
        self.prediction_of(&self.chart.target(from, action), action)
    }

    /// Whether `action` has moved in so few of the states where it was tried that it is not expected to in the next one.
    fn is_idle(&self, action: Action) -> bool {
        let (moves, bumps) = (self.moves_of[action.index()], self.bumps_of[action.index()]);
        self.is_thorough && (moves + 1) * RARE < moves + bumps + 2
    }

    /// How many points are known: what was found since at one of them, with another heading, was expected. As many as states, while places have no headings or are not trusted.
    pub fn num_points(&self, graph: &TransitionGraph) -> usize {
        match self.turns() {
            true => self.chart.num_points(),
            false => graph.num_states(),
        }
    }

    /// Counts how often predictions have changed as a whole.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// States known at the point of `place`, with any heading.
    pub fn states_at(&self, place: &Place) -> impl Iterator<Item = StateId> {
        self.chart.states_at(*place)
    }

    /// Where `state` lies, if it is known and places are trusted.
    pub fn place(&self, state: StateId) -> Option<Place> {
        let is_known = self.trusted() && state.index() < self.chart.len();
        is_known.then(|| Place::of(self.chart.position(state)))
    }

    /// What `action` is expected to do at `place`, where no state need be known, and to where it leads.
    pub fn predict_from(&self, place: &Place, action: Action) -> (Prediction, Place) {
        let target = self.chart.moved(*place, action);
        let prediction = match self.is_idle(action) {
            true => Prediction::Idle,
            false => self.prediction_of(&target, action),
        };
        (prediction, target)
    }

    /// What there is at the place to where `action` is headed.
    fn prediction_of(&self, target: &Place, action: Action) -> Prediction {
        match self.at(target) {
            Some(state) if self.chart.is_turn(action) => Prediction::Turn(state),
            Some(state) => Prediction::Known(state),
            None if self.chart.is_visited(target) => Prediction::OtherHeading,
            None if !self.stochastic && self.chart.is_wall(target) => Prediction::Wall,
            None => Prediction::Fresh,
        }
    }

    /// A lower bound on the steps from the place where `action` leads from `from` to `goal`; 0 while positions
    /// are not trusted, or while an action is without its inverse: it might be the one that leads back along
    /// another's axis.
    pub fn lower_bound(&self, from: StateId, action: Action, goal: StateId) -> u32 {
        let known = self.entry.len();
        let placed = from.index() < known && goal.index() < known;
        if !placed || !self.trusted() || !self.is_paired(action) {
            return 0;
        }
        self.chart
            .lower_bound(&self.chart.target(from, action), goal)
    }

    /// How many points next to that of `place` are taken. O(axes).
    pub fn known_sides(&self, place: &Place) -> u32 {
        self.chart.visited_sides(place)
    }

    /// Whether `action`, and every action that has ever moved, has a known inverse, or turns or goes ahead: then it is known how all of them move.
    fn is_paired(&self, action: Action) -> bool {
        let is_known = |a: usize| {
            self.inverse[a].is_some() || !matches!(self.chart.effects[a], Effect::Shift(_))
        };
        let mut actions = 0..self.num_actions;
        is_known(action.index()) && actions.all(|a| is_known(a) || self.moves_of[a] == 0)
    }

    fn append_position(&mut self, state: StateId) {
        let place = match self.entry[state.index()] {
            Some((from, action)) if self.stochastic => self.likely_target(from, action),
            Some((from, action)) => self.chart.target(from, action),
            None => self.chart.origin(),
        };
        self.chart.append(state, &place);
    }

    /// Tests the new step against its known successors and predecessors.
    fn test_undoing(
        &mut self,
        graph: &TransitionGraph,
        from: StateId,
        action: Action,
        to: StateId,
    ) {
        for b in (0..self.num_actions as u16).map(Action) {
            if let Some(next) = graph.likely_successor(to, b).filter(|next| *next != to) {
                self.count_undo(action, b, next == from);
            }
        }
        for &neighbor in graph.adjacency().neighbors(from.0) {
            for b in (0..self.num_actions as u16).map(Action) {
                if graph.likely_successor(StateId(neighbor), b) == Some(from) {
                    self.count_undo(b, action, StateId(neighbor) == to);
                }
            }
        }
    }

    fn count_undo(&mut self, first: Action, second: Action, undone: bool) {
        let pair = first.index() * self.num_actions + second.index();
        self.tests[pair] += 1;
        self.undone[pair] += u32::from(undone);
        if undone
            && !self.stochastic
            && self.inverse[first.index()].is_none()
            && self.undoes(first, second)
            && self.undoes(second, first)
        {
            self.inverse[first.index()] = Some(second);
            self.inverse[second.index()] = Some(first);
            if !self.chart.has_headings() {
                self.rebuild_axes();
            }
        }
    }

    fn undoes(&self, first: Action, second: Action) -> bool {
        let pair = first.index() * self.num_actions + second.index();
        let tests = self.tests[pair];
        tests >= MIN_UNDO_TESTS && f64::from(self.undone[pair]) >= MIN_AGREEMENT * f64::from(tests)
    }

    /// A chart without headings, where each pair of inverses has one axis; no state has a place yet.
    fn chart_of_pairs(&self) -> Chart {
        let mut directions: Vec<AxisDirection> = Vec::with_capacity(self.num_actions);
        let mut num_axes = 0;
        for a in 0..self.num_actions {
            directions.push(match self.inverse[a] {
                Some(b) if b.index() < a => AxisDirection {
                    axis: directions[b.index()].axis,
                    sign: -1,
                },
                _ => {
                    num_axes += 1;
                    let axis = num_axes - 1;
                    AxisDirection { axis, sign: 1 }
                }
            });
        }
        Chart::new(directions.into_iter().map(Effect::Shift).collect(), 1)
    }

    /// Draws a chart anew, its loops to be confirmed by what follows; happens once a pair, and when actions turn out to slip.
    fn rebuild_axes(&mut self) {
        self.revision += 1;
        self.chart = self.chart_of_pairs();
        for state in 0..self.entry.len() as u32 {
            self.append_position(StateId(state));
        }
        for &(from, action) in &self.bumps {
            self.chart.mark_wall(from, action);
        }
    }
}

#[cfg(test)]
mod tests;
