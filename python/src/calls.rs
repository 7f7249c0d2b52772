//! Calls that may take long: without the interpreter's lock, with panics as exceptions, and in forked processes too.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::ThreadPool;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Whether this process was forked off another one, whose threads it does not have.
static FORKED: AtomicBool = AtomicBool::new(false);

/// The threads of a forked process.
static OWN_POOL: Mutex<Option<Arc<ThreadPool>>> = Mutex::new(None);

/// Runs `work` without the interpreter's lock. A panic, which would be a bug, becomes a `RuntimeError`.
pub fn unlocked<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| guarded(work)).map_err(bug)
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
