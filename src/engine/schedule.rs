//! When the spectrum is refreshed and when the potential is fitted again.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of the schedule.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ScheduleParams {
    /// The spectrum is refreshed, and the potential fitted, when the graph has gained this share of nodes.
    pub growth: f64,
    /// The potential is fitted at the latest this many steps after a change of the graph; sooner at the end of an episode.
    pub refit_every: u64,
    /// … but not before the graph has gained this share of edges, or the episode has ended.
    pub edge_growth: f64,
}

impl Default for ScheduleParams {
    fn default() -> Self {
        Self {
            growth: 0.05,
            refit_every: 50,
            edge_growth: 0.01,
        }
    }
}

/// A parameter that breaks its rule.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("schedule.{key} = {value}: {rule}")]
pub struct ScheduleParamsError {
    /// The key in the `[schedule]` table.
    pub key: &'static str,
    /// What it was.
    pub value: f64,
    /// What it must be.
    pub rule: &'static str,
}

impl ScheduleParams {
    /// Checks every rule.
    ///
    /// # Errors
    /// The first key that breaks its rule.
    pub fn validate(&self) -> Result<(), ScheduleParamsError> {
        let rule = "must be above 0 and at most 1";
        for (key, value) in [("growth", self.growth), ("edge_growth", self.edge_growth)] {
            if !(value > 0.0 && value <= 1.0) {
                return Err(ScheduleParamsError { key, value, rule });
            }
        }
        if self.refit_every == 0 {
            return Err(ScheduleParamsError {
                key: "refit_every",
                value: 0.0,
                rule: "must be at least 1",
            });
        }
        Ok(())
    }
}

/// How large the graph is, and when that is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

/// Remembers the last refresh and the last fit.
#[derive(Clone, Debug, Default)]
pub struct RefreshSchedule {
    params: ScheduleParams,
    spectrum: Option<Moment>,
    fit: Option<Moment>,
}

impl RefreshSchedule {
    /// Nothing refreshed yet.
    pub fn new(params: ScheduleParams) -> Self {
        Self {
            params,
            spectrum: None,
            fit: None,
        }
    }

    /// Whether the graph has outgrown the spectrum.
    pub fn spectrum_due(&self, now: Moment) -> bool {
        now.nodes > 1 && self.spectrum.is_none_or(|then| self.has_grown(then, now))
    }

    /// Whether the potential should be fitted, once there is something to fit it on.
    pub fn fit_due(&self, now: Moment, episode_over: bool) -> bool {
        self.fit.is_none_or(|then| {
            let changed = now.nodes > then.nodes
                || now.edges > then.edges
                || now.pairs_tried > then.pairs_tried;
            let waited = now.step - then.step >= self.params.refit_every;
            let gained =
                (now.edges - then.edges) as f64 >= self.params.edge_growth * then.edges as f64;
            changed && (episode_over || self.has_grown(then, now) || (waited && gained))
        })
    }

    /// The spectrum has just been refreshed.
    pub fn spectrum_refreshed(&mut self, now: Moment) {
        self.spectrum = Some(now);
    }

    /// The potential has just been fitted.
    pub fn fitted(&mut self, now: Moment) {
        self.fit = Some(now);
    }

    /// The fit is void: the goals have changed.
    pub fn invalidate_fit(&mut self) {
        self.fit = None;
    }

    fn has_grown(&self, then: Moment, now: Moment) -> bool {
        now.nodes > then.nodes && now.nodes as f64 >= (1.0 + self.params.growth) * then.nodes as f64
    }
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
    fn spectrum_follows_the_growth_in_nodes() {
        let mut schedule = RefreshSchedule::new(ScheduleParams::default());
        assert!(
            !schedule.spectrum_due(at(0, 1, 0)),
            "one node has no spectrum worth a refresh"
        );
        assert!(schedule.spectrum_due(at(1, 2, 1)));
        schedule.spectrum_refreshed(at(1, 100, 120));
        assert!(!schedule.spectrum_due(at(9, 104, 130)));
        assert!(schedule.spectrum_due(at(9, 105, 130)));
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
            !schedule.fit_due(at(500, 100, 100), true),
            "nothing has changed"
        );
        assert!(!schedule.fit_due(at(110, 100, 101), false));
        assert!(schedule.fit_due(at(110, 100, 101), true));
        assert!(schedule.fit_due(at(150, 100, 101), false));
        assert!(schedule.fit_due(at(110, 105, 105), false));
        schedule.invalidate_fit();
        assert!(schedule.fit_due(at(110, 100, 100), false));
    }
}
