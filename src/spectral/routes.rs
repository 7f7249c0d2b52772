//! The routes of [`super::LowSpectrum`], one function each.

use super::assess::tolerance_floor;
use super::dense::laplacian_eigen;
use super::eigenpairs::{Convergence, Eigenpairs, relative_unit};
use super::factor::CholeskyFactor;
use super::kept::Kept;
use super::low_spectrum::{LowSpectrum, Problem, Solved, block_width};
use super::products::first_filter;
use super::search::{Found, PROOF_LIMIT, Search};
use super::solver::residual_norms;
use super::{Method, Route, SpectralError, SymmetricOperator};
use faer::Mat;
use rand_chacha::ChaCha8Rng;
use std::sync::OnceLock;

/// Rounds of products, and block solves, that an update takes as a rule.
const ROUNDS: f64 = 3.0;
const SOLVES: f64 = 5.0;

/// Products that a search from nothing may take: where the factor fills up they usually suffice.
const COLD_PRODUCTS: f64 = 1000.0;

/// How much faster multiplications are in a dense factorisation than in a sparse product.
const DENSE_SPEED: f64 = 3.0;

impl Solved {
    /// Pairs in the user's numbering.
    fn given(route: Route, pairs: Eigenpairs) -> Self {
        Self {
            route,
            values: pairs.values.clone(),
            convergence: pairs.convergence.clone(),
            pairs: OnceLock::from(pairs),
        }
    }
}

impl LowSpectrum {
    /// Decomposes the whole matrix.
    pub(super) fn solve_dense(
        &mut self,
        problem: Problem<'_>,
        route: Route,
    ) -> Result<Solved, SpectralError> {
        let Problem { laplacian, k, .. } = problem;
        let (values, all) = laplacian_eigen(laplacian)?;
        let kept = values.len().min(block_width(k) + 1);
        let nulls = problem.null_space.dim().min(kept);
        self.keep_vectors(
            problem,
            &values[nulls..kept],
            &all.subcols(nulls, kept - nulls).to_owned(),
        );
        let vectors = all.subcols(0, k).to_owned();
        let residuals = residual_norms(laplacian, &vectors, &values[..k]);
        let unit = relative_unit(k.checked_sub(1).map_or(0.0, |last| values[last]));
        let next = values.get(k).filter(|_| k > 0);
        let facts = Convergence::from_residuals(residuals, unit);
        let tol = self.params.tol;
        let floor = tolerance_floor(tol, unit, laplacian.norm_bound()).unwrap_or(tol);
        let reached = floor.max(facts.max_relative_residual);
        let pairs = Eigenpairs {
            values: values[..k].to_vec(),
            vectors,
            convergence: Convergence {
                converged: k,
                applications: k,
                cluster_cut: next.is_some_and(|v| v - values[k - 1] <= tol * unit),
                certified: Some(true),
                tolerance_floor: (reached > tol).then_some(reached),
                ..facts
            },
        };
        Ok(Solved::given(route, pairs))
    }

    /// At least k components: k null vectors, by their components' order of discovery.
    pub(super) fn solve_null_space(&mut self, problem: Problem<'_>) -> Solved {
        let k = problem.k;
        self.keep_vectors(problem, &[], &Mat::new());
        let pairs = Eigenpairs {
            values: vec![0.0; k],
            vectors: problem.null_space.vectors(&problem.order.position, k),
            convergence: Convergence {
                converged: k,
                cluster_cut: problem.null_space.dim() > k,
                certified: Some(true),
                ..Convergence::from_residuals(vec![0.0; k], relative_unit(0.0))
            },
        };
        Solved::given(Route::NullSpace, pairs)
    }

    /// By shift and invert, or by products with L where the factor does not fit or takes more work.
    pub(super) fn solve_sparse(
        &mut self,
        problem: Problem<'_>,
        warm: bool,
        rng: &mut ChaCha8Rng,
    ) -> Result<Solved, SpectralError> {
        let permuted = &mut self.workspace.permuted;
        permuted.assign(problem.laplacian, problem.order, self.params.threads);
        let wanted = problem.wanted();
        let usual = block_width(wanted);
        let kept = self.kept.take().filter(|_| warm);
        let width = kept
            .as_ref()
            .map_or(usual, |kept| kept.width(wanted, usual));
        let plan = kept
            .as_ref()
            .map(|kept| kept.plan(problem.laplacian.dim(), wanted, width));
        let norm = problem.laplacian.norm_bound();
        let buffers = std::mem::take(&mut self.workspace.factor);
        let must_count = self.params.certify
            || problem.null_space.dim() > 1
            || problem.laplacian.dim() <= PROOF_LIMIT;
        let factor = CholeskyFactor::analyze(permuted, problem.order, self.params.threads, buffers)
            .filter(|factor| factor.num_values() as f64 <= self.most_fill)
            .filter(|factor| {
                let products = match &plan {
                    Some(plan) => ROUNDS * first_filter(plan, norm).products() as f64,
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
        let needs = kept.as_ref().map(|kept| kept.needs.clone());
        let mut x = std::mem::take(&mut self.workspace.block);
        let (route, (found, spare)) = match factor {
            Some(mut factor) => {
                let found = search.run((kept, plan), &mut factor, &mut x, rng)?;
                self.workspace.factor = factor.into_buffers();
                (Route::ShiftInvert, found)
            }
            None => (
                Route::Products,
                search.run_without_factor((kept, plan), &mut x, rng)?,
            ),
        };
        self.workspace.block = spare;
        let finite = found.outcome.values.iter().take_while(|v| v.is_finite());
        // What a start from nothing needed says nothing of later ones.
        let needs = needs.map(|needs| needs.and(found.outcome.gain_needed));
        let null_space = problem.null_space.clone();
        self.kept = Some(Kept::new(
            x,
            finite.copied().collect(),
            null_space,
            problem.order,
            needs.unwrap_or_default(),
        ));
        Ok(solved(route, &found, problem, self.params.tol))
    }

    /// Keeps Ritz vectors that are in the user's numbering.
    fn keep_vectors(&mut self, problem: Problem<'_>, values: &[f64], vectors: &Mat<f64>) {
        if self.params.method == Method::Warm {
            let needs = self.kept.as_ref().map(|k| k.needs.clone());
            let null_space = problem.null_space.clone();
            let values = values.to_vec();
            let kept = Kept::from_vectors(
                vectors.as_ref(),
                values,
                null_space,
                problem.order,
                needs.unwrap_or_default(),
            );
            self.kept = Some(kept);
        }
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
        pairs: OnceLock::new(),
    }
}
