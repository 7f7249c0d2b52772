//! The threads of the program: as many as asked for, or as there are to be had.

use anyhow::{Context, Result};
use eigentrail::telemetry::say;
use std::io;
use std::num::NonZeroUsize;
use std::sync::Mutex;
use std::thread::{Builder, available_parallelism, scope};

/// Left to the signal handler, the live page and the trace.
const SPARE: usize = 4;

/// Gives rayon `wanted` threads, or one for each processor; fewer, with a warning, if the system refuses some, and only
/// the present one if it refuses all. Results do not depend on it.
pub fn start(wanted: Option<usize>) -> Result<()> {
    let processors = || available_parallelism().map_or(1, NonZeroUsize::get);
    let wanted = wanted.unwrap_or_else(processors);
    let had = how_many(wanted + SPARE).saturating_sub(SPARE);
    let pool = rayon::ThreadPoolBuilder::new();
    let pool = match had {
        0 => pool.num_threads(1).use_current_thread(),
        some => pool.num_threads(some),
    };
    pool.build_global().context("cannot start the threads")?;
    let used = rayon::current_num_threads();
    if used < wanted {
        say(format!(
            "warning: {wanted} threads are not to be had; going on with {used}"
        ));
    }
    Ok(())
}

/// Fails if not even one more thread can be had.
pub fn require_one() -> io::Result<()> {
    let thread = Builder::new().spawn(|| ())?;
    thread.join().map_err(|_| io::ErrorKind::Other.into())
}

/// How many of `wanted` threads can be had side by side. They are tried out, because rayon's common pool, once it has
/// failed to start, cannot be started again.
fn how_many(wanted: usize) -> usize {
    let gate = Mutex::new(());
    scope(|scope| {
        let closed = gate.lock();
        let wait = || drop(gate.lock());
        let held = (0..wanted)
            .take_while(|_| Builder::new().spawn_scoped(scope, wait).is_ok())
            .count();
        drop(closed);
        held
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_threads_can_be_had() {
        assert_eq!(how_many(3), 3);
    }
}
