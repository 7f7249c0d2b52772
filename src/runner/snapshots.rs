//! φ and the first eigenvectors through the refreshes: few enough frames to look at.
//!
//! Every `stride`-th refresh leaves a frame. Whenever the frames become too many, every second one is dropped and the
//! stride doubles, so that what remains is spread over the whole run, whatever its length. Nothing is done between
//! refreshes, and no clock is read: equal runs leave equal bytes.

use super::observer::Knowledge;
use crate::archive::Snapshot;
use serde::{Deserialize, Serialize};

/// Frames kept, the last state of the run not counted.
const MAX_FRAMES: usize = 39;

/// Numbers kept in all frames together; larger graphs have fewer frames.
const MAX_NUMBERS: usize = 1_000_000;

/// Eigenvectors kept: from the second on, because the first is the same everywhere up to degrees.
const VECTORS: std::ops::Range<usize> = 1..5;

/// Frames of one seed.
#[derive(Clone, Debug, Serialize, Deserialize)]
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
    pub fn refreshed(&mut self, step: u64, known: &Knowledge<'_>) {
        let number = self.refreshes;
        self.refreshes += 1;
        if number.is_multiple_of(self.stride) {
            self.frames.push(snapshot(step, known, self.frames.last()));
            self.thin();
        }
    }

    /// The frames so far, and how things stand at `step`.
    pub fn up_to_now(&self, step: u64, known: &Knowledge<'_>) -> Vec<Snapshot> {
        let now = snapshot(step, known, self.frames.last());
        self.frames.iter().cloned().chain([now]).collect()
    }

    fn thin(&mut self) {
        let numbers: usize = self.frames.iter().map(numbers).sum();
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

/// The frame of this moment; the one before tells the signs of eigenvectors.
fn snapshot(step: u64, known: &Knowledge<'_>, before: Option<&Snapshot>) -> Snapshot {
    let nodes = known.graph.num_states();
    let mut potential: Vec<f32> = rounded(known.potential.values().iter().copied());
    potential.resize(nodes, 0.0);
    let pairs = known.eigenpairs;
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
    Snapshot {
        step,
        nodes,
        edges: known.graph.adjacency().num_edges(),
        potential,
        eigenvalues: pairs.map_or(Vec::new(), |pairs| pairs.values.clone()),
        vectors,
    }
}

/// Numbers kept in a frame.
fn numbers(frame: &Snapshot) -> usize {
    frame.potential.len() + frame.vectors.iter().map(Vec::len).sum::<usize>()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::archive::{read_snapshots, write_snapshots};
    use crate::engine::{PipelineParams, ShapingPipeline};
    use crate::env::{Action, Step, StepStatus};
    use crate::runner::places::{Map, Places, knowledge};

    /// States without a map.
    struct Nowhere;

    impl Places<u32> for Nowhere {
        fn label(&self, state: &u32) -> Vec<String> {
            vec![state.to_string()]
        }

        fn action(&self, _: Action) -> &str {
            "on"
        }

        fn map(&self) -> Option<Map<'_, u32>> {
            None
        }
    }

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
            snapshots.refreshed(step, &knowledge(&pipeline, &Nowhere));
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
        let known = knowledge(&pipeline, &Nowhere);
        let written = Snapshots::default().up_to_now(5, &known);
        write_snapshots(folder.path(), &written).unwrap();
        let mut frames = read_snapshots(folder.path()).unwrap();
        let mut written = snapshot(5, &known, None);
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
