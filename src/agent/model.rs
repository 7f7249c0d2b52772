//! The empirical MDP: what was seen to follow from each (state, action), with counts.
//!
//! P̂(s′|s, a) = N(s, a, s′) / N(s, a) and r̂(s, a, s′) = mean of the rewards seen; the maximum-likelihood model of
//! Moore & Atkeson (1993) and Brafman & Tennenholtz (2002).
//!
//! Two things are not averaged, because they may change while the agent learns and only the latest is true: the
//! shaping F of a transition (its potential is re-fitted), and whether arriving in s′ ends the task (the goal may
//! move). The latter is taken to be a property of s′; when it changes, so has what arriving pays, and the rewards seen
//! on all ways into s′ give way to the latest one. Else a bonus that was paid a hundred times would keep the agent where
//! its goal was for thousands of steps.
//!
//! Every distinct (s, a, s′) is one entry of an arena and a member of two chains: the outcomes of (s, a), and the ways
//! into s′. So a growing model makes no allocation per pair, and is plain data.

use super::Experience;
use crate::env::{Action, StepStatus};
use crate::graph::StateId;
use serde::{Deserialize, Serialize};

/// Ends a chain.
const NONE: u32 = u32::MAX;

/// One distinct (s, a, s′).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Entry {
    from: u32,
    action: u16,
    to: u32,
    count: u32,
    reward_sum: f64,
    /// Σ (r − r̂)², 0 while all rewards were equal.
    deviation: f64,
    shaping: f64,
    next_outcome: u32,
    next_way_in: u32,
}

/// The outcomes of one (s, a): how often it was tried, and its first entry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Pair {
    tries: u32,
    first: u32,
}

/// One (state, action) that can lead to a given state, and how likely it is to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WayIn {
    pub state: StateId,
    pub action: Action,
    pub probability: f64,
    /// r̂ on this way.
    pub reward: f64,
}

/// One distinct state that was seen to follow from a (state, action).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// The state.
    pub to: StateId,
    /// N(s, a, s′).
    pub count: u32,
    /// r̂(s, a, s′).
    pub reward: f64,
    /// Whether arriving there ends the task.
    pub ends: bool,
}

/// Model of the world as known so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct EmpiricalModel {
    num_actions: usize,
    /// Weight of the shaping in the rewards that [`EmpiricalModel::action_value`] adds up.
    mix: f64,
    pairs: Vec<Pair>,
    /// By state: how many actions were never tried.
    untried: Vec<u32>,
    /// For each state the first entry that leads to it.
    first_way_in: Vec<u32>,
    terminal: Vec<bool>,
    entries: Vec<Entry>,
    noise: RewardNoise,
}

/// Rewards of transitions that did not always pay the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct RewardNoise {
    /// Σ (r − r̂)² over all of these, and of how many rewards, less one a transition.
    deviation: f64,
    rewards: u64,
}

impl RewardNoise {
    /// σ₀², 0 while every transition paid the same each time.
    fn variance(self) -> f64 {
        match self.rewards {
            0 => 0.0,
            rewards => (self.deviation / rewards as f64).max(0.0),
        }
    }

    /// Takes in one more reward of `entry`, before it is added to the others.
    fn count(&mut self, entry: &mut Entry, reward: f64) {
        let count = f64::from(entry.count);
        let surprise = reward - entry.reward_sum / count;
        if entry.count == 0 || surprise.abs() <= ROUNDING * reward.abs() {
            return;
        }
        self.rewards += match entry.deviation > 0.0 {
            true => 1,
            false => u64::from(entry.count), // those before count from now on, too
        };
        let more = surprise.powi(2) * count / (count + 1.0);
        entry.deviation += more;
        self.deviation += more;
    }

    /// `entry` has been given new rewards, all equal.
    fn forget(&mut self, entry: &mut Entry) {
        if entry.deviation > 0.0 {
            self.deviation -= std::mem::take(&mut entry.deviation);
            self.rewards = self.rewards.saturating_sub(u64::from(entry.count) - 1);
        }
    }
}

/// Relative differences of rewards that are none.
const ROUNDING: f64 = 1e-9;

impl EmpiricalModel {
    /// Nothing seen yet; rewards will be r + `mix` · F.
    ///
    /// # Panics
    /// If there are no actions.
    pub fn new(num_actions: usize, mix: f64) -> Self {
        assert!(num_actions > 0, "an agent needs at least one action");
        EmpiricalModel {
            num_actions,
            mix,
            pairs: Vec::new(),
            untried: Vec::new(),
            first_way_in: Vec::new(),
            terminal: Vec::new(),
            entries: Vec::new(),
            noise: RewardNoise::default(),
        }
    }

