//! From a case to a solver: refuses what the method cannot honour, by JSON path.

use std::marker::PhantomData;
use std::sync::Arc;

use colluvium_case::description::{Body, Boundary, LoadCarrier, Space, Wall as CaseWall};
use colluvium_case::{Case, CaseError, Plan, PointList, Solver, StepLimit, spatial};
use colluvium_constitutive::{InitialCondition, Material, SymTensor};
use colluvium_grid::{Basis, Grid, Layout, Node, Walls};
use colluvium_points::Sample;

use crate::absorbing::{Absorbing, Impedance};
use crate::config::{COURANT, Integration, ShapeFunctions, StepCriterion, WallFriction};
use crate::consistent::ConsistentMass;
use crate::driven::{self, Driven};
use crate::dual::DualNodes;
use crate::gap::SurfaceDistance;
use crate::mixed::{self, CellStresses};
use crate::momentum::RowSums;
use crate::points::{Ground, PointDomain, PointSet, ground};
use crate::solver::MpmSolver;
use crate::strain::CellStrains;
use crate::touch::{filled, filled_on_mesh};
use crate::{
    Formulation, MpmOptions, StressScheme, Transfer, contact, dispatch, dual, free_surface, loads, mesh,
    nodal, two_phase, walls,
};

/// Memory to sort a point by cell (bytes): its place in the order and the largest of its arrays a second time.
pub const SORTING: usize = 16 + size_of::<SymTensor>();
/// Updates per second of one phase with GIMP in the plane and in space, a million points on one thread
/// (docs/benchmarks/2026-11-22-mpm).
const PACE: [f64; 2] = [12e6, 7e6];

/// Beyond this many points the ids no longer fit.
const MOST_POINTS: usize = u32::MAX as usize;

/// The options of the case, checked.
pub fn options(case: &Case) -> Result<MpmOptions, CaseError> {
    if !case.methods.contains_key("mpm") {
        let problem = "is missing: the material point method needs at least its `cell_size` (m)";
        return Err(CaseError::new("methods.mpm", problem));
    }
    let options: MpmOptions = case.method_options("mpm")?;
    options.validate().map_err(|(name, problem)| CaseError::new(format!("methods.mpm.{name}"), problem))?;
    options.validate_stage_flip(case)?;
    let options = two_phase::cleared(case, options)?;
    if options.shape == ShapeFunctions::Cpdi2 && case.space != Space::PlaneStrain {
        let problem = "cpdi2 is of quadrilaterals and available in plane strain only: use cpdi";
        return Err(CaseError::new("methods.mpm.shape", problem));
    }
    mesh::cleared(case, &options)?;
    dual::cleared(case, &options)?;
    crate::consistent::cleared(case, &options)?;
    mixed::cleared(&options)?;
    Ok(options)
}

/// The grid of the case.
pub fn grid<const D: usize>(case: &Case, options: &MpmOptions) -> Result<Grid<D>, CaseError> {
    let corner = |values: &[f64]| std::array::from_fn(|axis| values[axis]);
    Grid::new(corner(&case.domain.min), corner(&case.domain.max), options.cell_size)
        .map_err(|error| CaseError::new("methods.mpm.cell_size", error.to_string()))
}

/// The nodes of the case.
pub fn layout<const D: usize, const S: usize, B: Basis<S>>(
    case: &Case,
    grid: &Grid<D>,
    options: &MpmOptions,
) -> Result<Layout<D>, CaseError> {
    let layout = Layout::new::<S, B>(grid);
    if case.domain.periodic.is_empty() {
        return Ok(layout);
    }
    if !options.contacts.is_empty() {
        return Err(CaseError::new("domain.periodic", "is not available with contacts"));
    }
    let periodic = std::array::from_fn(|axis| case.domain.is_periodic(axis));
    layout.repeating(periodic).ok_or_else(|| {
        let problem =
            "needs shape linear, ugimp or cpgimp, and along a periodic axis at least 3 cells (cpgimp: 5)";
        CaseError::new("domain.periodic", problem)
    })
}

/// The solver of a case.
struct Build<'a> {
    case: &'a Case,
    options: &'a MpmOptions,
}

