//! Approximate minimum degree: which node to eliminate next so that the factor fills little.
//!
//! Amestoy, Davis & Duff (1996), *An approximate minimum degree ordering algorithm*. Eliminating a node
//! joins its neighbours to one another. That clique is kept as an *element*, a list of the nodes in
//! it, so that the graph never grows. An element that another one contains is dropped (absorbed);
//! nodes with the same lists are ordered together (a supervariable); a node whose neighbours are all in the new
//! element goes with the pivot. The degree is a bound that is cheap to keep up:
//!
//!   d_i ≤ min(d_i + |L_p \ i|, |A_i| + |L_p \ i| + Σ_e |L_e \ L_p|).
//!
//! Elements may be there from the start: parts of the graph that are eliminated already. That is
//! what lets the order of a graph that grows be mended where it grew.

/// The part of a graph that is still to be ordered.
#[derive(Clone, Debug, Default)]
pub(crate) struct QuotientGraph {
    /// Where each node's list starts, and the length of all lists.
    pub(crate) starts: Vec<usize>,
    /// Lists of nodes, and of elements numbered behind the nodes. No node is in its own list, none is in a list twice,
    /// and of two neighbours each lists the other.
    pub(crate) lists: Vec<u32>,
    pub(crate) elements: usize,
}

/// A node with more neighbours than this times √n comes last: it would be looked at all the time and end up late
/// anyway.
const DENSE: f64 = 10.0;

/// An order of elimination. Cost: about O(length of the lists + length of the factor's row lists).
pub(crate) fn minimum_degree(graph: &QuotientGraph) -> Vec<u32> {
    let mut state = State::new(graph);
    let mut order = Vec::with_capacity(state.nodes);
    while let Some(pivot) = state.queue.pop() {
        state.eliminate(pivot);
        state.members.append_to(&mut order, pivot);
    }
    order.extend_from_slice(&state.dense);
    order
}

/// Nodes and elements share one numbering; a pivot's number goes on as that of its element.
struct State {
    nodes: usize,
    lists: Vec<u32>,
    start: Vec<usize>,
    len: Vec<u32>,
    /// A node's list begins with so many elements.
    elements: Vec<u32>,
    /// How many nodes a supervariable stands for: negative while it is in the element in the making,
    /// 0 once it is ordered or part of another one.
    weight: Vec<i32>,
    /// A node's bound on its degree; an element's weight.
    degree: Vec<u32>,
    /// For an element: 0 once it is dropped; else, from `stamp` on, `stamp` + its weight outside the new one.
    outside: Vec<u64>,
    stamp: u64,
    queue: Queue,
    members: Members,
    /// Weight that is still to be ordered.
    left: u32,
    dense: Vec<u32>,
    scratch: Scratch,
}

#[derive(Default)]
struct Scratch {
    list: Vec<u32>,
    hashes: Vec<(u32, u32)>,
    mark: Vec<u32>,
    marked: u32,
}

impl State {
    fn new(graph: &QuotientGraph) -> Self {
        let nodes = graph.starts.len() - 1;
        let all = nodes + graph.elements;
        let mut state = Self {
            nodes,
            lists: Vec::with_capacity(2 * graph.lists.len()),
            start: Vec::with_capacity(all),
            len: vec![0; all],
            elements: vec![0; nodes],
            weight: vec![1; nodes],
            degree: vec![0; all],
            outside: vec![0; all],
            stamp: 1,
            queue: Queue::new(nodes),
            members: Members::new(nodes),
            left: nodes as u32,
            dense: Vec::new(),
            scratch: Scratch {
                mark: vec![0; all],
                ..Default::default()
            },
        };
        let limit = (DENSE * (nodes as f64).sqrt()).max(16.0) as usize;
        for (i, ends) in graph.starts.windows(2).enumerate() {
            if ends[1] - ends[0] > limit {
                state.weight[i] = 0;
                state.dense.push(i as u32);
            }
        }
        state.left -= state.dense.len() as u32;
        state.copy_nodes(graph);
        state.gather_elements(graph);
        state.enqueue_all();
        state
    }

