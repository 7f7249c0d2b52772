//! The section `[env]`: which world.

use super::error::BrokenRule;
use super::goals::{GoalSpec, Goals, HazardSpec};
use super::place::{MaxSteps, MoveAfter, Place};
use super::start::Start;
use crate::env::EnvError;
use crate::env::boards::Fall;
use crate::env::grid_world::RewardScheme;
use crate::env::layouts::Doors;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Kind of world.
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
    /// bsuite's deep sea: N steps down, a treasure at the bottom right.
    DeepSea,
    /// A chain against the current: 5 near, 10 000 far.
    RiverSwim,
    /// Gymnasium's cliff of 4 × 12 cells.
    Cliff,
    /// Gymnasium's lake of 4 × 4 or 8 × 8 cells, slippery.
    FrozenLake,
    /// Gymnasium's taxi.
    Taxi,
    /// A short way that falls, and a safe one.
    Bridge,
}

impl EnvKind {
    /// Every kind, in the order of the documentation.
    pub const ALL: [EnvKind; 13] = [
        EnvKind::Open,
        EnvKind::Rooms,
        EnvKind::Linked,
        EnvKind::Maze,
        EnvKind::Caves,
        EnvKind::Ascii,
        EnvKind::EdgeList,
        EnvKind::DeepSea,
        EnvKind::RiverSwim,
        EnvKind::Cliff,
        EnvKind::FrozenLake,
        EnvKind::Taxi,
        EnvKind::Bridge,
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
            EnvKind::DeepSea => "deep-sea",
            EnvKind::RiverSwim => "river-swim",
            EnvKind::Cliff => "cliff",
            EnvKind::FrozenLake => "frozen-lake",
            EnvKind::Taxi => "taxi",
            EnvKind::Bridge => "bridge",
        }
    }

    /// The keys that mean something for some kinds only.
    pub(super) fn own_keys(self) -> &'static [&'static str] {
        match self {
            EnvKind::Open => &["rows", "cols", "actions"],
            EnvKind::Rooms => &["rows", "cols", "room", "doors", "seed", "actions"],
            EnvKind::Linked => &["rows", "cols", "room", "corridor", "actions"],
            EnvKind::Maze => &["rows", "cols", "loops", "seed", "actions"],
            EnvKind::Caves => &["rows", "cols", "fill", "rounds", "seed", "actions"],
            EnvKind::Ascii => &["map", "rewards", "actions"],
            EnvKind::EdgeList => &["file"],
            EnvKind::DeepSea => &["size", "stochastic", "seed"],
            EnvKind::RiverSwim | EnvKind::FrozenLake => &["size"],
            EnvKind::Cliff | EnvKind::Taxi => &[],
            EnvKind::Bridge => &["fall"],
        }
    }

    /// Whether `key` means something for it, as far as that depends on the kind.
    pub(super) fn has_use_for(self, key: &str) -> bool {
        let is_own = |kind: &EnvKind| kind.own_keys().contains(&key);
        is_own(&self) || !EnvKind::ALL.iter().any(is_own)
    }

    /// Whether it is a board of the field, which says itself where episodes begin and end and what steps pay.
    pub(super) fn is_board(self) -> bool {
        matches!(
            self,
            EnvKind::DeepSea
                | EnvKind::RiverSwim
                | EnvKind::Cliff
                | EnvKind::FrozenLake
                | EnvKind::Taxi
                | EnvKind::Bridge
        )
    }

    fn is_map(self) -> bool {
        self != EnvKind::EdgeList && !self.is_board()
    }
}

/// What a walker on a map does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Actions {
    /// Up, right, down, left.
    #[default]
    Moves,
    /// Turn left, turn right, forward.
    Turns,
}

/// Which of the two lists of goals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum GoalList {
    /// Those that a run begins with.
    First,
    /// Those that take their place.
    Moved,
}

impl GoalList {
    /// Its key.
    pub(super) fn key(self) -> &'static str {
        match self {
            GoalList::First => "env.goals",
            GoalList::Moved => "env.moved_goals",
        }
    }

    /// The goals in it, if it is given and lists them.
    pub(super) fn of(self, env: &EnvParams) -> Option<&[GoalSpec]> {
        match (self, &env.goals) {
            (GoalList::First, Some(Goals::Listed(goals))) => Some(goals),
            (GoalList::First, _) => None,
            (GoalList::Moved, _) => env.moved_goals.as_deref(),
        }
    }

    /// Whether each seed draws a goal of its own instead.
    pub(super) fn is_drawn(self, env: &EnvParams) -> bool {
        self == GoalList::First && matches!(env.goals, Some(Goals::Drawn(_)))
    }
}

