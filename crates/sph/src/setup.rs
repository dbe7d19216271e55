//! From a case to a solver: refuses what the method cannot honour, by JSON path.

use std::sync::Arc;

use colluvium_case::description::{Axis, Body, Space, Wall};
use colluvium_case::{Case, CaseError, Plan, Size, Solver, spatial};
use colluvium_constitutive::{InitialCondition, Kind, MaterialSpec};
use colluvium_points::{CellList, HalfList, NeighbourList};

use crate::config::{
    Confined, Continuity, DensityReset, Formulation, Regularisation, RoughWall, SmoothWall, SoundSpeed,
    SphOptions, WallStress, WallVelocity,
};
use crate::confinement::blind_to_surfaces;
use crate::kernel::Smoothing;
use crate::pairs::SmoothBodies;
use crate::particles::{Group, Particles};
use crate::ranks::RankedSolver;
use crate::solver::{Audit, Kept, Listed, SphSolver};
use crate::total::{self, Reference};
use crate::walls::{Contact, Period, Plane, Walls, sites};

/// Share by which the width of listed particles may differ from `spacing` without a word.
const LISTED_SLACK: f64 = 0.1;

/// Beyond this many particles the ids no longer fit.
const MOST_PARTICLES: usize = u32::MAX as usize;
/// Walls of more particles than this are refused, as bodies are: they would not fit in memory.
const MOST_OF_WALLS: f64 = (1u64 << 28) as f64;
/// Share by which the density of a particle may be off when it is summed up. Of full supports it is by up to 2 % (sheet
/// §2.2); beside a free surface by 13 % or more.
const SUMMED: f64 = 0.1;

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
fn refuse(case: &Case, options: &SphOptions) -> Result<(), CaseError> {
    if case.space == Space::Axisymmetric {
        return Err(CaseError::new("space", "sph has no axisymmetric form: use plane-strain or 3d"));
    }
    case.refuse_driven("sph")?;
    case.refuse_dissipation("sph")?;
    case.refuse_dropping("sph")?;
    if let Some(number) = case.stages.iter().position(|stage| !stage.excavate.is_empty()) {
        let problem = "sph removes whole bodies only: use remove_bodies";
        return Err(CaseError::new(format!("stages[{number}].excavate"), problem));
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
        if boundary.group.is_some() {
            return Err(CaseError::new(path("group"), "sph has no mesh with groups of nodes"));
        }
        if matches!(boundary.wall, Wall::Absorbing { .. }) {
            return Err(CaseError::new(path("wall"), "sph has no absorbing boundaries"));
        }
        if boundary.separation {
            return Err(CaseError::new(
                path("separation"),
                "material cannot lift off the rough and smooth walls of sph",
            ));
        }
        if matches!(boundary.wall, Wall::Frictional { bilateral: true, .. }) {
            let problem = "material can always lift off the frictional walls of sph";
            return Err(CaseError::new(path("wall.bilateral"), problem));
        }
        let frictional = matches!(boundary.wall, Wall::Frictional { .. });
        if frictional && options.wall_stress != WallStress::Pairwise {
            return Err(CaseError::new(
                path("wall"),
                "frictional walls answer pairwise: set wall_stress to pairwise",
            ));
        }
    }
    check_periods(case, options)?;
    for (number, name) in options.held.iter().enumerate() {
        if !case.bodies.iter().any(|body| body.name == *name) {
            let problem = format!("{name:?} is not the name of a body");
            return Err(CaseError::new(format!("methods.sph.held[{number}]"), problem));
        }
    }
    for (number, name) in options.smooth_bodies.iter().enumerate() {
        if !options.held.contains(name) {
            let problem = format!("{name:?} is not among the bodies that are held: only these can be smooth");
            return Err(CaseError::new(format!("methods.sph.smooth_bodies[{number}]"), problem));
        }
    }
    for (name, history) in &options.held_history {
        let path = format!("methods.sph.held_history.{name}");
        if !options.held.contains(name) {
            let problem = format!("{name:?} is not among the bodies that are held");
            return Err(CaseError::new(path, problem));
        }
        history.validate().map_err(|(key, problem)| CaseError::new(format!("{path}.{key}"), problem))?;
    }
    if case.bodies.iter().all(|body| options.held.contains(&body.name)) {
        return Err(CaseError::new("methods.sph.held", "at least one body must be free to move"));
    }
    for (number, name) in options.confining.iter().flat_map(|c| c.bodies.iter().flatten()).enumerate() {
        if !case.bodies.iter().any(|body| body.name == *name) {
            let problem = format!("{name:?} is not the name of a body");
            return Err(CaseError::new(format!("methods.sph.confining.bodies[{number}]"), problem));
        }
    }
    if options.formulation == Formulation::TotalLagrangian {
        total::refuse(case, options)?;
    }
    check_density_forms(case, options)
}

