//! Errors of a world: one variant per broken rule, with the place and what to do about it.

/// Reason why a world could not be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EnvError {
    /// Several places of a map or a file that are wrong, each by itself, in their order.
    #[error("{}", lines(errors))]
    Several {
        /// What is wrong with each; at least two.
        errors: Vec<EnvError>,
    },
    /// A map without rows or columns.
    #[error("the map is empty: give it at least one row and one column")]
    EmptyMap,
    /// More cells than can be numbered.
    #[error("a map of {rows} × {cols} cells is too large: at most {limit} cells")]
    MapTooLarge {
        /// Rows asked for.
        rows: usize,
        /// Columns asked for.
        cols: usize,
        /// The largest number of cells.
        limit: usize,
    },
    /// Walls everywhere.
    #[error("the map has no free cell: an agent needs somewhere to stand")]
    NoFreeCell,
    /// A character that means nothing in a map.
    #[error(
        "map line {line}, column {column}: unknown character {found:?}; \
         use # (wall), . or space (free), S (start), G or 1-9 (goals), ^ v < > (one-way)"
    )]
    UnknownCharacter {
        /// Line of the map, from 1.
        line: usize,
        /// Column of the map in characters, from 1.
        column: usize,
        /// What stands there.
        found: char,
    },
    /// A map with two `S`.
    #[error(
        "map line {line}, column {column}: a second start; keep one S, or ask for random starts"
    )]
    SecondStart {
        /// Line of the second `S`, from 1.
        line: usize,
        /// Its column, from 1.
        column: usize,
    },
    /// A numbered goal whose number is not in the table of rewards.
    #[error(
        "map line {line}, column {column}: goal {digit} has no reward; add {digit} = NUMBER to the table of rewards"
    )]
    GoalWithoutReward {
        /// Line of the map, from 1.
        line: usize,
        /// Column of the map, from 1.
        column: usize,
        /// The digit.
        digit: char,
    },
    /// A table entry for something that is no numbered goal.
    #[error("the table of rewards names {key:?}, which is not a digit from 1 to 9")]
    RewardKey {
        /// The key.
        key: char,
    },
    /// A parameter of a generated map or board outside its range.
    #[error("{parameter} = {value}: {rule}")]
    LayoutParameter {
        /// Name of the parameter.
        parameter: &'static str,
        /// What was given.
        value: String,
        /// What is allowed.
        rule: &'static str,
    },
    /// A place beyond the edge of the map.
    #[error(
        "[{row}, {col}] is outside the map, which has {rows} rows and {cols} columns counted from 0"
    )]
    OutsideMap {
        /// Row given, from 0.
        row: usize,
        /// Column given, from 0.
        col: usize,
        /// Rows of the map.
        rows: usize,
        /// Columns of the map.
        cols: usize,
    },
    /// "farthest" before there is a start to be far from.
    #[error(
        "\"farthest\" means farthest from the start: give a fixed start first, or name another place"
    )]
    FarthestWithoutStart,
    /// Neither a start in the map nor random starts.
    #[error("there is no start: mark one S in the map, name a place, or ask for random starts")]
    NoStart,
    /// No goal at all.
    #[error("there is no goal: mark one G in the map, or name a place")]
    NoGoal,
    /// Nowhere to draw a goal from.
    #[error(
        "there is no place for a random goal: no free cell but the start can be reached; open a way, or move the start"
    )]
    NoPlaceForGoal,
    /// The start lies in a wall.
    #[error("the start [{row}, {col}] is in a wall: choose a free cell")]
    StartInWall {
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        col: usize,
    },
    /// A goal lies in a wall.
    #[error("the goal [{row}, {col}] is in a wall: choose a free cell")]
    GoalInWall {
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        col: usize,
    },
    /// The same place twice among the goals.
    #[error("the goal {place} is given twice: keep one")]
    DuplicateGoal {
        /// The cell or the state's name.
        place: String,
    },
    /// A hazard where none can be.
    #[error("the hazard {place} {rule}")]
    MisplacedHazard {
        /// Its number in the list, from 0.
        hazard: usize,
        /// Its cell.
        place: String,
        /// What is wrong with it.
        rule: &'static str,
    },
    /// The episode would be over before its first step.
    #[error("start and goal are the same place, {place}: move one of them")]
    StartIsGoal {
        /// The cell or the state's name.
        place: String,
    },
    /// One of several starts stands twice.
    #[error("the start {place} is given twice: keep one, with a larger weight")]
    DuplicateStart {
        /// The cell or the state's name.
        place: String,
    },
    /// A weight that is no share of anything.
    #[error("the start {place} has weight {weight}: a weight is a finite number above 0")]
    StartWeight {
        /// The cell or the state's name.
        place: String,
        /// What was given.
        weight: f64,
    },
    /// One of several starts has no way to any goal.
    #[error("no goal can be reached from the start {place}: open a way, or leave it out")]
    StartLeadsNowhere {
        /// The cell or the state's name.
        place: String,
    },
    /// No way from the start to this goal.
    #[error(
        "the goal {goal} cannot be reached from {start}: open a way, or move one of them \
         (an episode ends at the first goal, so a goal behind another is out of reach)"
    )]
    GoalUnreachable {
        /// The goal's cell or name.
        goal: String,
        /// The start's cell or name, or "any start".
        start: String,
    },
    /// A slip probability outside [0, 1).
    #[error("slip = {slip}: a probability from 0 up to, but not including, 1")]
    Slip {
        /// What was given.
        slip: f64,
    },
    /// A reward that is NaN or infinite.
    #[error("the reward of {place} is {reward}: rewards must be finite numbers")]
    RewardNotFinite {
        /// Which reward.
        place: String,
        /// Its value.
        reward: f64,
    },
    /// A step that pays.
    #[error(
        "the reward of a step is {reward}: it must not be positive, or it pays never to reach the goal"
    )]
    StepRewardPositive {
        /// Its value.
        reward: f64,
    },
    /// A goal's own reward, where the file says itself what a step into the goal pays.
    #[error(
        "reward = {reward} of the goal {name:?} means nothing here: {file} says itself what entering it by action {action:?} \
         from {from:?} pays; leave its column reward empty on lines into the goal, or leave the number out"
    )]
    GoalRewardUnused {
        /// The file.
        file: String,
        /// The goal's place in the list of goals, from 0.
        goal: usize,
        /// Its state.
        name: String,
        /// Its reward.
        reward: f64,
        /// State that is left on the line with a reward.
        from: String,
        /// Action on that line.
        action: String,
    },
    /// Numbers for lines that say no reward, where all lines do.
    #[error(
        "{what} means nothing here: {file} says itself what each of these steps pays; leave its column reward empty \
         where the number is to hold, or leave the number out"
    )]
    RewardUnused {
        /// The file.
        file: String,
        /// Which number.
        what: String,
    },
    /// An episode without steps.
    #[error("max_steps = 0: an episode needs at least one step")]
    NoSteps,
    /// An MDP without states or actions.
    #[error("an MDP needs at least one state and one action; this one has {states} and {actions}")]
    EmptyMdp {
        /// Number of states.
        states: usize,
        /// Number of actions.
        actions: usize,
    },
    /// More (state, action) pairs or actions than can be numbered.
    #[error(
        "{states} states with {actions} actions are too many: at most 65535 actions and 2^32 − 1 pairs"
    )]
    MdpTooLarge {
        /// Number of states.
        states: usize,
        /// Number of actions.
        actions: usize,
    },
    /// An outcome that leads nowhere.
    #[error("state {state}, action {action}: leads to state {next} of {states}")]
    NoSuchState {
        /// The state left.
        state: usize,
        /// The action taken.
        action: usize,
        /// Where it leads.
        next: usize,
        /// Number of states.
        states: usize,
    },
    /// Probabilities outside [0, 1], or not summing to 1.
    #[error(
        "state {state}, action {action}: the probabilities must lie in [0, 1] and sum to 1 (they sum to {sum})"
    )]
    Probabilities {
        /// The state left.
        state: usize,
        /// The action taken.
        action: usize,
        /// What they sum to.
        sum: f64,
    },
    /// A start that is no state, or is terminal, or no start at all.
    #[error("{start} cannot be a start: starts are non-terminal states of {states}")]
    BadStart {
        /// The start given, or "nothing".
        start: String,
        /// Number of states.
        states: usize,
    },
    /// A continuing task that ends.
    #[error(
        "a continuing task has no end, but {end:?} is one and can be reached: leave out continuing, or the ends"
    )]
    ContinuingEnd {
        /// The end's name.
        end: String,
    },
    /// A continuing task with a way that cannot be gone back.
    #[error(
        "every state of a continuing task must be reachable from every other, but {to:?} cannot be reached from {from:?}: \
         add a way, or leave out continuing"
    )]
    NoWayBack {
        /// Name of the state with no way out to the other.
        from: String,
        /// Name of the other.
        to: String,
    },
    /// A continuing task of which what is best could not be found.
    #[error(
        "the world is too large or too slow for a continuing task: what its best policy earns a step lies between {lower} and \
         {upper}, and closing this would take too long; make it smaller, or leave out continuing"
    )]
    GainUnsettled {
        /// Lower bound of the gain.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// A name that is not in the edge list.
    #[error("{file}: no state is named {name:?}{}", suggestion(.nearest))]
    UnknownState {
        /// The file.
        file: String,
        /// The name asked for.
        name: String,
        /// The closest name there is.
        nearest: Option<String>,
    },
    /// A file that could not be read.
    #[error("{file}: {message}")]
    Unreadable {
        /// The file.
        file: String,
        /// Why not.
        message: String,
    },
    /// A line of an edge list that breaks a rule.
    #[error("{file}, line {line}: {problem}")]
    EdgeList {
        /// The file.
        file: String,
        /// The line, from 1 (the header).
        line: u64,
        /// The rule.
        problem: EdgeListProblem,
    },
}

