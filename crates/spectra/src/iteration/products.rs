//! The lowest pairs from products with L alone: where its factor would not fit in memory, or takes
//! more work than the products.
//!
//! Filtered subspace iteration as in [`super::subspace`], with a polynomial in L in place of one in
//! (L + σI)⁻¹. On graphs that any node reaches from any other in a few steps (random graphs, small worlds) the factor
//! fills up, while λ_k is so far from 0 that a hundred products suffice; on grids and mazes it is the other way round.

use super::chebyshev::ChebyshevFilter;
use super::gain_history::{MARGIN, RAISE};
use super::null_space::NullSpace;
use super::subspace::{
    Goal, INDEPENDENT, Outcome, Pairs, Patience, Plan, randomize, refill, refined,
};
use crate::SpectralError;
use crate::block::RowBlock;
use crate::cholesky::PermutedLaplacian;
use rand_chacha::ChaCha8Rng;

/// Part of the usual need that the first filter aims at: needs differ tenfold from one update to the next,
/// and a short second filter now and then costs less than a long first one every time.
const AIM: f64 = 0.25;

/// Least gain of a first filter: what it takes to find a mode that growth has brought in.
const LEAST_GAIN: f64 = 10.0;

/// L off its null space, in elimination order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Products<'a> {
    pub(crate) laplacian: &'a PermutedLaplacian,
    pub(crate) null_space: &'a NullSpace,
}

impl Products<'_> {
    /// Turns the start block `x` into Ritz vectors, by `plan` or, where there is none, from random
    /// columns. `z` is scratch of the same shape.
    pub(crate) fn iterate(
        &self,
        (x, z): (&mut RowBlock, &mut RowBlock),
        goal: &Goal,
        plan: Option<&Plan>,
        rng: &mut ChaCha8Rng,
    ) -> Result<Outcome, SpectralError> {
        let mut applications = 0;
        let mut filter = match plan {
            Some(plan) => first_filter(plan, goal.norm),
            None => {
                randomize(x, 0, rng);
                self.null_space.project_out(x, goal.threads);
                applications += x.width();
                next_filter(&refined(self.laplacian, x, z, goal)?.0, goal, MARGIN)
            }
        };
        let wanted = plan.map_or(f64::INFINITY, |p| p.wanted);
        let first_gain = filter.gain(wanted.min(filter.cut())).max(1.0);
        let mut gain_needed = None;
        let mut patience = Patience::default();
        for rounds in 1.. {
            filter.apply(self.laplacian, x, z, goal.threads);
            self.null_space.project_out(x, goal.threads);
            let (mut pairs, independence) = refined(self.laplacian, x, z, goal)?;
            applications += (filter.products() + 1) * x.width();
            let gain_needed = *gain_needed.get_or_insert(first_gain * pairs.assessment.excess);
            let hopeless = rounds > goal.max_restarts || patience.is_lost(pairs.assessment.excess);
            let last = hopeless || pairs.assessment.converged == goal.wanted;
            if last && independence < INDEPENDENT {
                pairs = refined(self.laplacian, x, z, goal)?.0;
                applications += x.width();
            }
            if hopeless || pairs.assessment.converged == goal.wanted {
                return Ok(Outcome {
                    values: pairs.values,
                    residuals: pairs.residuals,
                    assessment: pairs.assessment,
                    rounds,
                    applications,
                    solves: 0,
                    gain_needed,
                });
            }
            refill(self.null_space, x, &pairs.values, (rng, goal.threads));
            filter = next_filter(&pairs, goal, MARGIN * RAISE.powi(rounds.min(4) as i32 - 1));
        }
        unreachable!("the loop over rounds has no end of its own")
    }
}

/// The filter for an update that begins with earlier vectors.
pub(crate) fn first_filter(plan: &Plan, norm: f64) -> ChebyshevFilter {
    let gain = (AIM * plan.gains.usual()).max(LEAST_GAIN);
    ChebyshevFilter::with_gain((gain, plan.wanted), plan.cut, norm)
}

/// The filter for what is still missing.
fn next_filter(pairs: &Pairs, goal: &Goal, margin: f64) -> ChebyshevFilter {
    let gain = margin * pairs.assessment.excess;
    let wanted = pairs.values[goal.wanted - 1];
    ChebyshevFilter::with_gain((gain, wanted), pairs.assessment.cut, goal.norm)
}
