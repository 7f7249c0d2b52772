//! Proof that no eigenpair was missed.
//!
//! Small residuals show that pairs are eigenpairs, not that they are the lowest. By Sylvester's law
//! L − μI has as many negative pivots as L has eigenvalues below μ. Ritz values bound eigenvalues
//! from above, so the count for a μ just above the j-th Ritz value is at least j, and more than j
//! exactly if something below μ is missing.

use super::assess::value_error;
use super::factor::CholeskyFactor;
use super::permuted::PermutedLaplacian;
use super::subspace::Outcome;

/// The widest offset of μ above a Ritz value, relative to it.
const OFFSET: f64 = 0.05;

/// Where to count, and how many eigenvalues other than the null ones should lie below.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Checkpoint {
    mu: f64,
    expected: usize,
}

/// How many eigenvalues below about λ_k are missing; `None` if the pairs leave no gap in which to
/// count, which a cluster wider than the block does. Overwrites `factor`.
pub(super) fn count_missing(
    outcome: &Outcome,
    wanted: usize,
    nulls: usize,
    tol: f64,
    laplacian: &PermutedLaplacian,
    factor: &mut CholeskyFactor,
) -> Option<usize> {
    let margin = tol * tol * outcome.assessment.unit;
    let eta = outcome.assessment.eta;
    let place = checkpoint(&outcome.values, &outcome.residuals, wanted, (eta, margin))?;
    let count = factor.count_below(laplacian, place.mu)?;
    Some(count.saturating_sub(place.expected + nulls))
}

/// The first gap at or after the last wanted value that is wider than the values are accurate.
fn checkpoint(
    values: &[f64],
    residuals: &[f64],
    wanted: usize,
    (eta, margin): (f64, f64),
) -> Option<Checkpoint> {
    (wanted - 1..values.len() - 1).find_map(|j| {
        let next = values[j + 1] - value_error(values[j + 1], residuals[j + 1], eta);
        let gap = next - values[j];
        (gap.is_finite() && gap > 4.0 * margin).then(|| Checkpoint {
            mu: values[j] + (0.5 * gap).min(OFFSET * values[j].abs()),
            expected: j + 1,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_count_is_taken_behind_the_cluster_that_k_cuts() {
        let values = [0.1, 0.2, 0.2, 0.5, 0.9];
        let residuals = [1e-9; 5];
        let place = checkpoint(&values, &residuals, 2, (0.9, 1e-6)).unwrap();
        assert_eq!(place.expected, 3);
        assert!(place.mu > 0.2 && place.mu < 0.22);
        assert_eq!(checkpoint(&[0.2; 4], &[1e-9; 4], 2, (0.2, 1e-6)), None);
    }
}
