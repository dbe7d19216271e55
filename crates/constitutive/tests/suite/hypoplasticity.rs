//! Hypoplasticity and its viscous part: reference values of `sheet: constitutive §2.12, V-16, V-17`, and
//! bad input of §7 (kPa in the comments, Pa in the code).

use colluvium_constitutive::driver::{ElementPath, ElementTest, LoadingPath, TestStage};
use colluvium_constitutive::laws::hypoplastic::{
    Calibration, CriticalState, HypoplasticConstants, HypoplasticParameters, HypoplasticSpec,
};
use colluvium_constitutive::laws::{AccelerationViscosity, ViscousMode};
use colluvium_constitutive::{
    InitialCondition, Mat3, MaterialError, MaterialSpec, Model, Motion, Point, PointLaw, StressUpdate,
    SymTensor,
};
use colluvium_testkit::assert_near;

const VISCOSITY: AccelerationViscosity = AccelerationViscosity {
    a: -8e-4,
    m1: 0.5,
    m2: 1e-3,
    eta1: 0.0,
    eta3: 0.0,
    mode: ViscousMode::Integrated,
};

const CRITICAL: CriticalState =
    CriticalState { minimum_void_ratio: 0.5, p1: 0.5, p2: 0.5, p3: -5e-7, q1: 1.0, q2: -0.2, q3: -1e-7 };

fn calibration(friction_angle: f64, youngs_modulus: f64) -> Calibration {
    Calibration { youngs_modulus, pressure: 100e3, poissons_ratio: 0.0, friction_angle, dilatancy_angle: 0.0 }
}

fn constants(friction_angle: f64, youngs_modulus: f64) -> HypoplasticConstants {
    HypoplasticConstants::calibrate(&calibration(friction_angle, youngs_modulus)).unwrap()
}

fn spec() -> HypoplasticSpec {
    HypoplasticSpec {
        density: 1700.0,
        void_ratio: 0.7,
        parameters: HypoplasticParameters::Calibration(calibration(30.0, 20e6)),
        critical_state: None,
        minimum_pressure: 10.0,
        viscous: None,
    }
}

fn run(spec: HypoplasticSpec, path: LoadingPath, steps: usize, duration: f64) -> ElementPath {
    let test = ElementTest {
        title: String::new(),
        material: MaterialSpec::Hypoplastic(spec),
        initial_stress: [-100e3, -100e3, -100e3, 0.0, 0.0, 0.0],
        stages: vec![TestStage { path, steps, duration }],
    };
    test.run().unwrap()
}

#[test]
fn calibrations_have_the_constants_of_the_sheet() {
    for (friction, modulus, exact) in [
        (30.0, 20e6, [-66.666_666_7, -615.481_247_3, -615.481_247_3, 654.341_392_4]),
        (33.0, 30e6, [-100.0, -819.194_246_3, -819.194_246_3, 638.811_112_2]),
    ] {
        let HypoplasticConstants { c1, c2, c3, c4 } = constants(friction, modulus);
        for (found, exact) in [c1, c2, c3, c4].into_iter().zip(exact) {
            assert_near(found, exact, 1e-7);
        }
    }
}

#[test]
fn calibrated_constants_satisfy_the_four_calibration_conditions() {
    let of = Calibration { poissons_ratio: 0.2, dilatancy_angle: 5.0, ..calibration(32.0, 15e6) };
    let set = HypoplasticConstants::calibrate(&of).unwrap();
    let isotropic = SymTensor::isotropic(-100e3);
    let rate = set.rate(&isotropic, &SymTensor::diagonal(-1.0, 0.2, 0.2), 1.0);
    assert_near(rate[0], -15e6, 1e-6);
    assert_near(rate[2], 0.0, 1e-6);
    let sin = 32f64.to_radians().sin();
    let failure = SymTensor::diagonal((1.0 + sin) / (sin - 1.0), -1.0, -1.0) * 100e3;
    let nu = 0.5 * (1.0 + 5f64.to_radians().tan());
    assert_near(set.rate(&failure, &SymTensor::diagonal(-1.0, nu, nu), 1.0).norm(), 0.0, 1e-6);
    assert_near(set.failure_flow(&failure, 1.0).norm(), 1.0, 1e-12);
}

