//! Experiments, repeated.
mod error;
pub mod files;
mod folder;

pub use error::RunnerError;
pub use folder::{Existing, RunFolder, is_run, seed_folder_name};
