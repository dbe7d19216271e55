//! Solvers that a program describes, steps, reads and changes.

use colluvium_case::{Axis, Body, Case, CaseErrors, Domain, Side, Simulation, Solver, Space, Stage, Wall};
use colluvium_constitutive::MohrCoulombSpec;
use colluvium_depth_sph::{
    ColumnOptions, DamOptions, DepthOptions, DepthSolver, DepthSph, DilatancyOptions, EarthPressureOptions,
    InflowOptions, InterphaseDrag, MixtureOptions, Phases, SkeletonOptions, TimeScheme,
};
use serde_json::json;

fn options() -> DepthOptions {
    DepthOptions { courant: 0.25, ..DepthOptions::new(0.05) }
}

fn sand() -> MohrCoulombSpec {
    MohrCoulombSpec::new(1600.0, 1e7, 0.3, 30.0)
}

/// Column of sand that is released on a rough floor, in two stages.
fn column() -> Case {
    Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [10.0, 2.0]))
        .gravity([0.0, -9.81])
        .material("sand", sand())
        .body(Body::block("column", "sand", [0.0, 0.0], [2.0, 1.0]))
        .wall(Side::XMin, Wall::Smooth)
        .wall(Side::YMin, Wall::Rough)
        .stage(Stage::new("release", 0.2))
        .stage(Stage::new("flow", 0.2))
}

/// Layer without friction in a periodic profile.
fn layer() -> Case {
    let domain = Domain { periodic: vec![Axis::X], ..Domain::new([0.0, 0.0], [4.0, 2.0]) };
    Case::new(Space::PlaneStrain, domain)
        .gravity([0.0, -10.0])
        .material("sand", sand())
        .body(Body::block("layer", "sand", [0.0, 0.0], [4.0, 1.0]))
        .wall(Side::YMin, Wall::Smooth)
        .stage(Stage::new("slide", 1.0))
}

/// Heap of grains and fluid on flat ground in space.
fn heap() -> Case {
    Case::new(Space::ThreeD, Domain::new([0.0; 3], [20.0, 10.0, 5.0]))
        .gravity([0.0, 0.0, -9.81])
        .material("debris", MohrCoulombSpec::new(1990.0, 1e7, 0.3, 30.0))
        .body(Body::block("heap", "debris", [2.0, 3.0, 0.0], [6.0, 7.0, 1.5]))
        .wall(Side::ZMin, Wall::Smooth)
        .stage(Stage::new("release", 0.5))
}

/// Options of two phases.
fn two_phases() -> DepthOptions {
    let mixture = MixtureOptions { drag: InterphaseDrag::anderson(0.05), ..MixtureOptions::new(2650.0) };
    DepthOptions { phases: Phases::Two, mixture: Some(mixture), ..DepthOptions::new(0.5) }
}

fn solver(case: &Case) -> Simulation<DepthSolver<1>> {
    DepthSph::new(options()).solver::<1>(case).unwrap()
}

/// Hash after all stages, stepped by the program.
fn hash_at_end<const D: usize>(mut solver: Simulation<DepthSolver<D>>) -> u64 {
    while !solver.is_complete() {
        solver.step().unwrap();
    }
    solver.snapshot().hash()
}

#[test]
fn a_case_of_a_program_has_the_bits_of_its_file() {
    let case = column().method(&options());
    let read = Case::from_json(&case.to_json()).unwrap();
    assert_eq!(read, case);
    let hash = hash_at_end(solver(&case));
    assert_eq!(hash, hash_at_end(solver(&read)), "stepped by the program");
    assert_eq!(hash, colluvium_testkit::solve(&DepthSph, &read).snapshot.hash(), "run from its file");
    let case = heap().method(&two_phases());
    let read = Case::from_json(&case.to_json()).unwrap();
    let hash = hash_at_end(DepthSph::new(two_phases()).solver::<2>(&heap()).unwrap());
    assert_eq!(hash, colluvium_testkit::solve(&DepthSph, &read).snapshot.hash(), "two phases in plan");
}

