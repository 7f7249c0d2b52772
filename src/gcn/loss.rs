//! Softmax cross-entropy on labelled nodes plus smoothness of the class probabilities on the graph:
//!
//! ```text
//! loss(Z) = −(1/|Y|) Σ_{(i,c) ∈ Y} ln P_ic + (λ/|E|) · ½ tr(PᵀLP),    P = softmax(Z) by rows,  L = D − A
//! ```
//!
//! With two classes ½ tr(PᵀLP) = φᵀLφ = Σ_{{i,j} ∈ E} w_ij (φ_i − φ_j)² for φ the probability of either class:
//! the propagation loss of Klissarov & Precup, "Reward Propagation Using Graph Convolutional Networks",
//! NeurIPS 2020, per edge, so that λ means the same on small and on large graphs. With more classes no class
//! is singled out. Gradient, with e = (λ/|E|) L P:
//!
//! ```text
//! ∂loss/∂Z_i = P_i ⊙ (e_i − ⟨P_i, e_i⟩) + (1/|Y|) Σ_{(i,c) ∈ Y} (P_i − 1_c)
//! ```

use super::Smoothness;
use super::rows::{BLOCK_ROWS, pack, rows_per_lane, view};
use crate::exponential::{exp, exp_in_place};
use crate::graph::SymmetricCsr;
use faer::MatRef;
use rayon::prelude::*;

/// The loss of one labelled graph.
#[derive(Clone, Copy, Debug)]
pub struct ClassifierLoss<'a> {
    smoothness: Smoothness<'a>,
    labels: &'a [(u32, usize)],
    lambda: f64,
}

/// Buffers of a loss, row-major n × c, reused from call to call.
#[derive(Clone, Debug, Default)]
pub struct LossWorkspace {
    probabilities: Vec<f64>,
    gradient: Vec<f64>,
    classes: usize,
}

impl LossWorkspace {
    /// P of the last evaluation, n × c.
    pub fn probabilities(&self) -> MatRef<'_, f64> {
        view(&self.probabilities, self.classes)
    }

    /// ∂loss/∂Z of the last evaluation, n × c.
    pub fn gradient(&self) -> MatRef<'_, f64> {
        view(&self.gradient, self.classes)
    }

    /// The same, row-major.
    pub(super) fn gradient_rows(&self) -> &[f64] {
        &self.gradient
    }

    fn reserve(&mut self, nodes: usize, classes: usize) {
        self.classes = classes;
        self.probabilities.resize(nodes * classes, 0.0);
        self.gradient.resize(nodes * classes, 0.0);
    }
}

impl<'a> ClassifierLoss<'a> {
    /// `labels` are (node, class); a node may appear more than once, and each entry counts. Without labels
    /// only smoothness is left. `lambda` is λ ≥ 0. O(nnz).
    ///
    /// # Panics
    /// If a label names no node of the graph.
    pub fn new(adjacency: &'a SymmetricCsr, labels: &'a [(u32, usize)], lambda: f64) -> Self {
        for &(node, _) in labels {
            assert!(
                (node as usize) < adjacency.num_nodes(),
                "label of node {node}"
            );
        }
        Self {
            smoothness: Smoothness::new(adjacency),
            labels,
            lambda,
        }
    }

    /// loss(Z); leaves P and ∂loss/∂Z in the workspace. O((n + nnz) · c), no allocation in a steady state.
    /// A NaN among the logits makes the loss NaN if λ > 0 and its node has an edge, or if its node is labelled.
    ///
    /// # Panics
    /// If `logits` has not n rows or no column, or a label names no class of it.
    pub fn evaluate(&self, logits: MatRef<'_, f64>, workspace: &mut LossWorkspace) -> f64 {
        let classes = logits.ncols();
        assert!(classes > 0, "logits of no class");
        workspace.reserve(logits.nrows(), classes);
        let LossWorkspace {
            probabilities,
            gradient,
            ..
        } = workspace;
        pack(logits, probabilities);
        softmax_rows(probabilities, classes);
        let smoothness = self.smooth(probabilities, classes, gradient);
        let cross_entropy = self.cross_entropy(logits, probabilities, gradient);
        cross_entropy + smoothness
    }

    /// The smoothness term; sets `gradient` to its share of ∂loss/∂Z.
    fn smooth(&self, probabilities: &[f64], classes: usize, gradient: &mut [f64]) -> f64 {
        if self.lambda == 0.0 {
            gradient.fill(0.0);
            return 0.0;
        }
        let half_lambda = 0.5 * self.lambda;
        let energy = self.smoothness.evaluate(probabilities, classes, gradient);
        through_softmax_rows(gradient, probabilities, classes, half_lambda);
        half_lambda * energy
    }

    /// The mean over the labels; adds its share to `gradient`. From the logits, because ln P of a node that is
    /// certain of the wrong class would be −∞.
    fn cross_entropy(
        &self,
        logits: MatRef<'_, f64>,
        probabilities: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let classes = logits.ncols();
        let share = 1.0 / self.labels.len().max(1) as f64;
        let mut total = 0.0;
        for &(node, class) in self.labels {
            assert!(class < classes, "label {class} with {classes} classes");
            let node = node as usize;
            let entries = node * classes..(node + 1) * classes;
            total += log_sum_exp(|| logits.row(node).iter().copied()) - logits[(node, class)];
            let gradient = &mut gradient[entries.clone()];
            for (gradient, p) in gradient.iter_mut().zip(&probabilities[entries]) {
                *gradient += share * p;
            }
            gradient[class] -= share;
        }
        share * total
    }
}

