//! The lowest pairs from products with L alone, where its factor would not fit in memory.
//!
//! The null vectors N are known, so the search runs on L + c N Nᵀ, c ≥ ‖L‖: the zero eigenvalues
//! become c, the others stay, and what is found is orthogonal to N.

use super::eigenpairs::{Eigenpairs, relative_unit};
use super::low_spectrum::Problem;
use super::solver::{residual_norms, smallest_eigenpairs};
use super::{Convergence, Laplacian, SpectralError, SpectralParams, SymmetricOperator};
use faer::{Mat, MatMut, MatRef};

/// L + c N Nᵀ.
struct Deflated<'a> {
    laplacian: &'a Laplacian<'a>,
    /// Each node's component, and its entry in the null vector of that component.
    owner: Vec<u32>,
    entry: Vec<f64>,
    components: usize,
    lift: f64,
}

impl<'a> Deflated<'a> {
    fn new(problem: Problem<'a>) -> Self {
        let rows = problem.order.position.iter().map(|&row| row as usize);
        let (owners, entries) = (problem.null_space.owners(), problem.null_space.entries());
        Self {
            laplacian: problem.laplacian,
            owner: rows.clone().map(|row| owners[row]).collect(),
            entry: rows.map(|row| entries[row]).collect(),
            components: problem.null_space.dim(),
            lift: problem.laplacian.norm_bound(),
        }
    }
}

impl SymmetricOperator for Deflated<'_> {
    fn dim(&self) -> usize {
        self.laplacian.dim()
    }

    fn apply(&self, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>) {
        self.laplacian.apply(x, y.as_mut());
        for c in 0..x.ncols() {
            let mut sums = vec![0.0; self.components];
            for (i, (&owner, &entry)) in self.owner.iter().zip(&self.entry).enumerate() {
                sums[owner as usize] += entry * x[(i, c)];
            }
            for (i, (&owner, &entry)) in self.owner.iter().zip(&self.entry).enumerate() {
                y[(i, c)] += self.lift * entry * sums[owner as usize];
            }
        }
    }
}

/// The k lowest pairs, null vectors in closed form, from `start` (user's numbering) or from random
/// vectors drawn from `seed`.
pub(super) fn lowest_by_products(
    problem: Problem<'_>,
    start: Option<Mat<f64>>,
    params: &SpectralParams,
    seed: u64,
) -> Result<Eigenpairs, SpectralError> {
    let nulls = problem.null_space.dim();
    let params = SpectralParams {
        num_eigenpairs: problem.wanted(),
        ..params.clone()
    };
    let deflated = Deflated::new(problem);
    let found = smallest_eigenpairs(&deflated, start.as_ref().map(Mat::as_ref), &params, seed)?;
    let mut vectors = problem.null_space.vectors(&problem.order.position, nulls);
    vectors.resize_with(problem.laplacian.dim(), problem.k, |i, j| {
        found.vectors[(i, j - nulls)]
    });
    let mut values = vec![0.0; nulls];
    values.extend(&found.values);
    let mut residuals = residual_norms(problem.laplacian, &vectors, &values);
    residuals[..nulls].fill(0.0);
    let unit = relative_unit(values[problem.k - 1]);
    Ok(Eigenpairs {
        values,
        vectors,
        convergence: Convergence {
            converged: nulls + found.convergence.converged,
            restarts: found.convergence.restarts,
            applications: found.convergence.applications,
            cluster_cut: found.convergence.cluster_cut,
            ..Convergence::from_residuals(residuals, unit)
        },
    })
}
