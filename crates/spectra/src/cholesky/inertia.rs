//! Inertia: how many eigenvalues lie below μ, and how far rounding may have moved them.
//!
//! The computed C S Cᵀ is the exact factorisation of L − μI + E. Each entry of E is a sum's rounding:
//! |E| ≤ γ_t |C| |C|ᵀ, γ_t = t u / (1 − t u), with at most t terms in any entry (Higham, *Accuracy and
//! Stability of Numerical Algorithms*, theorem 9.3). Hence ‖E‖ ≤ γ_t ‖C‖_F², and from the diagonal of
//! C S Cᵀ = L − μI + E follows ‖C‖_F² ≈ tr(L − μI) + 2 Σ ‖c_j‖² over the columns with a negative pivot:
//! positive pivots cannot blow up, and of negative ones there are few. By Weyl's theorem no eigenvalue
//! of L is further than ‖E‖ from one of the matrix whose signs were counted.

use super::dense_front::Pivots;
use super::permuted::PermutedLaplacian;
use super::subtrees::Subtrees;

/// The outcome of a count of negative pivots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Inertia {
    /// Negative pivots of L − μI: no more eigenvalues than that lie below `certain`.
    pub(crate) negative: usize,
    /// μ less the bound on rounding.
    pub(crate) certain: f64,
}

impl Inertia {
    /// What `pivots` of the factorisation of L − μI by `structure` say.
    pub(crate) fn new(
        pivots: Pivots,
        mu: f64,
        laplacian: &PermutedLaplacian,
        structure: &Subtrees,
    ) -> Self {
        let trace: f64 = (0..laplacian.dim())
            .map(|j| (laplacian.diagonal(j) - mu).abs())
            .sum();
        let highest = structure.all().map(highest).max().unwrap_or(0);
        let negative = (pivots.negative * highest) as f64 * pivots.growth;
        // Twice the unit roundoff for each term, and a few for the root, the division and the shift.
        let gamma = f64::EPSILON * (longest_sum(structure) + 8) as f64;
        Self {
            negative: pivots.negative,
            certain: mu - gamma * (trace + 2.0 * negative),
        }
    }
}

/// Most rows in a column of a part of the factor.
fn highest(part: &super::subtrees::Part) -> usize {
    let supernodes = &part.supernodes;
    (0..supernodes.len())
        .map(|s| supernodes.shape(s).height())
        .max()
        .unwrap_or(0)
}

/// Most entries in a row of the factor, which is the most products in the sum for any entry.
fn longest_sum(structure: &Subtrees) -> usize {
    let mut separator = vec![0usize; structure.separator.num_rows()];
    let mut longest = 0;
    for part in structure.all() {
        let own = part.num_columns();
        let mut entries = vec![0usize; part.num_rows()];
        for s in 0..part.supernodes.len() {
            let shape = part.supernodes.shape(s);
            for c in 0..shape.size {
                entries[shape.first + c] += c + 1;
            }
            for &row in shape.rows {
                entries[row as usize] += shape.size;
            }
        }
        for (&row, &count) in part.boundary_in_separator().iter().zip(&entries[own..]) {
            separator[row as usize] += count;
        }
        // The separator comes last: what the parts have in its rows is known by then.
        let is_separator = std::ptr::eq(part, &structure.separator);
        let sums = entries[..own].iter().enumerate();
        let whole = sums.map(|(row, &count)| count + if is_separator { separator[row] } else { 0 });
        longest = longest.max(whole.max().unwrap_or(0));
    }
    longest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cholesky::elimination::EliminationOrder;
    use crate::cholesky::factor::{CholeskyFactor, FactorBuffers};
    use crate::dense::laplacian_eigen;
    use crate::{Laplacian, LaplacianKind, testing};

    #[test]
    fn the_longest_sum_is_the_longest_row_of_the_factor() {
        // A path eliminated from its ends has at most two entries beside the diagonal in a row; every row of
        // a complete graph's factor is full up to the diagonal. Relaxed supernodes store a few zeros more.
        let longest = |graph: crate::SymmetricCsr| {
            let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized);
            let order = EliminationOrder::new(&laplacian, None);
            let mut l = PermutedLaplacian::default();
            l.assign(&laplacian, &order, 1);
            longest_sum(&Subtrees::new(&l, &order.parent, 1).unwrap())
        };
        assert_eq!(longest(testing::complete(70)), 70);
        assert!((2..=6).contains(&longest(testing::path(5000))));
        assert_eq!(longest(testing::star(3000)), 3000);
    }

    #[test]
    fn no_more_eigenvalues_than_counted_lie_below_what_is_certain() {
        for graph in [
            testing::grid(20, 21),
            testing::random(300, 5.0, 1),
            testing::complete(90),
        ] {
            let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized);
            let (values, _) = laplacian_eigen(&laplacian).unwrap();
            let order = EliminationOrder::new(&laplacian, None);
            let mut l = PermutedLaplacian::default();
            l.assign(&laplacian, &order, 1);
            let factor = CholeskyFactor::analyze(&l, &order, 1, FactorBuffers::default()).unwrap();
            for value in values.iter().step_by(7) {
                // So close to an eigenvalue that signs are luck.
                for offset in [-1e-9, -1e-13, -1e-15, 0.0, 1e-15, 1e-13, 1e-9] {
                    if let Some(count) = factor.count_below(&l, value + offset) {
                        let below = values
                            .iter()
                            .filter(|&&v| v < count.certain - 1e-14)
                            .count();
                        assert!(
                            below <= count.negative,
                            "{value} + {offset}: {count:?}, {below}"
                        );
                    }
                }
            }
            // Not halfway: there a leading block of the complete graph's matrix is singular, and a pivot all but vanishes.
            let mu = 0.37 * values.iter().find(|&&v| v > 0.0).unwrap();
            let clear = factor.count_below(&l, mu).unwrap();
            assert!(mu - clear.certain < 1e-9, "{clear:?}");
        }
    }
}
