//! The event file of a seed, for TensorBoard: `events.out.tfevents.0.eigentrail`.
//!
//! | tag | at each | says |
//! |---|---|---|
//! | `charts/episodic_return`, `charts/episodic_length` | episode | Σ r, steps |
//! | `charts/shaped_return`, `charts/regret` | episode | Σ (r + F), ρ so far |
//! | `charts/SPS` | episode | environment steps per second since the run began |
//! | `losses/td_loss` | episode | mean δ² |
//! | `graph/nodes`, `graph/edges` | episode | states and undirected edges known |
//! | `spectral/applications`, `spectral/solves`, `spectral/converged`, `spectral/seconds` | refresh | what the eigensolver did |
//! | `spectral/max_relative_residual`, `spectral/lambda_2`, `spectral/lambda_k` | refresh | ‖Lv − λv‖ ÷ λ_k at worst, eigenvalues |
//! | `gcn/initial_loss`, `gcn/loss`, `gcn/epochs` | fit | the network's training |
//! | `potential/sweeps`, `potential/residual`, `potential/seconds` | fit | what the soft Bellman equation took |
//! | `potential/lowest`, `potential/highest` | fit | range of φ |
//! | `potential/phi`, `spectral/residuals` | picture | histograms of φ over states, of ‖Lv − λv‖ over pairs |
//! | `potential/map` | picture | φ on the map, where there is one |
//! | `scenario` | run | the resolved scenario |
//!
//! The step of every value is the environment step. The first three tags, `charts/SPS` and `losses/td_loss` are CleanRL's,
//! and lie over its runs. Times of day and the two rates and durations are all that equal runs do not share.
//!
//! Long runs are thinned ([`Thinning`]): all of the first 2000 episodes, every second of the next 2000 kept, and so on;
//! refreshes likewise from 1000 on, and pictures from 16. An interrupted seed goes on from a
//! checkpoint, and so does this file.

use super::map_png::png_of_values;
use super::{Png, Summary, write_event, write_version};
use crate::archive::files::GrowingFile;
use crate::archive::{ArchiveError, names};
use crate::env::layouts::Cell;
use crate::runner::{
    Episode, Knowledge, KnownMap, Refresh, RunObserver, RunStart, RunState, SavedObserver, save,
};
use crate::shaping::PotentialFit;
use crate::spectral::SpectrumRefresh;
use crate::statistics::Thinning;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

const EPISODES: u64 = 2000;
const REFRESHES: u64 = 1000;
const PICTURES: u64 = 16;

/// How long events may wait in memory.
const PATIENCE: Duration = Duration::from_secs(2);

/// Writer of the event file of one seed.
pub struct TensorBoardWriter {
    file: GrowingFile,
    /// Records that are not in the file yet.
    waiting: Vec<u8>,
    flushed: Instant,
    begun: Instant,
    episodes: Thinning,
    refreshes: Thinning,
    pictures: Thinning,
}

impl TensorBoardWriter {
    /// Begins the file in the folder of the seed anew, with the text of the scenario; or goes on with it as the seed does.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn create(start: &RunStart<'_>) -> Result<Self, ArchiveError> {
        let path = start.folder.join(names::TENSORBOARD);
        let now = Instant::now();
        if let Some(Saved {
            length,
            seconds,
            episodes,
            refreshes,
            pictures,
        }) = start.saved(NAME)
            && let Ok(file) = GrowingFile::go_on(&path, length)
        {
            return Ok(Self {
                file,
                waiting: Vec::new(),
                flushed: now,
                begun: now.checked_sub(seconds).unwrap_or(now),
                episodes,
                refreshes,
                pictures,
            });
        }
        let mut writer = Self {
            file: GrowingFile::create(&path).map_err(ArchiveError::write(&path))?,
            waiting: Vec::new(),
            flushed: now,
            begun: now,
            episodes: Thinning::new(EPISODES),
            refreshes: Thinning::new(REFRESHES),
            pictures: Thinning::new(PICTURES),
        };
        write_version(&mut writer.waiting, seconds_since_1970());
        let mut summary = Summary::default();
        summary.text("scenario", &markdown(start.seed, &start.scenario.to_toml()));
        writer.write(0, &summary)?;
        writer.flush()?;
        Ok(writer)
    }

    fn write(&mut self, step: u64, summary: &Summary) -> Result<(), ArchiveError> {
        if summary.is_empty() {
            return Ok(());
        }
        write_event(&mut self.waiting, seconds_since_1970(), step, summary);
        if self.flushed.elapsed() >= PATIENCE {
            self.flush()?;
        }
        Ok(())
    }
}

/// What a writer goes on from.
#[derive(Serialize, Deserialize)]
struct Saved {
    length: u64,
    /// Since the run began.
    seconds: Duration,
    episodes: Thinning,
    refreshes: Thinning,
    pictures: Thinning,
}

/// The writer's name in checkpoints.
const NAME: &str = "tensorboard";

impl RunObserver for TensorBoardWriter {
    fn save(&mut self) -> Result<Option<SavedObserver>, ArchiveError> {
        self.flush()?;
        let length = self.file.sync();
        let saved = Saved {
            length: length.map_err(ArchiveError::write(self.file.path()))?,
            seconds: self.begun.elapsed(),
            episodes: self.episodes.clone(),
            refreshes: self.refreshes.clone(),
            pictures: self.pictures.clone(),
        };
        Ok(save(NAME, &saved))
    }

