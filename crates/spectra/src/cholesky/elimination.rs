//! In which order to eliminate the nodes: approximate minimum degree, then a postorder.
//!
//! The factor's fill depends on the order; so does speed, since the factor, the products and the
//! blocks are all kept in it: nodes that meet in a product should be near in memory.
//!
//! A graph that grows is ordered anew only where it has changed. Eliminating a node changes nothing
//! but its ancestors in the elimination tree, so every subtree whose nodes all have the neighbours they had is
//! *unchanged*: it keeps its order and enters the ordering of the rest as one element, the clique that
//! its elimination leaves on its neighbours. Growth by 5 % at the border of a grid of 1e5 nodes touches
//! 4 % of the old ones, in a maze 1 %. The steps:
//!
//! 1. *keep*: which subtrees stay as they are ([`UnchangedSubtrees`]);
//! 2. *relabel* the rest: in the previous order, each new node behind an old neighbour (breadth first
//!    where there is no previous order), which costs the next step far fewer cache misses;
//! 3. *minimum degree* ([`super::minimum_degree`]), and the elimination tree that follows from it;
//! 4. *postorder* of that tree, which leaves the fill as it is, makes each subtree and so each
//!    connected component a contiguous range, and lets supernodes form.

use super::etree::{ROOT, elimination_tree, postorder};
use super::minimum_degree::{QuotientGraph, minimum_degree};
use super::unchanged_subtrees::{NONE, UnchangedSubtrees};
use crate::{Laplacian, SymmetricOperator};
use std::ops::Range;

/// An order of elimination.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct EliminationOrder {
    /// Node eliminated i-th.
    pub(crate) node: Vec<u32>,
    /// When each node is eliminated: the inverse of `node`.
    pub(crate) position: Vec<u32>,
    /// Ranges of positions, one per connected component.
    pub(crate) components: Vec<Range<usize>>,
    /// The elimination tree, by positions: a postorder.
    pub(crate) parent: Vec<u32>,
    /// Nodes of the graph when it was last ordered as a whole.
    pub(crate) ordered_whole: usize,
    /// For each node, a number that tells sets of neighbours apart.
    pub(crate) fingerprint: Vec<u64>,
}

/// Growth since a graph was last ordered as a whole after which it is so again: separators that
/// were good for half the graph cost 4 % of fill in a grid by then, and nothing in a maze.
const REGROWN: f64 = 2.0;

impl EliminationOrder {
    /// A fill-reducing order for `laplacian`; `previous` is that of the graph before it grew.
    pub(crate) fn new(laplacian: &Laplacian<'_>, previous: Option<&EliminationOrder>) -> Self {
        let fingerprint = fingerprints(laplacian);
        let n = laplacian.dim();
        let Some(previous) = previous.filter(|p| p.node.len() <= n) else {
            let nothing = (&Self::default(), &UnchangedSubtrees::default());
            return ordered(laplacian, nothing, &breadth_first(laplacian), fingerprint);
        };
        let is_stale = n as f64 > REGROWN * previous.ordered_whole as f64;
        let unchanged = if is_stale {
            UnchangedSubtrees::nothing(previous.node.len())
        } else {
            UnchangedSubtrees::new(&previous.parent, previous.changed(&fingerprint))
        };
        let rest = appended(laplacian, previous, &unchanged);
        ordered(laplacian, (previous, &unchanged), &rest, fingerprint)
    }

    /// By position: whether the node there has other neighbours in a graph with this `fingerprint`.
    fn changed(&self, fingerprint: &[u64]) -> Vec<bool> {
        let has_changed = |&u: &u32| fingerprint[u as usize] != self.fingerprint[u as usize];
        self.node.iter().map(has_changed).collect()
    }
}

#[cfg(feature = "serde")]
impl EliminationOrder {
    /// Whether it is a permutation with a postordered tree, as every order made here is.
    pub(crate) fn is_consistent(&self) -> bool {
        let n = self.node.len();
        let lengths = [
            self.position.len(),
            self.parent.len(),
            self.fingerprint.len(),
        ];
        if lengths != [n; 3] {
            return false;
        }
        // With n nodes, each back where it came from, none occurs twice.
        let is_inverse = (0..n).all(|i| {
            let position = self.position.get(self.node[i] as usize);
            position.is_some_and(|&p| p as usize == i)
        });
        is_inverse && self.is_postordered()
    }

