//! Return mappings of Drucker–Prager, Mohr–Coulomb and Tresca (sheet: constitutive V-05, V-08; §3.7.1–3.7.4), in kPa.

use colluvium::constitutive::laws::drucker_prager::Cone;
use colluvium::constitutive::laws::mohr_coulomb::{Pyramid, YieldRegion};
use colluvium::constitutive::laws::multi_surface::{YieldPlane, active_set, return_to};
use colluvium::constitutive::laws::{DruckerPrager, DruckerPragerSpec, Elasticity, MohrCoulombSpec};
use colluvium::constitutive::{Mat3, Motion, Point, SmallStrain, SymTensor};
use serde_json::json;

use crate::analysis::{MaxOrNan, max_or_nan};
use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of return mappings to cone, pyramid and prism.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "constitutive/returns",
    title: "Return mappings to cone, pyramid and prism",
    source: "sheet: constitutive V-05, V-08, tables of §3.7.1–3.7.4",
    short_seconds: Some(1),
    full_seconds: 1,
    run: benchmark,
};

/// Reason of the tolerance of values printed in the sheet.
const DIGITS: &str = "the digits the sheet gives";
/// Number of trial stresses of each random test.
const TRIALS: usize = 10_000;
/// Reference pressure of the sheet's tolerances (kPa).
const REFERENCE: f64 = 100.0;

/// Checks return mappings to cone, pyramid and prism.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    cone_returns(&mut outcome)?;
    random_cone(&mut outcome)?;
    pyramid_returns(&mut outcome)?;
    cut_off_returns(&mut outcome)?;
    prism_returns(&mut outcome)?;
    random_pyramid(&mut outcome)?;
    Ok(outcome)
}

/// Elasticity of the parameter set R1 (kPa).
fn r1() -> Result<Elasticity, String> {
    Elasticity::new(20_000.0, 0.3).map_err(|error| error.to_string())
}

/// Sequence of random numbers in 0..1, equal in every run.
pub(super) struct RandomSequence(pub u64);