#[test]
fn the_printed_table_is_a_degenerate_calibration() {
    // E_i = 500 kPa at 100 kPa, φ = 15°, ψ = 0: the exact constants behind Table 1.
    let exact =
        HypoplasticConstants { c1: -1.666_666_7, c2: -283.437_391, c3: -283.437_391, c4: 2_419.349_97 };
    let states = exact.stationary_states();
    assert_eq!(states.len(), 3, "{states:?}");
    for (state, (ratio, angle)) in states.iter().zip([(1.065, -43.0), (1.698, 0.0), (2.216, 63.0)]) {
        assert_near(state.stress_ratio, ratio, 6e-4);
        assert_near(state.dilatancy_angle.to_degrees(), angle, 0.5);
    }
    let refused = HypoplasticConstants::calibrate(&calibration(15.0, 500e3));
    let Err(MaterialError::Parameter { field, rule, .. }) = refused else { panic!("{refused:?}") };
    assert_eq!(field, "parameters.calibration.friction_angle");
    assert!(rule.contains("1.0645"), "{rule}");
    // The printed set is accepted as direct constants, with a warning.
    let printed = HypoplasticSpec {
        parameters: HypoplasticParameters::Constants(HypoplasticConstants::TABLE_1),
        ..spec()
    };
    printed.law().unwrap();
    assert!(printed.warnings()[0].text.starts_with("parameters.constants:"), "{:?}", printed.warnings());
    // From 18° on the intended state is the only one.
    for friction in [18.0, 25.0, 30.0, 33.0] {
        let states = constants(friction, 20e6).stationary_states();
        assert_eq!(states.len(), 1, "{friction}: {states:?}");
    }
    assert!(spec().warnings().is_empty());
    // Steeper sets have another one far above failure, out of reach.
    let steep = constants(40.0, 20e6).stationary_states();
    assert_near(steep[0].stress_ratio, 4.598_909_932, 1e-8);
    assert!(steep[1..].iter().all(|state| state.stress_ratio > 10.0), "{steep:?}");
}

#[test]
fn a_single_evaluation() {
    let stress = SymTensor([-100e3, -80e3, -60e3, 15e3, 0.0, 0.0]);
    let l = Mat3([[-1e-3, 2e-3, 0.0], [0.5e-3, 0.5e-3, 0.0], [0.0; 3]]);
    let d = l.sym();
    assert_near(d.norm(), 0.002_091_650_066, 1e-12);
    let rate = constants(30.0, 20e6).rate(&stress, &d, 0.9);
    let exact = [5.150_940_15, 18.825_191_32, 0.324_178_56, 12.255_688_38];
    for (k, exact) in exact.into_iter().enumerate() {
        assert_near(rate[k] * 1e-3, exact, 1e-8);
    }
    let spin = l.skew();
    let turned = rate.to_matrix() + spin * stress.to_matrix() - stress.to_matrix() * spin;
    assert_near(turned.0[0][0] * 1e-3, 5.173_440_15, 1e-8);
    assert_near(turned.0[1][1] * 1e-3, 18.802_691_32, 1e-8);
    assert_near(turned.0[0][1] * 1e-3, 12.270_688_38, 1e-8);
}

/// Stress ratio and void ratio at the end of a drained triaxial test.
fn triaxial(spec: &HypoplasticSpec, axial_compression: f64, steps: usize) -> (f64, f64, ElementPath) {
    let path = run(spec.clone(), LoadingPath::TriaxialDrained { axial_compression }, steps, 1.0);
    let ratio = path.last("stress_zz") / path.last("stress_xx");
    (ratio, path.last("void_ratio"), path)
}