    /// Number of actions.
    pub fn num_actions(&self) -> usize {
        self.num_actions
    }

    /// Number of states it has rows for.
    pub fn num_states(&self) -> usize {
        self.terminal.len()
    }

    /// Makes room for `state`. Amortised O(actions).
    pub fn grow_to(&mut self, state: StateId) {
        let states = state.index() + 1;
        if states > self.num_states() {
            self.pairs.resize(
                states * self.num_actions,
                Pair {
                    tries: 0,
                    first: NONE,
                },
            );
            self.untried.resize(states, self.num_actions as u32);
            self.first_way_in.resize(states, NONE);
            self.terminal.resize(states, false);
        }
    }

    /// Counts one step, the first 2³² − 1 of each kind; true if s′ turned out to be terminal, or no longer so, against what was believed.
    /// O(outcomes of (s, a)).
    ///
    /// # Panics
    /// If the action is out of range.
    pub fn record(&mut self, experience: &Experience<'_>) -> bool {
        let (from, to) = (experience.state, experience.next.state);
        assert!(
            experience.action.index() < self.num_actions,
            "action out of range"
        );
        self.grow_to(StateId(from.0.max(to.0)));
        let terminal = experience.status == StepStatus::Terminated;
        let changed = std::mem::replace(&mut self.terminal[to.index()], terminal) != terminal;
        let mut noise = self.noise;
        let entry = self.entry(from, experience.action, to);
        if entry.count < u32::MAX {
            if !changed {
                noise.count(entry, experience.reward);
            }
            entry.count += 1;
            entry.reward_sum += experience.reward;
        }
        entry.shaping = experience.shaping;
        self.noise = noise;
        let place = self.place(from, experience.action);
        self.untried[from.index()] -= u32::from(self.pairs[place].tries == 0);
        self.pairs[place].tries = self.pairs[place].tries.saturating_add(1);
        if changed {
            self.forget_rewards(to, experience.reward);
        }
        changed
    }

    /// Every way into `state` is taken to pay what was paid last. O(ways into the state).
    fn forget_rewards(&mut self, state: StateId, latest: f64) {
        let mut way = self.first_way_in[state.index()];
        while let Some(entry) = self.entries.get_mut(way as usize) {
            entry.reward_sum = latest * f64::from(entry.count);
            self.noise.forget(entry);
            way = entry.next_way_in;
        }
    }

    /// The entry of (from, action, to), made if it is new.
    fn entry(&mut self, from: StateId, action: Action, to: StateId) -> &mut Entry {
        let place = self.place(from, action);
        let first = self.pairs[place].first;
        let known =
            chain(&self.entries, first, |e| e.next_outcome).find(|&i| self.entries[i].to == to.0);
        let index = known.unwrap_or_else(|| {
            let index = self.entries.len();
            let link = u32::try_from(index).expect("fewer than 2^32 distinct transitions");
            self.entries.push(Entry {
                from: from.0,
                action: action.0,
                to: to.0,
                count: 0,
                reward_sum: 0.0,
                deviation: 0.0,
                shaping: 0.0,
                next_outcome: std::mem::replace(&mut self.pairs[place].first, link),
                next_way_in: std::mem::replace(&mut self.first_way_in[to.index()], link),
            });
            index
        });
        &mut self.entries[index]
    }

    #[inline]
    fn place(&self, state: StateId, action: Action) -> usize {
        state.index() * self.num_actions + action.index()
    }

    /// N(s, a); 0 for states beyond the model.
    pub fn tries(&self, state: StateId, action: Action) -> u32 {
        self.pairs
            .get(self.place(state, action))
            .map_or(0, |pair| pair.tries)
    }

    /// The pairs of `state`, one per action.
    ///
    /// # Panics
    /// If the state is beyond the model.
    fn pairs_of(&self, state: StateId) -> &[Pair] {
        let place = state.index() * self.num_actions;
        &self.pairs[place..place + self.num_actions]
    }

    /// Whether some action of `state` was never tried.
    ///
    /// # Panics
    /// If the state is beyond the model.
    pub fn has_untried(&self, state: StateId) -> bool {
        self.untried[state.index()] > 0
    }

    /// Σ_a N(state, a). O(actions).
    pub fn tries_in(&self, state: StateId) -> u32 {
        let tries = self.pairs_of(state).iter().map(|pair| pair.tries);
        tries.fold(0, u32::saturating_add)
    }

    /// The action of `state` with the fewest tries, the first of equals, and its tries. O(actions).
    pub fn least_tried(&self, state: StateId) -> (Action, u32) {
        let tries = self.pairs_of(state).iter().map(|pair| pair.tries);
        let least = tries.enumerate().min_by_key(|&(_, tries)| tries);
        let (action, tries) = least.expect("there are actions");
        (Action(action as u16), tries)
    }

