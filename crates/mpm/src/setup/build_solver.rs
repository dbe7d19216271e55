//! Assembly of a solver from the parts of a case.

use std::sync::Arc;

use colluvium_case::description::{Body, LoadTarget, Wall as CaseWall};
use colluvium_case::{Case, CaseError, OVERLAP_TOLERANCE, PlacedObstacle};
use colluvium_grid::{Layout, NodalState, NodeFaces, NodeWalls};

use crate::background_grid::BackgroundGrid;
use crate::background_grid::dimension_dispatch::SelectedTransfers;
use crate::background_grid::unstructured_mesh::grid_mesh_and_layout;
use crate::boundary::absorbing_boundary::{AbsorbingBoundaries, Impedance};
use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::boundary::{nodal_loads, point_loads, prescribed_motion, rigid_bodies, walls};
use crate::clock::Clock;
use crate::contact::contact_correction::{
    radii, rigid_volume_thresholds, rigid_volume_thresholds_on_mesh, row_contacts,
};
use crate::contact::contact_gap::SurfaceDistance;
use crate::contact::contact_law;
use crate::contact::contact_law::FieldContacts;
use crate::contact::rigid_contact::ContactSet;
use crate::momentum::EquilibriumTerms;
use crate::momentum::consistent_mass::ConsistentMass;
use crate::momentum::driven_object::DrivenObject;
use crate::momentum::velocity_fields::VelocityFields;
use crate::obstacles::node_obstacles::NodeObstacles;
use crate::obstacles::obstacle_penalty::initialise_penalty;
use crate::obstacles::reaction::ReactionRecorder;
use crate::obstacles::state::PenaltyObstacles;
use crate::points::bodies::Bodies;
use crate::points::point_set::PointSet;
use crate::setup::bodies::point_set;
use crate::solver::MpmSolver;
use crate::stress::averages::CellAverages;
use crate::stress::cell_integration::{CellStresses, check_stress_reset};
use crate::stress::dual_domain::DualDomainNodes;
use crate::stress::free_surface::free_surface;
use crate::stress::stress_work::start_work_record;
use crate::stress::volumetric_strain::CellStrains;
use crate::transfer::affine_transfer::initialise_affine;
use crate::{MpmOptions, ObstacleCoupling, StressScheme, obstacles, phases};
use colluvium_case::CaseErrorKind;

/// Returns a solver with its concrete type, at time zero.
pub fn solver<const D: usize>(
    case: &Case,
    options: &MpmOptions,
    chosen: SelectedTransfers<D>,
) -> Result<MpmSolver<D>, CaseError> {
    let axis = chosen.transfers.basis_1d();
    let background = BackgroundGrid::new(case, chosen, grid_mesh_and_layout(case, options, &axis)?);
    // Stages only remove walls: those of the first are the largest set.
    walls::walls(case, 0, &background, options)?;
    let obstacles = CaseObstacles::new(case, options, &background)?;
    let mut driven = prescribed_motion::driven_objects(case);
    let mut two_phase = phases::two_phase(case, options, &background.layout);
    if let Some(phases) = two_phase.as_mut().filter(|_| obstacles.penalty.is_none()) {
        phases.faces = Arc::new(obstacles::pore_fluid_faces(&obstacles.placed_obstacles, &background));
    }
    let mut sets = point_sets(case, options, &background, &driven, &obstacles.placed_obstacles)?;
    let clock = Clock::new(case, options);
    rigid_bodies::initialise_rigid(&clock, &sets, &mut driven);
    let contacts = contact_law::field_contacts(case, options, &mut sets)?;
    check_stress_reset(case, options, &sets)?;
    let nodal_loads = nodal_loads::nodal_loads(case, options, &background, &sets)?;
    for number in 0..case.loads.len() {
        if case.loads[number].applied_to() == LoadTarget::Points {
            point_loads::apply(case, number, &background.mesh, &mut sets)?;
        }
    }
    let absorbing = absorbing_boundaries(case, options, &sets, contacts.fields())?;
    let averages = cell_averages(case, options, &background, &sets, contacts.fields())?;
    let fields = if two_phase.is_none() { contacts.fields() } else { 0 };
    let boundary = BoundaryConditions {
        walls: NodeWalls::default(),
        has_wall: [[false; 2]; D],
        node_obstacles: obstacles.on_nodes,
        reaction_recorder: obstacles.reaction_recorder,
        penalty_obstacles: obstacles.penalty,
        driven,
        contacts,
        row_contacts: Vec::new(),
        rigid_contacts: ContactSet::default(),
        load_starts: case.load_starts(),
        nodal_loads,
        absorbing,
        body_force: None,
    };
    let mut solver = MpmSolver {
        clock,
        averages,
        bodies: Bodies::new(sets),
        nodes: velocity_fields(options, &background.layout, fields),
        consistent: ConsistentMass::new(options, &background.layout),
        background,
        boundary,
        two_phase,
        manufactured_solution: None,
    };
    initialise(case, options, &mut solver)?;
    Ok(solver)
}

