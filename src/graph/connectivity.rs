//! Hops between states, by breadth-first search.
//!
//! hops(v) = the least number of links on a way to v from the nearest source, by breadth-first search, O(n + nnz).
//! What a link is comes from [`Links`]: the edges of an [`Adjacency`] or a [`SymmetricCsr`]; the tried transitions as they were
//! taken ([`Leaving`]); or those against their direction ([`Entering`]), so that hops from a goal are the number of
//! steps **to** it, one-way passages respected.

use super::{Adjacency, StateId, SymmetricCsr, TransitionGraph};
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;

/// The hops of a node that no source reaches.
pub const UNREACHED: u32 = u32::MAX;

/// Something whose nodes `0..num_nodes` are linked.
pub trait Links {
    /// Number of nodes n.
    fn num_nodes(&self) -> usize;

    /// The nodes one link away from `node`, in an order that is always the same; repetitions and `node` itself are
    /// allowed.
    fn linked(&self, node: u32) -> impl Iterator<Item = u32>;
}

impl Links for Adjacency {
    fn num_nodes(&self) -> usize {
        Adjacency::num_nodes(self)
    }

    fn linked(&self, node: u32) -> impl Iterator<Item = u32> {
        self.neighbors(node).iter().copied()
    }
}

impl Links for SymmetricCsr {
    fn num_nodes(&self) -> usize {
        SymmetricCsr::num_nodes(self)
    }

    fn linked(&self, node: u32) -> impl Iterator<Item = u32> {
        self.row(node as usize).0.iter().copied()
    }
}

/// Tried transitions in the direction in which they were taken.
#[derive(Clone, Copy, Debug)]
pub struct Leaving<'a>(pub &'a TransitionGraph);

impl Links for Leaving<'_> {
    fn num_nodes(&self) -> usize {
        self.0.num_states()
    }

    fn linked(&self, node: u32) -> impl Iterator<Item = u32> {
        self.0.outcomes(StateId(node)).map(|outcome| outcome.next.0)
    }
}

/// Tried transitions against the direction in which they were taken.
#[derive(Clone, Copy, Debug)]
pub struct Entering<'a>(pub &'a TransitionGraph);

impl Links for Entering<'_> {
    fn num_nodes(&self) -> usize {
        self.0.num_states()
    }

    fn linked(&self, node: u32) -> impl Iterator<Item = u32> {
        self.0
            .predecessors(StateId(node))
            .map(|previous| previous.0)
    }
}

/// A breadth-first search and its buffers: the next search of a graph no larger allocates nothing.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct HopSearch {
    hops: Vec<u32>,
    reached: Vec<u32>,
}

impl HopSearch {
    /// Empty buffers.
    pub fn new() -> Self {
        Self::default()
    }

    /// Hops of every node from the nearest of `sources`, [`UNREACHED`] where there is no way; n values. O(n + nnz).
    ///
    /// # Panics
    /// If a source does not exist.
    pub fn run(
        &mut self,
        links: &impl Links,
        sources: impl IntoIterator<Item = StateId>,
    ) -> &[u32] {
        self.clear(links.num_nodes());
        for source in sources {
            self.visit(source.0, 0);
        }
        self.spread(links, Vec::new())
    }

    /// The same from sources with handicaps h: min over the sources of h + hops from there, so that a node next to a
    /// source of a large handicap may belong to a farther one. Of sources given twice the smaller handicap counts.
    /// O(n + nnz) for a handful of sources.
    ///
    /// # Panics
    /// If a source does not exist.
    pub fn run_with_handicaps(&mut self, links: &impl Links, sources: &[(StateId, u32)]) -> &[u32] {
        self.clear(links.num_nodes());
        let mut waiting = sources.to_vec();
        waiting.sort_by_key(|&(_, handicap)| Reverse(handicap));
        self.spread(links, waiting)
    }

    /// Counts `node`, which joined the graph after the last run, as one hop from `from`, until the next run. Others that
    /// joined before it stay [`UNREACHED`], a node that was there keeps its hops; [`Self::reached`] and
    /// [`Self::eccentricity`] remain those of the run. Amortised O(1).
    pub fn append(&mut self, from: StateId, node: StateId) {
        if node.index() >= self.hops.len() {
            let known = self.hops.get(from.index()).copied();
            let hops = known.unwrap_or(UNREACHED).saturating_add(1);
            self.hops.resize(node.index(), UNREACHED);
            self.hops.push(hops);
        }
    }

    fn clear(&mut self, num_nodes: usize) {
        self.hops.clear();
        self.hops.resize(num_nodes, UNREACHED);
        self.reached.clear();
    }

