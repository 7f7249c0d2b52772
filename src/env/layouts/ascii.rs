//! Maps as text, one character a cell, in both directions.
//!
//! `#` wall · `.` or space free · `S` start · `G` goal · `1`–`9` goal whose reward stands in a table ·
//! `^` `v` `<` `>` one-way: can only be left in that direction.
//!
//! Short lines are filled up with walls on the right, so trailing spaces count. Empty lines before the first and after
//! the last line with characters are dropped.

use super::{Cell, Direction, GoalCell, Layout, Tile};
use crate::env::EnvError;
use crate::env::error::MOST_ERRORS;
use std::collections::BTreeMap;
use std::fmt;

/// The one-way characters.
const ARROWS: [(char, Direction); 4] = [
    ('^', Direction::Up),
    ('>', Direction::Right),
    ('v', Direction::Down),
    ('<', Direction::Left),
];

impl Layout {
    /// Reads a map; `rewards` holds the reward of each numbered goal in it (see [`GoalCell::reward`]).
    ///
    /// A map may lack a start (for random ones) and goals (to be placed later).
    ///
    /// # Errors
    /// [`EnvError::EmptyMap`], [`EnvError::MapTooLarge`], and with line and column, both from 1:
    /// [`EnvError::UnknownCharacter`], [`EnvError::SecondStart`], [`EnvError::GoalWithoutReward`];
    /// [`EnvError::Several`] of these if there are several; [`EnvError::RewardKey`] if the table names something else than a digit from 1 to 9.
    pub fn from_ascii(map: &str, rewards: &BTreeMap<char, f64>) -> Result<Self, EnvError> {
        if let Some(&key) = rewards.keys().find(|key| !('1'..='9').contains(*key)) {
            return Err(EnvError::RewardKey { key });
        }
        let lines: Vec<&str> = map.lines().collect();
        let used = |line: &&str| !line.is_empty();
        let first = lines.iter().position(used).ok_or(EnvError::EmptyMap)?;
        let last = lines.iter().rposition(used).ok_or(EnvError::EmptyMap)?;
        let cols = lines
            .iter()
            .map(|line| line.chars().count())
            .max()
            .unwrap_or(0);
        let mut layout = Layout::filled(last - first + 1, cols, Tile::Wall)?;
        let mut errors = Vec::new();
        for (row, line) in lines[first..=last].iter().enumerate() {
            for (col, character) in line.chars().enumerate() {
                let cell = Cell((row * cols + col) as u32);
                let drawn = layout.draw(cell, character, rewards, (first + row + 1, col + 1));
                errors.extend(drawn.err());
            }
        }
        errors.truncate(MOST_ERRORS);
        EnvError::of_all(errors).map_or(Ok(layout), Err)
    }

    /// Puts one character of a map at `cell`; `place` is its line and column, for messages.
    fn draw(
        &mut self,
        cell: Cell,
        character: char,
        rewards: &BTreeMap<char, f64>,
        place: (usize, usize),
    ) -> Result<(), EnvError> {
        let (line, column) = place;
        let tile = match character {
            '#' => Tile::Wall,
            '.' | ' ' => Tile::Free,
            'S' if self.start.is_some() => return Err(EnvError::SecondStart { line, column }),
            'S' => {
                self.start = Some(cell);
                Tile::Free
            }
            'G' => {
                self.goals.push(GoalCell::new(cell));
                Tile::Free
            }
            digit @ '1'..='9' => {
                let reward = *rewards.get(&digit).ok_or(EnvError::GoalWithoutReward {
                    line,
                    column,
                    digit,
                })?;
                self.goals.push(GoalCell {
                    cell,
                    reward: Some(reward),
                    digit: Some(digit as u8 - b'0'),
                });
                Tile::Free
            }
            other => {
                let arrow = ARROWS.iter().find(|(arrow, _)| *arrow == other);
                let arrow = arrow.ok_or(EnvError::UnknownCharacter {
                    line,
                    column,
                    found: other,
                })?;
                Tile::OneWay(arrow.1)
            }
        };
        self.set_tile(cell, tile);
        Ok(())
    }

