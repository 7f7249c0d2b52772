//! Rooms: rows × columns of rooms with walls of one cell between them and one door in each shared wall.
//!
//! R × C rooms of h × w cells fill (R h + R − 1) × (C w + C − 1) cells and have R (C − 1) + C (R − 1) doors. Two by two
//! rooms of 5 × 5 are the 11 × 11 FourRooms of Sutton, Precup & Singh (1999), up to where the doors are.

use super::{Layout, Tile};
use crate::env::EnvError;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Place of the door in a shared wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Doors {
    /// In the middle; the upper or left one of two middles.
    Center,
    /// Anywhere along the wall, drawn for each wall.
    #[default]
    Random,
}

impl Doors {
    /// The door's offset along a wall of `length` cells. `Center` draws nothing.
    fn offset(self, length: usize, rng: &mut ChaCha8Rng) -> usize {
        match self {
            Doors::Center => (length - 1) / 2,
            Doors::Random => rng.random_range(0..length),
        }
    }
}

impl Layout {
    /// `rows` × `cols` rooms of `room` = [height, width] cells, one door per shared wall.
    ///
    /// # Errors
    /// [`EnvError::EmptyMap`] or [`EnvError::MapTooLarge`].
    pub fn rooms(
        rows: usize,
        cols: usize,
        room: [usize; 2],
        doors: Doors,
        rng: &mut ChaCha8Rng,
    ) -> Result<Self, EnvError> {
        let [height, width] = room;
        let mut layout = walled_blocks(rows, cols, room, 1)?;
        for block_row in 0..rows {
            for block_col in 0..cols {
                let (top, left) = (block_row * (height + 1), block_col * (width + 1));
                if block_col + 1 < cols {
                    layout.carve(top + doors.offset(height, rng), left + width, 1, 1);
                }
                if block_row + 1 < rows {
                    layout.carve(top + height, left + doors.offset(width, rng), 1, 1);
                }
            }
        }
        Ok(layout)
    }
}

/// `rows` × `cols` free blocks of `block` = [height, width] cells with walls of `gap` cells between them.
pub(super) fn walled_blocks(
    rows: usize,
    cols: usize,
    block: [usize; 2],
    gap: usize,
) -> Result<Layout, EnvError> {
    if rows == 0 || cols == 0 || block.contains(&0) {
        return Err(EnvError::EmptyMap);
    }
    let [height, width] = block;
    // Saturating: a side too long to compute is refused as too large, not wrapped into a small map.
    let side = |count: usize, length: usize| {
        count
            .saturating_mul(length.saturating_add(gap))
            .saturating_sub(gap)
    };
    let mut layout = Layout::filled(side(rows, height), side(cols, width), Tile::Wall)?;
    for block_row in 0..rows {
        for block_col in 0..cols {
            layout.carve(
                block_row * (height + gap),
                block_col * (width + gap),
                height,
                width,
            );
        }
    }
    Ok(layout)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds::{Stream, stream};

    #[test]
    fn four_rooms_are_eleven_by_eleven() {
        let layout =
            Layout::rooms(2, 2, [5, 5], Doors::Center, &mut stream(0, Stream::Layout)).unwrap();
        let picture = layout.to_string();
        let lines: Vec<_> = picture.lines().collect();
        assert_eq!(lines.len(), 11);
        assert_eq!(lines[0], ".....#.....");
        assert_eq!(lines[2], "...........");
        assert_eq!(lines[5], "##.#####.##");
        assert_eq!(layout.num_free(), 104);
    }

    #[test]
    fn absurd_sizes_are_refused() {
        let huge = Layout::rooms(
            usize::MAX,
            3,
            [5, 5],
            Doors::Center,
            &mut stream(0, Stream::Layout),
        );
        assert!(matches!(huge, Err(EnvError::MapTooLarge { .. })));
    }
}
