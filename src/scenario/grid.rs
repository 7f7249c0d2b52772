//! Grids: every combination of a few values of a few keys, each laid over one scenario as `--set` would.
//!
//! ```text
//! KEY=V1,V2,…     each V is what may stand after `--set KEY=`; commas within quotes, brackets and braces are the value's own
//! ```

use super::document::Setting;
use super::error::Location;
use super::{Arm, Loaded, Scenario, ScenarioError};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::str::FromStr;

/// More points than these are a slip of the finger.
const MOST_POINTS: usize = 100_000;

/// One key and the values that it takes, `agent.gamma=0.9,0.99`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Axis {
    /// The key with its section.
    pub key: String,
    /// Its values as they were written, each once; at least one.
    pub values: Vec<String>,
}

/// Reason why a grid is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GridError {
    /// There is no key, or nothing after it.
    #[error("expected section.key=value,value,…")]
    Assignment,
    /// There is nothing between two commas, or at an end.
    #[error("there is nothing between two commas of `{0}`; a text that is empty is \"\"")]
    Empty(String),
    /// Quotes or brackets do not pair.
    #[error("a quote or a bracket of `{0}` is not closed")]
    Unclosed(String),
    /// One key has two axes.
    #[error("--grid: `{0}` is given twice; name all its values at once")]
    Twice(String),
    /// It has too many points.
    #[error("--grid: these are more than {MOST_POINTS} points")]
    TooMany,
}

impl FromStr for Axis {
    type Err = GridError;

    fn from_str(text: &str) -> Result<Self, GridError> {
        let (key, list) = text.split_once('=').ok_or(GridError::Assignment)?;
        let (key, list) = (key.trim(), list.trim());
        if key.is_empty() || list.is_empty() {
            return Err(GridError::Assignment);
        }
        let mut values: Vec<String> = Vec::new();
        for value in split(list).ok_or_else(|| GridError::Unclosed(list.to_owned()))? {
            match value.trim() {
                "" => return Err(GridError::Empty(list.to_owned())),
                value if values.iter().any(|known| known == value) => {}
                value => values.push(value.to_owned()),
            }
        }
        let key = key.to_owned();
        Ok(Self { key, values })
    }
}

/// The text split at those commas that stand in no quotes and no brackets; none if one of these is left open.
fn split(text: &str) -> Option<Vec<&str>> {
    let (mut parts, mut from) = (Vec::new(), 0);
    let (mut open, mut quote, mut escaped) = (Vec::new(), None, false);
    for (at, c) in text.char_indices() {
        match (quote, c) {
            (Some('"'), '\\') if !escaped => {
                escaped = true;
                continue;
            }
            (Some(begun), c) if c == begun && !escaped => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(c),
            (None, '[') => open.push(']'),
            (None, '{') => open.push('}'),
            (None, ']' | '}') if open.pop() != Some(c) => return None,
            (None, ',') if open.is_empty() => {
                parts.push(&text[from..at]);
                from = at + 1;
            }
            (None, _) => {}
        }
        escaped = false;
    }
    parts.push(&text[from..]);
    (open.is_empty() && quote.is_none()).then_some(parts)
}

/// One point of a grid.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GridPoint {
    /// The arm that is laid over it; the scenario as it stands, if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arm: Option<String>,
    /// Key and value of each axis, in their order.
    pub settings: Vec<(String, String)>,
}

/// Every point of these axes for each arm, the last axis changing first; one point where there are no axes, and as many if
/// there are no arms as with one.
///
/// # Errors
/// If a key has two axes, or there are too many points.
pub fn grid(arms: &[String], axes: &[Axis]) -> Result<Vec<GridPoint>, GridError> {
    for (i, axis) in axes.iter().enumerate() {
        if axes[..i].iter().any(|earlier| earlier.key == axis.key) {
            return Err(GridError::Twice(axis.key.clone()));
        }
    }
    let counts = axes.iter().map(|axis| axis.values.len());
    let count = counts.fold(arms.len().max(1), usize::saturating_mul);
    if count > MOST_POINTS {
        return Err(GridError::TooMany);
    }
    let of_arm = |arm: &String| GridPoint {
        arm: Some(arm.clone()),
        settings: Vec::new(),
    };
    let mut points: Vec<GridPoint> = match arms.is_empty() {
        true => vec![GridPoint::default()],
        false => arms.iter().map(of_arm).collect(),
    };
    for axis in axes {
        let longer = points.iter().flat_map(|point| {
            axis.values.iter().map(|value| {
                let mut point = point.clone();
                point.settings.push((axis.key.clone(), value.clone()));
                point
            })
        });
        points = longer.collect();
    }
    Ok(points)
}

