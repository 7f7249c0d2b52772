//! `eigentrail track`

use super::progress::Progress;
use super::{BadInput, Ending, require_writable};
use crate::cli::{self, LaplacianChoice, MethodChoice};
use crate::output::{print, print_json};
use crate::signals;
use anyhow::Result;
use comfy_table::{Table, presets};
use eigentrail::archive::write_matrix;
use eigentrail::error::{Error, ErrorKind};
use eigentrail::graph::{SymmetricCsr, matrix_market};
use eigentrail::report::grouped;
use eigentrail::runner::require_spectrum_memory;
use eigentrail::spectral::{
    self, Eigenpairs, LaplacianKind, Method, SpectralError, TrackParams, TrackStatistics,
    TrackUpdate, TrackedSpectrum,
};
use eigentrail::telemetry::Telemetry;
use serde::Serialize;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Arc, mpsc};
use tracing::{debug, warn};

/// As the main thread has it.
const STACK: usize = 8 << 20;

/// `track --json`
#[derive(Serialize)]
struct TrackLine<'a> {
    #[serde(flatten)]
    statistics: &'a TrackStatistics,
    laplacian: &'static str,
}

pub fn track(
    args: &cli::Track,
    threads: Option<usize>,
    telemetry: &Telemetry,
    bars: bool,
) -> Result<Ending> {
    require_writable(args.vectors.as_deref())?;
    let graph = matrix_market::load(&args.graph).map_err(Error::from)?;
    let adjacency = graph.to_csr();
    let k = num_pairs(args, adjacency.num_nodes())?;
    require_spectrum_memory(adjacency.num_nodes(), k, method(args.method)).map_err(Error::from)?;
    let params = TrackParams {
        k,
        growth: args.growth,
        start_nodes: args.from,
        tol: args.tol,
        method: method(args.method),
        laplacian: laplacian(args.laplacian),
        threads: threads.unwrap_or_else(rayon::current_num_threads),
        seed: args.seed,
        certify: args.certify,
    };
    let (statistics, eigenpairs) = follow(args, adjacency, params, telemetry, bars)?;
    if let (Some(path), Some(pairs)) = (&args.vectors, &eigenpairs) {
        write_matrix(path, pairs.vectors.as_ref()).map_err(Error::from)?;
    }
    if args.json {
        let laplacian = laplacian_name(args.laplacian);
        print_json(&TrackLine {
            statistics: &statistics,
            laplacian,
        });
    } else {
        print(&table(&statistics, args.laplacian));
    }
    warn_of_rounding(args.tol, &statistics.updates);
    Ok(ending(args, &statistics))
}

/// How many pairs a graph of `n` nodes is asked for.
fn num_pairs(args: &cli::Track, n: usize) -> Result<usize> {
    let path = args.graph.display();
    let usual = TrackParams::default().k;
    match args.k {
        Some(k) if k > n => Err(BadInput(format!(
            "{path}: --k {k}: the graph has {n} nodes, and so at most {n} eigenpairs; say --k {n} or less"
        ))
        .into()),
        Some(k) => Ok(k),
        None if n < usual => {
            warn!("{path}: the graph has {n} nodes, so all {n} eigenpairs are kept; larger graphs have {usual} without --k");
            Ok(n)
        }
        None => Ok(usual),
    }
}

/// Says where rounding stood in for the tolerance asked for.
fn warn_of_rounding(tol: f64, updates: &[TrackUpdate]) {
    let beyond: Vec<f64> = updates
        .iter()
        .filter(|u| u.max_relative_residual > tol)
        .filter_map(|u| u.tolerance_floor)
        .collect();
    if let Some(worst) = beyond.iter().copied().reduce(f64::max) {
        warn!(
            "--tol {tol:e} is out of reach at {} of {} updates: rounding allows residuals of {worst:.1e} · λ_k there, \
             and pairs that good counted as converged; choose a larger --tol",
            beyond.len(),
            updates.len(),
        );
    }
}

