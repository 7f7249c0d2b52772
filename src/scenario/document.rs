//! A TOML file with assignments from the command line laid over it, where every value still knows its place.
//!
//! The parser gives each value the byte range it came from. Assignments are parsed one by one as small documents
//! of their own; their ranges are shifted past the end of the file, as if they stood below it. So one number
//! tells, for an error in any value, whether the file or a flag is to blame and where.

use super::error::{BrokenRule, Choices, Location, ScenarioError};
use super::keys::{KeyPlaces, line_and_column};
use serde::de::DeserializeOwned;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

type Table<'t> = DeTable<'t>;

/// A parsed scenario file, before it becomes types.
#[derive(Clone)]
pub struct Document {
    path: PathBuf,
    text: String,
    /// `key = value` as TOML, beside what to blame for it.
    laid: Vec<(String, Location)>,
}

impl Document {
    /// A document from its text; `path` only serves messages. `sets` are `a.b=value`: a value that is not TOML
    /// is taken as a string, so that `shaping.potential=none` needs no quotes.
    pub fn new(path: &Path, text: String, sets: &[String]) -> Result<Self, ScenarioError> {
        let mut document = Self {
            path: path.to_owned(),
            text,
            laid: Vec::new(),
        };
        for set in sets {
            document.lay(set, Location::Flag(set.clone()))?;
        }
        Ok(document)
    }

    /// Lays one more assignment `a.b=value` over the document; `place` is to blame for it.
    pub fn lay(&mut self, assigned: &str, place: Location) -> Result<(), ScenarioError> {
        let toml = assignment(assigned).ok_or_else(|| ScenarioError::Syntax {
            place: place.clone(),
            message: "an assignment looks like section.key=value".to_owned(),
        })?;
        self.laid.push((toml, place));
        Ok(())
    }

    /// The file that it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A broken rule as an error with its place.
    pub fn blame(&self, broken: BrokenRule) -> ScenarioError {
        ScenarioError::Rule {
            place: self.place_of(&broken.key),
            message: broken.message,
        }
    }

    /// The text of the file, without the assignments.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The document as a value of type `T`.
    pub fn deserialize<T: DeserializeOwned>(&self) -> Result<T, ScenarioError> {
        let table = self.merged()?;
        let places = KeyPlaces::of(&table);
        let whole = Spanned::new(0..self.text.len(), table);
        T::deserialize(toml::de::Deserializer::from(whole))
            .map_err(|error| self.explain(&error, &places))
    }

    /// Where `key` (`agent.gamma`, `env.goals[0].at`) stands; the nearest enclosing key if it is not written.
    pub fn place_of(&self, key: &str) -> Location {
        let Ok(table) = self.merged() else {
            return Location::File(self.path.clone());
        };
        let places = KeyPlaces::of(&table);
        let mut key = key;
        loop {
            if let Some(span) = places.value(key) {
                return self.place(span.start);
            }
            match key.rfind(['.', '[']) {
                Some(end) => key = &key[..end],
                None => return Location::File(self.path.clone()),
            }
        }
    }

