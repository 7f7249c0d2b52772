//! What happened, as events for whoever keeps a log: `first_goal`, `goal_lost`, `graph_growth`, `spectrum_refresh` and `gcn_fit`.

use super::record::RefreshRecord;
use super::walker::Observed;
use crate::spectral::SpectrumRefresh;
use tracing::{debug, info, warn};

/// Tells of a step in which a goal was found or lost, with the number of steps so far and of states known.
#[inline]
pub fn observed(seen: &Observed, step: u64, nodes: usize) {
    if seen.first_goal {
        info!(name: "first_goal", step, nodes, "first_goal");
    }
    if seen.lost_goal {
        info!(name: "goal_lost", step, "goal_lost");
    }
}

/// Tells of a refresh.
pub fn refreshed(refresh: &RefreshRecord) {
    debug!(name: "graph_growth", step = refresh.step, nodes = refresh.nodes, edges = refresh.edges, "graph_growth");
    if let Some(spectrum) = &refresh.spectrum {
        spectrum_refreshed(refresh, spectrum);
    }
    if let Some(fit) = &refresh.fit {
        let loss = fit.fit.as_ref().map(|statistics| statistics.loss);
        let epochs = fit.fit.as_ref().map(|statistics| statistics.epochs);
        debug!(name: "gcn_fit", step = refresh.step, nodes = refresh.nodes, loss, epochs, elapsed_ms = refresh.fit_seconds * 1e3, "gcn_fit");
    }
}

fn spectrum_refreshed(refresh: &RefreshRecord, spectrum: &SpectrumRefresh) {
    let convergence = &spectrum.convergence;
    debug!(
        name: "spectrum_refresh",
        step = refresh.step,
        nodes = refresh.nodes,
        edges = refresh.edges,
        converged = convergence.converged,
        applications = convergence.applications,
        max_relative_residual = convergence.max_relative_residual,
        elapsed_ms = refresh.spectrum_seconds * 1e3,
        "spectrum_refresh"
    );
    if convergence.converged < spectrum.eigenvalues.len() {
        warn!(
            step = refresh.step,
            nodes = refresh.nodes,
            converged = convergence.converged,
            "some eigenpairs did not converge; the best found are used: raise spectral.tol or lower spectral.num_eigenpairs"
        );
    }
}
