//! Construction of a solver from a case: rejects unsupported features, by JSON path.

mod band_checks;
mod bodies;
mod capabilities;
mod defaults;
pub(crate) mod fall_time;
pub(crate) mod manufactured;
pub(crate) mod problem_size;
mod warnings;

use std::sync::Arc;

use colluvium_case::description::{Body, LoadTarget, Space, Wall as CaseWall};
use colluvium_case::{Case, CaseError, OVERLAP_TOLERANCE, Plan, Resolution, Solver, StepLimit};
use colluvium_grid::{NodalState, NodeFaces, NodeWalls};

use crate::background_grid::BackgroundGrid;
use crate::background_grid::dimension_dispatch::SelectedTransfers;
use crate::background_grid::{dimension_dispatch, unstructured_mesh};
use crate::boundary::absorbing_boundary::{AbsorbingBoundaries, Impedance};
use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::boundary::prescribed_motion;
use crate::boundary::{nodal_loads, point_loads, rigid_bodies, walls};
use crate::clock::Clock;
use crate::config::ShapeFunctions;
use crate::contact::contact_correction::{radii, rigid_volume_thresholds, rigid_volume_thresholds_on_mesh};
use crate::contact::contact_gap::SurfaceDistance;
use crate::contact::contact_law;
use crate::contact::rigid_contact::ContactSet;
use crate::momentum::EquilibriumTerms;
use crate::momentum::consistent_mass::ConsistentMass;
use crate::momentum::driven_object::DrivenObject;
use crate::momentum::velocity_fields::VelocityFields;
use crate::obstacles::node_obstacles::NodeObstacles;
use crate::obstacles::obstacle_penalty::initialise_penalty;
use crate::obstacles::reaction::ReactionRecorder;
use crate::obstacles::state::PenaltyObstacles;
use crate::phases;
use crate::points::bodies::Bodies;
use crate::points::point_set::PointSet;
use crate::setup::band_checks::check_bands;
pub use crate::setup::capabilities::capabilities;
use crate::solver::MpmSolver;
use crate::stress::averages::CellAverages;
use crate::stress::cell_integration;
use crate::stress::cell_integration::CellStresses;
use crate::stress::dual_domain::DualDomainNodes;
use crate::stress::stress_work::start_work_record;
use crate::stress::volumetric_strain::CellStrains;
use crate::stress::{dual_domain, free_surface};
use crate::transfer::affine_transfer::initialise_affine;
use crate::{MpmOptions, ObstacleCoupling, StressScheme, obstacles};
use bodies::point_set;
use warnings::warnings;

/// Updates per second of one phase with GIMP in the plane and in space, a million points on one thread
/// (docs/benchmarks/2026-11-22-mpm).
const UPDATES_PER_SECOND: [f64; 2] = [12e6, 7e6];

/// Returns the validated options of the case.
pub fn options(case: &Case) -> Result<MpmOptions, CaseError> {
    if !case.methods.contains_key("mpm") {
        let problem = "is missing: the material point method needs at least its `cell_size` (m)";
        return Err(CaseError::new("methods.mpm", problem));
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
    crate::momentum::consistent_mass::check_supported(case, &options)?;
    cell_integration::check_supported(&options)?;
    obstacles::check_supported(case, &options)?;
    Ok(options)
}

/// Construction of the solver of a case.
struct BuildSolver<'a> {
    case: &'a Case,
    options: &'a MpmOptions,
}

impl dimension_dispatch::DimensionVisitor for BuildSolver<'_> {
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

impl dimension_dispatch::DimensionVisitor for BuildPlan<'_> {
    type Output = Result<Plan, CaseError>;

    fn visit<const D: usize>(self, chosen: SelectedTransfers<D>) -> Self::Output {
        let mut solver = solver(self.case, self.options, chosen)?;
        let time_step = solver.critical_step();
        let points = solver.points();
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
            warnings.push(format!("patches[{patch}].region: contains no node at the start"));
        }
        if time_step.limit == StepLimit::SEEPAGE_DRAG {
            // sheet: mpm P-13.
            warnings.push(format!(
                "pore_fluid: the drag of this low permeability limits the time step to {:.2e} s. Where no \
                 fluid flows out in the time considered, use the material `undrained`",
                time_step.dt
            ));
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
                key: "methods.mpm.cell_size",
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
    dimension_dispatch::dispatch(case, &options, BuildSolver { case, options: &options })
}

/// Returns the plan of `case`.
pub fn plan(case: &Case) -> Result<Plan, CaseError> {
    let options = options(case)?;
    dimension_dispatch::dispatch(case, &options, BuildPlan { case, options: &options })
}

