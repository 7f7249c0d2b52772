//! The lowest eigenpairs of a graph that grows: which route to take, and what to carry over.
//!
//! - hardly more nodes than the block has columns, or up to 300 and nothing to start from: dense
//!   ([`super::dense`]);
//! - as many components as pairs wanted: the null space alone, in closed form;
//! - else filtered subspace iteration on (L + σI)⁻¹ ([`super::subspace`]), from the vectors of the
//!   last refresh, or from random ones where there are none;
//! - where the factor does not fit or takes more work: a polynomial in L alone ([`super::products`]).

use super::block::{LANES, RowBlock};
use super::eigenpairs::{Convergence, Eigenpairs};
use super::elimination::EliminationOrder;
use super::factor::FactorBuffers;
use super::kept::Kept;
use super::null_space::NullSpace;
use super::permuted::PermutedLaplacian;
use super::search::PROOF_LIMIT;
use super::solver::DENSE_LIMIT;
use super::{Laplacian, Method, Route, SpectralError, SpectralParams, SymmetricOperator};
use crate::graph::Csr;
use crate::seeds::{Stream, stream};
use rand_chacha::ChaCha8Rng;
use std::sync::OnceLock;

/// Least number of guard columns beside the wanted ones; one in eight if that is more.
const GUARDS: usize = 4;

/// Entries of a factor beyond which the search goes on without one (4 GB).
const MOST_FILL: f64 = 5e8;

/// log2 of the random words set aside for each refresh.
const WORDS_PER_REFRESH: u32 = 40;

/// What a refresh did.
#[derive(Clone, Debug)]
pub struct SpectrumRefresh {
    /// Nodes of the graph.
    pub nodes: usize,
    /// Undirected edges, a self-loop counted once.
    pub edges: usize,
    /// How the pairs were found.
    pub route: Route,
    /// Whether the search began without earlier vectors.
    pub cold_start: bool,
    /// min(k, n) lowest eigenvalues, ascending.
    pub eigenvalues: Vec<f64>,
    /// Cost and quality.
    pub convergence: Convergence,
}

/// The k lowest eigenpairs of the Laplacian of a growing graph, kept up to date.
///
/// ```
/// use eigentrail::spectral::{LowSpectrum, SpectralParams};
/// use sprs::TriMatI;
///
/// let mut spectrum = LowSpectrum::new(SpectralParams { num_eigenpairs: 4, ..Default::default() }, 0);
/// for n in [400, 420] {
///     let mut path: TriMatI<f64, u32> = TriMatI::new((n, n));
///     for i in 1..n {
///         path.add_triplet(i - 1, i, 1.0);
///         path.add_triplet(i, i - 1, 1.0);
///     }
///     let refresh = spectrum.refresh(&path.to_csr())?;
///     let expected = 1.0 - (std::f64::consts::PI * 3.0 / (n as f64 - 1.0)).cos();
///     assert!((refresh.eigenvalues[3] - expected).abs() < 1e-3 * expected);
/// }
/// # Ok::<(), eigentrail::spectral::SpectralError>(())
/// ```
#[derive(Clone, Debug)]
pub struct LowSpectrum {
    pub(super) params: SpectralParams,
    pub(super) seed: u64,
    pub(super) refreshes: u64,
    solved: Option<Solved>,
    pub(super) kept: Option<Kept>,
    order: Option<EliminationOrder>,
    /// As [`MOST_FILL`]; tests set it lower.
    pub(super) most_fill: f64,
    /// As [`PROOF_LIMIT`]; tests set it lower.
    pub(super) most_rescued: usize,
    pub(super) workspace: Workspace,
}

/// Values and facts of a refresh; the vectors when somebody asks for them, or at once where the route
/// yields them in the user's numbering.
#[derive(Clone, Debug)]
pub(super) struct Solved {
    pub(super) route: Route,
    pub(super) values: Vec<f64>,
    pub(super) convergence: Convergence,
    pub(super) pairs: OnceLock<Eigenpairs>,
}

/// Big arrays whose contents do not outlive a refresh.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    pub(super) permuted: PermutedLaplacian,
    pub(super) factor: FactorBuffers,
    /// n × block width.
    pub(super) block: RowBlock,
}

impl Clone for Workspace {
    /// An empty one: nothing in it is needed again.
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// One graph, in the forms that every route needs.
#[derive(Clone, Copy)]
pub(super) struct Problem<'a> {
    pub(super) laplacian: &'a Laplacian<'a>,
    pub(super) order: &'a EliminationOrder,
    pub(super) null_space: &'a NullSpace,
    /// min(k, n).
    pub(super) k: usize,
}

impl Problem<'_> {
    /// Pairs besides the null vectors.
    pub(super) fn wanted(&self) -> usize {
        self.k.saturating_sub(self.null_space.dim())
    }
}

