//! Setup: from a case to a solver; rejects what the method does not support, by JSON path.

mod body_grains;
mod capabilities;
mod pair_laws;
mod problem_size;
mod sleeve_rings;
mod stage_changes;
mod stress_checks;
mod warnings;

use std::sync::Arc;

use colluvium_case::{Case, CaseError, MovingObstacle, ObstacleLaws, PlacedObstacle, Plan, Solver, spatial};
use colluvium_points::Surface;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub(crate) use crate::setup::body_grains::fill_of_body;
pub(crate) use crate::setup::capabilities::capabilities;
pub(crate) use crate::setup::problem_size::problem_size;

use crate::boundary::periodic_cell::PeriodicCell;
use crate::boundary::walls::{RigidWall, WallList};
use crate::config::{DemOptions, Fill};
use crate::contact::bond::Bond;
use crate::contact::contact_histories::HistoryColumns;
use crate::contact::{AttractionLaw, CONTACT_BONDED, PairLaw};
use crate::neighbours::VerletLists;
use crate::output::energy_balance::EnergyBalance;
use crate::points::grains::{Grains, volume};
use crate::points::vector::{difference, dot};
use crate::solver::{
    ControlledStress, DemSolver, KindProperties, SinceListBuild, SpecimenSource, StepBuffers,
};
use crate::specimen::file::StoredSpecimen;
use crate::specimen::pluviation;

/// Memory of a disk and of a sphere during a run, with buffers and pairs (bytes).
const BYTES_OF_GRAIN: [usize; 2] = [650, 1000];

/// Options of the case, validated.
pub(crate) fn options(case: &Case) -> Result<DemOptions, CaseError> {
    if !case.methods.contains_key("dem") {
        let problem = "is missing: the discrete element method needs at least its `grains` and `pairs`";
        return Err(CaseError::new("methods.dem", problem));
    }
    capabilities::reject_clumps(&case.methods["dem"])?;
    let options: DemOptions = case.method_options("dem")?;
    options
        .validate(case.dimension())
        .map_err(|(path, problem)| CaseError::new(format!("methods.dem.{path}"), problem))?;
    capabilities::check_supported(case, &options)?;
    Ok(options)
}

pub fn build(case: &Case) -> Result<Box<dyn Solver>, CaseError> {
    Ok(match case.dimension() {
        3 => Box::new(solver::<3, 3>(case)?),
        _ => Box::new(solver::<2, 1>(case)?),
    })
}

pub fn plan(case: &Case) -> Result<Plan, CaseError> {
    Ok(match case.dimension() {
        3 => build_plan(case, &solver::<3, 3>(case)?),
        _ => build_plan(case, &solver::<2, 1>(case)?),
    })
}

/// Plan of a case, and its solver.
pub fn plan_and_build(case: &Case) -> Result<(Plan, Box<dyn Solver>), CaseError> {
    Ok(match case.dimension() {
        3 => {
            let solver = solver::<3, 3>(case)?;
            (build_plan(case, &solver), Box::new(solver))
        }
        _ => {
            let solver = solver::<2, 1>(case)?;
            (build_plan(case, &solver), Box::new(solver))
        }
    })
}

fn build_plan<const D: usize, const R: usize>(case: &Case, solver: &DemSolver<D, R>) -> Plan {
    let time_step = solver.critical_step();
    let points = solver.grains.len();
    let (mut volumes, mut masses) = (vec![0.0; case.bodies.len()], vec![0.0; case.bodies.len()]);
    for ((body, radius), mass) in
        solver.grains.body.iter().zip(&solver.grains.radius).zip(&solver.grains.mass)
    {
        volumes[*body as usize] += volume(D, *radius);
        masses[*body as usize] += mass;
    }
    Plan {
        points,
        nodes: 0,
        steps: (case.end_time() / time_step.dt).ceil() as u64,
        time_step,
        memory: (points * BYTES_OF_GRAIN[D - 2]) as u64,
        volumes,
        grains: Some(masses),
        densities: None,
        resolution: None,
        updates_per_second: if D == 3 { 5e6 } else { 1e7 },
        warnings: warnings::warnings(case, solver),
    }
}

