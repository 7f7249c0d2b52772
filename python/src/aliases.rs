//! A watch for keys that give one name to states that behave differently.
//!
//! Where a name is a state, what comes of (s, a) does not depend on how s was reached. So of two earlier outcomes of
//! (s, a), the last one after the same predecessor and the last one after another, either is as likely as the other to be
//! repeated, however much the world slips. Steps in which just one of them is repeated are counted for it: if the two
//! counts lie farther apart than chance would ever put them, s is not a state.

use std::collections::HashMap;

/// Counts apart by so many standard deviations are no chance, looked at as often as one likes.
const DEVIATIONS: f64 = 5.0;

/// Ways that are remembered; what comes later is not looked at.
const MOST_WAYS: usize = 1 << 18;

/// Node and action that led to a state; none at the start of an episode.
type Predecessor = Option<(u32, i64)>;

/// Node that was reached, and whether the episode terminated there.
type Outcome = (u32, bool);

/// An outcome, and the predecessor after which it came.
type Latest = Option<(Predecessor, Outcome)>;

/// Counts for and against the present names.
#[derive(Default)]
pub struct Aliases {
    after: HashMap<(Predecessor, u32, i64), Outcome>,
    /// The last two outcomes of (s, a) after different predecessors, the last one first.
    latest: HashMap<(u32, i64), [Latest; 2]>,
    same: u64,
    other: u64,
    worst: Option<(u32, i64)>,
}

impl Aliases {
    /// Takes in a step. The node and the action where doubts became certain, once.
    pub fn observe(
        &mut self,
        predecessor: Predecessor,
        node: u32,
        action: i64,
        outcome: Outcome,
    ) -> Option<(u32, i64)> {
        if self.after.len() >= MOST_WAYS || self.worst.is_some() {
            return None;
        }
        let latest = self.latest.entry((node, action)).or_default();
        let elsewhere = latest.iter().flatten().find(|(way, _)| *way != predecessor);
        let before = self.after.insert((predecessor, node, action), outcome);
        if let (Some(before), Some((_, elsewhere))) = (before, elsewhere) {
            match (before == outcome, *elsewhere == outcome) {
                (true, false) => self.same += 1,
                (false, true) => self.other += 1,
                _ => {}
            }
        }
        if latest[0].is_none_or(|(way, _)| way != predecessor) {
            latest[1] = latest[0];
        }
        latest[0] = Some((predecessor, outcome));
        let (apart, all) = (
            self.same.abs_diff(self.other) as f64,
            (self.same + self.other) as f64,
        );
        if all > 0.0 && apart >= DEVIATIONS * all.sqrt() {
            self.worst = Some((node, action));
        }
        self.worst
    }
}
