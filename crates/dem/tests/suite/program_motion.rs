//! Walls, bodies and cells that a program moves.

use colluvium_case::{Axis, Body, Boundary, Case, Domain, Side, Simulation, Solver, Space, Stage, Wall};
use colluvium_constitutive::LinearElasticSpec;
use colluvium_dem::{
    BodyGrains, CellControl, CellEntry, Dem, DemOptions, DemSolver, Diameters, Fill, GrainKind, GrainStage,
    LatticePacking, NormalLaw, PairSpec, WallServo,
};
use colluvium_testkit::{assert_near, scalar_output};

fn options() -> DemOptions {
    let fill = Fill::Lattice { packing: LatticePacking::Square, pitch: None, jitter: 0.0 };
    let kind = GrainKind::filled(2650.0, Diameters::Equal { value: 0.1 }, fill);
    DemOptions::new([("sand", kind)], [PairSpec::new(["sand", "sand"], NormalLaw::linear(1e6)).friction(0.4)])
}

/// Square of 5 times 5 disks between a floor and a platen, with a held ball at its side, in two stages.
fn press() -> Case {
    let floor = Boundary { position: Some(0.0), ..Boundary::new(Side::YMin, Wall::Smooth) };
    let platen = Boundary {
        name: Some("platen".to_owned()),
        position: Some(0.5),
        ..Boundary::new(Side::YMax, Wall::frictional(0.5))
    };
    Case::new(Space::PlaneStrain, Domain::new([-2.0, -2.0], [2.0, 2.0]))
        .material("sand", LinearElasticSpec::new(2650.0, 1e7, 0.3))
        .body(Body::block("block", "sand", [0.0, 0.0], [0.5, 0.5]))
        .body(Body::ball("ball", "sand", [1.0, 0.25], 0.1))
        .boundary(floor)
        .boundary(platen)
        .stage(Stage { damping: 0.3, ..Stage::new("press", 0.02) })
        .stage(Stage { damping: 0.3, ..Stage::new("hold", 0.02) })
}

fn press_options() -> DemOptions {
    let ball = BodyGrains { held: true, fill: Some(Fill::Single), ..BodyGrains::default() };
    DemOptions { bodies: [("ball".to_owned(), ball)].into(), ..options() }
}

fn solver(case: &Case) -> Simulation<DemSolver<2, 1>> {
    Dem::new(press_options()).solver::<2>(case).unwrap()
}

/// The platen moves as prescribed through the end of a stage, and its work is that on the grains.
#[test]
fn a_wall_moves_as_the_program_prescribes() {
    let mut solver = solver(&press());
    solver.set_wall_velocity("platen", [0.0, -0.2]).unwrap();
    let (mut travel, mut work, mut before) = (0.0, 0.0, 0.0);
    while !solver.is_complete() {
        let speed = if solver.time() < 0.015 { -0.2 } else { -0.05 * (1.0 + solver.time()) };
        solver.set_wall_velocity("platen", [0.0, speed]).unwrap();
        let dt = solver.step().unwrap().dt;
        let wall = solver.wall("platen").unwrap();
        assert_eq!(wall.velocity(), [0.0, speed]);
        // The force is that at the start of the step, before the displacement.
        work += 0.5 * (before + wall.force()[1]) * travel_of(&mut travel, dt * speed);
        before = wall.force()[1];
    }
    assert_near(solver.wall("platen").unwrap().position(), 0.5 + travel, 1e-12);
    let (platen, floor) = (solver.wall("platen").unwrap(), solver.wall("y-min").unwrap());
    assert!(platen.force()[1] > 100.0 && floor.force()[1] < -100.0);
    // Without walls at the sides the area is that of the domain, 4 m.
    assert_near(platen.area(), 4.0, 1e-12);
    assert_near(platen.normal_stress(), -platen.force()[1] / 4.0, 1e-9);
    let reaction = solver.reaction("platen").unwrap().force;
    assert_eq!(reaction[1], platen.force()[1]);
    assert!(work < -1.0 && work.is_finite());
    assert_near(-scalar_output(&*solver, "work.boundaries") / work, 1.0, 2e-2);
    assert_near(scalar_output(&*solver, "energy_error"), 0.0, 1e-2);
}

/// Adds a displacement to the travel, and returns the displacement before it.
fn travel_of(travel: &mut f64, more: f64) -> f64 {
    *travel += more;
    more
}

#[test]
fn prescribed_motion_is_in_a_checkpoint() {
    let end = |mut solver: Simulation<DemSolver<2, 1>>| {
        while !solver.is_complete() {
            solver.step().unwrap();
        }
        (solver.snapshot().hash(), solver.wall("platen").unwrap().position().to_bits())
    };
    let start = |time: f64| {
        let mut solver = solver(&press());
        solver.set_wall_velocity("platen", [0.1, -0.2]).unwrap();
        solver.set_body_velocity("ball", [-0.5, 0.0]).unwrap();
        solver.step_to(time).unwrap();
        solver
    };
    for time in [0.01, 0.02, 0.025] {
        let mut bytes = Vec::new();
        start(time).save(&mut bytes).unwrap();
        let mut second = solver(&press());
        second.restore(&mut bytes.as_slice()).unwrap();
        assert_eq!(end(start(time)), end(second), "{time}");
    }
    // Velocities that the last step has not had yet are in it too.
    let change = |mut solver: Simulation<DemSolver<2, 1>>| {
        solver.set_wall_velocity("platen", [-0.3, 0.1]).unwrap();
        solver
    };
    let mut bytes = Vec::new();
    change(start(0.01)).save(&mut bytes).unwrap();
    let mut second = solver(&press());
    second.restore(&mut bytes.as_slice()).unwrap();
    assert_eq!(end(change(start(0.01))), end(second));
}