/// Allocates contact arrays and initialises the state of the points and the walls of the first stage.
fn initialise<const D: usize>(
    case: &Case,
    options: &MpmOptions,
    solver: &mut MpmSolver<D>,
) -> Result<(), CaseError> {
    let MpmSolver { clock, background, bodies, nodes, boundary, .. } = solver;
    if boundary.contacts.fields() > 1 {
        allocate_contacts(options, background, nodes, &mut boundary.contacts);
        let (rows, row_length) = (nodes.row_sums.len(), background.layout.strides()[0]);
        boundary.row_contacts = row_contacts(&boundary.contacts, rows, row_length);
    }
    walls::reject_walls_that_leave(case, background.spacing())?;
    initialise_penalty(background, bodies, &mut boundary.penalty_obstacles);
    boundary.absorbing.store_initial_positions(clock, background, bodies);
    solver.set_stage_walls(0)?;
    solver.sort();
    initialise_affine(&solver.clock, &solver.background, &mut solver.bodies);
    if case.measures_dissipation() {
        start_work_record(&mut solver.bodies);
    }
    check_fixed_step(solver, options)
}

/// Obstacles of a case, on its nodes or its points.
struct CaseObstacles<'a, const D: usize> {
    placed_obstacles: Vec<PlacedObstacle<'a, D>>,
    on_nodes: NodeObstacles<D>,
    reaction_recorder: Option<ReactionRecorder>,
    /// Obstacles on the points; `None` where they are on the nodes.
    penalty: Option<Box<PenaltyObstacles<D>>>,
}

impl<'a, const D: usize> CaseObstacles<'a, D> {
    /// Obstacles of the case, coupled to nodes or to points, with the recorder of their reactions.
    fn new(case: &'a Case, options: &MpmOptions, background: &BackgroundGrid<D>) -> Result<Self, CaseError> {
        let placed_obstacles = case.placed_obstacles::<D>()?;
        let at_points = options.obstacles == ObstacleCoupling::Points && !placed_obstacles.is_empty();
        let recorder = ReactionRecorder::new(case)?;
        let on_nodes =
            NodeObstacles::new(if at_points { &[] } else { &placed_obstacles }, background, &recorder);
        let is_recorded = !on_nodes.is_empty() && obstacles::why_not_recorded(options).is_none();
        let domain = (background.grid.origin, background.upper_corner);
        let penalty = at_points
            .then(|| Box::new(PenaltyObstacles::new(&placed_obstacles, domain, 2.0 * options.cell_size)));
        Ok(Self { placed_obstacles, on_nodes, reaction_recorder: is_recorded.then_some(recorder), penalty })
    }
}

