//! Reading an edge list: the columns, the lines, and the probabilities of each (from, action).

use super::quotes::check_quotes;
use super::{Edge, EdgeList};
use crate::env::error::{MOST_ERRORS, nearest};
use crate::env::tabular::PROBABILITY_TOLERANCE;
use crate::env::{EdgeListProblem, EnvError};
use csv::StringRecord;
use indexmap::IndexSet;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The columns there may be; the first two must be.
const COLUMNS: [&str; 5] = ["from", "to", "action", "probability", "reward"];
const REQUIRED: usize = 2;
/// Columns by their place in [`COLUMNS`].
const FROM: usize = 0;
const TO: usize = 1;
const ACTION: usize = 2;
const PROBABILITY: usize = 3;
const REWARD: usize = 4;
/// Actions there may be.
const MOST_ACTIONS: u16 = u16::MAX;
/// What some programs put before UTF-8 text.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// A line as it stands in the file.
struct Line {
    number: u64,
    from: u32,
    action: u16,
    to: u32,
    probability: Option<f64>,
    reward: Option<f64>,
}

impl EdgeList {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// [`EnvError::Unreadable`], or [`EnvError::EdgeList`] with the line of the broken rule; [`EnvError::Several`] of these if
    /// several lines are wrong.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, EnvError> {
        let name = path.as_ref().display().to_string();
        match File::open(path) {
            Ok(file) => Self::from_reader(&name, file),
            Err(error) => Err(EnvError::Unreadable {
                file: name,
                message: error.to_string(),
            }),
        }
    }

    /// Reads an edge list; `file` is its name in messages. Spaces around names and numbers do not count.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn from_reader(file: &str, reader: impl Read) -> Result<Self, EnvError> {
        let text = text(file, reader)?;
        check_quotes(&text).map_err(|(line, problem)| at(file, line, problem))?;
        let csv_error = |error: csv::Error| csv_error(file, &text, &error);
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .from_reader(text.as_slice());
        let columns = columns(file, reader.headers().map_err(csv_error)?)?;
        let mut list = EdgeList {
            file: file.to_owned(),
            states: IndexSet::new(),
            actions: IndexSet::new(),
            edges: Vec::new(),
            largest: None,
            smallest: None,
        };
        let (mut lines, mut errors) = (Vec::new(), Vec::new());
        let mut record = StringRecord::new();
        while errors.len() < MOST_ERRORS {
            match reader.read_record(&mut record).map_err(csv_error) {
                Ok(false) => break,
                // What is wrong with a line is no reason not to read the next one.
                Err(error @ EnvError::EdgeList { .. }) => errors.push(error),
                Err(error) => return Err(error),
                Ok(true) => {
                    let number = line_number(&text, record.position());
                    match list.line(&record, &columns, number) {
                        Ok(line) => lines.push(line),
                        Err(problem) => errors.push(at(file, number, problem)),
                    }
                }
            }
        }
        if let Some(error) = EnvError::of_all(errors) {
            return Err(error);
        }
        if lines.is_empty() {
            return Err(at(file, 1, EdgeListProblem::NoEdges));
        }
        if columns[ACTION].is_none() {
            list.number_actions(&mut lines)
                .map_err(|(number, problem)| at(file, number, problem))?;
        }
        // A stable sort keeps the order of the file within each (from, action).
        lines.sort_by_key(Line::pair);
        let mut errors = Vec::new();
        for group in lines.chunk_by(|a, b| a.pair() == b.pair()) {
            let added = list.add_group(group);
            errors.extend(added.err().map(|problem| (group[0].number, problem)));
        }
        errors.sort_by_key(|&(number, _)| number);
        let errors = errors.into_iter().take(MOST_ERRORS);
        let errors = errors.map(|(number, problem)| at(file, number, problem));
        EnvError::of_all(errors.collect()).map_or(Ok(list), Err)
    }

    /// Reads one line and numbers the names it brings; without a column of actions its action is 0.
    fn line(
        &mut self,
        record: &StringRecord,
        columns: &[Option<usize>; 5],
        number: u64,
    ) -> Result<Line, EdgeListProblem> {
        let field = |column: usize| columns[column].and_then(|at| record.get(at)).unwrap_or("");
        for name in [FROM, ACTION, TO] {
            if columns[name].is_some() && field(name).is_empty() {
                let column = COLUMNS[name];
                return Err(EdgeListProblem::EmptyName { column });
            }
        }
        let action = match columns[ACTION] {
            Some(_) => intern(&mut self.actions, field(ACTION)),
            None => 0,
        };
        let reward = number_in(COLUMNS[REWARD], field(REWARD))?;
        self.note_reward(number, reward.unwrap_or(0.0));
        Ok(Line {
            number,
            from: intern(&mut self.states, field(FROM)) as u32,
            action: u16::try_from(action)
                .ok()
                .filter(|&a| a < MOST_ACTIONS)
                .ok_or(EdgeListProblem::TooManyActions)?,
            to: intern(&mut self.states, field(TO)) as u32,
            probability: probability(field(PROBABILITY))?,
            reward,
        })
    }

    /// Makes each line an action of its own: the first of its state is 0, the next one 1.
    fn number_actions(&mut self, lines: &mut [Line]) -> Result<(), (u64, EdgeListProblem)> {
        let mut counts = vec![0; self.states.len()];
        for line in lines {
            let count = &mut counts[line.from as usize];
            if *count == MOST_ACTIONS {
                return Err((line.number, EdgeListProblem::TooManyActions));
            }
            line.action = *count;
            *count += 1;
        }
        let most = counts.into_iter().max().unwrap_or(0);
        self.actions = (0..most).map(|action| action.to_string()).collect();
        Ok(())
    }

    /// Keeps the largest and the smallest reward but 0.
    fn note_reward(&mut self, line: u64, reward: f64) {
        let size = reward.abs();
        if size == 0.0 {
            return;
        }
        if self.largest.is_none_or(|(_, r)| size > r.abs()) {
            self.largest = Some((line, reward));
        }
        if self.smallest.is_none_or(|(_, r)| size < r.abs()) {
            self.smallest = Some((line, reward));
        }
    }

    /// Fills in the probabilities of one (from, action) and appends its edges.
    fn add_group(&mut self, group: &[Line]) -> Result<(), EdgeListProblem> {
        let from = self.states[group[0].from as usize].clone();
        let action = self.actions[usize::from(group[0].action)].clone();
        let given = group
            .iter()
            .filter(|line| line.probability.is_some())
            .count();
        if given != 0 && given != group.len() {
            return Err(EdgeListProblem::ProbabilityMissing { from, action });
        }
        let sum: f64 = group.iter().filter_map(|line| line.probability).sum();
        if given != 0 && (sum - 1.0).abs() > PROBABILITY_TOLERANCE {
            return Err(EdgeListProblem::ProbabilitySum { from, action, sum });
        }
        let share = 1.0 / group.len() as f64;
        self.edges.extend(group.iter().map(|line| Edge {
            from: line.from,
            action: line.action,
            to: line.to,
            probability: line.probability.unwrap_or(share),
            reward: line.reward,
        }));
        Ok(())
    }
}

