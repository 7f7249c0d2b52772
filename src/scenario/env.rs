//! The section `[env]`: which world.

use super::error::{BrokenRule, nearest};
use super::place::{MaxSteps, Place};
use crate::env::EnvError;
use crate::env::grid_world::{GridWorldParams, RewardScheme};
use crate::env::layouts::{Doors, Landmark, Layout, Placement};
use crate::seeds::{Stream, stream};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// What kind of world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EnvKind {
    /// A rectangle without walls.
    #[default]
    Open,
    /// rows × cols of rooms with one door in each shared wall.
    Rooms,
    /// rows × cols of open grids joined by corridors.
    Linked,
    /// A random spanning tree of corridors, plus a share of loops.
    Maze,
    /// Caves grown by a cellular automaton.
    Caves,
    /// A map drawn in characters.
    Ascii,
    /// Any finite world, as a CSV file of its edges.
    EdgeList,
}

impl EnvKind {
    /// Every kind, in the order of the documentation.
    pub const ALL: [EnvKind; 7] = [
        EnvKind::Open,
        EnvKind::Rooms,
        EnvKind::Linked,
        EnvKind::Maze,
        EnvKind::Caves,
        EnvKind::Ascii,
        EnvKind::EdgeList,
    ];

    /// The name in scenario files.
    pub fn name(self) -> &'static str {
        match self {
            EnvKind::Open => "open",
            EnvKind::Rooms => "rooms",
            EnvKind::Linked => "linked",
            EnvKind::Maze => "maze",
            EnvKind::Caves => "caves",
            EnvKind::Ascii => "ascii",
            EnvKind::EdgeList => "edge-list",
        }
    }

    /// The keys that mean something for some kinds only.
    fn own_keys(self) -> &'static [&'static str] {
        match self {
            EnvKind::Open => &["rows", "cols"],
            EnvKind::Rooms => &["rows", "cols", "room", "doors", "seed"],
            EnvKind::Linked => &["rows", "cols", "room", "corridor"],
            EnvKind::Maze => &["rows", "cols", "loops", "seed"],
            EnvKind::Caves => &["rows", "cols", "fill", "rounds", "seed"],
            EnvKind::Ascii => &["map", "rewards"],
            EnvKind::EdgeList => &["file"],
        }
    }

    fn is_map(self) -> bool {
        self != EnvKind::EdgeList
    }
}

/// One goal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GoalSpec {
    /// Where it is.
    pub at: Place,
    /// What it pays on top of a step, if not what `reward` says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reward: Option<f64>,
}

/// The section `[env]`. A key that the kind has no use for is an error.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EnvParams {
    /// open | rooms | linked | maze | caves | ascii | edge-list
    pub kind: EnvKind,
    /// Rows of cells (open 15, maze 21, caves 30: for a maze an odd number), or of rooms or grids (rooms, linked: 2).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rows: Option<usize>,
    /// Columns, as `rows`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cols: Option<usize>,
    /// rooms, linked: height and width of a room or grid in cells (5 × 5).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub room: Option<[usize; 2]>,
    /// rooms: where in its wall a door is, "center" or "random".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub doors: Option<Doors>,
    /// linked: cells from one grid to the next (1).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corridor: Option<usize>,
    /// maze: the share of walls to open beyond a spanning tree (0).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loops: Option<f64>,
    /// caves: the share of walls in the noise they grow from (0.42).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fill: Option<f64>,
    /// caves: rounds of growing (4).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rounds: Option<usize>,
    /// rooms, maze, caves: which of the random maps; the same map whatever the seed of the run (0).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// ascii: the map. `#` wall, `.` or space free, `S` start, `G` goal, 1 to 9 goals with a reward in `rewards`,
    /// `^ v < >` cells that can only be left that way.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<String>,
    /// ascii: what the goals 1 to 9 of the map pay on top of a step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rewards: Option<BTreeMap<String, f64>>,
    /// edge-list: a CSV file with the header from,action,to and optionally probability,reward; a relative path
    /// begins at the folder of the scenario.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Where episodes begin: "random", [row, column], "top-left" (the default), "top-right", "bottom-left",
    /// "bottom-right", "center"; ascii: the `S` of the map; edge-list: a state (the first of the file).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<Place>,
    /// Where episodes end: places as for `start`, and "farthest" (from the start); the default is "bottom-right",
    /// for ascii what the map says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goals: Option<Vec<GoalSpec>>,
    /// "step-cost": −1 a step (eq. 2 of the report); "goal-bonus": −1 a step and 99 at the goal (eq. 1); or
    /// { step = NUMBER, goal = NUMBER }, the second one on top of the first.
    pub reward: RewardScheme,
    /// Probability that a move goes to one of its two sides instead.
    pub slip: f64,
    /// After how many steps an episode is cut off: "auto" (ten times the number of states) or a number.
    pub max_steps: MaxSteps,
}

