//! The lowest eigenpairs of a graph that grows: which route to take, and what to carry over.
//!
//! - hardly more nodes than the block has columns, or up to 300 and nothing to start from: dense
//!   ([`crate::dense`]);
//! - as many components as pairs wanted: the null space alone, in closed form;
//! - else filtered subspace iteration on (L + σI)⁻¹ ([`crate::iteration::subspace`]), from the vectors of the
//!   last refresh, or from random ones where there are none;
//! - where the factor does not fit or takes more work: a polynomial in L alone ([`crate::iteration::products`]).

use crate::block::{LANES, RowBlock};
use crate::cholesky::{EliminationOrder, FactorBuffers, PermutedLaplacian};
use crate::eigenpairs::{Convergence, Eigenpairs};
use crate::iteration::{DENSE_LIMIT, NullSpace, PROOF_LIMIT, WarmStart};
use crate::random::stream;
use crate::{
    Laplacian, Method, Route, SpectralError, SpectralParams, SymmetricCsr, SymmetricOperator,
};
use faer::Mat;
use rand_chacha::ChaCha8Rng;
use std::sync::OnceLock;

/// Least number of guard columns beside the wanted ones; one in eight if that is more.
const GUARDS: usize = 4;

/// Entries of a factor beyond which the search goes on without one (4 GB).
const MOST_FILL: f64 = 5e8;

/// log2 of the random words set aside for each refresh.
const WORDS_PER_REFRESH: u32 = 40;

/// Facts of a refresh.
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
/// use eigentrail_spectra::{GrowingEigensolver, SpectralParams, SymmetricCsr, sprs::TriMatI};
///
/// let params = SpectralParams { num_eigenpairs: 4, ..Default::default() };
/// let mut solver = GrowingEigensolver::new(params, 0);
/// for n in [400, 420] {
///     let mut path = TriMatI::<f64, u32>::new((n, n));
///     for i in 1..n {
///         path.add_triplet(i - 1, i, 1.0);
///         path.add_triplet(i, i - 1, 1.0);
///     }
///     let refresh = solver.refresh(&SymmetricCsr::new(path.to_csr())?)?;
///     let expected = 1.0 - (std::f64::consts::PI * 3.0 / (n as f64 - 1.0)).cos();
///     assert!((refresh.eigenvalues[3] - expected).abs() < 1e-3 * expected);
/// }
/// # Ok::<(), eigentrail_spectra::SpectralError>(())
/// ```
///
/// With the feature `serde` a solver can be written down between two refreshes, in any format; one read back goes
/// on to the same bits. (JSON needs `float_roundtrip` for the tolerance; all other numbers are written as integers.)
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "super::checkpoint::Checkpoint")
)]
pub struct GrowingEigensolver {
    pub(crate) params: SpectralParams,
    pub(crate) seed: u64,
    pub(crate) refreshes: u64,
    pub(crate) tracked: Option<Tracked>,
    /// As [`MOST_FILL`]; tests set it lower.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) most_fill: f64,
    /// As [`PROOF_LIMIT`]; tests set it lower.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) most_rescued: usize,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) workspace: Workspace,
}

/// All that is known of the graph of the last refresh.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Tracked {
    pub(crate) solved: Solved,
    pub(crate) order: EliminationOrder,
    /// Always there where the next refresh starts from it, and where the vectors are not in `solved`.
    pub(crate) warm_start: Option<WarmStart>,
    /// Put together when somebody asks for them.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) pairs: OnceLock<Eigenpairs>,
}

/// The values and facts of a refresh.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Solved {
    pub(crate) route: Route,
    #[cfg_attr(feature = "serde", serde(with = "crate::plain::numbers"))]
    pub(crate) values: Vec<f64>,
    #[cfg_attr(feature = "serde", serde(with = "crate::plain::PlainConvergence"))]
    pub(crate) convergence: Convergence,
    /// n × k in the user's numbering, where the route yields them so; else they are in the warm start.
    #[cfg_attr(feature = "serde", serde(with = "crate::plain::maybe_matrix"))]
    pub(crate) vectors: Option<Mat<f64>>,
}

/// Big arrays whose contents do not outlive a refresh.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    pub(crate) permuted: PermutedLaplacian,
    pub(crate) factor: FactorBuffers,
    /// n × block width.
    pub(crate) block: RowBlock,
}

impl Clone for Workspace {
    /// An empty one: nothing in it is needed again.
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// One graph, in the forms that every route needs.
#[derive(Clone, Copy)]
pub(crate) struct Problem<'a> {
    pub(crate) laplacian: &'a Laplacian<'a>,
    pub(crate) order: &'a EliminationOrder,
    pub(crate) null_space: &'a NullSpace,
    /// min(k, n).
    pub(crate) k: usize,
}

