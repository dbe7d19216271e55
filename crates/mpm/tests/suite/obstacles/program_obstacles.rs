//! Obstacles that a program moves.

use colluvium_case::description::{ObstacleMotion, ObstacleShape, ObstacleWall};
use colluvium_case::{Body, Case, Domain, Obstacle, Simulation, Solver, Space, Stage};
use colluvium_constitutive::LinearElasticSpec;
use colluvium_mpm::{Mpm, MpmOptions, MpmSolver, ObstacleCoupling, ShapeFunctions};

/// Elastic block before a plane with a velocity (m/s).
fn block_before_a_plane(velocity: f64) -> Case {
    let shape = ObstacleShape::Plane { point: vec![0.2, 0.0], normal: vec![1.0, 0.0] };
    let motion = ObstacleMotion { velocity: vec![velocity, 0.0], ..ObstacleMotion::default() };
    Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [1.0, 0.4]))
        .material("rubber", LinearElasticSpec::new(1000.0, 1e5, 0.3))
        .body(Body::block("block", "rubber", [0.2, 0.1], [0.4, 0.3]))
        .obstacle(Obstacle {
            motion: Some(motion),
            separation: true,
            ..Obstacle::new("piston", shape.clone(), ObstacleWall::Smooth)
        })
        .obstacle(Obstacle {
            shape: ObstacleShape::Plane { point: vec![0.95, 0.0], normal: vec![-1.0, 0.0] },
            ..Obstacle::new("stop", shape, ObstacleWall::Smooth)
        })
        .stage(Stage::new("push", 0.03))
}

fn solver(velocity: f64) -> Simulation<MpmSolver<2>> {
    let options = MpmOptions {
        shape: ShapeFunctions::Quadratic,
        obstacles: ObstacleCoupling::Points,
        ..MpmOptions::new(0.02)
    };
    Mpm::new(options).solver::<2>(&block_before_a_plane(velocity)).unwrap()
}

/// Momentum of the block along x (N s).
fn momentum(solver: &Simulation<MpmSolver<2>>) -> f64 {
    solver.points().velocity().iter().zip(solver.points().mass().iter()).map(|(v, m)| m * v[0]).sum()
}

#[test]
fn a_velocity_of_the_program_acts_as_that_of_the_case() {
    let mut by_case = solver(2.0);
    let mut by_program = solver(0.0);
    by_program.set_obstacle_velocity("piston", [2.0, 0.0]).unwrap();
    while !by_case.is_complete() {
        let dt = by_case.step().unwrap().dt;
        by_program.step_at_most(dt).unwrap();
    }
    let (a, b) = (momentum(&by_case), momentum(&by_program));
    assert!(a > 1.0 && (a / b - 1.0).abs() < 1e-9, "{a} {b} N s");
}

#[test]
fn a_block_is_left_by_an_obstacle_that_withdraws() {
    let mut solver = solver(2.0);
    solver.step_to(0.01).unwrap();
    solver.set_obstacle_velocity("piston", [-5.0, 0.0]).unwrap();
    // Beyond the reach of contacts.
    solver.step_to(0.022).unwrap();
    let free = momentum(&solver);
    solver.step_to(0.03).unwrap();
    assert!(free > 0.1 && (momentum(&solver) / free - 1.0).abs() < 1e-9, "{} {free}", momentum(&solver));
}

#[test]
fn motions_of_the_program_are_in_checkpoints() {
    let start = || {
        let mut solver = solver(2.0);
        solver.step_to(0.008).unwrap();
        solver.set_obstacle_velocity("piston", [1.0, 0.0]).unwrap();
        solver.step_to(0.012).unwrap();
        solver.set_obstacle_velocity("piston", [3.0, 0.5]).unwrap();
        solver
    };
    let mut whole = start();
    let mut bytes = Vec::new();
    whole.save(&mut bytes).unwrap();
    let mut restored = solver(2.0);
    restored.restore(&mut bytes.as_slice()).unwrap();
    for solver in [&mut whole, &mut restored] {
        solver.step_to(0.03).unwrap();
    }
    assert_eq!(whole.snapshot().hash(), restored.snapshot().hash());
}

#[test]
fn invalid_motions_are_refused_by_path() {
    let mut solver = solver(0.0);
    for (name, velocity, path) in [
        ("ram", 1.0, "obstacles"),
        ("stop", 1.0, "obstacles[1].motion"),
        ("piston", f64::NAN, "obstacles[0].motion.velocity"),
    ] {
        assert_eq!(solver.set_obstacle_velocity(name, [velocity, 0.0]).unwrap_err().path, path);
    }
}
