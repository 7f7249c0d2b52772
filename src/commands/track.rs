//! `eigentrail track`

use super::progress::Progress;
use super::{BadInput, Ending, print, print_json};
use crate::cli::{self, MethodChoice};
use anyhow::Result;
use comfy_table::{Table, presets};
use eigentrail::error::Error;
use eigentrail::graph::matrix_market;
use eigentrail::report::grouped;
use eigentrail::runner::{self, RunnerError, TrackReport, TrackUpdate, write_matrix};
use eigentrail::spectral::{Method, SpectralParams};
use eigentrail::telemetry::Telemetry;
use serde::Serialize;

/// `track --json`
#[derive(Serialize)]
struct TrackLine<'a> {
    n: usize,
    nnz: usize,
    k: usize,
    method: &'static str,
    threads: usize,
    updates: &'a [TrackUpdate],
    total_seconds: f64,
    eigenvalues: &'a [f64],
}

pub fn track(
    args: &cli::Track,
    threads: Option<usize>,
    telemetry: &Telemetry,
    bars: bool,
) -> Result<Ending> {
    let graph = matrix_market::load(&args.graph).map_err(Error::from)?;
    let adjacency = graph.to_csr();
    let (method, method_name) = method(args.method);
    let threads = threads.unwrap_or_else(rayon::current_num_threads);
    let params = SpectralParams {
        num_eigenpairs: args.k,
        tol: args.tol,
        method,
        threads,
        ..SpectralParams::default()
    };
    params.validate().map_err(Error::from)?;
    let sizes = runner::track_sizes(adjacency.rows(), args.growth).len() as u64;
    let mut progress = Progress::new(telemetry, bars, "updates", sizes);
    let report = runner::track(&adjacency, &params, args.growth, args.seed, |update| {
        progress.step(|| format!("{} nodes", update.nodes));
    });
    drop(progress);
    let report = report.map_err(|error| match Error::from(error) {
        error if error.kind() == eigentrail::error::ErrorKind::BadInput => {
            BadInput(format!("{}: {error}", args.graph.display())).into()
        }
        error => anyhow::Error::from(error),
    })?;
    if let (Some(path), Some(pairs)) = (&args.vectors, &report.eigenpairs) {
        write_matrix(path, pairs.vectors.as_ref())
            .map_err(|error: RunnerError| BadInput(error.to_string()))?;
    }
    if args.json {
        let eigenvalues = report.updates.last().map_or(&[][..], |u| &u.eigenvalues);
        print_json(&TrackLine {
            n: adjacency.rows(),
            nnz: adjacency.nnz(),
            k: args.k,
            method: method_name,
            threads,
            updates: &report.updates,
            total_seconds: report.total_seconds,
            eigenvalues,
        })?;
    } else {
        print(&table(&report))?;
    }
    let converged = report.updates.iter().all(|update| update.converged);
    Ok(if converged || !args.strict {
        Ending::Done
    } else {
        Ending::NotConverged
    })
}

fn method(choice: MethodChoice) -> (Method, &'static str) {
    match choice {
        MethodChoice::Warm => (Method::Warm, "warm"),
        MethodChoice::Cold => (Method::Cold, "cold"),
        MethodChoice::Full => (Method::Full, "full"),
    }
}

/// The updates as people read them: all if they are few, else the first and the last ones.
fn table(report: &TrackReport) -> String {
    const SHOWN: usize = 10;
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_header([
        "nodes",
        "edges",
        "ms",
        "products",
        "solves",
        "residual / λ_k",
        "λ_k",
        "converged",
    ]);
    let updates = &report.updates;
    for (i, update) in updates.iter().enumerate() {
        if i == SHOWN && updates.len() > 2 * SHOWN {
            table.add_row(["…"]);
        }
        if i < SHOWN || i + SHOWN >= updates.len() {
            table.add_row(row(update));
        }
    }
    let values = updates
        .last()
        .map(|u| u.eigenvalues.as_slice())
        .unwrap_or_default();
    let values: Vec<String> = values.iter().map(|v| format!("{v:.6e}")).collect();
    format!(
        "{}\n{} updates in {:.3} s\neigenvalues {}",
        table.trim_fmt(),
        updates.len(),
        report.total_seconds,
        values.join(" ")
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
