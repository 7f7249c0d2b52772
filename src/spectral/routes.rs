//! The routes of [`super::LowSpectrum`], one function each.

use super::block::LANES;
use super::dense::laplacian_eigen;
use super::eigenpairs::{Convergence, Eigenpairs, relative_unit};
use super::factor::CholeskyFactor;
use super::kept::Kept;
use super::low_spectrum::{LowSpectrum, Problem, Solved, block_width};
use super::products::lowest_by_products;
use super::search::{Found, Search};
use super::solver::residual_norms;
use super::start::{Grown, start_block};
use super::{Method, Route, SpectralError, SymmetricOperator};
use faer::Mat;
use rand_chacha::ChaCha8Rng;
use std::sync::OnceLock;

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
        let pairs = Eigenpairs {
            values: values[..k].to_vec(),
            vectors,
            convergence: Convergence {
                converged: k,
                applications: k,
                cluster_cut: next.is_some_and(|v| v - values[k - 1] <= self.params.tol * unit),
                certified: self.params.certify.then_some(true),
                ..Convergence::from_residuals(residuals, unit)
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
                certified: self.params.certify.then_some(true),
                ..Convergence::from_residuals(vec![0.0; k], relative_unit(0.0))
            },
        };
        Solved::given(Route::NullSpace, pairs)
    }

    /// By shift and invert if the factor fits, else by products with L.
    pub(super) fn solve_sparse(
        &mut self,
        problem: Problem<'_>,
        warm: bool,
        rng: &mut ChaCha8Rng,
    ) -> Result<Solved, SpectralError> {
        let permuted = &mut self.workspace.permuted;
        permuted.assign(problem.laplacian, problem.order);
        let buffers = std::mem::take(&mut self.workspace.factor);
        let factor = (problem.order.fill <= self.most_fill)
            .then(|| CholeskyFactor::analyze(permuted, problem.order, self.params.threads, buffers))
            .flatten();
        match factor {
            Some(factor) => self.solve_with(problem, factor, warm, rng),
            None => self.solve_without_factor(problem, warm, rng),
        }
    }

    fn solve_with(
        &mut self,
        problem: Problem<'_>,
        mut factor: CholeskyFactor,
        warm: bool,
        rng: &mut ChaCha8Rng,
    ) -> Result<Solved, SpectralError> {
        let wanted = problem.wanted();
        let width = block_width(wanted);
        let kept = self.kept.take().filter(|_| warm);
        let search = Search {
            laplacian: problem.laplacian,
            order: problem.order,
            null_space: problem.null_space,
            permuted: &self.workspace.permuted,
            params: &self.params,
            wanted,
            width: kept
                .as_ref()
                .map_or(width, |kept| kept.width(wanted, width)),
        };
        let mut x = std::mem::take(&mut self.workspace.block);
        let needs = kept.as_ref().map(|kept| kept.needs.clone());
        let (found, spare) = search.run(kept, &mut factor, &mut x, rng)?;
        self.workspace.factor = factor.into_buffers();
        self.workspace.block = spare;
        let finite = found.outcome.values.iter().take_while(|v| v.is_finite());
        let needs = needs.unwrap_or_default().and(found.outcome.gain_needed);
        let null_space = problem.null_space.clone();
        self.kept = Some(Kept::new(
            x,
            finite.copied().collect(),
            null_space,
            problem.order,
            needs,
        ));
        Ok(solved(&found, problem))
    }

    /// Restarted Lanczos on L itself, off the null space.
    fn solve_without_factor(
        &mut self,
        problem: Problem<'_>,
        warm: bool,
        rng: &mut ChaCha8Rng,
    ) -> Result<Solved, SpectralError> {
        let wanted = problem.wanted();
        let start = self.kept.take().filter(|_| warm).map(|kept| {
            let grown = Grown {
                laplacian: problem.laplacian,
                order: problem.order,
                null_space: problem.null_space,
                threads: self.params.threads,
            };
            let x = &mut self.workspace.block;
            start_block(&kept, grown, (wanted + 1).next_multiple_of(LANES), x, rng);
            let row = |u: usize| x.row(problem.order.position[u] as usize);
            Mat::from_fn(problem.laplacian.dim(), wanted, |u, j| row(u)[j])
        });
        let seed = self.seed.wrapping_add(self.refreshes);
        let pairs = lowest_by_products(problem, start, &self.params, seed)?;
        let nulls = problem.null_space.dim();
        let ritz = pairs.vectors.subcols(nulls, wanted).to_owned();
        self.keep_vectors(problem, &pairs.values[nulls..], &ritz);
        Ok(Solved::given(Route::Products, pairs))
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

/// Values and facts of a search, null vectors included.
fn solved(found: &Found, problem: Problem<'_>) -> Solved {
    let (nulls, wanted) = (problem.null_space.dim(), problem.wanted());
    let outcome = &found.outcome;
    let mut values = vec![0.0; nulls];
    values.extend(&outcome.values[..wanted]);
    let mut residuals = vec![0.0; nulls];
    residuals.extend(&outcome.residuals[..wanted]);
    Solved {
        route: Route::ShiftInvert,
        values,
        convergence: Convergence {
            converged: nulls + outcome.assessment.converged,
            restarts: outcome.rounds - 1,
            applications: outcome.applications,
            solves: outcome.solves,
            cluster_cut: outcome.assessment.cluster_cut,
            certified: found.certified,
            repaired: found.repaired,
            ..Convergence::from_residuals(residuals, outcome.assessment.unit)
        },
        pairs: OnceLock::new(),
    }
}
