//! A GCN and its optimiser, kept from one fit to the next while the graph and its features grow.

use crate::gcn::{Adam, Gcn, GcnError};
use serde::{Deserialize, Serialize};

/// Weights and moments. Plain values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Saved")]
pub(crate) struct Network {
    pub gcn: Gcn,
    pub adam: Adam,
}

impl Network {
    /// Makes the network in `slot` take the features of `untrained`, and says whether it is a new one: it is
    /// `untrained` on first use, widened when features were added (a small graph has fewer eigenvectors than asked for),
    /// and `untrained` again when some were taken away, because it is then unknown which.
    pub fn prepare(
        slot: &mut Option<Network>,
        untrained: Gcn,
        learning_rate: f64,
    ) -> (&mut Network, bool) {
        let features = untrained.num_features();
        let fits = |n: &Network| {
            n.gcn.num_features() <= features && n.gcn.num_outputs() == untrained.num_outputs()
        };
        let kept = slot.take().filter(fits);
        let is_new = kept.is_none();
        let network = slot.insert(kept.unwrap_or_else(|| Network {
            adam: Adam::new(&untrained, learning_rate),
            gcn: untrained,
        }));
        if network.gcn.num_features() < features {
            network.gcn.grow_inputs(features);
            network.adam.grow_inputs(features);
        }
        (network, is_new)
    }
}

/// A network as it was written, before it is known to have the moments of its own weights.
#[derive(Deserialize)]
struct Saved {
    gcn: Gcn,
    adam: Adam,
}

impl TryFrom<Saved> for Network {
    type Error = GcnError;

    fn try_from(Saved { gcn, adam }: Saved) -> Result<Self, GcnError> {
        adam.check(&gcn)?;
        Ok(Self { gcn, adam })
    }
}