    /// The file's table with the flags laid over it.
    fn merged(&self) -> Result<Table<'_>, ScenarioError> {
        let mut table = DeTable::parse(&self.text)
            .map_err(|error| self.syntax(&error, 0))?
            .into_inner();
        let mut base = self.text.len() + 1;
        for (toml, _) in &self.laid {
            let over = DeTable::parse(toml)
                .map_err(|error| self.syntax(&error, base))?
                .into_inner();
            overlay(&mut table, shifted(over, base));
            base += toml.len() + 1;
        }
        Ok(table)
    }

    /// The place of a byte offset in the sense of the module's head.
    fn place(&self, offset: usize) -> Location {
        let mut base = self.text.len() + 1;
        if offset < base {
            let (line, column) = line_and_column(&self.text, offset);
            return Location::Position {
                file: self.path.clone(),
                line,
                column,
            };
        }
        for (toml, place) in &self.laid {
            base += toml.len() + 1;
            if offset < base {
                return place.clone();
            }
        }
        Location::File(self.path.clone())
    }

    fn syntax(&self, error: &toml::de::Error, base: usize) -> ScenarioError {
        let place = match error.span() {
            Some(span) => self.place(base + span.start),
            None => self.place(base),
        };
        ScenarioError::Syntax {
            place,
            message: error.message().to_owned(),
        }
    }

    /// Turns serde's message into the rule, the key and the nearest right name.
    fn explain(&self, error: &toml::de::Error, places: &KeyPlaces) -> ScenarioError {
        let message = error.message();
        let span = error.span().unwrap_or(0..0);
        let place = self.place(span.start);
        let key = places.key_at(&span).unwrap_or("the file").to_owned();
        let (word, known) = quoted(message);
        let right = || Box::new(Choices::near(&word, known));
        if message.starts_with("unknown field") {
            ScenarioError::UnknownKey {
                place,
                key,
                right: right(),
            }
        } else if message.starts_with("unknown variant") {
            ScenarioError::UnknownChoice {
                place,
                key,
                right: right(),
                value: word,
            }
        } else {
            ScenarioError::Type {
                place,
                key,
                message: plain_types(message),
            }
        }
    }
}

/// `a.b=value` as TOML; none without an `=`.
fn assignment(set: &str) -> Option<String> {
    let (key, value) = set.split_once('=')?;
    let (key, value) = (key.trim(), value.trim());
    if DeValue::parse(value).is_ok() {
        return Some(format!("{key} = {value}"));
    }
    Some(format!("{key} = {}", toml::Value::from(value)))
}

/// Puts `over` on top of `table`, key by key; what is not a table is replaced.
fn overlay<'t>(table: &mut Table<'t>, over: Table<'t>) {
    for (key, value) in over {
        let name: &str = key.get_ref();
        if value.get_ref().is_table()
            && let Some(DeValue::Table(below)) = table.get_mut(name).map(|v| v.get_mut())
        {
            if let DeValue::Table(inner) = value.into_inner() {
                overlay(below, inner);
            }
            continue;
        }
        table.remove(name); // a map keeps its first key, and that one's place is the file's
        table.insert(key, value);
    }
}

