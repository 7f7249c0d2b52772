//! Worlds keep the contract, and what is computed about them agrees with what is computed another way.

use crate::env_worlds::{grid_world, maps, random_mdp};
use eigentrail::env::conformance::{Expectations, check_environment, check_model};
use eigentrail::env::{
    Action, Cell, Direction, Doors, EdgeList, EdgeListGoal, EdgeListParams, EnvError, Environment,
    GoalCell, GridWorld, GridWorldParams, Landmark, Layout, Model, RewardScheme, StepStatus,
    TabularEnvironment, TabularMdp, Tile,
};
use eigentrail::seeds::{Stream, stream};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

/// 0.999 quantile of χ² with 2, and with 8, degrees of freedom.
const CHI_SQUARE_2: f64 = 13.816;
const CHI_SQUARE_8: f64 = 26.124;

/// Values from two exact routes: only rounding parts them.
const ROUNDING: f64 = 1e-9;

fn params() -> GridWorldParams {
    GridWorldParams::default()
}

fn ascii(map: &str) -> Layout {
    Layout::from_ascii(map, &BTreeMap::from([('1', 5.0)])).unwrap()
}

fn layout_rng(seed: u64) -> ChaCha8Rng {
    stream(seed, Stream::Layout)
}

// ---------------------------------------------------------------------------------------------------- the contract

#[test]
fn every_map_keeps_the_contract() {
    let variants = [
        (params(), false),
        (
            GridWorldParams {
                slip: 0.3,
                ..params()
            },
            true,
        ),
        (
            GridWorldParams {
                random_start: true,
                max_steps: Some(37),
                ..params()
            },
            true,
        ),
        (
            GridWorldParams {
                rewards: RewardScheme::GoalBonus,
                ..params()
            },
            false,
        ),
    ];
    for (name, layout) in maps() {
        for (params, random) in &variants {
            let checked = check_model(|seed| grid_world(&layout, params, seed), *random);
            let coverage = checked.unwrap_or_else(|broken| panic!("{name}, {params:?}:\n{broken}"));
            assert!(
                coverage.truncations > 0 && coverage.states > 2,
                "{name}: {coverage:?}"
            );
        }
    }
}

#[test]
fn finite_mdps_keep_the_contract() {
    for seed in 0..20 {
        let mdp = random_mdp(7, 3, seed);
        let make = |seed| {
            TabularEnvironment::new(
                mdp.clone(),
                &[0, 2, 3],
                12,
                stream(seed, Stream::Environment),
            )
            .unwrap()
        };
        let coverage =
            check_model(make, true).unwrap_or_else(|broken| panic!("MDP {seed}:\n{broken}"));
        assert!(coverage.terminations > 0, "{coverage:?}");
    }
}

#[test]
fn without_slip_and_with_a_fixed_start_nothing_is_drawn() {
    let layout = &maps()[2].1;
    let expectations = Expectations {
        max_steps: Some(1040),
        random: true,
    };
    let broken =
        check_environment(|seed| grid_world(layout, &params(), seed), &expectations).unwrap_err();
    assert!(
        broken.contains(eigentrail::env::conformance::Rule::SeedsDiffer),
        "{broken}"
    );
}

// ------------------------------------------------------------------------------------------------------ grid worlds

#[test]
fn bumps_stay_and_moves_move() {
    let mut world = grid_world(&ascii("S#\n.G"), &params(), 0);
    assert_eq!(world.reset(), Cell(0));
    for blocked in [Direction::Up, Direction::Left, Direction::Right] {
        let step = world.step(blocked.action());
        assert_eq!(
            (step.state, step.reward, step.status),
            (Cell(0), -1.0, StepStatus::Running)
        );
    }
    assert_eq!(world.step(Direction::Down.action()).state, Cell(2));
    let last = world.step(Direction::Right.action());
    assert_eq!(
        (last.state, last.reward, last.status),
        (Cell(3), -1.0, StepStatus::Terminated)
    );
}

#[test]
fn each_scheme_pays_its_equation() {
    let pays = |layout: &Layout, rewards| {
        let mut world = grid_world(
            layout,
            &GridWorldParams {
                rewards,
                ..params()
            },
            0,
        );
        world.reset();
        [(); 2].map(|()| world.step(Direction::Right.action()).reward)
    };
    let plain = ascii("S.G");
    assert_eq!(pays(&plain, RewardScheme::StepCost), [-1.0, -1.0]);
    assert_eq!(pays(&plain, RewardScheme::GoalBonus), [-1.0, 99.0]);
    assert_eq!(
        pays(
            &plain,
            RewardScheme::Explicit {
                step: -0.1,
                goal: 2.0
            }
        ),
        [-0.1, 1.9]
    );
    // A goal with a number of its own is paid that number, whatever the scheme gives others.
    assert_eq!(pays(&ascii("S.1"), RewardScheme::StepCost), [-1.0, 4.0]);
    assert_eq!(pays(&ascii("S.1"), RewardScheme::GoalBonus), [-1.0, 4.0]);
}

