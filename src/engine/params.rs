//! Parameters of a world model and of the walkers on it.

use super::schedule::ScheduleParams;
use crate::agent::check_gamma;
use crate::exploration::ExplorationParams;
use crate::features::DeepWalkParams;
use crate::gcn::GcnParams;
use crate::parameter::ParameterError;
use crate::shaping::ShapingParams;
use crate::spectral::SpectralParams;

/// Parameters of every part of the pipeline.
#[derive(Clone, Debug)]
pub struct PipelineParams {
    /// Eigenpairs.
    pub spectral: SpectralParams,
    /// Random walks.
    pub deepwalk: DeepWalkParams,
    /// Network.
    pub gcn: GcnParams,
    /// Potential and scale.
    pub shaping: ShapingParams,
    /// Advice before and after the first goal.
    pub exploration: ExplorationParams,
    /// When to refresh and to fit.
    pub schedule: ScheduleParams,
    /// The discount that the agent learns with.
    pub gamma: f64,
}

impl Default for PipelineParams {
    /// The defaults of every part, and γ = 1 as in the source paper.
    fn default() -> Self {
        Self {
            spectral: SpectralParams::default(),
            deepwalk: DeepWalkParams::default(),
            gcn: GcnParams::default(),
            shaping: ShapingParams::default(),
            exploration: ExplorationParams::default(),
            schedule: ScheduleParams::default(),
            gamma: 1.0,
        }
    }
}

impl PipelineParams {
    /// Checks every part, and γ, whose key is that of the agent it is shared with.
    ///
    /// # Errors
    /// The first parameter that breaks its rule.
    pub fn validate(&self) -> Result<(), ParameterError> {
        self.spectral.validate()?;
        self.deepwalk.validate()?;
        self.gcn.validate()?;
        self.shaping.validate()?;
        self.exploration.validate()?;
        self.schedule.validate()?;
        check_gamma(self.gamma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_broken_rule_of_any_part_is_found_and_named() {
        assert_eq!(PipelineParams::default().validate(), Ok(()));
        type Slip = fn(&mut PipelineParams);
        let broken: [(&str, Slip); 9] = [
            ("spectral.tol = 2", |p| p.spectral.tol = 2.0),
            ("deepwalk.window = 0", |p| p.deepwalk.window = 0),
            ("gcn.hidden_dim = 0", |p| p.gcn.hidden_dim = 0),
            ("shaping.mix = NaN", |p| p.shaping.mix = f64::NAN),
            ("exploration.bonus = -1", |p| p.exploration.bonus = -1.0),
            ("schedule.refit_every = 0", |p| p.schedule.refit_every = 0),
            ("agent.gamma = 1.5", |p| p.gamma = 1.5),
            ("agent.gamma = -0.5", |p| p.gamma = -0.5),
            ("agent.gamma = NaN", |p| p.gamma = f64::NAN),
        ];
        for (named, break_it) in broken {
            let mut params = PipelineParams::default();
            break_it(&mut params);
            let error = params.validate().unwrap_err();
            assert_eq!(format!("{} = {}", error.path(), error.value), named);
        }
    }
}
