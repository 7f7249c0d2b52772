//! One search for the lowest pairs by shift-and-invert: start, iterate, certify.

use super::assess::{Assessment, assess};
use super::certify::{Evidence, ORTHOGONAL};
use super::gain_history::{GainHistory, round_cost};
use super::null_space::NullSpace;
use super::products::Products;
use super::shift_invert::ShiftInvert;
use super::start::{Grown, start_block};
use super::subspace::{Goal, Outcome, Plan, inverse_power, iterate, overlaps, randomize};
use super::warm_start::WarmStart;
use crate::block::RowBlock;
use crate::cholesky::{CholeskyFactor, EliminationOrder, Inertia, PermutedLaplacian};
use crate::{Laplacian, SpectralError, SpectralParams, SymmetricOperator};
use rand_chacha::ChaCha8Rng;

/// Shift of a cold start, relative to the bound of ‖L‖: only keeps the matrix positive definite.
const COLD_SHIFT: f64 = 1e-8;

/// Shift of a warm start, relative to λ_k: a larger one evens out the filter's gains, so that more
/// solves go between two Rayleigh–Ritz steps; a smaller one gains more per solve. Measured on grids,
/// rooms and mazes to 1e5 nodes: 0.05 to 0.2 are within 3 % of each other, 0.4 costs 8 % more.
const WARM_SHIFT: f64 = 0.1;

/// Least shift, relative to the bound of ‖L‖.
const LEAST_SHIFT: f64 = 1e-13;

/// Solves of a cold start before its first look at the eigenvalues. Measured on grids, rooms and mazes of
/// 1e5 nodes: 1 leaves the guesses so poor that two more solves follow, 3 and 4 gain nothing.
const COLD_STEPS: usize = 2;

/// Reduction of residuals asked of the first filter behind a cold start or a repair.
const COLD_GAIN: f64 = 100.0;
const REPAIR_GAIN: f64 = 1e4;

/// Searches after an inertia count that found more eigenvalues than settled pairs.
const MOST_REPAIRS: usize = 3;

/// Columns beyond the pairs that a repair asks for.
const LEAST_GUARDS: usize = 2;

/// Columns, and numbers in all (0.8 GB), up to which a block is widened that has not come to the end of
/// a cluster.
const MOST_COLUMNS: usize = 512;
const MOST_NUMBERS: usize = 100_000_000;

/// The problem in elimination order, and what is asked.
pub(crate) struct Search<'a> {
    pub(crate) laplacian: &'a Laplacian<'a>,
    pub(crate) order: &'a EliminationOrder,
    pub(crate) null_space: &'a NullSpace,
    pub(crate) permuted: &'a PermutedLaplacian,
    pub(crate) params: &'a SpectralParams,
    /// Pairs wanted besides the null vectors; at least 1.
    pub(crate) wanted: usize,
    /// Columns of the block.
    pub(crate) width: usize,
    /// Numbers in the factor; 0 without one.
    pub(crate) factor_entries: usize,
}

/// Graphs up to this size are always proven complete by an inertia count, which costs a millisecond
/// there.
pub(crate) const PROOF_LIMIT: usize = 1500;

/// Result of a search; the vectors are in its block.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) outcome: Outcome,
    pub(crate) certified: Option<bool>,
    pub(crate) repaired: usize,
    /// Memory for another block.
    pub(crate) spare: RowBlock,
}

/// Beginning of a search: the vectors of the last update, and what they let expect.
#[derive(Debug)]
pub(crate) struct Start {
    pub(crate) vectors: WarmStart,
    pub(crate) plan: Plan,
}

