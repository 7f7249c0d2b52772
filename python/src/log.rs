//! Events of the Rust half as records of Python's logger `eigentrail`.
//!
//! Events are rare (a refresh, a first goal), and steps make none: to ask the logger each time whether it wants one costs
//! nothing that could be measured, and its level may change at any time. Spans and traces are not passed on.

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;
use std::cell::RefCell;
use std::fmt::{Debug, Write};
use tracing::field::{Field, Visit};
use tracing::level_filters::LevelFilter;
use tracing::span::{Attributes, Id, Record};
use tracing::subscriber::Interest;
use tracing::{Event, Level, Metadata, Subscriber};

/// `logging.getLogger("eigentrail")`.
static LOGGER: PyOnceLock<Py<PyAny>> = PyOnceLock::new();

thread_local! {
    static RAISED: RefCell<Option<PyErr>> = const { RefCell::new(None) };
}

/// What Python raised on this thread while it was told of an event. Handlers of logs swallow their own errors: this is
/// a signal that was waiting for the interpreter, such as Ctrl-C, and must not be lost.
pub fn raised() -> Option<PyErr> {
    RAISED.with_borrow_mut(Option::take)
}

/// From now on events go to Python; not if another subscriber was there first.
pub fn pass_on() {
    let _ = tracing::subscriber::set_global_default(Bridge);
}

struct Bridge;

impl Subscriber for Bridge {
    fn register_callsite(&self, metadata: &'static Metadata<'static>) -> Interest {
        match metadata.is_event() && *metadata.level() <= Level::DEBUG {
            true => Interest::sometimes(),
            false => Interest::never(),
        }
    }

    fn max_level_hint(&self) -> Option<LevelFilter> {
        Some(LevelFilter::DEBUG)
    }

    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.is_event()
            && with_logger(|logger| {
                let asked = logger.call_method1("isEnabledFor", (number(metadata.level()),));
                asked?.extract()
            })
            .unwrap_or(false)
    }

    fn event(&self, event: &Event<'_>) {
        let mut told = Told::default();
        event.record(&mut told);
        with_logger(|logger| told.send(logger, event.metadata().level()));
    }

    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1)
    }

    fn record(&self, _: &Id, _: &Record<'_>) {}

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn enter(&self, _: &Id) {}

    fn exit(&self, _: &Id) {}
}

/// What an event says: its message, and its fields as text and as values.
#[derive(Default)]
struct Told {
    message: String,
    fields: Vec<(&'static str, Value)>,
}

enum Value {
    Integer(i64),
    Number(f64),
    Text(String),
}

impl Told {
    /// The record's message is the event's with `name=value` for each field; its attribute `fields` has them by name.
    fn send(&self, logger: &Bound<'_, PyAny>, level: &Level) -> PyResult<()> {
        let py = logger.py();
        let (mut text, fields) = (self.message.clone(), PyDict::new(py));
        for (name, value) in &self.fields {
            // A String takes whatever is written.
            let _ = match value {
                Value::Integer(value) => write!(text, " {name}={value}"),
                Value::Number(value) => write!(text, " {name}={value}"),
                Value::Text(value) => write!(text, " {name}={value}"),
            };
            match value {
                Value::Integer(value) => fields.set_item(name, value)?,
                Value::Number(value) => fields.set_item(name, value)?,
                Value::Text(value) => fields.set_item(name, value)?,
            }
        }
        let (extra, named) = (PyDict::new(py), PyDict::new(py));
        extra.set_item("fields", fields)?;
        named.set_item("extra", extra)?;
        logger.call_method("log", (number(level), "%s", text), Some(&named))?;
        Ok(())
    }

    fn put(&mut self, field: &Field, value: Value) {
        self.fields.push((field.name(), value));
    }
}

impl Visit for Told {
    fn record_i64(&mut self, field: &Field, value: i64) {
        self.put(field, Value::Integer(value));
    }

    fn record_u64(&mut self, field: &Field, value: u64) {
        self.put(field, Value::Integer(value as i64));
    }

    fn record_f64(&mut self, field: &Field, value: f64) {
        self.put(field, Value::Number(value));
    }

    fn record_str(&mut self, field: &Field, value: &str) {
        self.put(field, Value::Text(value.to_owned()));
    }

    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        match field.name() {
            "message" => self.message = format!("{value:?}"),
            _ => self.put(field, Value::Text(format!("{value:?}"))),
        }
    }
}

/// Python's number for a level.
fn number(level: &Level) -> u8 {
    match *level {
        Level::ERROR => 40,
        Level::WARN => 30,
        Level::INFO => 20,
        _ => 10,
    }
}

/// None while the interpreter shuts down, or if something is [raised].
fn with_logger<T>(work: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<T>) -> Option<T> {
    Python::try_attach(|py| {
        let logger = LOGGER.get_or_try_init(py, || {
            let logging = py.import("logging")?;
            Ok::<_, PyErr>(logging.call_method1("getLogger", ("eigentrail",))?.unbind())
        });
        let result = logger.and_then(|logger| work(logger.bind(py)));
        result.map_err(|error| RAISED.set(Some(error))).ok()
    })
    .flatten()
}