/// Point sets of all bodies; an error if a point is inside an obstacle.
fn point_sets<const D: usize>(
    case: &Case,
    options: &MpmOptions,
    background: &BackgroundGrid<D>,
    driven: &[DrivenObject],
    obstacles: &[PlacedObstacle<'_, D>],
) -> Result<Vec<PointSet<D>>, CaseError> {
    let wet = case.bodies.iter().any(|body| body.pore_fluid.is_some());
    let (mut sets, mut first_id) = (Vec::new(), 0);
    for (number, body) in case.bodies.iter().enumerate() {
        let listed = case.point_list(number)?;
        let mut set = point_set(case, options, background, (number, listed.as_ref()), first_id, wet)?;
        first_id += set.len();
        set.rigid = body.rigid.then(|| rigid_number(driven, body)).flatten();
        if set.rigid.is_none() || case.moves_freely(&body.name) {
            let tolerance = OVERLAP_TOLERANCE * options.cell_size;
            case.reject_overlapping_points(obstacles, number, &set.points.position, tolerance)?;
        }
        sets.push(set);
    }
    Ok(sets)
}

/// Index of the rigid body of the case among the objects with prescribed motion.
fn rigid_number(driven: &[DrivenObject], body: &Body) -> Option<usize> {
    driven.iter().position(|driven| driven.patch.is_none() && driven.name == body.name)
}

/// Returns the absorbing boundaries, with the wave impedances of the bodies where the case has any.
fn absorbing_boundaries<const D: usize>(
    case: &Case,
    options: &MpmOptions,
    sets: &[PointSet<D>],
    fields: usize,
) -> Result<AbsorbingBoundaries, CaseError> {
    let number = case.boundaries.iter().position(|b| matches!(b.wall, CaseWall::Absorbing { .. }));
    let impedances = number.map_or_else(Vec::new, |_| {
        sets.iter().map(|set| Impedance::of_body(set, options.mass_scaling)).collect()
    });
    if let (Some(number), true) = (number, fields > 1) {
        let problem = "an absorbing boundary is not available with contacts";
        return Err(CaseError::new(
            format!("boundaries[{number}].wall"),
            CaseErrorKind::coded("incompatible-options", problem),
        ));
    }
    Ok(AbsorbingBoundaries::new(impedances))
}

/// Returns the averages over cells and nodes that the options need.
fn cell_averages<const D: usize>(
    case: &Case,
    options: &MpmOptions,
    background: &BackgroundGrid<D>,
    sets: &[PointSet<D>],
    fields: usize,
) -> Result<CellAverages<D>, CaseError> {
    let (layout, cells) = (&background.layout, background.cell_layout());
    let max_points = sets.iter().map(PointSet::len).max().unwrap_or(0);
    Ok(CellAverages {
        strains: CellStrains::new(case, options, [layout, cells]),
        stresses: CellStresses::new(options, cells, fields),
        dual_domain: DualDomainNodes::new(options, layout, fields),
        free_surface: free_surface(case, options, background, max_points)?,
    })
}

/// Returns the nodes of a number of velocity fields, with the arrays that the options need.
fn velocity_fields<const D: usize>(
    options: &MpmOptions,
    layout: &Layout<D>,
    fields: usize,
) -> VelocityFields {
    let count = fields * layout.len();
    let array = |needed: bool| if needed { vec![Default::default(); count] } else { Vec::new() };
    VelocityFields {
        nodal_states: vec![NodalState::default(); count],
        row_sums: vec![EquilibriumTerms::default(); layout.nodes()[0]],
        // XPIC sweeps over the same nodes before they hold re-mapped velocities.
        remapped_velocities: array(
            options.stress_update != StressScheme::Usl || options.filters_velocities(),
        ),
        mass_gradients: array(options.rescales_small_mass_forces()),
        ..VelocityFields::default()
    }
}

/// Allocates the nodal arrays of the contacts.
fn allocate_contacts<const D: usize>(
    options: &MpmOptions,
    background: &BackgroundGrid<D>,
    nodes: &VelocityFields,
    contacts: &mut FieldContacts,
) {
    contacts.surfaces = vec![Default::default(); nodes.nodal_states.len()];
    if background.axisymmetric {
        contacts.radii = radii(background);
    }
    if background.is_meshed() {
        contacts.rigid_volume_threshold =
            rigid_volume_thresholds_on_mesh(&background.mesh, background.layout.len());
    } else {
        contacts.rigid_volume_threshold = rigid_volume_thresholds(background, options.points_per_cell);
        contacts.distance = SurfaceDistance::new(&background.basis_1d);
    }
}

/// Rejects a fixed time step above the critical one.
fn check_fixed_step<const D: usize>(solver: &MpmSolver<D>, options: &MpmOptions) -> Result<(), CaseError> {
    match options.time_step.and_then(|step| solver.wave_limit(1.0).fixed_step_problem(Some(step))) {
        Some(problem) => Err(CaseError::new("methods.mpm.time_step", problem)),
        None => Ok(()),
    }
}

impl<const D: usize> MpmSolver<D> {
    /// Sets the walls of a stage for all phases.
    pub(crate) fn set_stage_walls(&mut self, stage: usize) -> Result<(), CaseError> {
        let walls = |case: &Case, faces: &Arc<NodeFaces>| -> Result<NodeWalls, CaseError> {
            let mut walls = walls::walls(case, stage, &self.background, &self.clock.options)?;
            walls.set_starts_moving(self.clock.step == 0);
            Ok(walls.with_faces(Arc::clone(faces)))
        };
        let own = walls(&self.clock.case, &self.boundary.node_obstacles.static_faces)?;
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
