//! Golden results: hashes of everything that small runs and eigensolves write, the same on every machine.
//!
//! A scenario of `tests/golden/scenarios` is run with seed 0, a graph is followed by `track`, each with one
//! thread and with two; the SHA-256 of each result stands in `tests/golden/hashes.txt`. A change that means to
//! change results remakes that file and says so in CHANGELOG.md under "Results changed":
//!
//! ```sh
//! EIGENTRAIL_GOLDEN=write cargo test --locked --test golden
//! ```
//!
//! The same on another processor, under an emulator:
//!
//! ```sh
//! EIGENTRAIL_GOLDEN_RUNNER="qemu-x86_64 -cpu Haswell" cargo test --locked --test golden
//! ```
//!
//! The same scenarios are also written down in the middle of an episode, read back by another process and played on:
//! `continued/…`. What comes after must not depend on that.
//!
//! Sums have one order on every x86-64 processor with AVX2 and FMA. Without those, the dense kernels of faer use
//! narrower registers and round otherwise: there the tests are ignored, and listed so.

mod continued;
mod results;

use eigentrail_testing::graphs;
use libtest_mimic::{Arguments, Failed, Trial};
use results::{Hashes, Subject};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, Mutex};

fn main() -> ExitCode {
    if let Some(order) = continued::Order::of_this_process() {
        return continued::obey(&order);
    }
    let arguments = Arguments::from_args();
    let file = folder().join("hashes.txt");
    if std::env::var("EIGENTRAIL_GOLDEN").as_deref() == Ok("write") {
        return remake(arguments, &file);
    }
    let golden = Arc::new(results::read(&file));
    let results = subjects().into_iter().map(|subject| {
        let golden = Arc::clone(&golden);
        let name = subject.name();
        Trial::test(name, move || compare(&subject, &golden))
            .with_ignored_flag(!one_order_of_sums())
    });
    let continued = scenarios().into_iter().map(continued::trial);
    libtest_mimic::run(&arguments, results.chain(continued).collect()).exit_code()
}

/// Whether the processor is one of those for which equal results are promised.
fn one_order_of_sums() -> bool {
    #[cfg(target_arch = "x86_64")]
    let has = std::is_x86_feature_detected!("fma") && std::is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    let has = false;
    has
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

/// The files of the scenarios.
fn scenarios() -> Vec<PathBuf> {
    let files = std::fs::read_dir(folder().join("scenarios")).expect("the folder of scenarios");
    let mut scenarios: Vec<PathBuf> = files
        .map(|file| file.expect("a readable folder").path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    scenarios.sort();
    scenarios
}

/// Every scenario, and graphs of several kinds.
fn subjects() -> Vec<Subject> {
    let grid = graphs::discovered(&graphs::grid(48, 50), 1);
    let parts = [graphs::grid(30, 30), graphs::star(400), graphs::cycle(500)];
    let weighted: Vec<(usize, usize, f64)> = (0..1600)
        .flat_map(|u| {
            [(u, u + 1), (u, u + 40)].map(|(u, v)| (u, v, 1.0 / (1 + (u * v) % 7) as f64))
        })
        .filter(|&(_, v, _)| v < 1600)
        .collect();
    let flags = |flags: &str| flags.split_whitespace().map(str::to_owned).collect();
    let graphs = [
        ("grid", grid, flags("-k 16 --growth 0.2")),
        (
            "rooms",
            graphs::discovered(&graphs::rooms(6, 6, 8), 2),
            flags("-k 12 --tol 1e-6 --growth 0.3"),
        ),
        (
            "maze",
            graphs::discovered(&graphs::maze(61, 61, 0.05, 1), 3),
            flags("-k 16 --growth 0.5 --certify"),
        ),
        (
            "parts",
            graphs::shuffled(&graphs::disjoint(&parts), 4),
            flags("-k 20 --growth 0.5 --tol 1e-3"),
        ),
        (
            "weighted",
            graphs::from_weighted_edges(1600, &weighted),
            flags("-k 8 --growth 0.4 --method cold"),
        ),
        (
            "random",
            graphs::discovered(&graphs::random(2000, 12.0, 5), 6),
            flags("-k 8 --growth 0.3"),
        ),
        (
            "small",
            graphs::discovered(&graphs::grid(12, 12), 7),
            flags("-k 6 --method full --growth 0.5"),
        ),
    ];
    let scenarios = scenarios().into_iter().map(Subject::Scenario);
    let tracks = graphs
        .into_iter()
        .map(|(name, graph, flags)| Subject::Graph {
            name,
            graph: Box::new(graph),
            flags,
        });
    scenarios.chain(tracks).collect()
}

fn compare(subject: &Subject, golden: &BTreeMap<String, String>) -> Result<(), Failed> {
    for threads in [1, 2] {
        let found = subject.hashes(threads)?;
        let prefix = format!("{}/", subject.name());
        let expected: Hashes = golden
            .range(prefix.clone()..)
            .take_while(|(name, _)| name.starts_with(&prefix))
            .map(|(name, hash)| (name.clone(), hash.clone()))
            .collect();
        let names = expected.keys().chain(found.keys());
        let mut other: Vec<&String> = names
            .filter(|name| expected.get(*name) != found.get(*name))
            .collect();
        other.sort();
        other.dedup();
        if !other.is_empty() {
            return Err(
                format!("with {threads} threads other bytes than before: {other:?}").into(),
            );
        }
    }
    Ok(())
}

/// Writes the file anew, each subject a test of its own.
fn remake(mut arguments: Arguments, file: &Path) -> ExitCode {
    arguments.filter = None;
    let all = Arc::new(Mutex::new(Hashes::new()));
    let trials = subjects().into_iter().map(|subject| {
        let all = Arc::clone(&all);
        Trial::test(subject.name(), move || {
            let hashes = subject.hashes(1)?;
            all.lock().expect("no test panics with it").extend(hashes);
            Ok(())
        })
    });
    let conclusion = libtest_mimic::run(&arguments, trials.collect());
    if !conclusion.has_failed() {
        results::write(file, &all.lock().expect("no test panics with it"));
    }
    conclusion.exit_code()
}
