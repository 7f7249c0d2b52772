//! From what the run leaves on the desk to drawings on the board.

use super::board::Board;
use crate::archive::{
    EpisodeRow, GraphRow, PolicyRow, RecordedRun, RecordedSeed, RefreshRow, SeedResult, SeedTiming,
    Snapshot, Summary,
};
use crate::report::report_data;
use crate::scenario::Scenario;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Between two drawings, so that reading them is possible.
const PAUSE: Duration = Duration::from_secs(1);

/// The painter rests so many times as long as it worked: a tenth of one processor is what it may take.
const REST: u32 = 9;

/// Head of the page: what it says about the run beside its numbers.
#[derive(Clone, Debug)]
pub struct Title {
    /// The run.
    pub name: String,
    /// Its scenario.
    pub scenario: Scenario,
    /// The command line.
    pub arguments: Vec<String>,
}

/// State of a run as the live page shows it: its history in a bounded number of rows, and the present of everything else.
#[derive(Clone, Debug)]
pub(super) struct LiveUpdate {
    /// The run so far.
    pub result: SeedResult,
    /// What the clock says.
    pub timing: SeedTiming,
    /// Its episodes, later ones several in a row.
    pub episodes: Vec<EpisodeRow>,
    /// Its refreshes, of later ones only some, but the last fit in any case.
    pub refreshes: Vec<RefreshRow>,
    /// Frames of the whole run, the present one last.
    pub snapshots: Vec<Snapshot>,
    /// Place (`row,col`) or name of each state.
    pub labels: Vec<String>,
    /// Names of the actions by number.
    pub actions: Vec<String>,
    /// Visits and best action of each state.
    pub policy: Vec<PolicyRow>,
    /// What was seen.
    pub graph: Vec<GraphRow>,
}

/// Room for one update.
#[derive(Debug, Default)]
pub(super) struct Desk {
    slot: Mutex<Slot>,
    changed: Condvar,
    busy: AtomicBool,
}

#[derive(Debug, Default)]
struct Slot {
    update: Option<LiveUpdate>,
    closed: bool,
}

impl Desk {
    /// Whether the painter has done with the update before, and has rested.
    pub fn is_free(&self) -> bool {
        !self.busy.load(Ordering::Acquire)
    }

    /// Leaves an update in the place of what lies there.
    pub fn leave(&self, update: LiveUpdate) {
        self.busy.store(true, Ordering::Release);
        self.locked().update = Some(update);
        self.changed.notify_all();
    }

    /// Nothing will be left here any more.
    pub fn close(&self) {
        self.locked().closed = true;
        self.changed.notify_all();
    }

    /// Waits for an update; none after the last one.
    fn take(&self) -> Option<LiveUpdate> {
        let empty = |slot: &mut Slot| slot.update.is_none() && !slot.closed;
        let waited = self.changed.wait_while(self.locked(), empty);
        let mut slot = waited.unwrap_or_else(PoisonError::into_inner);
        slot.update.take()
    }

    /// Rests until the time has come or the desk is closed, and then asks for another update.
    fn rest(&self, time: Duration) {
        let open = |slot: &mut Slot| !slot.closed;
        drop(self.changed.wait_timeout_while(self.locked(), time, open));
        self.busy.store(false, Ordering::Release);
    }

    fn locked(&self) -> MutexGuard<'_, Slot> {
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Draws every update that is left on the desk, until it is closed; the last one too, for whoever comes later.
pub(super) fn paint(desk: &Desk, board: &Board, title: Title) {
    let name = title.scenario.name.as_str().into();
    let mut run = RecordedRun {
        name: title.name,
        resolved: title.scenario.to_toml(),
        scenario: title.scenario,
        arguments: title.arguments,
        summary: Summary::default(),
        seeds: vec![RecordedSeed::default()],
    };
    while let Some(update) = desk.take() {
        let begun = Instant::now();
        take_in(&mut run, update);
        let json = report_data(std::slice::from_ref(&run));
        board.put(std::sync::Arc::clone(&name), json.into());
        desk.rest((begun.elapsed() * REST).max(PAUSE));
    }
}

/// Replaces what was known before.
fn take_in(run: &mut RecordedRun, update: LiveUpdate) {
    run.summary.put(update.result, update.timing);
    let seed = &mut run.seeds[0];
    seed.seed = update.timing.seed;
    seed.episodes = update.episodes;
    seed.refreshes = update.refreshes;
    seed.snapshots = update.snapshots;
    seed.labels = update.labels;
    seed.actions = Some(update.actions);
    seed.policy = update.policy;
    seed.graph = update.graph;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::serve::tests::update;

    #[test]
    fn a_desk_is_free_once_the_painter_has_rested() {
        let desk = Desk::default();
        assert!(desk.is_free());
        desk.leave(update(1));
        assert!(!desk.is_free());
        assert!(desk.take().is_some());
        assert!(!desk.is_free(), "the painter has not rested yet");
        desk.rest(Duration::ZERO);
        assert!(desk.is_free());
    }
}
