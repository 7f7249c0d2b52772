//! The network's hand-written gradients against central differences, its fit against a recorded PyTorch run,
//! and what a fitted potential and a growing network must satisfy.

use eigentrail::gcn::{
    Adam, ClassifierLoss, Gcn, GcnError, GcnParameters, GcnParams, GcnWorkspace, GraphConv,
    LossWorkspace, Propagation, fit_classifier,
};
use eigentrail::graph::SymmetricCsr;
use eigentrail::seeds::{Stream, stream};
use faer::{Mat, MatRef};
use proptest::prelude::*;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Step of the central differences; with losses of order 1 truncation (h²) and rounding (1e-16 / h) are both near 1e-10.
const STEP: f64 = 1e-5;
/// What the gradients are promised to reach.
const RELATIVE_TOLERANCE: f64 = 1e-6;
/// Pre-activations nearer to 0 than this might cross the ReLU's kink within a step.
const KINK: f64 = 1e-3;

fn graph(n: usize, edges: &[(usize, usize)]) -> SymmetricCsr {
    let mut triplets = sprs::TriMatI::<f64, u32>::new((n, n));
    for &(i, j) in edges {
        triplets.add_triplet(i, j, 1.0);
        if i != j {
            triplets.add_triplet(j, i, 1.0);
        }
    }
    SymmetricCsr::new(triplets.to_csr()).unwrap()
}

fn grid_edges(rows: usize, columns: usize) -> Vec<(usize, usize)> {
    let mut edges = Vec::new();
    for i in 0..rows * columns {
        if i % columns + 1 < columns {
            edges.push((i, i + 1));
        }
        if i + columns < rows * columns {
            edges.push((i, i + columns));
        }
    }
    edges
}

fn random(rows: usize, columns: usize, rng: &mut ChaCha8Rng) -> Mat<f64> {
    Mat::from_fn(rows, columns, |_, _| rng.random_range(-1.0..1.0))
}

/// A network with random biases, so that they matter.
fn random_gcn(shape: (usize, usize, usize), biases: bool, rng: &mut ChaCha8Rng) -> Gcn {
    let gcn = Gcn::new(shape.0, shape.1, shape.2, biases, rng);
    let mut parameters = gcn.parameters().clone();
    for layer in [&mut parameters.hidden, &mut parameters.output] {
        for b in layer.bias.iter_mut().flatten() {
            *b = rng.random_range(-0.5..0.5);
        }
    }
    Gcn::from_parameters(parameters).unwrap()
}

/// A graph, its features and a network, as one function of the network's parameters.
struct Problem {
    adjacency: SymmetricCsr,
    propagation: Propagation,
    tx: Mat<f64>,
    gcn: Gcn,
}

impl Problem {
    /// Draws until no pre-activation lies near the kink.
    fn draw(
        adjacency: SymmetricCsr,
        shape: (usize, usize, usize),
        biases: bool,
        seed: u64,
    ) -> Self {
        let rng = &mut stream(seed, Stream::Gcn);
        loop {
            let problem = Self::draw_anywhere(adjacency.clone(), shape, biases, rng);
            if problem.distance_to_kink() > KINK {
                return problem;
            }
        }
    }

    /// For tests that differentiate nothing numerically.
    fn draw_anywhere(
        adjacency: SymmetricCsr,
        shape: (usize, usize, usize),
        biases: bool,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        let propagation = Propagation::new(&adjacency);
        let x = random(adjacency.num_nodes(), shape.0, rng);
        Self {
            tx: propagation.apply(x.as_ref()),
            gcn: random_gcn(shape, biases, rng),
            adjacency,
            propagation,
        }
    }

    fn distance_to_kink(&self) -> f64 {
        let hidden = &self.gcn.parameters().hidden;
        let s = &self.tx * hidden.weight();
        let bias = |j: usize| hidden.bias.as_ref().map_or(0.0, |b| b[j]);
        let mut smallest = f64::INFINITY;
        for i in 0..s.nrows() {
            for j in 0..s.ncols() {
                smallest = smallest.min((s[(i, j)] + bias(j)).abs());
            }
        }
        smallest
    }

    fn output(&self, gcn: &Gcn) -> Mat<f64> {
        let mut workspace = GcnWorkspace::default();
        gcn.forward(&self.propagation, self.tx.as_ref(), &mut workspace)
            .to_owned()
    }

