//! Comparisons as people read them: a table for each world, and one over all worlds.

use super::terminal::{amount, counts_steps, grouped, whole};
use crate::archive::{
    ArmDifference, ArmSummary, ArmTiming, Comparison, IqmInterval, MedianInterval, Moments,
};
use crate::statistics::{EQUIVALENCE_MARGIN, Verdict};
use comfy_table::{CellAlignment, Table, presets};
use std::fmt::Write;

/// Style of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TableStyle {
    /// With lines.
    #[default]
    Terminal,
    /// For documents.
    Markdown,
}

/// One world: a row for each arm, and below it what the columns refer to.
pub fn render_comparison(comparison: &Comparison, style: TableStyle) -> String {
    let mut header = vec!["arm", "regret (IQM)", "÷ sparse"];
    if comparison.tuning.is_some() {
        header.push("÷ tuned");
    }
    if !comparison.differences.is_empty() {
        header.push("paired");
    }
    header.extend([
        "first goal",
        "to 1.1×",
        "final",
        "greedy",
        "failed",
        "false max.",
        "µs a step",
    ]);
    let mut table = table(style, header);
    for (arm, timing) in comparison.arms.iter().zip(&comparison.timing) {
        table.add_row(row(arm, timing, comparison));
    }
    let mut text = format!("{}\n\n", title(comparison));
    text += &align_right(table);
    text.push('\n');
    text + &notes(comparison)
}

/// All worlds: ratios to the sparse arm, a column for each arm.
pub fn render_overview(comparisons: &[Comparison], style: TableStyle) -> String {
    let Some(first) = comparisons.first() else {
        return String::new();
    };
    let names = || first.arms.iter().map(|arm| arm.name.as_str());
    let mut table = table(style, ["regret ÷ sparse"].into_iter().chain(names()));
    for comparison in comparisons {
        let ratios = comparison
            .arms
            .iter()
            .map(|arm| ratio(&arm.ratio_to_sparse));
        table.add_row([comparison.scenario.clone()].into_iter().chain(ratios));
    }
    let mut text = align_right(table);
    text.push_str("\nMedians over seeds, with exact 95 % intervals.\n");
    text
}

fn table<T: Into<comfy_table::Cell>>(
    style: TableStyle,
    header: impl IntoIterator<Item = T>,
) -> Table {
    let mut table = Table::new();
    table.load_style(match style {
        TableStyle::Terminal => presets::UTF8_FULL_CONDENSED,
        TableStyle::Markdown => presets::ASCII_MARKDOWN,
    });
    table.set_header(header);
    table
}

/// Numbers to the right.
fn align_right(mut table: Table) -> String {
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt() + "\n"
}

fn title(comparison: &Comparison) -> String {
    let since = match comparison.goals_moved_after {
        Some(_) => " since the goals moved",
        None => "",
    };
    let (most, steps) = (comparison.optimal_return, comparison.optimal_steps);
    let earns = match counts_steps(most, steps) {
        true => String::new(), // −1 a step: the steps say it
        false => format!(", return {}", amount(most)),
    };
    format!(
        "{}: {} seeds ({}), {} episodes each, optimal episode {steps:.1} steps{earns}{since}",
        comparison.scenario,
        comparison.seeds.len(),
        ranges(&comparison.seeds),
        grouped(comparison.episodes as u64),
    )
}

fn row(arm: &ArmSummary, timing: &ArmTiming, comparison: &Comparison) -> Vec<String> {
    let mut cells = vec![
        arm.name.clone(),
        iqm(&arm.regret),
        ratio(&arm.ratio_to_sparse),
    ];
    if comparison.tuning.is_some() {
        cells.push(arm.ratio_to_tuned_sparse.as_ref().map_or_else(dash, ratio));
    }
    if !comparison.differences.is_empty() {
        cells.push(paired(comparison.difference(&arm.name)));
    }
    cells.extend([
        moments(&arm.first_goal_step),
        moments(&arm.steps_to_1_1x),
        final_cell(arm, comparison.optimal_return),
        greedy_cell(&arm.greedy_return, comparison.optimal_return),
        arm.failures.map_or_else(dash, percent),
        arm.spurious_maxima.map_or_else(dash, |n| n.to_string()),
        format!("{:.2}", 1e6 / timing.median.steps_per_second),
    ]);
    cells
}

