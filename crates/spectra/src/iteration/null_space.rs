//! The null space of a Laplacian, known in closed form and so never computed.
//!
//! Each connected component C contributes D^1/2 1_C / ‖·‖ (normalised) or 1_C / √|C|. In postordered
//! elimination order a component is one stretch of rows, so that the projection off the null space,
//! x ← x − N Nᵀ x, costs two passes over the block however many components there are.

use crate::block::RowBlock;
use crate::block::simd::{self, Panel, PanelKernel};
use crate::cholesky::EliminationOrder;
use crate::{Laplacian, SymmetricOperator};
use faer::Mat;
use pulp::Simd;
use std::ops::Range;

/// Orthonormal null vectors with disjoint supports, in elimination order.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct NullSpace {
    /// Entry i of the null vector of i's component.
    #[cfg_attr(feature = "serde", serde(with = "crate::plain::numbers"))]
    entries: Vec<f64>,
    components: Vec<Range<usize>>,
    /// ‖D^1/2 1_C‖ (or √|C|) of each component.
    #[cfg_attr(feature = "serde", serde(with = "crate::plain::numbers"))]
    norms: Vec<f64>,
}

impl NullSpace {
    pub(crate) fn new(laplacian: &Laplacian<'_>, order: &EliminationOrder) -> Self {
        let mut entries: Vec<f64> = order
            .node
            .iter()
            .map(|&u| laplacian.scale(u as usize))
            .collect();
        // In order of discovery, so that the first null vectors stay the first ones.
        let mut components = order.components.clone();
        components.sort_by_cached_key(|c| order.node[c.clone()].iter().min().copied());
        let mut norms = Vec::with_capacity(components.len());
        for component in &components {
            let entries = &mut entries[component.clone()];
            let norm = norm(entries);
            entries.iter_mut().for_each(|e| *e /= norm);
            norms.push(norm);
        }
        debug_assert_eq!(entries.len(), laplacian.dim());
        Self {
            entries,
            components,
            norms,
        }
    }

    /// The factor between vectors and functions on nodes ([`Laplacian::scale`]), in elimination order.
    pub(crate) fn scales(&self) -> Vec<f64> {
        let mut scales = self.entries.clone();
        for (component, norm) in self.components.iter().zip(&self.norms) {
            scales[component.clone()]
                .iter_mut()
                .for_each(|s| *s *= norm);
        }
        scales
    }

    /// Which component each row belongs to.
    pub(crate) fn owners(&self) -> Vec<u32> {
        let mut owners = vec![0; self.entries.len()];
        for (c, component) in self.components.iter().enumerate() {
            owners[component.clone()].fill(c as u32);
        }
        owners
    }

    /// Entry of the null vector of each row's component.
    pub(crate) fn entries(&self) -> &[f64] {
        &self.entries
    }

    /// Number of connected components.
    pub(crate) fn dim(&self) -> usize {
        self.components.len()
    }

    /// Support of null vector `c` and its entries there.
    pub(crate) fn vector(&self, c: usize) -> (Range<usize>, &[f64]) {
        let support = self.components[c].clone();
        (support.clone(), &self.entries[support])
    }

    /// The first `count` null vectors as columns; `position` is the row of each node.
    pub(crate) fn vectors(&self, position: &[u32], count: usize) -> Mat<f64> {
        let owners = self.owners();
        let mut vectors = Mat::zeros(position.len(), count);
        for (u, &row) in position.iter().enumerate() {
            let owner = owners[row as usize] as usize;
            if owner < count {
                vectors[(u, owner)] = self.entries[row as usize];
            }
        }
        vectors
    }

    /// x ← x − N Nᵀ x.
    pub(crate) fn project_out(&self, x: &mut RowBlock, threads: usize) {
        let width = x.width();
        for c in 0..self.dim() {
            let (support, entries) = self.vector(c);
            let block = &mut x.as_mut_slice()[support.start * width..support.end * width];
            let shared: &[f64] = block;
            let partial = simd::map_stretches(entries.len(), threads, |rows| {
                let mut sums = vec![0.0; width];
                let entries = &entries[rows.clone()];
                let x = &shared[rows.start * width..rows.end * width];
                simd::for_each_panel(
                    width,
                    WeightedSum {
                        entries,
                        x,
                        sums: &mut sums,
                    },
                );
                sums
            });
            let coefficients = simd::add_up(partial, width);
            simd::for_each_stretch_mut(block, width, threads, |rows, x| {
                let entries = &entries[rows];
                let coefficients = &coefficients;
                simd::for_each_panel(
                    width,
                    SubtractOuter {
                        entries,
                        coefficients,
                        x,
                    },
                );
            });
        }
    }
}

