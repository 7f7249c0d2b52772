//! The adjacency as plain values, checked when it is read back.

use super::Adjacency;
use crate::graph::GraphError;
use crate::graph::slack_rows::SlackRows;
use serde::{Deserialize, Serialize};

/// What is written down: compact rows, and the degrees as they were added up, so that a resumed run is bit-exact.
#[derive(Serialize, Deserialize)]
pub(super) struct Saved {
    row_lengths: Vec<u32>,
    columns: Vec<u32>,
    weights: Vec<f64>,
    degrees: Vec<f64>,
}

impl From<Adjacency> for Saved {
    fn from(adjacency: Adjacency) -> Self {
        let rows = || 0..adjacency.num_nodes() as u32;
        Saved {
            row_lengths: rows()
                .map(|row| adjacency.neighbors(row).len() as u32)
                .collect(),
            columns: rows()
                .flat_map(|row| adjacency.neighbors(row))
                .copied()
                .collect(),
            weights: rows()
                .flat_map(|row| adjacency.weights(row))
                .copied()
                .collect(),
            degrees: adjacency.degrees,
        }
    }
}

impl TryFrom<Saved> for Adjacency {
    type Error = GraphError;

    fn try_from(saved: Saved) -> Result<Self, GraphError> {
        let nodes = saved.row_lengths.len();
        let mut offsets = vec![0];
        offsets.extend(saved.row_lengths.iter().scan(0_usize, |end, &len| {
            *end = end.saturating_add(len as usize);
            Some(*end)
        }));
        let expect = |what, expected, found| {
            if expected == found {
                Ok(())
            } else {
                Err(GraphError::Damaged {
                    what,
                    expected,
                    found,
                })
            }
        };
        expect("columns", offsets[nodes], saved.columns.len())?;
        expect("weights", offsets[nodes], saved.weights.len())?;
        expect("degrees", nodes, saved.degrees.len())?;
        if let Some(&node) = saved
            .columns
            .iter()
            .find(|&&column| column as usize >= nodes)
        {
            return Err(GraphError::NodeOutOfRange { node, nodes });
        }
        let checked = Self::from_rows(SlackRows::from_sorted(
            &offsets,
            saved.columns,
            saved.weights,
        ))?;
        Ok(Self {
            degrees: saved.degrees,
            ..checked
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::triangle_with_tail;
    use super::*;

    #[test]
    fn saved_and_loaded_is_the_same_to_the_bit() {
        let mut graph = triangle_with_tail();
        for (u, v, weight) in [(4, 3, 0.1), (4, 2, 0.2), (4, 0, 0.3)] {
            graph.add_edge(u, v, weight);
        }
        let saved = serde_json::to_string(&graph).unwrap();
        let loaded: Adjacency = serde_json::from_str(&saved).unwrap();
        loaded.assert_consistent();
        assert_eq!(
            (loaded.to_csr(), loaded.degrees()),
            (graph.to_csr(), graph.degrees())
        );
        let damaged = saved.replacen("\"columns\":[1", "\"columns\":[7", 1);
        assert!(
            serde_json::from_str::<Adjacency>(&damaged)
                .unwrap_err()
                .to_string()
                .contains("node 7")
        );
    }
}
