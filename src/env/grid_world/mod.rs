//! The grid world of the source paper, section 2.1: four moves, and whatever is in the way stops the agent.
//!
//! P: with probability 1 − slip the agent moves as it chose, with slip/2 each to the left or right of that direction;
//! where the cell in question cannot be entered ([`Layout::neighbor`]) it stays. R: [`RewardScheme`]. Entering a goal or a
//! hazard terminates the episode; the step number `max_steps` truncates it, unless it enters one.
//!
//! A step costs one byte of memory traffic and no division, branch-free but for slips and ends: per cell a mask of the
//! moves that lead out of it, and a bit that says whether it is an end. Without slip a step draws no random number; with a
//! fixed start neither does a reset.
//!
//! [`GridWorld::turning`] makes of the same map a world of three actions for a walker with a heading.

mod model;
mod params;
mod rewards;
mod turns;

pub(crate) use params::require_weight;
pub use params::{GridWorldParams, validate};
pub use rewards::RewardScheme;
pub(crate) use rewards::require_finite;

use super::clock::EpisodeClock;
use super::layouts::{Cell, Direction, GoalCell, Layout, Tile};
use super::{Action, EnvError, Environment, Starts, Step};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// The bit of a cell's mask that says episodes end there, at a goal or a hazard; the four below it are [`Direction::bit`].
const END: u8 = 1 << 4;

/// An agent on a map.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct GridWorld {
    layout: Layout,
    params: GridWorldParams,
    clock: EpisodeClock,
    /// Exits and end bit of each cell; 0 for walls.
    masks: Vec<u8>,
    /// What to add to a cell's number to move in each direction, wrapping.
    offsets: [u32; 4],
    /// Number in the MDP of each free cell: how many free cells come before it.
    ranks: Vec<u32>,
    /// Reward on entering each goal, in the order of `layout.goals`, and then each hazard.
    end_rewards: Vec<f64>,
    /// Where an episode may begin.
    starts: Starts<Cell>,
    rng: ChaCha8Rng,
    cell: Cell,
}

impl GridWorld {
    /// Names of the actions, in the order of their numbers, which are those of [`Direction`].
    pub const ACTION_NAMES: [&str; 4] = ["up", "right", "down", "left"];

    /// The world on `layout`; `rng` draws slips and random starts. O(cells).
    ///
    /// # Errors
    /// What [`validate`] finds wrong.
    pub fn new(layout: Layout, params: GridWorldParams, rng: ChaCha8Rng) -> Result<Self, EnvError> {
        validate(&layout, &params)?;
        let cols = layout.cols() as u32;
        let mut world = GridWorld {
            clock: EpisodeClock::new(params.resolved_max_steps(layout.num_free())),
            masks: Vec::new(),
            offsets: [cols.wrapping_neg(), 1, cols, 1_u32.wrapping_neg()],
            ranks: ranks(&layout),
            end_rewards: Vec::new(),
            starts: Starts::equally_likely(Vec::new()),
            rng,
            cell: Cell(0),
            layout,
            params,
        };
        world.prepare();
        Ok(world)
    }

    /// Draws slips and random starts from `rng` from now on.
    pub fn reseed(&mut self, rng: ChaCha8Rng) {
        self.rng = rng;
    }

    /// Moves the goals: from the next episode on, these are the goals. An episode under way is abandoned.
    ///
    /// # Errors
    /// What [`validate`] finds wrong with them; the world is then unchanged.
    pub fn set_goals(&mut self, goals: Vec<GoalCell>) -> Result<(), EnvError> {
        let before = std::mem::replace(&mut self.layout.goals, goals);
        if let Err(error) = validate(&self.layout, &self.params) {
            self.layout.goals = before;
            return Err(error);
        }
        self.clock.abandon();
        self.prepare();
        Ok(())
    }

    /// The map, with start and goals.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The numbers it was built with.
    pub fn params(&self) -> &GridWorldParams {
        &self.params
    }

    /// After how many steps an episode is truncated.
    pub fn max_steps(&self) -> usize {
        self.clock.max_steps()
    }

    /// Where an episode may begin.
    pub fn starts(&self) -> &[Cell] {
        self.starts.places()
    }

