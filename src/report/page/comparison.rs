//! A comparison as a page: interquartile means over seeds with bootstrap intervals, medians with exact ones.

use super::PROGRAM;
use super::data::{Arm, PageData, Phases, Versus, command, short_band};
use super::ground::map_of;
use super::sights::Sights;
use crate::archive::{ArmSummary, ArmTiming, LearningCurve, RecordedArm, RecordedComparison};
use crate::report::band::Band;
use crate::report::comparison_table::{
    dash, final_cell, greedy_cell, iqm, moments, percent, ratio,
};
use crate::report::terminal::grouped;
use crate::report::validity::validity;
use crate::scenario::{BASELINE, BUILT_IN_ARMS};

/// The page about a comparison.
pub(super) fn of_comparison(recorded: &RecordedComparison) -> PageData {
    let summaries = recorded.numbers.arms.iter().zip(&recorded.numbers.timing);
    let arms: Vec<Arm> = (recorded.arms.iter().zip(summaries))
        .map(|(arm, (summary, timing))| of_arm(recorded, arm, summary, timing))
        .collect();
    let mut notes = vec![
        "Curves show blocks of episodes; maps show the first seed at up to 40 moments.".to_owned(),
    ];
    if let Some(after) = recorded.numbers.goals_moved_after {
        notes.push(format!(
            "The goals moved after {after} episodes: maps, approaches and last episodes are of those since."
        ));
    }
    if !arms.iter().any(|arm| arm.name == BASELINE) {
        let regret = iqm(&recorded.numbers.sparse_regret);
        notes.push(format!(
            "The {BASELINE} arm was run for the ratios: regret {regret}."
        ));
    }
    notes.extend(arms.iter().filter_map(|arm| arm.sights.as_ref()?.note()));
    notes.dedup();
    PageData {
        title: recorded.numbers.scenario.clone(),
        program: PROGRAM,
        headline: headline(recorded),
        notes,
        statistic: "interquartile mean, 95 % bootstrap interval over seeds",
        arms,
        others: Vec::new(),
    }
}

fn of_arm(
    recorded: &RecordedComparison,
    arm: &RecordedArm,
    summary: &ArmSummary,
    timing: &ArmTiming,
) -> Arm {
    let time = &timing.median;
    let last = recorded.numbers.episodes.saturating_sub(1);
    let sights = |seed| Sights::new(seed, map_of(&arm.scenario, seed.seed, last).as_ref());
    let sights = arm.first.as_ref().map(sights);
    let curves: Vec<&LearningCurve> = arm.trials.iter().map(|trial| &trial.curve).collect();
    let points = curves.iter().map(|curve| curve.episodes.len()).min();
    let points = points.unwrap_or(0);
    let band = |part: fn(&LearningCurve) -> &[f64]| {
        let value = |seed: usize, i: usize| part(curves[seed])[i];
        short_band(Band::robust(curves.len(), points, value))
    };
    Arm {
        name: arm.name.clone(),
        label: arm.name.clone(),
        about: Some(about(recorded, arm)),
        command: command(&recorded.about.arguments),
        resolved: arm.resolved.clone(),
        seeds: recorded.numbers.seeds.clone(),
        facts: facts(recorded, summary, timing),
        episodes: curves
            .first()
            .map_or(Vec::new(), |c| c.episodes[..points].to_vec()),
        length: band(|curve| &curve.length),
        regret: band(|curve| &curve.regret),
        plain: None,
        shaped: None,
        versus: Some(Versus {
            ratio: summary.ratio_to_sparse,
            improvement: summary.probability_of_improvement,
        }),
        phases: Some(Phases {
            spectrum: time.spectrum_seconds,
            fit: time.fit_seconds,
            rest: time.rest_seconds,
        }),
        checks: (arm.first.as_ref()).map_or(Vec::new(), |seed| validity(&arm.scenario, seed)),
        sights,
        solver: Vec::new(),
    }
}

/// What an arm is: in the words of the scenario or of the program, else by its settings.
fn about(recorded: &RecordedComparison, arm: &RecordedArm) -> String {
    if let Some(about) = &arm.about {
        return about.clone();
    }
    match BUILT_IN_ARMS.iter().find(|known| known.name == arm.name) {
        Some(known) => known.about.to_owned(),
        None => match recorded.about.arms.get(&arm.name) {
            Some(settings) if !settings.is_empty() => settings.join(", "),
            _ => "the scenario as it stands".to_owned(),
        },
    }
}

/// The arm with the least regret, in a sentence.
fn headline(recorded: &RecordedComparison) -> String {
    let numbers = &recorded.numbers;
    let others = numbers.arms.iter().filter(|arm| arm.name != BASELINE);
    let best = others.min_by(|a, b| a.regret.iqm.total_cmp(&b.regret.iqm));
    let tail = format!(
        "{} seeds of {} episodes.",
        numbers.seeds.len(),
        grouped(numbers.episodes as u64)
    );
    match best {
        Some(best) => format!(
            "{} has {} of the regret of {BASELINE}, and less in {:.0} % of pairs of runs. {tail}",
            best.name,
            ratio(&best.ratio_to_sparse),
            100.0 * best.probability_of_improvement.value
        ),
        None => tail,
    }
}

fn facts(
    recorded: &RecordedComparison,
    arm: &ArmSummary,
    timing: &ArmTiming,
) -> Vec<(&'static str, String)> {
    let chance = &arm.probability_of_improvement;
    let best = recorded.numbers.optimal_return;
    let final_name = match best < 0.0 {
        true => "final return ÷ best",
        false => "final return",
    };
    let mut facts = vec![
        ("regret (reward)", iqm(&arm.regret)),
        ("regret ÷ sparse, median", ratio(&arm.ratio_to_sparse)),
    ];
    if recorded.numbers.tuning.is_some() {
        let tuned = arm.ratio_to_tuned_sparse.as_ref();
        facts.push(("regret ÷ tuned sparse", tuned.map_or_else(dash, ratio)));
    }
    facts.extend([
        (
            "chance of less regret than sparse",
            format!(
                "{:.2} [{:.2}, {:.2}]",
                chance.value, chance.low, chance.high
            ),
        ),
        ("first goal (step)", moments(&arm.first_goal_step)),
        ("steps to 1.5 × best return", moments(&arm.steps_to_1_5x)),
        ("steps to 1.1 × best return", moments(&arm.steps_to_1_1x)),
        (
            final_name,
            final_cell(&arm.final_return, arm.final_ratio, best),
        ),
        (
            "exact return of the greedy policy",
            greedy_cell(&arm.greedy_return, best),
        ),
        (
            "the same without any advice",
            greedy_cell(&arm.greedy_return_unadvised, best),
        ),
        (
            "failed (greedy policy)",
            arm.failures.map_or_else(dash, percent),
        ),
        ("seed with the most regret", arm.worst_seed.to_string()),
        ("epochs of the fits", format!("{:.0}", arm.gcn_epochs)),
        (
            "false maxima of φ",
            arm.spurious_maxima.map_or_else(dash, |n| n.to_string()),
        ),
        (
            "milliseconds a run",
            format!("{:.0}", timing.median.wall_seconds * 1e3),
        ),
        (
            "microseconds a step",
            format!("{:.2}", 1e6 / timing.median.steps_per_second),
        ),
    ]);
    facts
}
