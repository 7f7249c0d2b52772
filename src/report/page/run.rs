//! Runs as the arms of a page: means over seeds with Student's intervals.

use super::data::{Arm, Effort, PageData, Phases, command, short_band, tenths, with_interval};
use super::ground::map_of;
use super::names::{RunName, run_names, world_titles};
use super::sights::{Sights, short};
use super::{MAX_POINTS, PROGRAM};
use crate::archive::{EpisodeRow, RecordedRun, RecordedSeed, SeedResult};
use crate::report::band::{Band, interval};
use crate::report::terminal::{amount, counts_steps, grouped};
use crate::report::validity::validity;
use crate::statistics::blocks;
use std::ops::Range;

/// The page about `runs`, those of other worlds behind those of the first.
///
/// # Panics
/// If there are no runs.
pub(super) fn of_runs(runs: &[RecordedRun]) -> PageData {
    let mut worlds: Vec<Vec<&RecordedRun>> = Vec::new();
    for run in runs {
        let same = |world: &&mut Vec<&RecordedRun>| world[0].scenario.env == run.scenario.env;
        match worlds.iter_mut().find(same) {
            Some(world) => world.push(run),
            None => worlds.push(vec![run]),
        }
    }
    let firsts: Vec<&RecordedRun> = worlds.iter().map(|world| world[0]).collect();
    let titles = world_titles(&firsts).into_iter();
    let mut pages = titles
        .zip(&worlds)
        .map(|(title, runs)| of_world(title, runs));
    let first = pages.next().expect("there are runs");
    PageData {
        others: pages.collect(),
        ..first
    }
}

/// The page about runs of one world.
fn of_world(title: String, runs: &[&RecordedRun]) -> PageData {
    let names = run_names(runs);
    let headline = |(run, name): (&&RecordedRun, &RunName)| headline(run, &name.label);
    let headlines: Vec<String> = runs.iter().zip(&names).map(headline).collect();
    let named = runs.iter().zip(names);
    let arms: Vec<Arm> = named.map(|(run, name)| arm(run, name)).collect();
    let mut notes = vec![
        "Maps show at most 40 moments and curves blocks of episodes; the run folder has everything."
            .to_owned(),
    ];
    let more = arms.iter().filter_map(|arm| arm.sights.as_ref()?.note());
    notes.extend(more);
    notes.dedup();
    PageData {
        title,
        program: PROGRAM,
        headline: headlines.join("\n"),
        notes,
        statistic: "mean, 95 % interval over seeds",
        arms,
        others: Vec::new(),
    }
}

fn arm(run: &RecordedRun, name: RunName) -> Arm {
    let seed = &run.seeds[0];
    let last = seed.num_episodes().saturating_sub(1);
    let map = map_of(&run.scenario, seed.seed, last);
    let ends: Vec<Vec<usize>> = run.seeds.iter().map(RecordedSeed::ends).collect();
    let common = ends.iter().map(|ends| ends.last().copied().unwrap_or(0));
    let blocks = blocks(common.min().unwrap_or(0), MAX_POINTS);
    let rows =
        |seed: usize, block: &Range<usize>| &run.seeds[seed].episodes[rows_of(&ends[seed], block)];
    // Means over the episodes of each block.
    let mean = |value: fn(&EpisodeRow) -> f64| {
        short_band(Band::over(run.seeds.len(), blocks.len(), |seed, i| {
            let rows = rows(seed, &blocks[i]);
            let episodes: usize = rows.iter().map(|row| row.episodes).sum();
            rows.iter().map(value).sum::<f64>() / episodes as f64
        }))
    };
    let mut facts = facts(run);
    if name.whole != run.name {
        facts.insert(0, ("folder", run.name.clone()));
    }
    Arm {
        about: None,
        name: name.whole,
        label: name.label,
        command: command(&run.arguments),
        resolved: run.resolved.clone(),
        seeds: run.seeds.iter().map(|seed| seed.seed).collect(),
        facts,
        length: mean(|row| row.length as f64),
        // The regret of a block is that at its end.
        regret: short_band(Band::over(run.seeds.len(), blocks.len(), |seed, i| {
            rows(seed, &blocks[i]).last().map_or(0.0, |row| row.regret)
        })),
        plain: Some(mean(|row| row.plain_return)),
        shaped: Some(mean(|row| row.shaped_return)),
        episodes: blocks.into_iter().map(|block| block.end).collect(),
        versus: None,
        phases: phases(run),
        checks: validity(&run.scenario, seed),
        sights: Some(Sights::new(seed, map.as_ref())),
        solver: efforts(seed),
    }
}

/// The rows that end in a block, up to the one that holds its last episode.
fn rows_of(ends: &[usize], block: &Range<usize>) -> Range<usize> {
    let last = ends.partition_point(|&end| end < block.end);
    let first = ends.partition_point(|&end| end <= block.start);
    first.min(last)..last + 1
}