impl EnvParams {
    /// Writes out the defaults of the kind's own keys.
    pub(super) fn fill_defaults(&mut self) {
        let (rows, cols) = match self.kind {
            EnvKind::Open => (15, 15),
            EnvKind::Rooms | EnvKind::Linked => (2, 2),
            EnvKind::Maze => (21, 21),
            EnvKind::Caves => (30, 30),
            EnvKind::Ascii | EnvKind::EdgeList => (0, 0),
        };
        for key in self.kind.own_keys() {
            match *key {
                "rows" => fill(&mut self.rows, rows),
                "cols" => fill(&mut self.cols, cols),
                "room" => fill(&mut self.room, [5, 5]),
                "doors" => fill(&mut self.doors, Doors::default()),
                "corridor" => fill(&mut self.corridor, 1),
                "loops" => fill(&mut self.loops, 0.0),
                "fill" => fill(&mut self.fill, 0.42),
                "rounds" => fill(&mut self.rounds, 4),
                "seed" => fill(&mut self.seed, 0),
                _ => {} // map, rewards and file have no default
            }
        }
        if self.kind.is_map() && self.kind != EnvKind::Ascii {
            fill(&mut self.start, Place::from("top-left"));
            let goal = GoalSpec {
                at: Place::from("bottom-right"),
                reward: None,
            };
            fill(&mut self.goals, vec![goal]);
        }
    }

    /// Whether what is given goes together; the map itself is judged when it is built.
    pub(super) fn validate(&self) -> Result<(), BrokenRule> {
        let given = [
            ("rows", self.rows.is_some()),
            ("cols", self.cols.is_some()),
            ("room", self.room.is_some()),
            ("doors", self.doors.is_some()),
            ("corridor", self.corridor.is_some()),
            ("loops", self.loops.is_some()),
            ("fill", self.fill.is_some()),
            ("rounds", self.rounds.is_some()),
            ("seed", self.seed.is_some()),
            ("map", self.map.is_some()),
            ("rewards", self.rewards.is_some()),
            ("file", self.file.is_some()),
        ];
        let own = self.kind.own_keys();
        let stray = given
            .iter()
            .find(|(key, given)| *given && !own.contains(key));
        if let Some((key, _)) = stray {
            return Err(self.stray(key));
        }
        match self.kind {
            EnvKind::Ascii if self.map.is_none() => Err(missing("env.map", self.kind)),
            EnvKind::EdgeList if self.file.is_none() => Err(missing("env.file", self.kind)),
            EnvKind::EdgeList if self.goals.is_none() => Err(missing("env.goals", self.kind)),
            EnvKind::EdgeList if self.slip != 0.0 => Err(BrokenRule::new(
                "env.slip",
                "env.slip is for maps: an edge list says itself where an action may lead, in its column probability",
            )),
            _ => Ok(()),
        }
    }

    /// A key of another kind.
    fn stray(&self, key: &str) -> BrokenRule {
        let owners: Vec<String> = EnvKind::ALL
            .iter()
            .filter(|kind| kind.own_keys().contains(&key))
            .map(|kind| format!("\"{}\"", kind.name()))
            .collect();
        let message = format!(
            "env.{key} means nothing for kind = \"{}\": it belongs to {}",
            self.kind.name(),
            owners.join(", ")
        );
        BrokenRule::new(format!("env.{key}"), message)
    }

    /// The numbers that a map needs to become a world.
    pub(crate) fn grid_world_params(&self) -> GridWorldParams {
        GridWorldParams {
            slip: self.slip,
            rewards: self.reward,
            max_steps: self.max_steps.given(),
            random_start: self.starts_anywhere(),
        }
    }

    /// Whether `start = "random"`.
    pub(crate) fn starts_anywhere(&self) -> bool {
        self.start == Some(Place::from("random"))
    }

    /// The map with its start and goals. Call it on parameters with their defaults written out.
    ///
    /// # Errors
    /// What the map's constructors find wrong, with the key to blame.
    pub(crate) fn layout(&self) -> Result<Layout, BrokenRule> {
        let mut layout = self.bare_layout().map_err(|e| self.blame(e))?;
        if let Some(start) = &self.start
            && !self.starts_anywhere()
        {
            let at = placement("env.start", start)?;
            layout = layout
                .with_start(at)
                .map_err(|e| place_rule("env.start", &e))?;
        }
        if let Some(goals) = &self.goals {
            layout.goals.clear();
            for (i, goal) in goals.iter().enumerate() {
                let key = format!("env.goals[{i}].at");
                let at = placement(&key, &goal.at)?;
                layout = layout
                    .with_goal(at, goal.reward)
                    .map_err(|e| place_rule(&key, &e))?;
            }
        }
        Ok(layout)
    }

