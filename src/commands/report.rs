//! `eigentrail report`

use super::{BadInput, Ending, require_replaceable, write_text};
use crate::cli;
use crate::output::print;
use anyhow::{Result, bail};
use eigentrail::archive::{RecordedComparison, is_comparison, names, read_runs};
use eigentrail::error::Error;
use eigentrail::report::{html_comparison, html_report};
use std::path::Path;

pub fn report(args: &cli::Report) -> Result<Ending> {
    require_replaceable(&args.out)?;
    if let Some(comparison) = args.runs.iter().find(|path| is_comparison(path)) {
        if args.runs.len() > 1 {
            bail!(BadInput(format!(
                "{}: a comparison has a page of its own; give it alone",
                comparison.display()
            )));
        }
        write_text(&args.out, &comparison_page(comparison)?)?;
        print(&format!("written to {}", args.out.display()));
        return Ok(Ending::Done);
    }
    let mut runs = Vec::new();
    for folder in &args.runs {
        runs.extend(read_runs(folder).map_err(Error::from)?);
    }
    write_text(&args.out, &html_report(&runs))?;
    print(&format!("written to {}", args.out.display()));
    Ok(Ending::Done)
}

/// Writes `report.html` into a run folder.
pub fn write_into(folder: &Path) -> Result<()> {
    let runs = read_runs(folder).map_err(Error::from)?;
    write_text(&folder.join(names::PAGE), &html_report(&runs))
}

/// Writes `report.html` into the folder of a comparison.
pub fn write_comparison_into(folder: &Path) -> Result<()> {
    write_text(&folder.join(names::PAGE), &comparison_page(folder)?)
}

fn comparison_page(folder: &Path) -> Result<String> {
    let recorded = RecordedComparison::read(folder).map_err(Error::from)?;
    Ok(html_comparison(&recorded))
}
