//! Displacements of actions, learnt from what they did: which action undoes which, and where a path has led.
//!
//! Suppose every action a moves by a fixed displacement δ_a of an abelian group, or not at all (a wall). Then
//! positions follow by dead reckoning, pos(s′) = pos(s) + δ_a, and two facts come for free: where an untried
//! action would lead, and a lower bound Σ|pos(s) − pos(g)| on the steps from s to g. Grid worlds are like that,
//! most other worlds are not, and nobody tells the agent: the hypothesis is built from the transitions seen
//! (pairs of actions that undo one another share an axis with opposite signs) and tested on every loop that
//! closes. While it is not confirmed, or once loops contradict it, nothing is predicted and the bound is 0.
//!
//! Where actions slip, one step tells little; [`relocation`] then takes all steps together, and [`action_noise`] says how an
//! action's outcomes are spread.

pub mod action_noise;
mod moves;
mod placement;
pub mod relocation;

pub use action_noise::ActionNoise;

use crate::env::Action;
use crate::graph::{StateId, TransitionGraph};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::ops::Deref;

/// Tests of "b undoes a" before it is believed.
const MIN_UNDO_TESTS: u32 = 2;
/// Closed loops before positions are believed.
const MIN_LOOPS: u64 = 4;
/// Believed facts hold in at least this share of their tests.
const MIN_AGREEMENT: f64 = 0.95;
/// With more actions than this the table of pairs is not worth its cost.
const MAX_ACTIONS: usize = 16;

/// Expected outcome of an untried action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prediction {
    /// It undoes the step by which the state was entered from this neighbour, or goes a way that is known: as good as
    /// known itself.
    Undo(StateId),
    /// It leads to the position of this state, if nothing stands in between.
    Known(StateId),
    /// It leads to a position where no state is known, if nothing stands in between.
    Fresh,
    /// Nothing is known about it.
    Unknown,
}

/// Axis and sign of an action's displacement.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct AxisDirection {
    axis: usize,
    sign: i32,
}

/// Coordinates of a place, one per axis: no more axes than actions, and no more actions than [`MAX_ACTIONS`].
#[derive(Clone, Copy, Debug)]
struct Position {
    coordinates: [i32; MAX_ACTIONS],
    num_axes: usize,
}

impl Position {
    fn of(row: &[i32]) -> Self {
        let mut coordinates = [0; MAX_ACTIONS];
        coordinates[..row.len()].copy_from_slice(row);
        Self {
            coordinates,
            num_axes: row.len(),
        }
    }

    fn moved(mut self, direction: AxisDirection) -> Self {
        self.coordinates[direction.axis] += direction.sign;
        self
    }
}

impl Deref for Position {
    type Target = [i32];

    fn deref(&self) -> &[i32] {
        &self.coordinates[..self.num_axes]
    }
}

/// The learnt displacements. Memory O(n · axes); an update is O(actions) and allocates only for new states.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct DeadReckoning {
    num_actions: usize,
    /// `tests[a · A + b]`: transitions a then b, both moving, that could show b undoing a; `undone` of them did.
    tests: Vec<u32>,
    undone: Vec<u32>,
    inverse: Vec<Option<Action>>,
    /// Whether the action has ever led to another state.
    moved: Vec<bool>,
    directions: Vec<AxisDirection>,
    num_axes: usize,
    /// How each state was first entered, in order of discovery; `None` for starts.
    entry: Vec<Option<(StateId, Action)>>,
    /// n × axes, row-major.
    positions: Vec<i32>,
    #[serde(with = "occupied")]
    occupied: Occupied,
    loops_confirmed: u64,
    loops_contradicted: u64,
    /// Some action has led to two places.
    stochastic: bool,
    noise: Option<ActionNoise>,
    steps: u64,
    /// When to reckon anew, in steps.
    due: u64,
}

/// Which state lies where.
type Occupied = HashMap<Vec<i32>, StateId, foldhash::fast::FixedState>;

/// [`Occupied`] as a list in the order of the states, so that equal maps are written alike.
mod occupied {
    use super::Occupied;
    use crate::graph::StateId;
    use serde::{Deserialize, Deserializer, Serializer};

    pub(super) fn serialize<S: Serializer>(map: &Occupied, to: S) -> Result<S::Ok, S::Error> {
        let mut places: Vec<_> = map.iter().map(|(place, &state)| (state, place)).collect();
        places.sort_unstable();
        to.collect_seq(places)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Occupied, D::Error> {
        let places = Vec::<(StateId, Vec<i32>)>::deserialize(from)?;
        Ok(places
            .into_iter()
            .map(|(state, place)| (place, state))
            .collect())
    }
}

impl DeadReckoning {
    /// Nothing known yet.
    pub fn new(num_actions: usize) -> Self {
        let directions = (0..num_actions)
            .map(|axis| AxisDirection { axis, sign: 1 })
            .collect();
        Self {
            num_actions,
            tests: vec![0; num_actions * num_actions],
            undone: vec![0; num_actions * num_actions],
            inverse: vec![None; num_actions],
            moved: vec![false; num_actions],
            directions,
            num_axes: num_actions,
            entry: Vec::new(),
            positions: Vec::new(),
            occupied: HashMap::default(),
            loops_confirmed: 0,
            loops_contradicted: 0,
            stochastic: false,
            noise: None,
            steps: 0,
            due: 0,
        }
    }

