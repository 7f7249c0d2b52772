//! GraphML and DOT files, read back by parsers that know nothing of their writers.

use eigentrail::env::Action;
use eigentrail::graph::{
    GraphAttributes, StateId, TransitionGraph, dot::write_dot, graphml::write_graphml,
};
use proptest::prelude::*;

/// Checks that `xml` is well formed and returns (element, attributes, text before the next tag) in document order.
fn elements(xml: &str) -> Vec<(String, String, String)> {
    let body = xml
        .strip_prefix("<?xml version=\"1.0\" encoding=\"UTF-8\"?>")
        .expect("a declaration");
    let (mut open, mut found) = (Vec::new(), Vec::new());
    let mut pieces = body.split('<');
    assert!(pieces.next().is_some_and(|text| text.trim().is_empty()));
    for piece in pieces {
        let (tag, text) = piece.split_once('>').expect("a tag ends");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "tags nest");
            continue;
        }
        let (content, is_empty) = tag
            .strip_suffix('/')
            .map_or((tag, false), |content| (content, true));
        let (name, attributes) = content.split_once(' ').unwrap_or((content, ""));
        assert_eq!(attributes.matches('"').count() % 2, 0, "quotes pair up");
        if !is_empty {
            open.push(name);
        }
        found.push((name.to_owned(), attributes.to_owned(), unescape(text)));
    }
    assert_eq!(open, [""; 0], "all tags are closed");
    found
}

fn unescape(text: &str) -> String {
    let mut parts = text.split('&');
    let mut plain = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (entity, rest) = part.split_once(';').expect("an entity ends");
        let known = [
            ("lt", '<'),
            ("gt", '>'),
            ("amp", '&'),
            ("quot", '"'),
            ("apos", '\''),
            ("#13", '\r'),
        ];
        plain.push(
            known
                .iter()
                .find(|(name, _)| *name == entity)
                .expect("a known entity")
                .1,
        );
        plain.push_str(rest);
    }
    plain
}

/// n states in a ring with a bump at each, half of the edges terminal.
fn ring(n: u32) -> TransitionGraph {
    let mut graph = TransitionGraph::new(2);
    (0..n).for_each(|_| {
        graph.add_state();
    });
    for state in 0..n {
        graph.record(
            StateId(state),
            Action(0),
            -1.0,
            StateId((state + 1) % n),
            state % 2 == 0,
        );
        graph.record(StateId(state), Action(1), -0.5, StateId(state), false);
    }
    graph
}

proptest! {
    #[test]
    fn graphml_is_well_formed_and_names_survive(names in proptest::collection::vec("[ -~é<>&\"'\r\n]{0,12}", 1..6)) {
        let graph = ring(names.len() as u32);
        let actions = [names[0].clone(), "stay".to_owned()];
        let phi: Vec<f64> = (0..names.len()).map(|state| -(state as f64) / 3.0).collect();
        let mut bytes = Vec::new();
        write_graphml(&mut bytes, &graph, &GraphAttributes { names: Some(&names), potential: Some(&phi), action_names: Some(&actions) }).unwrap();
        let found = elements(std::str::from_utf8(&bytes).unwrap());
        let data = |key: &str| -> Vec<String> {
            let attribute = format!("key=\"{key}\"");
            found.iter().filter(|(name, attributes, _)| name == "data" && *attributes == attribute).map(|found| found.2.clone()).collect()
        };
        prop_assert_eq!(data("name"), names);
        prop_assert_eq!(data("phi").iter().map(|phi| phi.parse().unwrap()).collect::<Vec<f64>>(), phi);
        prop_assert_eq!(data("action").len(), graph.num_transitions());
        let of_action = data("action").iter().map(|number| actions[number.parse::<usize>().unwrap()].clone()).collect::<Vec<_>>();
        prop_assert_eq!(data("action_name"), of_action);
        prop_assert_eq!(data("mean_reward").iter().filter(|&mean| mean == "-0.5").count(), graph.num_states());
        let edges: Vec<&str> = found.iter().filter(|found| found.0 == "edge").map(|found| found.1.as_str()).collect();
        let first = format!("source=\"n0\" target=\"n{}\"", 1 % graph.num_states());
        prop_assert!(edges.contains(&first.as_str()));
    }

    #[test]
    fn quotes_in_dot_pair_up_whatever_the_names(names in proptest::collection::vec("[a-z\"\\\\\n]{0,8}", 1..6)) {
        let graph = ring(names.len() as u32);
        let actions = [names[0].clone(), "stay".to_owned()];
        let mut bytes = Vec::new();
        write_dot(&mut bytes, &graph, &GraphAttributes { names: Some(&names), potential: None, action_names: Some(&actions) }).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        // Between the braces: one line per node and per edge, each with one pair of quotes that are not escaped.
        let lines: Vec<&str> = text.lines().filter(|line| line.contains("label")).collect();
        prop_assert_eq!(lines.len(), graph.num_states() + graph.num_transitions());
        for line in lines {
            let (mut quotes, mut is_escaped) = (0, false);
            for character in line.chars() {
                quotes += usize::from(character == '"' && !is_escaped);
                is_escaped = character == '\\' && !is_escaped;
            }
            prop_assert_eq!(quotes, 2, "{}", line);
        }
    }
}

#[test]
#[should_panic(expected = "one potential for each of 3 states")]
fn attributes_of_the_wrong_length_panic() {
    let attributes = GraphAttributes {
        names: None,
        potential: Some(&[0.0]),
        action_names: None,
    };
    let _ = write_graphml(&mut Vec::new(), &ring(3), &attributes);
}
