//! From a case to a solver: refuses what the method cannot honour, by JSON path.

use std::sync::Arc;

use colluvium_case::description::{Body, Space, Wall};
use colluvium_case::{Case, CaseError, Plan, Solver};
use colluvium_constitutive::{InitialCondition, MaterialSpec};
use colluvium_points::{CellList, NeighbourList};

use crate::config::{SoundSpeed, SphOptions};
use crate::kernel::Smoothing;
use crate::particles::{Group, Particles};
use crate::solver::{Audit, SphSolver};
use crate::walls::{Plane, Walls};

/// Beyond this many particles the ids no longer fit.
const MOST_PARTICLES: usize = u32::MAX as usize;

/// The options of the case, checked.
fn options(case: &Case) -> Result<SphOptions, CaseError> {
    if !case.methods.contains_key("sph") {
        let problem = "is missing: smoothed particle hydrodynamics needs at least its `spacing` (m)";
        return Err(CaseError::new("methods.sph", problem));
    }
    let options: SphOptions = case.method_options("sph")?;
    options.validate().map_err(|(name, problem)| CaseError::new(format!("methods.sph.{name}"), problem))?;
    Ok(options)
}

/// Refuses by name what SPH cannot do (yet).
fn refuse(case: &Case) -> Result<(), CaseError> {
    if case.space == Space::Axisymmetric {
        return Err(CaseError::new("space", "sph has no axisymmetric form: use plane-strain or 3d"));
    }
    case.refuse_driven("sph")?;
    if let Some(number) = case.stages.iter().position(|stage| !stage.excavate.is_empty()) {
        let problem = "sph removes whole bodies only: use remove_bodies";
        return Err(CaseError::new(format!("stages[{number}].excavate"), problem));
    }
    if !case.domain.periodic.is_empty() {
        return Err(CaseError::new("domain.periodic", "sph has no periodic boundaries"));
    }
    if !case.loads.is_empty() {
        return Err(CaseError::new("loads[0]", "sph cannot apply tractions"));
    }
    if let Some(number) = case.bodies.iter().position(|body| body.pore_fluid.is_some()) {
        let path = format!("bodies[{number}].pore_fluid");
        return Err(CaseError::new(
            path,
            "sph has one phase; where no fluid leaves use the material undrained",
        ));
    }
    for (number, boundary) in case.boundaries.iter().enumerate() {
        let path = |key: &str| format!("boundaries[{number}].{key}");
        if matches!(boundary.wall, Wall::Frictional { .. }) {
            return Err(CaseError::new(path("wall"), "sph has rough and smooth walls, none with friction"));
        }
        if boundary.group.is_some() {
            return Err(CaseError::new(path("group"), "sph has no mesh with groups of nodes"));
        }
        if matches!(boundary.wall, Wall::Absorbing { .. }) {
            return Err(CaseError::new(path("wall"), "sph has no absorbing boundaries"));
        }
        if boundary.separation {
            return Err(CaseError::new(path("separation"), "material cannot lift off the walls of sph"));
        }
        if boundary.velocity.as_ref().is_some_and(|velocity| velocity.iter().any(|v| *v != 0.0)) {
            return Err(CaseError::new(path("velocity"), "the walls of sph cannot move"));
        }
    }
    Ok(())
}

fn corner<const D: usize>(values: &[f64]) -> [f64; D] {
    std::array::from_fn(|axis| values[axis])
}

/// The walls of a stage.
pub fn walls<const D: usize>(case: &Case, stage: usize, options: &SphOptions, reach: f64) -> Walls<D> {
    let (mut mirrors, mut rough) = (Vec::new(), Vec::new());
    for (_, boundary) in case.active_boundaries(stage) {
        let plane = Plane {
            axis: boundary.side.axis(),
            position: boundary.position(&case.domain),
            upper: boundary.side.is_max(),
        };
        match boundary.wall {
            Wall::Smooth => mirrors.push(plane),
            Wall::Rough | Wall::Frictional { .. } | Wall::Absorbing { .. } => rough.push(plane),
        }
    }
    let span = (corner(&case.domain.min), corner(&case.domain.max));
    Walls::new(mirrors, &rough, span, options.spacing, reach)
}

