//! W: where the optimally controlled walk goes, and linear systems with I − W.
//!
//! ```text
//! W_ij = ∂ softmin_i / ∂v_j = P_ij e^{−v_j} / Σ_k P_ik e^{−v_k},     softmin_i = −ln Σ_j P_ij e^{−v_j}
//! (I − W) x = b      forwards:   what a change b of the costs does to v
//! (I − Wᵀ) x = b     backwards:  what a gradient b with respect to v is with respect to the costs
//! ```
//!
//! Rows of W sum to 1 and goals absorb, so x_i in the first system is b summed along the walk from i, and in the second
//! the b that has flowed through i on its way to the goals.
//!
//! # The sweep
//! Gauss–Seidel along the chain resolves all ways that only approach the goal; each step away from it must wait for the
//! next sweep. In a long corridor with a tenth of the steps leading away, news from the goal would travel 14 hops a
//! sweep. What is nearly right in the old iterate is not x_j of a far neighbour but the difference x_j − x_i, so the
//! part t_i of row i's far weight is carried along with x_i:
//!
//! ```text
//! I − W = M − N,   M = diag(1 − t) − W_near,   N = W_far − diag(t)
//! M x_new = N x_old + b   forwards, nearest first;      Mᵀ x_new = Nᵀ x_old + b   backwards, farthest first
//! ```
//!
//! On a path the error then falls by a / (1 − a) a sweep, a the far weight, however long the path. Where a is large that
//! overshoots, so t ≤ 0.4; should the iteration grow nevertheless, which it does on large grids with small costs, t is
//! halved, down to plain Gauss–Seidel, a regular splitting of an M-matrix, which converges.

use super::absorbing_chain::AbsorbingChain;
use std::ops::Range;

/// The largest part of a row's far weight that is carried along: a / (1 − a) is 1 at ½.
const CARRY: f64 = 0.4;

/// A change this much larger than the smallest one seen means that the iteration grows.
const GROWTH: f64 = 4.0;

/// W on one chain, and the buffers of its solves.
#[derive(Clone, Debug)]
pub struct ControlledWalk<'c> {
    chain: &'c AbsorbingChain,
    /// W, in the layout of the chain's columns.
    weights: Vec<f64>,
    /// Σ_far W_ij by position; 0 for goals.
    far_weight: Vec<f64>,
    carry: f64,
    /// b and what has flowed in so far, of the transposed sweep.
    inflow: Vec<f64>,
}

impl<'c> ControlledWalk<'c> {
    /// The walk that is not controlled: W = P, normalised over the states that reach a goal.
    pub fn new(chain: &'c AbsorbingChain) -> Self {
        let mut walk = Self {
            chain,
            weights: vec![0.0; chain.nnz()],
            far_weight: vec![0.0; chain.len()],
            carry: CARRY,
            inflow: Vec::new(),
        };
        let indifferent = vec![0.0; chain.len()];
        walk.update(&indifferent, &mut indifferent.clone());
        walk
    }

