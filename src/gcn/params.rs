//! Parameters of the network and of its fit.

use crate::features::FeatureSource;
use crate::parameter::{ParameterError, Section};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of the network and of its fit; the defaults are those of section 4.3 of the source paper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, rename_all = "snake_case")]
pub struct GcnParams {
    /// What the network sees of a state.
    pub features: FeatureSource,
    /// Hidden units, 1 to 65 536 (paper: 16).
    pub hidden_dim: usize,
    /// Adam's step size, above 0 (paper: 0.01).
    pub learning_rate: f64,
    /// Epochs of a fit, at most 1 000 000; 0 leaves the weights as they are (paper: 40).
    pub epochs: usize,
    /// λ ≥ 0 of the smoothness loss (λ / |E|) φᵀLφ. Without it two labels leave every other node free.
    pub smoothness: f64,
}

impl Default for GcnParams {
    fn default() -> Self {
        Self {
            features: FeatureSource::default(),
            hidden_dim: 16,
            learning_rate: 0.01,
            epochs: 40,
            smoothness: 3.0,
        }
    }
}

/// More hidden units than this are a slip of the pen.
const MAX_HIDDEN: usize = 65_536;

/// More epochs than this would take for ever.
const MAX_EPOCHS: usize = 1_000_000;

impl GcnParams {
    /// Checks every key.
    ///
    /// # Errors
    /// The first key out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let section = Section("gcn");
        section.count("hidden_dim", self.hidden_dim, 1..=MAX_HIDDEN)?;
        section.count("epochs", self.epochs, ..=MAX_EPOCHS)?;
        let rate = self.learning_rate;
        let holds = rate > 0.0 && rate.is_finite();
        section.number("learning_rate", rate, holds, "positive and finite")?;
        let smoothness = self.smoothness;
        let holds = smoothness >= 0.0 && smoothness.is_finite();
        section.number("smoothness", smoothness, holds, "0 or more, and finite")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_the_reports_and_valid() {
        let params = GcnParams::default();
        assert_eq!(
            (params.hidden_dim, params.learning_rate, params.epochs),
            (16, 0.01, 40)
        );
        assert!(params.validate().is_ok());
    }

    #[test]
    fn broken_rules_name_the_key_and_the_value() {
        let message = |params: GcnParams| params.validate().unwrap_err().to_string();
        let default = GcnParams::default;
        assert_eq!(
            message(GcnParams {
                hidden_dim: 0,
                ..default()
            }),
            "gcn.hidden_dim = 0: must be 1 to 65536"
        );
        assert_eq!(
            message(GcnParams {
                hidden_dim: 65_537,
                ..default()
            }),
            "gcn.hidden_dim = 65537: must be 1 to 65536"
        );
        assert_eq!(
            message(GcnParams {
                epochs: 1_000_001,
                ..default()
            }),
            "gcn.epochs = 1000001: must be at most 1000000"
        );
        for learning_rate in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(
                message(GcnParams {
                    learning_rate,
                    ..default()
                })
                .ends_with(": must be positive and finite")
            );
        }
        assert_eq!(
            message(GcnParams {
                smoothness: -0.5,
                ..default()
            }),
            "gcn.smoothness = -0.5: must be 0 or more, and finite"
        );
    }

    #[test]
    fn missing_keys_default_and_unknown_keys_are_refused() {
        let params: GcnParams = toml::from_str("epochs = 7").unwrap();
        assert_eq!(
            params,
            GcnParams {
                epochs: 7,
                ..GcnParams::default()
            }
        );
        assert!(toml::from_str::<GcnParams>("epoch = 7").is_err());
    }
}
