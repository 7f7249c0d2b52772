//! v*(s) = max_a Σ_{s′} P(s′ | s, a) (R(s, a, s′) + γ v*(s′)), v* = 0 where episodes end.
//!
//! Gauss–Seidel sweeps (Bertsekas, Dynamic Programming and Optimal Control, vol. II): each state uses the values already improved in this sweep. States
//! are visited in the order of their distance to the end, and values begin as if every transition cost as much as the
//! dearest one, so that in a deterministic world where all steps cost the same the first sweep is exact.
//!
//! With γ = 1 this is a stochastic shortest path. Only policies that end with probability 1 count; a state without one has
//! the value −∞.

use super::{Action, TabularMdp};

/// Sweeps after which an iteration gives up: an MDP whose values are not finite never settles.
const MAX_SWEEPS: usize = 100_000;

/// Values of all states, and how they were found.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueFunction {
    /// One per state.
    pub values: Vec<f64>,
    /// Sweeps over all states.
    pub sweeps: usize,
    /// Whether the change fell below the tolerance before the sweeps ran out.
    pub converged: bool,
}

impl TabularMdp {
    /// The optimal values, within `tol` of the true ones if γ < 1; if γ = 1 the last sweep changed none by more than
    /// `tol`. O(outcomes) a sweep.
    ///
    /// # Panics
    /// If `gamma` is outside [0, 1] or `tol` is not positive.
    pub fn value_iteration(&self, gamma: f64, tol: f64) -> ValueFunction {
        self.value_iteration_within(gamma, tol, MAX_SWEEPS)
    }

    /// The same, given up after `max_sweeps`.
    pub(super) fn value_iteration_within(
        &self,
        gamma: f64,
        tol: f64,
        max_sweeps: usize,
    ) -> ValueFunction {
        self.iterate(gamma, tol, max_sweeps, |values, state| {
            let backups = self
                .actions()
                .map(|action| self.action_value(values, gamma, state, action));
            backups.fold(f64::NEG_INFINITY, f64::max)
        })
    }

    /// The values of a policy, `policy[s · |A| + a]` = π(a | s); tolerance and cost as
    /// [`value_iteration`](Self::value_iteration). With γ = 1 and a policy that does not end it does not converge.
    ///
    /// # Panics
    /// If `policy` has not one entry per state and action, `gamma` is outside [0, 1], or `tol` is not positive.
    pub fn policy_evaluation(&self, policy: &[f64], gamma: f64, tol: f64) -> ValueFunction {
        assert_eq!(
            policy.len(),
            self.num_states() * self.num_actions,
            "π has states × actions entries"
        );
        self.iterate(gamma, tol, MAX_SWEEPS, |values, state| {
            let weighted = |action: Action| match policy[state * self.num_actions + action.index()]
            {
                // An action that is never taken may have the value −∞, which 0 would turn into NaN.
                0.0 => 0.0,
                weight => weight * self.action_value(values, gamma, state, action),
            };
            self.actions().map(weighted).sum()
        })
    }

    /// Q(s, a) = Σ P (R + γ v(s′)); 0 if `state` is terminal.
    ///
    /// # Panics
    /// If there is no such state or action, or `values` has not one entry per state.
    pub fn action_value(&self, values: &[f64], gamma: f64, state: usize, action: Action) -> f64 {
        assert_eq!(values.len(), self.num_states(), "one value per state");
        let worth = |next: u32| {
            if gamma == 0.0 {
                0.0
            } else {
                gamma * values[next as usize]
            }
        };
        let outcomes = self.outcomes(state, action);
        outcomes
            .iter()
            .map(|outcome| outcome.probability * (outcome.reward + worth(outcome.next)))
            .sum()
    }

    /// Every action whose value is within `tol` of the best; none if `state` is terminal.
    ///
    /// # Panics
    /// As [`action_value`](Self::action_value).
    pub fn greedy_actions(
        &self,
        values: &[f64],
        gamma: f64,
        state: usize,
        tol: f64,
    ) -> Vec<Action> {
        if self.terminal[state] {
            return Vec::new();
        }
        let value = |action| self.action_value(values, gamma, state, action);
        let best = self.actions().map(value).fold(f64::NEG_INFINITY, f64::max);
        self.actions()
            .filter(|&action| value(action) >= best - tol)
            .collect()
    }

    /// Sweeps `backup` over the states until no value changes by more than what `tol` allows.
    fn iterate(
        &self,
        gamma: f64,
        tol: f64,
        max_sweeps: usize,
        backup: impl Fn(&[f64], usize) -> f64,
    ) -> ValueFunction {
        assert!(
            (0.0..=1.0).contains(&gamma),
            "γ = {gamma} is outside [0, 1]"
        );
        assert!(tol > 0.0, "tolerance {tol} is not positive");
        let distance = self.distances_to_terminal();
        let mut values = self.first_guess(gamma, &distance);
        let order = self.order_of_sweeps(gamma, &distance, &mut values);
        // A sweep is a contraction by γ, so ‖v − v*‖ ≤ γ/(1 − γ) · change of the last sweep.
        let allowed = if gamma == 1.0 {
            tol
        } else {
            tol * (1.0 - gamma) / gamma.max(f64::MIN_POSITIVE)
        };
        for sweeps in 1..=max_sweeps {
            let (mut change, mut largest) = (0.0_f64, 0.0_f64);
            for &state in &order {
                let value = backup(&values, state as usize);
                // f64::max drops a NaN, which would then pass for convergence.
                let difference = (value - values[state as usize]).abs();
                change = if difference.is_nan() {
                    f64::INFINITY
                } else {
                    change.max(difference)
                };
                largest = largest.max(value.abs());
                values[state as usize] = value;
            }
            // A change below rounding cannot shrink further.
            if change <= allowed.max(4.0 * f64::EPSILON * largest) {
                return ValueFunction {
                    values,
                    sweeps,
                    converged: true,
                };
            }
        }
        ValueFunction {
            values,
            sweeps: max_sweeps,
            converged: false,
        }
    }