/// The section `[env]`. A key that the kind has no use for is an error.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EnvParams {
    /// Which kind of world.
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
    /// rooms: where in its wall a door is.
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
    /// caves: rounds of growing (4), at most 1000.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rounds: Option<usize>,
    /// deep-sea, river-swim, frozen-lake: rows (10), states (6), or cells a side (4, or 8).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<usize>,
    /// deep-sea: bsuite's stochastic form (false): a step right fails with probability 1/size, and a standard normal number is added
    /// to what the last step pays at both ends of the last row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stochastic: Option<bool>,
    /// bridge: what a fall leads to, "pit" (the end, at 100), "swamp" (30 steps back) or "back" (the start, at 20).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fall: Option<Fall>,
    /// rooms, maze, caves, deep-sea: which of the random maps; the same map whatever the seed of the run (0).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// ascii: the map. `#` wall, `.` or space free, `S` start, `G` goal, 1 to 9 goals with a reward in `rewards`,
    /// `^ v < >` cells that can only be left that way.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(example = "S..#\n...G\n")]
    pub map: Option<String>,
    /// ascii: what the goals 1 to 9 of the map pay on top of a step.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(example = example_of_rewards())]
    pub rewards: Option<BTreeMap<String, f64>>,
    /// edge-list: a CSV file with the header from,action,to and optionally probability,reward, or from,to and optionally
    /// reward: then each line is an action of its own. A relative path begins at the folder of the scenario.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(example = "world.csv")]
    pub file: Option<PathBuf>,
    /// Maps: what a walker does. "moves" (the default): up, right, down, left, its states are cells. "turns": turn left, turn
    /// right, forward, its states are cells with a heading, named "row,column,heading"; it begins heading east, and a goal
    /// is one whatever the heading. Pages and `show` then list states by name, and draw no map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actions: Option<Actions>,
    /// Where episodes begin: "random", [row, column], "top-left" (the default), "top-right", "bottom-left",
    /// "bottom-right", "center"; ascii: the `S` of the map; edge-list: a state (the first of the file). Or one of
    /// several places, drawn for each episode: [PLACE, ...], or [{ at = PLACE, weight = NUMBER }, ...], as often as their
    /// weights (1) say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<Start>,
    /// Where episodes end: places as for `start`, and "farthest" (from the start); the default is "bottom-right",
    /// for ascii what the map says. On maps also "random": one goal, which each seed of the run puts at a place of its
    /// own, each that can be reached equally likely.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goals: Option<Goals>,
    /// Goals that take the place of `goals` while the run goes on; the agent is not told. Without them nothing moves.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(example = example_of_moved_goals())]
    pub moved_goals: Option<Vec<GoalSpec>>,
    /// With `moved_goals`: the episodes before the move, "half" of the run's (the default) or a number.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(example = 250)]
    pub goals_move_after: Option<MoveAfter>,
    /// Maps: where episodes end, too, though it is no goal (lava, holes), and what this pays on top of a step.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(example = example_of_hazards())]
    pub hazards: Option<Vec<HazardSpec>>,
    /// "step-cost": −1 a step (eq. 2 of the paper); "goal-bonus": −1 a step and 99 at the goal (eq. 1); or
    /// { step = NUMBER, goal = NUMBER }, the second one on top of the first. edge-list: for lines without a reward.
    pub reward: RewardScheme,
    /// Probability that a move goes to one of its two sides instead, the heading staying what it was; turns never fail.
    pub slip: f64,
    /// edge-list without goals, and boards without ends (river-swim): nothing is reset when the clock runs out, an "episode" is a
    /// window of `max_steps` steps of one unbroken life, and what is best is the most that can be earned a step for ever.
    /// Most learners need agent.gamma < 1 then.
    pub continuing: bool,
    /// After how many steps an episode is cut off: "auto" (ten times the number of states; boards of the field: as is usual
    /// there) or a number, at most 1 000 000 000.
    pub max_steps: MaxSteps,
}

// Examples for the schema. They are functions because its derive reads no other expression without the whole of syn.

fn example_of_rewards() -> BTreeMap<&'static str, f64> {
    BTreeMap::from([("1", 20.0)])
}

fn example_of_hazards() -> [HazardSpec; 1] {
    [HazardSpec {
        at: Place::Cell([1, 2]),
        reward: -50.0,
    }]
}

fn example_of_moved_goals() -> [GoalSpec; 1] {
    [GoalSpec {
        at: Place::from("top-right"),
        reward: None,
    }]
}

/// The longest episode: what "auto" gives the largest map.
const MOST_STEPS: usize = 1_000_000_000;