#[test]
fn a_released_wall_follows_its_case_and_a_servo_waits_for_it() {
    let mut case = press();
    case.boundaries[1].velocity = Some(vec![0.0, -0.1]);
    let mut moved = solver(&case);
    moved.set_wall_velocity("platen", [0.0, 0.0]).unwrap();
    moved.step_to(0.005).unwrap();
    assert_near(moved.wall("platen").unwrap().position(), 0.5, 0.0);
    moved.release_wall("platen").unwrap();
    moved.step_to(0.015).unwrap();
    assert_near(moved.wall("platen").unwrap().position(), 0.499, 1e-9);

    let servo = GrainStage {
        walls: [("platen".to_owned(), WallServo { area: Some(0.5), ..WallServo::new(-1e3, 0.1) })].into(),
        ..GrainStage::default()
    };
    let options = DemOptions { stages: [("press".to_owned(), servo)].into(), ..press_options() };
    let mut served = Dem::new(options).solver::<2>(&press()).unwrap();
    served.set_wall_velocity("platen", [0.0, 0.05]).unwrap();
    served.step_to(0.01).unwrap();
    assert_near(served.wall("platen").unwrap().position(), 0.5005, 1e-9);
    served.release_wall("platen").unwrap();
    served.step_to(0.012).unwrap();
    assert!(served.wall("platen").unwrap().velocity()[1] < -0.09);
}

#[test]
fn a_body_moves_as_the_program_prescribes() {
    let mut solver = solver(&press());
    let at = |solver: &DemSolver<2, 1>| {
        let ball = solver.grains().body().iter().position(|body| *body == 1).unwrap();
        solver.grains().position()[ball]
    };
    solver.set_body_velocity("ball", [0.0, 1.0]).unwrap();
    solver.step_to(0.01).unwrap();
    assert_near(at(&solver)[1], 0.26, 1e-12);
    solver.set_body_velocity("ball", [1.0, 0.0]).unwrap();
    solver.step_to(0.03).unwrap();
    assert_near(at(&solver)[0], 1.02, 1e-12);
    solver.set_body_velocity("ball", [500.0, 0.0]).unwrap();
    assert!(solver.limit().dt < 1.1e-5, "a tenth of a radius in a step");
    solver.set_body_velocity("ball", [0.0, 0.0]).unwrap();
    solver.release_body("ball").unwrap();
    solver.step().unwrap();
    assert_near(at(&solver)[0], 1.02, 1e-12);
}

#[test]
fn motions_that_do_not_exist_are_refused() {
    let mut solver = solver(&press());
    let refusals = [
        (solver.set_wall_velocity("lid", [0.0, 0.0]).unwrap_err(), "boundaries: have no wall \"lid\""),
        (solver.set_wall_velocity("platen", [0.0, f64::NAN]).unwrap_err(), "boundaries[1].velocity: NaN"),
        (solver.release_wall("lid").unwrap_err(), "boundaries: have no wall \"lid\""),
        (solver.set_body_velocity("rock", [0.0, 0.0]).unwrap_err(), "bodies: have no body \"rock\""),
        (solver.set_body_velocity("block", [0.0, 0.0]).unwrap_err(), "methods.dem.bodies.block.held"),
        (solver.set_body_velocity("ball", [f64::INFINITY, 0.0]).unwrap_err(), "bodies[1].velocity: inf"),
        (solver.set_cell_gradient([[1.0, 0.0], [0.0, 0.0]]).unwrap_err(), "domain.periodic"),
    ];
    for (error, part) in refusals {
        assert!(error.to_string().contains(part), "{part}: {error}");
    }
    assert!(solver.wall("lid").is_none());
}

/// Periodic cell of a square lattice.
fn cell() -> Case {
    let domain = Domain { periodic: vec![Axis::X, Axis::Y], ..Domain::new([0.0; 2], [1.0; 2]) };
    Case::new(Space::PlaneStrain, domain)
        .material("sand", LinearElasticSpec::new(2650.0, 1e7, 0.3))
        .body(Body::block("block", "sand", [0.0, 0.0], [1.0, 1.0]))
        .stage(Stage::new("shear", 0.01))
}

#[test]
fn a_cell_deforms_as_the_program_prescribes() {
    let rates = CellControl {
        xx: Some(CellEntry::Rate(-0.5)),
        xy: Some(CellEntry::Rate(1.0)),
        ..CellControl::default()
    };
    let stage = GrainStage { cell: Some(rates), ..GrainStage::default() };
    let with_stage = DemOptions { stages: [("shear".to_owned(), stage)].into(), ..options() };
    let mut of_case = Dem::new(with_stage).solver::<2>(&cell()).unwrap();
    let start = || Dem::new(options()).solver::<2>(&cell()).unwrap();
    let mut of_program = start();
    of_program.set_cell_gradient([[-0.5, 1.0], [0.0, 0.0]]).unwrap();
    of_case.step_to(0.005).unwrap();
    of_program.step_to(0.005).unwrap();
    let mut bytes = Vec::new();
    of_program.save(&mut bytes).unwrap();
    let mut restored = start();
    restored.restore(&mut bytes.as_slice()).unwrap();
    of_case.step_to(0.01).unwrap();
    restored.step_to(0.01).unwrap();
    assert_eq!(of_case.snapshot().hash(), restored.snapshot().hash());
    // The strain of half a per cent in a lattice of the stiffness k gives a stress of k times the strain.
    assert_near(restored.cell_stress()[0][0] / (-1e6 * 0.005), 1.0, 0.1);
    let error = restored.set_cell_gradient([[0.0, 0.0], [1.0, 0.0]]).unwrap_err().to_string();
    assert!(error.contains("below the diagonal"), "{error}");
    restored.release_cell();
}