/// A difference in per cent, and what it shows.
fn paired(difference: Option<&ArmDifference>) -> String {
    let Some(ArmDifference { share, verdict, .. }) = difference else {
        return dash();
    };
    let sign = match verdict {
        Verdict::Equivalent => "=",
        Verdict::Less => "<",
        Verdict::More => ">",
        Verdict::Open => "?",
    };
    let share = share.median.unwrap_or_default();
    match share.abs() {
        ..9.995 => format!("{sign} {:+.0} %", 100.0 * share),
        _ => format!("{sign} {:+.0}×", share),
    }
}

/// The exact return of the greedy policy, beside R* where that is not a cost.
pub(super) fn greedy_cell(value: &MedianInterval, optimal_return: f64) -> String {
    match value.median {
        None => dash(),
        Some(earned) if optimal_return < 0.0 => amount(earned),
        Some(earned) => format!("{} of {}", amount(earned), amount(optimal_return)),
    }
}

/// A share of seeds.
pub(super) fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// The return of the last episodes ÷ R* where both are costs, so that more is worse; "0.31 of 1.00" where the best policy
/// earns something, or nothing.
pub(super) fn final_cell(arm: &ArmSummary, optimal_return: f64) -> String {
    match arm.final_return.median {
        Some(earned) if optimal_return >= 0.0 => {
            format!("{} of {}", amount(earned), amount(optimal_return))
        }
        _ => times(arm.final_ratio),
    }
}

/// A ratio, as a power of ten where it is beyond counting.
fn times(ratio: f64) -> String {
    match ratio.abs() {
        ..1e6 => format!("{ratio:.2}"),
        _ => format!("{ratio:.1e}"),
    }
}

/// What the columns mean and refer to.
fn notes(comparison: &Comparison) -> String {
    let mut text = String::from(
        "[ ]: 95 % interval, of medians exact, of IQM by bootstrap. first goal, to 1.1×: median environment steps, – if half of \
         the seeds or more never get there.",
    );
    text += nearness(comparison.optimal_return);
    text += " greedy: exact return of the final greedy policy, median. failed: seeds in which it is below R* − 0.05 |R*|.\n";
    if let Some(difference) = comparison.differences.first() {
        let _ = writeln!(
            text,
            "paired: regret − that of {} with the same seed, median in shares of what {} has; < less, > more, = within \
             {:.0} %, ? nothing is shown, all together with 95 %.",
            difference.against,
            difference.against,
            100.0 * EQUIVALENCE_MARGIN
        );
    }
    if comparison.seeds.len() < 6 {
        text += "With fewer than 6 seeds the intervals of medians hold all seeds, and are less sure than 95 %.\n";
    }
    if let Some(after) = comparison.goals_moved_after {
        let _ = writeln!(
            text,
            "The goals moved after {after} episodes: regret is against the goals in force in each episode; to 1.5×, to 1.1× \
             and final count from the move."
        );
    }
    let has_sparse = comparison.arms.iter().any(|arm| arm.name == "sparse");
    if !has_sparse {
        let _ = writeln!(
            text,
            "The sparse arm was run for the ratios: regret {}.",
            iqm(&comparison.sparse_regret)
        );
    }
    if let Some(tuning) = &comparison.tuning {
        let _ = writeln!(
            text,
            "Tuned sparse arm: critic {}, actor {}, the best of {} pairs over {} seeds ({}); regret {}.",
            tuning.chosen.critic_learning_rate,
            tuning.chosen.actor_learning_rate,
            tuning.tried.len(),
            tuning.seeds.len(),
            ranges(&tuning.seeds),
            iqm(&tuning.regret)
        );
    }
    text
}

