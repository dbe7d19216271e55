//! Solvers that a program describes, steps, reads and changes.

use std::sync::Arc;

use colluvium_case::{
    Body, Case, Domain, EquilibriumCriterion, Side, Simulation, Solver, Space, Stage, Wall,
};
use colluvium_constitutive::{DruckerPragerSpec, LinearElasticSpec, MaterialSpec, NewtonianFluidSpec};
use colluvium_sph::{
    ConfiningPressure, Kernel, LagrangianFormulation, Sph, SphOptions, SphSolver, TimeHistory,
    TimeIntegration, setup,
};
use serde_json::json;

/// Schemes of time integration.
const SCHEMES: [TimeIntegration; 7] = [
    TimeIntegration::Leapfrog,
    TimeIntegration::LeapfrogRates,
    TimeIntegration::PredictorCorrector,
    TimeIntegration::PositionVerlet,
    TimeIntegration::VelocityVerlet,
    TimeIntegration::Verlet,
    TimeIntegration::RungeKutta4,
];

/// Options with a spacing of 2.5 cm.
pub(crate) fn options() -> SphOptions {
    SphOptions { kernel: Kernel::WendlandC2, smoothing: 1.5, ..SphOptions::new(0.025) }
}

/// Block of soil that falls on a rough floor, in two stages.
pub(crate) fn falling_block() -> Case {
    let soil = DruckerPragerSpec { cohesion: 500.0, ..DruckerPragerSpec::new(1600.0, 1e6, 0.3, 25.0) };
    Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [0.6, 0.4]))
        .gravity([0.0, -10.0])
        .material("soil", soil)
        .body(Body::block("block", "soil", [0.1, 0.05], [0.3, 0.2]).velocity([0.5, -1.0]))
        .wall(Side::YMin, Wall::Rough)
        .wall(Side::XMax, Wall::Smooth)
        .stage(Stage::new("fall", 0.01))
        .stage(Stage { damping: 0.2, ..Stage::new("damped", 0.02) })
}

/// Elastic ball in free space.
fn ball() -> Case {
    Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [1.0, 1.0]))
        .material("rubber", LinearElasticSpec::new(1000.0, 1e5, 0.3))
        .body(Body::ball("ball", "rubber", [0.5, 0.5], 0.1))
        .stage(Stage::new("flight", 0.1))
}

pub(crate) fn solver(case: &Case) -> Simulation<SphSolver<2>> {
    Sph::new(options()).solver::<2>(case).unwrap()
}

/// Hash after all stages, stepped by the program.
fn hash_at_end<const D: usize>(mut solver: Simulation<SphSolver<D>>) -> u64 {
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
    assert_eq!(hash, colluvium_testkit::solve(&Sph, &read).snapshot.hash(), "run from its file");
}

#[test]
fn options_of_a_program_are_those_of_a_file() {
    let case = falling_block().method(&options());
    let keys: Vec<&String> = case.methods["sph"].as_object().unwrap().keys().collect();
    assert_eq!(keys, ["kernel", "smoothing", "spacing"], "options at their defaults are absent");
    let read: SphOptions = serde_json::from_value(json!({ "spacing": 0.05 })).unwrap();
    assert_eq!(read, SphOptions::new(0.05));
    let read: ConfiningPressure = serde_json::from_value(json!({ "pressure": 1e4 })).unwrap();
    assert_eq!(read, ConfiningPressure::new(1e4));
    let read: TimeHistory = serde_json::from_value(json!({ "times": [0, 1], "factors": [1, 2] })).unwrap();
    assert_eq!(read, TimeHistory::new([0.0, 1.0], [1.0, 2.0]));
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
    let particles = solver.particles();
    let address = |solver: &SphSolver<2>| solver.particles().velocity().as_ptr();
    assert_eq!(address(&solver), particles.of_body(0).velocity().as_ptr());
    assert!(particles.of_body(1).is_empty() && particles.len() == solver.point_count());
    let snapshot = solver.snapshot();
    for (k, id) in snapshot.ids.iter().enumerate() {
        let at = particles.id().iter().position(|own| u64::from(*own) == *id).unwrap();
        assert_eq!(particles.position()[at][..], snapshot.positions[k][..2]);
    }
    let mass: f64 = particles.mass().iter().sum();
    assert!((mass - 1600.0 * 0.2 * 0.15).abs() < 1e-9 * mass);
    assert!(particles.density().iter().all(|density| (density / 1600.0 - 1.0).abs() < 1e-2));
    assert!((particles.volume().sum::<f64>() / 0.03 - 1.0).abs() < 1e-2);
    assert!(particles.body().eq(vec![0; particles.len()]) && particles.stress().len() == particles.len());
    let before = address(&solver);
    solver.velocities_mut().for_each(|v| *v = [0.0, 0.25]);
    assert_eq!(before, address(&solver));
    assert!(solver.particles().velocity().iter().all(|v| *v == [0.0, 0.25]));
}

