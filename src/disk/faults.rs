//! Faults of the disk, for tests: what a file system may do to each operation below a folder, from the n-th one on.

use super::Operation;
use std::collections::BTreeMap;
use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// What happens at an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Fault {
    /// Nothing: operations are counted.
    Nothing,
    /// The program is killed just before it: nothing changes the disk any more.
    Kill,
    /// The program is killed in the middle of it; only writes have a middle.
    KillWithin,
    /// The power goes: as [`Fault::Kill`], and bytes that were not synced are gone.
    PowerLoss,
    /// It fails once, as on a bad sector.
    Broken,
    /// The disk is full from now on: half of a write fits, then nothing grows and nothing new is made.
    Full,
    /// No more files: those that are there can be written to.
    NoInodes,
    /// The folder, with all that is in it, is removed by somebody else.
    FolderRemoved,
    /// It may not be written to any more, as a file system that the kernel has gone over to read only.
    ReadOnly,
}

impl Fault {
    /// All but [`Fault::Nothing`].
    pub const ALL: [Self; 8] = [
        Self::Kill,
        Self::KillWithin,
        Self::PowerLoss,
        Self::Broken,
        Self::Full,
        Self::NoInodes,
        Self::FolderRemoved,
        Self::ReadOnly,
    ];

    /// Whether the program ends there, whatever it does afterwards.
    pub fn kills(self) -> bool {
        matches!(self, Self::Kill | Self::KillWithin | Self::PowerLoss)
    }
}

/// A fault that waits below a folder, as long as this is there.
pub(crate) struct Injected(Arc<Waiting>);

struct Waiting {
    root: PathBuf,
    fault: Fault,
    /// It comes at the operation with this number, from 0.
    at: usize,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    counts: BTreeMap<Operation, usize>,
    has_come: bool,
    /// Bytes of files that are on the disk for certain; others than these are.
    synced: BTreeMap<PathBuf, u64>,
}

static ALL: Mutex<Vec<Arc<Waiting>>> = Mutex::new(Vec::new());

/// Lets `fault` come at the `at`-th operation below `root`, counted from 0.
pub(crate) fn inject(root: &Path, fault: Fault, at: usize) -> Injected {
    let waiting = Arc::new(Waiting {
        root: root.to_owned(),
        fault,
        at,
        state: Mutex::default(),
    });
    all().push(Arc::clone(&waiting));
    Injected(waiting)
}

impl Injected {
    /// Operations so far, by kind.
    pub fn counts(&self) -> BTreeMap<Operation, usize> {
        self.0.state().counts.clone()
    }

    /// Whether it has come.
    pub fn has_come(&self) -> bool {
        self.0.state().has_come
    }
}

impl Drop for Injected {
    fn drop(&mut self) {
        all().retain(|waiting| !Arc::ptr_eq(waiting, &self.0));
    }
}

fn all() -> std::sync::MutexGuard<'static, Vec<Arc<Waiting>>> {
    ALL.lock().unwrap_or_else(PoisonError::into_inner)
}

fn above(path: &Path) -> Option<Arc<Waiting>> {
    let all = all();
    all.iter()
        .find(|waiting| path.starts_with(&waiting.root))
        .cloned()
}

/// What an operation meets.
enum Met {
    Nothing,
    /// It fails at once.
    Error(io::Error),
    /// A write of which so many bytes get there.
    Part(usize),
}

pub(super) fn before(operation: Operation, path: &Path) -> io::Result<()> {
    match above(path).map_or(Met::Nothing, |waiting| waiting.meet(operation, path, 0)) {
        Met::Error(error) => Err(error),
        Met::Nothing | Met::Part(_) => Ok(()),
    }
}

pub(super) fn before_write(path: &Path, length: usize) -> io::Result<usize> {
    let met = above(path).map_or(Met::Nothing, |waiting| {
        waiting.meet(Operation::Write, path, length)
    });
    match met {
        Met::Error(error) => Err(error),
        Met::Part(part) => Ok(part),
        Met::Nothing => Ok(length),
    }
}

/// What is known of a file goes with its name.
pub(super) fn renamed(from: &Path, to: &Path) {
    let Some(waiting) = above(to) else { return };
    let mut state = waiting.state();
    let synced = state.synced.remove(from);
    state.synced.remove(to);
    if let Some(synced) = synced {
        state.synced.insert(to.to_owned(), synced);
    }
}

impl Waiting {
    fn state(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn meet(&self, operation: Operation, path: &Path, length: usize) -> Met {
        use Operation::{Create, MakeFolder, Write};
        let mut state = self.state();
        if state.has_come && self.fault.kills() {
            return Met::Error(io::Error::other("killed"));
        }
        let number: usize = state.counts.values().sum();
        *state.counts.entry(operation).or_default() += 1;
        let now = number == self.at;
        if now {
            state.has_come = true;
        }
        if !state.has_come {
            state.note(operation, path);
            return Met::Nothing;
        }
        let grows = matches!(operation, Create | MakeFolder | Write);
        let error = |kind: ErrorKind| Met::Error(io::Error::from(kind));
        match self.fault {
            // What is written now, the test writes itself: nothing else may come in between.
            Fault::KillWithin if operation == Write && length > 1 => {
                write_to(path, length / 2);
                Met::Error(io::Error::other("killed"))
            }
            Fault::Kill | Fault::KillWithin => Met::Error(io::Error::other("killed")),
            Fault::PowerLoss => {
                state.lose();
                Met::Error(io::Error::other("killed"))
            }
            Fault::Broken if now => Met::Error(io::Error::from_raw_os_error(EIO)),
            Fault::Full if now && operation == Write && length > 1 => Met::Part(length / 2),
            Fault::Full if grows => error(ErrorKind::StorageFull),
            Fault::NoInodes if matches!(operation, Create | MakeFolder) => {
                error(ErrorKind::StorageFull)
            }
            Fault::FolderRemoved => {
                if now {
                    let _ = fs::remove_dir_all(&self.root);
                }
                Met::Nothing
            }
            Fault::ReadOnly => error(ErrorKind::ReadOnlyFilesystem),
            Fault::Nothing | Fault::Broken | Fault::Full | Fault::NoInodes => Met::Nothing,
        }
    }
}

const EIO: i32 = 5;

/// Appends to a file, whose handle is elsewhere, what a torn write may leave there: anything.
fn write_to(path: &Path, length: usize) {
    use std::io::Write;
    if let Ok(mut file) = OpenOptions::new().append(true).open(path) {
        let _ = file.write_all(&vec![b'?'; length]);
    }
}

impl State {
    fn note(&mut self, operation: Operation, path: &Path) {
        let length = || fs::metadata(path).map_or(0, |there| there.len());
        match operation {
            Operation::Create => {
                self.synced.insert(path.to_owned(), 0);
            }
            Operation::Sync => {
                self.synced.insert(path.to_owned(), length());
            }
            // A file of an earlier run, whose bytes have been on the disk for long.
            Operation::Open | Operation::SetLength => {
                let synced = self.synced.get(path).copied().unwrap_or_else(length);
                self.synced.insert(path.to_owned(), synced);
            }
            _ => {}
        }
    }

    /// Cuts files back to what was synced.
    fn lose(&self) {
        for (path, &synced) in &self.synced {
            if let Ok(file) = OpenOptions::new().write(true).open(path)
                && file.metadata().is_ok_and(|there| there.len() > synced)
            {
                let _ = file.set_len(synced);
            }
        }
    }
}
