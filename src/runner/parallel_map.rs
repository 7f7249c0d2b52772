//! Many independent jobs on all threads.
//!
//! Each worker is a pool of one thread: what a job would split among threads it does itself. With jobs as tasks of
//! one common pool a worker that waits inside a job could pick up a whole other job meanwhile, and the clock of the
//! first would count the second.

use rayon::ThreadPoolBuilder;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::Builder;

/// Results of `work` on every job, as many at a time as rayon has threads; in the order of the jobs. After the first
/// failure no further job is begun, and of the failures there are the one that comes first in the list is returned.
/// Where the system refuses threads, those that there are do all of it.
///
/// # Errors
/// What a job failed with.
///
/// # Panics
/// If a job panics.
pub fn parallel_map<J: Sync, T: Send, E: Send>(
    jobs: &[J],
    work: impl Fn(&J) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let next = AtomicUsize::new(0);
    let slots: Vec<Mutex<Option<Result<T, E>>>> = jobs.iter().map(|_| Mutex::new(None)).collect();
    let begin_and_end = || {
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let Some(job) = jobs.get(i) else { break };
            let done = work(job);
            if done.is_err() {
                next.store(jobs.len(), Ordering::Relaxed);
            }
            *slots[i].lock().expect("only this worker has this slot") = Some(done);
        }
    };
    let worker = || match ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(pool) => pool.install(begin_and_end),
        Err(_) => begin_and_end(),
    };
    std::thread::scope(|scope| {
        let wanted = rayon::current_num_threads().min(jobs.len());
        let started = (0..wanted)
            .take_while(|_| Builder::new().spawn_scoped(scope, worker).is_ok())
            .count();
        if started == 0 {
            begin_and_end();
        }
    });
    slots
        .into_iter()
        .filter_map(|slot| slot.into_inner().expect("only its worker had this slot"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_keep_the_order_of_the_jobs() {
        let jobs: Vec<u64> = (0..100).collect();
        let squares: Result<Vec<u64>, ()> = parallel_map(&jobs, |&x| Ok(x * x));
        assert_eq!(
            squares.unwrap(),
            jobs.iter().map(|x| x * x).collect::<Vec<_>>()
        );
        let none: Result<Vec<u64>, ()> = parallel_map(&[], |&x: &u64| Ok(x));
        assert!(none.unwrap().is_empty());
    }

    #[test]
    fn a_failure_ends_it() {
        let begun = AtomicUsize::new(0);
        let jobs: Vec<u64> = (0..10_000).collect();
        let result = parallel_map(&jobs, |&x| {
            begun.fetch_add(1, Ordering::Relaxed);
            if x == 3 { Err(x) } else { Ok(x) }
        });
        assert_eq!(result.unwrap_err(), 3);
        assert!(begun.into_inner() < jobs.len());
    }

    #[test]
    fn inner_parallelism_stays_in_its_job() {
        let threads = parallel_map(&[1, 2], |_| Ok::<_, ()>(rayon::current_num_threads()));
        assert_eq!(threads.unwrap(), [1, 1]);
    }
}
