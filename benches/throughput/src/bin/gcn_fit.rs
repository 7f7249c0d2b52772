//! Seconds of a fit of the classifier on one thread, for `gcn_fit.py`: SIDE EPOCHS as arguments, a line of JSON as output.

use eigentrail::gcn::{Adam, Gcn, GcnParams, Propagation, fit_classifier};
use eigentrail::graph::SymmetricCsr;
use eigentrail::seeds::{Stream, stream};
use faer::Mat;
use std::time::Instant;

const FEATURES: usize = 16;

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

/// Products of cosines: low eigenvectors of the grid's D − A, with entries of order 1.
fn cosines(side: usize) -> Mat<f64> {
    let wave = |at: usize, order: usize| {
        (std::f64::consts::PI * order as f64 * (at as f64 + 0.5) / side as f64).cos()
    };
    Mat::from_fn(side * side, FEATURES, |i, j| {
        2.0 * wave(i / side, j / 4) * wave(i % side, j % 4)
    })
}

fn main() {
    let numbers: Vec<usize> = std::env::args()
        .skip(1)
        .map(|number| number.parse().expect("SIDE EPOCHS"))
        .collect();
    let [side, epochs] = numbers[..] else {
        panic!("SIDE EPOCHS");
    };
    let params = GcnParams {
        epochs,
        ..Default::default()
    };
    let (adjacency, features) = (grid(side), cosines(side));
    let labels = [(0, 0), ((side * side - 1) as u32, 1)];
    let mut gcn = Gcn::new(FEATURES, 16, 2, true, &mut stream(0, Stream::Gcn));
    let mut adam = Adam::new(&gcn, params.learning_rate);
    let start = serde_json::to_value(gcn.parameters()).expect("numbers");
    let propagation = Propagation::new(&adjacency);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let (seconds, loss) = one.expect("a thread").install(|| {
        let begun = Instant::now();
        let (_, statistics) = fit_classifier(
            &mut gcn,
            &mut adam,
            &propagation,
            &adjacency,
            features.as_ref(),
            &labels,
            &params,
        )
        .expect("the fit does not diverge");
        (begun.elapsed().as_secs_f64(), statistics.loss)
    });
    let line = serde_json::json!({
        "seconds": seconds, "loss": loss, "start": start,
        "learning_rate": params.learning_rate, "smoothness": params.smoothness,
    });
    println!("{line}");
}
