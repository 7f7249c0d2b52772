//! Linked grids: open grids in rows and columns, neighbours joined by one corridor each.
//!
//! Fig. 9 of the source paper shows "4-connected grid worlds": four grids of which each is joined to the next. It
//! does not say how long the links are; here they are straight corridors of any length from the middle of one side to
//! the middle of the facing one. Four 5 × 5 grids have 100 cells and four corridors. With corridors of one cell these
//! are [rooms](Layout::rooms) with doors in the middle; longer ones make the graph "highly sparse", as the paper says.

use super::Layout;
use super::rooms::walled_blocks;
use crate::env::EnvError;

impl Layout {
    /// `rows` × `cols` open grids of `grid` = [height, width] cells, joined by corridors of `corridor` cells.
    ///
    /// # Errors
    /// [`EnvError::EmptyMap`], [`EnvError::MapTooLarge`], or [`EnvError::LayoutParameter`] for a corridor without
    /// length.
    pub fn linked(
        rows: usize,
        cols: usize,
        grid: [usize; 2],
        corridor: usize,
    ) -> Result<Self, EnvError> {
        if corridor == 0 {
            let rule = "a corridor is at least one cell long";
            return Err(EnvError::LayoutParameter {
                parameter: "corridor",
                value: corridor.to_string(),
                rule,
            });
        }
        let [height, width] = grid;
        let mut layout = walled_blocks(rows, cols, grid, corridor)?;
        for grid_row in 0..rows {
            for grid_col in 0..cols {
                let (top, left) = (
                    grid_row * (height + corridor),
                    grid_col * (width + corridor),
                );
                if grid_col + 1 < cols {
                    layout.carve(top + (height - 1) / 2, left + width, 1, corridor);
                }
                if grid_row + 1 < rows {
                    layout.carve(top + height, left + (width - 1) / 2, corridor, 1);
                }
            }
        }
        Ok(layout)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_grids_have_a_hundred_cells_and_four_corridors() {
        for corridor in 1..4 {
            let layout = Layout::linked(2, 2, [5, 5], corridor).unwrap();
            assert_eq!(layout.num_free(), 100 + 4 * corridor);
        }
        assert_eq!(
            Layout::linked(1, 2, [1, 2], 2).unwrap().to_string(),
            "......"
        );
    }
}
