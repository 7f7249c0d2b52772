//! The optimal gain of a communicating MDP, the most it pays a step on average in a life without end:
//!
//! ```text
//! g* = max_π lim_T (1/T) E[Σ_{t<T} r_t],      g* + h(s) = max_a Σ P (R + h(s′)) for some h
//! ```
//!
//! Where each state can be reached from each other one g* is the same in all of them (Puterman 1994, section 8.3). What a policy
//! falls short of it, Σ_t (g* − r_t), is its regret (Jaksch, Ortner & Auer 2010).
//!
//! Two ways to the number. In a deterministic world g* is the largest mean reward of a cycle, and with D_k(s) the most that k
//! steps from some first state to s earn (Karp 1978),
//!
//! ```text
//! g* = max_s min_{k<n} (D_n(s) − D_k(s)) / (n − k)
//! ```
//!
//! Elsewhere, and in worlds too large for that, the bounds of relative value iteration.

use super::TabularMdp;

/// Outcomes looked at before a number is not found.
const MAX_WORK: usize = 100_000_000;
/// Bounds this close, relative to the largest reward, are one number.
const CLOSED: f64 = 1e-10;
/// No way of so many steps.
const NO_WAY: f64 = f64::NEG_INFINITY;

/// Why there is no one gain, or none that was found. States are numbers of the MDP.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoGain {
    /// Episodes end in a state that can be reached.
    End(usize),
    /// No way leads from the first state to the second.
    NoWay(usize, usize),
    /// The world is too large, or too slow, for the work that is allowed: g* lies between the two.
    Unsettled(f64, f64),
}

impl TabularMdp {
    /// g* of what can be reached from `starts`, in which each state must be reachable from each other one. Good to 1e-10 of
    /// the largest reward. O(states × outcomes) in a deterministic world, O(outcomes) a sweep elsewhere; at most some
    /// 10⁸ outcomes are looked at.
    ///
    /// # Errors
    /// [`NoGain`].
    ///
    /// # Panics
    /// If there is no start, or one is no state.
    pub fn optimal_gain(&self, starts: &[usize]) -> Result<f64, NoGain> {
        let states = self.communicating(starts)?;
        let outcomes: usize = states
            .iter()
            .map(|&state| self.outcomes_of_state(state).len())
            .sum();
        let is_certain = |&state: &usize| {
            let mut outcomes = self.outcomes_of_state(state).iter();
            outcomes.all(|outcome| outcome.probability == 1.0)
        };
        if states.iter().all(is_certain) && states.len().saturating_mul(outcomes) <= MAX_WORK / 2 {
            return Ok(self.largest_cycle_mean(&states));
        }
        let all_actions = |&state: &usize| (state, self.actions().collect());
        let component = states.iter().map(all_actions).collect();
        let rewards = states
            .iter()
            .flat_map(|&state| self.outcomes_of_state(state))
            .map(|outcome| outcome.reward.abs());
        let largest = rewards.fold(0.0, f64::max);
        let is_closed = |lower: f64, upper: f64| upper - lower <= CLOSED * largest;
        let (lower, upper) = self.gain_bounds(&component, is_closed);
        match is_closed(lower, upper) {
            true => Ok(0.5 * (lower + upper)),
            false => Err(NoGain::Unsettled(lower, upper)),
        }
    }

    /// The states that can be reached from `starts`, if none is an end and each leads to each other one. Enough that the
    /// first start leads to all, and all to it. O(outcomes).
    pub(super) fn communicating(&self, starts: &[usize]) -> Result<Vec<usize>, NoGain> {
        let origin = starts[0];
        let reached = self.reachable_from(starts);
        let states: Vec<usize> = (0..self.num_states()).filter(|&s| reached[s]).collect();
        if let Some(&end) = states.iter().find(|&&state| self.terminal[state]) {
            return Err(NoGain::End(end));
        }
        let (there, back) = (self.distances_from(&[origin]), self.distances_to(&[origin]));
        for &state in &states {
            if there[state].is_none() {
                return Err(NoGain::NoWay(origin, state));
            }
            if back[state].is_none() {
                return Err(NoGain::NoWay(state, origin));
            }
        }
        Ok(states)
    }

    /// Karp's formula for a strongly connected deterministic world. D is computed twice instead of kept: n² numbers are
    /// more than time is.
    fn largest_cycle_mean(&self, states: &[usize]) -> f64 {
        let n = states.len();
        let mut start = vec![NO_WAY; self.num_states()];
        start[states[0]] = 0.0;
        let mut most = start.clone();
        for _ in 0..n {
            most = self.one_step_more(states, &most);
        }
        let mut mean = vec![f64::INFINITY; self.num_states()];
        let mut so_far = start;
        for steps in 0..n {
            for &state in states.iter().filter(|&&s| so_far[s] != NO_WAY) {
                let rest = (most[state] - so_far[state]) / (n - steps) as f64;
                mean[state] = rest.min(mean[state]);
            }
            so_far = self.one_step_more(states, &so_far);
        }
        states.iter().map(|&s| mean[s]).fold(NO_WAY, f64::max)
    }

