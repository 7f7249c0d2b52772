//! T̂ X, one epoch's passes and a whole fit of the classifier, on square grids with their closed-form
//! proto-value functions: k = 16, 16 hidden units, 40 epochs, on one thread and on all.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use eigentrail::gcn::{Adam, Gcn, GcnParams, GcnWorkspace, Propagation, fit_classifier};
use eigentrail::graph::SymmetricCsr;
use eigentrail::seeds::{Stream, stream};
use faer::Mat;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::hint::black_box;

const FEATURES: usize = 16;
const SIDES: [usize; 3] = [32, 100, 316];

/// side × side grid graph, rows in reading order.
fn grid(side: usize) -> SymmetricCsr {
    let n = side * side;
    let mut edges = sprs::TriMatI::<f64, u32>::new((n, n));
    for node in 0..n {
        let right = (node % side + 1 < side).then_some(node + 1);
        let below = (node + side < n).then_some(node + side);
        for other in right.into_iter().chain(below) {
            edges.add_triplet(node, other, 1.0);
            edges.add_triplet(other, node, 1.0);
        }
    }
    SymmetricCsr::new(edges.to_csr()).expect("an undirected grid")
}

/// Products of cosines: the low eigenvectors of the grid's D − A, with entries of order 1.
fn cosines(side: usize) -> Mat<f64> {
    let wave = |at: usize, order: usize| {
        (std::f64::consts::PI * order as f64 * (at as f64 + 0.5) / side as f64).cos()
    };
    Mat::from_fn(side * side, FEATURES, |i, j| {
        2.0 * wave(i / side, j / 4) * wave(i % side, j % 4)
    })
}

fn pools() -> [(&'static str, ThreadPool); 2] {
    let pool = |threads| ThreadPoolBuilder::new().num_threads(threads).build();
    [
        ("one_thread", pool(1).expect("a thread")),
        ("all_threads", pool(0).expect("threads")),
    ]
}

fn propagate(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("gcn_propagate");
    for side in SIDES {
        let (propagation, x) = (Propagation::new(&grid(side)), cosines(side));
        group.throughput(Throughput::Elements((side * side) as u64));
        for (name, pool) in pools() {
            group.bench_function(BenchmarkId::new(name, side * side), |bencher| {
                pool.install(|| bencher.iter(|| black_box(propagation.apply(x.as_ref()))));
            });
        }
    }
    group.finish();
}

fn passes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("gcn_forward_backward");
    for side in SIDES {
        let propagation = Propagation::new(&grid(side));
        let tx = propagation.apply(cosines(side).as_ref());
        let gcn = Gcn::new(FEATURES, 16, 2, true, &mut stream(0, Stream::Gcn));
        let slope = Mat::from_fn(side * side, 2, |i, j| (i % 3) as f64 - j as f64);
        for (name, pool) in pools() {
            let mut workspace = GcnWorkspace::default();
            group.bench_function(BenchmarkId::new(name, side * side), |bencher| {
                pool.install(|| {
                    bencher.iter(|| {
                        gcn.forward(&propagation, tx.as_ref(), &mut workspace);
                        gcn.backward(&propagation, tx.as_ref(), &mut workspace, slope.as_ref())
                    });
                });
            });
        }
    }
    group.finish();
}

fn fit(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("gcn_fit");
    group.sample_size(10);
    let params = GcnParams::default();
    for side in SIDES {
        let (adjacency, x) = (grid(side), cosines(side));
        let propagation = Propagation::new(&adjacency);
        let labels = [(0, 0), ((side * side - 1) as u32, 1)];
        let start = Gcn::new(FEATURES, 16, 2, true, &mut stream(0, Stream::Gcn));
        for (name, pool) in pools() {
            group.bench_function(BenchmarkId::new(name, side * side), |bencher| {
                pool.install(|| {
                    bencher.iter(|| {
                        let mut gcn = start.clone();
                        let mut adam = Adam::new(&gcn, params.learning_rate);
                        fit_classifier(
                            &mut gcn,
                            &mut adam,
                            &propagation,
                            &adjacency,
                            x.as_ref(),
                            &labels,
                            &params,
                        )
                    });
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, propagate, passes, fit);
criterion_main!(benches);
