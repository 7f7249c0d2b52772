//! The graph at the end of a run as tables: `graph.csv` and `policy.csv`.
//!
//! | file | a row for each |
//! |---|---|
//! | `graph.csv` | (state, action, next state) that was seen: how often, Σ r, whether it ended an episode |
//! | `policy.csv` | state: how often it was left, and the likeliest action there, with the advice of φ but not of a search (empty if none) |

use super::error::ArchiveError;
use super::files::write_atomically;
use super::names;
use super::rows::{GraphRow, PolicyRow};
use std::io::Write;
use std::path::Path;

/// Writes `graph.csv` into the seed's `folder`.
///
/// # Errors
/// If it cannot be written.
pub fn write_graph(
    folder: &Path,
    rows: impl IntoIterator<Item = GraphRow>,
) -> Result<(), ArchiveError> {
    let path = folder.join(names::GRAPH);
    write_atomically(&path, |file| {
        writeln!(file, "from,action,to,count,reward_sum,terminal")?;
        for row in rows {
            let (from, action, to, count) = (row.from, row.action, row.to, row.count);
            let (sum, terminal) = (row.reward_sum, row.terminal);
            writeln!(file, "{from},{action},{to},{count},{sum},{terminal}")?;
        }
        Ok(())
    })
    .map_err(ArchiveError::write(&path))
}

/// Writes `policy.csv` into the seed's `folder`.
///
/// # Errors
/// If it cannot be written.
pub fn write_policy(
    folder: &Path,
    rows: impl IntoIterator<Item = PolicyRow>,
) -> Result<(), ArchiveError> {
    let path = folder.join(names::POLICY);
    write_atomically(&path, |file| {
        writeln!(file, "state,visits,greedy")?;
        for row in rows {
            match row.greedy {
                Some(action) => writeln!(file, "{},{},{action}", row.state, row.visits)?,
                None => writeln!(file, "{},{},", row.state, row.visits)?,
            }
        }
        Ok(())
    })
    .map_err(ArchiveError::write(&path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_as_they_went() {
        let folder = tempfile::tempdir().unwrap();
        let row = |action, reward_sum, terminal| GraphRow {
            from: 0,
            action,
            to: 1,
            count: 2,
            reward_sum,
            terminal,
        };
        let graph = [row(1, -2.0, true), row(0, -0.5, false)];
        write_graph(folder.path(), graph.clone()).unwrap();
        let text = std::fs::read_to_string(folder.path().join("graph.csv")).unwrap();
        assert_eq!(
            text,
            "from,action,to,count,reward_sum,terminal\n0,1,1,2,-2,true\n0,0,1,2,-0.5,false\n"
        );
        let mut read = csv::Reader::from_reader(text.as_bytes());
        let read: Vec<GraphRow> = read.deserialize().map(Result::unwrap).collect();
        assert_eq!(read, graph);
        let policy = [Some(3), None].map(|greedy| PolicyRow {
            state: 0,
            visits: 3,
            greedy,
        });
        write_policy(folder.path(), policy.clone()).unwrap();
        let mut read = csv::Reader::from_path(folder.path().join("policy.csv")).unwrap();
        let read: Vec<PolicyRow> = read.deserialize().map(Result::unwrap).collect();
        assert_eq!(read, policy);
    }
}
