//! Setup of a solver from a case; rejects unsupported features, by JSON path.

mod body_points;
mod capabilities;
pub(crate) mod manufactured;
mod point_changes;

use std::any::Any;
use std::sync::Arc;

use colluvium_case::{
    Case, CaseError, CaseErrorKind, Manufactured, OVERLAP_TOLERANCE, Plan, ProblemSize, Resolution, Solver,
    StepLimit, TimeStep,
};
use colluvium_grid::{NodalState, Transfers};

pub(crate) use crate::setup::capabilities::capabilities;

use crate::background_grid::{BackgroundGrid, shape_function_kind};
use crate::config::{NAME, SnowOptions};
use crate::momentum::{GridNodes, MomentumTerms};
use crate::obstacles::node_obstacles::NodeObstacles;
use crate::output::energy_balance::EnergyBalance;
use crate::output::hazard_rasters::HazardRasters;
use crate::points::bodies::{Bodies, BodyPoints};

use crate::boundary::walls::BoundaryConditions;
use crate::solver::{Clock, RestChecks, SnowSolver};

/// Point updates per second and thread in the plane and in space, with cubic functions and APIC.
const UPDATES_PER_SECOND: [f64; 2] = [2.5e6, 0.8e6];

/// Returns an error at a key of the options.
pub(crate) fn option_error(key: &str, kind: impl Into<CaseErrorKind>) -> CaseError {
    CaseError::new(format!("methods.{NAME}.{key}"), kind)
}

/// Returns the checked options of the case.
pub(crate) fn options(case: &Case) -> Result<SnowOptions, CaseError> {
    if !case.methods.contains_key(NAME) {
        let problem = "is missing: finite-strain MPM needs at least its `cell_size` (m)";
        return Err(CaseError::new(format!("methods.{NAME}"), CaseErrorKind::missing_input(NAME, problem)));
    }
    let options: SnowOptions = case.method_options(NAME)?;
    options.validate().map_err(|(key, problem)| option_error(key, problem))?;
    Ok(options)
}

/// Solver of a case, with a manufactured solution if one is given.
pub(crate) fn build(case: &Case, solution: Option<Manufactured>) -> Result<Box<dyn Solver>, CaseError> {
    match case.dimension() {
        1 => build_in::<1>(case, solution),
        2 => build_in::<2>(case, solution),
        _ => build_in::<3>(case, solution),
    }
}

/// Solver of a case of `D` dimensions, with its type.
pub(crate) fn typed_solver<const D: usize>(case: &Case) -> Result<SnowSolver<D>, CaseError> {
    let options = options(case)?;
    let shape = shape_function_kind(options.shape);
    let solver: Box<dyn Any> = match case.dimension() {
        1 => Box::new(solver(case, &options, shape.on_line())?),
        2 => Box::new(solver(case, &options, shape.in_plane())?),
        _ => Box::new(solver(case, &options, shape.in_space())?),
    };
    let other_dimension = |_| CaseError::new("space", format!("has not {D} dimensions"));
    solver.downcast().map(|solver| *solver).map_err(other_dimension)
}

/// Solver of a case of `D` dimensions, in the initial state of a manufactured solution if one is given.
fn build_in<const D: usize>(
    case: &Case,
    solution: Option<Manufactured>,
) -> Result<Box<dyn Solver>, CaseError> {
    let mut solver = typed_solver::<D>(case)?;
    if let Some(solution) = solution {
        solver.begin_manufactured(solution)?;
    }
    Ok(Box::new(solver))
}

/// Plan of `case`.
pub(crate) fn plan(case: &Case) -> Result<Plan, CaseError> {
    let options = options(case)?;
    let shape = shape_function_kind(options.shape);
    match case.dimension() {
        1 => plan_in(case, &options, shape.on_line()),
        2 => plan_in(case, &options, shape.in_plane()),
        _ => plan_in(case, &options, shape.in_space()),
    }
}

/// Size of `case`, estimated without its points.
pub(crate) fn problem_size(case: &Case) -> Result<ProblemSize, CaseError> {
    let options = options(case)?;
    let dimension = case.dimension();
    let apart = options.cell_size / options.points_per_cell as f64;
    let points = case.point_counts(apart);
    let cells = |axis: usize| (case.domain.max[axis] - case.domain.min[axis]) / options.cell_size;
    let nodes: f64 = (0..dimension).map(|axis| cells(axis) + 11.0).product();
    let number = size_of::<f64>();
    // Columns of the points, and the memory to sort their moments.
    let own = (3 * dimension + 2 * dimension * dimension + 9) * number + 4;
    let mut memory = nodes * size_of::<NodalState>() as f64;
    for (body, points) in case.bodies.iter().zip(&points) {
        let path = || format!("materials.{}", body.material);
        let law = case.materials[&body.material].build();
        let state = law.map_err(|error| CaseError::new(path(), error))?.state_size();
        memory += points * (own + 2 * state + 16) as f64;
    }
    Ok(ProblemSize {
        points: points.iter().sum(),
        nodes,
        memory,
        case_key: "methods.snow-mpm.cell_size",
        ..ProblemSize::default()
    })
}

