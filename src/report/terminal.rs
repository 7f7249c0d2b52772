//! The summary of a run as people read it.

use super::sparkline::sparkline;
use super::summary::{SeedResult, SeedTiming};
use comfy_table::{CellAlignment, Table, presets};
use std::fmt::Write;
use std::path::Path;

/// Blocks of the curve.
const CURVE_WIDTH: usize = 48;

/// A table of one seed's results, with the curve of its episode lengths and the folder.
pub fn render_run(
    scenario: &str,
    result: &SeedResult,
    timing: &SeedTiming,
    steps_per_episode: &[u32],
    folder: &Path,
) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_header(vec!["scenario".to_owned(), scenario.to_owned()]);
    table.add_rows(rows(result, timing).map(|(name, value)| vec![name.to_owned(), value]));
    if let Some(values) = table.column_mut(1) {
        values.set_cell_alignment(CellAlignment::Right);
    }
    let mut text = table.trim_fmt();
    text.push('\n');
    if let (Some(first), Some(last)) = (steps_per_episode.first(), steps_per_episode.last()) {
        let curve = sparkline(steps_per_episode, CURVE_WIDTH);
        let _ = writeln!(text, "steps per episode (log)  {first} {curve} {last}");
    }
    let _ = write!(text, "written to {}", folder.display());
    text
}

fn rows(result: &SeedResult, timing: &SeedTiming) -> impl Iterator<Item = (&'static str, String)> {
    let ratio = result.final_mean_steps / result.optimal_steps;
    let episodes = if result.finished {
        ""
    } else {
        " (interrupted)"
    };
    let first_goal = match result.first_goal_step {
        Some(step) => format!("step {}", grouped(step)),
        None => "never".to_owned(),
    };
    let moved = match result.goals_moved_after {
        Some(after) => format!(", goals moved after {}", grouped(after as u64)),
        None => String::new(),
    };
    [
        ("seed", result.seed.to_string()),
        (
            "episodes",
            format!("{}{episodes}{moved}", grouped(result.episodes as u64)),
        ),
        ("steps", grouped(result.steps)),
        ("first goal", first_goal),
        ("regret", grouped_real(result.regret)),
        (
            "final episodes against optimal",
            format!(
                "{:.1} / {:.1} steps = {ratio:.2}",
                result.final_mean_steps, result.optimal_steps
            ),
        ),
        (
            "graph",
            format!(
                "{} states, {} edges",
                grouped(result.nodes as u64),
                grouped(result.edges as u64)
            ),
        ),
        (
            "spectrum refreshes",
            grouped(result.spectrum_refreshes as u64),
        ),
        ("fits of the potential", grouped(result.gcn_fits as u64)),
        (
            "speed",
            format!(
                "{:.2} s, {} steps/s",
                timing.wall_seconds,
                grouped(timing.steps_per_second.round() as u64)
            ),
        ),
    ]
    .into_iter()
}

/// 1 234 567, with narrow gaps.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// The same for a real number, to a tenth, without a needless ".0".
fn grouped_real(number: f64) -> String {
    let tenths = (number.abs() * 10.0).round() as u64;
    let sign = if number < 0.0 && tenths > 0 { "-" } else { "" };
    match tenths % 10 {
        0 => format!("{sign}{}", grouped(tenths / 10)),
        tenth => format!("{sign}{}.{tenth}", grouped(tenths / 10)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_grouped_by_three() {
        assert_eq!(grouped(7), "7");
        assert_eq!(grouped(1234), "1 234");
        assert_eq!(grouped(123456), "123 456");
        assert_eq!(grouped_real(-1234.56), "-1 234.6");
        assert_eq!(grouped_real(-0.01), "0");
        assert_eq!(grouped_real(20.0), "20");
    }

    #[test]
    fn a_run_reads_well() {
        let result = SeedResult {
            seed: 3,
            finished: true,
            episodes: 500,
            steps: 12_345,
            regret: 1_250.5,
            optimal_steps: 20.0,
            goals_moved_after: None,
            final_mean_steps: 21.5,
            first_goal_step: Some(321),
            nodes: 104,
            edges: 188,
            spectrum_refreshes: 9,
            gcn_fits: 8,
        };
        let timing = SeedTiming {
            seed: 3,
            wall_seconds: 0.5,
            steps_per_second: 24_690.0,
        };
        let text = render_run(
            "four-rooms",
            &result,
            &timing,
            &[321, 60, 20],
            Path::new("runs/x"),
        );
        insta::assert_snapshot!(text, @"
        ┌────────────────────────────────┬──────────────────────────┐
        │ scenario                       ┆               four-rooms │
        ╞════════════════════════════════╪══════════════════════════╡
        │ seed                           ┆                        3 │
        │ episodes                       ┆                      500 │
        │ steps                          ┆                   12 345 │
        │ first goal                     ┆                 step 321 │
        │ regret                         ┆                  1 250.5 │
        │ final episodes against optimal ┆ 21.5 / 20.0 steps = 1.07 │
        │ graph                          ┆    104 states, 188 edges │
        │ spectrum refreshes             ┆                        9 │
        │ fits of the potential          ┆                        8 │
        │ speed                          ┆   0.50 s, 24 690 steps/s │
        └────────────────────────────────┴──────────────────────────┘
        steps per episode (log)  321 █▄▁ 20
        written to runs/x
        ");
    }
}
