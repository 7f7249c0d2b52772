//! Fitting a network to labels: T̂X once, then epochs of forward, loss, backward, step, from the present weights.

use super::rows::view;
use super::{
    Adam, ClassifierLoss, Gcn, GcnError, GcnParams, GcnWorkspace, LossWorkspace, Propagation,
};
use crate::graph::SymmetricCsr;
use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

/// Epochs and losses of a fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FitStatistics {
    /// Steps of the optimiser.
    pub epochs: usize,
    /// Loss of the weights that the fit began with.
    pub initial_loss: f64,
    /// Loss of the weights that it left.
    pub loss: f64,
}

/// Fits `gcn` to `labels` (node, class) under the [loss](ClassifierLoss) with λ = `params.smoothness`, for
/// `params.epochs` steps of `adam` at step size `params.learning_rate`, continuing from the present weights and moments.
///
/// `adjacency` is the graph that `propagation` was made from, `features` is X, n × [`Gcn::num_features`].
/// Returns the class probabilities of the final weights, n × classes, and what happened.
/// O(epochs · (n · features · hidden + nnz · classes)); epochs do not allocate.
///
/// # Errors
/// [`GcnError::Parameter`] if `params` are out of range, [`GcnError::NotFinite`] if weights or features are not finite to begin with,
/// [`GcnError::Diverged`] if the loss or the weights stop being so. The network and the optimiser are then as before the call.
///
/// # Panics
/// If shapes disagree, or a label names no node or no class.
pub fn fit_classifier(
    gcn: &mut Gcn,
    adam: &mut Adam,
    propagation: &Propagation,
    adjacency: &SymmetricCsr,
    features: MatRef<'_, f64>,
    labels: &[(u32, usize)],
    params: &GcnParams,
) -> Result<(Mat<f64>, FitStatistics), GcnError> {
    params.validate()?;
    assert_eq!(
        adjacency.num_nodes(),
        propagation.num_nodes(),
        "adjacency's rows"
    );
    assert_eq!(features.nrows(), propagation.num_nodes(), "features' rows");
    if !gcn.parameters().is_finite() {
        return Err(GcnError::NotFinite { what: "weights" });
    }
    let tx = propagation.apply_packed(features);
    if !tx.iter().all(|value| value.is_finite()) {
        return Err(GcnError::NotFinite { what: "features" });
    }
    let mut fit = Fit {
        propagation,
        tx: view(&tx, features.ncols()),
        loss: ClassifierLoss::new(adjacency, labels, params.smoothness),
        activations: GcnWorkspace::default(),
        evaluation: LossWorkspace::default(),
    };
    let before = (gcn.clone(), adam.clone());
    adam.learning_rate = params.learning_rate;
    let outcome = fit.run(gcn, adam, params.epochs);
    if outcome.is_err() {
        (*gcn, *adam) = before;
    }
    Ok((fit.evaluation.probabilities().to_owned(), outcome?))
}

/// One fit: what stays the same from epoch to epoch, and the buffers.
struct Fit<'a> {
    propagation: &'a Propagation,
    tx: MatRef<'a, f64>,
    loss: ClassifierLoss<'a>,
    activations: GcnWorkspace,
    evaluation: LossWorkspace,
}

impl Fit<'_> {
    fn run(
        &mut self,
        gcn: &mut Gcn,
        adam: &mut Adam,
        epochs: usize,
    ) -> Result<FitStatistics, GcnError> {
        let initial_loss = self.evaluate(gcn, 0)?;
        let mut statistics = FitStatistics {
            epochs,
            initial_loss,
            loss: initial_loss,
        };
        let mut gradient = gcn.parameters().zeros_like();
        for epoch in 1..=epochs {
            gcn.backward_packed(
                self.propagation,
                self.tx,
                &mut self.activations,
                self.evaluation.gradient_rows(),
                &mut gradient,
            );
            adam.step(gcn, &gradient);
            statistics.loss = self.evaluate(gcn, epoch)?;
        }
        Ok(statistics)
    }

    /// The loss after `epoch` steps; leaves what the next step needs in the buffers.
    fn evaluate(&mut self, gcn: &Gcn, epoch: usize) -> Result<f64, GcnError> {
        let logits = gcn.forward(self.propagation, self.tx, &mut self.activations);
        let loss = self.loss.evaluate(logits, &mut self.evaluation);
        // The weights are asked too: a silent hidden unit hides a weight of −∞ from the loss.
        if loss.is_finite() && gcn.parameters().is_finite() {
            return Ok(loss);
        }
        Err(GcnError::Diverged { epoch, loss })
    }
}
