//! Hop distance: h_i = 1 + min_{j ∈ succ(i)} h_j, h_g = D_g. What a planner knows that ignores step costs and
//! probabilities; under slip the diffusions are better guides, because they average over where a move may end.

use super::absorbing_chain::AbsorbingChain;
use super::fit_context::{FitContext, GraphPotential};
use super::{PotentialFit, ShapingError};
use serde::{Deserialize, Serialize};

/// The `hops` potential.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HopsPotential {
    /// Range of φ ÷ cost of the longest known way.
    pub scale_factor: f64,
}

impl GraphPotential for HopsPotential {
    fn fit_in(&mut self, context: &FitContext<'_>) -> Result<PotentialFit, ShapingError> {
        let hops = hop_distances(&context.problem.chain, context.problem.forgone());
        PotentialFit::checked(context.problem.potential(&hops, self.scale_factor))
    }
}

/// h by position, from `terminal` on goals. Sweeps in the chain's order until nothing changes: one and a check where
/// all steps cost the same, because the order is then that of h.
fn hop_distances(chain: &AbsorbingChain, terminal: &[f64]) -> Vec<f64> {
    let mut hops = terminal.to_vec();
    hops.resize(chain.len(), f64::INFINITY);
    loop {
        let mut changed = false;
        for i in chain.num_goals()..chain.len() {
            let next = chain.columns_of(i).iter().map(|&j| hops[j as usize]);
            let through = 1.0 + next.fold(f64::INFINITY, f64::min);
            changed |= through < hops[i];
            hops[i] = hops[i].min(through);
        }
        if !changed {
            return hops;
        }
    }
}
