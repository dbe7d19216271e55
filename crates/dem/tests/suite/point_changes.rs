//! Points that a program adds and removes while it steps.

use colluvium_case::{
    Body, Boundary, Case, Domain, GrainColumns, PointList, Side, Simulation, Solver, Space, Stage, Wall,
};
use colluvium_constitutive::LinearElasticSpec;
use colluvium_dem::{
    Dem, DemOptions, DemSolver, Diameters, Fill, GrainKind, GrainStage, LatticePacking, NormalLaw, PairSpec,
};
use colluvium_testkit::{assert_near, scalar_output};

/// Block of disks that falls on a floor.
fn solver() -> Simulation<DemSolver<2, 1>> {
    let case = Case::new(Space::PlaneStrain, Domain::new([-2.0, -2.0], [4.0, 4.0]))
        .gravity([0.0, -10.0])
        .material("sand", LinearElasticSpec::new(2650.0, 1e7, 0.3))
        .body(Body::block("block", "sand", [0.0, 0.05], [1.5, 1.0]).velocity([0.5, -1.0]))
        .boundary(Boundary { position: Some(0.0), ..Boundary::new(Side::YMin, Wall::frictional(0.5)) })
        .stage(Stage::new("fall", 0.1));
    let fill = Fill::Lattice { packing: LatticePacking::Hexagonal, pitch: None, jitter: 0.02 };
    let sand = GrainKind::filled(2650.0, Diameters::Equal { value: 0.1 }, fill);
    let pair = PairSpec::new(["sand", "sand"], NormalLaw::linear(1e6).restitution(0.5)).friction(0.4);
    let options = DemOptions { seed: 3, ..DemOptions::new([("sand", sand)], [pair]) };
    Dem::new(options).solver::<2>(&case).unwrap()
}

/// Grains beside the block.
fn grains() -> PointList {
    PointList {
        positions: vec![[3.0, 2.0, 0.0], [3.2, 2.0, 0.0]],
        volumes: vec![0.01; 2],
        velocities: Some(vec![[0.0; 3]; 2]),
        grains: GrainColumns { radii: Some(vec![0.05, 0.08]), ..GrainColumns::default() },
        ..PointList::default()
    }
}

/// Solver to which grains have been added at 50 ms.
fn grown() -> Simulation<DemSolver<2, 1>> {
    let mut solver = solver();
    solver.step_to(0.05).unwrap();
    solver.add_points(0, &grains()).unwrap();
    solver
}

/// Hash after all stages.
fn hash_at_end(mut solver: Simulation<DemSolver<2, 1>>) -> u64 {
    while !solver.is_complete() {
        solver.step().unwrap();
    }
    solver.snapshot().hash()
}

#[test]
fn added_grains_have_their_radii_and_fall_freely() {
    let mut solver = grown();
    let count = solver.grains().len();
    let at = |solver: &Simulation<DemSolver<2, 1>>, id: usize| {
        solver.grains().id().iter().position(|own| *own as usize == id).unwrap()
    };
    let last = at(&solver, count - 1);
    let mass = 2650.0 * std::f64::consts::PI * 0.08f64.powi(2);
    assert_near(solver.grains().mass()[last], mass, 1e-12 * mass);
    let (start, first_step) = (solver.time(), solver.step().unwrap().dt);
    solver.step_to(0.1).unwrap();
    let velocity = solver.grains().velocity()[at(&solver, count - 1)];
    // Velocities are half a step before the positions.
    let slack = 10.0 * first_step;
    assert!((velocity[1] + 10.0 * (solver.time() - start)).abs() < slack, "{velocity:?}");
    let error = scalar_output(&*solver, "energy_error");
    assert!(error.abs() < 1e-3, "{error}");
}

#[test]
fn bits_with_added_grains_are_the_same_on_two_threads_and_after_a_restart() {
    let whole = hash_at_end(grown());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    assert_eq!(whole, pool.install(|| hash_at_end(grown())));
    let mut bytes = Vec::new();
    grown().save(&mut bytes).unwrap();
    let mut restored = solver();
    restored.restore(&mut bytes.as_slice()).unwrap();
    assert_eq!(whole, hash_at_end(restored));
}

/// The stable step follows from the smallest grains that there are, before and after a restart.
#[test]
fn a_restart_after_small_grains_are_removed_has_the_same_bits() {
    let small = PointList {
        grains: GrainColumns { radii: Some(vec![0.01, 0.01]), ..GrainColumns::default() },
        ..grains()
    };
    let start = || {
        let mut solver = solver();
        let step = solver.limit().dt;
        let ids: Vec<u32> = solver.add_points(0, &small).unwrap().collect();
        assert!(solver.limit().dt < 0.5 * step);
        solver.step().unwrap();
        solver.remove_points(&ids).unwrap();
        assert_near(solver.limit().dt, step, 1e-12 * step);
        solver
    };
    let mut bytes = Vec::new();
    start().save(&mut bytes).unwrap();
    let mut restored = solver();
    restored.restore(&mut bytes.as_slice()).unwrap();
    assert_eq!(hash_at_end(start()), hash_at_end(restored));
}

