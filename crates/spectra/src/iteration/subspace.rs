//! Filtered subspace iteration: from a start block to the lowest eigenpairs.
//!
//! Each round filters the block, takes the Rayleigh–Ritz step, measures the true residuals, and
//! plans the next filter from what is still missing. The block is wider than the pairs wanted: its
//! *guard* columns widen the gap that the filter works against, and the last of them starts at
//! random, which is what finds an eigenvector that growth brought in and the old block lacks.

use super::assess::{Assessment, assess};
use super::filter::Filter;
use super::gain_history::{GainHistory, MARGIN, RAISE};
use super::null_space::NullSpace;
use super::shift_invert::ShiftInvert;
use crate::SpectralError;
use crate::block::{Ritz, RowBlock, gram, gram_and_product, ritz, rotate};
use crate::cholesky::PermutedLaplacian;
use faer::Mat;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Below this independence of the basis the final vectors are orthonormalised once more, so that they
/// are orthonormal to about 1e-12.
pub(crate) const INDEPENDENT: f64 = 1e-4;

/// Largest loss of orthogonality, relative to the tolerance, that orthonormalising mends without a
/// change of residuals worth measuring; beyond it the Rayleigh–Ritz step is repeated.
const SLIGHT: f64 = 1e-4;

/// Factors t in the first filter: a start block is full of modes far beyond the cut.
const START_DAMPING: usize = 2;

/// Share of low modes in the other columns of a start block.
const START_ADMIXTURE: f64 = 0.03;

/// Share that rounding gives them in the course of a filter, at least.
const LEAST_ADMIXTURE: f64 = 1e-8;

/// Rounds without a halving of the excess after which nothing more is to be hoped for.
const PATIENCE: usize = 5;

/// What the first round starts from.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    /// Guess of the first eigenvalue that the block does not hold.
    pub(crate) cut: f64,
    /// Guesses of λ_k and of the lowest eigenvalue that is not 0.
    pub(crate) wanted: f64,
    pub(crate) lowest: f64,
    /// Reductions of residuals that may be necessary.
    pub(crate) gains: GainHistory,
}

/// What is asked of an iteration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// Pairs wanted besides the null vectors.
    pub(crate) wanted: usize,
    pub(crate) tol: f64,
    /// Bound on ‖L‖.
    pub(crate) norm: f64,
    pub(crate) max_restarts: usize,
    pub(crate) threads: usize,
    /// What a round costs besides its filter, in block solves.
    pub(crate) round_cost: f64,
}

/// The Ritz pairs that a block holds after an iteration, and what they cost.
#[derive(Debug)]
pub(crate) struct Outcome {
    /// Ritz values of all columns, ascending; infinite for columns that hold nothing.
    pub(crate) values: Vec<f64>,
    pub(crate) residuals: Vec<f64>,
    pub(crate) assessment: Assessment,
    pub(crate) rounds: usize,
    /// Columns multiplied by L and columns solved.
    pub(crate) applications: usize,
    pub(crate) solves: usize,
    /// The reduction of residuals that would just have sufficed in the first round.
    pub(crate) gain_needed: f64,
}

impl Outcome {
    /// The same pairs, with the cost of an earlier iteration added.
    pub(crate) fn after(mut self, earlier: &Outcome) -> Self {
        self.rounds += earlier.rounds;
        self.applications += earlier.applications;
        self.solves += earlier.solves;
        self.gain_needed = earlier.gain_needed;
        self
    }
}