    fn gradient(&self, output_gradient: MatRef<'_, f64>) -> GcnParameters {
        let mut workspace = GcnWorkspace::default();
        let (t, tx) = (&self.propagation, self.tx.as_ref());
        self.gcn.forward(t, tx, &mut workspace);
        self.gcn.backward(t, tx, &mut workspace, output_gradient)
    }

    /// ‖analytic − numeric‖∞ ÷ ‖numeric‖∞ over all parameters of a loss of Z.
    fn relative_error(
        &self,
        loss: impl Fn(&Mat<f64>) -> f64,
        output_gradient: MatRef<'_, f64>,
    ) -> f64 {
        let analytic = self.gradient(output_gradient);
        let (mut error, mut scale) = (0.0f64, 0.0f64);
        for (index, &analytic) in analytic.slices().flatten().enumerate() {
            let at = |step: f64| {
                let mut parameters = self.gcn.parameters().clone();
                *parameters.slices_mut().flatten().nth(index).unwrap() += step;
                loss(&self.output(&Gcn::from_parameters(parameters).unwrap()))
            };
            let numeric = (at(STEP) - at(-STEP)) / (2.0 * STEP);
            error = error.max((analytic - numeric).abs());
            scale = scale.max(numeric.abs());
        }
        assert!(scale > 0.0, "a loss that nothing depends on tests nothing");
        error / scale
    }
}

fn classifier_loss(loss: &ClassifierLoss<'_>, z: &Mat<f64>) -> f64 {
    loss.evaluate(z.as_ref(), &mut LossWorkspace::default())
}

/// Graphs with a cycle, an isolated node, a self-loop, several components.
fn graphs() -> Vec<SymmetricCsr> {
    vec![
        graph(1, &[]),
        graph(6, &[(0, 1), (1, 2), (2, 0), (3, 4)]),
        graph(5, &[(0, 1), (1, 1), (1, 2), (2, 3)]),
        graph(12, &grid_edges(3, 4)),
    ]
}

#[test]
fn backward_matches_central_differences_for_any_output_gradient() {
    for (seed, adjacency) in graphs().into_iter().enumerate() {
        for shape in [(1, 1, 1), (3, 5, 1), (4, 3, 2), (2, 7, 4)] {
            for biases in [false, true] {
                // On a single node enough units that one of them is sure to be awake.
                let hidden = if adjacency.num_nodes() == 1 {
                    9
                } else {
                    shape.1
                };
                let shape = (shape.0, hidden, shape.2);
                let n = adjacency.num_nodes();
                let problem = Problem::draw(adjacency.clone(), shape, biases, seed as u64);
                let slope = random(n, shape.2, &mut stream(seed as u64, Stream::Walks));
                let loss = |z: &Mat<f64>| -> f64 {
                    (0..n)
                        .flat_map(|i| (0..shape.2).map(move |j| (i, j)))
                        .map(|at| z[at] * slope[at])
                        .sum()
                };
                let error = problem.relative_error(loss, slope.as_ref());
                assert!(
                    error < RELATIVE_TOLERANCE,
                    "graph {seed}, {shape:?}, biases {biases}: {error:.1e}"
                );
            }
        }
    }
}

#[test]
fn the_whole_loss_matches_central_differences() {
    for (seed, adjacency) in graphs().into_iter().enumerate() {
        let last = adjacency.num_nodes() as u32 - 1;
        for (classes, lambda) in [(2, 0.0), (2, 0.7), (2, 30.0), (3, 3.0)] {
            let labels = [(0, 0), (last, 1), (0, classes - 1)];
            let problem = Problem::draw(adjacency.clone(), (3, 9, classes), true, seed as u64);
            let loss = ClassifierLoss::new(&problem.adjacency, &labels, lambda);
            let mut workspace = LossWorkspace::default();
            loss.evaluate(problem.output(&problem.gcn).as_ref(), &mut workspace);
            let error = problem.relative_error(|z| classifier_loss(&loss, z), workspace.gradient());
            assert!(
                error < RELATIVE_TOLERANCE,
                "graph {seed}, {classes} classes, lambda {lambda}: {error:.1e}"
            );
        }
    }
}

