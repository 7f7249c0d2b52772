//! Arms × seeds: each pair is run once and its numbers kept in a file of its own.
//!
//! Nothing is logged by the step, so that the long runs of weak arms go at the speed of the loop. One seed of each arm
//! leaves, at its end, what its page needs to draw φ, the eigenvectors and the policy.

use super::Field;
use crate::archive::checkpoint::{self, without_intervals};
use crate::archive::{
    ArchiveError, Existing, SeedResult, TrialRecord, TrialResult, TrialsByArm, begin_arm,
    scenario_hash, seed_folder_name, trial_file_name,
};
use crate::disk;
use crate::runner::checkpoints::Checkpoints;
use crate::runner::error::RunnerError;
use crate::runner::observer::Observers;
use crate::runner::parallel_map::parallel_map;
use crate::runner::seed_writer::SightsWriter;
use crate::runner::trial::{self, Trial};
use crate::scenario::Arm;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

impl Field<'_> {
    /// Arms × seeds below `folder`, those found there not run again; none if stopped.
    pub(super) fn trials(
        &self,
        folder: &Path,
        arms: &[&Arm],
        seeds: &[u64],
    ) -> Result<Option<TrialsByArm>, RunnerError> {
        let begin = |arm: &&Arm| {
            let resolved = arm.scenario.to_toml();
            begin_arm(&folder.join(&arm.name), &resolved)?;
            Ok(scenario_hash(&without_intervals(&resolved)))
        };
        let hashes: Vec<String> = arms
            .iter()
            .map(begin)
            .collect::<Result<_, ArchiveError>>()?;
        let jobs: Vec<(usize, u64)> = (0..arms.len())
            .flat_map(|arm| seeds.iter().map(move |&seed| (arm, seed)))
            .collect();
        let done = parallel_map(&jobs, |&(arm, seed)| {
            let (arm, hash) = (arms[arm], &hashes[arm]);
            self.trial(&folder.join(&arm.name), arm, hash, seed)
        })?;
        let Some(done) = done.into_iter().collect::<Option<Vec<TrialRecord>>>() else {
            return Ok(None);
        };
        let by_arm = arms.iter().zip(done.chunks(seeds.len()));
        let named = by_arm.map(|(arm, trials)| (arm.name.clone(), trials.to_vec()));
        Ok(Some(named.collect()))
    }

    fn trial(
        &self,
        folder: &Path,
        arm: &Arm,
        hash: &str,
        seed: u64,
    ) -> Result<Option<TrialRecord>, RunnerError> {
        let path = folder.join(trial_file_name(seed));
        let seed_folder = folder.join(seed_folder_name(seed));
        let first = seed == self.request.seeds[0];
        let keep = first.then_some(seed_folder.as_path());
        // Until its record is on the disk, a trial has not ended.
        let remove_checkpoints = || {
            checkpoint::remove(&seed_folder)?;
            if keep.is_none() {
                let _ = disk::remove_folder(&seed_folder); // there for checkpoints alone; whoever put more into it keeps it
            }
            Ok::<_, RunnerError>(())
        };
        if let Some(trial) = TrialRecord::finished(&path, hash) {
            remove_checkpoints()?; // a kill may have come before they were removed
            (self.watch.on_trial)(&arm.name, &trial);
            return Ok(Some(trial));
        }
        if self.watch.stop.load(Ordering::Relaxed) {
            return Ok(None); // before the optimum is worked out, which may take its time
        }
        let (scenario, worlds) = (&arm.scenario, &self.loaded.worlds);
        let mut checkpoints = Checkpoints::new(scenario, seed, &seed_folder);
        let resumed = match self.request.existing {
            Existing::Resume => checkpoints
                .go_on(|checkpoint| trial::resume(scenario, worlds, seed, &checkpoint.run)),
            _ => None,
        };
        let (resumed, mut trial) = match resumed {
            Some((checkpoint, trial)) => (Some(checkpoint), trial),
            None => {
                let optimal = self.optimal.of(worlds, seed);
                (None, trial::begin(scenario, worlds, optimal, seed)?)
            }
        };
        let sights = keep.map(|folder| match &resumed {
            Some(checkpoint) => SightsWriter::go_on(folder, checkpoint),
            None => SightsWriter::new(folder),
        });
        drop(resumed); // as large as the trial itself
        let stop = self.watch.stop;
        let Some(trial) = record(&mut *trial, hash, sights, stop, Some(&mut checkpoints))? else {
            return Ok(None);
        };
        trial.write(&path)?;
        remove_checkpoints()?;
        (self.watch.on_trial)(&arm.name, &trial);
        Ok(Some(trial))
    }
}

