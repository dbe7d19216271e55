//! Rigid bodies that a program moves.

use colluvium_case::{Body, Case, Domain, PrescribedMotion, Simulation, Solver, Space, Stage};
use colluvium_constitutive::LinearElasticSpec;
use colluvium_sph::{Kernel, Sph, SphOptions, SphSolver};

/// Solver of an elastic block beside a rigid piston that the case moves at a velocity (m/s).
fn solver(velocity: f64) -> Simulation<SphSolver<2>> {
    let rubber = LinearElasticSpec::new(1000.0, 1e5, 0.3);
    let piston = Body { rigid: true, ..Body::block("piston", "rubber", [0.1, 0.1], [0.2, 0.3]) };
    let case = Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [1.0, 0.4]))
        .material("rubber", rubber)
        .body(Body::block("block", "rubber", [0.2, 0.1], [0.4, 0.3]))
        .body(piston)
        .stage(Stage {
            motions: vec![PrescribedMotion::new("piston", [velocity, 0.0])],
            ..Stage::new("push", 0.03)
        });
    Sph::new(SphOptions { kernel: Kernel::WendlandC2, smoothing: 1.5, ..SphOptions::new(0.02) })
        .solver::<2>(&case)
        .unwrap()
}

#[test]
fn a_velocity_of_the_program_acts_on_a_body_as_that_of_the_case() {
    let mut by_case = solver(2.0);
    let mut by_program = solver(0.0);
    by_program.set_body_velocity("piston", [2.0, 0.0]).unwrap();
    while !by_case.is_complete() {
        let dt = by_case.step_at_most(1e-4).unwrap().dt;
        by_program.step_at_most(dt).unwrap();
    }
    let front = |solver: &Simulation<SphSolver<2>>| {
        solver.particles().position().iter().map(|x| x[0]).fold(0.0, f64::max)
    };
    let (a, b) = (front(&by_case), front(&by_program));
    // The body of the program moves half a step earlier.
    assert!(a > 0.4 && (a - b).abs() < 1e-5, "{a} {b} m");
    assert!(by_program.reaction("piston").unwrap().force[0] < 0.0, "the block is pushed by the piston");
}

#[test]
fn velocities_of_bodies_by_the_program_are_in_checkpoints_and_are_released() {
    let start = || {
        let mut solver = solver(2.0);
        solver.step_to(0.008).unwrap();
        solver.set_body_velocity("piston", [3.0, 0.5]).unwrap();
        solver.step_to(0.012).unwrap();
        solver
    };
    let mut whole = start();
    let mut bytes = Vec::new();
    whole.save(&mut bytes).unwrap();
    let mut restored = solver(2.0);
    restored.restore(&mut bytes.as_slice()).unwrap();
    for solver in [&mut whole, &mut restored] {
        solver.step_to(0.02).unwrap();
        solver.release_body("piston").unwrap();
        solver.step_to(0.03).unwrap();
    }
    assert_eq!(whole.snapshot().hash(), restored.snapshot().hash());
    // 0.02 s at 2 m/s of the case, 0.012 s less 0.008 s and 0.008 s at 3 m/s.
    let piston = restored.particles();
    let least = piston.position().iter().map(|x| x[0]).fold(f64::INFINITY, f64::min);
    let start = solver(2.0).particles().position().iter().map(|x| x[0]).fold(f64::INFINITY, f64::min);
    assert!((least - start - (0.018 * 2.0 + 0.012 * 3.0)).abs() < 0.002, "{least}");
}

#[test]
fn bodies_that_move_by_themselves_and_unknown_ones_are_refused() {
    let mut solver = solver(0.0);
    let before = solver.snapshot().hash();
    for (name, velocity, path) in
        [("pistom", 1.0, "bodies"), ("block", 1.0, "bodies[0]"), ("piston", f64::NAN, "bodies[1].velocity")]
    {
        assert_eq!(solver.set_body_velocity(name, [velocity, 0.0]).unwrap_err().path, path);
    }
    assert_eq!(solver.release_body("block").unwrap_err().path, "bodies[0]");
    assert_eq!(solver.snapshot().hash(), before);
}