    /// The lists of the nodes: elements first, dense nodes left out.
    fn copy_nodes(&mut self, graph: &QuotientGraph) {
        for i in 0..self.nodes {
            let list = &graph.lists[graph.starts[i]..graph.starts[i + 1]];
            let begin = self.lists.len();
            self.start.push(begin);
            let is_element = |&&j: &&u32| j as usize >= self.nodes;
            self.lists.extend(list.iter().filter(is_element));
            self.elements[i] = (self.lists.len() - begin) as u32;
            let is_node = |&&j: &&u32| (j as usize) < self.nodes && self.weight[j as usize] > 0;
            self.lists.extend(list.iter().filter(is_node));
            self.len[i] = (self.lists.len() - begin) as u32;
        }
    }

    /// The lists of the elements, from those of the nodes.
    fn gather_elements(&mut self, graph: &QuotientGraph) {
        let of_node = |state: &Self, i: usize| {
            let range = state.start[i]..state.start[i] + state.elements[i] as usize;
            if state.weight[i] > 0 { range } else { 0..0 }
        };
        for i in 0..self.nodes {
            for at in of_node(self, i) {
                self.len[self.lists[at] as usize] += 1;
            }
        }
        let mut end = self.lists.len();
        for e in self.nodes..self.nodes + graph.elements {
            self.start.push(end);
            end += self.len[e] as usize;
            self.degree[e] = std::mem::take(&mut self.len[e]);
            self.outside[e] = 1;
        }
        self.lists.resize(end, 0);
        for i in 0..self.nodes {
            for at in of_node(self, i) {
                let e = self.lists[at] as usize;
                let to = self.start[e] + self.len[e] as usize;
                self.lists[to] = i as u32;
                self.len[e] += 1;
            }
        }
    }

    fn enqueue_all(&mut self) {
        for i in (0..self.nodes).rev().filter(|&i| self.weight[i] > 0) {
            let (elements, neighbors) = self.list(i).split_at(self.elements[i] as usize);
            let around = |&e: &u32| self.degree[e as usize] - 1;
            let bound = neighbors.len() as u32 + elements.iter().map(around).sum::<u32>();
            self.degree[i] = bound.min(self.left - 1);
            self.queue.push(i as u32, self.degree[i]);
        }
    }

    fn list(&self, i: usize) -> &[u32] {
        &self.lists[self.start[i]..self.start[i] + self.len[i] as usize]
    }

    /// Turns node `pivot` into an element and brings its neighbours up to date.
    fn eliminate(&mut self, pivot: u32) {
        let p = pivot as usize;
        let begin = self.form_element(p);
        let mut weight = self.element_weight(begin);
        self.measure_overlaps(begin);
        for at in begin..self.lists.len() {
            let i = self.lists[at] as usize;
            if self.update(i, pivot) == 0 {
                // Nothing outside the new element: eliminated with the pivot.
                weight -= self.weight[i].unsigned_abs();
                self.left -= self.weight[i].unsigned_abs();
                self.weight[i] = 0;
                self.members.join(pivot, i as u32);
            }
        }
        self.merge_equal();
        self.close_element(p, begin, weight);
    }

    /// Appends L_p: the neighbours of `p`, directly or through elements, which it drops. They leave the queue.
    fn form_element(&mut self, p: usize) -> usize {
        self.left -= self.weight[p] as u32;
        self.weight[p] = 0;
        let begin = self.lists.len();
        let own = self.start[p]..self.start[p] + self.len[p] as usize;
        let (elements, rest) = (self.elements[p] as usize, own.clone());
        for at in own.take(elements) {
            let e = self.lists[at] as usize;
            if self.outside[e] > 0 {
                self.outside[e] = 0;
                self.take(self.start[e]..self.start[e] + self.len[e] as usize);
            }
        }
        self.take(rest.start + elements..rest.end);
        begin
    }

    fn take(&mut self, list: std::ops::Range<usize>) {
        for at in list {
            let i = self.lists[at];
            let weight = &mut self.weight[i as usize];
            if *weight > 0 {
                *weight = -*weight;
                self.queue.remove(i, self.degree[i as usize]);
                self.lists.push(i);
            }
        }
    }