/// The same table, `base` bytes further down.
fn shifted(table: Table<'_>, base: usize) -> Table<'_> {
    let shift = |span: Range<usize>| span.start + base..span.end + base;
    table
        .into_iter()
        .map(|(key, value)| {
            let key_span = shift(key.span());
            (
                Spanned::new(key_span, key.into_inner()),
                shifted_value(value, base),
            )
        })
        .collect()
}

fn shifted_value(value: Spanned<DeValue<'_>>, base: usize) -> Spanned<DeValue<'_>> {
    let span = value.span();
    let inner = match value.into_inner() {
        DeValue::Table(table) => DeValue::Table(shifted(table, base)),
        DeValue::Array(items) => {
            DeValue::Array(items.into_iter().map(|v| shifted_value(v, base)).collect())
        }
        other => other,
    };
    Spanned::new(span.start + base..span.end + base, inner)
}

/// The words in backticks of serde's message: the offending one, then the right ones.
fn quoted(message: &str) -> (String, Vec<String>) {
    let mut words = message.split('`').skip(1).step_by(2).map(str::to_owned);
    (words.next().unwrap_or_default(), words.collect())
}

/// serde's "expected f64", in the words of someone who writes TOML.
fn plain_types(message: &str) -> String {
    const WORDS: [(&str, &str); 8] = [
        (
            "wanted string or table",
            "expected one of its words, in quotes",
        ),
        ("expected f64", "expected a number"),
        ("expected usize", "expected a whole number from 0"),
        ("expected u64", "expected a whole number from 0"),
        ("expected u32", "expected a whole number from 0"),
        ("expected a sequence", "expected a list"),
        ("expected a boolean", "expected true or false"),
        ("floating point `", "number `"),
    ];
    let message = match message.split_once("expected struct ") {
        Some((found, _)) => format!("{found}expected a table of keys"), // the type's name is ours, not the user's
        None => message.to_owned(),
    };
    WORDS
        .iter()
        .fold(message, |text, (from, to)| text.replace(from, to))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Default, Deserialize, PartialEq)]
    #[serde(default, deny_unknown_fields)]
    struct Sample {
        agent: Agent,
    }

    #[derive(Debug, Default, Deserialize, PartialEq)]
    #[serde(default, deny_unknown_fields)]
    struct Agent {
        gamma: f64,
        kind: Kind,
        goals: Vec<Agent>,
    }

    #[derive(Debug, Default, Deserialize, PartialEq)]
    #[serde(rename_all = "kebab-case")]
    enum Kind {
        #[default]
        ActorCritic,
        QLearning,
    }

    fn read(text: &str, sets: &[&str]) -> Result<Sample, String> {
        let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
        Document::new(Path::new("x.toml"), text.to_owned(), &sets)
            .and_then(|d| d.deserialize())
            .map_err(|e| e.to_string())
    }

    #[test]
    fn misspelt_key_is_placed_and_corrected() {
        assert_eq!(
            read("\n[agent]\n  gama = 1.0\n", &[]).unwrap_err(),
            "x.toml:3:3: unknown key `agent.gama`; did you mean `gamma`?"
        );
    }

    #[test]
    fn wrong_type_is_placed_at_the_value() {
        assert_eq!(
            read("[agent]\ngamma = \"high\"\n", &[]).unwrap_err(),
            "x.toml:2:9: `agent.gamma`: invalid type: string \"high\", expected a number"
        );
    }

    #[test]
    fn wrong_types_are_told_without_names_of_our_own() {
        assert_eq!(
            read("", &["agent=3"]).unwrap_err(),
            "--set agent=3: `agent`: invalid type: integer `3`, expected a table of keys"
        );
        assert_eq!(
            read("[agent]\nkind = 3\n", &[]).unwrap_err(),
            "x.toml:2:8: `agent.kind`: expected one of its words, in quotes"
        );
    }

    #[test]
    fn wrong_choice_names_the_nearest() {
        assert_eq!(
            read("[agent]\nkind = \"q-leaning\"\n", &[]).unwrap_err(),
            "x.toml:2:8: `agent.kind` cannot be \"q-leaning\"; did you mean `q-learning`?"
        );
    }

    #[test]
    fn keys_inside_lists_are_placed() {
        let error = read("[agent]\ngoals = [{}, { gamm = 2 }]\n", &[]).unwrap_err();
        assert!(
            error.starts_with("x.toml:2:16: unknown key `agent.goals[1].gamm`"),
            "{error}"
        );
    }

    #[test]
    fn flags_win_over_the_file_and_are_blamed_for_their_own_slips() {
        let text = "[agent]\ngamma = 0.5\n";
        let sample = read(text, &["agent.gamma=0.9", "agent.kind=q-learning"]).unwrap();
        assert_eq!(sample.agent.gamma, 0.9);
        assert_eq!(sample.agent.kind, Kind::QLearning);
        assert_eq!(
            read(text, &["agent.kind=q-learning", "agent.gmma=1"]).unwrap_err(),
            "--set agent.gmma=1: unknown key `agent.gmma`; did you mean `gamma`?"
        );
        assert!(
            read(text, &["agent.gamma=high"])
                .unwrap_err()
                .starts_with("--set agent.gamma=high: `agent.gamma`: invalid type")
        );
        assert!(
            read(text, &["agent"])
                .unwrap_err()
                .contains("section.key=value")
        );
    }

    #[test]
    fn syntax_errors_are_placed() {
        let error = read("[agent]\ngamma = = 1\n", &[]).unwrap_err();
        assert!(error.starts_with("x.toml:2:9: not valid TOML"), "{error}");
    }

    #[test]
    fn place_of_an_unwritten_key_is_its_section() {
        let d = Document::new(Path::new("x.toml"), "\n[agent]\n".to_owned(), &[]).unwrap();
        assert_eq!(d.place_of("agent.gamma").to_string(), "x.toml:2:1");
        assert_eq!(d.place_of("run.episodes").to_string(), "x.toml");
    }
}
