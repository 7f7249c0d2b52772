//! Hops on the visited graph, along steps that the agent could take as far as it knows.
//!
//! A step u → v counts as possible if some action of u was seen to lead to v, or if v was seen to lead to u and u
//! still has untried actions, one of which may lead back: so one-way doors are respected once they are known. Nothing leads on from
//! where episodes end. Where places have headings no action leads back; there a turn counts as possible that is known to lead to v.

use super::dead_reckoning::DeadReckoning;
use crate::graph::connectivity::{HopSearch, Links, UNREACHED};
use crate::graph::{StateId, TransitionGraph};
use serde::{Deserialize, Serialize};

/// What decides which steps are possible.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known<'a> {
    /// What was seen.
    pub graph: &'a TransitionGraph,
    /// What actions do.
    pub reckoning: &'a DeadReckoning,
    /// By state: episodes end there. Shorter than the graph if the last states are none of these.
    pub ends: &'a [bool],
}

impl Known<'_> {
    /// Whether an action that was not tried in `state` may lead to any of its neighbours.
    fn may_lead_back(&self, state: StateId) -> bool {
        let ends_here = self.ends.get(state.index()).is_some_and(|&ends| ends);
        !ends_here && !self.reckoning.turns() && self.graph.untried_actions(state) > 0
    }
}

/// Possible steps in their direction.
struct PossibleSteps<'a>(Known<'a>);

impl Links for PossibleSteps<'_> {
    fn num_nodes(&self) -> usize {
        self.0.graph.num_states()
    }

    fn linked(&self, node: u32) -> impl Iterator<Item = u32> {
        let (state, graph) = (StateId(node), self.0.graph);
        let guessed = match self.0.may_lead_back(state) {
            true => graph.adjacency().neighbors(node),
            false => &[],
        };
        let seen = graph.outcomes(state).map(|outcome| outcome.next.0);
        let turns = self.0.reckoning.known_turns(graph, state);
        seen.chain(guessed.iter().copied())
            .chain(turns.map(|next| next.0))
    }
}

/// Possible steps against their direction.
struct PossibleStepsBack<'a>(Known<'a>);

impl Links for PossibleStepsBack<'_> {
    fn num_nodes(&self) -> usize {
        self.0.graph.num_states()
    }

    fn linked(&self, node: u32) -> impl Iterator<Item = u32> {
        let (state, graph) = (StateId(node), self.0.graph);
        let neighbors = graph.adjacency().neighbors(node).iter().copied();
        let guessed = neighbors.filter(|&u| self.0.may_lead_back(StateId(u)));
        let seen = graph.predecessors(state).map(|previous| previous.0);
        let turns = self.0.reckoning.known_turns_to(graph, state);
        seen.chain(guessed).chain(turns.map(|previous| previous.0))
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
    pub(super) fn search_from(&mut self, known: Known<'_>, start: StateId) {
        self.search.run(&PossibleSteps(known), [start]);
    }

    /// Hops from every state to the nearest of `goals`, each with a handicap in hops. O(n + m).
    ///
    /// # Panics
    /// If a goal is not in the graph.
    pub(super) fn search_to(&mut self, known: Known<'_>, goals: &[(StateId, u32)]) {
        self.search
            .run_with_handicaps(&PossibleStepsBack(known), goals);
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
    fn is_possible(graph: &TransitionGraph, ends: &[bool], from: StateId, to: StateId) -> bool {
        let leads = |u, v| graph.outcomes(u).any(|outcome| outcome.next == v);
        let may_lead_back =
            graph.untried_actions(from) > 0 && ends.get(from.index()) != Some(&true);
        leads(from, to) || (leads(to, from) && may_lead_back)
    }

    /// All possible steps as a petgraph, with one node more that leads to (or from) the sources at their handicaps.
    fn oracle(
        graph: &TransitionGraph,
        ends: &[bool],
        sources: &[(StateId, u32)],
        back: bool,
    ) -> Vec<u32> {
        let n = graph.num_states() as u32;
        let mut steps = DiGraph::<(), u32>::new();
        for _ in 0..=n {
            steps.add_node(());
        }
        for (u, v) in (0..n).flat_map(|u| (0..n).map(move |v| (u, v))) {
            if u != v && is_possible(graph, ends, StateId(u), StateId(v)) {
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
            ends in prop::collection::vec(any::<bool>(), 0..9),
        ) {
            let n = graph.num_states() as u32;
            let reckoning = unaware(&graph);
            let known = Known { graph: &graph, reckoning: &reckoning, ends: &ends };
            let mut distances = Distances::default();
            let start = StateId(start % n);
            distances.search_from(known, start);
            prop_assert_eq!(all(&distances, &graph), oracle(&graph, &ends, &[(start, 0)], false));
            let goals: Vec<_> = goals.iter().map(|&(g, h)| (StateId(g % n), h)).collect();
            distances.search_to(known, &goals);
            let expected = oracle(&graph, &ends, &goals, true);
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
        let reckoning = unaware(&graph);
        let hops_of_yard = |graph: &TransitionGraph, ends: &[bool]| {
            let mut distances = Distances::default();
            let (graph, reckoning) = (graph, &reckoning);
            let known = Known {
                graph,
                reckoning,
                ends,
            };
            distances.search_to(known, &[(hall, 0)]);
            let back = distances.get(yard);
            distances.search_from(known, hall);
            (back, distances.get(yard))
        };
        assert_eq!(
            hops_of_yard(&graph, &[]),
            (1, 1),
            "what was not tried may lead back"
        );
        let yard_ends = [false, true];
        assert_eq!(
            hops_of_yard(&graph, &yard_ends),
            (UNREACHED, 1),
            "but not from an end"
        );
        graph.record(yard, Action(0), -1.0, yard, false);
        assert_eq!(hops_of_yard(&graph, &[]), (UNREACHED, 1));
    }

    /// A goal next to the way to a better one is not on it.
    #[test]
    fn a_handicap_is_not_walked_around() {
        let mut graph = TransitionGraph::new(2);
        let [start, poor, rich] = std::array::from_fn(|_| graph.add_state());
        graph.record(start, Action(0), -1.0, poor, true);
        graph.record(start, Action(1), -1.0, rich, true);
        let reckoning = unaware(&graph);
        let known = Known {
            graph: &graph,
            reckoning: &reckoning,
            ends: &[false, true, true],
        };
        let mut distances = Distances::default();
        distances.search_to(known, &[(poor, 7), (rich, 0)]);
        assert_eq!(all(&distances, &graph), [1, 7, 0]);
    }
}