/// Periodic axes must be longer than the reach of a particle, and a whole number of spacings.
fn check_periods(case: &Case, options: &SphOptions) -> Result<(), CaseError> {
    // Walls that interpolate go on beyond the ends by one reach, and ask the soil one further out.
    let layers = if options.wall_stress == WallStress::Pairwise { 1.0 } else { 2.0 };
    let reach = options.kernel.support() * options.length() * options.smoothing_growth.max(1.2).max(layers);
    for (number, axis) in case.domain.periodic.iter().enumerate() {
        let path = format!("domain.periodic[{number}]");
        let axis = axis.number();
        let length = case.domain.max[axis] - case.domain.min[axis];
        if length < reach {
            let problem =
                format!("the domain is {length} m long, less than the reach of a particle, {reach} m");
            return Err(CaseError::new(path, problem));
        }
        let count = length / options.spacing;
        if (count - count.round()).abs() > 1e-6 {
            let problem =
                format!("the domain is {count} spacings of methods.sph long: a whole number is needed");
            return Err(CaseError::new(path, problem));
        }
    }
    Ok(())
}

/// The least and the largest density of a body (kg/m³).
fn densities(case: &Case) -> (f64, f64) {
    let all = case.bodies.iter().filter_map(|b| case.materials.get(&b.material)).map(MaterialSpec::density);
    all.fold((f64::INFINITY, 0.0f64), |(low, high), density| (low.min(density), high.max(density)))
}

/// Density by summation across jumps, and what is for fluids only.
fn check_density_forms(case: &Case, options: &SphOptions) -> Result<(), CaseError> {
    let (low, high) = densities(case);
    if options.continuity == Continuity::Summation && low < high && !options.allow_summation {
        let problem = format!(
            "summation smears the jump between bodies of {low} and {high} kg/m³: use volume, or allow_summation"
        );
        return Err(CaseError::new("methods.sph.continuity", problem));
    }
    let fluid = case
        .bodies
        .iter()
        .any(|body| case.materials.get(&body.material).is_some_and(|spec| spec.facts().kind == Kind::Fluid));
    for (name, on) in [
        ("density_diffusion", options.density_diffusion > 0.0),
        ("density_reset", options.density_reset != DensityReset::None),
    ] {
        if on && !fluid {
            return Err(CaseError::new(
                format!("methods.sph.{name}"),
                "is for fluids, and no body is made of one",
            ));
        }
    }
    Ok(())
}

/// Laws that are not in rate form find their stress anew in every step: nothing is left of what smooths it.
fn check_stress_forms(groups: &[Group], options: &SphOptions) -> Result<(), CaseError> {
    if groups.iter().any(|group| group.material.is_in_rate_form()) {
        return Ok(());
    }
    for (name, on) in [
        ("regularisation", options.regularisation != Regularisation::None),
        ("stress_diffusion", options.stress_diffusion > 0.0),
    ] {
        if on {
            let problem =
                "is for laws in rate form, and no body is made of one: others find their stress anew";
            return Err(CaseError::new(format!("methods.sph.{name}"), problem));
        }
    }
    Ok(())
}

