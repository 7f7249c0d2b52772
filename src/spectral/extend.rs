//! Old eigenvectors on new nodes.
//!
//! y = x / scale (D^-1/2 x for the normalised Laplacian) varies slowly over the graph, and keeps its
//! meaning when degrees change. A new node takes the weighted mean of y over the neighbours that are
//! already known, new nodes in order of discovery; one without such a neighbour takes 0. Zero for
//! all new nodes would cost about a further solve.

use super::block::RowBlock;
use super::{Laplacian, SymmetricOperator};

/// Rows of y for the nodes that `known` (old nodes × width) does not have. Cost: O(width · edges of
/// new nodes).
pub(super) fn extend(laplacian: &Laplacian<'_>, known: &RowBlock) -> RowBlock {
    let (old, width) = (known.rows(), known.width());
    let mut fresh = RowBlock::zeros(laplacian.dim() - old, width);
    let mut mean = vec![0.0; width];
    for i in old..laplacian.dim() {
        let (neighbors, weights) = laplacian.row(i);
        let mut total = 0.0;
        mean.fill(0.0);
        for (&j, &w) in neighbors.iter().zip(weights) {
            let j = j as usize;
            if j >= i {
                break;
            }
            let row = if j < old {
                known.row(j)
            } else {
                fresh.row(j - old)
            };
            for (m, v) in mean.iter_mut().zip(row) {
                *m += w * v;
            }
            total += w;
        }
        if total > 0.0 {
            for (v, m) in fresh.row_mut(i - old).iter_mut().zip(&mean) {
                *v = m / total;
            }
        }
    }
    fresh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectral::{LaplacianKind, testing};

    #[test]
    fn new_nodes_take_the_mean_in_order_of_discovery() {
        // 0–1 known; 2 joins both with weights 1 and 3, 3 hangs on 2, 4 on nothing, 5 on 4.
        let edges = [
            (0, 1, 1.0),
            (0, 2, 1.0),
            (1, 2, 3.0),
            (2, 3, 1.0),
            (4, 5, 1.0),
        ];
        let graph = testing::from_weighted_edges(6, &edges);
        let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized).unwrap();
        let mut known = RowBlock::zeros(2, 8);
        known.row_mut(0).fill(4.0);
        known.row_mut(1).fill(8.0);
        let fresh = extend(&laplacian, &known);
        let first: Vec<f64> = (0..4).map(|i| fresh.row(i)[0]).collect();
        assert_eq!(first, [7.0, 7.0, 0.0, 0.0]);
    }
}
