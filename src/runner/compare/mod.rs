//! Arms × seeds of one scenario, side by side.
//!
//! ```text
//! runs/four_rooms/2026-11-21T22-05-00Z-compare/
//!   arms.json       what is compared: arms with their settings, seeds, the command line
//!   scenario.toml   the scenario as it was given
//!   arms/gcn/       resolved.toml, and seed-1000.json as soon as that seed has ended
//!   tuning/…        the same for the step sizes tried for the sparse arm
//!   arms/gcn/seed-1000/   graph, policy and snapshots of the first seed
//!   compare.json    the numbers; what a clock said stands in `timing`
//!   compare.csv     a row for each arm and seed, without a clock;  timings.csv  the same with one
//!   report.html     all of it to look at
//! ```
//!
//! A trial that has ended is never run again in the same folder, as long as its arm's resolved scenario is the same:
//! each file carries a hash of it. So an interrupted comparison goes on where it was, and arms and seeds can be added.

pub(super) mod summarise;
pub(super) mod trials;
mod tuning;

use super::build::warn_of_file;
use super::error::RunnerError;
use super::estimate::require_memory;
use super::optimal_returns::KnownOptima;
use crate::archive::{
    Compared, Comparison, Existing, FolderKind, RunFolder, TrialRecord, TrialsByArm, Tuning,
    begin_comparison, names, write_comparison,
};
use crate::scenario::{Arm, BASELINE, Choices, DEFAULT_ARM, Loaded, Scenario};
use crate::time_stamp;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use summarise::{differences, mean_over, regret_interval, summarise, timing};
use tuning::tuning_trials;

/// Request for a comparison: what to compare, and where to write it.
#[derive(Clone, Debug)]
pub struct CompareRequest {
    /// The scenario file, for messages and relative paths.
    pub path: PathBuf,
    /// Assignments laid over every arm; an arm's own settings win.
    pub sets: Vec<String>,
    /// Master seeds, without duplicates; at least one.
    pub seeds: Vec<u64>,
    /// Names of arms, without duplicates; at least one.
    pub arms: Vec<String>,
    /// Whether to compare with a sparse arm tuned for the world, too.
    pub tuned: bool,
    /// The folder; `runs/NAME/TIME-compare` if none is given.
    pub out: Option<PathBuf>,
    /// What to do if it exists.
    pub existing: Existing,
    /// The command line, for `arms.json`.
    pub arguments: Vec<String>,
}

/// Observer of a comparison, and the flag that stops it.
#[derive(Clone, Copy)]
pub struct CompareWatch<'a> {
    /// Set from anywhere: trials under way are given up, no new ones begin.
    pub stop: &'a AtomicBool,
    /// Told of each trial as it ends: the arm's name and what came of it.
    pub on_trial: &'a (dyn Fn(&str, &TrialRecord) + Sync),
}

/// Numbers of a comparison, and its folder.
#[derive(Clone, Debug)]
pub struct CompareOutcome {
    /// Its numbers; none if it was stopped before every trial had ended.
    pub comparison: Option<Comparison>,
    /// Its folder; nobody else writes there while this is kept.
    pub folder: RunFolder,
}

impl CompareRequest {
    /// How many trials it takes, those that a folder holds already included.
    pub fn num_trials(&self) -> usize {
        let extra = usize::from(!self.arms.iter().any(|arm| arm == BASELINE));
        let tuned = usize::from(self.tuned);
        (self.arms.len() + extra + tuned) * self.seeds.len() + tuned * tuning_trials()
    }
}

/// Compares arms over seeds. All arms see the same worlds: a seed draws slips, starts and the agent's choices from
/// streams of their own. Results do not depend on the number of threads.
///
/// # Errors
/// If an arm does not exist or does not go with the scenario, the folder cannot be used, or a trial fails; trials
/// that have ended by then are on disk.
///
/// # Panics
/// If there are no arms or no seeds.
pub fn compare(
    loaded: &Loaded,
    request: &CompareRequest,
    watch: CompareWatch<'_>,
) -> Result<CompareOutcome, RunnerError> {
    assert!(!request.seeds.is_empty() && !request.arms.is_empty());
    require_known(&request.arms, &loaded.scenario)?;
    let lay = |name: &str| lay_arm(name, request, loaded);
    let arms = request.arms.iter().map(|name| lay(name));
    let arms: Vec<Arm> = arms.collect::<Result<_, _>>()?;
    let sparse = lay(BASELINE)?;
    let at_once = rayon::current_num_threads().min(request.num_trials());
    for arm in arms.iter().chain([&sparse]) {
        require_memory(&arm.scenario, loaded.worlds.first(), at_once)?;
    }
    warn_of_file(&loaded.worlds, arms.iter().map(|arm| &arm.scenario));
    let kind = FolderKind::Comparison;
    let folder = RunFolder::open_kind(kind, request.out.as_deref(), loaded, request.existing)?;
    let field = Field {
        loaded,
        request,
        watch,
        folder: folder.path(),
        optimal: KnownOptima::default(),
    };
    begin_comparison(folder.path(), &field.compared(&arms), &loaded.text)?;
    let comparison = field.run(arms, sparse)?;
    if let Some((comparison, trials)) = &comparison {
        write_comparison(folder.path(), comparison, trials)?;
    }
    Ok(CompareOutcome {
        comparison: comparison.map(|(comparison, _)| comparison),
        folder,
    })
}

fn lay_arm(name: &str, request: &CompareRequest, loaded: &Loaded) -> Result<Arm, RunnerError> {
    let scenario = &loaded.scenario;
    let laid = scenario.lay_arm(name, &request.path, &loaded.text, &request.sets)?;
    laid.ok_or_else(|| unknown_arms([name], scenario))
}