#[test]
fn only_particles_that_move_by_themselves_are_changed() {
    let mut case = falling_block()
        .body(Body::block("plate", "soil", [0.1, 0.3], [0.2, 0.35]))
        .body(Body { rigid: true, ..Body::block("rock", "soil", [0.4, 0.05], [0.5, 0.15]) })
        .body(Body::block("other", "soil", [0.4, 0.2], [0.5, 0.3]));
    let held = SphOptions { held: vec!["plate".to_owned()], ..options() };
    let mut solver = Sph::new(held.clone()).solver::<2>(&case).unwrap();
    let counts: Vec<usize> = (0..4).map(|body| solver.particles().of_body(body).len()).collect();
    assert_eq!(solver.velocities_mut().count(), counts[0] + counts[3]);
    solver.stresses_mut().for_each(|stress| stress[0] = -7.0);
    for body in 0..4 {
        let is_free = matches!(body, 0 | 3);
        assert!(
            solver.particles().of_body(body).stress().iter().all(|stress| (stress[0] == -7.0) == is_free)
        );
    }
    case.bodies.retain(|body| body.rigid || body.name == "plate");
    let mut solver = Sph::new(held).solver::<2>(&case).unwrap();
    let error = solver.set_body_force(|_, _, _| [0.0; 2]).unwrap_err().to_string();
    assert!(error.contains("bodies: are all rigid or held"), "{error}");
}

/// A uniform acceleration moves all particles alike, with the velocity `g t`, as gravity does.
#[test]
fn a_uniform_body_force_is_free_fall_in_all_schemes() {
    let gravity = [0.3, -10.0];
    let total = SphOptions { formulation: LagrangianFormulation::TotalLagrangian, ..options() };
    let schemes = SCHEMES.map(|integration| SphOptions { integration, ..options() });
    for options in schemes.into_iter().chain([total]) {
        let mut fallen = Sph::new(options.clone()).solver::<2>(&ball().gravity(gravity)).unwrap();
        let mut pulled = Sph::new(options.clone()).solver::<2>(&ball()).unwrap();
        pulled.set_body_force(move |_, _, _| gravity).unwrap();
        for _ in 0..20 {
            let dt = fallen.limit().dt.min(pulled.limit().dt);
            fallen.step_at_most(dt).unwrap();
            pulled.step_at_most(dt).unwrap();
        }
        let of = |solver: &Simulation<SphSolver<2>>| solver.particles().velocity()[3];
        let (a, b, t) = (of(&fallen), of(&pulled), pulled.velocity_time());
        assert!(t > 0.0 && t <= pulled.time());
        (0..2).for_each(|c| {
            let exact = gravity[c] * t;
            let agree = (a[c] - exact).abs() < 1e-9 && (b[c] - exact).abs() < 1e-9;
            assert!(agree, "{:?}: {a:?} {b:?} {exact}", options.integration);
        });
    }
}

/// The velocity under the acceleration `cos ωt` is `sin(ωt)/ω`.
#[test]
fn a_body_force_in_time_is_integrated_by_each_scheme() {
    for integration in SCHEMES {
        let case = ball().stage(Stage::new("more", 1.0));
        let mut solver = Sph::new(SphOptions { integration, ..options() }).solver::<2>(&case).unwrap();
        let frequency = 40.0f64;
        let pull = move |_: &[f64; 2], _: &[f64; 2], t: f64| [(frequency * t).cos(), 0.0];
        solver.set_body_force(pull).unwrap();
        solver.step_to(0.1).unwrap();
        let (v, t) = (solver.particles().velocity()[0][0], solver.velocity_time());
        let exact = (frequency * t).sin() / frequency;
        // All schemes are of second order or higher, and a step is a small part of a radian.
        assert!((v - exact).abs() < 2e-3 / frequency, "{integration:?}: {v} {exact}");
    }
}