impl LowSpectrum {
    /// Nothing yet. `params` are checked by the first [`refresh`](Self::refresh).
    pub fn new(params: SpectralParams, seed: u64) -> Self {
        Self {
            params,
            seed,
            refreshes: 0,
            solved: None,
            kept: None,
            order: None,
            most_fill: MOST_FILL,
            most_rescued: PROOF_LIMIT,
            workspace: Workspace::default(),
        }
    }

    /// The pairs of the last refresh: ascending values, unit vectors in the user's numbering.
    /// Cost: O(n k) the first time after a refresh.
    pub fn eigenpairs(&self) -> Option<&Eigenpairs> {
        let solved = self.solved.as_ref()?;
        Some(solved.pairs.get_or_init(|| {
            let kept = self.kept.as_ref().expect("pairs are given or kept");
            Eigenpairs {
                vectors: kept.vectors(solved.values.len()),
                values: solved.values.clone(),
                convergence: solved.convergence.clone(),
            }
        }))
    }

    /// The pairs of the last refresh, for keeps.
    pub fn into_eigenpairs(mut self) -> Option<Eigenpairs> {
        // The vectors are copied out; the factor and the scratch block need not be there beside them.
        self.workspace = Workspace::default();
        self.eigenpairs()?;
        self.solved.take()?.pairs.into_inner()
    }

    /// The parameters given at the start.
    pub fn params(&self) -> &SpectralParams {
        &self.params
    }

    /// Brings the pairs up to date with a graph that has grown since the last call: rows are only
    /// appended, edges may join any two nodes. Keeps min(k, n) pairs. A graph with fewer rows than
    /// last time is taken for another graph and searched from nothing.
    ///
    /// # Errors
    /// [`SpectralError::Parameter`], [`SpectralError::Weight`] or [`SpectralError::Degree`] for bad
    /// input, after which the pairs of the last refresh are still there. Not converging is no error:
    /// see [`Convergence::converged`].
    ///
    /// # Panics
    /// If `adjacency` is not square, not stored by rows, or has 2³¹ rows or more.
    pub fn refresh(&mut self, adjacency: &Csr) -> Result<SpectrumRefresh, SpectralError> {
        self.params.validate()?;
        let laplacian = Laplacian::new(adjacency, self.params.laplacian)?;
        let n = laplacian.dim();
        assert!(n < i32::MAX as usize, "rows are numbered in 31 bits");
        let mut rng = stream(self.seed, Stream::Spectral);
        rng.set_word_pos(u128::from(self.refreshes) << WORDS_PER_REFRESH);
        self.solved = None;
        if self.params.method != Method::Warm || self.kept.as_ref().is_some_and(|k| k.nodes() > n) {
            self.workspace.block = self.kept.take().map(|k| k.block).unwrap_or_default();
            self.order = None;
        }
        let nothing_known = self.kept.is_none();
        let order = EliminationOrder::new(&laplacian, self.order.as_ref());
        let null_space = NullSpace::new(&laplacian, &order);
        let problem = Problem {
            laplacian: &laplacian,
            order: &order,
            null_space: &null_space,
            k: self.params.num_eigenpairs.min(n),
        };
        let (solved, searched_cold) = self.solve(problem, &mut rng)?;
        self.order = Some(order);
        self.refreshes += 1;
        let refresh = SpectrumRefresh {
            nodes: n,
            edges: laplacian.num_edges(),
            route: solved.route,
            cold_start: nothing_known || searched_cold,
            eigenvalues: solved.values.clone(),
            convergence: solved.convergence.clone(),
        };
        self.solved = Some(solved);
        Ok(refresh)
    }

    /// The pairs, and whether a search began without earlier vectors.
    fn solve(
        &mut self,
        problem: Problem<'_>,
        rng: &mut ChaCha8Rng,
    ) -> Result<(Solved, bool), SpectralError> {
        let (n, wanted) = (problem.laplacian.dim(), problem.wanted());
        let warm = self
            .kept
            .as_ref()
            .is_some_and(|k| k.ritz_vectors() >= wanted);
        if self.params.method == Method::Full {
            return Ok((self.solve_dense(problem, Route::Full)?, false));
        }
        if n < 4 * block_width(problem.k) {
            return Ok((self.solve_dense(problem, Route::Small)?, false));
        }
        if wanted == 0 {
            return Ok((self.solve_null_space(problem), false));
        }
        if n <= DENSE_LIMIT && !warm {
            return Ok((self.solve_dense(problem, Route::Small)?, false));
        }
        let mut solved = self.solve_sparse(problem, warm, rng)?;
        let proven = solved.convergence.certified == Some(true);
        if n <= self.most_rescued && !(proven && solved.convergence.converged == problem.k) {
            solved = self.rescued(problem, &solved.convergence)?;
        }
        Ok((solved, !warm))
    }

