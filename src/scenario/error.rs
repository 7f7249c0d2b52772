//! Errors of a scenario, said with the place and the nearest right name.

use super::examination::MOST_MISTAKES;
use crate::parameter::ParameterError;
use std::fmt;
use std::io::ErrorKind;
use std::path::PathBuf;

/// Place in the input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Location {
    /// A position in a file, both numbers from 1; columns count characters.
    Position {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
    },
    /// A file as a whole.
    File(PathBuf),
    /// An assignment on the command line, as it was typed.
    Flag(String),
    /// One value of a grid, with its key.
    Grid(String),
    /// A setting of an arm that is built in or made up for a comparison: the arm's name, the setting.
    Arm(String, String),
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Location::Position { file, line, column } => {
                write!(f, "{}:{line}:{column}", file.display())
            }
            Location::File(file) => write!(f, "{}", file.display()),
            Location::Flag(text) => write!(f, "--set {text}"),
            Location::Grid(text) => write!(f, "--grid {text}"),
            Location::Arm(name, setting) => write!(f, "arm {name}, {setting}"),
        }
    }
}

/// Reason why a scenario was not accepted: all its mistakes, in the order of the file, those of the command line last.
#[derive(Debug)]
pub struct ScenarioError {
    /// The file.
    pub file: PathBuf,
    /// The scenario's name, if that much could be read.
    pub scenario: Option<String>,
    /// The mistakes; at least one.
    pub mistakes: Vec<Mistake>,
}

impl std::error::Error for ScenarioError {}

/// A line for each mistake, and their number below if there are several.
impl fmt::Display for ScenarioError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, mistake) in self.mistakes.iter().enumerate() {
            let end = if i == 0 { "" } else { "\n" };
            write!(f, "{end}{mistake}")?;
        }
        let more = match self.mistakes.len() {
            1 => return Ok(()),
            MOST_MISTAKES.. => ", and perhaps more",
            _ => "",
        };
        let (n, file) = (self.mistakes.len(), self.file.display());
        write!(f, "\n{n} mistakes in {file}{more}")
    }
}

/// One mistake of a scenario. Its text begins with the [`Location`].
#[derive(Debug)]
#[non_exhaustive]
pub enum Mistake {
    /// A file could not be read.
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
        /// What may have been meant, to be said behind the reason.
        hint: String,
    },
    /// The text is not TOML.
    Syntax {
        /// Where the parser stopped.
        place: Location,
        /// What it expected.
        message: String,
    },
    /// A key that no section has.
    UnknownKey {
        /// Where the key stands.
        place: Location,
        /// The key with its section, `agent.gama`.
        key: String,
        /// The keys that would be right there.
        right: Box<Choices>,
    },
    /// A word that is none of the choices.
    UnknownChoice {
        /// Where the word stands.
        place: Location,
        /// The key it was given to.
        key: String,
        /// The word.
        value: String,
        /// The words that would be right.
        right: Box<Choices>,
    },
    /// A value of the wrong type or form.
    Type {
        /// Where the value stands.
        place: Location,
        /// The key it was given to.
        key: String,
        /// What was expected and what was found.
        message: String,
    },
    /// A value of the right type that breaks a rule, or does not go with another one.
    Rule {
        /// Where the value stands (the whole file, if a default is at odds with what the file says).
        place: Location,
        /// The key to blame.
        key: String,
        /// The rule and what breaks it, with the key's name.
        message: String,
    },
}

impl Mistake {
    /// Where it is.
    pub fn place(&self) -> Location {
        match self {
            Mistake::Read { path, .. } => Location::File(path.clone()),
            Mistake::Syntax { place, .. }
            | Mistake::UnknownKey { place, .. }
            | Mistake::UnknownChoice { place, .. }
            | Mistake::Type { place, .. }
            | Mistake::Rule { place, .. } => place.clone(),
        }
    }

    /// The key to blame, with its section.
    pub fn key(&self) -> Option<&str> {
        match self {
            Mistake::Read { .. } | Mistake::Syntax { .. } => None,
            Mistake::UnknownKey { key, .. }
            | Mistake::UnknownChoice { key, .. }
            | Mistake::Type { key, .. }
            | Mistake::Rule { key, .. } => Some(key),
        }
    }

