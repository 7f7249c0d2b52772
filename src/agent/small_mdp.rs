//! Policy iteration with policies evaluated exactly, for a model of few states (Howard 1960).
//!
//! v = r_π + γ P_π v is a linear system, however slowly sweeps would come near its solution. With γ = 1 it has one solution
//! if each state has a way out under π, to an end or to something unknown; states without one form closed sets. There a
//! mean reward above zero is worth more than any number, and one of zero or less sinks without an end, to a floor.

use crate::vector_state::clear_upper_halves;
use faer::prelude::Solve;
use faer::{Col, Mat};

/// Improvements of a policy; a handful is usual.
const MAX_IMPROVEMENTS: usize = 50;
/// 1 − γ by which closed sets are valued: gains of a ten millionth show.
const HARDLY_DISCOUNTED: f64 = 1e-7;
/// Chances of a way out below this are rounding.
const ROUNDING: f64 = 1e-12;

/// One action: its mean reward, and where it leads with what chance. What is missing to 1 is the chance of an end.
#[derive(Clone, Debug, Default)]
pub(crate) struct Row {
    pub reward: f64,
    pub next: Vec<(usize, f64)>,
}

/// The model as a linear problem.
#[derive(Clone, Debug)]
pub(crate) struct SmallMdp {
    /// Of each state its actions, at least one.
    pub rows: Vec<Vec<Row>>,
    pub gamma: f64,
    /// No value is below.
    pub floor: f64,
    /// Values of closed sets above this are without bound.
    pub ceiling: f64,
    /// Actions that are better by less are no better.
    pub tolerance: f64,
}

/// Outcome of an attempt to solve it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Solution {
    /// Optimal values, and the policies it took.
    Values(Vec<f64>, usize),
    /// Going round some loop pays for ever.
    Unbounded,
}

impl SmallMdp {
    /// The optimal values; `start` are values whose greedy policy it begins with. O(states³) a policy.
    pub fn solve(&self, start: &[f64]) -> Solution {
        let mut policy = vec![0; self.rows.len()];
        self.improve(&mut policy, start);
        let mut values = start.to_vec();
        for policies in 1..=MAX_IMPROVEMENTS {
            let Some(found) = self.evaluate(&policy) else {
                return Solution::Unbounded;
            };
            values = found;
            if !self.improve(&mut policy, &values) {
                return Solution::Values(values, policies);
            }
        }
        Solution::Values(values, MAX_IMPROVEMENTS)
    }

    fn action_value(&self, row: &Row, values: &[f64]) -> f64 {
        let ahead: f64 = row.next.iter().map(|&(to, p)| p * values[to]).sum();
        row.reward + self.gamma * ahead
    }

    /// Makes the policy greedy; whether it changed. An action keeps its place against others that are no better.
    fn improve(&self, policy: &mut [usize], values: &[f64]) -> bool {
        let mut changed = false;
        for (choice, rows) in policy.iter_mut().zip(&self.rows) {
            let mut best = self.action_value(&rows[*choice], values) + self.tolerance;
            for (action, row) in rows.iter().enumerate() {
                let value = self.action_value(row, values);
                if value > best {
                    (best, *choice, changed) = (value, action, true);
                }
            }
        }
        changed
    }

    /// v^π, not below the floor; `None` if it is without bound.
    fn evaluate(&self, policy: &[usize]) -> Option<Vec<f64>> {
        let chosen: Vec<&Row> = self.rows.iter().zip(policy).map(|(r, &a)| &r[a]).collect();
        let mut known = vec![None; chosen.len()];
        if self.gamma == 1.0 {
            let closed = closed(&chosen);
            if closed.contains(&true) {
                let others = closed.iter().map(|&closed| (!closed).then_some(0.0));
                let worth = linear(
                    &chosen,
                    1.0 - HARDLY_DISCOUNTED,
                    &others.collect::<Vec<_>>(),
                )?;
                for (state, _) in closed.iter().enumerate().filter(|(_, closed)| **closed) {
                    if worth[state] > self.ceiling {
                        return None;
                    }
                    known[state] = Some(worth[state].max(self.floor));
                }
            }
        }
        let values = linear(&chosen, self.gamma, &known)?;
        Some(values.iter().map(|value| value.max(self.floor)).collect())
    }
}

