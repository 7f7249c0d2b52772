//! From the trials of a point to its numbers.

use super::plan::PlannedPoint;
use crate::archive::{PointSetting, PointSummary, TrialRecord, TrialResult};
use crate::runner::compare::summarise::{
    mean_over, median_interval, median_moment, regret_interval, share, worst_seed,
};
use crate::statistics::median;

/// The summary of a point; `trials` must not be empty.
pub fn summarise(point: &PlannedPoint, trials: &[TrialRecord]) -> PointSummary {
    let moments = |part: fn(&TrialResult) -> Option<u64>| {
        let reached: Vec<Option<u64>> = trials.iter().map(|t| part(&t.result)).collect();
        median_moment(&reached)
    };
    let all = |part: fn(&TrialResult) -> f64| -> Vec<f64> {
        trials.iter().map(|t| part(&t.result)).collect()
    };
    let some = |part: fn(&TrialResult) -> Option<f64>| -> Vec<f64> {
        trials.iter().filter_map(|t| part(&t.result)).collect()
    };
    let settings = point.point.settings.iter();
    PointSummary {
        hash: point.hash.clone(),
        arm: point.point.arm.clone(),
        settings: settings
            .map(|(key, value)| PointSetting::new(key, value))
            .collect(),
        episodes: point.scenario.run.episodes,
        optimal_steps: mean_over(trials, |result| result.optimal_steps),
        optimal_return: mean_over(trials, |result| result.optimal_return),
        goals_moved_after: trials[0].result.goals_moved_after,
        regret: regret_interval(trials),
        first_goal_step: moments(|result| result.first_goal_step),
        episodes_to_1_5x: moments(|result| result.within_1_5x.map(|a| a.episodes)),
        steps_to_1_5x: moments(|result| result.within_1_5x.map(|a| a.steps)),
        episodes_to_1_1x: moments(|result| result.within_1_1x.map(|a| a.episodes)),
        steps_to_1_1x: moments(|result| result.within_1_1x.map(|a| a.steps)),
        final_return: median_interval(&all(|result| result.final_return)),
        final_ratio: median(&all(|result| result.final_ratio)),
        greedy_return: median_interval(&some(|result| result.greedy_return)),
        greedy_return_unadvised: median_interval(&some(|result| result.greedy_return_unadvised)),
        failures: share(trials, |result| result.failed),
        failures_unadvised: share(trials, |result| result.failed_unadvised),
        worst_seed: worst_seed(trials),
        gcn_epochs: median(&all(|result| result.gcn_epochs as f64)),
        spurious_maxima: trials.iter().filter_map(|t| t.result.spurious_maxima).max(),
    }
}
