//! Runs that are interrupted, killed or damaged anywhere go on to the bytes of a run that nothing has happened to.

use super::*;
use crate::archive::{ArchiveError, Checkpoint, Existing, SeedResult, checkpoint, names};
use crate::scenario::{Loaded, Scenario};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Each with something of its own: a map on which goals move and moves slip, names and a file, a learner with features and random
/// walks, noisy rewards.
const WORLDS: [&str; 4] = [
    "[env]\nrows = 5\ncols = 5\nslip = 0.1\nmoved_goals = [\"top-right\"]\n[run]\nepisodes = 40\n",
    "[env]\nkind = \"taxi\"\n[run]\nepisodes = 12\n[shaping]\npotential = \"oracle\"\n",
    "[env]\nrows = 4\ncols = 4\nactions = \"turns\"\n[agent]\nkind = \"actor-critic\"\nfeatures = \"deepwalk\"\n[run]\nepisodes = 15\n",
    "[env]\nkind = \"deep-sea\"\nsize = 6\nstochastic = true\n[run]\nepisodes = 60\n",
];

fn load(text: &str, more: &[&str]) -> Loaded {
    let sets: Vec<String> = more.iter().map(|set| (*set).to_owned()).collect();
    Scenario::parse(Path::new("x.toml"), text.to_owned(), &sets).unwrap()
}

/// What makes a run end before its time.
#[derive(Clone, Copy, Debug, PartialEq)]
enum End {
    /// It is told to stop when so many checkpoints have been taken.
    Stop(usize),
    /// It fails at the first event after so many checkpoints, and what it has written since then stays.
    Crash(usize),
    Never,
}

struct Ender<'a> {
    end: End,
    stop: &'a AtomicBool,
    taken: &'a AtomicUsize,
    crashes: Cell<bool>,
}

impl RunObserver for Ender<'_> {
    fn save(&mut self) -> Result<Option<SavedObserver>, ArchiveError> {
        let taken = self.taken.fetch_add(1, Ordering::Relaxed) + 1;
        self.stop
            .fetch_or(self.end == End::Stop(taken), Ordering::Relaxed);
        if self.end == End::Crash(taken) {
            self.crashes.set(true);
        }
        Ok(None)
    }

    fn episode_ended(&mut self, _: &Episode<'_>, _: &dyn RunState) -> Result<(), ArchiveError> {
        match self.crashes.get() {
            true => Err(ArchiveError::damaged(Path::new("here"), "a crash")),
            false => Ok(()),
        }
    }
}

/// Runs into `out`, or goes on there; the number of checkpoints taken, and the result if it got one.
fn play(loaded: &Loaded, out: &Path, end: End) -> (usize, Option<SeedResult>) {
    let (stop, taken) = (AtomicBool::new(false), AtomicUsize::new(0));
    let observers = |_: &RunStart<'_>| -> Result<Observers<'_>, ArchiveError> {
        let (stop, taken) = (&stop, &taken);
        Ok(vec![Box::new(Ender {
            end,
            stop,
            taken,
            crashes: Cell::new(false),
        })])
    };
    let request = RunRequest {
        seeds: vec![3],
        out: Some(out.to_owned()),
        existing: Existing::Resume,
        arguments: Vec::new(),
    };
    let watch = Watch {
        stop: &stop,
        observers: &observers,
    };
    let ran = run(loaded, &request, watch);
    let result = ran.ok().map(|ran| ran.seeds[0].result.clone());
    (taken.load(Ordering::Relaxed), result)
}

/// What equal runs share to the byte.
fn results(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let seed = fs::read_dir(out.join("seed-0003")).unwrap().flatten();
    let files = seed.map(|entry| {
        (
            entry.file_name().into_string().unwrap(),
            fs::read(entry.path()).unwrap(),
        )
    });
    files.filter(|(name, _)| name != names::TIMINGS).collect()
}