#[test]
fn options_of_a_program_are_those_of_a_file() {
    let case = column().method(&options());
    let keys: Vec<&String> = case.methods["depth-sph"].as_object().unwrap().keys().collect();
    assert_eq!(keys, ["courant", "spacing"], "options at their defaults are absent");
    let read: DepthOptions = serde_json::from_value(json!({ "spacing": 0.05 })).unwrap();
    assert_eq!(read, DepthOptions::new(0.05));
}

/// Each constructor of a part of the options sets what a file with its required keys has.
#[test]
fn parts_of_the_options_are_those_of_a_file() {
    use colluvium_depth_sph::BedRegion;
    fn same<T: serde::de::DeserializeOwned + PartialEq + std::fmt::Debug>(own: &T, file: serde_json::Value) {
        assert_eq!(serde_json::from_value::<T>(file).unwrap(), *own);
    }
    same(&BedRegion::default(), json!({}));
    same(
        &DamOptions::new([[0.0, 0.0], [1.0, 0.0]], 2.0),
        json!({ "line": [[0.0, 0.0], [1.0, 0.0]], "height": 2.0 }),
    );
    same(&InflowOptions::default(), json!({}));
    let discharge = [[0.0, 1.0], [5.0, 0.0]];
    same(
        &InflowOptions::across_line([0.0, 0.0], [1.0, 0.0], discharge),
        json!({ "from": [0.0, 0.0], "to": [1.0, 0.0], "discharge": discharge }),
    );
    same(
        &InflowOptions::through_end(Side::XMin, discharge),
        json!({ "side": "x-min", "discharge": discharge }),
    );
    same(&MixtureOptions::new(2650.0), json!({ "grain_density": 2650.0 }));
    same(&InterphaseDrag::anderson(0.1), json!({ "law": "anderson", "settling_velocity": 0.1 }));
    same(&ColumnOptions::default(), json!({}));
    same(&ColumnOptions::new(0.1), json!({ "consolidation": 0.1 }));
    same(&SkeletonOptions::new(1e7, 0.3), json!({ "youngs_modulus": 1e7, "poissons_ratio": 0.3 }));
    same(&DilatancyOptions::new(4.0, 0.4), json!({ "slope": 4.0, "critical_porosity": 0.4 }));
    same(
        &EarthPressureOptions::new(35.0, 25.0),
        json!({ "internal_friction_angle": 35.0, "basal_friction_angle": 25.0 }),
    );
}

#[test]
fn bits_are_the_same_on_two_threads_and_after_a_restart_in_the_loop() {
    let case = column();
    let hash = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| hash_at_end(solver(&case)))
    };
    let whole = hash(1);
    assert_eq!(whole, hash(2), "threads");
    for end in [0.1, 0.2, 0.3] {
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
    let mut solver = solver(&column());
    solver.step_to(0.1).unwrap();
    let (nodes, snapshot) = (solver.nodes(), solver.snapshot());
    let (ids, depth) = (nodes.id(), snapshot.scalars("depth").unwrap());
    for (k, id) in snapshot.ids.iter().enumerate() {
        let at = ids.iter().position(|own| own == id).unwrap();
        assert_eq!(nodes.position()[at][0], snapshot.positions[k][0]);
        assert_eq!(nodes.depth()[at], depth[k]);
        assert_eq!(nodes.thickness()[at], depth[k]);
    }
    let mass: f64 = nodes.mass().sum();
    assert!((mass / 3200.0 - 1.0).abs() < 1e-12 && (nodes.volume().iter().sum::<f64>() - 2.0).abs() < 1e-12);
    assert!(nodes.density().all(|density| density == 1600.0) && nodes.bed_level().all(|level| level == 0.0));
    assert_eq!((nodes.len(), nodes.mass().count()), (nodes.body().len(), nodes.len()));
    assert_eq!((nodes.phase_count(), nodes.of_phase(0).len(), nodes.of_phase(1).len()), (1, nodes.len(), 0));
    let address = |solver: &DepthSolver<1>| solver.nodes().velocity().as_slice().unwrap().as_ptr();
    let before = address(&solver);
    solver.velocities_mut().for_each(|v| *v = [0.25]);
    assert_eq!(before, address(&solver));
    assert!(solver.nodes().velocity().iter().all(|v| *v == [0.25]));
}