#[test]
fn drained_triaxial_compression_reaches_the_critical_stress_ratio() {
    // sheet: constitutive V-16, without dependence on density.
    for (strain, exact) in [
        (0.001, 1.193_145),
        (0.005, 1.841_913),
        (0.01, 2.394_411),
        (0.02, 2.865_386),
        (0.05, 2.998_983),
        (0.1, 3.0),
    ] {
        let (ratio, ..) = triaxial(&spec(), strain, 200);
        assert_near(ratio, exact, 5e-4 * exact);
    }
    let (_, void_ratio, path) = triaxial(&spec(), 0.1, 400);
    assert_near(void_ratio, 0.687_857, 5e-4 * 0.687_857);
    let lateral = path.column("strain_xx").unwrap();
    assert_near((lateral[400] - lateral[380]) / (0.1 * 20.0 / 400.0), 0.5, 5e-4);
}

#[test]
fn dense_soil_peaks_and_softens_to_the_critical_state() {
    // sheet: constitutive V-16, e₀ = 0.70 and 0.90: peak, its strain, and the ends at a strain of 0.4; 5·10⁻⁴.
    let dense = HypoplasticSpec { critical_state: Some(CRITICAL), ..spec() };
    let (ratio, void_ratio, path) = triaxial(&dense, 0.4, 2000);
    assert_near(ratio, 3.2390, 5e-4 * 3.2390);
    assert_near(void_ratio, 0.805_491, 5e-4 * 0.805_491);
    let ratios = path.column("stress_zz").unwrap().into_iter().zip(path.column("stress_xx").unwrap());
    let ratios: Vec<f64> = ratios.map(|(axial, lateral)| axial / lateral).collect();
    let peak = (0..ratios.len()).max_by(|&a, &b| ratios[a].total_cmp(&ratios[b])).unwrap();
    assert_near(ratios[peak], 3.617_78, 5e-4 * 3.617_78);
    assert_near(0.4 / 2000.0 * peak as f64, 0.0403, 4e-4);
    let loose = HypoplasticSpec { void_ratio: 0.9, ..dense };
    let (_, void_ratio, path) = triaxial(&loose, 0.4, 2000);
    assert_near(void_ratio, 0.888_273, 5e-4 * 0.888_273);
    let ratios = path.column("stress_zz").unwrap().into_iter().zip(path.column("stress_xx").unwrap());
    assert_near(ratios.map(|(a, l)| a / l).fold(0.0, f64::max), 3.0059, 5e-4 * 3.0059);
}

#[test]
fn stress_without_viscosity_is_rate_independent() {
    let law = spec().build().unwrap();
    let l = Mat3([[-0.1, 0.3, 0.0], [0.0, 0.05, 0.1], [0.0, 0.0, 0.02]]);
    let stress = |rate: f64| {
        let start = InitialCondition { stress: SymTensor::isotropic(-100e3), density: 1700.0 };
        let (mut stress, mut states) = law.initial(&[start]).unwrap();
        let motion = Motion::from_velocity_gradient(&(l * rate), 0.1 / rate, 1700.0, 1.0).unwrap();
        for _ in 0..5 {
            law.update(&[motion], &mut stress, &mut states.blocks_mut()[0]).unwrap();
        }
        stress[0]
    };
    let (slow, fast) = (stress(1.0), stress(2.0));
    assert!((slow - fast).norm() <= 1e-9 * slow.norm());
}

#[test]
fn expansion_ends_at_the_floor_and_recompression_starts_there() {
    let law = spec().law().unwrap();
    let still = Motion::from_velocity_gradient(&Mat3::ZERO, 1.0, 1700.0, 1.0).unwrap();
    let start = Point { stress: SymTensor([-40e3, -50e3, -45e3, 5e3, 0.0, 0.0]), state: Default::default() };
    use colluvium_constitutive::SmallStrain;
    let open = law.update(&SymTensor::isotropic(0.05), &still, &start).unwrap();
    assert_eq!(open.stress, SymTensor::isotropic(-10.0));
    let wider = law.update(&SymTensor::diagonal(0.05, -0.01, 0.0), &still, &open).unwrap();
    assert_eq!(wider.stress, open.stress);
    let closing = law.update(&SymTensor::isotropic(-0.01), &still, &wider).unwrap();
    assert!(closing.stress.pressure() > 100.0);
}

