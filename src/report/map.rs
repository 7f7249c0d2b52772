//! Maps drawn in characters, bare or shaded by a function of the cells.

use crate::env::layouts::{Cell, Direction, Layout, Tile};

/// Which characters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Charset {
    /// Unicode blocks.
    #[default]
    Blocks,
    /// ASCII only.
    Ascii,
}

/// The widest map whose cells are drawn two characters wide, so that they look square.
const WIDEST_DOUBLE: usize = 50;

/// Heights that stand for low to high.
const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
const DIGITS: [char; 10] = ['0', '1', '2', '3', '4', '5', '6', '7', '8', '9'];

/// The map with its start `S` and goals `G` (or their digits).
pub fn draw_map(layout: &Layout, charset: Charset) -> String {
    draw(layout, |cell| match (mark(layout, cell), charset) {
        (Some(mark), _) => mark,
        (None, _) => tile(layout, cell, charset),
    })
}

/// The map shaded from the lowest to the highest of the values that `value` gives; cells without one stay blank.
pub fn draw_values(
    layout: &Layout,
    value: impl Fn(Cell) -> Option<f64>,
    charset: Charset,
) -> String {
    let finite = |cell| value(cell).filter(|v: &f64| v.is_finite());
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for v in layout.free_cells().filter_map(&finite) {
        (low, high) = (low.min(v), high.max(v));
    }
    let ramp: &[char] = match charset {
        Charset::Blocks => &BARS,
        Charset::Ascii => &DIGITS,
    };
    draw(layout, |cell| match (mark(layout, cell), finite(cell)) {
        _ if layout.tile(cell) == Tile::Wall => wall(charset),
        (Some(mark), _) => mark,
        (None, Some(v)) => {
            let share = (v - low) / (high - low).max(f64::MIN_POSITIVE);
            ramp[(share * (ramp.len() - 1) as f64).round() as usize]
        }
        (None, None) => ' ',
    })
}

fn draw(layout: &Layout, character: impl Fn(Cell) -> char) -> String {
    let double = layout.cols() <= WIDEST_DOUBLE;
    let mut text = String::new();
    for row in 0..layout.rows() {
        for col in 0..layout.cols() {
            let Some(cell) = layout.cell(row, col) else {
                continue;
            };
            let c = character(cell);
            text.push(c);
            if double {
                let spreads = BARS.contains(&c) || c == wall(Charset::Blocks) || c == '#';
                text.push(if spreads { c } else { ' ' });
            }
        }
        text.truncate(text.trim_end_matches(' ').len());
        text.push('\n');
    }
    text
}

/// The character of a start or a goal.
fn mark(layout: &Layout, cell: Cell) -> Option<char> {
    if layout.start == Some(cell) {
        return Some('S');
    }
    let goal = layout.goals.iter().find(|goal| goal.cell == cell)?;
    Some(goal.digit.map_or('G', |digit| char::from(b'0' + digit)))
}

fn tile(layout: &Layout, cell: Cell, charset: Charset) -> char {
    let [free, up, right, down, left] = match charset {
        Charset::Blocks => ['·', '↑', '→', '↓', '←'],
        Charset::Ascii => ['.', '^', '>', 'v', '<'],
    };
    match layout.tile(cell) {
        Tile::Wall => wall(charset),
        Tile::Free => free,
        Tile::OneWay(Direction::Up) => up,
        Tile::OneWay(Direction::Right) => right,
        Tile::OneWay(Direction::Down) => down,
        Tile::OneWay(Direction::Left) => left,
    }
}

fn wall(charset: Charset) -> char {
    match charset {
        Charset::Blocks => '▒',
        Charset::Ascii => '#',
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn layout() -> Layout {
        let rewards = BTreeMap::from([('3', 1.0)]);
        Layout::from_ascii("S.#\n>.3\n..G", &rewards).unwrap()
    }

    #[test]
    fn every_kind_of_cell_has_its_character() {
        assert_eq!(
            draw_map(&layout(), Charset::Ascii),
            "S . ##\n> . 3\n. . G\n"
        );
        assert_eq!(
            draw_map(&layout(), Charset::Blocks),
            "S · ▒▒\n→ · 3\n· · G\n"
        );
    }

    #[test]
    fn values_are_shaded_from_lowest_to_highest() {
        let layout = layout();
        let value = |cell: Cell| match layout.position(cell) {
            (2, 0) => None,
            (row, col) => Some(-((4 - row - col) as f64)),
        };
        assert_eq!(
            draw_values(&layout, value, Charset::Ascii),
            "S 2 ##\n2 5 3\n  7 G\n"
        );
    }

    #[test]
    fn wide_maps_take_one_character_a_cell() {
        let layout = Layout::open(1, 60).unwrap();
        assert_eq!(
            draw_map(&layout, Charset::Ascii),
            format!("{}\n", ".".repeat(60))
        );
    }
}