/// Compiled transfers of the selected shape functions; `None` if there are none for this dimension.
type SelectedTransfers<const D: usize> = Option<&'static dyn Transfers<D>>;

/// Plan of a case: number of points, steps and memory.
fn plan_in<const D: usize>(
    case: &Case,
    options: &SnowOptions,
    chosen: SelectedTransfers<D>,
) -> Result<Plan, CaseError> {
    let mut solver = solver(case, options, chosen)?;
    let time_step = solver.limit();
    let mut volumes = vec![0.0; case.bodies.len()];
    for body in &solver.bodies.bodies {
        volumes[body.number as usize] += body.points.volume.iter().sum::<f64>();
    }
    let memory = solver.bodies.bodies.iter().map(BodyPoints::bytes).sum::<usize>() + solver.nodes.bytes();
    Ok(Plan {
        points: solver.bodies.len(),
        nodes: solver.background.layout.len(),
        steps: (case.end_time() / time_step.dt).ceil() as u64,
        time_step,
        memory: memory as u64,
        volumes,
        grains: None,
        densities: None,
        resolution: Some(Resolution {
            width: options.cell_size,
            point_distance: options.cell_size / options.points_per_cell as f64,
            axes: D,
            case_key: "methods.snow-mpm.cell_size",
            noun: "cells",
        }),
        updates_per_second: UPDATES_PER_SECOND[usize::from(D == 3)],
        warnings: capabilities::warnings(case, options),
    })
}

/// Returns the background with the periodic axes of the domain.
fn periodic_background<const D: usize>(
    case: &Case,
    background: BackgroundGrid<D>,
) -> Result<BackgroundGrid<D>, CaseError> {
    let periodic = std::array::from_fn(|axis| case.domain.is_periodic(axis));
    background.with_periodic_axes(periodic).map_err(|smallest| {
        let problem = format!(
            "needs {smallest} cells or more along each periodic axis, because shape functions extend that far \
             beyond its sides"
        );
        CaseError::new("domain.periodic", CaseErrorKind::coded("needs-other-key", problem))
    })
}

/// Clock at the start of the first stage.
fn initial_clock() -> Clock {
    Clock {
        stage: 0,
        stage_start: 0.0,
        time: 0.0,
        step: 0,
        limit: TimeStep { dt: f64::INFINITY, limit: StepLimit::NO_MOTION, point: None, position: [0.0; 3] },
        sums: MomentumTerms::default(),
        external_work: 0.0,
        rest_checks: RestChecks::default(),
    }
}

/// Returns a solver with its concrete type, at time zero.
fn solver<const D: usize>(
    case: &Case,
    options: &SnowOptions,
    chosen: SelectedTransfers<D>,
) -> Result<SnowSolver<D>, CaseError> {
    let sweeps = chosen.ok_or_else(|| {
        option_error(
            "shape",
            CaseErrorKind::coded("wrong-dimension", "is not available in so many dimensions"),
        )
    })?;
    let corner = |values: &[f64]| std::array::from_fn(|axis| values[axis]);
    let corners = [corner(&case.domain.min), corner(&case.domain.max)];
    capabilities::check_layer_thickness(case, options)?;
    crate::solver::saw_test::check_saw_tests(case)?;
    let background = BackgroundGrid::new(corners, options.cell_size, sweeps)
        .map_err(|error| option_error("cell_size", CaseErrorKind::coded(error.code(), error.to_string())))?;
    let background = periodic_background(case, background)?;
    let standing = case.placed_obstacles::<D>()?;
    let mut all = Vec::new();
    let mut next = 0;
    for number in 0..case.bodies.len() {
        let listed = case.point_list(number)?;
        let body = body_points::body_points(case, options, &background, (number, listed.as_ref()), next)?;
        next += body.points.len();
        let slack = OVERLAP_TOLERANCE * options.cell_size;
        case.reject_overlapping_points(&standing, number, &body.points.position, slack)?;
        all.push(body);
    }
    let obstacles = NodeObstacles::new(case, &standing, &background)?;
    let mut solver = SnowSolver {
        case: Arc::new(case.clone()),
        options: options.clone(),
        nodes: GridNodes::new(&background.layout),
        boundaries: BoundaryConditions::new(case, 0, &background, Arc::new(obstacles.static_faces().clone())),
        obstacles,
        background,
        bodies: Bodies::new(all),
        energy_balance: EnergyBalance::default(),
        hazard_rasters: HazardRasters::of_case(case, options.cell_size)?,
        manufactured_solution: None,
        body_force: None,
        energies_before_changes: None,
        cut_bounds: case.removal_shapes.iter().map(|cut| cut.bounds(D)).collect(),
        clock: initial_clock(),
    };
    solver.bodies.sort(&mut solver.background);
    solver.energy_balance = EnergyBalance::new(&solver.stored_energies(), case.removal_shapes.len());
    solver.update_step_bounds();
    if let Some(maps) = &mut solver.hazard_rasters {
        maps.update(&solver.bodies, 0.0);
    }
    match solver.clock.limit.fixed_step_problem(options.time_step) {
        Some(problem) => Err(option_error("time_step", problem)),
        None => Ok(solver),
    }
}
