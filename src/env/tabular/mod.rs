//! Finite MDPs given by P(s′ | s, a) and R(s, a, s′), and what can be computed from them exactly.
//!
//! | question | answered by |
//! |---|---|
//! | v*(s) = max_a Σ P (R + γ v*(s′)), with γ ≤ 1 | [`TabularMdp::value_iteration`] |
//! | v^π of a given policy | [`TabularMdp::policy_evaluation`] |
//! | which actions are greedy | [`TabularMdp::greedy_actions`] |
//! | how many transitions to the end, from everywhere | [`TabularMdp::distances_to_terminal`] |
//! | the best episode under a step limit | [`TabularMdp::optimum`] |
//! | the episode of a given policy under a step limit | [`TabularMdp::policy_return`] |
//! | does a loop pay for ever | [`TabularMdp::best_gain`] |
//! | the best mean reward of a life without end | [`TabularMdp::optimal_gain`] |
//! | how hard is it to learn | [`TabularMdp::diameter`], [`TabularMdp::sum_of_inverse_gaps`] |
//! | is the task one that should be solved by reaching a goal | [`TabularMdp::cautions`] |
//!
//! These are the yardsticks of experiments and the oracles of tests. A [`TabularEnvironment`] lets an agent act in one.

mod average_reward;
mod cautions;
mod environment;
mod gain;
mod hardness;
mod optimum;
mod policy_return;
mod reachability;
mod reward_noise;
mod value_iteration;

pub use average_reward::NoGain;
pub use cautions::Caution;
pub use environment::{MdpState, TabularEnvironment};
pub use hardness::Unmeasured;
pub use optimum::Optimum;
pub use value_iteration::ValueFunction;

use super::{Action, EnvError};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// How far from 1 the probabilities of one action may sum.
pub(crate) const PROBABILITY_TOLERANCE: f64 = 1e-9;

/// One thing that may come of an action.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The number of the next state.
    pub next: u32,
    /// P(s′ | s, a), in (0, 1].
    pub probability: f64,
    /// R(s, a, s′).
    pub reward: f64,
}

/// A finite MDP.
///
/// The outcomes of all (state, action) pairs lie one after the other, as the rows of a CSR matrix: pair s · |A| + a owns
/// `outcomes[offsets[pair]..offsets[pair + 1]]`. 24 bytes an outcome, 8 a pair.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TabularMdp {
    num_actions: usize,
    terminal: Vec<bool>,
    /// One entry per pair and one more, not decreasing; the last is `outcomes.len()`.
    offsets: Vec<usize>,
    /// Probabilities are positive and sum to 1 within each pair of a non-terminal state; terminal states have none.
    outcomes: Vec<Outcome>,
}

impl TabularMdp {
    /// An MDP from nested lists: `transitions[s][a]` are the outcomes of action a in state s. Those of terminal states
    /// are ignored and may be missing.
    ///
    /// # Errors
    /// As [`from_fn`](Self::from_fn).
    ///
    /// # Panics
    /// If the lists have different lengths: `transitions` and `terminal`, or the actions of two non-terminal states.
    ///
    /// ```
    /// use eigentrail::env::{Outcome, TabularMdp};
    /// // A corridor of three states: action 0 goes on, action 1 stays.
    /// let to = |next| vec![Outcome { next, probability: 1.0, reward: -1.0 }];
    /// let mdp = TabularMdp::new(&[vec![to(1), to(0)], vec![to(2), to(1)], vec![]], vec![false, false, true])?;
    /// assert_eq!(mdp.value_iteration(1.0, 1e-9).values, [-2.0, -1.0, 0.0]);
    /// # Ok::<(), eigentrail::env::EnvError>(())
    /// ```
    pub fn new(transitions: &[Vec<Vec<Outcome>>], terminal: Vec<bool>) -> Result<Self, EnvError> {
        assert_eq!(
            transitions.len(),
            terminal.len(),
            "one list of actions and one flag per state"
        );
        let num_actions = transitions.iter().map(Vec::len).max().unwrap_or(0);
        for (actions, _) in transitions
            .iter()
            .zip(&terminal)
            .filter(|&(_, &terminal)| !terminal)
        {
            assert_eq!(
                actions.len(),
                num_actions,
                "as many actions in every non-terminal state"
            );
        }
        Self::from_fn(num_actions, terminal, |state, action, outcomes| {
            outcomes.extend_from_slice(&transitions[state][action.index()]);
        })
    }

    /// An MDP from a function that pushes the outcomes of (state, action) into an empty list. It is called once for each
    /// action of each non-terminal state, in order. Outcomes of probability 0 are left out. O(outcomes).
    ///
    /// # Errors
    /// [`EnvError::EmptyMdp`], [`EnvError::MdpTooLarge`], [`EnvError::NoSuchState`], [`EnvError::Probabilities`],
    /// [`EnvError::RewardNotFinite`].
    pub fn from_fn(
        num_actions: usize,
        terminal: Vec<bool>,
        mut fill: impl FnMut(usize, Action, &mut Vec<Outcome>),
    ) -> Result<Self, EnvError> {
        let states = terminal.len();
        require_size(states, num_actions)?;
        let mut offsets = Vec::with_capacity(states * num_actions + 1);
        let mut outcomes = Vec::new();
        let mut row = Vec::new();
        offsets.push(0);
        for (state, &ends_here) in terminal.iter().enumerate() {
            for action in 0..num_actions {
                if !ends_here {
                    row.clear();
                    fill(state, Action(action as u16), &mut row);
                    require_distribution(state, action, &row, states)?;
                    outcomes.extend(row.iter().filter(|outcome| outcome.probability > 0.0));
                }
                offsets.push(outcomes.len());
            }
        }
        Ok(TabularMdp {
            num_actions,
            terminal,
            offsets,
            outcomes,
        })
    }