/// The solution of v = r + γ P v with some of it known.
fn linear(chosen: &[&Row], gamma: f64, known: &[Option<f64>]) -> Option<Col<f64>> {
    let n = chosen.len();
    let mut matrix = Mat::<f64>::identity(n, n);
    let mut right = Col::zeros(n);
    for (state, (row, known)) in chosen.iter().zip(known).enumerate() {
        right[state] = known.unwrap_or(row.reward);
        if known.is_none() {
            for &(to, probability) in &row.next {
                matrix[(state, to)] -= gamma * probability;
            }
        }
    }
    let solution = matrix.partial_piv_lu().solve(&right);
    clear_upper_halves();
    let is_solved = solution.iter().all(|value| value.is_finite());
    is_solved.then_some(solution)
}

/// Which states have no way out: those from which no state can be reached whose action may end.
fn closed(chosen: &[&Row]) -> Vec<bool> {
    let may_end = |row: &&Row| 1.0 - row.next.iter().map(|&(_, p)| p).sum::<f64>() > ROUNDING;
    let mut closed: Vec<bool> = chosen.iter().map(|row| !may_end(row)).collect();
    loop {
        let mut changed = false;
        for (state, row) in chosen.iter().enumerate() {
            if closed[state] && row.next.iter().any(|&(to, _)| !closed[to]) {
                (closed[state], changed) = (false, true);
            }
        }
        if !changed {
            return closed;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(reward: f64, next: &[(usize, f64)]) -> Row {
        Row {
            reward,
            next: next.to_vec(),
        }
    }

    fn solve(rows: Vec<Vec<Row>>, gamma: f64) -> Solution {
        let start = vec![5.0; rows.len()];
        let problem = SmallMdp {
            rows,
            gamma,
            floor: -100.0,
            ceiling: 100.0,
            tolerance: 1e-9,
        };
        problem.solve(&start)
    }

    #[track_caller]
    fn assert_values(solution: Solution, expected: &[f64]) {
        let Solution::Values(values, _) = solution else {
            panic!("{solution:?}");
        };
        for (value, expected) in values.iter().zip(expected) {
            assert!((value - expected).abs() < 1e-8, "{values:?}");
        }
    }

    /// From 0 one may go on or stay, for nothing; from 1 end for .4 or .5. Any value above a half would be consistent at 0.
    #[test]
    fn free_loops_are_worth_their_best_exit() {
        let stay = |s| row(0.0, &[(s, 1.0)]);
        let rows = vec![
            vec![row(0.0, &[(1, 1.0)]), stay(0)],
            vec![row(0.4, &[]), row(0.5, &[])],
        ];
        assert_values(solve(rows, 1.0), &[0.5, 0.5]);
        // A try that succeeds once in four, at a cost of 1: four tries.
        let tries = vec![vec![row(-1.0, &[(0, 0.75)]), row(-5.0, &[])]];
        assert_values(solve(tries, 1.0), &[-4.0]);
    }

    #[test]
    fn closed_sets_sink_to_the_floor_or_pay_for_ever() {
        let trap = || vec![row(-1.0, &[(1, 1.0)])];
        let into = vec![row(-1.0, &[(1, 0.5)]), row(-60.0, &[])];
        assert_values(solve(vec![into, trap()], 1.0), &[-51.0, -100.0]);
        let round = vec![
            vec![row(3.0, &[(1, 1.0)]), row(9.0, &[])],
            vec![row(-2.0, &[(0, 1.0)])],
        ];
        assert_eq!(solve(round.clone(), 1.0), Solution::Unbounded);
        // Discounted, the round is worth 1.2 / .19 = 6.3, less than the end.
        assert_values(solve(round, 0.9), &[9.0, 6.1]);
    }
}
