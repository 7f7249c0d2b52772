//! Names for runs that stand side by side: by what they differ in.

use crate::archive::RecordedRun;
use std::collections::{BTreeMap, BTreeSet};

/// Settings told in a name; of more, their number.
const TOLD: usize = 4;

/// Value of each setting, by its key.
type Settings = BTreeMap<String, toml::Value>;

/// A run as it is called on a page.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RunName {
    /// Alone: `four_rooms · agent.gamma=0.99, seed 3`.
    pub whole: String,
    /// Beside the others, where there is little room: `agent.gamma=0.99, seed 3`.
    pub label: String,
}

/// Names of runs of one world, all different. A single one keeps that of its folder.
pub(super) fn run_names(runs: &[&RecordedRun]) -> Vec<RunName> {
    if let [run] = runs {
        return vec![RunName {
            whole: run.name.clone(),
            label: run.name.clone(),
        }];
    }
    let settings: Vec<Settings> = runs.iter().map(|run| run.scenario.settings()).collect();
    let mut whole = differences(&settings, is_of_learning, Keys::Whole);
    let mut brief = differences(&settings, is_of_learning, Keys::Brief);
    let seeds: Vec<String> = runs.iter().map(|run| seeds(run)).collect();
    if seeds.iter().any(|each| *each != seeds[0]) {
        for told in [&mut whole, &mut brief] {
            let each = told.iter_mut().zip(seeds.clone());
            each.for_each(|(told, seeds)| told.push(seeds));
        }
    }
    let mut names: Vec<RunName> = (runs.iter().zip(whole.iter().zip(&brief)))
        .map(|(run, (whole, brief))| match whole.is_empty() {
            true => RunName {
                whole: format!("{} · {}", run.scenario.name, run.name),
                label: run.name.clone(),
            },
            false => RunName {
                whole: format!("{} · {}", run.scenario.name, whole.join(", ")),
                label: brief.join(", "),
            },
        })
        .collect();
    tell_apart(&mut names, runs);
    names
}

/// Adds the folder to names that are the same, and a number where that is no help.
fn tell_apart(names: &mut [RunName], runs: &[&RecordedRun]) {
    let mut count: BTreeMap<String, usize> = BTreeMap::new();
    for name in names.iter() {
        *count.entry(name.whole.clone()).or_default() += 1;
    }
    let mut used = BTreeSet::new();
    for (i, (name, run)) in names.iter_mut().zip(runs).enumerate() {
        let mut more = String::new();
        if count[&name.whole] > 1 && name.label != run.name {
            more = format!(" ({})", run.name);
        }
        if !used.insert(format!("{}{more}", name.whole)) {
            more += &format!(" #{}", i + 1);
        }
        name.whole += &more;
        name.label += &more;
    }
}

/// Titles of worlds, given by a run of each: the scenario, and what of `env` differs where that is not enough.
pub(super) fn world_titles(runs: &[&RecordedRun]) -> Vec<String> {
    let title = |run: &&RecordedRun| run.scenario.name.clone();
    let mut titles: Vec<String> = runs.iter().map(title).collect();
    for name in titles.clone().into_iter().collect::<BTreeSet<String>>() {
        let same: Vec<usize> = (0..runs.len())
            .filter(|&i| runs[i].scenario.name == name)
            .collect();
        let settings: Vec<Settings> = same.iter().map(|&i| runs[i].scenario.settings()).collect();
        let differing = differences(&settings, is_of_world, Keys::Whole);
        for (&i, told) in same.iter().zip(differing) {
            if !told.is_empty() {
                titles[i] = format!("{name} · {}", told.join(", "));
            }
        }
    }
    titles
}

/// Seeds are told apart from settings, and worlds have pages of their own.
fn is_of_learning(key: &str) -> bool {
    key != "name" && key != "run.seed" && !key.starts_with("arms.") && !is_of_world(key)
}

fn is_of_world(key: &str) -> bool {
    key.starts_with("env.")
}

/// How keys are written.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Keys {
    /// As `--set` takes them.
    Whole,
    /// Without their section, where that leaves no doubt.
    Brief,
}

/// `key=value` for each of the keys, among those that `counts` says, whose values differ; by whose settings they are.
fn differences(all: &[Settings], counts: fn(&str) -> bool, keys: Keys) -> Vec<Vec<String>> {
    let known: BTreeSet<&str> = (all.iter().flat_map(BTreeMap::keys))
        .map(String::as_str)
        .collect();
    let differs = |key: &&str| {
        let first = all[0].get(*key);
        counts(key) && all.iter().any(|settings| settings.get(*key) != first)
    };
    let differing: Vec<&str> = known.into_iter().filter(differs).collect();
    let written = |key: &str| {
        let last = |key: &str| key.rsplit('.').next().unwrap_or_default().to_owned();
        let brief = last(key);
        let same = differing.iter().filter(|other| last(other) == brief);
        match keys == Keys::Brief && brief != "kind" && same.count() == 1 {
            true => brief,
            false => key.to_owned(),
        }
    };
    let told = |settings: &Settings| {
        let assigned = |key: &&str| {
            let value = text(settings.get(*key)?);
            Some(format!("{}={value}", written(key)))
        };
        let mut told: Vec<String> = differing.iter().filter_map(assigned).collect();
        let more = told.len().saturating_sub(TOLD);
        if more > 1 {
            told.truncate(TOLD);
            told.push(format!("{more} more"));
        }
        told
    };
    all.iter().map(told).collect()
}

