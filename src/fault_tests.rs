//! A run, a comparison and a sweep meet every fault of the disk at every operation, go on afterwards, and end with the bytes of
//! those that met none.
//!
//! The tests try a part of all points, evenly. `EIGENTRAIL_FAULTS=all` tries every one, and prints how many there were.

use crate::archive::{ArchiveError, Existing, RunInfo, SeedResult, names};
use crate::disk::faults::{Fault, inject};
use crate::runner::{
    CompareRequest, CompareWatch, Observers, RunRequest, RunStart, RunnerError, SweepPlan,
    SweepRequest, SweepWatch, Watch, compare, run, sweep,
};
use crate::scenario::{Loaded, Scenario};
use crate::tensorboard::TensorBoardWriter;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use tempfile::TempDir;

/// What is compared of a run: files by their paths below its folder.
type Bytes = BTreeMap<String, Vec<u8>>;

static GO_ON: AtomicBool = AtomicBool::new(false);

/// Something that is run into a folder, or goes on there.
struct Subject {
    name: &'static str,
    play: fn(&Path) -> Result<(), RunnerError>,
    /// Points that the tests try of each kind of fault.
    points: usize,
}

const SUBJECTS: [Subject; 3] = [
    Subject {
        name: "run",
        play: play_run,
        points: 10,
    },
    Subject {
        name: "compare",
        play: play_compare,
        points: 5,
    },
    Subject {
        name: "sweep",
        play: play_sweep,
        points: 5,
    },
];

/// Goals that move, steps that slip, two seeds, two refreshes or more, and a checkpoint every fifteen steps.
const WORLD: &str = "[env]\nrows = 5\ncols = 5\nslip = 0.1\nmoved_goals = [\"top-right\"]\n[run]\nepisodes = 30\ncheckpoint_every_steps = 15\n";

fn load() -> Loaded {
    Scenario::parse(Path::new("x.toml"), WORLD.to_owned(), &[]).unwrap()
}

fn play_run(out: &Path) -> Result<(), RunnerError> {
    let observers = |start: &RunStart<'_>| -> Result<Observers<'_>, ArchiveError> {
        Ok(vec![Box::new(TensorBoardWriter::create(start)?)])
    };
    let request = RunRequest {
        seeds: vec![3, 4],
        out: Some(out.to_owned()),
        existing: Existing::Resume,
        arguments: Vec::new(),
    };
    let watch = Watch {
        stop: &GO_ON,
        observers: &observers,
    };
    let ran = run(&load(), &request, watch)?;
    let results: Vec<&SeedResult> = ran.seeds.iter().map(|seed| &seed.result).collect();
    assert!(results.len() == 2 && results.iter().all(|result| result.finished));
    Ok(())
}

fn play_compare(out: &Path) -> Result<(), RunnerError> {
    let request = CompareRequest {
        path: Path::new("x.toml").to_owned(),
        sets: Vec::new(),
        seeds: vec![0, 1],
        arms: vec!["gcn".to_owned(), "sparse".to_owned()],
        tuned: false,
        out: Some(out.to_owned()),
        existing: Existing::Resume,
        arguments: Vec::new(),
    };
    let watch = CompareWatch {
        stop: &GO_ON,
        on_trial: &|_, _| {},
    };
    let compared = compare(&load(), &request, watch)?;
    assert!(compared.comparison.is_some());
    Ok(())
}

fn play_sweep(out: &Path) -> Result<(), RunnerError> {
    let scenario = out.with_extension("toml");
    fs::write(&scenario, WORLD).unwrap();
    let request = SweepRequest {
        path: scenario,
        axes: vec!["agent.gamma=0.9,1".parse().unwrap()],
        seeds: vec![0, 1],
        ..SweepRequest::default()
    };
    let plan = Arc::new(SweepPlan::of(request)?);
    let watch = SweepWatch {
        stop: &GO_ON,
        on_trial: &|_| {},
    };
    let swept = sweep(&plan, Some(out), Existing::Resume, watch)?;
    assert!(swept.sweep.is_some());
    Ok(())
}

