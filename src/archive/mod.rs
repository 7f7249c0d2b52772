//! Files that runs and comparisons leave on disk: names, rows and results, written and read back.
//!
//! - [`RunFolder`]: a folder with one writer, and what stands in it around its seeds.
//! - [`SeedTables`] and the functions beside it: the files of one seed.
//! - [`Checkpoint`]: a moment of a seed's run, from which it goes on.
//! - [`TrialRecord`], [`write_comparison`]: the files of a comparison.
//! - [`Shard`], [`write_sweep`]: the files of a sweep.
//! - [`RecordedRun`], [`RecordedComparison`]: folders read back, which every page and figure is made of.
//! - [`files`]: files that are never half written, of whatever kind.
//!
//! Nothing here knows how a run is made or shown. Other programs read these files: names of files, columns and keys stay as
//! they are.

mod belongings;
mod bounded;
pub mod checkpoint;
mod comparison;
mod comparison_files;
pub mod container;
mod error;
pub mod files;
mod folder;
mod folder_kind;
mod graph_files;
mod lock;
pub mod names;
mod recorded;
mod recorded_comparison;
mod result_columns;
mod rows;
mod run_files;
mod run_line;
mod seed_files;
mod shard;
mod snapshots;
mod summary;
mod sweep;
mod sweep_files;
mod trial_record;

pub use bounded::BoundedEpisodes;
pub use checkpoint::Checkpoint;
pub use comparison::{
    ArmDifference, ArmSummary, ArmTiming, Comparison, FirstWithin, IqmInterval, LearningCurve,
    MedianInterval, Moments, ProbabilityInterval, TrialResult, TrialTiming, Tuning, TuningEntry,
};
pub use comparison_files::{Compared, TrialsByArm, begin_arm, begin_comparison, write_comparison};
pub use error::ArchiveError;
pub use folder::{Existing, RunFolder};
pub use folder_kind::{FolderKind, is_comparison, is_run};
pub use graph_files::{read_action_names, write_actions, write_graph, write_policy};
pub use lock::FolderLock;
pub use names::{seed_folder_name, trial_file_name};
pub use recorded::{PhaseSeconds, RecordedRun, RecordedSeed, read_runs};
pub use recorded_comparison::{RecordedArm, RecordedComparison};
pub use rows::{EpisodeRow, GraphRow, PolicyRow, RefreshRow};
pub use run_files::{RunInfo, RunStatus};
pub use run_line::{RunLine, RunLines};
pub use seed_files::{
    SeedTables, TableLengths, read_labels, read_potential, write_matrix, write_potential,
    write_states,
};
pub use shard::{Shard, read_shards};
pub use snapshots::{Snapshot, read_snapshots, write_snapshots};
pub use summary::{SeedResult, SeedTiming, Summary, Timing};
pub use sweep::{PointSetting, PointSummary, Sweep, Swept, SweptPoint};
pub use sweep_files::{
    TrialsByPoint, begin_point, begin_sweep, sweep_rows, unwrite_sweep, write_sweep,
};
pub use trial_record::{TrialRecord, content_hash, scenario_hash};
