//! Setup: from a case to a solver; rejects what the method does not support, by JSON path.

mod body_grains;
mod capabilities;
mod initial_bonds;
mod pair_laws;
mod point_changes;
mod problem_size;
mod sleeve_rings;
pub(crate) mod stage_changes;
mod start_checks;
mod stress_checks;
mod walls;
mod warnings;

use std::collections::BTreeMap;

use colluvium_case::{Case, CaseError, CaseErrorKind, PlacedObstacle, Plan, Solver};

pub(crate) use crate::setup::capabilities::capabilities;
pub(crate) use crate::setup::problem_size::problem_size;

use crate::boundary::body_force::ProgramForce;
use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::boundary::controlled_cell::ControlledCell;
use crate::boundary::membranes::Membranes;
use crate::boundary::periodic_cell::PeriodicCell;
use crate::clock::Clock;
use crate::config::{DemOptions, GrainKind};
use crate::contact::contact_histories::HistoryColumns;
use crate::contact::contact_laws::{ContactLaws, GrainSizes, KindProperties};
use crate::neighbours::grain_neighbours::GrainNeighbours;
use crate::output::energy_balance::EnergyBalance;
use crate::output::records::Records;
use crate::output::stress_control_check::ControlledStress;
use crate::points::grain_extremes::GrainExtremes;
use crate::points::grains::{Grains, volume};
use crate::setup::initial_bonds::initialise_bonds;
use crate::setup::start_checks::{check_overlaps, check_stages, check_step};
use crate::setup::walls::stage_walls;
use crate::solver::{DemSolver, Workspace};
use crate::specimen::file::StoredSpecimen;
use crate::specimen::fill_report::fill_reports;
use crate::specimen::pluviation;
use crate::specimen::specimen_preparation::{SpecimenPreparation, SpecimenSource};

/// Memory of a disk and of a sphere during a run (bytes), with buffers and pairs.
const BYTES_OF_GRAIN: [usize; 2] = [650, 1000];

/// Options of the case, validated.
pub(crate) fn options(case: &Case) -> Result<DemOptions, CaseError> {
    if !case.methods.contains_key("dem") {
        let problem = "is missing: the discrete element method needs at least its `grains` and `pairs`";
        return Err(CaseError::new("methods.dem", CaseErrorKind::missing_input("dem", problem)));
    }
    capabilities::reject_clumps(&case.methods["dem"])?;
    let options: DemOptions = case.method_options("dem")?;
    options
        .validate(case.dimension())
        .map_err(|(path, problem)| CaseError::new(format!("methods.dem.{path}"), problem))?;
    capabilities::check_supported(case, &options)?;
    Ok(options)
}

/// Solver of a case.
pub fn build(case: &Case) -> Result<Box<dyn Solver>, CaseError> {
    Ok(match case.dimension() {
        3 => Box::new(solver::<3, 3>(case)?),
        _ => Box::new(solver::<2, 1>(case)?),
    })
}

/// Plan of a case: number of grains, steps and memory, with warnings.
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

