//! Maps drawn in characters: bare, shaded by a function of the cells, or with arrows.
//!
//! A map that is wider than the terminal is drawn in squares of cells, each as large as it must be: their mean value,
//! their most frequent action, a wall where half of them are walls.

use super::ansi::{Ground, Ink};
use crate::env::layouts::{Cell, Direction, Layout, Tile};
use std::ops::Range;

/// Character set of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Charset {
    /// Unicode blocks and arrows.
    #[default]
    Blocks,
    /// ASCII only.
    Ascii,
}

/// Look of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Look {
    /// With which characters.
    pub charset: Charset,
    /// With which colours.
    pub ink: Ink,
    /// Characters in a line at most; none for as many as the map takes.
    pub width: Option<usize>,
}

impl From<Charset> for Look {
    fn from(charset: Charset) -> Self {
        Self {
            charset,
            ..Self::default()
        }
    }
}

/// The widest map whose cells are drawn two characters wide, so that they look square, where no width is given.
const WIDEST_DOUBLE: usize = 50;

/// Heights that stand for low to high.
const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
const DIGITS: [char; 10] = ['0', '1', '2', '3', '4', '5', '6', '7', '8', '9'];

/// The map with its start `S` and goals `G` (or their digits).
pub fn draw_map(layout: &Layout, look: impl Into<Look>) -> String {
    let look = look.into();
    draw(layout, look, |square| {
        let cell = square.cells().find(|&cell| layout.tile(cell) != Tile::Wall);
        let c = cell.map_or(' ', |cell| tile(layout, cell, look.charset));
        (c, None)
    })
}

/// The map shaded from the lowest to the highest of the values that `value` gives; cells without one stay blank.
pub fn draw_values(
    layout: &Layout,
    value: impl Fn(Cell) -> Option<f64>,
    look: impl Into<Look>,
) -> String {
    let look = look.into();
    let shade = Shade::new(layout, &value);
    let ramp: &[char] = match look.charset {
        Charset::Blocks => &BARS,
        Charset::Ascii => &DIGITS,
    };
    draw(layout, look, |square| match shade.of(square) {
        None => (' ', None),
        // Colours say it better than heights.
        Some(share) if look.ink != Ink::None => (' ', Some(share)),
        Some(share) => (
            ramp[(share * (ramp.len() - 1) as f64).round() as usize],
            None,
        ),
    })
}

/// The map with an arrow for each action that `action` gives (its number, as of [`Direction`]), on ground coloured by
/// `value` where there are colours.
pub fn draw_policy(
    layout: &Layout,
    action: impl Fn(Cell) -> Option<u16>,
    value: impl Fn(Cell) -> Option<f64>,
    look: impl Into<Look>,
) -> String {
    let look = look.into();
    let shade = Shade::new(layout, &value);
    draw(layout, look, |square| {
        let mut counts = [0; 4];
        for action in square.cells().filter_map(&action) {
            if let Some(count) = counts.get_mut(usize::from(action)) {
                *count += 1;
            }
        }
        let most = Direction::ALL
            .into_iter()
            .rev()
            .max_by_key(|&d| counts[d as usize]);
        let held = most.filter(|&d| counts[d as usize] > 0);
        let c = held.map_or(' ', |direction| arrow(direction, look.charset));
        (c, shade.of(square).filter(|_| look.ink != Ink::None))
    })
}

/// What to say below a map that had to be fitted into the width of `look`.
pub fn fitting_note(layout: &Layout, look: Look) -> Option<String> {
    let side = look.side(layout);
    (side > 1).then(|| format!("fitted: each square stands for {side} × {side} cells"))
}

impl Look {
    /// Cells along a side of a square.
    fn side(self, layout: &Layout) -> usize {
        match self.width {
            Some(width) => layout.cols().div_ceil(width.max(1)),
            None => 1,
        }
    }

    /// Whether squares are two characters wide.
    fn is_double(self, layout: &Layout) -> bool {
        let across = layout.cols().div_ceil(self.side(layout));
        match self.width {
            Some(width) => 2 * across <= width,
            None => across <= WIDEST_DOUBLE,
        }
    }
}

/// Cells that share a character.
struct Square<'a> {
    layout: &'a Layout,
    rows: Range<usize>,
    cols: Range<usize>,
}

impl Square<'_> {
    fn cells(&self) -> impl Iterator<Item = Cell> {
        let cols = self.cols.clone();
        let all = self
            .rows
            .clone()
            .flat_map(move |row| cols.clone().map(move |col| (row, col)));
        all.filter_map(|(row, col)| self.layout.cell(row, col))
    }

    fn is_wall(&self) -> bool {
        let walls = self
            .cells()
            .filter(|&cell| self.layout.tile(cell) == Tile::Wall)
            .count();
        2 * walls >= self.rows.len() * self.cols.len()
    }

    fn mark(&self) -> Option<char> {
        let marks = || self.cells().filter_map(|cell| mark(self.layout, cell));
        marks().find(|&c| c != 'S').or_else(|| marks().next())
    }
}

