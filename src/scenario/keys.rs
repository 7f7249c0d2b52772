//! Places of the keys in a document.

use std::ops::Range;
use toml::de::{DeTable, DeValue};

/// Every key of a document with the ranges of the key and of its value.
pub(super) struct KeyPlaces(Vec<(String, Range<usize>, Range<usize>)>);

impl KeyPlaces {
    /// Those of a whole document.
    pub(super) fn of(table: &DeTable<'_>) -> Self {
        let mut places = Self(Vec::new());
        places.add_table("", table);
        places
    }

    fn add_table(&mut self, prefix: &str, table: &DeTable<'_>) {
        for (key, value) in table {
            let name = match prefix {
                "" => key.get_ref().to_string(),
                _ => format!("{prefix}.{}", key.get_ref()),
            };
            self.0.push((name.clone(), key.span(), value.span()));
            self.add_value(&name, value.get_ref());
        }
    }

    fn add_value(&mut self, name: &str, value: &DeValue<'_>) {
        match value {
            DeValue::Table(table) => self.add_table(name, table),
            DeValue::Array(items) => {
                for (i, item) in items.iter().enumerate() {
                    let name = format!("{name}[{i}]");
                    self.0.push((name.clone(), item.span(), item.span()));
                    self.add_value(&name, item.get_ref());
                }
            }
            _ => {}
        }
    }

    /// The deepest key whose own range or value's range is `span`.
    pub(super) fn key_at(&self, span: &Range<usize>) -> Option<&str> {
        self.0
            .iter()
            .filter(|(_, key, value)| key == span || value == span)
            .max_by_key(|(name, _, _)| name.len())
            .map(|(name, _, _)| name.as_str())
    }

    /// The range of a key, or of the element of a list.
    pub(super) fn key(&self, key: &str) -> Option<&Range<usize>> {
        self.0
            .iter()
            .find(|(name, _, _)| name == key)
            .map(|(_, key, _)| key)
    }

    /// Every key, and element of a list, with its range.
    pub(super) fn keys(&self) -> impl Iterator<Item = (&str, &Range<usize>)> {
        self.0.iter().map(|(name, key, _)| (name.as_str(), key))
    }

    /// The range of a key's value.
    pub(super) fn value(&self, key: &str) -> Option<&Range<usize>> {
        self.0
            .iter()
            .find(|(name, _, _)| name == key)
            .map(|(_, _, value)| value)
    }
}

/// Line and column of a byte offset, from 1, columns in characters.
pub(super) fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before = &text.as_bytes()[..offset.min(text.len())];
    let line = before.iter().filter(|&&b| b == b'\n').count() + 1;
    let start = before
        .iter()
        .rposition(|&b| b == b'\n')
        .map_or(0, |i| i + 1);
    let column = String::from_utf8_lossy(&before[start..]).chars().count() + 1;
    (line, column)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters() {
        let text = "a\nφ = 1\n";
        let one = text.find('1').unwrap();
        assert_eq!(line_and_column(text, one), (2, 5));
        assert_eq!(line_and_column(text, 0), (1, 1));
        assert_eq!(line_and_column(text, 99), (3, 1));
    }

    #[test]
    fn the_deepest_key_is_found() {
        let text = "[a]\nb = [{ c = 1 }]\n";
        let table = DeTable::parse(text).unwrap().into_inner();
        let places = KeyPlaces::of(&table);
        let one = text.find('1').unwrap();
        assert_eq!(places.key_at(&(one..one + 1)), Some("a.b[0].c"));
        assert_eq!(places.value("a.b[0].c"), Some(&(one..one + 1)));
        assert_eq!(places.value("a.c"), None);
    }
}
