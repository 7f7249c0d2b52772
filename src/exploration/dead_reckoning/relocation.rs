//! DeadReckoning where actions slip: reckoned anew from all that was seen, now and then.
//!
//! Dead reckoning step by step is wrong as soon as one step slips. So which action undoes which is decided by majority,
//! positions by `Placement`, chances by [`ActionNoise`], each from the estimate of the others before. The hypothesis is tested
//! as a whole: the share of the transitions seen that are displacements at all.

use super::action_noise::ActionNoise;
use super::chart::{Effect, Place};
use super::moves::Moves;
use super::placement::Placement;
use super::{DeadReckoning, MAX_ACTIONS};
use crate::env::Action;
use crate::graph::{StateId, TransitionGraph};

/// Tests of "b undoes a" before their share is looked at.
const MIN_TESTS: u32 = 6;
/// Two steps that undo one another when neither slips do so at least this often: slips of up to a half.
const MIN_UNDONE: f64 = 0.25;
/// Positions are reckoned anew when the steps have grown by one part in so many, or in so many while they are no use.
const PART: u64 = 16;
const PART_UNTRUSTED: u64 = 8;
/// But not more often than this.
const MIN_STEPS: u64 = 16;
/// So many tries that came to nothing, and a way that was only gone back is one-way.
const ONE_WAY_AFTER: u32 = 3;

impl DeadReckoning {
    /// An action has led to two places, one of them over a way that was known. O(1) but the first time.
    pub fn notice_slip(&mut self) {
        if !self.stochastic && self.num_actions <= MAX_ACTIONS {
            self.expect_slips();
        }
    }

    /// Notes that some action has led to two places: from now on nothing is taken for granted after one try.
    pub(super) fn expect_slips(&mut self) {
        self.stochastic = true;
        self.inverse.fill(None);
        self.bumps = Vec::new();
        self.revision += 1;
        if self.chart.has_headings() {
            self.rebuild_axes();
        }
        self.chart.distrust();
    }

    /// Counts a step. O(1), but for one step in 16, which costs O(m log m); amortised O(log m).
    pub fn count_step(&mut self, graph: &TransitionGraph) {
        self.steps += 1;
        if self.stochastic && self.steps >= self.due {
            self.relocate(graph);
            let part = if self.trusted() { PART } else { PART_UNTRUSTED };
            self.due = self.steps + (self.steps / part).max(MIN_STEPS);
        }
    }

    /// What actions do when they slip, once believed; `None` where they do not, or where it depends on the state.
    pub fn noise(&self) -> Option<&ActionNoise> {
        self.noise
            .as_ref()
            .filter(|_| self.stochastic && self.trusted())
    }

    /// The known state that lies where `action` leads to from `from` unless it slips, if the way there is open as far as
    /// is known: it was gone, or it was gone back and `action` has not failed here again and again. O(degree).
    pub fn neighbor_towards(
        &self,
        graph: &TransitionGraph,
        from: StateId,
        action: Action,
    ) -> Option<StateId> {
        if !self.trusted() || from.index() >= self.entry.len() {
            return None;
        }
        let next = self.at(&self.chart.target(from, action))?;
        let mut outcomes = graph.outcomes(from);
        let mut failures = 0;
        let gone = outcomes.any(|outcome| {
            if outcome.action == action && outcome.next == from {
                failures = outcome.count;
            }
            outcome.next == next
        });
        let gone_back = || graph.adjacency().neighbors(from.0).contains(&next.0);
        (gone || (failures < ONE_WAY_AFTER && gone_back())).then_some(next)
    }

    fn relocate(&mut self, graph: &TransitionGraph) {
        self.revision += 1;
        self.chart.distrust();
        let neighbors = |s: usize| graph.adjacency().neighbors(s as u32).len();
        let crowded = (0..graph.num_states()).any(|s| neighbors(s) > self.num_actions);
        if crowded || self.num_actions > MAX_ACTIONS || graph.num_states() != self.entry.len() {
            return;
        }
        let Some(moves) = self.majority_moves() else {
            return;
        };
        let guess = self
            .noise
            .take()
            .unwrap_or_else(|| ActionNoise::prior(&moves));
        let placement = Placement::new(graph, &moves, &guess);
        let (noise, agree, disagree) = placement.count_noise();
        let (positions, occupied) = (placement.positions, placement.occupied);
        self.noise = Some(noise);
        if positions.iter().all(Option::is_some) {
            self.chart.positions.clear();
            self.chart
                .positions
                .extend(positions.into_iter().flatten().flatten());
            self.chart.occupied = occupied;
            self.chart.loops_confirmed = agree;
            self.chart.loops_contradicted = disagree;
        }
    }

    /// Each action's best inverse, if they come in pairs.
    fn majority_moves(&mut self) -> Option<Moves> {
        let actions = 0..self.num_actions;
        let undone = |a: usize, b: usize| self.undone_share(a, b) + self.undone_share(b, a);
        let best = |a| {
            actions
                .clone()
                .max_by(|&b, &c| undone(a, b).total_cmp(&undone(a, c)))
        };
        let inverse: Vec<usize> = actions.clone().filter_map(best).collect();
        let paired = |a: usize| {
            let b = inverse[a];
            b != a && inverse[b] == a && self.undone_share(a, b) > MIN_UNDONE
        };
        if !actions.clone().all(paired) {
            return None;
        }
        let believed: Vec<_> = inverse.iter().map(|&b| Some(Action(b as u16))).collect();
        if believed != self.inverse {
            self.inverse = believed;
            self.noise = None;
            self.rebuild_axes();
        }
        let shift = |a: usize| {
            let mut shift = vec![0; self.chart.num_axes()];
            if let Effect::Shift(direction) = self.chart.effects[a] {
                shift[direction.axis] = direction.sign;
            }
            shift
        };
        Some(Moves {
            shifts: actions.map(shift).collect(),
            inverse,
        })
    }

    fn undone_share(&self, first: usize, second: usize) -> f64 {
        let pair = first * self.num_actions + second;
        if self.tests[pair] < MIN_TESTS {
            return 0.0;
        }
        f64::from(self.undone[pair]) / f64::from(self.tests[pair])
    }

    /// Under slip: the likeliest free position for a state first entered from `from` by `action`.
    pub(super) fn likely_target(&self, from: StateId, action: Action) -> Place {
        let likelihood = |d: Action| match &self.noise {
            Some(noise) => noise.share(action, d),
            None => f64::from(u8::from(d == action)),
        };
        let mut best: Option<(f64, Place)> = None;
        for d in (0..self.num_actions as u16).map(Action) {
            let place = self.chart.target(from, d);
            if self.at(&place).is_none() && best.is_none_or(|(known, _)| likelihood(d) > known) {
                best = Some((likelihood(d), place));
            }
        }
        best.map_or_else(|| self.chart.target(from, action), |(_, place)| place)
    }
}
