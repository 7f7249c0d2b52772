//! A handful of runs in a few numbers, and long series in few points.
//!
//! - [`interquartile_mean`], [`Bootstrap`]: statistics that the odd run does not move, with their intervals.
//! - [`blocks`]: many episodes as few blocks.
//! - [`Thinning`]: which of a stream of unknown length to keep.

mod blocks;
mod robust;
mod thinning;

pub use blocks::blocks;
pub use robust::{
    Bootstrap, Interval, interquartile_mean, median, probability_of_improvement, quantile,
};
pub use thinning::Thinning;