#[test]
fn three_routes_to_the_distance_agree() {
    for (name, layout) in maps() {
        let world = grid_world(&layout, &params(), 0);
        let mdp = world.to_mdp();
        let on_map = layout.distances_to_goals();
        let in_mdp = mdp.distances_to_terminal();
        let mut uniform = layout.clone();
        uniform.goals = layout.goals.iter().map(|g| GoalCell::new(g.cell)).collect();
        let values = grid_world(&uniform, &params(), 0)
            .to_mdp()
            .value_iteration(1.0, ROUNDING);
        assert!(
            values.converged && values.sweeps <= 2,
            "{name}: {} sweeps",
            values.sweeps
        );
        for (state, cell) in world.mdp_cells().enumerate() {
            assert_eq!(world.mdp_index(&cell), state);
            assert_eq!(on_map[cell.index()], in_mdp[state], "{name}, {cell:?}");
            let value = in_mdp[state].map_or(f64::NEG_INFINITY, |moves| -f64::from(moves));
            assert_eq!(values.values[state], value, "{name}, {cell:?}");
        }
    }
}

#[test]
fn optimum_is_the_shortest_path() {
    let optimum = |map: &Layout, params: &GridWorldParams| grid_world(map, params, 0).optimum();
    let open = Layout::open(5, 5)
        .unwrap()
        .with_start([0, 0])
        .unwrap()
        .with_goal([4, 4], None)
        .unwrap();
    let best = optimum(&open, &params());
    assert_eq!((best.expected_return, best.expected_steps), (-8.0, 8.0));
    let random = optimum(
        &open,
        &GridWorldParams {
            random_start: true,
            ..params()
        },
    );
    // Mean of (4 − r) + (4 − c) over the 24 other cells: 25 · 4 / 24.
    assert!((random.expected_steps - 100.0 / 24.0).abs() < ROUNDING);
    // The far goal pays 5 more for 3 more steps.
    let two = optimum(&ascii("1.......S.....G"), &params());
    assert_eq!((two.expected_return, two.expected_steps), (-3.0, 8.0));
}

#[test]
fn playing_greedily_earns_the_optimum() {
    let layout = &maps()[0].1;
    let params = GridWorldParams {
        slip: 0.2,
        ..params()
    };
    let mut world = grid_world(layout, &params, 5);
    let mdp = world.to_mdp();
    let values = mdp.value_iteration(1.0, 1e-12).values;
    let episodes = 4000;
    let returns: Vec<f64> = (0..episodes)
        .map(|_| {
            let mut state = world.reset();
            let mut total = 0.0;
            loop {
                let action = mdp.greedy_actions(&values, 1.0, world.mdp_index(&state), ROUNDING)[0];
                let step = world.step(action);
                (state, total) = (step.state, total + step.reward);
                if step.status.is_last() {
                    return total;
                }
            }
        })
        .collect();
    let mean = returns.iter().sum::<f64>() / returns.len() as f64;
    let variance =
        returns.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / (returns.len() - 1) as f64;
    let standard_error = (variance / returns.len() as f64).sqrt();
    let optimum = world.optimum().expected_return;
    assert!(
        (mean - optimum).abs() < 4.0 * standard_error,
        "{mean} ± {standard_error}, optimum {optimum}"
    );
    // The limit of 250 steps hardly ever cuts an episode, so the undiscounted optimum is nearly the same.
    assert!((values[world.start_states()[0]] - optimum).abs() < 1e-6);
}