impl Problem<'_> {
    /// Pairs besides the null vectors.
    pub(crate) fn wanted(&self) -> usize {
        self.k.saturating_sub(self.null_space.dim())
    }
}

/// The outcome of a route.
#[derive(Debug)]
pub(crate) struct Solution {
    pub(crate) solved: Solved,
    pub(crate) warm_start: Option<WarmStart>,
    /// Whether a search began without earlier vectors.
    pub(crate) searched_cold: bool,
}

impl Tracked {
    fn nodes(&self) -> usize {
        self.order.node.len()
    }

    fn eigenpairs(&self) -> &Eigenpairs {
        self.pairs.get_or_init(|| {
            let Solved { values, .. } = &self.solved;
            let kept = || self.warm_start.as_ref().map(|w| w.vectors(values.len()));
            let vectors = self.solved.vectors.clone().or_else(kept);
            Eigenpairs {
                values: values.clone(),
                vectors: vectors.expect("vectors are in one place or the other"),
                convergence: self.solved.convergence.clone(),
            }
        })
    }
}

impl GrowingEigensolver {
    /// A solver that knows nothing yet. `params` are checked by the first [`refresh`](Self::refresh).
    pub fn new(params: SpectralParams, seed: u64) -> Self {
        Self {
            params,
            seed,
            refreshes: 0,
            tracked: None,
            most_fill: MOST_FILL,
            most_rescued: PROOF_LIMIT,
            workspace: Workspace::default(),
        }
    }

    /// The pairs of the last refresh: ascending values, unit vectors in the user's numbering.
    /// Cost: O(n k) the first time after a refresh.
    pub fn eigenpairs(&self) -> Option<&Eigenpairs> {
        self.tracked.as_ref().map(Tracked::eigenpairs)
    }

    /// Frees the buffers that are kept for the next refresh, some 60 numbers a node beside those of the factor: for who refreshes seldom.
    pub fn release_buffers(&mut self) {
        self.workspace = Workspace::default();
    }

