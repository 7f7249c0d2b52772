//! Records of episodes and refreshes, as plain values.

use super::schedule::Moment;
use crate::env::StepStatus;
use crate::features::EmbeddingRefresh;
use crate::shaping::PotentialFit;
use crate::spectral::SpectrumRefresh;
use serde::{Deserialize, Serialize};

/// Sums over one episode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeRecord {
    /// Number of the episode, from 0.
    pub episode: u64,
    /// Environment steps taken up to and including this episode.
    pub step: u64,
    /// Steps of this episode.
    pub length: u64,
    /// Σ r, the plain return.
    pub plain_return: f64,
    /// Σ (r + F), what the agent learnt from.
    pub shaped_return: f64,
    /// Σ δ², the squared errors of the agent's predictions; 0 for agents that make none.
    pub td_squares: f64,
    /// Terminated or truncated.
    pub status: StepStatus,
    /// States known at its end.
    pub nodes: usize,
    /// Undirected edges known at its end.
    pub edges: usize,
}

/// One refresh of the spectrum, of the potential, or of both.
#[derive(Clone, Debug)]
pub struct RefreshRecord {
    /// Environment steps taken before it.
    pub step: u64,
    /// States known.
    pub nodes: usize,
    /// Undirected edges known.
    pub edges: usize,
    /// What the eigensolver did, if the spectrum was refreshed.
    pub spectrum: Option<SpectrumRefresh>,
    /// What the random walks did, if they were drawn.
    pub embedding: Option<EmbeddingRefresh>,
    /// What the fit did, if the potential was fitted. Its `values` are moved into the pipeline's table.
    pub fit: Option<PotentialFit>,
    /// Wall time of the features, in seconds; for the log only.
    pub spectrum_seconds: f64,
    /// Wall time of the fit, in seconds; for the log only.
    pub fit_seconds: f64,
}

impl RefreshRecord {
    /// Nothing done yet.
    pub(super) fn at(now: Moment) -> Self {
        Self {
            step: now.step,
            nodes: now.nodes,
            edges: now.edges,
            spectrum: None,
            embedding: None,
            fit: None,
            spectrum_seconds: 0.0,
            fit_seconds: 0.0,
        }
    }

    /// Whether features were refreshed, from whichever source.
    pub fn has_features(&self) -> bool {
        self.spectrum.is_some() || self.embedding.is_some()
    }
}
