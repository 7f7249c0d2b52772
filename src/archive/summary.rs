//! The summary of a run: `summary.json`.

use super::comparison::TrialTiming;
use serde::{Deserialize, Serialize};

/// Results of one seed. Equal runs have equal results, bit for bit: no clock is read for them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SeedResult {
    /// Master seed.
    pub seed: u64,
    /// Whether every episode was run; false after an interruption.
    pub finished: bool,
    /// Episodes run.
    pub episodes: usize,
    /// Environment steps taken.
    pub steps: u64,
    /// ρ(T) = T R* − Σ R_t in units of reward (eq. 15 of the source paper), with R* the best expected return.
    pub regret: f64,
    /// Mean length of an episode under the best policy.
    pub optimal_steps: f64,
    /// Mean length of the last tenth of the episodes, at least 20 of them; 0 before the first episode ends.
    pub final_mean_steps: f64,
    /// Mean return of an episode under the best policy; none if an earlier version made the folder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub optimal_return: Option<f64>,
    /// Mean return of the episodes of `final_mean_steps`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub final_return: Option<f64>,
    /// Episodes before the goals moved, if they did: what is optimal and what is final are then of the episodes since.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goals_moved_after: Option<usize>,
    /// The environment step, from 1, that first reached a goal; none if none did.
    pub first_goal_step: Option<u64>,
    /// States discovered.
    pub nodes: usize,
    /// Undirected edges discovered.
    pub edges: usize,
    /// How often the eigenvectors were brought up to date.
    pub spectrum_refreshes: usize,
    /// How often the potential's network was fitted.
    pub gcn_fits: usize,
}

/// Time that one seed took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SeedTiming {
    /// Master seed.
    pub seed: u64,
    /// Seconds from the first step to the last file.
    pub wall_seconds: f64,
    /// Environment steps ÷ `wall_seconds`, or ÷ a nanosecond if no clock ticked.
    pub steps_per_second: f64,
    /// Seconds in the eigensolver; 0 in summaries of versions that did not note it, as the two that follow.
    #[serde(default)]
    pub spectrum_seconds: f64,
    /// Seconds in fits of the potential.
    #[serde(default)]
    pub fit_seconds: f64,
    /// Seconds in everything else: environment, graph, exploration, learner, files.
    #[serde(default)]
    pub rest_seconds: f64,
}

impl SeedTiming {
    /// The time of `seed`, by what took it.
    pub fn new(seed: u64, timing: TrialTiming) -> Self {
        Self {
            seed,
            wall_seconds: timing.wall_seconds,
            steps_per_second: timing.steps_per_second,
            spectrum_seconds: timing.spectrum_seconds,
            fit_seconds: timing.fit_seconds,
            rest_seconds: timing.rest_seconds,
        }
    }
}

/// Contents of `summary.json`: everything but `timing` is the same for equal runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Name of the scenario.
    pub scenario: String,
    /// Results by seed, ascending.
    pub seeds: Vec<SeedResult>,
    /// What the clock said.
    pub timing: Timing,
}

/// Readings of clocks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// By seed, in the order of [`Summary::seeds`].
    pub seeds: Vec<SeedTiming>,
}

impl Summary {
    /// Adds a seed, or replaces what was known of it.
    pub fn put(&mut self, result: SeedResult, timing: SeedTiming) {
        self.seeds.retain(|s| s.seed != result.seed);
        self.timing.seeds.retain(|t| t.seed != timing.seed);
        let at = self.seeds.partition_point(|s| s.seed < result.seed);
        self.seeds.insert(at, result);
        let at = self.timing.seeds.partition_point(|t| t.seed < timing.seed);
        self.timing.seeds.insert(at, timing);
    }

    /// The finished result of `seed` and its timing.
    pub fn finished(&self, seed: u64) -> Option<(&SeedResult, &SeedTiming)> {
        let result = self.seeds.iter().find(|s| s.seed == seed && s.finished)?;
        let timing = self.timing.seeds.iter().find(|t| t.seed == seed)?;
        Some((result, timing))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_stay_sorted_and_unique() {
        let mut summary = Summary::default();
        for (seed, steps) in [(3, 1), (1, 2), (3, 5)] {
            let result = SeedResult {
                seed,
                finished: true,
                episodes: 1,
                steps,
                regret: 0.0,
                optimal_steps: 1.0,
                goals_moved_after: None,
                final_mean_steps: 1.0,
                optimal_return: Some(-1.0),
                final_return: Some(-1.0),
                first_goal_step: None,
                nodes: 1,
                edges: 0,
                spectrum_refreshes: 0,
                gcn_fits: 0,
            };
            summary.put(result, SeedTiming::new(seed, TrialTiming::default()));
        }
        let seeds: Vec<u64> = summary.seeds.iter().map(|s| s.seed).collect();
        assert_eq!(seeds, [1, 3]);
        assert_eq!(summary.finished(3).unwrap().0.steps, 5);
        assert!(summary.finished(2).is_none());
    }
}
