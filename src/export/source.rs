//! A run folder, read as tables and graphs.

use super::arrays::Matrix;
use super::error::ExportError;
use super::table::{Column, Table};
use crate::archive::files::read_npy;
use crate::archive::{GraphRow, is_run, names, read_action_names, seed_folder_name};
use crate::env::Action;
use crate::graph::{StateId, TransitionGraph, TransitionStats};
use crate::memory;
use std::fs;
use std::path::{Path, PathBuf};

/// A run, or one seed of it.
#[derive(Clone, Debug)]
pub struct Source {
    path: PathBuf,
    /// The seeds that have ended, ascending.
    seeds: Vec<SourceSeed>,
}

/// The folder of a seed that has ended.
#[derive(Clone, Debug)]
pub struct SourceSeed {
    seed: u64,
    folder: PathBuf,
}

/// The graph of a seed, with what is known about its states.
#[derive(Clone, Debug)]
pub struct NamedGraph {
    /// What was seen.
    pub graph: TransitionGraph,
    /// Place (`row,col`) or name of each state.
    pub names: Vec<String>,
    /// φ of each state.
    pub potential: Vec<f64>,
    /// Name of each action, where the run has written them.
    pub action_names: Option<Vec<String>>,
}

/// Rows of a CSV file, with its header.
struct Rows {
    names: Vec<String>,
    rows: Vec<csv::StringRecord>,
}

impl Source {
    /// The run in `path`, or the seed whose folder it is.
    ///
    /// # Errors
    /// If it is neither, or no seed of it has ended.
    pub fn open(path: &Path) -> Result<Self, ExportError> {
        let mut seeds: Vec<SourceSeed> = match SourceSeed::at(path) {
            Some(seed) => vec![seed],
            None => {
                let entries = fs::read_dir(path).into_iter().flatten().flatten();
                entries
                    .filter_map(|entry| SourceSeed::at(&entry.path()))
                    .collect()
            }
        };
        seeds.sort_by_key(|seed| seed.seed);
        if seeds.is_empty() {
            return Err(ExportError::damaged(
                path,
                match is_run(path) {
                    true => "no seed of this run has ended yet",
                    false => "not a run folder",
                },
            ));
        }
        Ok(Self {
            path: path.to_owned(),
            seeds,
        })
    }

    /// The seed there is.
    ///
    /// # Errors
    /// If there are several.
    pub fn only_seed(&self) -> Result<&SourceSeed, ExportError> {
        match self.seeds.as_slice() {
            [seed] => Ok(seed),
            several => Err(ExportError::ManySeeds {
                path: self.path.clone(),
                seeds: several.len(),
                first: several[0].folder.clone(),
            }),
        }
    }

    /// The four tables.
    ///
    /// # Errors
    /// If a file cannot be read, or does not say what it should.
    pub fn tables(&self) -> Result<Vec<Table>, ExportError> {
        let from = |name: &'static str, read: &dyn Fn(&SourceSeed) -> Result<Rows, ExportError>| {
            let parts: Vec<(u64, Rows)> = self
                .seeds
                .iter()
                .map(|seed| Ok((seed.seed, read(seed)?)))
                .collect::<Result<_, ExportError>>()?;
            Ok::<_, ExportError>(joined(name, &parts))
        };
        let file = |name: &'static str| move |seed: &SourceSeed| Rows::read(&seed.folder, name);
        Ok(vec![
            from("episodes", &file(names::EPISODES))?,
            from("refreshes", &file(names::REFRESHES))?,
            from("states", &SourceSeed::states)?,
            from("transitions", &SourceSeed::transitions)?,
        ])
    }

    /// The eigenvectors of each seed that has some, under the name of its folder.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub(super) fn eigenvectors(&self) -> Result<Vec<Matrix>, ExportError> {
        let paths = self.seeds.iter().map(|seed| {
            let path = seed.folder.join(names::EIGENVECTORS);
            (seed_folder_name(seed.seed), path)
        });
        let there = paths.filter(|(_, path)| path.is_file());
        let read = there.map(|(name, path)| {
            let (shape, entries) = array(&path)?;
            Ok(Matrix {
                name,
                shape,
                entries,
            })
        });
        read.collect()
    }
}

impl SourceSeed {
    /// The seed whose folder `path` is.
    fn at(path: &Path) -> Option<Self> {
        let name = path.canonicalize().ok()?;
        let seed = name.file_name()?.to_str()?.strip_prefix("seed-")?;
        path.join(names::POTENTIAL).is_file().then_some(Self {
            seed: seed.parse().ok()?,
            folder: path.to_owned(),
        })
    }