    fn element_weight(&self, begin: usize) -> u32 {
        let weight = |&i: &u32| self.weight[i as usize].unsigned_abs();
        self.lists[begin..].iter().map(weight).sum()
    }

    /// |L_e \ L_p| for all elements that meet the new one.
    fn measure_overlaps(&mut self, begin: usize) {
        self.stamp += self.nodes as u64 + 1;
        for at in begin..self.lists.len() {
            let i = self.lists[at] as usize;
            let weight = u64::from(self.weight[i].unsigned_abs());
            for at in self.start[i]..self.start[i] + self.elements[i] as usize {
                let e = self.lists[at] as usize;
                let outside = &mut self.outside[e];
                if *outside >= self.stamp {
                    *outside -= weight;
                } else if *outside > 0 {
                    *outside = self.stamp + u64::from(self.degree[e]) - weight;
                }
            }
        }
    }

    /// Shortens the list of `i` in L_p; returns the bound on its degree outside L_p, and notes its hash if that is not 0.
    fn update(&mut self, i: usize, pivot: u32) -> u32 {
        let list = &mut self.scratch.list;
        list.clear();
        list.push(pivot);
        let (mut bound, mut hash) = (0, pivot);
        let own = self.start[i]..self.start[i] + self.len[i] as usize;
        let (elements, neighbors) = self.lists[own.clone()].split_at(self.elements[i] as usize);
        for &e in elements {
            let outside = &mut self.outside[e as usize];
            if *outside == 0 {
                continue;
            }
            let rest = (*outside - self.stamp) as u32;
            if rest == 0 {
                *outside = 0;
                continue;
            }
            bound += rest;
            hash = hash.wrapping_add(e);
            list.push(e);
        }
        self.elements[i] = list.len() as u32;
        for &j in neighbors {
            let weight = self.weight[j as usize];
            if weight > 0 {
                bound += weight as u32;
                hash = hash.wrapping_add(j);
                list.push(j);
            }
        }
        debug_assert!(
            list.len() <= own.len(),
            "the pivot was in the list, or an element with it"
        );
        self.lists[own.start..own.start + list.len()].copy_from_slice(list);
        self.len[i] = list.len() as u32;
        self.degree[i] = self.degree[i].min(bound);
        if bound > 0 {
            self.scratch.hashes.push((hash, i as u32));
        }
        bound
    }

    /// Joins the nodes of L_p that have the same lists.
    fn merge_equal(&mut self) {
        let mut hashes = std::mem::take(&mut self.scratch.hashes);
        hashes.sort_unstable();
        for run in hashes
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|run| run.len() > 1)
        {
            for (at, &(_, i)) in run.iter().enumerate() {
                if self.weight[i as usize] == 0 {
                    continue;
                }
                self.mark_list(i as usize);
                for &(_, j) in &run[at + 1..] {
                    if self.weight[j as usize] != 0 && self.has_marked_list(i as usize, j as usize)
                    {
                        self.weight[i as usize] += self.weight[j as usize];
                        self.weight[j as usize] = 0;
                        self.members.join(i, j);
                    }
                }
            }
        }
        hashes.clear();
        self.scratch.hashes = hashes;
    }

    fn mark_list(&mut self, i: usize) {
        self.scratch.marked += 1;
        for at in self.start[i]..self.start[i] + self.len[i] as usize {
            self.scratch.mark[self.lists[at] as usize] = self.scratch.marked;
        }
    }

    fn has_marked_list(&self, i: usize, j: usize) -> bool {
        let is_marked = |&l: &u32| self.scratch.mark[l as usize] == self.scratch.marked;
        self.len[i] == self.len[j]
            && self.elements[i] == self.elements[j]
            && self.list(j).iter().all(is_marked)
    }

    /// The new element of weight `weight` with those of its nodes that are left, which go back into the queue.
    fn close_element(&mut self, p: usize, begin: usize, weight: u32) {
        let mut end = begin;
        for at in begin..self.lists.len() {
            let i = self.lists[at];
            let own = &mut self.weight[i as usize];
            if *own == 0 {
                continue;
            }
            *own = -*own;
            let own = *own as u32;
            let degree = &mut self.degree[i as usize];
            *degree = (*degree + weight - own).min(self.left - own);
            self.queue.push(i, *degree);
            self.lists[end] = i;
            end += 1;
        }
        self.lists.truncate(end);
        self.start[p] = begin;
        self.len[p] = (end - begin) as u32;
        self.degree[p] = weight;
        self.outside[p] = u64::from(end > begin);
    }
}

