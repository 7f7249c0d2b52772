//! The open field: n × m cells and no walls (section 2.1 and Fig. 2 of the source paper).

use super::{Layout, Tile};
use crate::env::EnvError;

impl Layout {
    /// A rectangle of free cells.
    ///
    /// # Errors
    /// [`EnvError::EmptyMap`] or [`EnvError::MapTooLarge`].
    pub fn open(rows: usize, cols: usize) -> Result<Self, EnvError> {
        Layout::filled(rows, cols, Tile::Free)
    }
}