    fn bare_layout(&self) -> Result<Layout, EnvError> {
        let rows = self.rows.unwrap_or_default();
        let cols = self.cols.unwrap_or_default();
        let room = self.room.unwrap_or_default();
        let mut rng = stream(self.seed.unwrap_or_default(), Stream::Layout);
        match self.kind {
            EnvKind::Open => Layout::open(rows, cols),
            EnvKind::Rooms => {
                Layout::rooms(rows, cols, room, self.doors.unwrap_or_default(), &mut rng)
            }
            EnvKind::Linked => Layout::linked(rows, cols, room, self.corridor.unwrap_or_default()),
            EnvKind::Maze => Layout::maze(rows, cols, self.loops.unwrap_or_default(), &mut rng),
            EnvKind::Caves => {
                let fill = self.fill.unwrap_or_default();
                Layout::caves(rows, cols, fill, self.rounds.unwrap_or_default(), &mut rng)
            }
            EnvKind::Ascii | EnvKind::EdgeList => Layout::from_ascii(
                self.map.as_deref().unwrap_or_default(),
                &self.digit_rewards()?,
            ),
        }
    }

    /// The table of rewards by digit.
    fn digit_rewards(&self) -> Result<BTreeMap<char, f64>, EnvError> {
        let table = self.rewards.iter().flatten();
        table
            .map(|(key, &reward)| {
                let mut characters = key.chars();
                match (characters.next(), characters.next()) {
                    (Some(digit), None) => Ok((digit, reward)),
                    (first, _) => Err(EnvError::RewardKey {
                        key: first.unwrap_or(' '),
                    }),
                }
            })
            .collect()
    }

    /// The key to blame for what is wrong with a world.
    pub(crate) fn blame(&self, error: EnvError) -> BrokenRule {
        let key = match &error {
            EnvError::RewardKey { .. } => "env.rewards".to_owned(),
            EnvError::GoalWithoutReward { .. } => "env.rewards".to_owned(),
            EnvError::LayoutParameter { parameter, .. } => format!("env.{parameter}"),
            EnvError::Slip { .. } => "env.slip".to_owned(),
            EnvError::NoSteps => "env.max_steps".to_owned(),
            EnvError::RewardNotFinite { .. } | EnvError::StepRewardPositive { .. } => {
                "env.reward".to_owned()
            }
            EnvError::NoGoal
            | EnvError::GoalInWall { .. }
            | EnvError::DuplicateGoal { .. }
            | EnvError::GoalUnreachable { .. } => self.or_map("env.goals", self.goals.is_some()),
            EnvError::NoStart | EnvError::StartInWall { .. } | EnvError::StartIsGoal { .. } => {
                self.or_map("env.start", self.start.is_some())
            }
            EnvError::EmptyMap | EnvError::MapTooLarge { .. } if self.kind != EnvKind::Ascii => {
                "env.rows".to_owned()
            }
            _ if self.kind == EnvKind::EdgeList => "env.file".to_owned(),
            _ => "env.map".to_owned(),
        };
        BrokenRule::new(key, error.to_string())
    }

    /// `key` if it is given, else the map that says the same by its characters.
    fn or_map(&self, key: &str, given: bool) -> String {
        match self.kind {
            EnvKind::Ascii if !given => "env.map".to_owned(),
            _ => key.to_owned(),
        }
    }
}

fn fill<T>(slot: &mut Option<T>, default: T) {
    slot.get_or_insert(default);
}

fn missing(key: &str, kind: EnvKind) -> BrokenRule {
    BrokenRule::new(
        key,
        format!("{key} is missing: kind = \"{}\" needs it", kind.name()),
    )
}

fn place_rule(key: &str, error: &EnvError) -> BrokenRule {
    BrokenRule::new(key, error.to_string())
}

/// A place on a map.
fn placement(key: &str, place: &Place) -> Result<Placement, BrokenRule> {
    const LANDMARKS: [(&str, Landmark); 6] = [
        ("top-left", Landmark::TopLeft),
        ("top-right", Landmark::TopRight),
        ("bottom-left", Landmark::BottomLeft),
        ("bottom-right", Landmark::BottomRight),
        ("center", Landmark::Center),
        ("farthest", Landmark::Farthest),
    ];
    let name = match place {
        Place::Cell(at) => return Ok(Placement::At(*at)),
        Place::Named(name) => name,
    };
    if let Some((_, landmark)) = LANDMARKS.iter().find(|(n, _)| n == name) {
        return Ok(Placement::Named(*landmark));
    }
    let names = LANDMARKS.map(|(n, _)| n);
    let hint = match nearest(name, names) {
        Some(near) => format!("did you mean \"{near}\"?"),
        None => format!("it is one of {}, or [row, column]", names.join(", ")),
    };
    Err(BrokenRule::new(
        key,
        format!("\"{name}\" is no place on a map; {hint}"),
    ))
}
