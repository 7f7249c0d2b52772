//! Names of files and folders, each in one place.
//!
//! Other programs read them: they do not change.

/// What is run, as it was given.
pub const SCENARIO: &str = "scenario.toml";
/// The same with every default and every `--set`.
pub const RESOLVED: &str = "resolved.toml";
/// The page about a run or a comparison.
pub const PAGE: &str = "report.html";

/// Who ran what when, and how it ended: the mark of a run.
pub const RUN: &str = "run.json";
/// Results of a run by seed, or of a sweep by point.
pub const SUMMARY: &str = "summary.json";

/// Row for each episode.
pub const EPISODES: &str = "episodes.csv";
/// Row for each refresh of the spectrum, of the potential, or of both.
pub const REFRESHES: &str = "refreshes.csv";
/// Seconds of a seed's episodes and refreshes, or of the trials of a comparison or a sweep.
pub const TIMINGS: &str = "timings.csv";
/// Log of a seed.
pub const EVENTS: &str = "events.jsonl";
/// Event file of a seed. TensorBoard looks for `.tfevents.`; where others put a time and a host stand 0 and our name, so
/// that the folder of a run lists the same files each time.
pub const TENSORBOARD: &str = "events.out.tfevents.0.eigentrail";
/// φ by state.
pub const POTENTIAL: &str = "potential.npy";
/// Eigenvectors of the last refresh.
pub const EIGENVECTORS: &str = "eigenvectors.npy";
/// Place or name of each state.
pub const STATES: &str = "states.csv";
/// Transitions that were seen.
pub const GRAPH: &str = "graph.csv";
/// Name of each action.
pub const ACTIONS: &str = "actions.csv";
/// Action held best in each state.
pub const POLICY: &str = "policy.csv";
/// φ and eigenvectors through the run.
pub const SNAPSHOTS: &str = "snapshots.json";

/// The newest moment from which a seed that has not ended goes on.
pub const CHECKPOINT: &str = "checkpoint";
/// The one before.
pub const CHECKPOINT_BEFORE: &str = "checkpoint-before";

/// Files of a seed.
pub(super) const SEED_FILES: [&str; 14] = [
    CHECKPOINT,
    CHECKPOINT_BEFORE,
    EPISODES,
    REFRESHES,
    TIMINGS,
    EVENTS,
    TENSORBOARD,
    POTENTIAL,
    EIGENVECTORS,
    STATES,
    GRAPH,
    ACTIONS,
    POLICY,
    SNAPSHOTS,
];

/// What is compared, and who asked for it when: the mark of a comparison.
pub const ARMS: &str = "arms.json";
/// Numbers of a comparison.
pub const COMPARISON: &str = "compare.json";
/// Row for each trial of a comparison.
pub const TRIALS: &str = "compare.csv";
/// Folder of a comparison's arms.
pub const ARMS_FOLDER: &str = "arms";
/// Folder of the step sizes tried for the sparse arm.
pub const TUNING_FOLDER: &str = "tuning";

/// What is swept, and who asked for it when: the mark of a sweep.
pub const SWEEP: &str = "sweep.json";
/// Row for each trial of a sweep.
pub const SWEEP_TRIALS: &str = "sweep.csv";
/// Chunks of a sweep that failed where they were computed by other processes.
pub const SWEEP_ERRORS: &str = "errors.json";
/// Folder of a sweep's points.
pub const POINTS_FOLDER: &str = "points";

/// Folder of a seed, `seed-0007`.
pub fn seed_folder_name(seed: u64) -> String {
    format!("seed-{seed:04}")
}

/// File of a trial in the folder of its arm, `seed-0007.json`.
pub fn trial_file_name(seed: u64) -> String {
    seed_folder_name(seed) + ".json"
}
