//! Maps: which cells are free, where the start and the goals are.
//!
//! A [`Layout`] is a plain value. Cells are numbered row by row, `cell = row · cols + col`, rows downwards from the
//! top, both from 0. There is no outer wall unless a map draws one: the edge of the map stops the agent anyway.
//!
//! | constructor | what it makes |
//! |---|---|
//! | [`Layout::open`] | a rectangle without walls (Fig. 2 of the source paper) |
//! | [`Layout::rooms`] | rows × columns of rooms, one door in each shared wall |
//! | [`Layout::linked`] | rows × columns of open grids joined by corridors (Fig. 9) |
//! | [`Layout::maze`] | a random spanning tree, plus a share of loops |
//! | [`Layout::caves`] | a cellular automaton's caves, connected |
//! | [`Layout::from_ascii`] | what you draw |

mod ascii;
mod caves;
mod distances;
mod linked;
mod maze;
mod open;
mod placement;
mod random_goal;
mod rooms;

pub use placement::{Landmark, Placement};
pub use rooms::Doors;

use super::{Action, EnvError};
use serde::{Deserialize, Serialize};

/// The most cells a map may have: a hundred times the largest world that runs in reasonable memory, so that a slip of
/// the pen is an error and not the end of the memory.
pub(super) const MAX_CELLS: usize = 100_000_000;

/// A cell of a map, and the state of a [`GridWorld`](super::GridWorld): `row · cols + col`.
///
/// Number of a cell. Where it lies is known to the map: [`Layout::position`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Cell(pub u32);

impl Cell {
    /// The cell as an array index.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// The four moves, in the order of their action numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[repr(u8)]
pub enum Direction {
    /// Towards row 0.
    Up = 0,
    /// Towards the last column.
    Right = 1,
    /// Towards the last row.
    Down = 2,
    /// Towards column 0.
    Left = 3,
}

impl Direction {
    /// All four, by action number.
    pub const ALL: [Direction; 4] = [
        Direction::Up,
        Direction::Right,
        Direction::Down,
        Direction::Left,
    ];

    /// The action that moves this way.
    pub fn action(self) -> Action {
        Action(self as u16)
    }

    /// The way back.
    pub fn opposite(self) -> Self {
        Self::ALL[(self as usize + 2) % 4]
    }

    /// This direction's bit in a mask of exits.
    pub(crate) fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// Kind of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Tile {
    /// Cannot be entered.
    Wall,
    /// Can be entered and left any way.
    Free,
    /// Can be entered from anywhere, but left only in this direction; other moves stay in place.
    OneWay(Direction),
}

/// A cell where episodes end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GoalCell {
    /// Where.
    pub cell: Cell,
    /// Added to the reward of the step that enters it; `None` for what the reward scheme gives every goal.
    pub reward: Option<f64>,
    /// The digit 1 to 9 that stands for it in an ASCII map; `None` for `G`.
    pub digit: Option<u8>,
}

impl GoalCell {
    /// A goal that pays what the reward scheme says.
    pub fn new(cell: Cell) -> Self {
        GoalCell {
            cell,
            reward: None,
            digit: None,
        }
    }
}

/// A cell where episodes end, and that is no goal: lava, a hole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HazardCell {
    /// Where.
    pub cell: Cell,
    /// Added to the reward of the step that enters it.
    pub reward: f64,
}

/// One of several places where episodes begin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StartCell {
    /// Where it is.
    pub cell: Cell,
    /// How often episodes begin there, beside the weights of the others; finite and above 0.
    pub weight: f64,
}

/// A map with its starts, goals and hazards.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Layout {
    rows: usize,
    cols: usize,
    /// Row by row; its length is rows × cols, at least 1.
    tiles: Vec<Tile>,
    /// The fixed start, if there is one.
    pub start: Option<Cell>,
    /// Places of which one is drawn for each episode, where there is no fixed start.
    pub drawn_starts: Vec<StartCell>,
    /// Where episodes end, in the order given.
    pub goals: Vec<GoalCell>,
    /// Where they end without a goal, in the order given.
    #[serde(default)]
    pub hazards: Vec<HazardCell>,
}

impl Layout {
    /// A map of one kind of tile, without start or goals.
    ///
    /// # Errors
    /// [`EnvError::EmptyMap`] or [`EnvError::MapTooLarge`].
    pub fn filled(rows: usize, cols: usize, tile: Tile) -> Result<Self, EnvError> {
        if rows == 0 || cols == 0 {
            return Err(EnvError::EmptyMap);
        }
        let cells = rows.checked_mul(cols).filter(|&cells| cells <= MAX_CELLS);
        let cells = cells.ok_or(EnvError::MapTooLarge {
            rows,
            cols,
            limit: MAX_CELLS,
        })?;
        Ok(Layout {
            rows,
            cols,
            tiles: vec![tile; cells],
            start: None,
            drawn_starts: Vec::new(),
            goals: Vec::new(),
            hazards: Vec::new(),
        })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Number of cells, walls included: rows × columns.
    pub fn num_cells(&self) -> usize {
        self.tiles.len()
    }

    /// Number of cells that are not walls.
    pub fn num_free(&self) -> usize {
        self.free_cells().count()
    }

    /// The cells that are not walls, in order of their numbers.
    pub fn free_cells(&self) -> impl Iterator<Item = Cell> + '_ {
        self.cells().filter(|&cell| self.tile(cell) != Tile::Wall)
    }

