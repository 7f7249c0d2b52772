//! The schedule of refreshes and fits.
//!
//! A fit costs time in proportion to the states known, so unless much has changed it waits for as many steps as are a
//! given share of them: what fits cost by step then does not grow with the world. Where next to nothing has changed it waits longer, in proportion, for a
//! learner that knows its world goes on finding an action here and there that it had not tried.

use crate::parameter::{ParameterError, Section};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of the schedule.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ScheduleParams {
    /// The potential is fitted, and features that the agent uses are refreshed, when the graph has gained this share of
    /// nodes.
    pub growth: f64,
    /// Features that only the potential uses are refreshed when the graph has gained this share of nodes; until then
    /// new states take the mean of their neighbours' features.
    pub feature_growth: f64,
    /// It is also fitted at the end of an episode in which the graph has changed, or this many steps after the last fit,
    pub refit_every: u64,
    /// … the latter only if the graph has gained this share of edges,
    pub edge_growth: f64,
    /// … and both only after as many steps as this share of the states known; up to ten times as many where less than `edge_growth` is new.
    pub refit_share: f64,
}

impl Default for ScheduleParams {
    fn default() -> Self {
        Self {
            growth: 0.05,
            feature_growth: 0.25,
            refit_every: 50,
            edge_growth: 0.05,
            refit_share: 0.1,
        }
    }
}

impl ScheduleParams {
    /// Checks every rule.
    ///
    /// # Errors
    /// The first key that breaks its rule.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let section = Section("schedule");
        let shares = [
            ("growth", self.growth),
            ("feature_growth", self.feature_growth),
            ("edge_growth", self.edge_growth),
        ];
        for (key, value) in shares {
            let holds = value > 0.0 && value <= 1.0;
            section.number(key, value, holds, "above 0 and at most 1")?;
        }
        let share = self.refit_share;
        let holds = share >= 0.0 && share.is_finite();
        section.number("refit_share", share, holds, "0 or a positive number")?;
        section.count("refit_every", self.refit_every, 1..)
    }
}

/// On a graph that no longer grows there is a fit when steps are so many times those of the last one, for frequencies and returns have changed.
const STALE: u64 = 2;

/// A fit waits at most so many times as long because little has changed.
const LULL: f64 = 10.0;

/// Size of the graph at a moment of the run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Moment {
    /// Environment steps taken.
    pub step: u64,
    /// States discovered.
    pub nodes: usize,
    /// Undirected edges discovered.
    pub edges: usize,
    /// State–action pairs tried at least once.
    pub pairs_tried: u64,
}

/// Moments of the last refresh of the features and of the last fit.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct RefreshSchedule {
    params: ScheduleParams,
    features: Option<Moment>,
    fit: Option<Moment>,
}

impl RefreshSchedule {
    /// Nothing refreshed yet.
    pub fn new(params: ScheduleParams) -> Self {
        Self {
            params,
            features: None,
            fit: None,
        }
    }

    /// Whether the graph has outgrown the features of an agent that uses them.
    pub fn agent_features_due(&self, now: Moment) -> bool {
        have_outgrown(self.features, now, self.params.growth)
    }

    /// Whether the graph has outgrown the features that only the potential uses.
    pub fn potential_features_due(&self, now: Moment) -> bool {
        have_outgrown(self.features, now, self.params.feature_growth)
    }

    /// Whether the potential should be fitted, once there is something to fit it on.
    pub fn fit_due(&self, now: Moment, episode_over: bool) -> bool {
        self.fit.is_none_or(|then| {
            let changed = now.nodes > then.nodes
                || now.edges > then.edges
                || now.pairs_tried > then.pairs_tried
                || now.step >= STALE * then.step.max(1);
            changed
                && (has_grown(then, now, self.params.growth)
                    || (episode_over || self.may_interrupt(then, now))
                        && now.step - then.step >= self.patience(then, now))
        })
    }

    /// Whether an episode may be interrupted for a fit.
    fn may_interrupt(&self, then: Moment, now: Moment) -> bool {
        let gained = (now.edges - then.edges) as f64;
        now.step - then.step >= self.params.refit_every
            && gained >= self.params.edge_growth * then.edges as f64
    }

    /// Steps that a fit waits after the one `then`.
    fn patience(&self, then: Moment, now: Moment) -> u64 {
        (self.params.refit_share * now.nodes as f64 * self.lull(then, now)) as u64
    }