    /// The chain it walks on.
    pub fn chain(&self) -> &'c AbsorbingChain {
        self.chain
    }

    /// Sets W to that of `v`, and `softmin` past the goals. Both by position; v finite. O(nnz).
    ///
    /// # Panics
    /// If `v` or `softmin` has not one entry per position.
    pub fn update(&mut self, v: &[f64], softmin: &mut [f64]) {
        assert_eq!(
            (v.len(), softmin.len()),
            (self.chain.len(), self.chain.len()),
            "one entry per position"
        );
        for i in self.interior() {
            let columns = self.chain.columns_of(i);
            // Relative to the lowest neighbour, so that nothing under- or overflows.
            let lowest = columns
                .iter()
                .map(|&j| v[j as usize])
                .fold(f64::INFINITY, f64::min);
            let weights = &mut self.weights[self.chain.range(i)];
            let terms = columns.iter().zip(self.chain.probabilities_of(i));
            let mut total = 0.0;
            for (weight, (&j, probability)) in weights.iter_mut().zip(terms) {
                *weight = probability * libm::exp(lowest - v[j as usize]);
                total += *weight;
            }
            weights.iter_mut().for_each(|weight| *weight /= total);
            softmin[i] = lowest - libm::log(total);
            self.far_weight[i] = self.weights[self.chain.far_range(i)].iter().sum();
        }
    }

    /// Row i of W: columns by position, and weights.
    pub fn row(&self, i: usize) -> (&[u32], &[f64]) {
        (self.chain.columns_of(i), &self.weights[self.chain.range(i)])
    }

    /// Improves `x` towards the solution of (I − W) x = b, x = 0 on goals, until a sweep changes it by no more than
    /// `tol` times its largest entry, or for `max_sweeps`. Returns the number of sweeps. O(nnz) each.
    ///
    /// # Panics
    /// If `b` or `x` has not one entry per position.
    pub fn solve(&mut self, b: &[f64], x: &mut [f64], tol: f64, max_sweeps: usize) -> usize {
        self.iterate(b, x, tol, max_sweeps, Self::sweep)
    }

    /// The same for (I − Wᵀ) x = b.
    ///
    /// # Panics
    /// If `b` or `x` has not one entry per position.
    pub fn solve_transposed(
        &mut self,
        b: &[f64],
        x: &mut [f64],
        tol: f64,
        max_sweeps: usize,
    ) -> usize {
        self.iterate(b, x, tol, max_sweeps, Self::sweep_transposed)
    }

    fn iterate(
        &mut self,
        b: &[f64],
        x: &mut [f64],
        tol: f64,
        max_sweeps: usize,
        sweep: impl Fn(&mut Self, &[f64], &mut [f64]) -> Change,
    ) -> usize {
        let n = self.chain.len();
        assert_eq!((b.len(), x.len()), (n, n), "one entry per position");
        x[..self.chain.num_goals()].fill(0.0);
        let mut smallest = f64::INFINITY;
        for sweeps in 1..=max_sweeps {
            let change = sweep(self, b, x);
            if change.largest_step <= tol * change.largest_entry {
                return sweeps;
            }
            if change.largest_step > GROWTH * smallest {
                self.carry *= 0.5;
                smallest = f64::INFINITY;
            }
            smallest = smallest.min(change.largest_step);
        }
        max_sweeps
    }

    fn sweep(&mut self, b: &[f64], x: &mut [f64]) -> Change {
        let mut change = Change::default();
        for i in self.interior() {
            let (columns, weights) = self.row(i);
            let terms = columns.iter().zip(weights);
            let sum: f64 = terms.map(|(&j, w)| w * x[j as usize]).sum();
            let carried = self.carried(i);
            let new = (b[i] + sum - carried * x[i]) / (1.0 - carried);
            change.note(x[i], new);
            x[i] = new;
        }
        change
    }

    fn sweep_transposed(&mut self, b: &[f64], x: &mut [f64]) -> Change {
        let mut inflow = std::mem::take(&mut self.inflow);
        inflow.clear();
        inflow.extend_from_slice(b);
        for i in self.interior() {
            self.push(self.chain.far_range(i), x[i], &mut inflow);
        }
        let mut change = Change::default();
        for i in self.interior().rev() {
            let carried = self.carried(i);
            let new = (inflow[i] - carried * x[i]) / (1.0 - carried);
            change.note(x[i], new);
            x[i] = new;
            self.push(self.chain.near_range(i), new, &mut inflow);
        }
        self.inflow = inflow;
        change
    }

    /// Sends `amount` along the weights in `range`.
    fn push(&self, range: Range<usize>, amount: f64, inflow: &mut [f64]) {
        for (&j, w) in self.chain.columns()[range.clone()]
            .iter()
            .zip(&self.weights[range])
        {
            inflow[j as usize] += w * amount;
        }
    }

    /// t_i.
    fn carried(&self, i: usize) -> f64 {
        self.far_weight[i].min(self.carry)
    }

    /// Positions past the goals.
    fn interior(&self) -> Range<usize> {
        self.chain.num_goals()..self.chain.len()
    }
}