/// What equal runs share to the byte: no clocks, and no times of day.
fn bytes(out: &Path) -> Bytes {
    fn walk(folder: &Path, root: &Path, found: &mut Bytes) {
        for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
            let path = entry.path();
            if path.is_dir() {
                walk(&path, root, found);
                continue;
            }
            let name = path
                .strip_prefix(root)
                .unwrap()
                .to_str()
                .unwrap()
                .to_owned();
            found.insert(name, fs::read(&path).unwrap());
        }
    }
    let mut found = Bytes::new();
    walk(out, out, &mut found);
    for (name, text) in &mut found {
        let file = Path::new(name).file_name().unwrap().to_str().unwrap();
        if [
            names::TIMINGS,
            names::TENSORBOARD,
            names::ARMS,
            names::SWEEP,
        ]
        .contains(&file)
        {
            text.clear(); // it is there, as it is without a fault
        } else if file == names::RUN {
            let info: RunInfo = serde_json::from_slice(text).unwrap();
            *text = serde_json::to_vec(&(info.status, info.seeds)).unwrap();
        } else if [names::SUMMARY, names::COMPARISON].contains(&file) || file.starts_with("seed") {
            *text = without_timing(text);
        }
    }
    found
}

/// Clock readings stand in an object of their own.
fn without_timing(json: &[u8]) -> Vec<u8> {
    let mut document: serde_json::Value = serde_json::from_slice(json).unwrap();
    fn strip(value: &mut serde_json::Value) {
        match value {
            serde_json::Value::Object(fields) => {
                fields.retain(|name, _| name != "timing");
                fields.values_mut().for_each(strip);
            }
            serde_json::Value::Array(values) => values.iter_mut().for_each(strip),
            _ => {}
        }
    }
    strip(&mut document);
    serde_json::to_vec(&document).unwrap()
}

/// A folder in memory where there is such, for what waits for the disk waits long.
fn scratch() -> TempDir {
    let memory = Path::new("/dev/shm");
    match memory.is_dir() {
        true => tempfile::tempdir_in(memory).unwrap(),
        false => tempfile::tempdir().unwrap(),
    }
}

/// Lets `fault` come at one operation, and looks at what it has left; why that is wrong, if it is.
fn survives(
    subject: &Subject,
    fault: Fault,
    at: usize,
    undisturbed: &Bytes,
) -> Result<bool, String> {
    let folder = scratch();
    let out = folder.path().join("out");
    let injected = inject(&out, fault, at);
    let ended = (subject.play)(&out);
    let has_come = injected.has_come();
    drop(injected);
    match ended {
        // What says that it has ended well must have.
        Ok(()) if !fault.kills() && fault != Fault::FolderRemoved => {
            let mut there = bytes(&out);
            there.retain(|name, _| !name.ends_with(".lock")); // without a lock it means nothing
            if there != *undisturbed {
                return Err("it said nothing, and left something else".to_owned());
            }
        }
        Ok(()) => {}
        Err(error) if !has_come => return Err(format!("before anything had happened: {error}")),
        Err(RunnerError::Archive(_)) => {}
        Err(error) => return Err(format!("not an error of files: {error}")),
    }
    (subject.play)(&out).map_err(|error| format!("it does not go on: {error}"))?;
    let there = bytes(&out);
    if there != *undisturbed {
        let names: Vec<&String> = there.keys().chain(undisturbed.keys()).collect();
        let differ = names
            .into_iter()
            .filter(|&name| there.get(name) != undisturbed.get(name));
        return Err(format!(
            "these differ afterwards: {:?}",
            differ.collect::<Vec<_>>()
        ));
    }
    Ok(has_come)
}

#[test]
fn every_fault_at_every_operation_is_survived() {
    let every_point = std::env::var("EIGENTRAIL_FAULTS").is_ok_and(|which| which == "all");
    let mut survived = 0;
    for subject in &SUBJECTS {
        let folder = scratch();
        let out = folder.path().join("out");
        let counted = inject(&out, Fault::Nothing, 0);
        (subject.play)(&out).unwrap();
        let counts = counted.counts();
        drop(counted);
        let operations: usize = counts.values().sum();
        let undisturbed = bytes(&out);
        let step = if every_point {
            1
        } else {
            operations.div_ceil(subject.points)
        };
        for (number, fault) in Fault::ALL.into_iter().enumerate() {
            // Each kind begins elsewhere.
            let first = if every_point {
                0
            } else {
                number * step / Fault::ALL.len()
            };
            let points: Vec<usize> = (first..operations).step_by(step).collect();
            let failed: Vec<String> = points
                .par_iter()
                .filter_map(|&at| match survives(subject, fault, at, &undisturbed) {
                    Ok(_) => None,
                    Err(what) => Some(format!(
                        "{} {fault:?} at operation {at}: {what}",
                        subject.name
                    )),
                })
                .collect();
            assert!(
                failed.is_empty(),
                "{} of {} points:\n{}",
                failed.len(),
                points.len(),
                failed.join("\n")
            );
            survived += points.len();
            println!(
                "{}, {fault:?}: {} points survived",
                subject.name,
                points.len()
            );
        }
        println!("{}: {operations} operations, {counts:?}", subject.name);
    }
    println!("{survived} points survived in all");
}