#[test]
fn slips_have_their_frequencies() {
    let layout = ascii("...\n.S.\nG..");
    let slip = 0.3;
    let params = GridWorldParams { slip, ..params() };
    for direction in Direction::ALL {
        let mut world = grid_world(&layout, &params, 77);
        let draws = 30_000;
        let mut counts = [0_u32; 9];
        for _ in 0..draws {
            world.reset();
            counts[world.step(direction.action()).state.index()] += 1;
        }
        let d = direction as usize;
        let cell = |d: usize| {
            layout
                .neighbor(Cell(4), Direction::ALL[d % 4])
                .unwrap()
                .index()
        };
        let expected = [
            (cell(d), 1.0 - slip),
            (cell(d + 1), slip / 2.0),
            (cell(d + 3), slip / 2.0),
        ];
        let terms = expected.map(|(cell, p)| (f64::from(counts[cell]), p * f64::from(draws)));
        assert!(
            terms.iter().map(|(seen, _)| seen).sum::<f64>() == f64::from(draws),
            "moved back or stayed"
        );
        let chi_square: f64 = terms
            .iter()
            .map(|(seen, expected)| (seen - expected).powi(2) / expected)
            .sum();
        assert!(chi_square < CHI_SQUARE_2, "{direction:?}: {chi_square}");
    }
}

#[test]
fn random_starts_are_uniform_over_what_leads_to_a_goal() {
    // Nine cells lead to the goal; the three below the one-way row do not.
    let layout = ascii("...\n...\n..G\nvvv\n..#");
    let mut world = grid_world(
        &layout,
        &GridWorldParams {
            random_start: true,
            ..params()
        },
        3,
    );
    assert_eq!(world.starts(), [0, 1, 2, 3, 4, 5, 6, 7].map(Cell));
    let mut counts = [0_u32; 9];
    let draws = 9000;
    (0..draws).for_each(|_| counts[world.reset().index()] += 1);
    let expected = f64::from(draws) / 8.0;
    let chi_square: f64 = counts[..8]
        .iter()
        .map(|&seen| (f64::from(seen) - expected).powi(2) / expected)
        .sum();
    assert!(counts[8] == 0 && chi_square < CHI_SQUARE_8, "{counts:?}");
}

#[test]
fn goals_move_between_episodes() {
    let mut world = grid_world(&ascii("G.S.."), &params(), 0);
    world.reset();
    world.set_goals(vec![GoalCell::new(Cell(4))]).unwrap();
    assert_eq!(world.optimum().expected_steps, 2.0);
    assert_eq!(world.reset(), Cell(2));
    let left = [(); 3].map(|()| world.step(Direction::Left.action()).status);
    assert_eq!(left, [StepStatus::Running; 3], "the old goal is gone");
    let refused = world.set_goals(vec![GoalCell::new(Cell(2))]);
    assert_eq!(
        refused,
        Err(EnvError::StartIsGoal {
            place: "[0, 2]".to_owned()
        })
    );
    assert_eq!(
        world.step(Direction::Right.action()).state,
        Cell(1),
        "a refused change changes nothing"
    );
}

#[test]
fn a_million_cells_are_solved_by_shortest_paths() {
    let layout = Layout::open(1000, 1000)
        .unwrap()
        .with_start([0, 0])
        .unwrap()
        .with_goal([999, 999], None)
        .unwrap();
    let world = grid_world(&layout, &params(), 0);
    assert_eq!(world.optimum().expected_steps, 1998.0);
    let solved = world.to_mdp().value_iteration(1.0, ROUNDING);
    assert_eq!((solved.values[0], solved.sweeps), (-1998.0, 1));
}

