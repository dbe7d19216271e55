//! From a case to a solver: refuses what the method cannot honour, by JSON path.

mod bands;
mod bodies;
mod defaults;
mod refuse;

use std::f64::consts::PI;
use std::sync::Arc;

use colluvium_case::{Case, CaseError, Honours, Plan, Resolution, Size, Solver};

use crate::config::{Confined, Continuity, Formulation, SphOptions};
use crate::confinement::blind_to_surfaces;
use crate::kernel::Smoothing;
use crate::loads::{Loaded, Loads};
use crate::particles::{Bodies, Group};
use crate::ranks::RankedSolver;
use crate::setting::{Setting, corner};
use crate::solver::SphSolver;
use crate::total::Reference;
use crate::walls::{Obstacles, Walls, check_walls, has_friction, planes, wall_sites};
use bands::check_bands;
use bodies::{add_body, check_distances};
use refuse::{check_stress_forms, refuse, warnings};

/// Share by which the density of a particle may be off when it is summed up. Of full supports it is by up to 2 %
/// (sheet: sph §2.2); beside a free surface by 13 % or more.
const SUMMED: f64 = 0.1;

/// How deep particles may lie in an obstacle at the start, in spacings.
const COVERED: f64 = 1e-6;

/// Time to place a particle of a wall (s).
const PLACING: f64 = 3e-7;

/// The options of the case, checked.
pub fn options(case: &Case) -> Result<SphOptions, CaseError> {
    if !case.methods.contains_key("sph") {
        let problem = "is missing: smoothed particle hydrodynamics needs at least its `spacing` (m)";
        return Err(CaseError::new("methods.sph", problem));
    }
    let mut options: SphOptions = case.method_options("sph")?;
    defaults::fit(case, &mut options);
    options.validate().map_err(|(name, problem)| CaseError::new(format!("methods.sph.{name}"), problem))?;
    Ok(options)
}

/// What SPH says to the features of `case`.
pub fn honours(case: &Case) -> Result<Honours, CaseError> {
    Ok(refuse::honours(&options(case)?))
}

/// The solver of `case`.
pub fn build(case: &Case) -> Result<Box<dyn Solver>, CaseError> {
    let options = options(case)?;
    Ok(match case.dimension() {
        1 => boxed::<1>(case, &options)?,
        2 => boxed::<2>(case, &options)?,
        _ => boxed::<3>(case, &options)?,
    })
}

fn boxed<const D: usize>(case: &Case, options: &SphOptions) -> Result<Box<dyn Solver>, CaseError> {
    Ok(shared_out(solver::<D>(case, options)?, options.ranks))
}

/// A solver with its particles shared out among `ranks`.
pub fn shared_out<const D: usize>(whole: SphSolver<D>, ranks: u32) -> Box<dyn Solver> {
    match ranks {
        1 => Box::new(whole),
        ranks => Box::new(RankedSolver::new(whole, ranks as usize)),
    }
}

/// The plan of `case`.
pub fn plan(case: &Case) -> Result<Plan, CaseError> {
    let options = options(case)?;
    match case.dimension() {
        1 => measure::<1>(case, &options),
        2 => measure::<2>(case, &options),
        _ => measure::<3>(case, &options),
    }
}

/// The size of `case`, without making its particles.
pub fn size(case: &Case) -> Result<Size, CaseError> {
    let options = options(case)?;
    let points = case.points_at(options.spacing);
    let mut states = 0.0;
    for (body, points) in case.bodies.iter().zip(&points) {
        let path = || format!("materials.{}", body.material);
        let law = case.materials[&body.material].build();
        let size = law.map_err(|error| CaseError::new(path(), error.to_string()))?.state_size();
        states += points * bytes_of_state(size) as f64;
    }
    let points = points.iter().sum();
    match case.dimension() {
        1 => size_in::<1>(case, &options, points, states),
        2 => size_in::<2>(case, &options, points, states),
        _ => size_in::<3>(case, &options, points, states),
    }
}

/// The size of `points` particles with `states` (bytes) of their laws, and of the walls of particles, which follow from the domain.
fn size_in<const D: usize>(
    case: &Case,
    options: &SphOptions,
    points: f64,
    states: f64,
) -> Result<Size, CaseError> {
    let walls = wall_sites::<D>(case, options, smoothing::<D>(options)?.radius());
    let memory = points * bytes_each::<D>(options)? + states + walls * bytes_acting(D) as f64;
    let (key, cure) = if walls > points {
        ("domain", "most are particles of walls: make it smaller, or the spacing larger")
    } else {
        ("methods.sph.spacing", "")
    };
    Ok(Size { points: points + walls, memory, key, placing: walls * PLACING, cure, ..Size::default() })
}

fn smoothing<const D: usize>(options: &SphOptions) -> Result<Smoothing<D>, CaseError> {
    Smoothing::<D>::new(options.kernel, options.length())
        .map_err(|error| CaseError::new("methods.sph.kernel", error.to_string()))
}

/// Memory of what acts on others (bytes), a particle or one of a wall.
const fn bytes_acting(dimension: usize) -> usize {
    (2 * dimension + 12 + 16) * size_of::<f64>()
}

/// Memory of what only a particle has (bytes), its neighbours aside, with the buffers of a sort.
const fn bytes_own(dimension: usize) -> usize {
    (5 * dimension + 2 * dimension * dimension + 8) * size_of::<f64>() + 16
}

