//! Construction of a solver from a case: refuses unsupported features, by JSON path.

mod band_checks;
mod bodies;
mod capabilities;
mod defaults;
mod point_changes;
pub mod rates_only;

use std::f64::consts::PI;
use std::sync::Arc;

use colluvium_case::{Capabilities, Case, CaseError, CaseErrorKind, Plan, ProblemSize, Resolution, Solver};

use crate::config::{ConfiningPressureTarget, ContinuityEquation, LagrangianFormulation, SphOptions};
use crate::context::{SolverContext, leading_components};
use crate::kernel::Smoothing;
use crate::momentum::confining_pressure::surface_detection_problem;
use crate::points::body_loads::{BodyLoads, LoadedBody};
use crate::points::particles::{Bodies, ParticleGroup};
use crate::ranks::RankedSolver;
use crate::setup::band_checks::check_bands;
use crate::setup::capabilities::{check_stress_forms, check_supported, warnings};
use crate::solver::SphSolver;
use crate::stress::total_lagrangian::TotalLagrangianReference;
use crate::walls::{ObstacleFaces, Walls, check_walls, flat_walls, has_friction, wall_particle_count};
use bodies::{add_body, check_distances};

/// Largest relative error of the summed density of a particle. Full supports have up to 2 %
/// (sheet: sph §2.2); beside a free surface it is 13 % or more.
const DENSITY_TOLERANCE: f64 = 0.1;

/// Largest depth of particles in an obstacle at the start, in spacings.
const OVERLAP_TOLERANCE: f64 = 1e-6;

/// Time to place a wall particle (s).
const PLACING_TIME: f64 = 3e-7;

/// Options of the case, checked.
pub fn options(case: &Case) -> Result<SphOptions, CaseError> {
    if !case.methods.contains_key("sph") {
        let problem = "is missing: smoothed particle hydrodynamics needs at least its `spacing` (m)";
        return Err(CaseError::new("methods.sph", CaseErrorKind::missing_input("sph", problem)));
    }
    let mut options: SphOptions = case.method_options("sph")?;
    defaults::set_case_defaults(case, &mut options);
    options.validate().map_err(|(name, problem)| CaseError::new(format!("methods.sph.{name}"), problem))?;
    Ok(options)
}

/// Capabilities of SPH for the features of `case`.
pub fn capabilities(case: &Case) -> Result<Capabilities, CaseError> {
    Ok(capabilities::capabilities(&options(case)?))
}

/// Returns the solver of `case`.
pub fn build(case: &Case) -> Result<Box<dyn Solver>, CaseError> {
    let options = options(case)?;
    Ok(match case.dimension() {
        1 => boxed_solver::<1>(case, &options)?,
        2 => boxed_solver::<2>(case, &options)?,
        _ => boxed_solver::<3>(case, &options)?,
    })
}

/// Solver of a case of `D` dimensions, with its type.
///
/// # Errors
/// The first unsupported part of the case; more than one rank; a case of other dimensions.
pub fn typed_solver<const D: usize>(case: &Case) -> Result<SphSolver<D>, CaseError> {
    let options = options(case)?;
    if case.dimension() != D {
        return Err(CaseError::new("space", format!("has not {D} dimensions")));
    }
    if options.ranks > 1 {
        let problem = format!(
            "{} ranks are available in a run only, not in a solver that a program steps",
            options.ranks
        );
        return Err(CaseError::new("methods.sph.ranks", problem));
    }
    solver(case, &options)
}

/// Solver of a case in `D` dimensions, distributed over ranks.
fn boxed_solver<const D: usize>(case: &Case, options: &SphOptions) -> Result<Box<dyn Solver>, CaseError> {
    Ok(distributed_solver(solver::<D>(case, options)?, options.ranks))
}

/// Returns a solver with its particles distributed over `ranks`.
pub fn distributed_solver<const D: usize>(whole: SphSolver<D>, ranks: u32) -> Box<dyn Solver> {
    match ranks {
        1 => Box::new(whole),
        ranks => Box::new(RankedSolver::new(whole, ranks as usize)),
    }
}

/// Plan of `case`.
pub fn plan(case: &Case) -> Result<Plan, CaseError> {
    let options = options(case)?;
    match case.dimension() {
        1 => build_plan::<1>(case, &options),
        2 => build_plan::<2>(case, &options),
        _ => build_plan::<3>(case, &options),
    }
}

