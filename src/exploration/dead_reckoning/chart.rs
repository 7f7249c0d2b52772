//! A chart: what each action does to a place, and where each state lies if that is so.
//!
//! A place is a point of an integer lattice with, in worlds where actions turn, one of k headings. Its symmetries are
//!
//! ```text
//! shift:    x ← x ± e_i          turn:    h ← h + j (mod k)          advance:    x ← x + u_{h + r}
//! ```
//!
//! where u_0, u_1, …, u_{k−1} are the steps ahead by heading: k = 4 is the square lattice, k = 3 and 6 are the triangular ones, k = 2 a line. No
//! other k turns a lattice onto itself. Without headings, k = 1, every action is a shift.

use super::MAX_ACTIONS;
use crate::env::Action;
use crate::graph::{StateId, TransitionGraph};
use serde::{Deserialize, Serialize};
use std::collections::{HashMap, HashSet};
use std::ops::Deref;

/// Closed loops before positions are believed.
const MIN_LOOPS: u64 = 4;
/// Believed facts hold in at least this share of their tests.
pub(super) const MIN_AGREEMENT: f64 = 0.95;

/// Axis and sign of a shift.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct AxisDirection {
    pub axis: usize,
    pub sign: i32,
}

/// What an action does to a place, if nothing stands in between.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Effect {
    Shift(AxisDirection),
    /// By so many k-ths of a turn.
    Turn(usize),
    /// Ahead, or so many k-ths of a turn to the side of that.
    Advance(usize),
}

/// u_h by k and h.
const AHEAD: [&[(i32, i32)]; 7] = [
    &[],
    &[],
    &[(1, 0), (-1, 0)],
    &[(1, 0), (0, 1), (-1, -1)],
    &[(1, 0), (0, 1), (-1, 0), (0, -1)],
    &[],
    &[(1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)],
];
/// Coordinates in which [`AHEAD`] goes.
const PLANE: usize = 2;

/// Whether a lattice has this number of headings.
pub(super) fn is_lattice(headings: usize) -> bool {
    AHEAD.get(headings).is_some_and(|ahead| !ahead.is_empty())
}

/// Coordinates of a place, and its heading behind them where there are headings.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    coordinates: [i32; MAX_ACTIONS + PLANE + 1],
    width: usize,
}

impl Place {
    pub fn of(row: &[i32]) -> Self {
        let mut coordinates = [0; MAX_ACTIONS + PLANE + 1];
        coordinates[..row.len()].copy_from_slice(row);
        Self {
            coordinates,
            width: row.len(),
        }
    }

    fn shifted(mut self, direction: AxisDirection) -> Self {
        self.coordinates[direction.axis] += direction.sign;
        self
    }
}

impl Deref for Place {
    type Target = [i32];

    fn deref(&self) -> &[i32] {
        &self.coordinates[..self.width]
    }
}

/// Which state lies where.
pub(super) type Occupied = HashMap<Vec<i32>, StateId, foldhash::fast::FixedState>;
/// Points, without headings.
type Points = HashSet<Vec<i32>, foldhash::fast::FixedState>;

/// Effects of all actions, and the places of all states. Memory O(n · axes).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Chart {
    pub effects: Vec<Effect>,
    /// k; 1 without headings.
    headings: usize,
    /// Of points.
    num_axes: usize,
    /// n × width, row-major.
    pub positions: Vec<i32>,
    #[serde(with = "occupied")]
    pub occupied: Occupied,
    /// Points where some state lies, whatever its heading; empty without headings.
    #[serde(with = "points")]
    visited: Points,
    /// Points that steps have bumped into.
    #[serde(with = "points")]
    walls: Points,
    pub loops_confirmed: u64,
    pub loops_contradicted: u64,
}

impl Chart {
    /// No state has a place yet.
    ///
    /// # Panics
    /// If actions turn and no lattice has so many headings.
    pub fn new(effects: Vec<Effect>, headings: usize) -> Self {
        assert!(headings == 1 || is_lattice(headings));
        let of_shift = |effect: &Effect| match effect {
            Effect::Shift(direction) => direction.axis + 1,
            _ => PLANE,
        };
        Self {
            headings,
            num_axes: effects.iter().map(of_shift).max().unwrap_or(0),
            effects,
            positions: Vec::new(),
            occupied: Occupied::default(),
            visited: Points::default(),
            walls: Points::default(),
            loops_confirmed: 0,
            loops_contradicted: 0,
        }
    }