/// What the first line of an edge list says.
const HEADER: &str = "the first line names the columns: from,action,to and optionally probability,reward, or from,to and \
                      optionally reward";

/// The rules of an edge list.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EdgeListProblem {
    /// A required column is not in the header.
    #[error("the column {column:?} is missing; {HEADER}")]
    MissingColumn {
        /// Its name.
        column: &'static str,
    },
    /// A column nobody knows.
    #[error("unknown column {column:?}{}; {HEADER}", suggestion(.nearest))]
    UnknownColumn {
        /// Its name.
        column: String,
        /// The closest name there is.
        nearest: Option<String>,
    },
    /// Chances in a file whose lines are actions of their own.
    #[error(
        "the column \"probability\" needs the column \"action\": without that each line is an action of its own, which \
         always leads where the line says"
    )]
    ProbabilityWithoutAction,
    /// The same column twice.
    #[error("the column {column:?} is given twice")]
    DuplicateColumn {
        /// Its name.
        column: String,
    },
    /// A header and nothing below it.
    #[error("there are no edges below the header")]
    NoEdges,
    /// A state or action without a name.
    #[error("the column {column:?} is empty: every edge needs a name there")]
    EmptyName {
        /// The column.
        column: &'static str,
    },
    /// Not a number, or not a finite one.
    #[error("{column} = {value:?} is not a finite number")]
    NotANumber {
        /// The column.
        column: &'static str,
        /// What stands there.
        value: String,
    },
    /// A probability outside (0, 1].
    #[error("probability = {value}: a probability above 0, up to 1")]
    ProbabilityRange {
        /// What stands there.
        value: f64,
    },
    /// The outcomes of one action do not add up.
    #[error("the probabilities of action {action:?} in state {from:?} sum to {sum}, not to 1")]
    ProbabilitySum {
        /// The state.
        from: String,
        /// The action.
        action: String,
        /// What they sum to.
        sum: f64,
    },
    /// Some outcomes of one action have a probability and some have none.
    #[error(
        "action {action:?} in state {from:?} has a probability on some of its lines only: give all or none"
    )]
    ProbabilityMissing {
        /// The state.
        from: String,
        /// The action.
        action: String,
    },
    /// More than 65535 different actions.
    #[error("more than 65535 different actions")]
    TooManyActions,
    /// A quote that does not open or close its field.
    #[error("column {column}: {rule}")]
    Quote {
        /// Where in the line, from 1 and in characters.
        column: usize,
        /// The rule.
        rule: &'static str,
    },
    /// Not CSV.
    #[error("{message}")]
    Malformed {
        /// What the CSV reader says.
        message: String,
    },
}