impl dispatch::Visitor for Build<'_> {
    type Output = Result<Box<dyn Solver>, CaseError>;

    fn visit<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>>(self) -> Self::Output {
        Ok(Box::new(solver::<D, S, B, P>(self.case, self.options)?))
    }
}

/// Memory of a grid node (bytes).
pub fn bytes_of_node(phases: usize, contacts: bool) -> usize {
    phases * size_of::<Node>() + 32 * if contacts { 2 } else { phases }
}

/// What would be solved.
struct Measure<'a> {
    case: &'a Case,
    options: &'a MpmOptions,
}

impl dispatch::Visitor for Measure<'_> {
    type Output = Result<Plan, CaseError>;

    fn visit<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>>(self) -> Self::Output {
        let mut solver = solver::<D, S, B, P>(self.case, self.options)?;
        let time_step = solver.critical_step();
        let points = solver.points();
        let duration: f64 = self.case.stages.iter().map(|stage| stage.duration).sum();
        let nodes = solver.layout.len() * solver.contacts.fields();
        let phases = if solver.two_phase.is_some() { 2 } else { 1 };
        let mut per_node = bytes_of_node(phases, solver.contacts.fields() > 1);
        per_node += if solver.dual.is_used() { DualNodes::BYTES } else { 0 };
        per_node += if solver.consistent.is_used() { ConsistentMass::BYTES } else { 0 };
        let mut volumes = vec![0.0; self.case.bodies.len()];
        for set in &solver.sets {
            volumes[set.body as usize] += set.initial_volume.iter().sum::<f64>();
        }
        let of_points = solver.sets.iter().map(PointSet::bytes).sum::<usize>();
        let mut warnings = warnings(self.case, self.options, points);
        for patch in solver.empty_patches() {
            warnings.push(format!("patches[{patch}].region: holds no node at the start"));
        }
        if time_step.limit == StepLimit::SeepageDrag {
            // MPM sheet P-13.
            warnings.push(format!(
                "pore_fluid: the drag of so low a permeability limits the step, to {:.2e} s; where no fluid leaves in \
                 the time considered use the material `undrained`",
                time_step.dt
            ));
        }
        Ok(Plan {
            points,
            nodes,
            steps: (duration / time_step.dt).ceil() as u64,
            time_step,
            memory: (of_points + points * SORTING + nodes * per_node) as u64,
            volumes,
            updates_per_second: PACE[usize::from(D == 3)] / phases as f64,
            warnings,
        })
    }
}

/// Courant number at which stress last is stable with splines at sides of the domain that nothing holds, where the end
/// functions are steep: 0.5 was not, in two and three dimensions, and 0.45 only just.
const OPEN_SIDE: f64 = 0.4;

/// Sides of the domain that bodies reach and no wall holds for good, with steps that are not stable there.
fn open_sides(case: &Case, options: &MpmOptions) -> Vec<String> {
    let spline = matches!(options.shape, ShapeFunctions::Quadratic | ShapeFunctions::Cubic);
    if !spline || options.stress_update != StressScheme::Usl || options.courant <= OPEN_SIDE {
        return Vec::new();
    }
    let last = case.active_boundaries(case.stages.len());
    let held = |axis: usize, upper: bool| {
        last.iter().any(|(_, boundary)| {
            boundary.side.axis() == axis
                && boundary.side.is_max() == upper
                && boundary.position.is_none()
                && !matches!(boundary.wall, CaseWall::Absorbing { .. })
        })
    };
    let mut found = Vec::new();
    for (number, body) in case.bodies.iter().enumerate() {
        let (low, high) = body.shape.bounds(case.dimension());
        for axis in (0..case.dimension()).filter(|axis| !case.domain.is_periodic(*axis)) {
            let reach = 0.5 * options.cell_size;
            let lower = low[axis] - case.domain.min[axis] < reach
                && !(axis == 0 && case.space == Space::Axisymmetric);
            for (upper, reaches) in [(false, lower), (true, case.domain.max[axis] - high[axis] < reach)] {
                if reaches && !held(axis, upper) {
                    let side = format!("{}-{}", ["x", "y", "z"][axis], if upper { "max" } else { "min" });
                    found.push(format!(
                        "bodies[{number}]: reaches the side {side} of the domain, which no wall holds for good: there splines with usl \
                         are stable up to a courant of {OPEN_SIDE} only; make the domain a cell larger, or use musl"
                    ));
                }
            }
        }
    }
    found
}

