//! `eigentrail figures`: pictures of a scenario, from runs made for the purpose.

use super::observers::EventKeeper;
use super::runs_for_figures::{SPARSE, run};
use super::{BadInput, Ending, Interrupted, gallery, require_replaceable, write_text};
use crate::cli;
use crate::output::print;
use crate::signals;
use anyhow::{Context, Result, bail};
use eigentrail::archive::ArchiveError;
use eigentrail::archive::files::TemporaryFolder;
use eigentrail::error::Error;
use eigentrail::report::overview;
use eigentrail::runner::{Observers, RunStart, Watch};
use eigentrail::scenario::{Scenario, World};
use eigentrail::telemetry::Telemetry;
use std::path::Path;
use std::sync::atomic::Ordering;

pub fn figures(args: &cli::Figures, telemetry: &Telemetry) -> Result<Ending> {
    let stop = signals::stop_flag();
    let events = &telemetry.events;
    let observers = |start: &RunStart<'_>| -> Result<Observers<'_>, ArchiveError> {
        let events = EventKeeper::create(events, start)?;
        Ok(vec![Box::new(events)])
    };
    let watch = Watch {
        stop: &stop,
        observers: &observers,
    };
    let sets = &args.sets;
    let Some(scenario) = &args.scenario else {
        let out = args.out.as_deref().unwrap_or(Path::new("figures"));
        return gallery::write_all(out, args.seeds, sets, watch);
    };
    let out = args.out.as_deref().unwrap_or(Path::new("figure.svg"));
    require_replaceable(out)?;
    let runs = TemporaryFolder::create().context("cannot make a folder for the runs")?;
    let load = |sets: &[String]| Scenario::load(scenario, sets).map_err(Error::from);
    let plain: Vec<String> = sets
        .iter()
        .cloned()
        .chain(SPARSE.map(str::to_owned))
        .collect();
    let (shaped, sparse) = (load(sets)?, load(&plain)?);
    // φ is that of the end of the run, so the goals are, too.
    let last = shaped.scenario.run.episodes - 1;
    let World::Grid(map) = shaped.worlds.in_episode(0, last) else {
        bail!(BadInput("this figure needs a world with a map".to_owned()));
    };
    let shaped = run(&shaped, args.seeds, &runs.path().join("shaped"), watch)?;
    let sparse = run(&sparse, args.seeds, &runs.path().join("sparse"), watch)?;
    let svg = overview(map.layout(), &shaped, &sparse);
    if stop.load(Ordering::Relaxed) {
        bail!(Interrupted);
    }
    write_text(out, &svg)?;
    print(&format!("written to {}", out.display()));
    Ok(Ending::Done)
}
