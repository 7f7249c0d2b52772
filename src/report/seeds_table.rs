//! The summary of several seeds of a run as people read it.

use super::fitted_table::{Column, TableStyle, render_columns};
use super::terminal::{amount, counts_steps, grouped, whole};
use crate::archive::{SeedResult, SeedTiming};
use crate::statistics::median;
use std::path::Path;

/// A row for each seed, the medians below them, and the folder. It fits 80 characters.
pub fn render_seeds<'a>(
    scenario: &str,
    seeds: impl Iterator<Item = (&'a SeedResult, &'a SeedTiming)>,
    folder: &Path,
) -> String {
    let (results, timings): (Vec<_>, Vec<_>) = seeds.unzip();
    let table = render_columns(
        &columns(&results, &timings),
        TableStyle::Terminal { width: usize::MAX },
    );
    let unfinished = results.iter().filter(|result| !result.finished).count();
    let interrupted = match unfinished {
        0 => String::new(),
        n => format!(", {n} of them interrupted"),
    };
    let optimal = results.first().map(|result| match result.optimal_return {
        Some(most) if !counts_steps(most, result.optimal_steps) => {
            format!(
                "; optimal: {:.1} steps, return {}",
                result.optimal_steps,
                amount(most)
            )
        }
        _ => format!("; optimal: {:.1} steps", result.optimal_steps),
    });
    format!(
        "{scenario}: {} seeds{interrupted}{}\n\n{table}\nlast: mean of the last tenth of the episodes\nwritten to {}",
        results.len(),
        optimal.unwrap_or_default(),
        folder.display()
    )
}

fn columns(results: &[&SeedResult], timings: &[&SeedTiming]) -> Vec<Column> {
    let real = |header: &str, show: &dyn Fn(f64) -> String, values: Vec<Option<f64>>| {
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
        column(header, cells)
    };
    let count = |number: f64| grouped(number.round() as u64);
    let of = |value: &dyn Fn(&SeedResult) -> Option<f64>| -> Vec<Option<f64>> {
        results.iter().map(|result| value(result)).collect()
    };
    let seeds = results.iter().map(|result| result.seed.to_string());
    let mut columns = vec![
        column("seed", seeds.chain(["median".to_owned()]).collect()),
        real("steps", &count, of(&|result| Some(result.steps as f64))),
        real(
            "first goal",
            &count,
            of(&|result| result.first_goal_step.map(|step| step as f64)),
        ),
        real("regret", &whole, of(&|result| Some(result.regret))),
        real(
            "last steps",
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
            &amount,
            of(&|result| result.final_return),
        ));
    }
    columns.push(real(
        "states",
        &count,
        of(&|result| Some(result.nodes as f64)),
    ));
    let speeds = timings.iter().map(|timing| Some(timing.steps_per_second));
    columns.push(real("steps/s", &count, speeds.collect()));
    columns
}

fn column(header: &str, cells: Vec<String>) -> Column {
    Column {
        header: header.to_owned(),
        cells,
        rank: 0,
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
        };
        (result, timing)
    }

    fn rendered(seeds: &[(SeedResult, SeedTiming)]) -> String {
        let seeds = seeds.iter().map(|(result, timing)| (result, timing));
        render_seeds("four_rooms", seeds, Path::new("runs/x"))
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
}