/// Plays every episode of a trial; none if `stop` was set before the last one ended. What `sights` has seen is written at the end.
pub fn record(
    trial: &mut dyn Trial,
    hash: &str,
    sights: Option<SightsWriter>,
    stop: &AtomicBool,
    checkpoints: Option<&mut Checkpoints<'_>>,
) -> Result<Option<TrialRecord>, RunnerError> {
    let mut observers: Observers<'_> = Vec::new();
    if let Some(sights) = sights {
        observers.push(Box::new(sights));
    }
    trial::play(trial, stop, &mut observers, checkpoints)?;
    if !trial.sums().is_complete() {
        return Ok(None);
    }
    let timing = trial.sums().timing(trial.steps());
    for observer in &mut observers {
        observer.ended(trial)?;
    }
    Ok(Some(TrialRecord {
        hash: hash.to_owned(),
        result: result(trial)?,
        curve: trial.sums().curve(),
        timing,
    }))
}

/// The results of a trial that has ended.
fn result(trial: &dyn Trial) -> Result<TrialResult, RunnerError> {
    let sums = trial.sums();
    let best = sums.best();
    let (final_return, final_steps) = (sums.final_return(), sums.final_steps());
    let greedy = trial.greedy_returns();
    let SeedResult {
        seed,
        episodes,
        steps,
        regret,
        optimal_steps,
        final_mean_steps,
        goals_moved_after,
        first_goal_step,
        nodes,
        edges,
        spectrum_refreshes,
        gcn_fits,
        ..
    } = trial.result();
    Ok(TrialResult {
        seed,
        episodes,
        steps,
        regret,
        optimal_steps,
        final_mean_steps,
        optimal_return: best.optimum.expected_return,
        final_return,
        final_ratio: best.ratio(final_return, final_steps),
        greedy_return: greedy.advised,
        greedy_return_unadvised: greedy.unadvised,
        failed: greedy.advised.map(|earned| best.fails(earned)),
        failed_unadvised: greedy.unadvised.map(|earned| best.fails(earned)),
        goals_moved_after,
        first_goal_step,
        within_1_5x: sums.within_1_5x(),
        within_1_1x: sums.within_1_1x(),
        nodes,
        edges,
        spectrum_refreshes,
        gcn_fits,
        gcn_epochs: sums.gcn_epochs(),
        spurious_maxima: trial.spurious_maxima(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runner::optimal_returns::OptimalReturns;
    use crate::scenario::{Loaded, Scenario};

    fn run_trial(
        loaded: &Loaded,
        seed: u64,
        keep: Option<&Path>,
        stop: &AtomicBool,
    ) -> Option<TrialRecord> {
        let optimal = OptimalReturns::of(&loaded.worlds, seed);
        let mut trial = trial::begin(&loaded.scenario, &loaded.worlds, optimal, seed).unwrap();
        let sights = keep.map(SightsWriter::new);
        record(&mut *trial, "", sights, stop, None).unwrap()
    }

    #[test]
    fn a_trial_agrees_with_the_world_and_stops_when_told() {
        let text = "[env]\nrows = 4\ncols = 4\n[run]\nepisodes = 40\n";
        let loaded = Scenario::parse(Path::new("x.toml"), text.to_owned(), &[]).unwrap();
        let go_on = AtomicBool::new(false);
        let folder = tempfile::tempdir().unwrap();
        let TrialRecord {
            result,
            curve,
            timing,
            ..
        } = run_trial(&loaded, 5, None, &go_on).unwrap();
        assert_eq!(curve.episodes.last(), Some(&40));
        assert_eq!(curve.regret.last(), Some(&result.regret));
        assert_eq!(curve.length.iter().sum::<f64>(), result.steps as f64);
        assert_eq!(result.optimal_steps, 6.0);
        // −1 a step, 0 for the one that enters the goal: regret is exactly the steps beyond the shortest path.
        assert_eq!(result.regret, result.steps as f64 - 40.0 * 6.0);
        assert_eq!(result.spurious_maxima, Some(0));
        assert_eq!(result.greedy_return, Some(result.optimal_return));
        assert_eq!(result.failed, Some(false));
        assert!(result.first_goal_step.unwrap() >= 6);
        assert!(timing.wall_seconds >= timing.spectrum_seconds + timing.fit_seconds);
        let kept = run_trial(&loaded, 5, Some(folder.path()), &go_on);
        assert_eq!(kept.unwrap().result, result);
        assert!(folder.path().join("snapshots.json").is_file());
        let stop = AtomicBool::new(true);
        assert!(run_trial(&loaded, 5, None, &stop).is_none());
    }

    fn greedy(text: &str) -> TrialResult {
        let loaded = Scenario::parse(Path::new("x.toml"), text.to_owned(), &[]).unwrap();
        let trial = run_trial(&loaded, 5, None, &AtomicBool::new(false));
        trial.unwrap().result
    }

    /// A corridor of which the agent knows the first cell or two: its greedy policy bumps into the upper wall for ever.
    #[test]
    fn a_policy_that_was_not_learnt_earns_what_its_first_action_earns() {
        let text = "[env]\nrows = 1\ncols = 9\nmax_steps = 3\n[agent]\nkind = \"q-learning\"\n[shaping]\npotential = \"none\"\n\
                    [exploration]\nkind = \"none\"\n[run]\nepisodes = 60\n";
        let lost = greedy(text);
        assert_eq!(lost.greedy_return, Some(-3.0), "{lost:?}");
        assert_eq!(lost.greedy_return_unadvised, lost.greedy_return);
        let far = greedy(&text.replace("= 3", "= 20"));
        assert_eq!(far.greedy_return, Some(-8.0), "{far:?}");
        assert_eq!((lost.failed, far.failed), (Some(false), Some(false)));
    }

    /// Without learning, advice alone leads to the goal; and nothing leads an agent that has no preferences.
    #[test]
    fn advice_is_told_from_what_was_learnt() {
        let text = "[env]\nrows = 4\ncols = 4\n[exploration]\npotential_advice = 20\noptimism = \"seen-goals\"\n\
                    [agent]\nkind = \"actor-critic\"\nactor_learning_rate = 1e-9\ncritic_learning_rate = 1e-9\n\
                    [shaping]\nmix = 0\n[run]\nepisodes = 60\n";
        let advised = greedy(text);
        assert_eq!(advised.failed, Some(false), "{advised:?}");
        assert_eq!(advised.failed_unadvised, Some(true), "{advised:?}");
        let random = greedy(&text.replace("\"actor-critic\"", "\"random\""));
        assert_eq!((random.greedy_return, random.failed), (None, None));
    }

    #[test]
    fn a_richer_goal_is_found_behind_the_nearest() {
        let trial = |seed: u64, more: &str| {
            let sets = ["run.episodes=200", "shaping.potential=heat", more].map(str::to_owned);
            let loaded = Scenario::load(Path::new("rewarded_goals"), &sets).unwrap();
            let trial = run_trial(&loaded, seed, None, &AtomicBool::new(false));
            trial.unwrap().result
        };
        for seed in 0..3 {
            let settled = trial(seed, "exploration.reward_search_share=0");
            let found = trial(seed, "run.seed=0");
            assert!(found.regret < 0.5 * settled.regret, "{found:?} {settled:?}");
            let length = found.final_mean_steps;
            assert!(length > 1.5 * settled.final_mean_steps, "{found:?}");
        }
    }

    #[test]
    fn a_goal_that_moves_is_measured_by_its_present_place() {
        let text = "[env]\nrows = 4\ncols = 5\nmoved_goals = [{ at = \"top-right\" }]\ngoals_move_after = 60\n[run]\nepisodes = 100\n";
        let loaded = Scenario::parse(Path::new("x.toml"), text.to_owned(), &[]).unwrap();
        let go_on = AtomicBool::new(false);
        let result = run_trial(&loaded, 5, None, &go_on).unwrap().result;
        assert_eq!(result.goals_moved_after, Some(60));
        assert_eq!(result.optimal_steps, 4.0);
        assert_eq!(
            result.regret,
            result.steps as f64 - (60.0 * 7.0 + 40.0 * 4.0)
        );
        let first = result
            .within_1_5x
            .expect("a field of 20 cells is soon known");
        assert!(first.episodes >= 20 && first.episodes <= 40, "{first:?}");
        assert!(first.steps < result.steps - 60 * 7, "{first:?}");
        assert!(result.final_mean_steps < 1.5 * 4.0, "{result:?}");
    }
}
