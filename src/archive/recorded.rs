//! A run folder read back: what every page and figure is made of.

use super::bounded::BoundedEpisodes;
use super::error::ArchiveError;
use super::files::read_json;
use super::folder_kind::is_run;
use super::graph_files::read_action_names;
use super::names::{self, seed_folder_name};
use super::rows::{EpisodeRow, GraphRow, PolicyRow, RefreshRow};
use super::seed_files::read_labels;
use super::snapshots::{Snapshot, read_snapshots};
use super::summary::Summary;
use crate::scenario::Scenario;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::fs;
use std::path::{Path, PathBuf};

/// Scenario and seeds of a run.
#[derive(Clone, Debug)]
pub struct RecordedRun {
    /// The folder's name.
    pub name: String,
    /// The scenario, complete.
    pub scenario: Scenario,
    /// Its text with every default.
    pub resolved: String,
    /// The command line that made it.
    pub arguments: Vec<String>,
    /// The results.
    pub summary: Summary,
    /// The seeds that have ended, ascending.
    pub seeds: Vec<RecordedSeed>,
}

/// With fewer episodes than this a recorded seed has a row for each.
const SINGLE_ROWS: usize = 200_000;

/// Tables and snapshots of one seed of a run.
#[derive(Clone, Debug, Default)]
pub struct RecordedSeed {
    /// Master seed.
    pub seed: u64,
    /// Rows of `episodes.csv`; of 200 000 and more the later ones are merged, so that they fit into memory.
    pub episodes: Vec<EpisodeRow>,
    /// Rows of `refreshes.csv`.
    pub refreshes: Vec<RefreshRow>,
    /// Frames of `snapshots.json`.
    pub snapshots: Vec<Snapshot>,
    /// Place (`row,col`) or name of each state.
    pub labels: Vec<String>,
    /// Names of the actions by number, if they are there.
    pub actions: Option<Vec<String>>,
    /// Rows of `policy.csv`.
    pub policy: Vec<PolicyRow>,
    /// Rows of `graph.csv`.
    pub graph: Vec<GraphRow>,
    /// Sums of `timings.csv`, if it is there.
    pub seconds: Option<PhaseSeconds>,
}

/// Seconds of a seed, by what took them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PhaseSeconds {
    /// In the eigensolver.
    pub spectrum: f64,
    /// In fits of the potential.
    pub fit: f64,
    /// In all episodes, what stands above included.
    pub episodes: f64,
}

/// The runs that `folder` is or holds, up to two levels below it, by name.
///
/// # Errors
/// If there is none, or one of them cannot be read.
pub fn read_runs(folder: &Path) -> Result<Vec<RecordedRun>, ArchiveError> {
    let mut found = Vec::new();
    find_runs(folder, 2, &mut found);
    if found.is_empty() {
        return Err(ArchiveError::damaged(folder, "not a run folder"));
    }
    found.iter().map(|path| RecordedRun::read(path)).collect()
}

fn find_runs(folder: &Path, depth: usize, found: &mut Vec<PathBuf>) {
    if is_run(folder) {
        found.push(folder.to_owned());
    } else if depth > 0 {
        for path in children(folder) {
            find_runs(&path, depth - 1, found);
        }
    }
}

/// The folders in `folder`, sorted.
fn children(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<_> = entries.map(|entry| entry.path()).collect();
    paths.retain(|path| path.is_dir());
    paths.sort();
    paths
}

impl RecordedRun {
    /// Reads a run folder.
    ///
    /// # Errors
    /// If it is none, no seed has ended in it, or a file does not say what it should.
    pub fn read(folder: &Path) -> Result<Self, ArchiveError> {
        let path = folder.join(names::RESOLVED);
        let resolved =
            fs::read_to_string(&path).map_err(|e| ArchiveError::damaged(&path, e.to_string()))?;
        let scenario =
            resolved_scenario(&resolved).map_err(|rule| ArchiveError::damaged(&path, rule))?;
        let path = folder.join(names::SUMMARY);
        let summary: Summary =
            read_json(&path).map_err(|e| ArchiveError::damaged(&path, e.to_string()))?;
        let seeds: Vec<_> = summary
            .seeds
            .iter()
            .map(|result| {
                let name = seed_folder_name(result.seed);
                RecordedSeed::read(&folder.join(name), result.seed)
            })
            .collect::<Result<_, _>>()?;
        if seeds.is_empty() {
            return Err(ArchiveError::damaged(
                folder,
                "no seed of this run has ended yet",
            ));
        }
        let name = folder.file_name().unwrap_or(folder.as_os_str());
        Ok(Self {
            name: name.to_string_lossy().into_owned(),
            scenario,
            resolved,
            arguments: arguments(folder),
            summary,
            seeds,
        })
    }
}