#[test]
fn the_integral_of_the_viscous_rate() {
    for (x, exact) in [(1.0, -5.658_739_302e-4), (50.0, -0.044_409_196_67), (500.0, -3.189_477_682)] {
        assert_near(VISCOSITY.phi(x), exact, 1e-9 * f64::abs(exact));
    }
    let linear = AccelerationViscosity { m2: 0.0, ..VISCOSITY };
    assert_near(linear.phi(3.0), -8e-4 * 0.5f64.sqrt() * 3.0, 1e-15);
}

#[test]
fn the_integrated_viscous_stress_solves_its_equation() {
    let inviscid = SymTensor([-100e3, -80e3, -60e3, 15e3, 5e3, -3e3]);
    let stretching = SymTensor([-20.0, 5.0, 10.0, 30.0, -4.0, 2.0]);
    let total = VISCOSITY.total(&inviscid, &stretching);
    let rate = stretching.norm();
    let anticommutator = (total.to_matrix() * stretching.to_matrix()).sym() * 2.0;
    let again = inviscid + anticommutator * (VISCOSITY.phi(rate) / rate);
    assert!((again - total).norm() < 1e-12 * total.norm());
}

#[test]
fn viscous_stress_of_a_ramp_of_the_shear_rate() {
    // V-17 (b): normal stress P on the planes of shear kept, friction ratio and normal-stress ratio of the
    // frictional part frozen.
    let (friction, lateral) = (0.657_168_0, 0.979_281_5);
    let table = [
        (10.0, 0.005_690_3, -0.003_787_8, 0.660_369),
        (50.0, 0.037_154_9, -0.025_059_3, 0.677_855),
        (100.0, 0.109_419_1, -0.075_958_1, 0.716_670),
        (200.0, 0.381_535_8, -0.291_109_2, 0.847_396),
    ];
    let stretching = |rate: f64| SymTensor([0.0, 0.0, 0.0, 0.5 * rate, 0.0, 0.0]);
    let total = |viscous: &SymTensor| {
        let normal = -1.0 - viscous[1];
        let inviscid = SymTensor([lateral * normal, normal, normal, -friction * normal, 0.0, 0.0]);
        inviscid + *viscous
    };
    let (mut viscous, mut rate, step) = (SymTensor::ZERO, 0.0, 0.01);
    for (end, shear, normal, ratio) in table {
        while rate < end - 0.5 * step {
            let (from, to) = (stretching(rate), stretching(rate + step));
            let half = viscous + VISCOSITY.increment(&total(&viscous), &from, &to, 1.0) * 0.5;
            viscous += VISCOSITY.increment(&total(&half), &from, &to, 1.0);
            rate += step;
        }
        assert_near(viscous[3], shear, 1e-2 * shear);
        assert_near(viscous[1], normal, 1e-2 * f64::abs(normal));
        assert_near(total(&viscous)[3], ratio, 1e-2 * ratio);
    }
}

