//! A watch for keys that give one name to states that behave differently.
//!
//! Where a name is a state, the outcomes of (s, a) are drawn anew each time, however much the world slips: none of them
//! says more about the next one than any other. So of two earlier outcomes either is as likely as the other to be repeated,
//!
//! - the last one, and the one before it: behind a name that hides a door, what comes of (s, a) changes now and then;
//! - one after the same predecessor, and one after another: behind a name that hides where one came from.
//!
//! Times when just one of the two is repeated are counted for it, and each outcome is used once in either comparison, so that
//! the times are independent. If two counts lie farther apart than chance would ever put them, s is not a state.

use std::collections::HashMap;

/// Counts apart by so many standard deviations are no chance, looked at as often as one likes.
const DEVIATIONS: f64 = 5.0;

/// Actions of states that are watched; those that come later are not.
const MOST_PAIRS: usize = 1 << 18;

/// Outcomes of one action of one state that may wait to be compared.
const MOST_WAITING: usize = 8;

/// Node and action that led to a state; none at the start of an episode.
type Predecessor = Option<(u32, i64)>;

/// Node that was reached, and whether the episode terminated there.
type Outcome = (u32, bool);

/// Counts for and against the present names.
#[derive(Default)]
pub struct Aliases {
    pairs: HashMap<(u32, i64), Waiting>,
    by_time: Tally,
    by_predecessor: Tally,
    found: Option<(u32, i64)>,
}

/// Outcomes of one action of one state that were not compared yet.
#[derive(Default)]
struct Waiting {
    in_time: Vec<Outcome>,
    by_predecessor: Vec<(Predecessor, Outcome)>,
}

/// Times when one of two outcomes was repeated, and the other one not.
#[derive(Clone, Copy, Default)]
struct Tally {
    first: u32,
    second: u32,
}

impl Aliases {
    /// Takes in a step. The node and the action at which doubts became certain, from then on.
    pub fn observe(
        &mut self,
        predecessor: Predecessor,
        node: u32,
        action: i64,
        outcome: Outcome,
    ) -> Option<(u32, i64)> {
        let is_full = self.pairs.len() >= MOST_PAIRS && !self.pairs.contains_key(&(node, action));
        if self.found.is_some() || is_full {
            return self.found;
        }
        let waiting = self.pairs.entry((node, action)).or_default();
        waiting.compare_in_time(&mut self.by_time, outcome);
        waiting.compare_by_predecessor(&mut self.by_predecessor, predecessor, outcome);
        if self.by_time.is_no_chance() || self.by_predecessor.is_no_chance() {
            self.found = Some((node, action));
        }
        self.found
    }
}

impl Waiting {
    fn compare_in_time(&mut self, tally: &mut Tally, outcome: Outcome) {
        if let [before, last] = self.in_time[..] {
            tally.count(last == outcome, before == outcome);
            self.in_time.clear();
        } else {
            self.in_time.push(outcome);
        }
    }

    fn compare_by_predecessor(
        &mut self,
        tally: &mut Tally,
        predecessor: Predecessor,
        outcome: Outcome,
    ) {
        let place = |same: bool| {
            let mut waiting = self.by_predecessor.iter();
            waiting.position(|(other, _)| (*other == predecessor) == same)
        };
        if let (Some(same), Some(other)) = (place(true), place(false)) {
            let repeated = |at: usize| self.by_predecessor[at].1 == outcome;
            tally.count(repeated(same), repeated(other));
            self.by_predecessor.remove(same.max(other));
            self.by_predecessor.remove(same.min(other));
        } else if self.by_predecessor.len() < MOST_WAITING {
            self.by_predecessor.push((predecessor, outcome));
        }
    }
}

impl Tally {
    fn count(&mut self, first: bool, second: bool) {
        self.first += u32::from(first && !second);
        self.second += u32::from(second && !first);
    }

    fn is_no_chance(self) -> bool {
        let apart = f64::from(self.first.abs_diff(self.second));
        let all = f64::from(self.first) + f64::from(self.second);
        all > 0.0 && apart >= DEVIATIONS * all.sqrt()
    }
}
