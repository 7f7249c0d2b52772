//! The control without learning: heat that flows from the goals and is lost at a fixed rate.
//!
//! ```text
//! u_i = e^{−q_i} Σ_j P_ij u_j,  u_g = 1 on the best goals,     q_i = c_i · (−ln kept),     φ ∝ ln u
//! ```
//!
//! With `kept` = 0.9 and unit costs this is u = 0.9 P u away from the goals, a random walk with restart seen from the
//! other end. −ln u behaves like a distance (Varadhan), but one that knows of all ways rather than of the shortest
//! alone: between two passages of equal length the wider one looks nearer.

use super::diffusion::Diffusion;
use super::grounded::GroundedSolution;
use super::site::{Site, SiteModel};
use super::{PotentialFit, ShapingError};

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
        let per_step = -libm::log(self.kept);
        let q: Vec<f64> = site.terrain.costs.iter().map(|c| c * per_step).collect();
        let mut diffusion = Diffusion::new(&site.terrain.chain);
        let solution = GroundedSolution::new(site.terrain, &mut diffusion, &q, None);
        let fit = PotentialFit::checked(site.terrain.potential(&solution.v, self.scale_factor))?;
        Ok(PotentialFit {
            solve: Some(solution.report),
            ..fit
        })
    }
}
