//! A table as named columns, each of one kind, any of whose values may be missing.

use std::io::{self, Write};

/// A table.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// What it is about, fit for a file name.
    pub name: &'static str,
    /// Columns of equal length, by name.
    pub columns: Vec<(String, Column)>,
}

/// The values of a column; `None` where there is none.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// Whole numbers.
    Integers(Vec<Option<i64>>),
    /// Numbers.
    Numbers(Vec<Option<f64>>),
    /// Yes or no.
    Flags(Vec<Option<bool>>),
    /// Anything else; never missing, but maybe empty.
    Texts(Vec<String>),
}

/// Columns that hold numbers, also where all of them happen to be whole.
const NUMBERS: [&str; 9] = [
    "return",
    "shaped_return",
    "regret",
    "reward_sum",
    "potential",
    "max_relative_residual",
    "largest_eigenvalue",
    "initial_loss",
    "loss",
];

/// Columns that hold names, also where all of them happen to be numbers.
const TEXTS: [&str; 4] = ["name", "status", "greedy_name", "action_name"];

impl Column {
    /// The column called `name` with these fields of a CSV file, an empty one meaning none. Its kind follows from the name
    /// where that is known, else it is the narrowest that holds every value.
    pub fn parse(name: &str, fields: Vec<String>) -> Self {
        if TEXTS.contains(&name) {
            return Column::Texts(fields);
        }
        let integers = || all(&fields).map(Column::Integers);
        let numbers = || all(&fields).map(Column::Numbers);
        let flags = || all(&fields).map(Column::Flags);
        let narrowest = if NUMBERS.contains(&name) {
            numbers()
        } else {
            integers().or_else(numbers).or_else(flags)
        };
        narrowest.unwrap_or(Column::Texts(fields))
    }

    /// How many values there are, the missing ones included.
    pub fn len(&self) -> usize {
        match self {
            Column::Integers(values) => values.len(),
            Column::Numbers(values) => values.len(),
            Column::Flags(values) => values.len(),
            Column::Texts(values) => values.len(),
        }
    }

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A value as a field of a CSV file.
    fn field(&self, row: usize) -> String {
        fn shown<T: ToString>(value: &Option<T>) -> String {
            value.as_ref().map_or_else(String::new, T::to_string)
        }
        match self {
            Column::Integers(values) => shown(&values[row]),
            Column::Numbers(values) => shown(&values[row]),
            Column::Flags(values) => shown(&values[row]),
            Column::Texts(values) => values[row].clone(),
        }
    }
}

/// Every field as a `T`; nothing if one of them is something else.
fn all<T: std::str::FromStr>(fields: &[String]) -> Option<Vec<Option<T>>> {
    let value = |field: &String| match field.as_str() {
        "" => Some(None),
        text => text.parse().ok().map(Some),
    };
    fields.iter().map(value).collect()
}

impl Table {
    /// How many rows there are.
    pub fn num_rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, column)| column.len())
    }

    /// Writes it with a header.
    pub(super) fn write_csv(&self, out: &mut impl Write) -> io::Result<()> {
        let mut writer = csv::Writer::from_writer(out);
        writer.write_record(self.columns.iter().map(|(name, _)| name))?;
        for row in 0..self.num_rows() {
            writer.write_record(self.columns.iter().map(|(_, column)| column.field(row)))?;
        }
        writer.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(name: &str, fields: &[&str]) -> Column {
        Column::parse(name, fields.iter().map(|&f| f.to_owned()).collect())
    }

    #[test]
    fn kinds_follow_names_or_values() {
        let integers = Column::Integers(vec![Some(1), None]);
        assert_eq!(column("length", &["1", ""]), integers);
        let numbers = Column::Numbers(vec![Some(1.0), None]);
        assert_eq!(column("loss", &["1", ""]), numbers);
        assert_eq!(column("new", &["1", "0.5"]).len(), 2);
        let flags = Column::Flags(vec![Some(true), Some(false)]);
        assert_eq!(column("terminal", &["true", "false"]), flags);
        let texts = Column::Texts(vec!["7".to_owned(), String::new()]);
        assert_eq!(column("name", &["7", ""]), texts);
        let mixed = Column::Texts(vec!["7".to_owned(), "x".to_owned()]);
        assert_eq!(column("new", &["7", "x"]), mixed);
    }

    #[test]
    fn csv_reads_back_as_it_was() {
        let table = Table {
            name: "t",
            columns: vec![
                (
                    "state".to_owned(),
                    Column::Integers(vec![Some(-1), Some(2)]),
                ),
                (
                    "name".to_owned(),
                    Column::Texts(vec!["a, \"b\"".to_owned(), String::new()]),
                ),
                (
                    "potential".to_owned(),
                    Column::Numbers(vec![Some(0.1 + 0.2), None]),
                ),
            ],
        };
        let mut bytes = Vec::new();
        table.write_csv(&mut bytes).unwrap();
        let mut reader = csv::Reader::from_reader(bytes.as_slice());
        let names: Vec<String> = reader
            .headers()
            .unwrap()
            .iter()
            .map(str::to_owned)
            .collect();
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        for (place, (name, column)) in table.columns.iter().enumerate() {
            assert_eq!(&names[place], name);
            let fields = rows.iter().map(|row| row[place].to_owned()).collect();
            assert_eq!(&Column::parse(name, fields), column);
        }
    }
}
