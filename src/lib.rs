//! **eigentrail turns the graph an agent is still discovering into a reward it can follow.**
//!
//! As an agent explores an unknown MDP, the graph of visited states grows; the lowest eigenvectors of its Laplacian are kept
//! up to date; a small graph network is re-fitted on them now and then; it sets the temperatures of a soft Bellman equation, whose solution is the potential φ of a reward shaping
//! R′ = R + γφ(s′) − φ(s) that leaves optimal policies optimal, and advice on where to go.
//!
//! # In a loop of your own
//!
//! ```
//! use eigentrail::{Action, PipelineParams, ShapingPipeline, Step, StepStatus};
//!
//! // Nine rooms in a row; action 0 goes on, action 1 stays; the last room ends the episode.
//! let step = |room: u32, action: Action| {
//!     let state = if action == Action(0) { room + 1 } else { room };
//!     let status = if state == 8 { StepStatus::Terminated } else { StepStatus::Running };
//!     Step { state, reward: -1.0, status }
//! };
//! let mut pipeline = ShapingPipeline::new(&PipelineParams::default(), 2, None, 0)?;
//! for _episode in 0..2 {
//!     let mut room = 0;
//!     pipeline.begin_episode(&room);
//!     loop {
//!         // Your agent chooses; this one does as it is advised.
//!         let action = Action(u16::from(pipeline.advice()[1] > pipeline.advice()[0]));
//!         let step = step(room, action);
//!         let seen = pipeline.observe(action, &step)?;
//!         let _reward_to_learn_from = step.reward + seen.shaping;
//!         room = step.state;
//!         if step.status.is_last() {
//!             break;
//!         }
//!     }
//! }
//! // φ rises towards the goal: each step on is paid, each step back costs.
//! let phi = pipeline.potential().values();
//! assert!(phi.windows(2).all(|pair| pair[0] < pair[1]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Several explorers that share what they find take a [`WorldModel`] and a [`Walker`] each; [`Engine`] is the whole loop
//! with one of the [learners](agent); `eigentrail run` is a program around it.
//!
//! # The modules, in the order in which data flows
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
//! # Limitations
//!
//! - States are compared for equality and hashed: a world of real numbers has to be cut into cells first. At most 2³² − 1
//!   states and 65 536 actions, the same in every state.
//! - To the search an end of an episode is a goal if it pays more than a step, or costs no more than three
//!   ([`ExpectedReturn`](exploration::Optimism::ExpectedReturn)); with other kinds of optimism every end is, until an episode goes on there.
//! - Shaping leaves the optimal policies what they are; the *advice* is no reward and has no such proof. An agent that must
//!   be free of it sets `exploration.kind = "none"`.
//! - A fit looks at the whole graph, in O((n + transitions) log n); the schedule sees to it that fits become rarer as the
//!   graph grows.
//! - Equal inputs give equal bytes, at any number of threads, on x86-64 with AVX2 and FMA; elsewhere results differ in
//!   rounding.
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
#[cfg(any(feature = "matrix-market", feature = "runner"))]
#[cfg_attr(not(feature = "runner"), allow(dead_code, unused_imports))]
// a graph is saved, and no more
mod disk;
pub mod engine;
pub mod env;
pub mod error;
pub mod exploration;
mod exponential;
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

#[cfg(all(test, feature = "cli"))]
mod fault_tests;
#[cfg(all(any(test, fuzzing), feature = "cli"))]
#[allow(missing_docs, clippy::disallowed_methods)]
pub mod fuzzing;

pub use agent::{Agent, AnyAgent};
pub use engine::{
    Engine, Observed, PipelineError, PipelineParams, ShapingPipeline, Walker, WorldModel,
};
pub use env::{Action, Environment, Step, StepStatus};
pub use faer;
pub use graph::{StateGraph, StateId};
pub use parameter::ParameterError;
pub use shaping::Potential;
pub use spectral::GrowingEigensolver;

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
