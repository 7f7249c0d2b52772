//! The graph at the end of a run as tables: `graph.csv` and `policy.csv`.
//!
//! | file | a row for each |
//! |---|---|
//! | `graph.csv` | (state, action, next state) that was seen: how often, Σ r, whether it ended an episode |
//! | `policy.csv` | state: how often it was left, and the likeliest action there, with the advice of φ but not of a search (empty if none) |

use super::error::RunnerError;
use super::files::write_atomically;
use crate::agent::Agent;
use crate::env::Action;
use crate::graph::{StateId, TransitionGraph};
use petgraph::visit::EdgeRef;
use serde::Deserialize;
use std::io::Write;
use std::path::Path;

/// A row of `graph.csv`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct GraphRow {
    /// State number.
    pub from: u32,
    /// Action number.
    pub action: u16,
    /// State number.
    pub to: u32,
    /// How often it was seen.
    pub count: u32,
    /// Σ r over those times.
    pub reward_sum: f64,
    /// Whether an episode ended on arrival.
    pub terminal: bool,
}

/// A row of `policy.csv`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct PolicyRow {
    /// State number.
    pub state: u32,
    /// How often an action was taken here.
    pub visits: u64,
    /// The likeliest action while nothing is searched for; none where the agent has no opinion.
    pub greedy: Option<u16>,
}

/// Writes both tables into the seed's `folder`. `advice`: n × actions, row-major.
///
/// # Errors
/// If they cannot be written.
///
/// # Panics
/// If `advice` does not have a number for each state and action.
pub fn write_graph_files(
    folder: &Path,
    graph: &TransitionGraph,
    agent: &impl Agent,
    advice: &[f64],
) -> Result<(), RunnerError> {
    let path = folder.join("graph.csv");
    write_atomically(&path, |file| {
        writeln!(file, "from,action,to,count,reward_sum,terminal")?;
        for row in graph_rows(graph) {
            let (from, action, to, count) = (row.from, row.action, row.to, row.count);
            let (sum, terminal) = (row.reward_sum, row.terminal);
            writeln!(file, "{from},{action},{to},{count},{sum},{terminal}")?;
        }
        Ok(())
    })
    .map_err(RunnerError::write(&path))?;
    let path = folder.join("policy.csv");
    write_atomically(&path, |file| {
        writeln!(file, "state,visits,greedy")?;
        for row in policy_rows(graph, agent, advice) {
            match row.greedy {
                Some(action) => writeln!(file, "{},{},{action}", row.state, row.visits)?,
                None => writeln!(file, "{},{},", row.state, row.visits)?,
            }
        }
        Ok(())
    })
    .map_err(RunnerError::write(&path))
}

/// The rows of `graph.csv`, in the order in which the transitions were first seen.
pub(super) fn graph_rows(graph: &TransitionGraph) -> impl Iterator<Item = GraphRow> {
    let digraph = graph.digraph();
    digraph.edge_references().map(|edge| {
        let stats = edge.weight();
        GraphRow {
            from: edge.source().index() as u32,
            action: stats.action.0,
            to: edge.target().index() as u32,
            count: stats.count,
            reward_sum: stats.reward_sum,
            terminal: stats.terminal,
        }
    })
}

/// The rows of `policy.csv`, by state.
pub(super) fn policy_rows(
    graph: &TransitionGraph,
    agent: &impl Agent,
    advice: &[f64],
) -> impl Iterator<Item = PolicyRow> {
    assert_eq!(advice.len(), graph.num_states() * graph.num_actions());
    let advice = advice.chunks_exact(graph.num_actions());
    (0..graph.num_states() as u32)
        .zip(advice)
        .map(|(state, advice)| {
            let actions = (0..graph.num_actions()).map(|a| Action(a as u16));
            let tries = actions.map(|action| u64::from(graph.tries(StateId(state), action)));
            PolicyRow {
                state,
                visits: tries.sum(),
                greedy: agent
                    .greedy_action(StateId(state), advice)
                    .map(|action| action.0),
            }
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::agent::{AgentParams, build_agent};

    #[test]
    fn every_transition_and_state_has_a_row() {
        let mut graph = TransitionGraph::new(2);
        let (a, b) = (graph.add_state(), graph.add_state());
        graph.record(a, Action(1), -1.0, b, true);
        graph.record(a, Action(1), -1.0, b, true);
        graph.record(a, Action(0), -0.5, a, false);
        let agent = build_agent(&AgentParams::default(), 2, 1.0, 0);
        let folder = tempfile::tempdir().unwrap();
        write_graph_files(folder.path(), &graph, &agent, &[0.0; 4]).unwrap();
        let text = std::fs::read_to_string(folder.path().join("graph.csv")).unwrap();
        assert_eq!(
            text,
            "from,action,to,count,reward_sum,terminal\n0,1,1,2,-2,true\n0,0,0,1,-0.5,false\n"
        );
        let mut rows = csv::Reader::from_path(folder.path().join("policy.csv")).unwrap();
        let rows: Vec<PolicyRow> = rows.deserialize().map(Result::unwrap).collect();
        let visits: Vec<u64> = rows.iter().map(|row| row.visits).collect();
        assert_eq!(visits, [3, 0]);
    }
}
