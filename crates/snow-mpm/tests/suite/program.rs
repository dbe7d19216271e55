//! Solvers that a program describes, steps, reads and changes.

use std::sync::Arc;

use colluvium_case::{
    Body, Case, CaseErrors, Domain, FailureReason, Side, Simulation, Solver, SolverError, Space, Stage,
    TypedMethod, Wall,
};
use colluvium_constitutive::{
    CohesiveCamClaySpec, InitialCondition, Law, LinearElasticSpec, MaterialError, MaterialSpec, Motion,
    Point, PointLaw, StressUpdate, SymTensor,
};
use colluvium_snow_mpm::{SnowMpm, SnowOptions, SnowSolver, SnowTransfer, SplineShape};
use colluvium_testkit::scalar_output;

/// Options with cells of 4 cm.
fn options() -> SnowOptions {
    SnowOptions { shape: SplineShape::Quadratic, ..SnowOptions::new(0.04) }
}

/// Snow that is yielding soon.
fn snow() -> CohesiveCamClaySpec {
    CohesiveCamClaySpec { cohesion_ratio: 0.3, ..CohesiveCamClaySpec::new(400.0, 3e6, 0.3, 1.2, 3000.0, 1.0) }
}

/// Block of snow that falls on a rough floor, in two stages.
fn falling_block() -> Case {
    Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [0.6, 0.4]))
        .gravity([0.0, -10.0])
        .material("snow", snow())
        .body(Body::block("block", "snow", [0.1, 0.08], [0.3, 0.24]).velocity([0.5, -3.0]))
        .wall(Side::YMin, Wall::Rough)
        .wall(Side::XMax, Wall::frictional(0.3))
        .stage(Stage::new("fall", 0.01))
        .stage(Stage { damping: 0.2, ..Stage::new("damped", 0.02) })
}

/// Elastic ball in free space.
fn ball() -> Case {
    Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [1.0, 1.0]))
        .material("snow", LinearElasticSpec::new(400.0, 1e6, 0.3))
        .body(Body::ball("ball", "snow", [0.5, 0.5], 0.2))
        .stage(Stage::new("flight", 0.1))
}

fn solver(case: &Case) -> Simulation<SnowSolver<2>> {
    SnowMpm::new(options()).solver::<2>(case).unwrap()
}

/// Hash after all stages, stepped by the program.
fn hash_at_end<const D: usize>(mut solver: Simulation<SnowSolver<D>>) -> u64 {
    while !solver.is_complete() {
        solver.step().unwrap();
    }
    solver.snapshot().hash()
}

/// State of a simulation.
fn saved(solver: &Simulation<SnowSolver<2>>) -> Vec<u8> {
    let mut bytes = Vec::new();
    solver.save(&mut bytes).unwrap();
    bytes
}

#[test]
fn a_case_of_a_program_has_the_bits_of_its_file() {
    let case = falling_block().method(&options());
    let read = Case::from_json(&case.to_json()).unwrap();
    assert_eq!(read, case);
    let hash = hash_at_end(solver(&case));
    assert_eq!(hash, hash_at_end(solver(&read)), "stepped by the program");
    assert_eq!(hash, colluvium_testkit::solve(&SnowMpm, &read).snapshot.hash(), "run from its file");
}

#[test]
fn a_case_in_space_has_the_bits_of_its_file() {
    let case = Case::new(Space::ThreeD, Domain::new([0.0; 3], [0.4, 0.4, 0.4]))
        .gravity([0.0, 0.0, -10.0])
        .material("snow", snow())
        .body(Body::ball("ball", "snow", [0.2, 0.2, 0.2], 0.1).velocity([0.0, 0.0, -5.0]))
        .wall(Side::ZMin, Wall::Rough)
        .stage(Stage::new("fall", 0.02))
        .method(&SnowOptions::new(0.04));
    let own = SnowMpm::new(SnowOptions::new(0.04)).solver::<3>(&case).unwrap();
    assert_eq!(hash_at_end(own), colluvium_testkit::solve(&SnowMpm, &case).snapshot.hash());
}

#[test]
fn options_of_a_program_are_those_of_a_file() {
    let case = falling_block().method(&options());
    let keys: Vec<&String> = case.methods["snow-mpm"].as_object().unwrap().keys().collect();
    assert_eq!(keys, ["cell_size", "shape"], "options at their defaults are absent");
    let read: SnowOptions = serde_json::from_value(serde_json::json!({ "cell_size": 0.05 })).unwrap();
    assert_eq!(read, SnowOptions::new(0.05));
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
        let mut second = solver(&case);
        second.restore(&mut saved(&first).as_slice()).unwrap();
        assert_eq!((first.stage(), first.time()), (second.stage(), second.time()));
        assert_eq!(whole, hash_at_end(second), "restart at {end} s");
    }
}