/// Turns the start block `x` into Ritz vectors. `z` is scratch of the same shape.
pub(crate) fn iterate(
    op: &ShiftInvert<'_>,
    x: &mut RowBlock,
    z: &mut RowBlock,
    goal: &Goal,
    plan: &Plan,
    rng: &mut ChaCha8Rng,
) -> Result<Outcome, SpectralError> {
    let mut filter = first_filter(plan, goal.round_cost, op.sigma);
    let first_gain = filter.gain(plan.wanted).max(1.0);
    let mut patience = Patience::default();
    let (mut applications, mut solves) = (0, 0);
    let mut gain_needed = None;
    for rounds in 1.. {
        filter.apply(op, x, z);
        solves += filter.solves() * x.width();
        op.project(x);
        let (mut pairs, independence) = rayleigh_ritz(op, x, z, goal)?;
        applications += x.width();
        let hopeless = rounds > goal.max_restarts || patience.is_lost(pairs.assessment.excess);
        let last = hopeless || pairs.assessment.converged == goal.wanted;
        if last && independence < INDEPENDENT {
            let overlap = overlaps(x, goal.wanted, op.threads);
            if overlap.norm_max() <= SLIGHT * goal.tol {
                rotate(x, &mended(&overlap, x.width()), op.threads);
            } else {
                pairs = refined(op.laplacian, x, z, goal)?.0;
                applications += 2 * x.width();
            }
        }
        let gain_needed = *gain_needed.get_or_insert(first_gain * pairs.assessment.excess);
        if hopeless || pairs.assessment.converged == goal.wanted {
            return Ok(Outcome {
                values: pairs.values,
                residuals: pairs.residuals,
                assessment: pairs.assessment,
                rounds,
                applications,
                solves,
                gain_needed,
            });
        }
        refill(op.null_space, x, &pairs.values, (rng, goal.threads));
        let margin = MARGIN * RAISE.powi(rounds.min(4) as i32 - 1);
        filter = next_filter(&pairs, goal.wanted, margin, op.sigma);
    }
    unreachable!("the loop over rounds has no end of its own")
}

/// x ← M⁻ᵖ x, p = `steps` ≥ 1, rotated to Ritz vectors; their values, ascending, one per column.
pub(crate) fn inverse_power(
    op: &ShiftInvert<'_>,
    x: &mut RowBlock,
    z: &mut RowBlock,
    steps: usize,
    goal: &Goal,
) -> Result<Vec<f64>, SpectralError> {
    for _ in 0..steps {
        z.copy_from(x, op.threads);
        op.solve(x);
        op.project(x);
    }
    Ok(rayleigh_ritz(op, x, z, goal)?.0.values)
}

/// Ritz values of all columns, their residuals, and what they amount to.
pub(crate) struct Pairs {
    pub(crate) values: Vec<f64>,
    pub(crate) residuals: Vec<f64>,
    pub(crate) assessment: Assessment,
}

/// Notices when rounds no longer help.
pub(crate) struct Patience {
    best: f64,
    left: usize,
}

impl Default for Patience {
    fn default() -> Self {
        Self {
            best: f64::INFINITY,
            left: PATIENCE,
        }
    }
}

impl Patience {
    pub(crate) fn is_lost(&mut self, excess: f64) -> bool {
        if excess < 0.5 * self.best {
            (self.best, self.left) = (excess, PATIENCE);
        } else {
            self.left -= 1;
        }
        self.left == 0
    }
}

fn first_filter(plan: &Plan, round_cost: f64, sigma: f64) -> Filter {
    let admixture = [(plan.lowest, START_ADMIXTURE)];
    let family = Filter::family(&admixture, plan.cut, sigma, START_DAMPING);
    plan.gains.cheapest(&family, plan.wanted, round_cost)
}

/// The filter for what is still missing. After a Rayleigh–Ritz step a mode is part of other columns
/// only as far as its own column is off: by about residual ÷ gap.
fn next_filter(pairs: &Pairs, wanted: usize, margin: f64, sigma: f64) -> Filter {
    let cut = pairs.assessment.cut;
    let admixtures: Vec<(f64, f64)> = pairs
        .values
        .iter()
        .zip(&pairs.residuals)
        .filter(|&(&theta, _)| theta < cut)
        .map(|(&theta, &r)| (theta, (r / (cut - theta)).max(LEAST_ADMIXTURE)))
        .collect();
    let gain = margin * pairs.assessment.excess;
    Filter::with_gain((gain, pairs.values[wanted - 1]), &admixtures, cut, sigma)
}

/// Rotates `x`, for which x = M⁻¹ z before projection, to Ritz vectors; returns them and the
/// independence of the basis.
fn rayleigh_ritz(
    op: &ShiftInvert<'_>,
    x: &mut RowBlock,
    z: &mut RowBlock,
    goal: &Goal,
) -> Result<(Pairs, f64), SpectralError> {
    let (gram, product) = gram_and_product(x, z, op.threads);
    if !gram.is_all_finite() {
        return Err(SpectralError::NotFinite);
    }
    // XᵀLX without a product by L: LX = Z − σX, and the projection does not change it.
    let projected = product - faer::Scale(op.sigma) * &gram;
    let ritz = ritz(&gram, &projected)?;
    rotate(x, &ritz.coefficients, op.threads);
    Ok((measured(op.laplacian, x, &ritz, goal), ritz.independence))
}