/// Which nodes each supervariable stands for, as lists.
struct Members {
    next: Vec<u32>,
    last: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl Members {
    fn new(nodes: usize) -> Self {
        Self {
            next: vec![NONE; nodes],
            last: (0..nodes as u32).collect(),
        }
    }

    /// Puts those of `j` behind those of `i`.
    fn join(&mut self, i: u32, j: u32) {
        self.next[self.last[i as usize] as usize] = j;
        self.last[i as usize] = self.last[j as usize];
    }

    fn append_to(&self, order: &mut Vec<u32>, first: u32) {
        let mut i = first;
        while i != NONE {
            order.push(i);
            i = self.next[i as usize];
        }
    }
}

/// Nodes by degree: a doubly linked list for each degree; last in, first out.
struct Queue {
    heads: Vec<u32>,
    next: Vec<u32>,
    previous: Vec<u32>,
    least: usize,
}

impl Queue {
    fn new(nodes: usize) -> Self {
        Self {
            heads: vec![NONE; nodes],
            next: vec![NONE; nodes],
            previous: vec![NONE; nodes],
            least: 0,
        }
    }

    fn push(&mut self, i: u32, degree: u32) {
        let head = std::mem::replace(&mut self.heads[degree as usize], i);
        self.next[i as usize] = head;
        self.previous[i as usize] = NONE;
        if head != NONE {
            self.previous[head as usize] = i;
        }
        self.least = self.least.min(degree as usize);
    }

    fn remove(&mut self, i: u32, degree: u32) {
        let (next, previous) = (self.next[i as usize], self.previous[i as usize]);
        if next != NONE {
            self.previous[next as usize] = previous;
        }
        if previous == NONE {
            self.heads[degree as usize] = next;
        } else {
            self.next[previous as usize] = next;
        }
    }

    /// A node of least degree.
    fn pop(&mut self) -> Option<u32> {
        while self.least < self.heads.len() {
            let i = self.heads[self.least];
            if i != NONE {
                self.remove(i, self.least as u32);
                return Some(i);
            }
            self.least += 1;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SymmetricCsr, testing};
    use faer::dyn_stack::{MemBuffer, MemStack};
    use faer::sparse::SymbolicSparseColMatRef;
    use faer::sparse::linalg::amd;
    use std::collections::BTreeSet;

    fn neighbors(graph: &SymmetricCsr) -> Vec<BTreeSet<u32>> {
        let of_row = |i: usize| {
            let mut set: BTreeSet<u32> = graph.row(i).0.iter().copied().collect();
            set.remove(&(i as u32));
            set
        };
        (0..graph.num_nodes()).map(of_row).collect()
    }

    fn quotient(lists: &[BTreeSet<u32>], elements: usize) -> QuotientGraph {
        let mut graph = QuotientGraph {
            starts: vec![0],
            elements,
            ..Default::default()
        };
        for list in lists {
            graph.lists.extend(list);
            graph.starts.push(graph.lists.len());
        }
        graph
    }

    /// Entries below the diagonal of the factor in this order.
    fn fill(mut neighbors: Vec<BTreeSet<u32>>, order: &[u32]) -> usize {
        let mut fill = 0;
        for &p in order {
            let clique = std::mem::take(&mut neighbors[p as usize]);
            fill += clique.len();
            for &i in &clique {
                neighbors[i as usize].remove(&p);
                neighbors[i as usize].extend(clique.iter().filter(|&&j| j != i));
            }
        }
        fill
    }

    /// The order of faer's own implementation of the same method.
    fn by_faer(neighbors: &[BTreeSet<u32>]) -> Vec<u32> {
        let n = neighbors.len();
        let whole = quotient(neighbors, 0);
        let starts: Vec<u32> = whole.starts.iter().map(|&s| s as u32).collect();
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &starts, None, &whole.lists);
        let (mut order, mut inverse) = (vec![0u32; n], vec![0u32; n]);
        let mut memory = MemBuffer::new(amd::order_scratch::<u32>(n, whole.lists.len()));
        let stack = MemStack::new(&mut memory);
        let control = amd::Control::default();
        amd::order(&mut order, &mut inverse, pattern, control, stack).unwrap();
        order
    }