/// Problem size of `case`, without its particles.
pub fn problem_size(case: &Case) -> Result<ProblemSize, CaseError> {
    let options = options(case)?;
    let points = case.point_counts(options.spacing);
    let mut states = 0.0;
    for (body, points) in case.bodies.iter().zip(&points) {
        let path = || format!("materials.{}", body.material);
        let law = case.materials[&body.material].build();
        let size = law.map_err(|error| CaseError::new(path(), error))?.state_size();
        states += points * bytes_of_state(size) as f64;
    }
    let points = points.iter().sum();
    match case.dimension() {
        1 => problem_size_in::<1>(case, &options, points, states),
        2 => problem_size_in::<2>(case, &options, points, states),
        _ => problem_size_in::<3>(case, &options, points, states),
    }
}

/// Size of a problem with `points` particles, `states` bytes of material states, and wall particles according to the domain.
fn problem_size_in<const D: usize>(
    case: &Case,
    options: &SphOptions,
    points: f64,
    states: f64,
) -> Result<ProblemSize, CaseError> {
    let walls = wall_particle_count::<D>(case, options, smoothing::<D>(options)?.radius());
    let memory = points * bytes_each::<D>(options)? + states + walls * source_bytes(D) as f64;
    let (case_key, cure) = if walls > points {
        ("domain", "most of them are wall particles: make the domain smaller, or the spacing larger")
    } else {
        ("methods.sph.spacing", "")
    };
    Ok(ProblemSize {
        points: points + walls,
        memory,
        case_key,
        placing_time: walls * PLACING_TIME,
        advice: cure,
        ..ProblemSize::default()
    })
}

/// Kernel and smoothing length of the options.
fn smoothing<const D: usize>(options: &SphOptions) -> Result<Smoothing<D>, CaseError> {
    Smoothing::<D>::new(options.kernel, options.smoothing_length_value()).map_err(|error| {
        CaseError::new("methods.sph.kernel", CaseErrorKind::coded(error.code(), error.to_string()))
    })
}

/// Memory (bytes) of the neighbour data of a particle or wall particle.
const fn source_bytes(dimension: usize) -> usize {
    (2 * dimension + 12 + 16) * size_of::<f64>()
}

/// Memory of a particle without neighbours and material state (bytes), with sort buffers.
const fn particle_bytes(dimension: usize) -> usize {
    (5 * dimension + 2 * dimension * dimension + 8) * size_of::<f64>() + 16
}

/// Memory (bytes) of a law state of `size` (bytes): doubled for the reordering of particles.
const fn bytes_of_state(size: usize) -> usize {
    2 * size
}

/// Memory (bytes) of the neighbours of a particle: each is a number and a weight.
fn bytes_neighbours(radius: f64, spacing: f64, dimension: usize) -> f64 {
    let unit_ball = [2.0, PI, 4.0 / 3.0 * PI][dimension - 1];
    12.0 * unit_ball * (1.1 * radius / spacing).powi(dimension as i32)
}

/// Memory of a particle (bytes).
fn bytes_each<const D: usize>(options: &SphOptions) -> Result<f64, CaseError> {
    let neighbours = bytes_neighbours(smoothing::<D>(options)?.radius(), options.spacing, D);
    Ok((source_bytes(D) + particle_bytes(D)) as f64 + neighbours)
}

/// Plan of a case in `D` dimensions: number of particles, steps and memory.
fn build_plan<const D: usize>(case: &Case, options: &SphOptions) -> Result<Plan, CaseError> {
    let mut solver = solver::<D>(case, options)?;
    let time_step = solver.critical_step();
    let (points, walls) = (solver.bodies.particles.len(), solver.walls.planes.particles.len());
    let (acting, own) = (source_bytes(D), particle_bytes(D));
    let neighbours = bytes_neighbours(solver.setting.smoothing.radius(), options.spacing, D);
    let states =
        |group: &ParticleGroup| (group.end - group.start) * bytes_of_state(group.material.state_size());
    let states = solver.bodies.groups.iter().map(states).sum::<usize>() as u64;
    let mut volumes = vec![0.0; case.bodies.len()];
    for group in &solver.bodies.groups {
        let mass = solver.bodies.particles.mass[group.range()].iter().sum::<f64>();
        volumes[group.body as usize] += mass / group.density;
    }
    Ok(Plan {
        points,
        nodes: 0,
        steps: (case.end_time() / time_step.dt).ceil() as u64,
        time_step,
        memory: ((points + walls) * acting + points * own) as u64
            + (points as f64 * neighbours) as u64
            + states,
        volumes,
        grains: None,
        densities: None,
        resolution: Some(Resolution {
            width: options.spacing,
            point_distance: options.spacing,
            axes: D,
            case_key: "methods.sph.spacing",
            noun: "spacings",
        }),
        updates_per_second: if D == 3 { 8e5 } else { 3e6 },
        warnings: warnings(case, options),
    })
}