/// The change of x in a sweep.
#[derive(Clone, Copy, Debug, Default)]
struct Change {
    largest_step: f64,
    largest_entry: f64,
}

impl Change {
    fn note(&mut self, old: f64, new: f64) {
        self.largest_step = self.largest_step.max((new - old).abs());
        self.largest_entry = self.largest_entry.max(new.abs());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shaping::fixtures::{any_graph, chain, graph, grid, path};
    use crate::shaping::linearly_solvable::LinearlySolvableMdp;
    use faer::Mat;
    use faer::prelude::Solve;
    use proptest::prelude::*;

    const STEP: f64 = 1e-5;

    /// The walk at the solution for q, and that solution.
    fn solved<'c>(chain: &'c AbsorbingChain, q: &[f64]) -> (ControlledWalk<'c>, Vec<f64>) {
        let mut v = vec![0.0; chain.num_goals()];
        let statistics = LinearlySolvableMdp::new(chain).solve_cold(q, &mut v, 1e-12);
        assert!(statistics.residual < 1e-10, "{statistics:?}");
        let mut walk = ControlledWalk::new(chain);
        walk.update(&v, &mut v.clone());
        (walk, v)
    }

    /// x of (I − W) x = b or (I − Wᵀ) x = b by dense LU.
    fn dense(walk: &ControlledWalk<'_>, b: &[f64], transposed: bool) -> Vec<f64> {
        let (n, goals) = (b.len(), walk.chain().num_goals());
        let mut matrix = Mat::<f64>::identity(n, n);
        for i in goals..n {
            let (columns, weights) = walk.row(i);
            for (&j, w) in columns
                .iter()
                .zip(weights)
                .filter(|(j, _)| **j as usize >= goals)
            {
                let (row, column) = if transposed {
                    (j as usize, i)
                } else {
                    (i, j as usize)
                };
                matrix[(row, column)] -= w;
            }
        }
        let right = Mat::from_fn(n, 1, |i, _| if i < goals { 0.0 } else { b[i] });
        let x = matrix.partial_piv_lu().solve(&right);
        (0..n).map(|i| x[(i, 0)]).collect()
    }

    fn assert_solves(walk: &mut ControlledWalk<'_>, b: &[f64]) {
        for transposed in [false, true] {
            let mut x = vec![0.0; b.len()];
            if transposed {
                walk.solve_transposed(b, &mut x, 1e-14, 10_000);
            } else {
                walk.solve(b, &mut x, 1e-14, 10_000);
            }
            let expected = dense(walk, b, transposed);
            let largest = expected.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
            for (i, (x, expected)) in x.iter().zip(&expected).enumerate() {
                assert!(
                    (x - expected).abs() < 1e-9 * largest,
                    "{i}: {x} against {expected}"
                );
            }
        }
    }

    /// dℓ/dq for ℓ = Σ g_i v_i, against central differences.
    fn assert_gradient_is_right(chain: &AbsorbingChain, q: &[f64], g: &[f64]) {
        let mut lambda = vec![0.0; chain.len()];
        solved(chain, q)
            .0
            .solve_transposed(g, &mut lambda, 1e-14, 10_000);
        let largest = lambda.iter().fold(1e-3_f64, |m, l| m.max(l.abs()));
        for (i, found) in lambda.iter().enumerate().skip(chain.num_goals()) {
            let loss = |step: f64| -> f64 {
                let mut q = q.to_vec();
                q[i] += step;
                solved(chain, &q).1.iter().zip(g).map(|(v, g)| v * g).sum()
            };
            let expected = (loss(STEP) - loss(-STEP)) / (2.0 * STEP);
            let error = (found - expected).abs() / largest;
            assert!(error < 1e-6, "position {i}: {found} against {expected}");
        }
    }