/// Solver with its concrete type, at time zero.
pub fn solver<const D: usize, const R: usize>(case: &Case) -> Result<DemSolver<D, R>, CaseError> {
    let options = options(case)?;
    let kinds = kinds(&options);
    let mut grains = Grains::default();
    let standing = case.placed_obstacles::<D>()?;
    let stored = StoredSpecimen::of_case(case, &options)?;
    body_grains::fill(case, &options, stored.as_ref(), &standing, &mut grains)?;
    check_covered(case, &standing, &grains)?;
    let laws = pair_laws::laws(case, &options, &kinds, &grains, 0)?;
    let columns = HistoryColumns::of(
        &laws.pairs.iter().chain(laws.walls.iter().flatten()).copied().collect::<Vec<_>>(),
    );
    let cell = stored.as_ref().map_or_else(|| Ok(domain(case)), |stored| stored.cell(case, domain(case)))?;
    let fastest = grains.velocity.iter().map(|v| dot(v, v)).fold(0.0, f64::max).sqrt();
    let mut solver = DemSolver {
        case: Arc::new(case.clone()),
        skin: options.skin * mean_diameter(case, &options, &grains),
        kinds,
        laws,
        columns,
        next_id: body_grains::next_id(&grains),
        grains,
        cell,
        lists: VerletLists::default(),
        wall_list: WallList::default(),
        walls: Vec::new(),
        obstacles: standing.into_iter().map(|obstacle| (obstacle.surface, obstacle.laws)).collect(),
        scratch: StepBuffers::default(),
        since_list_build: SinceListBuild::default(),
        stage: 0,
        stage_start: 0.0,
        time: 0.0,
        step: 0,
        last_step: 0.0,
        max_speed: fastest,
        deep_share: 1.0,
        radii: (0.0, 0.0),
        energy_balance: EnergyBalance::default(),
        virial: [[[0.0; D]; D]; 2],
        broken_bonds: Vec::new(),
        controlled_stresses: vec![ControlledStress::default(); D * D + case.boundaries.len()],
        imposed_gradient: None,
        scalar_only: false,
        membranes: Vec::new(),
        sources: pluviation::sources(case, &options),
        specimens: Vec::new(),
        specimen_source: SpecimenSource::default(),
        options,
    };
    solver.walls = stage_walls(&solver, 0);
    stored.map_or(Ok(()), |stored| stored.restore_contacts(case, &mut solver))?;
    check_step(&solver)?;
    check_stages(&solver)?;
    solver.build_lists().map_err(|error| CaseError::new("methods.dem", error.to_string()))?;
    check_overlaps(&solver)?;
    initialise_bonds(&mut solver)?;
    solver.specimens = solver.find_specimens();
    Ok(solver)
}

fn kinds(options: &DemOptions) -> Vec<KindProperties> {
    options
        .grains
        .iter()
        .map(|(name, kind)| KindProperties { name: name.clone(), density: kind.density })
        .collect()
}

/// Periodic cell of the domain.
fn domain<const D: usize>(case: &Case) -> PeriodicCell<D> {
    let corner = |values: &[f64]| std::array::from_fn(|axis| values[axis]);
    let periodic = std::array::from_fn(|axis| case.domain.is_periodic(axis));
    PeriodicCell::new(corner(&case.domain.min), corner(&case.domain.max), periodic)
}

/// Mean diameter (m) of the grains at the start, or of those that will enter.
fn mean_diameter<const D: usize, const R: usize>(
    case: &Case,
    options: &DemOptions,
    grains: &Grains<D, R>,
) -> f64 {
    match pluviation::sources(case, options).first() {
        Some(source) if grains.is_empty() => source.mean(D),
        _ => 2.0 * grains.radius.iter().sum::<f64>() / grains.len() as f64,
    }
}