#[test]
fn phases_are_read_one_by_one() {
    let mut solver = DepthSph::new(two_phases()).solver::<2>(&heap()).unwrap();
    solver.step_to(0.1).unwrap();
    let nodes = solver.nodes();
    let (grains, fluid) = (nodes.of_phase(0), nodes.of_phase(1));
    assert_eq!((nodes.phase_count(), grains.len() + fluid.len()), (2, nodes.len()));
    assert!(grains.density().all(|density| density == 2650.0) && fluid.density().all(|own| own == 1000.0));
    let volume = |part: colluvium_depth_sph::DepthNodes<'_, 2>| part.volume().iter().sum::<f64>();
    assert!((volume(grains) / 14.4 - 1.0).abs() < 1e-12 && (volume(fluid) / 9.6 - 1.0).abs() < 1e-12);
    assert_eq!(nodes.velocity().slices().len(), 2);
    let error = solver.set_body_force(|_, _, _| [1.0, 0.0]).unwrap_err().to_string();
    assert!(error.contains("methods.depth-sph.phases") && error.contains("is not defined"), "{error}");
}

#[test]
fn changed_velocities_limit_the_step_and_keep_the_energy_balance() {
    let mut solver = solver(&column());
    solver.step_to(0.1).unwrap();
    let error = |solver: &DepthSolver<1>| solver.flow().energy_balance_summary().error;
    let (limit, before) = (solver.limit().dt, error(&solver));
    let saved = |solver: &Simulation<DepthSolver<1>>| {
        let mut bytes = Vec::new();
        solver.save(&mut bytes).unwrap();
        bytes
    };
    let restored = |bytes: &[u8]| {
        let mut solver = self::solver(&column());
        solver.restore(&mut &bytes[..]).unwrap();
        solver
    };
    let mut unchanged = restored(&saved(&solver));
    solver.velocities_mut().for_each(|v| v[0] += 30.0);
    assert!(solver.limit().dt < 0.5 * limit);
    // The energies are of the order of 1 MJ.
    assert!((error(&solver) - before).abs() < 1e-6, "{} {before}", error(&solver));
    let mut changed_back = restored(&saved(&solver));
    changed_back.velocities_mut().for_each(|v| v[0] -= 30.0);
    // Both in one step, which is shorter than either limit.
    let end = unchanged.time() + 0.1 * limit;
    unchanged.step_to(end).unwrap();
    changed_back.step_to(end).unwrap();
    assert!((error(&unchanged) - error(&changed_back)).abs() < 1e-6);
    solver.velocities_mut().take(1).for_each(|v| v[0] = f64::NAN);
    let error = solver.step().unwrap_err().to_string();
    assert!(error.contains("not finite") || error.contains("point"), "{error}");
}

/// A uniform acceleration moves a layer without friction with `v = a t`, at the work `½ m v²`.
#[test]
fn a_uniform_body_force_is_frictionless_sliding() {
    for integration in [TimeScheme::Leapfrog, TimeScheme::RungeKutta2, TimeScheme::RungeKutta4] {
        let options = DepthOptions { integration, ..DepthOptions::new(0.05) };
        let mut solver = DepthSph::new(options).solver::<1>(&layer()).unwrap();
        solver.set_body_force(|_, _, _| [0.7]).unwrap();
        solver.step_to(0.5).unwrap();
        let nodes = solver.nodes();
        assert!(nodes.velocity().iter().all(|v| (v[0] - 0.35).abs() < 1e-10), "{integration:?}");
        let kinetic = 0.5 * nodes.mass().sum::<f64>() * 0.35 * 0.35;
        let work = solver.flow().records.energy_balance.applied_work;
        assert!((work / kinetic - 1.0).abs() < 0.02, "{work} {kinetic}");
        let error = solver.flow().energy_balance_summary().error;
        assert!(error.abs() < 0.02 * kinetic, "{error} {kinetic}");
        solver.clear_body_force();
        solver.step_to(0.6).unwrap();
        assert!(solver.nodes().velocity().iter().all(|v| (v[0] - 0.35).abs() < 1e-10));
    }
}