    /// Fills in what depends on the goals.
    fn prepare(&mut self) {
        self.masks = masks(&self.layout);
        let rewards = self.params.rewards;
        let bonus = |goal: &GoalCell| goal.reward.unwrap_or(rewards.goal());
        let hazards = self.layout.hazards.iter().map(|hazard| hazard.reward);
        let bonuses = self.layout.goals.iter().map(bonus).chain(hazards);
        self.end_rewards = bonuses.map(|bonus| rewards.step() + bonus).collect();
        self.starts = match self.layout.start {
            Some(start) if !self.params.random_start => Starts::equally_likely(vec![start]),
            None if !self.params.random_start => {
                let drawn = self.layout.drawn_starts.iter();
                Starts::weighted(drawn.map(|start| (start.cell, start.weight)))
            }
            _ => {
                let distances = self.layout.distances_to_goals();
                let leads_to_goal =
                    |cell: &Cell| distances[cell.index()].is_some_and(|moves| moves > 0);
                Starts::equally_likely(self.layout.free_cells().filter(leads_to_goal).collect())
            }
        };
    }

    /// The direction in which the agent really goes.
    fn slipped(&mut self, chosen: usize) -> usize {
        if self.params.slip == 0.0 {
            return chosen;
        }
        // One number decides both whether and which way: [0, slip/2) right of it, [slip/2, slip) left of it.
        let draw = self.rng.random::<f64>();
        match draw {
            _ if draw >= self.params.slip => chosen,
            _ if 2.0 * draw < self.params.slip => (chosen + 1) % 4,
            _ => (chosen + 3) % 4,
        }
    }

    /// The cell that `direction` leads to from a cell that is no end.
    fn moved(&self, from: Cell, direction: usize) -> Cell {
        let open = u32::from(self.masks[from.index()] >> direction & 1);
        Cell(from.0.wrapping_add(self.offsets[direction] * open))
    }

    /// Whether episodes end there, in a goal or a hazard.
    fn is_end(&self, cell: Cell) -> bool {
        self.masks[cell.index()] & END != 0
    }

    /// Reward of the step that enters `cell`.
    fn reward_on_entering(&self, cell: Cell) -> f64 {
        if !self.is_end(cell) {
            return self.params.rewards.step();
        }
        let end = ends(&self.layout).position(|end| end == cell);
        self.end_rewards[end.expect("only ends carry the end bit")]
    }
}

impl Environment for GridWorld {
    type State = Cell;

    fn num_actions(&self) -> usize {
        4
    }

    fn reset(&mut self) -> Cell {
        self.clock.begin();
        self.cell = self.starts.draw(&mut self.rng);
        self.cell
    }

    fn step(&mut self, action: Action) -> Step<Cell> {
        self.clock.assert_running();
        assert!(action.index() < 4, "action {} of 4", action.0);
        let direction = self.slipped(action.index());
        self.cell = self.moved(self.cell, direction);
        let status = self.clock.tick(self.is_end(self.cell));
        Step {
            state: self.cell,
            reward: self.reward_on_entering(self.cell),
            status,
        }
    }
}

fn masks(layout: &Layout) -> Vec<u8> {
    let mut masks = vec![0; layout.num_cells()];
    for cell in layout.free_cells() {
        let open = Direction::ALL
            .into_iter()
            .filter(|&direction| layout.neighbor(cell, direction).is_some());
        masks[cell.index()] = open.fold(0, |mask, direction| mask | direction.bit());
    }
    for end in ends(layout) {
        masks[end.index()] |= END;
    }
    masks
}

/// Where episodes end: goals, then hazards.
fn ends(layout: &Layout) -> impl Iterator<Item = Cell> + '_ {
    let goals = layout.goals.iter().map(|goal| goal.cell);
    goals.chain(layout.hazards.iter().map(|hazard| hazard.cell))
}

fn ranks(layout: &Layout) -> Vec<u32> {
    let mut next = 0;
    let rank = |cell: u32| {
        let rank = next;
        next += u32::from(layout.tile(Cell(cell)) != Tile::Wall);
        rank
    };
    (0..layout.num_cells() as u32).map(rank).collect()
}