fn warnings(case: &Case, options: &MpmOptions, points: usize) -> Vec<String> {
    let mut warnings = case.warnings();
    let dimension = case.dimension() as u32;
    let wanted = if dimension == 3 { 8 } else { 2usize.pow(dimension) };
    let per_cell = options.points_per_cell.pow(dimension);
    if per_cell < wanted {
        warnings.push(format!(
            "methods.mpm.points_per_cell: {per_cell} points per cell; fewer than {wanted} under-sample the grid"
        ));
    }
    if options.shape == ShapeFunctions::Linear && points > 0 {
        warnings.push(
            "methods.mpm.shape: linear shape functions make noise when points cross cells; \
             refining the grid makes it worse"
                .to_owned(),
        );
    }
    let jumps = matches!(options.shape, ShapeFunctions::Linear | ShapeFunctions::DualDomain);
    let steep = 0.5 * options.courant * options.courant;
    if jumps && options.stress_update == StressScheme::Usl && options.node_mass_cutoff < 0.99 * steep {
        warnings.push(format!(
            "methods.mpm.stress_update: usl with linear shape functions (dual-domain too) can turn points inside out at free \
             surfaces; use musl, ugimp, or a node_mass_cutoff of {steep:.3}, half the square of courant"
        ));
    }
    if options.step_criterion == StepCriterion::Simple {
        warnings.push(
            "methods.mpm.step_criterion: simple is not safe: steps may be longer than what drag and the fast wave of both phases \
             allow; with combined they are not"
                .to_owned(),
        );
    }
    let stable = options.surface_courant(case.dimension());
    // Without a word the default is what it can be.
    if options.courant > stable.max(COURANT) {
        warnings.push(format!(
            "methods.mpm.courant: with usl and this shape more than {stable:.3} is not stable at free surfaces; steps are made \
             with that"
        ));
    }
    warnings.extend(open_sides(case, options));
    let rubs = |boundary: &Boundary| matches!(boundary.wall, CaseWall::Frictional { .. });
    if options.wall_friction != WallFriction::default() && !case.boundaries.iter().any(rubs) {
        warnings.push("methods.mpm.wall_friction: has no effect, no wall is frictional".to_owned());
    }
    for (number, stage) in case.stages.iter().enumerate() {
        if options.mass_scaling > 1.0 && stage.equilibrium.is_none() {
            warnings.push(format!(
                "methods.mpm.mass_scaling: slows the motion of stages[{number}], which has no `equilibrium`; it is \
                 for quasi-static stages"
            ));
        }
        if options.integration == Integration::Gauss && stage.equilibrium.is_none() {
            warnings.push(format!(
                "methods.mpm.integration: with gauss cells that are filled in part pull as if they were full; \
                 stages[{number}] has no `equilibrium`, and it is for quasi-static stages"
            ));
        }
        let seeps = case.bodies.iter().any(|body| body.pore_fluid.is_some());
        if seeps && (stage.damping > 0.0 || options.mass_scaling > 1.0) && stage.equilibrium.is_some() {
            warnings.push(format!(
                "stages[{number}]: local damping and mass scaling slow consolidation; at rest the state is right, the time \
                 it takes is not"
            ));
        }
        if stage.damping > 0.0 && stage.equilibrium.is_none() {
            warnings.push(format!(
                "stages[{number}].damping: local damping in a stage without `equilibrium` also slows real motion"
            ));
        }
    }
    warnings
}

/// The solver of `case`.
pub fn build(case: &Case) -> Result<Box<dyn Solver>, CaseError> {
    let options = options(case)?;
    dispatch::dispatch(case, &options, Build { case, options: &options })
}

/// The plan of `case`.
pub fn plan(case: &Case) -> Result<Plan, CaseError> {
    let options = options(case)?;
    dispatch::dispatch(case, &options, Measure { case, options: &options })
}

