//! Experiments: a scenario becomes an engine, runs, and leaves a folder.
//!
//! - [`build_engine`]: from a scenario to an engine; the one place that knows every concrete type.
//! - [`run`]: one seed into a run folder, records written as they happen.
//! - [`compare`]: arms × seeds, with the [`statistics`] of a handful of runs.
//! - [`potential_of_graph`]: the potential of any graph, without a world.

mod belongings;
mod board;
mod build;
mod compare;
mod crew;
mod error;
mod estimate;
pub mod files;
mod folder;
mod follow;
mod graph_files;
mod ledger;
mod lock;
mod nearness;
mod phases;
mod places;
mod potential;
mod records;
mod run;
mod session;
mod snapshots;
pub mod statistics;
mod temporary;
mod thinning;
mod trial;

pub use board::BOARD_FILE;
pub use build::{build_engine, pipeline_params};
pub use compare::{CompareReport, CompareRequest, CompareWatch, Compared, Trial, compare};
pub use error::RunnerError;
pub use estimate::{estimated_bytes, require_memory, require_spectrum_memory};
pub use folder::{Existing, FolderKind, RunFolder, is_comparison, is_run, seed_folder_name};
pub use follow::{Follower, Moment};
pub use graph_files::{GraphRow, PolicyRow, write_graph_files};
pub use lock::FolderLock;
pub use potential::{GraphPotential, potential_of_graph};
pub use records::{SeedRecords, read_potential, write_matrix};
pub use run::{Outlets, SeedOutcome, Watch, run_seed};
pub use session::{RunReport, RunRequest, run};
pub use snapshots::{Snapshot, Snapshots, read_snapshots};
pub use trial::{TrialOutcome, run_trial};