/// Blocks of rows and lanes join without a seam: 5 000 nodes are several of both, and the forward pass
/// equals the formula written with whole matrices.
#[test]
fn large_graphs_equal_the_formula_in_whole_matrices() {
    let adjacency = graph(5000, &grid_edges(50, 100));
    let problem = Problem::draw_anywhere(adjacency, (5, 6, 2), true, &mut stream(8, Stream::Gcn));
    let parameters = problem.gcn.parameters();
    let bias = |layer: &GraphConv, j: usize| layer.bias.as_ref().unwrap()[j];
    let s = &problem.tx * parameters.hidden.weight();
    let s = Mat::from_fn(s.nrows(), s.ncols(), |i, j| {
        s[(i, j)] + bias(&parameters.hidden, j)
    });
    let h = Mat::from_fn(s.nrows(), s.ncols(), |i, j| s[(i, j)].max(0.0));
    let z = problem
        .propagation
        .apply((&h * parameters.output.weight()).as_ref());
    let z = Mat::from_fn(z.nrows(), z.ncols(), |i, j| {
        z[(i, j)] + bias(&parameters.output, j)
    });
    assert!((problem.output(&problem.gcn) - z).norm_max() < 1e-13);

    let slope = random(5000, 2, &mut stream(8, Stream::Walks));
    let p = problem.propagation.apply(slope.as_ref());
    let ds = &p * parameters.output.weight().transpose();
    let ds = Mat::from_fn(s.nrows(), s.ncols(), |i, j| {
        if s[(i, j)] > 0.0 { ds[(i, j)] } else { 0.0 }
    });
    let gradient = problem.gradient(slope.as_ref());
    let column_sums =
        |m: &Mat<f64>| -> Vec<f64> { (0..m.ncols()).map(|j| m.col(j).iter().sum()).collect() };
    let close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-10);
    assert!((gradient.hidden.weight() - problem.tx.transpose() * &ds).norm_max() < 1e-10);
    assert!((gradient.output.weight() - h.transpose() * &p).norm_max() < 1e-10);
    assert!(close(
        gradient.hidden.bias.as_ref().unwrap(),
        &column_sums(&ds)
    ));
    assert!(close(
        gradient.output.bias.as_ref().unwrap(),
        &column_sums(&slope)
    ));
}

// The numbers below were printed by PyTorch 2.15.0, in double precision, from this script:
//
// import torch
// torch.set_default_dtype(torch.float64)
// n, f, h, c, lam = 10, 3, 4, 2, 0.5
// edges = [(i, i + 1) for i in range(9) if i % 3 < 2] + [(i, i + 3) for i in range(6)] + [(8, 9)]
// A = torch.zeros(n, n)
// for i, j in edges: A[i, j] = A[j, i] = 1
// At = A + torch.eye(n); d = At.sum(1) ** -0.5; T = d[:, None] * At * d[None, :]
// L = torch.diag(A.sum(1)) - A
// cell = lambda a, b, m: lambda i, j: ((a * i + b * j) % m - m // 2) / m
// fill = lambda r, k, g: torch.tensor([[g(i, j) for j in range(k)] for i in range(r)])
// X = fill(n, f, cell(3, 5, 7))
// W0, b0 = fill(f, h, cell(7, 4, 11)), fill(1, h, cell(0, 5, 9))[0]
// W1, b1 = fill(h, c, cell(5, 3, 13)), fill(1, c, cell(0, 2, 5))[0]
// params = [p.requires_grad_() for p in (W0, b0, W1, b1)]
// nodes, classes = torch.tensor([0, 9, 0]), torch.tensor([0, 1, 0])
// adam = torch.optim.Adam(params, lr=0.01)
// forward = lambda: T @ (torch.relu(T @ (X @ W0) + b0) @ W1) + b1
// def loss(z):
//     phi = torch.softmax(z, 1)[:, 1]
//     return torch.nn.functional.cross_entropy(z[nodes], classes) + lam / len(edges) * phi @ L @ phi
// losses = []
// for _ in range(40):
//     adam.zero_grad(); l = loss(forward()); l.backward(); adam.step(); losses.append(l.item())
// losses.append(loss(forward()).item())
// print(losses); print(torch.softmax(forward(), 1)[:, 1].tolist(), torch.__version__)
const TORCH_LOSSES: [f64; 41] = [
    0.804312351207413,
    0.7952016751643923,
    0.7865757099171756,
    0.7784256831046737,
    0.7707402159173254,
    0.7635053182546917,
    0.7567044258403182,
    0.7502888853800745,
    0.744266479792327,
    0.7386301398004016,
    0.7333584423253527,
    0.7284345747952613,
    0.7237907739098312,
    0.7194006163454038,
    0.7152381338099992,
    0.7112766450395435,
    0.7074763787854941,
    0.7038264947450591,
    0.7003245944633448,
    0.6969429795406061,
    0.693666353829251,
    0.6904830003730891,
    0.6873833957257064,
    0.6843599353083728,
    0.6814066422948362,
    0.6785188655703234,
    0.6756929794746638,
    0.672926099963812,
    0.67021582977285,
    0.6675600412625237,
    0.6649884405775229,
    0.6624750062609215,
    0.6600150832974404,
    0.6576067063236666,
    0.6552478265285957,
    0.6529362959505135,
    0.6506699029216536,
    0.6484463931095645,
    0.6462634904040884,
    0.6441189157608935,
    0.6420104039706562,
];
const TORCH_PHI: [f64; 10] = [
    0.406419816876743,
    0.40571234155738073,
    0.41065255645145293,
    0.4018891052795988,
    0.4039047888809481,
    0.4072477254715464,
    0.40467909414817305,
    0.403419842266241,
    0.4080877866791832,
    0.41360273646616375,
];

