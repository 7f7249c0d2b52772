use super::*;
use crate::env::Action;
use crate::env::conformance::check_model;
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
        0.99, 0.99, 20_380.4, 105_170.0, -13.0, 0.744, 0.913, 7.93, -12.0, -12.0, -12.0,
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
        check_model(make, is_random).unwrap_or_else(|broken| panic!("{name}:\n{broken}"));
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
