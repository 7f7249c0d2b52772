//! `eigentrail run`

use super::progress::Progress;
use super::{Ending, print, print_json, stop_on_interrupt};
use crate::cli;
use anyhow::Result;
use eigentrail::error::Error;
use eigentrail::report::{RunLine, render_run};
use eigentrail::runner::{self, Existing, Outlets, RunRequest, Watch};
use eigentrail::scenario::Scenario;
use eigentrail::telemetry::Telemetry;
use tracing::info;

pub fn run(args: &cli::Run, telemetry: &Telemetry, bars: bool) -> Result<Ending> {
    let loaded =
        Scenario::load(&args.scenario.scenario, &args.scenario.sets).map_err(Error::from)?;
    let scenario = &loaded.scenario;
    let request = RunRequest {
        seed: args.seed.unwrap_or(scenario.run.seed),
        out: args.out.clone(),
        existing: existing(args),
        arguments: std::env::args().collect(),
    };
    let stop = stop_on_interrupt()?;
    let mut progress = Progress::new(telemetry, bars, "episodes", scenario.run.episodes as u64);
    let mut watch = Watch {
        events: &telemetry.events,
        stop: &stop,
        on_episode: &mut |record| {
            let detail = || format!("{} steps, {} states", record.step, record.nodes);
            progress.reach(record.episode + 1, detail);
        },
        outlets: Outlets {
            tensorboard: !args.no_tensorboard,
        },
    };
    let report = runner::run(&loaded, &request, &mut watch)?;
    drop(progress);
    if report.was_finished {
        info!(
            seed = request.seed,
            "already finished in this folder, not run again"
        );
    }
    if !args.no_report {
        super::report::write_into(&report.folder)?;
    }
    let outcome = &report.outcome;
    if args.json {
        print_json(&RunLine::new(
            &scenario.name,
            &outcome.result,
            &outcome.timing,
        ))?;
    } else {
        print(&render_run(
            &scenario.name,
            &outcome.result,
            &outcome.timing,
            &outcome.steps_per_episode,
            &report.folder,
        ))?;
    }
    Ok(if outcome.result.finished {
        Ending::Done
    } else {
        Ending::Interrupted
    })
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
