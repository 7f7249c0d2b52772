//! Experiments as files.
mod document;
mod error;
pub use document::Document;
pub use error::{BrokenRule, Place, ScenarioError, nearest};
