//! Results of a sweep: points of a grid over the same seeds.

use super::comparison::{IqmInterval, MedianInterval, Moments};
use crate::scenario::{Axis, GridPoint};
use serde::{Deserialize, Serialize};

/// Contents of `sweep.json`: what is swept, and who asked for it when.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Swept {
    /// Program and version.
    pub program: String,
    /// Name of the scenario.
    pub scenario: String,
    /// The command line.
    pub arguments: Vec<String>,
    /// Master seeds.
    pub seeds: Vec<u64>,
    /// Keys and their values.
    pub grid: Vec<Axis>,
    /// Every point, in the order of the grid.
    pub points: Vec<SweptPoint>,
    /// When it began.
    pub started: String,
}

/// One point, and the folder that its trials are in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweptPoint {
    /// Hash of its scenario.
    pub hash: String,
    /// The point.
    #[serde(flatten)]
    pub point: GridPoint,
}

/// Contents of `summary.json`. Nothing in it is from a clock, so equal sweeps have equal bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// Name of the scenario.
    pub scenario: String,
    /// Seeds, as asked for.
    pub seeds: Vec<u64>,
    /// Keys and their values as they were written.
    pub grid: Vec<Axis>,
    /// Every point, the last key of the grid changing first.
    pub points: Vec<PointSummary>,
}

/// Value of one key at a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointSetting {
    /// The key with its section.
    pub key: String,
    /// Its value.
    pub value: serde_json::Value,
}

impl PointSetting {
    /// The value as `--set` understands it: TOML, or a text.
    pub fn new(key: &str, text: &str) -> Self {
        let is_number_of_json = |value: &toml::Value| value.as_float().is_none_or(f64::is_finite);
        let parsed: Result<toml::Value, _> =
            toml::de::ValueDeserializer::parse(text).and_then(serde::Deserialize::deserialize);
        let value = parsed.ok().filter(is_number_of_json);
        let value = value.and_then(|value| serde_json::to_value(value).ok());
        Self {
            key: key.to_owned(),
            value: value.unwrap_or_else(|| text.into()),
        }
    }
}

/// Results of one point over all seeds; the fields of an arm of a comparison mean the same there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointSummary {
    /// Hash of the scenario of the point, which names its folder.
    pub hash: String,
    /// The arm that is laid over the point, if arms were asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arm: Option<String>,
    /// Key and value of each axis.
    pub settings: Vec<PointSetting>,
    /// Episodes of each run.
    pub episodes: usize,
    /// Mean length of an episode under the best policy, over the seeds.
    pub optimal_steps: f64,
    /// Mean return of such an episode, R*, over the seeds.
    pub optimal_return: f64,
    /// Episodes before the goals moved, if they did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goals_moved_after: Option<usize>,
    /// Regret in units of reward.
    pub regret: IqmInterval,
    /// Environment steps until a goal was reached first.
    pub first_goal_step: Moments,
    /// Episodes until the mean return of 20 was within 1.5 times the optimum.
    pub episodes_to_1_5x: Moments,
    /// Environment steps until then.
    pub steps_to_1_5x: Moments,
    /// Episodes until it was within 1.1 times the optimum.
    pub episodes_to_1_1x: Moments,
    /// Environment steps until then.
    pub steps_to_1_1x: Moments,
    /// Mean return of the last tenth of the episodes, at least 20 of them.
    pub final_return: MedianInterval,
    /// How far that is from the best, 1: median over seeds.
    pub final_ratio: f64,
    /// Exact return of the final greedy policy, with the advice of φ; none if it prefers nothing.
    pub greedy_return: MedianInterval,
    /// The same without any advice.
    pub greedy_return_unadvised: MedianInterval,
    /// Share of seeds whose greedy policy falls short of the optimum by more than a twentieth.
    pub failures: Option<f64>,
    /// The same without any advice.
    pub failures_unadvised: Option<f64>,
    /// The seed with the most regret.
    pub worst_seed: u64,
    /// Median of the epochs that the network was trained for in a run.
    pub gcn_epochs: f64,
    /// Largest number of false maxima of φ at the end of a run; none without a potential.
    pub spurious_maxima: Option<usize>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn values_are_what_they_were_meant_to_be() {
        let value = |text: &str| PointSetting::new("a.b", text).value;
        assert_eq!(value("8"), json!(8));
        assert_eq!(value("0.5"), json!(0.5));
        assert_eq!(value("true"), json!(true));
        assert_eq!(value("heat"), json!("heat"));
        assert_eq!(value("\"heat\""), json!("heat"));
        assert_eq!(
            value("[{ at = \"top-left\" }]"),
            json!([{ "at": "top-left" }])
        );
        assert_eq!(value("inf"), json!("inf"), "JSON has no infinity");
    }
}
