//! `eigentrail run`

use super::observers::{EpisodeProgress, EventKeeper};
use super::progress::Progress;
use super::{BadInput, Ending};
use crate::cli;
use crate::output::{print, print_json};
use crate::signals;
use anyhow::Result;
use eigentrail::archive::{ArchiveError, Existing, RunLine, RunLines};
use eigentrail::error::Error;
use eigentrail::report::{render_run, render_seeds};
use eigentrail::runner::{self, Observers, RunOutcome, RunRequest, RunStart, Watch};
use eigentrail::scenario::Scenario;
use eigentrail::serve::{LiveView, Server, Title};
use eigentrail::telemetry::{Telemetry, say};
use eigentrail::tensorboard::TensorBoardWriter;
use std::sync::atomic::Ordering;
use tracing::{info, warn};

pub fn run(args: &cli::Run, telemetry: &Telemetry, bars: bool) -> Result<Ending> {
    let loaded =
        Scenario::load(&args.scenario.scenario, &args.scenario.sets).map_err(Error::from)?;
    let scenario = &loaded.scenario;
    for caution in &loaded.cautions {
        warn!("{caution}");
    }
    let request = RunRequest {
        seeds: seeds(args, scenario),
        out: args.out.clone(),
        existing: existing(args),
        arguments: super::arguments(),
    };
    let stop = signals::stop_flag();
    let mut server = serve(args, scenario, &request)?;
    let episodes = scenario.run.episodes as u64 * request.seeds.len() as u64;
    let progress = Progress::new(telemetry, bars, "episodes", episodes);
    let events = &telemetry.events;
    let observers = |start: &RunStart<'_>| -> Result<Observers<'_>, ArchiveError> {
        let mut observers: Observers<'_> = vec![Box::new(EventKeeper::create(events, start)?)];
        if !args.no_tensorboard {
            observers.push(Box::new(TensorBoardWriter::create(start)?));
        }
        if let Some(server) = &server {
            observers.push(Box::new(LiveView::new(server)));
        }
        observers.push(Box::new(EpisodeProgress::new(&progress, start)));
        Ok(observers)
    };
    let watch = Watch {
        stop: &stop,
        observers: &observers,
    };
    let ran = runner::run(&loaded, &request, watch).map_err(Error::from)?;
    drop(progress);
    if let Some(server) = &mut server {
        server.end_of_run(); // browsers are shown the end before the page is written
    }
    for seed in ran.seeds.iter().filter(|seed| seed.was_finished) {
        let seed = seed.result.seed;
        info!(seed, "already finished in this folder, not run again");
    }
    // Interrupted early enough, there is nothing to report on.
    if !args.no_report && !ran.seeds.is_empty() {
        super::report::write_into(ran.folder.path())?;
    }
    show(args, &scenario.name, &ran);
    let ending = match ran.finished {
        true => Ending::Done,
        false => Ending::Interrupted,
    };
    let anything_to_show = ran.seeds.iter().any(|seed| !seed.was_finished);
    drop(ran); // whoever comes now may write to the folder
    if let Some(server) = server.filter(|_| args.serve.is_some() && anything_to_show)
        && !stop.load(Ordering::Relaxed)
    {
        let address = server.address();
        say(format!(
            "the run has ended; its page stays at http://{address}/ until Ctrl-C"
        ));
        signals::wait();
    }
    Ok(ending)
}

/// The seeds that are asked for.
fn seeds(args: &cli::Run, scenario: &Scenario) -> Vec<u64> {
    match &args.seeds {
        Some(seeds) => seeds.0.clone(),
        None => vec![args.seed.unwrap_or(scenario.run.seed)],
    }
}

/// The results, in the form of one seed or of several by how it was asked.
fn show(args: &cli::Run, name: &str, ran: &RunOutcome) {
    let folder = ran.folder.path();
    let results = || ran.seeds.iter().map(|seed| (&seed.result, &seed.timing));
    if args.seeds.is_some() {
        match args.json {
            true => print_json(&RunLines::new(name, results())),
            false => print(&render_seeds(
                name,
                results(),
                folder,
                super::table_style(false, false),
            )),
        }
        return;
    }
    for seed in &ran.seeds {
        let (result, timing) = (&seed.result, &seed.timing);
        match args.json {
            true => print_json(&RunLine::new(name, result, timing)),
            false => print(&render_run(
                name,
                result,
                timing,
                &seed.steps_per_episode,
                folder,
            )),
        }
    }
}

/// The server of the live page, if one is asked for.
fn serve(args: &cli::Run, scenario: &Scenario, request: &RunRequest) -> Result<Option<Server>> {
    let Some(address) = args.serve.or(args.serve_once) else {
        return Ok(None);
    };
    let title = Title {
        name: scenario.name.clone(),
        scenario: scenario.clone(),
        arguments: request.arguments.clone(),
    };
    let server = Server::start(address, title).map_err(|error| {
        let hint = "another run may be there; port 0 takes any that is free";
        BadInput(format!("--serve={address}: cannot listen: {error}; {hint}"))
    })?;
    let address = server.address();
    if !address.ip().is_loopback() {
        // Not a line of the log: whoever is quiet must know it, too.
        say(format!(
            "warning: the live page can be read by whoever reaches {address}"
        ));
    }
    say(format!("live at http://{address}/"));
    Ok(Some(server))
}

fn existing(args: &cli::Run) -> Existing {
    if args.resume {
        Existing::Resume
    } else if args.force {
        Existing::Replace
    } else {
        Existing::Refuse
    }
}
