//! Solvers that a program describes, steps, reads and changes.

use std::sync::Arc;

use colluvium_case::{
    Body, Case, CaseError, CaseErrorKind, CaseErrors, Domain, EquilibriumCriterion, FailureReason, Feature,
    Method, PointList, PoreFluid, Run, RunError, RunOptions, Shape, Side, Simulation, Solver, SolverError,
    Space, Stage, Wall,
};
use colluvium_constitutive::{DruckerPragerSpec, LinearElasticSpec, MaterialSpec};
use colluvium_mpm::{Mpm, MpmOptions, MpmSolver, ShapeFunctions, VelocityTransfer};

/// Options with cells of 5 cm.
fn options() -> MpmOptions {
    MpmOptions { shape: ShapeFunctions::Quadratic, ..MpmOptions::new(0.05) }
}

/// Block of soil that falls on a rough floor, in two stages.
fn falling_block() -> Case {
    let soil = DruckerPragerSpec { cohesion: 500.0, ..DruckerPragerSpec::new(1600.0, 1e6, 0.3, 25.0) };
    Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [0.6, 0.4]))
        .gravity([0.0, -10.0])
        .material("soil", soil)
        .body(Body::block("block", "soil", [0.1, 0.05], [0.3, 0.2]).velocity([0.5, -1.0]))
        .wall(Side::YMin, Wall::Rough)
        .wall(Side::XMax, Wall::frictional(0.3))
        .stage(Stage::new("fall", 0.01))
        .stage(Stage { damping: 0.2, ..Stage::new("damped", 0.02) })
}

/// Elastic ball in free space.
fn ball() -> Case {
    Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [1.0, 1.0]))
        .material("rubber", LinearElasticSpec::new(1000.0, 1e5, 0.3))
        .body(Body::ball("ball", "rubber", [0.5, 0.5], 0.2))
        .stage(Stage::new("flight", 0.1))
}

fn solver(case: &Case) -> Simulation<MpmSolver<2>> {
    Mpm::new(options()).solver::<2>(case).unwrap()
}

/// Hash after all stages, stepped by the program.
fn hash_at_end(mut solver: Simulation<MpmSolver<2>>) -> u64 {
    while !solver.is_complete() {
        solver.step().unwrap();
    }
    solver.snapshot().hash()
}

#[test]
fn a_case_of_a_program_has_the_bits_of_its_file() {
    let case = falling_block().method(&options());
    let read = Case::from_json(&case.to_json()).unwrap();
    assert_eq!(read, case);
    let hash = hash_at_end(solver(&case));
    assert_eq!(hash, hash_at_end(solver(&read)), "stepped by the program");
    assert_eq!(hash, colluvium_testkit::solve(&Mpm, &read).snapshot.hash(), "run from its file");
}

#[test]
fn options_of_a_program_are_those_of_a_file() {
    let case = falling_block().method(&options());
    let keys: Vec<&String> = case.methods["mpm"].as_object().unwrap().keys().collect();
    assert_eq!(keys, ["cell_size", "shape"], "options at their defaults are absent");
    let read: MpmOptions = serde_json::from_value(serde_json::json!({ "cell_size": 0.05 })).unwrap();
    assert_eq!(read, MpmOptions::new(0.05));
}

/// JSON has no such numbers: they must not become absent.
#[test]
fn options_that_are_not_finite_are_refused() {
    for (path, options) in [
        ("methods.mpm.time_step", MpmOptions { time_step: Some(f64::NAN), ..options() }),
        ("methods.mpm.time_step", MpmOptions { time_step: Some(f64::INFINITY), ..options() }),
        ("methods.mpm.cell_size", MpmOptions { cell_size: f64::NAN, ..options() }),
    ] {
        let error = Mpm::new(options).solver::<2>(&falling_block()).err().unwrap().to_string();
        assert!(error.starts_with(path) && error.contains("not a finite number"), "{error}");
    }
}

#[test]
fn bits_are_the_same_on_two_threads_and_after_a_restart_in_the_loop() {
    let case = falling_block();
    let hash = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| hash_at_end(solver(&case)))
    };
    let whole = hash(1);
    assert_eq!(whole, hash(2), "threads");
    for end in [0.004, 0.01, 0.017] {
        let mut first = solver(&case);
        while first.time() < end {
            first.step().unwrap();
        }
        let mut bytes = Vec::new();
        first.save(&mut bytes).unwrap();
        let mut second = solver(&case);
        second.restore(&mut bytes.as_slice()).unwrap();
        assert_eq!((first.stage(), first.time()), (second.stage(), second.time()));
        assert_eq!(whole, hash_at_end(second), "restart at {end} s");
    }
}

