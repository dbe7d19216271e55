//! Construction of a solver from a case: rejects unsupported features, by JSON path.
//!
//! Options with the defaults of the case, sampling of bodies, assembly of the owners, warnings, and the size of a problem. The module knows
//! all others except `output` and `checkpoint`.

mod band_checks;
mod bodies;
mod build_solver;
mod capabilities;
pub(crate) mod defaults;
pub(crate) mod fall_time;
pub(crate) mod manufactured;
mod point_changes;
pub(crate) mod problem_size;
mod warnings;

use std::any::Any;

use colluvium_case::description::Space;
use colluvium_case::{Case, CaseError, CaseErrorKind, Plan, Resolution, Solver, StepLimit};

use crate::background_grid::dimension_dispatch::{DimensionVisitor, SelectedTransfers, dispatch};
use crate::background_grid::unstructured_mesh;
use crate::boundary::prescribed_motion;
use crate::config::ShapeFunctions;
use crate::momentum::consistent_mass;
use crate::setup::band_checks::check_bands;
pub use crate::setup::build_solver::solver;
pub use crate::setup::capabilities::capabilities;
use crate::setup::warnings::warnings;
use crate::solver::MpmSolver;
use crate::stress::{cell_integration, dual_domain};
use crate::{MpmOptions, obstacles, phases};
use colluvium_case::Warning;

/// Point updates per second with GIMP in the plane and in space, for a million points of one phase on one thread
/// (docs/benchmarks/2026-11-22-mpm).
const UPDATES_PER_SECOND: [f64; 2] = [12e6, 7e6];

/// Returns the validated options of the case.
pub fn options(case: &Case) -> Result<MpmOptions, CaseError> {
    if !case.methods.contains_key("mpm") {
        let problem = "is missing: the material point method needs at least its `cell_size` (m)";
        return Err(CaseError::new("methods.mpm", CaseErrorKind::missing_input("mpm", problem)));
    }
    let mut options: MpmOptions = case.method_options("mpm")?;
    defaults::set_case_defaults(case, &mut options);
    options.validate().map_err(|(name, problem)| CaseError::new(format!("methods.mpm.{name}"), problem))?;
    options.validate_stage_flip(case)?;
    let options = phases::check_supported(case, options)?;
    check_bands(case, &options)?;
    if options.shape == ShapeFunctions::Cpdi2 && case.space != Space::PlaneStrain {
        let problem = "cpdi2 has quadrilateral point domains and is available in plane strain only: use cpdi";
        return Err(CaseError::new("methods.mpm.shape", problem));
    }
    unstructured_mesh::check_supported(case, &options)?;
    dual_domain::check_supported(case, &options)?;
    consistent_mass::check_supported(case, &options)?;
    cell_integration::check_supported(&options)?;
    obstacles::check_supported(case, &options)?;
    Ok(options)
}

/// Construction of the solver of a case.
struct BuildSolver<'a> {
    case: &'a Case,
    options: &'a MpmOptions,
}

impl DimensionVisitor for BuildSolver<'_> {
    type Output = Result<Box<dyn Solver>, CaseError>;

    fn visit<const D: usize>(self, chosen: SelectedTransfers<D>) -> Self::Output {
        Ok(Box::new(solver(self.case, self.options, chosen)?))
    }
}

/// Plan of a run.
struct BuildPlan<'a> {
    case: &'a Case,
    options: &'a MpmOptions,
}

impl DimensionVisitor for BuildPlan<'_> {
    type Output = Result<Plan, CaseError>;

    fn visit<const D: usize>(self, chosen: SelectedTransfers<D>) -> Self::Output {
        let mut solver = solver(self.case, self.options, chosen)?;
        let time_step = solver.critical_step();
        let points = solver.point_count();
        let duration: f64 = self.case.stages.iter().map(|stage| stage.duration).sum();
        let nodes = solver.background.layout.len() * solver.boundary.contacts.fields();
        let phases = if solver.two_phase.is_some() { 2 } else { 1 };
        let mut volumes = vec![0.0; self.case.bodies.len()];
        for set in &solver.bodies.sets {
            volumes[set.body as usize] += set.points.initial_volume.iter().sum::<f64>();
        }
        let mut warnings = warnings(self.case, self.options, (solver.clock.courant, time_step.dt), points);
        for patch in
            prescribed_motion::empty_patches(&solver.clock, &solver.background, &solver.boundary.driven)
        {
            warnings.push(Warning::new(
                "empty-patch",
                format!(
                    "patches[{patch}].region: contains no node at the start. Make it a cell \
                               larger, or move it"
                ),
            ));
        }
        if time_step.limit == StepLimit::SEEPAGE_DRAG {
            // sheet: mpm P-13.
            warnings.push(Warning::new("drag-limits-step", format!(
                "pore_fluid: the drag of this low permeability limits the time step to {:.2e} s. Where no \
                 fluid flows out in the time considered, use the material `undrained`",
                time_step.dt
            )));
        }
        Ok(Plan {
            points,
            nodes,
            steps: (duration / time_step.dt).ceil() as u64,
            time_step,
            memory: solver.memory() as u64,
            volumes,
            grains: None,
            densities: None,
            resolution: Some(Resolution {
                width: self.options.cell_size,
                point_distance: self.options.cell_size / self.options.points_per_cell as f64,
                axes: D,
                case_key: "methods.mpm.cell_size",
                noun: "cells",
            }),
            updates_per_second: UPDATES_PER_SECOND[usize::from(D == 3)] / f64::from(phases),
            warnings,
        })
    }
}

/// Returns the solver of `case`.
pub fn build(case: &Case) -> Result<Box<dyn Solver>, CaseError> {
    let options = options(case)?;
    dispatch(case, &options, BuildSolver { case, options: &options })
}

/// Returns the plan of `case`.
pub fn plan(case: &Case) -> Result<Plan, CaseError> {
    let options = options(case)?;
    dispatch(case, &options, BuildPlan { case, options: &options })
}

/// Construction of a solver with its type.
struct BuildTypedSolver<'a> {
    case: &'a Case,
    options: &'a MpmOptions,
}

impl DimensionVisitor for BuildTypedSolver<'_> {
    type Output = Result<Box<dyn Any>, CaseError>;

    fn visit<const D: usize>(self, chosen: SelectedTransfers<D>) -> Self::Output {
        Ok(Box::new(solver(self.case, self.options, chosen)?))
    }
}

/// Returns the solver of `case`, which has `D` dimensions.
pub fn typed_solver<const D: usize>(case: &Case) -> Result<MpmSolver<D>, CaseError> {
    let options = options(case)?;
    let solver = dispatch(case, &options, BuildTypedSolver { case, options: &options })?;
    let other_dimension = |_| {
        CaseError::new("space", CaseErrorKind::coded("wrong-dimension", format!("has not {D} dimensions")))
    };
    solver.downcast().map(|solver| *solver).map_err(other_dimension)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Returns the solver of a case in `D` dimensions, at time zero.
    pub fn initial_solver<const D: usize>(case: &Case) -> MpmSolver<D> {
        typed_solver(case).unwrap()
    }
}