impl Line {
    fn pair(&self) -> (u32, u16) {
        (self.from, self.action)
    }
}

/// Where each of [`COLUMNS`] stands in the file.
fn columns(file: &str, header: &StringRecord) -> Result<[Option<usize>; 5], EnvError> {
    let mut columns = [None; 5];
    for (position, name) in header.iter().enumerate() {
        let known = COLUMNS
            .iter()
            .position(|column| *column == name)
            .ok_or_else(|| {
                let nearest = nearest(name, COLUMNS.into_iter());
                at(
                    file,
                    1,
                    EdgeListProblem::UnknownColumn {
                        column: name.to_owned(),
                        nearest,
                    },
                )
            })?;
        if columns[known].replace(position).is_some() {
            return Err(at(
                file,
                1,
                EdgeListProblem::DuplicateColumn {
                    column: name.to_owned(),
                },
            ));
        }
    }
    let missing = columns[..REQUIRED].iter().position(Option::is_none);
    let problem = match missing.map(|place| COLUMNS[place]) {
        Some(column) => EdgeListProblem::MissingColumn { column },
        None if columns[ACTION].is_none() && columns[PROBABILITY].is_some() => {
            EdgeListProblem::ProbabilityWithoutAction
        }
        None => return Ok(columns),
    };
    Err(at(file, 1, problem))
}

