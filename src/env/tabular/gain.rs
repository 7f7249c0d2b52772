//! The most that can be earned a step for ever: g* = max over policies and recurrent classes of Σ μ(s) r(s, π(s)).
//!
//! A policy that never ends comes to stay in an end component: a set of states with actions that cannot leave it and lead
//! from each of its states to each other one (de Alfaro 1997). Within a maximal one every state has the same best gain, and
//! for any h
//!
//!   min_s (Th − h)(s) ≤ g* ≤ max_s (Th − h)(s),   (Th)(s) = max_a Σ P (R + h(s′)),
//!
//! bounds that relative value iteration closes (Puterman 1994, section 8.5); half of each step is left out, so that it
//! converges where policies are periodic. With γ = 1 a return without a limit is unbounded exactly where g* > 0.

use super::TabularMdp;
use crate::env::Action;
use petgraph::algo::kosaraju_scc;
use petgraph::graph::{DiGraph, NodeIndex};

/// A gain below this share of the largest reward is none: far above rounding.
const NO_GAIN: f64 = 1e-9;
/// The bounds are closed when they differ by less than this share of the upper one.
const CLOSED: f64 = 1e-6;
/// Outcomes looked at before the bounds are taken as they are: a second of work or less.
const MAX_WORK: usize = 100_000_000;
/// Share of each step that is taken.
const STEP: f64 = 0.5;

/// States among which one can stay for ever, each with the actions that do not leave.
pub(super) type EndComponent = Vec<(usize, Vec<Action>)>;

impl TabularMdp {
    /// The largest mean reward a step that a policy can go on earning without an end, once it is where it is earned, among
    /// what can be reached from `starts`; `None` if none pays, that is if all are zero or less.
    ///
    /// Good to a millionth of it. In components so large and slow that this would take long, a lower bound, and `None`
    /// if that is not above zero.
    ///
    /// # Panics
    /// If a start is no state.
    pub fn best_gain(&self, starts: &[usize]) -> Option<f64> {
        let reached = self.reachable_from(starts);
        let ends = |next: u32| self.terminal[next as usize];
        let pays_on_the_way = (0..self.num_states())
            .filter(|&state| reached[state])
            .flat_map(|state| self.outcomes_of_state(state))
            .any(|outcome| outcome.reward > 0.0 && !ends(outcome.next));
        if !pays_on_the_way {
            return None;
        }
        let components = self.end_components(&reached);
        let gains = components.iter().filter_map(|c| self.gain_within(c));
        gains.max_by(f64::total_cmp)
    }

    /// The maximal end components among `allowed` states: strongly connected components of the actions that cannot leave
    /// their component, taken again until none of them can. O(outcomes) a round, a few rounds.
    fn end_components(&self, allowed: &[bool]) -> Vec<EndComponent> {
        // Where each state belongs; terminal and forbidden states belong nowhere.
        let mut component: Vec<Option<usize>> = (0..self.num_states())
            .map(|state| (allowed[state] && !self.terminal[state]).then_some(0))
            .collect();
        loop {
            let next = self.components_within(&component);
            if next == component {
                break;
            }
            component = next;
        }
        let count = component.iter().flatten().max().map_or(0, |last| last + 1);
        let mut components = vec![EndComponent::new(); count];
        for (state, &own) in component.iter().enumerate() {
            if let Some(own) = own {
                components[own].push((state, self.staying(state, &component)));
            }
        }
        components
    }