/// Checks that free grains do not start inside obstacles.
fn check_covered<const D: usize, const R: usize>(
    case: &Case,
    standing: &[PlacedObstacle<'_, D>],
    grains: &Grains<D, R>,
) -> Result<(), CaseError> {
    for body in 0..case.bodies.len() {
        let of_body = (0..grains.len()).filter(|&i| grains.body[i] as usize == body && !grains.held[i]);
        let places: Vec<[f64; D]> = of_body.map(|i| grains.position[i]).collect();
        case.reject_overlapping_points(standing, body, &places, 0.0)?;
    }
    Ok(())
}

/// Checks that the contacts allow a fixed time step of the case.
fn check_step<const D: usize, const R: usize>(solver: &DemSolver<D, R>) -> Result<(), CaseError> {
    let Some(step) = solver.options.time_step.filter(|step| *step > solver.laws.step[1]) else {
        return Ok(());
    };
    let problem = format!(
        "{step} s is larger than {:.4e} s, the longest step of the stiffest contact with its lightest grains; {:.4e} s is taken \
         where it is left out",
        solver.laws.step[1], solver.laws.step[0]
    );
    Err(CaseError::new("methods.dem.time_step", problem))
}

/// Checks the membranes and servo walls of the stages against the grains and walls.
fn check_stages<const D: usize, const R: usize>(solver: &DemSolver<D, R>) -> Result<(), CaseError> {
    check_sheets(solver)?;
    check_areas(solver)
}

/// Checks that membranes in space are at least two whole rows of grains, and closed where they are filled with rings.
fn check_sheets<const D: usize, const R: usize>(solver: &DemSolver<D, R>) -> Result<(), CaseError> {
    for (stage, own) in &solver.options.stages {
        for (name, membrane) in &own.membranes {
            let Some(columns) = membrane.columns else { continue };
            let number = solver.case.bodies.iter().position(|body| body.name == *name);
            let count = solver.grains.body.iter().filter(|own| Some(**own as usize) == number).count();
            let body = number.map(|number| &solver.case.bodies[number]).filter(|body| body.points.is_none());
            let problem = match body.and_then(|body| fill_of_body(&solver.options, body)) {
                _ if count % columns != 0 || count < 2 * columns => {
                    format!("the body has {count} grains, which are not two or more rows of {columns}")
                }
                Some(Fill::Sleeve { columns: rings }) if rings != columns || !membrane.closed => {
                    format!(
                        "the body is filled with rings of {rings} grains: give columns {rings}, and closed true"
                    )
                }
                _ => continue,
            };
            let path = format!("methods.dem.stages.{stage}.membranes.{name}.columns");
            return Err(CaseError::new(path, problem));
        }
    }
    Ok(())
}

/// Checks that the area of each servo wall is known: bounded by walls or periods, or given by the case.
fn check_areas<const D: usize, const R: usize>(solver: &DemSolver<D, R>) -> Result<(), CaseError> {
    let case = &solver.case;
    for (stage, own) in &solver.options.stages {
        for (name, press) in &own.walls {
            let path = format!("methods.dem.stages.{stage}.walls.{name}");
            let Some(wall) = case.boundaries.iter().find(|boundary| boundary.name() == name) else {
                continue;
            };
            let axis = wall.side.axis();
            if let Some(sleeve) = &press.sleeve {
                if solver.enclosed_by(sleeve, axis).is_none() {
                    let problem = format!("{sleeve:?} is no body that is a closed membrane in some stage");
                    return Err(CaseError::new(format!("{path}.sleeve"), problem));
                }
                continue;
            }
            let bounded = |other: usize| {
                let on = |upper| {
                    case.boundaries.iter().any(|own| own.side.axis() == other && own.side.is_max() == upper)
                };
                other == axis || case.domain.is_periodic(other) || (on(false) && on(true))
            };
            if let (None, Some(other)) = (press.area, (0..D).find(|&other| !bounded(other))) {
                let problem = format!(
                    "is missing: along {} no walls bound what {name:?} presses on; give its area, or in space the membrane \
                     around it as sleeve",
                    ["x", "y", "z"][other]
                );
                return Err(CaseError::new(format!("{path}.area"), problem));
            }
        }
    }
    Ok(())
}

/// Checks the initial overlaps of grains with each other and with walls.
fn check_overlaps<const D: usize, const R: usize>(solver: &DemSolver<D, R>) -> Result<(), CaseError> {
    let (g, most) = (&solver.grains, solver.options.initial_overlap);
    let mut worst: Option<(f64, usize, Option<usize>)> = None;
    solver.for_each_contact(|contact, _, _| {
        let share = solver.overlap_of(&contact);
        let given = |grain: usize| solver.specimen_source.has(g.body[grain] as usize);
        // A specimen is in equilibrium with its overlaps.
        let of_file = given(contact.grain) && contact.other.is_none_or(given);
        let most = if of_file { most.max(solver.specimen_source.overlap) } else { most };
        if share > most * (1.0 + 1e-9) && worst.is_none_or(|(before, ..)| share > before) {
            worst = Some((share, contact.grain, contact.other));
        }
    });
    let Some((share, i, other)) = worst else { return Ok(()) };
    let body = |grain: usize| &solver.case.bodies[g.body[grain] as usize].name;
    let with = match other {
        Some(j) => format!("grain {} of body {:?} at {:.4?} m", g.id[j], body(j), g.position[j]),
        None => "a wall".to_owned(),
    };
    let problem = format!(
        "grain {} at {:.4?} m and {with} overlap by {share:.3} of the smaller radius at the start, more than {most}: fill more \
         loosely, or raise initial_overlap",
        g.id[i], g.position[i]
    );
    Err(CaseError::new(format!("bodies[{}].shape", g.body[i]), problem))
}

/// Bonds grains in contact at the start, and sets the cohesion of their contacts.
fn initialise_bonds<const D: usize, const R: usize>(solver: &mut DemSolver<D, R>) -> Result<(), CaseError> {
    let wanted = solver.laws.pairs.iter().any(|law| law.bond.is_some());
    let coheres = |law: &PairLaw| matches!(law.attraction, Some(AttractionLaw::Cohesion(_)));
    if !wanted && !solver.laws.pairs.iter().any(coheres) {
        return Ok(());
    }
    let mut random = ChaCha8Rng::seed_from_u64(solver.options.seed ^ 0xb0d5);
    let mut shifts = Vec::new();
    solver.cell.shifts(&mut shifts);
    let (g, laws, kinds) = (&solver.grains, &solver.laws.pairs, solver.kinds.len());
    let (mut bonds, mut pairs_of_ids) = (0usize, Vec::new());
    for (list, pairs) in [&solver.lists.slab_pairs, &solver.lists.periodic_pairs].into_iter().enumerate() {
        for (i, k) in pairs.firsts() {
            let j = pairs.other[k] as usize;
            let given = |grain: usize| solver.specimen_source.has(g.body[grain] as usize);
            if solver.specimen_source.bonded && given(i) && given(j) {
                // The file states that it is bonded, or broken.
                bonds += usize::from(pairs.histories.bond.get(k).is_some_and(Bond::is_intact));
                continue;
            }
            let law = &laws[g.kind[i] as usize * kinds + g.kind[j] as usize];
            let code = pairs.image.get(k).map_or(0, |code| *code as usize);
            let apart = difference(&difference(&g.position[i], &g.position[j]), &shifts[code].0);
            let gap = dot(&apart, &apart).sqrt() - g.radius[i] - g.radius[j];
            pairs_of_ids.push((
                g.id[i].min(g.id[j]),
                g.id[i].max(g.id[j]),
                list,
                k,
                gap,
                law,
                g.radius[i] + g.radius[j],
            ));
        }
    }
    // Strengths are drawn in the order of ids.
    pairs_of_ids.sort_by_key(|pair| (pair.0, pair.1));
    for (_, _, list, k, gap, law, mean) in pairs_of_ids {
        let memory = if list == 0 {
            &mut solver.lists.slab_pairs.histories
        } else {
            &mut solver.lists.periodic_pairs.histories
        };
        if let Some(beam) = law.bond
            && gap <= beam.gap * mean
        {
            memory.bond[k].strength = strength(beam.scatter, &mut random);
            bonds += 1;
        }
        if let Some(AttractionLaw::Cohesion(_)) = law.attraction
            && gap < 0.0
        {
            memory.state[k] = CONTACT_BONDED;
        }
    }
    if wanted && bonds == 0 {
        let problem =
            "no two grains are near enough at the start to be bonded: fill more densely, or raise bond.gap";
        return Err(CaseError::new("methods.dem.pairs", problem));
    }
    Ok(())
}

/// Random factor on strengths, of a Weibull distribution of mean 1 and coefficient of variation `scatter`.
fn strength(scatter: f64, random: &mut ChaCha8Rng) -> f64 {
    if scatter == 0.0 {
        return 1.0;
    }
    // Weibull modulus from the coefficient of variation (Justus and Mikhail 1976, within 1 % from 0.1 to 1).
    let modulus = scatter.powf(-1.086);
    let draw: f64 = 1.0 - random.random::<f64>();
    (-draw.ln()).powf(1.0 / modulus) / crate::specimen::size_distributions::gamma(1.0 + 1.0 / modulus)
}

/// Laws of the regions of obstacle number `number`, which are stored after those of all walls and obstacles.
fn laws_of_regions<const D: usize, const R: usize>(
    solver: &DemSolver<D, R>,
    number: usize,
) -> Vec<Vec<PairLaw>> {
    let case = &solver.case;
    let before: usize = case.obstacles[..number].iter().map(|obstacle| obstacle.regions.len()).sum();
    let first = case.boundaries.len() + case.obstacles.len() + before;
    solver.laws.walls[first..first + case.obstacles[number].regions.len()].to_vec()
}

/// Walls present in a stage.
fn stage_walls<const D: usize, const R: usize>(solver: &DemSolver<D, R>, stage: usize) -> Vec<RigidWall<D>> {
    let case = &solver.case;
    let corner = |values: &[f64]| std::array::from_fn(|axis| values[axis]);
    let domain: ([f64; D], [f64; D]) = (corner(&case.domain.min), corner(&case.domain.max));
    let wall = |(number, boundary): (usize, &colluvium_case::description::Boundary)| RigidWall {
        surface: None,
        moving: None,
        boundary: number,
        name: boundary.name().to_owned(),
        axis: boundary.side.axis(),
        upper: boundary.side.is_max(),
        position: boundary.position(&case.domain),
        velocity: boundary.velocity.as_ref().map_or([0.0; D], |v| {
            let v = spatial(v);
            std::array::from_fn(|c| v[c])
        }),
        laws: solver.laws.walls[number].clone(),
        obstacle_laws: None,
        regions: Vec::new(),
        reaction: [[0.0; D]; 2],
        moment: [0.0; 3],
    };
    let obstacle = |(number, (surface, places)): (usize, &(Arc<dyn Surface<D>>, ObstacleLaws))| RigidWall {
        surface: Some(Arc::clone(surface)),
        obstacle_laws: (!places.is_uniform()).then(|| places.clone()),
        regions: laws_of_regions(solver, number),
        moving: case.obstacles[number]
            .motion
            .as_ref()
            .map(|motion| MovingObstacle::new(motion, surface, domain)),
        boundary: case.boundaries.len() + number,
        name: case.obstacles[number].name.clone(),
        axis: 0,
        upper: false,
        position: 0.0,
        velocity: [0.0; D],
        laws: solver.laws.walls[case.boundaries.len() + number].clone(),
        reaction: [[0.0; D]; 2],
        moment: [0.0; 3],
    };
    let obstacles = solver.obstacles.iter().enumerate().map(obstacle);
    case.active_boundaries(stage).into_iter().map(wall).chain(obstacles).collect()
}
