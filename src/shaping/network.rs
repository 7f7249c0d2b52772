//! A GCN and its optimiser, kept from one fit to the next while the graph and its features grow.

use crate::gcn::{Adam, Gcn};
use serde::{Deserialize, Serialize};

/// Weights and moments. Plain values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Network {
    pub gcn: Gcn,
    pub adam: Adam,
}

impl Network {
    /// Makes the network in `slot` take `features` columns, and says whether it is a new one: it is made on first
    /// use, widened when features were added (a small graph has fewer eigenvectors than asked for), and made anew
    /// when some were taken away, because it is then unknown which.
    pub fn prepare(
        slot: &mut Option<Network>,
        features: usize,
        learning_rate: f64,
        make: impl FnOnce() -> Gcn,
    ) -> (&mut Network, bool) {
        let keeps = slot
            .as_ref()
            .is_some_and(|n| n.gcn.num_features() <= features);
        if !keeps {
            let gcn = make();
            let adam = Adam::new(&gcn, learning_rate);
            *slot = Some(Network { gcn, adam });
        }
        let network = slot.as_mut().expect("made above");
        if network.gcn.num_features() < features {
            network.gcn.grow_inputs(features);
            network.adam.grow_inputs(features);
        }
        (network, !keeps)
    }
}