/// Under `--strict` every update must have come within the tolerance, and under `--certify` with a proof.
fn ending(args: &cli::Track, statistics: &TrackStatistics) -> Ending {
    let sound = |u: &TrackUpdate| {
        u.converged && u.max_relative_residual <= args.tol && (!args.certify || u.certified)
    };
    if statistics.interrupted {
        Ending::Interrupted
    } else if args.strict && !statistics.updates.iter().all(sound) {
        Ending::NotConverged
    } else {
        Ending::Done
    }
}

/// What the main thread waits for.
enum Message {
    Update(TrackUpdate),
    /// The end, or a panic.
    Done(std::thread::Result<Result<TrackedSpectrum, SpectralError>>),
    Stop,
}

/// Follows the graph on a thread of its own, if the system gives one: a signal need not wait for the update under way.
/// Without eigenpairs then.
fn follow(
    args: &cli::Track,
    adjacency: SymmetricCsr,
    params: TrackParams,
    telemetry: &Telemetry,
    bars: bool,
) -> Result<(TrackStatistics, Option<Eigenpairs>)> {
    let progress = Progress::new(telemetry, bars, "nodes", adjacency.num_nodes() as u64);
    let mut statistics = TrackStatistics {
        n: adjacency.num_nodes(),
        nnz: adjacency.nnz(),
        k: params.k,
        method: params.method,
        threads: params.threads,
        updates: Vec::new(),
        total_seconds: 0.0,
        eigenvalues: Vec::new(),
        interrupted: true,
    };
    let (send, receive) = mpsc::channel();
    let stop = send.clone();
    // Nobody receives any more once the end is there.
    signals::on_first(move || drop(stop.send(Message::Stop)));
    let work = Arc::new(move || {
        let tell = |update: &TrackUpdate| drop(send.send(Message::Update(update.clone())));
        let follow = AssertUnwindSafe(|| spectral::track(&adjacency, &params, tell));
        drop(send.send(Message::Done(catch_unwind(follow))));
    });
    let there = Arc::clone(&work);
    let thread = std::thread::Builder::new().stack_size(STACK);
    if thread.spawn(move || there()).is_err() {
        work();
    }
    loop {
        match receive.recv()? {
            Message::Update(update) => {
                let (nodes, route) = (update.nodes, update.route);
                let reason = route.reason();
                debug!(name: "spectrum_refresh", nodes, ?route, reason, elapsed_ms = update.seconds * 1e3, "spectrum_refresh");
                progress.reach(update.nodes as u64);
                statistics.total_seconds += update.seconds;
                statistics.updates.push(update);
            }
            Message::Done(Ok(Ok(tracked))) => {
                return Ok((tracked.statistics, Some(tracked.eigenpairs)));
            }
            Message::Done(Ok(Err(error))) => return Err(told(args, error)),
            Message::Done(Err(panic)) => resume_unwind(panic),
            Message::Stop => return Ok((statistics, None)),
        }
    }
}

/// With the file to blame, if it is to blame.
fn told(args: &cli::Track, error: SpectralError) -> anyhow::Error {
    match Error::from(error) {
        error if error.kind() == ErrorKind::BadInput => {
            BadInput(format!("{}: {error}", args.graph.display())).into()
        }
        error => error.into(),
    }
}

fn laplacian(choice: LaplacianChoice) -> LaplacianKind {
    match choice {
        LaplacianChoice::Sym => LaplacianKind::Normalized,
        LaplacianChoice::Unnormalised => LaplacianKind::Combinatorial,
    }
}

/// Its name on the command line.
fn laplacian_name(choice: LaplacianChoice) -> &'static str {
    match choice {
        LaplacianChoice::Sym => "sym",
        LaplacianChoice::Unnormalised => "unnormalised",
    }
}

fn method(choice: MethodChoice) -> Method {
    match choice {
        MethodChoice::Warm => Method::Warm,
        MethodChoice::Cold => Method::Cold,
        MethodChoice::Full => Method::Full,
    }
}

