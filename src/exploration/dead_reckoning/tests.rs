use super::*;
use crate::exploration::fixtures::{World, walled_grids};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A random walk of so many steps from state `start`, learning on the way. State numbers are those of discovery;
/// `names[i]` is the world's name of state i.
struct Walk {
    graph: TransitionGraph,
    learnt: DeadReckoning,
    names: Vec<usize>,
}

impl Walk {
    fn begin(world: &World, start: usize) -> Self {
        let mut graph = TransitionGraph::new(world.num_actions());
        let mut learnt = DeadReckoning::new(world.num_actions(), true);
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
        self.arrive(from, action, to);
        to
    }

    fn arrive(&mut self, from: usize, action: Action, to: usize) {
        let from = self.id(from).expect("the walk has been there");
        let known = self.id(to);
        let target = known.unwrap_or_else(|| {
            self.names.push(to);
            self.graph.add_state()
        });
        let before = self.graph.num_transitions();
        let untried = self.graph.tries(from, action) == 0;
        let new_edge = self.graph.record(from, action, -1.0, target, false);
        if untried || new_edge || known.is_none() {
            self.learnt.learn(&self.graph, from, action, target);
        } else if self.graph.num_transitions() > before {
            self.learnt.notice_slip();
        }
        self.learnt.count_step(&self.graph);
    }

    /// The same where three moves in ten slip.
    fn slither(world: &World, start: usize, steps: usize, seed: u64) -> Self {
        let mut walk = Self::begin(world, start);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut here = start;
        for _ in 0..steps {
            let action = rng.random_range(0..world.num_actions());
            let to = world.slipped(here, action, rng.random());
            walk.arrive(here, Action(action as u16), to);
            here = to;
        }
        walk
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
    let walk = Walk::wander(&world, 24, 2000, 0);
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
        // Positions wrap: going round a torus of 4 × 4 contradicts 8 of its 32 + 32 steps.
        let walk = Walk::wander(&World::torus(4, 4), 0, 1500, seed);
        assert!(!walk.learnt.trusted(), "torus, seed {seed}");
    }
}

/// What is predicted of each action in each state of a walk that has been everywhere is what it does.
fn assert_predictions(walk: &Walk, world: &World) {
    for name in 0..world.num_states() {
        let Some(state) = walk.id(name) else { continue };
        for action in 0..world.num_actions() {
            let truth = walk.id(world.moves[name][action]);
            let action = Action(action as u16);
            match walk.learnt.predict(&walk.graph, state, action) {
                Prediction::Turn(next) | Prediction::Undo(next) => {
                    assert_eq!(truth, Some(next), "{name} {action:?}");
                }
                Prediction::Known(next) => {
                    let is_bump = truth == Some(state);
                    assert!(is_bump || truth == Some(next), "{name} {action:?}");
                }
                Prediction::Idle | Prediction::Unknown => panic!("{name} {action:?}"),
                Prediction::Wall | Prediction::Fresh | Prediction::OtherHeading => {
                    assert!(truth.is_none() || truth == Some(state), "{name} {action:?}");
                }
            }
        }
    }
}

#[test]
fn turns_are_learnt_on_square_and_triangular_lattices() {
    let worlds = [World::turtle(6), World::honeycomb(5, 6).turning()];
    for (world, seed) in worlds
        .iter()
        .flat_map(|world| (0..5).map(move |seed| (world, seed)))
    {
        for steps in [1000, 4000] {
            let walk = Walk::wander(world, 0, steps, seed);
            assert!(walk.learnt.turns(), "seed {seed}, {steps} steps");
            assert_predictions(&walk, world);
        }
    }
}

#[test]
fn steps_to_the_side_and_turns_by_a_half_are_learnt_too() {
    let open = World::grid(6, 6, |_, _| false);
    let (sideways, back) = (open.clone(), open.clone());
    let world = open
        .turning()
        .with_action(move |state| sideways.moves[state / 4][(state + 1) % 4] * 4 + state % 4)
        .with_action(move |state| back.moves[state / 4][(state + 2) % 4] * 4 + state % 4)
        .with_action(|state| state / 4 * 4 + (state + 2) % 4);
    for seed in 0..5 {
        let walk = Walk::wander(&world, 0, 4000, seed);
        assert!(walk.learnt.turns(), "seed {seed}");
        assert_predictions(&walk, &world);
    }
}

#[test]
fn an_action_that_never_moves_is_idle_and_no_turn() {
    let world = World::turtle(5).with_action(|state| state);
    let walk = Walk::wander(&world, 0, 3000, 0);
    assert!(walk.learnt.turns());
    let idle = walk.learnt.predict(&walk.graph, StateId(3), Action(3));
    assert_eq!(idle, Prediction::Idle);
}

#[test]
fn a_walker_who_is_not_thorough_learns_no_headings() {
    let world = World::turtle(5);
    assert!(Walk::wander(&world, 0, 3000, 0).learnt.turns());
    let mut walk = Walk::begin(&world, 0);
    walk.learnt = DeadReckoning::new(3, false);
    walk.learnt.add_start(StateId(0));
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut here = 0;
    for _ in 0..3000 {
        here = walk.step(&world, here, Action(rng.random_range(0..3)));
    }
    assert!(!walk.learnt.turns() && !walk.learnt.trusted());
}

