//! The promises of the transition graph, checked from scratch.

use super::TransitionGraph;
use crate::env::Action;
use crate::graph::StateId;

impl TransitionGraph {
    /// Checks every invariant of the [module](super); meant for tests, after each mutation.
    ///
    /// # Panics
    /// If one does not hold.
    #[doc(hidden)]
    pub fn assert_consistent(&self) {
        let n = self.num_states();
        self.adjacency.assert_consistent();
        assert_eq!(
            (self.digraph.node_count(), self.adjacency.num_nodes()),
            (n, n)
        );
        assert_eq!(self.attempts.len(), n * self.num_actions);
        for state in (0..n as u32).map(StateId) {
            let actions = || (0..self.num_actions).map(|action| Action(action as u16));
            for action in actions() {
                let counts = self
                    .outcomes_of(state, action)
                    .fold(0_u32, |sum, seen| sum.saturating_add(seen.count));
                assert_eq!(self.tries(state, action), counts);
                let mut targets: Vec<StateId> = self
                    .outcomes_of(state, action)
                    .map(|seen| seen.next)
                    .collect();
                targets.sort();
                assert!(
                    targets.is_sorted_by(|a, b| a < b),
                    "a transition is listed twice"
                );
            }
            assert_eq!(
                self.untried_actions(state),
                actions()
                    .filter(|&action| self.tries(state, action) == 0)
                    .count()
            );
            let mut around: Vec<u32> = self.outcomes(state).map(|seen| seen.next.0).collect();
            around.extend(self.predecessors(state).map(|previous| previous.0));
            around.retain(|&other| other != state.0);
            around.sort_unstable();
            around.dedup();
            assert_eq!(self.adjacency.neighbors(state.0), around);
            assert!(
                self.adjacency
                    .weights(state.0)
                    .iter()
                    .all(|&weight| weight == 1.0)
            );
        }
    }
}
