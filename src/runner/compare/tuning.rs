//! Step sizes of the sparse arm for one world: the fairest opponent there is.
//!
//! Every arm of a comparison shares its step sizes with the sparse one. They may suit the others better, so the ratio
//! is also given to a sparse arm that had its own chosen from a small grid, on seeds that the comparison does not use.

use super::Field;
use crate::archive::{TrialRecord, TuningEntry, names};
use crate::runner::error::RunnerError;
use crate::scenario::{Arm, BASELINE, Scenario};
use crate::statistics::interquartile_mean;
use std::path::Path;

/// Step sizes of the critic that are tried; the default is in the middle.
const CRITIC: [f64; 3] = [0.4, 0.7, 1.0];
/// Step sizes of the actor that are tried.
const ACTOR: [f64; 3] = [0.03, 0.1, 0.3];
/// Seeds each pair is tried on.
const SEEDS: usize = 5;
/// Where tuning seeds begin.
const FIRST_SEED: u64 = 1_000_000;

/// A pair of step sizes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSizes {
    /// Of the critic.
    pub critic: f64,
    /// Of the actor.
    pub actor: f64,
}

impl StepSizes {
    /// All pairs.
    pub fn grid() -> impl Iterator<Item = StepSizes> {
        CRITIC
            .into_iter()
            .flat_map(|critic| ACTOR.map(|actor| StepSizes { critic, actor }))
    }

    /// As the name of an arm.
    pub fn arm_name(self) -> String {
        format!("{BASELINE}-critic-{}-actor-{}", self.critic, self.actor)
    }

    /// As settings, to be laid over the sparse arm's.
    pub fn settings(self) -> [String; 2] {
        [
            format!("agent.critic_learning_rate={}", self.critic),
            format!("agent.actor_learning_rate={}", self.actor),
        ]
    }

    /// Regret of these trials with it.
    pub fn entry(self, trials: &[TrialRecord]) -> TuningEntry {
        let regrets: Vec<f64> = trials.iter().map(|t| t.result.regret).collect();
        TuningEntry {
            critic_learning_rate: self.critic,
            actor_learning_rate: self.actor,
            regret_iqm: interquartile_mean(&regrets),
        }
    }
}

/// Seeds that are not among those of the comparison.
pub fn tuning_seeds(taken: &[u64]) -> Vec<u64> {
    (FIRST_SEED..)
        .filter(|seed| !taken.contains(seed))
        .take(SEEDS)
        .collect()
}

/// Number of pairs, and of trials that tuning takes.
pub fn tuning_trials() -> usize {
    CRITIC.len() * ACTOR.len() * SEEDS
}

/// Where the trials of tuning are kept below the folder of a comparison.
pub fn tuning_folder(folder: &Path) -> std::path::PathBuf {
    folder.join(names::TUNING_FOLDER)
}

/// The tuned sparse arm.
pub(super) struct Tuned {
    pub arm: Arm,
    pub chosen: TuningEntry,
    pub tried: Vec<TuningEntry>,
    pub seeds: Vec<u64>,
}

impl Field<'_> {
    /// Tries the grid of step sizes; none if stopped.
    pub(super) fn tune(&self, sparse: &Arm) -> Result<Option<Tuned>, RunnerError> {
        let seeds = tuning_seeds(&self.request.seeds);
        let sizes: Vec<StepSizes> = StepSizes::grid().collect();
        let lay = |sizes: &StepSizes| {
            let settings = sparse.settings.iter().cloned().chain(sizes.settings());
            let (path, sets) = (&self.request.path, &self.request.sets);
            let (name, text) = (sizes.arm_name(), &self.loaded.text);
            Scenario::lay_settings(&name, settings.collect(), path, text, sets)
        };
        let arms: Vec<Arm> = sizes.iter().map(lay).collect::<Result<_, _>>()?;
        let all: Vec<&Arm> = arms.iter().collect();
        let Some(trials) = self.trials(&tuning_folder(self.folder), &all, &seeds)? else {
            return Ok(None);
        };
        let tried: Vec<TuningEntry> = sizes
            .iter()
            .zip(&trials)
            .map(|(sizes, (_, trials))| sizes.entry(trials))
            .collect();
        let best = (0..tried.len())
            .min_by(|&a, &b| tried[a].regret_iqm.total_cmp(&tried[b].regret_iqm))
            .expect("the grid is not empty");
        Ok(Some(Tuned {
            arm: arms[best].clone(),
            chosen: tried[best],
            tried,
            seeds,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tuning_seeds_are_never_those_of_the_comparison() {
        let seeds = tuning_seeds(&[3, 1_000_001]);
        assert_eq!(
            seeds,
            [1_000_000, 1_000_002, 1_000_003, 1_000_004, 1_000_005]
        );
    }

    #[test]
    fn the_grid_holds_the_default() {
        let default = crate::agent::ActorCriticParams::default();
        assert!(
            StepSizes::grid().any(|s| s.critic == default.critic_learning_rate
                && s.actor == default.actor_learning_rate)
        );
    }
}
