//! p(d|a): by which displacements an action really moves, pooled over all states.
//!
//! A table of outcomes per state knows little before every action was tried many times in it. Where actions do the same
//! everywhere, each try anywhere is a try of all of them.

use super::moves::Moves;
use crate::env::Action;
use serde::{Deserialize, Serialize};

/// Probabilities are kept this far from 0 and 1, for their logarithms.
const SMALLEST: f64 = 1e-3;

/// Pooled outcomes of every action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActionNoise {
    num_actions: usize,
    /// p(d|a), row-major by action; rows sum to 1.
    shares: Vec<f64>,
    /// ln p and ln (1 − p).
    logs: Vec<(f64, f64)>,
}

impl ActionNoise {
    /// A guess before anything was counted: mostly as meant, seldom the opposite.
    pub(super) fn prior(moves: &Moves) -> Self {
        Self::normalised(moves.num_actions(), Self::pseudo_counts(moves))
    }

    pub(super) fn pseudo_counts(moves: &Moves) -> Vec<f64> {
        let num_actions = moves.num_actions();
        let mut counts = vec![1.0; num_actions * num_actions];
        for a in 0..num_actions {
            counts[a * num_actions + moves.inverse[a]] = 0.25;
            counts[a * num_actions + a] = 4.0;
        }
        counts
    }

    /// Counts by action and displacement, row-major, as shares.
    pub(super) fn normalised(num_actions: usize, mut counts: Vec<f64>) -> Self {
        for row in counts.chunks_mut(num_actions) {
            let total: f64 = row.iter().sum();
            row.iter_mut().for_each(|count| *count /= total);
        }
        let bounded = |p: f64| p.clamp(SMALLEST, 1.0 - SMALLEST);
        let logs = |&p: &f64| (libm::log(bounded(p)), libm::log(1.0 - bounded(p)));
        Self {
            num_actions,
            logs: counts.iter().map(logs).collect(),
            shares: counts,
        }
    }

    /// p(d|a), where displacements are named after the actions that mean them.
    pub fn share(&self, action: Action, displacement: Action) -> f64 {
        self.shares[action.index() * self.num_actions + displacement.index()]
    }

    /// ln p(d|a) and ln (1 − p(d|a)).
    pub(super) fn logs(&self, action: Action, d: usize) -> (f64, f64) {
        self.logs[action.index() * self.num_actions + d]
    }
}
