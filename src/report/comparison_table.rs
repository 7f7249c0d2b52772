//! Comparisons as people read them: a table for each world, and one over all worlds.

use super::fitted_table::{Column, TableStyle, fitting, render_columns, width_of, wrapped};
use super::terminal::{amount, counts_steps, grouped, whole};
use crate::archive::{ArmDifference, ArmSummary, Comparison, IqmInterval, MedianInterval, Moments};
use crate::statistics::{EQUIVALENCE_MARGIN, Verdict};
use std::fmt::Write;

/// One world: a row for each arm, and below it what the columns refer to. Columns that do not fit are left out.
pub fn render_comparison(comparison: &Comparison, style: TableStyle) -> String {
    let (columns, left_out) = fitting(columns(comparison), style);
    let title = wrapped(&title(comparison), style.width());
    let table = render_columns(&columns, style);
    let mut notes = String::from("[ ]: 95 % interval, of medians exact, of regret by bootstrap.");
    for column in columns.iter().filter(|column| !column.note.is_empty()) {
        notes += " ";
        notes += &column.note;
    }
    notes.push('\n');
    notes += &circumstances(comparison);
    if left_out > 0 {
        let _ = writeln!(
            notes,
            "{left_out} more columns: --wide, --markdown, or report.html."
        );
    }
    format!("{title}\n{table}\n{}", wrapped(&notes, style.width()))
}

/// All worlds: ratios to the sparse arm, a column for each arm; where they do not all fit, several tables below each other.
pub fn render_overview(comparisons: &[Comparison], style: TableStyle) -> String {
    let Some(first) = comparisons.first() else {
        return String::new();
    };
    let column = |header: &str, cells: Vec<String>| Column {
        header: header.to_owned(),
        cells,
        rank: 0,
        note: String::new(),
    };
    let worlds = || {
        let names = comparisons.iter().map(|one| one.scenario.clone());
        column("regret ÷ sparse", names.collect())
    };
    let arms = (0..first.arms.len()).map(|arm| {
        let ratios = comparisons
            .iter()
            .map(|one| ratio(&one.arms[arm].ratio_to_sparse));
        column(&first.arms[arm].name, ratios.collect())
    });
    let mut text = String::new();
    let mut beside = vec![worlds()];
    for arm in arms {
        let used: usize = 1 + beside.iter().map(width_of).sum::<usize>();
        if beside.len() > 1 && used + width_of(&arm) > style.width() {
            text += &render_columns(&beside, style);
            beside = vec![worlds()];
        }
        beside.push(arm);
    }
    text += &render_columns(&beside, style);
    text.push_str("\nMedians over seeds, with exact 95 % intervals.\n");
    text
}

/// What is known of the arms, and which of it comes first where there is little room.
fn columns(comparison: &Comparison) -> Vec<Column> {
    let optimal_return = comparison.optimal_return;
    let mut columns = Vec::new();
    let mut add = |rank, header: &str, note: &str, cell: &dyn Fn(&ArmSummary) -> String| {
        columns.push(Column {
            header: header.to_owned(),
            cells: comparison.arms.iter().map(cell).collect(),
            rank,
            note: note.to_owned(),
        });
    };
    add(0, "arm", "", &|arm| arm.name.clone());
    add(2, "regret", "regret: interquartile mean.", &|arm| {
        whole(arm.regret.iqm)
    });
    add(9, "regret, 95 %", "", &|arm| interval(&arm.regret));
    add(1, "÷ sparse", "", &|arm| ratio(&arm.ratio_to_sparse));
    if comparison.tuning.is_some() {
        add(2, "÷ tuned", "", &|arm| {
            arm.ratio_to_tuned_sparse.as_ref().map_or_else(dash, ratio)
        });
    }
    if let Some(difference) = comparison.differences.first() {
        add(5, "paired", &paired_note(difference), &|arm| {
            paired(comparison.difference(&arm.name))
        });
    }
    add(
        6,
        "first goal",
        "first goal: median environment steps, – if half of the seeds or more never get there.",
        &|arm| moments(&arm.first_goal_step),
    );
    add(8, "to 1.1×", to_1_1x_note(optimal_return), &|arm| {
        moments(&arm.steps_to_1_1x)
    });
    add(7, "final", final_note(optimal_return), &|arm| {
        final_cell(&arm.final_return, arm.final_ratio, optimal_return)
    });
    add(
        4,
        "greedy",
        "greedy: exact return of the final greedy policy, median.",
        &|arm| greedy_cell(&arm.greedy_return, optimal_return),
    );
    add(
        3,
        "failed",
        "failed: seeds whose greedy return is below R* − 0.05 |R*|.",
        &|arm| arm.failures.map_or_else(dash, percent),
    );
    add(10, "false maxima", "", &|arm| {
        arm.spurious_maxima.map_or_else(dash, |n| n.to_string())
    });
    let steps_take = comparison.timing.iter();
    let microseconds = steps_take.map(|arm| format!("{:.2}", 1e6 / arm.median.steps_per_second));
    columns.push(Column {
        header: "µs a step".to_owned(),
        cells: microseconds.collect(),
        rank: 11,
        note: String::new(),
    });
    columns
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
pub(super) fn final_cell(
    final_return: &MedianInterval,
    final_ratio: f64,
    optimal_return: f64,
) -> String {
    match final_return.median {
        Some(earned) if optimal_return >= 0.0 => {
            format!("{} of {}", amount(earned), amount(optimal_return))
        }
        _ => times(final_ratio),
    }
}

/// A ratio, as a power of ten where it is beyond counting.
fn times(ratio: f64) -> String {
    match ratio.abs() {
        ..1e6 => format!("{ratio:.2}"),
        _ => format!("{ratio:.1e}"),
    }
}

/// What the differences to the default say.
fn paired_note(difference: &ArmDifference) -> String {
    let against = &difference.against;
    let margin = 100.0 * EQUIVALENCE_MARGIN;
    format!(
        "paired: regret − that of {against} with the same seed, median in shares of what {against} has; < less, > more, \
         = within {margin:.0} %, ? nothing is shown, all together with 95 %."
    )
}

/// What is said of seeds, moved goals and the arms that everything is compared with.
fn circumstances(comparison: &Comparison) -> String {
    let mut text = String::new();
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

/// What is near the optimum R*.
fn to_1_1x_note(optimal_return: f64) -> &'static str {
    if optimal_return < 0.0 {
        "to 1.1×: environment steps until the mean return of 20 episodes ≥ 1.1 R*."
    } else if optimal_return > 0.0 {
        "to 1.1×: environment steps until the mean return of 20 episodes ≥ 0.9 R*."
    } else {
        "to 1.1×: environment steps until the mean return of 20 episodes ≥ −0.1 × the largest |reward|."
    }
}

/// What the last episodes are held against.
fn final_note(optimal_return: f64) -> &'static str {
    if optimal_return < 0.0 {
        "final: return of the last episodes ÷ R*."
    } else {
        "final: return of the last episodes, of R*."
    }
}