    fn refreshed(&mut self, refresh: &Refresh<'_>) -> Result<(), ArchiveError> {
        let record = refresh.record;
        let mut summary = Summary::default();
        if self.refreshes.keeps() {
            if let Some(spectrum) = &record.spectrum {
                spectrum_scalars(&mut summary, spectrum);
                summary.scalar("spectral/seconds", record.spectrum_seconds);
            }
            if let Some(fit) = &record.fit {
                fit_scalars(&mut summary, fit);
                range_scalars(&mut summary, refresh.knowledge.potential.values());
                summary.scalar("potential/seconds", record.fit_seconds);
            }
        }
        if self.pictures.keeps() {
            picture(&mut summary, &refresh.knowledge);
        }
        self.write(record.step, &summary)
    }

    fn episode_ended(
        &mut self,
        episode: &Episode<'_>,
        _: &dyn RunState,
    ) -> Result<(), ArchiveError> {
        if !self.episodes.keeps() {
            return Ok(());
        }
        let record = episode.record;
        let seconds = self.begun.elapsed().as_secs_f64();
        let mut summary = Summary::default();
        for (tag, value) in [
            ("charts/episodic_return", record.plain_return),
            ("charts/episodic_length", record.length as f64),
            ("charts/shaped_return", record.shaped_return),
            ("charts/regret", episode.regret),
            ("charts/SPS", record.step as f64 / seconds.max(1e-9)),
            (
                "losses/td_loss",
                record.td_squares / record.length.max(1) as f64,
            ),
            ("graph/nodes", record.nodes as f64),
            ("graph/edges", record.edges as f64),
        ] {
            summary.scalar(tag, value);
        }
        self.write(record.step, &summary)
    }

    fn flush(&mut self) -> Result<(), ArchiveError> {
        self.flushed = Instant::now();
        let written = self.file.append(&self.waiting);
        self.waiting.clear();
        written.map_err(ArchiveError::write(self.file.path()))
    }

    fn ended(&mut self, run: &dyn RunState) -> Result<(), ArchiveError> {
        let mut summary = Summary::default();
        picture(&mut summary, &run.knowledge());
        self.write(run.steps(), &summary)?;
        self.flush()?;
        let synced = self.file.sync();
        synced.map_err(ArchiveError::write(self.file.path()))?;
        Ok(())
    }
}

/// The wall clock; a machine that is set to before 1970 gets 0.
fn seconds_since_1970() -> f64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0.0, |since| since.as_secs_f64())
}

/// Indented text is code in Markdown, whatever it contains.
fn markdown(seed: u64, scenario: &str) -> String {
    let code: String = scenario
        .lines()
        .map(|line| format!("    {line}\n"))
        .collect();
    format!("Seed {seed}, and the scenario with every default:\n\n{code}")
}

fn spectrum_scalars(summary: &mut Summary, spectrum: &SpectrumRefresh) {
    let convergence = &spectrum.convergence;
    for (tag, value) in [
        ("spectral/applications", convergence.applications as f64),
        ("spectral/solves", convergence.solves as f64),
        ("spectral/converged", convergence.converged as f64),
        (
            "spectral/max_relative_residual",
            convergence.max_relative_residual,
        ),
    ] {
        summary.scalar(tag, value);
    }
    let values = &spectrum.eigenvalues;
    for (tag, value) in [
        ("spectral/lambda_2", values.get(1)),
        ("spectral/lambda_k", values.last()),
    ] {
        if let Some(&value) = value {
            summary.scalar(tag, value);
        }
    }
}

fn fit_scalars(summary: &mut Summary, fit: &PotentialFit) {
    if let Some(report) = &fit.fit {
        summary.scalar("gcn/initial_loss", report.initial_loss);
        summary.scalar("gcn/loss", report.loss);
        summary.scalar("gcn/epochs", report.epochs as f64);
    }
    if let Some(solve) = &fit.solve {
        summary.scalar("potential/sweeps", solve.sweeps as f64);
        summary.scalar("potential/residual", solve.residual);
    }
}

fn range_scalars(summary: &mut Summary, phi: &[f64]) {
    let lowest = phi.iter().copied().reduce(f64::min);
    let highest = phi.iter().copied().reduce(f64::max);
    if let (Some(lowest), Some(highest)) = (lowest, highest) {
        summary.scalar("potential/lowest", lowest);
        summary.scalar("potential/highest", highest);
    }
}

/// What is drawn rather than plotted.
fn picture(summary: &mut Summary, known: &Knowledge<'_>) {
    let phi = known.potential.values();
    summary.histogram("potential/phi", phi.iter().copied());
    if let Some(pairs) = known.eigenpairs {
        let residuals = pairs.convergence.residual_norms.iter();
        summary.histogram("spectral/residuals", residuals.copied());
    }
    if let Some(map) = &known.map
        && !phi.is_empty()
    {
        summary.image("potential/map", &png_of_potential(map, known));
    }
}

fn png_of_potential(map: &KnownMap<'_>, known: &Knowledge<'_>) -> Png {
    let values: HashMap<Cell, f64> = (known.states().zip(known.potential.values()))
        .map(|(state, &value)| ((map.cell)(state), value))
        .collect();
    png_of_values(map.layout, |cell| values.get(&cell).copied())
}