impl RandomSequence {
    /// Next number, uniform in 0..1.
    pub fn next_number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Drucker–Prager law of the tests with a dilatancy angle (degrees).
fn cone_law(dilatancy: f64) -> Result<DruckerPrager, String> {
    let spec: DruckerPragerSpec = serde_json::from_value(json!({
        "density": 2.0, "youngs_modulus": 20e3, "poissons_ratio": 0.3, "friction_angle": 30.0, "cohesion": 10.0,
        "dilatancy_angle": dilatancy, "matching": "compression"
    }))
    .map_err(|error| error.to_string())?;
    spec.law().map_err(|error| error.to_string())
}

/// Stress and plastic strain `κ` after the return of a trial stress.
fn returned_stress(law: &DruckerPrager, trial: SymTensor) -> Result<(SymTensor, f64), String> {
    let still = Motion::from_deformation(&Mat3::IDENTITY, 1.0, 2.0, 1.0).ok_or("singular motion")?;
    let old = Point { stress: trial, state: Default::default() };
    let new = law.update(&SymTensor::ZERO, &still, &old).map_err(|error| error.to_string())?;
    Ok((new.stress, new.state.deviatoric))
}

/// Checks returns to the flank and to the apex of the cone.
fn cone_returns(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let law = cone_law(10.0)?;
    let (stress, kappa) = returned_stress(&law, SymTensor([-100.0, -350.0, -120.0, 120.0, 40.0, 0.0]))?;
    let table = [
        ("σ_xx", 0, -131.526_843),
        ("σ_yy", 1, -336.906_431),
        ("σ_zz", 2, -147.957_210),
        ("σ_xy", 3, 98.582_202),
        ("σ_yz", 4, 32.860_734),
    ];
    for (name, component, exact) in table {
        outcome.assert_close(format!("V-05 cone: {name} (kPa)"), exact, 2e-8, stress[component], DIGITS);
    }
    outcome.assert_close("V-05 cone: Δλ", 0.004_359_375_457, 1e-9, kappa * 3f64.sqrt(), DIGITS);
    let (apex, _) = returned_stress(&law, SymTensor([60.0, 50.0, 40.0, 5.0, 0.0, 0.0]))?;
    for c in 0..3 {
        outcome.assert_close(format!("V-05 apex: σ_{} (kPa)", c + 1), 17.320_508_08, 1e-9, apex[c], DIGITS);
    }
    outcome.assert_close("V-05 apex: shear stress (kPa)", 0.0, 0.0, apex[3].abs(), "exactly none");
    Ok(())
}

/// Violation of the Karush–Kuhn–Tucker conditions by an associated return, relative to the plastic strain.
fn optimality(cone: &Cone, elasticity: &Elasticity, trial: &SymTensor, stress: &SymTensor) -> f64 {
    let plastic = elasticity.strain(&(*trial - *stress));
    let deviator = plastic.deviator();
    let root = stress.j2().sqrt();
    let size = plastic.norm();
    if root > 0.0 {
        let multiplier = 2f64.sqrt() * deviator.norm();
        let flow = stress.deviator() * (0.5 / root) + SymTensor::isotropic(cone.friction);
        return (plastic - flow * multiplier).norm() / size;
    }
    let multiplier = plastic.trace() / (3.0 * cone.friction);
    (deviator.norm() - multiplier / 2f64.sqrt()).max(0.0) / size
}

/// Checks optimality and yield condition of random returns to the cone.
fn random_cone(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let elasticity = r1()?;
    for dilatancy in [0.0, 10.0, 30.0] {
        let law = cone_law(dilatancy)?;
        let cone = law.cone_at(0.0);
        let mut random = RandomSequence(7);
        let (mut excess, mut optimal, mut plastic, mut apex) = (f64::NEG_INFINITY, 0f64, 0, 0);
        for _ in 0..TRIALS {
            let trial = SymTensor(std::array::from_fn(|c| {
                if c < 3 {
                    600.0 * random.next_number() - 450.0
                } else {
                    240.0 * random.next_number() - 120.0
                }
            }));
            let (stress, _) = returned_stress(&law, trial)?;
            excess = max_or_nan(excess, cone.yield_value(stress.j2().sqrt(), stress.trace()));
            if stress != trial {
                plastic += 1;
                apex += usize::from(stress.j2() == 0.0);
                optimal = max_or_nan(optimal, optimality(&cone, &elasticity, &trial, &stress));
            }
        }
        let name = format!("V-05 {TRIALS} trials, ψ = {dilatancy}° ({plastic} plastic, {apex} to the apex)");
        outcome.assert_below(
            format!("{name}: largest f (kPa)"),
            "at most 1e-10 p_ref",
            excess,
            1e-10 * REFERENCE,
            "the sheet's 10⁻¹⁰ of p_ref = 100 kPa",
        );
        if dilatancy == 30.0 {
            outcome.assert_below(
                format!("{name}: largest KKT residual"),
                "0",
                optimal,
                1e-9,
                "machine precision as the sheet has it, 10⁻⁹: plastic strain in the normal cone",
            );
        }
    }
    Ok(())
}

/// Trial stress, the region to which it returns, and the returned stresses for ψ = 0, 10°, 30° with tolerances.
type ReturnRow = ([f64; 3], YieldRegion, [([f64; 3], f64); 3]);

/// Returns to plane, edges and apex of the pyramid: trial stress, region, returned stresses (kPa).
const PYRAMID_RETURNS: [ReturnRow; 4] = [
    (
        [-50.0, -120.0, -400.0],
        YieldRegion::Plane,
        [
            ([-103.8397, -120.0, -346.1603], 6e-5),
            ([-113.441_955_45, -131.522_651_39, -374.966_882_51], 6e-9),
            ([-124.5473, -144.8491, -408.2830], 6e-5),
        ],
    ),
    (
        [-40.0, -45.0, -400.0],
        YieldRegion::CompressionEdge,
        [
            ([-90.0718, -90.0718, -304.8564], 6e-5),
            ([-107.349_438_5, -107.349_438_5, -356.689_331_64], 6e-9),
            ([-126.4502, -126.4502, -413.9917], 6e-5),
        ],
    ),
    (
        [-20.0, -300.0, -310.0],
        YieldRegion::ExtensionEdge,
        [
            ([-80.1026, -274.9487, -274.9487], 6e-5),
            ([-87.716_210_85, -297.789_648_71, -297.789_648_71], 6e-9),
            ([-95.7292, -321.8287, -321.8287], 6e-5),
        ],
    ),
    ([60.0, 50.0, 40.0], YieldRegion::Apex, [([17.320_508_08; 3], 6e-9); 3]),
];

/// Checks returns to planes, edges and apex of the pyramid.
fn pyramid_returns(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let elasticity = r1()?;
    let mut check = |trial: [f64; 3], psi: f64, region: YieldRegion, exact: [f64; 3], digits: f64| {
        let pyramid = Pyramid::new(30f64.to_radians(), 10.0, psi.to_radians());
        let (stress, found) = pyramid.return_map(&elasticity, trial);
        let mut worst = (0..3).map(|c| (stress[c] - exact[c]).abs()).max_or_nan();
        if found != region {
            worst = f64::NAN;
        }
        let name = format!("V-08 {trial:?} kPa, ψ = {psi}°, to {region:?}: largest error (kPa)");
        outcome.assert_below(name, "0", worst, digits, DIGITS);
    };
    for (trial, region, values) in PYRAMID_RETURNS {
        for (psi, (exact, digits)) in [0.0, 10.0, 30.0].into_iter().zip(values) {
            check(trial, psi, region, exact, digits);
        }
    }
    let near_apex = [16.188_396_02, 13.924_171_92, 13.924_171_92];
    check([100.0, 20.0, -10.0], 10.0, YieldRegion::ExtensionEdge, near_apex, 6e-9);
    full_tensor_return(outcome)
}

/// Checks the return of a stress whose principal directions are not along the axes.
fn full_tensor_return(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let spec: MohrCoulombSpec = serde_json::from_value(json!({
        "density": 2.0, "youngs_modulus": 20e3, "poissons_ratio": 0.3, "friction_angle": 30.0, "cohesion": 10.0,
        "dilatancy_angle": 10.0
    }))
    .map_err(|error| error.to_string())?;
    let law = spec.law().map_err(|error| error.to_string())?;
    let still = Motion::from_deformation(&Mat3::IDENTITY, 1.0, 2.0, 1.0).ok_or("singular motion")?;
    let trial = SymTensor([-100.0, -350.0, -120.0, 120.0, 40.0, 0.0]);
    let old = Point { stress: trial, state: Default::default() };
    let new = law.update(&SymTensor::ZERO, &still, &old).map_err(|error| error.to_string())?.stress;
    let exact = SymTensor([-150.214_594, -337.741_476, -133.800_010, 88.636_360, 30.979_353, -8.603_396]);
    let worst = (0..6).map(|c| (new[c] - exact[c]).abs()).max_or_nan();
    outcome.assert_below("V-08 full tensor, ψ = 10°: largest error (kPa)", "0", worst, 6e-7, DIGITS);
    Ok(())
}

/// Checks returns of trial stresses to the Mohr–Coulomb pyramid with a tension cut-off.
fn cut_off_returns(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let table = [
        (2.0, [20.0, -15.0, -20.0], [2.0, -22.714_286, -27.714_286]),
        (2.0, [25.0, -5.0, -20.0], [2.0, -14.492_305, -28.641_016]),
        (2.0, [12.0, 10.0, -10.0], [2.0, 2.0, -15.4]),
        (2.0, [60.0, -30.0, -60.0], [-1.278_054, -38.475_177, -38.475_177]),
        (0.0, [30.0, 20.0, 10.0], [0.0, 0.0, -5.0]),
    ];
    let elasticity = r1()?;
    for (cut_off, trial, exact) in table {
        let pyramid = Pyramid::new(30f64.to_radians(), 10.0, 10f64.to_radians()).with_cut_off(Some(cut_off));
        let (stress, _) = pyramid.return_map(&elasticity, trial);
        let worst = (0..3).map(|c| (stress[c] - exact[c]).abs()).max_or_nan();
        let name = format!("V-08 cut-off at {cut_off} kPa, {trial:?} kPa: largest error (kPa)");
        outcome.assert_below(name, "0", worst, 6e-7, DIGITS);
    }
    Ok(())
}

/// Checks returns to Tresca's prism.
fn prism_returns(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let third = 1.0 / 3.0;
    let table = [
        ([30.0, -20.0, -60.0], [5.0, -20.0, -35.0]),
        ([50.0, 45.0, -100.0], [35.0 * third, 35.0 * third, -85.0 * third]),
        ([50.0, -90.0, -100.0], [-20.0, -60.0, -60.0]),
    ];
    let (elasticity, prism) = (r1()?, Pyramid::new(0.0, 20.0, 0.0));
    for (trial, exact) in table {
        let (stress, _) = prism.return_map(&elasticity, trial);
        let worst = (0..3).map(|c| (stress[c] - exact[c]).abs()).max_or_nan();
        let name = format!("V-08 Tresca, {trial:?} kPa: largest error (kPa)");
        outcome.assert_below(name, "0", worst, 1e-12 * REFERENCE, "closed form");
    }
    Ok(())
}

/// All six planes of a pyramid, since those of the reversed order of stresses are active too at the apex.
fn check_six_planes(pyramid: &Pyramid) -> [YieldPlane; 6] {
    let pairs = [[0, 2], [0, 1], [1, 2], [1, 0], [2, 1], [2, 0]];
    pairs.map(|[i, j]| {
        let along = |x: f64| {
            let mut direction = [0.0; 3];
            (direction[i], direction[j]) = (x, -1.0);
            direction
        };
        YieldPlane {
            normal: along(pyramid.friction),
            offset: pyramid.strength,
            flow: along(pyramid.dilatancy),
        }
    })
}

/// Checks optimality and yield condition of random returns to the pyramid.
fn random_pyramid(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let elasticity = r1()?;
    let regions =
        [YieldRegion::Plane, YieldRegion::CompressionEdge, YieldRegion::ExtensionEdge, YieldRegion::Apex];
    for (what, friction, cohesion, psi) in [
        ("ψ = 10°", 30f64, 10.0, 10f64),
        ("ψ = 0", 30.0, 10.0, 0.0),
        ("ψ = φ", 30.0, 10.0, 30.0),
        ("Tresca", 0.0, 20.0, 0.0),
    ] {
        let pyramid = Pyramid::new(friction.to_radians(), cohesion, psi.to_radians());
        let planes = check_six_planes(&pyramid);
        let mut random = RandomSequence(7);
        let mut worst = [(0f64, 0usize); 4];
        for _ in 0..TRIALS {
            let mut trial: [f64; 3] = std::array::from_fn(|_| 600.0 * random.next_number() - 500.0);
            trial.sort_by(|a, b| b.total_cmp(a));
            let (stress, region) = pyramid.return_map(&elasticity, trial);
            let Some(at) = regions.iter().position(|r| *r == region) else { continue };
            // Isochoric flow reaches no apex: the general return has no set there (sheet: constitutive §3.7.3).
            if region == YieldRegion::Apex && psi == 0.0 {
                continue;
            }
            let set = active_set(&planes, &elasticity, trial).ok_or(format!("no set carries {trial:?}"))?;
            let other = return_to(&planes, set, &elasticity, trial);
            let difference = (0..3).map(|c| (stress[c] - other[c]).abs()).max_or_nan();
            worst[at] = (max_or_nan(worst[at].0, difference), worst[at].1 + 1);
        }
        for (region, (difference, count)) in regions.iter().zip(worst).filter(|(_, (_, n))| *n > 0) {
            let name =
                format!("V-08 {what}, {count} of {TRIALS} trials to {region:?}: largest difference (kPa)");
            let reason = "the sheet's 10⁻⁹ of 100 kPa, against the general return of §3.7.3";
            outcome.assert_below(name, "0", difference, 1e-9 * REFERENCE, reason);
        }
    }
    Ok(())
}
