//! One update of the spectrum after 5 % growth: warm, cold and full side by side, k = 16.
//!
//! `cargo bench --bench spectral`. Beside the times: columns multiplied by L and columns solved with
//! its factor, which do not depend on the machine.

#[path = "../tests/common/graphs.rs"]
mod graphs;

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use eigentrail::spectral::{LowSpectrum, Method, SpectralParams, TrackParams, track};
use graphs::Csr;
use std::hint::black_box;
use std::time::Duration;

/// Sides of the square worlds; a full decomposition is only taken up to [`FULL_LIMIT`] nodes.
const SIDES: [usize; 4] = [15, 32, 50, 100];
const FULL_LIMIT: usize = 2500;

fn worlds(side: usize) -> [(&'static str, Csr); 3] {
    let pitch = side.div_ceil(10).max(2);
    [
        ("grid", graphs::grid(side, side)),
        ("rooms", graphs::rooms(pitch, pitch, side / pitch - 1)),
        ("maze", graphs::maze(side, side, 0.05, 1)),
    ]
    .map(|(name, graph)| (name, graphs::discovered(&graph, 1)))
}

fn spectrum(method: Method, tol: f64) -> LowSpectrum {
    let params = SpectralParams {
        method,
        tol,
        ..Default::default()
    };
    LowSpectrum::new(params, 0)
}

/// One refresh from 95 % of the nodes to all of them.
fn update(c: &mut Criterion) {
    for side in SIDES {
        for (name, graph) in worlds(side) {
            let n = graph.rows();
            let before = graphs::prefix(&graph, n - n / 20);
            let mut group = c.benchmark_group(format!("update/{name}"));
            group
                .sample_size(10)
                .measurement_time(Duration::from_secs(2));
            for method in [Method::Warm, Method::Cold, Method::Full] {
                if method == Method::Full && n > FULL_LIMIT {
                    continue;
                }
                let mut known = spectrum(method, 1e-3);
                if method == Method::Warm {
                    known.refresh(&before).expect("valid graph");
                }
                let facts = known
                    .clone()
                    .refresh(&graph)
                    .expect("valid graph")
                    .convergence;
                eprintln!(
                    "{name} {n} {method:?}: {} columns multiplied, {} solved, {} converged",
                    facts.applications, facts.solves, facts.converged
                );
                let id = BenchmarkId::new(format!("{method:?}").to_lowercase(), n);
                group.bench_function(id, |b| {
                    b.iter_batched_ref(
                        || known.clone(),
                        |spectrum| spectrum.refresh(black_box(&graph)),
                        BatchSize::PerIteration,
                    );
                });
            }
            group.finish();
        }
    }
}

/// Whole sequences from 64 nodes by 5 %.
fn sequence(c: &mut Criterion) {
    for (name, graph) in worlds(100) {
        let mut group = c.benchmark_group(format!("sequence/{name}"));
        group
            .sample_size(10)
            .measurement_time(Duration::from_secs(8));
        for method in [Method::Warm, Method::Cold] {
            let params = TrackParams {
                method,
                ..Default::default()
            };
            let report = track(&graph, &params, |_| ()).expect("valid graph").report;
            let total = |f: fn(&eigentrail::spectral::TrackUpdate) -> usize| {
                report.updates.iter().map(f).sum::<usize>()
            };
            eprintln!(
                "{name} 64 → {}, {method:?}: {} columns multiplied, {} solved",
                report.n,
                total(|u| u.applications),
                total(|u| u.solves)
            );
            let id = BenchmarkId::new(format!("{method:?}").to_lowercase(), report.n);
            group.bench_function(id, |b| b.iter(|| track(black_box(&graph), &params, |_| ())));
        }
        group.finish();
    }
}

criterion_group!(benches, update, sequence);
criterion_main!(benches);
