//! `eigentrail run`

use super::observers::{EpisodeProgress, EventKeeper};
use super::progress::Progress;
use super::{BadInput, Ending};
use crate::cli;
use crate::output::{print, print_json};
use crate::signals;
use anyhow::Result;
use eigentrail::archive::{ArchiveError, Existing};
use eigentrail::error::Error;
use eigentrail::report::{RunLine, render_run};
use eigentrail::runner::{self, Observers, RunRequest, RunStart, Watch};
use eigentrail::scenario::Scenario;
use eigentrail::serve::{LiveView, Server, Title};
use eigentrail::telemetry::{Telemetry, say};
use eigentrail::tensorboard::TensorBoardWriter;
use std::cell::RefCell;
use tracing::info;

pub fn run(args: &cli::Run, telemetry: &Telemetry, bars: bool) -> Result<Ending> {
    let loaded =
        Scenario::load(&args.scenario.scenario, &args.scenario.sets).map_err(Error::from)?;
    let scenario = &loaded.scenario;
    let request = RunRequest {
        seed: args.seed.unwrap_or(scenario.run.seed),
        out: args.out.clone(),
        existing: existing(args),
        arguments: super::arguments(),
    };
    let stop = signals::stop_flag();
    let server = serve(args, scenario, &request)?;
    let progress = Progress::new(telemetry, bars, "episodes", scenario.run.episodes as u64);
    let progress = RefCell::new(progress);
    let observers = |start: &RunStart<'_>| -> Result<Observers<'_>, ArchiveError> {
        let mut observers: Observers<'_> =
            vec![Box::new(EventKeeper::create(&telemetry.events, start)?)];
        if !args.no_tensorboard {
            observers.push(Box::new(TensorBoardWriter::create(start)?));
        }
        if let Some(server) = &server {
            observers.push(Box::new(LiveView::new(server)));
        }
        observers.push(Box::new(EpisodeProgress(&progress)));
        Ok(observers)
    };
    let watch = Watch {
        stop: &stop,
        observers: &observers,
    };
    let ran = runner::run(&loaded, &request, watch).map_err(Error::from)?;
    drop(progress);
    drop(server); // browsers are shown the end before the page is written
    if ran.was_finished {
        info!(
            seed = request.seed,
            "already finished in this folder, not run again"
        );
    }
    if !args.no_report {
        super::report::write_into(ran.folder.path())?;
    }
    let outcome = &ran.outcome;
    if args.json {
        print_json(&RunLine::new(
            &scenario.name,
            &outcome.result,
            &outcome.timing,
        ));
    } else {
        print(&render_run(
            &scenario.name,
            &outcome.result,
            &outcome.timing,
            &outcome.steps_per_episode,
            ran.folder.path(),
        ));
    }
    Ok(if outcome.result.finished {
        Ending::Done
    } else {
        Ending::Interrupted
    })
}

/// The server of the live page, if one is asked for.
fn serve(args: &cli::Run, scenario: &Scenario, request: &RunRequest) -> Result<Option<Server>> {
    let Some(address) = args.serve else {
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
    say(format!("live at http://{address}/ until the run ends"));
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
