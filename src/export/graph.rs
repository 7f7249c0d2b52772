//! The graph of a seed in the formats of graph programs.

use super::Format;
use super::source::NamedGraph;
use crate::graph::GraphAttributes;
use crate::graph::{dot::write_dot, graphml::write_graphml, matrix_market};
use std::io;

/// Writes the graph as DOT or Matrix Market if that is the format, else as GraphML.
///
/// # Errors
/// Those of `out`.
pub fn write_graph(out: &mut impl io::Write, named: &NamedGraph, format: Format) -> io::Result<()> {
    let attributes = GraphAttributes {
        names: Some(&named.names),
        potential: Some(&named.potential),
        action_names: named.action_names.as_deref(),
    };
    match format {
        Format::Dot => write_dot(out, &named.graph, &attributes),
        Format::MatrixMarket => matrix_market::write(out, named.graph.adjacency()),
        _ => write_graphml(out, &named.graph, &attributes),
    }
}
