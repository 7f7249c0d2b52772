//! The elimination tree, and its postorder.
//!
//! parent(j) = the first row below the diagonal in column j of the Cholesky factor. Liu (1990), *The
//! role of elimination trees in sparse factorization*, algorithm 4.2: walk from each entry (i, j) of
//! the upper triangle up to the present root and hang it below j, with path compression.

use std::ops::Range;

/// No parent.
pub(super) const ROOT: u32 = u32::MAX;

/// Parents in the elimination forest of a matrix given by its strict upper triangle, by columns.
/// Cost: O(nnz log n).
pub(super) fn elimination_tree(column_starts: &[u32], rows: &[u32]) -> Vec<u32> {
    let n = column_starts.len() - 1;
    let mut parent = vec![ROOT; n];
    let mut ancestor = vec![ROOT; n];
    for j in 0..n {
        for &row in &rows[column_starts[j] as usize..column_starts[j + 1] as usize] {
            let mut i = row;
            while i != ROOT && (i as usize) < j {
                let above = std::mem::replace(&mut ancestor[i as usize], j as u32);
                if above == ROOT {
                    parent[i as usize] = j as u32;
                }
                i = above;
            }
        }
    }
    parent
}

/// The nodes of a forest, children before parents and every subtree in one stretch; and the stretch
/// of each tree. Cost: O(n).
pub(super) fn postorder(parent: &[u32]) -> (Vec<u32>, Vec<Range<usize>>) {
    let n = parent.len();
    let mut first_child = vec![ROOT; n];
    let mut sibling = vec![ROOT; n];
    for i in (0..n).rev() {
        if parent[i] != ROOT {
            sibling[i] = std::mem::replace(&mut first_child[parent[i] as usize], i as u32);
        }
    }
    let mut order = Vec::with_capacity(n);
    let mut trees = Vec::new();
    let mut path = Vec::new();
    for root in (0..n).filter(|&i| parent[i] == ROOT) {
        let start = order.len();
        path.push(root as u32);
        while let Some(&i) = path.last() {
            // A child is taken off its parent's list when it is entered.
            let child = first_child[i as usize];
            if child == ROOT {
                order.push(i);
                path.pop();
            } else {
                first_child[i as usize] = sibling[child as usize];
                path.push(child);
            }
        }
        trees.push(start..order.len());
    }
    (order, trees)
}

/// The forest `parent` with its nodes numbered in `order`.
pub(super) fn renumbered(parent: &[u32], order: &[u32]) -> Vec<u32> {
    let mut position = vec![ROOT; parent.len()];
    for (i, &node) in order.iter().enumerate() {
        position[node as usize] = i as u32;
    }
    let above = |&node: &u32| match parent[node as usize] {
        ROOT => ROOT,
        p => position[p as usize],
    };
    order.iter().map(above).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tree_of_a_small_matrix_is_the_one_worked_by_hand() {
        // Edges 0–3, 1–2, 2–4, 3–4: eliminating 0 fills nothing, column 0 meets row 3 first.
        let starts = [0, 0, 0, 1, 2, 4];
        let rows = [1, 0, 2, 3];
        let parent = elimination_tree(&starts, &rows);
        assert_eq!(parent, [3, 2, 4, 4, ROOT]);
    }

    #[test]
    fn fill_is_followed() {
        // Edges 0–1, 0–2: eliminating 0 joins 1 and 2.
        assert_eq!(elimination_tree(&[0, 0, 1, 2], &[0, 0]), [1, 2, ROOT]);
    }

    #[test]
    fn postorder_puts_children_first_and_trees_apart() {
        let parent = [3, 4, ROOT, 2, ROOT, 2];
        let (order, trees) = postorder(&parent);
        assert_eq!(order, [0, 3, 5, 2, 1, 4]);
        assert_eq!(trees, [0..4, 4..6]);
    }
}
