//! The lowest eigenpairs of any symmetric operator, from products alone.
//!
//! Policy over [`BlockLanczos`]: expand until the basis is full, test, restart from the best Ritz
//! vectors. It needs no factorisation and no knowledge of where the matrix comes from. Where the low
//! end of the spectrum is crowded, as on large grids, shift-and-invert ([`crate::GrowingEigensolver`]) needs
//! far fewer steps.

use super::assess::assess;
use super::lanczos::{BlockLanczos, RitzPairs};
use crate::dense::symmetric_eigen;
use crate::eigenpairs::{Convergence, Eigenpairs};
use crate::random::stream;
use crate::{SpectralError, SpectralParams, SymmetricOperator};
use faer::{Mat, MatRef};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Matrices up to this order are decomposed whole.
pub(crate) const DENSE_LIMIT: usize = 300;

/// Columns of a random start block.
const DEFAULT_BLOCK: usize = 8;

/// Blocks added between two restarts.
const EXPANSIONS: usize = 8;

/// The `params.num_eigenpairs` lowest eigenpairs of `operator`, all of them if it has fewer.
///
/// `start` (n × any number of columns) is where to look first, such as the eigenvectors of a similar
/// matrix; without it the search starts from random vectors drawn from `seed`. Orders up to 300, and
/// operators with hardly more rows than the basis would have columns, are formed and decomposed
/// whole. `params.laplacian`, `method`, `certify` and `threads` are not used.
///
/// Memory: n × (k + about 70) doubles. Cost per restart: 8 products with a block and O(n k²).
///
/// # Errors
/// [`SpectralError::Parameter`] for parameters out of range, [`SpectralError::NotFinite`] if the
/// operator or `start` yields NaN or infinity.
///
/// # Panics
/// If `start` has other than `operator.dim()` rows.
///
/// ```
/// use eigentrail_spectra::{SpectralParams, smallest_eigenpairs};
/// use faer::Mat;
///
/// let matrix = Mat::from_fn(500, 500, |i, j| if i == j { i as f64 } else { 0.0 });
/// let params = SpectralParams { num_eigenpairs: 3, tol: 1e-8, ..Default::default() };
/// let pairs = smallest_eigenpairs(&matrix.as_ref(), None, &params, 0)?;
/// assert!((pairs.values[2] - 2.0).abs() < 1e-12);
/// # Ok::<(), eigentrail_spectra::SpectralError>(())
/// ```
pub fn smallest_eigenpairs<A: SymmetricOperator>(
    operator: &A,
    start: Option<MatRef<'_, f64>>,
    params: &SpectralParams,
    seed: u64,
) -> Result<Eigenpairs, SpectralError> {
    params.validate()?;
    let n = operator.dim();
    if let Some(start) = start {
        assert_eq!(
            start.nrows(),
            n,
            "start must have one row per row of the operator"
        );
        if !start.is_all_finite() {
            return Err(SpectralError::NotFinite);
        }
    }
    let k = params.num_eigenpairs.min(n);
    let mut rng = stream(seed);
    let start = start_block(n, k, start, &mut rng);
    let kept = k + start.ncols().max(4);
    let capacity = kept + (EXPANSIONS + 1) * start.ncols();
    if n <= DENSE_LIMIT || 2 * capacity > n {
        return whole(operator, k);
    }
    let lanczos = BlockLanczos::initialize(operator, start.as_ref(), capacity, rng);
    restarted(operator, lanczos, k, kept, params)
}

/// The given vectors and one random one beside them, or a random block.
fn start_block(
    n: usize,
    k: usize,
    given: Option<MatRef<'_, f64>>,
    rng: &mut ChaCha8Rng,
) -> Mat<f64> {
    let given = given.filter(|g| g.ncols() > 0);
    let taken = given.map_or(0, |g| g.ncols().min(k));
    let columns = if given.is_some() {
        taken + 1
    } else {
        DEFAULT_BLOCK
    };
    let mut start = Mat::from_fn(n, columns, |_, _| 2.0 * rng.random::<f64>() - 1.0);
    if let Some(given) = given {
        start
            .subcols_mut(0, taken)
            .copy_from(given.subcols(0, taken));
    }
    start
}

/// Forms the matrix and decomposes it.
fn whole<A: SymmetricOperator>(operator: &A, k: usize) -> Result<Eigenpairs, SpectralError> {
    let n = operator.dim();
    let mut matrix = Mat::zeros(n, n);
    operator.apply(Mat::<f64>::identity(n, n).as_ref(), matrix.as_mut());
    let (values, vectors) = symmetric_eigen(matrix.as_ref())?;
    let vectors = vectors.subcols(0, k).to_owned();
    let residuals = residual_norms(operator, &vectors, &values[..k]);
    let unit = unit_of(&values[..k]);
    Ok(Eigenpairs {
        values: values[..k].to_vec(),
        vectors,
        convergence: Convergence {
            converged: k,
            applications: n + k,
            ..Convergence::from_residuals(residuals, unit)
        },
    })
}