    /// How much longer than usual a fit may wait for what is new since `then`: 1 from `edge_growth` on.
    fn lull(&self, then: Moment, now: Moment) -> f64 {
        let found = (now.edges - then.edges).max((now.pairs_tried - then.pairs_tried) as usize);
        let news = found as f64 / then.pairs_tried.max(1) as f64;
        (self.params.edge_growth / news).clamp(1.0, LULL)
    }

    /// The features have just been refreshed.
    pub fn features_refreshed(&mut self, now: Moment) {
        self.features = Some(now);
    }

    /// The potential has just been fitted.
    pub fn fitted(&mut self, now: Moment) {
        self.fit = Some(now);
    }

    /// The fit is void: the goals have changed.
    pub fn invalidate_fit(&mut self) {
        self.fit = None;
    }
}

/// One node has no features worth a refresh.
fn have_outgrown(then: Option<Moment>, now: Moment, share: f64) -> bool {
    now.nodes > 1 && then.is_none_or(|then| has_grown(then, now, share))
}

fn has_grown(then: Moment, now: Moment, share: f64) -> bool {
    now.nodes > then.nodes && now.nodes as f64 >= (1.0 + share) * then.nodes as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(step: u64, nodes: usize, edges: usize) -> Moment {
        Moment {
            step,
            nodes,
            edges,
            pairs_tried: edges as u64,
        }
    }

    #[test]
    fn features_follow_the_growth_in_nodes() {
        let mut schedule = RefreshSchedule::new(ScheduleParams::default());
        let due = |schedule: &RefreshSchedule, now| {
            (
                schedule.agent_features_due(now),
                schedule.potential_features_due(now),
            )
        };
        assert_eq!(
            due(&schedule, at(0, 1, 0)),
            (false, false),
            "one node has none"
        );
        assert_eq!(due(&schedule, at(1, 2, 1)), (true, true));
        schedule.features_refreshed(at(1, 100, 120));
        assert_eq!(due(&schedule, at(9, 104, 130)), (false, false));
        assert_eq!(due(&schedule, at(9, 105, 130)), (true, false));
        assert_eq!(due(&schedule, at(9, 125, 130)), (true, true));
    }

    #[test]
    fn fits_of_a_large_graph_wait_in_proportion_to_it() {
        let mut schedule = RefreshSchedule::new(ScheduleParams::default());
        schedule.fitted(at(1000, 10_000, 15_000));
        for episode_over in [false, true] {
            assert!(!schedule.fit_due(at(1999, 10_010, 16_000), episode_over));
            assert!(schedule.fit_due(at(2001, 10_010, 16_000), episode_over));
        }
        assert!(schedule.fit_due(at(1001, 10_500, 16_000), false));
    }

    #[test]
    fn fits_wait_longer_where_little_is_new() {
        let mut schedule = RefreshSchedule::new(ScheduleParams::default());
        schedule.fitted(at(1000, 1000, 2000));
        // A tenth of the states in steps for 5 % and more; twice as long for half of that; as long as the states are many at most.
        for (found, wait) in [(200, 100), (100, 100), (50, 200), (10, 1000), (1, 1000)] {
            for episode_over in [false, true] {
                let edges = 2000 + found;
                let early = schedule.fit_due(at(999 + wait, 1000, edges), episode_over);
                assert!(!early, "{found} after {wait}");
            }
            assert!(schedule.fit_due(at(1000 + wait, 1000, 2000 + found), true));
        }
    }

    #[test]
    fn fit_waits_for_the_end_of_the_episode_unless_much_has_changed() {
        let mut schedule = RefreshSchedule::new(ScheduleParams::default());
        assert!(
            schedule.fit_due(at(5, 3, 2), false),
            "nothing was fitted yet"
        );
        schedule.fitted(at(100, 100, 100));
        assert!(
            !schedule.fit_due(at(199, 100, 100), true),
            "nothing has changed"
        );
        assert!(
            schedule.fit_due(at(200, 100, 100), true),
            "as much was seen again"
        );
        assert!(!schedule.fit_due(at(110, 100, 105), false));
        assert!(schedule.fit_due(at(110, 100, 105), true));
        assert!(schedule.fit_due(at(150, 100, 105), false));
        assert!(schedule.fit_due(at(110, 105, 105), false));
        schedule.invalidate_fit();
        assert!(schedule.fit_due(at(110, 100, 100), false));
    }
}