/// Refuses all names at once that no arm has.
fn require_known(names: &[String], scenario: &Scenario) -> Result<(), RunnerError> {
    let is_known = |name: &str| scenario.arm_names().any(|(known, _)| known == name);
    let strange: Vec<&str> = names
        .iter()
        .map(String::as_str)
        .filter(|name| !is_known(name))
        .collect();
    match strange.is_empty() {
        true => Ok(()),
        false => Err(unknown_arms(strange, scenario)),
    }
}

pub(super) fn unknown_arms<'a>(
    names: impl IntoIterator<Item = &'a str>,
    scenario: &Scenario,
) -> RunnerError {
    let with_choices = names.into_iter().map(|name| {
        let known = scenario.arm_names().map(|(known, _)| known.to_owned());
        (name.to_owned(), Choices::near(name, known.collect()))
    });
    RunnerError::UnknownArms(with_choices.collect())
}

/// The arm that the others are shown against: the default one, or the first.
fn reference(arms: &[Arm]) -> &str {
    let default = arms.iter().find(|arm| arm.name == DEFAULT_ARM);
    &default.unwrap_or(&arms[0]).name
}

/// A comparison under way.
struct Field<'a> {
    loaded: &'a Loaded,
    request: &'a CompareRequest,
    watch: CompareWatch<'a>,
    folder: &'a Path,
    /// Worked out by the first trial that needs it: no arm has a part in it.
    optimal: KnownOptima,
}

impl Field<'_> {
    /// What is compared.
    fn compared(&self, arms: &[Arm]) -> Compared {
        Compared {
            program: concat!("eigentrail ", env!("CARGO_PKG_VERSION")).to_owned(),
            scenario: self.loaded.scenario.name.clone(),
            arguments: self.request.arguments.clone(),
            seeds: self.request.seeds.clone(),
            tuned: self.request.tuned,
            arms: arms
                .iter()
                .map(|arm| (arm.name.clone(), arm.settings.clone()))
                .collect(),
            started: time_stamp::now(),
        }
    }

    /// Runs everything; none if it was stopped.
    fn run(
        &self,
        arms: Vec<Arm>,
        sparse: Arm,
    ) -> Result<Option<(Comparison, TrialsByArm)>, RunnerError> {
        let seeds = &self.request.seeds;
        let tuned = match self.request.tuned {
            true => match self.tune(&sparse)? {
                Some(tuned) => Some(tuned),
                None => return Ok(None),
            },
            false => None,
        };
        // The sparse arm takes longest, so it goes first.
        let mut all: Vec<&Arm> = vec![&sparse];
        all.extend(tuned.as_ref().map(|tuned| &tuned.arm));
        all.extend(arms.iter().filter(|arm| arm.name != BASELINE));
        let Some(trials) = self.trials(&self.folder.join(names::ARMS_FOLDER), &all, seeds)? else {
            return Ok(None);
        };
        let of = |name: &str| {
            let found = trials.iter().find(|(arm, _)| arm == name);
            found.map(|(_, trials)| trials.as_slice())
        };
        let sparse_trials = of(BASELINE).expect("the sparse arm was run");
        let tuned_trials = tuned.as_ref().and_then(|tuned| of(&tuned.arm.name));
        let summary = |arm: &Arm| {
            let trials = of(&arm.name).expect("every arm was run");
            summarise(&arm.name, trials, sparse_trials, tuned_trials)
        };
        let clock = |arm: &Arm| timing(&arm.name, of(&arm.name).expect("every arm was run"));
        let comparison = Comparison {
            scenario: self.loaded.scenario.name.clone(),
            seeds: seeds.clone(),
            arms: arms.iter().map(summary).collect(),
            episodes: self.loaded.scenario.run.episodes,
            optimal_steps: mean_over(sparse_trials, |result| result.optimal_steps),
            optimal_return: mean_over(sparse_trials, |result| result.optimal_return),
            goals_moved_after: sparse_trials[0].result.goals_moved_after,
            sparse_regret: regret_interval(sparse_trials),
            differences: differences(reference(&arms), &trials),
            tuning: tuned.zip(tuned_trials).map(|(tuned, trials)| Tuning {
                seeds: tuned.seeds,
                tried: tuned.tried,
                chosen: tuned.chosen,
                regret: regret_interval(trials),
            }),
            timing: arms.iter().map(clock).collect(),
        };
        Ok(Some((comparison, trials)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_arm_is_corrected_by_all_there_are() {
        let text = "[arms.steep]\nbase = \"gcn\"\nshaping.scale_factor = 8.0\n";
        let loaded = Scenario::parse(Path::new("x.toml"), text.to_owned(), &[]).unwrap();
        let request = CompareRequest {
            path: PathBuf::from("x.toml"),
            sets: Vec::new(),
            seeds: vec![0],
            arms: vec![],
            tuned: false,
            out: None,
            existing: Existing::Refuse,
            arguments: Vec::new(),
        };
        let refused = |name: &str| lay_arm(name, &request, &loaded).unwrap_err().to_string();
        assert_eq!(
            refused("plannner"),
            "--arms: there is no arm `plannner`; did you mean `planner`?"
        );
        let names = ["gnc", "heat", "plannner"].map(str::to_owned);
        let all = require_known(&names, &loaded.scenario).unwrap_err();
        assert_eq!(
            all.to_string(),
            "--arms: there is no arm `gnc`; did you mean `gcn`?\n\
             --arms: there is no arm `plannner`; did you mean `planner`?"
        );
        assert!(refused("stepe").ends_with("did you mean `steep`?"));
        assert!(refused("xyz").contains("sparse"));
        assert!(lay_arm("steep", &request, &loaded).is_ok());
    }
}