    /// Whether arriving in `state` ended the episode, the last time it was entered.
    pub fn is_terminal(&self, state: StateId) -> bool {
        self.terminal[state.index()]
    }

    /// Σ_s′ P̂(s′|s, a) (r̂ + mix·F + γ V(s′)), V being 0 at terminal states; `None` if the action was never tried.
    pub fn action_value(
        &self,
        state: StateId,
        action: Action,
        gamma: f64,
        value: impl Fn(StateId) -> f64,
    ) -> Option<f64> {
        let pair = self
            .pairs
            .get(self.place(state, action))
            .filter(|pair| pair.tries > 0)?;
        let total: f64 = chain(&self.entries, pair.first, |e| e.next_outcome)
            .map(|i| {
                let entry = &self.entries[i];
                let count = f64::from(entry.count);
                let to = StateId(entry.to);
                let ahead = if self.is_terminal(to) {
                    0.0
                } else {
                    gamma * value(to)
                };
                entry.reward_sum + count * (self.mix * entry.shaping + ahead)
            })
            .sum();
        Some(total / f64::from(pair.tries))
    }

    /// σ₀, the typical deviation of the rewards of a transition that does not always pay the same; 0 while there is none.
    pub fn reward_noise(&self) -> f64 {
        self.noise.variance().sqrt()
    }

    /// Standard error of r̂(state, action): √(Σ_s′ N(s, a, s′) σ²(s, a, s′)) / N(s, a). σ is that of the rewards seen, `typical` for a single one, 0 if all of several were equal.
    /// 0 if the action was never tried, or if `typical` is 0. O(outcomes).
    pub fn standard_error_of_reward(&self, state: StateId, action: Action, typical: f64) -> f64 {
        if typical == 0.0 {
            return 0.0; // as in most worlds
        }
        let pair = self.pairs.get(self.place(state, action));
        let Some(pair) = pair.filter(|pair| pair.tries > 0) else {
            return 0.0;
        };
        let typical = typical.powi(2);
        let of_outcome = |i: usize| {
            let entry = &self.entries[i];
            match (entry.count, entry.deviation > 0.0) {
                (1, _) => typical,
                (_, true) => entry.deviation + typical, // as of one more deviation that is typical
                (_, false) => 0.0,
            }
        };
        let outcomes = chain(&self.entries, pair.first, |e| e.next_outcome);
        let sum: f64 = outcomes.map(of_outcome).sum();
        sum.sqrt() / f64::from(pair.tries)
    }

    /// The states seen to follow from `action` in `state`, with their probabilities; none if it was never tried.
    pub fn ways_out(
        &self,
        state: StateId,
        action: Action,
    ) -> impl Iterator<Item = (StateId, f64)> + '_ {
        let pair = self.pairs.get(self.place(state, action));
        let first = pair.map_or(NONE, |pair| pair.first);
        let tries = f64::from(self.tries(state, action));
        chain(&self.entries, first, |e| e.next_outcome).map(move |i| {
            let entry = &self.entries[i];
            (StateId(entry.to), f64::from(entry.count) / tries)
        })
    }

    /// What was seen to follow from `action` in `state`, latest discovery first; nothing if it was never tried.
    pub fn outcomes(&self, state: StateId, action: Action) -> impl Iterator<Item = Outcome> + '_ {
        let pair = self.pairs.get(self.place(state, action));
        let first = pair.map_or(NONE, |pair| pair.first);
        chain(&self.entries, first, |e| e.next_outcome).map(|i| {
            let entry = &self.entries[i];
            let to = StateId(entry.to);
            Outcome {
                to,
                count: entry.count,
                reward: entry.reward_sum / f64::from(entry.count),
                ends: self.is_terminal(to),
            }
        })
    }

    /// The (state, action) pairs seen to lead to `state`, latest discovery first.
    pub fn ways_into(&self, state: StateId) -> impl Iterator<Item = WayIn> + '_ {
        chain(&self.entries, self.first_way_in[state.index()], |e| {
            e.next_way_in
        })
        .map(|i| {
            let entry = &self.entries[i];
            let (state, action) = (StateId(entry.from), Action(entry.action));
            let tries = self.pairs[self.place(state, action)].tries;
            WayIn {
                state,
                action,
                probability: f64::from(entry.count) / f64::from(tries),
                reward: entry.reward_sum / f64::from(entry.count),
            }
        })
    }
}