/// The Rayleigh–Ritz step with a true product by L, from any basis `x`.
pub(crate) fn refined(
    laplacian: &PermutedLaplacian,
    x: &mut RowBlock,
    z: &mut RowBlock,
    goal: &Goal,
) -> Result<(Pairs, f64), SpectralError> {
    z.reshape(x.rows(), x.width());
    laplacian.multiply(x, z, goal.threads);
    let (gram, projected) = gram_and_product(x, z, goal.threads);
    if !gram.is_all_finite() {
        return Err(SpectralError::NotFinite);
    }
    let ritz = ritz(&gram, &projected)?;
    rotate(x, &ritz.coefficients, goal.threads);
    Ok((measured(laplacian, x, &ritz, goal), ritz.independence))
}

/// XᵀX − I of the first `count` columns.
pub(crate) fn overlaps(x: &RowBlock, count: usize, threads: usize) -> Mat<f64> {
    let gram = gram(x, threads);
    gram.submatrix(0, 0, count, count) - Mat::<f64>::identity(count, count)
}

/// C with (XC)ᵀXC = I up to the square of the overlaps E of the first columns: one step of Newton's
/// iteration for the inverse square root, I − E / 2. Further columns stay as they are.
fn mended(overlap: &Mat<f64>, width: usize) -> Mat<f64> {
    let mut mended = Mat::<f64>::identity(width, width);
    let count = overlap.nrows();
    let mut leading = mended.submatrix_mut(0, 0, count, count);
    leading -= faer::Scale(0.5) * overlap;
    mended
}

fn measured(laplacian: &PermutedLaplacian, x: &RowBlock, ritz: &Ritz, goal: &Goal) -> Pairs {
    let values = padded(ritz, x.width());
    let residuals = residual_norms(laplacian, x, &values, goal.threads);
    Pairs {
        assessment: assess(&values, &residuals, goal.wanted, goal.tol, goal.norm),
        values,
        residuals,
    }
}

/// One value per column of the block: ∞ where the basis was short of rank.
fn padded(ritz: &Ritz, width: usize) -> Vec<f64> {
    let mut values = ritz.values.clone();
    values.resize(width, f64::INFINITY);
    values
}

fn residual_norms(
    laplacian: &PermutedLaplacian,
    x: &RowBlock,
    values: &[f64],
    threads: usize,
) -> Vec<f64> {
    let finite: Vec<f64> = values
        .iter()
        .map(|&v| if v.is_finite() { v } else { 0.0 })
        .collect();
    laplacian
        .squared_residuals(x, &finite, threads)
        .into_iter()
        .zip(values)
        .map(|(square, v)| {
            if v.is_finite() {
                square.sqrt()
            } else {
                f64::INFINITY
            }
        })
        .collect()
}

/// Fills columns that hold nothing with random numbers, off the null space.
pub(crate) fn refill(
    null_space: &NullSpace,
    x: &mut RowBlock,
    values: &[f64],
    (rng, threads): (&mut ChaCha8Rng, usize),
) {
    let first = values.partition_point(|v| v.is_finite());
    if first < x.width() {
        randomize(x, first, rng);
        null_space.project_out(x, threads);
    }
}

/// Overwrites the columns from `first` on by random numbers of about unit norm.
pub(crate) fn randomize(x: &mut RowBlock, first: usize, rng: &mut ChaCha8Rng) {
    let columns = x.width() - first;
    let noise = noise(x.rows(), columns, rng);
    for (i, noise) in noise.chunks_exact(columns).enumerate() {
        x.row_mut(i)[first..].copy_from_slice(noise);
    }
}

/// Random columns of about unit norm, row by row.
pub(crate) fn noise(rows: usize, columns: usize, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let scale = (3.0 / rows as f64).sqrt();
    let number = |_| scale * (2.0 * rng.random::<f64>() - 1.0);
    (0..rows * columns).map(number).collect()
}
