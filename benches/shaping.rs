//! Diffusion, its gradient and whole potentials on open grids and on a maze with paths of thousands of steps.
//!
//! `cargo bench --bench shaping`, or `-- diffusion/grid` for a part. Sizes above 10⁴ nodes take the fewest samples.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use eigentrail::gcn::GcnParams;
use eigentrail::graph::{StateId, SymmetricCsr};
use eigentrail::seeds::{Stream, stream};
use eigentrail::shaping::{
    LinearlySolvableMdp, PotentialKind, ShapingParams, ShortestPathProblem, TransitionMatrix,
    potential_on_graph,
};
use faer::Mat;
use rand::RngExt;
use std::hint::black_box;

const TOL: f64 = 1e-8;

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

fn problem(adjacency: &SymmetricCsr) -> ShortestPathProblem {
    ShortestPathProblem::uniform(&TransitionMatrix::undirected(adjacency), &[StateId(0)])
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

fn diffusion(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("diffusion");
    group.sample_size(10);
    for (name, adjacency) in worlds() {
        let problem = problem(&adjacency);
        let chain = &problem.chain;
        let q = vec![0.7; chain.len()];
        group.throughput(Throughput::Elements(chain.len() as u64));
        let id = |what: &str| BenchmarkId::new(format!("{name}/{what}"), chain.len());
        group.bench_function(id("problem"), |b| {
            b.iter(|| self::problem(black_box(&adjacency)))
        });
        group.bench_function(id("solve"), |b| {
            b.iter(|| LinearlySolvableMdp::new(chain).solve_cold(&q, &mut vec![0.0], TOL));
        });
        let mut mdp = LinearlySolvableMdp::new(chain);
        let statistics = mdp.solve_cold(&q, &mut vec![0.0], TOL);
        eprintln!(
            "{name} {}: {statistics:?}, E = {}",
            chain.len(),
            problem.eccentricity()
        );
        let gradient = vec![1.0; chain.len()];
        group.bench_function(id("gradient"), |b| {
            b.iter(|| {
                let mut lambda = vec![0.0; chain.len()];
                mdp.walk_mut()
                    .solve_transposed(&gradient, &mut lambda, TOL, 1000)
            });
        });
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

criterion_group!(benches, diffusion, potentials);
criterion_main!(benches);
