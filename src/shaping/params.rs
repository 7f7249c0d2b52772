//! The `[shaping]` section of a scenario.

use crate::parameter::{ParameterError, Section};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::RangeInclusive;

/// φ of the costliest run there may be is then still an `f32`, as snapshots keep it.
const MAX_SCALE_FACTOR: f64 = 1e6;

/// Source of φ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PotentialKind {
    /// A GCN sets the local cost of a diffusion (the default).
    #[default]
    Gcn,
    /// The GCN's probability of the rewarding class, as in the source paper.
    Report,
    /// A diffusion with fixed cost.
    Heat,
    /// Hop distance on the visited graph.
    Hops,
    /// Distance on the true map.
    Oracle,
    /// φ = 0: no shaping.
    None,
}

impl PotentialKind {
    /// Every kind, in the order of the documentation.
    pub const ALL: [PotentialKind; 6] = [
        PotentialKind::Gcn,
        PotentialKind::Report,
        PotentialKind::Heat,
        PotentialKind::Hops,
        PotentialKind::Oracle,
        PotentialKind::None,
    ];

    /// The name used in scenarios and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            PotentialKind::Gcn => "gcn",
            PotentialKind::Report => "report",
            PotentialKind::Heat => "heat",
            PotentialKind::Hops => "hops",
            PotentialKind::Oracle => "oracle",
            PotentialKind::None => "none",
        }
    }
}

impl fmt::Display for PotentialKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// In which units φ is handed out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ScaleMode {
    /// Shifted to 0 at the best goal and scaled to `scale_factor` times the cost of the longest known way there.
    #[default]
    Return,
    /// As the model puts it out. Only `potential = "report"` has a raw form of its own: the class probability.
    Raw,
}

/// The `[shaping]` section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ShapingParams {
    /// Where φ comes from.
    pub potential: PotentialKind,
    /// Units of φ: `return` or `raw` (the bare class probability, only for `report`).
    pub scale: ScaleMode,
    /// Range of φ ÷ cost of the longest known way to a goal; at most 1e6.
    pub scale_factor: f64,
    /// Weight of the shaped TD error against the plain one, 0 to 1 (α of Klissarov & Precup 2020).
    pub mix: f64,
    /// `gcn`: diffusion cost of one typical step, in nats, before the network has learnt anything.
    pub temperature: f64,
    /// `gcn`: the network may scale a local cost by e^±this.
    pub log_cost_clip: f64,
    /// `gcn`: states drawn as labels at each fit, 1 to 1 000 000.
    pub num_labels: usize,
    /// `gcn`: at most so many epochs, up to 1 000 000, when the network is trained for the first time.
    pub cold_epochs: usize,
    /// `gcn`: at most so many when it is trained again.
    pub warm_epochs: usize,
    /// `gcn`: training ends, or does not even begin, when the loss is at most this: the mean square of the relative
    /// error in the shape of the cost-to-go. 0: every epoch is taken.
    pub fit_tolerance: f64,
    /// `gcn`: weight of the smoothness loss zᵀLz, divided by the number of edges.
    pub cost_smoothness: f64,
    /// `heat`: the part of the heat that a typical step keeps, between 0 and 1.
    pub heat_kept: f64,
}

impl Default for ShapingParams {
    fn default() -> Self {
        Self {
            potential: PotentialKind::default(),
            scale: ScaleMode::default(),
            scale_factor: 4.0,
            mix: 1.0,
            temperature: 0.7,
            log_cost_clip: 1.5,
            num_labels: 256,
            cold_epochs: 150,
            warm_epochs: 20,
            fit_tolerance: 2e-4,
            cost_smoothness: 3.0,
            heat_kept: 0.9,
        }
    }
}

/// More labels or epochs than this would take for ever.
const MOST: usize = 1_000_000;

impl ShapingParams {
    /// Checks every range.
    ///
    /// # Errors
    /// The first key out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let section = Section("shaping");
        let factor = self.scale_factor;
        let holds = factor > 0.0 && factor <= MAX_SCALE_FACTOR;
        let rule = "a positive number of at most 1e6";
        section.number("scale_factor", factor, holds, rule)?;
        let within = |key, value: f64, range: RangeInclusive<f64>, rule| {
            section.number(key, value, range.contains(&value), rule)
        };
        within("mix", self.mix, 0.0..=1.0, "between 0 and 1")?;
        // Below this a solve takes thousands of sweeps on a large map.
        let rule = "between 0.001 and 100";
        within("temperature", self.temperature, 1e-3..=100.0, rule)?;
        let clip = self.log_cost_clip;
        within("log_cost_clip", clip, 0.0..=3.0, "between 0 and 3")?;
        section.count("num_labels", self.num_labels, 1..=MOST)?;
        section.count("cold_epochs", self.cold_epochs, ..=MOST)?;
        section.count("warm_epochs", self.warm_epochs, ..=MOST)?;
        let rule = "0 or a positive number";
        within("fit_tolerance", self.fit_tolerance, 0.0..=f64::MAX, rule)?;
        within(
            "cost_smoothness",
            self.cost_smoothness,
            0.0..=f64::MAX,
            rule,
        )?;
        let rule = "between 0.000001 and 0.999";
        within("heat_kept", self.heat_kept, 1e-6..=0.999, rule)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_valid_and_survive_toml() {
        let params = ShapingParams::default();
        params.validate().unwrap();
        let text = toml::to_string(&params).unwrap();
        assert_eq!(toml::from_str::<ShapingParams>(&text).unwrap(), params);
    }

    #[test]
    fn names_are_those_of_serde() {
        for kind in PotentialKind::ALL {
            let written = serde_json::to_string(&kind).unwrap();
            assert_eq!(written, format!("\"{kind}\""));
        }
    }

    #[test]
    fn unknown_keys_are_refused() {
        assert!(toml::from_str::<ShapingParams>("scal_factor = 2.0").is_err());
    }

    #[test]
    fn a_broken_rule_names_key_value_and_rule() {
        let check = |params: ShapingParams, message: &str| {
            assert_eq!(params.validate().unwrap_err().to_string(), message);
        };
        check(
            ShapingParams {
                mix: 1.5,
                ..Default::default()
            },
            "shaping.mix = 1.5: must be between 0 and 1",
        );
        check(
            ShapingParams {
                scale_factor: f64::NAN,
                ..Default::default()
            },
            "shaping.scale_factor = NaN: must be a positive number of at most 1e6",
        );
        check(
            ShapingParams {
                temperature: 0.0,
                ..Default::default()
            },
            "shaping.temperature = 0: must be between 0.001 and 100",
        );
        check(
            ShapingParams {
                num_labels: 0,
                ..Default::default()
            },
            "shaping.num_labels = 0: must be 1 to 1000000",
        );
    }
}
