//! The kit must catch what it is for: a correct corridor, and the same corridor with one fault at a time.

use super::*;
use crate::env::{Action, Model, Outcome, Starts, Step, StepStatus, TabularMdp};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const LENGTH: usize = 5;
const LIMIT: usize = 40;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    None,
    AnswersBeforeReset,
    AnswersAfterEnd,
    AcceptsAnyAction,
    PanicsInTheMiddle,
    NanReward,
    IgnoresItsSeed,
    DrawsFromOutside,
    TruncatesOneLate,
    TruncatesOneEarly,
    KeepsTheClockOnReset,
    CallsTruncationTermination,
    StartsAtTheEnd,
    PaysMoreThanItsModel,
    JumpsWhereItsModelDoesNot,
}

/// Cells 0..=LENGTH, the last one terminal; action 1 goes on with probability 0.7, action 0 goes back.
#[derive(Clone)]
struct Corridor {
    fault: Fault,
    rng: ChaCha8Rng,
    cell: usize,
    elapsed: usize,
    running: bool,
}

impl Corridor {
    fn new(fault: Fault, seed: u64) -> Self {
        let seed = match fault {
            Fault::IgnoresItsSeed => 0,
            Fault::DrawsFromOutside => {
                static CALLS: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);
                CALLS.fetch_add(1, std::sync::atomic::Ordering::Relaxed)
            }
            _ => seed,
        };
        Corridor {
            fault,
            rng: ChaCha8Rng::seed_from_u64(seed),
            cell: 0,
            elapsed: 0,
            running: false,
        }
    }

    fn next_cell(&mut self, action: Action) -> usize {
        let forward = action.0 == 1 && self.rng.random_bool(0.7);
        match self.cell {
            0 if self.fault == Fault::JumpsWhereItsModelDoesNot && forward => 2,
            cell if forward => (cell + 1).min(LENGTH),
            cell if action.0 == 1 => cell,
            cell => cell.saturating_sub(1),
        }
    }
}

impl Environment for Corridor {
    type State = usize;

    fn num_actions(&self) -> usize {
        2
    }

    fn reset(&mut self) -> usize {
        self.cell = if self.fault == Fault::StartsAtTheEnd {
            LENGTH
        } else {
            0
        };
        if self.fault != Fault::KeepsTheClockOnReset || !self.running {
            self.elapsed = 0;
        }
        self.running = true;
        self.cell
    }

    fn step(&mut self, action: Action) -> Step<usize> {
        let fault = self.fault;
        let begun = self.elapsed > 0 || self.running;
        let excused = if begun {
            fault == Fault::AnswersAfterEnd
        } else {
            fault == Fault::AnswersBeforeReset
        };
        assert!(self.running || excused, "no episode");
        assert!(
            action.0 < 2 || fault == Fault::AcceptsAnyAction,
            "unknown action"
        );
        self.cell = self.next_cell(action);
        self.elapsed += 1;
        assert!(
            fault != Fault::PanicsInTheMiddle || self.elapsed < 7,
            "lost the thread"
        );
        let limit = match fault {
            Fault::TruncatesOneLate => LIMIT + 1,
            Fault::TruncatesOneEarly => LIMIT - 1,
            _ => LIMIT,
        };
        let status = match () {
            () if self.cell == LENGTH => StepStatus::Terminated,
            () if self.elapsed < limit => StepStatus::Running,
            () if fault == Fault::CallsTruncationTermination => StepStatus::Terminated,
            () => StepStatus::Truncated,
        };
        self.running = status == StepStatus::Running;
        let reward = match fault {
            Fault::NanReward if self.cell == 3 => f64::NAN,
            Fault::PaysMoreThanItsModel if self.cell == LENGTH => 10.0,
            _ => -1.0,
        };
        Step {
            state: self.cell,
            reward,
            status,
        }
    }
}

impl Model for Corridor {
    fn to_mdp(&self) -> TabularMdp {
        let terminal = (0..=LENGTH).map(|cell| cell == LENGTH).collect();
        let filled = TabularMdp::from_fn(2, terminal, |cell, action, outcomes| {
            let outcome = |next: usize, probability| Outcome {
                next: next as u32,
                probability,
                reward: -1.0,
            };
            match action.0 {
                0 => outcomes.push(outcome(cell.saturating_sub(1), 1.0)),
                _ => outcomes.extend([outcome(cell + 1, 0.7), outcome(cell, 0.3)]),
            }
        });
        filled.unwrap()
    }

    fn mdp_index(&self, state: &usize) -> usize {
        *state
    }

    fn start_distribution(&self) -> Starts {
        Starts::from(&[0])
    }

    fn max_steps(&self) -> usize {
        LIMIT
    }
}

fn check(fault: Fault) -> Result<Coverage, Violations> {
    check_model(|seed| Corridor::new(fault, seed), true)
}

#[test]
fn a_correct_world_passes_and_is_covered() {
    let coverage = check(Fault::None).unwrap();
    assert!(
        coverage.terminations > 0 && coverage.truncations > 0,
        "{coverage:?}"
    );
    assert_eq!(coverage.states, LENGTH + 1);
}

#[test]
fn each_fault_breaks_its_rule() {
    let faults = [
        (Fault::AnswersBeforeReset, Rule::StepBeforeResetPanics),
        (Fault::AnswersAfterEnd, Rule::StepAfterEndPanics),
        (Fault::AcceptsAnyAction, Rule::UnknownActionPanics),
        (Fault::PanicsInTheMiddle, Rule::LegalCallsDoNotPanic),
        (Fault::NanReward, Rule::RewardsAreFinite),
        (Fault::IgnoresItsSeed, Rule::SeedsDiffer),
        (Fault::DrawsFromOutside, Rule::SameSeedSameAnswers),
        (Fault::TruncatesOneLate, Rule::TruncatedExactlyAtLimit),
        (Fault::TruncatesOneEarly, Rule::TruncatedExactlyAtLimit),
        (Fault::KeepsTheClockOnReset, Rule::ResetBeginsAnew),
        (
            Fault::CallsTruncationTermination,
            Rule::TerminatedExactlyAtTerminalStates,
        ),
        (Fault::StartsAtTheEnd, Rule::StartsAreStarts),
        (Fault::PaysMoreThanItsModel, Rule::TransitionsAreInTheModel),
        (
            Fault::JumpsWhereItsModelDoesNot,
            Rule::TransitionsAreInTheModel,
        ),
    ];
    for (fault, rule) in faults {
        let violations = check(fault).expect_err(&format!("{fault:?} went unnoticed"));
        assert!(
            violations.contains(rule),
            "{fault:?} was reported as: {violations}"
        );
    }
}

#[test]
fn a_fault_does_not_hide_behind_others() {
    // Faults of the clock and of rewards break one rule each, so that a message names the cause.
    for fault in [
        Fault::NanReward,
        Fault::TruncatesOneLate,
        Fault::KeepsTheClockOnReset,
        Fault::AcceptsAnyAction,
    ] {
        let Violations(broken) = check_environment(
            |seed| Corridor::new(fault, seed),
            &Expectations {
                max_steps: Some(LIMIT),
                random: true,
            },
        )
        .unwrap_err();
        assert_eq!(broken.len(), 1, "{fault:?}: {broken:?}");
    }
}

#[test]
fn violations_read_as_rules() {
    let message = check(Fault::NanReward).unwrap_err().to_string();
    assert!(
        message.starts_with("rewards are finite (NaN for action 1 into 3)"),
        "{message}"
    );
}
