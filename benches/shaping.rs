//! The soft Bellman equation, its gradient and whole potentials on open grids and on a maze with paths of thousands of steps.
//!
//! `cargo bench --bench shaping`, or `-- bellman/grid` for a part. Sizes above 10⁴ nodes take the fewest samples.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use eigentrail::gcn::GcnParams;
use eigentrail::graph::{StateId, SymmetricCsr};
use eigentrail::seeds::{Stream, stream};
use eigentrail::shaping::{
    LearntModel, PotentialKind, ShapingParams, SoftBellman, potential_on_graph,
};
use faer::Mat;
use rand::RngExt;
use std::hint::black_box;

const TOL: f64 = 1e-8;

/// Of a solve, in typical steps: that at which `gcn` begins, and about that of `heat`.
const TEMPERATURES: [f64; 2] = [0.5, 10.0];

fn from_edges(n: usize, edges: &[(usize, usize)]) -> SymmetricCsr {
    let mut triplets = sprs::TriMatI::<f64, u32>::new((n, n));
    for &(i, j) in edges {
        triplets.add_triplet(i, j, 1.0);
        triplets.add_triplet(j, i, 1.0);
    }
    SymmetricCsr::new(triplets.to_csr()).expect("an undirected graph")
}

fn grid(side: usize) -> SymmetricCsr {
    let right = (0..side * side)
        .filter(|i| i % side + 1 < side)
        .map(|i| (i, i + 1));
    let down = (0..side * (side - 1)).map(|i| (i, i + side));
    from_edges(side * side, &right.chain(down).collect::<Vec<_>>())
}

/// A perfect maze of `side` × `side` cells with the passages between them as nodes of their own, as on a map of
/// 2·side + 1 characters: depth-first, so that its ways are long.
fn maze(side: usize) -> SymmetricCsr {
    let mut rng = stream(7, Stream::Layout);
    let (mut visited, mut trail) = (vec![false; side * side], vec![0_usize]);
    visited[0] = true;
    let mut edges = Vec::new();
    let mut nodes = side * side;
    while let Some(&cell) = trail.last() {
        let (r, c) = (cell / side, cell % side);
        let around = [
            (r > 0).then(|| cell - side),
            (r + 1 < side).then(|| cell + side),
            (c > 0).then(|| cell - 1),
            (c + 1 < side).then(|| cell + 1),
        ];
        let fresh: Vec<usize> = around
            .into_iter()
            .flatten()
            .filter(|&n| !visited[n])
            .collect();
        if fresh.is_empty() {
            trail.pop();
            continue;
        }
        let next = fresh[rng.random_range(0..fresh.len())];
        edges.extend([(cell, nodes), (nodes, next)]);
        nodes += 1;
        visited[next] = true;
        trail.push(next);
    }
    from_edges(nodes, &edges)
}

fn model(adjacency: &SymmetricCsr) -> LearntModel {
    LearntModel::uniform(adjacency, &[StateId(0)])
}

fn worlds() -> Vec<(&'static str, SymmetricCsr)> {
    vec![
        ("grid", grid(32)),
        ("grid", grid(100)),
        ("grid", grid(316)),
        ("grid", grid(1000)),
        ("maze", maze(100)),
    ]
}

fn bellman(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("bellman");
    group.sample_size(10);
    for (name, adjacency) in worlds() {
        let model = model(&adjacency);
        let n = model.process.len();
        group.throughput(Throughput::Elements(n as u64));
        let id = |what: &str| BenchmarkId::new(format!("{name}/{what}"), n);
        group.bench_function(id("model"), |b| {
            b.iter(|| self::model(black_box(&adjacency)))
        });
        for temperature in TEMPERATURES {
            let tau = model.temperatures(temperature);
            let mut solver = SoftBellman::new(&model.process);
            group.bench_function(id(&format!("solve at {temperature}")), |b| {
                b.iter(|| solver.solve_cold(&tau, TOL));
            });
            let (_, statistics) = solver.solve_cold(&tau, TOL);
            eprintln!("{name} {n} at {temperature}: {statistics:?}");
            let gradient = vec![1.0; n];
            group.bench_function(id(&format!("gradient at {temperature}")), |b| {
                b.iter(|| {
                    let mut mu = vec![0.0; n];
                    solver.solve_transposed(&gradient, &mut mu, TOL, 1000)
                });
            });
        }
    }
    group.finish();
}

fn potentials(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("potential");
    group.sample_size(10);
    let (shaping, gcn) = (ShapingParams::default(), GcnParams::default());
    for (name, adjacency) in [("grid", grid(32)), ("grid", grid(100)), ("maze", maze(100))] {
        let n = adjacency.num_nodes();
        let features = Mat::from_fn(n, 16, |i, c| ((i * (c + 1)) as f64 * 0.01).cos());
        for kind in [
            PotentialKind::Gcn,
            PotentialKind::Report,
            PotentialKind::Heat,
            PotentialKind::Hops,
        ] {
            group.bench_function(BenchmarkId::new(format!("{name}/{kind}"), n), |b| {
                b.iter(|| {
                    let goals = [StateId(0)];
                    potential_on_graph(
                        &adjacency,
                        &goals,
                        kind,
                        features.as_ref(),
                        &shaping,
                        &gcn,
                        1,
                    )
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, bellman, potentials);
criterion_main!(benches);