#[test]
fn a_fit_repeats_the_recorded_pytorch_run() {
    // Exact in binary or rounded the same way in both languages: one division of small integers.
    let cell = |a: usize, b: usize, m: usize| {
        move |i: usize, j: usize| (((a * i + b * j) % m) as f64 - (m / 2) as f64) / m as f64
    };
    let layer = |inputs, outputs, w: (usize, usize, usize), b: (usize, usize)| GraphConv {
        inputs,
        outputs,
        weight: (0..inputs * outputs)
            .map(|at| cell(w.0, w.1, w.2)(at / outputs, at % outputs))
            .collect(),
        bias: Some((0..outputs).map(|j| cell(0, b.0, b.1)(0, j)).collect()),
    };
    let mut gcn = Gcn::from_parameters(GcnParameters {
        hidden: layer(3, 4, (7, 4, 11), (5, 9)),
        output: layer(4, 2, (5, 3, 13), (2, 5)),
    })
    .unwrap();
    let mut edges = grid_edges(3, 3);
    edges.push((8, 9));
    let adjacency = graph(10, &edges);
    let propagation = Propagation::new(&adjacency);
    let x = Mat::from_fn(10, 3, cell(3, 5, 7));
    let labels = [(0, 0), (9, 1), (0, 0)];
    let mut adam = Adam::new(&gcn, 0.01);
    // One epoch per call: also shows that a re-fit goes on from the present weights and moments.
    let params = GcnParams {
        hidden_dim: 4,
        learning_rate: 0.01,
        epochs: 1,
        smoothness: 0.5,
        ..GcnParams::default()
    };
    for pair in TORCH_LOSSES.windows(2) {
        let (phi, report) = fit_classifier(
            &mut gcn,
            &mut adam,
            &propagation,
            &adjacency,
            x.as_ref(),
            &labels,
            &params,
        )
        .unwrap();
        assert!((report.initial_loss - pair[0]).abs() < 1e-8, "{report:?}");
        assert!((report.loss - pair[1]).abs() < 1e-8, "{report:?}");
        if adam.steps() == 40 {
            for (i, expected) in TORCH_PHI.iter().enumerate() {
                assert!((phi[(i, 1)] - expected).abs() < 1e-8, "node {i}");
                assert!((phi[(i, 0)] + phi[(i, 1)] - 1.0).abs() < 1e-15);
            }
        }
    }
    assert_eq!(adam.steps(), 40);
}

/// Low eigenvectors of D − A on a grid, times √n: products of cosines, exact.
fn cosines(rows: usize, columns: usize, orders: usize) -> Mat<f64> {
    let wave = |at: usize, order: usize, length: usize| {
        let phase = std::f64::consts::PI * order as f64 * (at as f64 + 0.5) / length as f64;
        if order == 0 {
            1.0
        } else {
            2f64.sqrt() * phase.cos()
        }
    };
    Mat::from_fn(rows * columns, orders * orders, |i, k| {
        wave(i / columns, k / orders, rows) * wave(i % columns, k % orders, columns)
    })
}

