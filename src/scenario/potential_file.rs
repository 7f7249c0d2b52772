//! φ as a user gives it: a CSV file with a line for each state.
//!
//! ```text
//! row,col,potential      on a map            name,potential      where states have names; `node` is as good as `name`
//! ```
//!
//! That is what `export --to csv` writes into `states.csv` of one seed: its other columns are not looked at, least of all the
//! numbers of states, which another run gives to others.

use super::error::{BrokenRule, nearest};
use super::layout::STATES;
use super::world::World;
use crate::env::LARGEST_RETURN;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The key that names the file.
const KEY: &str = "shaping.file";
const VALUE: &str = "potential";
/// Columns of `states.csv` that say nothing of φ.
const PASSED_OVER: [&str; 5] = ["seed", "state", "visits", "greedy", "greedy_name"];
/// What some programs put before UTF-8 text.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// φ of the states of one world, as a file gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct PotentialFile {
    path: PathBuf,
    /// By number in the world's MDP.
    values: Vec<Option<f64>>,
}

/// Places of the columns in a line.
struct Columns {
    place: Vec<usize>,
    value: usize,
}

/// The number of the state in a place, or in words why there is none.
type FindState<'w> = Box<dyn Fn(&[&str]) -> Result<usize, String> + 'w>;

/// What a line may say of a state, and which number that is in the MDP.
struct States<'w> {
    count: usize,
    columns: &'static [&'static str],
    find: FindState<'w>,
}

impl PotentialFile {
    /// Reads φ of the states of `world`. O(states + lines).
    ///
    /// # Errors
    /// If the file cannot be read, has other columns, gives a state twice or one that is not in the world, or a φ that is no
    /// number of a size that can be added up.
    pub(super) fn read(path: &Path, world: &World) -> Result<Self, BrokenRule> {
        let broken = |message: String| BrokenRule::new(KEY, message).beside(&STATES);
        let text = std::fs::read_to_string(path);
        let text = text.map_err(|e| broken(format!("{}: cannot read: {e}", path.display())))?;
        let values = values(&text, &States::of(world)).map_err(|(line, problem)| {
            broken(format!("{}, line {line}: {problem}", path.display()))
        })?;
        Ok(Self {
            path: path.to_owned(),
            values,
        })
    }

    /// Where it was read.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// φ by number in the world's MDP; none where the file does not name the state.
    pub fn values(&self) -> &[Option<f64>] {
        &self.values
    }

    /// How many states it does not name.
    pub fn num_missing(&self) -> usize {
        self.values.iter().filter(|value| value.is_none()).count()
    }

    /// What its author may not have meant, in words.
    pub fn caution(&self) -> Option<String> {
        let (missing, all) = (self.num_missing(), self.values.len());
        (missing > 0).then(|| {
            format!(
                "{}: names {} of the {all} states of the world; φ is 0 in the other {missing}",
                self.path.display(),
                all - missing
            )
        })
    }
}

/// A broken rule and the line, from 1 (the header), that breaks it.
type Problem = (u64, String);

/// φ by number of the state.
fn values(text: &str, states: &States<'_>) -> Result<Vec<Option<f64>>, Problem> {
    let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let line_of = |position: Option<&csv::Position>| position.map_or(1, csv::Position::line);
    let malformed = |e: csv::Error| (line_of(e.position()), malformed(&e));
    let columns = Columns::of(reader.headers().map_err(malformed)?, states);
    let columns = columns.map_err(|problem| (1, problem))?;
    let mut values = vec![None; states.count];
    let mut lines = vec![0; states.count];
    for record in reader.records() {
        let record = record.map_err(malformed)?;
        let line = line_of(record.position());
        let at = |problem: String| (line, problem);
        let place: Vec<&str> = columns
            .place
            .iter()
            .map(|&column| &record[column])
            .collect();
        let state = (states.find)(&place).map_err(at)?;
        if values[state].is_some() {
            let (name, before) = (place.join(","), lines[state]);
            return Err(at(format!(
                "the state {name} is given on line {before} already: keep one of them (of several seeds, the lines of one)"
            )));
        }
        values[state] = Some(number(&record[columns.value]).map_err(at)?);
        lines[state] = line;
    }
    Ok(values)
}

fn malformed(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => format!("{len} fields, where the header has {expected_len}"),
        _ => error.to_string(),
    }
}

fn number(field: &str) -> Result<f64, String> {
    let number = field.parse().ok();
    let sound = number.filter(|phi: &f64| phi.abs() <= LARGEST_RETURN);
    sound.ok_or_else(|| {
        format!("{VALUE} = {field:?} is not a finite number of at most {LARGEST_RETURN:e} in size")
    })
}