    /// Whether actions turn.
    pub fn has_headings(&self) -> bool {
        self.headings > 1
    }

    pub fn num_axes(&self) -> usize {
        self.num_axes
    }

    fn width(&self) -> usize {
        self.num_axes + usize::from(self.has_headings())
    }

    /// Number of states that have places.
    pub fn len(&self) -> usize {
        self.positions.len() / self.width().max(1)
    }

    /// Whether places have been confirmed by closed loops.
    pub fn trusted(&self) -> bool {
        let tests = self.loops_confirmed + self.loops_contradicted;
        tests >= MIN_LOOPS && self.loops_confirmed as f64 >= MIN_AGREEMENT * tests as f64
    }

    pub fn distrust(&mut self) {
        self.loops_confirmed = 0;
        self.loops_contradicted = 0;
    }

    pub fn position(&self, state: StateId) -> &[i32] {
        &self.positions[state.index() * self.width()..][..self.width()]
    }

    /// Coordinates of a place without its heading.
    pub fn point<'a>(&self, place: &'a [i32]) -> &'a [i32] {
        &place[..self.num_axes]
    }

    /// Where all begins.
    pub fn origin(&self) -> Place {
        Place::of(&[0; MAX_ACTIONS + PLANE + 1][..self.width()])
    }

    /// Where `action` leads from `from`, if nothing stands in between.
    pub fn target(&self, from: StateId, action: Action) -> Place {
        self.moved(Place::of(self.position(from)), action)
    }

    /// The same from a place where no state need be.
    pub fn moved(&self, mut place: Place, action: Action) -> Place {
        match self.effects[action.index()] {
            Effect::Shift(direction) => place.shifted(direction),
            Effect::Turn(by) => {
                let heading = &mut place.coordinates[self.num_axes];
                *heading = (*heading + by as i32) % self.headings as i32;
                place
            }
            Effect::Advance(side) => {
                let heading = place.coordinates[self.num_axes] as usize + side;
                let (x, y) = AHEAD[self.headings][heading % self.headings];
                place.coordinates[0] += x;
                place.coordinates[1] += y;
                place
            }
        }
    }

    /// Whether `action` turns.
    pub fn is_turn(&self, action: Action) -> bool {
        matches!(self.effects[action.index()], Effect::Turn(_))
    }

    /// The states from which a turn leads to `state`, and which; none if it has no place.
    pub fn turned_from(&self, state: StateId) -> impl Iterator<Item = (StateId, Action)> + '_ {
        let known = state.index() < self.len();
        let actions = (0..self.effects.len() as u16).map(Action);
        actions.filter_map(move |action| {
            let Effect::Turn(by) = self.effects[action.index()] else {
                return None;
            };
            let mut place = Place::of(known.then(|| self.position(state))?);
            let heading = &mut place.coordinates[self.num_axes];
            *heading = (*heading + (self.headings - by) as i32) % self.headings as i32;
            Some((*self.occupied.get(&*place)?, action))
        })
    }

    /// Gives the next state its place.
    pub fn append(&mut self, state: StateId, place: &[i32]) {
        self.positions.extend_from_slice(place);
        self.occupied.entry(place.to_vec()).or_insert(state);
        if self.has_headings() {
            self.visited.insert(self.point(place).to_vec());
        }
    }

    /// Takes note of a step that led nowhere. A turn that fails tells nothing of the point beyond.
    pub fn mark_wall(&mut self, from: StateId, action: Action) {
        if !self.is_turn(action) {
            let place = self.target(from, action);
            self.walls.insert(self.point(&place).to_vec());
        }
    }

    /// The states at the point of `place`, with any heading.
    pub fn states_at(&self, mut place: Place) -> impl Iterator<Item = StateId> + '_ {
        (0..self.headings as i32).filter_map(move |heading| {
            if self.has_headings() {
                place.coordinates[self.num_axes] = heading;
            }
            self.occupied.get(&*place).copied()
        })
    }

    /// Whether a step has bumped into the point of `place`.
    pub fn is_wall(&self, place: &Place) -> bool {
        self.walls.contains(self.point(place))
    }

    /// Whether some state lies at the point of `place`, whatever its heading.
    pub fn is_visited(&self, place: &Place) -> bool {
        match self.has_headings() {
            true => self.visited.contains(self.point(place)),
            false => self.occupied.contains_key(&**place),
        }
    }

    /// Points where some state lies, of a chart with headings.
    pub fn num_points(&self) -> usize {
        self.visited.len()
    }

    /// Compares a step with the places of its ends.
    pub fn close_loop(&mut self, from: StateId, action: Action, to: StateId) {
        if *self.position(to) == *self.target(from, action) {
            self.loops_confirmed += 1;
        } else {
            self.loops_contradicted += 1;
        }
    }

    /// Counts all loops of what was seen anew; `entry` has the step by which each state was found. How many loops hold that no turn closes. O(transitions).
    pub fn close_loops(
        &mut self,
        graph: &TransitionGraph,
        entry: &[Option<(StateId, Action)>],
    ) -> u64 {
        let mut by_steps = 0;
        self.distrust();
        for from in (0..self.len() as u32).map(StateId) {
            for seen in graph.outcomes(from) {
                let is_entry = entry.get(seen.next.index()) == Some(&Some((from, seen.action)));
                if seen.next != from && !is_entry && seen.next.index() < self.len() {
                    let before = self.loops_confirmed;
                    self.close_loop(from, seen.action, seen.next);
                    if !self.is_turn(seen.action) {
                        by_steps += self.loops_confirmed - before;
                    }
                }
            }
        }
        by_steps
    }

    /// How many points next to that of `place` are taken. O(axes).
    pub fn visited_sides(&self, place: &Place) -> u32 {
        let plane = if self.has_headings() { PLANE } else { 0 };
        let ahead = AHEAD[self.headings].iter().map(|&(x, y)| {
            let mut side = *place;
            side.coordinates[0] += x;
            side.coordinates[1] += y;
            side
        });
        let shifts = (plane..self.num_axes)
            .flat_map(|axis| [1, -1].map(|sign| place.shifted(AxisDirection { axis, sign })));
        let sides = ahead.chain(shifts);
        sides.filter(|side| self.is_visited(side)).count() as u32
    }

    /// A lower bound on the steps from `place` to the point where `goal` lies, if every shift can be undone.
    pub fn lower_bound(&self, place: &Place, goal: StateId) -> u32 {
        let goal = self.position(goal);
        let away = |axis: usize| goal[axis] - place[axis];
        let plane = if self.has_headings() { PLANE } else { 0 };
        let shifts: u32 = (plane..self.num_axes)
            .map(|axis| away(axis).unsigned_abs())
            .sum();
        match self.has_headings() {
            false => shifts,
            true => {
                let (x, y) = (away(0), away(1));
                shifts + self.moves_across(x, y) + self.turns_across(x, y, place[self.num_axes])
            }
        }
    }

    /// Steps ahead that make up (x, y), whatever the heading.
    fn moves_across(&self, x: i32, y: i32) -> u32 {
        let steps = match self.headings {
            6 => x.abs().max(y.abs()).max((x + y).abs()),
            3 => x + y + 3 * 0.max(-x).max(-y),
            _ => x.abs() + y.abs(),
        };
        steps as u32
    }

    /// Turns that are needed to go by (x, y), where all steps are ahead and turns by a quarter.
    fn turns_across(&self, x: i32, y: i32, heading: i32) -> u32 {
        let is_plain = |effect: &Effect| match effect {
            Effect::Shift(_) => true,
            Effect::Turn(by) => *by == 1 || *by + 1 == self.headings,
            Effect::Advance(side) => *side == 0,
        };
        if self.headings != 4 || !self.effects.iter().all(is_plain) {
            return 0;
        }
        let along_x = if x > 0 { 0 } else { 2 };
        let along_y = if y > 0 { 1 } else { 3 };
        let quarter_turns = |to: i32| [0, 1, 2, 1][(to - heading).rem_euclid(4) as usize];
        match (x != 0, y != 0) {
            (false, false) => 0,
            (true, false) => quarter_turns(along_x),
            (false, true) => quarter_turns(along_y),
            (true, true) => 1 + quarter_turns(along_x).min(quarter_turns(along_y)),
        }
    }
}

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

/// [`Points`] in order.
mod points {
    use super::Points;
    use serde::{Deserialize, Deserializer, Serializer};

    pub(super) fn serialize<S: Serializer>(points: &Points, to: S) -> Result<S::Ok, S::Error> {
        let mut points: Vec<_> = points.iter().collect();
        points.sort_unstable();
        to.collect_seq(points)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Points, D::Error> {
        Ok(Vec::<Vec<i32>>::deserialize(from)?.into_iter().collect())
    }
}
