//! Features for every state, also for those that are newer than the features.

use crate::graph::SymmetricCsr;
use faer::{Mat, MatRef};

/// `features` with a row for each node of `adjacency`: a missing row is the mean of the rows of its neighbours that
/// have one by then, taken in order of discovery (a new node is usually found from an old one), and 0 without any.
/// Without a single column there is one constant feature. O(n k + nnz k of the new rows).
///
/// # Panics
/// If there are more rows than nodes.
pub fn extended_features(features: MatRef<'_, f64>, adjacency: &SymmetricCsr) -> Mat<f64> {
    let (known, columns) = features.shape();
    let n = adjacency.num_nodes();
    assert!(known <= n, "{known} rows of features for {n} nodes");
    if columns == 0 {
        return Mat::full(n, 1, 1.0);
    }
    let mut extended = Mat::zeros(n, columns);
    extended.subrows_mut(0, known).copy_from(features);
    for i in known..n {
        let (neighbors, _) = adjacency.row(i);
        // Neighbours are sorted, so the older ones come first.
        let older = &neighbors[..neighbors.partition_point(|&j| (j as usize) < i)];
        for c in 0..columns {
            let sum: f64 = older.iter().map(|&j| extended[(j as usize, c)]).sum();
            extended[(i, c)] = sum / older.len().max(1) as f64;
        }
    }
    extended
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shaping::fixtures::graph;

    #[test]
    fn new_rows_are_means_of_older_neighbours() {
        let adjacency = graph(6, &[(0, 1), (0, 2), (1, 2), (2, 3), (4, 5)]);
        let known = Mat::from_fn(2, 2, |i, c| (10 * i + c) as f64);
        let all = extended_features(known.as_ref(), &adjacency);
        let row = |i: usize| [all[(i, 0)], all[(i, 1)]];
        assert_eq!(row(0), [0.0, 1.0]);
        assert_eq!(row(1), [10.0, 11.0]);
        assert_eq!(row(2), [5.0, 6.0], "mean of 0 and 1");
        assert_eq!(row(3), [5.0, 6.0], "through the new node 2");
        assert_eq!(row(4), [0.0, 0.0], "no older neighbour");
        assert_eq!(row(5), [0.0, 0.0], "its only neighbour has 0");
    }

    #[test]
    fn without_columns_there_is_a_constant_one() {
        let all = extended_features(Mat::<f64>::zeros(0, 0).as_ref(), &graph(3, &[]));
        assert_eq!(all, Mat::<f64>::full(3, 1, 1.0));
    }
}