    /// Splits components at the actions that leave them; states without any other action drop out.
    fn components_within(&self, component: &[Option<usize>]) -> Vec<Option<usize>> {
        let mut graph = DiGraph::<(), ()>::new();
        for _ in 0..self.num_states() {
            graph.add_node(());
        }
        let mut stays = vec![false; self.num_states()];
        for (state, stays) in stays.iter_mut().enumerate() {
            for action in self.staying(state, component) {
                *stays = true;
                for outcome in self.outcomes(state, action) {
                    graph.add_edge(
                        NodeIndex::new(state),
                        NodeIndex::new(outcome.next as usize),
                        (),
                    );
                }
            }
        }
        let mut parts = kosaraju_scc(&graph);
        parts.retain(|part| part.iter().any(|node| stays[node.index()]));
        // Numbered by their first states, so that equal partitions have equal numbers.
        for part in &mut parts {
            part.sort_unstable();
        }
        parts.sort_unstable();
        let mut next = vec![None; self.num_states()];
        for (number, part) in parts.iter().enumerate() {
            for node in part.iter().filter(|node| stays[node.index()]) {
                next[node.index()] = Some(number);
            }
        }
        next
    }

    /// The actions of `state` that cannot leave its component; none if it has no component.
    fn staying(&self, state: usize, component: &[Option<usize>]) -> Vec<Action> {
        let Some(own) = component[state] else {
            return Vec::new();
        };
        let stays = |&action: &Action| {
            let mut outcomes = self.outcomes(state, action).iter();
            outcomes.all(|outcome| component[outcome.next as usize] == Some(own))
        };
        self.actions().filter(stays).collect()
    }

    /// g* within an end component, if it is above zero.
    fn gain_within(&self, component: &EndComponent) -> Option<f64> {
        let pairs = component
            .iter()
            .flat_map(|(state, actions)| actions.iter().map(move |&action| (*state, action)));
        let outcomes: Vec<_> = pairs
            .flat_map(|(s, action)| self.outcomes(s, action))
            .collect();
        let largest = outcomes.iter().fold(0.0_f64, |l, o| l.max(o.reward.abs()));
        if outcomes.iter().all(|outcome| outcome.reward <= 0.0) {
            return None;
        }
        let none = NO_GAIN * largest;
        let (lower, _) = self.gain_bounds(component, |lower, upper| {
            upper <= none || upper - lower <= CLOSED * upper
        });
        (lower > none).then_some(lower)
    }