impl GridPoint {
    /// The scenario at this point, without its arm: `text` is the file at `path`, and `sets` are assignments laid over it first.
    ///
    /// # Errors
    /// [`ScenarioError`], with the value of the grid to blame where it is one.
    pub fn load(&self, path: &Path, text: &str, sets: &[String]) -> Result<Loaded, ScenarioError> {
        Scenario::parse_laid(path, text.to_owned(), &self.laid(sets))
    }

    /// The arm `name` laid over what [`load`](Self::load) made of the same; none if there is no such arm.
    ///
    /// # Errors
    /// If the arm does not go with the scenario.
    pub fn lay_arm(
        &self,
        name: &str,
        loaded: &Loaded,
        path: &Path,
        sets: &[String],
    ) -> Result<Option<Arm>, ScenarioError> {
        let below = self.laid(sets);
        let scenario = &loaded.scenario;
        scenario.lay_arm_over(name, path, &loaded.text, &below)
    }

    fn laid(&self, sets: &[String]) -> Vec<Setting> {
        let settings = self.settings.iter().map(|(key, value)| {
            let text = format!("{key}={value}");
            Setting {
                place: Location::Grid(text.clone()),
                text,
            }
        });
        Setting::typed(sets).into_iter().chain(settings).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<String> {
        text.parse::<Axis>().unwrap().values
    }

    #[test]
    fn commas_of_a_value_are_its_own() {
        assert_eq!(values("agent.gamma = 0.9, 1"), ["0.9", "1"]);
        assert_eq!(values("env.room=[3, 3],[5,5]"), ["[3, 3]", "[5,5]"]);
        assert_eq!(
            values(r#"env.goals=[{ at = "a,b" }],[{ at = 'c]' }]"#),
            [r#"[{ at = "a,b" }]"#, "[{ at = 'c]' }]"]
        );
        assert_eq!(values(r#"x.y="a\",b",c"#), [r#""a\",b""#, "c"]);
        assert_eq!(values("x.y=a,b,a"), ["a", "b"], "each once");
    }

    #[test]
    fn what_is_no_axis_is_refused() {
        let refused = |text: &str| text.parse::<Axis>().unwrap_err();
        for text in ["agent.gamma", "=1", "agent.gamma=", ""] {
            assert_eq!(refused(text), GridError::Assignment, "{text}");
        }
        for text in ["a.b=[1,2", "a.b=1]", "a.b=[1}", "a.b=\"x", "a.b='x,y"] {
            assert!(matches!(refused(text), GridError::Unclosed(_)), "{text}");
        }
        for text in ["a.b=1,,2", "a.b=,1", "a.b=1,"] {
            assert!(matches!(refused(text), GridError::Empty(_)), "{text}");
        }
    }

    #[test]
    fn the_last_axis_changes_first() {
        let axes: Vec<Axis> = ["a.b=1,2", "c.d=x,y"]
            .map(|axis| axis.parse().unwrap())
            .into();
        let told = |arms: &[&str]| -> Vec<String> {
            let arms: Vec<String> = arms.iter().map(|&arm| arm.to_owned()).collect();
            let points = grid(&arms, &axes).unwrap();
            let told = points.iter().map(|point| {
                let values: Vec<&str> = point.settings.iter().map(|(_, value)| &**value).collect();
                format!(
                    "{}{}",
                    point.arm.as_deref().unwrap_or_default(),
                    values.concat()
                )
            });
            told.collect()
        };
        assert_eq!(told(&[]), ["1x", "1y", "2x", "2y"]);
        assert_eq!(told(&["p", "q"])[3..6], ["p2y", "q1x", "q1y"]);
        assert_eq!(grid(&[], &[]).unwrap(), [GridPoint::default()]);
        let twice = [axes[0].clone(), axes[0].clone()];
        assert_eq!(grid(&[], &twice), Err(GridError::Twice("a.b".to_owned())));
        let long = Axis {
            key: "e.f".to_owned(),
            values: (0..50_001).map(|i| i.to_string()).collect(),
        };
        assert_eq!(grid(&[], &[axes[0].clone(), long]), Err(GridError::TooMany));
    }

    #[test]
    fn a_mistake_names_the_value_of_the_grid() {
        let point = GridPoint {
            arm: None,
            settings: vec![("agent.gama".to_owned(), "0.9".to_owned())],
        };
        let refused = point.load(Path::new("x.toml"), "", &[]).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "--grid agent.gama=0.9: unknown key `agent.gama`; did you mean `gamma`?"
        );
    }
}
