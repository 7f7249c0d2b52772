//! The growing graph: `cargo bench --bench graph`.
//!
//! - `grow`: a square grid, cell by cell, in place: time per edge must not depend on n.
//! - `rebuild_5_percent`: the same grid by the peer's way, sprs triplets to CSR again at each 5 % more nodes (from 64);
//!   `compact_5_percent`: the same moments, the growing adjacency handed out as a compact CSR.
//! - `rebuild_each_node`: triplets to CSR at each new node; only for small n, since it is quadratic.
//! - `hub`: neighbours of one node, arriving in order and (worst case) in reverse order.
//! - `record`: steps that are known, walking about a graph of 1e6 states, in a deterministic and in a slippery world.
//! - `matrix_market`: reading and writing.

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use eigentrail::env::Action;
use eigentrail::graph::{Adjacency, StateId, SymmetricCsr, TransitionGraph, matrix_market};
use std::hint::black_box;

/// For each node of a `side` × `side` grid, row by row, its neighbours that come before it.
fn grid(side: u32) -> Vec<Vec<u32>> {
    let before = |node: u32| {
        let left = (!node.is_multiple_of(side)).then(|| node - 1);
        [node.checked_sub(side), left]
            .into_iter()
            .flatten()
            .collect()
    };
    (0..side * side).map(before).collect()
}

fn num_edges(nodes: &[Vec<u32>]) -> u64 {
    nodes.iter().map(|earlier| earlier.len() as u64).sum()
}

fn extend(graph: &mut Adjacency, nodes: &[Vec<u32>]) {
    for earlier in &nodes[graph.num_nodes()..] {
        let node = graph.add_node();
        earlier.iter().for_each(|&other| {
            graph.add_edge(node, other, 1.0);
        });
    }
}

/// Prefix lengths 64, then 5 % more each time, up to n.
fn growth_steps(n: usize) -> Vec<usize> {
    let mut steps = vec![64.min(n)];
    while let Some(&last) = steps.last().filter(|&&last| last < n) {
        steps.push((last + last.div_ceil(20)).min(n));
    }
    steps
}

fn rebuild(nodes: &[Vec<u32>]) -> sprs::CsMatI<f64, u32> {
    let mut triplets =
        sprs::TriMatI::<f64, u32>::with_capacity((nodes.len(), nodes.len()), 4 * nodes.len());
    for (node, earlier) in nodes.iter().enumerate() {
        for &other in earlier {
            triplets.add_triplet(node, other as usize, 1.0);
            triplets.add_triplet(other as usize, node, 1.0);
        }
    }
    triplets.to_csr()
}

fn growth(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("growth");
    group.sample_size(10);
    for side in [32_u32, 100, 316, 1000] {
        let nodes = grid(side);
        let steps = growth_steps(nodes.len());
        group.throughput(Throughput::Elements(num_edges(&nodes)));
        group.bench_function(format!("grow/{}", nodes.len()), |bencher| {
            bencher.iter(|| extend(black_box(&mut Adjacency::new()), &nodes));
        });
        group.bench_function(format!("compact_5_percent/{}", nodes.len()), |bencher| {
            bencher.iter(|| {
                let (mut graph, mut csr) = (Adjacency::new(), SymmetricCsr::empty());
                for &m in &steps {
                    extend(&mut graph, &nodes[..m]);
                    graph.write_csr(black_box(&mut csr));
                }
            });
        });
        group.bench_function(format!("rebuild_5_percent/{}", nodes.len()), |bencher| {
            bencher.iter(|| {
                steps
                    .iter()
                    .for_each(|&m| drop(black_box(rebuild(&nodes[..m]))))
            });
        });
        if nodes.len() <= 1024 {
            group.bench_function(format!("rebuild_each_node/{}", nodes.len()), |bencher| {
                bencher
                    .iter(|| (1..=nodes.len()).for_each(|m| drop(black_box(rebuild(&nodes[..m])))));
            });
        }
    }
    group.finish();
}

fn hub(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("hub");
    group
        .sample_size(10)
        .throughput(Throughput::Elements(100_000));
    let grow = |leaves: &mut dyn Iterator<Item = u32>| {
        let mut graph = Adjacency::with_nodes(100_001);
        leaves.for_each(|leaf| {
            graph.add_edge(0, leaf, 1.0);
        });
        graph
    };
    group.bench_function("ascending", |bencher| {
        bencher.iter(|| grow(&mut (1..100_001)))
    });
    group.bench_function("descending", |bencher| {
        bencher.iter(|| grow(&mut (1..100_001).rev()))
    });
    group.finish();
}

/// A ring of `n` states with actions −1 and +1; in a slippery one each can go either way.
fn ring(n: u32, is_slippery: bool) -> TransitionGraph {
    let mut graph = TransitionGraph::new(2);
    (0..n).for_each(|_| {
        graph.add_state();
    });
    for state in 0..n {
        let ends = [(state + n - 1) % n, (state + 1) % n];
        for (action, to) in (0..2).flat_map(|action| ends.map(|to| (action, to))) {
            if is_slippery || ends[usize::from(action)] == to {
                graph.record(StateId(state), Action(action), -1.0, StateId(to), false);
            }
        }
    }
    graph
}

fn record(criterion: &mut Criterion) {
    const STATES: u32 = 1_000_000;
    const STEPS: u32 = 1_000_000;
    let mut group = criterion.benchmark_group("record");
    group
        .sample_size(10)
        .throughput(Throughput::Elements(u64::from(STEPS)));
    for (name, is_slippery) in [("deterministic", false), ("slippery", true)] {
        let mut graph = ring(STATES, is_slippery);
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let (mut state, mut noise) = (0, 1_u32);
                for _ in 0..STEPS {
                    noise ^= noise << 13;
                    noise ^= noise >> 17;
                    noise ^= noise << 5;
                    let action = u16::from(noise & 3 == 0);
                    let goes_up = if is_slippery {
                        noise & 16 == 0
                    } else {
                        action == 1
                    };
                    let to = if goes_up {
                        (state + 1) % STATES
                    } else {
                        (state + STATES - 1) % STATES
                    };
                    graph.record(StateId(state), Action(action), -1.0, StateId(to), false);
                    state = to;
                }
            });
        });
    }
    group.finish();
}

fn matrix_market_files(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("matrix_market");
    group.sample_size(10);
    for side in [100, 1000] {
        let mut graph = Adjacency::new();
        extend(&mut graph, &grid(side));
        let mut bytes = Vec::new();
        matrix_market::write(&mut bytes, &graph).expect("a Vec takes all that is written");
        let text = String::from_utf8(bytes).expect("ASCII");
        group.throughput(Throughput::Bytes(text.len() as u64));
        group.bench_function(format!("read/{}", graph.num_nodes()), |bencher| {
            bencher.iter(|| matrix_market::parse(black_box(&text)));
        });
        group.bench_function(format!("write/{}", graph.num_nodes()), |bencher| {
            let buffer = || Vec::with_capacity(text.len());
            bencher.iter_batched(
                buffer,
                |mut out| matrix_market::write(&mut out, &graph),
                BatchSize::PerIteration,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, growth, hub, record, matrix_market_files);
criterion_main!(benches);