    #[test]
    fn rows_sum_to_one() {
        let chain = chain(&grid(9, 9, &[]), &[40]);
        let (walk, _) = solved(&chain, &vec![0.7; chain.len()]);
        for i in 1..81 {
            assert!((walk.row(i).1.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn both_systems_agree_with_a_dense_solve() {
        let spider = graph(8, &[(0, 1), (1, 2), (1, 3), (1, 4), (1, 5), (1, 6), (6, 7)]);
        for adjacency in [grid(7, 6, &[9, 15]), path(40), spider] {
            let chain = chain(&adjacency, &[0]);
            let q: Vec<f64> = (0..chain.len())
                .map(|i| 0.05 + 0.2 * (i % 4) as f64)
                .collect();
            let b: Vec<f64> = (0..chain.len()).map(|i| (i % 3) as f64 - 0.7).collect();
            assert_solves(&mut solved(&chain, &q).0, &b);
        }
    }

    #[test]
    fn gradients_agree_with_finite_differences() {
        for adjacency in [grid(6, 5, &[7, 12]), path(30)] {
            let chain = chain(&adjacency, &[0]);
            let q: Vec<f64> = (0..chain.len())
                .map(|i| 0.2 + 0.2 * (i % 4) as f64)
                .collect();
            let g: Vec<f64> = (0..chain.len()).map(|i| (i % 3) as f64 - 0.7).collect();
            assert_gradient_is_right(&chain, &q, &g);
        }
    }

    /// What flows in at the far end must flow out at the goal; and the number of sweeps does not grow with the length.
    #[test]
    fn a_long_path_takes_few_sweeps() {
        let chain = chain(&path(5_000), &[0]);
        let (mut walk, _) = solved(&chain, &vec![0.7; chain.len()]);
        let mut b = vec![0.0; chain.len()];
        b[4_999] = 1.0;
        let mut x = vec![0.0; chain.len()];
        let sweeps = walk.solve_transposed(&b, &mut x, 1e-12, 100);
        assert!(sweeps < 30, "{sweeps} sweeps");
        let into_goal = walk.row(1).1[0];
        assert!(
            (x[1] * into_goal - 1.0).abs() < 1e-9,
            "{} · {into_goal}",
            x[1]
        );
        x.fill(0.0);
        assert!(walk.solve(&vec![1.0; 5_000], &mut x, 1e-12, 100) < 30);
    }

    #[test]
    fn a_warm_start_is_kept() {
        let chain = chain(&grid(20, 20, &[]), &[0]);
        let (mut walk, _) = solved(&chain, &vec![0.7; chain.len()]);
        let (b, mut x) = (vec![1.0; chain.len()], vec![0.0; chain.len()]);
        assert!(walk.solve(&b, &mut x, 1e-9, 1000) > 3);
        assert_eq!(walk.solve(&b, &mut x, 1e-8, 1000), 1);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn any_graph_agrees_with_a_dense_solve(
            adjacency in any_graph(),
            q in prop::collection::vec(0.02_f64..3.0, 24),
            b in prop::collection::vec(-1.0_f64..1.0, 24),
        ) {
            let chain = chain(&adjacency, &[0]);
            assert_solves(&mut solved(&chain, &q[..chain.len()]).0, &b[..chain.len()]);
        }

        #[test]
        fn any_graph_has_the_right_gradient(
            adjacency in any_graph(),
            q in prop::collection::vec(0.1_f64..3.0, 24),
            g in prop::collection::vec(-1.0_f64..1.0, 24),
        ) {
            let chain = chain(&adjacency, &[0]);
            assert_gradient_is_right(&chain, &q[..chain.len()], &g[..chain.len()]);
        }
    }
}
