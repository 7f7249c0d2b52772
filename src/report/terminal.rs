//! The summary of a run as people read it.

use super::sparkline::sparkline;
use crate::archive::{SeedResult, SeedTiming};
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
        ("final episodes against optimal", against_optimal(result)),
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
        ("of which", phases(timing)),
    ]
    .into_iter()
}

/// Where most of the time goes that steps do not take.
fn phases(timing: &SeedTiming) -> String {
    format!(
        "fits {:.2} s, spectra {:.2} s",
        timing.fit_seconds, timing.spectrum_seconds
    )
}

/// Steps, and with them returns where these say more than steps do.
fn against_optimal(result: &SeedResult) -> String {
    let (steps, best) = (result.final_mean_steps, result.optimal_steps);
    let lengths = format!("{steps:.1} / {best:.1} steps");
    match (result.final_return, result.optimal_return) {
        (Some(earned), Some(most))
            if !(counts_steps(earned, steps) && counts_steps(most, best)) =>
        {
            format!("return {} of {}, {lengths}", amount(earned), amount(most))
        }
        _ => format!("{lengths} = {:.2}", steps / best),
    }
}

/// Whether a mean return is −1 times a mean length, but for rounding.
pub(super) fn counts_steps(mean_return: f64, mean_steps: f64) -> bool {
    (mean_return + mean_steps).abs() <= 1e-9 * mean_steps
}

/// A return, to about three digits.
pub(super) fn amount(number: f64) -> String {
    match number.abs() {
        0.0 => "0".to_owned(),
        ..0.01 => format!("{number:.1e}"),
        ..9.995 => format!("{number:.2}"),
        ..999.95 => format!("{number:.1}"),
        _ => whole(number),
    }
}

/// A real number as a whole one; as a power of ten where no one counts digits any more.
pub(super) fn whole(number: f64) -> String {
    if number.abs() >= 1e15 {
        return format!("{number:.3e}");
    }
    let sign = if number <= -0.5 { "-" } else { "" };
    format!("{sign}{}", grouped(number.abs().round() as u64))
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
    if number.abs() >= 1e15 {
        return whole(number);
    }
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

    fn result() -> SeedResult {
        SeedResult {
            seed: 3,
            finished: true,
            episodes: 500,
            steps: 12_345,
            regret: 1_250.5,
            optimal_steps: 20.0,
            goals_moved_after: None,
            final_mean_steps: 21.5,
            optimal_return: None,
            final_return: None,
            first_goal_step: Some(321),
            nodes: 104,
            edges: 188,
            spectrum_refreshes: 9,
            gcn_fits: 8,
        }
    }

    #[test]
    fn digits_are_grouped_by_three() {
        assert_eq!(grouped(7), "7");
        assert_eq!(grouped(1234), "1 234");
        assert_eq!(grouped(123456), "123 456");
        assert_eq!(grouped_real(-1234.56), "-1 234.6");
        assert_eq!(grouped_real(-0.01), "0");
        assert_eq!(grouped_real(20.0), "20");
        assert_eq!(grouped_real(-1.5e24), "-1.500e24");
    }

    #[test]
    fn returns_have_about_three_digits() {
        let texts = [0.0, 1.0, -0.744, 12.34, -120.0, 2345.6, -0.0012, 2e18].map(amount);
        let expected = [
            "0", "1.00", "-0.74", "12.3", "-120.0", "2 346", "-1.2e-3", "2.000e18",
        ];
        assert_eq!(texts, expected);
        assert_eq!([-0.4, -0.5, 1234.5].map(whole), ["0", "-1", "1 235"]);
    }

    #[test]
    fn a_run_that_earns_nothing_does_not_look_short() {
        let mut result = result();
        (result.final_mean_steps, result.optimal_steps) = (1.0, 3.0);
        assert_eq!(against_optimal(&result), "1.0 / 3.0 steps = 0.33");
        (result.final_return, result.optimal_return) = (Some(0.0), Some(1.0));
        assert_eq!(
            against_optimal(&result),
            "return 0 of 1.00, 1.0 / 3.0 steps"
        );
        (result.final_return, result.optimal_return) = (Some(-1.0), Some(-3.0));
        assert_eq!(against_optimal(&result), "1.0 / 3.0 steps = 0.33");
    }

    #[test]
    fn a_run_reads_well() {
        let result = result();
        let timing = SeedTiming {
            seed: 3,
            wall_seconds: 0.5,
            steps_per_second: 24_690.0,
            spectrum_seconds: 0.1,
            fit_seconds: 0.25,
            rest_seconds: 0.15,
        };
        let text = render_run(
            "four-rooms",
            &result,
            &timing,
            &[321, 60, 20],
            Path::new("runs/x"),
        );
        insta::assert_snapshot!(text, @"
        ┌────────────────────────────────┬─────────────────────────────┐
        │ scenario                       ┆                  four-rooms │
        ╞════════════════════════════════╪═════════════════════════════╡
        │ seed                           ┆                           3 │
        │ episodes                       ┆                         500 │
        │ steps                          ┆                      12 345 │
        │ first goal                     ┆                    step 321 │
        │ regret                         ┆                     1 250.5 │
        │ final episodes against optimal ┆    21.5 / 20.0 steps = 1.07 │
        │ graph                          ┆       104 states, 188 edges │
        │ spectrum refreshes             ┆                           9 │
        │ fits of the potential          ┆                           8 │
        │ speed                          ┆      0.50 s, 24 690 steps/s │
        │ of which                       ┆ fits 0.25 s, spectra 0.10 s │
        └────────────────────────────────┴─────────────────────────────┘
        steps per episode (log)  321 █▄▁ 20
        written to runs/x
        ");
    }
}
