//! The clock of an episode: begun by a reset, ended by the task or by the step limit.

use super::StepStatus;
use serde::{Deserialize, Serialize};

/// Counts the steps of an episode and says how it stands after each.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct EpisodeClock {
    max_steps: usize,
    elapsed: usize,
    running: bool,
}

impl EpisodeClock {
    /// No episode yet; each will be truncated after `max_steps`.
    pub fn new(max_steps: usize) -> Self {
        Self {
            max_steps,
            elapsed: 0,
            running: false,
        }
    }

    /// After how many steps an episode is truncated.
    pub fn max_steps(&self) -> usize {
        self.max_steps
    }

    /// An episode begins.
    #[inline]
    pub fn begin(&mut self) {
        self.elapsed = 0;
        self.running = true;
    }

    /// The episode under way, if any, is given up.
    pub fn abandon(&mut self) {
        self.running = false;
    }

    /// Before a step.
    ///
    /// # Panics
    /// If no episode is under way.
    #[inline]
    pub fn assert_running(&self) {
        assert!(self.running, "step without an episode: call reset first");
    }

    /// After a step: how the episode stands. Termination wins over a limit reached by the same step.
    #[inline]
    pub fn tick(&mut self, terminated: bool) -> StepStatus {
        self.elapsed += 1;
        let status = if terminated {
            StepStatus::Terminated
        } else if self.elapsed >= self.max_steps {
            StepStatus::Truncated
        } else {
            StepStatus::Running
        };
        self.running = status == StepStatus::Running;
        status
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_truncates_unless_the_same_step_terminates() {
        let mut clock = EpisodeClock::new(2);
        for (last, expected) in [
            (false, StepStatus::Truncated),
            (true, StepStatus::Terminated),
        ] {
            clock.begin();
            clock.assert_running();
            assert_eq!(clock.tick(false), StepStatus::Running);
            assert_eq!(clock.tick(last), expected);
        }
        clock.begin();
        assert_eq!(clock.tick(true), StepStatus::Terminated);
    }

    #[test]
    #[should_panic(expected = "call reset first")]
    fn an_abandoned_episode_has_no_steps() {
        let mut clock = EpisodeClock::new(2);
        clock.begin();
        clock.abandon();
        clock.assert_running();
    }
}