/// The places of a chain's entries, from `first` on.
fn chain(
    entries: &[Entry],
    first: u32,
    next: impl Fn(&Entry) -> u32,
) -> impl Iterator<Item = usize> {
    let mut at = first;
    std::iter::from_fn(move || {
        let index = (at != NONE).then_some(at as usize)?;
        at = next(&entries[index]);
        Some(index)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::agent::Situation;

    fn step(
        model: &mut EmpiricalModel,
        from: u32,
        action: u16,
        reward: f64,
        shaping: f64,
        to: u32,
        status: StepStatus,
    ) -> bool {
        model.record(&Experience {
            state: StateId(from),
            action: Action(action),
            reward,
            shaping,
            next: Situation {
                state: StateId(to),
                advice: &[0.0; 2],
            },
            status,
        })
    }

    #[test]
    fn action_value_is_the_expectation_over_what_was_seen() {
        use StepStatus::{Running, Terminated};
        let mut model = EmpiricalModel::new(2, 0.5);
        step(&mut model, 0, 1, -1.0, 10.0, 1, Running);
        step(&mut model, 0, 1, -3.0, 4.0, 1, Running);
        assert!(step(&mut model, 0, 1, 5.0, 0.0, 2, Terminated));
        // to 1 twice: mean reward −2, latest F 4; to 2 once: 5, and nothing after the end
        let value = model
            .action_value(StateId(0), Action(1), 0.9, |s| 10.0 * f64::from(s.0))
            .unwrap();
        let expected = (2.0 * (-2.0 + 0.5 * 4.0 + 0.9 * 10.0) + 5.0) / 3.0;
        assert!((value - expected).abs() < 1e-14);
        assert_eq!(
            model.action_value(StateId(0), Action(0), 0.9, |_| 0.0),
            None
        );
        assert_eq!(model.tries(StateId(0), Action(1)), 3);
        assert_eq!(model.tries(StateId(9), Action(0)), 0);
    }

    #[test]
    fn what_arriving_pays_is_learnt_anew_when_the_goal_leaves_or_comes() {
        use StepStatus::{Running, Terminated};
        let mut model = EmpiricalModel::new(2, 0.0);
        for _ in 0..100 {
            step(&mut model, 0, 0, 0.0, 0.0, 2, Terminated);
        }
        step(&mut model, 1, 0, 0.0, 0.0, 2, Terminated);
        step(&mut model, 1, 1, -7.0, 0.0, 0, Running);
        let value = |model: &EmpiricalModel, from: u32, action: u16| {
            model.action_value(StateId(from), Action(action), 1.0, |_| 0.0)
        };
        assert_eq!(value(&model, 0, 0), Some(0.0));
        assert!(step(&mut model, 1, 0, -1.0, 0.0, 2, Running));
        assert_eq!(value(&model, 0, 0), Some(-1.0), "by the other way in, too");
        assert_eq!(value(&model, 1, 0), Some(-1.0));
        assert_eq!(
            value(&model, 1, 1),
            Some(-7.0),
            "other states are as they were"
        );
        assert!(step(&mut model, 0, 0, 5.0, 0.0, 2, Terminated));
        assert_eq!(value(&model, 1, 0), Some(5.0));
    }

    #[test]
    fn ways_in_mirror_the_outcomes() {
        let mut model = EmpiricalModel::new(2, 1.0);
        step(&mut model, 0, 0, 0.0, 0.0, 3, StepStatus::Running);
        step(&mut model, 1, 1, 0.0, 0.0, 3, StepStatus::Running);
        step(&mut model, 1, 1, 0.0, 0.0, 2, StepStatus::Running);
        let ways: Vec<_> = model
            .ways_into(StateId(3))
            .map(|w| (w.state.0, w.action.0, w.probability))
            .collect();
        assert_eq!(ways, [(1, 1, 0.5), (0, 0, 1.0)]);
        let out: Vec<_> = model
            .ways_out(StateId(1), Action(1))
            .map(|(state, probability)| (state.0, probability))
            .collect();
        assert_eq!(out, [(2, 0.5), (3, 0.5)]);
        assert_eq!(model.ways_out(StateId(1), Action(0)).count(), 0);
        assert_eq!(model.ways_into(StateId(1)).count(), 0);
    }

    #[test]
    fn the_end_of_the_task_is_what_was_seen_last() {
        let mut model = EmpiricalModel::new(2, 1.0);
        assert!(!step(&mut model, 0, 0, 0.0, 0.0, 1, StepStatus::Running));
        assert!(step(&mut model, 0, 0, 0.0, 0.0, 1, StepStatus::Terminated));
        assert!(!step(&mut model, 0, 0, 0.0, 0.0, 1, StepStatus::Terminated));
        assert!(
            step(&mut model, 0, 0, 0.0, 0.0, 1, StepStatus::Truncated),
            "the goal has moved away"
        );
        assert!(!model.is_terminal(StateId(1)));
    }
}
