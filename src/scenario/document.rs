//! A TOML file with assignments from the command line laid over it, where every value still knows its place.
//!
//! The parser gives each value the byte range it came from. Assignments are parsed one by one as small documents
//! of their own; their ranges are shifted past the end of the file, as if they stood below it. So one number
//! tells, for an error in any value, whether the file or a flag is to blame and where.

use super::Scenario;
use super::error::{BrokenRule, Choices, Location, Mistake, ScenarioError};
use super::examination::MOST_MISTAKES;
use super::keys::{KeyPlaces, line_and_column};
use serde::de::DeserializeOwned;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

type Table<'t> = DeTable<'t>;

/// A parsed scenario file, before it becomes types.
#[derive(Clone)]
pub(super) struct Document {
    path: PathBuf,
    text: String,
    /// `key = value` as TOML, beside what to blame for it.
    laid: Vec<(String, Location)>,
    /// Keys that are passed over, by their ranges, and the words that stand in for the values of some.
    mended: Vec<(Range<usize>, Option<String>)>,
}

/// One assignment that is laid over a document.
#[derive(Clone)]
pub(super) struct Setting {
    /// `section.key=value`. A value that is not TOML is taken as a string, so that `shaping.potential=none` needs no quotes.
    pub text: String,
    /// What is to blame for it.
    pub place: Location,
}

impl Setting {
    /// Those of a command line.
    pub fn typed(sets: &[String]) -> Vec<Self> {
        let settings = sets.iter().map(|set| Self {
            text: set.clone(),
            place: Location::Flag(set.clone()),
        });
        settings.collect()
    }

    /// `section.key`
    pub fn key(&self) -> &str {
        self.text.split('=').next().unwrap_or_default().trim()
    }
}

/// A mistake, and how to look past it.
pub(super) struct Found {
    pub mistake: Mistake,
    /// The key to blame as the document names it.
    pub key: String,
    /// Its range; none if nothing that is written is to blame.
    pub range: Option<Range<usize>>,
    /// The word that must have been meant, of a misspelt key or of a misspelt choice.
    pub meant: Option<String>,
}

impl Document {
    /// A document from its text; `path` only serves messages.
    ///
    /// # Errors
    /// Wherever the text is not TOML.
    pub fn new(path: &Path, text: String) -> Result<Self, ScenarioError> {
        let document = Self {
            path: path.to_owned(),
            text,
            laid: Vec::new(),
            mended: Vec::new(),
        };
        let (_, errors) = DeTable::parse_recoverable(&document.text);
        let errors = errors.iter().map(|error| Mistake::Syntax {
            place: document.place(error.span().map_or(0, |span| span.start)),
            message: error.message().to_owned(),
        });
        let mut mistakes: Vec<Mistake> = errors.collect();
        // What else the parser stumbles over in a line follows from the first.
        mistakes.dedup_by_key(|mistake| document.order(&mistake.place()).0);
        mistakes.truncate(MOST_MISTAKES);
        match mistakes.is_empty() {
            true => Ok(document),
            false => Err(ScenarioError {
                file: document.path,
                scenario: None,
                mistakes,
            }),
        }
    }

    /// Lays an assignment over the document.
    ///
    /// # Errors
    /// If it is none.
    pub fn lay(&mut self, Setting { text, place }: &Setting) -> Result<(), Mistake> {
        let not_toml = |message: &str| Mistake::Syntax {
            place: place.clone(),
            message: message.to_owned(),
        };
        let toml = assignment(text)
            .ok_or_else(|| not_toml("an assignment looks like section.key=value"))?;
        DeTable::parse(&toml).map_err(|error| not_toml(error.message()))?;
        self.laid.push((toml, place.clone()));
        Ok(())
    }

    /// The file that it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The text of the file, without the assignments.
    pub fn into_text(self) -> String {
        self.text
    }

    /// Every key that is written, with its place, in the order of the places.
    pub fn written(&self) -> Vec<(String, Location)> {
        let places = KeyPlaces::of(&self.merged());
        let keys = places
            .keys()
            .map(|(key, range)| (key.to_owned(), self.place(range.start)));
        let mut keys: Vec<_> = keys.collect();
        keys.sort_by_key(|(_, place)| self.order(place));
        keys
    }

    /// Passes over the key at `range` from now on, or over its value, for which `word` then stands in. False if that has been
    /// done before.
    pub fn mend(&mut self, range: Range<usize>, word: Option<String>) -> bool {
        let is_new = !self.mended.contains(&(range.clone(), word.clone()));
        self.mended.retain(|(mended, _)| *mended != range);
        self.mended.push((range, word));
        is_new
    }

    /// The document as a value of type `T`.
    pub fn deserialize<T: DeserializeOwned>(&self) -> Result<T, Box<Found>> {
        let table = self.mended();
        let whole = Spanned::new(0..self.text.len(), table);
        T::deserialize(toml::de::Deserializer::from(whole))
            .map_err(|error| Box::new(self.explain(&error)))
    }