/// `; did you mean "x"?`, or nothing.
fn suggestion(nearest: &Option<String>) -> String {
    nearest
        .as_ref()
        .map_or_else(String::new, |name| format!("; did you mean {name:?}?"))
}

/// The candidate closest to `name`, if one is close enough to be what was meant: at most a third of the letters differ.
pub(crate) fn nearest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Option<String> {
    let limit = name.chars().count().div_ceil(3);
    candidates
        .map(|candidate| (strsim::damerau_levenshtein(name, candidate), candidate))
        .filter(|&(distance, _)| distance <= limit)
        .min()
        .map(|(_, candidate)| candidate.to_owned())
}

/// So many wrong places of one map or file are told.
pub(super) const MOST_ERRORS: usize = 100;

impl EnvError {
    /// `errors` as one; none if there are none.
    pub(super) fn of_all(mut errors: Vec<EnvError>) -> Option<EnvError> {
        match errors.len() {
            0 | 1 => errors.pop(),
            _ => Some(Self::Several { errors }),
        }
    }
}

fn lines(errors: &[EnvError]) -> String {
    let lines: Vec<String> = errors.iter().map(EnvError::to_string).collect();
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_name_is_close_or_absent() {
        let names = ["from", "action", "to", "probability", "reward"];
        assert_eq!(
            nearest("probabilty", names.into_iter()).as_deref(),
            Some("probability")
        );
        assert_eq!(nearest("colour", names.into_iter()), None);
    }
}
