//! A handful of runs in a few numbers, and long series in few points.
//!
//! - [`interquartile_mean`], [`Bootstrap`]: statistics that the odd run does not move, with their intervals.
//! - [`MedianBetween`]: a median between two values of its sample, exact whatever they are distributed like.
//! - [`PairedDifference`]: two arms over the same seeds, and whether they differ, are the same, or nothing is shown.
//! - [`blocks`]: many episodes as few blocks.
//! - [`Thinning`]: which of a stream of unknown length to keep.

mod blocks;
mod order;
mod paired;
mod robust;
mod thinning;

pub use blocks::blocks;
pub use order::MedianBetween;
pub use paired::{EQUIVALENCE_MARGIN, PairedDifference, Verdict};
pub use robust::{
    Bootstrap, Interval, interquartile_mean, median, probability_of_improvement, quantile,
};
pub use thinning::Thinning;