/// The momentum of a heap that spreads grows by the force.
#[test]
fn a_body_force_accelerates_a_heap_in_plan() {
    let mut solver = DepthSph::new(DepthOptions::new(0.25)).solver::<2>(&heap()).unwrap();
    solver.set_body_force(|_, _, _| [0.5, -0.2]).unwrap();
    solver.step_to(0.4).unwrap();
    let nodes = solver.nodes();
    let mut momentum = [0.0; 2];
    for (mass, v) in nodes.mass().zip(nodes.velocity().iter()) {
        (0..2).for_each(|c| momentum[c] += mass * v[c]);
    }
    let mass: f64 = nodes.mass().sum();
    assert!(
        (momentum[0] / mass - 0.2).abs() < 1e-3 && (momentum[1] / mass + 0.08).abs() < 1e-3,
        "{momentum:?}"
    );
}

#[test]
fn a_state_with_a_body_force_needs_it_again() {
    let start = || {
        let mut solver = solver(&column());
        solver.set_body_force(|x, v, t| [0.1 * x[0] - 3.0 * v[0] + t]).unwrap();
        solver
    };
    let whole = hash_at_end(start());
    assert_ne!(whole, hash_at_end(solver(&column())));
    let mut first = start();
    first.step_to(0.13).unwrap();
    let mut bytes = Vec::new();
    first.save(&mut bytes).unwrap();
    let error = solver(&column()).restore(&mut bytes.as_slice()).unwrap_err().to_string();
    assert!(error.contains("set it before the state is restored"), "{error}");
    let mut second = start();
    second.restore(&mut bytes.as_slice()).unwrap();
    assert_eq!(hash_at_end(first), hash_at_end(second));
}

#[test]
fn an_infinite_body_force_leaves_the_state_as_it_was() {
    let mut solver = solver(&column());
    solver.step().unwrap();
    let before = solver.snapshot().hash();
    solver.set_body_force(|x, _, _| [if x[0] > 1.0 { f64::INFINITY } else { 0.0 }]).unwrap();
    let error = solver.step().unwrap_err().to_string();
    assert!(error.contains("body force of the program") && error.contains("point"), "{error}");
    assert_eq!(before, solver.snapshot().hash());
    let error = solver.step().unwrap_err().to_string();
    assert!(error.contains("an earlier step has failed"), "{error}");
}

/// Each nonsense of a program is refused with the path that a file has.
#[test]
fn nonsense_is_refused_with_the_path_of_a_file() {
    let refusal = |case: &Case, options: DepthOptions| -> String {
        let result: Result<Simulation<DepthSolver<1>>, CaseErrors> = DepthSph::new(options).solver::<1>(case);
        result.err().expect("an error").to_string()
    };
    let cases = [
        ("methods.depth-sph.spacing", column(), DepthOptions::new(-1.0)),
        ("methods.depth-sph.spacing", column(), DepthOptions::new(f64::NAN)),
        ("methods.depth-sph.courant", column(), DepthOptions { courant: 2.0, ..options() }),
        ("methods.depth-sph.xsph", column(), DepthOptions { xsph: -0.1, ..options() }),
        (
            "methods.depth-sph.mixture",
            column(),
            DepthOptions { mixture: Some(MixtureOptions::new(-5.0)), phases: Phases::Two, ..options() },
        ),
        ("bodies[1].material", column().body(Body::block("b", "ice", [3.0, 0.0], [4.0, 1.0])), options()),
        ("gravity", column().gravity([0.0, 0.0, -10.0]), options()),
        ("stages[2].duration", column().stage(Stage::new("s", f64::INFINITY)), options()),
    ];
    for (path, case, options) in cases {
        let error = refusal(&case, options);
        assert!(error.contains(path), "{path}: {error}");
    }
    let error = DepthSph::new(options()).solver::<2>(&column()).err().unwrap().to_string();
    assert!(error.contains("space: gives a solver of 1 dimensions, and one of 2 was requested"), "{error}");
    let error = refusal(&heap(), DepthOptions::new(0.5));
    assert!(error.contains("space: gives a solver of 2 dimensions, and one of 1 was requested"), "{error}");
}
