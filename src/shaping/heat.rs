//! The control without learning: heat that flows from the goals and is lost at a fixed rate.
//!
//! ```text
//! u_i = e^{−q_i} Σ_j P_ij u_j,  u_g = 1 on the best goals,     q_i = c_i · (−ln kept),     φ ∝ ln u
//! ```
//!
//! With `kept` = 0.9 and unit costs this is u = 0.9 P u away from the goals, a random walk with restart seen from the
//! other end. −ln u behaves like a distance (Varadhan), but one that knows of all ways rather than of the shortest
//! alone: between two passages of equal length the wider one looks nearer.

use super::diffusion::{Diffusion, SolveReport};
use super::site::{Site, SiteModel};
use super::terrain::Terrain;
use super::{PotentialFit, ShapingError};

/// Bellman residual at which a potential is final, in nats: far below any state cost, so that the maximum principle
/// holds for what is handed out.
pub(crate) const FINAL_TOL: f64 = 1e-8;

/// Rounds that bring goals of different reward into the diffusion's currency, and when to stop.
const MAX_ROUNDS: usize = 12;
const ROUNDS_TOL: f64 = 1e-3;

/// The `heat` potential.
#[derive(Clone, Debug)]
pub struct HeatPotential {
    /// The part of the heat that a typical step keeps, between 0 and 1.
    pub kept: f64,
    /// Range of φ ÷ cost of the longest known way.
    pub scale_factor: f64,
}

impl SiteModel for HeatPotential {
    fn fit_site(&mut self, site: &Site<'_>) -> Result<PotentialFit, ShapingError> {
        let per_step = -self.kept.ln();
        let q: Vec<f64> = site.terrain.costs.iter().map(|c| c * per_step).collect();
        let mut diffusion = Diffusion::new(&site.terrain.chain);
        let solution = GroundedSolution::new(site.terrain, &mut diffusion, &q);
        let fit = PotentialFit::checked(site.terrain.potential(&solution.v, self.scale_factor))?;
        Ok(PotentialFit {
            solve: Some(solution.report),
            ..fit
        })
    }
}

/// v from goals whose terminal costs are in step with the rest.
///
/// A goal that forgoes D_g typical steps must count as much as a way that is D_g steps longer. A step raises v by more
/// than its q: there is also the price of steering, the ln of how improbable the right move was. So the terminal cost
/// is v_g = κ D_g with κ the rise of v per typical step, (max v − min v) / E. κ depends on v and is found by
/// repetition, from a first guess of 2 q. With goals of equal reward there is nothing to repeat.
pub(crate) struct GroundedSolution {
    /// v by position.
    pub v: Vec<f64>,
    /// Sweeps over all rounds; residual of the last.
    pub report: SolveReport,
}

impl GroundedSolution {
    pub fn new(terrain: &Terrain, diffusion: &mut Diffusion<'_>, q: &[f64]) -> Self {
        let past_goals = terrain.past_goals(q);
        let mean_q = past_goals.iter().sum::<f64>() / past_goals.len().max(1) as f64;
        let mut per_step = 2.0 * mean_q;
        let mut sweeps = 0;
        let mut round = 1;
        loop {
            let mut v: Vec<f64> = terrain.forgone().iter().map(|d| per_step * d).collect();
            let mut report = diffusion.solve_cold(q, &mut v, FINAL_TOL);
            sweeps += report.sweeps;
            let measured = terrain.rise(&v) / terrain.eccentricity();
            let settled = !terrain.goals_differ()
                || (measured - per_step).abs() <= ROUNDS_TOL * per_step
                || !measured.is_finite();
            if settled || round == MAX_ROUNDS {
                report.sweeps = sweeps;
                return Self { v, report };
            }
            per_step = measured;
            round += 1;
        }
    }
}
