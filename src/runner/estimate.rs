//! Estimate of the memory that a run will take, and whether there is so much.
//!
//! In floating point, so that no number in a scenario can make it overflow.

use super::error::RunnerError;
use crate::agent::{AgentKind, FeatureKind};
use crate::features::FeatureSource;
use crate::memory;
use crate::scenario::{Scenario, World};
use crate::shaping::PotentialKind;
use crate::spectral::Method;

/// Bytes that a run in a world of `states` reachable states needs at its end, to within a factor of about two.
///
/// Counted by state: number and name, a directed edge with its counts for each action, two tables of the agent, the
/// undirected rows, eigenvectors, random walks' vectors and activations of the network as far as they are used. By
/// episode: its length, and its return in a comparison.
pub fn estimated_bytes(scenario: &Scenario, states: usize, actions: usize) -> u64 {
    const NAME: f64 = 48.0;
    const TRANSITION: f64 = 56.0;
    const UNDIRECTED: f64 = 16.0;
    const EPISODE: f64 = 8.0;
    let learnt = matches!(
        scenario.shaping.potential,
        PotentialKind::Gcn | PotentialKind::Report
    );
    let actor_critic = scenario.agent.kind == AgentKind::ActorCritic;
    let walks = learnt && scenario.gcn.features == FeatureSource::Deepwalk
        || actor_critic && scenario.agent.features == FeatureKind::Deepwalk;
    let network = if learnt { 3 * 8 } else { 0 } as f64 * scenario.gcn.hidden_dim as f64;
    let vectors = if walks { 4 * 8 } else { 0 } as f64 * scenario.deepwalk.dimensions as f64;
    let by_action = actions as f64 * (TRANSITION + UNDIRECTED + 2.0 * 8.0);
    let by_state = NAME + by_action + network + vectors;
    let pairs = scenario.spectral.num_eigenpairs;
    let spectrum = spectrum_bytes(states, pairs, scenario.spectral.method);
    // A cast from floating point saturates.
    (states as f64 * by_state + spectrum + scenario.run.episodes as f64 * EPISODE) as u64
}

/// Bytes that `pairs` eigenpairs of a graph of `nodes` take while they are looked for: old, new, features and work; and
/// the sparse factor with 40 entries a node, what planar graphs of 1e5 nodes have, or the dense matrix.
fn spectrum_bytes(nodes: usize, pairs: usize, method: Method) -> f64 {
    const FACTOR: f64 = 40.0 * 12.0;
    let (nodes, columns) = (nodes as f64, pairs.min(nodes) as f64 + 8.0); // with guards
    let matrix = match method {
        Method::Full => 3.0 * nodes * 8.0,
        Method::Warm | Method::Cold => FACTOR,
    };
    nodes * (4.0 * columns * 8.0 + matrix)
}

/// Refuses a run in `world`, `at_once` of them side by side, that cannot fit into this machine whatever the estimate
/// is wrong by.
///
/// # Errors
/// [`RunnerError::TooMuchMemory`].
pub fn require_memory(
    scenario: &Scenario,
    world: &World,
    at_once: usize,
) -> Result<(), RunnerError> {
    let states = match world {
        World::Grid(map) => map.layout().num_free(),
        World::Listed(_, names) => names.states.len(),
    };
    let one = estimated_bytes(scenario, states, world.num_actions());
    let what = match at_once {
        0 | 1 => "the run".to_owned(),
        several => format!("{several} runs side by side"),
    };
    let advice = "take a smaller world, fewer episodes, or smaller spectral.num_eigenpairs, gcn.hidden_dim or \
                  deepwalk.dimensions";
    fits(what, one.saturating_mul(at_once.max(1) as u64), advice)
}

/// Refuses `pairs` eigenpairs of a graph of `nodes` that cannot fit into this machine.
///
/// # Errors
/// [`RunnerError::TooMuchMemory`].
pub fn require_spectrum_memory(
    nodes: usize,
    pairs: usize,
    method: Method,
) -> Result<(), RunnerError> {
    let what = format!("{pairs} eigenpairs of {nodes} nodes");
    let advice = match method {
        Method::Full => "the full method keeps dense matrices: take another one",
        Method::Warm | Method::Cold => "ask for fewer pairs",
    };
    fits(what, spectrum_bytes(nodes, pairs, method) as u64, advice)
}

/// The estimate may be twice too large.
const SLACK: u64 = 2;

fn fits(what: String, needed: u64, advice: &'static str) -> Result<(), RunnerError> {
    let there_is = memory::total();
    if needed / SLACK <= there_is {
        return Ok(());
    }
    Err(RunnerError::TooMuchMemory {
        what,
        needed,
        there_is,
        advice,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn scenario(text: &str) -> Scenario {
        let loaded = Scenario::parse(Path::new("x.toml"), text.to_owned(), &[]);
        loaded.unwrap().scenario
    }

    #[test]
    fn the_largest_numbers_do_not_overflow() {
        let mut params = scenario("");
        params.spectral.num_eigenpairs = usize::MAX;
        params.gcn.hidden_dim = usize::MAX;
        params.run.episodes = usize::MAX;
        assert_eq!(estimated_bytes(&params, usize::MAX, usize::MAX), u64::MAX);
        // No more pairs than states: 225 states with 4 actions and a few episodes are less than a hundred megabytes.
        params.gcn.hidden_dim = 16;
        params.run.episodes = 10;
        assert!(estimated_bytes(&params, 225, 4) < 100_000_000);
    }

    #[test]
    fn what_is_not_used_is_not_counted() {
        let with = |text: &str| estimated_bytes(&scenario(text), 1000, 4);
        let plain = with("");
        assert_eq!(with("[deepwalk]\ndimensions = 4096\n"), plain);
        let walks = "[deepwalk]\ndimensions = 4096\n[gcn]\nfeatures = \"deepwalk\"\n";
        // At least the vectors themselves, twice.
        assert!(with(walks) >= plain + 2 * 4096 * 8 * 1000);
        assert!(with("[shaping]\npotential = \"none\"\n") < plain);
    }

    #[test]
    fn what_cannot_fit_is_refused_in_words() {
        let small = scenario("");
        let world = small.world(0).unwrap();
        assert!(require_memory(&small, &world, 2).is_ok());
        let error = require_memory(&small, &world, usize::MAX).unwrap_err();
        assert!(matches!(error, RunnerError::TooMuchMemory { .. }));
        let message = error.to_string();
        assert!(message.contains("this machine has"), "{message}");
        // 24 bytes n² for 10⁹ nodes are 24 exabytes.
        assert!(require_spectrum_memory(1_000_000_000, 1, Method::Full).is_err());
        assert!(require_spectrum_memory(1_000, 1_000, Method::Full).is_ok());
    }
}
