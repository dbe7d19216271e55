//! Solvers that a program describes, steps, reads and changes.

use colluvium_case::{
    Body, Boundary, Case, CaseErrors, Domain, Side, Simulation, Solver, Space, Stage, Wall,
};
use colluvium_constitutive::LinearElasticSpec;
use colluvium_dem::{
    BodyGrains, Dem, DemOptions, DemSolver, Diameters, Fill, GrainKind, LatticePacking, NormalLaw, PairSpec,
    Pluviation,
};
use colluvium_testkit::{assert_near, scalar_output};
use serde_json::json;

/// Kind of sand in a lattice of disks.
fn sand() -> GrainKind {
    let fill = Fill::Lattice { packing: LatticePacking::Hexagonal, pitch: None, jitter: 0.02 };
    GrainKind::filled(2650.0, Diameters::Equal { value: 0.1 }, fill)
}

fn pair() -> PairSpec {
    PairSpec::new(["sand", "sand"], NormalLaw::linear(1e6).restitution(0.5)).friction(0.4)
}

fn options() -> DemOptions {
    DemOptions { seed: 3, ..DemOptions::new([("sand", sand())], [pair()]) }
}

/// Empty domain under gravity.
fn space() -> Case {
    Case::new(Space::PlaneStrain, Domain::new([-2.0, -2.0], [4.0, 4.0]))
        .gravity([0.0, -10.0])
        .material("sand", LinearElasticSpec::new(2650.0, 1e7, 0.3))
}

/// Block of disks that falls on a floor, in two stages.
fn falling_block() -> Case {
    let floor = Boundary { position: Some(0.0), ..Boundary::new(Side::YMin, Wall::frictional(0.5)) };
    let right = Boundary { position: Some(1.6), ..Boundary::new(Side::XMax, Wall::Smooth) };
    space()
        .body(Body::block("block", "sand", [0.0, 0.05], [1.5, 1.0]).velocity([0.5, -1.0]))
        .boundary(floor)
        .boundary(right)
        .stage(Stage::new("fall", 0.05))
        .stage(Stage { damping: 0.2, ..Stage::new("damped", 0.05) })
}

fn solver(case: &Case) -> Simulation<DemSolver<2, 1>> {
    Dem::new(options()).solver::<2>(case).unwrap()
}

/// Hash after all stages, stepped by the program.
fn hash_at_end(mut solver: Simulation<DemSolver<2, 1>>) -> u64 {
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
    assert_eq!(hash, colluvium_testkit::solve(&Dem, &read).snapshot.hash(), "run from its file");
}

#[test]
fn options_of_a_program_are_those_of_a_file() {
    let case = falling_block().method(&options());
    let keys: Vec<&String> = case.methods["dem"].as_object().unwrap().keys().collect();
    assert_eq!(keys, ["grains", "pairs", "seed"], "options at their defaults are absent");
    let read: DemOptions = serde_json::from_value(json!({
        "grains": { "dust": { "density": 1000.0 } },
        "pairs": [{ "between": ["dust", "dust"], "normal": { "law": "hertz", "youngs_modulus": 1e7, "poissons_ratio": 0.2 } }]
    }))
    .unwrap();
    let pair = PairSpec::new(["dust", "dust"], NormalLaw::hertz(1e7, 0.2));
    assert_eq!(read, DemOptions::new([("dust", GrainKind::new(1000.0))], [pair]));
}

