//! **eigentrail turns the graph an agent is still discovering into a reward it can follow.**
//!
//! The modules, in the order in which data flows through them:
//!
//! - [`env`](mod@env): worlds. [`env::Environment`] and the grid worlds, mazes and edge lists behind it.
//! - [`graph`]: the graph of visited states, growing in place.
//! - [`spectral`]: the low eigenvectors of its Laplacian (proto-value functions), kept up to date.
//! - [`features`]: those eigenvectors or other features of a state, kept up to date.
//! - [`gcn`]: a graph convolutional network of two layers on those features.
//! - [`shaping`]: the potential φ and the policy-invariant reward that comes from it.
//! - [`exploration`]: what guides the agent before the first reward.
//! - [`agent`]: the learners, and the yardsticks beside them.
//! - [`engine`]: the loop of the above, and the pipeline for those who bring their own loop.
//! - [`scenario`], [`runner`]: experiments as files, repeated over seeds and arms.
//! - [`archive`], [`statistics`]: what they leave on disk, and in a few numbers.
//! - [`report`]: what people look at.
//! - [`serve`], [`export`]: a run in the browser while it goes on, and for other programs afterwards.
//! - [`telemetry`], [`tensorboard`]: what is said while they run, to programs and to TensorBoard.

#![deny(missing_docs)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod agent;
pub mod archive;
mod brief;
pub mod engine;
pub mod env;
pub mod error;
pub mod exploration;
pub mod export;
pub mod features;
pub mod gcn;
pub mod graph;
mod memory;
pub mod printable;
pub mod report;
pub mod runner;
pub mod scenario;
pub mod seeds;
pub mod serve;
pub mod shaping;
pub mod spectral;
pub mod statistics;
pub mod telemetry;
pub mod tensorboard;
mod vector_state;