/// A solver with its concrete type, at time zero.
pub fn solver<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>>(
    case: &Case,
    options: &MpmOptions,
) -> Result<MpmSolver<D, S, B, P>, CaseError> {
    let (grid, mesh, layout) = mesh::terrain::<D, S, B>(case, options)?;
    for stage in 0..case.stages.len() {
        walls::walls::<D, S, B>(case, stage, &Ground { grid: &grid, mesh: &mesh }, &layout, options)?;
    }
    if options.formulation == Formulation::TotalLagrangian {
        case.refuse_driven("the total-Lagrangian formulation of mpm")?;
        case.refuse_dropping("the total-Lagrangian formulation of mpm")?;
    }
    let driven = driven::driven(case);
    let ground = Ground { grid: &grid, mesh: &mesh };
    let two_phase = two_phase::two_phase(case, options, &layout);
    let mut sets = Vec::new();
    let mut next = 0;
    for number in 0..case.bodies.len() {
        let mut set = point_set::<D, P>(case, options, &ground, number, next)?;
        next += set.len();
        set.rigid = case.bodies[number].rigid.then(|| rigid_number(&driven, &case.bodies[number])).flatten();
        sets.push(set);
    }
    let contacts = contact::contacts(case, options, &mut sets)?;
    mixed::resettable(case, options, &sets)?;
    let elements = P::MESHED.then(|| Layout::of_elements(&mesh, &grid));
    let cells = elements.as_ref().unwrap_or(&layout);
    let strains = CellStrains::new(case, options, [&layout, cells]);
    let stresses = CellStresses::new(options, cells, contacts.fields());
    let dual = DualNodes::new(options, &layout, contacts.fields());
    let consistent = ConsistentMass::new(options, &layout);
    let nodal = nodal::nodal_loads::<D, S, B, P>(case, options, &ground, &layout, &sets)?;
    for number in 0..case.loads.len() {
        if case.loads[number].carrier() == LoadCarrier::Points {
            loads::apply(case, number, &mesh, &mut sets)?;
        }
    }
    let absorbs = case.boundaries.iter().position(|b| matches!(b.wall, CaseWall::Absorbing { .. }));
    let impedances = absorbs
        .map_or_else(Vec::new, |_| sets.iter().map(|set| Impedance::of(set, options.mass_scaling)).collect());
    if let (Some(number), true) = (absorbs, contacts.fields() > 1) {
        let problem = "an absorbing boundary is not available with contacts";
        return Err(CaseError::new(format!("boundaries[{number}].wall"), problem));
    }
    let free_surface = free_surface::free_surface(case, options, &grid, &layout, elements.as_ref())?;
    let own_nodes = if two_phase.is_none() { contacts.fields() * layout.len() } else { 0 };
    let mut solver = MpmSolver {
        case: Arc::new(case.clone()),
        options: options.clone(),
        flip: options.flip_share(&case.stages[0]),
        nodes: vec![Node::default(); own_nodes],
        remapped: Vec::new(),
        row_sums: vec![RowSums::default(); layout.nodes()[0]],
        walls: Walls::default(),
        upper: grid.upper(),
        closed: [[false; 2]; D],
        periodic: std::array::from_fn(|axis| case.domain.is_periodic(axis)),
        layout,
        elements,
        grid,
        mesh,
        strains,
        stresses,
        dual,
        consistent,
        sets,
        contacts,
        load_starts: loads::starts(case),
        nodal,
        driven,
        axisymmetric: case.space == Space::Axisymmetric,
        gravity: case.gravity3(),
        stage: 0,
        stage_start: 0.0,
        time: 0.0,
        step: 0,
        travel: 0.0,
        heaviest: 0.0,
        left: Box::default(),
        limit: None,
        limit_age: 0,
        sums: RowSums::default(),
        external_work: 0.0,
        two_phase,
        manufactured: None,
        free_surface,
        absorbing: Absorbing::default(),
        impedances,
        basis: PhantomData,
    };
    // XPIC sweeps over the same nodes before they hold re-mapped velocities.
    if options.stress_update != StressScheme::Usl || options.transfer == Transfer::Xpic {
        solver.remapped = vec![Default::default(); solver.nodes.len()];
    }
    if solver.contacts.fields() > 1 {
        solver.contacts.surfaces = vec![Default::default(); solver.nodes.len()];
        solver.contacts.rows =
            crate::touch::rows(&solver.contacts, solver.row_sums.len(), solver.layout.strides()[0]);
        if solver.axisymmetric {
            solver.contacts.radii = solver.radii();
        }
        if P::MESHED {
            solver.contacts.filled = filled_on_mesh(&solver.mesh, solver.layout.len());
        } else {
            solver.contacts.filled = filled::<D, S, B>(&solver.grid, &solver.layout, options.points_per_cell);
            solver.contacts.distance = SurfaceDistance::new::<S, B>();
        }
    }
    walls::refuse_walls_that_leave(case, if P::MESHED { solver.mesh.height() } else { solver.grid.cell })?;
    solver.remember_starts();
    solver.set_stage_walls(0)?;
    solver.sort();
    solver.start_affine();
    if case.measures_dissipation() {
        solver.count_work();
    }
    check_fixed_step(&solver, options)?;
    Ok(solver)
}

