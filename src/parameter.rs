//! The error of a parameter out of its range, one for every part, and the checks that find it.

use std::borrow::Cow;
use std::fmt::Display;
use std::ops::{Bound, RangeBounds};

/// A parameter that breaks its rule, by the names it has in a scenario: `agent.gamma = 1.5: must be within 0 and 1`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{section}.{key} = {value}: must be {rule}")]
pub struct ParameterError {
    /// The table of a scenario, or the part of the library, that it belongs to.
    pub section: &'static str,
    /// Its key there.
    pub key: &'static str,
    /// The value it has, as messages show it.
    pub value: String,
    /// The values it may have, as the end of "must be …".
    pub rule: Cow<'static, str>,
}

impl ParameterError {
    /// The key with its section, `agent.gamma`.
    pub fn path(&self) -> String {
        format!("{}.{}", self.section, self.key)
    }
}

/// A section whose keys are checked one by one.
#[derive(Clone, Copy)]
pub(crate) struct Section(pub &'static str);

impl Section {
    /// `Ok` if the rule of a number `holds`.
    pub fn number(
        self,
        key: &'static str,
        value: f64,
        holds: bool,
        rule: &'static str,
    ) -> Result<(), ParameterError> {
        match holds {
            true => Ok(()),
            false => Err(self.error(key, brief(value), rule.into())),
        }
    }

    /// `Ok` if a count lies in `range`, whose ends, if it has any, are included.
    pub fn count<T: Display + PartialOrd>(
        self,
        key: &'static str,
        value: T,
        range: impl RangeBounds<T>,
    ) -> Result<(), ParameterError> {
        match range.contains(&value) {
            true => Ok(()),
            false => Err(self.error(key, value.to_string(), told(&range).into())),
        }
    }

    fn error(self, key: &'static str, value: String, rule: Cow<'static, str>) -> ParameterError {
        ParameterError {
            section: self.0,
            key,
            value,
            rule,
        }
    }
}

/// `1 to 1024`, `at least 1`, `at most 1000`.
fn told<T: Display>(range: &impl RangeBounds<T>) -> String {
    let end = |bound| match bound {
        Bound::Included(end) | Bound::Excluded(end) => Some(end),
        Bound::Unbounded => None,
    };
    match (end(range.start_bound()), end(range.end_bound())) {
        (Some(least), Some(most)) => format!("{least} to {most}"),
        (Some(least), None) => format!("at least {least}"),
        (None, Some(most)) => format!("at most {most}"),
        (None, None) => "any number".to_owned(),
    }
}

/// A number with all its digits, unless these are a row of zeros: `0.25`, `1500`, `1e308`.
fn brief(value: f64) -> String {
    match value.abs() {
        0.0 | 1e-6..1e16 => value.to_string(),
        _ => format!("{value:e}"), // NaN and inf are written alike by both
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_are_not_counted_out() {
        let numbers = [0.0, -0.25, 1500.0, 1e308, -2.5e-9, f64::NAN, f64::INFINITY];
        let texts = ["0", "-0.25", "1500", "1e308", "-2.5e-9", "NaN", "inf"];
        assert_eq!(numbers.map(brief), texts);
    }

    #[test]
    fn messages_say_section_key_value_and_rule() {
        let section = Section("part");
        let message = |checked: Result<(), ParameterError>| checked.unwrap_err().to_string();
        assert_eq!(section.number("share", 0.5, true, "below 1"), Ok(()));
        assert_eq!(
            message(section.number("share", 1e300, false, "below 1")),
            "part.share = 1e300: must be below 1"
        );
        assert_eq!(section.count("threads", 1024, 1..=1024), Ok(()));
        assert_eq!(
            message(section.count("threads", usize::MAX, 1..=1024)),
            format!("part.threads = {}: must be 1 to 1024", usize::MAX)
        );
        assert_eq!(
            message(section.count("every", 0_u64, 1..)),
            "part.every = 0: must be at least 1"
        );
        assert_eq!(
            message(section.count("epochs", 7, ..=6)),
            "part.epochs = 7: must be at most 6"
        );
        let error = section.count("epochs", 7, ..=6).unwrap_err();
        assert_eq!(error.path(), "part.epochs");
    }
}