#[test]
fn views_are_slices_of_the_solver() {
    let mut solver = solver(&falling_block());
    solver.step().unwrap();
    let address = |solver: &SnowSolver<2>| solver.points().velocity().as_slice().unwrap().as_ptr();
    let points = solver.points();
    assert_eq!(address(&solver), points.of_body(0).velocity().slices()[0].as_ptr());
    assert!(points.of_body(1).is_empty() && points.len() == solver.point_count());
    let (snapshot, ids) = (solver.snapshot(), points.id());
    for (k, id) in snapshot.ids.iter().enumerate() {
        let at = ids.iter().position(|own| u64::from(*own) == *id).unwrap();
        assert_eq!(points.position()[at][..], snapshot.positions[k][..2]);
        assert_eq!(points.velocity()[at][..], snapshot.vectors("velocity").unwrap()[k][..2]);
    }
    let mass: f64 = points.mass().iter().sum();
    assert!((mass - 400.0 * 0.2 * 0.16).abs() < 1e-9 * mass);
    assert!(points.density().all(|density| (density / 400.0 - 1.0).abs() < 1e-2));
    assert!(points.body().eq(vec![0; points.len()]) && points.stress().len() == points.len());
    let before = address(&solver);
    solver.velocities_mut().for_each(|v| *v = [0.0, 0.25]);
    assert_eq!(before, address(&solver));
    assert!(solver.points().velocity().iter().all(|v| *v == [0.0, 0.25]));
}

/// A uniform acceleration moves all points alike, with the velocity `g t` and the work of gravity.
#[test]
fn a_uniform_body_force_is_free_fall() {
    let gravity = [0.3, -10.0];
    for transfer in [SnowTransfer::Apic, SnowTransfer::Flip] {
        let start = |case: &Case| {
            let options = SnowOptions { transfer, ..options() };
            SnowMpm::new(options).solver::<2>(case).unwrap()
        };
        let (mut fallen, mut pulled) = (start(&ball().gravity(gravity)), start(&ball()));
        pulled.set_body_force(move |_, _, _| gravity).unwrap();
        for _ in 0..100 {
            let dt = fallen.limit().dt.min(pulled.limit().dt);
            fallen.step_at_most(dt).unwrap();
            pulled.step_at_most(dt).unwrap();
        }
        let of = |solver: &Simulation<SnowSolver<2>>| solver.points().velocity()[3];
        let (a, b, t) = (of(&fallen), of(&pulled), pulled.time());
        (0..2).for_each(|c| {
            let exact = gravity[c] * t;
            assert!((a[c] - exact).abs() < 1e-9 && (b[c] - exact).abs() < 1e-9, "{a:?} {b:?}");
        });
        let works =
            [scalar_output(&*fallen, "work_of_gravity"), scalar_output(&*pulled, "work_of_body_force")];
        assert!(works[0] > 0.0 && (works[1] / works[0] - 1.0).abs() < 1e-6, "{works:?}");
        let numerical = [&fallen, &pulled].map(|solver| scalar_output(&**solver, "energy_numerical"));
        assert!((numerical[1] - numerical[0]).abs() < 1e-6 * works[0], "{numerical:?}");
    }
}

/// The energy that a program adds or removes is no numerical dissipation, before the next step and after it, and in a saved state.
#[test]
fn changed_velocities_are_in_the_energy_balance() {
    let case = falling_block();
    let mut first = solver(&case);
    first.step_to(0.004).unwrap();
    let numerical = |solver: &Simulation<SnowSolver<2>>| scalar_output(&**solver, "energy_numerical");
    let before = numerical(&first);
    first.velocities_mut().for_each(|v| v[1] *= 0.5);
    let limit = first.points().velocity()[0];
    assert!((numerical(&first) - before).abs() < 1e-9, "{} {before}", numerical(&first));
    let mut second = solver(&case);
    second.restore(&mut saved(&first).as_slice()).unwrap();
    assert_eq!(second.points().velocity()[0], limit);
    assert_eq!(hash_at_end(first), hash_at_end(second));
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
    let bytes = saved(&first);
    let error = solver(&falling_block()).restore(&mut bytes.as_slice()).unwrap_err().to_string();
    assert!(error.contains("set it before the state is restored"), "{error}");
    let mut second = start();
    second.restore(&mut bytes.as_slice()).unwrap();
    assert_eq!(hash_at_end(first), hash_at_end(second));
    let mut cleared = start();
    cleared.clear_body_force();
    assert_eq!(hash_at_end(cleared), hash_at_end(solver(&falling_block())));
}

#[test]
fn an_infinite_body_force_leaves_the_state_as_it_was() {
    let mut solver = solver(&falling_block());
    solver.step().unwrap();
    let before = solver.snapshot().hash();
    let pull = |x: &[f64; 2], _: &[f64; 2], _: f64| [0.0, if x[0] > 0.2 { f64::INFINITY } else { 0.0 }];
    solver.set_body_force(pull).unwrap();
    let error = solver.step().unwrap_err();
    let SolverError::Point { position, .. } = error else { panic!("{error}") };
    assert!(position[0] > 0.2 && error.to_string().contains("body force of the program"), "{error}");
    assert_eq!(before, solver.snapshot().hash());
    let error = solver.step().unwrap_err().to_string();
    assert!(error.contains("an earlier step has failed"), "{error}");
}

