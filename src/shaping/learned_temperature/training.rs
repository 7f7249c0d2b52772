//! One fit: a solve, and as many epochs as are worth it.

use super::objective::Objective;
use crate::gcn::{FitStatistics, GcnWorkspace, Propagation};
use crate::shaping::ShapingError;
use crate::shaping::network::Network;
use faer::MatRef;

/// Sweeps for the gradient of the first epoch, when there is none to start from, and of the others.
const FIRST_SWEEPS: usize = 40;
const SWEEPS_PER_EPOCH: usize = 4;

/// Every so many epochs the loss must have fallen by this share of it, or training ends: the labels are noisy, and what is left is their noise.
pub(super) const PATIENCE: usize = 10;
pub(super) const PROGRESS: f64 = 0.05;

/// The input of the network: T̂ and T̂X, the same in all epochs.
#[derive(Clone, Copy)]
pub(super) struct Inputs<'a> {
    pub propagation: &'a Propagation,
    pub tx: MatRef<'a, f64>,
}

/// How much training there may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// At most.
    pub epochs: usize,
    /// None at all unless the loss is above this.
    pub begin_above: f64,
    /// No more once the loss is down to this.
    pub end_at: f64,
}

/// Lowers `objective` by Adam's steps from where it has begun, at the network's output that `workspace` holds. The weights with the lowest loss seen are kept, as the objective keeps its temperatures:
/// an epoch too wide does not spoil what comes after.
///
/// # Errors
/// If the loss is not finite.
pub(super) fn train(
    network: &mut Network,
    inputs: Inputs<'_>,
    workspace: &mut GcnWorkspace,
    objective: &mut Objective<'_>,
    initial_loss: f64,
    effort: Effort,
) -> Result<FitStatistics, ShapingError> {
    let Inputs { propagation, tx } = inputs;
    let mut statistics = FitStatistics {
        epochs: 0,
        initial_loss,
        loss: initial_loss,
    };
    if initial_loss <= effort.begin_above {
        return Ok(statistics);
    }
    let mut best = network.gcn.clone();
    let mut gradient = network.gcn.parameters().zeros_like();
    let mut sweeps = FIRST_SWEEPS;
    let mut milestone = initial_loss;
    while statistics.epochs < effort.epochs && statistics.loss > effort.end_at {
        if statistics.epochs > 0 && statistics.epochs.is_multiple_of(PATIENCE) {
            if statistics.loss > (1.0 - PROGRESS) * milestone {
                break;
            }
            milestone = statistics.loss;
        }
        let upstream = objective.gradient(sweeps);
        network
            .gcn
            .backward_into(propagation, tx, workspace, upstream, &mut gradient);
        network.adam.step(&mut network.gcn, &gradient);
        let z = network.gcn.forward(propagation, tx, workspace);
        statistics.epochs += 1;
        let loss = objective.follow(z, statistics.epochs)?;
        if loss < statistics.loss {
            statistics.loss = loss;
            best.clone_from(&network.gcn);
        }
        sweeps = SWEEPS_PER_EPOCH;
    }
    network.gcn = best;
    Ok(statistics)
}
