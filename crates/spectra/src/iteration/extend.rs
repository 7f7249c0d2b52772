//! Old eigenvectors on new nodes.
//!
//! y = x / scale (D^-1/2 x for the normalised Laplacian) varies slowly over the graph, and keeps its
//! meaning when degrees change. A new node takes the weighted mean of y over the neighbours that are
//! already known, new nodes in order of discovery; one without such a neighbour takes 0. Zero for
//! all new nodes would cost about a further solve.

use crate::block::RowBlock;
use crate::cholesky::EliminationOrder;
use crate::{Laplacian, SymmetricOperator};

/// Overwrites the first `columns` entries in the rows of the nodes from `old` on, `x` being in
/// elimination order and holding the nodes before them. Cost: O(columns · edges of new nodes).
pub(crate) fn extend(
    laplacian: &Laplacian<'_>,
    order: &EliminationOrder,
    (old, columns): (usize, usize),
    x: &mut RowBlock,
) {
    let mut mean = vec![0.0; columns];
    for i in old..laplacian.dim() {
        let (neighbors, weights) = laplacian.row(i);
        let mut total = 0.0;
        mean.fill(0.0);
        for (&j, &w) in neighbors.iter().zip(weights) {
            let j = j as usize;
            if j >= i {
                break;
            }
            let share = w / laplacian.scale(j);
            for (m, v) in mean.iter_mut().zip(x.row(order.position[j] as usize)) {
                *m += share * v;
            }
            total += w;
        }
        let factor = if total > 0.0 {
            laplacian.scale(i) / total
        } else {
            0.0
        };
        let row = x.row_mut(order.position[i] as usize);
        for (v, m) in row.iter_mut().zip(&mean) {
            *v = factor * m;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LaplacianKind, testing};

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
        for kind in [LaplacianKind::Normalized, LaplacianKind::Combinatorial] {
            let laplacian = Laplacian::new(&graph, kind);
            let order = EliminationOrder::new(&laplacian, None);
            let at = |u: usize| order.position[u] as usize;
            let mut x = RowBlock::zeros(6, 8);
            for (u, y) in [(0, 4.0), (1, 8.0), (4, 99.0)] {
                x.row_mut(at(u)).fill(y * laplacian.scale(u));
            }
            extend(&laplacian, &order, (2, 8), &mut x);
            for (u, expected) in [(2, 7.0), (3, 7.0), (4, 0.0), (5, 0.0)] {
                let y = x.row(at(u))[7] / laplacian.scale(u);
                assert!((y - expected).abs() < 1e-14, "node {u}: {y}");
            }
        }
    }
}