    /// What is wrong, and what would be right, without the place.
    pub fn message(&self) -> String {
        match self {
            Mistake::Read { source, hint, .. } => match source.kind() {
                ErrorKind::NotFound => format!("there is no such file{hint}"),
                _ => format!("cannot read the file: {source}{hint}"),
            },
            Mistake::Syntax { message, .. } => format!("not valid TOML: {message}"),
            Mistake::UnknownKey { key, right, .. } => format!("unknown key `{key}`{right}"),
            Mistake::UnknownChoice {
                key, value, right, ..
            } => format!("`{key}` cannot be \"{value}\"{right}"),
            Mistake::Type { key, message, .. } => format!("`{key}`: {message}"),
            Mistake::Rule { message, .. } => message.clone(),
        }
    }
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place(), self.message())
    }
}

/// What would have been right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choices {
    /// The one that is nearest in spelling, if one is near.
    pub nearest: Option<String>,
    /// All of them.
    pub all: Vec<String>,
}

impl Choices {
    /// Those that might have been meant by `word`.
    pub fn near(word: &str, all: Vec<String>) -> Self {
        let nearest = nearest(word, all.iter().map(String::as_str)).map(str::to_owned);
        Self { nearest, all }
    }
}

/// The end of a message: "; did you mean …", or the list.
impl fmt::Display for Choices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.nearest {
            Some(nearest) => write!(f, "; did you mean `{nearest}`?"),
            None if self.all.is_empty() => Ok(()),
            None => write!(f, "; it is one of {}", self.all.join(", ")),
        }
    }
}

/// A broken rule before its place is known.
#[derive(Clone, Debug, PartialEq)]
pub struct BrokenRule {
    /// The key with its section, `env.goals[0].at`.
    pub key: String,
    /// The rule and what breaks it.
    pub message: String,
    /// What else is wrong with the same value, each in words.
    pub more: Vec<String>,
    /// Other keys that the rule is about: while one of them is wrong itself, nobody knows whether this rule is broken.
    pub others: Vec<String>,
}

impl BrokenRule {
    /// The rule that `key` breaks. A message that does not name the key is prefixed by it.
    pub fn new(key: impl Into<String>, message: impl Into<String>) -> Self {
        let (key, mut message) = (key.into(), message.into());
        if !message.contains(&key) {
            message = format!("{key}: {message}");
        }
        Self {
            key,
            message,
            more: Vec::new(),
            others: Vec::new(),
        }
    }

    /// The same of a value with which more is wrong.
    pub(super) fn with_more(mut self, more: impl IntoIterator<Item = String>) -> Self {
        let key = &self.key;
        let more = more
            .into_iter()
            .map(|message| Self::new(key, message).message);
        self.more = more.collect();
        self
    }

    /// The same of a rule that is about these keys, too.
    pub(super) fn beside(mut self, others: &[&str]) -> Self {
        self.others.extend(others.iter().map(|&key| key.to_owned()));
        self
    }
}

impl From<ParameterError> for BrokenRule {
    fn from(error: ParameterError) -> Self {
        Self::new(error.path(), error.to_string())
    }
}

/// The entry of `known` that `word` was most likely meant to be: at most a third of its letters differ.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase().replace('_', "-");
    known
        .into_iter()
        .map(|k| (distance(&word, &k.replace('_', "-")), k))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|&(distance, _)| distance <= 0.34)
        .map(|(_, k)| k)
}

/// Share of letters that differ, with swapped neighbours as one slip.
fn distance(a: &str, b: &str) -> f64 {
    1.0 - strsim::normalized_damerau_levenshtein(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_find_their_key_and_strangers_do_not() {
        let known = ["gamma", "num_eigenpairs", "actor_learning_rate"];
        assert_eq!(nearest("gama", known), Some("gamma"));
        assert_eq!(nearest("num-eigenpair", known), Some("num_eigenpairs"));
        assert_eq!(
            nearest("actor_learnig_rate", known),
            Some("actor_learning_rate")
        );
        assert_eq!(nearest("colour", known), None);
    }
}