    fn assert_permutation(order: &[u32], n: usize) {
        let mut sorted = order.to_vec();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..n as u32));
    }

    fn graphs() -> Vec<SymmetricCsr> {
        vec![
            testing::grid(30, 30),
            testing::maze(40, 40, 0.1, 1),
            testing::random(300, 4.0, 1),
            testing::random(600, 2.0, 2),
            testing::complete(30),
            testing::star(400),
            testing::disjoint(&[testing::grid(9, 9), testing::cycle(20), testing::path(1)]),
        ]
    }

    #[test]
    fn fill_is_that_of_faers_implementation_within_a_few_per_cent() {
        for graph in graphs() {
            let neighbors = neighbors(&graph);
            let order = minimum_degree(&quotient(&neighbors, 0));
            assert_permutation(&order, graph.num_nodes());
            let peer = fill(neighbors.clone(), &by_faer(&neighbors));
            let own = fill(neighbors, &order);
            assert!(own as f64 <= 1.08 * peer as f64, "{own} for {peer}");
        }
    }

    #[test]
    fn a_tree_fills_nothing() {
        for (width, height, seed) in [(20, 20, 1), (50, 9, 2), (7, 80, 3)] {
            let tree = testing::maze(width, height, 0.0, seed);
            let neighbors = neighbors(&tree);
            let order = minimum_degree(&quotient(&neighbors, 0));
            assert_eq!(fill(neighbors, &order), tree.num_nodes() - 1);
        }
    }

    #[test]
    fn elements_stand_for_what_is_eliminated_already() {
        for graph in graphs() {
            let mut all = neighbors(&graph);
            let n = graph.num_nodes();
            // A first part is eliminated in whatever order; what is left of it are cliques.
            let first = minimum_degree(&quotient(&all, 0));
            let (first, rest) = first.split_at(n / 2);
            let mut cliques: Vec<BTreeSet<u32>> = Vec::new();
            for &p in first {
                let mut clique = std::mem::take(&mut all[p as usize]);
                cliques.retain(|other| {
                    let absorbed = other.contains(&p);
                    if absorbed {
                        clique.extend(other);
                    }
                    !absorbed
                });
                clique.remove(&p);
                for &i in &clique {
                    all[i as usize].remove(&p);
                }
                cliques.push(clique);
            }
            let name = |u: u32| rest.iter().position(|&v| v == u).map(|at| at as u32);
            let mut lists: Vec<BTreeSet<u32>> = rest
                .iter()
                .map(|&u| all[u as usize].iter().filter_map(|&v| name(v)).collect())
                .collect();
            let mut filled = lists.clone();
            for (e, clique) in cliques.iter().enumerate() {
                let clique: Vec<u32> = clique.iter().filter_map(|&v| name(v)).collect();
                for &i in &clique {
                    lists[i as usize].insert((rest.len() + e) as u32);
                    filled[i as usize].extend(clique.iter().filter(|&&j| j != i));
                }
            }
            let with_elements = minimum_degree(&quotient(&lists, cliques.len()));
            let with_edges = minimum_degree(&quotient(&filled, 0));
            assert_permutation(&with_elements, rest.len());
            let (own, peer) = (
                fill(filled.clone(), &with_elements),
                fill(filled, &with_edges),
            );
            assert!(own as f64 <= 1.08 * peer as f64 + 5.0, "{own} for {peer}");
        }
    }
}
