//! Points that a program adds and removes while it steps.

use colluvium_case::{
    Body, Case, Domain, PointList, Side, Simulation, Solver, SolverError, Space, Stage, Wall,
};
use colluvium_constitutive::DruckerPragerSpec;
use colluvium_sph::{Kernel, LagrangianFormulation, Sph, SphOptions, SphSolver};
use colluvium_testkit::assert_near;

/// Block of soil that falls on a rough floor.
fn falling_block() -> Case {
    let soil = DruckerPragerSpec { cohesion: 500.0, ..DruckerPragerSpec::new(1600.0, 1e6, 0.3, 25.0) };
    Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [0.6, 0.4]))
        .gravity([0.0, -10.0])
        .material("soil", soil)
        .body(Body::block("block", "soil", [0.1, 0.05], [0.3, 0.2]).velocity([0.5, -1.0]))
        .wall(Side::YMin, Wall::Rough)
        .stage(Stage::new("fall", 0.02))
}

fn options() -> SphOptions {
    SphOptions { kernel: Kernel::WendlandC2, smoothing: 1.5, ..SphOptions::new(0.025) }
}

fn solver() -> Simulation<SphSolver<2>> {
    Sph::new(options()).solver::<2>(&falling_block()).unwrap()
}

/// Points beside the block.
fn points() -> PointList {
    PointList {
        positions: vec![[0.45, 0.35, 0.0], [0.55, 0.35, 0.0], [0.25, 0.215, 0.0]],
        volumes: vec![6e-4, 6e-4, 5e-4],
        velocities: Some(vec![[0.0; 3], [0.0; 3], [0.5, -1.0, 0.0]]),
        ..PointList::default()
    }
}

/// Solver to which points have been added at 4 ms.
fn grown() -> Simulation<SphSolver<2>> {
    let mut solver = solver();
    solver.step_to(0.004).unwrap();
    solver.add_points(0, &points()).unwrap();
    solver
}

/// Hash after all stages.
fn hash_at_end(mut solver: Simulation<SphSolver<2>>) -> u64 {
    while !solver.is_complete() {
        solver.step().unwrap();
    }
    solver.snapshot().hash()
}

#[test]
fn added_points_have_their_mass_and_fall_freely() {
    let mut solver = solver();
    solver.step_to(0.004).unwrap();
    let mass = |solver: &Simulation<SphSolver<2>>| solver.particles().mass().iter().sum::<f64>();
    let (before, count) = (mass(&solver), solver.particles().len() as u32);
    assert_eq!(solver.add_points(0, &points()).unwrap(), count..count + 3);
    assert_near(mass(&solver) - before, 1600.0 * 1.7e-3, 1e-12);
    let start = solver.velocity_time();
    solver.step_to(0.02).unwrap();
    let at = solver.particles().id().iter().position(|id| *id == count).unwrap();
    let velocity = solver.particles().velocity()[at];
    assert!(
        (velocity[1] + 10.0 * (solver.velocity_time() - start)).abs() < 1e-12 && velocity[0].abs() < 1e-12,
        "{velocity:?}"
    );
}

#[test]
fn bits_with_added_points_are_the_same_on_two_threads_and_after_a_restart() {
    let whole = hash_at_end(grown());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    assert_eq!(whole, pool.install(|| hash_at_end(grown())));
    let mut bytes = Vec::new();
    grown().save(&mut bytes).unwrap();
    let mut restored = solver();
    restored.restore(&mut bytes.as_slice()).unwrap();
    assert_eq!(
        restored.add_points(0, &PointList::default()).unwrap().start,
        grown().particles().len() as u32
    );
    assert_eq!(whole, hash_at_end(restored));
}

#[test]
fn removed_points_are_gone_and_their_numbers_are_not_used_again() {
    let mut solver = grown();
    let end = solver.particles().len() as u32;
    let removed = [end - 1, 0, end - 3, end - 2];
    solver.remove_points(&removed).unwrap();
    assert_eq!(solver.particles().len() as u32, end - 4);
    assert!(!solver.particles().id().iter().any(|id| removed.contains(id)));
    assert_eq!(solver.add_points(0, &points()).unwrap(), end..end + 3);
    let all = solver.particles().id().to_vec();
    solver.remove_points(&all).unwrap();
    assert!(solver.particles().is_empty());
    assert!(matches!(solver.step(), Err(SolverError::TimeStep(_))), "no material moves");
    assert_eq!(solver.add_points(0, &points()).unwrap_err().path, "body");
}

#[test]
fn invalid_changes_are_refused_and_leave_the_state_as_it_was() {
    let mut solver = grown();
    let before = solver.snapshot().hash();
    let outside = PointList { positions: vec![[0.7, 0.1, 0.0]; 3], ..points() };
    let short = PointList { volumes: vec![6e-4; 2], ..points() };
    for (body, list, path) in
        [(0, outside, "points.positions[0]"), (0, short, "points.volumes"), (1, points(), "body")]
    {
        assert_eq!(solver.add_points(body, &list).unwrap_err().path, path);
    }
    assert_eq!(solver.remove_points(&[3, 4000]).unwrap_err().path, "ids[1]");
    assert_eq!(before, solver.snapshot().hash());
    let options = SphOptions { formulation: LagrangianFormulation::TotalLagrangian, ..options() };
    let case = Case { boundaries: Vec::new(), ..falling_block() };
    let mut anchored = Sph::new(options).solver::<2>(&case).unwrap();
    for error in [anchored.add_points(0, &points()).unwrap_err(), anchored.remove_points(&[0]).unwrap_err()] {
        assert_eq!(error.path, "methods.sph.formulation");
    }
}