#[cfg(feature = "serde")]
impl NullSpace {
    /// Whether it is one of a graph with the components of `order`.
    pub(crate) fn is_consistent(&self, order: &EliminationOrder) -> bool {
        let mut components = self.components.clone();
        components.sort_by_key(|c| c.start);
        self.entries.len() == order.node.len()
            && self.norms.len() == components.len()
            && components == order.components
    }
}

/// Summed by parts: a million equal terms added one to another would lose five digits.
fn norm(entries: &[f64]) -> f64 {
    let part = |part: &[f64]| part.iter().map(|e| e * e).sum::<f64>();
    entries.chunks(simd::STRETCH).map(part).sum::<f64>().sqrt()
}

/// sums += Σ_i entries_i x_i
struct WeightedSum<'a> {
    entries: &'a [f64],
    x: &'a [f64],
    sums: &'a mut [f64],
}

impl PanelKernel for WeightedSum<'_> {
    #[inline(always)]
    fn run<S: Simd, const NV: usize>(&mut self, simd: S, panel: Panel) {
        let x = S::as_simd_f64s(self.x).0;
        let sums = S::as_mut_simd_f64s(self.sums).0;
        let mut sum: [_; NV] = panel.load(&*sums, 0);
        for (i, &entry) in self.entries.iter().enumerate() {
            let entry = simd.splat_f64s(entry);
            let xi: [_; NV] = panel.load(x, i);
            for v in 0..NV {
                sum[v] = simd.mul_add_f64s(entry, xi[v], sum[v]);
            }
        }
        panel.store(sums, 0, sum);
    }
}

/// x_i ← x_i − entries_i coefficients
struct SubtractOuter<'a> {
    entries: &'a [f64],
    coefficients: &'a [f64],
    x: &'a mut [f64],
}

impl PanelKernel for SubtractOuter<'_> {
    #[inline(always)]
    fn run<S: Simd, const NV: usize>(&mut self, simd: S, panel: Panel) {
        let coefficients: [_; NV] = panel.load(S::as_simd_f64s(self.coefficients).0, 0);
        let x = S::as_mut_simd_f64s(self.x).0;
        for (i, &entry) in self.entries.iter().enumerate() {
            let entry = simd.splat_f64s(entry);
            let mut xi: [_; NV] = panel.load(&*x, i);
            for v in 0..NV {
                xi[v] = simd.negate_mul_add_f64s(entry, coefficients[v], xi[v]);
            }
            panel.store(x, i, xi);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cholesky::PermutedLaplacian;
    use crate::{LaplacianKind, testing};

    #[test]
    fn null_vectors_are_orthonormal_null_and_projected_out() {
        let parts = [testing::grid(50, 60), testing::path(1), testing::star(9)];
        let graph = testing::disjoint(&parts);
        for kind in [LaplacianKind::Normalized, LaplacianKind::Combinatorial] {
            let laplacian = Laplacian::new(&graph, kind);
            let order = EliminationOrder::new(&laplacian, None);
            let mut l = PermutedLaplacian::default();
            l.assign(&laplacian, &order, 1);
            let null = NullSpace::new(&laplacian, &order);
            assert_eq!(null.dim(), 3);

            let mut x = RowBlock::zeros(l.dim(), 8);
            for c in 0..3 {
                let (support, entries) = null.vector(c);
                assert!((norm(entries) - 1.0).abs() < 1e-14);
                for (i, &e) in support.zip(entries) {
                    x.row_mut(i)[c] = e;
                }
            }
            let residuals = l.squared_residuals(&x, &[0.0; 8], 1);
            assert!(residuals.iter().all(|&r| r < 1e-28));
            for threads in [1, 3] {
                let mut x = x.clone();
                null.project_out(&mut x, threads);
                assert!(x.as_slice().iter().all(|v| v.abs() < 1e-15));
            }
        }
    }
}