#[test]
fn views_are_slices_of_the_solver() {
    let mut solver = solver(&falling_block());
    solver.step().unwrap();
    let points = solver.points();
    let address = |slice: &[[f64; 2]]| slice.as_ptr();
    assert_eq!(address(points.velocity().slices()[0]), address(points.velocity().as_slice().unwrap()));
    let snapshot = solver.snapshot();
    let columns = points.id();
    for (k, id) in snapshot.ids.iter().enumerate() {
        let at = columns.iter().position(|own| u64::from(*own) == *id).unwrap();
        assert_eq!(points.position()[at][..], snapshot.positions[k][..2]);
    }
    let mass: f64 = points.mass().iter().sum();
    assert!((mass - 1600.0 * 0.2 * 0.15).abs() < 1e-9 * mass);
    assert!(points.density().all(|density| (density / 1600.0 - 1.0).abs() < 1e-2));
    let before = address(solver.points().velocity().slices()[0]);
    solver.velocities_mut().for_each(|v| *v = [0.0, 0.25]);
    assert_eq!(before, address(solver.points().velocity().slices()[0]));
    assert!(solver.points().velocity().iter().all(|v| *v == [0.0, 0.25]));
}

/// Shape functions are a partition of unity: the nodes have the mass and, in free flight, the momentum of the points.
#[test]
fn nodes_have_the_mass_and_the_momentum_of_the_points() {
    let case = Case { gravity: Vec::new(), ..ball() };
    let mut solver = Mpm::new(options()).solver::<2>(&case).unwrap();
    solver.velocities_mut().for_each(|v| *v = [0.7, -0.2]);
    assert_eq!(solver.nodes().count(), 0, "before the first step");
    solver.step().unwrap();
    let mass: f64 = solver.points().mass().iter().sum();
    let sum = |of: fn(&colluvium_mpm::MpmNode<2>) -> f64| {
        solver.nodes().map(|node| node.mass * of(&node)).sum::<f64>()
    };
    assert!((sum(|_| 1.0) / mass - 1.0).abs() < 1e-12);
    assert!((sum(|node| node.velocity[0]) / (0.7 * mass) - 1.0).abs() < 1e-12);
}

#[test]
fn outputs_of_laws_are_fields() {
    let mut solver = solver(&falling_block());
    solver.step_to(0.02).unwrap();
    let strains = solver.points().field("plastic_strain").unwrap();
    assert_eq!(strains.len(), solver.points().len());
    let largest = strains.iter().copied().fold(0.0, f64::max);
    assert!(strains.iter().all(|strain| *strain >= 0.0) && largest > 0.0, "{largest}");
    assert_eq!(solver.points().field("temperature"), None);
}

/// A uniform acceleration moves all points alike, with the velocity `g t`, as gravity does.
#[test]
fn a_uniform_body_force_is_free_fall() {
    let gravity = [0.3, -10.0];
    let mut fallen = Mpm::new(options()).solver::<2>(&ball().gravity(gravity)).unwrap();
    let mut pulled = Mpm::new(options()).solver::<2>(&ball()).unwrap();
    pulled.set_body_force(move |_, _, _| gravity).unwrap();
    for _ in 0..40 {
        let dt = fallen.limit().dt.min(pulled.limit().dt);
        fallen.step_at_most(dt).unwrap();
        pulled.step_at_most(dt).unwrap();
    }
    let of = |solver: &Simulation<MpmSolver<2>>| solver.points().velocity()[3];
    let (a, b, t) = (of(&fallen), of(&pulled), pulled.time());
    (0..2).for_each(|c| {
        assert!((a[c] - gravity[c] * t).abs() < 1e-9 && (b[c] - gravity[c] * t).abs() < 1e-9, "{a:?} {b:?}");
    });
}

#[test]
fn a_state_with_a_body_force_needs_it_again() {
    let drag = |_: &[f64; 2], v: &[f64; 2], _: f64| v.map(|v| -3.0 * v);
    let start = || {
        let mut solver = solver(&falling_block());
        solver.set_body_force(drag).unwrap();
        solver
    };
    let whole = hash_at_end(start());
    assert_ne!(whole, hash_at_end(solver(&falling_block())));
    let mut first = start();
    first.step_to(0.006).unwrap();
    let mut bytes = Vec::new();
    first.save(&mut bytes).unwrap();
    let error = solver(&falling_block()).restore(&mut bytes.as_slice()).unwrap_err().to_string();
    assert!(error.contains("set it before the state is restored"), "{error}");
    let mut second = start();
    second.restore(&mut bytes.as_slice()).unwrap();
    assert_eq!(hash_at_end(first), hash_at_end(second));
}