impl EnvParams {
    /// Writes out the defaults of the kind's own keys.
    pub(super) fn fill_defaults(&mut self) {
        let (rows, cols) = match self.kind {
            EnvKind::Open => (15, 15),
            EnvKind::Rooms | EnvKind::Linked => (2, 2),
            EnvKind::Maze => (21, 21),
            EnvKind::Caves => (30, 30),
            _ => (0, 0), // no such keys
        };
        let size = match self.kind {
            EnvKind::DeepSea => 10,
            EnvKind::RiverSwim => 6,
            _ => 4,
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
                "size" => fill(&mut self.size, size),
                "stochastic" => fill(&mut self.stochastic, false),
                "fall" => fill(&mut self.fall, Fall::default()),
                "actions" => fill(&mut self.actions, Actions::default()),
                _ => {} // map, rewards and file have no default
            }
        }
        if self.kind.is_map() && self.kind != EnvKind::Ascii {
            fill(&mut self.start, Start::At(Place::from("top-left")));
            let goal = GoalSpec {
                at: Place::from("bottom-right"),
                reward: None,
            };
            fill(&mut self.goals, Goals::Listed(vec![goal]));
        }
        if self.moved_goals.is_some() {
            fill(&mut self.goals_move_after, MoveAfter::default());
        }
    }

    /// Whether each number is one, whatever the others are.
    pub(super) fn check_numbers(&self) -> Result<(), BrokenRule> {
        if let Some(start) = &self.start {
            start.validate()?;
        }
        if !(0.0..1.0).contains(&self.slip) {
            let error = EnvError::Slip { slip: self.slip };
            return Err(self.blame(error, GoalList::First));
        }
        if self.max_steps.given().is_some_and(|n| n > MOST_STEPS) {
            return Err(BrokenRule::new(
                "env.max_steps",
                format!("env.max_steps must be at most {MOST_STEPS}"),
            ));
        }
        Ok(())
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
            ("size", self.size.is_some()),
            ("stochastic", self.stochastic.is_some()),
            ("fall", self.fall.is_some()),
            ("actions", self.actions.is_some()),
        ];
        let own = self.kind.own_keys();
        let stray = given
            .iter()
            .find(|(key, given)| *given && !own.contains(key));
        if let Some((key, _)) = stray {
            return Err(self.stray(key));
        }
        if self.kind.is_board() {
            self.require_board()?;
        }
        if self.continuing {
            self.require_no_goals()?;
        }
        if self.goals_move_after.is_some() && self.moved_goals.is_none() {
            return Err(BrokenRule::new(
                "env.goals_move_after",
                "env.goals_move_after needs env.moved_goals: where the goals move to",
            )
            .beside(&["env.moved_goals"]));
        }
        let of_kind = self.check_kind();
        of_kind.map_err(|broken| broken.beside(&["env.kind", "env.continuing"]))
    }

    /// Whether the kind has what it needs, and nothing that it has no use for.
    fn check_kind(&self) -> Result<(), BrokenRule> {
        match self.kind {
            EnvKind::Ascii if self.map.is_none() => Err(missing("env.map", self.kind)),
            EnvKind::EdgeList if self.file.is_none() => Err(missing("env.file", self.kind)),
            EnvKind::EdgeList if self.goals.is_none() && !self.continuing => {
                Err(missing("env.goals", self.kind))
            }
            EnvKind::EdgeList if GoalList::First.is_drawn(self) => Err(BrokenRule::new(
                "env.goals",
                "env.goals = \"random\" is for maps: an edge list needs the names of its goals",
            )),
            EnvKind::EdgeList if self.hazards.is_some() => Err(BrokenRule::new(
                "env.hazards",
                "env.hazards is for maps: in an edge list an end is a state without lines of its own, or a goal",
            )),
            EnvKind::EdgeList if self.slip != 0.0 => Err(BrokenRule::new(
                "env.slip",
                "env.slip is for maps: an edge list says itself where an action may lead, in its column probability",
            )),
            _ => Ok(()),
        }
    }

    /// Whether nothing is said of what the board says itself.
    fn require_board(&self) -> Result<(), BrokenRule> {
        let said = [
            ("env.start", self.start.is_some()),
            ("env.goals", self.goals.is_some()),
            ("env.moved_goals", self.moved_goals.is_some()),
            ("env.hazards", self.hazards.is_some()),
            ("env.reward", self.reward != RewardScheme::default()),
            ("env.slip", self.slip != 0.0),
        ];
        match said.iter().find(|(_, said)| *said) {
            None => Ok(()),
            Some((key, _)) => Err(BrokenRule::new(
                *key,
                format!(
                    "{key} means nothing for kind = \"{}\": it has its own starts, ends, rewards and chances",
                    self.kind.name()
                ),
            )
            .beside(&["env.kind"])),
        }
    }

    /// Whether nothing is said of goals, where episodes would end.
    fn require_no_goals(&self) -> Result<(), BrokenRule> {
        if self.kind.is_map() {
            let message = format!(
                "env.continuing is for worlds without ends: kind = \"{}\" has goals, where episodes end; a world without goals \
                 can be written as an edge list",
                self.kind.name()
            );
            return Err(BrokenRule::new("env.continuing", message).beside(&["env.kind"]));
        }
        for list in [GoalList::First, GoalList::Moved] {
            if list.of(self).is_some_and(|goals| !goals.is_empty()) {
                let key = list.key();
                let message = format!(
                    "{key}: episodes end at goals, and a continuing task has none; leave out one of the two"
                );
                return Err(BrokenRule::new(key, message).beside(&["env.kind", "env.continuing"]));
            }
        }
        Ok(())
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
        BrokenRule::new(format!("env.{key}"), message).beside(&["env.kind"])
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
