//! Step sizes of the sparse arm for one world: the fairest opponent there is.
//!
//! Every arm of a comparison shares its step sizes with the sparse one. They may suit the others better, so the ratio
//! is also given to a sparse arm that had its own chosen from a grid, on seeds that the comparison does not use. The grid begins
//! with 3 × 3 pairs and grows where its best pair lies on an edge, until that is inside (or no step size is left to try).

use super::Field;
use crate::archive::{TrialRecord, TuningEntry, names};
use crate::runner::error::RunnerError;
use crate::scenario::{Arm, BASELINE, Scenario};
use crate::statistics::interquartile_mean;
use std::ops::RangeInclusive;
use std::path::Path;

/// Step sizes of the critic that may be tried, up to the largest there is.
const CRITIC: [f64; 5] = [0.1, 0.2, 0.4, 0.7, 1.0];
/// Step sizes of the actor that may be tried.
const ACTOR: [f64; 10] = [0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0];
/// Those that are tried first, of each; the defaults are in the middle.
const FIRST_CRITIC: RangeInclusive<usize> = 2..=4;
const FIRST_ACTOR: RangeInclusive<usize> = 3..=5;
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

/// Number of trials that tuning takes at least.
pub fn tuning_trials() -> usize {
    FIRST_CRITIC.count() * FIRST_ACTOR.count() * SEEDS
}

/// The part of the two lists that is tried.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Grid {
    critic: RangeInclusive<usize>,
    actor: RangeInclusive<usize>,
}

impl Grid {
    fn first() -> Self {
        Self {
            critic: FIRST_CRITIC,
            actor: FIRST_ACTOR,
        }
    }

    fn pairs(&self) -> Vec<StepSizes> {
        let critics = self.critic.clone();
        critics
            .flat_map(|c| self.actor.clone().map(move |a| (CRITIC[c], ACTOR[a])))
            .map(|(critic, actor)| StepSizes { critic, actor })
            .collect()
    }

    /// The grid with a step size more on each side on which `best` lies, as far as there are any; none if there is nothing to
    /// add.
    fn beyond(&self, best: StepSizes) -> Option<Self> {
        let grown = Self {
            critic: grow(&self.critic, &CRITIC, best.critic),
            actor: grow(&self.actor, &ACTOR, best.actor),
        };
        (grown != *self).then_some(grown)
    }
}

fn grow(tried: &RangeInclusive<usize>, all: &[f64], best: f64) -> RangeInclusive<usize> {
    let (mut first, mut last) = (*tried.start(), *tried.end());
    if best == all[first] {
        first = first.saturating_sub(1);
    }
    if best == all[last] {
        last = (last + 1).min(all.len() - 1);
    }
    first..=last
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
    /// Tries grids of step sizes until the best pair is inside; none if stopped.
    pub(super) fn tune(&self, sparse: &Arm) -> Result<Option<Tuned>, RunnerError> {
        let seeds = tuning_seeds(&self.request.seeds);
        let mut grid = Grid::first();
        let mut tried: Vec<(StepSizes, Arm, TuningEntry)> = Vec::new();
        loop {
            let mut pairs = grid.pairs();
            pairs.retain(|pair| tried.iter().all(|(known, ..)| known != pair));
            let arms: Vec<Arm> = pairs
                .iter()
                .map(|pair| self.sparse_with(sparse, *pair))
                .collect::<Result<_, _>>()?;
            let all: Vec<&Arm> = arms.iter().collect();
            let Some(trials) = self.trials(&tuning_folder(self.folder), &all, &seeds)? else {
                return Ok(None);
            };
            let entries = pairs.iter().zip(arms).zip(&trials);
            tried
                .extend(entries.map(|((pair, arm), (_, trials))| (*pair, arm, pair.entry(trials))));
            let (best, arm, chosen) = tried
                .iter()
                .min_by(|a, b| a.2.regret_iqm.total_cmp(&b.2.regret_iqm))
                .expect("the grid is not empty");
            let Some(grown) = grid.beyond(*best) else {
                return Ok(Some(Tuned {
                    arm: arm.clone(),
                    chosen: *chosen,
                    tried: tried.iter().map(|(_, _, entry)| *entry).collect(),
                    seeds,
                }));
            };
            grid = grown;
        }
    }

    fn sparse_with(&self, sparse: &Arm, sizes: StepSizes) -> Result<Arm, RunnerError> {
        let settings = sparse.settings.iter().cloned().chain(sizes.settings());
        let (path, sets) = (&self.request.path, &self.request.sets);
        let (name, text) = (sizes.arm_name(), &self.loaded.text);
        Ok(Scenario::lay_settings(
            &name,
            settings.collect(),
            path,
            text,
            sets,
        )?)
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
            Grid::first()
                .pairs()
                .iter()
                .any(|s| s.critic == default.critic_learning_rate
                    && s.actor == default.actor_learning_rate)
        );
    }

    /// Follows the best pair of a made-up world to where it is inside.
    #[test]
    fn the_grid_grows_until_the_best_is_inside() {
        let search = |regret: &dyn Fn(StepSizes) -> f64| {
            let mut grid = Grid::first();
            loop {
                let pairs = grid.pairs();
                let best = *pairs
                    .iter()
                    .min_by(|a, b| regret(**a).total_cmp(&regret(**b)))
                    .unwrap();
                match grid.beyond(best) {
                    Some(grown) => grid = grown,
                    None => return (grid, best),
                }
            }
        };
        let bowl = |critic: f64, actor: f64| {
            move |s: StepSizes| (s.critic / critic).ln().abs() + (s.actor / actor).ln().abs()
        };
        let (grid, best) = search(&bowl(0.7, 0.1));
        assert_eq!((grid, best.actor), (Grid::first(), 0.1));
        let (grid, best) = search(&bowl(0.2, 3.0));
        assert_eq!((best.critic, best.actor), (0.2, 3.0));
        assert_eq!((grid.critic, grid.actor), (0..=4, 3..=8));
        // Nothing is larger than 1 for a critic, and the list of the actor ends somewhere.
        let (grid, best) = search(&bowl(5.0, 1e9));
        assert_eq!((best.critic, best.actor), (1.0, 30.0));
        assert_eq!((grid.critic, grid.actor), (2..=4, 3..=9));
    }
}