    /// Bounds of g* within an end component, until they are closed enough or [`MAX_WORK`] outcomes were looked at.
    pub(super) fn gain_bounds(
        &self,
        component: &EndComponent,
        is_closed: impl Fn(f64, f64) -> bool,
    ) -> (f64, f64) {
        let outcomes: usize = component
            .iter()
            .flat_map(|(state, actions)| actions.iter().map(|&a| self.outcomes(*state, a).len()))
            .sum();
        let mut ahead = vec![0.0; self.num_states()];
        let mut change = vec![0.0; component.len()];
        let (mut lower, mut upper) = (f64::NEG_INFINITY, f64::INFINITY);
        for _ in 0..(MAX_WORK / outcomes).max(1) {
            for (change, (state, actions)) in change.iter_mut().zip(component) {
                let values = actions
                    .iter()
                    .map(|&action| self.action_value(&ahead, 1.0, *state, action));
                *change = values.fold(f64::NEG_INFINITY, f64::max) - ahead[*state];
            }
            lower = change
                .iter()
                .copied()
                .fold(f64::INFINITY, f64::min)
                .max(lower);
            upper = change
                .iter()
                .copied()
                .fold(f64::NEG_INFINITY, f64::max)
                .min(upper);
            if is_closed(lower, upper) {
                break;
            }
            let origin = ahead[component[0].0] + STEP * change[0];
            for (change, (state, _)) in change.iter().zip(component) {
                ahead[*state] += STEP * change - origin;
            }
        }
        (lower, upper)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Outcome;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    fn sure(next: u32, reward: f64) -> Vec<Outcome> {
        vec![Outcome {
            next,
            probability: 1.0,
            reward,
        }]
    }

    fn coin(a: (u32, f64), b: (u32, f64)) -> Vec<Outcome> {
        [a, b]
            .map(|(next, reward)| Outcome {
                next,
                probability: 0.5,
                reward,
            })
            .to_vec()
    }

    fn gain(actions: &[Vec<Vec<Outcome>>]) -> Option<f64> {
        let terminal = actions.iter().map(Vec::is_empty).collect();
        TabularMdp::new(actions, terminal).unwrap().best_gain(&[0])
    }

    #[test]
    fn loops_pay_their_mean() {
        let near = |gain: Option<f64>, expected: f64| {
            assert!(
                (gain.unwrap() - expected).abs() < 1e-5 * expected,
                "{gain:?}"
            );
        };
        near(gain(&[vec![sure(0, 1.0), sure(1, -1.0)], vec![]]), 1.0);
        // There +3, back −2: a half a step. A loop of three that pays 1.2 is no better.
        let two = vec![sure(1, 3.0), sure(2, 0.0)];
        let back = vec![sure(0, -2.0), sure(0, -2.0)];
        near(
            gain(&[two, back, vec![sure(3, 0.0); 2], vec![sure(0, 1.2); 2]]),
            0.5,
        );
        // A coin that pays 3 or takes 1, for ever.
        near(
            gain(&[vec![coin((0, 3.0), (0, -1.0)), sure(1, 0.0)], vec![]]),
            1.0,
        );
    }

    #[test]
    fn what_costs_what_it_pays_or_surely_ends_is_no_gain() {
        assert_eq!(gain(&[vec![sure(1, 2.0)], vec![sure(0, -2.0)]]), None);
        assert_eq!(gain(&[vec![coin((0, 1.0), (0, -1.0))]]), None);
        // Pays each time, but leaks into the end.
        assert_eq!(gain(&[vec![coin((0, 5.0), (1, 5.0))], vec![]]), None);
        assert_eq!(gain(&[vec![sure(1, 7.0)], vec![]]), None);
        // It pays where no start leads.
        assert_eq!(
            gain(&[vec![sure(1, 0.0)], vec![], vec![sure(2, 1.0)]]),
            None
        );
    }

    /// The largest mean reward of any deterministic policy from any state that can be reached from 0, by a high power of
    /// its transition matrix. Ends earn 0 for ever.
    fn by_all_policies(actions: &[Vec<Vec<Outcome>>]) -> f64 {
        let n = actions.len();
        let terminal = actions.iter().map(Vec::is_empty).collect();
        let reached = TabularMdp::new(actions, terminal)
            .unwrap()
            .reachable_from(&[0]);
        let choices = actions.iter().map(Vec::len).max().unwrap();
        let mut best = 0.0_f64;
        for code in 0..choices.pow(n as u32) {
            let mut p = DMatrix::<f64>::zeros(n, n);
            let mut r = DVector::<f64>::zeros(n);
            for (s, own) in actions.iter().enumerate() {
                match own.get(code / choices.pow(s as u32) % choices) {
                    None => p[(s, s)] = 1.0,
                    Some(outcomes) => {
                        for o in outcomes {
                            p[(s, o.next as usize)] += o.probability;
                            r[s] += o.probability * o.reward;
                        }
                    }
                }
            }
            // Half of each step left out: the same stationary distributions, and no period.
            let mut power = (DMatrix::identity(n, n) + p) * 0.5;
            for _ in 0..14 {
                power = &power * &power;
            }
            let means = power * r;
            best = (0..n)
                .filter(|&s| reached[s])
                .map(|s| means[s])
                .fold(best, f64::max);
        }
        best
    }

    fn small_world() -> impl Strategy<Value = Vec<Vec<Vec<Outcome>>>> {
        let row = (0..4_u32, 0..4_u32, -3..4_i32, -3..4_i32)
            .prop_map(|(a, b, x, y)| coin((a, f64::from(x)), (b, f64::from(y))));
        let state = prop::collection::vec(row, 2);
        prop::collection::vec(state, 3).prop_map(|mut states| {
            states.push(vec![]);
            states
        })
    }

    proptest! {
        #[test]
        fn as_trying_all_policies(world in small_world()) {
            let found = gain(&world).unwrap_or(0.0);
            let brute = by_all_policies(&world);
            prop_assert!((found - brute).abs() < 1e-5, "{} {}", found, brute);
        }
    }
}