    /// The dense route where a search has failed, or cannot prove that it has not, and a decomposition
    /// is still cheap: k cuts an eigenspace of more dimensions than the block has columns, on a graph
    /// of many symmetries.
    fn rescued(
        &mut self,
        problem: Problem<'_>,
        spent: &Convergence,
    ) -> Result<Solved, SpectralError> {
        let mut exact = self.solve_dense(problem, Route::Rescued)?;
        exact.convergence.applications += spent.applications;
        exact.convergence.solves = spent.solves;
        exact.convergence.restarts = spent.restarts;
        if let Some(pairs) = exact.pairs.get_mut() {
            pairs.convergence.clone_from(&exact.convergence);
        }
        Ok(exact)
    }
}

/// Columns of a block that holds `wanted` pairs and their guards.
pub(super) fn block_width(wanted: usize) -> usize {
    (wanted + GUARDS.max(wanted / 8)).next_multiple_of(LANES)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectral::dense::laplacian_eigen;
    use crate::spectral::{LaplacianKind, testing};
    use faer::Mat;

    fn spectrum(k: usize) -> LowSpectrum {
        let params = SpectralParams {
            num_eigenpairs: k,
            tol: 1e-3,
            ..Default::default()
        };
        LowSpectrum::new(params, 0)
    }

    fn exact(graph: &Csr) -> Vec<f64> {
        let laplacian = Laplacian::new(graph, LaplacianKind::Normalized).unwrap();
        laplacian_eigen(&laplacian).unwrap().0
    }

    #[test]
    fn a_factor_that_would_not_fit_is_done_without() {
        let parts = [testing::random(500, 6.0, 1), testing::cycle(100)];
        let whole = testing::discovered(&testing::disjoint(&parts), 2);
        let mut spectrum = spectrum(8);
        spectrum.most_fill = 0.0;
        for (n, cold) in [(560, true), (600, false)] {
            let graph = testing::prefix(&whole, n);
            let refresh = spectrum.refresh(&graph).unwrap();
            assert_eq!(refresh.cold_start, cold);
            assert_eq!(refresh.convergence.solves, 0);
            assert_eq!(refresh.convergence.converged, 8);
            for (found, expected) in refresh.eigenvalues.iter().zip(exact(&graph)) {
                assert!((found - expected).abs() < 1e-7, "{found} for {expected}");
            }
        }
    }

    #[test]
    fn where_the_factor_fills_up_products_are_taken_and_find_the_same() {
        let whole = testing::discovered(&testing::random(1700, 16.0, 1), 2);
        let n = whole.rows() - whole.rows() / 20;
        for (most_fill, cold_route) in [(MOST_FILL, Route::ShiftInvert), (0.0, Route::Products)] {
            let mut spectrum = spectrum(8);
            spectrum.most_fill = most_fill;
            for (n, route) in [(n, cold_route), (whole.rows(), Route::Products)] {
                let graph = testing::prefix(&whole, n);
                let refresh = spectrum.refresh(&graph).unwrap();
                assert!(n > PROOF_LIMIT, "too large to be decomposed instead");
                assert_eq!((refresh.route, refresh.convergence.converged), (route, 8));
                assert!(refresh.convergence.max_relative_residual <= 1e-3);
                for (found, expected) in refresh.eigenvalues.iter().zip(exact(&graph)) {
                    assert!((found - expected).abs() < 1e-7, "{found} for {expected}");
                }
                let pairs = spectrum.eigenpairs().unwrap();
                let gram = pairs.vectors.transpose() * &pairs.vectors;
                let error = gram - Mat::<f64>::identity(8, 8);
                assert!(error.norm_max() < 1e-12, "{error:?}");
            }
        }
    }

    #[test]
    fn a_copy_goes_on_exactly_as_the_original() {
        let whole = testing::discovered(&testing::grid(25, 25), 1);
        let mut original = spectrum(8);
        original.refresh(&testing::prefix(&whole, 500)).unwrap();
        let mut copy = original.clone();
        let a = original.refresh(&whole).unwrap();
        let b = copy.refresh(&whole).unwrap();
        assert_eq!(a.eigenvalues, b.eigenvalues);
        let vectors = |s: &LowSpectrum| s.eigenpairs().unwrap().vectors.clone();
        assert_eq!(vectors(&original), vectors(&copy));
    }

    #[test]
    fn starts_are_called_cold_when_they_are() {
        let whole = testing::discovered(&testing::grid(25, 25), 1);
        let colds = |method| {
            let mut spectrum = spectrum(8);
            spectrum.params.method = method;
            [64, 200, 500, 625].map(|n| {
                let graph = testing::prefix(&whole, n);
                spectrum.refresh(&graph).unwrap().cold_start
            })
        };
        assert_eq!(colds(Method::Warm), [true, false, false, false]);
        assert_eq!(colds(Method::Cold), [true; 4]);
        assert_eq!(colds(Method::Full), [true; 4]);
    }
}