/// Returns a solver of concrete type, at time zero.
pub fn solver<const D: usize>(case: &Case, options: &SphOptions) -> Result<SphSolver<D>, CaseError> {
    check_supported(case, options)?;
    check_bands::<D>(case, options)?;
    let smoothing = smoothing::<D>(options)?;
    let on_surface =
        options.confining.as_ref().is_some_and(|confining| confining.on == ConfiningPressureTarget::Surface);
    if on_surface && let Some(problem) = surface_detection_problem(&smoothing, options.spacing) {
        return Err(CaseError::new("methods.sph.smoothing", problem));
    }
    check_walls::<D>(case, options, smoothing.radius())?;
    let mut bodies = Bodies::default();
    for number in 0..case.bodies.len() {
        let (listed, first_id) = (case.point_list(number)?, bodies.particles.len() as u32);
        let group = add_body(case, options, (number, listed.as_ref()), first_id, &mut bodies.particles)?;
        bodies.groups.push(group);
    }
    let count = bodies.particles.len();
    bodies.next_id = count as u32;
    check_stress_forms(&bodies.groups, options)?;
    check_distances(&bodies.particles.position, options)?;
    if options.ranks as usize > count {
        let problem = format!("{} is more than the {count} particles", options.ranks);
        return Err(CaseError::new("methods.sph.ranks", problem));
    }
    let loaded = |group: &ParticleGroup| LoadedBody {
        body: group.body,
        is_held: group.prescribed_velocity.is_some(),
        first: bodies.particles.id[group.start],
        positions: &bodies.particles.position[group.range()],
    };
    bodies.loads =
        BodyLoads::new(case, &bodies.groups.iter().map(loaded).collect::<Vec<_>>(), options.spacing)?;
    bodies.resize(count);
    if has_friction(case) {
        bodies.particles.delayed_pressure.resize(count, 0.0);
    }
    let places =
        bodies.groups.iter().map(|group| (group.body as usize, &bodies.particles.position[group.range()]));
    let looks = (OVERLAP_TOLERANCE * options.spacing, smoothing.radius());
    let obstacles = ObstacleFaces::new(case, places, looks)?;
    let walls = Walls::new(flat_walls(case, 0, options, smoothing.radius()), obstacles);
    let (case, gravity) = (Arc::new(case.clone()), leading_components(&case.gravity3()));
    let setting = SolverContext { case, options: options.clone(), smoothing, gravity };
    let mut solver = SphSolver::new(setting, bodies, walls);
    if options.formulation == LagrangianFormulation::TotalLagrangian {
        let reference = TotalLagrangianReference::new(&solver.bodies.particles, &solver.setting.smoothing);
        let reference = reference.map_err(|error| {
            CaseError::new("bodies", CaseErrorKind::coded(error.code(), error.to_string()))
        })?;
        solver.reference = Some(Box::new(reference));
    }
    check_fixed_step(&mut solver)?;
    if options.continuity == ContinuityEquation::Summation && !options.allow_summation {
        check_summed_densities(&solver)?;
    }
    Ok(solver)
}

/// Checks that supports are full for density by summation.
fn check_summed_densities<const D: usize>(solver: &SphSolver<D>) -> Result<(), CaseError> {
    let summed = solver.summed_densities().map_err(|error| {
        CaseError::new("methods.sph", CaseErrorKind::coded(error.code(), error.to_string()))
    })?;
    let p = &solver.bodies.particles;
    let off = summed
        .iter()
        .zip(&p.density)
        .position(|(sum, density)| !((sum / density - 1.0).abs() <= DENSITY_TOLERANCE));
    let Some(i) = off else { return Ok(()) };
    let problem = format!(
        "by summation the particle at {:?} m has {:.3} of its density: fill the domain between walls or \
         periodic sides, or set allow_summation",
        p.position[i],
        summed[i] / p.density[i]
    );
    Err(CaseError::new("methods.sph.continuity", problem))
}

/// Checks that the fixed step of the case does not exceed the critical step.
fn check_fixed_step<const D: usize>(solver: &mut SphSolver<D>) -> Result<(), CaseError> {
    solver.critical_step();
    let problem = solver.clock.fixed_step_problem(solver.setting.options.time_step);
    solver.clock.limit = None;
    problem.map_or(Ok(()), |problem| Err(CaseError::new("methods.sph.time_step", problem)))
}
