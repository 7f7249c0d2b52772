//! How much memory a run will take, roughly.

use crate::scenario::Scenario;

/// Bytes that a run in a world of `states` reachable states needs at its end, to within a factor of about two.
///
/// Counted by state: number and name, a directed edge with its counts for each action, two tables of the agent, the
/// undirected rows, eigenvectors (old, new, features, work), activations of the network; the fill of the sparse
/// factor is taken as 40 entries a state, what planar graphs of 1e5 nodes have.
pub fn estimated_bytes(scenario: &Scenario, states: usize, actions: usize) -> u64 {
    const NAME: usize = 48;
    const TRANSITION: usize = 56;
    const UNDIRECTED: usize = 16;
    const FACTOR: usize = 40 * 12;
    let columns = scenario.spectral.num_eigenpairs + 8; // with guards
    let spectral = 4 * columns * 8 + FACTOR;
    let network = 3 * scenario.gcn.hidden_dim * 8;
    let by_state = NAME + actions * (TRANSITION + UNDIRECTED + 2 * 8) + spectral + network;
    (states as u64).saturating_mul(by_state as u64)
}