/// The updates as people read them: all if they are few, else the first and the last ones.
fn table(statistics: &TrackStatistics, laplacian: LaplacianChoice) -> String {
    const SHOWN: usize = 10;
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_header([
        "nodes",
        "edges",
        "ms",
        "products",
        "solves",
        "‖r‖ / λ_k",
        "λ_k",
        "converged",
    ]);
    let updates = &statistics.updates;
    for (i, update) in updates.iter().enumerate() {
        if i == SHOWN && updates.len() > 2 * SHOWN {
            table.add_row(["…"]);
        }
        if i < SHOWN || i + SHOWN >= updates.len() {
            table.add_row(row(update));
        }
    }
    let values: Vec<String> = statistics
        .eigenvalues
        .iter()
        .map(|v| format!("{v:.6e}"))
        .collect();
    let (table, count) = (table.trim_fmt(), updates.len());
    let (seconds, laplacian) = (statistics.total_seconds, laplacian_name(laplacian));
    if statistics.interrupted {
        let (reached, n) = (updates.last().map_or(0, |u| u.nodes), statistics.n);
        let (reached, n) = (grouped(reached as u64), grouped(n as u64));
        return format!(
            "{table}\n{count} updates in {seconds:.3} s, laplacian {laplacian}, interrupted at {reached} of {n} nodes"
        );
    }
    let values = values.join(" ");
    format!(
        "{table}\n{count} updates in {seconds:.3} s, laplacian {laplacian}\neigenvalues {values}"
    )
}

fn row(update: &TrackUpdate) -> [String; 8] {
    [
        grouped(update.nodes as u64),
        grouped(update.edges as u64),
        format!("{:.2}", update.seconds * 1e3),
        grouped(update.applications as u64),
        grouped(update.solves as u64),
        format!("{:.1e}", update.max_relative_residual),
        update
            .eigenvalues
            .last()
            .map_or_else(String::new, |v| format!("{v:.3e}")),
        if update.converged { "yes" } else { "no" }.to_owned(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::{Cli, Command};
    use clap::Parser;
    use eigentrail::spectral::Route;

    fn ending_of(flags: &str, converged: bool, certified: bool, residual: f64) -> Ending {
        let line = format!("eigentrail track g.mtx {flags}");
        let Command::Track(args) = Cli::parse_from(line.split_whitespace()).command else {
            panic!("{line}");
        };
        let update = TrackUpdate {
            nodes: 1,
            edges: 0,
            seconds: 0.0,
            applications: 0,
            solves: 0,
            max_relative_residual: residual,
            converged,
            cold_start: true,
            eigenvalues: vec![0.0],
            cluster_cut: false,
            route: Route::ShiftInvert,
            certified,
            tolerance_floor: None,
            repaired: 0,
        };
        let statistics = TrackStatistics {
            n: 1,
            nnz: 0,
            k: 1,
            method: Method::Warm,
            threads: 1,
            updates: vec![update],
            total_seconds: 0.0,
            eigenvalues: vec![0.0],
            interrupted: false,
        };
        ending(&args, &statistics)
    }

    #[test]
    fn only_strict_minds() {
        use Ending::{Done, NotConverged};
        assert_eq!(ending_of("", false, false, 0.0), Done);
        assert_eq!(ending_of("--tol 1e-13", true, false, 1e-12), Done);
        assert_eq!(ending_of("--strict", true, false, 0.0), Done);
        assert_eq!(ending_of("--strict", false, false, 0.0), NotConverged);
        let rounded = ending_of("--strict --tol 1e-13", true, false, 1e-12);
        assert_eq!(rounded, NotConverged, "rounding stood in for the tolerance");
        assert_eq!(ending_of("--strict --certify", true, true, 0.0), Done);
        assert_eq!(
            ending_of("--strict --certify", true, false, 0.0),
            NotConverged
        );
    }
}