#[test]
fn an_infinite_body_force_leaves_the_state_as_it_was() {
    let mut solver = solver(&falling_block());
    solver.step().unwrap();
    let before = solver.snapshot().hash();
    let pull = |x: &[f64; 2], _: &[f64; 2], _: f64| [0.0, if x[0] > 0.2 { f64::INFINITY } else { 0.0 }];
    solver.set_body_force(pull).unwrap();
    let error = solver.step().unwrap_err().to_string();
    assert!(error.contains("body force of the program") && error.contains("point"), "{error}");
    assert_eq!(before, solver.snapshot().hash());
    let error = solver.step().unwrap_err().to_string();
    assert!(error.contains("an earlier step has failed"), "{error}");
}

#[test]
fn a_step_too_short_to_change_the_time_leaves_the_state_as_it_was() {
    let mut solver = solver(&falling_block());
    solver.step().unwrap();
    let before = solver.snapshot().hash();
    let error = solver.step_at_most(1e-17 * solver.time()).unwrap_err();
    assert!(error.to_string().contains("does not change the time"), "{error}");
    assert_eq!(solver.snapshot().hash(), before);
    solver.step().unwrap();
}

#[test]
fn a_simulation_whose_step_panicked_is_not_continued() {
    let mut solver = solver(&falling_block());
    solver.set_body_force(|_, _, _| panic!("a force of the program")).unwrap();
    let step = std::panic::AssertUnwindSafe(|| solver.step().map(|_| ()));
    assert!(std::panic::catch_unwind(step).is_err());
    solver.clear_body_force();
    assert!(matches!(solver.step(), Err(SolverError::Step { reason: FailureReason::HasFailed, .. })));
    assert!(solver.save(&mut Vec::new()).is_err());
}

#[test]
fn states_of_other_cases_and_damaged_ones_are_refused_and_leave_the_state_as_it_was() {
    let mut own = solver(&falling_block());
    let mut bytes = Vec::new();
    own.save(&mut bytes).unwrap();
    own.step().unwrap();
    let before = own.snapshot().hash();
    let mut other = Vec::new();
    solver(&ball()).save(&mut other).unwrap();
    let mut damaged = bytes.clone();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    for wrong in [&other, &damaged, &bytes[..middle].to_vec(), &Vec::new()] {
        assert!(matches!(own.restore(&mut wrong.as_slice()), Err(SolverError::Checkpoint(_))));
        assert_eq!(own.snapshot().hash(), before);
    }
    own.step().unwrap();
    own.restore(&mut bytes.as_slice()).unwrap();
}

/// Excavation belongs to the beginning of a stage, not to a restart.
#[test]
fn points_added_in_a_pit_at_its_excavation_are_there_after_a_restart() {
    let mut case = falling_block();
    case.stages[0].excavate = vec![Shape::Box { min: vec![0.1, 0.05], max: vec![0.2, 0.2] }];
    let mut dug = solver(&case);
    let list = PointList { positions: vec![[0.15, 0.1, 0.0]], volumes: vec![5e-4], ..PointList::default() };
    dug.add_points(0, &list).unwrap();
    let mut bytes = Vec::new();
    dug.save(&mut bytes).unwrap();
    let mut restored = solver(&case);
    restored.restore(&mut bytes.as_slice()).unwrap();
    assert_eq!(restored.points().len(), dug.points().len());
}

/// Cases that no file check has seen.
#[test]
fn runs_check_cases_before_they_build_them() {
    let material = falling_block().body(Body::block("other", "clay", [0.4, 0.2], [0.5, 0.3]));
    let mut stages = falling_block();
    stages.stages.clear();
    let mut domain = falling_block();
    (domain.domain.min, domain.domain.max) = (Vec::new(), Vec::new());
    for (case, path) in [(material, "bodies[1].material"), (stages, "stages"), (domain, "domain.min")] {
        let case = case.method(&options());
        assert_eq!(Mpm.build(&case).err().unwrap().path, path);
        let Err(RunError::Case(errors)) = Run::new(Arc::new(case), &Mpm, RunOptions::default()) else {
            panic!("{path} was accepted");
        };
        assert_eq!(errors.first().path, path);
    }
}

#[test]
fn the_end_of_the_stages_is_the_end_of_the_steps() {
    let mut solver = solver(&falling_block());
    let steps = solver.step_to(0.03).unwrap();
    assert!(steps > 5 && solver.is_complete() && (solver.time() - 0.03).abs() < 1e-12);
    for error in [solver.step().unwrap_err(), solver.step_to(0.04).unwrap_err()] {
        assert!(matches!(error, SolverError::Step { reason: FailureReason::IsComplete, .. }), "{error}");
        assert!(error.to_string().contains("the last stage has ended"), "{error}");
    }
    assert!(solver.step_to(f64::NAN).unwrap_err().to_string().contains("not finite"));
    assert!(solver.step_at_most(0.0).unwrap_err().to_string().contains("not positive"));
}

