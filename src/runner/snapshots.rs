//! φ and the first eigenvectors through the refreshes: few enough frames to look at, as `snapshots.json`.
//!
//! Every `stride`-th refresh leaves a frame. Whenever the frames become too many, every second one is dropped and the
//! stride doubles, so that what remains is spread over the whole run, whatever its length. Nothing is done between
//! refreshes, and no clock is read: equal runs leave equal bytes.

use super::error::RunnerError;
use super::files::{read_json, write_compact_json};
use crate::engine::ShapingPipeline;
use serde::{Deserialize, Serialize};
use std::hash::Hash;
use std::path::Path;

/// The file in the folder of a seed.
const FILE: &str = "snapshots.json";

/// Frames kept, the last state of the run not counted.
const MAX_FRAMES: usize = 39;

/// Numbers kept in all frames together; larger graphs have fewer frames.
const MAX_NUMBERS: usize = 1_000_000;

/// Eigenvectors kept: from the second on, because the first is the same everywhere up to degrees.
const VECTORS: std::ops::Range<usize> = 1..5;

/// What was known at one moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Environment steps taken before it.
    pub step: u64,
    /// States known.
    pub nodes: usize,
    /// Undirected edges known.
    pub edges: usize,
    /// φ by state number, to four digits.
    pub potential: Vec<f32>,
    /// The lowest eigenvalues, ascending; empty before the first spectrum.
    pub eigenvalues: Vec<f64>,
    /// The second to fifth eigenvector by state number, scaled by √n, to four digits, each with the sign that agrees
    /// best with the frame before; may be shorter than `potential` by the states found since the last spectrum.
    pub vectors: Vec<Vec<f32>>,
}

/// Collects the frames of one seed.
#[derive(Clone, Debug)]
pub struct Snapshots {
    frames: Vec<Snapshot>,
    stride: usize,
    refreshes: usize,
}

impl Default for Snapshots {
    fn default() -> Self {
        Self {
            frames: Vec::new(),
            stride: 1,
            refreshes: 0,
        }
    }
}

impl Snapshots {
    /// A refresh has happened at `step`. O(states) for those that are kept, O(1) for the others.
    pub fn refreshed<S: Clone + Eq + Hash>(&mut self, step: u64, pipeline: &ShapingPipeline<S>) {
        let number = self.refreshes;
        self.refreshes += 1;
        if number.is_multiple_of(self.stride) {
            self.push(step, pipeline);
            self.thin();
        }
    }

    /// Adds the end of the run, and writes all frames into the seed's `folder`.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn finish<S: Clone + Eq + Hash>(
        mut self,
        step: u64,
        pipeline: &ShapingPipeline<S>,
        folder: &Path,
    ) -> Result<(), RunnerError> {
        self.push(step, pipeline);
        let path = folder.join(FILE);
        write_compact_json(&path, &self.frames).map_err(RunnerError::write(&path))
    }

    /// The frames so far, and how things stand at `step`.
    pub(super) fn up_to_now<S: Clone + Eq + Hash>(
        &self,
        step: u64,
        pipeline: &ShapingPipeline<S>,
    ) -> Vec<Snapshot> {
        let now = Snapshot::of(step, pipeline, self.frames.last());
        self.frames.iter().cloned().chain([now]).collect()
    }

    fn push<S: Clone + Eq + Hash>(&mut self, step: u64, pipeline: &ShapingPipeline<S>) {
        let frame = Snapshot::of(step, pipeline, self.frames.last());
        self.frames.push(frame);
    }

    fn thin(&mut self) {
        let numbers: usize = self.frames.iter().map(Snapshot::numbers).sum();
        let too_many = self.frames.len() > MAX_FRAMES || numbers > MAX_NUMBERS;
        if too_many && self.frames.len() > 1 {
            let mut number = 0;
            self.frames.retain(|_| {
                number += 1;
                number % 2 == 1
            });
            self.stride *= 2;
        }
    }
}

impl Snapshot {
    fn of<S: Clone + Eq + Hash>(
        step: u64,
        pipeline: &ShapingPipeline<S>,
        before: Option<&Self>,
    ) -> Self {
        let graph = pipeline.transitions();
        let nodes = graph.num_states();
        let mut potential: Vec<f32> = rounded(pipeline.potential().values().iter().copied());
        potential.resize(nodes, 0.0);
        let pairs = pipeline.spectrum().eigenpairs();
        let vectors = pairs.map_or(Vec::new(), |pairs| {
            let (rows, columns) = pairs.vectors.shape();
            let before = |k| before.and_then(|frame| frame.vectors.get(k));
            VECTORS
                .take_while(|&k| k < columns)
                .enumerate()
                .map(|(place, k)| {
                    let column: Vec<f64> = (0..rows).map(|row| pairs.vectors[(row, k)]).collect();
                    let scale = (rows as f64).sqrt() * sign(&column, before(place));
                    rounded(column.iter().map(|entry| entry * scale))
                })
                .collect()
        });
        Self {
            step,
            nodes,
            edges: graph.adjacency().num_edges(),
            potential,
            eigenvalues: pairs.map_or(Vec::new(), |pairs| pairs.values.clone()),
            vectors,
        }
    }

