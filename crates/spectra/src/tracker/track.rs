//! Following the spectrum of any growing graph: prefixes of a matrix in order of discovery.
//!
//! Row order is the order of discovery. The graph grows from min(64, n) nodes by a fixed share per
//! update until all n are there; while it has fewer than k nodes it has as many pairs as nodes.

use super::prefixes::prefix_sizes;
use crate::{
    Eigenpairs, GrowingEigensolver, LaplacianKind, Method, ParameterError, Route, SpectralError,
    SpectralParams, SymmetricCsr,
};
use std::time::Instant;

/// Parameters of following a growing graph.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackParams {
    /// Pairs to keep; 1 ≤ k ≤ n.
    pub k: usize,
    /// Share by which the graph grows per update, above 0; 0.05 is 5 %, at least one node.
    pub growth: f64,
    /// As [`SpectralParams::tol`].
    pub tol: f64,
    /// How each update finds its pairs.
    pub method: Method,
    /// Which Laplacian.
    pub laplacian: LaplacianKind,
    /// As [`SpectralParams::threads`]; a pool of this size is set up for the run.
    pub threads: usize,
    /// Seed of start blocks and guard columns.
    pub seed: u64,
    /// As [`SpectralParams::certify`].
    pub certify: bool,
    /// Nodes of the first update, at least 1.
    pub start_nodes: usize,
}

impl Default for TrackParams {
    fn default() -> Self {
        Self {
            k: 16,
            growth: 0.05,
            tol: 1e-2,
            method: Method::Warm,
            laplacian: LaplacianKind::Normalized,
            threads: 1,
            seed: 0,
            certify: false,
            start_nodes: 64,
        }
    }
}

/// One update, in the fields of the record.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct TrackUpdate {
    /// Nodes of the prefix.
    pub nodes: usize,
    /// Its undirected edges, loops included.
    pub edges: usize,
    /// Wall time of the update, without the building of the prefix.
    pub seconds: f64,
    /// Columns multiplied by L.
    pub applications: usize,
    /// Columns solved with a factor of L + σI.
    pub solves: usize,
    /// Largest residual norm ÷ λ_k.
    pub max_relative_residual: f64,
    /// Whether all min(k, nodes) pairs converged.
    pub converged: bool,
    /// Whether the search began without earlier vectors.
    pub cold_start: bool,
    /// min(k, nodes) lowest eigenvalues, ascending.
    pub eigenvalues: Vec<f64>,
    /// Whether k cuts a cluster of eigenvalues.
    pub cluster_cut: bool,
    /// How the pairs were found.
    pub route: Route,
    /// Whether the pairs are proven to be the lowest, none missed: see [`Convergence::certified`](crate::Convergence::certified).
    pub certified: bool,
    /// As [`Convergence::tolerance_floor`](crate::Convergence::tolerance_floor); absent where the tolerance asked for is within reach.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub tolerance_floor: Option<f64>,
    /// Pairs that the inertia count found missing and a further search added.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_zero"))]
    pub repaired: usize,
}

/// A whole run, in the fields of the record.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct TrackStatistics {
    /// Nodes of the whole graph.
    pub n: usize,
    /// Stored entries of its matrix.
    pub nnz: usize,
    /// Pairs asked for.
    pub k: usize,
    /// How each update found its pairs.
    pub method: Method,
    /// Threads in use.
    pub threads: usize,
    /// First to last.
    pub updates: Vec<TrackUpdate>,
    /// Sum of the updates' wall times.
    pub total_seconds: f64,
    /// Eigenvalues of the whole graph, ascending; none if it was interrupted.
    pub eigenvalues: Vec<f64>,
    /// Whether whoever listened to the updates ended it before the whole graph was there.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "std::ops::Not::not"))]
    pub interrupted: bool,
}

/// What [`track`] returns: the record, and the last pairs.
#[derive(Clone, Debug)]
pub struct TrackedSpectrum {
    /// Everything but the vectors.
    pub statistics: TrackStatistics,
    /// The pairs of the whole graph: vectors n × k.
    pub eigenpairs: Eigenpairs,
}