#[test]
fn fast_shear_raises_friction_and_void_ratio_and_unloads_the_skeleton() {
    // Slow shear to the critical state, then on at the given rate.
    let at = |rate: f64, mode| {
        let viscous = AccelerationViscosity { mode, ..VISCOSITY };
        let material = HypoplasticSpec { critical_state: Some(CRITICAL), viscous: Some(viscous), ..spec() };
        let path = LoadingPath::SimpleShearConstantNormalStress { shear: 1.0 };
        let stage = |rate: f64| TestStage { path: path.clone(), steps: 500, duration: 1.0 / rate };
        let test = ElementTest {
            title: String::new(),
            material: MaterialSpec::Hypoplastic(material),
            initial_stress: [-100e3, -100e3, -100e3, 0.0, 0.0, 0.0],
            stages: vec![stage(0.1), stage(rate)],
        };
        let path = test.run().unwrap();
        (path.last("stress_xy") / -path.last("stress_yy"), path.last("void_ratio"))
    };
    for mode in [ViscousMode::Integrated, ViscousMode::RateMaterial] {
        let (slow, fast, faster) = (at(0.1, mode), at(20.0, mode), at(60.0, mode));
        assert!(slow.0 < fast.0 && fast.0 < faster.0, "{mode:?}: {slow:?} {fast:?} {faster:?}");
        assert!(slow.1 < fast.1 && fast.1 < faster.1, "{mode:?}: {slow:?} {fast:?} {faster:?}");
    }
}

/// Material rate of the stretching: in steady simple shear the viscous stress is constant, where a
/// corotational rate would continue to change it (`D W - W D` of ±γ̇²/2) and rotate it.
#[test]
fn with_the_material_rate_the_viscous_stress_of_steady_shear_is_constant() {
    use colluvium_constitutive::Corotational;
    let viscous = AccelerationViscosity { mode: ViscousMode::RateMaterial, ..VISCOSITY };
    let law =
        colluvium_constitutive::laws::AccelerationViscous::new(Corotational(spec().law().unwrap()), viscous)
            .unwrap();
    let start = InitialCondition { stress: SymTensor::isotropic(-100e3), density: 1700.0 };
    let l = Mat3([[0.0, 40.0, 0.0], [0.0; 3], [0.0; 3]]);
    let motion = Motion::from_velocity_gradient(&l, 1e-4, 1700.0, 1.0).unwrap();
    let mut point = law.update(&motion, &law.initial(&start).unwrap()).unwrap();
    let first = point.state.viscous;
    assert!(first.norm() > 1e3, "{first:?}");
    for _ in 0..100 {
        point = law.update(&motion, &point).unwrap();
        assert!((point.state.viscous - first).norm() < 1e-8 * first.norm(), "{:?}", point.state.viscous);
    }
}

#[test]
fn viscous_stress_ends_with_the_motion_and_rotates_with_the_observer() {
    use colluvium_constitutive::Corotational;
    let law = colluvium_constitutive::laws::AccelerationViscous::new(
        Corotational(spec().law().unwrap()),
        VISCOSITY,
    )
    .unwrap();
    let start = InitialCondition { stress: SymTensor::isotropic(-100e3), density: 1700.0 };
    let l = Mat3([[-3.0, 20.0, 0.0], [5.0, 4.0, 1.0], [0.0, 2.0, -2.0]]);
    let motion = Motion::from_velocity_gradient(&l, 1e-3, 1700.0, 1.0).unwrap();
    let moving = law.update(&motion, &law.initial(&start).unwrap()).unwrap();
    assert!(moving.state.viscous.norm() > 100.0);
    assert!(law.viscosity(&moving) > 0.0);
    let still = Motion::from_velocity_gradient(&Mat3::ZERO, 1e-3, 1700.0, 1.0).unwrap();
    let stopped = law.update(&still, &moving).unwrap();
    assert_eq!(stopped.stress, moving.state.inviscid);
}

/// Parameter that the error of a material names.
fn field(spec: &HypoplasticSpec) -> String {
    match spec.build() {
        Err(MaterialError::Parameter { field, .. }) => field,
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("accepted {spec:?}"),
    }
}

fn critical(state: CriticalState) -> HypoplasticSpec {
    HypoplasticSpec { critical_state: Some(state), ..spec() }
}

