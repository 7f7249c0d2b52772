//! The graph at the end of a run as tables: `graph.csv`, `actions.csv` and `policy.csv`.
//!
//! | file | a row for each |
//! |---|---|
//! | `graph.csv` | (state, action, next state) that was seen: how often, Σ r, whether it ended an episode |
//! | `actions.csv` | action: its number and its name |
//! | `policy.csv` | state: how often it was left, and the likeliest action there by number and name, with the advice of φ but not of a search (empty if none) |

use super::error::ArchiveError;
use super::names;
use super::rows::{GraphRow, PolicyRow};
use crate::disk::write_atomically;
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

/// Writes `actions.csv` into the seed's `folder`: the number of each action and its name.
///
/// # Errors
/// If it cannot be written.
pub fn write_actions(folder: &Path, action_names: &[&str]) -> Result<(), ArchiveError> {
    let path = folder.join(names::ACTIONS);
    write_atomically(&path, |file| {
        let mut table = csv::Writer::from_writer(file);
        table.write_record(["action", "name"])?;
        for (action, name) in action_names.iter().enumerate() {
            table.write_record([&action.to_string(), *name])?;
        }
        table.flush()
    })
    .map_err(ArchiveError::write(&path))
}

/// Names of the actions in the order of their numbers; none of a seed that was written without them.
///
/// # Errors
/// If the table does not say what it should.
pub fn read_action_names(folder: &Path) -> Result<Option<Vec<String>>, ArchiveError> {
    let path = folder.join(names::ACTIONS);
    if !path.exists() {
        return Ok(None);
    }
    let rows: Vec<(usize, String)> = csv::Reader::from_path(&path)
        .and_then(|mut reader| reader.deserialize().collect())
        .map_err(|error| ArchiveError::damaged(&path, error.to_string()))?;
    let (numbers, action_names): (Vec<usize>, Vec<String>) = rows.into_iter().unzip();
    if numbers.is_empty() || !numbers.iter().copied().eq(0..numbers.len()) {
        let rule = "actions must be numbered from 0, one a row";
        return Err(ArchiveError::damaged(&path, rule));
    }
    Ok(Some(action_names))
}

/// Writes `policy.csv` into the seed's `folder`; actions are called as in `action_names`.
///
/// # Errors
/// If it cannot be written.
pub fn write_policy(
    folder: &Path,
    rows: impl IntoIterator<Item = PolicyRow>,
    action_names: &[&str],
) -> Result<(), ArchiveError> {
    let path = folder.join(names::POLICY);
    write_atomically(&path, |file| {
        let mut table = csv::Writer::from_writer(file);
        table.write_record(["state", "visits", "greedy", "greedy_name"])?;
        for row in rows {
            let (state, visits) = (row.state.to_string(), row.visits.to_string());
            let greedy = row
                .greedy
                .map_or_else(String::new, |action| action.to_string());
            let name = row
                .greedy
                .map_or("", |action| action_names[usize::from(action)]);
            table.write_record([&state, &visits, &greedy, name])?;
        }
        table.flush()
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
        let names = ["up", "left, or \"west\"", "2", "on"];
        write_policy(folder.path(), policy.clone(), &names).unwrap();
        let text = std::fs::read_to_string(folder.path().join("policy.csv")).unwrap();
        assert_eq!(text, "state,visits,greedy,greedy_name\n0,3,3,on\n0,3,,\n");
        assert_eq!(read_action_names(folder.path()).unwrap(), None);
        write_actions(folder.path(), &names).unwrap();
        let read = read_action_names(folder.path()).unwrap();
        assert_eq!(read, Some(names.map(str::to_owned).to_vec()));
        std::fs::write(folder.path().join("actions.csv"), "action,name\n1,up\n").unwrap();
        assert!(read_action_names(folder.path()).is_err());
        let mut read = csv::Reader::from_path(folder.path().join("policy.csv")).unwrap();
        let read: Vec<PolicyRow> = read.deserialize().map(Result::unwrap).collect();
        assert_eq!(read, policy);
    }
}