/// A value as `--set` takes it.
fn text(value: &toml::Value) -> String {
    match value {
        toml::Value::String(text) => text.clone(),
        value => value.to_string(),
    }
}

/// `seed 3`, `seeds 0–4`, `seeds 0, 7`
fn seeds(run: &RecordedRun) -> String {
    let seeds: Vec<u64> = run.seeds.iter().map(|seed| seed.seed).collect();
    match seeds.as_slice() {
        [seed] => format!("seed {seed}"),
        [first, .., last] if last - first + 1 == seeds.len() as u64 => {
            format!("seeds {first}–{last}")
        }
        seeds => {
            let all: Vec<String> = seeds.iter().map(u64::to_string).collect();
            format!("seeds {}", all.join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::archive::{RecordedSeed, Summary};
    use crate::scenario::Scenario;
    use std::path::Path;

    fn run(folder: &str, sets: &[&str], seeds: &[u64]) -> RecordedRun {
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        let loaded = Scenario::load(Path::new("four_rooms"), &sets).unwrap();
        let seed = |&seed: &u64| RecordedSeed {
            seed,
            ..RecordedSeed::default()
        };
        RecordedRun {
            name: folder.to_owned(),
            scenario: loaded.scenario,
            resolved: String::new(),
            arguments: Vec::new(),
            summary: Summary::default(),
            seeds: seeds.iter().map(seed).collect(),
        }
    }

    fn names(runs: &[RecordedRun]) -> Vec<String> {
        let runs: Vec<&RecordedRun> = runs.iter().collect();
        run_names(&runs)
            .into_iter()
            .map(|name| name.whole)
            .collect()
    }

    #[test]
    fn names_carry_what_differs() {
        let runs = [
            run("a", &[], &[0]),
            run("b", &["agent.gamma=0.99"], &[3]),
            run("c", &["agent.gamma=0.99", "run.seed=7"], &[0, 1, 2]),
        ];
        assert_eq!(names(&runs[..1]), ["a"], "one has nothing to differ from");
        assert_eq!(
            names(&runs),
            [
                "four_rooms · agent.gamma=1.0, seed 0",
                "four_rooms · agent.gamma=0.99, seed 3",
                "four_rooms · agent.gamma=0.99, seeds 0–2",
            ]
        );
        let seeds = [run("a", &[], &[0, 4]), run("b", &[], &[1])];
        assert_eq!(
            names(&seeds),
            ["four_rooms · seeds 0, 4", "four_rooms · seed 1"]
        );
    }

    #[test]
    fn labels_are_brief_but_never_in_doubt() {
        let other = &[
            "agent.gamma=0.9",
            "exploration.kind=none",
            "shaping.potential=none",
        ];
        let runs = [run("a", &[], &[0]), run("b", other, &[0])];
        let runs: Vec<&RecordedRun> = runs.iter().collect();
        let labels: Vec<String> = run_names(&runs).into_iter().map(|n| n.label).collect();
        assert_eq!(
            labels[0],
            "gamma=1.0, exploration.kind=frontier, potential=gcn"
        );
        assert!(labels[1].ends_with("exploration.kind=none, potential=none"));
    }

    #[test]
    fn equal_runs_are_told_apart() {
        let same = [
            run("a", &[], &[0]),
            run("b", &[], &[0]),
            run("b", &[], &[0]),
        ];
        assert_eq!(
            names(&same),
            ["four_rooms · a", "four_rooms · b", "four_rooms · b #3"]
        );
        let gamma = &["agent.gamma=0.9"];
        let two = [
            run("a", &[], &[0]),
            run("b", gamma, &[0]),
            run("c", gamma, &[0]),
        ];
        assert_eq!(
            names(&two),
            [
                "four_rooms · agent.gamma=1.0",
                "four_rooms · agent.gamma=0.9 (b)",
                "four_rooms · agent.gamma=0.9 (c)",
            ]
        );
    }

    #[test]
    fn worlds_of_one_name_are_told_apart() {
        let runs = [run("a", &[], &[0]), run("b", &["env.slip=0.2"], &[0])];
        let runs: Vec<&RecordedRun> = runs.iter().collect();
        assert_eq!(
            world_titles(&runs),
            ["four_rooms · env.slip=0.0", "four_rooms · env.slip=0.2"]
        );
        assert_eq!(world_titles(&runs[..1]), ["four_rooms"]);
    }
}
