//! JSON lines, each seed's in its own file, also when seeds run side by side.
//!
//! The `run` span of a seed is given the number of its [`SeedLog`] in the field `log`, as soon as the file is open. Everything below that span
//! goes to that file, whichever thread it happens on; everything outside such a span goes nowhere. A line is
//! written when an event happens and when a span closes:
//! `{"time":…,"level":…,"name":"spectrum_refresh","step":…,"nodes":…,…,"elapsed_ms":…}`.

use crate::disk::DiskFile;
use crate::time_stamp;
use serde::Serialize;
use serde_json::{Map, Value};
use std::collections::HashMap;
use std::fmt;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;
use tracing::field::{Field, Visit};
use tracing::{Event, Metadata, Subscriber, span};
use tracing_subscriber::Layer;
use tracing_subscriber::layer::Context;
use tracing_subscriber::registry::LookupSpan;

/// Hands out files for seeds and finds them again. Clones share the files.
#[derive(Clone, Debug, Default)]
pub struct EventLog {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    open: Mutex<HashMap<u64, Sink>>,
    next: AtomicU64,
}

/// A file, and the first error that writing to it met.
#[derive(Clone, Debug)]
struct Sink(Arc<Mutex<(BufWriter<DiskFile>, Option<io::Error>)>>);

/// The open event file of one seed; dropping it closes the file.
#[derive(Debug)]
pub struct SeedLog {
    number: u64,
    sink: Sink,
    shared: Arc<Shared>,
}

impl EventLog {
    /// Creates the file of one seed.
    pub fn open(&self, path: &Path) -> io::Result<SeedLog> {
        Ok(self.keep(DiskFile::create(path)?))
    }

    /// Goes on behind the first `length` bytes of the file of one seed; what of them is gone is not missed.
    pub fn go_on(&self, path: &Path, length: u64) -> io::Result<SeedLog> {
        let mut file = DiskFile::open_or_create(path)?;
        file.set_length(length.min(file.length()?))?;
        Ok(self.keep(file))
    }

    fn keep(&self, file: DiskFile) -> SeedLog {
        let writer = BufWriter::new(file);
        let sink = Sink(Arc::new(Mutex::new((writer, None))));
        let number = self.shared.next.fetch_add(1, Ordering::Relaxed);
        locked(&self.shared.open).insert(number, sink.clone());
        SeedLog {
            number,
            sink,
            shared: Arc::clone(&self.shared),
        }
    }

    /// The reader that fills the files.
    pub(super) fn layer(&self) -> EventLogLayer {
        EventLogLayer {
            shared: Arc::clone(&self.shared),
        }
    }
}

impl SeedLog {
    /// The value for the field `log` of the seed's `run` span.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// Brings what was logged so far to the disk. The length of the file.
    ///
    /// # Errors
    /// As [`flush`](Self::flush).
    pub fn sync(&self) -> io::Result<u64> {
        self.flush()?;
        let mut sink = locked(&self.sink.0);
        let file = sink.0.get_mut();
        file.sync()?;
        file.length()
    }

    /// Brings what was logged so far to the file.
    ///
    /// # Errors
    /// The first error met while writing since the last call.
    pub fn flush(&self) -> io::Result<()> {
        let mut sink = locked(&self.sink.0);
        match sink.1.take() {
            Some(error) => Err(error),
            None => sink.0.flush(),
        }
    }
}

impl Drop for SeedLog {
    fn drop(&mut self) {
        locked(&self.shared.open).remove(&self.number);
        // An error here has nobody left to go to; `flush` is the way to hear of it.
        let _ = self.flush();
    }
}

impl Sink {
    fn write(&self, line: &Line) {
        let mut sink = locked(&self.0);
        let written = serde_json::to_writer(&mut sink.0, line)
            .map_err(io::Error::from)
            .and_then(|()| sink.0.write_all(b"\n"));
        if let Err(error) = written {
            sink.1.get_or_insert(error);
        }
    }
}

/// A panic elsewhere does not spoil a log.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The `tracing` side of [`EventLog`].
pub(super) struct EventLogLayer {
    shared: Arc<Shared>,
}

impl EventLogLayer {
    /// The file that the field `log` names, which is then left out.
    fn take_sink(&self, fields: &mut Fields) -> Option<Sink> {
        let number = fields.0.shift_remove("log")?.as_u64()?;
        locked(&self.shared.open).get(&number).cloned()
    }
}

/// What a span remembers until it closes.
struct OpenSpan {
    fields: Map<String, Value>,
    begun: Instant,
    sink: Option<Sink>,
}

impl<S: Subscriber + for<'a> LookupSpan<'a>> Layer<S> for EventLogLayer {
    fn on_new_span(&self, attributes: &span::Attributes<'_>, id: &span::Id, ctx: Context<'_, S>) {
        let Some(span) = ctx.span(id) else { return };
        let mut fields = Fields::default();
        attributes.record(&mut fields);
        let sink = span.parent().and_then(|parent| {
            let extensions = parent.extensions();
            extensions.get::<OpenSpan>().and_then(|p| p.sink.clone())
        });
        span.extensions_mut().insert(OpenSpan {
            fields: fields.0,
            begun: Instant::now(),
            sink,
        });
    }