    /// What each state would be worth if every transition cost as much as the dearest: r (1 − γ^d)/(1 − γ), or r d.
    fn first_guess(&self, gamma: f64, distance: &[Option<u32>]) -> Vec<f64> {
        let dearest = self
            .outcomes
            .iter()
            .map(|outcome| outcome.reward)
            .fold(0.0, f64::min);
        let guess = |transitions: &Option<u32>| match transitions {
            Some(transitions) if gamma == 1.0 => dearest * f64::from(*transitions),
            None if gamma == 1.0 => 0.0,
            Some(transitions) => {
                dearest * (1.0 - libm::pow(gamma, f64::from(*transitions))) / (1.0 - gamma)
            }
            None => dearest / (1.0 - gamma),
        };
        distance.iter().map(guess).collect()
    }

    /// Non-terminal states, nearest to the end first. With γ = 1 those that cannot surely end get −∞ and are left out.
    fn order_of_sweeps(
        &self,
        gamma: f64,
        distance: &[Option<u32>],
        values: &mut [f64],
    ) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.num_states() as u32)
            .filter(|&state| !self.terminal[state as usize])
            .collect();
        if gamma == 1.0 {
            let ends = self.can_surely_end();
            for (value, _) in values.iter_mut().zip(&ends).filter(|(_, ends)| !**ends) {
                *value = f64::NEG_INFINITY;
            }
            order.retain(|&state| ends[state as usize]);
        }
        order.sort_by_key(|&state| distance[state as usize].unwrap_or(u32::MAX));
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Outcome;

    fn outcome(next: u32, probability: f64, reward: f64) -> Outcome {
        Outcome {
            next,
            probability,
            reward,
        }
    }

    /// One state that tries again and again: succeeds with probability p, at a cost of 1 a try.
    fn geometric(p: f64) -> TabularMdp {
        let tries = vec![outcome(0, 1.0 - p, -1.0), outcome(1, p, -1.0)];
        TabularMdp::new(&[vec![tries], vec![]], vec![false, true]).unwrap()
    }

    #[test]
    fn repeated_tries_match_the_geometric_distribution() {
        for p in [0.1, 0.5, 0.9] {
            let undiscounted = geometric(p).value_iteration(1.0, 1e-13);
            assert!((undiscounted.values[0] + 1.0 / p).abs() < 1e-11);
            let gamma = 0.9;
            let discounted = geometric(p).value_iteration(gamma, 1e-12);
            assert!((discounted.values[0] + 1.0 / (1.0 - gamma * (1.0 - p))).abs() < 1e-11);
        }
    }

    #[test]
    fn an_endless_loop_is_worth_its_geometric_series() {
        let mdp = TabularMdp::new(&[vec![vec![outcome(0, 1.0, 2.0)]]], vec![false]).unwrap();
        let solved = mdp.value_iteration(0.9, 1e-9);
        assert!(solved.converged && (solved.values[0] - 20.0).abs() < 1e-9);
        assert_eq!(mdp.value_iteration(1.0, 1e-9).values, [f64::NEG_INFINITY]);
        assert_eq!(mdp.value_iteration(0.0, 1e-9).values, [2.0]);
    }

    #[test]
    fn greedy_actions_are_all_that_tie() {
        let to_end = |reward| vec![outcome(1, 1.0, reward)];
        let mdp = TabularMdp::new(
            &[vec![to_end(-1.0), to_end(-2.0), to_end(-1.0)], vec![]],
            vec![false, true],
        );
        let mdp = mdp.unwrap();
        let values = mdp.value_iteration(1.0, 1e-9).values;
        assert_eq!(
            mdp.greedy_actions(&values, 1.0, 0, 1e-9),
            [Action(0), Action(2)]
        );
        assert_eq!(mdp.greedy_actions(&values, 1.0, 1, 1e-9), []);
    }

    #[test]
    fn a_policy_that_never_ends_does_not_converge() {
        let stay_or_end = vec![vec![outcome(0, 1.0, -1.0)], vec![outcome(1, 1.0, -1.0)]];
        let mdp = TabularMdp::new(&[stay_or_end, vec![]], vec![false, true]).unwrap();
        assert!(
            !mdp.policy_evaluation(&[1.0, 0.0, 0.5, 0.5], 1.0, 1e-9)
                .converged
        );
        let fair = mdp.policy_evaluation(&[0.5, 0.5, 0.5, 0.5], 1.0, 1e-12);
        assert!(fair.converged && (fair.values[0] + 2.0).abs() < 1e-10);
    }
}
