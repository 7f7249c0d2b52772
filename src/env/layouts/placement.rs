//! Places on a map that are named rather than counted: corners, the middle, as far away as possible.

use super::{Cell, Layout};
use crate::env::EnvError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A place by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Landmark {
    /// The free cell nearest to the first row and first column.
    TopLeft,
    /// The free cell nearest to the first row and last column.
    TopRight,
    /// The free cell nearest to the last row and first column.
    BottomLeft,
    /// The free cell nearest to the last row and last column.
    BottomRight,
    /// The free cell nearest to the middle (up and left of it, if the sides are even).
    Center,
    /// The cell that takes the most moves from the start, and is no hazard.
    Farthest,
}

/// Where a start or a goal is: `"top-left"` or `[row, col]`, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "a place is \"top-left\", \"top-right\", \"bottom-left\", \"bottom-right\", \"center\", \"farthest\" \
                 or [row, col] counted from 0"
)]
pub enum Placement {
    /// By name.
    Named(Landmark),
    /// By row and column; may be a wall, which is then an error of the world that is built on it.
    At([usize; 2]),
}

impl From<Landmark> for Placement {
    fn from(landmark: Landmark) -> Self {
        Placement::Named(landmark)
    }
}

impl From<[usize; 2]> for Placement {
    fn from(position: [usize; 2]) -> Self {
        Placement::At(position)
    }
}

impl Layout {
    /// The cell at `placement`. "Nearest" counts rows plus columns; of equally near cells the first in reading order is
    /// taken, of equally far ones the last. O(cells).
    ///
    /// # Errors
    /// [`EnvError::OutsideMap`], [`EnvError::NoFreeCell`], [`EnvError::FarthestWithoutStart`].
    pub fn locate(&self, placement: Placement) -> Result<Cell, EnvError> {
        let (rows, cols) = (self.rows(), self.cols());
        match placement {
            Placement::At([row, col]) => self.cell(row, col).ok_or(EnvError::OutsideMap {
                row,
                col,
                rows,
                cols,
            }),
            Placement::Named(Landmark::TopLeft) => self.nearest_free(0, 0),
            Placement::Named(Landmark::TopRight) => self.nearest_free(0, cols - 1),
            Placement::Named(Landmark::BottomLeft) => self.nearest_free(rows - 1, 0),
            Placement::Named(Landmark::BottomRight) => self.nearest_free(rows - 1, cols - 1),
            Placement::Named(Landmark::Center) => self.nearest_free((rows - 1) / 2, (cols - 1) / 2),
            Placement::Named(Landmark::Farthest) => self.farthest(),
        }
    }

    fn nearest_free(&self, row: usize, col: usize) -> Result<Cell, EnvError> {
        let moves = |cell: &Cell| {
            let (r, c) = self.position(*cell);
            r.abs_diff(row) + c.abs_diff(col)
        };
        self.free_cells()
            .min_by_key(moves)
            .ok_or(EnvError::NoFreeCell)
    }

    fn farthest(&self) -> Result<Cell, EnvError> {
        let start = self.start.ok_or(EnvError::FarthestWithoutStart)?;
        let distances = self.distances_from(start);
        let reached = self
            .free_cells()
            .filter(|&cell| distances[cell.index()].is_some() && !self.is_hazard(cell));
        reached
            .max_by_key(|cell| distances[cell.index()])
            .ok_or(EnvError::NoFreeCell)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn located(map: &str, landmark: Landmark) -> [usize; 2] {
        let layout = Layout::from_ascii(map, &BTreeMap::new()).unwrap();
        layout
            .position(layout.locate(landmark.into()).unwrap())
            .into()
    }

    #[test]
    fn landmarks_are_free_cells() {
        let map = "#..#\n....\n#.#.\n.S##";
        assert_eq!(located(map, Landmark::TopLeft), [0, 1]);
        assert_eq!(located(map, Landmark::TopRight), [0, 2]);
        assert_eq!(located(map, Landmark::BottomLeft), [3, 0]);
        assert_eq!(located(map, Landmark::BottomRight), [2, 3]);
        assert_eq!(located(map, Landmark::Center), [1, 1]);
        assert_eq!(located(map, Landmark::Farthest), [2, 3]);
    }

    #[test]
    fn farthest_goes_round_walls() {
        assert_eq!(located("S#.\n.#.\n...", Landmark::Farthest), [0, 2]);
    }

    #[test]
    fn misplaced_places_are_errors() {
        let layout = Layout::open(2, 3).unwrap();
        let outside = layout.locate([2, 0].into());
        assert_eq!(
            outside,
            Err(EnvError::OutsideMap {
                row: 2,
                col: 0,
                rows: 2,
                cols: 3
            })
        );
        assert_eq!(
            layout.locate(Landmark::Farthest.into()),
            Err(EnvError::FarthestWithoutStart)
        );
    }

    #[test]
    fn places_read_from_text_and_say_what_they_may_be() {
        let read = |text: &str| serde_json::from_str::<Placement>(text);
        assert_eq!(
            read("\"bottom-right\"").unwrap(),
            Landmark::BottomRight.into()
        );
        assert_eq!(read("[3, 4]").unwrap(), [3, 4].into());
        let message = read("\"botom-right\"").unwrap_err().to_string();
        assert!(message.contains("\"bottom-right\""), "{message}");
    }
}
