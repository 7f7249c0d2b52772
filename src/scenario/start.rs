//! Where episodes begin, as it is written: one place, or several, with weights or without.

use super::error::BrokenRule;
use super::place::Place;
use schemars::JsonSchema;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{self, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;

/// Where episodes begin.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Start {
    /// In one place, or in a random one.
    At(Place),
    /// In one of several, drawn for each episode.
    Drawn(#[schemars(with = "Vec<ListedPlace>")] Vec<WeightedPlace>),
}

/// One of several starts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeightedPlace {
    /// Where it is.
    pub at: Place,
    /// How often episodes begin there, beside the weights of the others (1).
    #[serde(default = "one")]
    pub weight: f64,
}

fn one() -> f64 {
    1.0
}

/// How one of several starts is written.
#[derive(JsonSchema)]
#[serde(untagged)]
#[allow(dead_code, reason = "describes the format to the schema")]
enum ListedPlace {
    /// As likely as any other without a weight.
    Place(Place),
    Weighted(WeightedPlace),
}

impl From<Place> for WeightedPlace {
    fn from(at: Place) -> Self {
        Self { at, weight: one() }
    }
}

impl Start {
    /// Whether there is a place, and every weight is one.
    pub(super) fn validate(&self) -> Result<(), BrokenRule> {
        let Start::Drawn(starts) = self else {
            return Ok(());
        };
        if starts.is_empty() {
            return Err(BrokenRule::new(
                "env.start",
                "env.start = []: episodes begin somewhere; name at least one place",
            ));
        }
        let sound = |weight: f64| weight.is_finite() && weight > 0.0;
        match starts.iter().position(|start| !sound(start.weight)) {
            None => Ok(()),
            Some(i) => Err(BrokenRule::new(
                format!("env.start[{i}].weight"),
                format!(
                    "env.start[{i}].weight = {}: a weight is a finite number above 0",
                    starts[i].weight
                ),
            )),
        }
    }
}

/// An element of a list: a coordinate of one place, or one place of several.
enum Item {
    Coordinate(usize),
    Place(WeightedPlace),
}

impl<'de> Deserialize<'de> for Item {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ItemVisitor;
        impl<'de> Visitor<'de> for ItemVisitor {
            type Value = Item;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(
                    "a row or column counted from 0, a place, or { at = PLACE, weight = NUMBER }",
                )
            }
            fn visit_str<E: de::Error>(self, name: &str) -> Result<Item, E> {
                Ok(Item::Place(Place::from(name).into()))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Item, A::Error> {
                let place = Place::deserialize(SeqAccessDeserializer::new(seq))?;
                Ok(Item::Place(place.into()))
            }
            fn visit_i64<E: de::Error>(self, number: i64) -> Result<Item, E> {
                let coordinate = usize::try_from(number);
                let negative = |_| E::invalid_value(de::Unexpected::Signed(number), &self);
                coordinate.map(Item::Coordinate).map_err(negative)
            }
            fn visit_u64<E: de::Error>(self, number: u64) -> Result<Item, E> {
                let coordinate = usize::try_from(number);
                let huge = |_| E::invalid_value(de::Unexpected::Unsigned(number), &self);
                coordinate.map(Item::Coordinate).map_err(huge)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Item, A::Error> {
                WeightedPlace::deserialize(MapAccessDeserializer::new(map)).map(Item::Place)
            }
        }
        deserializer.deserialize_any(ItemVisitor)
    }
}

impl<'de> Deserialize<'de> for Start {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct StartVisitor;
        impl<'de> Visitor<'de> for StartVisitor {
            type Value = Start;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(
                    "a place: a name such as \"top-left\", or [row, column] counted from 0; or a list of places, or of \
                     { at = PLACE, weight = NUMBER }",
                )
            }
            fn visit_str<E: de::Error>(self, name: &str) -> Result<Start, E> {
                Ok(Start::At(Place::from(name)))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Start, A::Error> {
                let (mut coordinates, mut places) = (Vec::new(), Vec::new());
                while let Some(item) = seq.next_element()? {
                    match item {
                        Item::Coordinate(number) => coordinates.push(number),
                        Item::Place(place) => places.push(place),
                    }
                }
                match (coordinates.as_slice(), places) {
                    ([], places) => Ok(Start::Drawn(places)),
                    (&[row, col], places) if places.is_empty() => {
                        Ok(Start::At(Place::Cell([row, col])))
                    }
                    (numbers, places) => Err(de::Error::invalid_length(
                        numbers.len() + places.len(),
                        &self,
                    )),
                }
            }
        }
        deserializer.deserialize_any(StartVisitor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Given {
        start: Start,
    }

    fn read(text: &str) -> Result<Start, toml::de::Error> {
        toml::from_str::<Given>(&format!("start = {text}")).map(|given| given.start)
    }

    #[test]
    fn every_way_of_writing_survives_a_round_trip() {
        let weighted = |at, weight| WeightedPlace { at, weight };
        let several = vec![
            weighted(Place::from("top-left"), 2.0),
            weighted(Place::Cell([3, 4]), 1.0),
        ];
        let equally = ["top-left", "center"].map(|name| Place::from(name).into());
        let cells = [[1, 2], [3, 4]].map(|cell| Place::Cell(cell).into());
        for (text, start) in [
            ("[\"top-left\", \"center\"]", Start::Drawn(equally.to_vec())),
            ("[[1, 2], [3, 4]]", Start::Drawn(cells.to_vec())),
            ("\"random\"", Start::At(Place::from("random"))),
            ("[3, 4]", Start::At(Place::Cell([3, 4]))),
            (
                "[{ at = \"top-left\", weight = 2 }, { at = [3, 4] }]",
                Start::Drawn(several),
            ),
            ("[]", Start::Drawn(vec![])),
        ] {
            let read = read(text).unwrap();
            assert_eq!(read, start);
            let written = toml::to_string(&Given { start: read }).unwrap();
            assert_eq!(toml::from_str::<Given>(&written).unwrap().start, start);
        }
    }

    #[test]
    fn nonsense_is_told_what_was_expected() {
        for text in ["3", "[1]", "[1, 2, 3]", "[1, { at = [1, 2] }]"] {
            let message = read(text).unwrap_err().message().to_owned();
            assert!(message.contains("a list of places, or of"), "{message}");
        }
        assert!(read("[1, -2]").unwrap_err().message().contains("-2"));
        let error = read("[{ at = \"center\", wieght = 2 }]").unwrap_err();
        assert!(error.message().contains("weight"), "{error}");
    }

    #[test]
    fn weights_are_finite_and_above_zero() {
        let key = |text: &str| read(text).unwrap().validate().map_err(|broken| broken.key);
        assert_eq!(key("[{ at = \"a\", weight = 0.5 }]"), Ok(()));
        assert_eq!(key("[]"), Err("env.start".to_owned()));
        for bad in ["0", "-1", "inf", "nan"] {
            let text = format!("[{{ at = \"a\" }}, {{ at = \"b\", weight = {bad} }}]");
            assert_eq!(key(&text), Err("env.start[1].weight".to_owned()), "{bad}");
        }
    }
}
