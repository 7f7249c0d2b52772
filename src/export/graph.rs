//! The graph of a seed in the formats of graph programs.

use super::Format;
use super::source::NamedGraph;
use crate::graph::NodeAttributes;
use crate::graph::{dot::write_dot, graphml::write_graphml};
use std::io;

/// Writes the graph as DOT if that is the format, else as GraphML.
///
/// # Errors
/// Those of `out`.
pub fn write_graph(out: &mut impl io::Write, named: &NamedGraph, format: Format) -> io::Result<()> {
    let attributes = NodeAttributes {
        names: Some(&named.names),
        potential: Some(&named.potential),
    };
    match format {
        Format::Dot => write_dot(out, &named.graph, &attributes),
        _ => write_graphml(out, &named.graph, &attributes),
    }
}
