//! The routes of [`crate::GrowingEigensolver`], one function each.

use super::growing_eigensolver::{GrowingEigensolver, Problem, Solution, Solved, block_width};
use crate::cholesky::CholeskyFactor;
use crate::dense::laplacian_eigen;
use crate::eigenpairs::{Convergence, relative_unit};
use crate::iteration::{
    Found, GainHistory, PROOF_LIMIT, Search, Start, WarmStart, first_filter, residual_norms,
    tolerance_floor,
};
use crate::{Method, Route, SpectralError, SymmetricOperator};
use faer::MatRef;
use rand_chacha::ChaCha8Rng;

/// Rounds of products, and block solves, that an update takes as a rule.
const ROUNDS: f64 = 3.0;
const SOLVES: f64 = 5.0;

/// Products that a search from nothing may take: where the factor fills up they usually suffice.
const COLD_PRODUCTS: f64 = 1000.0;

/// How much faster multiplications are in a dense factorisation than in a sparse product.
const DENSE_SPEED: f64 = 3.0;

impl GrowingEigensolver {
    /// Decomposes the whole matrix.
    pub(crate) fn solve_dense(
        &mut self,
        problem: Problem<'_>,
        route: Route,
        gains: GainHistory,
    ) -> Result<Solution, SpectralError> {
        let Problem { laplacian, k, .. } = problem;
        let (values, all) = laplacian_eigen(laplacian)?;
        let kept = values.len().min(block_width(k) + 1);
        let nulls = problem.null_space.dim().min(kept);
        let ritz_vectors = all.subcols(nulls, kept - nulls);
        let warm_start = self.warm_start(problem, &values[nulls..kept], ritz_vectors, gains);
        let vectors = all.subcols(0, k).to_owned();
        let residuals = residual_norms(laplacian, &vectors, &values[..k]);
        let unit = relative_unit(k.checked_sub(1).map_or(0.0, |last| values[last]));
        let next = values.get(k).filter(|_| k > 0);
        let facts = Convergence::from_residuals(residuals, unit);
        let tol = self.params.tol;
        let floor = tolerance_floor(tol, unit, laplacian.norm_bound()).unwrap_or(tol);
        let reached = floor.max(facts.max_relative_residual);
        let solved = Solved {
            route,
            values: values[..k].to_vec(),
            convergence: Convergence {
                converged: k,
                applications: k,
                cluster_cut: next.is_some_and(|v| v - values[k - 1] <= tol * unit),
                certified: Some(true),
                tolerance_floor: (reached > tol).then_some(reached),
                ..facts
            },
            vectors: Some(vectors),
        };
        Ok(Solution {
            solved,
            warm_start,
            searched_cold: false,
        })
    }

    /// At least k components: k null vectors, by their components' order of discovery.
    pub(crate) fn solve_null_space(
        &mut self,
        problem: Problem<'_>,
        gains: GainHistory,
    ) -> Solution {
        let k = problem.k;
        let nothing = MatRef::from_column_major_slice(&[], problem.laplacian.dim(), 0);
        let solved = Solved {
            route: Route::NullSpace,
            values: vec![0.0; k],
            convergence: Convergence {
                converged: k,
                cluster_cut: problem.null_space.dim() > k,
                certified: Some(true),
                ..Convergence::from_residuals(vec![0.0; k], relative_unit(0.0))
            },
            vectors: Some(problem.null_space.vectors(&problem.order.position, k)),
        };
        Solution {
            solved,
            warm_start: self.warm_start(problem, &[], nothing, gains),
            searched_cold: false,
        }
    }

