//! Skip-gram with negative sampling (Mikolov, Sutskever, Chen, Corrado & Dean 2013, eq. 4), one pair at a time.
//!
//! ```text
//! J(c, o, N) = −ln σ(x_c · y_o) − Σ_{k ∈ N} ln σ(−x_c · y_k),      σ(s) = 1 / (1 + e^{−s})
//! ∂J/∂y_k = (σ(x_c · y_k) − [k = o]) x_c,      ∂J/∂x_c = Σ_{k ∈ {o} ∪ N} (σ(x_c · y_k) − [k = o]) y_k
//! ```
//!
//! x are the vectors of nodes as centres of a window, y as its members. What is handed out in the end is x.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// The two vectors of every node.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SkipGram {
    dimensions: usize,
    /// x by node.
    #[serde(with = "crate::spectral::plain::numbers")]
    centres: Vec<f64>,
    /// y by node.
    #[serde(with = "crate::spectral::plain::numbers")]
    members: Vec<f64>,
    /// ∂J/∂x_c of the pair at hand.
    #[serde(skip)]
    gradient: Vec<f64>,
}

impl SkipGram {
    /// No nodes yet.
    pub fn new(dimensions: usize) -> Self {
        Self {
            dimensions,
            centres: Vec::new(),
            members: Vec::new(),
            gradient: Vec::new(),
        }
    }

    /// Whether there are two vectors of `dimensions` numbers, at least one, for each of `nodes` nodes.
    pub(super) fn has_shape(&self, nodes: usize, dimensions: usize) -> bool {
        let length = nodes.checked_mul(dimensions);
        dimensions > 0
            && self.dimensions == dimensions
            && length == Some(self.centres.len())
            && length == Some(self.members.len())
    }

    /// Number of nodes.
    pub fn num_nodes(&self) -> usize {
        self.centres.len() / self.dimensions
    }

    /// x, row by row.
    pub fn centres(&self) -> &[f64] {
        &self.centres
    }

    /// Appends a node amid `neighbors`, which must be known: both its vectors are the means of theirs. Without any,
    /// x is small and random and y is 0.
    pub fn push(&mut self, neighbors: &[u32], rng: &mut ChaCha8Rng) {
        let d = self.dimensions;
        if neighbors.is_empty() {
            let small = 1.0 / d as f64;
            self.centres
                .extend((0..d).map(|_| small * (rng.random::<f64>() - 0.5)));
            self.members.resize(self.centres.len(), 0.0);
            return;
        }
        for vectors in [&mut self.centres, &mut self.members] {
            for c in 0..d {
                let sum: f64 = neighbors.iter().map(|&j| vectors[j as usize * d + c]).sum();
                vectors.push(sum / neighbors.len() as f64);
            }
        }
    }

    /// J before the step, then a step of size `rate` down its gradient. A negative that is `member` itself is left
    /// out; one that is drawn twice counts twice.
    pub fn step(&mut self, centre: u32, member: u32, negatives: &[u32], rate: f64) -> f64 {
        let d = self.dimensions;
        let x = &mut self.centres[centre as usize * d..][..d];
        self.gradient.clear();
        self.gradient.resize(d, 0.0);
        let mut loss = 0.0;
        let told_apart = negatives.iter().filter(|&&k| k != member);
        for (k, is_member) in [(member, true)]
            .into_iter()
            .chain(told_apart.map(|&k| (k, false)))
        {
            let y = &mut self.members[k as usize * d..][..d];
            let score: f64 = x.iter().zip(&*y).map(|(a, b)| a * b).sum();
            loss += softplus(if is_member { -score } else { score });
            let error = 1.0 / (1.0 + libm::exp(-score)) - f64::from(u8::from(is_member));
            for ((g, y), x) in self.gradient.iter_mut().zip(y).zip(&*x) {
                *g += error * *y;
                *y -= rate * error * x;
            }
        }
        x.iter_mut()
            .zip(&self.gradient)
            .for_each(|(x, g)| *x -= rate * g);
        loss
    }
}

/// ln(1 + e^s) = −ln σ(−s), without overflow.
fn softplus(s: f64) -> f64 {
    s.max(0.0) + libm::log1p(libm::exp(-s.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds::{Stream, stream};

    fn model(nodes: usize) -> SkipGram {
        let mut rng = stream(3, Stream::Walks);
        let mut model = SkipGram::new(4);
        (0..nodes).for_each(|_| model.push(&[], &mut rng));
        let values = model.centres.iter_mut().chain(&mut model.members);
        values.for_each(|v| *v = 2.0 * rng.random::<f64>() - 1.0);
        model
    }

    /// A step of size 1 is minus the gradient; J itself is what a step of size 0 returns.
    #[test]
    fn a_step_goes_down_the_gradient_of_the_loss() {
        let before = model(6);
        let (pair, negatives) = ((1, 4), [0, 2, 4, 5]);
        let mut after = before.clone();
        after.step(pair.0, pair.1, &negatives, 1.0);
        let loss_with = |is_centre: bool, place: usize, shift: f64| {
            let mut shifted = before.clone();
            let vectors = if is_centre {
                &mut shifted.centres
            } else {
                &mut shifted.members
            };
            vectors[place] += shift;
            shifted.step(pair.0, pair.1, &negatives, 0.0)
        };
        let mut moved = 0;
        for is_centre in [true, false] {
            for place in 0..24 {
                let slope =
                    (loss_with(is_centre, place, 1e-5) - loss_with(is_centre, place, -1e-5)) / 2e-5;
                let pick = |m: &SkipGram| {
                    if is_centre {
                        m.centres[place]
                    } else {
                        m.members[place]
                    }
                };
                let step = pick(&after) - pick(&before);
                assert!((step + slope).abs() < 1e-8, "{step} against {slope}");
                moved += usize::from(step != 0.0);
            }
        }
        assert_eq!(moved, 4 * (1 + 1 + 3), "centre, member, three negatives");
    }

    #[test]
    fn softplus_is_exact_where_the_plain_form_overflows() {
        for s in [-30.0, -1.0, 0.0, 0.3, 20.0] {
            let plain = (1.0 + f64::exp(s)).ln();
            assert!((softplus(s) - plain).abs() < 1e-12);
        }
        assert_eq!(softplus(1000.0), 1000.0);
        assert_eq!(softplus(-1000.0), 0.0);
    }

    #[test]
    fn a_new_node_stands_amid_its_neighbours() {
        let mut model = model(3);
        let x: Vec<f64> = model.centres.clone();
        model.push(&[0, 2], &mut stream(0, Stream::Walks));
        for c in 0..4 {
            assert_eq!(model.centres[12 + c], (x[c] + x[8 + c]) / 2.0);
        }
        assert_eq!(model.num_nodes(), 4);
    }
}