fn rigid_number(driven: &[Driven], body: &Body) -> Option<usize> {
    driven.iter().position(|driven| driven.patch.is_none() && driven.name == body.name)
}

fn check_fixed_step<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>>(
    solver: &MpmSolver<D, S, B, P>,
    options: &MpmOptions,
) -> Result<(), CaseError> {
    match options.time_step.and_then(|step| solver.wave_limit(1.0).too_long(Some(step))) {
        Some(problem) => Err(CaseError::new("methods.mpm.time_step", problem)),
        None => Ok(()),
    }
}

fn point_set<const D: usize, P: PointDomain<D>>(
    case: &Case,
    options: &MpmOptions,
    ground: &Ground<'_, D>,
    number: usize,
    first_id: usize,
) -> Result<PointSet<D, P>, CaseError> {
    let body = &case.bodies[number];
    let path = format!("bodies[{number}]");
    let listed = case.point_list(number)?;
    let samples = samples(options, ground, (body, listed.as_ref()), &path, first_id)?;
    let spec = &case.materials[&body.material];
    let material: Arc<dyn Material> = spec
        .build()
        .map_err(|error| CaseError::new(format!("materials.{}", body.material), error.to_string()))?;
    let position: Vec<[f64; D]> = samples.iter().map(|sample| sample.position).collect();
    let radial = |x: &[f64; D]| if case.space == Space::Axisymmetric { x[0] } else { 1.0 };
    let volume: Vec<f64> = samples.iter().map(|sample| sample.volume * radial(&sample.position)).collect();
    let density = spec.density();
    let initial: Vec<InitialCondition> = position
        .iter()
        .enumerate()
        .map(|(point, x)| InitialCondition {
            stress: case.initial_stress_of(body, listed.as_ref(), point, spatial(x)),
            density,
        })
        .collect();
    let pore = two_phase::pore_set(case, body, &position);
    let (stress, states) = material.initial(&initial).map_err(|error| {
        let place = &position[error.index];
        CaseError::new(format!("{path}.stress"), format!("at {place:?} m: {}", error.source))
    })?;
    let velocity_at = |(point, x): (usize, &[f64; D])| {
        let own = listed.as_ref().and_then(|list| Some(list.velocities.as_ref()?[point]));
        let velocity = own.unwrap_or_else(|| body.velocity.at(spatial(x)));
        std::array::from_fn(|c| velocity[c])
    };
    let follows_later = P::STRETCHES && options.stress_update == StressScheme::Usf;
    Ok(PointSet {
        body: number as u32,
        field: 0,
        rigid: None,
        material,
        extent: [width(ground, options, &samples, listed.is_some()); D],
        id: (first_id as u32..(first_id + position.len()) as u32).collect(),
        velocity: position.iter().enumerate().map(velocity_at).collect(),
        mass: volume.iter().map(|v| v * density).collect(),
        initial_volume: volume.clone(),
        volume,
        stress,
        states,
        origin: position.clone(),
        domain: domains(ground, &position, &path)?,
        affine: if options.transfer.is_affine() { vec![[[0.0; D]; D]; position.len()] } else { Vec::new() },
        scratch: if options.transfer == Transfer::Xpic { vec![[0.0; D]; position.len()] } else { Vec::new() },
        position,
        loads: Vec::new(),
        traction: Vec::new(),
        work: Vec::new(),
        pending: if follows_later { vec![[[0.0; D]; D]; samples.len()] } else { Vec::new() },
        pore,
        slabs: Vec::new(),
    })
}