/// Memory of the state of a law that takes `size` (bytes): once more where particles are put in a new order.
const fn bytes_of_state(size: usize) -> usize {
    2 * size
}

/// Memory of the neighbours of a particle (bytes): each is a number and a weight.
fn bytes_neighbours(radius: f64, spacing: f64, dimension: usize) -> f64 {
    let unit_ball = [2.0, PI, 4.0 / 3.0 * PI][dimension - 1];
    12.0 * unit_ball * (1.1 * radius / spacing).powi(dimension as i32)
}

/// Memory of a particle (bytes).
fn bytes_each<const D: usize>(options: &SphOptions) -> Result<f64, CaseError> {
    let neighbours = bytes_neighbours(smoothing::<D>(options)?.radius(), options.spacing, D);
    Ok((bytes_acting(D) + bytes_own(D)) as f64 + neighbours)
}

fn measure<const D: usize>(case: &Case, options: &SphOptions) -> Result<Plan, CaseError> {
    let mut solver = solver::<D>(case, options)?;
    let time_step = solver.critical_step();
    let (points, walls) = (solver.bodies.particles.len(), solver.walls.planes.particles.len());
    let (acting, own) = (bytes_acting(D), bytes_own(D));
    let neighbours = bytes_neighbours(solver.setting.smoothing.radius(), options.spacing, D);
    let states = |group: &Group| (group.end - group.start) * bytes_of_state(group.material.state_size());
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
            apart: options.spacing,
            axes: D,
            key: "methods.sph.spacing",
            noun: "spacings",
        }),
        updates_per_second: if D == 3 { 8e5 } else { 3e6 },
        warnings: warnings(case, options),
    })
}

/// A solver with its concrete type, at time zero.
pub fn solver<const D: usize>(case: &Case, options: &SphOptions) -> Result<SphSolver<D>, CaseError> {
    refuse(case, options)?;
    check_bands::<D>(case, options)?;
    let smoothing = smoothing::<D>(options)?;
    let on_surface = options.confining.as_ref().is_some_and(|confining| confining.on == Confined::Surface);
    if on_surface && let Some(problem) = blind_to_surfaces(&smoothing, options.spacing) {
        return Err(CaseError::new("methods.sph.smoothing", problem));
    }
    check_walls::<D>(case, options, smoothing.radius())?;
    let mut bodies = Bodies::default();
    for (number, body) in case.bodies.iter().enumerate() {
        let group = add_body(case, options, number, body, &mut bodies.particles)?;
        bodies.groups.push(group);
    }
    let count = bodies.particles.len();
    check_stress_forms(&bodies.groups, options)?;
    check_distances(&bodies.particles, options)?;
    if options.ranks as usize > count {
        let problem = format!("{} is more than the {count} particles", options.ranks);
        return Err(CaseError::new("methods.sph.ranks", problem));
    }
    let loaded = |group: &Group| Loaded {
        body: group.body,
        held: group.held.is_some(),
        first: bodies.particles.id[group.start],
        positions: &bodies.particles.position[group.range()],
    };
    bodies.loads = Loads::new(case, &bodies.groups.iter().map(loaded).collect::<Vec<_>>(), options.spacing)?;
    bodies.resize(count);
    if has_friction(case) {
        bodies.particles.pressed.resize(count, 0.0);
    }
    let places =
        bodies.groups.iter().map(|group| (group.body as usize, &bodies.particles.position[group.range()]));
    let looks = (COVERED * options.spacing, smoothing.radius());
    let obstacles = Obstacles::new(case, places, looks)?;
    let walls = Walls::new(planes(case, 0, options, smoothing.radius()), obstacles);
    let (case, gravity) = (Arc::new(case.clone()), corner(&case.gravity3()));
    let setting = Setting { case, options: options.clone(), smoothing, gravity };
    let mut solver = SphSolver::new(setting, bodies, walls);
    if options.formulation == Formulation::TotalLagrangian {
        let reference = Reference::new(&solver.bodies.particles, &solver.setting.smoothing);
        let reference = reference.map_err(|error| CaseError::new("bodies", error.to_string()))?;
        solver.reference = Some(Box::new(reference));
    }
    check_fixed_step(&mut solver)?;
    if options.continuity == Continuity::Summation && !options.allow_summation {
        check_summed_densities(&solver)?;
    }
    Ok(solver)
}

/// Density by summation needs full supports.
fn check_summed_densities<const D: usize>(solver: &SphSolver<D>) -> Result<(), CaseError> {
    let summed =
        solver.summed_densities().map_err(|error| CaseError::new("methods.sph", error.to_string()))?;
    let p = &solver.bodies.particles;
    let off =
        summed.iter().zip(&p.density).position(|(sum, density)| !((sum / density - 1.0).abs() <= SUMMED));
    let Some(i) = off else { return Ok(()) };
    let problem = format!(
        "summation gives the particle at {:?} m {:.3} of its density: fill the domain between walls or periods, or allow_summation",
        p.position[i],
        summed[i] / p.density[i]
    );
    Err(CaseError::new("methods.sph.continuity", problem))
}

/// A step that the case fixes must be below the critical one.
fn check_fixed_step<const D: usize>(solver: &mut SphSolver<D>) -> Result<(), CaseError> {
    solver.critical_step();
    let problem = solver.clock.too_long(solver.setting.options.time_step);
    solver.clock.limit = None;
    problem.map_or(Ok(()), |problem| Err(CaseError::new("methods.sph.time_step", problem)))
}