fn restarted<A: SymmetricOperator>(
    operator: &A,
    mut lanczos: BlockLanczos<'_, A>,
    k: usize,
    kept: usize,
    params: &SpectralParams,
) -> Result<Eigenpairs, SpectralError> {
    let mut applications = 0;
    for restarts in 0.. {
        while lanczos.can_expand() {
            let before = lanczos.len();
            lanczos.expand();
            applications += lanczos.len() - before;
        }
        let pairs = lanczos.ritz_pairs()?;
        let norm = pairs.values.last().map_or(0.0, |v| v.abs());
        let assessment = assess(&pairs.values, &pairs.residuals, k, params.tol, norm);
        if assessment.converged == k || restarts == params.max_restarts {
            let vectors = lanczos.ritz_vectors(&pairs, k);
            let converged = (assessment.converged, assessment.cluster_cut);
            return Ok(finished(
                operator,
                &pairs,
                vectors,
                converged,
                restarts,
                applications + k,
            ));
        }
        lanczos.restart(&pairs, kept);
    }
    unreachable!("the loop over restarts has no end of its own")
}

fn finished<A: SymmetricOperator>(
    operator: &A,
    pairs: &RitzPairs,
    vectors: Mat<f64>,
    (converged, cluster_cut): (usize, bool),
    restarts: usize,
    applications: usize,
) -> Eigenpairs {
    let values = pairs.values[..vectors.ncols()].to_vec();
    let residuals = residual_norms(operator, &vectors, &values);
    let unit = unit_of(&values);
    Eigenpairs {
        values,
        vectors,
        convergence: Convergence {
            converged,
            restarts,
            applications,
            cluster_cut,
            ..Convergence::from_residuals(residuals, unit)
        },
    }
}

fn unit_of(values: &[f64]) -> f64 {
    values
        .last()
        .map_or(1.0, |v| v.abs().max(crate::eigenpairs::LAMBDA_FLOOR))
}

/// ‖A v − λ v‖ of each column.
pub(crate) fn residual_norms<A: SymmetricOperator>(
    operator: &A,
    vectors: &Mat<f64>,
    values: &[f64],
) -> Vec<f64> {
    let mut product = Mat::zeros(vectors.nrows(), vectors.ncols());
    operator.apply(vectors.as_ref(), product.as_mut());
    (0..values.len())
        .map(|j| (product.col(j) - faer::Scale(values[j]) * vectors.col(j)).norm_l2())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Laplacian, LaplacianKind, testing};

    fn params(k: usize, tol: f64) -> SpectralParams {
        SpectralParams {
            num_eigenpairs: k,
            tol,
            ..Default::default()
        }
    }

    #[test]
    fn repeated_eigenvalues_of_a_torus_are_all_found() {
        // Product of two cycles: eigenvalues (2 − cos a − cos b) / 2, mostly four- and eightfold.
        let m = 24;
        let edges: Vec<_> = (0..m * m)
            .flat_map(|u| {
                let (r, c) = (u / m, u % m);
                [(u, r * m + (c + 1) % m), (u, (r + 1) % m * m + c)]
            })
            .collect();
        let graph = testing::from_edges(m * m, &edges);
        let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized);
        let angle = |i: usize| (std::f64::consts::TAU * i as f64 / m as f64).cos();
        let mut expected: Vec<f64> = (0..m * m)
            .map(|u| (2.0 - angle(u / m) - angle(u % m)) / 2.0)
            .collect();
        expected.sort_by(f64::total_cmp);
        let cold = smallest_eigenpairs(&laplacian, None, &params(21, 1e-6), 3).unwrap();
        assert_eq!(cold.convergence.converged, 21);
        for (found, expected) in cold.values.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-9);
        }
        let start = Some(cold.vectors.as_ref());
        let warm = smallest_eigenpairs(&laplacian, start, &params(21, 1e-6), 3).unwrap();
        assert!(warm.convergence.applications <= cold.convergence.applications);
        assert_eq!(warm.convergence.restarts, 0);
    }

    #[test]
    fn small_orders_and_k_beyond_n_are_exact() {
        for n in [0, 1, 2, 30] {
            let matrix = Mat::from_fn(n, n, |i, j| if i == j { i as f64 - 3.0 } else { 0.0 });
            let pairs = smallest_eigenpairs(&matrix.as_ref(), None, &params(50, 1e-3), 0).unwrap();
            assert_eq!(pairs.values.len(), n);
            for (i, v) in pairs.values.iter().enumerate() {
                assert!((v - (i as f64 - 3.0)).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn not_converging_is_a_result() {
        let graph = testing::path(2000);
        let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized);
        let mut hopeless = params(10, 1e-9);
        hopeless.max_restarts = 1;
        let pairs = smallest_eigenpairs(&laplacian, None, &hopeless, 1).unwrap();
        assert!(pairs.convergence.converged < 10);
        assert_eq!(pairs.values.len(), 10);
        assert!(pairs.convergence.max_relative_residual > 1e-9);
    }

    #[test]
    fn not_a_number_is_an_error() {
        let matrix = Mat::from_fn(10, 10, |_, _| f64::NAN);
        assert!(smallest_eigenpairs(&matrix.as_ref(), None, &params(2, 1e-3), 0).is_err());
    }
}