impl Columns {
    fn of(header: &csv::StringRecord, states: &States<'_>) -> Result<Self, String> {
        let known: Vec<&str> = states.columns.iter().copied().chain([VALUE]).collect();
        let rule = format!("the header is {}", known.join(","));
        let mut place = vec![None; known.len()];
        for (column, name) in header.iter().enumerate() {
            let synonym = if name == "node" { "name" } else { name };
            match known.iter().position(|known| *known == synonym) {
                Some(at) if place[at].is_some() => {
                    return Err(format!("the column {name:?} is given twice"));
                }
                Some(at) => place[at] = Some(column),
                None if PASSED_OVER.contains(&name) => {}
                None => {
                    let meant = nearest(name, known.iter().copied());
                    let meant = meant.map_or(String::new(), |m| format!("; did you mean {m:?}?"));
                    return Err(format!("unknown column {name:?}{meant}; {rule}"));
                }
            }
        }
        let found = |at: usize| {
            place[at].ok_or_else(|| format!("the column {:?} is missing; {rule}", known[at]))
        };
        Ok(Self {
            place: (0..states.columns.len())
                .map(found)
                .collect::<Result<_, _>>()?,
            value: found(states.columns.len())?,
        })
    }
}

impl<'w> States<'w> {
    fn of(world: &'w World) -> Self {
        match world {
            World::Grid(world) => {
                let layout = world.layout();
                let cells: HashMap<_, _> = world.mdp_cells().zip(0..).collect();
                Self {
                    count: cells.len(),
                    columns: &["row", "col"],
                    find: Box::new(move |place| {
                        let cell =
                            layout.cell(coordinate("row", place[0])?, coordinate("col", place[1])?);
                        let (rows, cols) = (layout.rows(), layout.cols());
                        let cell = cell.ok_or_else(|| {
                            format!("{} is outside the map, which has {rows} rows and {cols} columns counted from 0", place.join(","))
                        })?;
                        let free = cells.get(&cell).copied();
                        free.ok_or_else(|| format!("{} is a wall: no state", place.join(",")))
                    }),
                }
            }
            World::Listed(world, names) => {
                let numbers: HashMap<&str, usize> =
                    names.states.iter().map(String::as_str).zip(0..).collect();
                Self {
                    count: world.mdp().num_states(),
                    columns: &["name"],
                    find: Box::new(move |name| {
                        numbers.get(name[0]).copied().ok_or_else(|| {
                            let meant = nearest(name[0], names.states.iter().map(String::as_str));
                            let meant =
                                meant.map_or(String::new(), |m| format!("; did you mean {m:?}?"));
                            format!("no state is named {:?}{meant}", name[0])
                        })
                    }),
                }
            }
        }
    }
}

fn coordinate(column: &str, field: &str) -> Result<usize, String> {
    let number = field.parse();
    number.map_err(|_| format!("{column} = {field:?} is not a whole number from 0"))
}

#[cfg(test)]
mod tests {
    use crate::scenario::{Loaded, Scenario};
    use std::fs;

    const MAP: &str = "[env]\nkind = \"ascii\"\nmap = \"\"\"\nS.#\n..G\n\"\"\"\n";
    const LIST: &str =
        "[env]\nkind = \"edge-list\"\nfile = \"world.csv\"\ngoals = [{ at = \"the pond\" }]\n";

    fn load(world: &str, phi: &str) -> Result<Loaded, String> {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        put(
            "world.csv",
            "from,action,to\nhome,go,mill\nmill,go,the pond\n",
        );
        put("phi.csv", phi);
        let text = format!("{world}[shaping]\npotential = \"file\"\nfile = \"phi.csv\"\n");
        let path = folder.path().join("x.toml");
        Scenario::parse(&path, text, &[]).map_err(|e| e.to_string())
    }

    fn values(world: &str, phi: &str) -> Vec<Option<f64>> {
        let loaded = load(world, phi).unwrap_or_else(|e| panic!("{e}"));
        let path = loaded.scenario.shaping.file.unwrap();
        loaded.worlds.potential_of(&path).unwrap().values().to_vec()
    }

