//! Transitions as a [Graphviz](https://graphviz.org) DOT file, by petgraph's writer.

use super::export::{GraphAttributes, mean_reward};
use super::{StateId, TransitionGraph, TransitionStats};
use petgraph::dot::{Config, Dot};
use std::io;

/// Writes the digraph of tried transitions: nodes with name and φ, edges with the action's name (else `a` and its number),
/// count and mean reward, transitions that ended an episode in bold.
///
/// # Errors
/// Those of `out`.
///
/// # Panics
/// If `attributes` has not one value per state and one name per action.
pub fn write_dot(
    out: &mut impl io::Write,
    graph: &TransitionGraph,
    attributes: &GraphAttributes,
) -> io::Result<()> {
    attributes.check(graph);
    let config = [Config::NodeNoLabel, Config::EdgeNoLabel];
    let edge =
        |_, edge: petgraph::graph::EdgeReference<_>| edge_attributes(edge.weight(), attributes);
    let node = |_, (node, _): (petgraph::graph::NodeIndex, _)| {
        node_attributes(StateId(node.index() as u32), attributes)
    };
    write!(
        out,
        "{:?}",
        Dot::with_attr_getters(graph.digraph(), &config, &edge, &node)
    )
}

fn edge_attributes(stats: &TransitionStats, attributes: &GraphAttributes) -> String {
    let style = if stats.terminal { " style = bold" } else { "" };
    let action = attributes
        .action_name(stats.action)
        .map_or_else(|| format!("a{}", stats.action.0), escape);
    format!(
        "label = \"{action} ×{} r={}\"{style}",
        stats.count,
        mean_reward(stats)
    )
}

fn node_attributes(state: StateId, attributes: &GraphAttributes) -> String {
    let name = attributes
        .name(state)
        .map_or_else(|| state.0.to_string(), escape);
    match attributes.phi(state) {
        Some(phi) => format!("label = \"{name}\\nφ={phi}\" phi = \"{phi}\""),
        None => format!("label = \"{name}\""),
    }
}

/// A text between the quotes of a DOT string: a quote or a backslash in it stands for itself.
fn escape(text: &str) -> String {
    text.replace('\\', "\\\\")
        .replace('"', "\\\"")
        .replace('\n', "\\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Action;

    #[test]
    fn every_node_and_edge_is_written_with_its_label() {
        let mut graph = TransitionGraph::new(2);
        let [a, b] = std::array::from_fn(|_| graph.add_state());
        graph.record(a, Action(1), -1.0, b, true);
        graph.record(a, Action(1), -2.0, b, false);
        graph.record(b, Action(0), 0.0, b, false);
        let actions = ["stay".to_string(), "go \"on\"".to_string()];
        let names = ["say \"hi\"".to_string(), "C:\\tmp\nx".to_string()];
        let attributes = GraphAttributes {
            names: Some(&names),
            potential: Some(&[-1.5, 0.0]),
            action_names: Some(&actions),
        };
        let mut bytes = Vec::new();
        write_dot(&mut bytes, &graph, &attributes).unwrap();
        let lines: Vec<String> = String::from_utf8(bytes)
            .unwrap()
            .lines()
            .map(|line| line.trim().into())
            .collect();
        let strip = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
        let found: Vec<String> = lines.iter().map(|line| strip(line)).collect();
        assert_eq!(
            found,
            [
                "digraph {",
                r#"0 [ label = "say \"hi\"\nφ=-1.5" phi = "-1.5"]"#,
                r#"1 [ label = "C:\\tmp\nx\nφ=0" phi = "0"]"#,
                r#"0 -> 1 [ label = "go \"on\" ×2 r=-1.5" style = bold]"#,
                r#"1 -> 1 [ label = "stay ×1 r=0"]"#,
                "}"
            ]
        );
    }
}
