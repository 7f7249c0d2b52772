//! Proto-value functions: eigenvectors as features that keep their meaning while the graph grows.
//!
//! A learner that keeps its weights needs features that move little from one refresh to the next.
//! The new eigenvectors V are therefore turned by the orthogonal Procrustes solution Q of
//! min ‖V Q − B‖_F, B the features of the refresh before on the nodes it had; V Q spans the same
//! space. Scaled by √n the entries are of order 1 whatever the size of the graph.

use super::{
    Eigenpairs, GrowingEigensolver, SpectralError, SpectralParams, SpectrumRefresh, SymmetricCsr,
    procrustes, with_fixed_signs,
};
use crate::vector_state::clear_upper_halves;
use faer::{Mat, MatRef, Scale};
use serde::{Deserialize, Serialize};

/// The features of a growing graph: lowest eigenvectors, aligned from one refresh to the next. A plain value.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ProtoValueFunctions {
    spectrum: GrowingEigensolver,
    /// √n V Q.
    #[serde(with = "super::plain::maybe_matrix")]
    features: Option<Mat<f64>>,
}

impl ProtoValueFunctions {
    /// Nothing yet. `params` are checked by the first [`refresh`](Self::refresh).
    pub fn new(params: SpectralParams, seed: u64) -> Self {
        Self {
            spectrum: GrowingEigensolver::new(params, seed),
            features: None,
        }
    }

    /// Brings the pairs up to date with a graph that has grown since the last call (rows only
    /// appended). Keeps min(k, n) pairs. On not converging keeps the best found and says so.
    ///
    /// # Errors
    /// As [`GrowingEigensolver::refresh`]; the features of the last refresh are then still there.
    ///
    /// # Panics
    /// As [`GrowingEigensolver::refresh`].
    pub fn refresh(&mut self, adjacency: &SymmetricCsr) -> Result<SpectrumRefresh, SpectralError> {
        let refresh = self.spectrum.refresh(adjacency)?;
        self.spectrum.release_buffers(); // the graph will have outgrown them
        let vectors = &self
            .eigenpairs()
            .expect("a refresh has just succeeded")
            .vectors;
        let turned = match &self.features {
            Some(last) if continues(vectors, last) => {
                vectors * procrustes(vectors.as_ref(), last.as_ref())?
            }
            _ => with_fixed_signs(vectors.as_ref()),
        };
        self.features = Some(Scale((refresh.nodes as f64).sqrt()) * turned);
        clear_upper_halves();
        Ok(refresh)
    }

    /// The current features, n × k: an orthogonal basis of the k-space, each column of norm √n,
    /// aligned to the features of the refresh before and so *not* in eigenvalue order. None before
    /// the first refresh.
    pub fn features(&self) -> Option<MatRef<'_, f64>> {
        self.features.as_ref().map(Mat::as_ref)
    }

    /// The true eigenpairs, ascending, before alignment. None before the first refresh.
    pub fn eigenpairs(&self) -> Option<&Eigenpairs> {
        self.spectrum.eigenpairs()
    }
}

/// Whether `last` can be features of an earlier state of the same graph.
fn continues(vectors: &Mat<f64>, last: &Mat<f64>) -> bool {
    last.nrows() <= vectors.nrows() && last.ncols() <= vectors.ncols()
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentrail_testing::graphs;

    fn checked(graph: graphs::Csr) -> SymmetricCsr {
        SymmetricCsr::new(graph).unwrap()
    }

    fn params(k: usize) -> SpectralParams {
        SpectralParams {
            num_eigenpairs: k,
            tol: 1e-3,
            ..Default::default()
        }
    }

    #[test]
    fn features_span_the_eigenspace_with_columns_of_norm_sqrt_n() {
        let whole = checked(graphs::discovered(&graphs::grid(21, 20), 1));
        let mut pvf = ProtoValueFunctions::new(params(6), 0);
        assert!(pvf.features().is_none() && pvf.eigenpairs().is_none());
        for n in [0, 1, 3, 10, 200, 380, 420] {
            pvf.refresh(&whole.leading_block(n)).unwrap();
            let k = 6.min(n);
            let features = pvf.features().unwrap();
            assert_eq!((features.nrows(), features.ncols()), (n, k));
            let gram =
                features.transpose() * features - Scale(n as f64) * Mat::<f64>::identity(k, k);
            assert!(gram.norm_max() <= 1e-9 * n as f64);
            let vectors = &pvf.eigenpairs().unwrap().vectors;
            let outside = features - vectors * (vectors.transpose() * features);
            assert!(outside.norm_max() < 1e-9);
        }
    }

    #[test]
    fn features_hardly_move_when_the_graph_hardly_grows() {
        // λ_7 and λ_8 of a 23 × 20 grid are well apart, so that the 7-space moves little; within it
        // raw eigenvectors would swap and change sign.
        let whole = checked(graphs::grid(23, 20));
        let mut pvf = ProtoValueFunctions::new(params(7), 0);
        pvf.refresh(&whole.leading_block(440)).unwrap();
        for n in (441..=460).step_by(1) {
            let before = pvf.features().unwrap().to_owned();
            pvf.refresh(&whole.leading_block(n)).unwrap();
            let after = pvf.features().unwrap().subrows(0, before.nrows());
            let moved = (after - &before).norm_l2() / before.norm_l2();
            assert!(moved < 0.1, "n = {n}: moved by {moved}");
        }
    }

    #[test]
    fn an_error_leaves_the_last_features_in_place() {
        let mut pvf = ProtoValueFunctions::new(params(4), 0);
        pvf.refresh(&checked(graphs::path(10))).unwrap();
        let bad = SymmetricCsr::new(graphs::from_weighted_edges(11, &[(0, 1, f64::NAN)]));
        assert!(bad.and_then(|bad| pvf.refresh(&bad)).is_err());
        assert_eq!(pvf.features().unwrap().nrows(), 10);
    }
}