#[test]
fn impossible_worlds_are_refused_by_name() {
    let refusal = |layout: Layout, params: GridWorldParams| {
        GridWorld::new(layout, params, stream(0, Stream::Environment))
            .map(|_| ())
            .unwrap_err()
    };
    let good = || ascii("S.G");
    let by_map = |map: &str| refusal(ascii(map), params());
    assert_eq!(by_map("..G"), EnvError::NoStart);
    assert_eq!(by_map("S.."), EnvError::NoGoal);
    assert_eq!(by_map("###"), EnvError::NoFreeCell);
    let walled_off = by_map(".\nS#G").to_string();
    assert!(
        walled_off.contains("[1, 2] cannot be reached from the start [1, 0]"),
        "{walled_off}"
    );
    // Behind another goal is out of reach: the episode is over there.
    assert!(matches!(by_map("S.G.G"), EnvError::GoalUnreachable { .. }));
    assert!(matches!(by_map("S<G"), EnvError::GoalUnreachable { .. }));
    let lonely = ascii("..G#G");
    let random = GridWorldParams {
        random_start: true,
        ..params()
    };
    assert!(matches!(
        refusal(lonely, random),
        EnvError::GoalUnreachable { .. }
    ));
    let placed = |start: [usize; 2], goal: [usize; 2]| {
        refusal(
            ascii("...\n#..")
                .with_start(start)
                .unwrap()
                .with_goal(goal, None)
                .unwrap(),
            params(),
        )
    };
    assert_eq!(
        placed([1, 0], [0, 0]),
        EnvError::StartInWall { row: 1, col: 0 }
    );
    assert_eq!(
        placed([0, 0], [1, 0]),
        EnvError::GoalInWall { row: 1, col: 0 }
    );
    assert_eq!(
        placed([0, 0], [0, 0]),
        EnvError::StartIsGoal {
            place: "[0, 0]".to_owned()
        }
    );
    let twice = good().with_goal([0, 2], Some(1.0)).unwrap();
    assert_eq!(
        refusal(twice, params()),
        EnvError::DuplicateGoal {
            place: "[0, 2]".to_owned()
        }
    );
    let nan = good().with_goal([0, 1], Some(f64::NAN)).unwrap();
    assert!(matches!(
        refusal(nan, params()),
        EnvError::RewardNotFinite { .. }
    ));
    for slip in [-0.1, 1.0, f64::NAN] {
        assert!(matches!(
            refusal(good(), GridWorldParams { slip, ..params() }),
            EnvError::Slip { .. }
        ));
    }
    assert_eq!(
        refusal(
            good(),
            GridWorldParams {
                max_steps: Some(0),
                ..params()
            }
        ),
        EnvError::NoSteps
    );
    let paid = RewardScheme::Explicit {
        step: 1.0,
        goal: 0.0,
    };
    let paid = refusal(
        good(),
        GridWorldParams {
            rewards: paid,
            ..params()
        },
    );
    assert_eq!(paid, EnvError::StepRewardPositive { reward: 1.0 });
    assert_eq!(Layout::open(0, 3), Err(EnvError::EmptyMap));
    assert!(matches!(
        Layout::open(1 << 20, 1 << 20),
        Err(EnvError::MapTooLarge { .. })
    ));
}

#[test]
fn layout_parameters_out_of_range_are_named() {
    let parameter = |made: Result<Layout, EnvError>| match made {
        Err(EnvError::LayoutParameter { parameter, .. }) => parameter,
        other => panic!("{other:?}"),
    };
    let rng = &mut layout_rng(0);
    assert_eq!(parameter(Layout::maze(4, 5, 0.0, rng)), "rows");
    assert_eq!(parameter(Layout::maze(5, 0, 0.0, rng)), "cols");
    assert_eq!(parameter(Layout::maze(5, 5, 1.5, rng)), "loops");
    assert_eq!(parameter(Layout::maze(5, 5, f64::NAN, rng)), "loops");
    assert_eq!(parameter(Layout::caves(5, 5, 1.0, 3, rng)), "fill");
    assert_eq!(parameter(Layout::linked(2, 2, [5, 5], 0)), "corridor");
    assert_eq!(Layout::caves(3, 3, 0.99, 3, rng), Err(EnvError::NoFreeCell));
}

// ------------------------------------------------------------------------------------------------------------- maps

/// Number of pairs of free cells side by side.
fn passages(layout: &Layout) -> usize {
    let ahead = [Direction::Right, Direction::Down];
    let of_cell = |cell| {
        ahead
            .iter()
            .filter(|&&d| layout.neighbor(cell, d).is_some())
            .count()
    };
    layout.free_cells().map(of_cell).sum()
}

fn is_connected(layout: &Layout) -> bool {
    let first = layout.free_cells().next().unwrap();
    let reached = layout.distances_from(first);
    layout
        .free_cells()
        .all(|cell| reached[cell.index()].is_some())
}

/// What cannot be reached, by a route of its own: relax all moves until nothing changes.
fn distances_by_relaxation(layout: &Layout, from: Cell) -> Vec<Option<u32>> {
    let mut moves = vec![u32::MAX; layout.num_cells()];
    moves[from.index()] = 0;
    let is_goal = |cell: Cell| cell != from && layout.goals.iter().any(|goal| goal.cell == cell);
    for _ in 0..layout.num_cells() {
        for cell in layout.free_cells().filter(|&cell| !is_goal(cell)) {
            for next in Direction::ALL
                .into_iter()
                .filter_map(|direction| layout.neighbor(cell, direction))
            {
                moves[next.index()] =
                    moves[next.index()].min(moves[cell.index()].saturating_add(1));
            }
        }
    }
    moves
        .into_iter()
        .map(|moves| (moves != u32::MAX).then_some(moves))
        .collect()
}