    /// Whether positions have been confirmed by closed loops.
    pub fn trusted(&self) -> bool {
        let tests = self.loops_confirmed + self.loops_contradicted;
        tests >= MIN_LOOPS && self.loops_confirmed as f64 >= MIN_AGREEMENT * tests as f64
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

    /// Learns from the first time that `action` in `from` led to `to`. Call after the graph has recorded it.
    pub fn learn(&mut self, graph: &TransitionGraph, from: StateId, action: Action, to: StateId) {
        if self.num_actions > MAX_ACTIONS {
            return;
        }
        if to.index() == self.entry.len() {
            self.entry.push(Some((from, action)));
            self.append_position(to);
        } else if to != from && !self.stochastic {
            self.close_loop(from, action, to);
        }
        if !self.stochastic && graph.tries(from, action) > 1 {
            self.expect_slips();
        }
        if to != from {
            self.moved[action.index()] = true;
            self.test_undoing(graph, from, action, to);
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
        if !self.trusted() || from.index() >= self.entry.len() {
            return Prediction::Unknown;
        }
        match self.occupied.get(&*self.target(from, action)) {
            Some(&state) => Prediction::Known(state),
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
        let target = self.target(from, action);
        let goal = self.position(goal);
        target.iter().zip(goal).map(|(a, b)| a.abs_diff(*b)).sum()
    }

    /// How many positions next to the place where `action` leads from `from` are taken; 0 while positions are not
    /// trusted. O(axes).
    pub fn known_sides(&self, from: StateId, action: Action) -> u32 {
        if !self.trusted() || from.index() >= self.entry.len() {
            return 0;
        }
        let target = self.target(from, action);
        let mut sides = 0;
        for axis in 0..self.num_axes {
            for sign in [1, -1] {
                let side = target.moved(AxisDirection { axis, sign });
                sides += u32::from(self.occupied.contains_key(&*side));
            }
        }
        sides
    }

    /// Whether `action`, and every action that has ever moved, has a known inverse.
    fn is_paired(&self, action: Action) -> bool {
        let mut actions = self.inverse.iter().zip(&self.moved);
        self.inverse[action.index()].is_some()
            && actions.all(|(inverse, &moved)| inverse.is_some() || !moved)
    }

    fn position(&self, state: StateId) -> &[i32] {
        &self.positions[state.index() * self.num_axes..][..self.num_axes]
    }

    /// Where `action` leads from `from`, if nothing stands in between.
    fn target(&self, from: StateId, action: Action) -> Position {
        Position::of(self.position(from)).moved(self.directions[action.index()])
    }

    fn append_position(&mut self, state: StateId) {
        let place = match self.entry[state.index()] {
            Some((from, action)) if self.stochastic => self.likely_target(from, action),
            Some((from, action)) => self.target(from, action),
            None => Position::of(&[0; MAX_ACTIONS][..self.num_axes]),
        };
        self.positions.extend_from_slice(&place);
        self.occupied.entry(place.to_vec()).or_insert(state);
    }

    fn close_loop(&mut self, from: StateId, action: Action, to: StateId) {
        if *self.position(to) == *self.target(from, action) {
            self.loops_confirmed += 1;
        } else {
            self.loops_contradicted += 1;
        }
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
            self.rebuild_axes();
        }
    }

    fn undoes(&self, first: Action, second: Action) -> bool {
        let pair = first.index() * self.num_actions + second.index();
        let tests = self.tests[pair];
        tests >= MIN_UNDO_TESTS && f64::from(self.undone[pair]) >= MIN_AGREEMENT * f64::from(tests)
    }

    /// Gives each pair of inverses one axis.
    fn assign_axes(&mut self) {
        self.num_axes = 0;
        for a in 0..self.num_actions {
            self.directions[a] = match self.inverse[a] {
                Some(b) if b.index() < a => AxisDirection {
                    axis: self.directions[b.index()].axis,
                    sign: -1,
                },
                _ => {
                    self.num_axes += 1;
                    AxisDirection {
                        axis: self.num_axes - 1,
                        sign: 1,
                    }
                }
            };
        }
    }

    /// Reckons all positions anew; happens once a pair.
    fn rebuild_axes(&mut self) {
        self.assign_axes();
        self.positions.clear();
        self.occupied.clear();
        self.loops_confirmed = 0;
        self.loops_contradicted = 0;
        for state in 0..self.entry.len() as u32 {
            self.append_position(StateId(state));
        }
    }
}

#[cfg(test)]
mod tests;