    /// Whether every subtree is one stretch that ends with its root, and `components` are the trees.
    fn is_postordered(&self) -> bool {
        let mut first: Vec<usize> = (0..self.parent.len()).collect();
        let mut size = vec![1; self.parent.len()];
        let mut trees = Vec::new();
        for (j, &parent) in self.parent.iter().enumerate() {
            if first[j] + size[j] != j + 1 {
                return false;
            }
            let parent = parent as usize;
            if self.parent[j] == ROOT {
                trees.push(first[j]..j + 1);
            } else if parent > j && parent < self.parent.len() {
                first[parent] = first[parent].min(first[j]);
                size[parent] += size[j];
            } else {
                return false;
            }
        }
        trees == self.components
    }
}

/// Orders the nodes `rest` behind the unchanged subtrees they border on.
fn ordered(
    laplacian: &Laplacian<'_>,
    (previous, unchanged): (&EliminationOrder, &UnchangedSubtrees),
    rest: &[u32],
    fingerprint: Vec<u64>,
) -> EliminationOrder {
    let graph = quotient(laplacian, (previous, unchanged), rest);
    let sequence = minimum_degree(&graph);
    let parent = elimination_tree(&graph, &sequence);
    let (order, trees) = postorder(&parent);
    let mut spliced = Spliced::new(laplacian.dim());
    let mut starts = Vec::with_capacity(order.len() + 1);
    for &i in &order {
        starts.push(spliced.node.len());
        let i = i as usize;
        match unchanged.stretches.get(i) {
            Some(stretch) => spliced.copy(previous, stretch.clone()),
            None => spliced.push(rest[sequence[i - unchanged.stretches.len()] as usize]),
        }
    }
    starts.push(spliced.node.len());
    spliced.link(&order, &parent, &starts);
    let ordered_whole = match unchanged.stretches.is_empty() {
        true => laplacian.dim(),
        false => previous.ordered_whole,
    };
    EliminationOrder {
        ordered_whole,
        position: inverse(&spliced.node),
        components: trees
            .iter()
            .map(|t| starts[t.start]..starts[t.end])
            .collect(),
        node: spliced.node,
        parent: spliced.parent,
        fingerprint,
    }
}

/// A new order in the making.
struct Spliced {
    node: Vec<u32>,
    parent: Vec<u32>,
}

impl Spliced {
    fn new(nodes: usize) -> Self {
        Self {
            node: Vec::with_capacity(nodes),
            parent: Vec::with_capacity(nodes),
        }
    }

    /// An unchanged subtree: the same tree, further up or down.
    fn copy(&mut self, previous: &EliminationOrder, stretch: Range<usize>) {
        let (from, to) = (stretch.start as u32, self.node.len() as u32);
        self.node.extend_from_slice(&previous.node[stretch.clone()]);
        let inside = &previous.parent[stretch.start..stretch.end - 1];
        self.parent.extend(inside.iter().map(|p| p - from + to));
        self.parent.push(ROOT);
    }

    fn push(&mut self, node: u32) {
        self.node.push(node);
        self.parent.push(ROOT);
    }

    /// Hangs the roots of unchanged subtrees and the other nodes, `order` by their postorder, below their parents. Each takes up
    /// the positions between two of `starts` and is known by the last of them.
    fn link(&mut self, order: &[u32], parent: &[u32], starts: &[usize]) {
        let mut place = vec![0; order.len()];
        for (at, &i) in order.iter().enumerate() {
            place[i as usize] = starts[at + 1] - 1;
        }
        for (&last, &above) in place.iter().zip(parent) {
            if above != ROOT {
                self.parent[last] = place[above as usize] as u32;
            }
        }
    }
}

/// The graph on `rest`, with an element for each unchanged subtree.
fn quotient(
    laplacian: &Laplacian<'_>,
    (previous, unchanged): (&EliminationOrder, &UnchangedSubtrees),
    rest: &[u32],
) -> QuotientGraph {
    let mut number = vec![NONE; laplacian.dim()];
    for (i, &u) in rest.iter().enumerate() {
        number[u as usize] = i as u32;
    }
    let mut graph = QuotientGraph {
        starts: vec![0],
        elements: unchanged.stretches.len(),
        ..Default::default()
    };
    // Which node last listed each element.
    let mut listed = vec![NONE; graph.elements];
    for (i, &u) in rest.iter().enumerate() {
        for &v in laplacian.row(u as usize).0.iter().filter(|&&v| v != u) {
            let mut j = number[v as usize];
            if j == NONE {
                let element = unchanged.owner[previous.position[v as usize] as usize];
                if std::mem::replace(&mut listed[element as usize], i as u32) == i as u32 {
                    continue;
                }
                j = rest.len() as u32 + element;
            }
            graph.lists.push(j);
        }
        graph.starts.push(graph.lists.len());
    }
    graph
}

