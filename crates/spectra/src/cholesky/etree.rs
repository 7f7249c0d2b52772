//! The elimination tree, and its postorder.
//!
//! parent(j) = the first row below the diagonal in column j of the Cholesky factor. Liu (1990), *The
//! role of elimination trees in sparse factorization*, algorithm 4.2: walk from each entry (i, j) of
//! the upper triangle up to the present root and hang it below j, with path compression.

use super::minimum_degree::QuotientGraph;
use std::ops::Range;

/// No parent.
pub(crate) const ROOT: u32 = u32::MAX;

/// Parents in the elimination forest of `graph` ordered by `sequence`. Trees are numbered thus: the elements,
/// which come before all nodes, then the nodes in sequence.
/// Cost: O(nnz log n).
pub(crate) fn elimination_tree(graph: &QuotientGraph, sequence: &[u32]) -> Vec<u32> {
    let (nodes, elements) = (sequence.len(), graph.elements);
    let mut number = vec![0; nodes + elements];
    for (i, &u) in sequence.iter().enumerate() {
        number[u as usize] = (elements + i) as u32;
    }
    for (e, number) in number[nodes..].iter_mut().enumerate() {
        *number = e as u32;
    }
    let mut parent = vec![ROOT; nodes + elements];
    let mut ancestor = vec![ROOT; nodes + elements];
    for (j, &u) in (elements as u32..).zip(sequence) {
        for &v in &graph.lists[graph.starts[u as usize]..graph.starts[u as usize + 1]] {
            let mut i = number[v as usize];
            while i != ROOT && i < j {
                let above = std::mem::replace(&mut ancestor[i as usize], j);
                if above == ROOT {
                    parent[i as usize] = j;
                }
                i = above;
            }
        }
    }
    parent
}

/// The nodes of a forest, children before parents and every subtree in one stretch; and the stretch
/// of each tree. Cost: O(n).
pub(crate) fn postorder(parent: &[u32]) -> (Vec<u32>, Vec<Range<usize>>) {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn graph(lists: &[&[u32]], elements: usize) -> QuotientGraph {
        let mut graph = QuotientGraph {
            starts: vec![0],
            elements,
            ..Default::default()
        };
        for list in lists {
            graph.lists.extend_from_slice(list);
            graph.starts.push(graph.lists.len());
        }
        graph
    }

    #[test]
    fn tree_of_a_small_matrix_is_the_one_worked_by_hand() {
        // Edges 0–3, 1–2, 2–4, 3–4: eliminating 0 fills nothing, column 0 meets row 3 first.
        let edges = graph(&[&[3], &[2], &[1, 4], &[0, 4], &[2, 3]], 0);
        let parent = elimination_tree(&edges, &[0, 1, 2, 3, 4]);
        assert_eq!(parent, [3, 2, 4, 4, ROOT]);
        // In the opposite order: 4–3, 4–2, then 3–2 by fill, 2–1, 3–0.
        let parent = elimination_tree(&edges, &[4, 3, 2, 1, 0]);
        assert_eq!(parent, [1, 2, 3, 4, ROOT]);
    }

    #[test]
    fn fill_is_followed() {
        // Edges 0–1, 0–2: eliminating 0 joins 1 and 2.
        let star = graph(&[&[1, 2], &[0], &[0]], 0);
        assert_eq!(elimination_tree(&star, &[0, 1, 2]), [1, 2, ROOT]);
    }

    #[test]
    fn elements_come_first_and_join_what_they_touch() {
        // Element 3 on nodes 0 and 2, element 4 on nothing; node 1 alone.
        let nodes = graph(&[&[3], &[], &[3]], 2);
        let parent = elimination_tree(&nodes, &[2, 1, 0]);
        assert_eq!(parent, [2, ROOT, 4, ROOT, ROOT]);
    }

    #[test]
    fn postorder_puts_children_first_and_trees_apart() {
        let parent = [3, 4, ROOT, 2, ROOT, 2];
        let (order, trees) = postorder(&parent);
        assert_eq!(order, [0, 3, 5, 2, 1, 4]);
        assert_eq!(trees, [0..4, 4..6]);
    }
}