/// Each row of `gradient` ← P_i ⊙ (e_i − ⟨P_i, e_i⟩) with e = `scale` · `gradient`.
fn through_softmax_rows(gradient: &mut [f64], p: &[f64], classes: usize, scale: f64) {
    let rows = rows_per_lane(p.len() / classes);
    if p.len() <= rows * classes {
        return through_softmax(gradient, p, classes, scale);
    }
    gradient
        .par_chunks_mut(rows * classes)
        .zip(p.par_chunks(rows * classes))
        .for_each(|(gradient, p)| through_softmax(gradient, p, classes, scale));
}

fn through_softmax(gradient: &mut [f64], p: &[f64], classes: usize, scale: f64) {
    let rows = gradient.chunks_exact_mut(classes);
    for (gradient, p) in rows.zip(p.chunks_exact(classes)) {
        let mean: f64 = gradient.iter().zip(p).map(|(g, p)| g * p).sum();
        for (gradient, p) in gradient.iter_mut().zip(p) {
            *gradient = scale * p * (*gradient - mean);
        }
    }
}

/// Each row z of `values` ← softmax(z).
fn softmax_rows(values: &mut [f64], classes: usize) {
    let rows = rows_per_lane(values.len() / classes);
    let softmax_lane = |values: &mut [f64]| {
        let blocks = values.chunks_mut(BLOCK_ROWS * classes);
        blocks.for_each(|block| softmax_block(block, classes));
    };
    if values.len() <= rows * classes {
        return softmax_lane(values);
    }
    values.par_chunks_mut(rows * classes).for_each(softmax_lane);
}

/// Row by row but for the exponentials, which are taken of all rows at once.
fn softmax_block(block: &mut [f64], classes: usize) {
    for row in block.chunks_exact_mut(classes) {
        let largest = row.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        row.iter_mut().for_each(|value| *value -= largest);
    }
    exp_in_place(block);
    for row in block.chunks_exact_mut(classes) {
        let scale = 1.0 / row.iter().sum::<f64>();
        row.iter_mut().for_each(|value| *value *= scale);
    }
}

/// ln Σ exp z over the entries of a row, which is walked twice.
fn log_sum_exp<I: Iterator<Item = f64>>(row: impl Fn() -> I) -> f64 {
    let largest = row().fold(f64::NEG_INFINITY, f64::max);
    largest + libm::log(row().map(|z| exp(z - largest)).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    fn path(n: usize) -> SymmetricCsr {
        let mut triplets = sprs::TriMatI::<f64, u32>::new((n, n));
        for i in 1..n {
            triplets.add_triplet(i - 1, i, 1.0);
            triplets.add_triplet(i, i - 1, 1.0);
        }
        SymmetricCsr::new(triplets.to_csr()).unwrap()
    }

    /// Log-odds 0 and ln 3 give φ = 1/2 and 3/4: cross-entropy of (node 1, class 1) is −ln(3/4), the single
    /// edge adds λ/16.
    #[test]
    fn two_nodes_by_hand() {
        let (graph, labels) = (path(2), [(1, 1)]);
        let logits = Mat::from_fn(2, 2, |i, j| if (i, j) == (1, 1) { 3f64.ln() } else { 0.0 });
        let mut workspace = LossWorkspace::default();
        let loss = ClassifierLoss::new(&graph, &labels, 8.0);
        let value = loss.evaluate(logits.as_ref(), &mut workspace);
        assert!((value - ((4.0f64 / 3.0).ln() + 0.5)).abs() < 1e-15);
        assert!((workspace.probabilities()[(1, 1)] - 0.75).abs() < 1e-15);
        // ∂(λ φᵀLφ)/∂z_01 = 2 λ (φ_0 − φ_1) φ_0 (1 − φ_0) = 16 · (−1/4) · 1/4.
        assert!((workspace.gradient()[(0, 1)] + 1.0).abs() < 1e-15);
    }

    #[test]
    fn certainty_of_the_wrong_class_costs_a_finite_amount() {
        let (graph, labels) = (path(2), [(0, 1)]);
        let logits = Mat::from_fn(2, 2, |_, j| if j == 0 { 2000.0 } else { -2000.0 });
        let mut workspace = LossWorkspace::default();
        let loss = ClassifierLoss::new(&graph, &labels, 1.0);
        assert_eq!(loss.evaluate(logits.as_ref(), &mut workspace), 4000.0);
        assert_eq!(workspace.gradient()[(0, 1)], -1.0);
    }

    #[test]
    fn a_repeated_label_counts_each_time_and_none_at_all_is_legal() {
        let graph = path(3);
        let logits = Mat::from_fn(3, 2, |i, j| (i * 2 + j) as f64);
        let mut workspace = LossWorkspace::default();
        let mut value = |labels: &[(u32, usize)]| {
            ClassifierLoss::new(&graph, labels, 0.0).evaluate(logits.as_ref(), &mut workspace)
        };
        let (low, high) = (value(&[(0, 1)]), value(&[(0, 0)]));
        assert!((value(&[(0, 1), (0, 1), (0, 0)]) - (2.0 * low + high) / 3.0).abs() < 1e-15);
        assert_eq!(value(&[]), 0.0);
    }

    #[test]
    fn nan_is_not_hidden() {
        let (graph, labels) = (path(2), [(0, 1)]);
        let logits = Mat::from_fn(2, 2, |i, _| if i == 1 { f64::NAN } else { 0.0 });
        let loss = ClassifierLoss::new(&graph, &labels, 1.0);
        assert!(
            loss.evaluate(logits.as_ref(), &mut LossWorkspace::default())
                .is_nan()
        );
    }
}