#[test]
fn a_chart_with_headings_is_given_up_when_turns_fail() {
    let world = World::turtle(5);
    let mut walk = Walk::wander(&world, 0, 2000, 1);
    assert!(walk.learnt.turns());
    let at = walk.id(0).expect("it began there");
    let elsewhere = walk.names[50];
    assert_ne!(elsewhere, world.moves[0][1]);
    walk.arrive(0, Action(1), elsewhere); // left led somewhere else for once
    assert!(!walk.learnt.turns() && !walk.learnt.trusted());
    let prediction = walk.learnt.predict(&walk.graph, at, Action(1));
    assert!(matches!(prediction, Prediction::Unknown | Prediction::Idle));
}

#[test]
fn without_trust_there_is_no_bound_and_no_prediction_of_places() {
    let walk = Walk::wander(&World::torus(4, 4), 0, 1500, 0);
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
    let walk = Walk::wander(&world, 0, 500, 1);
    assert!(!walk.learnt.trusted());
    assert_eq!(walk.learnt.inverse(Action(1)), None);
    assert_eq!(
        walk.learnt.predict(&walk.graph, StateId(3), Action(2)),
        Prediction::Unknown
    );
}

#[test]
fn on_ice_inverses_positions_and_slips_are_learnt_all_the_same() {
    let world = World::grid(7, 7, |_, _| false);
    for seed in 0..5 {
        let walk = Walk::slither(&world, 24, 4000, seed);
        let noise = walk.learnt.noise().expect("actions do the same everywhere");
        for action in 0..4 {
            let share = |turn| noise.share(Action(action), Action((action + turn) % 4));
            for (turn, expected) in [(0, 0.7), (1, 0.15), (2, 0.0), (3, 0.15)] {
                let error: f64 = share(turn) - expected;
                assert!(error.abs() < 0.08, "seed {seed}: {action} {turn} {error}");
            }
        }
        let goal = walk.id(0).expect("4000 steps go everywhere");
        for (cell, action) in (0..49).flat_map(|cell| (0..4).map(move |action| (cell, action))) {
            let from = walk.id(cell).expect("4000 steps go everywhere");
            let next = world.moves[cell][action];
            let action = Action(action as u16);
            let towards = walk.learnt.neighbor_towards(&walk.graph, from, action);
            assert_eq!(
                towards,
                walk.id(next).filter(|_| next != cell),
                "seed {seed}"
            );
            if next != cell {
                let bound = walk.learnt.lower_bound(from, action, goal);
                assert_eq!(bound as usize, next / 7 + next % 7, "seed {seed}");
            }
        }
    }
}

/// Positions wrap, headings turn: in neither world is an action the same displacement everywhere.
#[test]
fn on_ice_nothing_is_pooled_where_actions_are_no_displacements() {
    for seed in 0..5 {
        let walk = Walk::slither(&World::turtle(4), 0, 3000, seed);
        assert_eq!(walk.learnt.noise(), None, "turtle, seed {seed}");
        let walk = Walk::slither(&World::torus(4, 4), 0, 3000, seed);
        assert_eq!(walk.learnt.noise(), None, "torus, seed {seed}");
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut anywhere = World::grid(5, 5, |_, _| false);
        for next in anywhere.moves.iter_mut().flatten() {
            *next = rng.random_range(0..25);
        }
        let walk = Walk::slither(&anywhere, 0, 3000, seed);
        assert_eq!(walk.learnt.noise(), None, "random moves, seed {seed}");
    }
}

#[test]
fn on_ice_a_one_way_door_is_no_way_back() {
    // Down through the middle of the wall between rows 1 and 2, never up.
    let world = World::grid(4, 5, |cell, direction| {
        (cell / 5 == 1 && direction == 2 && cell % 5 != 2) || (cell / 5 == 2 && direction == 0)
    });
    let mut walk = Walk::slither(&world, 0, 2, 0);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut here = *walk.names.last().expect("begun");
    for step in 0..6000 {
        if step % 200 == 0 {
            here = 0;
        }
        let action = rng.random_range(0..4);
        let to = world.slipped(here, action, rng.random());
        walk.arrive(here, Action(action as u16), to);
        here = to;
    }
    let [above, below] = [7, 12].map(|cell| walk.id(cell).expect("30 episodes go everywhere"));
    let towards = |from, action| {
        walk.learnt
            .neighbor_towards(&walk.graph, from, Action(action))
    };
    assert_eq!(towards(above, 2), Some(below));
    assert_eq!(towards(below, 0), None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Walls and one-way passages only make ways longer: on grids the bound never exceeds the truth, turns included.
    #[test]
    fn the_bound_never_exceeds_the_distance(
        grid in walled_grids(),
        turns in any::<bool>(),
        seed in any::<u64>(),
        steps in 10usize..400,
    ) {
        let world = if turns { grid.turning() } else { grid };
        let walk = Walk::wander(&world, 0, steps, seed);
        if walk.learnt.trusted() {
            for from in 0..walk.names.len() {
                for action in 0..world.num_actions() {
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