    /// Number of states.
    pub fn num_states(&self) -> usize {
        self.terminal.len()
    }

    /// Number of actions, the same in every state.
    pub fn num_actions(&self) -> usize {
        self.num_actions
    }

    /// Whether episodes end in `state`.
    ///
    /// # Panics
    /// If there is no such state.
    pub fn is_terminal(&self, state: usize) -> bool {
        self.terminal[state]
    }

    /// What may come of `action` in `state`; empty if `state` is terminal.
    ///
    /// # Panics
    /// If there is no such state or action.
    pub fn outcomes(&self, state: usize, action: Action) -> &[Outcome] {
        assert!(
            action.index() < self.num_actions,
            "action {} of {}",
            action.0,
            self.num_actions
        );
        let pair = state * self.num_actions + action.index();
        &self.outcomes[self.offsets[pair]..self.offsets[pair + 1]]
    }

    /// The smallest and the largest reward of any outcome; both 0 if every state is terminal. O(outcomes).
    pub fn reward_range(&self) -> (f64, f64) {
        let rewards = self.outcomes.iter().map(|outcome| outcome.reward);
        let widen = |(low, high): (f64, f64), reward: f64| (low.min(reward), high.max(reward));
        let pairs = rewards.map(|reward| (reward, reward));
        pairs
            .reduce(|range, (reward, _)| widen(range, reward))
            .unwrap_or((0.0, 0.0))
    }

    /// Every action number.
    pub fn actions(&self) -> impl Iterator<Item = Action> + use<> {
        (0..self.num_actions as u16).map(Action)
    }

    /// The outcomes of all actions of `state`, one after the other.
    fn outcomes_of_state(&self, state: usize) -> &[Outcome] {
        let pairs: Range<usize> = state * self.num_actions..(state + 1) * self.num_actions;
        &self.outcomes[self.offsets[pairs.start]..self.offsets[pairs.end]]
    }
}

fn require_size(states: usize, actions: usize) -> Result<(), EnvError> {
    if states == 0 || actions == 0 {
        return Err(EnvError::EmptyMdp { states, actions });
    }
    let pairs = states
        .checked_mul(actions)
        .filter(|&pairs| pairs < u32::MAX as usize);
    if actions > usize::from(u16::MAX) || pairs.is_none() {
        return Err(EnvError::MdpTooLarge { states, actions });
    }
    Ok(())
}

fn require_distribution(
    state: usize,
    action: usize,
    row: &[Outcome],
    states: usize,
) -> Result<(), EnvError> {
    if let Some(outcome) = row.iter().find(|outcome| outcome.next as usize >= states) {
        return Err(EnvError::NoSuchState {
            state,
            action,
            next: outcome.next as usize,
            states,
        });
    }
    if let Some(outcome) = row.iter().find(|outcome| !outcome.reward.is_finite()) {
        let place = format!("state {state}, action {action}");
        return Err(EnvError::RewardNotFinite {
            place,
            reward: outcome.reward,
        });
    }
    let sum: f64 = row.iter().map(|outcome| outcome.probability).sum();
    let in_range = row
        .iter()
        .all(|outcome| (0.0..=1.0).contains(&outcome.probability));
    if in_range && (sum - 1.0).abs() <= PROBABILITY_TOLERANCE {
        Ok(())
    } else {
        Err(EnvError::Probabilities { state, action, sum })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(next: u32, probability: f64, reward: f64) -> Outcome {
        Outcome {
            next,
            probability,
            reward,
        }
    }

    fn with_row(row: Vec<Outcome>) -> Result<TabularMdp, EnvError> {
        TabularMdp::new(&[vec![row], vec![]], vec![false, true])
    }

    #[test]
    fn malformed_rows_are_refused_by_name() {
        let short = with_row(vec![outcome(1, 0.5, 0.0)]);
        assert_eq!(
            short,
            Err(EnvError::Probabilities {
                state: 0,
                action: 0,
                sum: 0.5
            })
        );
        let negative = with_row(vec![outcome(1, 1.5, 0.0), outcome(0, -0.5, 0.0)]);
        assert!(matches!(negative, Err(EnvError::Probabilities { .. })));
        let nan = with_row(vec![outcome(1, f64::NAN, 0.0)]);
        assert!(matches!(nan, Err(EnvError::Probabilities { .. })));
        let nowhere = with_row(vec![outcome(2, 1.0, 0.0)]);
        assert_eq!(
            nowhere,
            Err(EnvError::NoSuchState {
                state: 0,
                action: 0,
                next: 2,
                states: 2
            })
        );
        let reward = with_row(vec![outcome(1, 1.0, f64::NAN)]);
        assert!(matches!(reward, Err(EnvError::RewardNotFinite { .. })));
        assert_eq!(
            TabularMdp::new(&[], vec![]),
            Err(EnvError::EmptyMdp {
                states: 0,
                actions: 0
            })
        );
    }

    #[test]
    fn impossible_outcomes_and_those_of_terminal_states_are_left_out() {
        let row = vec![outcome(0, 0.0, 9.0), outcome(1, 1.0, -1.0)];
        let mdp = TabularMdp::new(&[vec![row.clone()], vec![row]], vec![false, true]).unwrap();
        assert_eq!(mdp.outcomes(0, Action(0)), [outcome(1, 1.0, -1.0)]);
        assert_eq!(mdp.outcomes(1, Action(0)), []);
    }
}
