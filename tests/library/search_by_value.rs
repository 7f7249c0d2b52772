//! Searches that the first end does not close: boards where what pays is far, noisy, or paid step by step.
//!
//! How well the default agent learns is told by tables. Here it has to find what there is, as an account of every episode says.

use eigentrail::agent::{AgentParams, build_agent};
use eigentrail::engine::{Engine, PipelineParams, ShapingPipeline};
use eigentrail::env::TabularEnvironment;
use eigentrail::env::boards::{Board, deep_sea, river_swim, stochastic_deep_sea};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The returns of so many episodes of the default agent.
fn returns(board: &Board, episodes: usize, seed: u64) -> Vec<f64> {
    let world: TabularEnvironment = board
        .environment(None, ChaCha8Rng::seed_from_u64(seed))
        .unwrap();
    let (agent, pipeline) = (AgentParams::default(), PipelineParams::default());
    let agent = build_agent(&agent, 2, pipeline.shaping.mix, seed);
    let pipeline = ShapingPipeline::new(&pipeline, 2, None, seed).unwrap();
    let mut engine = Engine::new(world, pipeline, agent);
    let mut returns = Vec::new();
    while returns.len() < episodes {
        let episode = engine.step(|_, _| {}).unwrap();
        returns.extend(episode.map(|episode| episode.plain_return));
    }
    returns
}

fn mean(returns: &[f64]) -> f64 {
    returns.iter().sum::<f64>() / returns.len() as f64
}

/// In an episode of as many steps as there are rows no end is early, and all but one pay nothing.
#[test]
fn the_treasure_of_the_deep_sea_is_found_and_kept() {
    for seed in 0..8 {
        let board = deep_sea(12, &mut ChaCha8Rng::seed_from_u64(100 + seed)).unwrap();
        let returns = returns(&board, 100, seed);
        // 12 · 13 cells' actions, of which each episode tries several.
        assert!(
            returns[..40].iter().any(|&found| found > 0.9),
            "seed {seed}"
        );
        assert!(
            returns[60..].iter().all(|&found| found > 0.9),
            "seed {seed}"
        );
    }
}

/// Standard normal noise on what the two ends of the last row pay; whoever always goes right gets there in 3 of 8 episodes.
#[test]
fn noise_does_not_hide_the_treasure() {
    let (q, rows) = (1.0 - 1.0 / 12.0, 12);
    let best = f64::powi(q, rows - 1) - 0.01 * (1.0 - f64::powi(q, rows));
    for seed in 0..8 {
        let board = stochastic_deep_sea(12, &mut ChaCha8Rng::seed_from_u64(100 + seed)).unwrap();
        let returns = returns(&board, 6000, seed);
        // The mean of 4000 returns of deviation 0.8 or so lies within 0.04 of its expectation in 998 of 1000 cases.
        let found = mean(&returns[2000..]);
        assert!(found > 0.8 * best, "seed {seed}: {found} of {best}");
    }
}

/// Nothing ends an episode, something small pays at once, and the way to what is worth a thousand times more mostly fails.
#[test]
fn nobody_settles_for_the_near_bank_of_the_river() {
    let board = river_swim(6).unwrap();
    let best = board
        .mdp()
        .optimal_return(board.starts(), board.max_steps());
    for seed in 0..8 {
        let returns = returns(&board, 2000, seed);
        let found = mean(&returns[500..]);
        assert!(found > 0.85 * best, "seed {seed}: {found} of {best}");
    }
}