    /// The search. `reached` is its queue, in order of hops; `waiting`, the smallest handicap last, are sources that
    /// enter it in front of everything farther away than they are.
    fn spread(&mut self, links: &impl Links, mut waiting: Vec<(StateId, u32)>) -> &[u32] {
        let mut next = 0;
        loop {
            let head = self.reached.get(next).copied();
            let ahead = head.map(|node| self.hops[node as usize]);
            let due = waiting.pop_if(|source| ahead.is_none_or(|hops| source.1 <= hops));
            match (due, head) {
                (Some((source, handicap)), _) => {
                    let known = &mut self.hops[source.index()];
                    if *known == UNREACHED {
                        *known = handicap;
                        self.reached.insert(next, source.0);
                    }
                }
                (None, Some(node)) => {
                    next += 1;
                    let hops = self.hops[node as usize] + 1;
                    links
                        .linked(node)
                        .for_each(|neighbor| self.visit(neighbor, hops));
                }
                (None, None) => return &self.hops,
            }
        }
    }

    fn visit(&mut self, node: u32, hops: u32) {
        let known = &mut self.hops[node as usize];
        if *known == UNREACHED {
            *known = hops;
            self.reached.push(node);
        }
    }

    /// The result of the last [`Self::run`].
    pub fn hops(&self) -> &[u32] {
        &self.hops
    }

    /// The nodes that the last run reached, nearest first.
    pub fn reached(&self) -> &[u32] {
        &self.reached
    }

    /// The largest hops of any node reached: the eccentricity of the sources. 0 if there were no sources.
    pub fn eccentricity(&self) -> u32 {
        self.reached
            .last()
            .map_or(0, |&farthest| self.hops[farthest as usize])
    }
}

/// Hops of every node from the nearest of `sources`; see [`HopSearch::run`], which reuses its buffers.
///
/// # Panics
/// If a source does not exist.
pub fn hops(links: &impl Links, sources: impl IntoIterator<Item = StateId>) -> Vec<u32> {
    let mut search = HopSearch::new();
    search.run(links, sources);
    search.hops
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Action;

    /// A cycle 0‥5, an isolated node 6 with a loop, an edge {7, 8}.
    fn three_components() -> Adjacency {
        let mut graph = Adjacency::with_nodes(9);
        (0..6).for_each(|u| assert!(graph.add_edge(u, (u + 1) % 6, 1.0)));
        graph.add_edge(6, 6, 1.0);
        graph.add_edge(8, 7, 1.0);
        graph
    }

    #[test]
    fn hops_on_a_cycle_go_the_shorter_way() {
        let graph = three_components();
        let mut search = HopSearch::new();
        let x = UNREACHED;
        assert_eq!(
            search.run(&graph, [StateId(1)]),
            [1, 0, 1, 2, 3, 2, x, x, x]
        );
        assert_eq!((search.eccentricity(), search.reached().len()), (3, 6));
        assert_eq!(
            search.run(&graph.to_csr(), [StateId(1), StateId(5), StateId(1)]),
            [1, 0, 1, 2, 1, 0, x, x, x]
        );
        assert_eq!(search.run(&graph, []), [x; 9]);
        assert_eq!(search.eccentricity(), 0);
    }

    #[test]
    fn sources_with_handicaps_join_the_search_when_it_is_their_turn() {
        let graph = three_components();
        let mut search = HopSearch::new();
        let x = UNREACHED;
        let sources = [(StateId(3), 2), (StateId(0), 0), (StateId(7), 5)];
        assert_eq!(
            search.run_with_handicaps(&graph, &sources),
            [0, 1, 2, 2, 2, 1, x, 5, 6]
        );
        assert_eq!(search.eccentricity(), 6);
        let hops: Vec<u32> = search
            .reached()
            .iter()
            .map(|&v| search.hops()[v as usize])
            .collect();
        assert!(hops.is_sorted(), "{hops:?}");
        let twice = [(StateId(0), 9), (StateId(0), 1)];
        assert_eq!(search.run_with_handicaps(&graph, &twice)[..3], [1, 2, 3]);
        assert_eq!(search.run_with_handicaps(&graph, &[]), [x; 9]);
    }

    #[test]
    fn nodes_that_join_later_are_counted_from_where_they_were_entered() {
        let mut search = HopSearch::new();
        search.run(&three_components(), [StateId(0)]);
        search.append(StateId(3), StateId(10));
        search.append(StateId(9), StateId(11));
        search.append(StateId(0), StateId(3));
        assert_eq!(search.hops()[9..], [UNREACHED, 4, UNREACHED]);
        assert_eq!(search.hops()[3], 3, "a known node keeps its hops");
        assert_eq!(search.eccentricity(), 3);
    }

    #[test]
    fn one_way_passages_count_in_their_direction() {
        let mut graph = TransitionGraph::new(1);
        let [a, b, c] = std::array::from_fn(|_| graph.add_state());
        graph.record(a, Action(0), 0.0, b, false);
        graph.record(b, Action(0), 0.0, c, false);
        assert_eq!(hops(&Leaving(&graph), [a]), [0, 1, 2]);
        assert_eq!(hops(&Entering(&graph), [a]), [0, UNREACHED, UNREACHED]);
        assert_eq!(hops(&Entering(&graph), [c]), [2, 1, 0]);
        assert_eq!(hops(graph.adjacency(), [c]), [2, 1, 0]);
    }
}