#[test]
fn bad_input_is_refused_by_name() {
    let direct = |c1: f64, c4: f64| {
        let set = HypoplasticConstants { c1, c4, ..HypoplasticConstants::TABLE_1 };
        HypoplasticSpec { parameters: HypoplasticParameters::Constants(set), ..spec() }
    };
    assert_eq!(field(&direct(0.0, 1.0)), "parameters.constants.c1");
    assert_eq!(field(&direct(1.0, 1.0)), "parameters.constants.c1");
    assert_eq!(field(&direct(-1.0, f64::NAN)), "parameters.constants.c4");
    let calibrated = |of| HypoplasticSpec { parameters: HypoplasticParameters::Calibration(of), ..spec() };
    let good = calibration(30.0, 20e6);
    assert_eq!(
        field(&calibrated(Calibration { youngs_modulus: 0.0, ..good })),
        "parameters.calibration.youngs_modulus"
    );
    assert_eq!(field(&calibrated(Calibration { pressure: -1.0, ..good })), "parameters.calibration.pressure");
    assert_eq!(
        field(&calibrated(Calibration { poissons_ratio: 0.5, ..good })),
        "parameters.calibration.poissons_ratio"
    );
    assert_eq!(
        field(&calibrated(Calibration { friction_angle: 15.0, ..good })),
        "parameters.calibration.friction_angle"
    );
    assert_eq!(
        field(&calibrated(Calibration { friction_angle: 95.0, ..good })),
        "parameters.calibration.friction_angle"
    );
    assert_eq!(
        field(&calibrated(Calibration { dilatancy_angle: 60.0, ..good })),
        "parameters.calibration.dilatancy_angle"
    );
    let too_large = CriticalState { minimum_void_ratio: 1.0, ..CRITICAL };
    assert_eq!(field(&critical(too_large)), "critical_state.minimum_void_ratio");
    assert_eq!(field(&critical(CriticalState { p3: 1e-7, ..CRITICAL })), "critical_state.p3");
    assert_eq!(field(&HypoplasticSpec { void_ratio: 0.0, ..spec() }), "void_ratio");
    assert_eq!(field(&HypoplasticSpec { minimum_pressure: 0.0, ..spec() }), "minimum_pressure");
    let viscous = |viscous| HypoplasticSpec { viscous: Some(viscous), ..spec() };
    assert_eq!(field(&viscous(AccelerationViscosity { a: 1e-3, ..VISCOSITY })), "viscous.a");
    assert_eq!(field(&viscous(AccelerationViscosity { m1: 0.0, ..VISCOSITY })), "viscous.m1");
    assert_eq!(field(&viscous(AccelerationViscosity { m2: -1.0, ..VISCOSITY })), "viscous.m2");
}

#[test]
fn inadmissible_initial_stresses_are_refused() {
    let dense = critical(CriticalState { minimum_void_ratio: 0.9, ..CRITICAL });
    assert!(dense.warnings()[0].text.starts_with("void_ratio"));
    let initial = |spec: &HypoplasticSpec, stress| {
        let initial = InitialCondition { stress, density: 1700.0 };
        spec.build().unwrap().initial(&[initial]).map(|_| ()).map_err(|error| error.source)
    };
    // e_min lies below the critical void ratio without stress, but not at 1 MPa.
    let at_depth = initial(&dense, SymTensor::isotropic(-1e6));
    let named = matches!(&at_depth, Err(MaterialError::Parameter { field, .. }) if field == "critical_state.minimum_void_ratio");
    assert!(named, "{at_depth:?}");
    for stress in [SymTensor::ZERO, SymTensor::isotropic(1e3), SymTensor::isotropic(f64::NAN)] {
        assert!(matches!(initial(&spec(), stress), Err(MaterialError::Initial { .. })));
    }
}

#[test]
fn the_material_rate_gives_a_warning() {
    let steady = HypoplasticSpec {
        viscous: Some(AccelerationViscosity { mode: ViscousMode::RateMaterial, ..VISCOSITY }),
        ..spec()
    };
    assert!(steady.warnings()[0].text.starts_with("viscous.mode"));
}
