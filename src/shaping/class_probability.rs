//! The source paper's own potential: φ_i = Φ(X)_{i, rewarding}, the probability of the rewarding class (eq. 5).
//!
//! The paper's Algorithm 1 reads column 0 of Φ, which its section 4.1 defines as *non*-rewarding; here it is the
//! rewarding class. Labels come from the agent's trajectories: the state that ended one is rewarding or not, the
//! start state is not. The rest of the graph is filled in by the smoothness loss (without it most nodes are free, and
//! learning fails).
//!
//! With `scale = "return"` the probability is shifted and scaled as every other potential. Even then few labels leave
//! **false local maxima**, some hundred on a large grid, and the goal need not have the largest φ: this potential is
//! here to be compared with. With `scale = "raw"` it is handed out as it comes from the softmax, in [0, 1], which is
//! the recipe as printed.

use super::features::extended_features;
use super::fit_context::{FitContext, GraphPotential};
use super::network::Network;
use super::params::ScaleMode;
use super::{PotentialFit, ShapingError};
use crate::gcn::{Gcn, GcnParams, Propagation, fit_classifier};
use crate::seeds::{Stream, stream};
use serde::{Deserialize, Serialize};

/// The class whose probability is φ.
const REWARDING: usize = 1;

/// The `report` potential. Weights and moments stay from fit to fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClassProbabilityPotential {
    /// Network and optimiser.
    pub gcn: GcnParams,
    /// Units of φ.
    pub scale: ScaleMode,
    /// Range of φ ÷ cost of the longest known way.
    pub scale_factor: f64,
    seed: u64,
    network: Option<Network>,
}

impl ClassProbabilityPotential {
    /// A potential with untrained weights drawn from `seed`.
    pub fn new(gcn: GcnParams, scale: ScaleMode, scale_factor: f64, seed: u64) -> Self {
        Self {
            gcn,
            scale,
            scale_factor,
            seed,
            network: None,
        }
    }

    fn untrained(&self, features: usize) -> Gcn {
        Gcn::new(
            features,
            self.gcn.hidden_dim,
            2,
            false,
            &mut stream(self.seed, Stream::Gcn),
        )
    }
}

impl GraphPotential for ClassProbabilityPotential {
    /// Without labels φ is 0.
    fn fit_in(&mut self, context: &FitContext<'_>) -> Result<PotentialFit, ShapingError> {
        if context.labels.is_empty() {
            return Ok(PotentialFit::flat(context.adjacency.num_nodes()));
        }
        let features = extended_features(context.features, context.adjacency);
        let untrained = self.untrained(features.ncols());
        let rate = self.gcn.learning_rate;
        let (network, _) = Network::prepare(&mut self.network, untrained, rate);
        let labels: Vec<(u32, usize)> = context
            .labels
            .iter()
            .map(|&(s, class)| (s.0, class))
            .collect();
        let (probabilities, statistics) = fit_classifier(
            &mut network.gcn,
            &mut network.adam,
            &Propagation::new(context.adjacency),
            context.adjacency,
            features.as_ref(),
            &labels,
            &self.gcn,
        )?;
        let rewarding: Vec<f64> = (0..probabilities.nrows())
            .map(|i| probabilities[(i, REWARDING)])
            .collect();
        let values = match self.scale {
            ScaleMode::Raw => rewarding,
            ScaleMode::Return => {
                let unlikely: Vec<f64> = rewarding.iter().map(|p| -p).collect();
                let chain = &context.problem.chain;
                context
                    .problem
                    .potential(&chain.gather(&unlikely), self.scale_factor)
            }
        };
        Ok(PotentialFit {
            fit: Some(statistics),
            ..PotentialFit::checked(values)?
        })
    }
}
