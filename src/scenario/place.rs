//! Small values that are written in more than one way: places, starts, limits.

use schemars::JsonSchema;
use serde::de::{self, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// A place: a cell, a landmark of a map, or a state of an edge list.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Place {
    /// Row and column, counted from 0.
    Cell([usize; 2]),
    /// On a map "top-left", "top-right", "bottom-left", "bottom-right", "center" or "farthest" (from the start); in
    /// an edge list the name of a state. As a start also "random", unless a state of the edge list is called so.
    Named(String),
}

impl From<&str> for Place {
    fn from(name: &str) -> Self {
        Place::Named(name.to_owned())
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Cell([row, col]) => write!(f, "[{row}, {col}]"),
            Place::Named(name) => f.write_str(name),
        }
    }
}

impl<'de> Deserialize<'de> for Place {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PlaceVisitor;
        impl<'de> Visitor<'de> for PlaceVisitor {
            type Value = Place;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a place: a name such as \"top-left\", or [row, column] counted from 0")
            }
            fn visit_str<E: de::Error>(self, name: &str) -> Result<Place, E> {
                Ok(Place::Named(name.to_owned()))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Place, A::Error> {
                let missing = |n| de::Error::invalid_length(n, &self);
                let row = seq.next_element()?.ok_or_else(|| missing(0))?;
                let col = seq.next_element()?.ok_or_else(|| missing(1))?;
                match seq.next_element::<de::IgnoredAny>()? {
                    None => Ok(Place::Cell([row, col])),
                    Some(_) => Err(missing(3)),
                }
            }
        }
        deserializer.deserialize_any(PlaceVisitor)
    }
}

/// After how many steps an episode is cut off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, JsonSchema)]
#[schemars(with = "AutoOrNumber")]
pub enum MaxSteps {
    /// "auto": ten times the number of states.
    #[default]
    Auto,
    /// So many.
    Steps(usize),
}

impl MaxSteps {
    /// The number given; none for "auto".
    pub fn given(self) -> Option<usize> {
        match self {
            MaxSteps::Auto => None,
            MaxSteps::Steps(steps) => Some(steps),
        }
    }
}

/// After how many episodes goals move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, JsonSchema)]
#[schemars(with = "HalfOrNumber")]
pub enum MoveAfter {
    /// "half": half of the run's episodes, rounded up.
    #[default]
    Half,
    /// So many.
    Episodes(usize),
}

impl MoveAfter {
    /// The number of episodes with the first goals, in a run of `episodes`.
    pub fn resolved(self, episodes: usize) -> usize {
        match self {
            MoveAfter::Half => episodes.div_ceil(2),
            MoveAfter::Episodes(given) => given,
        }
    }
}

/// How [`MaxSteps`] is written.
#[derive(JsonSchema)]
#[serde(untagged)]
#[schemars(rename = "MaxSteps")]
#[allow(dead_code, reason = "describes the format to the schema")]
enum AutoOrNumber {
    Word(Auto),
    Number(usize),
}

#[derive(JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[allow(dead_code, reason = "describes the format to the schema")]
enum Auto {
    Auto,
}

/// How [`MoveAfter`] is written.
#[derive(JsonSchema)]
#[serde(untagged)]
#[schemars(rename = "MoveAfter")]
#[allow(dead_code, reason = "describes the format to the schema")]
enum HalfOrNumber {
    Word(Half),
    Number(usize),
}

#[derive(JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[allow(dead_code, reason = "describes the format to the schema")]
enum Half {
    Half,
}

impl Serialize for MaxSteps {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            MaxSteps::Auto => serializer.serialize_str("auto"),
            MaxSteps::Steps(steps) => serializer.serialize_u64(*steps as u64),
        }
    }
}

impl Serialize for MoveAfter {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            MoveAfter::Half => serializer.serialize_str("half"),
            MoveAfter::Episodes(episodes) => serializer.serialize_u64(*episodes as u64),
        }
    }
}

impl<'de> Deserialize<'de> for MaxSteps {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let given = deserializer.deserialize_any(WordOr("auto"))?;
        Ok(given.map_or(MaxSteps::Auto, MaxSteps::Steps))
    }
}

impl<'de> Deserialize<'de> for MoveAfter {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let given = deserializer.deserialize_any(WordOr("half"))?;
        Ok(given.map_or(MoveAfter::Half, MoveAfter::Episodes))
    }
}

/// Reads a whole number from 1, or this word, which is none.
struct WordOr(&'static str);

impl Visitor<'_> for WordOr {
    type Value = Option<usize>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\"{}\" or a whole number from 1", self.0)
    }

    fn visit_str<E: de::Error>(self, word: &str) -> Result<Option<usize>, E> {
        if word == self.0 {
            Ok(None)
        } else {
            Err(E::invalid_value(de::Unexpected::Str(word), &self))
        }
    }

    fn visit_i64<E: de::Error>(self, number: i64) -> Result<Option<usize>, E> {
        match usize::try_from(number) {
            Ok(positive @ 1..) => Ok(Some(positive)),
            _ => Err(E::invalid_value(de::Unexpected::Signed(number), &self)),
        }
    }

    fn visit_u64<E: de::Error>(self, number: u64) -> Result<Option<usize>, E> {
        match i64::try_from(number) {
            Ok(number) => self.visit_i64(number),
            Err(_) => Err(E::invalid_value(de::Unexpected::Unsigned(number), &self)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Both {
        start: Place,
        max_steps: MaxSteps,
        #[serde(default)]
        goals_move_after: MoveAfter,
    }

    #[test]
    fn both_ways_of_writing_survive_a_round_trip() {
        for text in [
            "start = \"top-left\"\nmax_steps = \"auto\"\ngoals_move_after = \"half\"\n",
            "start = [3, 4]\nmax_steps = 17\ngoals_move_after = 5\n",
        ] {
            let both: Both = toml::from_str(text).unwrap();
            assert_eq!(toml::to_string(&both).unwrap(), text);
        }
    }

    #[test]
    fn half_of_the_episodes_is_rounded_up() {
        assert_eq!([1, 2, 5].map(|n| MoveAfter::Half.resolved(n)), [1, 1, 3]);
        assert_eq!(MoveAfter::Episodes(7).resolved(500), 7);
    }

    #[test]
    fn nonsense_is_told_what_was_expected() {
        let message = |text: &str| {
            toml::from_str::<Both>(text)
                .unwrap_err()
                .message()
                .to_owned()
        };
        assert!(message("start = 3\nmax_steps = 1").contains("expected a place"));
        assert!(message("start = [1, 2, 3]\nmax_steps = 1").contains("expected a place"));
        assert!(message("start = [1, -2]\nmax_steps = 1").contains("-2"));
        for steps in ["0", "-4", "\"automatic\"", "1.5"] {
            let text = format!("start = \"center\"\nmax_steps = {steps}");
            assert!(
                message(&text).contains("\"auto\" or a whole number"),
                "{text}"
            );
            let text = format!("start = \"center\"\nmax_steps = 1\ngoals_move_after = {steps}");
            assert!(
                message(&text).contains("\"half\" or a whole number"),
                "{text}"
            );
        }
    }
}
