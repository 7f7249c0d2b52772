//! A sweep as people read it: a row for each point.

use super::comparison_table::{dash, final_cell, greedy_cell, interval, moments, percent, ranges};
use super::fitted_table::{Column, TableStyle, fitting, render_columns, wrapped};
use super::terminal::{amount, grouped, whole};
use crate::archive::{PointSummary, Sweep};
use serde_json::Value;
use std::fmt::Write;

/// A row for each point, under the keys of the grid. Columns that do not fit are left out.
pub fn render_sweep(sweep: &Sweep, style: TableStyle) -> String {
    let (columns, left_out) = fitting(columns(sweep), style);
    let title = wrapped(&title(sweep), style.width());
    let table = render_columns(&columns, style);
    let notes = columns.iter().map(|column| column.note.as_str());
    let notes: Vec<&str> = notes.filter(|note| !note.is_empty()).collect();
    let mut notes = notes.join(" ");
    notes.push('\n');
    if left_out > 0 {
        let _ = writeln!(
            notes,
            "{left_out} more columns: --wide, --markdown, --json, or summary.json."
        );
    }
    format!("{title}\n{table}\n{}", wrapped(&notes, style.width()))
}

fn title(sweep: &Sweep) -> String {
    let count = |count: usize, what: &str| match count {
        1 => format!("1 {what}"),
        n => format!("{} {what}s", grouped(n as u64)),
    };
    format!(
        "{}: {}, {} each ({})",
        sweep.scenario,
        count(sweep.points.len(), "point"),
        count(sweep.seeds.len(), "seed"),
        ranges(&sweep.seeds)
    )
}

/// What is known of the points, and which of it comes first where there is little room.
fn columns(sweep: &Sweep) -> Vec<Column> {
    let mut columns = Vec::new();
    let mut add = |rank, header: &str, note: &str, cell: &dyn Fn(&PointSummary) -> String| {
        columns.push(Column {
            header: header.to_owned(),
            cells: sweep.points.iter().map(cell).collect(),
            rank,
            note: note.to_owned(),
        });
    };
    let has_arms = sweep.points.iter().any(|point| point.arm.is_some());
    if has_arms {
        add(0, "arm", "", &|point| {
            point.arm.clone().unwrap_or_else(dash)
        });
    }
    for (i, header) in headers(sweep).into_iter().enumerate() {
        add(0, header, "", &|point| value(&point.settings[i].value));
    }
    if !has_arms && sweep.grid.is_empty() {
        add(0, "scenario", "", &|_| sweep.scenario.clone());
    }
    add(1, "regret", "regret: interquartile mean.", &|point| {
        whole(point.regret.iqm)
    });
    add(
        5,
        "regret, 95 %",
        "[ ]: 95 % interval by bootstrap.",
        &|point| interval(&point.regret),
    );
    add(
        4,
        "first goal",
        "first goal: median environment steps, – if half of the seeds or more never get there.",
        &|point| moments(&point.first_goal_step),
    );
    add(
        7,
        "to 1.1×",
        "to 1.1×: environment steps until the mean return of 20 episodes is within 1.1 times the optimum, median.",
        &|point| moments(&point.steps_to_1_1x),
    );
    add(
        6,
        "final",
        "final: return of the last episodes, of R* or ÷ R* where that is a cost.",
        &|point| final_cell(&point.final_return, point.final_ratio, point.optimal_return),
    );
    add(
        3,
        "greedy",
        "greedy: exact return of the final greedy policy, median.",
        &|point| greedy_cell(&point.greedy_return, point.optimal_return),
    );
    add(
        2,
        "failed",
        "failed: seeds whose greedy return is below R* − 0.05 |R*|.",
        &|point| point.failures.map_or_else(dash, percent),
    );
    add(8, "R*", "R*: mean return of the best policy.", &|point| {
        amount(point.optimal_return)
    });
    add(9, "false maxima", "", &|point| {
        point.spurious_maxima.map_or_else(dash, |n| n.to_string())
    });
    columns
}

/// The keys of the grid without their sections, where that leaves no two alike.
fn headers(sweep: &Sweep) -> Vec<&str> {
    let short = |key: &'_ str| -> usize { key.rfind('.').map_or(0, |dot| dot + 1) };
    let keys = || sweep.grid.iter().map(|axis| axis.key.as_str());
    let alike = |name: &str| keys().filter(|key| &key[short(key)..] == name).count() > 1;
    keys()
        .map(|key| match &key[short(key)..] {
            name if alike(name) => key,
            name => name,
        })
        .collect()
}

/// A text without quotes; the rest as JSON.
fn value(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        value => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn sweep(keys: &[&str], arm: Option<&str>) -> Sweep {
        let settings = keys.iter().enumerate();
        let settings: Vec<Value> = settings
            .map(|(i, key)| json!({ "key": key, "value": i }))
            .collect();
        let grid: Vec<Value> = keys
            .iter()
            .map(|key| json!({ "key": key, "values": ["0"] }))
            .collect();
        let moments = json!({ "median": 321.0, "reached": 2 });
        let median = json!({ "median": -21.0, "low": -22.0, "high": -20.0 });
        serde_json::from_value(json!({
            "scenario": "rooms", "seeds": [0, 1, 2], "grid": grid,
            "points": [{
                "hash": "9a", "arm": arm, "settings": settings, "episodes": 5, "optimal_steps": 20.0, "optimal_return": -20.0,
                "regret": { "iqm": 1234.4, "low": 990.0, "high": 1500.6 },
                "first_goal_step": moments, "episodes_to_1_5x": moments, "steps_to_1_5x": moments,
                "episodes_to_1_1x": moments, "steps_to_1_1x": { "median": null, "reached": 1 },
                "final_return": median, "final_ratio": 1.05, "greedy_return": median, "greedy_return_unadvised": median,
                "failures": 0.25, "failures_unadvised": null, "worst_seed": 1, "gcn_epochs": 3.0, "spurious_maxima": null
            }]
        }))
        .unwrap()
    }

    fn lines(sweep: &Sweep, width: usize) -> Vec<String> {
        let text = render_sweep(sweep, TableStyle::Terminal { width });
        text.lines().map(str::to_owned).collect()
    }

    #[test]
    fn a_sweep_reads_well() {
        let sweep = sweep(&["agent.gamma", "run.episodes"], Some("gcn"));
        let text = render_sweep(&sweep, TableStyle::Markdown);
        for words in [
            "rooms: 1 point, 3 seeds each (0–2)",
            "| arm | gamma | episodes | regret |   regret, 95 % |",
            "| gcn |     0 |        1 |  1 234 | [990, 1 501] |",
            "–",
        ] {
            let words: String = words.split_whitespace().collect();
            let squeezed: String = text.split_whitespace().collect();
            assert!(squeezed.contains(&words), "no {words} in\n{text}");
        }
        let narrow = lines(&sweep, 60);
        assert!(narrow.iter().all(|line| line.chars().count() <= 60));
        assert!(narrow.iter().any(|line| line.contains("more columns")));
        assert!(narrow.iter().any(|line| line.contains("gamma")));
    }

    #[test]
    fn keys_that_end_alike_keep_their_sections() {
        let alike = sweep(&["env.kind", "agent.kind", "agent.gamma"], None);
        assert_eq!(headers(&alike), ["env.kind", "agent.kind", "gamma"]);
        let none = sweep(&[], None);
        assert!(
            lines(&none, 80)
                .iter()
                .any(|line| line.contains("scenario"))
        );
    }
}