    fn on_record(&self, id: &span::Id, values: &span::Record<'_>, ctx: Context<'_, S>) {
        let Some(span) = ctx.span(id) else { return };
        if let Some(open) = span.extensions_mut().get_mut::<OpenSpan>() {
            let mut fields = Fields(std::mem::take(&mut open.fields));
            values.record(&mut fields);
            if let Some(own) = self.take_sink(&mut fields) {
                open.sink = Some(own);
            }
            open.fields = fields.0;
        }
    }

    fn on_event(&self, event: &Event<'_>, ctx: Context<'_, S>) {
        let Some(span) = ctx.event_span(event) else {
            return;
        };
        let extensions = span.extensions();
        let Some(sink) = extensions.get::<OpenSpan>().and_then(|s| s.sink.as_ref()) else {
            return;
        };
        let mut fields = Fields::default();
        event.record(&mut fields);
        sink.write(&line(event.metadata(), fields.0));
    }

    fn on_close(&self, id: span::Id, ctx: Context<'_, S>) {
        let Some(span) = ctx.span(&id) else { return };
        let Some(mut open) = span.extensions_mut().remove::<OpenSpan>() else {
            return;
        };
        if let Some(sink) = open.sink.take() {
            let elapsed = open.begun.elapsed().as_secs_f64() * 1e3;
            open.fields.insert("elapsed_ms".to_owned(), elapsed.into());
            sink.write(&line(span.metadata(), open.fields));
        }
    }
}

/// A line of the file.
#[derive(Serialize)]
struct Line {
    time: String,
    level: &'static str,
    name: String,
    #[serde(flatten)]
    fields: Map<String, Value>,
}

/// An event without a name of its own is named by its message if that is one word, else `message`. A message that
/// repeats the name is left out.
fn line(metadata: &Metadata<'_>, mut fields: Map<String, Value>) -> Line {
    let unnamed = metadata.is_event() && metadata.name().starts_with("event ");
    let message = fields.get("message").and_then(Value::as_str);
    let word = message.filter(|text| !text.contains(char::is_whitespace));
    let name = match (unnamed, word) {
        (true, Some(word)) => word.to_owned(),
        (true, None) => "message".to_owned(),
        (false, _) => metadata.name().to_owned(),
    };
    if message == Some(&name) {
        fields.shift_remove("message");
    }
    Line {
        time: time_stamp::now(),
        level: metadata.level().as_str(),
        name,
        fields,
    }
}

/// `tracing`'s fields as JSON.
#[derive(Default)]
struct Fields(Map<String, Value>);

impl Fields {
    fn put(&mut self, field: &Field, value: impl Into<Value>) {
        self.0.insert(field.name().to_owned(), value.into());
    }
}

impl Visit for Fields {
    fn record_f64(&mut self, field: &Field, value: f64) {
        self.put(field, value);
    }
    fn record_i64(&mut self, field: &Field, value: i64) {
        self.put(field, value);
    }
    fn record_u64(&mut self, field: &Field, value: u64) {
        self.put(field, value);
    }
    fn record_bool(&mut self, field: &Field, value: bool) {
        self.put(field, value);
    }
    fn record_str(&mut self, field: &Field, value: &str) {
        self.put(field, value);
    }
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        self.put(field, format!("{value:?}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracing::{Level, debug_span, info, info_span};
    use tracing_subscriber::layer::SubscriberExt;

    fn lines(path: &Path) -> Vec<Value> {
        let text = std::fs::read_to_string(path).unwrap();
        text.lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect()
    }

    #[test]
    fn every_seed_writes_to_its_own_file() {
        let folder = tempfile::tempdir().unwrap();
        let log = EventLog::default();
        let subscriber = tracing_subscriber::registry().with(log.layer());
        tracing::subscriber::with_default(subscriber, || {
            let paths = [0, 1].map(|i| folder.path().join(format!("{i}.jsonl")));
            let logs = paths.clone().map(|path| log.open(&path).unwrap());
            for (seed, seed_log) in logs.iter().enumerate() {
                let run = info_span!("run", seed, log = tracing::field::Empty);
                run.record("log", seed_log.number());
                let _in_run = run.enter();
                let refresh = debug_span!("spectrum_refresh", nodes = tracing::field::Empty);
                refresh.in_scope(|| info!(step = 7 + seed, "first_goal"));
                info!("two words");
                refresh.record("nodes", 12_u64);
            }
            info!("nobody's");
            for (seed, (path, seed_log)) in paths.iter().zip(&logs).enumerate() {
                seed_log.flush().unwrap();
                let lines = lines(path);
                assert_eq!(lines.len(), 4, "two events, refresh, run: {lines:?}");
                assert_eq!(lines[0]["name"], "first_goal");
                assert_eq!(lines[0]["step"], 7 + seed);
                assert_eq!(lines[0]["level"], Level::INFO.as_str());
                assert!(lines[0]["message"].is_null());
                assert_eq!(lines[1]["name"], "message");
                assert_eq!(lines[1]["message"], "two words");
                assert_eq!(lines[2]["name"], "spectrum_refresh");
                assert_eq!(lines[2]["nodes"], 12);
                assert!(lines[2]["elapsed_ms"].as_f64().unwrap() >= 0.0);
                assert_eq!(lines[3]["name"], "run");
                assert_eq!(lines[3]["seed"], seed);
            }
        });
    }
}