/// What is allowed but worth a word, of the case and its options together.
fn warnings(case: &Case, options: &SphOptions) -> Vec<String> {
    let mut warnings = case.warnings();
    warnings.extend(options.warnings());
    for number in 0..case.bodies.len() {
        let Ok(Some(list)) = case.point_list(number) else { continue };
        let spacing = list.spacing(case.dimension());
        if (spacing / options.spacing - 1.0).abs() > LISTED_SLACK {
            warnings.push(format!(
                "bodies[{number}].points: they are {spacing:.4e} m wide on the mean, methods.sph.spacing is {} m, and the \
                 smoothing length follows from that",
                options.spacing
            ));
        }
    }
    let (low, high) = densities(case);
    if options.weighs_masses() && high >= 2.0 * low {
        warnings.push(format!(
            "methods.sph.continuity: densities from {low} to {high} kg/m³: volume is the form for such jumps"
        ));
    }
    let any = |of: &dyn Fn(&Wall) -> bool| case.boundaries.iter().any(|boundary| of(&boundary.wall));
    let of_particles = any(&|wall| !mirrors(wall, options));
    let (rough, smooth) = (any(&|wall| *wall == Wall::Rough), any(&|wall| *wall == Wall::Smooth));
    let opposes = rough && options.rough_wall != RoughWall::Mirror;
    for (name, is_set, has_effect, none) in [
        ("wall_stress", options.wall_stress != WallStress::default(), of_particles, "is made of particles"),
        ("wall_guard", options.wall_guard != 0.0, of_particles, "is made of particles"),
        ("wall_velocity", options.wall_velocity != WallVelocity::default(), opposes, "of particles is rough"),
        ("rough_wall", options.rough_wall != RoughWall::default(), rough, "is rough"),
        ("smooth_wall", options.smooth_wall != SmoothWall::default(), smooth, "is smooth"),
    ] {
        if is_set && !has_effect {
            warnings.push(format!("methods.sph.{name}: has no effect, no wall {none}"));
        }
    }
    warnings
}

fn corner<const D: usize>(values: &[f64]) -> [f64; D] {
    std::array::from_fn(|axis| values[axis])
}

/// Whether a wall is made of mirror images, not of particles.
fn mirrors(wall: &Wall, options: &SphOptions) -> bool {
    match wall {
        Wall::Smooth => options.smooth_wall == SmoothWall::Mirror,
        Wall::Rough => options.rough_wall == RoughWall::Mirror,
        Wall::Absorbing { .. } | Wall::Frictional { .. } => false,
    }
}

/// The box that walls of particles cover (m), and how deep they are, for a kernel of the radius `reach` (m).
fn extent<const D: usize>(case: &Case, options: &SphOptions, reach: f64) -> (([f64; D], [f64; D]), f64) {
    let growth = if options.is_variable() { options.smoothing_growth } else { 1.0 };
    ((corner(&case.domain.min), corner(&case.domain.max)), reach * growth)
}

/// Walls of particles along a large domain would not fit in memory.
fn check_walls<const D: usize>(case: &Case, options: &SphOptions, reach: f64) -> Result<(), CaseError> {
    let (span, depth) = extent::<D>(case, options, reach);
    let of_particles = case.boundaries.iter().filter(|boundary| !mirrors(&boundary.wall, options));
    let count: f64 = of_particles
        .map(|boundary| sites(boundary.side.axis(), &span, options.spacing, depth).iter().product::<f64>())
        .sum();
    if count <= MOST_OF_WALLS {
        return Ok(());
    }
    let problem = format!(
        "its walls would need about {count:.2e} particles, more than 2^28: make it smaller, or use a larger spacing"
    );
    Err(CaseError::new("domain", problem))
}

