use super::*;
use crate::env::conformance::{Expectations, check_environment, check_model};
use crate::env::{Action, Environment, MdpState};
use crate::seeds::{Stream, stream};

/// R* under the board's own step limit, by backward induction written here.
fn optimal_return(board: &Board) -> f64 {
    let mdp = board.mdp();
    let mut value = vec![0.0; mdp.num_states()];
    for _ in 0..board.max_steps() {
        let worth = |outcome: &Outcome| {
            outcome.probability * (outcome.reward + value[outcome.next as usize])
        };
        value = (0..mdp.num_states())
            .map(|state| {
                let actions = (0..mdp.num_actions()).map(|a| Action(a as u16));
                let best = |action| mdp.outcomes(state, action).iter().map(worth).sum::<f64>();
                match mdp.is_terminal(state) {
                    true => 0.0,
                    false => actions.map(best).fold(f64::NEG_INFINITY, f64::max),
                }
            })
            .collect();
    }
    let starts = board.starts();
    starts.iter().map(|&start| value[start]).sum::<f64>() / starts.len() as f64
}

fn all() -> Vec<(&'static str, Board)> {
    vec![
        (
            "deep sea",
            deep_sea(10, &mut stream(0, Stream::Layout)).unwrap(),
        ),
        (
            "deep sea of another map",
            deep_sea(10, &mut stream(1, Stream::Layout)).unwrap(),
        ),
        (
            "stochastic deep sea",
            stochastic_deep_sea(10, &mut stream(0, Stream::Layout)).unwrap(),
        ),
        ("river of 6", river_swim(6).unwrap()),
        ("river of 20", river_swim(20).unwrap()),
        ("cliff", cliff_walking().unwrap()),
        ("lake of 4", frozen_lake(4).unwrap()),
        ("lake of 8", frozen_lake(8).unwrap()),
        ("taxi", taxi().unwrap()),
        ("pit", bridge(Fall::Pit).unwrap()),
        ("swamp", bridge(Fall::Swamp).unwrap()),
        ("back", bridge(Fall::Back).unwrap()),
    ]
}

/// Figures that the field knows.
#[test]
fn optimal_returns_are_the_known_ones() {
    let known = [
        0.99, 0.99, 0.381, 20_380.4, 105_170.0, -13.0, 0.744, 0.913, 7.93, -12.0, -12.0, -12.0,
    ];
    for ((name, board), known) in all().into_iter().zip(known) {
        let found = optimal_return(&board);
        let digits = if known > 1000.0 { 0.05 } else { 0.0005 };
        let digits = if name == "taxi" { 0.005 } else { digits };
        assert!(
            (found - known).abs() <= digits,
            "{name}: {found}, not {known}"
        );
        // And the general solver says the same.
        let general = board.mdp().optimum(board.starts(), board.max_steps());
        assert!(
            (general.expected_return - found).abs() <= 1e-9 * found.abs().max(1.0),
            "{name}"
        );
    }
}

#[test]
fn boards_keep_the_contract_of_environments() {
    for (name, board) in all() {
        assert_eq!(
            board.state_names().len(),
            board.mdp().num_states(),
            "{name}"
        );
        let mut names = board.state_names().to_vec();
        names.sort_unstable();
        names.dedup();
        assert_eq!(
            names.len(),
            board.mdp().num_states(),
            "{name}: a name twice"
        );
        let is_random = !["deep sea", "deep sea of another map", "cliff"].contains(&name);
        let make = |seed| {
            board
                .environment(None, stream(seed, Stream::Environment))
                .unwrap()
        };
        let kept = if name == "stochastic deep sea" {
            // What it pays is not what the model says, but on average.
            let expectations = Expectations {
                max_steps: Some(board.max_steps()),
                random: true,
            };
            check_environment(make, &expectations)
        } else {
            check_model(make, is_random)
        };
        kept.unwrap_or_else(|broken| panic!("{name}:\n{broken}"));
    }
}

/// V of always taking the bridge, from the equation of the way: each step on succeeds with 0.7.
#[test]
fn the_bridge_is_worth_what_its_equation_says() {
    let crossing = |fall: f64, returns: bool| {
        // V = Σ_{i<4} .7^i (−.7 + .3 fall) + (returns) (1 − .7⁴) V
        let reach: f64 = (0..4).map(|i| 0.7_f64.powi(i)).sum();
        let once = reach * (-0.7 + 0.3 * fall);
        if returns {
            once / 0.7_f64.powi(4)
        } else {
            once
        }
    };
    let expected = [
        (Fall::Pit, crossing(-100.0, false), -77.8),
        (Fall::Swamp, crossing(-31.0, true), -105.5),
        (Fall::Back, crossing(-20.0, true), -70.7),
    ];
    for (fall, equation, published) in expected {
        let board = bridge(fall).unwrap();
        let go = [1.0, 0.0, 0.0].repeat(board.mdp().num_states());
        let value = board.mdp().policy_evaluation(&go, 1.0, 1e-10).values[0];
        assert!(
            (value - equation).abs() < 1e-6,
            "{fall:?}: {value}, not {equation}"
        );
        assert!((equation - published).abs() < 0.05, "{fall:?}: {equation}");
    }
}

