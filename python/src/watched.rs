//! Long work that can be interrupted: it goes on in a thread of its own, while the one that called looks after signals and
//! progress.

use crate::calls::{bug, guarded};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::ThreadPoolBuilder;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::{Builder, scope};
use std::time::Duration;

/// How often signals are looked after.
const TICK: Duration = Duration::from_millis(50);

/// Work under way, as it is seen from outside.
#[derive(Debug, Default)]
pub struct Watched {
    /// Set as soon as it is to end.
    pub stop: AtomicBool,
    /// How much there is; 0 as long as that is not known.
    pub total: AtomicUsize,
    /// How much of it is done.
    pub done: AtomicUsize,
}

impl Watched {
    /// One thing more is done.
    pub fn advance(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }
}

/// What `work` returns; it is run without the interpreter's lock on so many threads. `progress` is called with what is done by then
/// and what there is, now and then and at the end. After a signal such as Ctrl-C, or if `progress` raises, the work is asked to end, waited for, and
/// that is raised.
pub fn watched<T: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(&Watched) -> T + Send,
) -> PyResult<T> {
    let seen = &Watched::default();
    let look = || -> PyResult<()> {
        Python::attach(|py| -> PyResult<()> {
            py.check_signals()?;
            if let Some(progress) = progress {
                let [done, total] = [&seen.done, &seen.total].map(|n| n.load(Ordering::Relaxed));
                progress.call1(py, (done, total))?;
            }
            Ok(())
        })
    };
    let (ended, looked) = py.detach(|| {
        scope(|scope| -> PyResult<_> {
            let (tell, told) = channel();
            let work = move || {
                let result = guarded(|| on_threads(threads, || work(seen)));
                let _ = tell.send(()); // nobody listens any more if looking went wrong
                result
            };
            let worker = Builder::new().spawn_scoped(scope, work);
            let worker = worker.map_err(|error| {
                PyRuntimeError::new_err(format!("cannot start a thread: {error}"))
            })?;
            let mut looked: PyResult<()> = Ok(());
            while looked.is_ok() && told.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
                looked = look();
            }
            if looked.is_err() {
                seen.stop.store(true, Ordering::Relaxed);
            }
            Ok((worker.join().and_then(|result| result), looked))
        })
    })?;
    looked?;
    let result = ended.map_err(bug)??;
    look()?;
    Ok(result)
}

fn on_threads<T: Send>(threads: Option<usize>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let Some(threads) = threads else {
        return Ok(work());
    };
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool
        .map_err(|error| PyRuntimeError::new_err(format!("cannot start the threads: {error}")))?;
    Ok(pool.install(work))
}
