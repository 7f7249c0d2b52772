//! Results of a solver: pairs, and the facts of how it came by them.

use faer::Mat;

/// Stands in for λ_k in relative tolerances where λ_k itself is 0, which it is when a graph has at
/// least k components.
pub const LAMBDA_FLOOR: f64 = 1e-10;

/// The k lowest eigenpairs, values ascending and repeated by multiplicity.
#[derive(Clone, Debug)]
pub struct Eigenpairs {
    /// λ_1 ≤ … ≤ λ_k.
    pub values: Vec<f64>,
    /// n × k, orthonormal columns; column j belongs to `values[j]`.
    pub vectors: Mat<f64>,
    /// Cost and quality.
    pub convergence: Convergence,
}

/// Cost of an eigensolve, and how well it did. Not converging is a result, not an error.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Convergence {
    /// Leading pairs with ‖Lv − λv‖ ≤ tol · λ_k and an estimated error of λ of at most tol² · λ_k.
    pub converged: usize,
    /// ‖Lv − λv‖₂ of each pair, measured with the returned vectors; 0 for null vectors known in
    /// closed form.
    pub residual_norms: Vec<f64>,
    /// Largest residual norm ÷ λ_k (÷ [`LAMBDA_FLOOR`] where λ_k is 0).
    pub max_relative_residual: f64,
    /// Rayleigh–Ritz steps after the first.
    pub restarts: usize,
    /// Columns multiplied by L.
    pub applications: usize,
    /// Columns solved with the factor of L + σI.
    pub solves: usize,
    /// λ_k and λ_{k+1} are closer than tol · λ_k: they belong to one cluster, cut by k, and the
    /// k-space is ill-posed at its edge.
    pub cluster_cut: bool,
    /// Whether the pairs are proven to be the k lowest, none missed, each value within tol · λ_k of its
    /// eigenvalue: `Some(true)` by an inertia count that agrees with the residuals of clusters of settled
    /// pairs, or by a decomposition of the whole matrix; `Some(false)` if a count shows that some are
    /// missing; `None` if no proof was tried or found possible.
    pub certified: Option<bool>,
    /// The relative residual that rounding allows, where it is larger than the tolerance asked for:
    /// pairs count as converged when they are that good.
    pub tolerance_floor: Option<f64>,
    /// Pairs that the inertia count found missing and a further search then added.
    pub repaired: usize,
}

/// λ_k as the unit of relative tolerances.
pub(crate) fn relative_unit(lambda_k: f64) -> f64 {
    if lambda_k > 0.0 {
        lambda_k
    } else {
        LAMBDA_FLOOR
    }
}

impl Convergence {
    /// Facts of pairs whose residuals were measured against `unit`, λ_k or its floor.
    pub(crate) fn from_residuals(residual_norms: Vec<f64>, unit: f64) -> Self {
        let largest = residual_norms.iter().fold(0.0, |a: f64, &r| a.max(r));
        Self {
            max_relative_residual: largest / unit,
            residual_norms,
            ..Self::default()
        }
    }
}
