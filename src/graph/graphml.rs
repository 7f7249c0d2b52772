//! Transitions as [GraphML](http://graphml.graphdrawing.org), which Gephi, yEd, networkx and igraph read.

use super::export::{GraphAttributes, mean_reward};
use super::{StateId, TransitionGraph};
use petgraph::visit::EdgeRef;
use std::borrow::Cow;
use std::io;

const HEAD: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<graphml xmlns="http://graphml.graphdrawing.org/xmlns">
  <key id="name" for="node" attr.name="name" attr.type="string"/>
  <key id="phi" for="node" attr.name="phi" attr.type="double"/>
  <key id="action" for="edge" attr.name="action" attr.type="int"/>
  <key id="count" for="edge" attr.name="count" attr.type="long"/>
  <key id="mean_reward" for="edge" attr.name="mean_reward" attr.type="double"/>
  <key id="terminal" for="edge" attr.name="terminal" attr.type="boolean"/>
  <key id="action_name" for="edge" attr.name="action_name" attr.type="string"/>
  <graph id="transitions" edgedefault="directed">
"#;

/// Writes the digraph of tried transitions: nodes `n0, n1, …` with name and φ, edges with action, count, mean reward,
/// whether they ended an episode, and the action's name.
///
/// # Errors
/// Those of `out`; give it a buffer.
///
/// # Panics
/// If `attributes` has not one value per state and one name per action.
pub fn write_graphml(
    out: &mut impl io::Write,
    graph: &TransitionGraph,
    attributes: &GraphAttributes,
) -> io::Result<()> {
    attributes.check(graph);
    out.write_all(HEAD.as_bytes())?;
    for state in (0..graph.num_states() as u32).map(StateId) {
        write!(out, "    <node id=\"n{}\">", state.0)?;
        if let Some(name) = attributes.name(state) {
            write!(out, "<data key=\"name\">{}</data>", escape(name))?;
        }
        if let Some(phi) = attributes.phi(state) {
            write!(out, "<data key=\"phi\">{}</data>", double(phi))?;
        }
        writeln!(out, "</node>")?;
    }
    for edge in graph.digraph().edge_references() {
        let stats = edge.weight();
        write!(
            out,
            "    <edge source=\"n{}\" target=\"n{}\">",
            edge.source().index(),
            edge.target().index()
        )?;
        write!(
            out,
            "<data key=\"action\">{}</data><data key=\"count\">{}</data>",
            stats.action.0, stats.count
        )?;
        write!(
            out,
            "<data key=\"mean_reward\">{}</data>",
            double(mean_reward(stats))
        )?;
        write!(out, "<data key=\"terminal\">{}</data>", stats.terminal)?;
        if let Some(name) = attributes.action_name(stats.action) {
            write!(out, "<data key=\"action_name\">{}</data>", escape(name))?;
        }
        writeln!(out, "</edge>")?;
    }
    out.write_all(b"  </graph>\n</graphml>\n")
}

/// A number as XML Schema writes it.
fn double(value: f64) -> Cow<'static, str> {
    match value {
        f64::INFINITY => "INF".into(),
        f64::NEG_INFINITY => "-INF".into(),
        finite_or_nan => finite_or_nan.to_string().into(),
    }
}

/// Text between two tags. XML 1.0 has no way to write most control characters: they become U+FFFD.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&apos;"),
            '\r' => escaped.push_str("&#13;"),
            '\t' | '\n' => escaped.push(character),
            '\0'..'\u{20}' | '\u{FFFE}' | '\u{FFFF}' => escaped.push(char::REPLACEMENT_CHARACTER),
            _ => escaped.push(character),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_in_names_is_escaped() {
        assert_eq!(
            escape("a<b & \"c\">'d'\u{1}é\n"),
            "a&lt;b &amp; &quot;c&quot;&gt;&apos;d&apos;\u{FFFD}é\n"
        );
    }

    #[test]
    fn numbers_are_those_of_xml_schema() {
        assert_eq!(
            [f64::INFINITY, f64::NEG_INFINITY, f64::NAN, -0.5].map(double),
            ["INF", "-INF", "NaN", "-0.5"]
        );
    }
}