/// Returns a solver with its concrete type, at time zero.
pub fn solver<const D: usize>(
    case: &Case,
    options: &MpmOptions,
    chosen: SelectedTransfers<D>,
) -> Result<MpmSolver<D>, CaseError> {
    let axis = chosen.transfers.basis_1d();
    let background =
        BackgroundGrid::new(case, chosen, unstructured_mesh::grid_mesh_and_layout(case, options, &axis)?);
    // Stages only remove walls: those of the first are the largest set.
    walls::walls(case, 0, &background, options)?;
    let standing = case.placed_obstacles::<D>()?;
    let at_points = options.obstacles == ObstacleCoupling::Points && !standing.is_empty();
    let bearing = ReactionRecorder::new(case)?;
    let held = NodeObstacles::new(if at_points { &[] } else { &standing }, &background, &bearing);
    let told = !held.is_empty() && obstacles::why_not_recorded(options).is_none();
    let domain = (background.grid.origin, background.upper);
    let rocks =
        at_points.then(|| Box::new(PenaltyObstacles::new(&standing, domain, 2.0 * options.cell_size)));
    let mut driven = prescribed_motion::driven_objects(case);
    let BackgroundGrid { mesh, layout, .. } = &background;
    let mut two_phase = phases::two_phase(case, options, layout);
    if let Some(phases) = two_phase.as_mut().filter(|_| !at_points) {
        phases.faces = Arc::new(obstacles::pore_fluid_faces(&standing, &background));
    }
    let mut sets = Vec::new();
    let mut next = 0;
    for number in 0..case.bodies.len() {
        let mut set = point_set(case, options, &background, number, next, two_phase.is_some())?;
        next += set.len();
        set.rigid = case.bodies[number].rigid.then(|| rigid_number(&driven, &case.bodies[number])).flatten();
        if set.rigid.is_none() || case.moves_freely(&case.bodies[number].name) {
            case.reject_overlapping_points(
                &standing,
                number,
                &set.points.position,
                OVERLAP_TOLERANCE * options.cell_size,
            )?;
        }
        sets.push(set);
    }
    let clock = Clock::new(case, options);
    rigid_bodies::initialise_rigid(&clock, &sets, &mut driven);
    let contacts = contact_law::field_contacts(case, options, &mut sets)?;
    cell_integration::check_stress_reset(case, options, &sets)?;
    let cells = background.cell_layout();
    let strains = CellStrains::new(case, options, [layout, cells]);
    let stresses = CellStresses::new(options, cells, contacts.fields());
    let dual = DualDomainNodes::new(options, layout, contacts.fields());
    let consistent = ConsistentMass::new(options, layout);
    let nodal = nodal_loads::nodal_loads(case, options, &background, &sets)?;
    for number in 0..case.loads.len() {
        if case.loads[number].applied_to() == LoadTarget::Points {
            point_loads::apply(case, number, mesh, &mut sets)?;
        }
    }
    let absorbs = case.boundaries.iter().position(|b| matches!(b.wall, CaseWall::Absorbing { .. }));
    let impedances = absorbs.map_or_else(Vec::new, |_| {
        sets.iter().map(|set| Impedance::of_body(set, options.mass_scaling)).collect()
    });
    if let (Some(number), true) = (absorbs, contacts.fields() > 1) {
        let problem = "an absorbing boundary is not available with contacts";
        return Err(CaseError::new(format!("boundaries[{number}].wall"), problem));
    }
    let most = sets.iter().map(PointSet::len).max().unwrap_or(0);
    let free_surface = free_surface::free_surface(case, options, &background, most)?;
    let own_nodes = if two_phase.is_none() { contacts.fields() * layout.len() } else { 0 };
    let nodes = VelocityFields {
        solved: vec![NodalState::default(); own_nodes],
        row_sums: vec![EquilibriumTerms::default(); layout.nodes()[0]],
        ..VelocityFields::default()
    };
    let boundary = BoundaryConditions {
        walls: NodeWalls::default(),
        has_wall: [[false; 2]; D],
        node_obstacles: held,
        reaction_recorder: told.then_some(bearing),
        penalty_obstacles: rocks,
        driven,
        contacts,
        row_contacts: Vec::new(),
        rigid_contacts: ContactSet::default(),
        load_starts: case.load_starts(),
        nodal_loads: nodal,
        absorbing: AbsorbingBoundaries::new(impedances),
    };
    let mut solver = MpmSolver {
        clock,
        averages: CellAverages { strains, stresses, dual_domain: dual, free_surface },
        bodies: Bodies::new(sets),
        background,
        nodes,
        boundary,
        consistent,
        two_phase,
        manufactured: None,
    };
    // XPIC sweeps over the same nodes before they hold re-mapped velocities.
    if options.stress_update != StressScheme::Usl || options.filters_velocities() {
        solver.nodes.remapped = vec![Default::default(); solver.nodes.solved.len()];
    }
    if options.rescales_small_mass_forces() {
        solver.nodes.mass_gradients = vec![Default::default(); solver.nodes.solved.len()];
    }
    if solver.boundary.contacts.fields() > 1 {
        solver.boundary.contacts.surfaces = vec![Default::default(); solver.nodes.solved.len()];
        solver.boundary.row_contacts = crate::contact::contact_correction::row_contacts(
            &solver.boundary.contacts,
            solver.nodes.row_sums.len(),
            solver.background.layout.strides()[0],
        );
        if solver.background.axisymmetric {
            solver.boundary.contacts.radii = radii(&solver.background);
        }
        if solver.background.is_meshed() {
            solver.boundary.contacts.rigid_volume_threshold =
                rigid_volume_thresholds_on_mesh(&solver.background.mesh, solver.background.layout.len());
        } else {
            solver.boundary.contacts.rigid_volume_threshold =
                rigid_volume_thresholds(&solver.background, options.points_per_cell);
            solver.boundary.contacts.distance = SurfaceDistance::new(&solver.background.basis_1d);
        }
    }
    walls::reject_walls_that_leave(case, solver.background.spacing())?;
    initialise_penalty(&solver.background, &mut solver.bodies, &mut solver.boundary.penalty_obstacles);
    solver.boundary.absorbing.store_initial_positions(&solver.clock, &solver.background, &solver.bodies);
    solver.set_stage_walls(0)?;
    solver.sort();
    initialise_affine(&solver.clock, &solver.background, &mut solver.bodies);
    if case.measures_dissipation() {
        start_work_record(&mut solver.bodies);
    }
    check_fixed_step(&solver, options)?;
    Ok(solver)
}