/// The source paper's Fig. 5b: on 5 × 5 with the goal in a corner, reward has spread from goal to start.
#[test]
fn the_fitted_potential_falls_with_distance_from_the_goal() {
    let adjacency = graph(25, &grid_edges(5, 5));
    let propagation = Propagation::new(&adjacency);
    let x = cosines(5, 5, 3);
    for seed in 0..5 {
        let mut gcn = Gcn::new(9, 16, 2, true, &mut stream(seed, Stream::Gcn));
        let mut adam = Adam::new(&gcn, 0.01);
        let params = GcnParams {
            epochs: 40,
            ..GcnParams::default()
        };
        let labels = [(0, 0), (24, 1)];
        let (p, report) = fit_classifier(
            &mut gcn,
            &mut adam,
            &propagation,
            &adjacency,
            x.as_ref(),
            &labels,
            &params,
        )
        .unwrap();
        assert!(report.loss < report.initial_loss);
        // Mean over the cells at each distance from the goal; the cells themselves may wiggle.
        let means: Vec<f64> = (0..9)
            .map(|distance| {
                let ring: Vec<f64> = (0..25)
                    .filter(|i| 8 - (i / 5 + i % 5) == distance)
                    .map(|i| p[(i, 1)])
                    .collect();
                ring.iter().sum::<f64>() / ring.len() as f64
            })
            .collect();
        assert!(
            means.windows(2).all(|pair| pair[0] > pair[1]),
            "seed {seed}: {means:.3?}"
        );
    }
}

#[test]
fn growing_the_inputs_changes_nothing_until_the_next_step() {
    let adjacency = graph(12, &grid_edges(3, 4));
    let propagation = Propagation::new(&adjacency);
    let x = random(12, 5, &mut stream(2, Stream::Walks));
    let (labels, params) = ([(0, 0), (11, 1)], GcnParams::default());
    let mut gcn = Gcn::new(3, 8, 2, true, &mut stream(2, Stream::Gcn));
    let mut adam = Adam::new(&gcn, 0.01);
    let fit = |gcn: &mut Gcn, adam: &mut Adam, features: usize| {
        let x = x.as_ref().subcols(0, features);
        fit_classifier(gcn, adam, &propagation, &adjacency, x, &labels, &params).unwrap()
    };
    let (_, narrow) = fit(&mut gcn, &mut adam, 3);
    gcn.grow_inputs(5);
    adam.grow_inputs(5);
    let (_, wide) = fit(&mut gcn, &mut adam, 5);
    assert!((wide.initial_loss - narrow.loss).abs() < 1e-15);
    assert!(wide.loss < wide.initial_loss);
    let new_rows = &gcn.parameters().hidden.weight[3 * 8..];
    assert!(new_rows.iter().any(|&w| w != 0.0), "new inputs are used");
}

#[test]
fn a_zero_output_layer_gives_zero_and_still_learns() {
    let mut problem = Problem::draw_anywhere(
        graphs().remove(3),
        (3, 4, 1),
        true,
        &mut stream(1, Stream::Gcn),
    );
    problem.gcn.zero_output_layer();
    assert_eq!(problem.output(&problem.gcn).norm_max(), 0.0);
    let slope = Mat::from_fn(12, 1, |_, _| 1.0);
    let gradient = problem.gradient(slope.as_ref());
    assert!(gradient.output.weight.iter().any(|&g| g != 0.0));
}

#[test]
fn numbers_that_are_none_are_errors_and_leave_the_network_alone() {
    let adjacency = graph(4, &[(0, 1), (1, 2), (2, 3)]);
    let propagation = Propagation::new(&adjacency);
    let x = random(4, 2, &mut stream(0, Stream::Walks));
    let fit = |gcn: &mut Gcn, x: &Mat<f64>, params: &GcnParams| {
        let mut adam = Adam::new(gcn, params.learning_rate);
        let labels = [(0, 0), (3, 1)];
        let result = fit_classifier(
            gcn,
            &mut adam,
            &propagation,
            &adjacency,
            x.as_ref(),
            &labels,
            params,
        );
        assert!(result.is_ok() || adam.steps() == 0, "moments were kept");
        result
    };
    let start = Gcn::new(2, 3, 2, true, &mut stream(0, Stream::Gcn));
    let params = GcnParams::default();

    let mut parameters = start.parameters().clone();
    parameters.hidden.weight[1] = f64::NAN;
    let mut broken = Gcn::from_parameters(parameters).unwrap();
    let error = fit(&mut broken, &x, &params).unwrap_err();
    assert_eq!(error, GcnError::NotFinite { what: "weights" });

    let mut gcn = start.clone();
    let bad = Mat::from_fn(4, 2, |i, _| if i == 2 { f64::INFINITY } else { 1.0 });
    let error = fit(&mut gcn, &bad, &params).unwrap_err();
    assert!(matches!(error, GcnError::NotFinite { .. }));

    let wild = GcnParams {
        learning_rate: 1e300,
        ..params.clone()
    };
    let error = fit(&mut gcn, &x, &wild).unwrap_err();
    assert!(
        matches!(error, GcnError::Diverged { epoch: 1.., .. }),
        "{error}"
    );
    assert_eq!(gcn, start);

    let none = GcnParams {
        hidden_dim: 0,
        ..params
    };
    let error = fit(&mut gcn, &x, &none).unwrap_err();
    assert!(error.to_string().starts_with("gcn.hidden_dim"));
}

