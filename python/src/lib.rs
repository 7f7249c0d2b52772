//! The Rust half of the Python package `eigentrail`: the calls that must be fast, with as few types as they need.
//!
//! Whatever can be said in Python is said there: this module takes bytes, numbers and arrays, and gives the same back.

#![warn(clippy::disallowed_methods)]

mod aliases;
mod arrays;
mod calls;
mod container;
mod engine;
mod errors;
mod experiments;
mod learner;
mod log;
mod mdp;
mod parameters;
mod seen;
mod shards;
mod tracker;
mod watched;
mod worlds;

use pyo3::prelude::*;

#[pymodule]
mod _eigentrail {
    #[pymodule_export]
    use crate::calls::after_fork;
    #[pymodule_export]
    use crate::engine::Engine;
    #[pymodule_export]
    use crate::experiments::{compare, run, sweep};
    #[pymodule_export]
    use crate::learner::Learner;
    #[pymodule_export]
    use crate::mdp::solve;
    #[pymodule_export]
    use crate::shards::{SweepFolder, run_shard};
    #[pymodule_export]
    use crate::tracker::{EigenTracker, track};
    #[pymodule_export]
    use crate::worlds::{pack_worlds, unpack_worlds};
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(_module: &Bound<'_, PyModule>) -> PyResult<()> {
        crate::log::pass_on();
        Ok(())
    }
}
