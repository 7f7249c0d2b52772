//! Returns that the agent has had, by state: the labels of learnt potentials.
//!
//! ```text
//! G(s) = Σ_k γ^k r_{t+k},   t: the last visit of s in an episode that terminated
//! ```
//!
//! Detours that led back to s are not counted: they tell how the agent searched, not what s is worth. Of an episode the last [`MEMORY`] steps
//! count, of the episodes that came through s about the last [`EPISODES`].

use crate::env::StepStatus;
use crate::graph::StateId;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Steps of an episode that are remembered.
const MEMORY: usize = 4096;

/// Returns that a mean reaches back over.
const EPISODES: f64 = 8.0;

/// The last steps of the episode under way: states left, rewards received.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Trajectory {
    steps: VecDeque<(StateId, f64)>,
}

impl Trajectory {
    /// Begins an episode.
    pub fn begin(&mut self) {
        self.steps.clear();
    }

    /// Adds a step. Amortised O(1).
    pub fn push(&mut self, state: StateId, reward: f64) {
        if self.steps.len() == MEMORY {
            self.steps.pop_front();
        }
        self.steps.push_back((state, reward));
    }
}

/// What is known of one state.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct MeanReturn {
    mean: f64,
    count: u32,
    /// The last episode, counted from 1, that it was updated in.
    episode: u32,
}

/// Mean returns by state.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ReturnStatistics {
    states: Vec<MeanReturn>,
    episodes: u32,
}

impl ReturnStatistics {
    /// Takes in an episode that ended as `status` says; one that was cut off tells nothing of how it would have ended. O(its steps).
    pub fn take(&mut self, trajectory: &Trajectory, gamma: f64, status: StepStatus) {
        if status != StepStatus::Terminated {
            return;
        }
        self.episodes = self.episodes.wrapping_add(1);
        let mut to_go = 0.0;
        for &(state, reward) in trajectory.steps.iter().rev() {
            to_go = reward + gamma * to_go;
            if self.states.len() <= state.index() {
                self.states.resize(state.index() + 1, MeanReturn::default());
            }
            let known = &mut self.states[state.index()];
            if known.episode != self.episodes {
                known.episode = self.episodes;
                known.count = known.count.saturating_add(1);
                known.mean += (to_go - known.mean) / f64::from(known.count).min(EPISODES);
            }
        }
    }

    /// Mean return of every state that has one, ascending by state. O(n).
    pub fn means(&self) -> Vec<(StateId, f64)> {
        let states = self.states.iter().zip(0..);
        let known = states.filter(|(state, _)| state.count > 0);
        known.map(|(state, i)| (StateId(i), state.mean)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn episode(steps: &[(u32, f64)]) -> Trajectory {
        let mut trajectory = Trajectory::default();
        let steps = steps.iter();
        steps.for_each(|&(state, reward)| trajectory.push(StateId(state), reward));
        trajectory
    }

    #[test]
    fn detours_do_not_count_and_later_episodes_do() {
        let mut returns = ReturnStatistics::default();
        let wandering = episode(&[(0, -1.0), (3, -1.0), (0, -2.0), (1, 8.0)]);
        returns.take(&wandering, 0.5, StepStatus::Terminated);
        let expected = [(0, -2.0 + 4.0), (1, 8.0), (3, -1.0 + 0.5 * 2.0)];
        let means = |returns: &ReturnStatistics| -> Vec<(u32, f64)> {
            returns.means().into_iter().map(|(s, g)| (s.0, g)).collect()
        };
        assert_eq!(means(&returns), expected);
        returns.take(&episode(&[(1, 0.0)]), 0.5, StepStatus::Truncated);
        assert_eq!(
            means(&returns),
            expected,
            "nobody knows how it would have ended"
        );
        returns.take(&episode(&[(1, 4.0)]), 0.5, StepStatus::Terminated);
        assert_eq!(means(&returns)[1], (1, 6.0));
        for _ in 0..200 {
            returns.take(&episode(&[(1, -1.0)]), 0.5, StepStatus::Terminated);
        }
        assert!(
            (means(&returns)[1].1 + 1.0).abs() < 1e-6,
            "long ago is forgotten"
        );
    }

    #[test]
    fn an_endless_episode_is_remembered_from_its_end() {
        let mut trajectory = Trajectory::default();
        for state in 0..MEMORY as u32 + 5 {
            trajectory.push(StateId(state), 1.0);
        }
        let mut returns = ReturnStatistics::default();
        returns.take(&trajectory, 1.0, StepStatus::Terminated);
        let means = returns.means();
        assert_eq!(means[0], (StateId(5), MEMORY as f64));
        assert_eq!(means.len(), MEMORY);
        trajectory.begin();
        returns.take(&trajectory, 1.0, StepStatus::Terminated);
        assert_eq!(returns.means(), means);
    }
}