    /// The character of `cell`: what a map with this cell would show.
    ///
    /// # Panics
    /// If `cell` is not on the map.
    pub fn character(&self, cell: Cell) -> char {
        if self.is_start(cell) {
            return 'S';
        }
        if let Some(goal) = self.goals.iter().find(|goal| goal.cell == cell) {
            return goal.digit.map_or('G', |digit| char::from(b'0' + digit));
        }
        if self.is_hazard(cell) {
            return 'X';
        }
        match self.tile(cell) {
            Tile::Wall => '#',
            Tile::Free => '.',
            Tile::OneWay(direction) => {
                let arrow = ARROWS.iter().find(|(_, way)| *way == direction);
                arrow.expect("ARROWS names every direction").0
            }
        }
    }
}

/// The map as text, lines parted by newlines, without a last one. [`Layout::from_ascii`] reads it back, except that a
/// start or goal hides the arrow under it, a reward without a digit is not shown, and a hazard, `X`, is not read.
impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for cell in self.cells() {
            if cell.0 != 0 && cell.index() % self.cols == 0 {
                f.write_str("\n")?;
            }
            fmt::Write::write_char(f, self.character(cell))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(map: &str) -> Result<Layout, EnvError> {
        Layout::from_ascii(map, &BTreeMap::from([('3', 2.5)]))
    }

    #[test]
    fn every_character_has_its_meaning() {
        let layout = parse("\nS.#3\n>v\n< ^G\n\n").unwrap();
        assert_eq!(layout.to_string(), "S.#3\n>v##\n<.^G");
        assert_eq!(layout.start, Some(Cell(0)));
        let digit = GoalCell {
            cell: Cell(3),
            reward: Some(2.5),
            digit: Some(3),
        };
        assert_eq!(layout.goals, [digit, GoalCell::new(Cell(11))]);
        assert_eq!(layout.tile(Cell(4)), Tile::OneWay(Direction::Right));
    }

    #[test]
    fn one_way_cells_are_left_one_way_and_entered_any_way() {
        let layout = parse("...\n.v.\n...").unwrap();
        for direction in Direction::ALL {
            let left = layout.neighbor(Cell(4), direction).is_some();
            assert_eq!(left, direction == Direction::Down);
            let from = layout.beside(Cell(4), direction).unwrap();
            assert_eq!(layout.neighbor(from, direction.opposite()), Some(Cell(4)));
        }
    }

    #[test]
    fn errors_name_line_and_column() {
        assert_eq!(
            parse("S.\n.x"),
            Err(EnvError::UnknownCharacter {
                line: 2,
                column: 2,
                found: 'x'
            })
        );
        assert_eq!(
            parse("\nS.\n.S"),
            Err(EnvError::SecondStart { line: 3, column: 2 })
        );
        assert_eq!(
            parse(".7"),
            Err(EnvError::GoalWithoutReward {
                line: 1,
                column: 2,
                digit: '7'
            })
        );
        let Err(EnvError::Several { errors }) = parse("S?\n.S\n7x") else {
            panic!("four places are wrong")
        };
        let told: Vec<String> = errors.iter().map(EnvError::to_string).collect();
        let places = [
            "line 1, column 2",
            "line 2, column 2",
            "line 3, column 1",
            "line 3, column 2",
        ];
        assert_eq!(told.len(), places.len(), "{told:?}");
        for (told, place) in told.iter().zip(places) {
            assert!(told.contains(place), "{told}");
        }
        assert_eq!(parse("\n\n"), Err(EnvError::EmptyMap));
        assert_eq!(parse(""), Err(EnvError::EmptyMap));
        let zero = Layout::from_ascii("S0", &BTreeMap::from([('0', 1.0)]));
        assert_eq!(zero, Err(EnvError::RewardKey { key: '0' }));
    }
}