/// Any map of any tiles, with a start and goals on free cells.
fn any_map() -> impl Strategy<Value = Layout> {
    let tiles = prop::sample::select(vec!['#', '.', '.', '.', '^', 'v', '<', '>', 'G', '1']);
    let lines = (1..7_usize, 1..7_usize).prop_flat_map(move |(rows, cols)| {
        prop::collection::vec(prop::collection::vec(tiles.clone(), cols), rows)
    });
    (lines, any::<prop::sample::Index>()).prop_map(|(mut lines, start)| {
        let (rows, cols) = (lines.len(), lines[0].len());
        let at = start.index(rows * cols);
        lines[at / cols][at % cols] = 'S';
        let lines: Vec<String> = lines
            .into_iter()
            .map(|line| line.into_iter().collect())
            .collect();
        ascii(&lines.join("\n"))
    })
}

proptest! {
    #[test]
    fn maps_survive_being_drawn(layout in any_map()) {
        prop_assert_eq!(ascii(&layout.to_string()), layout);
    }

    #[test]
    fn distances_agree_with_relaxation(layout in any_map()) {
        let start = layout.start.unwrap();
        prop_assert_eq!(layout.distances_from(start), distances_by_relaxation(&layout, start));
        let forward = layout.distances_from(start);
        for goal in &layout.goals {
            prop_assert_eq!(layout.distances_to(&[goal.cell])[start.index()], forward[goal.cell.index()]);
        }
    }

    #[test]
    fn a_world_that_is_accepted_can_be_finished(layout in any_map(), random_start: bool) {
        let params = GridWorldParams { random_start, ..params() };
        if let Ok(world) = GridWorld::new(layout, params, stream(0, Stream::Environment)) {
            let mdp = world.to_mdp();
            let distance = mdp.distances_to_terminal();
            prop_assert!(world.start_states().iter().all(|&start| distance[start].is_some_and(|moves| moves > 0)));
        }
    }

    #[test]
    fn a_maze_without_loops_is_a_spanning_tree(rows in 0..9_usize, cols in 0..9_usize, seed: u64) {
        let layout = Layout::maze(2 * rows + 1, 2 * cols + 1, 0.0, &mut layout_rng(seed)).unwrap();
        let nodes = (rows + 1) * (cols + 1);
        prop_assert!(is_connected(&layout));
        prop_assert_eq!(layout.num_free(), 2 * nodes - 1);
        prop_assert_eq!(passages(&layout), layout.num_free() - 1);
    }

    #[test]
    fn each_opened_wall_of_a_maze_closes_one_loop(rows in 0..9_usize, cols in 0..9_usize, loops in 0.0..=1.0, seed: u64) {
        let layout = Layout::maze(2 * rows + 1, 2 * cols + 1, loops, &mut layout_rng(seed)).unwrap();
        let nodes = (rows + 1) * (cols + 1);
        let walls_between = rows * (cols + 1) + cols * (rows + 1) - (nodes - 1);
        let opened = (loops * walls_between as f64).round() as usize;
        prop_assert!(is_connected(&layout));
        prop_assert_eq!(passages(&layout) + 1 - layout.num_free(), opened);
    }

    #[test]
    fn each_shared_wall_of_rooms_has_one_door(
        rows in 1..5_usize, cols in 1..5_usize, height in 1..6_usize, width in 1..6_usize, center: bool, seed: u64,
    ) {
        let doors = if center { Doors::Center } else { Doors::Random };
        let layout = Layout::rooms(rows, cols, [height, width], doors, &mut layout_rng(seed)).unwrap();
        prop_assert!(is_connected(&layout));
        let free = |row, col| layout.tile(layout.cell(row, col).unwrap()) == Tile::Free;
        for (r, c) in (0..rows).flat_map(|r| (0..cols).map(move |c| (r, c))) {
            let (top, left) = (r * (height + 1), c * (width + 1));
            prop_assert!((0..height * width).all(|i| free(top + i / width, left + i % width)));
            if c + 1 < cols {
                prop_assert_eq!((0..height).filter(|i| free(top + i, left + width)).count(), 1);
            }
            if r + 1 < rows {
                prop_assert_eq!((0..width).filter(|i| free(top + height, left + i)).count(), 1);
            }
        }
        let shared = rows * (cols - 1) + cols * (rows - 1);
        prop_assert_eq!(layout.num_free(), rows * cols * height * width + shared, "nothing else is open");
    }

    #[test]
    fn caves_are_connected_and_repeat(rows in 4..20_usize, cols in 4..20_usize, fill in 0.0..0.5, seed: u64) {
        let make = || Layout::caves(rows, cols, fill, 4, &mut layout_rng(seed));
        if let Ok(layout) = make() {
            prop_assert!(is_connected(&layout));
            prop_assert_eq!(make().unwrap(), layout);
        }
    }
}

