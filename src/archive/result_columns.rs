//! The columns that tables of trials share.

use super::comparison::TrialResult;
use serde::Serialize;

/// What came of a trial, from what would have been best on; whose trial it is stands before it.
#[derive(Serialize)]
pub(super) struct ResultColumns {
    optimal_steps: f64,
    final_mean_steps: f64,
    optimal_return: f64,
    final_return: f64,
    final_ratio: f64,
    greedy_return: Option<f64>,
    greedy_return_unadvised: Option<f64>,
    failed: Option<bool>,
    failed_unadvised: Option<bool>,
    first_goal_step: Option<u64>,
    episodes_to_1_5x: Option<u64>,
    steps_to_1_5x: Option<u64>,
    episodes_to_1_1x: Option<u64>,
    steps_to_1_1x: Option<u64>,
    nodes: usize,
    edges: usize,
    spectrum_refreshes: usize,
    gcn_fits: usize,
    gcn_epochs: usize,
    spurious_maxima: Option<usize>,
}

impl From<&TrialResult> for ResultColumns {
    fn from(result: &TrialResult) -> Self {
        Self {
            optimal_steps: result.optimal_steps,
            final_mean_steps: result.final_mean_steps,
            optimal_return: result.optimal_return,
            final_return: result.final_return,
            final_ratio: result.final_ratio,
            greedy_return: result.greedy_return,
            greedy_return_unadvised: result.greedy_return_unadvised,
            failed: result.failed,
            failed_unadvised: result.failed_unadvised,
            first_goal_step: result.first_goal_step,
            episodes_to_1_5x: result.within_1_5x.map(|a| a.episodes),
            steps_to_1_5x: result.within_1_5x.map(|a| a.steps),
            episodes_to_1_1x: result.within_1_1x.map(|a| a.episodes),
            steps_to_1_1x: result.within_1_1x.map(|a| a.steps),
            nodes: result.nodes,
            edges: result.edges,
            spectrum_refreshes: result.spectrum_refreshes,
            gcn_fits: result.gcn_fits,
            gcn_epochs: result.gcn_epochs,
            spurious_maxima: result.spurious_maxima,
        }
    }
}
