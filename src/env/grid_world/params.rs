//! The numbers of a grid world, and the check that map and numbers make a world one can act in.

use super::rewards::{RewardScheme, require_finite};
use crate::env::EnvError;
use crate::env::layouts::{Cell, Direction, Layout, Tile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters that a [`GridWorld`](super::GridWorld) adds to its map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GridWorldParams {
    /// Probability in [0, 1) that a move goes to one of its two sides instead, each equally likely.
    pub slip: f64,
    /// What a step pays.
    pub rewards: RewardScheme,
    /// After how many steps an episode is truncated; `None`: ten times the number of free cells.
    pub max_steps: Option<usize>,
    /// Begin anywhere from where a goal can be reached, instead of at the map's start.
    pub random_start: bool,
}

impl GridWorldParams {
    /// The step limit on a map with `free_cells` free cells.
    pub fn resolved_max_steps(&self, free_cells: usize) -> usize {
        self.max_steps
            .unwrap_or_else(|| free_cells.saturating_mul(10))
    }
}

/// Checks that `layout` and `params` make a world: places on free cells, every goal within reach, sensible numbers.
/// O(cells); the world's constructor calls it.
///
/// # Errors
/// The [`EnvError`] of the first broken rule.
pub fn validate(layout: &Layout, params: &GridWorldParams) -> Result<(), EnvError> {
    if !(0.0..1.0).contains(&params.slip) {
        return Err(EnvError::Slip { slip: params.slip });
    }
    if params.max_steps == Some(0) {
        return Err(EnvError::NoSteps);
    }
    params.rewards.validate()?;
    if layout.free_cells().next().is_none() {
        return Err(EnvError::NoFreeCell);
    }
    validate_goals(layout, params.rewards)?;
    validate_hazards(layout, params.rewards)?;
    if params.random_start {
        return validate_random_starts(layout);
    }
    match layout.start {
        Some(start) => validate_start(layout, start),
        None => validate_drawn_starts(layout),
    }
}

fn is_free(layout: &Layout, cell: Cell) -> bool {
    cell.index() < layout.num_cells() && layout.tile(cell) != Tile::Wall
}

fn validate_goals(layout: &Layout, rewards: RewardScheme) -> Result<(), EnvError> {
    if layout.goals.is_empty() {
        return Err(EnvError::NoGoal);
    }
    for (i, goal) in layout.goals.iter().enumerate() {
        let (row, col) = layout.position(goal.cell);
        let place = layout.describe(goal.cell);
        if !is_free(layout, goal.cell) {
            return Err(EnvError::GoalInWall { row, col });
        }
        let bonus = goal.reward.unwrap_or(rewards.goal());
        require_finite(&format!("the goal {place}"), bonus)?;
        // Two finite numbers may have a sum that is not.
        let entering = format!("the step into the goal {place}");
        require_finite(&entering, rewards.step() + bonus)?;
        if layout.goals[..i]
            .iter()
            .any(|earlier| earlier.cell == goal.cell)
        {
            return Err(EnvError::DuplicateGoal { place });
        }
    }
    Ok(())
}

fn validate_hazards(layout: &Layout, rewards: RewardScheme) -> Result<(), EnvError> {
    for (i, hazard) in layout.hazards.iter().enumerate() {
        let place = layout.describe(hazard.cell);
        let misplaced = |rule| {
            Err(EnvError::MisplacedHazard {
                hazard: i,
                place: place.clone(),
                rule,
            })
        };
        if !is_free(layout, hazard.cell) {
            return misplaced("is in a wall: choose a free cell");
        }
        if layout.is_goal(hazard.cell) {
            return misplaced("is a goal, too: move one of them");
        }
        let mut earlier = layout.hazards[..i].iter();
        if earlier.any(|earlier| earlier.cell == hazard.cell) {
            return misplaced("is given twice: keep one");
        }
        let entering = format!("the step into the hazard {place}");
        require_finite(&entering, hazard.reward)?;
        require_finite(&entering, rewards.step() + hazard.reward)?;
    }
    Ok(())
}

fn validate_start(layout: &Layout, start: Cell) -> Result<(), EnvError> {
    require_start(layout, start)?;
    let distances = layout.distances_from(start);
    match layout
        .goals
        .iter()
        .find(|goal| distances[goal.cell.index()].is_none())
    {
        None => Ok(()),
        Some(goal) => Err(EnvError::GoalUnreachable {
            goal: layout.describe(goal.cell),
            start: format!("the start {}", layout.describe(start)),
        }),
    }
}

fn require_start(layout: &Layout, start: Cell) -> Result<(), EnvError> {
    let (row, col) = layout.position(start);
    if !is_free(layout, start) {
        return Err(EnvError::StartInWall { row, col });
    }
    if layout.goals.iter().any(|goal| goal.cell == start) {
        return Err(EnvError::StartIsGoal {
            place: layout.describe(start),
        });
    }
    let mut hazards = layout.hazards.iter();
    match hazards.position(|hazard| hazard.cell == start) {
        None => Ok(()),
        Some(hazard) => Err(EnvError::MisplacedHazard {
            hazard,
            place: layout.describe(start),
            rule: "is the start, too: move one of them",
        }),
    }
}

/// Each start must lead to some goal, and each goal must be led to by some start.
fn validate_drawn_starts(layout: &Layout) -> Result<(), EnvError> {
    let starts = &layout.drawn_starts;
    if starts.is_empty() {
        return Err(EnvError::NoStart);
    }
    let mut reached = vec![false; layout.goals.len()];
    for (i, start) in starts.iter().enumerate() {
        require_start(layout, start.cell)?;
        let place = layout.describe(start.cell);
        if starts[..i].iter().any(|earlier| earlier.cell == start.cell) {
            return Err(EnvError::DuplicateStart { place });
        }
        require_weight(&place, start.weight)?;
        let distances = layout.distances_from(start.cell);
        let leads = layout
            .goals
            .iter()
            .map(|goal| distances[goal.cell.index()].is_some());
        let leads: Vec<bool> = leads.collect();
        if !leads.contains(&true) {
            return Err(EnvError::StartLeadsNowhere { place });
        }
        for (reached, leads) in reached.iter_mut().zip(leads) {
            *reached |= leads;
        }
    }
    match reached.iter().position(|reached| !reached) {
        None => Ok(()),
        Some(goal) => Err(EnvError::GoalUnreachable {
            goal: layout.describe(layout.goals[goal].cell),
            start: "any start".to_owned(),
        }),
    }
}

/// Refuses weights of starts that are no finite number above 0.
pub(crate) fn require_weight(place: &str, weight: f64) -> Result<(), EnvError> {
    if weight.is_finite() && weight > 0.0 {
        return Ok(());
    }
    Err(EnvError::StartWeight {
        place: place.to_owned(),
        weight,
    })
}

/// Each goal must be entered from some cell that is no end; that cell can then be a start.
fn validate_random_starts(layout: &Layout) -> Result<(), EnvError> {
    let is_entered = |cell: Cell| {
        let mut before = Direction::ALL
            .into_iter()
            .filter_map(|direction| layout.predecessor(cell, direction));
        before.any(|cell| !layout.is_goal(cell) && !layout.is_hazard(cell))
    };
    match layout.goals.iter().find(|goal| !is_entered(goal.cell)) {
        None => Ok(()),
        Some(goal) => Err(EnvError::GoalUnreachable {
            goal: layout.describe(goal.cell),
            start: "any start".to_owned(),
        }),
    }
}
