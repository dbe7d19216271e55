//! Errors of solvers that a program describes, steps and changes: refused with the path of a file, never a panic.

use std::sync::Arc;

use colluvium_case::{
    Body, Case, CaseErrors, Domain, FailureReason, Simulation, Solver, SolverError, Space, Stage, TypedMethod,
};
use colluvium_constitutive::{
    InitialCondition, Law, LinearElasticSpec, MaterialError, Motion, Point, PointLaw, StressUpdate, SymTensor,
};
use colluvium_sph::{ConfiningPressure, Sph, SphOptions, SphSolver, Tensile, TimeHistory, TimeIntegration};

use crate::program::{falling_block, options, solver};

/// Message of the refusal of a case with options.
fn refusal(case: &Case, options: SphOptions) -> String {
    let result: Result<Simulation<SphSolver<2>>, CaseErrors> = Sph::new(options).solver::<2>(case);
    result.err().expect("an error").to_string()
}

#[test]
fn nonsense_is_refused_with_the_path_of_a_file() {
    let soil = |density: f64| LinearElasticSpec::new(density, 1e6, 0.3);
    let cases = [
        ("materials.soil.density", falling_block().material("soil", soil(-1.0)), options()),
        ("materials.soil.density", falling_block().material("soil", soil(f64::NAN)), options()),
        (
            "materials.soil.density",
            falling_block().law("soil", f64::NAN, Arc::new(Faulty(Fault::Error))),
            options(),
        ),
        ("bodies[1].material", falling_block().body(Body::ball("b", "ice", [0.5, 0.3], 0.05)), options()),
        ("bodies[1].shape", falling_block().body(Body::ball("b", "soil", [0.5, 0.3], -0.05)), options()),
        ("bodies[1].shape", falling_block().body(Body::ball("b", "soil", [0.5, f64::NAN], 0.05)), options()),
        ("stages[2].duration", falling_block().stage(Stage::new("s", f64::INFINITY)), options()),
        ("gravity", falling_block().gravity([0.0, 0.0, -10.0]), options()),
        ("methods.sph.spacing", falling_block(), SphOptions::new(f64::NAN)),
        ("methods.sph.spacing", falling_block(), SphOptions::new(-1.0)),
        ("methods.sph.courant", falling_block(), SphOptions { courant: f64::NAN, ..options() }),
        ("methods.sph.held", falling_block(), SphOptions { held: vec!["x".to_owned()], ..options() }),
        ("methods.sph.ranks", falling_block(), SphOptions { ranks: 2, ..options() }),
        ("stages", Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [1.0, 1.0])), options()),
    ];
    for (path, case, options) in cases {
        let error = refusal(&case, options);
        assert!(error.contains(path), "{path}: {error}");
    }
    let tensile = Tensile::ArtificialStress { strength: f64::NAN, exponent: 4.0 };
    let error = refusal(&falling_block(), SphOptions { tensile, ..options() });
    assert!(error.contains("methods.sph.tensile"), "{error}");
    let confining = Some(ConfiningPressure::new(-1.0));
    let error = refusal(&falling_block(), SphOptions { confining, ..options() });
    assert!(error.contains("methods.sph.confining.pressure"), "{error}");
    let held_history = [("block".to_owned(), TimeHistory::new([0.0, 0.0], [1.0, 1.0]))].into();
    let error =
        refusal(&falling_block(), SphOptions { held: vec!["block".to_owned()], held_history, ..options() });
    assert!(error.contains("methods.sph.held_history.block.times[1]"), "{error}");
}

#[test]
fn a_solver_of_another_dimension_is_refused() {
    let error = Sph::new(options()).solver::<3>(&falling_block()).err().unwrap().to_string();
    assert!(error.contains("space: gives a solver of 2 dimensions, and one of 3 was requested"), "{error}");
    let case = falling_block().method(&options()).checked(std::path::Path::new("")).unwrap();
    let error = TypedMethod::<1>::typed_solver(&Sph, &case).err().unwrap().to_string();
    assert!(error.contains("space: has not 1 dimensions"), "{error}");
}

#[test]
fn ranks_are_available_in_a_run_only() {
    let error = refusal(&falling_block(), SphOptions { ranks: 3, ..options() });
    assert!(error.contains("methods.sph.ranks: 3 ranks are available in a run only"), "{error}");
}

