//! From what the run leaves on the desk to drawings on the board.

use super::Title;
use super::board::Board;
use crate::report::{RecordedRun, RecordedSeed, Summary, report_data};
use crate::runner::Moment;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Between two drawings, so that reading them is possible.
const PAUSE: Duration = Duration::from_secs(1);

/// The painter rests so many times as long as it worked: a tenth of one processor is what it may take.
const REST: u32 = 9;

/// Room for one moment.
#[derive(Debug, Default)]
pub(super) struct Desk {
    slot: Mutex<Slot>,
    changed: Condvar,
    busy: AtomicBool,
}

#[derive(Debug, Default)]
struct Slot {
    moment: Option<Moment>,
    closed: bool,
}

impl Desk {
    /// Whether the painter has done with the moment before, and has rested.
    pub fn is_free(&self) -> bool {
        !self.busy.load(Ordering::Acquire)
    }

    /// Leaves a moment in the place of what lies there.
    pub fn leave(&self, moment: Moment) {
        self.busy.store(true, Ordering::Release);
        self.locked().moment = Some(moment);
        self.changed.notify_all();
    }

    /// Nothing will be left here any more.
    pub fn close(&self) {
        self.locked().closed = true;
        self.changed.notify_all();
    }

    fn is_closed(&self) -> bool {
        self.locked().closed
    }

    /// Waits for a moment; none after the last one.
    fn take(&self) -> Option<Moment> {
        let empty = |slot: &mut Slot| slot.moment.is_none() && !slot.closed;
        let waited = self.changed.wait_while(self.locked(), empty);
        let mut slot = waited.unwrap_or_else(PoisonError::into_inner);
        slot.moment.take()
    }

    /// Rests until the time has come or the desk is closed, and then asks for another moment.
    fn rest(&self, time: Duration) {
        let open = |slot: &mut Slot| !slot.closed;
        drop(self.changed.wait_timeout_while(self.locked(), time, open));
        self.busy.store(false, Ordering::Release);
    }

    fn locked(&self) -> MutexGuard<'_, Slot> {
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Draws every moment that is left on the desk, until it is closed.
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
    while let Some(moment) = desk.take() {
        let begun = Instant::now();
        take_in(&mut run, moment);
        if desk.is_closed() && !board.is_looked_at() {
            return;
        }
        let json = report_data(std::slice::from_ref(&run));
        board.put(std::sync::Arc::clone(&name), json.into());
        desk.rest((begun.elapsed() * REST).max(PAUSE));
    }
}

/// Replaces what was known before.
fn take_in(run: &mut RecordedRun, moment: Moment) {
    run.summary.put(moment.result, moment.timing);
    let seed = &mut run.seeds[0];
    seed.seed = moment.timing.seed;
    seed.episodes = moment.episodes;
    seed.refreshes = moment.refreshes;
    seed.snapshots = moment.snapshots;
    seed.labels = moment.labels;
    seed.policy = moment.policy;
    seed.graph = moment.graph;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::serve::tests::moment;

    #[test]
    fn a_desk_is_free_once_the_painter_has_rested() {
        let desk = Desk::default();
        assert!(desk.is_free());
        desk.leave(moment(1));
        assert!(!desk.is_free());
        assert!(desk.take().is_some());
        assert!(!desk.is_free(), "the painter has not rested yet");
        desk.rest(Duration::ZERO);
        assert!(desk.is_free());
    }
}
