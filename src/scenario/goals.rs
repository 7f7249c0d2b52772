//! Goals as a scenario writes them: a list of places, or one that each seed draws.

use super::place::Place;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{self, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;
use std::fmt;

/// One goal, written as a table or as its place alone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GoalSpec {
    /// Where it is.
    pub at: Place,
    /// What it pays on top of a step, if not what `reward` says; edge-list: if the file does not say it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reward: Option<f64>,
}

/// How a goal is written that is not just a place.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct GoalTable {
    /// Where it is.
    at: Place,
    /// What it pays on top of a step, if not what `reward` says; edge-list: if the file does not say it.
    reward: Option<f64>,
}

/// How a goal is written.
#[derive(JsonSchema)]
#[serde(untagged)]
#[allow(dead_code, reason = "describes the format to the schema")]
enum Written {
    /// One that pays what `reward` says.
    Place(Place),
    Table(GoalTable),
}

impl JsonSchema for GoalSpec {
    fn schema_name() -> Cow<'static, str> {
        "GoalSpec".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Written::json_schema(generator)
    }
}

impl<'de> Deserialize<'de> for GoalSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct GoalVisitor;
        impl<'de> Visitor<'de> for GoalVisitor {
            type Value = GoalSpec;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(
                    "a place: a name such as \"top-left\", or [row, column] counted from 0; or { at = PLACE, reward = NUMBER }",
                )
            }
            fn visit_str<E: de::Error>(self, name: &str) -> Result<GoalSpec, E> {
                Ok(Place::from(name).into())
            }
            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<GoalSpec, A::Error> {
                Place::deserialize(SeqAccessDeserializer::new(seq)).map(GoalSpec::from)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<GoalSpec, A::Error> {
                let GoalTable { at, reward } =
                    GoalTable::deserialize(MapAccessDeserializer::new(map))?;
                Ok(GoalSpec { at, reward })
            }
        }
        deserializer.deserialize_any(GoalVisitor)
    }
}

impl From<Place> for GoalSpec {
    fn from(at: Place) -> Self {
        Self { at, reward: None }
    }
}

/// A place where episodes end that is no goal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HazardSpec {
    /// Where it is.
    pub at: Place,
    /// What it pays on top of a step.
    pub reward: f64,
}

/// Goals of a world.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Goals {
    /// "random": one, where each seed of a run draws it.
    Drawn(Draw),
    /// These, whatever the seed.
    Listed(Vec<GoalSpec>),
}

/// How a goal is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Draw {
    /// Each place that can be reached is equally likely.
    Random,
}

impl<'de> Deserialize<'de> for Goals {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct GoalsVisitor;
        impl<'de> Visitor<'de> for GoalsVisitor {
            type Value = Goals;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("\"random\" or a list of goals such as [\"top-right\"] or [{ at = [0, 3], reward = 2 }]")
            }
            fn visit_str<E: de::Error>(self, word: &str) -> Result<Goals, E> {
                match word {
                    "random" => Ok(Goals::Drawn(Draw::Random)),
                    _ => Err(E::invalid_value(de::Unexpected::Str(word), &self)),
                }
            }
            fn visit_seq<A: SeqAccess<'de>>(self, goals: A) -> Result<Goals, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(goals)).map(Goals::Listed)
            }
        }
        deserializer.deserialize_any(GoalsVisitor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct World {
        goals: Goals,
    }

    #[test]
    fn both_ways_of_writing_survive_a_round_trip() {
        for text in [
            "goals = \"random\"\n",
            "[[goals]]\nat = \"center\"\n\n[[goals]]\nat = [3, 4]\nreward = 2.0\n",
        ] {
            let world: World = toml::from_str(text).unwrap();
            assert_eq!(toml::to_string(&world).unwrap(), text);
        }
        let places: World = toml::from_str("goals = [\"center\", [3, 4]]").unwrap();
        let tables: World =
            toml::from_str("goals = [{ at = \"center\" }, { at = [3, 4] }]").unwrap();
        assert_eq!(places, tables);
    }

    #[test]
    fn nonsense_is_told_what_was_expected() {
        for (text, place) in [
            (
                "goals = \"rnadom\"",
                "1 | goals = \"rnadom\"\n  |         ^^^^^^^^",
            ),
            ("goals = 3", "expected \"random\" or a list of goals"),
            (
                "goals = [{ att = [0, 1] }]",
                "unknown field `att`, expected `at` or `reward`",
            ),
            ("goals = [3]", "expected a place: a name such as"),
        ] {
            let message = toml::from_str::<World>(text).unwrap_err().to_string();
            assert!(message.contains(place), "{message}");
        }
    }
}