/// All that `reader` has, without a byte order mark.
fn text(file: &str, mut reader: impl Read) -> Result<Vec<u8>, EnvError> {
    let mut text = Vec::new();
    reader
        .read_to_end(&mut text)
        .map_err(|error| EnvError::Unreadable {
            file: file.to_owned(),
            message: error.to_string(),
        })?;
    if text.starts_with(BYTE_ORDER_MARK) {
        text.drain(..BYTE_ORDER_MARK.len());
    }
    Ok(text)
}

/// The line of a record; 0 if it has no place. The reader's own count is that of the blank lines before it, which it skips.
fn line_number(text: &[u8], position: Option<&csv::Position>) -> u64 {
    position.map_or(0, |position| {
        let from = usize::try_from(position.byte()).map_or(text.len(), |at| at.min(text.len()));
        let blank = text[from..]
            .iter()
            .take_while(|byte| matches!(byte, b'\n' | b'\r'));
        position.line() + blank.filter(|&&byte| byte == b'\n').count() as u64
    })
}

/// The number of `name`, a new one if it is new.
fn intern(names: &mut IndexSet<String>, name: &str) -> usize {
    match names.get_index_of(name) {
        Some(number) => number,
        None => names.insert_full(name.to_owned()).0,
    }
}

fn probability(text: &str) -> Result<Option<f64>, EdgeListProblem> {
    match number_in(COLUMNS[PROBABILITY], text)? {
        Some(value) if !(value > 0.0 && value <= 1.0) => {
            Err(EdgeListProblem::ProbabilityRange { value })
        }
        value => Ok(value),
    }
}

/// A finite number, or nothing.
fn number_in(column: &'static str, text: &str) -> Result<Option<f64>, EdgeListProblem> {
    if text.is_empty() {
        return Ok(None);
    }
    let number = text.parse().ok().filter(|number: &f64| number.is_finite());
    number.map(Some).ok_or(EdgeListProblem::NotANumber {
        column,
        value: text.to_owned(),
    })
}

fn at(file: &str, line: u64, problem: EdgeListProblem) -> EnvError {
    EnvError::EdgeList {
        file: file.to_owned(),
        line,
        problem,
    }
}