    #[test]
    fn places_and_names_find_their_states() {
        // In reading order: 0,0  0,1  1,0  1,1  1,2.
        assert_eq!(
            values(MAP, "row,col,potential\n1,1,-1\n0,0,-3.5\n"),
            [Some(-3.5), None, None, Some(-1.0), None]
        );
        let exported = "\u{feff}seed,state,row,col,potential,visits,greedy,greedy_name\r\n7,0, 0 ,1,1e3,5,,\r\n7,1,1,2,-0,5,2,down\r\n";
        assert_eq!(
            values(MAP, exported),
            [None, Some(1000.0), None, None, Some(0.0)]
        );
        for header in ["name,potential", "node,potential", "state,name,potential"] {
            let state = if header.starts_with("state") {
                "4,"
            } else {
                ""
            };
            let text = format!("{header}\n{state}\"the pond\",0\n{state}home,-2\n");
            assert_eq!(values(LIST, &text), [Some(-2.0), None, Some(0.0)]);
        }
        assert_eq!(values(MAP, "row,col,potential\n"), [None; 5]);
    }

    #[test]
    fn states_left_out_are_counted() {
        let caution = |phi: &str| load(MAP, phi).unwrap().worlds.potential_cautions().next();
        let all = "row,col,potential\n0,0,1\n0,1,1\n1,0,1\n1,1,1\n1,2,1\n";
        assert_eq!(caution(all), None);
        let said = caution("row,col,potential\n0,0,1\n0,1,1\n").unwrap();
        assert!(
            said.ends_with("phi.csv: names 2 of the 5 states of the world; φ is 0 in the other 3"),
            "{said}"
        );
    }

    #[test]
    fn a_slip_is_placed_and_explained() {
        for (world, phi, expected) in [
            (
                MAP,
                "",
                "line 1: the column \"row\" is missing; the header is row,col,potential",
            ),
            (
                MAP,
                "state,potential\n0,1\n",
                "line 1: the column \"row\" is missing; the header is row,col,potential",
            ),
            (
                MAP,
                "row,col\n",
                "line 1: the column \"potential\" is missing",
            ),
            (
                MAP,
                "row,col,potental\n",
                "line 1: unknown column \"potental\"; did you mean \"potential\"?; the header is",
            ),
            (
                MAP,
                "row,col,col,potential\n",
                "line 1: the column \"col\" is given twice",
            ),
            (
                LIST,
                "name,node,potential\n",
                "line 1: the column \"node\" is given twice",
            ),
            (
                LIST,
                "row,col,potential\n",
                "line 1: unknown column \"row\"; the header is name,potential",
            ),
            (
                MAP,
                "row,col,potential\n0,0,-1\n0,1\n",
                "line 3: 2 fields, where the header has 3",
            ),
            (
                MAP,
                "row,col,potential\n0,0,high\n",
                "line 2: potential = \"high\" is not a finite number of at most 1e27 in size",
            ),
            (
                MAP,
                "row,col,potential\n0,0,NaN\n",
                "line 2: potential = \"NaN\" is not a finite number",
            ),
            (
                MAP,
                "row,col,potential\n0,0,\n",
                "line 2: potential = \"\" is not a finite number",
            ),
            (
                MAP,
                "row,col,potential\n0,1,-inf\n",
                "line 2: potential = \"-inf\" is not a finite number",
            ),
            (
                MAP,
                "row,col,potential\n0,1,1e28\n",
                "line 2: potential = \"1e28\" is not a finite number of at most 1e27",
            ),
            (
                MAP,
                "row,col,potential\n-1,0,0\n",
                "line 2: row = \"-1\" is not a whole number from 0",
            ),
            (
                MAP,
                "row,col,potential\n1,3,0\n",
                "line 2: 1,3 is outside the map, which has 2 rows and 3 columns counted from 0",
            ),
            (MAP, "row,col,potential\n0,2,0\n", "line 2: 0,2 is a wall"),
            (
                MAP,
                "row,col,potential\n1,1,0\n\n1,0,2\n1,1,0\n",
                "line 5: the state 1,1 is given on line 2 already",
            ),
            (
                LIST,
                "name,potential\nhome,-2\nthe pnd,0\n",
                "line 3: no state is named \"the pnd\"; did you mean \"the pond\"?",
            ),
        ] {
            let message = load(world, phi).unwrap_err();
            let found = message.contains(&format!("phi.csv, {expected}"));
            assert!(found && message.contains("x.toml:"), "{phi}: {message}");
            assert!(message.contains(": shaping.file: "), "{message}");
        }
        let unreadable = load(MAP, "row,col,potential\n").unwrap().scenario;
        let message = unreadable.validate().unwrap_err().message;
        assert!(message.contains("phi.csv: cannot read: "), "{message}");
    }
}
