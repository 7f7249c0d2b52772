//! v of a linearly solvable process with goals whose terminal costs are in step with the rest.
//!
//! ```text
//! v_g = κ D_g,   κ = (max v − min v) / E          D_g: typical steps forgone at g;  E: eccentricity, in typical steps
//! ```
//!
//! A goal that forgoes D_g typical steps must count as much as a way that is D_g steps longer. A step raises v by more
//! than its q: there is also the price of steering, the ln of how improbable the right move was. So the terminal cost
//! takes κ, the rise of v per typical step. κ depends on v and is found by repetition, from a first guess of 2 q. With
//! goals of equal reward there is nothing to repeat.

use super::linearly_solvable::{LinearlySolvableMdp, SolveStatistics};
use super::shortest_path::ShortestPathProblem;

/// Bellman residual at which a potential is final: in nats, and as a share of the smallest cost of a step, below which the
/// maximum principle holds for what is handed out.
const FINAL_TOL: f64 = 1e-5;
const FINAL_SHARE: f64 = 1e-3;

/// Rounds for κ, and its relative change at which they stop.
const MAX_ROUNDS: usize = 12;
const ROUNDS_TOL: f64 = 1e-3;

/// Bellman residual at which the v of a potential is final, for these costs of steps.
pub(crate) fn final_tolerance(past_goals: &[f64]) -> f64 {
    let cheapest = past_goals.iter().copied().fold(1.0, f64::min);
    FINAL_TOL.min(FINAL_SHARE * cheapest)
}

/// A first guess of a solution, from an earlier one.
#[derive(Clone, Debug)]
pub(crate) struct Guess {
    /// By position, ∞ where nothing is known.
    pub v: Vec<f64>,
    /// κ.
    pub per_step: f64,
}

/// A solution, and the κ that belongs to it.
#[derive(Clone, Debug, Default)]
pub(crate) struct GroundedSolution {
    /// v by position.
    pub v: Vec<f64>,
    /// κ.
    pub per_step: f64,
    /// Steps and sweeps of all rounds; residual of the last.
    pub statistics: SolveStatistics,
}

impl GroundedSolution {
    /// v for the costs `q` by position, from `guess` if there is one.
    pub fn new(
        problem: &ShortestPathProblem,
        mdp: &mut LinearlySolvableMdp<'_>,
        q: &[f64],
        guess: Option<Guess>,
    ) -> Self {
        let past_goals = problem.past_goals(q);
        let tol = final_tolerance(past_goals);
        let mean_q = past_goals.iter().sum::<f64>() / past_goals.len().max(1) as f64;
        let mut per_step = guess.as_ref().map_or(2.0 * mean_q, |guess| guess.per_step);
        let mut nearby = guess.map(|guess| guess.v);
        let mut total = SolveStatistics::default();
        let mut round = 1;
        loop {
            let mut v: Vec<f64> = problem.forgone().iter().map(|d| per_step * d).collect();
            let statistics = match &nearby {
                None => mdp.solve_cold(q, &mut v, tol),
                Some(nearby) => mdp.solve_near(nearby, q, &mut v, tol),
            };
            total = SolveStatistics {
                steps: total.steps + statistics.steps,
                sweeps: total.sweeps + statistics.sweeps,
                ..statistics
            };
            let measured = problem.rise(&v) / problem.eccentricity();
            let settled = !problem.goals_differ()
                || (measured - per_step).abs() <= ROUNDS_TOL * per_step
                || !measured.is_finite();
            if settled || round == MAX_ROUNDS {
                let statistics = total;
                return Self {
                    v,
                    per_step,
                    statistics,
                };
            }
            per_step = measured;
            nearby = Some(v);
            round += 1;
        }
    }

    /// For costs that differ a little; none before anything was solved.
    pub fn guess(&self) -> Option<Guess> {
        (!self.v.is_empty()).then(|| Guess {
            v: self.v.clone(),
            per_step: self.per_step,
        })
    }
}
