//! What actions do, learnt from what they did: which action undoes which, and where a path has led.
//!
//! Suppose every action a moves by a fixed displacement δ_a of an abelian group, or not at all (a wall). Then
//! positions follow by dead reckoning, pos(s′) = pos(s) + δ_a, and two facts come for free: where an untried
//! action would lead, and a lower bound Σ|pos(s) − pos(g)| on the steps from s to g. Grid worlds are like that,
//! most other worlds are not, and nobody tells the agent: the hypothesis is built from the transitions seen
//! (pairs of actions that undo one another share an axis with opposite signs) and tested on every loop that
//! closes. While it is not confirmed, or once loops contradict it, nothing is predicted and the bound is 0.

use crate::env::Action;
use crate::graph::{StateId, TransitionGraph};
use std::collections::HashMap;

/// Tests of "b undoes a" before it is believed.
const MIN_UNDO_TESTS: u32 = 2;
/// Closed loops before positions are believed.
const MIN_LOOPS: u64 = 4;
/// Believed facts hold in at least this share of their tests.
const MIN_AGREEMENT: f64 = 0.95;
/// With more actions than this the table of pairs is not worth its cost.
const MAX_ACTIONS: usize = 16;

/// What an untried action is expected to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prediction {
    /// It undoes the step by which the state was entered from this neighbour: as good as known.
    Undo(StateId),
    /// It leads to the position of this state, if nothing stands in between.
    Known(StateId),
    /// It leads to a position where no state is known, if nothing stands in between.
    Fresh,
    /// Nothing is known about it.
    Unknown,
}

/// Axis and sign of an action's displacement.
#[derive(Clone, Copy, Debug)]
struct Direction {
    axis: usize,
    sign: i32,
}

/// The learnt displacements. Memory O(n · axes); an update is O(actions) and allocates only for new states.
#[derive(Clone, Debug)]
pub struct Displacements {
    num_actions: usize,
    /// `tests[a · A + b]`: transitions a then b, both moving, that could show b undoing a; `undone` of them did.
    tests: Vec<u32>,
    undone: Vec<u32>,
    inverse: Vec<Option<Action>>,
    /// Whether the action has ever led to another state.
    moved: Vec<bool>,
    directions: Vec<Direction>,
    num_axes: usize,
    /// How each state was first entered, in order of discovery; `None` for starts.
    entry: Vec<Option<(StateId, Action)>>,
    /// n × axes, row-major.
    positions: Vec<i32>,
    occupied: HashMap<Vec<i32>, StateId, foldhash::fast::FixedState>,
    loops_confirmed: u64,
    loops_contradicted: u64,
    scratch: Vec<i32>,
}

