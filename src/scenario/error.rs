//! What can be wrong with a scenario, said with the place and the nearest right name.

use std::fmt;
use std::path::PathBuf;

/// Where in the input something stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
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
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Position { file, line, column } => {
                write!(f, "{}:{line}:{column}", file.display())
            }
            Place::File(file) => write!(f, "{}", file.display()),
            Place::Flag(text) => write!(f, "--set {text}"),
        }
    }
}

/// Why a scenario was not accepted. Every message begins with the [`Place`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// A file could not be read.
    #[error("{path}: cannot read the file: {source}", path = path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The text is not TOML.
    #[error("{place}: not valid TOML: {message}")]
    Syntax {
        /// Where the parser stopped.
        place: Place,
        /// What it expected.
        message: String,
    },
    /// A key that no section has.
    #[error("{place}: unknown key `{key}`{}", suggestion(nearest, known))]
    UnknownKey {
        /// Where the key stands.
        place: Place,
        /// The key with its section, `agent.gama`.
        key: String,
        /// The right key that is nearest in spelling.
        nearest: Option<String>,
        /// Every key that would be right there.
        known: Vec<String>,
    },
    /// A word that is none of the choices.
    #[error("{place}: `{key}` cannot be \"{value}\"{}", suggestion(nearest, known))]
    UnknownChoice {
        /// Where the word stands.
        place: Place,
        /// The key it was given to.
        key: String,
        /// The word.
        value: String,
        /// The choice that is nearest in spelling.
        nearest: Option<String>,
        /// Every choice.
        known: Vec<String>,
    },
    /// A value of the wrong type or form.
    #[error("{place}: `{key}`: {message}")]
    Type {
        /// Where the value stands.
        place: Place,
        /// The key it was given to.
        key: String,
        /// What was expected and what was found.
        message: String,
    },
    /// A value of the right type that breaks a rule, or does not go with another one.
    #[error("{place}: `{key}` {rule}")]
    Rule {
        /// Where the value stands (the whole file, if a default is at odds with what the file says).
        place: Place,
        /// The key.
        key: String,
        /// The rule, as the end of a sentence that begins with the key.
        rule: String,
    },
    /// A row of an edge list cannot be used.
    #[error("{place}: {message}")]
    EdgeList {
        /// The row.
        place: Place,
        /// What is wrong with it.
        message: String,
    },
}

/// "; did you mean …", or the list of what would be right.
fn suggestion(nearest: &Option<String>, known: &[String]) -> String {
    match nearest {
        Some(nearest) => format!("; did you mean `{nearest}`?"),
        None if known.is_empty() => String::new(),
        None => format!("; it is one of {}", known.join(", ")),
    }
}

/// A broken rule before its place is known: the key, and the rest of the sentence.
#[derive(Clone, Debug, PartialEq)]
pub struct BrokenRule {
    /// The key with its section, `env.goals`.
    pub key: String,
    /// The rule, as the end of a sentence that begins with the key.
    pub rule: String,
}

impl BrokenRule {
    /// The rule that `key` breaks.
    pub fn new(key: impl Into<String>, rule: impl Into<String>) -> Self {
        Self {
            key: key.into(),
            rule: rule.into(),
        }
    }

    /// `Err` of this rule unless it holds.
    pub fn unless(holds: bool, key: &str, rule: impl Into<String>) -> Result<(), Self> {
        if holds {
            Ok(())
        } else {
            Err(Self::new(key, rule))
        }
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
