//! What one update of the spectrum costs, k = 16: about ten minutes on a quiet machine.
//!
//! - `full`: after 5 % growth the incremental update against decomposing the whole matrix, by nalgebra and by faer;
//!   the slowest of those are timed once, and those over a minute only with `SPECTRAL_BENCH_LONG=1` (half an hour);
//! - `growth`: warm against cold after 1, 5 and 20 % growth at 10⁴ and 10⁵ nodes;
//! - `sequence`: whole sequences from 64 nodes to 10⁴ by 5 %.
//!
//! `cargo bench --bench spectral`, or parts: `cargo bench --bench spectral -- growth/maze`. Beside the times:
//! columns multiplied by L and columns solved with its factor, which do not depend on the machine.

#[path = "../tests/common/graphs.rs"]
mod graphs;

use criterion::measurement::WallTime;
use criterion::{
    BatchSize, BenchmarkGroup, BenchmarkId, Criterion, SamplingMode, criterion_group,
    criterion_main,
};
use eigentrail::spectral::{
    Convergence, GrowingEigensolver, Laplacian, LaplacianKind, Method, SpectralParams, TrackParams,
    TrackUpdate, symmetric_eigen, track,
};
use graphs::SymmetricCsr;
use std::cell::OnceCell;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Sides of the grids that are also decomposed whole: 225 to about 5 000 nodes.
const FULL_SIDES: [usize; 5] = [15, 18, 32, 50, 71];

/// Nodes above which a decomposition is timed once, and above which nalgebra's takes minutes.
const REPEATED: usize = 1100;
const LONG: usize = 2600;

/// Sides of worlds of 10⁴ and 10⁵ nodes.
const GROWN_SIDES: [usize; 2] = [100, 316];

fn worlds(side: usize) -> [(&'static str, SymmetricCsr); 3] {
    let pitch = side.div_ceil(10).max(2);
    [
        ("grid", graphs::grid(side, side)),
        ("rooms", graphs::rooms(pitch, pitch, side / pitch - 1)),
        ("maze", graphs::maze(side, side, 0.05, 1)),
    ]
    .map(|(name, graph)| (name, graphs::discovered(&graph, 1)))
}

fn spectrum(method: Method, tol: f64) -> GrowingEigensolver {
    let params = SpectralParams {
        method,
        tol,
        ..Default::default()
    };
    GrowingEigensolver::new(params, 0)
}

fn group<'a>(c: &'a mut Criterion, name: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = c.benchmark_group(name);
    group
        .sample_size(10)
        .sampling_mode(SamplingMode::Flat)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2));
    group
}

/// One refresh from `before` to `graph`, the earlier one outside the time: it leaves its buffers, as in a sequence.
fn refresh(
    group: &mut BenchmarkGroup<'_, WallTime>,
    id: BenchmarkId,
    (method, tol): (Method, f64),
    (before, graph): (&SymmetricCsr, &SymmetricCsr),
) {
    let prepared = || {
        let mut known = spectrum(method, tol);
        known.refresh(before).expect("valid graph");
        known
    };
    let told = OnceCell::new();
    // Inside, so that a filtered run does no work for what it leaves out.
    group.bench_function(id, |b| {
        told.get_or_init(|| tell(&prepared().refresh(graph).expect("valid graph").convergence));
        b.iter_batched_ref(
            prepared,
            |spectrum| spectrum.refresh(black_box(graph)),
            BatchSize::PerIteration,
        );
    });
}

fn tell(facts: &Convergence) {
    eprintln!(
        "  {} columns multiplied, {} solved, {} converged",
        facts.applications, facts.solves, facts.converged
    );
}

fn decompose_by_nalgebra(graph: &SymmetricCsr) -> f64 {
    let dense = dense(graph);
    let matrix =
        nalgebra::DMatrix::from_fn(graph.num_nodes(), graph.num_nodes(), |i, j| dense[(i, j)]);
    matrix.symmetric_eigen().eigenvalues[0]
}