/// What is near the optimum R*, and what "final" says.
fn nearness(optimal_return: f64) -> &'static str {
    if optimal_return < 0.0 {
        " to 1.1×: until the mean return of 20 episodes ≥ 1.1 R*. final: return of the last episodes ÷ R*."
    } else if optimal_return > 0.0 {
        " to 1.1×: until the mean return of 20 episodes ≥ 0.9 R*. final: return of the last episodes, of R*."
    } else {
        " to 1.1×: until the mean return of 20 episodes ≥ −0.1 × the largest |reward|. final: return of the last episodes, \
         of R*."
    }
}

pub(super) fn dash() -> String {
    "–".to_owned()
}

pub(super) fn iqm(value: &IqmInterval) -> String {
    format!(
        "{} [{}, {}]",
        whole(value.iqm),
        whole(value.low),
        whole(value.high)
    )
}

pub(super) fn ratio(value: &MedianInterval) -> String {
    match (value.median, value.low, value.high) {
        (Some(median), Some(low), Some(high)) => {
            format!("{} [{}, {}]", short(median), short(low), short(high))
        }
        _ => dash(),
    }
}

/// Three decimals for small ratios, two for large ones.
fn short(ratio: f64) -> String {
    match ratio.abs() {
        ..0.0095 => format!("{ratio:.4}"),
        ..0.95 => format!("{ratio:.3}"),
        _ => format!("{ratio:.2}"),
    }
}

pub(super) fn moments(moments: &Moments) -> String {
    moments
        .median
        .map_or_else(dash, |steps| grouped(steps.round() as u64))
}