#[test]
fn a_fit_gives_the_same_bits_on_one_thread_and_on_many() {
    let adjacency = graph(6000, &grid_edges(60, 100));
    let x = cosines(60, 100, 2);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| {
            let mut gcn = Gcn::new(4, 8, 2, true, &mut stream(5, Stream::Gcn));
            let mut adam = Adam::new(&gcn, 0.01);
            let params = GcnParams {
                epochs: 5,
                ..GcnParams::default()
            };
            let fitted = fit_classifier(
                &mut gcn,
                &mut adam,
                &Propagation::new(&adjacency),
                &adjacency,
                x.as_ref(),
                &[(0, 0), (5999, 1)],
                &params,
            );
            (fitted.unwrap(), gcn, adam)
        })
    };
    let (one, four) = (on(1), on(4));
    assert_eq!(one.0.0, four.0.0);
    assert_eq!((one.0.1, one.1, one.2), (four.0.1, four.1, four.2));
}

#[test]
fn a_stored_network_of_broken_shape_is_refused() {
    let gcn = Gcn::new(2, 3, 2, true, &mut stream(0, Stream::Gcn));
    let json = serde_json::to_string(&gcn).unwrap();
    assert_eq!(
        serde_json::from_str::<Gcn>(&json).unwrap().num_features(),
        2
    );
    let wrong = json.replacen("\"inputs\":2", "\"inputs\":4", 1);
    let error = serde_json::from_str::<Gcn>(&wrong).unwrap_err().to_string();
    assert!(error.contains("hidden layer claims 4 inputs"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Any small graph, self-loops, isolated nodes and several components included.
    #[test]
    fn gradients_hold_on_any_small_graph(
        n in 1usize..6,
        edges in prop::collection::vec((0usize..6, 0usize..6), 0..8),
        classes in 2usize..4,
        lambda in 0.0f64..5.0,
        seed in 0u64..1000,
    ) {
        let mut edges: Vec<_> = edges
            .into_iter()
            .map(|(i, j)| ((i % n).min(j % n), (i % n).max(j % n)))
            .collect();
        edges.sort_unstable();
        edges.dedup();
        let problem = Problem::draw(graph(n, &edges), (2, 9, classes), true, seed);
        let labels = [(0, 0), (n as u32 - 1, 1)];
        let loss = ClassifierLoss::new(&problem.adjacency, &labels, lambda);
        let mut workspace = LossWorkspace::default();
        loss.evaluate(problem.output(&problem.gcn).as_ref(), &mut workspace);
        let error = problem.relative_error(|z| classifier_loss(&loss, z), workspace.gradient());
        prop_assert!(error < RELATIVE_TOLERANCE, "{error:.1e}");
    }

    /// Renaming the nodes renames the output: the network sees a graph, not an order.
    #[test]
    fn the_output_does_not_depend_on_the_order_of_the_nodes(
        edges in prop::collection::vec((0usize..6, 0usize..6), 0..10),
        seed in 0u64..1000,
    ) {
        let reverse = |i: usize| 5 - i;
        let mut edges: Vec<_> = edges.into_iter().map(|(i, j)| (i.min(j), i.max(j))).collect();
        edges.sort_unstable();
        edges.dedup();
        let renamed: Vec<_> = edges.iter().map(|&(i, j)| (reverse(i), reverse(j))).collect();
        let rng = &mut stream(seed, Stream::Gcn);
        let x = random(6, 3, rng);
        let gcn = random_gcn((3, 4, 2), true, rng);
        let output = |adjacency: SymmetricCsr, x: Mat<f64>| {
            let propagation = Propagation::new(&adjacency);
            let tx = propagation.apply(x.as_ref());
            gcn.forward(&propagation, tx.as_ref(), &mut GcnWorkspace::default()).to_owned()
        };
        let z = output(graph(6, &edges), x.clone());
        let reversed = output(graph(6, &renamed), Mat::from_fn(6, 3, |i, j| x[(reverse(i), j)]));
        for i in 0..6 {
            for j in 0..2 {
                prop_assert!((z[(i, j)] - reversed[(reverse(i), j)]).abs() < 1e-12);
            }
        }
    }
}
