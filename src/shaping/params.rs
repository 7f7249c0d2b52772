//! The `[shaping]` section of a scenario.

use crate::parameter::{ParameterError, Section};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// φ of the costliest run there may be is then still an `f32`, as snapshots keep it.
const MAX_SCALE_FACTOR: f64 = 1e6;

/// Source of φ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PotentialKind {
    /// The soft value of the learnt model, with temperatures set by a GCN (the default).
    #[default]
    Gcn,
    /// The GCN's probability of the rewarding class, as in the source paper.
    Report,
    /// The soft value of the learnt model at a fixed temperature.
    Heat,
    /// The value of a linearly solvable process, from the default representation.
    Dr,
    /// Expected discounted visits of the goal, from the successor representation.
    Sr,
    /// The value of the learnt model's optimal policy.
    Hops,
    /// Distance on the true map.
    Oracle,
    /// The opposite of the oracle's φ: leads away from the goal.
    NegatedOracle,
    /// A number drawn for each state.
    Random,
    /// As `shaping.file` gives it.
    File,
    /// φ = 0: no shaping.
    None,
}

impl PotentialKind {
    /// Every kind, in the order of the documentation.
    pub const ALL: [PotentialKind; 11] = [
        PotentialKind::Gcn,
        PotentialKind::Report,
        PotentialKind::Heat,
        PotentialKind::Dr,
        PotentialKind::Sr,
        PotentialKind::Hops,
        PotentialKind::Oracle,
        PotentialKind::NegatedOracle,
        PotentialKind::Random,
        PotentialKind::File,
        PotentialKind::None,
    ];

    /// The name used in scenarios and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            PotentialKind::Gcn => "gcn",
            PotentialKind::Report => "report",
            PotentialKind::Heat => "heat",
            PotentialKind::Dr => "dr",
            PotentialKind::Sr => "sr",
            PotentialKind::Hops => "hops",
            PotentialKind::Oracle => "oracle",
            PotentialKind::NegatedOracle => "negated-oracle",
            PotentialKind::Random => "random",
            PotentialKind::File => "file",
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
    /// As the model puts it out. Only `report`, `dr` and `sr` have a raw form of their own: the class probability; the value,
    /// less that of the best goal; and the discounted visits of the goal, relative to those from the goal, less 1.
    Raw,
}

/// The `[shaping]` section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ShapingParams {
    /// Where φ comes from.
    pub potential: PotentialKind,
    /// Units of φ; `raw`, as the model puts it out, only for `report`, `dr` and `sr`.
    pub scale: ScaleMode,
    /// Factor of φ, at most 1e6. At 1 `gcn`, `heat` and `hops` are the return-to-go itself; with `scale = "return"` the others reach from 0 to
    /// what the longest known way to a goal costs.
    pub scale_factor: f64,
    /// Weight of the shaped TD error against the plain one, 0 to 1 (α of Klissarov & Precup 2020).
    pub mix: f64,
    /// `gcn`: temperature before the network has learnt anything, in typical steps. `dr`: λ, in the same.
    pub temperature: f64,
    /// `gcn`: the network may scale a temperature by e^±this.
    pub log_temperature_clip: f64,
    /// `gcn`: states drawn as labels at each fit, 1 to 1 000 000.
    pub num_labels: usize,
    /// `gcn`: at most so many epochs, up to 1 000 000, when the network is trained for the first time.
    pub cold_epochs: usize,
    /// `gcn`: at most so many when it is trained again.
    pub warm_epochs: usize,
    /// `gcn`: training ends, or does not even begin, when the loss is at most this: the mean square of the relative
    /// error of the returns. It ends, too, when ten epochs have lowered the loss by less than a twentieth.
    pub fit_tolerance: f64,
    /// `gcn`: weight of the smoothness loss zᵀLz, divided by the number of edges.
    pub smoothness: f64,
    /// `heat`: the part of the heat that a typical step keeps, between 0 and 1.
    pub heat_kept: f64,
    /// `file`: a CSV file of φ with the columns row,col,potential, or name,potential where states have names; as `export` writes
    /// them. A relative path begins at the folder of the scenario. φ is used as it is, from the first goal on.
    #[schemars(example = "phi.csv")]
    pub file: Option<PathBuf>,
}

impl Default for ShapingParams {
    fn default() -> Self {
        Self {
            potential: PotentialKind::default(),
            scale: ScaleMode::default(),
            scale_factor: 1.0,
            mix: 1.0,
            temperature: 0.5,
            log_temperature_clip: 1.5,
            num_labels: 256,
            cold_epochs: 150,
            warm_epochs: 20,
            fit_tolerance: 2e-4,
            smoothness: 3.0,
            heat_kept: 0.9,
            file: None,
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
        let clip = self.log_temperature_clip;
        within("log_temperature_clip", clip, 0.0..=3.0, "between 0 and 3")?;
        section.count("num_labels", self.num_labels, 1..=MOST)?;
        section.count("cold_epochs", self.cold_epochs, ..=MOST)?;
        section.count("warm_epochs", self.warm_epochs, ..=MOST)?;
        let rule = "0 or a positive number";
        within("fit_tolerance", self.fit_tolerance, 0.0..=f64::MAX, rule)?;
        within("smoothness", self.smoothness, 0.0..=f64::MAX, rule)?;
        let rule = "between 0.000001 and 0.999";
        within("heat_kept", self.heat_kept, 1e-6..=0.999, rule)?;
        self.check_file()
    }

    /// Whether there is a file where one is needed, and nowhere else.
    fn check_file(&self) -> Result<(), ParameterError> {
        let broken = |key, value: String, rule: String| ParameterError {
            section: "shaping",
            key,
            value,
            rule: rule.into(),
        };
        let kind = self.potential;
        match (&self.file, kind) {
            (None, PotentialKind::File) => {
                let rule = "accompanied by shaping.file, a CSV file of φ";
                Err(broken("potential", kind.to_string(), rule.to_owned()))
            }
            (None, _) | (Some(_), PotentialKind::File) => Ok(()),
            (Some(file), _) => {
                let rule = format!(
                    "left out, or else shaping.potential be \"file\": \"{kind}\" reads none"
                );
                Err(broken("file", file.display().to_string(), rule))
            }
        }
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
        for (scale_factor, said) in [
            (f64::NAN, "NaN"),
            (-1.0, "-1"),
            (0.0, "0"),
            (2e6, "2000000"),
        ] {
            check(
                ShapingParams {
                    scale_factor,
                    ..Default::default()
                },
                &format!("shaping.scale_factor = {said}: must be a positive number of at most 1e6"),
            );
        }
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
        check(
            ShapingParams {
                potential: PotentialKind::File,
                ..Default::default()
            },
            "shaping.potential = file: must be accompanied by shaping.file, a CSV file of φ",
        );
        check(
            ShapingParams {
                potential: PotentialKind::Heat,
                file: Some(PathBuf::from("phi.csv")),
                ..Default::default()
            },
            "shaping.file = phi.csv: must be left out, or else shaping.potential be \"file\": \"heat\" reads none",
        );
    }
}
