//! What a run amounts to: the numbers that every report prints.

use serde::{Deserialize, Serialize};

/// The results of one seed. Equal runs have equal results, bit for bit: no clock is read for them.
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

/// How long one seed took.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SeedTiming {
    /// Master seed.
    pub seed: u64,
    /// Seconds from the first step to the last file.
    pub wall_seconds: f64,
    /// Environment steps ÷ `wall_seconds`, or ÷ a nanosecond if no clock ticked.
    pub steps_per_second: f64,
}

/// `summary.json`: everything but `timing` is the same for equal runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Name of the scenario.
    pub scenario: String,
    /// Results by seed, ascending.
    pub seeds: Vec<SeedResult>,
    /// What the clock said.
    pub timing: Timing,
}

/// The readings of clocks.
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

/// What `run --json` prints: one seed's results and timing side by side.
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

/// Mean of the last tenth of `steps`, at least 20 of them (all, if there are fewer); 0 for none.
pub fn final_mean_steps(steps: &[u32]) -> f64 {
    let last = last_tenth(steps);
    let sum: u64 = last.iter().map(|&s| u64::from(s)).sum();
    sum as f64 / last.len().max(1) as f64
}

/// The same of the episodes' returns.
pub fn final_mean_return(returns: &[f64]) -> f64 {
    let last = last_tenth(returns);
    last.iter().sum::<f64>() / last.len().max(1) as f64
}

/// Of something that was noted for each episode, the last tenth, at least 20.
fn last_tenth<T>(noted: &[T]) -> &[T] {
    let window = (noted.len() / 10).max(20).min(noted.len());
    &noted[noted.len() - window..]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn final_mean_takes_the_last_tenth_but_at_least_twenty() {
        let steps: Vec<u32> = (0..1000).collect();
        assert_eq!(
            final_mean_steps(&steps),
            (900..1000).sum::<u32>() as f64 / 100.0
        );
        assert_eq!(
            final_mean_steps(&steps[..30]),
            (10..30).sum::<u32>() as f64 / 20.0
        );
        assert_eq!(final_mean_steps(&[4, 6]), 5.0);
        assert_eq!(final_mean_steps(&[]), 0.0);
        let returns: Vec<f64> = steps.iter().map(|&s| -f64::from(s)).collect();
        for n in [1000, 30, 2, 1] {
            assert_eq!(
                final_mean_return(&returns[..n]),
                -final_mean_steps(&steps[..n])
            );
        }
        assert_eq!(final_mean_return(&[]), 0.0);
    }

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
            let timing = SeedTiming {
                seed,
                wall_seconds: 1.0,
                steps_per_second: 1.0,
            };
            summary.put(result, timing);
        }
        let seeds: Vec<u64> = summary.seeds.iter().map(|s| s.seed).collect();
        assert_eq!(seeds, [1, 3]);
        assert_eq!(summary.finished(3).unwrap().0.steps, 5);
        assert!(summary.finished(2).is_none());
    }
}
