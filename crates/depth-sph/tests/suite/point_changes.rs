//! Points that a program adds and removes while it steps.

use colluvium_case::{
    Body, Case, Domain, PointList, Side, Simulation, Solver, SolverError, Space, Stage, Wall,
};
use colluvium_constitutive::MohrCoulombSpec;
use colluvium_depth_sph::{DepthOptions, DepthSolver, DepthSph, ThicknessEquation};
use colluvium_testkit::assert_near;

/// Column of sand that is released on a rough floor.
fn column() -> Case {
    Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [10.0, 2.0]))
        .gravity([0.0, -9.81])
        .material("sand", MohrCoulombSpec::new(1600.0, 1e7, 0.3, 30.0))
        .body(Body::block("column", "sand", [0.0, 0.0], [2.0, 1.0]))
        .wall(Side::XMin, Wall::Smooth)
        .wall(Side::YMin, Wall::Rough)
        .stage(Stage::new("release", 0.4))
}

fn solver() -> Simulation<DepthSolver<1>> {
    DepthSph::new(DepthOptions::new(0.05)).solver::<1>(&column()).unwrap()
}

/// Nodes in front of the column.
fn nodes() -> PointList {
    let positions: Vec<[f64; 3]> = (0..20).map(|i| [5.0 + 0.05 * f64::from(i), 0.0, 0.0]).collect();
    PointList { volumes: vec![0.02; positions.len()], positions, ..PointList::default() }
}

/// Solver to which nodes have been added at 0.1 s.
fn grown() -> Simulation<DepthSolver<1>> {
    let mut solver = solver();
    solver.step_to(0.1).unwrap();
    solver.add_points(0, &nodes()).unwrap();
    solver
}

/// Hash after all stages.
fn hash_at_end(mut solver: Simulation<DepthSolver<1>>) -> u64 {
    while !solver.is_complete() {
        solver.step().unwrap();
    }
    solver.snapshot().hash()
}

#[test]
fn added_nodes_have_their_volume_and_their_depth() {
    let mut solver = solver();
    solver.step_to(0.1).unwrap();
    let volume = |solver: &Simulation<DepthSolver<1>>| solver.nodes().volume().iter().sum::<f64>();
    let (before, count) = (volume(&solver), solver.nodes().len() as u64);
    assert_eq!(solver.add_points(0, &nodes()).unwrap(), count..count + 20);
    assert_near(volume(&solver) - before, 0.4, 1e-12);
    solver.step().unwrap();
    let middle = solver.nodes().id().iter().position(|id| *id == count + 10).unwrap();
    // Twenty nodes of 0.02 m² on 0.05 m each have a depth of 0.4 m in the middle.
    assert_near(solver.nodes().depth()[middle], 0.4, 0.01);
    let by_mass = PointList { masses: Some(vec![32.0; 20]), ..nodes() };
    let mut heavy = grown();
    heavy.remove_points(&(count..count + 20).collect::<Vec<_>>()).unwrap();
    heavy.add_points(0, &by_mass).unwrap();
    assert_near(volume(&heavy) - before, 0.4, 1e-12);
}

#[test]
fn bits_with_added_nodes_are_the_same_on_two_threads_and_after_a_restart() {
    let whole = hash_at_end(grown());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    assert_eq!(whole, pool.install(|| hash_at_end(grown())));
    let mut bytes = Vec::new();
    grown().save(&mut bytes).unwrap();
    let mut restored = solver();
    restored.restore(&mut bytes.as_slice()).unwrap();
    assert_eq!(whole, hash_at_end(restored));
}

#[test]
fn invalid_changes_are_refused_and_leave_the_state_as_it_was() {
    let mut solver = grown();
    let before = solver.snapshot().hash();
    let outside = PointList { positions: vec![[12.0, 0.0, 0.0]; 20], ..nodes() };
    let stressed = PointList { stresses: Some(vec![colluvium_constitutive::SymTensor::ZERO; 20]), ..nodes() };
    for (list, path) in [(outside, "points.positions[0]"), (stressed, "points.stresses")] {
        assert_eq!(solver.add_points(0, &list).unwrap_err().path, path);
    }
    assert_eq!(solver.remove_points(&[3, 4000]).unwrap_err().path, "ids[1]");
    assert_eq!(before, solver.snapshot().hash());
    let options = DepthOptions { continuity: ThicknessEquation::RateDifference, ..DepthOptions::new(0.05) };
    let mut integrated = DepthSph::new(options).solver::<1>(&column()).unwrap();
    assert_eq!(integrated.add_points(0, &nodes()).unwrap_err().path, "methods.depth-sph.continuity");
}

#[test]
fn a_flow_without_nodes_has_no_step() {
    let mut solver = grown();
    let all: Vec<u64> = solver.nodes().id().iter().copied().collect();
    solver.remove_points(&all).unwrap();
    assert!(solver.nodes().is_empty());
    assert!(matches!(solver.step(), Err(SolverError::TimeStep(_))), "no material moves");
}
