//! The newest drawing, for everybody to see.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A drawing: the object that the page is drawn from, as JSON.
#[derive(Clone, Debug)]
pub(super) struct Drawing {
    /// Counts drawings from 1.
    pub number: u64,
    /// What the page is called.
    pub title: Arc<str>,
    /// The object, without line breaks.
    pub json: Arc<str>,
}

/// Holds one drawing; a new one takes its place whether or not anybody has seen it.
#[derive(Debug, Default)]
pub(super) struct Board {
    state: Mutex<State>,
    changed: Condvar,
    onlookers: AtomicUsize,
}

#[derive(Debug, Default)]
struct State {
    newest: Option<Drawing>,
    ended: bool,
}

/// What waiting came to.
#[derive(Clone, Debug)]
pub(super) enum News {
    /// A drawing that is newer than the one known.
    Drawing(Drawing),
    /// None in that time.
    Nothing,
    /// There will be none any more.
    End,
}

/// Somebody who looks at the board, until dropped.
#[derive(Debug)]
pub(super) struct Onlooker<'a>(&'a Board);

impl Board {
    pub fn look(&self) -> Onlooker<'_> {
        self.onlookers.fetch_add(1, Ordering::Relaxed);
        Onlooker(self)
    }

    pub fn is_looked_at(&self) -> bool {
        self.onlookers.load(Ordering::Relaxed) > 0
    }

    pub fn put(&self, title: Arc<str>, json: Arc<str>) {
        let mut state = self.locked();
        let number = state.newest.as_ref().map_or(0, |drawing| drawing.number) + 1;
        state.newest = Some(Drawing {
            number,
            title,
            json,
        });
        self.changed.notify_all();
    }

    /// No drawing will come any more.
    pub fn end(&self) {
        self.locked().ended = true;
        self.changed.notify_all();
    }

    /// Waits at most `patience` for a drawing after number `known`.
    pub fn news(&self, known: u64, patience: Duration) -> News {
        let nothing_new = |state: &mut State| {
            let newest = state.newest.as_ref();
            !state.ended && newest.is_none_or(|drawing| drawing.number <= known)
        };
        let waited = self
            .changed
            .wait_timeout_while(self.locked(), patience, nothing_new);
        let (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        match &state.newest {
            Some(drawing) if drawing.number > known => News::Drawing(drawing.clone()),
            _ if state.ended => News::End,
            _ => News::Nothing,
        }
    }

    /// A thread that panicked has left whole drawings behind.
    fn locked(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Onlooker<'_> {
    fn drop(&mut self) {
        self.0.onlookers.fetch_sub(1, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_comes_late_sees_the_newest_only() {
        let board = Board::default();
        let moment = Duration::from_millis(1);
        assert!(matches!(board.news(0, moment), News::Nothing));
        for json in ["1", "2", "3"] {
            board.put("t".into(), json.into());
        }
        let News::Drawing(drawing) = board.news(1, moment) else {
            panic!("there is one");
        };
        assert_eq!((drawing.number, &*drawing.json), (3, "3"));
        assert!(matches!(board.news(3, moment), News::Nothing));
        board.end();
        assert!(matches!(board.news(2, moment), News::Drawing(_)));
        assert!(matches!(board.news(3, moment), News::End));
    }

    #[test]
    fn onlookers_are_counted() {
        let board = Board::default();
        let (one, two) = (board.look(), board.look());
        drop(one);
        assert!(board.is_looked_at());
        drop(two);
        assert!(!board.is_looked_at());
    }
}