/// A number for each node's set of neighbours: a sum of scrambled names, which two sets share once in 2⁶⁴.
fn fingerprints(laplacian: &Laplacian<'_>) -> Vec<u64> {
    // The finaliser of SplitMix64 (Steele, Lea & Flood 2014).
    let scrambled = |&j: &u32| {
        let mut z = (u64::from(j) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let of_row = |i| {
        let neighbors = laplacian.row(i).0.iter().map(scrambled);
        neighbors.fold(0, u64::wrapping_add)
    };
    (0..laplacian.dim()).map(of_row).collect()
}

fn inverse(permutation: &[u32]) -> Vec<u32> {
    let mut inverse = vec![0; permutation.len()];
    for (i, &p) in permutation.iter().enumerate() {
        inverse[p as usize] = i as u32;
    }
    inverse
}

/// The previous order without what is unchanged, and each new node behind one of its neighbours.
fn appended(
    laplacian: &Laplacian<'_>,
    previous: &EliminationOrder,
    unchanged: &UnchangedSubtrees,
) -> Vec<u32> {
    let old = previous.node.len();
    let mut anchors: Vec<u32> = Vec::with_capacity(laplacian.dim() - old);
    for i in old..laplacian.dim() {
        let known = laplacian
            .row(i)
            .0
            .iter()
            .map(|&j| j as usize)
            .filter(|&j| j < i);
        let anchor = known.map(|j| match j.checked_sub(old) {
            Some(new) => anchors[new],
            None => previous.position[j],
        });
        anchors.push(anchor.min().unwrap_or(old as u32));
    }
    let mut order: Vec<(u32, u32)> = (0..old)
        .filter(|&position| unchanged.owner[position] == NONE)
        .map(|position| (position as u32, previous.node[position]))
        .collect();
    order.extend(anchors.iter().copied().zip(old as u32..));
    // Old nodes at their own positions, new ones behind them in order of discovery.
    order.sort_by_key(|&(anchor, _)| anchor);
    order.into_iter().map(|(_, node)| node).collect()
}

/// Breadth first from the earliest node of each component.
fn breadth_first(laplacian: &Laplacian<'_>) -> Vec<u32> {
    let n = laplacian.dim();
    let mut seen = vec![false; n];
    let mut order: Vec<u32> = Vec::with_capacity(n);
    for root in 0..n {
        if seen[root] {
            continue;
        }
        seen[root] = true;
        let mut next = order.len();
        order.push(root as u32);
        while next < order.len() {
            for &v in laplacian.row(order[next] as usize).0 {
                if !seen[v as usize] {
                    seen[v as usize] = true;
                    order.push(v);
                }
            }
            next += 1;
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LaplacianKind, SymmetricCsr, testing};
    use sprs::TriMatI;
    use std::collections::BTreeSet;

    fn assert_is_order(order: &EliminationOrder, n: usize) {
        let mut seen = vec![false; n];
        for (i, &u) in order.node.iter().enumerate() {
            assert_eq!(order.position[u as usize], i as u32);
            seen[u as usize] = true;
        }
        assert!(seen.iter().all(|&s| s));
    }

    #[test]
    fn growing_orders_are_permutations_with_one_range_per_component() {
        let whole = testing::disjoint(&[testing::grid(9, 7), testing::path(5), testing::path(1)]);
        let mut previous = None;
        for n in [10, 40, 63, 66, 69] {
            let graph = testing::prefix(&whole, n);
            let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized);
            let order = EliminationOrder::new(&laplacian, previous.as_ref());
            assert_is_order(&order, n);
            let expected = 1 + usize::from(n > 63) + usize::from(n > 68);
            assert_eq!(order.components.len(), expected, "n = {n}");
            assert_eq!(order.components.last().map(|c| c.end), Some(n));
            previous = Some(order);
        }
    }

    /// Rows below the diagonal of each column of the factor, by elimination of one node after another.
    fn columns(laplacian: &Laplacian<'_>, order: &EliminationOrder) -> Vec<BTreeSet<u32>> {
        let mut below: Vec<BTreeSet<u32>> = (0..laplacian.dim())
            .map(|i| {
                let neighbors = laplacian.row(order.node[i] as usize).0.iter();
                let positions = neighbors.map(|&v| order.position[v as usize]);
                positions.filter(|&j| j as usize > i).collect()
            })
            .collect();
        for j in 0..below.len() {
            let column = below[j].clone();
            if let Some(&parent) = column.first() {
                below[parent as usize].extend(column.iter().skip(1));
            }
        }
        below
    }

    fn assert_tree_follows_from_elimination(laplacian: &Laplacian<'_>, order: &EliminationOrder) {
        assert_is_order(order, laplacian.dim());
        for (j, column) in columns(laplacian, order).iter().enumerate() {
            let parent = column.first().copied().unwrap_or(ROOT);
            assert_eq!(order.parent[j], parent, "column {j} of {}", laplacian.dim());
        }
        let trees = order.parent.iter().filter(|&&p| p == ROOT).count();
        assert_eq!(order.components.len(), trees);
    }

    #[test]
    fn mended_orders_have_the_tree_of_the_graph_that_has_grown_and_little_more_fill() {
        for whole in [
            testing::discovered(&testing::grid(24, 22), 1),
            testing::discovered(&testing::maze(25, 25, 0.1, 2), 3),
            testing::random(400, 3.0, 1),
            testing::disjoint(&[testing::grid(9, 9), testing::star(30), testing::cycle(200)]),
        ] {
            let mut previous: Option<EliminationOrder> = None;
            let (mut fill, mut fresh_fill, mut copied) = (0, 0, 0);
            let mut n = 50;
            while n <= whole.num_nodes() {
                let graph = testing::prefix(&whole, n);
                let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized);
                let order = EliminationOrder::new(&laplacian, previous.as_ref());
                assert_tree_follows_from_elimination(&laplacian, &order);
                let entries =
                    |order| -> usize { columns(&laplacian, order).iter().map(BTreeSet::len).sum() };
                fill += entries(&order);
                fresh_fill += entries(&EliminationOrder::new(&laplacian, None));
                copied += usize::from(order.ordered_whole < n);
                previous = Some(order);
                n += n / 15;
            }
            assert!(copied > 10, "orders are mended");
            assert!(
                fill as f64 <= 1.15 * fresh_fill as f64,
                "{fill} for {fresh_fill}"
            );
        }
    }

    #[test]
    fn edges_between_old_nodes_and_edges_that_went_are_noticed() {
        // Two paths; then their ends change partners, which leaves every degree as it was.
        let edges = |pairs: &[(usize, usize)]| {
            let mut graph = TriMatI::<f64, u32>::new((40, 40));
            let path = (0..39).filter(|&i| i != 9 && i != 29).map(|i| (i, i + 1));
            for (i, j) in path.chain(pairs.iter().copied()) {
                graph.add_triplet(i, j, 1.0);
                graph.add_triplet(j, i, 1.0);
            }
            SymmetricCsr::new(graph.to_csr()).unwrap()
        };
        let before = edges(&[(9, 10), (29, 30)]);
        let laplacian = Laplacian::new(&before, LaplacianKind::Combinatorial);
        let order = EliminationOrder::new(&laplacian, None);
        for pairs in [[(9, 29), (10, 30)], [(9, 30), (10, 29)], [(0, 20), (9, 30)]] {
            let after = edges(&pairs);
            let laplacian = Laplacian::new(&after, LaplacianKind::Combinatorial);
            let order = EliminationOrder::new(&laplacian, Some(&order));
            assert_tree_follows_from_elimination(&laplacian, &order);
        }
    }

    #[test]
    fn an_unchanged_graph_keeps_its_order() {
        let graph = testing::maze(20, 20, 0.1, 1);
        let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized);
        let order = EliminationOrder::new(&laplacian, None);
        let again = EliminationOrder::new(&laplacian, Some(&order));
        assert_eq!(order.node, again.node);
        assert_eq!(order.parent, again.parent);
    }
}