fn csv_error(file: &str, text: &[u8], error: &csv::Error) -> EnvError {
    match error.kind() {
        csv::ErrorKind::Io(io) => EnvError::Unreadable {
            file: file.to_owned(),
            message: io.to_string(),
        },
        csv::ErrorKind::UnequalLengths {
            pos,
            expected_len,
            len,
        } => {
            let line = line_number(text, pos.as_ref());
            at(
                file,
                line,
                EdgeListProblem::Malformed {
                    message: format!("{len} fields where the header has {expected_len}"),
                },
            )
        }
        csv::ErrorKind::Utf8 { pos, .. } => {
            let line = line_number(text, pos.as_ref());
            at(
                file,
                line,
                EdgeListProblem::Malformed {
                    message: "not UTF-8 text".to_owned(),
                },
            )
        }
        _ => EnvError::Unreadable {
            file: file.to_owned(),
            message: error.to_string(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The line and the problem of a list that is wrong.
    fn problem(text: &str) -> (u64, EdgeListProblem) {
        match EdgeList::from_reader("edges.csv", text.as_bytes()) {
            Err(EnvError::EdgeList {
                file,
                line,
                problem,
            }) => {
                assert_eq!(file, "edges.csv");
                (line, problem)
            }
            other => panic!("{other:?}"),
        }
    }

    /// The lines of a list of which several are wrong.
    fn problems(text: &str) -> Vec<u64> {
        let Err(EnvError::Several { errors }) = EdgeList::from_reader("edges.csv", text.as_bytes())
        else {
            panic!("several lines are wrong")
        };
        let line = |error: &EnvError| match error {
            EnvError::EdgeList { line, .. } => *line,
            other => panic!("{other:?}"),
        };
        errors.iter().map(line).collect()
    }

    #[test]
    fn columns_may_stand_in_any_order() {
        let list =
            EdgeList::from_reader("edges.csv", "to, from ,action\n b, a ,go\n".as_bytes()).unwrap();
        assert_eq!(list.state_names().collect::<Vec<_>>(), ["a", "b"]);
        assert_eq!(list.action_names().collect::<Vec<_>>(), ["go"]);
        assert_eq!(
            (
                list.edges[0].from,
                list.edges[0].to,
                list.edges[0].probability
            ),
            (0, 1, 1.0)
        );
    }

    #[test]
    fn without_a_column_of_actions_each_line_is_one() {
        let text = "from,to,reward\na,b,-1\nb,c,\na,c,-3\na,b,-2\n";
        let list = EdgeList::from_reader("edges.csv", text.as_bytes()).unwrap();
        assert_eq!(list.action_names().collect::<Vec<_>>(), ["0", "1", "2"]);
        let edge = |edge: &Edge| {
            (
                edge.from,
                edge.action,
                edge.to,
                edge.probability,
                edge.reward,
            )
        };
        assert_eq!(
            list.edges.iter().map(edge).collect::<Vec<_>>(),
            [
                (0, 0, 1, 1.0, Some(-1.0)),
                (0, 1, 2, 1.0, Some(-3.0)),
                (0, 2, 1, 1.0, Some(-2.0)),
                (1, 0, 2, 1.0, None),
            ]
        );
        let lines: String = (0..=u32::from(MOST_ACTIONS))
            .map(|i| format!("a,{i}\n"))
            .collect();
        assert_eq!(
            problem(&format!("from,to\n{lines}")),
            (u64::from(MOST_ACTIONS) + 2, EdgeListProblem::TooManyActions)
        );
    }

    #[test]
    fn headers_are_checked() {
        assert_eq!(
            problem("from,action\n"),
            (1, EdgeListProblem::MissingColumn { column: "to" })
        );
        assert_eq!(
            problem("from,to,probability\na,b,0.5\n"),
            (1, EdgeListProblem::ProbabilityWithoutAction)
        );
        // A file without a header is told what one looks like.
        let (_, headless) = problem("a,b\nb,c\n");
        assert!(headless.to_string().contains("from,to"), "{headless}");
        let unknown = EdgeListProblem::UnknownColumn {
            column: "probabilty".to_owned(),
            nearest: Some("probability".to_owned()),
        };
        assert_eq!(problem("from,action,to,probabilty\n"), (1, unknown));
        let twice = EdgeListProblem::DuplicateColumn {
            column: "to".to_owned(),
        };
        assert_eq!(problem("from,action,to,to\n"), (1, twice));
        assert_eq!(problem("from,action,to\n"), (1, EdgeListProblem::NoEdges));
    }

    #[test]
    fn lines_are_checked() {
        let header = "from,action,to,probability,reward\n";
        let second = |line: &str| problem(&format!("{header}a,go,b,1,\n{line}\n"));
        assert_eq!(
            second("b,,c,1,0"),
            (3, EdgeListProblem::EmptyName { column: "action" })
        );
        let number = |column, value: &str| EdgeListProblem::NotANumber {
            column,
            value: value.to_owned(),
        };
        assert_eq!(second("b,go,c,half,0"), (3, number("probability", "half")));
        assert_eq!(second("b,go,c,1,NaN"), (3, number("reward", "NaN")));
        assert_eq!(
            second("b,go,c,1.5,0"),
            (3, EdgeListProblem::ProbabilityRange { value: 1.5 })
        );
        let (from, action) = ("b".to_owned(), "go".to_owned());
        let sum = EdgeListProblem::ProbabilitySum {
            from: from.clone(),
            action: action.clone(),
            sum: 0.5,
        };
        assert_eq!(second("b,go,c,0.5,0"), (3, sum));
        assert_eq!(
            second("b,go,c,0.5,0\nb,go,a,,0"),
            (3, EdgeListProblem::ProbabilityMissing { from, action })
        );
        assert_eq!(
            problems(&format!(
                "{header},go,b,1,\nb,go,c\nb,go,c,2,0\nb,go,c,1,x\n"
            )),
            [2, 3, 4, 5]
        );
        let halves = "b,go,c,0.5,0\na,go,c,0.25,0\nc,go,a,1,\n";
        assert_eq!(problems(&format!("{header}{halves}")), [2, 3]);
        assert!(matches!(
            second("b,go,c"),
            (3, EdgeListProblem::Malformed { .. })
        ));
        // Blank lines count, though they say nothing.
        assert_eq!(
            second("\n\r\nb,go,c,1.5,0"),
            (5, EdgeListProblem::ProbabilityRange { value: 1.5 })
        );
        assert!(matches!(
            second("\n\nb,go,c"),
            (5, EdgeListProblem::Malformed { .. })
        ));
        assert!(matches!(
            second("b,go,\"c,1,0\n\"c\",go,a,1,0"),
            (3, EdgeListProblem::Quote { column: 6, .. })
        ));
    }
}