fn decompose_by_faer(graph: &SymmetricCsr) -> f64 {
    let (values, _) = symmetric_eigen(dense(graph).as_ref()).expect("finite matrix");
    values[0]
}

fn dense(graph: &SymmetricCsr) -> faer::Mat<f64> {
    Laplacian::new(graph, LaplacianKind::Normalized).to_dense()
}

/// Incremental against full.
fn full(c: &mut Criterion) {
    for side in FULL_SIDES {
        let graph = graphs::discovered(&graphs::grid(side, side), 1);
        let n = graph.num_nodes();
        let before = graphs::prefix(&graph, n - n / 20);
        let mut group = group(c, "full");
        for tol in [1e-2, 1e-6] {
            let id = BenchmarkId::new(format!("incremental, tol {tol:e}"), n);
            refresh(&mut group, id, (Method::Warm, tol), (&before, &graph));
        }
        type Decompose = fn(&SymmetricCsr) -> f64;
        let peers: [(&str, Decompose); 2] = [
            ("faer", decompose_by_faer),
            ("nalgebra", decompose_by_nalgebra),
        ];
        for (name, decompose) in peers {
            if name == "nalgebra" && n > LONG && !long_wished() {
                eprintln!("full/nalgebra/{n} is left out: SPECTRAL_BENCH_LONG=1 for it");
                continue;
            }
            let once = OnceCell::new();
            group.bench_function(BenchmarkId::new(name, n), |b| {
                if n <= REPEATED {
                    b.iter(|| decompose(black_box(&graph)));
                } else {
                    let once = once.get_or_init(|| timed(|| decompose(&graph)));
                    b.iter_custom(|iterations| *once * iterations as u32);
                }
            });
        }
        group.finish();
    }
}

fn long_wished() -> bool {
    std::env::var_os("SPECTRAL_BENCH_LONG").is_some()
}

fn timed(run: impl FnOnce() -> f64) -> Duration {
    let start = Instant::now();
    black_box(run());
    start.elapsed()
}

/// Warm against cold.
fn growth(c: &mut Criterion) {
    for side in GROWN_SIDES {
        for (name, graph) in worlds(side) {
            let n = graph.num_nodes();
            let mut group = group(c, &format!("growth/{name}"));
            for percent in [1, 5, 20] {
                let before = graphs::prefix(&graph, n * 100 / (100 + percent));
                for method in [Method::Warm, Method::Cold] {
                    let label = format!("{method:?} after {percent} %").to_lowercase();
                    let id = BenchmarkId::new(label, n);
                    refresh(&mut group, id, (method, 1e-2), (&before, &graph));
                }
            }
            group.finish();
        }
    }
}

/// Whole sequences from 64 nodes by 5 %.
fn sequence(c: &mut Criterion) {
    for (name, graph) in worlds(100) {
        let mut group = group(c, &format!("sequence/{name}"));
        for method in [Method::Warm, Method::Cold] {
            let params = TrackParams {
                method,
                ..Default::default()
            };
            let run = || {
                track(&graph, &params, |_| ())
                    .expect("valid graph")
                    .statistics
            };
            let told = OnceCell::new();
            let id = BenchmarkId::new(format!("{method:?}").to_lowercase(), graph.num_nodes());
            group.bench_function(id, |b| {
                told.get_or_init(|| tell_all(&run().updates));
                b.iter(run);
            });
        }
        group.finish();
    }
}

fn tell_all(updates: &[TrackUpdate]) {
    let total = |count: fn(&TrackUpdate) -> usize| updates.iter().map(count).sum::<usize>();
    eprintln!(
        "  {} updates: {} columns multiplied, {} solved",
        updates.len(),
        total(|u| u.applications),
        total(|u| u.solves)
    );
}

criterion_group!(benches, full, growth, sequence);
criterion_main!(benches);