    /// D_{k+1} from D_k.
    fn one_step_more(&self, states: &[usize], most: &[f64]) -> Vec<f64> {
        let mut next = vec![NO_WAY; most.len()];
        for &state in states.iter().filter(|&&s| most[s] != NO_WAY) {
            for outcome in self.outcomes_of_state(state) {
                let there = &mut next[outcome.next as usize];
                *there = there.max(most[state] + outcome.reward);
            }
        }
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::{Action, Outcome, boards};
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    fn sure(next: u32, reward: f64) -> Vec<Outcome> {
        vec![Outcome {
            next,
            probability: 1.0,
            reward,
        }]
    }

    /// The largest gain of any deterministic policy from state 0: g of the linear system g + h = r + P h with h = 0 in
    /// a state of each recurrent class, by a high power of the matrix with half of each step left out.
    fn by_all_policies(mdp: &TabularMdp) -> f64 {
        let (n, choices) = (mdp.num_states(), mdp.num_actions());
        let mut best = f64::NEG_INFINITY;
        for code in 0..choices.pow(n as u32) {
            let mut p = DMatrix::<f64>::zeros(n, n);
            let mut r = DVector::<f64>::zeros(n);
            for state in 0..n {
                let action = Action((code / choices.pow(state as u32) % choices) as u16);
                for o in mdp.outcomes(state, action) {
                    p[(state, o.next as usize)] += o.probability;
                    r[state] += o.probability * o.reward;
                }
            }
            let mut power = (DMatrix::identity(n, n) + p) * 0.5;
            for _ in 0..16 {
                power = &power * &power;
            }
            best = best.max((power * r).max());
        }
        best
    }

    #[test]
    fn the_river_pays_what_the_best_of_its_64_policies_does() {
        let river = boards::river_swim(6).unwrap();
        let found = river.mdp().optimal_gain(&[0]).unwrap();
        let brute = by_all_policies(river.mdp());
        assert!((found - brute).abs() < 1e-5, "{found}, not {brute}");
        // Going right for ever is a chain of birth and death: μ_{i+1} / μ_i = up_i / down_{i+1}.
        let (up, down) = ([0.6, 0.35, 0.35, 0.35, 0.35], [0.05, 0.05, 0.05, 0.05, 0.4]);
        let mut weights = vec![1.0];
        for (up, down) in up.iter().zip(down) {
            weights.push(weights.last().unwrap() * up / down);
        }
        let share = weights[5] / weights.iter().sum::<f64>();
        assert!(
            (found - 0.6 * 10_000.0 * share).abs() < 1e-5,
            "{found}, {share}"
        );
    }

    #[test]
    fn a_ring_pays_its_mean_whatever_its_sign() {
        // Ten states in a ring; the other action stays, at a cost.
        let ring = |on: f64, stay: f64| {
            let state = |s: u32| vec![sure((s + 1) % 10, on - f64::from(s)), sure(s, stay)];
            TabularMdp::new(&(0..10).map(state).collect::<Vec<_>>(), vec![false; 10]).unwrap()
        };
        assert_eq!(ring(1.0, -9.0).optimal_gain(&[3]), Ok(-3.5));
        assert_eq!(ring(1.0, -2.0).optimal_gain(&[0]), Ok(-2.0));
        assert_eq!(ring(4.5, -2.0).optimal_gain(&[0, 7]), Ok(0.0));
        assert_eq!(ring(9.0, 4.0).optimal_gain(&[0]), Ok(4.5));
    }

    #[test]
    fn ends_and_one_way_streets_are_named() {
        let to_end = TabularMdp::new(&[vec![sure(1, 0.0)], vec![]], vec![false, true]).unwrap();
        assert_eq!(to_end.optimal_gain(&[0]), Err(NoGain::End(1)));
        let trap = [vec![sure(1, 0.0)], vec![sure(1, 1.0)], vec![sure(0, 9.0)]];
        let trap = TabularMdp::new(&trap, vec![false; 3]).unwrap();
        assert_eq!(trap.optimal_gain(&[0]), Err(NoGain::NoWay(1, 0)));
        assert_eq!(trap.optimal_gain(&[1, 2]), Err(NoGain::NoWay(1, 0)));
        // What cannot be reached does not matter.
        assert_eq!(trap.optimal_gain(&[1]), Ok(1.0));
    }

    #[test]
    fn a_river_too_long_for_the_work_says_between_what() {
        let river = boards::river_swim(200_000).unwrap();
        let found = river.mdp().optimal_gain(&[0]);
        assert!(
            matches!(found, Err(NoGain::Unsettled(low, high)) if low < high && high <= 10_000.0),
            "{found:?}"
        );
    }

    /// Four states, two actions; the first action goes round, so that all communicate, the second anywhere.
    fn small_world(certain: bool) -> impl Strategy<Value = TabularMdp> {
        let anywhere = (0..4_u32, 0..4_u32, [-5..6_i32, -5..6_i32, -5..6_i32]);
        prop::collection::vec(anywhere, 4).prop_map(move |states| {
            let state = |s: usize| {
                let (a, b, [x, y, on]) = states[s];
                let half = |next, reward| Outcome {
                    next,
                    probability: 0.5,
                    reward: f64::from(reward),
                };
                let freely = match certain {
                    true => sure(a, f64::from(x)),
                    false => vec![half(a, x), half(b, y)],
                };
                vec![sure((s as u32 + 1) % 4, f64::from(on)), freely]
            };
            let states: Vec<_> = (0..4).map(state).collect();
            TabularMdp::new(&states, vec![false; 4]).unwrap()
        })
    }

    proptest! {
        #[test]
        fn as_trying_all_policies(mdp in prop_oneof![small_world(true), small_world(false)]) {
            let found = mdp.optimal_gain(&[0]).unwrap();
            let brute = by_all_policies(&mdp);
            prop_assert!((found - brute).abs() < 1e-7, "{} {}", found, brute);
        }
    }
}