/// Two blocks, of which the second stage removes the one of small grains; velocities are disturbed at the start.
fn removed_block() -> Simulation<DemSolver<2, 1>> {
    let case = Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [4.0, 2.0]))
        .gravity([0.0, -10.0])
        .material("sand", LinearElasticSpec::new(2650.0, 1e7, 0.3))
        .material("fine", LinearElasticSpec::new(2650.0, 1e7, 0.3))
        .body(Body::block("block", "sand", [0.0, 0.05], [1.5, 1.0]))
        .body(Body::block("fines", "fine", [2.0, 0.05], [2.5, 0.5]))
        .wall(Side::YMin, Wall::frictional(0.5))
        .stage(Stage::new("fall", 0.02))
        .stage(Stage { remove_bodies: vec!["fines".to_owned()], ..Stage::new("alone", 0.05) });
    let kind = |value| {
        let fill = Fill::Lattice { packing: LatticePacking::Hexagonal, pitch: None, jitter: 0.0 };
        GrainKind::filled(2650.0, Diameters::Equal { value }, fill)
    };
    let pair =
        |a: &str, b: &str| PairSpec::new([a, b], NormalLaw::linear(1e6).restitution(0.5)).friction(0.4);
    let pairs = [pair("sand", "sand"), pair("fine", "fine"), pair("sand", "fine")];
    let agitated = GrainStage { agitation: 0.1, ..GrainStage::default() };
    let options = DemOptions {
        stages: [("fall".to_owned(), agitated)].into(),
        ..DemOptions::new([("sand", kind(0.1)), ("fine", kind(0.02))], pairs)
    };
    Dem::new(options).solver::<2>(&case).unwrap()
}

#[test]
fn a_restart_in_the_stage_that_removes_small_grains_or_at_the_very_start_has_the_same_bits() {
    let whole = hash_at_end(removed_block());
    for time in [0.0, 0.03] {
        let mut solver = removed_block();
        solver.step_to(time).unwrap();
        let mut bytes = Vec::new();
        solver.save(&mut bytes).unwrap();
        let (limit, mut restored) = (solver.limit(), removed_block());
        restored.restore(&mut bytes.as_slice()).unwrap();
        assert_eq!(restored.limit(), limit);
        // The rest is stepped from the same time.
        assert_eq!(hash_at_end(solver), hash_at_end(restored));
        if time == 0.0 {
            let mut restored = removed_block();
            restored.restore(&mut bytes.as_slice()).unwrap();
            assert_eq!(hash_at_end(restored), whole);
        }
    }
}

#[test]
fn removed_grains_are_gone_with_their_contacts() {
    let mut solver = solver();
    solver.step_to(0.1).unwrap();
    let contact = solver.contacts().first().unwrap();
    let id = solver.grains().id()[contact.grain];
    let (count, contacts) = (solver.grains().len(), solver.contacts().len());
    solver.remove_points(&[id]).unwrap();
    assert_eq!(solver.grains().len(), count - 1);
    assert!(solver.contacts().len() < contacts && !solver.grains().id().contains(&id));
    let all = solver.grains().id().to_vec();
    solver.remove_points(&all).unwrap();
    assert!(solver.grains().is_empty() && solver.contacts().is_empty());
}

#[test]
fn invalid_changes_are_refused_and_leave_the_state_as_it_was() {
    let mut solver = grown();
    let before = solver.snapshot().hash();
    let taken = solver.grains().position()[0];
    let on_grain =
        PointList { positions: vec![[3.0, 3.0, 0.0], [taken[0], taken[1] + 1e-3, 0.0]], ..grains() };
    let together = PointList { positions: vec![[3.0, 3.0, 0.0], [3.01, 3.0, 0.0]], ..grains() };
    let in_floor = PointList { positions: vec![[3.0, 0.01, 0.0], [3.0, 3.0, 0.0]], ..grains() };
    let numbered = GrainColumns { ids: Some(vec![7, 8]), ..grains().grains };
    let unknown = GrainColumns { grain_types: Some(vec!["ice".to_owned(); 2]), ..grains().grains };
    for (list, path) in [
        (on_grain, "points.positions[1]"),
        (together, "points.positions[1]"),
        (in_floor, "points.positions[0]"),
        (PointList { grains: numbered, ..grains() }, "points.grains.ids"),
        (PointList { grains: unknown, ..grains() }, "points"),
    ] {
        assert_eq!(solver.add_points(0, &list).unwrap_err().path, path);
    }
    assert_eq!(solver.remove_points(&[3, 4000]).unwrap_err().path, "ids[1]");
    assert_eq!(before, solver.snapshot().hash());
}