/// 1000–1019 for runs of consecutive seeds.
fn ranges(seeds: &[u64]) -> String {
    let mut parts: Vec<(u64, u64)> = Vec::new();
    for &seed in seeds {
        match parts.last_mut() {
            Some((_, end)) if end.checked_add(1) == Some(seed) => *end = seed,
            _ => parts.push((seed, seed)),
        }
    }
    let part = |&(from, to): &(u64, u64)| match from == to {
        true => from.to_string(),
        false => format!("{from}–{to}"),
    };
    parts.iter().map(part).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::archive::{ProbabilityInterval, TrialTiming};

    fn comparison() -> Comparison {
        let never = Moments {
            median: None,
            reached: 1,
        };
        let at = |steps| Moments {
            median: Some(steps),
            reached: 3,
        };
        let gcn = ArmSummary {
            name: "gcn".to_owned(),
            regret: IqmInterval {
                iqm: 1234.4,
                low: 990.0,
                high: 1500.6,
            },
            ratio_to_sparse: MedianInterval {
                median: Some(0.0345),
                low: Some(0.00312),
                high: Some(1.5),
            },
            ratio_to_tuned_sparse: None,
            probability_of_improvement: ProbabilityInterval {
                value: 1.0,
                low: 0.9,
                high: 1.0,
            },
            first_goal_step: at(321.0),
            episodes_to_1_5x: at(25.0),
            steps_to_1_5x: at(1000.5),
            episodes_to_1_1x: never,
            steps_to_1_1x: never,
            final_return: MedianInterval {
                median: Some(-21.08),
                low: Some(-22.0),
                high: Some(-20.0),
            },
            final_ratio: 1.054,
            greedy_return: MedianInterval {
                median: Some(-20.0),
                low: Some(-20.0),
                high: Some(-20.0),
            },
            greedy_return_unadvised: MedianInterval {
                median: None,
                low: None,
                high: None,
            },
            failures: Some(0.25),
            failures_unadvised: None,
            worst_seed: 1001,
            gcn_epochs: 30.0,
            spurious_maxima: None,
        };
        Comparison {
            scenario: "four-rooms".to_owned(),
            seeds: vec![1000, 1001, 1002, 7],
            arms: vec![gcn],
            episodes: 500,
            optimal_steps: 20.0,
            optimal_return: -20.0,
            goals_moved_after: None,
            sparse_regret: IqmInterval {
                iqm: 10_350.0,
                low: 9_000.0,
                high: 12_000.0,
            },
            differences: Vec::new(),
            tuning: None,
            timing: vec![ArmTiming {
                name: "gcn".to_owned(),
                median: TrialTiming {
                    wall_seconds: 0.25,
                    spectrum_seconds: 0.1,
                    fit_seconds: 0.1,
                    rest_seconds: 0.05,
                    steps_per_second: 40_000.0,
                },
            }],
        }
    }

    #[test]
    fn a_comparison_reads_well() {
        let text = render_comparison(&comparison(), TableStyle::Markdown);
        for words in [
            "four-rooms: 4 seeds (1000–1002, 7), 500 episodes each, optimal episode 20.0 steps",
            "| gcn | 1 234 [990, 1 501] | 0.035 [0.0031, 1.50] |        321 |       – |  1.05 |  -20.0 |   25 % |          – |     25.00 |",
            "The sparse arm was run for the ratios: regret 10 350 [9 000, 12 000].",
        ] {
            assert!(text.contains(words), "no {words} in\n{text}");
        }
    }

    #[test]
    fn an_arm_that_earns_nothing_does_not_look_as_if_it_had_arrived() {
        let mut holes = comparison();
        holes.optimal_return = 1.0;
        holes.arms[0].final_ratio = 2.0;
        holes.arms[0].final_return.median = Some(0.0);
        let text = render_comparison(&holes, TableStyle::Markdown);
        for words in [
            "optimal episode 20.0 steps, return 1.00\n",
            "|       – | 0 of 1.00 |",
            "≥ 0.9 R*",
        ] {
            assert!(text.contains(words), "no {words} in\n{text}");
        }
        holes.optimal_return = -10.0;
        holes.arms[0].final_ratio = 1.3;
        let text = render_comparison(&holes, TableStyle::Markdown);
        assert!(text.contains("|       – |  1.30 |"), "{text}");
        assert!(
            text.contains("return -10.0\n") && text.contains("≥ 1.1 R*"),
            "{text}"
        );
    }

    #[test]
    fn differences_say_what_they_show() {
        let difference = |median: f64, verdict| ArmDifference {
            arm: "heat".to_owned(),
            against: "gcn".to_owned(),
            share: MedianInterval {
                median: Some(median),
                low: None,
                high: None,
            },
            confidence: 0.96,
            verdict,
        };
        let shown = |median, verdict| paired(Some(&difference(median, verdict)));
        assert_eq!(shown(0.042, Verdict::Equivalent), "= +4 %");
        assert_eq!(shown(-0.5, Verdict::Less), "< -50 %");
        assert_eq!(shown(57.3, Verdict::More), "> +57×");
        assert_eq!(paired(None), "–");
        let mut two = comparison();
        two.arms.push(two.arms[0].clone());
        two.arms[1].name = "heat".to_owned();
        two.timing.push(two.timing[0].clone());
        two.differences = vec![difference(0.3, Verdict::Open)];
        let text = render_comparison(&two, TableStyle::Markdown);
        assert!(
            text.contains("? +30 %") && text.contains("that of gcn"),
            "{text}"
        );
    }

    #[test]
    fn the_overview_has_a_row_for_each_world() {
        let worlds = [comparison(), comparison()];
        let text = render_overview(&worlds, TableStyle::Terminal);
        assert_eq!(
            text.matches("│ four-rooms      ┆ 0.035 [0.0031, 1.50] │")
                .count(),
            2,
            "{text}"
        );
    }
}
