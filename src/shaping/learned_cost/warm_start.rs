//! The warm start that one fit leaves to the next one, on a graph that has grown meanwhile.
//!
//! **v** is kept as v_i / d_i by state, which is nearly the same everywhere and changes little when states are found,
//! while v itself falls by as much as the whole way when a short cut is. A guess for states that were not there is left
//! to the solver.
//!
//! **z** is kept so that the network need not be asked while neither it nor its features have changed: new states take
//! the mean z of their older neighbours, as they would take the mean of their features.

use crate::graph::SymmetricCsr;
use crate::shaping::features::extended_features;
use crate::shaping::fit_context::FitContext;
use crate::shaping::grounded::{GroundedSolution, Guess};
use crate::shaping::shortest_path::ShortestPathProblem;
use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

/// Stands for what is not known: a guess of ∞. (JSON has no ∞.)
const UNKNOWN: f64 = f64::MAX;

/// The network is asked again when the graph has grown by this share since.
const STALE_GROWTH: f64 = 0.25;

/// The network's last output and the last solution.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct WarmStart {
    /// z by state.
    output: Vec<f64>,
    /// States, and a fingerprint of the features, when the network was asked.
    asked_at: (usize, u64),
    /// v ÷ cost-to-go, by state.
    ratios: Vec<f64>,
    /// κ of the solution.
    per_step: f64,
}

impl WarmStart {
    /// The warm start that a fit on `context` leaves; `earlier` is what it began with if the network was not asked.
    pub fn new(
        context: &FitContext<'_>,
        output: Vec<f64>,
        solution: &GroundedSolution,
        earlier: Option<&Self>,
    ) -> Self {
        let problem = context.problem;
        let goals = problem.chain.num_goals();
        let ratios = solution.v.iter().zip(&problem.distances).enumerate();
        let ratios: Vec<f64> = ratios
            .map(|(p, (v, d))| if p < goals { UNKNOWN } else { v / d })
            .collect();
        let now = (context.adjacency.num_nodes(), fingerprint(context.features));
        Self {
            output,
            asked_at: earlier.map_or(now, |earlier| earlier.asked_at),
            ratios: problem.chain.scatter(&ratios, UNKNOWN),
            per_step: solution.per_step,
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

    /// A guess of v on a problem of the same states and more.
    pub fn guess(&self, problem: &ShortestPathProblem) -> Guess {
        let places = problem.chain.order().iter().zip(&problem.distances);
        let known = |state: u32| self.ratios.get(state as usize).copied().unwrap_or(UNKNOWN);
        Guess {
            v: places.map(|(&state, d)| known(state) * d).collect(),
            per_step: self.per_step,
        }
    }
}

/// Equal features have equal fingerprints, others hardly ever. O(n k).
fn fingerprint(features: MatRef<'_, f64>) -> u64 {
    let mix = |sum: u64, bits: u64| (sum.rotate_left(5) ^ bits).wrapping_mul(0x517c_c1b7_2722_0a95);
    let values = features.col_iter().flat_map(|column| column.iter());
    values.fold(features.nrows() as u64, |sum, x| mix(sum, x.to_bits()))
}
