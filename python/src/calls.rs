//! Calls that may take long: without the interpreter's lock, with panics as exceptions, and in forked processes too.

use crate::log;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::ThreadPool;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// How long a signal may wait for an answer.
const PATIENCE: Duration = Duration::from_millis(50);

/// Whether this process was forked off another one, whose threads it does not have.
static FORKED: AtomicBool = AtomicBool::new(false);

/// The threads of a forked process.
static OWN_POOL: Mutex<Option<Arc<ThreadPool>>> = Mutex::new(None);

/// Runs `work` without the interpreter's lock. A panic, which would be a bug, becomes a `RuntimeError`.
pub fn unlocked<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let result = py.detach(|| guarded(work)).map_err(bug);
    match log::raised() {
        Some(signal) => Err(signal),
        None => result,
    }
}

/// The same for work that may take minutes: a signal whose handler raises, such as Ctrl-C, ends the call at once. Nothing
/// can stop the work itself; it goes on in the background, and what comes of it is thrown away.
pub fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let (sender, mut receiver) = mpsc::channel();
    // Nobody receives after a signal.
    let run = move || drop(sender.send(guarded(work)));
    let spawned = thread::Builder::new().name("eigentrail".into()).spawn(run);
    spawned
        .map_err(|error| PyRuntimeError::new_err(format!("no thread could be started: {error}")))?;
    loop {
        let (answer, back) = py.detach(move || waited(receiver));
        receiver = back;
        match answer {
            Ok(result) => return result.map_err(bug),
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("bug in eigentrail: no answer"));
            }
        }
    }
}

fn waited<T>(receiver: Receiver<T>) -> (Result<T, RecvTimeoutError>, Receiver<T>) {
    (receiver.recv_timeout(PATIENCE), receiver)
}

/// Runs `work`, with threads that are there, and returns its panic instead of passing it on.
pub fn guarded<T: Send>(work: impl FnOnce() -> T + Send) -> std::thread::Result<T> {
    catch_unwind(AssertUnwindSafe(|| match FORKED.load(Ordering::Relaxed) {
        true => in_own_pool(work),
        false => work(),
    }))
}

/// A panic as a `RuntimeError`.
pub fn bug(panic: Box<dyn Any + Send>) -> PyErr {
    PyRuntimeError::new_err(format!("bug in eigentrail: {}", text(&*panic)))
}

/// Rayon's global pool is that of the parent process: nobody would ever answer from there.
fn in_own_pool<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let pool = {
        let mut kept = OWN_POOL.lock().unwrap_or_else(PoisonError::into_inner);
        match &*kept {
            Some(pool) => Some(Arc::clone(pool)),
            None => {
                let pool = rayon::ThreadPoolBuilder::new().build().ok().map(Arc::new);
                kept.clone_from(&pool);
                pool
            }
        }
    };
    match pool {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

/// To be called in the child after a fork.
#[pyfunction]
pub fn after_fork() {
    FORKED.store(true, Ordering::Relaxed);
    let mut kept = OWN_POOL.lock().unwrap_or_else(PoisonError::into_inner);
    // The pool of a parent that was forked itself: its threads are not here to be joined.
    std::mem::forget(kept.take());
}

fn text(panic: &(dyn Any + Send)) -> &str {
    let literal = panic.downcast_ref::<&str>().copied();
    let formatted = panic.downcast_ref::<String>().map(String::as_str);
    literal.or(formatted).unwrap_or("a panic without a message")
}