#[test]
fn linked_grids_are_joined_by_bridges() {
    let layout = Layout::linked(2, 2, [5, 5], 2).unwrap();
    assert!(is_connected(&layout));
    // Four grids in a ring: one corridor may be closed, two part the ring.
    let mut cut = layout.clone();
    cut.set_tile(layout.cell(2, 5).unwrap(), Tile::Wall);
    assert!(is_connected(&cut));
    cut.set_tile(layout.cell(9, 5).unwrap(), Tile::Wall);
    assert!(!is_connected(&cut));
}

#[test]
fn seeds_make_maps_of_one_family() {
    let caves = |seed| Layout::caves(30, 30, 0.4, 4, &mut layout_rng(seed)).unwrap();
    let maze = |seed| Layout::maze(31, 31, 0.1, &mut layout_rng(seed)).unwrap();
    assert_ne!(caves(1), caves(2));
    assert_ne!(maze(1), maze(2));
    assert!(caves(1).num_free() > 300, "{}", caves(1));
}

// ------------------------------------------------------------------------------------------------------ finite MDPs

/// v^π from (I − γ P_π) v = r_π, by a dense solver.
fn solved_densely(mdp: &TabularMdp, policy: &[f64], gamma: f64) -> Vec<f64> {
    let n = mdp.num_states();
    let mut system = DMatrix::<f64>::identity(n, n);
    let mut rewards = DVector::<f64>::zeros(n);
    for state in (0..n).filter(|&state| !mdp.is_terminal(state)) {
        for action in mdp.actions() {
            let weight = policy[state * mdp.num_actions() + action.index()];
            for outcome in mdp.outcomes(state, action) {
                let p = weight * outcome.probability;
                rewards[state] += p * outcome.reward;
                if !mdp.is_terminal(outcome.next as usize) {
                    system[(state, outcome.next as usize)] -= gamma * p;
                }
            }
        }
    }
    system.lu().solve(&rewards).unwrap().as_slice().to_vec()
}

/// Every deterministic policy, as a table of probabilities.
fn all_policies(states: usize, actions: usize) -> impl Iterator<Item = Vec<f64>> {
    (0..actions.pow(states as u32)).map(move |mut code| {
        let mut policy = vec![0.0; states * actions];
        for state in 0..states {
            policy[state * actions + code % actions] = 1.0;
            code /= actions;
        }
        policy
    })
}

/// v_H by trying every action at every step.
fn expectimax(mdp: &TabularMdp, state: usize, steps: usize) -> f64 {
    if steps == 0 || mdp.is_terminal(state) {
        return 0.0;
    }
    let value = |action: Action| -> f64 {
        let outcomes = mdp.outcomes(state, action).iter();
        outcomes
            .map(|o| o.probability * (o.reward + expectimax(mdp, o.next as usize, steps - 1)))
            .sum()
    };
    mdp.actions().map(value).fold(f64::NEG_INFINITY, f64::max)
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= ROUNDING * a.abs().max(1.0)
}

proptest! {
    #[test]
    fn policy_evaluation_agrees_with_a_dense_solver(seed: u64, gamma in prop::sample::select(vec![0.0, 0.5, 0.95, 1.0])) {
        let mdp = random_mdp(6, 3, seed);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut policy = vec![0.0; 18];
        for row in policy.chunks_mut(3) {
            row.fill_with(|| rng.random());
            let sum: f64 = row.iter().sum();
            row.iter_mut().for_each(|weight| *weight /= sum);
        }
        let evaluated = mdp.policy_evaluation(&policy, gamma, 1e-12);
        prop_assert!(evaluated.converged);
        for (ours, exact) in evaluated.values.iter().zip(solved_densely(&mdp, &policy, gamma)) {
            prop_assert!(close(*ours, exact), "{ours} {exact}");
        }
    }

    #[test]
    fn value_iteration_finds_the_best_of_all_policies(seed: u64, gamma in prop::sample::select(vec![0.0, 0.9, 1.0])) {
        let mdp = random_mdp(4, 2, seed);
        let solved = mdp.value_iteration(gamma, 1e-12);
        prop_assert!(solved.converged);
        let mut best = vec![f64::NEG_INFINITY; 4];
        for policy in all_policies(4, 2) {
            let values = solved_densely(&mdp, &policy, gamma);
            best.iter_mut().zip(values).for_each(|(best, value)| *best = best.max(value));
        }
        for (ours, exact) in solved.values.iter().zip(&best) {
            prop_assert!(close(*ours, *exact), "{ours} {exact}");
        }
        // A greedy policy earns what the values promise.
        let mut greedy = vec![0.0; 8];
        for state in 0..3 {
            greedy[state * 2 + mdp.greedy_actions(&solved.values, gamma, state, ROUNDING)[0].index()] = 1.0;
        }
        for (earned, promised) in solved_densely(&mdp, &greedy, gamma).iter().zip(&solved.values) {
            prop_assert!(close(*earned, *promised), "{earned} {promised}");
        }
    }

    #[test]
    fn optimum_agrees_with_trying_everything(seed: u64, limit in 1..6_usize) {
        let mdp = random_mdp(4, 2, seed);
        for start in 0..3 {
            let exact = expectimax(&mdp, start, limit);
            prop_assert!(close(mdp.optimal_return(&[start], limit), exact));
            prop_assert!((1.0..=limit as f64).contains(&mdp.optimal_steps(&[start], limit)));
        }
    }

    #[test]
    fn without_a_limit_the_optimum_is_the_undiscounted_value(seed: u64) {
        let mdp = random_mdp(6, 2, seed);
        let values = mdp.value_iteration(1.0, 1e-13).values;
        prop_assert!(close(mdp.optimal_return(&[0], 1_000_000), values[0]));
    }
}

