//! `eigentrail sweep`

use super::Ending;
use super::progress::Progress;
use crate::cli;
use crate::output::{print, print_json};
use crate::signals;
use anyhow::Result;
use eigentrail::archive::Existing;
use eigentrail::error::Error;
use eigentrail::report::render_sweep;
use eigentrail::runner::{self, SweepPlan, SweepRequest, SweepWatch};
use eigentrail::telemetry::{Telemetry, say};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

pub fn sweep(args: &cli::Sweep, telemetry: &Telemetry, bars: bool) -> Result<Ending> {
    let plan = Arc::new(SweepPlan::of(request(args)).map_err(Error::from)?);
    let stop = signals::stop_flag();
    let progress = Progress::new(telemetry, bars, "trials", plan.num_trials() as u64);
    let ended = AtomicUsize::new(0);
    let watch = SweepWatch {
        stop: &stop,
        on_trial: &|trial| {
            ended.fetch_add(1, Ordering::Relaxed);
            progress.add(1);
            progress.add_steps(trial.result.steps);
        },
    };
    let existing = match args.force {
        true => Existing::Replace,
        false => Existing::Resume,
    };
    let swept = runner::sweep(&plan, args.out.as_deref(), existing, watch).map_err(Error::from)?;
    drop(progress);
    let folder = swept.folder.path().display();
    let Some((sweep, _)) = &swept.sweep else {
        let (name, done, all) = (plan.name(), ended.into_inner(), plan.num_trials());
        say(format!(
            "{name}: interrupted, {done} of {all} trials are finished in {folder}; the same command goes on"
        ));
        return Ok(Ending::Interrupted);
    };
    match args.json {
        true => print_json(sweep),
        false => {
            let style = super::table_style(args.markdown, args.wide);
            print(&render_sweep(sweep, style));
            print(&format!("written to {folder}"));
        }
    }
    Ok(Ending::Done)
}

fn request(args: &cli::Sweep) -> SweepRequest {
    SweepRequest {
        path: args.scenario.scenario.clone(),
        sets: args.scenario.sets.clone(),
        axes: args.grid.clone(),
        arms: super::without_duplicates(&args.arms),
        seeds: args.seeds.0.clone(),
        arguments: super::arguments(),
    }
}