impl Search<'_> {
    /// Fills `x` with Ritz vectors, from those of the last update if there are any, whose memory is then used
    /// for others.
    pub(crate) fn run(
        &self,
        start: Option<Start>,
        factor: &mut CholeskyFactor,
        x: &mut RowBlock,
        rng: &mut ChaCha8Rng,
    ) -> Result<Found, SpectralError> {
        let mut z = RowBlock::default();
        let (plan, sigma, cold_solves) = match start {
            Some(Start { vectors, plan }) => {
                let sigma = self.factorize(factor, WARM_SHIFT * plan.wanted)?;
                start_block(&vectors, self.grown(), self.width, x, rng);
                z = vectors.block;
                (plan, sigma, 0)
            }
            None => self.start_cold(factor, (x, &mut z), rng)?,
        };
        let op = self.operator(factor, sigma);
        let mut outcome = iterate(&op, x, &mut z, &self.goal(), &plan, rng)?;
        outcome.solves += cold_solves;
        outcome.applications += cold_solves / COLD_STEPS;
        while outcome.assessment.converged < self.wanted && self.may_widen(&outcome, x.width()) {
            widen(x, rng);
            op.project(x);
            let again = iterate(
                &op,
                x,
                &mut z,
                &self.goal(),
                &self.plan_after(&outcome),
                rng,
            )?;
            outcome = again.after(&outcome);
        }
        let mut found = Found {
            outcome,
            certified: None,
            repaired: 0,
            spare: RowBlock::default(),
        };
        // Of a component that is new the warm start holds one random combination at most; of any mode
        // that is new nothing, if rounding has swallowed the random column.
        let is_small = self.laplacian.dim() <= PROOF_LIMIT;
        let lost_random = found.outcome.values.iter().any(|v| v.is_infinite());
        if self.params.certify || self.null_space.dim() > 1 || is_small || lost_random {
            self.certify(&mut found, &op, (x, &mut z), rng)?;
        }
        found.spare = z;
        Ok(found)
    }

    /// The same by products with L alone. Nothing is certified.
    pub(crate) fn run_without_factor(
        &self,
        start: Option<Start>,
        x: &mut RowBlock,
        rng: &mut ChaCha8Rng,
    ) -> Result<Found, SpectralError> {
        match &start {
            Some(start) => start_block(&start.vectors, self.grown(), self.width, x, rng),
            None => x.reshape(self.laplacian.dim(), self.width),
        }
        let (mut z, plan) = match start {
            Some(Start { vectors, plan }) => (vectors.block, Some(plan)),
            None => (RowBlock::default(), None),
        };
        let products = Products {
            laplacian: self.permuted,
            null_space: self.null_space,
        };
        let outcome = products.iterate((x, &mut z), &self.goal(), plan.as_ref(), rng)?;
        Ok(Found {
            outcome,
            certified: None,
            repaired: 0,
            spare: z,
        })
    }

    fn grown(&self) -> Grown<'_> {
        Grown {
            laplacian: self.laplacian,
            order: self.order,
            null_space: self.null_space,
            threads: self.params.threads,
        }
    }

    /// Whether more columns could help: the guards do not reach beyond the cluster of λ_k, and rounds
    /// were not what was lacking.
    fn may_widen(&self, outcome: &Outcome, width: usize) -> bool {
        let beyond = outcome.values[self.wanted - 1] * (1.0 + self.params.tol);
        let in_cluster = outcome.assessment.eta <= beyond;
        self.can_widen(width) && in_cluster && outcome.rounds <= self.params.max_restarts
    }

    /// Whether a block of `width` columns may be doubled.
    fn can_widen(&self, width: usize) -> bool {
        let n = self.laplacian.dim();
        2 * width <= MOST_COLUMNS && 8 * width <= n && 2 * width * n <= MOST_NUMBERS
    }

    fn plan_after(&self, outcome: &Outcome) -> Plan {
        Plan {
            cut: outcome.assessment.cut,
            wanted: outcome.values[self.wanted - 1],
            lowest: outcome.values[0],
            gains: GainHistory::of(REPAIR_GAIN),
        }
    }

    fn operator<'b>(&'b self, factor: &'b CholeskyFactor, sigma: f64) -> ShiftInvert<'b> {
        ShiftInvert {
            laplacian: self.permuted,
            factor,
            null_space: self.null_space,
            sigma,
            threads: self.params.threads,
        }
    }

    fn goal(&self) -> Goal {
        Goal {
            wanted: self.wanted,
            tol: self.params.tol,
            norm: self.laplacian.norm_bound(),
            max_restarts: self.params.max_restarts,
            threads: self.params.threads,
            round_cost: round_cost(self.laplacian.dim(), self.factor_entries),
        }
    }

    /// Factors L + σI, with a larger σ where rounding made the wished one indefinite.
    fn factorize(&self, factor: &mut CholeskyFactor, wish: f64) -> Result<f64, SpectralError> {
        let norm = self.laplacian.norm_bound();
        let mut sigma = wish.max(LEAST_SHIFT * norm);
        while factor.factorize(self.permuted, sigma).is_err() {
            sigma *= 10.0;
            if sigma.is_nan() || sigma >= norm {
                return Err(SpectralError::NotFinite);
            }
        }
        Ok(sigma)
    }

    /// Starts from random columns and a few steps of the inverse power method: the plan, σ, and columns
    /// solved so far.
    fn start_cold(
        &self,
        factor: &mut CholeskyFactor,
        (x, z): (&mut RowBlock, &mut RowBlock),
        rng: &mut ChaCha8Rng,
    ) -> Result<(Plan, f64, usize), SpectralError> {
        let mut sigma = self.factorize(factor, COLD_SHIFT * self.laplacian.norm_bound())?;
        x.reshape(self.laplacian.dim(), self.width);
        randomize(x, 0, rng);
        self.null_space.project_out(x, self.params.threads);
        let op = self.operator(factor, sigma);
        let values = inverse_power(&op, x, z, COLD_STEPS, &self.goal())?;
        let plan = Plan {
            cut: values[self.width - 1],
            wanted: values[self.wanted - 1],
            lowest: values[0],
            gains: GainHistory::of(COLD_GAIN),
        };
        if sigma > plan.wanted {
            sigma = self.factorize(factor, WARM_SHIFT * plan.wanted)?;
        }
        Ok((plan, sigma, COLD_STEPS * self.width))
    }

    /// Counts eigenvalues. Where more lie below μ than pairs have settled there, searches on until as many
    /// have: from random guards, if some were missed.
    fn certify(
        &self,
        found: &mut Found,
        op: &ShiftInvert<'_>,
        (x, z): (&mut RowBlock, &mut RowBlock),
        rng: &mut ChaCha8Rng,
    ) -> Result<(), SpectralError> {
        let nulls = self.null_space.dim();
        let mut goal = self.goal();
        for repair in 0..=MOST_REPAIRS {
            let evidence = self.evidence(&found.outcome);
            let place = evidence.place(self.wanted, &found.outcome.assessment);
            let Some(mu) = place else { return Ok(()) };
            let Some(count) = op.factor.count_below(self.permuted, mu) else {
                return Ok(());
            };
            if self.is_proof(found, &count, x) {
                found.certified = Some(true);
                return Ok(());
            }
            let below = count.negative.saturating_sub(nulls);
            let missing = below.saturating_sub(evidence.known_below(mu));
            found.certified = (missing > 0).then_some(false);
            if below < self.wanted || repair == MOST_REPAIRS {
                return Ok(());
            }
            while below + LEAST_GUARDS > x.width() {
                if !self.can_widen(x.width()) {
                    return Ok(());
                }
                widen(x, rng);
            }
            found.repaired += missing;
            if missing > 0 {
                randomize(x, self.wanted, rng);
            }
            op.project(x);
            goal.wanted = goal.wanted.max(below);
            let before = &found.outcome;
            let mut again = iterate(op, x, z, &goal, &self.plan_after(before), rng)?.after(before);
            again.assessment = self.assessed(&again);
            found.outcome = again;
            // The count stands, whatever has been found since.
            if self.is_proof(found, &count, x) {
                found.certified = Some(true);
                return Ok(());
            }
        }
        Ok(())
    }

    fn evidence<'b>(&self, outcome: &'b Outcome) -> Evidence<'b> {
        let rounding = self.permuted.rounding() * self.laplacian.norm_bound();
        Evidence::new(outcome, self.params.tol, rounding)
    }

    /// Whether `count` proves the pairs in `x` complete. Null vectors are counted apart, which takes Ritz vectors
    /// orthogonal to them: every filter ends with that projection, and the step after it, which drops directions
    /// held to less than 1e-13, can spoil it to 1e-9 at most.
    fn is_proof(&self, found: &Found, count: &Inertia, x: &RowBlock) -> bool {
        let nulls = self.null_space.dim();
        self.evidence(&found.outcome)
            .is_complete(self.wanted, nulls, count)
            && overlaps(x, count.negative - nulls, self.params.threads).norm_l2() <= ORTHOGONAL
    }

    /// What the pairs of a search for more than were asked for amount to.
    fn assessed(&self, outcome: &Outcome) -> Assessment {
        let norm = self.laplacian.norm_bound();
        let (values, residuals) = (&outcome.values, &outcome.residuals);
        assess(values, residuals, self.wanted, self.params.tol, norm)
    }
}

/// Doubles the columns, the new ones random.
fn widen(x: &mut RowBlock, rng: &mut ChaCha8Rng) {
    let width = x.width();
    let mut wide = RowBlock::default();
    wide.reshape(x.rows(), 2 * width);
    for i in 0..x.rows() {
        wide.row_mut(i)[..width].copy_from_slice(x.row(i));
    }
    randomize(&mut wide, width, rng);
    *x = wide;
}
