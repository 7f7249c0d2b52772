//! Runs and comparisons from their beginning to their end.

use super::*;
use crate::archive::{ArchiveError, Existing, RunStatus, names};
use crate::scenario::{Loaded, Scenario};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Nobody stops these runs.
static NEVER: AtomicBool = AtomicBool::new(false);

const RING: &str = "from,action,to\na,on,b\nb,on,c\nc,on,d\nd,on,a\nb,back,a\nc,back,b\nd,back,c\n";

/// A ring of four states in `folder`.
fn ring(folder: &Path) -> (Loaded, PathBuf) {
    let list = folder.join("ring.csv");
    fs::write(&list, RING).unwrap();
    let text = "[env]\nkind = \"edge-list\"\nfile = \"ring.csv\"\ngoals = [{ at = \"d\" }]\n\
                moved_goals = [{ at = \"c\" }]\n[run]\nepisodes = 30\n";
    let path = folder.join("ring.toml");
    (Scenario::parse(&path, text.to_owned(), &[]).unwrap(), list)
}

fn run_into<'a>(
    loaded: &Loaded,
    out: &Path,
    observers: &'a MakeObservers<'a>,
) -> Result<RunOutcome, RunnerError> {
    let request = RunRequest {
        seeds: vec![3],
        out: Some(out.to_owned()),
        existing: Existing::Refuse,
        arguments: Vec::new(),
    };
    let watch = Watch {
        stop: &NEVER,
        observers,
    };
    run(loaded, &request, watch)
}

fn compare_into(loaded: &Loaded, out: &Path) -> CompareOutcome {
    let request = CompareRequest {
        path: out.with_file_name("ring.toml"),
        sets: Vec::new(),
        seeds: vec![0, 1],
        arms: vec!["gcn".to_owned(), "heat".to_owned()],
        tuned: false,
        out: Some(out.to_owned()),
        existing: Existing::Refuse,
        arguments: Vec::new(),
    };
    let watch = CompareWatch {
        stop: &NEVER,
        on_trial: &|_, _| (),
    };
    compare(loaded, &request, watch).unwrap()
}

/// What a file that is edited or removed meanwhile must not change.
#[test]
fn an_edge_list_is_read_once() {
    type Change = fn(&Path);
    let changes: [Change; 3] = [
        |_| (),
        |list| fs::remove_file(list).unwrap(),
        |list| fs::write(list, "from,action,to\nd,on,nowhere\n").unwrap(),
    ];
    let results = changes.map(|change| {
        let folder = tempfile::tempdir().unwrap();
        let (loaded, list) = ring(folder.path());
        change(&list);
        let ran = run_into(&loaded, &folder.path().join("run"), &|_| Ok(Vec::new())).unwrap();
        let policy = fs::read(ran.folder.seed(3).join(names::POLICY)).unwrap();
        let compared = compare_into(&loaded, &folder.path().join("comparison"));
        let table = fs::read(compared.folder.file(names::TRIALS)).unwrap();
        (ran.seeds[0].result.clone(), policy, table)
    });
    assert_eq!(results[0].0.goals_moved_after, Some(15));
    assert_eq!(results[0], results[1]);
    assert_eq!(results[0], results[2]);
}

/// Fails at its second episode, and again when it is to write what it has.
struct Failing<'a> {
    episodes: u64,
    ended: &'a AtomicBool,
}

fn failure(path: &str) -> ArchiveError {
    ArchiveError::damaged(Path::new(path), "so it is")
}

impl RunObserver for Failing<'_> {
    fn episode_ended(&mut self, _: &Episode<'_>, _: &dyn RunState) -> Result<(), ArchiveError> {
        self.episodes += 1;
        match self.episodes {
            2 => Err(failure("first")),
            _ => Ok(()),
        }
    }

    fn flush(&mut self) -> Result<(), ArchiveError> {
        Err(failure("second"))
    }

    fn ended(&mut self, _: &dyn RunState) -> Result<(), ArchiveError> {
        self.ended.store(true, Ordering::Relaxed);
        Ok(())
    }
}

#[test]
fn the_first_error_of_an_observer_ends_a_run_whose_rows_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let (loaded, _) = ring(folder.path());
    let out = folder.path().join("run");
    let ended = AtomicBool::new(false);
    let observers = |start: &RunStart<'_>| -> Result<Observers<'_>, ArchiveError> {
        assert!(start.folder.is_dir() && start.seed == 3);
        let failing = Failing {
            episodes: 0,
            ended: &ended,
        };
        Ok(vec![Box::new(failing)])
    };
    let error = run_into(&loaded, &out, &observers).unwrap_err();
    assert_eq!(error.to_string(), "first: so it is");
    assert!(!ended.load(Ordering::Relaxed), "what failed has not ended");
    let rows = fs::read_to_string(out.join("seed-0003").join(names::EPISODES)).unwrap();
    assert_eq!(rows.lines().count(), 3, "a header and two episodes: {rows}");
    let info = fs::read_to_string(out.join(names::RUN)).unwrap();
    let info: crate::archive::RunInfo = serde_json::from_str(&info).unwrap();
    assert_eq!(info.status, RunStatus::Failed);
}

#[test]
fn what_cannot_be_flushed_is_told_though_every_episode_was_played() {
    let folder = tempfile::tempdir().unwrap();
    let (loaded, _) = ring(folder.path());
    let ended = AtomicBool::new(false);
    let observers = |_: &RunStart<'_>| -> Result<Observers<'_>, ArchiveError> {
        let failing = Failing {
            episodes: 2, // it will not come by its second one
            ended: &ended,
        };
        Ok(vec![Box::new(failing)])
    };
    let error = run_into(&loaded, &folder.path().join("run"), &observers).unwrap_err();
    assert_eq!(error.to_string(), "second: so it is");
    assert!(!ended.load(Ordering::Relaxed));
}
