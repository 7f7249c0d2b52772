//! `eigentrail report`

use super::{Ending, print};
use crate::cli;
use anyhow::{Context, Result};
use eigentrail::error::Error;
use eigentrail::report::{html_report, read_runs};
use std::path::Path;

pub fn report(args: &cli::Report) -> Result<Ending> {
    let mut runs = Vec::new();
    for folder in &args.runs {
        runs.extend(read_runs(folder).map_err(Error::from)?);
    }
    write(&args.out, &html_report(&runs))?;
    print(&format!("written to {}", args.out.display()))?;
    Ok(Ending::Done)
}

/// Writes `report.html` into a run folder.
pub fn write_into(folder: &Path) -> Result<()> {
    let runs = read_runs(folder).map_err(Error::from)?;
    write(&folder.join("report.html"), &html_report(&runs))
}

fn write(path: &Path, page: &str) -> Result<()> {
    std::fs::write(path, page).with_context(|| format!("{}: cannot write", path.display()))
}