#[cfg(feature = "serde")]
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// Follows the spectrum of `graph` while it grows; calls `on_update` after each update.
///
/// # Errors
/// [`SpectralError::Parameter`] and [`SpectralError::TooManyPairs`] for parameters out of range; else as
/// [`GrowingEigensolver::refresh`].
///
/// # Panics
/// As [`GrowingEigensolver::refresh`].
pub fn track(
    graph: &SymmetricCsr,
    params: &TrackParams,
    mut on_update: impl FnMut(&TrackUpdate) + Send,
) -> Result<TrackedSpectrum, SpectralError> {
    params.validate(graph.num_nodes())?;
    if params.threads == 1 {
        return follow(graph, params, &mut on_update);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(params.threads);
    match pool.build() {
        Ok(pool) => pool.install(|| follow(graph, params, &mut on_update)),
        // The system refuses them: the result does not depend on how many there are.
        Err(_) => follow(graph, &params.alone(), &mut on_update),
    }
}

fn follow(
    graph: &SymmetricCsr,
    params: &TrackParams,
    on_update: &mut impl FnMut(&TrackUpdate),
) -> Result<TrackedSpectrum, SpectralError> {
    let mut solver = GrowingEigensolver::new(params.spectral(), params.seed);
    let mut updates = Vec::new();
    for nodes in prefix_sizes(graph.num_nodes(), params.start_nodes, params.growth) {
        let prefix = graph.leading_block(nodes);
        let start = Instant::now();
        let refresh = solver.refresh(&prefix)?;
        let seconds = start.elapsed().as_secs_f64();
        let facts = refresh.convergence;
        let update = TrackUpdate {
            nodes,
            edges: refresh.edges,
            seconds,
            applications: facts.applications,
            solves: facts.solves,
            max_relative_residual: facts.max_relative_residual,
            converged: facts.converged == refresh.eigenvalues.len(),
            cold_start: refresh.cold_start,
            eigenvalues: refresh.eigenvalues,
            cluster_cut: facts.cluster_cut,
            route: refresh.route,
            certified: facts.certified == Some(true),
            tolerance_floor: facts.tolerance_floor,
            repaired: facts.repaired,
        };
        on_update(&update);
        updates.push(update);
    }
    let eigenpairs = solver
        .into_eigenpairs()
        .expect("k ≥ 1 and k ≤ n, so that there was an update");
    Ok(TrackedSpectrum {
        statistics: TrackStatistics {
            n: graph.num_nodes(),
            nnz: graph.nnz(),
            k: params.k,
            method: params.method,
            threads: params.threads,
            total_seconds: updates.iter().map(|u| u.seconds).sum(),
            updates,
            eigenvalues: eigenpairs.values.clone(),
            interrupted: false,
        },
        eigenpairs,
    })
}

impl TrackParams {
    /// The same on one thread.
    fn alone(&self) -> Self {
        Self {
            threads: 1,
            ..self.clone()
        }
    }

    fn spectral(&self) -> SpectralParams {
        SpectralParams {
            num_eigenpairs: self.k,
            tol: self.tol,
            laplacian: self.laplacian,
            method: self.method,
            threads: self.threads,
            certify: self.certify,
            ..SpectralParams::default()
        }
    }

    fn validate(&self, n: usize) -> Result<(), SpectralError> {
        if self.k > n {
            return Err(SpectralError::TooManyPairs { k: self.k, n });
        }
        self.spectral().validate()?;
        let refuse = |name, value: String, rule| Err(ParameterError { name, value, rule }.into());
        if !(self.growth > 0.0 && self.growth.is_finite()) {
            return refuse("growth", self.growth.to_string(), "above 0");
        }
        if self.start_nodes == 0 {
            return refuse("start_nodes", self.start_nodes.to_string(), "at least 1");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn statistics_have_the_documented_fields() {
        let graph = testing::discovered(&testing::grid(10, 10), 1);
        let params = TrackParams {
            k: 70,
            ..Default::default()
        };
        let mut seen = 0;
        let tracked = track(&graph, &params, |_| seen += 1).unwrap();
        let json = serde_json::to_value(&tracked.statistics).unwrap();
        for field in [
            "n",
            "nnz",
            "k",
            "method",
            "threads",
            "updates",
            "total_seconds",
            "eigenvalues",
        ] {
            assert!(json.get(field).is_some(), "{field}");
        }
        assert_eq!(json["method"], "warm");
        let update = &json["updates"][0];
        for field in [
            "nodes",
            "edges",
            "seconds",
            "applications",
            "solves",
            "max_relative_residual",
            "converged",
            "cold_start",
            "eigenvalues",
            "route",
            "certified",
        ] {
            assert!(update.get(field).is_some(), "{field}");
        }
        assert_eq!(
            update["eigenvalues"].as_array().unwrap().len(),
            64,
            "fewer nodes than k"
        );
        assert_eq!(tracked.eigenpairs.vectors.ncols(), 70);
        assert_eq!(seen, tracked.statistics.updates.len());
    }

    #[test]
    fn bad_input_is_named() {
        let graph = testing::path(20);
        let with = |change: fn(&mut TrackParams)| {
            let mut params = TrackParams {
                k: 4,
                ..Default::default()
            };
            change(&mut params);
            track(&graph, &params, |_| ()).unwrap_err().to_string()
        };
        assert!(with(|p| p.k = 21).contains("k = 21"));
        assert!(with(|p| p.k = 0).contains("num_eigenpairs"));
        assert!(with(|p| p.growth = 0.0).contains("growth"));
        assert!(with(|p| p.tol = f64::NAN).contains("tol"));
        assert!(with(|p| p.start_nodes = 0).contains("start_nodes"));
        assert!(with(|p| p.threads = 0).contains("threads"));
    }
}