    /// The graph.
    ///
    /// # Errors
    /// If a file cannot be read, or does not say what it should.
    pub fn graph(&self) -> Result<NamedGraph, ExportError> {
        let states = self.states()?;
        let place = states.names.iter().position(|name| name == "potential");
        let place = place.expect("the table was made with this column");
        let path = self.folder.join(names::GRAPH);
        let rows: Vec<GraphRow> = csv::Reader::from_path(&path)
            .and_then(|mut reader| reader.deserialize().collect())
            .map_err(|error| ExportError::damaged(&path, error.to_string()))?;
        let action_names = self.action_names()?;
        let num_actions = match &action_names {
            Some(names) => names.len(),
            None => rows
                .iter()
                .map(|row| usize::from(row.action) + 1)
                .max()
                .unwrap_or(1),
        };
        let transitions = rows.iter().map(|row| {
            let stats = TransitionStats {
                action: Action(row.action),
                count: row.count,
                reward_sum: row.reward_sum,
                terminal: row.terminal,
            };
            (StateId(row.from), stats, StateId(row.to))
        });
        let graph = TransitionGraph::from_transitions(num_actions, states.rows.len(), transitions);
        let names = states.rows.iter().map(|row| {
            let label: Vec<&str> = row.iter().take(place).skip(1).collect();
            label.join(",")
        });
        Ok(NamedGraph {
            graph: graph.map_err(|source| ExportError::Graph { path, source })?,
            names: names.collect(),
            potential: array(&self.folder.join(names::POTENTIAL))?.1,
            action_names,
        })
    }

    /// Names of the actions, if they are there.
    fn action_names(&self) -> Result<Option<Vec<String>>, ExportError> {
        let path = self.folder.join(names::ACTIONS);
        read_action_names(&self.folder)
            .map_err(|error| ExportError::damaged(&path, error.to_string()))
    }

    /// `graph.csv`, and in a last column what each action is called, if that is known.
    fn transitions(&self) -> Result<Rows, ExportError> {
        let mut rows = Rows::read(&self.folder, names::GRAPH)?;
        let (Some(action_names), Some(place)) = (
            self.action_names()?,
            rows.names.iter().position(|name| name == "action"),
        ) else {
            return Ok(rows);
        };
        rows.names.push("action_name".to_owned());
        for row in &mut rows.rows {
            let number = row.get(place).and_then(|field| field.parse::<usize>().ok());
            let name = number.and_then(|number| action_names.get(number));
            row.push_field(name.map_or("", String::as_str));
        }
        Ok(rows)
    }

    /// `states.csv`, φ, and `policy.csv` side by side.
    fn states(&self) -> Result<Rows, ExportError> {
        let mut states = Rows::read(&self.folder, names::STATES)?;
        let policy = Rows::read(&self.folder, names::POLICY)?;
        let path = self.folder.join(names::POTENTIAL);
        let (_, potential) = array(&path)?;
        let lengths = [policy.rows.len(), potential.len()];
        if lengths.iter().any(|&length| length != states.rows.len()) {
            let message = format!(
                "{} potentials and {} rows of policy.csv for {} states",
                lengths[1],
                lengths[0],
                states.rows.len()
            );
            return Err(ExportError::damaged(&path, message));
        }
        states.names.push("potential".to_owned());
        states.names.extend(policy.names.into_iter().skip(1));
        let beside = potential.iter().zip(&policy.rows);
        for (row, (phi, policy)) in states.rows.iter_mut().zip(beside) {
            row.push_field(&phi.to_string());
            policy
                .iter()
                .skip(1)
                .for_each(|field| row.push_field(field));
        }
        Ok(states)
    }
}

impl Rows {
    fn read(folder: &Path, name: &str) -> Result<Self, ExportError> {
        let path = folder.join(name);
        // Each field becomes a text and then a number of its own.
        const BYTES_PER_BYTE: u64 = 8;
        let length = fs::metadata(&path).map_or(0, |there| there.len());
        if length.saturating_mul(BYTES_PER_BYTE) > memory::total() {
            let message = "the table is too large for this machine's memory; read the file itself";
            return Err(ExportError::damaged(&path, message));
        }
        let read = || {
            let mut reader = csv::Reader::from_path(&path)?;
            let names = reader.headers()?.iter().map(str::to_owned).collect();
            let rows = reader.records().collect::<csv::Result<_>>()?;
            Ok(Self { names, rows })
        };
        read().map_err(|error: csv::Error| ExportError::damaged(&path, error.to_string()))
    }
}

fn array(path: &Path) -> Result<(Vec<usize>, Vec<f64>), ExportError> {
    read_npy(path).map_err(|error| ExportError::damaged(path, error.to_string()))
}

/// One table from the rows of each seed, with the columns that any of them has: a run without a refresh leaves a file
/// without a header.
fn joined(name: &'static str, parts: &[(u64, Rows)]) -> Table {
    let mut names: Vec<&String> = Vec::new();
    for column in parts.iter().flat_map(|(_, rows)| &rows.names) {
        if !names.contains(&column) {
            names.push(column);
        }
    }
    let seeds = parts
        .iter()
        .flat_map(|(seed, rows)| rows.rows.iter().map(|_| Some(*seed as i64)));
    let mut columns = vec![("seed".to_owned(), Column::Integers(seeds.collect()))];
    for column in names {
        let fields = parts.iter().flat_map(|(_, part)| {
            let place = part.names.iter().position(|name| name == column);
            part.rows.iter().map(move |row| {
                let field = place.and_then(|place| row.get(place));
                field.unwrap_or_default().to_owned()
            })
        });
        columns.push((column.clone(), Column::parse(column, fields.collect())));
    }
    Table { name, columns }
}
