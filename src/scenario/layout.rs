//! From the section `[env]` to a map, and from a world's complaint to the key that is to blame.

use super::env::{EnvKind, EnvParams, GoalList};
use super::error::{BrokenRule, nearest};
use super::place::Place;
use super::start::Start;
use crate::env::EnvError;
use crate::env::grid_world::GridWorldParams;
use crate::env::layouts::{Landmark, Layout, Placement};
use crate::seeds::{Stream, stream};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

/// Keys that decide which states there are.
pub(super) const STATES: [&str; 14] = [
    "env.kind",
    "env.rows",
    "env.cols",
    "env.room",
    "env.doors",
    "env.corridor",
    "env.loops",
    "env.fill",
    "env.rounds",
    "env.seed",
    "env.size",
    "env.map",
    "env.file",
    "env.actions",
];

/// Keys that decide which of them an episode visits, and what that pays.
const EPISODES: [&str; 7] = [
    "env.start",
    "env.goals",
    "env.moved_goals",
    "env.hazards",
    "env.reward",
    "env.rewards",
    "env.continuing",
];

impl EnvParams {
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
        self.start == Some(Start::At(Place::from("random")))
    }

    /// The map with its start and these goals, which `seed` draws if they are drawn. Call it on parameters with their
    /// defaults written out.
    ///
    /// # Errors
    /// What the map's constructors find wrong, with the key to blame.
    pub(super) fn layout(&self, goals: GoalList, seed: u64) -> Result<Layout, BrokenRule> {
        let mut layout = self.bare_layout().map_err(|e| self.blame(e, goals))?;
        match &self.start {
            Some(Start::At(place)) if !self.starts_anywhere() => {
                let at = placement("env.start", place)?;
                layout = layout
                    .with_start(at)
                    .map_err(|e| place_rule("env.start", &e))?;
            }
            Some(Start::Drawn(starts)) => {
                for (i, start) in starts.iter().enumerate() {
                    let key = format!("env.start[{i}].at");
                    let at = placement(&key, &start.at)?;
                    layout = layout
                        .with_drawn_start(at, start.weight)
                        .map_err(|e| place_rule(&key, &e))?;
                }
            }
            _ => {}
        }
        for (i, hazard) in self.hazards.iter().flatten().enumerate() {
            let key = format!("env.hazards[{i}].at");
            let at = placement(&key, &hazard.at)?;
            layout = layout
                .with_hazard(at, hazard.reward)
                .map_err(|e| place_rule(&key, &e))?;
        }
        if goals.is_drawn(self) {
            let drawn = layout.with_random_goal(self.starts_anywhere(), &mut goal_stream(seed));
            return drawn.map_err(|e| self.blame(e, goals));
        }
        if let Some(specs) = goals.of(self) {
            layout.goals.clear();
            for (i, goal) in specs.iter().enumerate() {
                let key = format!("{}[{i}].at", goals.key());
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
            // Kinds that are no maps have none, and their keys say so.
            _ => Layout::from_ascii(
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

    /// The key to blame for what is wrong with the world that has these goals.
    pub(super) fn blame(&self, error: EnvError, goals: GoalList) -> BrokenRule {
        if let EnvError::Several { mut errors } = error {
            let more: Vec<String> = errors.drain(1..).map(|error| error.to_string()).collect();
            return self.blame(errors.remove(0), goals).with_more(more);
        }
        let key = match &error {
            EnvError::RewardKey { .. } => "env.rewards".to_owned(),
            EnvError::GoalWithoutReward { .. } => "env.rewards".to_owned(),
            EnvError::LayoutParameter { parameter, .. } => format!("env.{parameter}"),
            EnvError::Slip { .. } => "env.slip".to_owned(),
            EnvError::ContinuingEnd { .. }
            | EnvError::NoWayBack { .. }
            | EnvError::GainUnsettled { .. } => "env.continuing".to_owned(),
            EnvError::NoSteps => "env.max_steps".to_owned(),
            EnvError::RewardNotFinite { .. }
            | EnvError::StepRewardPositive { .. }
            | EnvError::RewardUnused { .. } => "env.reward".to_owned(),
            EnvError::GoalRewardUnused { goal, .. } => format!("{}[{goal}].reward", goals.key()),
            EnvError::NoGoal
            | EnvError::GoalInWall { .. }
            | EnvError::DuplicateGoal { .. }
            | EnvError::GoalUnreachable { .. } => {
                self.or_map(goals.key(), goals.of(self).is_some())
            }
            EnvError::MisplacedHazard { hazard, .. } => format!("env.hazards[{hazard}].at"),
            EnvError::NoPlaceForGoal => goals.key().to_owned(),
            EnvError::StartIsGoal { .. } if goals == GoalList::Moved => goals.key().to_owned(),
            EnvError::NoStart
            | EnvError::StartInWall { .. }
            | EnvError::StartIsGoal { .. }
            | EnvError::DuplicateStart { .. }
            | EnvError::StartWeight { .. }
            | EnvError::StartLeadsNowhere { .. } => self.or_map("env.start", self.start.is_some()),
            EnvError::EmptyMap | EnvError::MapTooLarge { .. } if self.kind != EnvKind::Ascii => {
                "env.rows".to_owned()
            }
            _ if self.kind == EnvKind::EdgeList => "env.file".to_owned(),
            _ if self.kind.is_board() => "env.kind".to_owned(),
            _ => "env.map".to_owned(),
        };
        beside_others(BrokenRule::new(key, error.to_string()), &error)
    }

    /// `key` if it is given, else the map that says the same by its characters.
    fn or_map(&self, key: &str, given: bool) -> String {
        match self.kind {
            EnvKind::Ascii if !given => "env.map".to_owned(),
            _ => key.to_owned(),
        }
    }
}

/// What is to be said of a map whose lines differ in length: editors take spaces away that were meant to be free cells.
pub(super) fn ragged(map: &str) -> Option<String> {
    let widths = map.lines().map(|line| line.chars().count());
    let longest = widths.clone().max()?;
    let mut short = widths
        .zip(1..)
        .filter(|&(width, _)| 0 < width && width < longest);
    let (width, line) = short.next()?;
    let others = match short.count() {
        0 => String::new(),
        n => format!(", as are {n} more"),
    };
    Some(format!(
        "env.map: line {line} has {width} characters where the longest has {longest}, and is filled up with walls{others}; \
         write free cells at the end of a line as ."
    ))
}

fn place_rule(key: &str, error: &EnvError) -> BrokenRule {
    beside_others(BrokenRule::new(key, error.to_string()), error)
}

/// The rule with the other keys that a world's complaint is about.
fn beside_others(broken: BrokenRule, error: &EnvError) -> BrokenRule {
    match error {
        EnvError::Slip { .. } | EnvError::NoSteps | EnvError::RewardKey { .. } => broken,
        EnvError::LayoutParameter { .. }
        | EnvError::UnknownCharacter { .. }
        | EnvError::SecondStart { .. }
        | EnvError::StepRewardPositive { .. }
        | EnvError::Unreadable { .. }
        | EnvError::EdgeList { .. } => broken.beside(&["env.kind"]),
        EnvError::EmptyMap
        | EnvError::MapTooLarge { .. }
        | EnvError::NoFreeCell
        | EnvError::OutsideMap { .. }
        | EnvError::UnknownState { .. } => broken.beside(&STATES),
        _ => broken.beside(&STATES).beside(&EPISODES),
    }
}

/// What draws the goal that a run with this seed has for itself.
pub(super) fn goal_stream(seed: u64) -> ChaCha8Rng {
    stream(seed, Stream::Goals)
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
    Err(
        BrokenRule::new(key, format!("\"{name}\" is no place on a map; {hint}"))
            .beside(&["env.kind"]),
    )
}
