//! Event files as [TensorBoard](https://www.tensorflow.org/tensorboard) reads them, written without TensorFlow.
//!
//! A file is a sequence of framed records ([`record`](mod@record)), each a protocol buffer `Event` with a time, a step and
//! the values of that moment. The first one names the version of the format.
//!
//! ```
//! use eigentrail::tensorboard::{Summary, write_event, write_version};
//!
//! let mut file = Vec::new();
//! write_version(&mut file, 0.0);
//! let mut now = Summary::default();
//! now.scalar("charts/episodic_return", -12.0);
//! now.text("notes", "a *first* episode");
//! write_event(&mut file, 0.5, 12, &now);
//! ```
//!
//! TensorBoard takes any file with `.tfevents.` in its name. [`TensorBoardWriter`] writes that of a run.

mod histogram;
mod map_png;
mod protobuf;
pub mod record;
mod summary;
mod writer;

pub use summary::{Png, Summary};
pub use writer::TensorBoardWriter;

use protobuf::Message;

/// Appends the record that an event file begins with; `wall_time` in seconds since 1970.
pub fn write_version(out: &mut Vec<u8>, wall_time: f64) {
    let mut event = Message::default();
    event.double(1, wall_time);
    event.bytes(3, b"brain.Event:2");
    record::append(out, event.as_bytes());
}

/// Appends the record of `summary` at `step`; `wall_time` in seconds since 1970.
pub fn write_event(out: &mut Vec<u8>, wall_time: f64, step: u64, summary: &Summary) {
    let mut event = Message::default();
    event.double(1, wall_time);
    event.integer(2, step);
    event.message(5, summary.message());
    record::append(out, event.as_bytes());
}