    /// By shift and invert, or by products with L where the factor does not fit or takes more work.
    pub(crate) fn solve_sparse(
        &mut self,
        problem: Problem<'_>,
        known: Option<WarmStart>,
        rng: &mut ChaCha8Rng,
    ) -> Result<Solution, SpectralError> {
        let searched_cold = known.is_none();
        let permuted = &mut self.workspace.permuted;
        permuted.assign(problem.laplacian, problem.order, self.params.threads);
        let wanted = problem.wanted();
        let usual = block_width(wanted);
        let width = known.as_ref().map_or(usual, |k| k.width(wanted, usual));
        let gains = known.as_ref().map(|known| known.gains.clone());
        let start = known.map(|vectors| Start {
            plan: vectors.plan(problem.laplacian.dim(), wanted, width),
            vectors,
        });
        let norm = problem.laplacian.norm_bound();
        let buffers = std::mem::take(&mut self.workspace.factor);
        let must_count = self.params.certify
            || problem.null_space.dim() > 1
            || problem.laplacian.dim() <= PROOF_LIMIT;
        let factor = CholeskyFactor::analyze(permuted, problem.order, self.params.threads, buffers)
            .filter(|factor| factor.num_values() as f64 <= self.most_fill)
            .filter(|factor| {
                let products = match &start {
                    Some(start) => ROUNDS * first_filter(&start.plan, norm).products() as f64,
                    None => COLD_PRODUCTS,
                };
                must_count || work(factor, width) <= products * permuted.nnz() as f64
            });
        let search = Search {
            laplacian: problem.laplacian,
            order: problem.order,
            null_space: problem.null_space,
            permuted: &self.workspace.permuted,
            params: &self.params,
            wanted,
            width,
            factor_entries: factor.as_ref().map_or(0, CholeskyFactor::num_values),
        };
        let mut x = std::mem::take(&mut self.workspace.block);
        let (route, found) = match factor {
            Some(mut factor) => {
                let found = search.run(start, &mut factor, &mut x, rng)?;
                self.workspace.factor = factor.into_buffers();
                (Route::ShiftInvert, found)
            }
            None => {
                let found = search.run_without_factor(start, &mut x, rng)?;
                (Route::Products, found)
            }
        };
        let finite = found.outcome.values.iter().take_while(|v| v.is_finite());
        // What a start from nothing needed says nothing of later ones.
        let gains = gains.map(|gains| gains.and(found.outcome.gain_needed));
        let warm_start = WarmStart::new(
            x,
            finite.copied().collect(),
            problem.null_space.clone(),
            problem.order,
            gains.unwrap_or_default(),
        );
        let solved = solved(route, &found, problem, self.params.tol);
        self.workspace.block = found.spare;
        Ok(Solution {
            solved,
            warm_start: Some(warm_start),
            searched_cold,
        })
    }

    /// What the next refresh starts from, out of Ritz vectors in the user's numbering.
    fn warm_start(
        &self,
        problem: Problem<'_>,
        values: &[f64],
        vectors: MatRef<'_, f64>,
        gains: GainHistory,
    ) -> Option<WarmStart> {
        (self.params.method == Method::Warm).then(|| {
            let null_space = problem.null_space.clone();
            WarmStart::from_vectors(vectors, values.to_vec(), null_space, problem.order, gains)
        })
    }
}

/// What an update takes with a factor: multiplications per column of the block, as in a product with L.
fn work(factor: &CholeskyFactor, width: usize) -> f64 {
    factor.operations() / (DENSE_SPEED * width as f64) + 2.0 * SOLVES * factor.num_values() as f64
}

/// Values and facts of a search, null vectors included.
fn solved(route: Route, found: &Found, problem: Problem<'_>, tol: f64) -> Solved {
    let (nulls, wanted) = (problem.null_space.dim(), problem.wanted());
    let outcome = &found.outcome;
    let mut values = vec![0.0; nulls];
    values.extend(&outcome.values[..wanted]);
    let mut residuals = vec![0.0; nulls];
    residuals.extend(&outcome.residuals[..wanted]);
    Solved {
        route,
        values,
        convergence: Convergence {
            converged: nulls + outcome.assessment.converged,
            restarts: outcome.rounds - 1,
            applications: outcome.applications,
            solves: outcome.solves,
            cluster_cut: outcome.assessment.cluster_cut,
            certified: found.certified,
            repaired: found.repaired,
            tolerance_floor: tolerance_floor(
                tol,
                outcome.assessment.unit,
                problem.laplacian.norm_bound(),
            ),
            ..Convergence::from_residuals(residuals, outcome.assessment.unit)
        },
        vectors: None,
    }
}