#[test]
fn velocities_and_stresses_that_are_not_finite_fail_the_next_step() {
    for bad in [f64::NAN, f64::INFINITY] {
        let mut with_velocity = solver(&falling_block());
        with_velocity.velocities_mut().take(1).for_each(|v| v[1] = bad);
        assert!(with_velocity.step().is_err(), "velocity {bad}");
        let mut with_stress = solver(&falling_block());
        with_stress.stresses_mut().take(1).for_each(|stress| stress[1] = bad);
        assert!(with_stress.step().is_err(), "stress {bad}");
    }
}

/// Each nonsense of a program is refused with the path that a file has.
#[test]
fn nonsense_is_refused_with_the_path_of_a_file() {
    let refusal = |case: &Case, options: SnowOptions| -> String {
        let result: Result<Simulation<SnowSolver<2>>, CaseErrors> = SnowMpm::new(options).solver::<2>(case);
        result.err().expect("an error").to_string()
    };
    let elastic = |density: f64| LinearElasticSpec::new(density, 1e6, 0.3);
    let cases = [
        ("materials.snow.density", falling_block().material("snow", elastic(-1.0)), options()),
        ("materials.snow.density", falling_block().material("snow", elastic(f64::NAN)), options()),
        ("bodies[1].material", falling_block().body(Body::ball("b", "ice", [0.5, 0.3], 0.05)), options()),
        ("bodies[1].shape", falling_block().body(Body::ball("b", "snow", [0.5, 0.3], -0.05)), options()),
        ("stages[2].duration", falling_block().stage(Stage::new("s", f64::INFINITY)), options()),
        ("gravity", falling_block().gravity([0.0, 0.0, -10.0]), options()),
        ("methods.snow-mpm.cell_size", falling_block(), SnowOptions::new(f64::NAN)),
        ("methods.snow-mpm.cell_size", falling_block(), SnowOptions::new(0.07)),
        (
            "methods.snow-mpm.courant_elastic",
            falling_block(),
            SnowOptions { courant_elastic: f64::NAN, ..options() },
        ),
        ("methods.snow-mpm.flip_ratio", falling_block(), SnowOptions { flip_ratio: Some(1.5), ..options() }),
        ("stages", Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [1.0, 1.0])), options()),
    ];
    for (path, case, options) in cases {
        let error = refusal(&case, options);
        assert!(error.contains(path), "{path}: {error}");
    }
    let error = SnowMpm::new(options()).solver::<3>(&falling_block()).err().unwrap().to_string();
    assert!(error.contains("space: gives a solver of 2 dimensions, and one of 3 was requested"), "{error}");
    let case = falling_block().method(&options()).checked(std::path::Path::new("")).unwrap();
    let error = TypedMethod::<1>::typed_solver(&SnowMpm, &case).err().unwrap().to_string();
    assert!(error.contains("space: has not 1 dimensions"), "{error}");
}

/// Elastic law with a fault in points that are compressed: an error, or a stress that is not a number.
struct Faulty {
    is_error: bool,
}

impl Law for Faulty {
    fn name(&self) -> &'static str {
        "faulty"
    }
}

impl PointLaw for Faulty {
    /// Volumetric strain.
    type State = f64;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<f64>, MaterialError> {
        Ok(Point { stress: initial.stress, state: 0.0 })
    }

    fn wave_modulus(&self, _: &Point<f64>) -> f64 {
        1e6
    }
}

impl StressUpdate for Faulty {
    fn update(&self, motion: &Motion, old: &Point<f64>) -> Result<Point<f64>, MaterialError> {
        let state = old.state + motion.strain_increment().trace();
        let stress = SymTensor::isotropic(1e6 * state);
        match (state < -1e-4, self.is_error) {
            (true, true) => Err(MaterialError::update("faulty", "no solution")),
            (true, false) => Ok(Point { stress: stress * f64::NAN, state }),
            _ => Ok(Point { stress, state }),
        }
    }
}

#[test]
fn a_faulty_law_is_an_error_that_names_the_point() {
    for (is_error, reason) in [(true, "faulty: no solution"), (false, "its stress is not finite")] {
        let case = falling_block().law("snow", 400.0, Arc::new(Faulty { is_error }));
        let error = solver(&case).step_to(0.03).unwrap_err();
        let text = error.to_string();
        let SolverError::Point { position, reason: kind, .. } = error else { panic!("{error}") };
        // The floor compresses the lowest points first.
        assert!(position[1] < 0.14 && text.contains(reason), "{text}");
        match kind {
            FailureReason::Law { material, .. } => assert!(is_error && material == "snow"),
            kind => assert!(!is_error && matches!(kind, FailureReason::NotFinite(_)), "{kind:?}"),
        }
    }
}

#[test]
fn a_law_of_the_program_is_a_material() {
    let law = MaterialSpec::from(LinearElasticSpec::new(400.0, 1e6, 0.3)).build().unwrap();
    let own = falling_block().law("snow", 400.0, Arc::clone(&law));
    let listed = falling_block().material("snow", LinearElasticSpec::new(400.0, 1e6, 0.3));
    assert_eq!(hash_at_end(solver(&own)), hash_at_end(solver(&listed)));
}