#[test]
fn a_body_force_does_work_as_gravity_does() {
    let mut case = ball().wall(Side::YMin, Wall::Smooth);
    case.stages[0].equilibrium =
        Some(EquilibriumCriterion { required: false, ..EquilibriumCriterion::default() });
    let start = |case: &Case| Sph::new(options()).solver::<2>(case).unwrap();
    let (mut fallen, mut pulled) = (start(&case.clone().gravity([0.0, -10.0])), start(&case));
    assert!(pulled.is_isolated());
    pulled.set_body_force(|_, _, _| [0.0, -10.0]).unwrap();
    assert!(!pulled.is_isolated());
    for _ in 0..30 {
        let dt = fallen.limit().dt.min(pulled.limit().dt);
        fallen.step_at_most(dt).unwrap();
        pulled.step_at_most(dt).unwrap();
    }
    let (a, b) = (fallen.equilibrium().unwrap(), pulled.equilibrium().unwrap());
    assert!((a.kinetic_ratio / b.kinetic_ratio - 1.0).abs() < 1e-9, "{a:?} {b:?}");
    assert!((a.unbalanced_force / b.unbalanced_force - 1.0).abs() < 1e-9, "{a:?} {b:?}");
    pulled.clear_body_force();
    assert!(pulled.is_isolated());
    let before = pulled.particles().velocity()[0];
    pulled.step().unwrap();
    let after = pulled.particles().velocity()[0];
    assert!((after[1] - before[1]).abs() < 1e-9, "{before:?} {after:?}");
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

/// Body of a force that depends on it, in a stage without another body.
#[test]
fn a_removed_body_takes_its_body_force_with_it() {
    let mut case = falling_block().body(Body::block("other", "soil", [0.4, 0.2], [0.5, 0.3]));
    case.bodies.swap(0, 1);
    case.stages[1].remove_bodies = vec!["other".to_owned()];
    let start = || {
        let mut solver = solver(&case);
        solver.set_body_force(|x, v, _| [if x[0] > 0.35 { 90.0 } else { -9.0 * v[0] }, 0.0]).unwrap();
        solver
    };
    let whole = hash_at_end(start());
    let mut first = start();
    while first.time() < 0.015 {
        first.step().unwrap();
    }
    assert_eq!((first.stage(), first.particles().of_body(0).len()), (1, 0));
    assert!(first.particles().velocity().iter().all(|v| v[0] < 0.6), "the force of the other body is gone");
    let mut bytes = Vec::new();
    first.save(&mut bytes).unwrap();
    let mut second = start();
    second.restore(&mut bytes.as_slice()).unwrap();
    assert_eq!((hash_at_end(first), hash_at_end(second)), (whole, whole));
}

#[test]
fn cases_in_space_and_on_a_line_have_the_bits_of_their_files() {
    let soil = DruckerPragerSpec { cohesion: 500.0, ..DruckerPragerSpec::new(1600.0, 1e6, 0.3, 25.0) };
    let cube = Case::new(Space::ThreeD, Domain::new([0.0; 3], [0.3; 3]))
        .gravity([0.0, 0.0, -10.0])
        .material("soil", soil)
        .body(Body::ball("ball", "soil", [0.15, 0.15, 0.1], 0.06).velocity([0.0, 0.0, -2.0]))
        .wall(Side::ZMin, Wall::Rough)
        .stage(Stage::new("fall", 0.01))
        .method(&options());
    let own = Sph::new(options()).solver::<3>(&cube).unwrap();
    assert_eq!(hash_at_end(own), colluvium_testkit::solve(&Sph, &cube).snapshot.hash());
    let bar = Case::new(Space::OneD, Domain::new([0.0], [2.0]))
        .material("rubber", LinearElasticSpec::new(1000.0, 1e5, 0.3))
        .body(Body::block("bar", "rubber", [0.5], [1.0]).velocity([1.0]))
        .stage(Stage::new("flight", 0.01))
        .method(&SphOptions::new(0.025));
    let own = Sph::new(SphOptions::new(0.025)).solver::<1>(&bar).unwrap();
    assert_eq!(hash_at_end(own), colluvium_testkit::solve(&Sph, &bar).snapshot.hash());
}

#[test]
fn a_cleared_body_force_leaves_no_trace() {
    let mut solver_with = solver(&falling_block());
    solver_with.set_body_force(|_, _, _| [0.0, 5.0]).unwrap();
    solver_with.clear_body_force();
    assert_eq!(hash_at_end(solver_with), hash_at_end(solver(&falling_block())));
}

#[test]
fn a_body_force_acts_in_ranks_as_in_one() {
    let case = falling_block().method(&options());
    let hash = |ranks: u32| {
        let mut whole = setup::solver::<2>(&case, &setup::options(&case).unwrap()).unwrap();
        whole.set_body_force(|x, v, t| [3.0 * x[1] - v[0], 1000.0 * t]).unwrap();
        let mut solver = setup::distributed_solver(whole, ranks);
        solver.begin_stage(0, 0.0).unwrap();
        (0..60).for_each(|_| assert!(solver.step(1e-3).is_ok()));
        let mut snapshot = solver.snapshot();
        snapshot.fields.retain(|field| field.name != "rank");
        snapshot.hash()
    };
    assert_eq!(hash(1), hash(3));
}

#[test]
fn a_law_of_the_program_is_a_material() {
    let law = MaterialSpec::from(LinearElasticSpec::new(1600.0, 1e6, 0.3)).build().unwrap();
    let own = falling_block().law("soil", 1600.0, Arc::clone(&law));
    let listed = falling_block().material("soil", LinearElasticSpec::new(1600.0, 1e6, 0.3));
    assert_eq!(hash_at_end(solver(&own)), hash_at_end(solver(&listed)));
    let error =
        Case::from_json(&own.to_json()).and_then(|case| Sph::new(options()).solver::<2>(&case).map(|_| ()));
    let error = error.unwrap_err().to_string();
    assert!(error.contains("materials.soil") && error.contains("\"soil\" is not available here"), "{error}");
}

#[test]
fn defaults_of_a_liquid_are_those_of_its_file() {
    let water = NewtonianFluidSpec { viscosity: 1.0, ..NewtonianFluidSpec::new(1000.0, 1e6) };
    let case = falling_block().material("soil", water);
    let read = Case::from_json(&case.clone().method(&SphOptions::new(0.025)).to_json()).unwrap();
    let hash = hash_at_end(Sph::new(SphOptions::new(0.025)).solver::<2>(&case).unwrap());
    assert_eq!(hash, colluvium_testkit::solve(&Sph, &read).snapshot.hash());
}