/// Plan of a case in `D` dimensions, from its solver with all grains.
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
    let mut grains = Grains::default();
    let obstacles = case.placed_obstacles::<D>()?;
    let stored = StoredSpecimen::of_case(case, &options)?;
    body_grains::fill(case, &options, stored.as_ref(), &obstacles, &mut grains)?;
    check_covered(case, &obstacles, &grains)?;
    let laws = contact_laws(case, &options, &grains)?;
    let cell = stored.as_ref().map_or_else(|| Ok(domain(case)), |stored| stored.cell(case, domain(case)))?;
    let obstacles: Vec<_> = obstacles.into_iter().map(|obstacle| (obstacle.surface, obstacle.laws)).collect();
    let walls = stage_walls(case, &laws.stage, &obstacles, 0);
    let mut solver = DemSolver {
        extremes: GrainExtremes::at_start(&grains),
        cell: ControlledCell::new(cell),
        boundary: BoundaryConditions {
            walls,
            obstacles,
            membranes: Membranes::default(),
            body_force: ProgramForce::default(),
            body_velocities: BTreeMap::new(),
        },
        neighbours: GrainNeighbours {
            skin: options.skin * mean_diameter(case, &options, &grains),
            ..GrainNeighbours::default()
        },
        records: Records {
            energy_balance: EnergyBalance::default(),
            broken_bonds: Vec::new(),
            controlled_stresses: vec![ControlledStress::default(); D * D + case.boundaries.len()],
        },
        specimen: SpecimenPreparation {
            sources: pluviation::sources(case, &options),
            next_id: body_grains::next_id(&grains),
            reports: Vec::new(),
            source: SpecimenSource::default(),
        },
        workspace: Workspace::default(),
        clock: Clock::new(case, options),
        laws,
        grains,
    };
    stored.map_or(Ok(()), |stored| restore_contacts(&stored, case, &mut solver))?;
    check_step(&solver.clock, &solver.laws)?;
    check_stages(&solver)?;
    solver.build_lists().map_err(|error| {
        CaseError::new("methods.dem", CaseErrorKind::coded(error.code(), error.to_string()))
    })?;
    check_overlaps(&solver)?;
    let DemSolver { clock, laws, grains, cell, neighbours, specimen, .. } = &mut solver;
    initialise_bonds(clock, laws, grains, &cell.geometry, &mut neighbours.pairs, &specimen.source)?;
    solver.specimen.reports = fill_reports(&solver.view(), &solver.specimen);
    Ok(solver)
}

/// Restores the contacts of a specimen file, and the length of its last step.
fn restore_contacts<const D: usize, const R: usize>(
    stored: &StoredSpecimen,
    case: &Case,
    solver: &mut DemSolver<D, R>,
) -> Result<(), CaseError> {
    let DemSolver { clock, laws, grains, cell, boundary, neighbours, records, specimen, .. } = solver;
    clock.last_step = stored.last_step(case)?;
    records.energy_balance.continue_from_other_run();
    let grains = (&*grains, laws.columns);
    stored.restore_contacts(case, grains, cell, &mut boundary.walls, neighbours, &mut specimen.source)
}

/// Kinds of grains with their contact laws at the start.
fn contact_laws<const D: usize, const R: usize>(
    case: &Case,
    options: &DemOptions,
    grains: &Grains<D, R>,
) -> Result<ContactLaws, CaseError> {
    let kind =
        |(name, kind): (&String, &GrainKind)| KindProperties { name: name.clone(), density: kind.density };
    let kinds: Vec<KindProperties> = options.grains.iter().map(kind).collect();
    let sizes = GrainSizes::of_grains(grains, kinds.len());
    let stage = pair_laws::laws::<D>(case, options, &kinds, &sizes, 0)?;
    let columns = HistoryColumns::for_laws(
        &stage.pairs.iter().chain(stage.walls.iter().flatten()).copied().collect::<Vec<_>>(),
    );
    Ok(ContactLaws { kinds, sizes, stage, columns, scalar_only: false })
}

/// Periodic cell of the domain.
fn domain<const D: usize>(case: &Case) -> PeriodicCell<D> {
    let corner = |values: &[f64]| std::array::from_fn(|axis| values[axis]);
    let periodic = std::array::from_fn(|axis| case.domain.is_periodic(axis));
    PeriodicCell::new(corner(&case.domain.min), corner(&case.domain.max), periodic)
}

/// Mean diameter of the initial grains, or of those that will enter (m).
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
    obstacles: &[PlacedObstacle<'_, D>],
    grains: &Grains<D, R>,
) -> Result<(), CaseError> {
    for body in 0..case.bodies.len() {
        let of_body = (0..grains.len()).filter(|&i| grains.body[i] as usize == body && !grains.is_held[i]);
        let places: Vec<[f64; D]> = of_body.map(|i| grains.position[i]).collect();
        case.reject_overlapping_points(obstacles, body, &places, 0.0)?;
    }
    Ok(())
}
