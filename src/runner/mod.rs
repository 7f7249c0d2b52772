//! Experiments: a scenario becomes an engine, runs, and leaves a folder.
//!
//! - [`build_engine`]: from a scenario to an engine; the one place that knows every concrete type.
//! - [`run`]: one seed into a run folder, records written as they happen.
//! - [`compare`]: arms × seeds, with the [`statistics`](crate::statistics) of a handful of runs.
//! - [`sweep`]: a grid × seeds, in shards that any process may compute.
//! - [`RunObserver`]: whoever else is told what happens in a run; the runner itself shows nothing.
//! - [`potential_of_graph`]: the potential of any graph, without a world.
//!
//! Both loops are one: a trial plays episode after episode, and tells its observers.

mod build;
mod checkpoints;
mod compare;
mod error;
mod estimate;
mod evaluation;
mod nearness;
mod observer;
mod optimal_returns;
mod parallel_map;
mod places;
mod potential;
mod run;
mod seed_writer;
mod snapshots;
mod sums;
mod sweep;
mod trial;

pub use build::{build_engine, move_goals, pipeline_params, with_discovery_hook};
pub use compare::{CompareOutcome, CompareRequest, CompareWatch, compare};
pub use error::RunnerError;
pub use estimate::{estimated_bytes, require_memory, require_spectrum_memory};
pub use observer::{
    Episode, Knowledge, KnownMap, Observers, Refresh, RunObserver, RunStart, RunState,
    SavedObserver, save,
};
pub use potential::{PotentialOfGraph, potential_of_graph};
pub use run::{MakeObservers, RunOutcome, RunRequest, SeedOutcome, Watch, run, run_seed};
pub use snapshots::Snapshots;
pub use sweep::{OpenSweep, ShardTask, SweepOutcome, SweepPlan, SweepRequest, SweepWatch, sweep};

#[cfg(test)]
mod checkpoint_tests;
#[cfg(test)]
mod tests;