    /// The cell in `row` and `col`, if the map reaches that far.
    pub fn cell(&self, row: usize, col: usize) -> Option<Cell> {
        (row < self.rows && col < self.cols).then(|| Cell((row * self.cols + col) as u32))
    }

    /// Row and column of `cell`.
    pub fn position(&self, cell: Cell) -> (usize, usize) {
        (cell.index() / self.cols, cell.index() % self.cols)
    }

    /// What `cell` is made of.
    ///
    /// # Panics
    /// If `cell` is not on the map.
    pub fn tile(&self, cell: Cell) -> Tile {
        self.tiles[cell.index()]
    }

    /// Changes what `cell` is made of.
    ///
    /// # Panics
    /// If `cell` is not on the map.
    pub fn set_tile(&mut self, cell: Cell, tile: Tile) {
        self.tiles[cell.index()] = tile;
    }

    /// The cell that a move from `cell` leads to, `None` where it bumps: at the edge, at a wall, against a one-way cell's
    /// arrow.
    pub fn neighbor(&self, cell: Cell, direction: Direction) -> Option<Cell> {
        let next = self.beside(cell, direction)?;
        let may_leave = match self.tile(cell) {
            Tile::Wall => false,
            Tile::Free => true,
            Tile::OneWay(only) => only == direction,
        };
        (may_leave && self.tile(next) != Tile::Wall).then_some(next)
    }

    /// The cell in `direction` of `cell` from which the opposite move leads to `cell`, if there is one.
    pub(crate) fn predecessor(&self, cell: Cell, direction: Direction) -> Option<Cell> {
        let before = self.beside(cell, direction)?;
        (self.neighbor(before, direction.opposite()) == Some(cell)).then_some(before)
    }

    /// The same map with its start at `at`.
    ///
    /// # Errors
    /// If the place is not on the map, or cannot be found ([`Placement`]).
    pub fn with_start(mut self, at: impl Into<Placement>) -> Result<Self, EnvError> {
        // A new start is not looked for relative to the old one.
        self.start = None;
        self.drawn_starts.clear();
        self.start = Some(self.locate(at.into())?);
        Ok(self)
    }

    /// The same map with one place more where episodes may begin, instead of a fixed start.
    ///
    /// # Errors
    /// As [`with_start`](Self::with_start).
    pub fn with_drawn_start(
        mut self,
        at: impl Into<Placement>,
        weight: f64,
    ) -> Result<Self, EnvError> {
        self.start = None;
        let cell = self.locate(at.into())?;
        self.drawn_starts.push(StartCell { cell, weight });
        Ok(self)
    }

    /// Whether it is the fixed start, or one of those that are drawn.
    pub fn is_start(&self, cell: Cell) -> bool {
        self.start == Some(cell) || self.drawn_starts.iter().any(|start| start.cell == cell)
    }

    /// The same map with one goal more, at `at`; see [`GoalCell::reward`].
    ///
    /// # Errors
    /// If the place is not on the map, or cannot be found ([`Placement`]).
    pub fn with_goal(
        mut self,
        at: impl Into<Placement>,
        reward: Option<f64>,
    ) -> Result<Self, EnvError> {
        let cell = self.locate(at.into())?;
        self.goals.push(GoalCell {
            reward,
            ..GoalCell::new(cell)
        });
        Ok(self)
    }

    /// The same map with one hazard more, at `at`; see [`HazardCell::reward`].
    ///
    /// # Errors
    /// If the place is not on the map, or cannot be found ([`Placement`]).
    pub fn with_hazard(mut self, at: impl Into<Placement>, reward: f64) -> Result<Self, EnvError> {
        let cell = self.locate(at.into())?;
        self.hazards.push(HazardCell { cell, reward });
        Ok(self)
    }

    /// Whether `cell` is a goal.
    pub fn is_goal(&self, cell: Cell) -> bool {
        self.goals.iter().any(|goal| goal.cell == cell)
    }

    /// Whether `cell` is a hazard.
    pub(crate) fn is_hazard(&self, cell: Cell) -> bool {
        self.hazards.iter().any(|hazard| hazard.cell == cell)
    }

    /// `[row, col]`, for messages.
    pub(crate) fn describe(&self, cell: Cell) -> String {
        let (row, col) = self.position(cell);
        format!("[{row}, {col}]")
    }

    /// The cell next to `cell` on the map, whatever it is made of.
    fn beside(&self, cell: Cell, direction: Direction) -> Option<Cell> {
        let (row, col) = self.position(cell);
        match direction {
            Direction::Up => self.cell(row.checked_sub(1)?, col),
            Direction::Right => self.cell(row, col + 1),
            Direction::Down => self.cell(row + 1, col),
            Direction::Left => self.cell(row, col.checked_sub(1)?),
        }
    }

    fn cells(&self) -> impl Iterator<Item = Cell> + use<> {
        (0..self.tiles.len() as u32).map(Cell)
    }

    /// Makes the rectangle of `height` × `width` cells with this top left corner free.
    fn carve(&mut self, top: usize, left: usize, height: usize, width: usize) {
        for row in top..top + height {
            let begin = row * self.cols + left;
            self.tiles[begin..begin + width].fill(Tile::Free);
        }
    }
}
