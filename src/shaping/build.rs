//! From parameters to a potential: the one place that knows every kind.

use super::conductance::ConductancePotential;
use super::heat::HeatPotential;
use super::hops::HopsPotential;
use super::none::NoPotential;
use super::oracle::OraclePotential;
use super::report::ReportPotential;
use super::site::SiteModel;
use super::{PotentialKind, PotentialModel, ShapingParams};
use crate::gcn::GcnParams;

/// The potential that `shaping.potential` names. The oracle is told its distances afterwards
/// ([`PotentialModel::set_true_distance`]).
pub fn build_potential(
    shaping: &ShapingParams,
    gcn: &GcnParams,
    seed: u64,
) -> Box<dyn PotentialModel> {
    match shaping.potential {
        PotentialKind::Oracle => Box::new(OraclePotential::new(shaping.scale_factor)),
        PotentialKind::None => Box::new(NoPotential),
        PotentialKind::Gcn => Box::new(gcn_potential(shaping, gcn, seed)),
        PotentialKind::Report => Box::new(report_potential(shaping, gcn, seed)),
        PotentialKind::Heat => Box::new(heat_potential(shaping)),
        PotentialKind::Hops => Box::new(hops_potential(shaping)),
    }
}

/// The same for the kinds that need no world; `None` for the others.
pub(crate) fn build_site_model(
    kind: PotentialKind,
    shaping: &ShapingParams,
    gcn: &GcnParams,
    seed: u64,
) -> Option<Box<dyn SiteModel>> {
    match kind {
        PotentialKind::Gcn => Some(Box::new(gcn_potential(shaping, gcn, seed))),
        PotentialKind::Report => Some(Box::new(report_potential(shaping, gcn, seed))),
        PotentialKind::Heat => Some(Box::new(heat_potential(shaping))),
        PotentialKind::Hops => Some(Box::new(hops_potential(shaping))),
        PotentialKind::Oracle | PotentialKind::None => None,
    }
}

fn gcn_potential(shaping: &ShapingParams, gcn: &GcnParams, seed: u64) -> ConductancePotential {
    ConductancePotential::new(shaping.clone(), gcn.clone(), seed)
}

fn report_potential(shaping: &ShapingParams, gcn: &GcnParams, seed: u64) -> ReportPotential {
    ReportPotential::new(gcn.clone(), shaping.scale, shaping.scale_factor, seed)
}

fn heat_potential(shaping: &ShapingParams) -> HeatPotential {
    HeatPotential {
        kept: shaping.heat_kept,
        scale_factor: shaping.scale_factor,
    }
}

fn hops_potential(shaping: &ShapingParams) -> HopsPotential {
    HopsPotential {
        scale_factor: shaping.scale_factor,
    }
}
