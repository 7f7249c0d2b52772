//! The runs that figures are drawn from.

use super::Interrupted;
use anyhow::{Result, bail};
use eigentrail::archive::{Existing, RecordedRun};
use eigentrail::error::Error;
use eigentrail::runner::{self, RunRequest, Watch};
use eigentrail::scenario::Loaded;
use std::path::Path;

/// The arm to compare with: nothing but the environment's own reward.
pub(super) const SPARSE: [&str; 2] = ["shaping.potential=none", "exploration.kind=none"];

/// Runs seeds 0, 1, 2 … of a scenario, every one to its end, and reads them back.
pub(super) fn run(
    loaded: &Loaded,
    seeds: u64,
    folder: &Path,
    watch: Watch<'_>,
) -> Result<RecordedRun> {
    let request = RunRequest {
        seeds: (0..seeds).collect(),
        out: Some(folder.to_owned()),
        existing: Existing::Resume,
        arguments: super::arguments(),
    };
    let ran = runner::run(loaded, &request, watch).map_err(Error::from)?;
    if !ran.finished {
        bail!(Interrupted); // less than all the seeds would be a false picture
    }
    Ok(RecordedRun::read(folder).map_err(Error::from)?)
}
