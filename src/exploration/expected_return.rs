//! Expected return of the best policy on what was seen.
//!
//! ```text
//! V(s) = max_a Σ_s′ P̂(s′|s, a) (r̂ + λ V(s′)),   V = 0 after an end,   λ = 1 − 10⁻⁵
//! ```
//!
//! over the actions tried, by Gauss–Seidel sweeps from the values before. With λ below 1, what never ends has a value, too: it is
//! where values of new states begin, so that they rise, a path at a sweep, and never have to sink a step at a time.

use crate::graph::{StateId, TransitionGraph};
use serde::{Deserialize, Serialize};

/// 1 − λ: chance that an episode ends by itself after a step.
const END_OF_TIME: f64 = 1e-5;
/// Sweeps of one update at most; what is left is done by the next.
const SWEEPS: usize = 50;
/// Changes below this share of the mean cost of a step end an update.
const TOLERANCE: f64 = 1e-2;

/// V by state, as of the last update.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct ExpectedReturn {
    values: Vec<f64>,
}

impl ExpectedReturn {
    /// V(state); `None` if it was not known at the last update.
    pub fn get(&self, state: StateId) -> Option<f64> {
        self.values.get(state.index()).copied()
    }

    /// Brings V up to date with `graph`, whose episodes end in the states that `is_terminal` (shorter if the last ones are none) and
    /// where any other step costs `step_cost` > 0 on average. O(sweeps · transitions).
    pub fn update(&mut self, graph: &TransitionGraph, is_terminal: &[bool], step_cost: f64) {
        self.values
            .resize(graph.num_states(), -step_cost / END_OF_TIME);
        let mut actions = vec![(0.0, 0.0); graph.num_actions()];
        for _ in 0..SWEEPS {
            let mut largest = 0.0_f64;
            for s in (0..graph.num_states()).rev() {
                if let Some(value) = self.best(graph, is_terminal, StateId(s as u32), &mut actions)
                {
                    largest = largest.max((value - self.values[s]).abs());
                    self.values[s] = value;
                }
            }
            if largest <= TOLERANCE * step_cost {
                break;
            }
        }
    }

    /// max_a Q(state, a), `None` if nothing was tried; `actions` is room for the sum of returns and of tries of each.
    fn best(
        &self,
        graph: &TransitionGraph,
        is_terminal: &[bool],
        state: StateId,
        actions: &mut [(f64, f64)],
    ) -> Option<f64> {
        actions.fill((0.0, 0.0));
        for seen in graph.outcomes(state) {
            let tries = f64::from(seen.count);
            let ahead = match is_terminal.get(seen.next.index()) {
                Some(true) => 0.0,
                _ => (1.0 - END_OF_TIME) * self.values[seen.next.index()],
            };
            let (sum, total) = &mut actions[seen.action.index()];
            *sum += seen.reward_sum + tries * ahead;
            *total += tries;
        }
        let tried = actions.iter().filter(|(_, tries)| *tries > 0.0);
        tried.map(|(sum, tries)| sum / tries).reduce(f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::{Action, Outcome, TabularMdp};
    use proptest::prelude::*;

    /// 0 –0→ 1 –0→ 2, an end; 0 –1→ 2 or, as often, back to 0.
    fn shortcut(pit: f64) -> TransitionGraph {
        let mut graph = TransitionGraph::new(2);
        (0..3).for_each(|_| {
            graph.add_state();
        });
        let [start, middle, end] = [StateId(0), StateId(1), StateId(2)];
        graph.record(start, Action(0), -1.0, middle, false);
        graph.record(middle, Action(0), -1.0, end, true);
        graph.record(start, Action(1), pit, end, true);
        graph.record(start, Action(1), -1.0, start, false);
        graph
    }

    #[test]
    fn risk_counts() {
        for (pit, expected) in [(-1.0, -2.0), (-9.0, -2.0), (5.0, 4.0)] {
            let mut found = ExpectedReturn::default();
            found.update(&shortcut(pit), &[false, false, true], 1.0);
            let value = found.get(StateId(0)).unwrap();
            assert!((value - expected).abs() < 1e-2, "{pit}: {value}");
        }
    }

    #[test]
    fn without_an_end_it_is_the_cost_of_all_time_and_an_end_is_noticed() {
        let mut graph = TransitionGraph::new(1);
        let start = graph.add_state();
        graph.record(start, Action(0), -1.0, start, false);
        let mut found = ExpectedReturn::default();
        assert_eq!(found.get(start), None);
        found.update(&graph, &[], 1.0);
        assert!((found.get(start).unwrap() + 1e5).abs() < 1.0);
        let end = graph.add_state();
        graph.record(start, Action(0), -1.0, end, true);
        for _ in 0..3 {
            found.update(&graph, &[false, true], 1.0);
        }
        assert!((found.get(start).unwrap() + 2.0).abs() < 1e-2);
    }

    fn outcome() -> impl Strategy<Value = (u32, f64)> {
        (0..6_u32, -3.0..-0.5_f64)
    }

    proptest! {
        /// Against the solver of known worlds. Everything can end, for each action of a state has an end among its outcomes.
        #[test]
        fn as_value_iteration_on_the_same_chances(
            outcomes in prop::collection::vec(prop::collection::vec(prop::collection::vec(outcome(), 0..3), 2), 5),
        ) {
            let mut graph = TransitionGraph::new(2);
            (0..6).for_each(|_| {
                graph.add_state();
            });
            let mut world: Vec<Vec<Vec<Outcome>>> = Vec::new();
            for (s, actions) in outcomes.iter().enumerate() {
                let mut rows = Vec::new();
                for (a, seen) in actions.iter().enumerate() {
                    let mut all = seen.clone();
                    all.push((5, -1.0));
                    for &(next, reward) in &all {
                        graph.record(StateId(s as u32), Action(a as u16), reward, StateId(next), next == 5);
                    }
                    let probability = 1.0 / all.len() as f64;
                    rows.push(all.iter().map(|&(next, reward)| Outcome { next, probability, reward }).collect());
                }
                world.push(rows);
            }
            world.push(vec![]);
            let mdp = TabularMdp::new(&world, vec![false, false, false, false, false, true]).unwrap();
            let mut found = ExpectedReturn::default();
            found.update(&graph, &[false, false, false, false, false, true], 1.0);
            for s in 0..5 {
                let expected = mdp.optimal_return(&[s], 10_000);
                let value = found.get(StateId(s as u32)).unwrap();
                prop_assert!((value - expected).abs() < 0.02, "{} {}", value, expected);
            }
        }
    }
}