    /// The pairs of the last refresh, for keeps.
    pub fn into_eigenpairs(mut self) -> Option<Eigenpairs> {
        // The vectors are copied out; the factor and the scratch block need not be there beside them.
        self.release_buffers();
        self.eigenpairs()?;
        self.tracked?.pairs.into_inner()
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
    /// [`SpectralError::Parameter`] for a parameter out of its range, [`SpectralError::NotFinite`] and
    /// [`SpectralError::Dense`] where arithmetic fails, after which the next refresh starts from nothing. Not
    /// converging is no error: see [`Convergence::converged`].
    ///
    /// # Panics
    /// If `adjacency` has 2³¹ rows or more.
    pub fn refresh(&mut self, adjacency: &SymmetricCsr) -> Result<SpectrumRefresh, SpectralError> {
        self.params.validate()?;
        let n = adjacency.num_nodes();
        assert!(n < i32::MAX as usize, "rows are numbered in 31 bits");
        let laplacian = Laplacian::new(adjacency, self.params.laplacian);
        let mut rng = stream(self.seed);
        rng.set_word_pos(u128::from(self.refreshes) << WORDS_PER_REFRESH);
        let is_warm = self.params.method == Method::Warm;
        let previous = self.tracked.take();
        let previous = previous.filter(|p| is_warm && p.nodes() <= n);
        let nothing_known = previous.is_none();
        let order = EliminationOrder::new(&laplacian, previous.as_ref().map(|p| &p.order));
        let null_space = NullSpace::new(&laplacian, &order);
        let problem = Problem {
            laplacian: &laplacian,
            order: &order,
            null_space: &null_space,
            k: self.params.num_eigenpairs.min(n),
        };
        let warm_start = previous.and_then(|p| p.warm_start);
        let solution = self.solve(problem, warm_start, &mut rng)?;
        self.refreshes += 1;
        let Solution {
            solved, warm_start, ..
        } = solution;
        let refresh = SpectrumRefresh {
            nodes: n,
            edges: adjacency.num_edges(),
            route: solved.route,
            cold_start: nothing_known || solution.searched_cold,
            eigenvalues: solved.values.clone(),
            convergence: solved.convergence.clone(),
        };
        self.tracked = Some(Tracked {
            solved,
            order,
            warm_start,
            pairs: OnceLock::new(),
        });
        Ok(refresh)
    }

    /// Takes the route that the graph, the parameters and what is known call for.
    fn solve(
        &mut self,
        problem: Problem<'_>,
        known: Option<WarmStart>,
        rng: &mut ChaCha8Rng,
    ) -> Result<Solution, SpectralError> {
        let (n, wanted) = (problem.laplacian.dim(), problem.wanted());
        let gains = known.as_ref().map(|k| k.gains.clone());
        let gains = gains.unwrap_or_default();
        let known = known.filter(|k| k.ritz_vectors() >= wanted);
        if self.params.method == Method::Full {
            return self.solve_dense(problem, Route::Full, gains);
        }
        if n < 4 * block_width(problem.k) {
            return self.solve_dense(problem, Route::Small, gains);
        }
        if wanted == 0 {
            return Ok(self.solve_null_space(problem, gains));
        }
        if n <= DENSE_LIMIT && known.is_none() {
            return self.solve_dense(problem, Route::Small, gains);
        }
        let found = self.solve_sparse(problem, known, rng)?;
        let convergence = &found.solved.convergence;
        let proven = convergence.certified == Some(true) && convergence.converged == problem.k;
        if n <= self.most_rescued && !proven {
            return self.rescued(problem, found);
        }
        Ok(found)
    }

    /// The dense route where a search has failed, or cannot prove that it has not, and a decomposition
    /// is still cheap: k cuts an eigenspace of more dimensions than the block has columns, on a graph
    /// of many symmetries.
    fn rescued(
        &mut self,
        problem: Problem<'_>,
        failed: Solution,
    ) -> Result<Solution, SpectralError> {
        let gains = failed.warm_start.map(|w| w.gains).unwrap_or_default();
        let mut exact = self.solve_dense(problem, Route::Rescued, gains)?;
        let spent = &failed.solved.convergence;
        exact.solved.convergence.applications += spent.applications;
        exact.solved.convergence.solves = spent.solves;
        exact.solved.convergence.restarts = spent.restarts;
        exact.searched_cold = failed.searched_cold;
        Ok(exact)
    }
}

/// Columns of a block that holds `wanted` pairs and their guards.
pub(crate) fn block_width(wanted: usize) -> usize {
    (wanted + GUARDS.max(wanted / 8)).next_multiple_of(LANES)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cholesky::faults;
    use crate::dense::laplacian_eigen;
    use crate::{LaplacianKind, testing};

    fn spectrum(k: usize) -> GrowingEigensolver {
        let params = SpectralParams {
            num_eigenpairs: k,
            tol: 1e-3,
            ..Default::default()
        };
        GrowingEigensolver::new(params, 0)
    }

    fn exact(graph: &SymmetricCsr) -> Vec<f64> {
        let laplacian = Laplacian::new(graph, LaplacianKind::Normalized);
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
        let n = whole.num_nodes() - whole.num_nodes() / 20;
        for (most_fill, cold_route) in [(MOST_FILL, Route::ShiftInvert), (0.0, Route::Products)] {
            let mut spectrum = spectrum(8);
            spectrum.most_fill = most_fill;
            for (n, route) in [(n, cold_route), (whole.num_nodes(), Route::Products)] {
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

    /// A larger shift helps where some factorisations fail; where all do it is an error, and the next refresh goes on without.
    #[test]
    fn factorisations_that_fail_cost_time_or_are_an_error() {
        let whole = testing::discovered(&testing::grid(40, 45), 1);
        let part = testing::prefix(&whole, 1700);
        assert!(
            part.num_nodes() > PROOF_LIMIT,
            "too large to be decomposed instead"
        );
        let graphs = [&part, &whole].map(|graph| (graph, exact(graph)));
        let is_right = |spectrum: &GrowingEigensolver, exact: &[f64]| {
            let pairs = spectrum.eigenpairs().unwrap();
            assert_eq!(pairs.convergence.converged, 8);
            for (found, expected) in pairs.values.iter().zip(exact) {
                assert!((found - expected).abs() < 1e-7, "{found} for {expected}");
            }
        };
        for failures in [1, 2, 3] {
            let mut spectrum = spectrum(8);
            for (graph, exact) in &graphs {
                faults::inject(failures);
                assert_eq!(spectrum.refresh(graph).unwrap().route, Route::ShiftInvert);
                is_right(&spectrum, exact);
            }
        }
        let mut spectrum = spectrum(8);
        spectrum.refresh(&part).unwrap();
        faults::inject(u32::MAX);
        let error = spectrum.refresh(&whole).unwrap_err();
        assert_eq!(error, SpectralError::NotFinite);
        faults::inject(0);
        assert!(spectrum.eigenpairs().is_none());
        assert!(spectrum.refresh(&whole).unwrap().cold_start);
        is_right(&spectrum, &graphs[1].1);
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
        let vectors = |s: &GrowingEigensolver| s.eigenpairs().unwrap().vectors.clone();
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