/// The solver of `case`.
pub fn build(case: &Case) -> Result<Box<dyn Solver>, CaseError> {
    let options = options(case)?;
    Ok(match case.dimension() {
        1 => Box::new(solver::<1>(case, &options)?),
        2 => Box::new(solver::<2>(case, &options)?),
        _ => Box::new(solver::<3>(case, &options)?),
    })
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

fn measure<const D: usize>(case: &Case, options: &SphOptions) -> Result<Plan, CaseError> {
    let mut solver = solver::<D>(case, options)?;
    let time_step = solver.critical_step();
    let (points, walls) = (solver.particles.len, solver.walls.particles.len());
    let mut warnings = case.warnings();
    warnings.extend(options.warnings());
    let matrix = D * D * size_of::<f64>();
    let acting = 2 * D * size_of::<f64>() + 2 * matrix + 9 * size_of::<f64>();
    let own = 3 * D * size_of::<f64>() + matrix + 12;
    // Neighbours are listed twice while the list is made.
    let neighbours = 8.0 * (2.2 * solver.smoothing.radius() / options.spacing).powi(D as i32);
    Ok(Plan {
        points,
        nodes: 0,
        steps: (case.end_time() / time_step.dt).ceil() as u64,
        time_step,
        memory: ((points + walls) * acting + points * own) as u64 + (points as f64 * neighbours) as u64,
        updates_per_second: if D == 3 { 4e5 } else { 1.5e6 },
        warnings,
    })
}

/// A solver with its concrete type, at time zero.
pub fn solver<const D: usize>(case: &Case, options: &SphOptions) -> Result<SphSolver<D>, CaseError> {
    refuse(case)?;
    let smoothing = Smoothing::<D>::new(options.kernel, options.length())
        .map_err(|error| CaseError::new("methods.sph.kernel", error.to_string()))?;
    let mut particles = Particles::default();
    let mut groups = Vec::new();
    for (number, body) in case.bodies.iter().enumerate() {
        groups.push(add_body(case, options, number, body, &mut particles)?);
    }
    let (gravity, none) = (case.gravity3(), Vec::new());
    let mut solver = SphSolver {
        case: Arc::new(case.clone()),
        options: options.clone(),
        smoothing,
        walls: walls(case, 0, options, smoothing.radius()),
        particles,
        groups,
        images: Vec::new(),
        neighbours: NeighbourList::new(),
        cells: CellList::new(),
        listed: none,
        smoothed: Vec::new(),
        gravity: corner(&gravity),
        stage: 0,
        stage_start: 0.0,
        time: 0.0,
        step: 0,
        last_step: 0.0,
        limit: None,
        limit_age: 0,
        audit: Audit::default(),
    };
    solver.particles.resize(solver.particles.len);
    check_fixed_step(&mut solver, options)?;
    Ok(solver)
}

fn check_fixed_step<const D: usize>(
    solver: &mut SphSolver<D>,
    options: &SphOptions,
) -> Result<(), CaseError> {
    let Some(step) = options.time_step else { return Ok(()) };
    let critical = solver.find_limit().dt / options.courant;
    if step > critical {
        let problem = format!("{step} s is larger than the critical step {critical:.4e} s");
        return Err(CaseError::new("methods.sph.time_step", problem));
    }
    Ok(())
}

/// Young's modulus of a material (Pa), where it has one.
fn youngs_modulus(spec: &MaterialSpec) -> Option<f64> {
    serde_json::to_value(spec).ok()?.get("youngs_modulus")?.as_f64()
}

fn add_body<const D: usize>(
    case: &Case,
    options: &SphOptions,
    number: usize,
    body: &Body,
    particles: &mut Particles<D>,
) -> Result<Group, CaseError> {
    let path = format!("bodies[{number}]");
    let low: [f64; D] = corner(&case.domain.min);
    let samples = colluvium_points::lattice(&body.shape, low, options.spacing)
        .map_err(|error| CaseError::new(format!("{path}.shape"), error.to_string()))?;
    if samples.is_empty() {
        let problem = format!("holds no particle: it is smaller than the spacing of {} m", options.spacing);
        return Err(CaseError::new(format!("{path}.shape"), problem));
    }
    let start = particles.len;
    if start + samples.len() > MOST_PARTICLES {
        return Err(CaseError::new(
            "methods.sph.spacing",
            format!("gives more than {MOST_PARTICLES} particles"),
        ));
    }
    let positions: Vec<[f64; D]> = samples.iter().map(|sample| sample.position).collect();
    check_places(case, &path, &positions)?;
    let spec = &case.materials[&body.material];
    let youngs_modulus = match options.sound_speed {
        SoundSpeed::PWave => None,
        SoundSpeed::YoungsModulus => Some(youngs_modulus(spec).ok_or_else(|| {
            let problem = format!("material {:?} has no Young's modulus: use p-wave", body.material);
            CaseError::new("methods.sph.sound_speed", problem)
        })?),
    };
    let material = spec
        .build()
        .map_err(|error| CaseError::new(format!("materials.{}", body.material), error.to_string()))?;
    let density = spec.density();
    let space = crate::solver::spatial::<D>;
    let initial: Vec<InitialCondition> = positions
        .iter()
        .map(|x| InitialCondition { stress: body.stress.at(space(x), density, case.gravity3()), density })
        .collect();
    let (stress, states) = material.initial(&initial).map_err(|error| {
        let place = &positions[error.index];
        CaseError::new(format!("{path}.stress"), format!("at {place:?} m: {}", error.source))
    })?;
    let count = positions.len();
    particles.id.extend(start as u32..(start + count) as u32);
    particles.velocity.extend(positions.iter().map(|x| corner::<D>(&body.velocity.at(space(x)))));
    particles.mass.extend(samples.iter().map(|sample| sample.volume * density));
    particles.density.extend(std::iter::repeat_n(density, count));
    particles.sound.extend(std::iter::repeat_n(0.0, count));
    particles.stress.extend(stress);
    particles.origin.extend_from_slice(&positions);
    particles.position.extend(positions);
    particles.len += count;
    Ok(Group { body: number as u32, start, end: start + count, material, states, youngs_modulus, density })
}

/// Every particle must lie in the domain and in no wall.
fn check_places<const D: usize>(case: &Case, path: &str, positions: &[[f64; D]]) -> Result<(), CaseError> {
    let outside = |x: &&[f64; D]| (0..D).any(|c| x[c] < case.domain.min[c] || x[c] > case.domain.max[c]);
    if let Some(x) = positions.iter().find(outside) {
        let problem = format!("the particle at {x:?} m lies outside the domain");
        return Err(CaseError::new(format!("{path}.shape"), problem));
    }
    for (number, boundary) in case.boundaries.iter().enumerate() {
        let (axis, face) = (boundary.side.axis(), boundary.position(&case.domain));
        let sign = if boundary.side.is_max() { -1.0 } else { 1.0 };
        if let Some(x) = positions.iter().find(|x| sign * (x[axis] - face) <= 0.0) {
            let problem = format!("the particle at {x:?} m lies inside the wall boundaries[{number}]");
            return Err(CaseError::new(format!("{path}.shape"), problem));
        }
    }
    Ok(())
}
