//! Lessons of a step: the graph, the potential of new states, and the goals.

use super::WorldModel;
use crate::engine::error::PipelineError;
use crate::engine::goal_statistics::LostEnd;
use crate::engine::returns::{ReturnStatistics, Trajectory};
use crate::env::{Action, Step, StepStatus};
use crate::exploration::RecordedStep;
use crate::graph::StateId;
use std::hash::Hash;

/// A step as the graph has taken it in.
#[derive(Clone, Copy, Debug)]
pub(in crate::engine) struct Recorded {
    pub step: RecordedStep,
    pub new_state: bool,
}

impl<S: Clone + Eq + Hash> WorldModel<S> {
    /// The number of a state, which joins the graph if it is new.
    pub(in crate::engine) fn intern(&mut self, state: &S) -> StateId {
        self.graph.intern(state).0
    }

    /// Takes a step from `from` into the graph; a new state inherits its potential.
    ///
    /// # Errors
    /// If the reward is not finite or the action does not exist; nothing has changed then.
    #[inline]
    pub(in crate::engine) fn record(
        &mut self,
        from: StateId,
        action: Action,
        step: &Step<S>,
    ) -> Result<Recorded, PipelineError> {
        self.check(action, step.reward)?;
        self.step += 1;
        let terminated = step.status == StepStatus::Terminated;
        let (to, new_state) = self.graph.intern_next(from, action, &step.state);
        let untried = self.graph.transitions().tries(from, action) == 0;
        let known = self.graph.transitions().num_transitions();
        let new_edge = self.graph.record(from, action, step.reward, to, terminated);
        self.pairs_tried += u64::from(untried);
        if new_state {
            self.table.inherit(to, from);
        }
        Ok(Recorded {
            step: RecordedStep {
                from,
                action,
                to,
                terminated,
                new_way: untried || new_edge || new_state,
                first_time: self.graph.transitions().num_transitions() > known,
            },
            new_state,
        })
    }

    fn check(&self, action: Action, reward: f64) -> Result<(), PipelineError> {
        let (step, num_actions) = (self.step, self.graph.transitions().num_actions());
        if action.index() >= num_actions {
            return Err(PipelineError::Action {
                step,
                action: action.0,
                num_actions,
            });
        }
        match reward.is_finite() {
            true => Ok(()),
            false => Err(PipelineError::Reward { step, reward }),
        }
    }

    /// The episode goes on in `state`: if that was a goal it is none any more. Whether it was one.
    #[inline]
    pub(in crate::engine) fn forget_goal(&mut self, state: StateId, reward: f64) -> bool {
        let Some(lost) = self.goals.forget(state) else {
            return false;
        };
        self.schedule.invalidate_fit();
        self.graph.forget_end(state, reward);
        let was_goal = lost == LostEnd::Goal;
        if was_goal && let Some(returns) = &mut self.returns {
            *returns = ReturnStatistics::default(); // of a task that is over
        }
        if was_goal && let Some(exploration) = &mut self.exploration {
            exploration.forget_destination(self.graph.transitions(), state);
        }
        let is_last = match was_goal {
            true => self.goals.is_empty(),
            false => !self.is_worth_fitting(), // no fit will follow that lifts φ there
        };
        if is_last {
            self.table.flatten();
            self.unit = 1.0;
        }
        was_goal
    }

    /// Takes in the returns of an episode whose last step this was, if anybody learns from them.
    #[inline]
    pub(in crate::engine) fn count_returns(
        &mut self,
        trajectory: &mut Trajectory,
        from: StateId,
        step: &Step<S>,
    ) {
        if let Some(returns) = &mut self.returns {
            trajectory.push(from, step.reward);
            if step.status.is_last() {
                returns.take(trajectory, self.gamma, step.status);
            }
        }
    }

    /// Takes note of the time in the episode at which a state was met.
    #[inline]
    pub(in crate::engine) fn meet(&mut self, state: StateId, time: u32) {
        if self.layers.meet(state, time) {
            self.reconsider_ends();
        }
    }

    /// Which ends are goals depends on whether time can be saved, of which something else is believed now.
    #[cold]
    fn reconsider_ends(&mut self) {
        let time_counts = !self.layers.believed();
        if self.goals.reconsider(time_counts) {
            self.schedule.invalidate_fit();
        }
        if let Some(exploration) = &mut self.exploration {
            exploration.set_time_counts(time_counts);
            if self.goals.is_empty() {
                exploration.set_destinations(self.graph.transitions(), &[]);
            }
        }
    }

    /// Counts what a step of an episode that began in `start` says of goals and costs.
    #[inline]
    pub(in crate::engine) fn count(&mut self, start: StateId, next: StateId, step: &Step<S>) {
        match step.status {
            StepStatus::Running => self.goals.count_step(step.reward),
            StepStatus::Truncated => self.goals.label_trajectory(start, next, false),
            StepStatus::Terminated => {
                if self
                    .goals
                    .count_ending(next, step.reward, !self.layers.believed())
                {
                    self.schedule.invalidate_fit();
                }
                if self.layers.end_episode() {
                    self.reconsider_ends();
                }
                let at_goal = self.goals.contains(next);
                self.goals.label_trajectory(start, next, at_goal);
            }
        }
        if self.goals.something_pays()
            && let Some(exploration) = &mut self.exploration
        {
            exploration.set_something_pays();
        }
    }
}
