//! `eigentrail compare`

use super::progress::Progress;
use super::{BadInput, Ending};
use crate::cli;
use crate::output::{print, print_json};
use crate::signals;
use anyhow::{Result, bail};
use eigentrail::archive::{Comparison, Existing};
use eigentrail::error::Error;
use eigentrail::report::{TableStyle, render_comparison, render_overview};
use eigentrail::runner::{self, CompareRequest, CompareWatch};
use eigentrail::scenario::{Loaded, Scenario};
use eigentrail::telemetry::{Telemetry, say};
use serde::Serialize;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// `compare --json` over several scenarios.
#[derive(Serialize)]
struct Comparisons<'a> {
    scenarios: &'a [Comparison],
}

pub fn compare(args: &cli::Compare, telemetry: &Telemetry, bars: bool) -> Result<Ending> {
    if super::without_duplicates(&args.arms).is_empty() {
        bail!(BadInput(
            "--arms: names no arm; `eigentrail list` tells which there are".to_owned()
        ));
    }
    // Every file is judged before the first one runs.
    let all = args.scenarios.iter().map(|path| {
        let loaded = Scenario::load(path, &args.sets).map_err(Error::from)?;
        Ok((loaded, request(args, path)))
    });
    let mut all: Vec<(Loaded, CompareRequest)> = all.collect::<Result<_>>()?;
    if all.len() > 1 {
        require_distinct_names(&all, args)?;
        for (loaded, request) in &mut all {
            request.out = request
                .out
                .take()
                .map(|out| out.join(&loaded.scenario.name));
        }
    }
    let stop = signals::stop_flag();
    let mut comparisons = Vec::new();
    for (loaded, request) in &all {
        let compared = compare_one(loaded, request, telemetry, bars, &stop)?;
        let folder = compared.folder.path();
        let Some(comparison) = compared.comparison else {
            let (name, folder) = (&loaded.scenario.name, folder.display());
            say(format!(
                "{name}: interrupted; --resume --out {folder} goes on"
            ));
            return Ok(Ending::Interrupted);
        };
        if !args.no_report {
            super::report::write_comparison_into(folder)?;
        }
        if !args.json {
            print(&render_comparison(&comparison, style(args)));
            print(&format!("written to {}\n\n", folder.display()));
        }
        comparisons.push(comparison);
    }
    show_all(args, &comparisons);
    Ok(Ending::Done)
}

/// With `--out` each scenario has a folder of its name: two of one name would be written over each other.
fn require_distinct_names(all: &[(Loaded, CompareRequest)], args: &cli::Compare) -> Result<()> {
    let mut seen = HashMap::new();
    for (loaded, request) in all.iter().filter(|_| args.out.is_some()) {
        let name = &loaded.scenario.name;
        if let Some(other) = seen.insert(name, &request.path) {
            bail!(BadInput(format!(
                "{}: the scenario is called {name}, as that of {}, so that both would be written to one folder below --out; \
                 change the name of one",
                request.path.display(),
                other.display()
            )));
        }
    }
    Ok(())
}

fn request(args: &cli::Compare, path: &Path) -> CompareRequest {
    CompareRequest {
        path: PathBuf::from(path),
        sets: args.sets.clone(),
        seeds: args.seeds.0.clone(),
        arms: super::without_duplicates(&args.arms),
        tuned: args.tuned,
        out: args.out.clone(),
        existing: existing(args),
        arguments: super::arguments(),
    }
}

fn compare_one(
    loaded: &Loaded,
    request: &CompareRequest,
    telemetry: &Telemetry,
    bars: bool,
    stop: &AtomicBool,
) -> Result<runner::CompareOutcome> {
    let trials = request.num_trials() as u64;
    let progress = Progress::new(telemetry, bars, "trials", trials);
    let watch = CompareWatch {
        stop,
        on_trial: &|_, trial| {
            progress.add(1);
            progress.add_steps(trial.result.steps);
        },
    };
    Ok(runner::compare(loaded, request, watch).map_err(Error::from)?)
}

/// What is said at the end: the numbers as JSON, or the table over all scenarios.
fn show_all(args: &cli::Compare, comparisons: &[Comparison]) {
    match comparisons {
        [one] if args.json => print_json(one),
        several if args.json => print_json(&Comparisons { scenarios: several }),
        [_] => {}
        several => print(&render_overview(several, style(args))),
    }
}

fn style(args: &cli::Compare) -> TableStyle {
    super::table_style(args.markdown, args.wide)
}

fn existing(args: &cli::Compare) -> Existing {
    if args.resume {
        Existing::Resume
    } else if args.force {
        Existing::Replace
    } else {
        Existing::Refuse
    }
}
