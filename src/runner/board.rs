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
//! | `potential/sweeps`, `potential/residual`, `potential/seconds` | fit | what the diffusion took |
//! | `potential/lowest`, `potential/highest` | fit | range of φ |
//! | `potential/phi`, `spectral/residuals` | picture | histograms of φ over states, of ‖Lv − λv‖ over pairs |
//! | `potential/map` | picture | φ on the map, where there is one |
//! | `scenario` | run | the resolved scenario |
//!
//! The step of every value is the environment step. The first three tags, `charts/SPS` and `losses/td_loss` are CleanRL's,
//! and lie over its runs. Times of day and the two rates and durations are all that equal runs do not share.
//!
//! Long runs are thinned ([`Thinning`]): all of the first 2000 episodes, every second of the next 2000 kept, and so on;
//! refreshes likewise from 1000 on, and pictures from 16. An interrupted seed begins anew, and so does this file.

use super::error::RunnerError;
use super::files::GrowingFile;
use super::places::Places;
use super::thinning::Thinning;
use crate::engine::{EpisodeRecord, RefreshRecord, ShapingPipeline};
use crate::env::layouts::{Cell, Layout};
use crate::graph::StateId;
use crate::report::png_of_values;
use crate::shaping::PotentialFit;
use crate::spectral::SpectrumRefresh;
use crate::tensorboard::{Png, Summary, write_event, write_version};
use std::collections::HashMap;
use std::hash::Hash;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// The file in the folder of a seed. TensorBoard looks for `.tfevents.`; where others put a time and a host stand 0 and
/// our name, so that the folder of a run lists the same files each time.
pub const BOARD_FILE: &str = "events.out.tfevents.0.eigentrail";

const EPISODES: u64 = 2000;
const REFRESHES: u64 = 1000;
const PICTURES: u64 = 16;

/// How long events may wait in memory.
const PATIENCE: Duration = Duration::from_secs(2);

/// The open event file of one seed.
pub(super) struct Board {
    file: GrowingFile,
    /// Records that are not in the file yet.
    waiting: Vec<u8>,
    flushed: Instant,
    begun: Instant,
    episodes: Thinning,
    refreshes: Thinning,
    pictures: Thinning,
}

impl Board {
    /// Begins the file in `folder` anew, with the text of the scenario.
    pub fn create(folder: &Path, seed: u64, scenario: &str) -> Result<Self, RunnerError> {
        let path = folder.join(BOARD_FILE);
        let now = Instant::now();
        let mut board = Self {
            file: GrowingFile::create(&path).map_err(RunnerError::write(&path))?,
            waiting: Vec::new(),
            flushed: now,
            begun: now,
            episodes: Thinning::new(EPISODES),
            refreshes: Thinning::new(REFRESHES),
            pictures: Thinning::new(PICTURES),
        };
        write_version(&mut board.waiting, seconds_since_1970());
        let mut summary = Summary::default();
        summary.text("scenario", &markdown(seed, scenario));
        board.write(0, &summary)?;
        board.flush()?;
        Ok(board)
    }

    /// An episode has ended; `regret` is that of the run so far.
    pub fn episode(&mut self, record: &EpisodeRecord, regret: f64) -> Result<(), RunnerError> {
        if !self.episodes.keeps() {
            return Ok(());
        }
        let seconds = self.begun.elapsed().as_secs_f64();
        let mut summary = Summary::default();
        for (tag, value) in [
            ("charts/episodic_return", record.plain_return),
            ("charts/episodic_length", record.length as f64),
            ("charts/shaped_return", record.shaped_return),
            ("charts/regret", regret),
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

    /// The spectrum, the potential, or both were brought up to date.
    pub fn refreshed<S: Clone + Eq + Hash>(
        &mut self,
        record: &RefreshRecord,
        pipeline: &ShapingPipeline<S>,
        places: &Places<S>,
    ) -> Result<(), RunnerError> {
        let mut summary = Summary::default();
        if self.refreshes.keeps() {
            if let Some(spectrum) = &record.spectrum {
                spectrum_scalars(&mut summary, spectrum);
                summary.scalar("spectral/seconds", record.spectrum_seconds);
            }
            if let Some(fit) = &record.fit {
                fit_scalars(&mut summary, fit);
                range_scalars(&mut summary, pipeline.potential().values());
                summary.scalar("potential/seconds", record.fit_seconds);
            }
        }
        if self.pictures.keeps() {
            picture(&mut summary, pipeline, places);
        }
        self.write(record.step, &summary)
    }

    /// The run has ended at `step`.
    pub fn finish<S: Clone + Eq + Hash>(
        mut self,
        step: u64,
        pipeline: &ShapingPipeline<S>,
        places: &Places<S>,
    ) -> Result<(), RunnerError> {
        let mut summary = Summary::default();
        picture(&mut summary, pipeline, places);
        self.write(step, &summary)?;
        self.flush()
    }

    /// Brings every record to the file.
    pub fn flush(&mut self) -> Result<(), RunnerError> {
        self.flushed = Instant::now();
        let written = self.file.append(&self.waiting);
        self.waiting.clear();
        written.map_err(RunnerError::write(self.file.path()))
    }

    fn write(&mut self, step: u64, summary: &Summary) -> Result<(), RunnerError> {
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
fn picture<S: Clone + Eq + Hash>(
    summary: &mut Summary,
    pipeline: &ShapingPipeline<S>,
    places: &Places<S>,
) {
    let phi = pipeline.potential().values();
    summary.histogram("potential/phi", phi.iter().copied());
    if let Some(pairs) = pipeline.spectrum().eigenpairs() {
        let residuals = pairs.convergence.residual_norms.iter();
        summary.histogram("spectral/residuals", residuals.copied());
    }
    if let Some(map) = &places.map
        && !phi.is_empty()
    {
        let cell = |state| (map.cell)(pipeline.graph().state(state));
        let png = png_of_potential(&map.layout, phi, cell);
        summary.image("potential/map", &png);
    }
}

fn png_of_potential(layout: &Layout, phi: &[f64], cell: impl Fn(StateId) -> Cell) -> Png {
    let states = (0..phi.len()).map(|s| StateId(s as u32));
    let values: HashMap<Cell, f64> = states.zip(phi).map(|(s, &v)| (cell(s), v)).collect();
    png_of_values(layout, |cell| values.get(&cell).copied())
}