impl Displacements {
    /// Nothing known yet.
    pub fn new(num_actions: usize) -> Self {
        let directions = (0..num_actions)
            .map(|axis| Direction { axis, sign: 1 })
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
            scratch: Vec::new(),
        }
    }

    /// Whether positions have been confirmed by closed loops.
    pub fn trusted(&self) -> bool {
        let tests = self.loops_confirmed + self.loops_contradicted;
        tests >= MIN_LOOPS && self.loops_confirmed as f64 >= MIN_AGREEMENT * tests as f64
    }

    /// The action that undoes `action`, once believed.
    pub fn inverse(&self, action: Action) -> Option<Action> {
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
        } else if to != from {
            self.close_loop(from, action, to);
        }
        if to != from {
            self.moved[action.index()] = true;
            self.test_undoing(graph, from, action, to);
        }
    }

    /// What the untried `action` in `from` is expected to do. O(degree).
    pub fn predict(
        &mut self,
        graph: &TransitionGraph,
        from: StateId,
        action: Action,
    ) -> Prediction {
        if let Some(back) = self.inverse[action.index()] {
            for &neighbor in graph.adjacency().neighbors(from.0) {
                if graph.likely_successor(StateId(neighbor), back) == Some(from) {
                    return Prediction::Undo(StateId(neighbor));
                }
            }
        }
        if !self.trusted() || from.index() >= self.entry.len() {
            return Prediction::Unknown;
        }
        self.load_target(from, action);
        match self.occupied.get(self.scratch.as_slice()) {
            Some(&state) => Prediction::Known(state),
            None => Prediction::Fresh,
        }
    }

    /// A lower bound on the steps from the place where `action` leads from `from` to `goal`; 0 while positions
    /// are not trusted, or while an action is without its inverse: it might be the one that leads back along
    /// another's axis.
    pub fn lower_bound(&mut self, from: StateId, action: Action, goal: StateId) -> u32 {
        let known = self.entry.len();
        let placed = from.index() < known && goal.index() < known;
        if !placed || !self.trusted() || !self.is_paired(action) {
            return 0;
        }
        self.load_target(from, action);
        let goal = &self.positions[goal.index() * self.num_axes..][..self.num_axes];
        self.scratch
            .iter()
            .zip(goal)
            .map(|(a, b)| a.abs_diff(*b))
            .sum()
    }

    /// Whether `action`, and every action that has ever moved, has a known inverse.
    fn is_paired(&self, action: Action) -> bool {
        let mut actions = self.inverse.iter().zip(&self.moved);
        self.inverse[action.index()].is_some()
            && actions.all(|(inverse, &moved)| inverse.is_some() || !moved)
    }

    /// Puts the position to which `action` leads from `from` into `scratch`.
    fn load_target(&mut self, from: StateId, action: Action) {
        let row = &self.positions[from.index() * self.num_axes..][..self.num_axes];
        self.scratch.clear();
        self.scratch.extend_from_slice(row);
        let direction = self.directions[action.index()];
        self.scratch[direction.axis] += direction.sign;
    }

    fn append_position(&mut self, state: StateId) {
        match self.entry[state.index()] {
            Some((from, action)) => self.load_target(from, action),
            None => {
                self.scratch.clear();
                self.scratch.resize(self.num_axes, 0);
            }
        }
        self.positions.extend_from_slice(&self.scratch);
        self.occupied.entry(self.scratch.clone()).or_insert(state);
    }

    fn close_loop(&mut self, from: StateId, action: Action, to: StateId) {
        self.load_target(from, action);
        let agrees = self.positions[to.index() * self.num_axes..][..self.num_axes] == self.scratch;
        if agrees {
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

    /// Gives each pair of inverses one axis and reckons all positions anew; happens once a pair.
    fn rebuild_axes(&mut self) {
        self.num_axes = 0;
        for a in 0..self.num_actions {
            self.directions[a] = match self.inverse[a] {
                Some(b) if b.index() < a => Direction {
                    axis: self.directions[b.index()].axis,
                    sign: -1,
                },
                _ => {
                    self.num_axes += 1;
                    Direction {
                        axis: self.num_axes - 1,
                        sign: 1,
                    }
                }
            };
        }
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
mod tests {
    use super::*;
    use crate::exploration::fixtures::{World, walled_grids};
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A random walk of so many steps from state `start`, learning on the way. State numbers are those of discovery;
    /// `names[i]` is the world's name of state i.
    struct Walk {
        graph: TransitionGraph,
        learnt: Displacements,
        names: Vec<usize>,
    }

    impl Walk {
        fn begin(world: &World, start: usize) -> Self {
            let mut graph = TransitionGraph::new(world.num_actions());
            let mut learnt = Displacements::new(world.num_actions());
            learnt.add_start(graph.add_state());
            Self {
                graph,
                learnt,
                names: vec![start],
            }
        }

        fn id(&self, name: usize) -> Option<StateId> {
            let place = self.names.iter().position(|&known| known == name);
            place.map(|i| StateId(i as u32))
        }

        fn step(&mut self, world: &World, from: usize, action: Action) -> usize {
            let to = world.moves[from][action.index()];
            let from = self.id(from).expect("the walk has been there");
            let target = self.id(to).unwrap_or_else(|| {
                self.names.push(to);
                self.graph.add_state()
            });
            let first_time = self.graph.tries(from, action) == 0;
            self.graph.record(from, action, -1.0, target, false);
            if first_time {
                self.learnt.learn(&self.graph, from, action, target);
            }
            to
        }

        fn wander(world: &World, start: usize, steps: usize, seed: u64) -> Self {
            let mut walk = Self::begin(world, start);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut here = start;
            for _ in 0..steps {
                let action = Action(rng.random_range(0..world.num_actions() as u16));
                here = walk.step(world, here, action);
            }
            walk
        }
    }

    #[test]
    fn on_an_open_grid_inverses_and_positions_are_learnt() {
        let world = World::grid(7, 7, |_, _| false);
        let mut walk = Walk::wander(&world, 24, 2000, 0);
        assert!(walk.learnt.trusted());
        for (action, undoing) in [(0, 2), (1, 3), (2, 0), (3, 1)] {
            assert_eq!(walk.learnt.inverse(Action(action)), Some(Action(undoing)));
        }
        let goal = walk.id(0).expect("2000 steps go everywhere");
        for cell in 0..49 {
            let from = walk.id(cell).expect("2000 steps go everywhere");
            for action in 0..4 {
                // At the edge the bound is that of the cell beyond it.
                let (row, col) = (cell as i32 / 7, cell as i32 % 7);
                let (down, right) = [(-1, 0), (0, 1), (1, 0), (0, -1)][action];
                let expected = (row + down).unsigned_abs() + (col + right).unsigned_abs();
                let bound = walk.learnt.lower_bound(from, Action(action as u16), goal);
                assert_eq!(bound, expected, "cell {cell} action {action}");
            }
        }
    }

    #[test]
    fn predictions_tell_undoing_known_and_fresh_places_apart() {
        let world = World::grid(3, 3, |_, _| false);
        let [up, right, down, left] = [0, 1, 2, 3].map(Action);
        let mut walk = Walk::begin(&world, 0);
        assert_eq!(
            walk.learnt.predict(&walk.graph, StateId(0), up),
            Prediction::Unknown
        );
        // To and fro until both pairs are believed: over the top row and the left column and back.
        let mut here = 0;
        for action in [right, right, left, left, down, down, up, up] {
            here = walk.step(&world, here, action);
        }
        assert_eq!(walk.learnt.inverse(right), Some(left));
        assert_eq!(walk.learnt.inverse(up), Some(down));
        // Loops were counted anew since the second pair was learnt; a few more confirm.
        let more = [
            right, down, left, right, left, down, right, left, up, right, right, left, right, up,
        ];
        for action in more {
            here = walk.step(&world, here, action);
        }
        assert_eq!(here, 2);
        assert!(walk.learnt.trusted());
        let top_right = walk.id(2).expect("visited");
        assert_eq!(
            walk.learnt.predict(&walk.graph, top_right, down),
            Prediction::Undo(walk.id(5).unwrap())
        );
        assert_eq!(
            walk.learnt.predict(&walk.graph, top_right, right),
            Prediction::Fresh
        );
        let [centre, bottom] = [4, 7].map(|cell| walk.id(cell).expect("visited"));
        assert_eq!(
            walk.learnt.predict(&walk.graph, bottom, up),
            Prediction::Known(centre)
        );
    }

    #[test]
    fn where_moves_do_not_commute_nothing_is_trusted() {
        for seed in 0..10 {
            let walk = Walk::wander(&World::turtle(4), 0, 1500, seed);
            assert!(!walk.learnt.trusted(), "turtle, seed {seed}");
            // Positions wrap: going round a torus of 4 × 4 contradicts 8 of its 32 + 32 steps.
            let walk = Walk::wander(&World::torus(4, 4), 0, 1500, seed);
            assert!(!walk.learnt.trusted(), "torus, seed {seed}");
        }
    }

    #[test]
    fn without_trust_there_is_no_bound_and_no_prediction_of_places() {
        let mut walk = Walk::wander(&World::torus(4, 4), 0, 1500, 0);
        for state in 0..16 {
            assert_eq!(
                walk.learnt
                    .lower_bound(StateId(state), Action(1), StateId(0)),
                0
            );
            let prediction = walk.learnt.predict(&walk.graph, StateId(state), Action(1));
            assert!(
                matches!(prediction, Prediction::Unknown | Prediction::Undo(_)),
                "{prediction:?}"
            );
        }
    }

    #[test]
    fn with_very_many_actions_nothing_is_learnt() {
        let moves = (0..20).map(|s: usize| (0..20).map(|a| (s + a) % 20).collect());
        let world = World {
            moves: moves.collect(),
        };
        let mut walk = Walk::wander(&world, 0, 500, 1);
        assert!(!walk.learnt.trusted());
        assert_eq!(walk.learnt.inverse(Action(1)), None);
        assert_eq!(
            walk.learnt.predict(&walk.graph, StateId(3), Action(2)),
            Prediction::Unknown
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        /// Walls and one-way passages only make ways longer: on grids the bound never exceeds the truth.
        #[test]
        fn the_bound_never_exceeds_the_distance(
            world in walled_grids(),
            seed in any::<u64>(),
            steps in 10usize..400,
        ) {
            let mut walk = Walk::wander(&world, 0, steps, seed);
            if walk.learnt.trusted() {
                for from in 0..walk.names.len() {
                    for action in 0..4 {
                        let next = world.moves[walk.names[from]][action];
                        if next == walk.names[from] {
                            continue; // a bump leads nowhere
                        }
                        let hops = world.hops_from(next);
                        for goal in 0..walk.names.len() {
                            let bound = walk.learnt.lower_bound(
                                StateId(from as u32),
                                Action(action as u16),
                                StateId(goal as u32),
                            );
                            let truth = hops[walk.names[goal]].unwrap_or(u32::MAX);
                            prop_assert!(bound <= truth, "{} > {} hops", bound, truth);
                        }
                    }
                }
            }
        }
    }
}
