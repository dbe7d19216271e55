//! Setup of the pore fluid of a case: columns of the points, and walls.

use std::collections::BTreeSet;
use std::sync::Arc;

use colluvium_case::description::{Body, Wall as CaseWall};
use colluvium_case::{Case, CaseError, PointList, spatial};
use colluvium_grid::{Layout, NodalState, NodeWalls, Vector4};

use crate::config::StepCriterion;
use crate::phases::{PhaseEquilibriumTerms, TwoPhase};
use crate::points::pore_fluid::{PoreColumns, PoreFluidConstants, PoreSet};
use crate::{MpmOptions, ShapeFunctions, StressScheme, VelocityTransfer};

/// Default Courant number of MUSL in a case with pore fluid (sheet: mpm §2.10).
const COURANT: f64 = 0.9;

/// Rejects features that two-phase analysis does not support, and sets its defaults.
pub fn check_supported(case: &Case, mut options: MpmOptions) -> Result<MpmOptions, CaseError> {
    let refuse = |path: &str, problem: &str| Err(CaseError::new(path, problem));
    if case.bodies.iter().all(|body| body.pore_fluid.is_none()) {
        if options.step_criterion != StepCriterion::Combined {
            return refuse(
                "methods.mpm.step_criterion",
                "simple is for two phases, but no body has a pore_fluid",
            );
        }
        return Ok(options);
    }
    if options.transfer != VelocityTransfer::Flip {
        return refuse("methods.mpm.transfer", "only flip (or a share of it) is available with a pore_fluid");
    }
    if options.residual_time.is_some() {
        return refuse("methods.mpm.residual_time", "is for one phase and not available with a pore_fluid");
    }
    if options.shape == ShapeFunctions::Cpdi2 {
        return refuse("methods.mpm.shape", "cpdi2 is not available with a pore_fluid: use cpdi");
    }
    if options.free_surface.is_some() {
        return refuse(
            "methods.mpm.free_surface",
            "is for liquids without grains and not available with a pore_fluid",
        );
    }
    if !options.contacts.is_empty() {
        return refuse(
            "methods.mpm.contacts",
            "are not available with a pore_fluid: at a contact between nodes the fluid has no correct \
             boundary condition, and its pressure oscillates. For a rigid partner use an obstacle, which may \
             move, with methods.mpm.obstacles points. Where no fluid flows out, use a material of the model \
             undrained in place of the pore_fluid. Bodies without a contact stick together, and the fluid \
             flows between them",
        );
    }
    // The criterion belongs to the sheet's sequence, which is MUSL; with USL it overshoots at free surfaces.
    let chosen = case.methods["mpm"].get("courant").is_some();
    let combined = options.step_criterion == StepCriterion::Combined;
    if !chosen && combined && options.stress_update == StressScheme::Musl {
        options.courant = COURANT;
    }
    Ok(options)
}

/// Returns the nodes of both phases; `None` for a case without pore fluid.
pub fn two_phase<const D: usize>(
    case: &Case,
    options: &MpmOptions,
    layout: &Layout<D>,
) -> Option<Box<TwoPhase>> {
    case.bodies.iter().any(|body| body.pore_fluid.is_some()).then(|| {
        let length = |needed: bool| if needed { layout.len() } else { 0 };
        Box::new(TwoPhase {
            nodes: vec![[NodalState::default(); 2]; layout.len()],
            remapped_velocities: vec![[Vector4::ZERO; 2]; length(options.stress_update != StressScheme::Usl)],
            constrained_components: Vec::new(),
            row_sums: vec![PhaseEquilibriumTerms::default(); layout.nodes()[0]],
            sums: PhaseEquilibriumTerms::default(),
            walls: NodeWalls::default(),
            faces: Arc::default(),
            max_liquid_mass: 0.0,
        })
    })
}

/// Case for the liquid, with smooth walls in place of impermeable ones.
pub fn liquid_case(case: &Case) -> Case {
    let mut liquid = case.clone();
    liquid.boundaries.retain(|boundary| !boundary.drained);
    liquid.boundaries.retain(|boundary| !matches!(boundary.wall, CaseWall::Absorbing { .. }));
    for boundary in &mut liquid.boundaries {
        boundary.separation |= boundary.wall.allows_separation();
        boundary.wall = CaseWall::Smooth;
    }
    let standing: BTreeSet<String> = liquid.boundaries.iter().map(|b| b.name().to_owned()).collect();
    for stage in &mut liquid.stages {
        stage.remove_boundaries.retain(|name| standing.contains(name));
    }
    liquid
}

/// Pore-fluid data of the points of a body; `listed` values are from a file.
pub fn pore_set<const D: usize>(
    case: &Case,
    body: &Body,
    listed: Option<&PointList>,
    position: &[[f64; D]],
) -> PoreSet<D> {
    let gravity = case.gravity3();
    let Some(fluid) = &body.pore_fluid else {
        return PoreSet {
            fluid: None,
            points: PoreColumns {
                velocity: vec![[0.0; D]; position.len()],
                pressure: vec![0.0; position.len()],
                ..PoreColumns::default()
            },
        };
    };
    let strength = gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
    let velocity_at = |(point, x): (usize, &[f64; D])| {
        let own = listed.and_then(|list| Some(list.velocities.as_ref()?[point]));
        let velocity = match (&fluid.velocity, own) {
            (Some(velocity), _) => velocity.velocity_at(spatial(x)),
            (None, Some(own)) => own,
            (None, None) => body.velocity.velocity_at(spatial(x)),
        };
        std::array::from_fn(|c| velocity[c])
    };
    let pressure: Vec<f64> = match listed.and_then(|list| list.pore_pressures.clone()) {
        Some(listed) => listed,
        None => position.iter().map(|x| fluid.pressure_at(spatial(x), gravity)).collect(),
    };
    let constants = PoreFluidConstants {
        density: fluid.density,
        bulk_modulus: fluid.bulk_modulus,
        porosity: fluid.porosity,
        resistance: fluid.resistance(strength),
        min_pressure: fluid.cavitation_strength.map_or(f64::NEG_INFINITY, |strength| -strength),
    };
    let velocity = position.iter().enumerate().map(velocity_at).collect();
    PoreSet { fluid: Some(constants), points: PoreColumns { velocity, pressure, ..PoreColumns::default() } }
}