// ------------------------------------------------------------------------------------------------------- edge lists

const HOUSE: &str = "\
from,action,to,probability,reward
hall,north,kitchen,0.75,
hall,north,hall,0.25,-3
kitchen,east,garden,,
kitchen,east,hall,,
garden,south,hall,1,
";

fn house(params: &EdgeListParams) -> Result<TabularEnvironment, EnvError> {
    let list = EdgeList::from_reader("house.csv", HOUSE.as_bytes())?;
    list.environment(params, stream(0, Stream::Environment))
}

fn to_garden(start: Option<&str>) -> EdgeListParams {
    let goals = vec![EdgeListGoal {
        at: "garden".to_owned(),
        reward: Some(10.0),
    }];
    EdgeListParams {
        start: start.map(str::to_owned),
        goals,
        ..EdgeListParams::default()
    }
}

#[test]
fn an_edge_list_is_the_mdp_it_says() {
    let world = house(&to_garden(Some("hall"))).unwrap();
    let mdp = world.to_mdp();
    let [hall, kitchen, garden] = [0, 1, 2];
    let [north, east] = [Action(0), Action(1)];
    let row = |state, action| {
        mdp.outcomes(state, action)
            .iter()
            .map(|o| (o.next, o.probability, o.reward))
            .collect()
    };
    let expect = |state, action, outcomes: &[(u32, f64, f64)]| {
        let row: Vec<_> = row(state, action);
        assert_eq!(row, outcomes);
    };
    expect(hall, north, &[(1, 0.75, -1.0), (0, 0.25, -3.0)]);
    expect(kitchen, east, &[(2, 0.5, 9.0), (0, 0.5, -1.0)]);
    // Actions that are not listed stay in place.
    expect(hall, east, &[(0, 1.0, -1.0)]);
    expect(kitchen, north, &[(1, 1.0, -1.0)]);
    assert!(mdp.is_terminal(garden));
    assert_eq!((world.start_states(), world.max_steps()), (vec![hall], 30));
    assert_eq!(
        house(&to_garden(None)).unwrap().start_states(),
        [hall, kitchen]
    );
}

#[test]
fn a_continuing_edge_list_has_no_goals_and_a_way_back_from_everywhere() {
    let continuing = |edges: &str, start: Option<&str>| {
        let params = EdgeListParams {
            start: start.map(str::to_owned),
            continuing: true,
            max_steps: Some(12),
            ..EdgeListParams::default()
        };
        let list = EdgeList::from_reader("round.csv", edges.as_bytes()).unwrap();
        list.environment(&params, stream(0, Stream::Environment))
    };
    let round = "from,action,to,reward\na,on,b,1\nb,on,c,-4\nc,on,a,6\n";
    let world = continuing(round, Some("b")).unwrap();
    assert_eq!(world.optimal_gain(), Some(1.0));
    assert_eq!(world.optimum().expected_return, 12.0);
    assert_eq!(world.start_states(), [1]);
    assert_eq!(continuing(round, None).unwrap().start_states(), [0, 1, 2]);
    // From d on there is no way back; from c there never was one to it.
    let trap = "from,action,to,reward\na,on,b,1\nb,on,a,2\nb,off,d,0\n";
    let told = continuing(trap, Some("a")).unwrap_err().to_string();
    assert!(
        told.contains("\"a\" cannot be reached from \"d\""),
        "{told}"
    );
    let aside = "from,action,to,reward\na,on,b,1\nb,on,a,2\nc,on,a,0\n";
    assert_eq!(
        continuing(aside, Some("a")).unwrap().optimal_gain(),
        Some(1.5)
    );
    let told = continuing(aside, None).unwrap_err().to_string();
    assert!(
        told.contains("\"c\" cannot be reached from \"a\""),
        "{told}"
    );
    let with_goal = EdgeListParams {
        continuing: true,
        ..to_garden(Some("hall"))
    };
    let told = house(&with_goal).unwrap_err().to_string();
    assert!(
        told.contains("\"garden\" is one and can be reached"),
        "{told}"
    );
    let none = house(&EdgeListParams::default());
    assert!(matches!(none, Err(EnvError::NoGoal)), "{none:?}");
}