    fn numbers(&self) -> usize {
        self.potential.len() + self.vectors.iter().map(Vec::len).sum::<usize>()
    }
}

/// −1 if `column` points away from the vector of the frame before, so that pictures do not flicker; else 1. Features
/// are aligned by a rotation instead, which is better for learning, but mixes the eigenvectors.
fn sign(column: &[f64], before: Option<&Vec<f32>>) -> f64 {
    let product: f64 = before.map_or(0.0, |before| {
        let pairs = column.iter().zip(before);
        pairs.map(|(now, &then)| now * f64::from(then)).sum()
    });
    if product < 0.0 { -1.0 } else { 1.0 }
}

/// Four digits of each value: enough for any colour.
fn rounded(values: impl Iterator<Item = f64>) -> Vec<f32> {
    values
        .map(|value| {
            let magnitude = libm::log10(value.abs().max(1e-9)).floor() as i32;
            let unit = 10_f64.powi(magnitude - 3);
            ((value / unit).round() * unit) as f32
        })
        .collect()
}

/// The frames that a seed has left in its folder.
///
/// # Errors
/// If there is no such file, or it does not hold frames.
pub fn read_snapshots(folder: &Path) -> Result<Vec<Snapshot>, RunnerError> {
    let path = folder.join(FILE);
    read_json(&path).map_err(|error| RunnerError::Damaged {
        path,
        message: error.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::PipelineParams;
    use crate::env::{Action, Step, StepStatus};

    fn walked(steps: u32) -> ShapingPipeline<u32> {
        let params = PipelineParams {
            gamma: 1.0,
            ..PipelineParams::default()
        };
        let mut pipeline = ShapingPipeline::new(&params, 1, None, 0).unwrap();
        pipeline.begin_episode(&0);
        for state in 1..=steps {
            let step = Step {
                state,
                reward: -1.0,
                status: StepStatus::Running,
            };
            pipeline.observe(Action(0), &step).unwrap();
        }
        pipeline
    }

    #[test]
    fn frames_are_few_and_spread_over_the_whole_run() {
        let pipeline = walked(3);
        let mut snapshots = Snapshots::default();
        for step in 0..1000 {
            snapshots.refreshed(step, &pipeline);
            assert!(snapshots.frames.len() <= MAX_FRAMES);
        }
        let steps: Vec<u64> = snapshots.frames.iter().map(|f| f.step).collect();
        assert!(steps.len() > MAX_FRAMES / 2);
        assert!(
            steps
                .windows(2)
                .all(|w| w[1] - w[0] == snapshots.stride as u64)
        );
        assert_eq!(steps[0], 0);
    }

    #[test]
    fn frames_come_back_as_they_went() {
        let folder = tempfile::tempdir().unwrap();
        let pipeline = walked(5);
        let snapshots = Snapshots::default();
        snapshots.finish(5, &pipeline, folder.path()).unwrap();
        let mut frames = read_snapshots(folder.path()).unwrap();
        let mut written = Snapshot::of(5, &pipeline, None);
        // JSON of f64 is read to the last bit but one.
        let values = frames[0].eigenvalues.drain(..);
        for (read, written) in values.zip(written.eigenvalues.drain(..)) {
            assert!((read - written).abs() < 1e-14);
        }
        assert_eq!(frames, [written]);
        assert_eq!((frames[0].nodes, frames[0].potential.len()), (6, 6));
    }

    #[test]
    fn signs_follow_the_frame_before() {
        assert_eq!(sign(&[1.0, -2.0], Some(&vec![-1.0])), -1.0);
        assert_eq!(sign(&[1.0, -2.0], Some(&vec![0.5, -0.5])), 1.0);
        assert_eq!(sign(&[1.0], None), 1.0);
    }

    #[test]
    fn four_digits_are_kept() {
        let values = [0.0, -12.345_678, 1e-30, 98_765.4];
        assert_eq!(rounded(values.into_iter()), [0.0, -12.35, 0.0, 98_770.0]);
    }
}