#[test]
fn a_run_goes_on_from_every_checkpoint_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    for (number, text) in WORLDS.into_iter().enumerate() {
        let plain = folder.path().join(format!("plain-{number}"));
        let never = load(text, &["run.checkpoint_every_minutes=0"]);
        let (taken, whole) = play(&never, &plain, End::Never);
        let whole = whole.unwrap();
        assert_eq!(taken, 0);
        // Nine of them, wherever in an episode that is; their settings are no part of what is compared.
        let every = format!("run.checkpoint_every_steps={}", whole.steps / 10);
        let loaded = load(text, &[&every]);
        let (all, undisturbed) = play(
            &loaded,
            &folder.path().join(format!("all-{number}")),
            End::Never,
        );
        assert!(all >= 9, "{all}");
        assert_eq!(undisturbed.unwrap(), whole, "taking them changes nothing");
        for end in (1..=all).flat_map(|taken| [End::Stop(taken), End::Crash(taken)]) {
            let out = folder.path().join(format!("{number}-{end:?}"));
            let (_, ended) = play(&loaded, &out, end);
            let is_over = ended.is_some_and(|result| result.finished);
            assert!(!is_over || end == End::Crash(all), "{end:?} came too late");
            let (_, resumed) = play(&loaded, &out, End::Never);
            assert_eq!(resumed.unwrap(), whole, "{text}{end:?}");
            assert_eq!(results(&out), results(&plain), "{text}{end:?}");
        }
    }
}

#[test]
fn intervals_may_change_between_the_parts_of_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let (plain, out) = (folder.path().join("plain"), folder.path().join("out"));
    let begun = load(WORLDS[0], &["run.checkpoint_every_steps=100"]);
    play(&begun, &plain, End::Never);
    play(&begun, &out, End::Stop(2));
    let resumed = [
        "run.checkpoint_every_steps=33",
        "run.checkpoint_every_minutes=0",
    ];
    assert!(play(&load(WORLDS[0], &resumed), &out, End::Never).0 > 2);
    assert_eq!(results(&out), results(&plain));
    let other = load(WORLDS[0], &["agent.gamma=0.9"]);
    assert!(
        play(&other, &out, End::Never).1.is_none(),
        "all else may not"
    );
}

/// It is stopped again and again, after one more checkpoint each time.
#[test]
fn a_run_that_is_always_interrupted_ends_as_well() {
    let folder = tempfile::tempdir().unwrap();
    let (plain, out) = (folder.path().join("plain"), folder.path().join("out"));
    let loaded = load(WORLDS[0], &["run.checkpoint_every_steps=60"]);
    let whole = play(&loaded, &plain, End::Never).1.unwrap();
    let mut interruptions = 0;
    let last = loop {
        let result = play(&loaded, &out, End::Stop(1)).1.unwrap();
        if result.finished {
            break result;
        }
        interruptions += 1;
    };
    assert!(interruptions >= 5, "{interruptions}");
    assert_eq!(last, whole);
    assert_eq!(results(&out), results(&plain));
}

