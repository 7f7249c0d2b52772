//! Hops on the visited graph, along steps that the agent could take as far as it knows.
//!
//! A step u → v counts as possible if some action of u was seen to lead to v, or if v was seen to lead to u and u
//! still has untried actions, one of which may lead back: so one-way doors are respected once they are known. Where places have
//! headings no action leads back; there a turn counts as possible that is known to lead to v.

use super::dead_reckoning::DeadReckoning;
use crate::graph::connectivity::{HopSearch, Links, UNREACHED};
use crate::graph::{StateId, TransitionGraph};
use serde::{Deserialize, Serialize};

/// Possible steps in their direction.
#[derive(Clone, Copy, Debug)]
pub struct PossibleSteps<'a>(pub &'a TransitionGraph, pub &'a DeadReckoning);

impl Links for PossibleSteps<'_> {
    fn num_nodes(&self) -> usize {
        self.0.num_states()
    }

    fn linked(&self, node: u32) -> impl Iterator<Item = u32> {
        let state = StateId(node);
        let guessed = match self.0.untried_actions(state) {
            0 => &[],
            _ if self.1.turns() => &[],
            _ => self.0.adjacency().neighbors(node),
        };
        let seen = self.0.outcomes(state).map(|outcome| outcome.next.0);
        let turns = self.1.known_turns(self.0, state).map(|next| next.0);
        seen.chain(guessed.iter().copied()).chain(turns)
    }
}

/// Possible steps against their direction.
#[derive(Clone, Copy, Debug)]
pub struct PossibleStepsBack<'a>(pub &'a TransitionGraph, pub &'a DeadReckoning);

impl Links for PossibleStepsBack<'_> {
    fn num_nodes(&self) -> usize {
        self.0.num_states()
    }

    fn linked(&self, node: u32) -> impl Iterator<Item = u32> {
        let may_lead_back = !self.1.turns();
        let has_untried = move |u: &u32| may_lead_back && self.0.untried_actions(StateId(*u)) > 0;
        let neighbors = self.0.adjacency().neighbors(node).iter().copied();
        let seen = self
            .0
            .predecessors(StateId(node))
            .map(|previous| previous.0);
        let turns = self.1.known_turns_to(self.0, StateId(node));
        seen.chain(neighbors.filter(has_untried))
            .chain(turns.map(|previous| previous.0))
    }
}

/// Distances in hops, as of the last search.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Distances {
    search: HopSearch,
}

impl Distances {
    /// Hops of `state`; [`UNREACHED`] if it was not reached, or is newer than the last search and was not
    /// [appended](Self::append).
    pub fn get(&self, state: StateId) -> u32 {
        let hops = self.search.hops().get(state.index());
        hops.copied().unwrap_or(UNREACHED)
    }

    /// The largest distance of a state that the last search reached; 0 before the first one.
    pub fn eccentricity(&self) -> u32 {
        self.search.eccentricity()
    }

    /// A state found after the last search, one hop from `from`. Amortised O(1).
    pub fn append(&mut self, from: StateId, state: StateId) {
        self.search.append(from, state);
    }

    /// Hops from `start` to every state. O(n + m).
    ///
    /// # Panics
    /// If `start` is not in the graph.
    pub fn search_from(
        &mut self,
        graph: &TransitionGraph,
        reckoning: &DeadReckoning,
        start: StateId,
    ) {
        self.search.run(&PossibleSteps(graph, reckoning), [start]);
    }

    /// Hops from every state to the nearest of `goals`, each with a handicap in hops. O(n + m).
    ///
    /// # Panics
    /// If a goal is not in the graph.
    pub fn search_to(
        &mut self,
        graph: &TransitionGraph,
        reckoning: &DeadReckoning,
        goals: &[(StateId, u32)],
    ) {
        self.search
            .run_with_handicaps(&PossibleStepsBack(graph, reckoning), goals);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Action;
    use crate::exploration::fixtures::small_graphs;
    use petgraph::algo::dijkstra;
    use petgraph::graph::{DiGraph, NodeIndex};
    use proptest::prelude::*;

    /// Knows nothing of what actions do.
    fn unaware(graph: &TransitionGraph) -> DeadReckoning {
        DeadReckoning::new(graph.num_actions(), true)
    }

    /// The rule of the module's head, pair by pair.
    fn is_possible(graph: &TransitionGraph, from: StateId, to: StateId) -> bool {
        let leads = |u, v| graph.outcomes(u).any(|outcome| outcome.next == v);
        leads(from, to) || (leads(to, from) && graph.untried_actions(from) > 0)
    }

    /// All possible steps as a petgraph, with one node more that leads to (or from) the sources at their handicaps.
    fn oracle(graph: &TransitionGraph, sources: &[(StateId, u32)], back: bool) -> Vec<u32> {
        let n = graph.num_states() as u32;
        let mut steps = DiGraph::<(), u32>::new();
        for _ in 0..=n {
            steps.add_node(());
        }
        for (u, v) in (0..n).flat_map(|u| (0..n).map(move |v| (u, v))) {
            if u != v && is_possible(graph, StateId(u), StateId(v)) {
                let (from, to) = if back { (v, u) } else { (u, v) };
                steps.add_edge(from.into(), to.into(), 1);
            }
        }
        let origin = NodeIndex::from(n);
        for &(source, handicap) in sources {
            steps.add_edge(origin, source.0.into(), handicap);
        }
        let found = dijkstra(&steps, origin, None, |edge| *edge.weight());
        (0..n)
            .map(|v| found.get(&NodeIndex::from(v)).copied().unwrap_or(UNREACHED))
            .collect()
    }

    fn all(distances: &Distances, graph: &TransitionGraph) -> Vec<u32> {
        (0..graph.num_states() as u32)
            .map(|s| distances.get(StateId(s)))
            .collect()
    }

    proptest! {
        #[test]
        fn distances_are_those_of_dijkstra(
            graph in small_graphs(),
            start in 0u32..8,
            goals in prop::collection::vec((0u32..8, 0u32..5), 1..4),
        ) {
            let n = graph.num_states() as u32;
            let mut distances = Distances::default();
            let start = StateId(start % n);
            distances.search_from(&graph, &unaware(&graph), start);
            prop_assert_eq!(all(&distances, &graph), oracle(&graph, &[(start, 0)], false));
            let goals: Vec<_> = goals.iter().map(|&(g, h)| (StateId(g % n), h)).collect();
            distances.search_to(&graph, &unaware(&graph), &goals);
            let expected = oracle(&graph, &goals, true);
            prop_assert_eq!(all(&distances, &graph), &expected[..]);
            let farthest = expected.into_iter().filter(|&hops| hops != UNREACHED).max();
            prop_assert_eq!(distances.eccentricity(), farthest.unwrap_or(0));
        }
    }

    #[test]
    fn a_door_is_one_way_once_everything_behind_it_was_tried() {
        let mut graph = TransitionGraph::new(1);
        let [hall, yard] = std::array::from_fn(|_| graph.add_state());
        graph.record(hall, Action(0), -1.0, yard, false);
        let mut distances = Distances::default();
        distances.search_to(&graph, &unaware(&graph), &[(hall, 0)]);
        assert_eq!(distances.get(yard), 1, "the untried action may lead back");
        graph.record(yard, Action(0), -1.0, yard, false);
        distances.search_to(&graph, &unaware(&graph), &[(hall, 0)]);
        assert_eq!(distances.get(yard), UNREACHED);
        distances.search_from(&graph, &unaware(&graph), hall);
        assert_eq!(distances.get(yard), 1);
    }
}
