//! The summary of several seeds of a run as people read it.

use super::fitted_table::{Column, TableStyle, fitting, render_columns, wrapped};
use super::terminal::{amount, counts_steps, grouped, whole};
use crate::archive::{SeedResult, SeedTiming};
use crate::statistics::median;
use std::path::Path;

/// A row for each seed, the medians below them, and the folder. Of the columns those that fit.
pub fn render_seeds<'a>(
    scenario: &str,
    seeds: impl Iterator<Item = (&'a SeedResult, &'a SeedTiming)>,
    folder: &Path,
    style: TableStyle,
) -> String {
    let (results, timings): (Vec<_>, Vec<_>) = seeds.unzip();
    let (columns, left_out) = fitting(columns(&results, &timings), style);
    let table = render_columns(&columns, style);
    let unfinished = results.iter().filter(|result| !result.finished).count();
    let interrupted = match unfinished {
        0 => String::new(),
        n => format!(", {n} of them interrupted"),
    };
    let notes = wrapped(&notes(&results, left_out), style.width());
    format!(
        "{scenario}: {} seeds{interrupted}\n\n{table}\n{notes}written to {}",
        results.len(),
        folder.display()
    )
}

/// What the columns mean, and the best there is.
fn notes(results: &[&SeedResult], left_out: usize) -> String {
    let mut notes = "last: mean of the last tenth of the episodes".to_owned();
    if let Some(optimal) = optimal(results) {
        notes += &format!("; {optimal}");
    }
    if left_out > 0 {
        notes +=
            &format!("\nnot shown for want of room: {left_out} of the columns; --json prints all");
    }
    notes
}

/// The best there is, if it is the same for all seeds: where goals are drawn, each has its own.
fn optimal(results: &[&SeedResult]) -> Option<String> {
    let first = results.first()?;
    let best = |result: &SeedResult| (result.optimal_steps, result.optimal_return);
    if results.iter().any(|result| best(result) != best(first)) {
        return None;
    }
    let steps = format!("optimal: {:.1} steps", first.optimal_steps);
    Some(match first.optimal_return {
        Some(most) if !counts_steps(most, first.optimal_steps) => {
            format!("{steps}, return {}", amount(most))
        }
        _ => steps,
    })
}

fn columns(results: &[&SeedResult], timings: &[&SeedTiming]) -> Vec<Column> {
    let real = |header: &str, rank: u8, show: &dyn Fn(f64) -> String, values: Vec<Option<f64>>| {
        let dash = || "–".to_owned();
        let mut cells: Vec<String> = values
            .iter()
            .map(|value| value.map_or_else(dash, show))
            .collect();
        // A seed that never got there took longer than any other.
        let values: Vec<f64> = values
            .iter()
            .map(|value| value.unwrap_or(f64::INFINITY))
            .collect();
        let middle = median(&values);
        cells.push(match middle.is_finite() {
            true => show(middle),
            false => dash(),
        });
        column(header, rank, cells)
    };
    let count = |number: f64| grouped(number.round() as u64);
    let of = |value: &dyn Fn(&SeedResult) -> Option<f64>| -> Vec<Option<f64>> {
        results.iter().map(|result| value(result)).collect()
    };
    let seeds = results.iter().map(|result| result.seed.to_string());
    let mut columns = vec![
        column("seed", 0, seeds.chain(["median".to_owned()]).collect()),
        real("steps", 2, &count, of(&|result| Some(result.steps as f64))),
        real(
            "first goal",
            1,
            &count,
            of(&|result| result.first_goal_step.map(|step| step as f64)),
        ),
        real("regret", 1, &whole, of(&|result| Some(result.regret))),
        real(
            "last steps",
            1,
            &|steps| format!("{steps:.1}"),
            of(&|result| Some(result.final_mean_steps)),
        ),
    ];
    let says_more = |result: &&SeedResult| {
        let earned = result.final_return;
        earned.is_some_and(|earned| !counts_steps(earned, result.final_mean_steps))
    };
    if results.iter().any(says_more) {
        columns.push(real(
            "last return",
            1,
            &amount,
            of(&|result| result.final_return),
        ));
    }
    columns.push(real(
        "states",
        3,
        &count,
        of(&|result| Some(result.nodes as f64)),
    ));
    let speeds = timings.iter().map(|timing| Some(timing.steps_per_second));
    columns.push(real("steps/s", 4, &count, speeds.collect()));
    columns
}

fn column(header: &str, rank: u8, cells: Vec<String>) -> Column {
    Column {
        header: header.to_owned(),
        cells,
        rank,
        note: String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seed(seed: u64, first_goal_step: Option<u64>) -> (SeedResult, SeedTiming) {
        let result = SeedResult {
            seed,
            finished: true,
            episodes: 500,
            steps: 12_345 + 1_000 * seed,
            regret: 1_250.5 * (seed + 1) as f64,
            optimal_steps: 20.0,
            goals_moved_after: None,
            final_mean_steps: 21.5,
            optimal_return: Some(-20.0),
            final_return: Some(-21.5),
            first_goal_step,
            nodes: 104,
            edges: 188,
            spectrum_refreshes: 9,
            gcn_fits: 8,
        };
        let timing = SeedTiming {
            seed,
            wall_seconds: 0.5,
            steps_per_second: 24_690.0,
            ..Default::default()
        };
        (result, timing)
    }

    fn rendered(seeds: &[(SeedResult, SeedTiming)]) -> String {
        let seeds = seeds.iter().map(|(result, timing)| (result, timing));
        let style = TableStyle::Terminal { width: 80 };
        render_seeds("four_rooms", seeds, Path::new("runs/x"), style)
    }

    #[test]
    fn seeds_read_well() {
        let seeds = [seed(0, Some(300)), seed(1, Some(500)), seed(2, None)];
        insta::assert_snapshot!(rendered(&seeds));
    }

    #[test]
    fn returns_are_shown_where_they_say_more_than_steps() {
        let mut seeds = [seed(0, None), seed(1, None), seed(2, Some(3))];
        for (result, _) in &mut seeds {
            (result.optimal_return, result.final_return) = (Some(1.0), Some(0.25));
        }
        seeds[1].0.finished = false;
        let text = rendered(&seeds);
        assert!(
            text.lines().all(|line| line.chars().count() <= 80),
            "{text}"
        );
        assert!(text.contains("1 of the columns"), "{text}");
        for words in [
            "last return",
            "0.25",
            "return 1.00",
            "1 of them interrupted",
        ] {
            assert!(text.contains(words), "no {words} in\n{text}");
        }
        let median = text.lines().find(|line| line.contains("median")).unwrap();
        assert!(
            median.contains('–'),
            "more than half never got there: {text}"
        );
    }

    #[test]
    fn the_best_is_told_if_it_is_the_same_for_all() {
        let mut seeds = [seed(0, None), seed(1, None)];
        assert!(rendered(&seeds).contains("optimal: 20.0 steps"));
        seeds[1].0.optimal_steps = 21.0;
        assert!(!rendered(&seeds).contains("optimal"));
    }
}