#[test]
fn a_damaged_checkpoint_is_passed_over_for_the_one_before() {
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("plain");
    let loaded = load(WORLDS[0], &["run.checkpoint_every_steps=100"]);
    play(&loaded, &plain, End::Never);
    type Damage = fn(&Path);
    let cut: Damage = |path| {
        let bytes = fs::read(path).unwrap();
        fs::write(path, &bytes[..bytes.len() / 2]).unwrap();
    };
    let flip: Damage = |path| {
        let mut bytes = fs::read(path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 4;
        fs::write(path, bytes).unwrap();
    };
    let foreign: Damage = |path| fs::write(path, "years of work").unwrap();
    let other: Damage = |path| {
        let mut checkpoint = Checkpoint::read(path).unwrap();
        checkpoint.seed = 4;
        let elsewhere = tempfile::tempdir().unwrap();
        checkpoint.write(elsewhere.path()).unwrap();
        fs::copy(elsewhere.path().join(names::CHECKPOINT), path).unwrap();
    };
    let gone: Damage = |path| fs::remove_file(path).unwrap();
    for (number, damage) in [cut, flip, foreign, other, gone].into_iter().enumerate() {
        for both in [false, true] {
            let out = folder.path().join(format!("{number}-{both}"));
            play(&loaded, &out, End::Crash(3));
            let [newest, before] = checkpoint::paths(&out.join("seed-0003"));
            assert!(
                Checkpoint::read(&newest).unwrap().steps > Checkpoint::read(&before).unwrap().steps
            );
            damage(&newest);
            if both {
                damage(&before);
            }
            play(&loaded, &out, End::Never);
            assert_eq!(results(&out), results(&plain), "{number} {both}");
        }
    }
}

/// A table that has lost rows that a checkpoint relies on: no checkpoint fits any more.
#[test]
fn a_seed_whose_files_are_gone_begins_anew() {
    let folder = tempfile::tempdir().unwrap();
    let (plain, out) = (folder.path().join("plain"), folder.path().join("out"));
    let loaded = load(WORLDS[0], &["run.checkpoint_every_steps=100"]);
    play(&loaded, &plain, End::Never);
    play(&loaded, &out, End::Stop(3));
    fs::write(out.join("seed-0003").join(names::EPISODES), "episode\n").unwrap();
    play(&loaded, &out, End::Never);
    assert_eq!(results(&out), results(&plain));
}

/// Checkpoints that earlier programs have written are gone on from. Where the form of a checkpoint changes, its version does, the file of
/// the old one stays, and `EIGENTRAIL_FIXTURE=write` adds the new one.
#[test]
fn checkpoints_of_earlier_formats_are_gone_on_from() {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/checkpoints");
    let loaded = load(WORLDS[0], &["run.checkpoint_every_steps=100"]);
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("plain");
    let whole = play(&loaded, &plain, End::Never).1.unwrap();
    let out = folder.path().join("out");
    play(&loaded, &out, End::Stop(2));
    let here = out.join("seed-0003").join(names::CHECKPOINT);
    let newest = kept.join(format!("version-{}", checkpoint::KIND.version));
    if std::env::var("EIGENTRAIL_FIXTURE").is_ok_and(|what| what == "write") {
        fs::copy(&here, &newest).unwrap();
    }
    assert!(newest.is_file(), "the present format is among them");
    for entry in fs::read_dir(&kept).unwrap() {
        let path = entry.unwrap().path();
        let earlier = Checkpoint::read(&path).unwrap();
        let scenario = &loaded.scenario;
        let mut trial = trial::resume(scenario, &loaded.worlds, 3, &earlier.run).unwrap();
        assert_eq!(trial.steps(), earlier.steps);
        assert!(earlier.steps > 0 && earlier.steps < whole.steps);
        let stop = AtomicBool::new(false);
        trial::play(&mut *trial, &stop, &mut Vec::new(), None).unwrap();
        assert_eq!(trial.result(), whole, "{}", path.display());
    }
}

#[test]
fn a_comparison_goes_on_within_its_trials() {
    let folder = tempfile::tempdir().unwrap();
    let loaded = load(WORLDS[0], &["run.checkpoint_every_steps=50"]);
    let compare_into = |name: &str, stop_after: usize| {
        let stop = AtomicBool::new(false);
        let ended = AtomicUsize::new(0);
        let request = CompareRequest {
            path: Path::new("x.toml").to_owned(),
            sets: vec!["run.checkpoint_every_steps=50".to_owned()],
            seeds: vec![0, 1],
            arms: vec!["gcn".to_owned(), "heat".to_owned()],
            tuned: false,
            out: Some(folder.path().join(name)),
            existing: Existing::Resume,
            arguments: Vec::new(),
        };
        let on_trial = |_: &str, _: &crate::archive::TrialRecord| {
            let ended = ended.fetch_add(1, Ordering::Relaxed) + 1;
            stop.fetch_or(ended >= stop_after, Ordering::Relaxed);
        };
        let watch = CompareWatch {
            stop: &stop,
            on_trial: &on_trial,
        };
        compare(&loaded, &request, watch).unwrap().comparison
    };
    let whole = compare_into("whole", usize::MAX).unwrap();
    for stop_after in 1..6 {
        let name = format!("stopped-{stop_after}");
        compare_into(&name, stop_after);
        let resumed = compare_into(&name, usize::MAX).unwrap();
        assert_eq!(resumed.arms.len(), whole.arms.len());
        let read = |name: &str| fs::read(folder.path().join(name).join(names::TRIALS)).unwrap();
        assert_eq!(read(&name), read("whole"));
        let arms = folder.path().join(&name).join(names::ARMS_FOLDER);
        for arm in ["gcn", "heat"] {
            assert!(
                !arms.join(arm).join("seed-0001").exists(),
                "only for checkpoints"
            );
            assert!(
                !arms
                    .join(arm)
                    .join("seed-0000")
                    .join(names::CHECKPOINT)
                    .exists()
            );
        }
    }
}