pub(super) fn dash() -> String {
    "–".to_owned()
}

pub(super) fn iqm(value: &IqmInterval) -> String {
    format!("{} {}", whole(value.iqm), interval(value))
}

pub(super) fn interval(value: &IqmInterval) -> String {
    format!("[{}, {}]", whole(value.low), whole(value.high))
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
pub(super) fn ranges(seeds: &[u64]) -> String {
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
    use crate::archive::{ArmTiming, ProbabilityInterval, TrialTiming};

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
            "| gcn |  1 234 | [990, 1 501] | 0.035 [0.0031, 1.50] |        321 |       – |  1.05 |  -20.0 |   25 % |            – |     25.00 |",
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

    /// As [`comparison`], with ten arms of the program's own.
    fn ten_arms() -> Comparison {
        let mut ten = comparison();
        let (arm, timing) = (ten.arms.remove(0), ten.timing.remove(0));
        let names = [
            "sparse",
            "gcn",
            "heat",
            "no-shaping",
            "look-ahead",
            "actor-critic-shaped",
            "actor-critic-unshaped",
            "planner-frontier",
            "mbie-eb",
            "q-learning",
        ];
        for (name, scale) in names.iter().zip(1..) {
            let scale = f64::from(scale * scale);
            let mut arm = arm.clone();
            (*name).clone_into(&mut arm.name);
            arm.regret.iqm *= scale;
            arm.regret.low *= scale;
            arm.regret.high *= scale;
            arm.spurious_maxima = Some(0);
            ten.arms.push(arm);
            ten.timing.push(ArmTiming {
                name: (*name).to_owned(),
                ..timing.clone()
            });
        }
        ten
    }

    #[test]
    fn ten_arms_fit_eighty_columns() {
        let text = render_comparison(&ten_arms(), TableStyle::Terminal { width: 80 });
        assert!(
            text.lines().all(|line| line.chars().count() <= 80),
            "{text}"
        );
        insta::assert_snapshot!(text);
    }

    #[test]
    fn where_there_is_room_every_column_is_shown() {
        let text = render_comparison(&ten_arms(), TableStyle::Terminal { width: usize::MAX });
        for header in ["regret, 95 %", "to 1.1×", "false maxima", "µs a step"] {
            assert!(text.contains(header), "no {header} in\n{text}");
        }
        assert!(!text.contains("more columns"), "{text}");
    }

    #[test]
    fn arms_that_do_not_fit_come_in_tables_below_each_other() {
        let worlds = [ten_arms(), ten_arms()];
        let text = render_overview(&worlds, TableStyle::Terminal { width: 80 });
        assert!(
            text.lines().all(|line| line.chars().count() <= 80),
            "{text}"
        );
        for arm in &worlds[0].arms {
            let mut cells = text.split(['┆', '│', '\n']).map(str::trim);
            assert!(cells.any(|cell| cell == arm.name), "{text}");
        }
    }

    #[test]
    fn the_overview_has_a_row_for_each_world() {
        let worlds = [comparison(), comparison()];
        let text = render_overview(&worlds, TableStyle::Terminal { width: 80 });
        assert_eq!(
            text.matches("│ four-rooms      ┆ 0.035 [0.0031, 1.50] │")
                .count(),
            2,
            "{text}"
        );
    }
}
