//! What a step teaches: the graph, the guide, and the goals.

use super::{Guide, ShapingPipeline};
use crate::env::{Action, Step, StepStatus};
use crate::graph::StateId;
use std::hash::Hash;

impl<S: Clone + Eq + Hash> ShapingPipeline<S> {
    pub(super) fn record(
        &mut self,
        action: Action,
        reward: f64,
        next: StateId,
        new_state: bool,
        terminated: bool,
    ) {
        let from = self.state;
        let untried = self.graph.transitions().tries(from, action) == 0;
        let new_edge = self.graph.record(from, action, reward, next, terminated);
        self.pairs_tried += u64::from(untried);
        if new_state {
            self.table.inherit(next, from);
        }
        if let Guide::Frontier(explorer) = &mut self.guide {
            let first_time = untried || new_edge || new_state;
            explorer.learn(
                self.graph.transitions(),
                from,
                action,
                next,
                terminated,
                first_time,
            );
        }
    }

    /// The episode goes on in `state`: if that was a goal it is none any more. Whether it was one.
    pub(super) fn forget_goal(&mut self, state: StateId) -> bool {
        if !self.book.forget(state) {
            return false;
        }
        self.schedule.invalidate_fit();
        if let Guide::Frontier(explorer) = &mut self.guide {
            explorer.forget_destination(self.graph.transitions(), state);
        }
        if self.book.is_empty() {
            self.table.flatten();
            self.unit = 1.0;
        }
        true
    }

    pub(super) fn keep_book(&mut self, next: StateId, step: &Step<S>) {
        match step.status {
            StepStatus::Running => self.book.count_step(step.reward),
            StepStatus::Truncated => self.book.label_trajectory(self.start, next, false),
            StepStatus::Terminated => {
                if self.book.count_ending(next, step.reward) {
                    self.schedule.invalidate_fit();
                }
                self.book.label_trajectory(self.start, next, true);
            }
        }
    }
}
