//! Features of states, for the graph network and if asked the agent: rows of a matrix X made from the visited graph.
//!
//! | source | a row is | moves when the graph grows |
//! |---|---|---|
//! | [`pvf`](crate::spectral::ProtoValueFunctions) | the state's entries of the lowest Laplacian eigenvectors | a little (aligned) |
//! | [`deepwalk`](DeepWalk) | the state's skip-gram vector over random walks (section 2.4 of the source paper) | a little (warm start) |
//! | [`random`](RandomFeatures) | normal numbers, drawn once when the state is found | never |
//! | `constant` | 1 | never |
//!
//! The last two are controls. A network that does as well on `random` or `constant` as on `pvf` has not used what the
//! features know of the graph. `constant` is no empty control, though: T̂ 1 holds the degrees around a state.
//!
//! [`FeatureSet`] keeps those sources up to date that are asked for.

mod deepwalk;
mod error;
mod random;
mod set;

pub use deepwalk::{DeepWalk, DeepWalkParams, EmbeddingRefresh};
pub use error::FeatureError;
pub use random::RandomFeatures;
pub use set::{FeatureRefresh, FeatureSet};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Source of a state's features.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FeatureSource {
    /// The lowest eigenvectors of the graph Laplacian: proto-value functions.
    #[default]
    Pvf,
    /// Skip-gram vectors over random walks (`[deepwalk]`).
    Deepwalk,
    /// Normal numbers, drawn once for each state, as many as there are eigenvectors: a control.
    Random,
    /// 1 for every state: a control.
    Constant,
}

impl FeatureSource {
    /// Every source, in the order of the documentation.
    pub const ALL: [FeatureSource; 4] = [
        FeatureSource::Pvf,
        FeatureSource::Deepwalk,
        FeatureSource::Random,
        FeatureSource::Constant,
    ];
}