#[test]
fn deep_seas_differ_in_what_their_actions_mean_and_in_nothing_else() {
    let boards: Vec<_> = (0..5)
        .map(|seed| deep_sea(6, &mut stream(seed, Stream::Layout)).unwrap())
        .collect();
    let sorted = |board: &Board, state| {
        let mut pair = [0, 1].map(|a| board.mdp().outcomes(state, Action(a))[0].next);
        pair.sort_unstable();
        pair
    };
    for board in &boards[1..] {
        assert_ne!(board.mdp(), boards[0].mdp());
        for state in 0..21 {
            assert_eq!(sorted(board, state), sorted(&boards[0], state));
        }
    }
}

/// q = 1 − 1/N is the chance of a step right: going right until one fails earns q^(N−1) at a cost of 0.01/N for each step
/// that comes to be taken. Here by the row: V_i = max(0, −0.01/N + q V_{i+1}), V_{N−1} = 1 − 0.01/N.
#[test]
fn in_the_stochastic_sea_the_best_goes_right_until_a_step_fails() {
    for size in [2, 3, 10, 40] {
        let board = stochastic_deep_sea(size, &mut stream(3, Stream::Layout)).unwrap();
        let (n, cost) = (size as f64, 0.01 / size as f64);
        let on_the_way = |below: f64, _| (below * (1.0 - 1.0 / n) - cost).max(0.0);
        let by_rows = (1..size).fold(1.0 - cost, on_the_way);
        let best = board.mdp().optimum(board.starts(), size).expected_return;
        assert!(
            (best - by_rows).abs() < 1e-12,
            "{size}: {best}, not {by_rows}"
        );
        assert!((optimal_return(&board) - by_rows).abs() < 1e-12);
        let q = 1.0 - 1.0 / n;
        let equation = q.powi(size as i32 - 1) - 0.01 * (1.0 - q.powi(size as i32));
        assert!(
            (best - equation).abs() < 1e-12,
            "{size}: {best}, not {equation}"
        );
    }
}

/// What is seen in random episodes against the model and the noise: frequencies, means and variances within five of their
/// standard errors. The fourth moment tells a normal number from others of variance 1.
#[test]
fn the_stochastic_sea_is_as_its_model_and_its_noise_say() {
    let size = 4;
    let board = stochastic_deep_sea(size, &mut stream(5, Stream::Layout)).unwrap();
    let mdp = board.mdp();
    let mut world = board
        .environment(None, stream(1, Stream::Environment))
        .unwrap();
    let pairs = mdp.num_states() * 2;
    let mut led = vec![vec![0.0; mdp.num_states()]; pairs];
    let mut powers = vec![[0.0; 5]; pairs]; // Σ zᵏ of the difference z between what was paid and the model's reward
    let mut choice = 1_u64;
    for _ in 0..60_000 {
        let mut state = world.reset();
        for _ in 0..size {
            choice = choice
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let action = Action((choice >> 63) as u16);
            let step = world.step(action);
            let pair = state.index() * 2 + action.index();
            let outcomes = mdp.outcomes(state.index(), action);
            let model = outcomes.iter().find(|o| o.next == step.state.0).unwrap();
            led[pair][step.state.index()] += 1.0;
            let mut power = 1.0;
            for sum in &mut powers[pair] {
                *sum += power;
                power *= step.reward - model.reward;
            }
            state = step.state;
        }
    }
    for state in (0..mdp.num_states()).filter(|&state| !mdp.is_terminal(state)) {
        let noisy = ["[3, 0]", "[3, 3]"].contains(&board.state_names()[state].as_str());
        let sigma = if noisy { 1.0 } else { 0.0 };
        assert_eq!(world.reward_deviation(MdpState(state as u32)), sigma);
        for action in [0, 1] {
            let pair = state * 2 + action;
            let n = powers[pair][0];
            assert!(n > 300.0, "{n} steps");
            for outcome in mdp.outcomes(state, Action(action as u16)) {
                let p = outcome.probability;
                let off = led[pair][outcome.next as usize] / n - p;
                assert!(
                    off.abs() <= 5.0 * (p * (1.0 - p) / n).sqrt(),
                    "{state}, {action}: {off}"
                );
            }
            // Var z = 1, Var z² = 2, Var z⁴ = 96.
            for (power, mean, variance) in [(1, 0.0, 1.0), (2, 1.0, 2.0), (4, 3.0, 96.0_f64)] {
                let off = powers[pair][power] / n - mean * sigma;
                let error = sigma * (variance / n).sqrt();
                assert!(
                    off.abs() <= 5.0 * error,
                    "{state}, {action}, {power}: {off}"
                );
            }
        }
    }
}

/// A world with noise nowhere draws what a world without it draws.
#[test]
fn a_deviation_of_0_draws_nothing() {
    let board = river_swim(6).unwrap();
    let plain = board
        .environment(None, stream(2, Stream::Environment))
        .unwrap();
    let zeros = plain.clone().with_reward_noise(&[0.0; 6]);
    let rewards = |mut world: crate::env::TabularEnvironment| -> Vec<_> {
        world.reset();
        (0..20).map(|_| world.step(Action(1))).collect()
    };
    assert_eq!(rewards(plain), rewards(zeros));
}

#[test]
fn sizes_that_no_board_has_are_refused() {
    for refused in [
        deep_sea(1, &mut stream(0, Stream::Layout)),
        deep_sea(4097, &mut stream(0, Stream::Layout)),
        river_swim(2),
        frozen_lake(5),
    ] {
        let error = refused.unwrap_err();
        assert!(error.to_string().starts_with("size = "), "{error}");
    }
}
