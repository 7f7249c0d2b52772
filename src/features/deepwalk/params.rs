//! The `[deepwalk]` section of a scenario.

use crate::parameter::{ParameterError, Section};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of walks and of the vectors fitted to them. Perozzi et al. use 80 walks of 40 nodes, a window of 10 and 64
/// dimensions on social networks; the defaults here are for graphs that are refreshed while they grow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DeepWalkParams {
    /// Length of a vector, 1 to 4096.
    pub dimensions: usize,
    /// Walks that begin in each node that is new or has a new edge, 1 to 10 000.
    pub walks_per_node: usize,
    /// Nodes of a walk, 2 to 10 000.
    pub walk_length: usize,
    /// How far apart on a walk two nodes may be to count as neighbours, 1 to 1000.
    pub window: usize,
    /// Random nodes that each pair is told apart from, 1 to 1000.
    pub negatives: usize,
    /// Step size at the beginning of a refresh, above 0; falls to a hundredth of it.
    pub learning_rate: f64,
}

impl Default for DeepWalkParams {
    fn default() -> Self {
        Self {
            dimensions: 16,
            walks_per_node: 10,
            walk_length: 20,
            window: 5,
            negatives: 5,
            learning_rate: 0.05,
        }
    }
}

impl DeepWalkParams {
    /// Checks every range.
    ///
    /// # Errors
    /// The first key out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let section = Section("deepwalk");
        section.count("dimensions", self.dimensions, 1..=4096)?;
        section.count("walks_per_node", self.walks_per_node, 1..=10_000)?;
        section.count("walk_length", self.walk_length, 2..=10_000)?;
        section.count("window", self.window, 1..=1000)?;
        section.count("negatives", self.negatives, 1..=1000)?;
        let rate = self.learning_rate;
        let holds = rate > 0.0 && rate.is_finite();
        section.number("learning_rate", rate, holds, "positive and finite")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_range_is_checked() {
        assert_eq!(DeepWalkParams::default().validate(), Ok(()));
        type Slip = fn(&mut DeepWalkParams);
        let broken: [(&str, Slip); 12] = [
            ("dimensions", |p| p.dimensions = 4097),
            ("walks_per_node", |p| p.walks_per_node = 10_001),
            ("walk_length", |p| p.walk_length = 1 << 32),
            ("window", |p| p.window = usize::MAX),
            ("negatives", |p| p.negatives = 1001),
            ("dimensions", |p| p.dimensions = 0),
            ("walks_per_node", |p| p.walks_per_node = 0),
            ("walk_length", |p| p.walk_length = 1),
            ("window", |p| p.window = 0),
            ("negatives", |p| p.negatives = 0),
            ("learning_rate", |p| p.learning_rate = 0.0),
            ("learning_rate", |p| p.learning_rate = f64::NAN),
        ];
        for (expected, break_it) in broken {
            let mut params = DeepWalkParams::default();
            break_it(&mut params);
            let error = params.validate().unwrap_err();
            assert_eq!((error.section, error.key), ("deepwalk", expected));
        }
    }

    #[test]
    fn unknown_keys_are_refused() {
        assert!(toml::from_str::<DeepWalkParams>("windows = 3").is_err());
    }
}
