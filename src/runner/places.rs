//! Where the states of a run are: on a map, or in a list of names.

use crate::env::layouts::{Cell, Layout};

/// What states of type `S` are called, and where they are on the map if there is one.
pub(super) struct Places<S> {
    /// Column names of `label`, for `states.csv`.
    pub columns: &'static str,
    /// Place (`row,col`) or name of a state, as fields of a CSV line.
    pub label: Box<dyn Fn(&S) -> String>,
    /// The map, if there is one.
    pub map: Option<Map<S>>,
}

/// A map, and where states are on it.
pub(super) struct Map<S> {
    pub layout: Layout,
    pub cell: fn(&S) -> Cell,
}

impl Places<Cell> {
    /// Cells of a map.
    pub fn on_map(layout: &Layout) -> Self {
        let map = layout.clone();
        Self {
            columns: "row,col",
            label: Box::new(move |cell| {
                let (row, col) = map.position(*cell);
                format!("{row},{col}")
            }),
            map: Some(Map {
                layout: layout.clone(),
                cell: |cell| *cell,
            }),
        }
    }
}

impl<S> Places<S> {
    /// States with names.
    pub fn named(names: Vec<String>, index: fn(&S) -> usize) -> Self
    where
        S: 'static,
    {
        Self {
            columns: "name",
            label: Box::new(move |state| csv_field(&names[index(state)])),
            map: None,
        }
    }
}

/// A name as a field of a CSV line, quoted if it must be.
fn csv_field(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_quoted_where_they_must_be() {
        assert_eq!(csv_field("hall"), "hall");
        assert_eq!(csv_field("hall, \"old\""), "\"hall, \"\"old\"\"\"");
    }

    #[test]
    fn cells_are_called_by_row_and_column() {
        let layout = Layout::open(2, 3).unwrap();
        let places = Places::on_map(&layout);
        let cell = layout.cell(1, 2).unwrap();
        assert_eq!((places.label)(&cell), "1,2");
        assert_eq!((places.map.unwrap().cell)(&cell), cell);
    }
}