impl RecordedSeed {
    /// The number of the last episode that each row stands for, from 1.
    pub fn ends(&self) -> Vec<usize> {
        let add = |sum: &mut usize, row: &EpisodeRow| {
            *sum += row.episodes;
            Some(*sum)
        };
        self.episodes.iter().scan(0, add).collect()
    }

    /// How many episodes its rows stand for.
    pub fn num_episodes(&self) -> usize {
        self.episodes.iter().map(|row| row.episodes).sum()
    }

    fn read(folder: &Path, seed: u64) -> Result<Self, ArchiveError> {
        Ok(Self {
            episodes: episodes(folder)?,
            refreshes: table(folder, names::REFRESHES)?,
            seconds: seconds(folder),
            ..Self::read_sights(folder, seed)?
        })
    }

    /// Reads what stands on maps: states, snapshots, actions, policy and graph.
    ///
    /// # Errors
    /// If `folder` does not hold a finished seed.
    pub fn read_sights(folder: &Path, seed: u64) -> Result<Self, ArchiveError> {
        Ok(Self {
            seed,
            snapshots: read_snapshots(folder)?,
            labels: read_labels(folder)?,
            actions: read_action_names(folder)?,
            policy: table(folder, names::POLICY)?,
            graph: table(folder, names::GRAPH)?,
            ..Self::default()
        })
    }
}

/// The scenario of a run as it was written down, which somebody may have changed since.
pub(super) fn resolved_scenario(text: &str) -> Result<Scenario, String> {
    let scenario: Scenario = toml::from_str(text).map_err(|error| error.message().to_owned())?;
    match scenario.validate_sections() {
        Ok(()) => Ok(scenario),
        Err(rule) => Err(rule.message),
    }
}

/// What `run.json` says about the command line; nothing if it says nothing.
fn arguments(folder: &Path) -> Vec<String> {
    #[derive(Deserialize)]
    struct Info {
        arguments: Vec<String>,
    }
    read_json::<Info>(&folder.join(names::RUN)).map_or(Vec::new(), |info| info.arguments)
}

/// Sums of `timings.csv`; nothing if it is gone.
fn seconds(folder: &Path) -> Option<PhaseSeconds> {
    #[derive(Deserialize)]
    struct Row {
        what: String,
        seconds: f64,
    }
    let mut sums = PhaseSeconds::default();
    let mut reader = csv::Reader::from_path(folder.join(names::TIMINGS)).ok()?;
    for row in reader.deserialize() {
        let row: Row = row.ok()?;
        match row.what.as_str() {
            "spectrum_refresh" => sums.spectrum += row.seconds,
            "gcn_fit" => sums.fit += row.seconds,
            "episode" => sums.episodes += row.seconds,
            _ => {}
        }
    }
    Some(sums)
}

/// Reads `episodes.csv` row by row.
fn episodes(folder: &Path) -> Result<Vec<EpisodeRow>, ArchiveError> {
    rows(folder, names::EPISODES, |reader| {
        let mut bounded = BoundedEpisodes::new(SINGLE_ROWS / 2);
        for row in reader.deserialize() {
            bounded.push(row?);
        }
        Ok(bounded.into_rows())
    })
}

fn table<T: DeserializeOwned>(folder: &Path, name: &str) -> Result<Vec<T>, ArchiveError> {
    rows(folder, name, |reader| reader.deserialize().collect())
}

fn rows<T>(
    folder: &Path,
    name: &str,
    read: impl FnOnce(&mut csv::Reader<fs::File>) -> csv::Result<Vec<T>>,
) -> Result<Vec<T>, ArchiveError> {
    let path = folder.join(name);
    csv::Reader::from_path(&path)
        .and_then(|mut reader| read(&mut reader))
        .map_err(|error| ArchiveError::damaged(&path, error.to_string()))
}
