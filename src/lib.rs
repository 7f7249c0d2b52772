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
//! - `scenario`, `runner`: experiments as files, repeated over seeds and arms.
//! - `archive`, `statistics`: what they leave on disk, and in a few numbers.
//! - `report`: pages, tables and figures made of that.
//! - `serve`, `export`: a run in the browser while it goes on, and for other programs afterwards.
//! - `telemetry`, `tensorboard`: what is said while they run, to programs and to TensorBoard.
//!
//! # Features
//!
//! | feature | brings | packages behind it, about |
//! |---|---|---|
//! | none (`default-features = false`) | everything down to `engine` | 90 |
//! | `matrix-market` | `graph::matrix_market` | 110 |
//! | `runner` | `scenario`, `runner`, `archive`, `statistics` | 110 |
//! | `cli` (the default) | both of these, all other modules and the program | 175 |
//! | `parquet` | `cli`, and Parquet among the formats of `export` | 200 |

#![deny(missing_docs)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod agent;
#[cfg(feature = "runner")]
pub mod archive;
pub mod engine;
pub mod env;
pub mod error;
pub mod exploration;
#[cfg(feature = "cli")]
pub mod export;
pub mod features;
pub mod gcn;
pub mod graph;
#[cfg(any(feature = "matrix-market", feature = "runner"))]
mod memory;
#[cfg(feature = "runner")]
mod npy;
pub mod parameter;
pub mod printable;
#[cfg(feature = "cli")]
pub mod report;
#[cfg(feature = "runner")]
pub mod runner;
#[cfg(feature = "runner")]
pub mod scenario;
pub mod seeds;
#[cfg(feature = "cli")]
pub mod serve;
pub mod shaping;
pub mod spectral;
#[cfg(feature = "runner")]
pub mod statistics;
#[cfg(feature = "cli")]
pub mod telemetry;
#[cfg(feature = "cli")]
pub mod tensorboard;
#[cfg(feature = "runner")]
mod time_stamp;
mod vector_state;

/// The examples of README.md and docs.
#[cfg(doctest)]
mod documents {
    #[doc = include_str!("../README.md")]
    struct Readme;
    #[doc = include_str!("../docs/learning.md")]
    struct Learning;
    #[doc = include_str!("../docs/method.md")]
    struct Method;
    #[doc = include_str!("../docs/spectra.md")]
    struct Spectra;
}
