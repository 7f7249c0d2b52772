//! The lowest eigenpairs of a graph that grows: which route to take, and what to carry over.
//!
//! - up to 300 nodes, or hardly more nodes than the block has columns: dense ([`super::dense`]);
//! - as many components as pairs wanted: the null space alone, in closed form;
//! - else filtered subspace iteration on (L + σI)⁻¹ ([`super::subspace`]), from the vectors of the
//!   last refresh, or from a block Lanczos run where there are none;
//! - where the factor would not fit: restarted block Lanczos on L ([`super::solver`]).

use super::block::{LANES, RowBlock};
use super::dense::laplacian_eigen;
use super::eigenpairs::{Convergence, Eigenpairs, relative_unit};
use super::elimination::EliminationOrder;
use super::factor::{CholeskyFactor, FactorBuffers};
use super::null_space::NullSpace;
use super::permuted::PermutedLaplacian;
use super::search::{Found, Search};
use super::solver::{DENSE_LIMIT, residual_norms, smallest_eigenpairs};
use super::start::Remembered;
use super::{Laplacian, Method, SpectralError, SpectralParams, SymmetricOperator};
use crate::graph::Csr;
use crate::seeds::{Stream, stream};
use faer::Mat;
use rand_chacha::ChaCha8Rng;

/// Least number of guard columns beside the wanted ones; one in eight if that is more.
const GUARDS: usize = 4;

/// Graphs up to this size are always proven complete by an inertia count, which costs a millisecond there, and are
/// decomposed whole where the proof fails.
pub(super) const PROOF_LIMIT: usize = 1500;

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
    params: SpectralParams,
    seed: u64,
    refreshes: u64,
    pairs: Option<Eigenpairs>,
    remembered: Option<Remembered>,
    order: Option<EliminationOrder>,
    /// As [`MOST_FILL`]; tests set it lower.
    most_fill: f64,
    workspace: Workspace,
}

/// Big arrays whose contents do not outlive a refresh.
#[derive(Debug, Default)]
struct Workspace {
    permuted: PermutedLaplacian,
    factor: FactorBuffers,
    /// n × block width each.
    x: RowBlock,
    z: RowBlock,
}