/// Each constructor of a part of the options sets what a file with its required keys has.
#[test]
fn parts_of_the_options_are_those_of_a_file() {
    use colluvium_dem::material::{CellContact, GranularCellSpec, Preparation};
    use colluvium_dem::*;
    fn same<T: serde::de::DeserializeOwned + PartialEq + std::fmt::Debug>(own: &T, file: serde_json::Value) {
        assert_eq!(serde_json::from_value::<T>(file).unwrap(), *own);
    }
    same(&NormalLaw::linear(5.0), json!({ "law": "linear", "stiffness": 5.0 }));
    same(
        &NormalLaw::linear(5.0).restitution(0.1),
        json!({ "law": "linear", "stiffness": 5.0, "restitution": 0.1 }),
    );
    same(&Fill::lattice(LatticePacking::Square), json!({ "kind": "lattice", "packing": "square" }));
    same(&Pluviation::new(2.0), json!({ "rate": 2.0 }));
    same(&Friction::new(0.5), json!({ "coefficient": 0.5 }));
    same(&RollingSpec::new(0.1), json!({ "friction": 0.1 }));
    same(&Adhesion::cohesive(1.0, 2.0), json!({ "kind": "cohesive", "tension": 1.0, "shear": 2.0 }));
    same(
        &Adhesion::capillary(0.07, 0.01),
        json!({ "kind": "capillary", "surface_tension": 0.07, "volume_ratio": 0.01 }),
    );
    same(&BondSpec::new(1e9, 2e9), json!({ "normal_stiffness": 1e9, "shear_stiffness": 2e9 }));
    same(&PairOverride::new(["a", "b"]), json!({ "between": ["a", "b"] }));
    same(&Membrane::new(1e3, "soil"), json!({ "pressure": 1e3, "against": "soil" }));
    same(&Shaking::new([1.0, 0.0], 5.0), json!({ "acceleration": [1.0, 0.0], "frequency": 5.0 }));
    same(&WallServo::new(-1e5, 0.1), json!({ "stress": -1e5, "speed": 0.1 }));
    same(&MeasuringRegion::new([0.0, 1.0], 0.2), json!({ "centre": [0.0, 1.0], "radius": 0.2 }));
    let contact = CellContact::new(NormalLaw::linear(1e6), Friction::new(0.3));
    same(
        &GranularCellSpec::new(2650.0, Diameters::Equal { value: 0.01 }, contact, Preparation::new(1e5)),
        json!({
            "grain_density": 2650.0, "diameter": { "distribution": "equal", "value": 0.01 },
            "contact": { "normal": { "law": "linear", "stiffness": 1e6 }, "friction": { "coefficient": 0.3 } },
            "preparation": { "pressure": 1e5 }
        }),
    );
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
    for end in [0.02, 0.05, 0.07] {
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
    solver.step_to(0.04).unwrap();
    let (grains, snapshot) = (solver.grains(), solver.snapshot());
    for (k, id) in snapshot.ids.iter().enumerate() {
        let at = grains.id().iter().position(|own| u64::from(*own) == *id).unwrap();
        assert_eq!(grains.position()[at][..], snapshot.positions[k][..2]);
    }
    let area = std::f64::consts::PI * 0.05 * 0.05;
    assert!(grains.mass().iter().all(|mass| (mass / (2650.0 * area) - 1.0).abs() < 1e-12));
    assert!(grains.radius().iter().all(|radius| *radius == 0.05));
    assert!(grains.kind().iter().chain(grains.body()).all(|index| *index == 0));
    let count = grains.len();
    assert_eq!(
        (count, grains.angular_velocity().len(), grains.force().len()),
        (snapshot.ids.len(), count, count)
    );
    let before = grains.velocity().as_ptr();
    solver.velocities_mut().fill([0.0, 0.25]);
    solver.angular_velocities_mut().fill([2.0]);
    assert_eq!(before, solver.grains().velocity().as_ptr());
    assert!(solver.grains().velocity().iter().all(|v| *v == [0.0, 0.25]));
    assert!(solver.grains().angular_velocity().iter().all(|w| *w == [2.0]));
    assert_eq!(solver.grains().position().as_ptr(), solver.grains().position().as_ptr());
}

/// Contacts have the forces that act on the grains in the next step, where there are no dashpots and no tangential springs.
#[test]
fn contacts_have_the_forces_of_the_grains() {
    let pair = PairSpec::new(["sand", "sand"], NormalLaw::linear(1e6)).friction(0.0);
    let options = DemOptions { seed: 3, ..DemOptions::new([("sand", sand())], [pair]) };
    let mut case = falling_block();
    case.boundaries[0].wall = Wall::Smooth;
    let mut solver = Dem::new(options).solver::<2>(&case).unwrap();
    solver.step_to(0.06).unwrap();
    let grains = solver.grains();
    let mut sums = vec![[0.0; 2]; grains.len()];
    let mut reaction = 0.0;
    for contact in solver.contacts() {
        let (first, second) = contact.ids;
        assert_eq!(first, grains.id()[contact.grain]);
        assert_eq!(second, contact.second.map(|j| grains.id()[j]));
        assert_eq!(second.is_none(), contact.wall.is_some());
        assert!(contact.overlap > 0.0 && !contact.is_bonded);
        assert_near(contact.normal / (1e6 * contact.overlap), 1.0, 1e-9);
        for c in 0..2 {
            let force = contact.normal * contact.unit_normal[c] + contact.tangential()[c];
            assert_near(force, contact.force[c], 1e-9);
            sums[contact.grain][c] += force;
            if let Some(j) = contact.second {
                sums[j][c] -= force;
            }
        }
        if contact.wall == Some(0) {
            reaction -= contact.force[1];
        }
    }
    assert!(solver.contacts().len() > 20 && !solver.contacts().is_empty());
    let ids: Vec<u32> = grains.id().to_vec();
    let dt = 1e-9;
    solver.step_at_most(dt).unwrap();
    assert_eq!(ids, solver.grains().id(), "no lists were built");
    for (sum, force) in sums.iter().zip(solver.grains().force()) {
        (0..2).for_each(|c| assert_near(sum[c], force[c], 1.0));
    }
    assert_near(solver.wall("y-min").unwrap().force()[1], reaction, 1.0);
}

#[test]
fn changed_velocities_limit_the_step_and_keep_the_energy_balance() {
    let mut solver = solver(&falling_block());
    solver.step_to(0.01).unwrap();
    let before = solver.limit().dt;
    solver.velocities_mut().iter_mut().for_each(|v| *v = [1000.0 + v[0], v[1]]);
    assert!(solver.limit().dt < 0.1 * before);
    let mut bytes = Vec::new();
    solver.save(&mut bytes).unwrap();
    let mut second = self::solver(&falling_block());
    second.restore(&mut bytes.as_slice()).unwrap();
    assert_eq!(solver.limit().dt, second.limit().dt);
    second.velocities_mut().iter_mut().for_each(|v| v[0] -= 1000.0);
    second.step_to(0.03).unwrap();
    assert_near(scalar_output(&*second, "energy_error"), 0.0, 1e-2);
    second.velocities_mut()[3][0] = f64::NAN;
    let error = second.step().unwrap_err().to_string();
    assert!(error.contains("not finite"), "{error}");
}

/// A uniform acceleration moves all grains alike, as gravity does, with its work.
#[test]
fn a_uniform_body_force_is_free_fall() {
    let gravity = [0.3, -10.0];
    let case =
        || space().body(Body::block("b", "sand", [0.0, 0.0], [1.0, 1.0])).stage(Stage::new("fall", 0.2));
    // The grains do not touch each other.
    let fill = Fill::Lattice { packing: LatticePacking::Square, pitch: Some(0.11), jitter: 0.0 };
    let apart = DemOptions::new([("sand", GrainKind { fill: Some(fill), ..sand() })], [pair()]);
    let start = |gravity: [f64; 2]| Dem::new(apart.clone()).solver::<2>(&case().gravity(gravity)).unwrap();
    let (mut fallen, mut pulled) = (start(gravity), start([0.0; 2]));
    pulled.set_body_force(move |_, _, _| gravity);
    let mut dt = 0.0;
    for _ in 0..200 {
        dt = fallen.limit().dt.min(pulled.limit().dt);
        fallen.step_at_most(dt).unwrap();
        pulled.step_at_most(dt).unwrap();
    }
    let (a, b, t) = (fallen.grains(), pulled.grains(), pulled.time());
    for i in 0..a.len() {
        for c in 0..2 {
            // The velocity is that half a step before the positions.
            assert_near(a.velocity()[i][c], gravity[c] * (t - 0.5 * dt), 1e-10);
            assert_near(a.velocity()[i][c], b.velocity()[i][c], 1e-11);
            assert_near(a.position()[i][c], b.position()[i][c], 1e-12);
        }
    }
    let works = [scalar_output(&*fallen, "work.gravity"), scalar_output(&*pulled, "work.forces")];
    assert_near(works[0] / works[1], 1.0, 1e-10);
    assert_near(scalar_output(&*pulled, "energy_error"), 0.0, 1e-9);
    pulled.clear_body_force();
    let before = pulled.grains().velocity()[0];
    pulled.step().unwrap();
    assert_eq!(before, pulled.grains().velocity()[0]);
}

/// Grains that enter during the run have the body force from their first step on.
#[test]
fn a_body_force_acts_on_entering_grains() {
    let gravity = [3.0, -10.0];
    let case =
        || space().body(Body::block("rain", "sand", [0.0, 2.0], [1.0, 2.5])).stage(Stage::new("rain", 0.4));
    let rain = BodyGrains { pluviation: Some(Pluviation::new(400.0)), ..BodyGrains::default() };
    let options = DemOptions { bodies: [("rain".to_owned(), rain)].into(), ..options() };
    let start = |gravity: [f64; 2]| Dem::new(options.clone()).solver::<2>(&case().gravity(gravity)).unwrap();
    let (mut fallen, mut pulled) = (start(gravity), start([0.0; 2]));
    pulled.set_body_force(move |_, _, _| gravity);
    while !fallen.is_complete() {
        let dt = fallen.limit().dt.min(pulled.limit().dt).min(2e-3);
        fallen.step_at_most(dt).unwrap();
        pulled.step_at_most(dt).unwrap();
    }
    let (a, b) = (fallen.grains(), pulled.grains());
    assert!(a.len() > 4 && a.id() == b.id());
    for i in 0..a.len() {
        (0..2).for_each(|c| assert_near(a.position()[i][c], b.position()[i][c], 1e-9));
    }
}

#[test]
fn a_state_with_a_body_force_needs_it_again() {
    let start = || {
        let mut solver = solver(&falling_block());
        solver.set_body_force(|_, v, _| v.map(|v| -3.0 * v));
        solver
    };
    let whole = hash_at_end(start());
    assert_ne!(whole, hash_at_end(solver(&falling_block())));
    let mut first = start();
    first.step_to(0.03).unwrap();
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
    solver.set_body_force(|x, _, _| [0.0, if x[0] > 0.9 { f64::INFINITY } else { 0.0 }]);
    let error = solver.step().unwrap_err().to_string();
    assert!(error.contains("body force of the program") && error.contains("point"), "{error}");
    assert_eq!(before, solver.snapshot().hash());
    let error = solver.step().unwrap_err().to_string();
    assert!(error.contains("an earlier step has failed"), "{error}");
}

/// Each nonsense of a program is refused with the path that a file has.
#[test]
fn nonsense_is_refused_with_the_path_of_a_file() {
    let refusal = |case: &Case, options: DemOptions| -> String {
        let result: Result<Simulation<DemSolver<2, 1>>, CaseErrors> = Dem::new(options).solver::<2>(case);
        result.err().expect("an error").to_string()
    };
    let of_pair = |pair: PairSpec| DemOptions::new([("sand", sand())], [pair]);
    let normal = |law: NormalLaw| of_pair(PairSpec::new(["sand", "sand"], law));
    let held = BodyGrains { held: true, ..BodyGrains::default() };
    let cases = [
        ("methods.dem.pairs[0].normal.stiffness", falling_block(), normal(NormalLaw::linear(-1.0))),
        ("methods.dem.pairs[0].normal.stiffness", falling_block(), normal(NormalLaw::linear(f64::NAN))),
        (
            "methods.dem.pairs[0].normal.restitution",
            falling_block(),
            normal(NormalLaw::linear(1.0).restitution(2.0)),
        ),
        ("methods.dem.pairs[0].friction.coefficient", falling_block(), of_pair(pair().friction(-0.1))),
        (
            "methods.dem.grains.sand.density",
            falling_block(),
            DemOptions::new([("sand", GrainKind { density: -1.0, ..sand() })], [pair()]),
        ),
        (
            "bodies[0].material",
            falling_block(),
            DemOptions::new([("clay", sand())], [PairSpec::new(["clay", "clay"], NormalLaw::linear(1e6))]),
        ),
        (
            "methods.dem.bodies.ball",
            falling_block(),
            DemOptions { bodies: [("ball".to_owned(), held)].into(), ..options() },
        ),
        ("methods.dem.skin", falling_block(), DemOptions { skin: 5.0, ..options() }),
        ("gravity", falling_block().gravity([0.0, 0.0, -10.0]), options()),
        ("stages[2].duration", falling_block().stage(Stage::new("s", f64::INFINITY)), options()),
    ];
    for (path, case, options) in cases {
        let error = refusal(&case, options);
        assert!(error.contains(path), "{path}: {error}");
    }
    let error = Dem::new(options()).solver::<3>(&falling_block()).err().unwrap().to_string();
    assert!(error.contains("space: gives a solver of 2 dimensions, and one of 3 was requested"), "{error}");
}

#[test]
fn spheres_are_stepped_by_a_program() {
    let grain = GrainKind { fill: Some(Fill::Single), ..GrainKind::new(2650.0) };
    let case = Case::new(Space::ThreeD, Domain::new([-1.0; 3], [1.0; 3]))
        .gravity([0.0, 0.0, -10.0])
        .material("sand", LinearElasticSpec::new(2650.0, 1e7, 0.3))
        .body(Body::ball("ball", "sand", [0.0, 0.0, 0.0], 0.1))
        .stage(Stage::new("fall", 0.1));
    let mut solver = Dem::new(DemOptions::new([("sand", grain)], [pair()])).solver::<3>(&case).unwrap();
    solver.angular_velocities_mut()[0] = [0.0, 0.0, 3.0];
    solver.step_to(0.1).unwrap();
    assert_near(solver.grains().position()[0][2], -0.05, 1e-3);
    assert_eq!(solver.grains().angular_velocity(), [[0.0, 0.0, 3.0]]);
}
