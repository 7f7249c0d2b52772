//! The warm start that one fit leaves to the next one, on a world that has grown meanwhile.
//!
//! z is kept so that the network need not be asked while neither it nor its features have changed: new states take
//! the mean z of their older neighbours, as they would take the mean of their features. V is not: where the model has turned out worse than believed,
//! states that vouch for each other would fall by a step a sweep, and label setting begins near enough.

use crate::graph::SymmetricCsr;
use crate::shaping::features::extended_features;
use crate::shaping::return_context::ReturnContext;
use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

/// The network is asked again when the graph has grown by this share since.
const STALE_GROWTH: f64 = 0.25;

/// The network's last output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct WarmStart {
    /// z by state.
    output: Vec<f64>,
    /// States, and a fingerprint of the features, when the network was asked.
    asked_at: (usize, u64),
}

impl WarmStart {
    /// The warm start that a fit on `context` leaves; `earlier` is what it began with if the network was not asked.
    pub fn new(context: &ReturnContext<'_>, output: Vec<f64>, earlier: Option<&Self>) -> Self {
        let now = (context.adjacency.num_nodes(), fingerprint(context.features));
        Self {
            output,
            asked_at: earlier.map_or(now, |earlier| earlier.asked_at),
        }
    }

    /// The network's output (n × 1), as far as one can tell without asking it; none if its features are new, or the
    /// graph has outgrown what it was asked about.
    pub fn output(&self, adjacency: &SymmetricCsr, features: MatRef<'_, f64>) -> Option<Mat<f64>> {
        let (nodes, of_features) = self.asked_at;
        let known = self.output.len()..=((1.0 + STALE_GROWTH) * nodes as f64) as usize;
        let holds = known.contains(&adjacency.num_nodes()) && fingerprint(features) == of_features;
        holds.then(|| {
            let known = MatRef::from_column_major_slice(&self.output, self.output.len(), 1);
            extended_features(known, adjacency)
        })
    }
}

/// Equal features have equal fingerprints, others hardly ever. O(n k).
fn fingerprint(features: MatRef<'_, f64>) -> u64 {
    let mix = |sum: u64, bits: u64| (sum.rotate_left(5) ^ bits).wrapping_mul(0x517c_c1b7_2722_0a95);
    let values = features.col_iter().flat_map(|column| column.iter());
    values.fold(features.nrows() as u64, |sum, x| mix(sum, x.to_bits()))
}