/// What came of a run, in a sentence.
fn headline(run: &RecordedRun, name: &str) -> String {
    let last = |value: fn(&SeedResult) -> f64| {
        let values: Vec<f64> = run.summary.seeds.iter().map(value).collect();
        interval(&values).0
    };
    let found = run.summary.seeds.iter().filter_map(|s| s.first_goal_step);
    let goal = match found.min() {
        Some(step) => format!("first goal after {} steps", grouped(step)),
        None => "no goal".to_owned(),
    };
    let (steps, fewest) = (last(|s| s.final_mean_steps), last(|s| s.optimal_steps));
    let returns = over_known(run, |s| s.final_return).zip(over_known(run, |s| s.optimal_return));
    let earned = match returns {
        Some(((earned, ..), (most, ..)))
            if !(counts_steps(earned, steps) && counts_steps(most, fewest)) =>
        {
            format!("return {} of {} and ", amount(earned), amount(most))
        }
        _ => String::new(),
    };
    format!(
        "{name}: {goal}; at the end {earned}{} steps an episode, {} are optimal.",
        tenths(steps),
        tenths(fewest),
    )
}

/// Mean and interval over seeds; none if an earlier version, which did not note it, ran one of them.
fn over_known(run: &RecordedRun, value: fn(&SeedResult) -> Option<f64>) -> Option<(f64, f64, f64)> {
    let values: Option<Vec<f64>> = run.summary.seeds.iter().map(value).collect();
    Some(interval(&values?))
}

fn facts(run: &RecordedRun) -> Vec<(&'static str, String)> {
    let over = |value: fn(&SeedResult) -> f64| {
        let values: Vec<f64> = run.summary.seeds.iter().map(value).collect();
        with_interval(interval(&values))
    };
    let seconds: Vec<f64> = run
        .summary
        .timing
        .seeds
        .iter()
        .map(|t| t.wall_seconds)
        .collect();
    let found = (run.summary.seeds.iter()).filter(|s| s.first_goal_step.is_some());
    let mut facts = vec![
        ("seeds", run.seeds.len().to_string()),
        ("episodes", over(|s| s.episodes as f64)),
        ("steps", over(|s| s.steps as f64)),
        ("regret (reward)", over(|s| s.regret)),
        ("final steps", over(|s| s.final_mean_steps)),
        ("optimal steps", over(|s| s.optimal_steps)),
        ("seeds with a first goal", found.count().to_string()),
        ("states discovered", over(|s| s.nodes as f64)),
        ("spectrum refreshes", over(|s| s.spectrum_refreshes as f64)),
        ("fits of the potential", over(|s| s.gcn_fits as f64)),
    ];
    let returns = [
        ("optimal return", over_known(run, |s| s.optimal_return)),
        ("final return", over_known(run, |s| s.final_return)),
    ];
    for (name, value) in returns {
        if let Some((mean, low, high)) = value {
            let text = match high > low {
                true => format!("{} [{}, {}]", amount(mean), amount(low), amount(high)),
                false => amount(mean),
            };
            facts.insert(4, (name, text));
        }
    }
    if let Some(after) = run.summary.seeds.iter().find_map(|s| s.goals_moved_after) {
        let note = format!("after {after} episodes; map, optimal and last episodes: since then");
        facts.insert(2, ("goals moved", note));
    }
    if !seconds.is_empty() {
        let (mean, ..) = interval(&seconds);
        facts.push(("seconds", format!("{mean:.2}")));
    }
    facts
}

/// Means over seeds of where the time went; nothing if the clock's file is gone.
fn phases(run: &RecordedRun) -> Option<Phases> {
    let mean = |part: fn(&RecordedSeed) -> Option<f64>| {
        let values: Option<Vec<f64>> = run.seeds.iter().map(part).collect();
        Some(interval(&values?).0)
    };
    let spectrum = mean(|seed| Some(seed.seconds?.spectrum))?;
    let fit = mean(|seed| Some(seed.seconds?.fit))?;
    let whole = mean(|seed| Some(seed.seconds?.episodes))?;
    Some(Phases {
        spectrum,
        fit,
        rest: (whole - spectrum - fit).max(0.0),
    })
}

fn efforts(seed: &RecordedSeed) -> Vec<Effort> {
    let stride = seed.refreshes.len().div_ceil(MAX_POINTS).max(1);
    (seed.refreshes.iter().step_by(stride))
        .map(|row| Effort {
            step: row.step,
            applications: row.applications,
            solves: row.solves,
            residual: row.max_relative_residual.map(short),
            loss: row.loss.map(short),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_has_the_rows_that_end_in_it() {
        let single: Vec<usize> = (1..=6).collect();
        assert_eq!(rows_of(&single, &(2..5)), 2..5);
        // Rows of 1, 1, 2 and 2 episodes.
        let merged = [1, 2, 4, 6];
        assert_eq!(rows_of(&merged, &(0..2)), 0..2);
        assert_eq!(rows_of(&merged, &(2..6)), 2..4);
        // Narrower than a row: the row that holds it.
        assert_eq!(rows_of(&merged, &(2..3)), 2..3);
        assert_eq!(rows_of(&merged, &(5..6)), 3..4);
    }
}
