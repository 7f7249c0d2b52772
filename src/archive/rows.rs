//! Rows of a seed's tables.

use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Row of `episodes.csv`. In long runs that are read back and on a live page it may stand for several episodes in a row: sums
/// of what is added up, and the rest as it was at the end of the last one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeRow {
    /// How many episodes it stands for; 1 in files.
    #[serde(skip, default = "one")]
    pub episodes: usize,
    /// Number of the episode, from 0.
    pub episode: u64,
    /// Environment steps up to its end.
    pub step: u64,
    /// Its steps.
    pub length: u64,
    /// Σ r.
    #[serde(rename = "return")]
    pub plain_return: f64,
    /// Σ (r + F).
    pub shaped_return: f64,
    /// `terminated` or `truncated`.
    pub status: Cow<'static, str>,
    /// ρ of the run so far.
    pub regret: f64,
    /// States known.
    pub nodes: usize,
    /// Undirected edges known.
    pub edges: usize,
}

fn one() -> usize {
    1
}

/// Row of `refreshes.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RefreshRow {
    /// Environment step.
    pub step: u64,
    /// States known.
    pub nodes: usize,
    /// Undirected edges known.
    pub edges: usize,
    /// Eigenpairs kept, if the spectrum was refreshed; so are all the numbers below down to `largest_eigenvalue`.
    pub pairs: Option<usize>,
    /// How many of them converged.
    pub converged: Option<usize>,
    /// Whether the eigensolver began from nothing.
    pub cold_start: Option<bool>,
    /// Products with the Laplacian.
    pub applications: Option<usize>,
    /// Solves with its factor.
    pub solves: Option<usize>,
    /// Largest ‖Lv − λv‖ relative to the largest eigenvalue kept.
    pub max_relative_residual: Option<f64>,
    /// λ_k.
    pub largest_eigenvalue: Option<f64>,
    /// Whether the potential was fitted.
    pub fitted: bool,
    /// Epochs of the network's training, if there was any.
    pub fit_epochs: Option<usize>,
    /// Its loss before.
    pub initial_loss: Option<f64>,
    /// Its loss after.
    pub loss: Option<f64>,
}

/// Row of `graph.csv`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct GraphRow {
    /// State number.
    pub from: u32,
    /// Action number.
    pub action: u16,
    /// State number.
    pub to: u32,
    /// How often it was seen.
    pub count: u32,
    /// Σ r over those times.
    pub reward_sum: f64,
    /// Whether an episode ended on arrival.
    pub terminal: bool,
}

/// Row of `policy.csv`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct PolicyRow {
    /// State number.
    pub state: u32,
    /// How often an action was taken here.
    pub visits: u64,
    /// The likeliest action while nothing is searched for; none where the agent has no opinion.
    pub greedy: Option<u16>,
}
