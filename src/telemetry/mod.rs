//! Messages of the program about itself while it works: one instrumentation (`tracing`), three readers.
//!
//! - people: lines on stderr, warnings only unless asked for more ([`Options::level`]);
//! - programs: JSON lines in the folder of each seed ([`EventLog`]);
//! - profilers: a Chrome trace for `chrome://tracing` or Perfetto ([`Options::chrome_trace`]).
//!
//! # Glossary
//! | name | kind | says | fields |
//! |---|---|---|---|
//! | [`RUN`] | span | one seed of a scenario, from first to last step | `scenario`, `seed` |
//! | [`EPISODE`] | span | one episode; only in Chrome traces and with `-vvv` | `episode` |
//! | [`GRAPH_GROWTH`] | event | the graph at a refresh | `step`, `nodes`, `edges` |
//! | [`SPECTRUM_REFRESH`] | event | the eigenvectors are up to date | `step`, `nodes`, `edges`, `converged`, `applications`, `max_relative_residual` |
//! | [`GCN_FIT`] | event | the potential is fitted | `step`, `nodes`, `loss`, `epochs` |
//! | [`FIRST_GOAL`] | event | the first rewarding end of an episode | `step`, `nodes` |
//!
//! `step` counts environment steps from the beginning of the run, `edges` undirected edges, `applications` columns
//! multiplied by the Laplacian. `elapsed_ms`, wall milliseconds, stands in the lines of spans that have closed and of
//! events that tell the end of some work.

mod event_log;
mod stderr;
mod trace;

pub use event_log::{EventLog, SeedLog};
pub use stderr::say;

use indicatif::MultiProgress;
use std::io;
use std::path::PathBuf;
use tracing::level_filters::LevelFilter;
use tracing_chrome::{ChromeLayerBuilder, FlushGuard};
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{Layer, fmt};

/// Span: one seed of a scenario.
pub const RUN: &str = "run";
/// Span: one episode.
pub const EPISODE: &str = "episode";
/// Event: the graph has grown.
pub const GRAPH_GROWTH: &str = "graph_growth";
/// Event: the eigenvectors are up to date.
pub const SPECTRUM_REFRESH: &str = "spectrum_refresh";
/// Event: the potential is fitted.
pub const GCN_FIT: &str = "gcn_fit";
/// Event: a goal was reached for the first time.
pub const FIRST_GOAL: &str = "first_goal";

/// Form of lines on stderr.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LogFormat {
    /// Short lines without a clock.
    #[default]
    Text,
    /// One JSON object a line.
    Json,
}

/// Readers of what the program says, and how much they get.
#[derive(Clone, Debug)]
pub struct Options {
    /// The least important line that reaches stderr.
    pub level: LevelFilter,
    /// How those lines look.
    pub format: LogFormat,
    /// Whether they are coloured.
    pub color: bool,
    /// Where to write a Chrome trace, if anywhere.
    pub chrome_trace: Option<PathBuf>,
}

/// The installed readers. Keep it until the end of the program: dropping it completes the Chrome trace.
pub struct Telemetry {
    /// Opens the JSON lines of a seed.
    pub events: EventLog,
    /// Progress bars register here, so that log lines do not tear them.
    pub bars: MultiProgress,
    _chrome: Option<FlushGuard>,
}

/// Installs the readers for this process. Meant for programs, once; libraries leave it to their user.
///
/// # Errors
/// If the Chrome trace cannot be created, or the process has a `tracing` subscriber already.
pub fn install(options: &Options) -> io::Result<Telemetry> {
    let events = EventLog::default();
    let bars = stderr::bars();
    let ours = |level: LevelFilter| Targets::new().with_target("eigentrail", level);
    let (chrome, guard) = match &options.chrome_trace {
        Some(path) => {
            let (layer, guard) = ChromeLayerBuilder::new()
                .writer(trace::TraceFile::create(path)?)
                .include_args(true)
                .build();
            (Some(layer), Some(guard))
        }
        None => (None, None),
    };
    tracing_subscriber::registry()
        .with(events.layer().with_filter(ours(LevelFilter::DEBUG)))
        .with(chrome.map(|layer| layer.with_filter(ours(LevelFilter::TRACE))))
        .with(human(options, &bars).with_filter(ours(options.level)))
        .try_init()
        .map_err(io::Error::other)?;
    Ok(Telemetry {
        events,
        bars,
        _chrome: guard,
    })
}

/// The lines on stderr.
fn human<S>(options: &Options, bars: &MultiProgress) -> Box<dyn Layer<S> + Send + Sync>
where
    S: tracing::Subscriber + for<'a> tracing_subscriber::registry::LookupSpan<'a>,
{
    let lines = fmt::layer()
        .log_internal_errors(false) // that would be one more message that can fail
        .with_writer(stderr::Beside(bars.clone()))
        .with_ansi(options.color)
        .with_target(false);
    match options.format {
        LogFormat::Text => lines.without_time().boxed(),
        LogFormat::Json => lines.json().boxed(),
    }
}
