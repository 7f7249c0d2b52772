//! `eigentrail figures --all`: the source paper's figures 4 to 9, from runs made for the purpose.

use super::runs_for_figures::{SPARSE, run};
use super::{Ending, Interrupted, require_replaceable, require_writable_folder, write_text};
use crate::output::print;
use anyhow::{Context, Result, bail};
use eigentrail::archive::RecordedRun;
use eigentrail::archive::files::{self, TemporaryFolder};
use eigentrail::error::Error;
use eigentrail::report::{PaperRuns, counterparts, figures_page};
use eigentrail::runner::Watch;
use eigentrail::scenario::{Scenario, report_scenarios};
use std::ops::RangeInclusive;
use std::path::Path;
use std::sync::atomic::Ordering;

/// Numbers of the figures in the paper.
const NUMBERS: RangeInclusive<u32> = 4..=9;

/// Runs every file of `scenarios/report/`, `seeds` times where learners are compared, and writes pictures and page.
pub fn write_all(out: &Path, seeds: u64, sets: &[String], watch: Watch<'_>) -> Result<Ending> {
    require_writable_folder(out)?;
    let index = out.join("index.html");
    let pictures = NUMBERS.map(|number| out.join(picture(number)));
    for file in pictures.chain([index.clone()]) {
        if file.exists() {
            require_replaceable(&file)?;
        }
    }
    let folder = TemporaryFolder::create().context("cannot make a folder for the runs")?;
    let go = |name: &str, more: &[&str], seeds| -> Result<RecordedRun> {
        let file = report_scenarios().iter().find(|file| file.name == name);
        let file = file.expect("every figure has its scenario");
        let path = Path::new("scenarios/report")
            .join(name)
            .with_extension("toml");
        let sets: Vec<String> = sets
            .iter()
            .cloned()
            .chain(more.iter().map(|&set| set.to_owned()))
            .collect();
        let loaded = Scenario::parse(&path, file.text.to_owned(), &sets).map_err(Error::from)?;
        let into = folder.path().join(format!("{name}-{}", more.len()));
        run(&loaded, seeds, &into, watch)
    };
    let runs = PaperRuns {
        graph: go("fig4_graph", &[], 1)?,
        reward: go("fig5_reward", &[], 1)?,
        scale: go("fig6_scale", &[], 1)?,
        two_goals: go("fig7a_two_goals", &[], 1)?,
        centre_goal: go("fig7b_centre_goal", &[], 1)?,
        learning: [
            go("fig8_learning", &[], seeds)?,
            go("fig8_learning", &SPARSE, seeds)?,
        ],
        linked: [
            go("fig9_linked_grids", &[], seeds)?,
            go("fig9_linked_grids", &SPARSE, seeds)?,
        ],
    };
    let figures = counterparts(&runs);
    if watch.stop.load(Ordering::Relaxed) {
        bail!(Interrupted);
    }
    files::create_folders(out).with_context(|| format!("{}: cannot make it", out.display()))?;
    for figure in &figures {
        write_text(&out.join(picture(figure.number)), &figure.svg)?;
    }
    write_text(&index, &figures_page(&figures))?;
    print(&format!("written to {}", index.display()));
    Ok(Ending::Done)
}

/// The file of a figure.
fn picture(number: u32) -> String {
    format!("fig{number}.svg")
}
