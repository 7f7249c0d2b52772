//! The tests by which Ritz pairs are good enough.
//!
//! A Ritz pair (θ, v) with residual r = ‖Lv − θv‖ lies within r of some eigenvalue, and within
//! r² / gap of its own, where gap = η − θ and η is the lowest eigenvalue of L among vectors orthogonal
//! to the whole subspace (Parlett, theorem 11.7.1). η is the first eigenvalue that the guard vectors
//! do not hold. Which one that is they cannot say: their upper part may have holes. So only the
//! lowest third of them is relied upon, and of it only what has itself settled. A pair has converged when
//!
//!   r ≤ tol · λ_k   and   min(r, r² / gap) ≤ ½ tol² · λ_k:
//!
//! the second asks of the eigenvalue the accuracy that the first would give it at a gap of λ_k, and
//! bites when the next eigenvalue is close.

use crate::eigenpairs::relative_unit;

/// Part of the accuracy promised of eigenvalues, tol² · λ_k, that their error bound may take up: η is an
/// estimate.
const VALUE_SHARE: f64 = 0.5;

/// A guard has settled when its residual is below this part of its value.
const SETTLED: f64 = 0.2;

/// Accuracy that doubles allow, relative to ‖L‖.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// The residual that rounding allows relative to `unit`, where it is larger than `tol`; `norm` bounds ‖L‖.
pub(crate) fn tolerance_floor(tol: f64, unit: f64, norm: f64) -> Option<f64> {
    let floor = ROUNDING * norm / unit;
    (floor > tol).then_some(floor)
}

/// Distance of the wanted pairs from what was asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Assessment {
    /// Leading pairs that are good enough.
    pub(crate) converged: usize,
    /// The factor by which the worst wanted residual is too large; at most 1 when all have converged.
    pub(crate) excess: f64,
    /// The unit of relative tolerances: λ_k or its floor.
    pub(crate) unit: f64,
    /// Estimate of the lowest eigenvalue orthogonal to the subspace.
    pub(crate) eta: f64,
    /// Ritz value beyond which the subspace holds nothing reliable.
    pub(crate) cut: f64,
    /// λ_k and λ_{k+1} are closer than tol · λ_k.
    pub(crate) cluster_cut: bool,
}

/// Assesses the first `wanted` of the pairs with Ritz values `values` (ascending) and residual norms
/// `residuals`; `norm` bounds ‖L‖.
pub(crate) fn assess(
    values: &[f64],
    residuals: &[f64],
    wanted: usize,
    tol: f64,
    norm: f64,
) -> Assessment {
    let last = values[wanted - 1];
    let unit = relative_unit(last.max(0.0));
    let (eta, cut) = horizon(values, residuals, wanted);
    let value_tol = (VALUE_SHARE * tol * tol * unit).max(ROUNDING * norm);
    let residual_tol = (tol * unit).max(ROUNDING * norm);
    let excess = |j: usize| {
        // min(r, r²/gap) ≤ v means r ≤ v or r ≤ √(v gap).
        let gap = (eta - values[j]).max(0.0);
        let enough = value_tol.max((value_tol * gap).sqrt());
        let too_large = residuals[j] / residual_tol.min(enough);
        // A NaN must not pass for small.
        if too_large.is_nan() {
            f64::INFINITY
        } else {
            too_large
        }
    };
    let excesses: Vec<f64> = (0..wanted).map(excess).collect();
    let next = values.get(wanted).zip(residuals.get(wanted));
    Assessment {
        converged: excesses.iter().take_while(|&&e| e <= 1.0).count(),
        excess: excesses.iter().fold(0.0, |a: f64, &e| a.max(e)),
        unit,
        eta,
        cut,
        cluster_cut: next
            .is_some_and(|(&theta, &r)| theta - value_error(theta, r, eta) - last <= tol * unit),
    }
}

/// Bound on the distance from Ritz value `theta` to its eigenvalue.
pub(crate) fn value_error(theta: f64, residual: f64, eta: f64) -> f64 {
    if eta > theta {
        residual.min(residual * residual / (eta - theta))
    } else {
        residual
    }
}

/// η from the lowest third of the guards; and the Ritz value, from the lower three quarters, beyond
/// which the next filter should damp (at least a little beyond the wanted ones).
fn horizon(values: &[f64], residuals: &[f64], wanted: usize) -> (f64, f64) {
    let guards = values.len() - wanted;
    let mut eta = f64::NEG_INFINITY;
    // A basis short of rank has infinite values at its end.
    let held = values[..wanted].iter().rfind(|v| v.is_finite());
    let mut cut = 1.02 * held.copied().unwrap_or(0.0);
    for (g, (&theta, &r)) in values[wanted..]
        .iter()
        .zip(&residuals[wanted..])
        .enumerate()
    {
        if !theta.is_finite() {
            break;
        }
        if 3 * g <= guards {
            eta = eta.max(theta - r);
        }
        let settled = r <= SETTLED * theta;
        if !settled || 4 * g > 3 * guards {
            break;
        }
        cut = cut.max(theta);
    }
    (eta, cut)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_close_neighbour_demands_more_of_the_residual() {
        let residuals = [1e-3, 1e-3, 1e-3];
        let apart = assess(&[0.5, 1.0, 2.0], &residuals, 2, 1e-2, 2.0);
        assert_eq!(apart.converged, 2);
        assert!(!apart.cluster_cut);
        let close = assess(&[0.5, 1.0, 1.005], &residuals, 2, 1e-2, 2.0);
        assert_eq!(close.converged, 1, "r²/gap = 2.5e-4 > 2e-5");
        assert!(close.cluster_cut);
    }

    #[test]
    fn unsettled_guards_are_not_relied_upon() {
        // The third guard's value says nothing: its residual is as large as itself.
        let a = assess(&[1.0, 1.1, 9.0], &[1e-3, 1.0, 5.0], 1, 1e-2, 10.0);
        assert!(a.excess > 1.0);
        assert!((a.cut - 1.02).abs() < 1e-12);
    }

    #[test]
    fn the_excess_is_what_the_residual_must_shrink_by() {
        // No gap at all: the residual itself has to come down to 5e-5; with a gap of 0.5 to √2.5e-5.
        let close = assess(&[1.0, 1.0, 1.0], &[2e-3; 3], 1, 1e-2, 2.0);
        assert!((close.excess - 40.0).abs() < 1e-9);
        let apart = assess(&[1.0, 1.5], &[2e-3, 0.0], 1, 1e-2, 2.0);
        assert!((apart.excess - 2e-3 / 2.5e-5f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn exact_clusters_pass() {
        let a = assess(&[1.0, 1.0, 1.0], &[0.0, 1e-16, 1e-16], 2, 1e-3, 2.0);
        assert_eq!((a.converged, a.cluster_cut), (2, true));
    }

    #[test]
    fn columns_that_hold_nothing_are_no_horizon() {
        let none = f64::INFINITY;
        let a = assess(&[1.0, 2.0, none], &[1e-9, 1e-9, none], 1, 1e-2, 3.0);
        assert_eq!((a.converged, a.cut), (1, 2.0));
        let short = assess(&[1.0, none, none], &[1e-9, none, none], 2, 1e-2, 3.0);
        assert_eq!(short.converged, 1);
        assert!(short.cut.is_finite());
    }

    #[test]
    fn not_a_number_never_passes() {
        assert_eq!(
            assess(&[1.0, 2.0], &[f64::NAN, 0.0], 1, 1e-2, 2.0).converged,
            0
        );
    }
}