#[test]
fn edge_lists_keep_the_contract() {
    let list = EdgeList::from_reader("house.csv", HOUSE.as_bytes()).unwrap();
    let make = |seed| {
        list.environment(&to_garden(None), stream(seed, Stream::Environment))
            .unwrap()
    };
    let coverage = check_model(make, true).unwrap();
    assert!(
        coverage.terminations > 0 && coverage.states == 3,
        "{coverage:?}"
    );
}

#[test]
fn names_and_ways_of_an_edge_list_are_checked() {
    let misspelt = EdgeListParams {
        start: Some("hal".to_owned()),
        ..to_garden(None)
    };
    let message = house(&misspelt).unwrap_err().to_string();
    assert_eq!(
        message,
        "house.csv: no state is named \"hal\"; did you mean \"hall\"?"
    );
    let refused = |params: &EdgeListParams| house(params).map(|_| ()).unwrap_err();
    assert_eq!(
        refused(&to_garden(Some("garden"))),
        EnvError::StartIsGoal {
            place: "\"garden\"".to_owned()
        }
    );
    assert_eq!(refused(&EdgeListParams::default()), EnvError::NoGoal);
    let mut twice = to_garden(None);
    twice.goals.push(twice.goals[0].clone());
    assert!(matches!(refused(&twice), EnvError::DuplicateGoal { .. }));
    let cut =
        EdgeList::from_reader("cut.csv", "from,action,to\na,go,b\nc,go,a\n".as_bytes()).unwrap();
    let goals = vec![EdgeListGoal {
        at: "c".to_owned(),
        reward: None,
    }];
    for start in [Some("a".to_owned()), None] {
        let params = EdgeListParams {
            start,
            goals: goals.clone(),
            ..EdgeListParams::default()
        };
        let unreached = cut
            .environment(&params, stream(0, Stream::Environment))
            .map(|_| ())
            .unwrap_err();
        assert!(
            matches!(unreached, EnvError::GoalUnreachable { .. }),
            "{unreached}"
        );
    }
    let missing = EdgeList::read("no/such/file.csv").unwrap_err();
    assert!(
        missing.to_string().starts_with("no/such/file.csv: "),
        "{missing}"
    );
}

// ----------------------------------------------------------------------------------------------------------- params

#[test]
fn parameters_read_from_toml() {
    let text = "slip = 0.1\nmax_steps = 50\nrewards = { step = -0.5, goal = 1.0 }";
    let params: GridWorldParams = toml::from_str(text).unwrap();
    let rewards = RewardScheme::Explicit {
        step: -0.5,
        goal: 1.0,
    };
    assert_eq!(
        params,
        GridWorldParams {
            slip: 0.1,
            max_steps: Some(50),
            rewards,
            random_start: false
        }
    );
    assert!(toml::from_str::<GridWorldParams>("slipp = 0.1").is_err());
    let schema = serde_json::to_string(&schemars::schema_for!(GridWorldParams)).unwrap();
    assert!(
        schema.contains("\"step-cost\"") && schema.contains("max_steps"),
        "{schema}"
    );
    #[derive(serde::Deserialize)]
    struct Table {
        rewards: BTreeMap<char, f64>,
        at: eigentrail::env::Placement,
    }
    let table: Table = toml::from_str("at = \"center\"\nrewards = { 1 = 5.0, 2 = -1.0 }").unwrap();
    assert_eq!(table.rewards, BTreeMap::from([('1', 5.0), ('2', -1.0)]));
    assert_eq!(table.at, Landmark::Center.into());
}

#[test]
fn a_map_beyond_all_memory_is_an_error() {
    let error = Layout::open(20_000, 20_000).unwrap_err();
    assert!(matches!(error, EnvError::MapTooLarge { .. }), "{error}");
}