fn domains<const D: usize, P: PointDomain<D>>(
    ground: &Ground<'_, D>,
    position: &[[f64; D]],
    path: &str,
) -> Result<Vec<P>, CaseError> {
    let mut domains = vec![P::default(); position.len()];
    for (domain, x) in domains.iter_mut().zip(position) {
        let placed = domain.start(ground, x);
        placed.map_err(|reason| {
            CaseError::new(format!("{path}.shape"), format!("the point at {x:?} m: {reason}"))
        })?;
    }
    Ok(domains)
}

/// Full width of every point of a body (m); in elements, and of points that are `listed`, the mean one of squares or cubes of
/// their volume.
fn width<const D: usize>(
    ground: &Ground<'_, D>,
    options: &MpmOptions,
    samples: &[Sample<D>],
    listed: bool,
) -> f64 {
    if ground.mesh.is_empty() && !listed {
        return ground.grid.cell / options.points_per_cell as f64;
    }
    let volume = samples.iter().map(|sample| sample.volume).sum::<f64>() / samples.len() as f64;
    // Shape functions reach no farther than points as wide as a cell.
    let width = volume.powf(1.0 / D as f64);
    if listed { width.min(ground.grid.cell) } else { width }
}

fn samples<const D: usize>(
    options: &MpmOptions,
    ground: &Ground<'_, D>,
    (body, listed): (&Body, Option<&PointList>),
    path: &str,
    first_id: usize,
) -> Result<Vec<Sample<D>>, CaseError> {
    let grid = ground.grid;
    let samples = if let Some(list) = listed {
        let spacing = list.spacing(D);
        if spacing > (1.0 + 1e-9) * grid.cell {
            let problem = format!(
                "the points are {spacing:.4e} m wide on the mean, more than the cells of {} m",
                grid.cell
            );
            return Err(CaseError::new(format!("{path}.points"), problem));
        }
        list.samples()
    } else if ground.mesh.is_empty() {
        colluvium_points::per_cell(&body.shape, grid.origin, grid.cell, options.points_per_cell)
            .map_err(|error| CaseError::new(format!("{path}.shape"), error.to_string()))?
    } else {
        mesh::samples(ground.mesh, options, body)
    };
    if samples.is_empty() {
        let problem = format!("holds no point: it is smaller than the cells of {} m", grid.cell);
        return Err(CaseError::new(format!("{path}.shape"), problem));
    }
    if first_id + samples.len() > MOST_POINTS {
        return Err(CaseError::new("methods.mpm.cell_size", format!("gives more than {MOST_POINTS} points")));
    }
    if let Some(outside) = samples.iter().find(|sample| !grid.contains(&sample.position)) {
        let problem = format!("the point at {:?} m lies outside the domain", outside.position);
        return Err(CaseError::new(format!("{path}.shape"), problem));
    }
    Ok(samples)
}

impl<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>> MpmSolver<D, S, B, P> {
    /// Takes the walls of a stage, of all phases.
    pub(crate) fn set_stage_walls(&mut self, stage: usize) -> Result<(), CaseError> {
        let walls = |case: &Case| -> Result<Walls, CaseError> {
            let mut walls =
                walls::walls::<D, S, B>(case, stage, &ground!(self), &self.layout, &self.options)?;
            walls.set_off(self.step == 0);
            Ok(walls)
        };
        let own = walls(&self.case)?;
        let of_liquid =
            self.two_phase.is_some().then(|| walls(&two_phase::of_liquid(&self.case))).transpose()?;
        if let (Some(phases), Some(of_liquid)) = (&mut self.two_phase, of_liquid) {
            phases.walls = of_liquid;
        }
        self.set_walls(own);
        self.set_absorbing(stage);
        Ok(())
    }
}