fn rigid_number(driven: &[DrivenObject], body: &Body) -> Option<usize> {
    driven.iter().position(|driven| driven.patch.is_none() && driven.name == body.name)
}

fn check_fixed_step<const D: usize>(solver: &MpmSolver<D>, options: &MpmOptions) -> Result<(), CaseError> {
    match options.time_step.and_then(|step| solver.wave_limit(1.0).fixed_step_problem(Some(step))) {
        Some(problem) => Err(CaseError::new("methods.mpm.time_step", problem)),
        None => Ok(()),
    }
}

impl<const D: usize> MpmSolver<D> {
    /// Sets the walls of a stage, of all phases.
    pub(crate) fn set_stage_walls(&mut self, stage: usize) -> Result<(), CaseError> {
        let walls = |case: &Case, faces: &Arc<NodeFaces>| -> Result<NodeWalls, CaseError> {
            let mut walls = walls::walls(case, stage, &self.background, &self.clock.options)?;
            walls.set_starts_moving(self.clock.step == 0);
            Ok(walls.with_faces(Arc::clone(faces)))
        };
        let own = walls(&self.clock.case, &self.boundary.node_obstacles.rest)?;
        let of_liquid = self
            .two_phase
            .as_ref()
            .map(|phases| walls(&phases::liquid_case(&self.clock.case), &phases.faces))
            .transpose()?;
        if let (Some(phases), Some(of_liquid)) = (&mut self.two_phase, of_liquid) {
            phases.walls = of_liquid;
        }
        self.boundary.set_walls(&self.background, own);
        self.boundary.absorbing.set_stage(&self.clock, &self.background, &self.bodies, stage);
        Ok(())
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::any::Any;

    use super::*;

    struct Begin<'a>(&'a Case, &'a MpmOptions);

    impl dimension_dispatch::DimensionVisitor for Begin<'_> {
        type Output = Result<Box<dyn Any>, CaseError>;

        fn visit<const D: usize>(self, chosen: SelectedTransfers<D>) -> Self::Output {
            Ok(Box::new(solver(self.0, self.1, chosen)?))
        }
    }

    /// Returns the solver of a case in `D` dimensions, at time zero.
    pub fn begun<const D: usize>(case: &Case) -> MpmSolver<D> {
        let options = options(case).unwrap();
        *dimension_dispatch::dispatch(case, &options, Begin(case, &options)).unwrap().downcast().unwrap()
    }
}
