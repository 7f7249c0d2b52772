//! A run folder from its opening to its end: what is written around the seeds.

use super::error::RunnerError;
use super::estimate::require_memory;
use super::files::{read_json, write_json, write_text};
use super::folder::{Existing, RunFolder};
use super::run::{SeedOutcome, Watch, run_seed};
use crate::error::Error;
use crate::report::Summary;
use crate::scenario::{Loaded, Scenario};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::{Path, PathBuf};

/// What to run, and where to write it.
#[derive(Clone, Debug)]
pub struct RunRequest {
    /// Master seed.
    pub seed: u64,
    /// The run folder; `runs/NAME/TIME` if none is given.
    pub out: Option<PathBuf>,
    /// What to do if it exists.
    pub existing: Existing,
    /// The command line, for `run.json`.
    pub arguments: Vec<String>,
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct RunReport {
    /// The seed's numbers.
    pub outcome: SeedOutcome,
    /// The run folder; nobody else writes there while this is kept.
    pub folder: RunFolder,
    /// Whether the seed had been finished before and was not run again.
    pub was_finished: bool,
}

/// `run.json`: who ran what when, and how it ended.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct RunInfo {
    program: String,
    scenario: String,
    arguments: Vec<String>,
    seeds: Vec<u64>,
    status: RunStatus,
    started: String,
    ended: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum RunStatus {
    Running,
    Finished,
    Interrupted,
    Failed,
}

/// Runs one seed of a scenario into a run folder.
///
/// With [`Existing::Resume`] a seed that is finished in the folder is not run again; one that is not, begins anew.
///
/// # Errors
/// If the folder cannot be used, a file cannot be written, or the run fails.
pub fn run(
    loaded: &Loaded,
    request: &RunRequest,
    watch: &mut Watch<'_>,
) -> Result<RunReport, Error> {
    let scenario = &loaded.scenario;
    if let Ok(world) = scenario.world(request.seed) {
        require_memory(scenario, &world, 1)?;
    }
    let folder = RunFolder::open(request.out.as_deref(), loaded, request.existing)?;
    let session = Session { folder, scenario };
    let begun = session.has_begun();
    let mut summary = match begun {
        true => session.earlier()?,
        false => session.new_summary(),
    };
    if let Some((result, timing)) = summary.finished(request.seed) {
        let outcome = SeedOutcome {
            result: result.clone(),
            timing: *timing,
            steps_per_episode: Vec::new(),
        };
        return Ok(session.report(outcome, true));
    }
    let mut info = session.info(request);
    session.write_info(&info)?; // first: it makes the folder known as ours
    if !begun {
        session.write_scenario(&loaded.text)?;
    }
    let folder = session.folder.seed(request.seed);
    let ran = run_seed(scenario, request.seed, &folder, watch);
    info.ended = Some(crate::time_stamp::now());
    info.status = match &ran {
        Ok(outcome) if outcome.result.finished => RunStatus::Finished,
        Ok(_) => RunStatus::Interrupted,
        Err(_) => RunStatus::Failed,
    };
    let noted = session.write_info(&info);
    let outcome = ran?;
    noted?;
    summary.put(outcome.result.clone(), outcome.timing);
    session.write_json("summary.json", &summary)?;
    Ok(session.report(outcome, false))
}

struct Session<'a> {
    folder: RunFolder,
    scenario: &'a Scenario,
}

impl Session<'_> {
    /// Whether the folder holds a run that goes on. One that was killed before its scenario was written begins anew.
    fn has_begun(&self) -> bool {
        let has = |name: &str| self.folder.file(name).exists();
        self.folder.is_resumed() && (has("resolved.toml") || has("summary.json"))
    }

    /// The summary in the folder, if the scenario is the one that began the run; a new one if there is none yet.
    fn earlier(&self) -> Result<Summary, RunnerError> {
        let resolved = self.scenario.to_toml();
        let resolved_path = self.folder.file("resolved.toml");
        let before = read(&resolved_path)?;
        if before != resolved {
            return Err(mismatch(resolved_path, &before, &resolved));
        }
        let path = self.folder.file("summary.json");
        if !path.exists() {
            return Ok(self.new_summary());
        }
        serde_json::from_str(&read(&path)?).map_err(|error| damaged(path, &error))
    }

    fn new_summary(&self) -> Summary {
        Summary {
            scenario: self.scenario.name.clone(),
            ..Summary::default()
        }
    }

    /// The scenario as it was given, and then the one with every default.
    fn write_scenario(&self, text: &str) -> Result<(), RunnerError> {
        let path = self.folder.file("scenario.toml");
        write_text(&path, text).map_err(RunnerError::write(&path))?;
        let path = self.folder.file("resolved.toml");
        write_text(&path, &self.scenario.to_toml()).map_err(RunnerError::write(&path))
    }

    /// The present run, after the seeds that the folder knows already.
    fn info(&self, request: &RunRequest) -> RunInfo {
        let path = self.folder.file("run.json");
        let before: Option<RunInfo> = match self.folder.is_resumed() {
            true => read_json(&path).ok(),
            false => None, // it is about to be replaced
        };
        let mut seeds = before.map(|info| info.seeds).unwrap_or_default();
        seeds.push(request.seed);
        seeds.sort_unstable();
        seeds.dedup();
        RunInfo {
            program: concat!("eigentrail ", env!("CARGO_PKG_VERSION")).to_owned(),
            scenario: self.scenario.name.clone(),
            arguments: request.arguments.clone(),
            seeds,
            status: RunStatus::Running,
            started: crate::time_stamp::now(),
            ended: None,
        }
    }

    fn write_info(&self, info: &RunInfo) -> Result<(), RunnerError> {
        self.write_json("run.json", info)
    }

    fn write_json<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        value: &T,
    ) -> Result<(), RunnerError> {
        let path = self.folder.file(name);
        write_json(&path, value).map_err(RunnerError::write(&path))
    }

    fn report(&self, outcome: SeedOutcome, was_finished: bool) -> RunReport {
        RunReport {
            outcome,
            folder: self.folder.clone(),
            was_finished,
        }
    }
}

fn read(path: &Path) -> Result<String, RunnerError> {
    fs::read_to_string(path).map_err(|error| damaged(path.to_owned(), &error))
}

fn damaged(path: PathBuf, error: &dyn std::fmt::Display) -> RunnerError {
    RunnerError::Damaged {
        path,
        message: error.to_string(),
    }
}

/// Names the first line that differs.
fn mismatch(path: PathBuf, before: &str, now: &str) -> RunnerError {
    let mut old = before.lines();
    let line = now.lines().find(|&line| old.next() != Some(line));
    RunnerError::ResumeMismatch {
        path,
        line: line.or(old.next()).unwrap_or_default().to_owned(),
    }
}