/// Values as shares of their range.
struct Shade<F> {
    value: F,
    low: f64,
    high: f64,
}

impl<F: Fn(Cell) -> Option<f64>> Shade<F> {
    fn new(layout: &Layout, value: F) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for v in layout
            .free_cells()
            .filter_map(&value)
            .filter(|v| v.is_finite())
        {
            (low, high) = (low.min(v), high.max(v));
        }
        Self { value, low, high }
    }

    /// The mean of a square's finite values, from 0 to 1.
    fn of(&self, square: &Square<'_>) -> Option<f64> {
        let values = square
            .cells()
            .filter_map(&self.value)
            .filter(|v| v.is_finite());
        let (sum, count) = values.fold((0.0, 0), |(sum, n), v| (sum + v, n + 1));
        let mean = sum / f64::from(count);
        (count > 0).then(|| (mean - self.low) / (self.high - self.low).max(f64::MIN_POSITIVE))
    }
}

/// Draws squares of a character and a share of the colour scale behind it.
fn draw(
    layout: &Layout,
    look: Look,
    draw_square: impl Fn(&Square<'_>) -> (char, Option<f64>),
) -> String {
    let (side, double) = (look.side(layout), look.is_double(layout));
    let squares = |length: usize| {
        (0..length.div_ceil(side)).map(move |i| i * side..((i + 1) * side).min(length))
    };
    let mut text = String::new();
    for rows in squares(layout.rows()) {
        let mut line = Vec::new();
        for cols in squares(layout.cols()) {
            let square = Square {
                layout,
                rows: rows.clone(),
                cols,
            };
            let (c, share) = match (square.mark(), square.is_wall()) {
                (Some(mark), _) => (mark, draw_square(&square).1),
                (None, true) => (wall(look.charset), None),
                (None, false) => draw_square(&square),
            };
            let ground = share.map_or(Ground::Bare, Ground::Share);
            let spreads = BARS.contains(&c) || c == wall(look.charset);
            line.push((c, ground));
            if double {
                line.push((if spreads { c } else { ' ' }, ground));
            }
        }
        look.ink.write_line(&line, &mut text);
    }
    text
}

/// The character of a start, a goal or a hazard.
fn mark(layout: &Layout, cell: Cell) -> Option<char> {
    if layout.is_start(cell) {
        return Some('S');
    }
    if layout.is_hazard(cell) {
        return Some('X');
    }
    let goal = layout.goals.iter().find(|goal| goal.cell == cell)?;
    Some(goal.digit.map_or('G', |digit| char::from(b'0' + digit)))
}

fn tile(layout: &Layout, cell: Cell, charset: Charset) -> char {
    match (layout.tile(cell), charset) {
        (Tile::Wall, _) => wall(charset),
        (Tile::Free, Charset::Blocks) => '·',
        (Tile::Free, Charset::Ascii) => '.',
        (Tile::OneWay(direction), _) => arrow(direction, charset),
    }
}

fn arrow(direction: Direction, charset: Charset) -> char {
    let arrows = match charset {
        Charset::Blocks => ['↑', '→', '↓', '←'],
        Charset::Ascii => ['^', '>', 'v', '<'],
    };
    arrows[direction as usize]
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
    fn policies_are_arrows() {
        let layout = layout();
        let action = |cell: Cell| match layout.position(cell) {
            (0, 1) => Some(1),
            (1, 1) => Some(2),
            (2, 1) => Some(3),
            _ => None,
        };
        let text = draw_policy(&layout, action, |_| Some(1.0), Charset::Blocks);
        assert_eq!(text, "S → ▒▒\n  ↓ 3\n  ← G\n");
    }

    #[test]
    fn wide_maps_take_one_character_a_cell() {
        let layout = Layout::open(1, 60).unwrap();
        assert_eq!(
            draw_map(&layout, Charset::Ascii),
            format!("{}\n", ".".repeat(60))
        );
    }

    #[test]
    fn maps_are_fitted_into_the_terminal() {
        let layout = Layout::from_ascii("S...#.\n....##\n.....G", &BTreeMap::new()).unwrap();
        let look = |width| Look {
            charset: Charset::Ascii,
            width: Some(width),
            ..Look::default()
        };
        assert_eq!(
            draw_map(&layout, look(12)),
            "S . . . ##.\n. . . . ####\n. . . . . G\n"
        );
        assert_eq!(draw_map(&layout, look(7)), "S...#.\n....##\n.....G\n");
        assert_eq!(draw_map(&layout, look(3)), "S.#\n..G\n");
        assert_eq!(fitting_note(&layout, look(6)), None);
        let note = fitting_note(&layout, look(3)).unwrap();
        assert!(note.contains("2 × 2 cells"), "{note}");
        // Means: of the first four columns 0, 0, 1, 1.
        let value = |cell| Some((layout.position(cell).1 / 2) as f64);
        assert_eq!(draw_values(&layout, value, look(3)), "S5#\n05G\n");
    }
}
