//! Hops on the visited graph, along steps that the agent could take as far as it knows.
//!
//! A step u → v counts as possible if some action of u was seen to lead to v, or if v was seen to lead to u and u
//! still has untried actions, one of which may lead back: so one-way doors are respected once they are known.

use crate::graph::{StateId, TransitionGraph};

/// The distance of states that are not reached.
pub const UNREACHED: u32 = u32::MAX;

/// Distances in hops, with buffers that are reused.
#[derive(Clone, Debug, Default)]
pub struct Distances {
    hops: Vec<u32>,
    layer: Vec<StateId>,
    next_layer: Vec<StateId>,
}

impl Distances {
    /// Hops of `state`; [`UNREACHED`] if it is newer than the last search or was not reached.
    pub fn get(&self, state: StateId) -> u32 {
        self.hops.get(state.index()).copied().unwrap_or(UNREACHED)
    }

    /// The largest distance of a state that was reached; 0 before the first search.
    pub fn eccentricity(&self) -> u32 {
        self.hops
            .iter()
            .copied()
            .filter(|hops| *hops != UNREACHED)
            .max()
            .unwrap_or(0)
    }

    /// A state found after the last search, one hop from `from`.
    pub fn append(&mut self, from: StateId, state: StateId) {
        if state.index() >= self.hops.len() {
            let hops = self.get(from).saturating_add(1);
            self.hops.resize(state.index(), UNREACHED);
            self.hops.push(hops);
        }
    }

    /// Hops from `start` to every state. O(n + m).
    pub fn search_from(&mut self, graph: &TransitionGraph, start: StateId) {
        self.search(graph, &[(start, 0)], |from, to| {
            is_possible(graph, from, to)
        });
    }

    /// Hops from every state to the nearest of `goals`, each with a handicap in hops. O(n + m).
    pub fn search_to(&mut self, graph: &TransitionGraph, goals: &[(StateId, u32)]) {
        self.search(graph, goals, |to, from| is_possible(graph, from, to));
    }

    /// Breadth-first search from sources that join in at their handicap.
    fn search(
        &mut self,
        graph: &TransitionGraph,
        sources: &[(StateId, u32)],
        possible: impl Fn(StateId, StateId) -> bool,
    ) {
        self.hops.clear();
        self.hops.resize(graph.num_states(), UNREACHED);
        let mut waiting: Vec<(StateId, u32)> = sources.to_vec();
        waiting.sort_by_key(|source| std::cmp::Reverse(source.1));
        self.layer.clear();
        let mut depth = 0;
        loop {
            while let Some((source, _)) = waiting.pop_if(|source| source.1 <= depth) {
                if self.hops[source.index()] == UNREACHED {
                    self.hops[source.index()] = depth;
                    self.layer.push(source);
                }
            }
            if self.layer.is_empty() {
                match waiting.last() {
                    Some(source) => depth = source.1,
                    None => return,
                }
                continue;
            }
            self.next_layer.clear();
            for &state in &self.layer {
                for &neighbor in graph.adjacency().neighbors(state.0) {
                    let neighbor = StateId(neighbor);
                    if self.hops[neighbor.index()] == UNREACHED && possible(state, neighbor) {
                        self.hops[neighbor.index()] = depth + 1;
                        self.next_layer.push(neighbor);
                    }
                }
            }
            std::mem::swap(&mut self.layer, &mut self.next_layer);
            depth += 1;
        }
    }
}

fn is_possible(graph: &TransitionGraph, from: StateId, to: StateId) -> bool {
    graph.untried_actions(from) > 0 || graph.outcomes(from).any(|outcome| outcome.next == to)
}
