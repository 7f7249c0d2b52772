//! Small values that are written in more than one way: places, starts, step limits.

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
    /// an edge list the name of a state. As a start also "random".
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

impl Serialize for MaxSteps {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            MaxSteps::Auto => serializer.serialize_str("auto"),
            MaxSteps::Steps(steps) => serializer.serialize_u64(*steps as u64),
        }
    }
}

impl<'de> Deserialize<'de> for MaxSteps {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct MaxStepsVisitor;
        impl Visitor<'_> for MaxStepsVisitor {
            type Value = MaxSteps;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("\"auto\" or a whole number from 1")
            }
            fn visit_str<E: de::Error>(self, word: &str) -> Result<MaxSteps, E> {
                match word {
                    "auto" => Ok(MaxSteps::Auto),
                    _ => Err(E::invalid_value(de::Unexpected::Str(word), &self)),
                }
            }
            fn visit_i64<E: de::Error>(self, steps: i64) -> Result<MaxSteps, E> {
                let invalid = || E::invalid_value(de::Unexpected::Signed(steps), &self);
                let steps = usize::try_from(steps).map_err(|_| invalid())?;
                if steps == 0 {
                    Err(invalid())
                } else {
                    Ok(MaxSteps::Steps(steps))
                }
            }
            fn visit_u64<E: de::Error>(self, steps: u64) -> Result<MaxSteps, E> {
                match i64::try_from(steps) {
                    Ok(steps) => self.visit_i64(steps),
                    Err(_) => Err(E::invalid_value(de::Unexpected::Unsigned(steps), &self)),
                }
            }
        }
        deserializer.deserialize_any(MaxStepsVisitor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Both {
        start: Place,
        max_steps: MaxSteps,
    }

    #[test]
    fn both_ways_of_writing_survive_a_round_trip() {
        for text in [
            "start = \"top-left\"\nmax_steps = \"auto\"\n",
            "start = [3, 4]\nmax_steps = 17\n",
        ] {
            let both: Both = toml::from_str(text).unwrap();
            assert_eq!(toml::to_string(&both).unwrap(), text);
        }
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
        }
    }
}