#[test]
fn an_infinite_body_force_leaves_the_state_as_it_was() {
    for integration in [TimeIntegration::Leapfrog, TimeIntegration::RungeKutta4] {
        let mut solver =
            Sph::new(SphOptions { integration, ..options() }).solver::<2>(&falling_block()).unwrap();
        solver.step().unwrap();
        let before = (solver.snapshot().hash(), solver.particles().position().to_vec());
        let pull = |x: &[f64; 2], _: &[f64; 2], _: f64| [0.0, if x[0] > 0.2 { f64::INFINITY } else { 0.0 }];
        solver.set_body_force(pull).unwrap();
        let error = solver.step().unwrap_err();
        let SolverError::Point { point, ref position, .. } = error else { panic!("{error}") };
        assert!(
            position[0] > 0.2 && error.to_string().contains("body force of the program"),
            "{point} {error}"
        );
        assert_eq!(before, (solver.snapshot().hash(), solver.particles().position().to_vec()));
        let error = solver.step().unwrap_err();
        assert!(matches!(error, SolverError::Step { reason: FailureReason::HasFailed, .. }), "{error}");
        assert!(error.to_string().contains("an earlier step has failed"), "{error}");
    }
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

/// Fault of a law.
#[derive(Clone, Copy, PartialEq)]
enum Fault {
    /// Stress that is not a number.
    Stress,
    /// Step that the law refuses.
    Error,
    /// Wave modulus that is not a number.
    Modulus,
}

/// Law with a fault in points that are compressed.
struct Faulty(Fault);

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

    fn wave_modulus(&self, point: &Point<f64>) -> f64 {
        if self.0 == Fault::Modulus && point.state < -1e-4 { f64::NAN } else { 1e6 }
    }
}

impl StressUpdate for Faulty {
    fn update(&self, motion: &Motion, old: &Point<f64>) -> Result<Point<f64>, MaterialError> {
        let state = old.state + motion.strain_increment().trace();
        let stress = SymTensor::isotropic(1e6 * state);
        match self.0 {
            Fault::Error if state < -1e-4 => Err(MaterialError::update("faulty", "no solution")),
            Fault::Stress if state < -1e-4 => Ok(Point { stress: stress * f64::NAN, state }),
            _ => Ok(Point { stress, state }),
        }
    }
}

#[test]
fn a_faulty_law_is_an_error_that_names_the_particle() {
    for (fault, reason) in
        [(Fault::Error, "faulty: no solution"), (Fault::Stress, "its stress is not finite")]
    {
        let case = falling_block().law("soil", 1600.0, Arc::new(Faulty(fault)));
        let error = solver(&case).step_to(0.03).unwrap_err();
        let text = error.to_string();
        let SolverError::Point { position, reason: kind, .. } = error else { panic!("{error}") };
        // The floor compresses the lowest particles first.
        assert!(position[1] < 0.1 && text.contains(reason), "{text}");
        match kind {
            FailureReason::Law { material, error } => {
                assert_eq!((fault == Fault::Error, material.as_str()), (true, "soil"));
                assert_eq!(*error, MaterialError::update("faulty", "no solution"));
            }
            FailureReason::NotFinite(_) => assert!(fault == Fault::Stress),
            other => panic!("{other:?}"),
        }
    }
    let case = falling_block().law("soil", 1600.0, Arc::new(Faulty(Fault::Modulus)));
    let error = solver(&case).step_to(0.03).unwrap_err();
    assert!(matches!(error, SolverError::Point { .. }), "{error}");
}

#[test]
fn a_faulty_law_is_an_error_in_each_scheme() {
    for integration in [
        TimeIntegration::LeapfrogRates,
        TimeIntegration::PredictorCorrector,
        TimeIntegration::PositionVerlet,
        TimeIntegration::VelocityVerlet,
        TimeIntegration::Verlet,
        TimeIntegration::RungeKutta4,
    ] {
        for fault in [Fault::Error, Fault::Stress] {
            let case = falling_block().law("soil", 1600.0, Arc::new(Faulty(fault)));
            let mut solver = Sph::new(SphOptions { integration, ..options() }).solver::<2>(&case).unwrap();
            let error = solver.step_to(0.03).unwrap_err();
            assert!(matches!(error, SolverError::Point { .. }), "{error}");
        }
    }
}