    /// A broken rule with its place.
    pub fn blame(&self, broken: BrokenRule) -> Found {
        let written = KeyPlaces::of(&self.mended());
        // A goal may be written as its place alone.
        let as_place = broken.key.strip_suffix(".at");
        let range = written
            .key(&broken.key)
            .or_else(|| as_place.and_then(|goal| written.key(goal)))
            .cloned();
        let (mut key, mut message) = (broken.key, broken.message);
        let place = self.place_of(&key);
        // Where an element before it is passed over, the file counts on.
        let places = KeyPlaces::of(&self.merged());
        if let Some(written) = range.as_ref().and_then(|range| places.key_at(range))
            && written != key
        {
            message = message.replace(&key, written);
            key = written.to_owned();
        }
        Found {
            mistake: Mistake::Rule {
                place,
                key: key.clone(),
                message,
            },
            key,
            range,
            meant: None,
        }
    }

    /// Where `key` (`agent.gamma`, `env.goals[0].at`) stands; the nearest enclosing key if it is not written.
    pub fn place_of(&self, key: &str) -> Location {
        let places = KeyPlaces::of(&self.mended());
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

    /// Whether `key` is written, passed over or not.
    pub fn is_written(&self, key: &str) -> bool {
        KeyPlaces::of(&self.merged()).key(key).is_some()
    }

    /// Orders places as they stand: those in the file first, then what is laid over it.
    pub fn order(&self, place: &Location) -> (usize, usize) {
        match place {
            Location::Position { line, column, .. } => (*line, *column),
            other => {
                let laid = self.laid.iter().position(|(_, place)| place == other);
                (usize::MAX, laid.map_or(0, |laid| laid + 1))
            }
        }
    }

    /// The file's table with the assignments laid over it.
    fn merged(&self) -> Table<'_> {
        let mut table = parsed(&self.text);
        let mut base = self.text.len() + 1;
        for (toml, _) in &self.laid {
            overlay(&mut table, shifted(parsed(toml), base));
            base += toml.len() + 1;
        }
        table
    }

    /// The same without what is passed over.
    fn mended(&self) -> Table<'_> {
        match self.mended.is_empty() {
            true => self.merged(),
            false => self.mend_table(self.merged()),
        }
    }

    fn mend_table<'t>(&self, table: Table<'t>) -> Table<'t> {
        let entries = table.into_iter();
        entries
            .filter_map(|(key, value)| {
                let value = self.mend_value(&key.span(), value)?;
                Some((key, value))
            })
            .collect()
    }

    fn mend_value<'t>(
        &self,
        key: &Range<usize>,
        value: Spanned<DeValue<'t>>,
    ) -> Option<Spanned<DeValue<'t>>> {
        let mut mended = self.mended.iter();
        let span = value.span();
        let inner = match (mended.find(|(range, _)| range == key), value.into_inner()) {
            (Some((_, None)), _) => return None,
            (Some((_, Some(word))), _) => DeValue::String(word.clone().into()),
            (None, DeValue::Table(table)) => DeValue::Table(self.mend_table(table)),
            (None, DeValue::Array(items)) => {
                let items = items.into_iter();
                let kept = items.filter_map(|item| self.mend_value(&item.span(), item));
                DeValue::Array(kept.collect())
            }
            (None, other) => other,
        };
        Some(Spanned::new(span, inner))
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

    /// Turns serde's message into the rule, the key and the nearest right name.
    fn explain(&self, error: &toml::de::Error) -> Found {
        let message = error.message();
        let span = error.span().unwrap_or(0..0);
        let place = self.place(span.start);
        let places = KeyPlaces::of(&self.merged());
        let written = places.key_at(&span);
        let range = written.and_then(|key| places.key(key)).cloned();
        let key = written.unwrap_or("the file").to_owned();
        let (word, known) = quoted(message);
        let mut right = Box::new(Choices::near(&word, known));
        if right.nearest.is_none() && key == word {
            right.nearest = in_a_section(&word);
        }
        let (mistake, meant) = if message.starts_with("unknown field") {
            let meant = right.nearest.clone();
            let key = key.clone();
            (Mistake::UnknownKey { place, key, right }, meant)
        } else if message.starts_with("unknown variant") {
            let (meant, value) = (right.nearest.clone(), word);
            let key = key.clone();
            let mistake = Mistake::UnknownChoice {
                place,
                key,
                value,
                right,
            };
            (mistake, meant)
        } else {
            let message = plain_types(message);
            let key = key.clone();
            (
                Mistake::Type {
                    place,
                    key,
                    message,
                },
                None,
            )
        };
        Found {
            mistake,
            key,
            range,
            meant,
        }
    }
}

/// The key of a section that is called `word`, if there is just one.
fn in_a_section(word: &str) -> Option<String> {
    let settings = Scenario::default().settings().into_keys();
    let mut called =
        settings.filter(|key| key.split_once('.').is_some_and(|(_, name)| name == word));
    called.next().filter(|_| called.next().is_none())
}

/// The table of a text that was found to be TOML.
fn parsed(toml: &str) -> Table<'_> {
    let table = DeTable::parse(toml).expect("it was TOML when it was taken in");
    table.into_inner()
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
        let mut document = Document::new(Path::new("x.toml"), text.to_owned())
            .map_err(|refused| refused.to_string())?;
        for setting in Setting::typed(&sets) {
            document
                .lay(&setting)
                .map_err(|mistake| mistake.to_string())?;
        }
        let read = document.deserialize();
        read.map_err(|found| found.mistake.to_string())
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
        let d = Document::new(Path::new("x.toml"), "\n[agent]\n".to_owned()).unwrap();
        assert_eq!(d.place_of("agent.gamma").to_string(), "x.toml:2:1");
        assert_eq!(d.place_of("run.episodes").to_string(), "x.toml");
    }
}
