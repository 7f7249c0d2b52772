//! The best plan for a number of steps, by value iteration (Puterman 1994, section 4.5).
//!
//! Q_k(s, a) = r(s, a) + u(s, a) B_k + γ Σ_s′ p(s′|s, a) V_{k−1}(s′),    V_k(s) = max_a Q_k(s, a),    V_0 = 0
//!
//! V_k(s) is what the best k steps from s are worth. With chance u something happens that the model knows nothing of, and
//! from that step on everything is worth B_k; with what u and all p leave to 1, the task ends.

use super::table::largest;

/// Of each (state, action), row by row: reward, chance of something unknown, and where else it leads.
#[derive(Clone, Debug)]
pub(crate) struct HorizonPlan {
    num_actions: usize,
    pairs: Vec<Pair>,
    /// States and chances of all pairs, one pair after the other.
    next: Vec<(u32, f64)>,
}

#[derive(Clone, Copy, Debug)]
struct Pair {
    reward: f64,
    unknown: f64,
    /// Where its part of `next` ends.
    end: usize,
}

/// What is believed to come of an action, besides the states that it leads to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Believed {
    /// r.
    pub reward: f64,
    /// u.
    pub unknown: f64,
}

impl HorizonPlan {
    /// A model of no states yet.
    pub fn new(num_actions: usize) -> Self {
        HorizonPlan {
            num_actions,
            pairs: Vec::new(),
            next: Vec::new(),
        }
    }

    /// Appends the next (state, action); `believe` appends the states that it leads to, with their chances.
    pub fn push(&mut self, believe: impl FnOnce(&mut Vec<(u32, f64)>) -> Believed) {
        let Believed { reward, unknown } = believe(&mut self.next);
        self.pairs.push(Pair {
            reward,
            unknown,
            end: self.next.len(),
        });
    }

    /// Q_H row by row, H being `horizon` ≥ 1, where `best` gives B_k; with `clip` no Q_k exceeds B_k. It ends before H sweeps if
    /// one changes no value by more than `tolerance`, since the next ones would do no better. O(pairs and their next states)
    /// a sweep.
    ///
    /// # Panics
    /// If a pair leads to a state that is not in the model.
    pub fn solve(
        &self,
        gamma: f64,
        horizon: usize,
        tolerance: f64,
        clip: bool,
        best: impl Fn(usize) -> f64,
    ) -> Vec<f64> {
        let mut action_values = vec![0.0; self.pairs.len()];
        let mut values = vec![0.0; self.pairs.len() / self.num_actions];
        for steps in 1..=horizon {
            let bound = best(steps);
            self.back_up(gamma, bound, &values, &mut action_values);
            if clip {
                action_values.iter_mut().for_each(|q| *q = q.min(bound));
            }
            let mut change = 0f64;
            let rows = action_values.chunks_exact(self.num_actions);
            for (value, row) in values.iter_mut().zip(rows) {
                let best = largest(row);
                change = change.max((best - std::mem::replace(value, best)).abs());
            }
            if change <= tolerance {
                break;
            }
        }
        action_values
    }

    /// From V_{k−1} and B_k to Q_k.
    fn back_up(&self, gamma: f64, bound: f64, values: &[f64], action_values: &mut [f64]) {
        let mut begin = 0;
        for (pair, action_value) in self.pairs.iter().zip(action_values) {
            let next = &self.next[begin..pair.end];
            let ahead: f64 = next.iter().map(|&(to, p)| p * values[to as usize]).sum();
            *action_value = pair.reward + pair.unknown * bound + gamma * ahead;
            begin = pair.end;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::{Action, TabularMdp};
    use proptest::prelude::*;

    fn known(reward: f64) -> Believed {
        Believed {
            reward,
            unknown: 0.0,
        }
    }

    /// Stay for 1, or leave for 3 and the end: of k steps, k + 2 are to be had.
    #[test]
    fn values_count_the_steps_that_are_left() {
        let mut plan = HorizonPlan::new(2);
        plan.push(|next| {
            next.push((0, 1.0));
            known(1.0)
        });
        plan.push(|_| known(3.0));
        let solved = |horizon| plan.solve(1.0, horizon, 0.0, false, |_| 0.0);
        assert_eq!(solved(1), [1.0, 3.0]);
        assert_eq!(solved(10), [11.0 + 1.0 - 1.0 + 1.0, 3.0]);
        assert_eq!(plan.solve(1.0, 10, 0.0, true, |k| k as f64), [10.0, 3.0]);
    }

    /// What is unknown is worth B of the steps that are left when it is reached: 2 + .5 · 8 of nine.
    #[test]
    fn the_unknown_is_worth_its_bound() {
        let mut plan = HorizonPlan::new(1);
        plan.push(|next| {
            next.push((1, 1.0));
            known(2.0)
        });
        plan.push(|_| Believed {
            reward: 0.0,
            unknown: 0.5,
        });
        assert_eq!(
            plan.solve(1.0, 9, 0.0, false, |k| k as f64),
            [2.0 + 0.5 * 8.0, 0.5 * 9.0]
        );
    }

    /// Terminal states have no values of their own: what leads there ends.
    fn of(mdp: &TabularMdp) -> HorizonPlan {
        let mut plan = HorizonPlan::new(mdp.num_actions());
        for state in 0..mdp.num_states() {
            for action in mdp.actions() {
                plan.push(|next| {
                    let outcomes = mdp.outcomes(state, action);
                    let goes_on = outcomes
                        .iter()
                        .filter(|o| !mdp.is_terminal(o.next as usize));
                    next.extend(goes_on.map(|o| (o.next, o.probability)));
                    known(outcomes.iter().map(|o| o.probability * o.reward).sum())
                });
            }
        }
        plan
    }

    proptest! {
        /// Two formulations: a sweep over all states at once from V = 0, and Gauss–Seidel sweeps.
        #[test]
        fn a_long_horizon_is_value_iteration(
            rows in prop::collection::vec(
                ((0..5u32, -3.0..3.0f64), (0..5u32, -3.0..3.0f64), 0.05..0.95f64), 10),
            gamma in 0.3..0.95f64,
        ) {
            let mdp = TabularMdp::from_fn(2, vec![false, false, false, false, true], |s, a, out| {
                let ((one, r), (other, q), p) = rows[2 * s + a.index()];
                let outcome = |next, reward, probability| crate::env::Outcome { next, reward, probability };
                out.extend([outcome(one, r, p), outcome(other, q, 1.0 - p)]);
            }).unwrap();
            let right = mdp.value_iteration(gamma, 1e-12).values;
            let found = of(&mdp).solve(gamma, 2000, 1e-12, false, |_| 0.0);
            for state in 0..4 {
                for action in 0..2 {
                    let right = mdp.action_value(&right, gamma, state, Action(action));
                    let found = found[2 * state + usize::from(action)];
                    prop_assert!((found - right).abs() < 1e-9, "{found} {right}");
                }
            }
        }
    }
}