#[test]
fn a_stage_without_its_equilibrium_is_an_error() {
    let mut case = falling_block();
    case.stages[0].equilibrium = Some(EquilibriumCriterion::default());
    let error = solver(&case).step_to(0.02).unwrap_err().to_string();
    assert!(error.starts_with("stages[0]: no equilibrium within its duration of 0.01 s"), "{error}");
    case.stages[0].equilibrium =
        Some(EquilibriumCriterion { required: false, ..EquilibriumCriterion::default() });
    solver(&case).step_to(0.02).unwrap();
}

/// Each nonsense of a program is refused with the path that a file has.
#[test]
fn nonsense_is_refused_with_the_path_of_a_file() {
    let refusal = |case: &Case, options: MpmOptions| -> String {
        let result: Result<Simulation<MpmSolver<2>>, CaseErrors> = Mpm::new(options).solver::<2>(case);
        result.err().expect("an error").to_string()
    };
    let soil = LinearElasticSpec::new(-1.0, 1e6, 0.3);
    let cases = [
        ("materials.soil.density", falling_block().material("soil", soil), options()),
        (
            "materials.soil.density",
            falling_block().material("soil", LinearElasticSpec::new(f64::NAN, 1e6, 0.3)),
            options(),
        ),
        ("bodies[1].material", falling_block().body(Body::ball("b", "ice", [0.5, 0.3], 0.05)), options()),
        ("bodies[1].shape", falling_block().body(Body::ball("b", "soil", [0.5, 0.3], -0.05)), options()),
        ("bodies[1].shape", falling_block().body(Body::ball("b", "soil", [0.5, f64::NAN], 0.05)), options()),
        ("stages[2].duration", falling_block().stage(Stage::new("s", f64::INFINITY)), options()),
        ("gravity", falling_block().gravity([0.0, 0.0, -10.0]), options()),
        ("methods.mpm.cell_size", falling_block(), MpmOptions::new(f64::NAN)),
        ("methods.mpm.cell_size", falling_block(), MpmOptions::new(0.07)),
        ("stages", Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [1.0, 1.0])), options()),
    ];
    for (path, case, options) in cases {
        let error = refusal(&case, options);
        assert!(error.contains(path), "{path}: {error}");
    }
    let error = Mpm::new(options()).solver::<3>(&falling_block()).err().unwrap().to_string();
    assert!(error.contains("space: gives a solver of 2 dimensions, and one of 3 was requested"), "{error}");
}

#[test]
fn a_law_of_the_program_is_a_material() {
    let law = MaterialSpec::from(LinearElasticSpec::new(1600.0, 1e6, 0.3)).build().unwrap();
    let own = falling_block().law("soil", 1600.0, Arc::clone(&law));
    let listed = falling_block().material("soil", LinearElasticSpec::new(1600.0, 1e6, 0.3));
    assert_eq!(hash_at_end(solver(&own)), hash_at_end(solver(&listed)));
    let error = Case::from_json(&own.to_json()).and_then(|case| {
        Mpm::new(MpmOptions { transfer: VelocityTransfer::Apic, ..options() }).solver::<2>(&case).map(|_| ())
    });
    let error = error.unwrap_err().to_string();
    assert!(error.contains("materials.soil") && error.contains("\"soil\" is not available here"), "{error}");
}

/// Advice for the first error of a case, by its kind.
fn advice(errors: &CaseErrors) -> String {
    let CaseError { path, kind } = errors.first();
    match kind {
        CaseErrorKind::OutOfRange { value, rule } => format!("{path}: {value} {rule}"),
        CaseErrorKind::NotSupported { feature: Feature::BodiesPoreFluid, method, .. } => {
            format!("{path}: take another method than {method}")
        }
        CaseErrorKind::UnknownName { suggestion: Some(name), .. } => format!("{path}: {name}?"),
        other => format!("{path}: {other}"),
    }
}

/// The example of the documentation of errors.
#[test]
fn errors_of_a_case_are_matched_by_kind() {
    let of = |case: &Case, options: MpmOptions| -> String {
        let result: Result<Simulation<MpmSolver<2>>, CaseErrors> = Mpm::new(options).solver::<2>(case);
        advice(&result.err().expect("an error"))
    };
    let found = of(&falling_block(), MpmOptions { courant: 2.0, ..options() });
    assert_eq!(found, "methods.mpm.courant: 2 is not in 0..=1 (0 excluded)");
    let mut stage = Stage::new("later", 0.1);
    stage.remove_bodies.push("blok".to_owned());
    assert_eq!(of(&falling_block().stage(stage), options()), "stages[2].remove_bodies[0]: block?");
    let mut wet = falling_block();
    wet.bodies[0].pore_fluid = Some(PoreFluid::new(0.3, 1e-4));
    let found = of(&wet, MpmOptions { shape: ShapeFunctions::DualDomain, ..options() });
    assert_eq!(found, "bodies[0].pore_fluid: take another method than mpm");
}
