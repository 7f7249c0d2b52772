//! The lines of JSON about runs.

use super::summary::{SeedResult, SeedTiming};
use serde::Serialize;

/// Line that `run --json` prints: one seed's results and timing side by side.
#[derive(Clone, Debug, Serialize)]
pub struct RunLine<'a> {
    scenario: &'a str,
    seed: u64,
    episodes: usize,
    steps: u64,
    regret: f64,
    optimal_steps: f64,
    final_mean_steps: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    goals_moved_after: Option<usize>,
    first_goal_step: Option<u64>,
    nodes: usize,
    edges: usize,
    spectrum_refreshes: usize,
    gcn_fits: usize,
    wall_seconds: f64,
    steps_per_second: f64,
}

impl<'a> RunLine<'a> {
    /// Puts a seed's numbers into the order of the format.
    pub fn new(scenario: &'a str, result: &SeedResult, timing: &SeedTiming) -> Self {
        Self {
            scenario,
            seed: result.seed,
            episodes: result.episodes,
            steps: result.steps,
            regret: result.regret,
            optimal_steps: result.optimal_steps,
            final_mean_steps: result.final_mean_steps,
            goals_moved_after: result.goals_moved_after,
            first_goal_step: result.first_goal_step,
            nodes: result.nodes,
            edges: result.edges,
            spectrum_refreshes: result.spectrum_refreshes,
            gcn_fits: result.gcn_fits,
            wall_seconds: timing.wall_seconds,
            steps_per_second: timing.steps_per_second,
        }
    }
}

/// Line that `run --seeds A..B --json` prints.
#[derive(Clone, Debug, Serialize)]
pub struct RunLines<'a> {
    scenario: &'a str,
    seeds: Vec<RunLine<'a>>,
}

impl<'a> RunLines<'a> {
    /// Puts the seeds' numbers into the order of the format.
    pub fn new(
        scenario: &'a str,
        seeds: impl Iterator<Item = (&'a SeedResult, &'a SeedTiming)>,
    ) -> Self {
        Self {
            scenario,
            seeds: seeds
                .map(|(result, timing)| RunLine::new(scenario, result, timing))
                .collect(),
        }
    }
}