impl Clone for Workspace {
    /// An empty one: nothing in it is needed again.
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl LowSpectrum {
    /// Nothing yet. `params` are checked by the first [`refresh`](Self::refresh).
    pub fn new(params: SpectralParams, seed: u64) -> Self {
        Self {
            params,
            seed,
            refreshes: 0,
            pairs: None,
            remembered: None,
            order: None,
            most_fill: MOST_FILL,
            workspace: Workspace::default(),
        }
    }

    /// The pairs of the last refresh: ascending values, unit vectors in the user's numbering.
    pub fn eigenpairs(&self) -> Option<&Eigenpairs> {
        self.pairs.as_ref()
    }

    /// The pairs of the last refresh, for keeps.
    pub fn into_eigenpairs(self) -> Option<Eigenpairs> {
        self.pairs
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
        if self.params.method != Method::Warm
            || self.remembered.as_ref().is_some_and(|r| r.nodes() > n)
        {
            self.remembered = None;
            self.order = None;
        }
        let k = self.params.num_eigenpairs.min(n);
        let dense =
            self.params.method == Method::Full || n <= DENSE_LIMIT || n < 4 * block_width(k);
        let nothing_known = self.remembered.is_none();
        let (pairs, cold_start) = if dense {
            (self.solve_dense(&laplacian, k)?, nothing_known)
        } else {
            let (pairs, cold_start) = self.solve_sparse(&laplacian, k, &mut rng)?;
            let mut pairs = self.rescued(pairs, &laplacian)?;
            if !self.params.certify {
                pairs.convergence.certified = None;
            }
            (pairs, cold_start)
        };
        self.refreshes += 1;
        let refresh = SpectrumRefresh {
            nodes: n,
            edges: laplacian.num_edges(),
            cold_start,
            eigenvalues: pairs.values.clone(),
            convergence: pairs.convergence.clone(),
        };
        self.pairs = Some(pairs);
        Ok(refresh)
    }

    /// The dense route where the sparse one has failed, or cannot prove that it has not, and a decomposition is still
    /// cheap: k cuts an eigenspace of more dimensions than the block has columns, on a graph of many symmetries.
    fn rescued(
        &mut self,
        pairs: Eigenpairs,
        laplacian: &Laplacian<'_>,
    ) -> Result<Eigenpairs, SpectralError> {
        let k = pairs.values.len();
        let proven = pairs.convergence.certified == Some(true);
        if laplacian.dim() > PROOF_LIMIT || (proven && pairs.convergence.converged == k) {
            return Ok(pairs);
        }
        let mut exact = self.solve_dense(laplacian, k)?;
        exact.convergence.applications += pairs.convergence.applications;
        exact.convergence.solves = pairs.convergence.solves;
        exact.convergence.restarts = pairs.convergence.restarts;
        Ok(exact)
    }

    fn solve_dense(
        &mut self,
        laplacian: &Laplacian<'_>,
        k: usize,
    ) -> Result<Eigenpairs, SpectralError> {
        let (values, all) = laplacian_eigen(laplacian)?;
        let kept = values.len().min(block_width(k) + 1);
        let nulls = values.partition_point(|&v| v == 0.0).min(kept);
        self.remember(laplacian, &values[..kept], nulls, None, |i, j| all[(i, j)]);
        let vectors = all.subcols(0, k).to_owned();
        let residuals = residual_norms(laplacian, &vectors, &values[..k]);
        let unit = relative_unit(k.checked_sub(1).map_or(0.0, |last| values[last]));
        let cluster_cut = k > 0
            && values
                .get(k)
                .is_some_and(|next| next - values[k - 1] <= self.params.tol * unit);
        Ok(Eigenpairs {
            values: values[..k].to_vec(),
            vectors,
            convergence: Convergence {
                converged: k,
                applications: k,
                cluster_cut,
                certified: self.params.certify.then_some(true),
                ..Convergence::from_residuals(residuals, unit)
            },
        })
    }

    /// The pairs, and whether the search began without earlier vectors.
    fn solve_sparse(
        &mut self,
        laplacian: &Laplacian<'_>,
        k: usize,
        rng: &mut ChaCha8Rng,
    ) -> Result<(Eigenpairs, bool), SpectralError> {
        let order = EliminationOrder::new(laplacian, self.order.as_ref());
        let null_space = NullSpace::new(laplacian, &order);
        let nulls = null_space.dim();
        if nulls >= k {
            let cold = self.remembered.is_none();
            let mut pairs = null_pairs(&order, &null_space, k);
            pairs.convergence.certified = Some(true);
            let entry = |i, j| pairs.vectors[(i, j)];
            self.remember(laplacian, &pairs.values, k, None, entry);
            self.order = Some(order);
            return Ok((pairs, cold));
        }
        self.workspace.permuted.assign(laplacian, &order);
        let buffers = std::mem::take(&mut self.workspace.factor);
        let factor = (order.fill <= self.most_fill)
            .then(|| {
                let threads = self.params.threads;
                CholeskyFactor::analyze(&self.workspace.permuted, &order, threads, buffers)
            })
            .flatten();
        let solved = match factor {
            Some(factor) => self.solve_with(laplacian, (&order, &null_space), factor, k, rng),
            None => self.solve_without_factor(laplacian, nulls),
        };
        self.order = Some(order);
        solved
    }

    fn solve_with(
        &mut self,
        laplacian: &Laplacian<'_>,
        (order, null_space): (&EliminationOrder, &NullSpace),
        mut factor: CholeskyFactor,
        k: usize,
        rng: &mut ChaCha8Rng,
    ) -> Result<(Eigenpairs, bool), SpectralError> {
        let wanted = k - null_space.dim();
        let Workspace { permuted, x, z, .. } = &mut self.workspace;
        let search = Search {
            laplacian,
            order,
            null_space,
            permuted,
            params: &self.params,
            wanted,
            width: block_width(wanted),
        };
        let usable = self
            .remembered
            .as_ref()
            .filter(|r| r.ritz_vectors() >= wanted);
        let cold = usable.is_none();
        let found = search.run(usable, &mut factor, (x, z), rng)?;
        self.workspace.factor = factor.into_buffers();
        let pairs = self.collect(order, null_space, &found, k);
        self.remember_block(laplacian, order, null_space, &found);
        Ok((pairs, cold))
    }

    /// Null vectors, then the wanted Ritz vectors, in the user's numbering.
    fn collect(
        &self,
        order: &EliminationOrder,
        null_space: &NullSpace,
        found: &Found,
        k: usize,
    ) -> Eigenpairs {
        let nulls = null_space.dim();
        let outcome = &found.outcome;
        let mut pairs = null_pairs(order, null_space, k.min(nulls));
        let mut vectors = Mat::zeros(order.node.len(), k);
        vectors.subcols_mut(0, nulls).copy_from(&pairs.vectors);
        for (i, &u) in order.node.iter().enumerate() {
            for (j, &v) in self.workspace.x.row(i)[..k - nulls].iter().enumerate() {
                vectors[(u as usize, nulls + j)] = v;
            }
        }
        let mut residuals = vec![0.0; nulls];
        residuals.extend(&outcome.residuals[..k - nulls]);
        pairs.values.extend(&outcome.values[..k - nulls]);
        Eigenpairs {
            values: pairs.values,
            vectors,
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
        }
    }

    /// Keeps the whole block, guards included, for the next refresh.
    fn remember_block(
        &mut self,
        laplacian: &Laplacian<'_>,
        order: &EliminationOrder,
        null_space: &NullSpace,
        found: &Found,
    ) {
        let nulls = null_space.dim();
        let kept_nulls = if nulls > 1 {
            null_pairs(order, null_space, nulls).vectors
        } else {
            Mat::new()
        };
        let finite = found.outcome.values.iter().take_while(|v| v.is_finite());
        let mut values = vec![0.0; nulls];
        values.extend(finite);
        let block = std::mem::take(&mut self.workspace.x);
        let gain = Some(found.outcome.gain_needed);
        self.remember(laplacian, &values, nulls, gain, |i, j| {
            if j < nulls {
                kept_nulls[(i, j)]
            } else {
                block.row(order.position[i] as usize)[j - nulls]
            }
        });
        self.workspace.x = block;
    }

    fn remember(
        &mut self,
        laplacian: &Laplacian<'_>,
        values: &[f64],
        nulls: usize,
        gain: Option<f64>,
        entry: impl Fn(usize, usize) -> f64,
    ) {
        if self.params.method == Method::Warm {
            let gain = gain.or(self.remembered.as_ref().map(|r| r.gain));
            // Its memory is free before as much again is taken.
            self.remembered = None;
            self.remembered = Some(Remembered::new(laplacian, values, nulls, gain, entry));
        }
    }

    /// Restarted Lanczos on L itself, for graphs whose factor would not fit.
    fn solve_without_factor(
        &mut self,
        laplacian: &Laplacian<'_>,
        nulls: usize,
    ) -> Result<(Eigenpairs, bool), SpectralError> {
        let n = laplacian.dim();
        let known = self.pairs.as_ref().filter(|_| self.remembered.is_some());
        let start = known.map(|pairs| {
            Mat::from_fn(n, pairs.vectors.ncols(), |i, j| {
                if i < pairs.vectors.nrows() {
                    pairs.vectors[(i, j)]
                } else {
                    0.0
                }
            })
        });
        let start_view = start.as_ref().map(Mat::as_ref);
        let seed = self.seed.wrapping_add(self.refreshes);
        let mut pairs = smallest_eigenpairs(laplacian, start_view, &self.params, seed)?;
        pairs.values[..nulls].fill(0.0);
        self.remember(laplacian, &pairs.values, nulls, None, |i, j| {
            pairs.vectors[(i, j)]
        });
        Ok((pairs, start.is_none()))
    }
}

/// Columns of a block that holds `wanted` pairs and their guards.
fn block_width(wanted: usize) -> usize {
    (wanted + GUARDS.max(wanted / 8)).next_multiple_of(LANES)
}

/// The first k null vectors, by their components' order of discovery.
fn null_pairs(order: &EliminationOrder, null_space: &NullSpace, k: usize) -> Eigenpairs {
    let mut vectors = Mat::zeros(order.node.len(), k);
    for c in 0..k {
        let (support, entries) = null_space.vector(c);
        for (&u, &entry) in order.node[support].iter().zip(entries) {
            vectors[(u as usize, c)] = entry;
        }
    }
    Eigenpairs {
        values: vec![0.0; k],
        vectors,
        convergence: Convergence {
            converged: k,
            cluster_cut: null_space.dim() > k,
            ..Convergence::from_residuals(vec![0.0; k], relative_unit(0.0))
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectral::{LaplacianKind, testing};

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