/// The walls of a stage.
pub fn walls<const D: usize>(case: &Case, stage: usize, options: &SphOptions, reach: f64) -> Walls<D> {
    let (mut planes, mut faces) = (Vec::new(), Vec::new());
    for (_, boundary) in case.active_boundaries(stage) {
        let contact = match boundary.wall {
            Wall::Smooth => Contact::FreeSlip,
            // Absorbing sides are refused.
            Wall::Rough | Wall::Absorbing { .. } => Contact::NoSlip,
            Wall::Frictional { friction_coefficient, .. } => Contact::Friction(friction_coefficient),
        };
        let kind = if mirrors(&boundary.wall, options) { &mut planes } else { &mut faces };
        kind.push(Plane {
            axis: boundary.side.axis(),
            position: boundary.position(&case.domain),
            upper: boundary.side.is_max(),
            velocity: boundary.velocity.as_ref().map_or([0.0; D], |velocity| corner(velocity)),
            contact,
        });
    }
    let period = |axis: &Axis| {
        let axis = axis.number();
        Period { axis, low: case.domain.min[axis], high: case.domain.max[axis] }
    };
    let periods = case.domain.periodic.iter().map(period).collect();
    let (span, depth) = extent(case, options, reach);
    Walls::new(planes, faces, periods, span, options.spacing, depth)
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
    let whole = solver::<D>(case, options)?;
    Ok(match options.ranks {
        1 => Box::new(whole),
        ranks => Box::new(RankedSolver::new(whole, ranks as usize)),
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

/// The size of `case`, without making its particles.
pub fn size(case: &Case) -> Result<Size, CaseError> {
    let options = options(case)?;
    let (points, key) = (case.points_at(options.spacing), "methods.sph.spacing");
    let each = match case.dimension() {
        1 => bytes_each::<1>(&options),
        2 => bytes_each::<2>(&options),
        _ => bytes_each::<3>(&options),
    }?;
    Ok(Size { points, nodes: 0.0, memory: points * each, key })
}

fn smoothing<const D: usize>(options: &SphOptions) -> Result<Smoothing<D>, CaseError> {
    Smoothing::<D>::new(options.kernel, options.length())
        .map_err(|error| CaseError::new("methods.sph.kernel", error.to_string()))
}

/// Memory of what acts on others (bytes), a particle or one of a wall.
const fn bytes_acting(dimension: usize) -> usize {
    (2 * dimension + 12 + 16) * size_of::<f64>()
}

/// Memory of what only a particle has (bytes), its neighbours aside.
const fn bytes_own(dimension: usize) -> usize {
    (4 * dimension + dimension * dimension + 1) * size_of::<f64>() + 12
}

/// Memory of the neighbours of a particle (bytes): each is a number and a weight.
fn bytes_neighbours(radius: f64, spacing: f64, dimension: usize) -> f64 {
    12.0 * (2.2 * radius / spacing).powi(dimension as i32)
}

/// Memory of a particle (bytes).
fn bytes_each<const D: usize>(options: &SphOptions) -> Result<f64, CaseError> {
    let neighbours = bytes_neighbours(smoothing::<D>(options)?.radius(), options.spacing, D);
    Ok((bytes_acting(D) + bytes_own(D)) as f64 + neighbours)
}

fn measure<const D: usize>(case: &Case, options: &SphOptions) -> Result<Plan, CaseError> {
    let mut solver = solver::<D>(case, options)?;
    let time_step = solver.critical_step();
    let (points, walls) = (solver.particles.len, solver.walls.particles.len());
    let (acting, own) = (bytes_acting(D), bytes_own(D));
    let neighbours = bytes_neighbours(solver.smoothing.radius(), options.spacing, D);
    let mut volumes = vec![0.0; case.bodies.len()];
    for group in &solver.groups {
        let mass = solver.particles.mass[group.range()].iter().sum::<f64>();
        volumes[group.body as usize] += mass / group.density;
    }
    Ok(Plan {
        points,
        nodes: 0,
        steps: (case.end_time() / time_step.dt).ceil() as u64,
        time_step,
        memory: ((points + walls) * acting + points * own) as u64 + (points as f64 * neighbours) as u64,
        volumes,
        updates_per_second: if D == 3 { 8e5 } else { 3e6 },
        warnings: warnings(case, options),
    })
}

/// A solver with its concrete type, at time zero.
pub fn solver<const D: usize>(case: &Case, options: &SphOptions) -> Result<SphSolver<D>, CaseError> {
    refuse(case, options)?;
    let smoothing = smoothing::<D>(options)?;
    let on_surface = options.confining.as_ref().is_some_and(|confining| confining.on == Confined::Surface);
    if on_surface && let Some(problem) = blind_to_surfaces(&smoothing, options.spacing) {
        return Err(CaseError::new("methods.sph.smoothing", problem));
    }
    check_walls::<D>(case, options, smoothing.radius())?;
    let mut particles = Particles::default();
    let mut groups = Vec::new();
    for (number, body) in case.bodies.iter().enumerate() {
        groups.push(add_body(case, options, number, body, &mut particles)?);
    }
    check_stress_forms(&groups, options)?;
    let gravity = case.gravity3();
    check_distances(&particles, options)?;
    if options.ranks as usize > particles.len {
        let problem = format!("{} is more than the {} particles", options.ranks, particles.len);
        return Err(CaseError::new("methods.sph.ranks", problem));
    }
    let mut solver = SphSolver {
        case: Arc::new(case.clone()),
        options: options.clone(),
        smoothing,
        walls: walls(case, 0, options, smoothing.radius()),
        particles,
        groups,
        images: Vec::new(),
        smooth: SmoothBodies::default(),
        neighbours: NeighbourList::new(),
        weights: Vec::new(),
        weighed: false,
        accelerated: false,
        cells: CellList::new(),
        listed: Listed::default(),
        sorted: None,
        tensors: Vec::new(),
        scalars: Vec::new(),
        kept: Kept::default(),
        surface: Vec::new(),
        shifts: Vec::new(),
        gravity: corner(&gravity),
        stage: 0,
        stage_start: 0.0,
        time: 0.0,
        step: 0,
        last_step: 0.0,
        limit: None,
        limit_age: 0,
        audit: Audit::default(),
        crowding: Vec::new(),
        pushes: Vec::new(),
        reference: None,
        guests: Vec::new(),
    };
    solver.particles.resize(solver.particles.len);
    if options.formulation == Formulation::TotalLagrangian {
        let reference = Reference::new(&solver.particles, &solver.smoothing);
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
    let p = &solver.particles;
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

/// No two particles may stand in the same place.
fn check_distances<const D: usize>(particles: &Particles<D>, options: &SphOptions) -> Result<(), CaseError> {
    let mut list = HalfList::<D>::new();
    let least = 1e-6 * options.spacing;
    // Cells of the search must not be much smaller than the spacing.
    list.build(&particles.position, 0.5 * options.spacing)
        .map_err(|error| CaseError::new("bodies", error.to_string()))?;
    let close = |&(i, j): &(u32, u32)| {
        let (a, b) = (&particles.position[i as usize], &particles.position[j as usize]);
        (0..D).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>() < least * least
    };
    match list.pairs().find(close) {
        None => Ok(()),
        Some((i, _)) => {
            let problem =
                format!("two particles stand at {:?} m: do bodies overlap?", particles.position[i as usize]);
            Err(CaseError::new("bodies", problem))
        }
    }
}

/// A step that the case fixes must be below the critical one.
fn check_fixed_step<const D: usize>(solver: &mut SphSolver<D>) -> Result<(), CaseError> {
    solver.critical_step();
    let checked =
        solver.too_long().map_or(Ok(()), |problem| Err(CaseError::new("methods.sph.time_step", problem)));
    solver.limit = None;
    checked
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
    let listed = case.point_list(number)?;
    let samples = match &listed {
        Some(list) => list.samples(),
        None => colluvium_points::lattice(&body.shape, low, options.spacing)
            .map_err(|error| CaseError::new(format!("{path}.shape"), error.to_string()))?,
    };
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
    let initial: Vec<InitialCondition> = positions
        .iter()
        .enumerate()
        .map(|(point, x)| InitialCondition {
            stress: case.initial_stress_of(body, listed.as_ref(), point, spatial(x)),
            density,
        })
        .collect();
    let (stress, states) = material.initial(&initial).map_err(|error| {
        let place = &positions[error.index];
        CaseError::new(format!("{path}.stress"), format!("at {place:?} m: {}", error.source))
    })?;
    let count = positions.len();
    particles.id.extend(start as u32..(start + count) as u32);
    let history = options.held_history.get(&body.name).cloned();
    let factor = history.as_ref().map_or(1.0, |history| history.at(0.0));
    let own = listed.as_ref().and_then(|list| list.velocities.as_ref());
    if own.is_some() && options.held.contains(&body.name) {
        let problem = "has velocities, and a held body moves with its `velocity`";
        return Err(CaseError::new(format!("{path}.points.file"), problem));
    }
    let velocity = |(point, x): (usize, &[f64; D])| match own {
        Some(velocities) => corner::<D>(&velocities[point]),
        None => corner::<D>(&body.velocity.at(spatial(x)).map(|v| factor * v)),
    };
    particles.velocity.extend(positions.iter().enumerate().map(velocity));
    particles.mass.extend(samples.iter().map(|sample| sample.volume * density));
    particles.density.extend(std::iter::repeat_n(density, count));
    particles.sound.extend(std::iter::repeat_n(0.0, count));
    particles.length.extend(std::iter::repeat_n(options.length(), count));
    particles.stress.extend(stress);
    particles.origin.extend_from_slice(&positions);
    particles.position.extend(positions);
    particles.len += count;
    let held = options.held.contains(&body.name).then(|| body.velocity.clone());
    let fluid = spec.facts().kind == Kind::Fluid;
    let end = start + count;
    let confined = options.confining.as_ref().is_some_and(|confining| {
        confining.bodies.as_ref().map_or(held.is_none(), |names| names.contains(&body.name))
    });
    let smooth = options.smooth_bodies.contains(&body.name);
    let body = number as u32;
    Ok(Group {
        body,
        start,
        end,
        material,
        states,
        youngs_modulus,
        density,
        held,
        history,
        factor,
        smooth,
        confined,
        fluid,
    })
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
