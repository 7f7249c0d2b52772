//! Tables for people: as many columns as fit, the more telling ones first.

use comfy_table::{CellAlignment, Table, presets};

/// Style of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableStyle {
    /// With lines, for a terminal of so many characters; `usize::MAX` shows everything.
    Terminal {
        /// Characters in a line.
        width: usize,
    },
    /// For documents, with every column.
    Markdown,
}

/// Column of a table, and what it says below the table if it is shown.
pub(super) struct Column {
    pub header: String,
    pub cells: Vec<String>,
    /// Of columns that do not all fit those with the smallest rank are shown.
    pub rank: u8,
    pub note: String,
}

impl TableStyle {
    /// Characters in a line.
    pub(super) fn width(self) -> usize {
        match self {
            Self::Terminal { width } => width,
            Self::Markdown => usize::MAX,
        }
    }
}

/// The columns that fit beside each other, in the order in which they came, and how many were left out. The first one is
/// always shown, and the one with the smallest rank with it.
pub(super) fn fitting(columns: Vec<Column>, style: TableStyle) -> (Vec<Column>, usize) {
    let all = columns.len();
    let mut by_rank: Vec<usize> = (1..all).collect();
    by_rank.sort_by_key(|&i| columns[i].rank);
    let mut shown = vec![false; all];
    let mut used = 1;
    for (place, i) in (0..all.min(1)).chain(by_rank).enumerate() {
        let needed = width_of(&columns[i]);
        if place < 2 || used + needed <= style.width() {
            shown[i] = true;
            used += needed;
        }
    }
    let mut shown = shown.into_iter();
    let kept: Vec<Column> = columns
        .into_iter()
        .filter(|_| shown.next() == Some(true))
        .collect();
    let left_out = all - kept.len();
    (kept, left_out)
}

/// Characters that a column takes, with the line and the gaps beside it.
pub(super) fn width_of(column: &Column) -> usize {
    let texts = column.cells.iter().chain([&column.header]);
    texts.map(|text| text.chars().count()).max().unwrap_or(0) + 3
}

/// The table, numbers to the right.
pub(super) fn render_columns(columns: &[Column], style: TableStyle) -> String {
    let mut table = Table::new();
    table.load_style(match style {
        TableStyle::Terminal { .. } => presets::UTF8_FULL_CONDENSED,
        TableStyle::Markdown => presets::ASCII_MARKDOWN,
    });
    table.set_header(columns.iter().map(|column| &column.header));
    let rows = columns.iter().map(|column| column.cells.len()).max();
    for row in 0..rows.unwrap_or(0) {
        table.add_row(columns.iter().map(|column| &column.cells[row]));
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt() + "\n"
}

/// `text` in lines of at most `width` characters, broken at spaces; a longer word has a line of its own.
pub(super) fn wrapped(text: &str, width: usize) -> String {
    let mut result = String::with_capacity(text.len());
    for line in text.lines() {
        let mut used = 0;
        for word in line.split(' ') {
            let needed = word.chars().count();
            if used > 0 && used + 1 + needed > width {
                result.push('\n');
                used = 0;
            } else if used > 0 {
                result.push(' ');
                used += 1;
            }
            result += word;
            used += needed;
        }
        result.push('\n');
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn column(header: &str, rank: u8) -> Column {
        Column {
            header: header.to_owned(),
            cells: vec!["1".to_owned()],
            rank,
            note: String::new(),
        }
    }

    fn headers(width: usize) -> Vec<String> {
        let columns = [("name", 0), ("rare", 9), ("vital", 1), ("useful", 2)];
        let columns = columns.map(|(header, rank)| column(header, rank)).into();
        let (shown, left_out) = fitting(columns, TableStyle::Terminal { width });
        assert_eq!(shown.len() + left_out, 4);
        shown.into_iter().map(|column| column.header).collect()
    }

    #[test]
    fn the_more_telling_columns_are_shown_in_their_old_order() {
        assert_eq!(headers(usize::MAX), ["name", "rare", "vital", "useful"]);
        assert_eq!(headers(31), ["name", "vital", "useful"]);
        assert_eq!(headers(24), ["name", "rare", "vital"], "what still fits");
        assert_eq!(headers(3), ["name", "vital"]);
    }

    #[test]
    fn lines_are_broken_at_spaces() {
        assert_eq!(wrapped("one two three\nfour", 7), "one two\nthree\nfour\n");
        assert_eq!(wrapped("indivisible a", 4), "indivisible\na\n");
    }

    proptest! {
        #[test]
        fn a_table_is_as_wide_as_was_reckoned(cells in proptest::collection::vec("[a-zé–]{1,9}", 1..6), width in 1..60usize) {
            let columns: Vec<Column> = cells.iter().map(|cell| column(cell, 0)).collect();
            let (shown, _) = fitting(columns, TableStyle::Terminal { width });
            let text = render_columns(&shown, TableStyle::Terminal { width });
            let widest = text.lines().map(|line| line.chars().count()).max().unwrap();
            prop_assert_eq!(widest, 1 + shown.iter().map(width_of).sum::<usize>());
            prop_assert!(widest <= width || shown.len() <= 2);
        }

        #[test]
        fn wrapping_keeps_every_word(text in "[a-z ]{0,60}", width in 1..30usize) {
            let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
            let lines = wrapped(&text, width);
            prop_assert_eq!(words(&lines), words(&text));
            for line in lines.lines() {
                prop_assert!(line.chars().count() <= width || !line.trim().contains(' '));
            }
        }
    }
}
