//! Cones of Drucker–Prager and von Mises.

use colluvium_constitutive::laws::drucker_prager::Cone;
use colluvium_constitutive::laws::{
    DruckerPragerSpec, ExactIn, Matching, Softening, StrainMeasure, VonMisesSpec,
};
use colluvium_constitutive::{Point, SmallStrain, SymTensor};
use colluvium_testkit::assert_close;

use super::{returned, still};
use crate::reference_materials::r1;

fn drucker_prager(matching: Matching, dilatancy_angle: f64) -> DruckerPragerSpec {
    crate::reference_materials::drucker_prager(1.0, matching, dilatancy_angle)
}

#[test]
fn cones_of_all_matchings() {
    let table = [
        (Matching::Compression, 0.230_940_11, 12.0, 0.070_943_63),
        (Matching::Extension, 0.164_957_22, 8.571_428_57, 0.063_180_17),
        (Matching::PlaneStrainAssociated, 0.160_128_15, 8.320_502_94, 0.057_594_00),
        (Matching::PlaneStrain, 0.162_790_79, 8.458_857_46, 0.057_594_00),
    ];
    for (matching, friction, strength, dilatancy) in table {
        let cone = Cone::new(matching, 30f64.to_radians(), 10.0, 10f64.to_radians());
        assert!((cone.friction - friction).abs() < 1e-8, "{matching:?}");
        assert!((cone.strength - strength).abs() < 1e-8, "{matching:?}");
        assert!((cone.dilatancy - dilatancy).abs() < 1e-8, "{matching:?}");
    }
    let isochoric = Cone::new(Matching::PlaneStrain, 30f64.to_radians(), 10.0, 0.0);
    assert_close(isochoric.friction, 0.5 / 3.0, 1e-12);
    assert_close(isochoric.strength, 8.660_254_04, 1e-9);
}

#[test]
fn drucker_prager_returns_to_cone_and_apex() {
    let law = drucker_prager(Matching::Compression, 10.0).law().unwrap();
    let new = returned(&law, [-100.0, -350.0, -120.0, 120.0, 40.0, 0.0], Default::default());
    let exact = [-131.526_843, -336.906_431, -147.957_210, 98.582_202, 32.860_734, 0.0];
    for (found, exact) in new.stress.0.into_iter().zip(exact) {
        assert!((found - exact).abs() < 1e-6, "{found} for {exact}");
    }
    assert_close(new.stress.trace(), -616.390_485, 1e-8);
    assert_close(new.stress.j2().sqrt(), 154.349_285, 1e-8);
    assert_close(new.state.deviatoric * 3f64.sqrt(), 0.004_359_375_457, 1e-12);
    let trial = SymTensor([-100.0, -350.0, -120.0, 120.0, 40.0, 0.0]);
    assert_close(trial.trace(), -570.0, 1e-15);
    assert_close(trial.j2().sqrt(), 187.882_942, 1e-8);
    let apex = returned(&law, [60.0, 50.0, 40.0, 5.0, 0.0, 0.0], Default::default());
    for c in 0..3 {
        assert_close(apex.stress[c], 17.320_508_08, 1e-9);
    }
    assert_eq!(apex.stress.0[3..], [0.0; 3]);
}

#[test]
fn drucker_prager_softens_implicitly() {
    // §2.3, Bui & Nguyen softening, kPa.
    let softening = Softening {
        residual_friction_angle: 15.0,
        residual_cohesion: 0.10,
        friction_rate: 3.0,
        cohesion_rate: 3.0,
        hardening: false,
    };
    let law = DruckerPragerSpec {
        youngs_modulus: 5000.0,
        friction_angle: 31.2,
        cohesion: 0.55,
        softening: Some(softening),
        ..drucker_prager(Matching::Compression, 0.0)
    }
    .law()
    .unwrap();
    let trial = SymTensor([-2.0, -7.0, -2.5, 1.5, 0.0, 0.0]);
    let cone = law.cone_at(0.1);
    assert_close(cone.yield_value(trial.j2().sqrt(), trial.trace()), 0.242_473_830, 1e-8);
    let new = returned(&law, trial.0, colluvium_constitutive::laws::PlasticStrain { deviatoric: 0.1 });
    assert_close(new.state.deviatoric, 0.100_072_896_69, 1e-10);
    assert_close(new.stress.j2().sqrt(), 2.893_005_452, 1e-9);
    for (c, exact) in [(0, -2.141_956_78), (1, -6.754_801_93), (2, -2.603_241_29), (3, 1.383_853_54)] {
        assert!((new.stress[c] - exact).abs() < 2e-8, "{} for {exact}", new.stress[c]);
    }
}

#[test]
fn softened_strength_follows_table_2() {
    let softening = Softening::of_cohesion(1.5, 5.0);
    let spec = DruckerPragerSpec {
        friction_angle: 0.0,
        cohesion: 25.0,
        softening: Some(softening),
        ..drucker_prager(Matching::PlaneStrain, 0.0)
    };
    let law = spec.law().unwrap();
    for (kappa, cohesion) in [(0.1, 15.753_470), (0.5, 3.428_997), (1.0, 1.658_342), (2.0, 1.501_067)] {
        assert!((law.cone_at(kappa).strength - cohesion).abs() < 1e-6);
    }
}

#[test]
fn tangent_of_the_drucker_prager_cone() {
    // §3.10: θ and H of the reference cone step, from the tangent.
    let law = drucker_prager(Matching::Compression, 10.0).law().unwrap();
    let trial = SymTensor([-100.0, -350.0, -120.0, 120.0, 40.0, 0.0]);
    let old = Point { stress: trial, state: Default::default() };
    let tangent = SmallStrain::tangent(&law, &SymTensor::ZERO, &still(), &old).unwrap();
    let (k, g) = (r1().bulk_modulus, r1().shear_modulus);
    let n = trial.deviator() * (1.0 / trial.deviator().norm());
    // A deviator normal to n keeps 2 G θ of itself.
    let other = SymTensor([1.0, 1.0, -2.0, 0.0, 0.0, 3.0]);
    let across = other - n * n.dot(&other);
    assert_close(
        tangent.apply(&across).dot(&across) / across.dot(&across) / (2.0 * g),
        0.821_518_351_0,
        1e-10,
    );
    // A volume change v changes the mean stress by K (1 - 9 K α α_ψ / H) v.
    let cone = Cone::new(Matching::Compression, 30f64.to_radians(), 10.0, 10f64.to_radians());
    let (alpha, psi) = (cone.friction, cone.dilatancy);
    let mean = tangent.apply(&SymTensor::IDENTITY).trace() / 9.0;
    assert_close(9.0 * k * alpha * psi / (1.0 - mean / k), 10_149.866_957_15, 1e-8);
}

#[test]
fn von_mises_is_matched_to_shear_or_to_compression() {
    let spec = |exact_in| VonMisesSpec {
        density: 2.0,
        youngs_modulus: 20_000.0,
        poissons_ratio: 0.3,
        cohesion: 25.0,
        exact_in,
        residual_cohesion: None,
        softening_rate: 0.0,
        strain_measure: StrainMeasure::Rate,
        return_initial_stress_to_yield: false,
    };
    let root_j2 = |exact_in| {
        let law = spec(exact_in).law().unwrap();
        returned(&law, [0.0, 0.0, 0.0, 300.0, 0.0, 0.0], Default::default()).stress.j2().sqrt()
    };
    assert_close(root_j2(ExactIn::PlaneStrain), 25.0, 1e-12);
    assert_close(root_j2(ExactIn::Triaxial), 28.867_513_459, 1e-9);
}

#[test]
fn parameters_out_of_range_are_named() {
    let field = |spec: DruckerPragerSpec| spec.law().unwrap_err().to_string();
    let base = || drucker_prager(Matching::Compression, 0.0);
    assert!(field(DruckerPragerSpec { friction_angle: 95.0, ..base() }).starts_with("friction_angle: 95"));
    assert!(field(DruckerPragerSpec { poissons_ratio: 0.5, ..base() }).starts_with("poissons_ratio: 0.5"));
    assert!(field(DruckerPragerSpec { cohesion: -1.0, ..base() }).starts_with("cohesion: -1"));
    assert!(field(DruckerPragerSpec { dilatancy_angle: 40.0, ..base() }).starts_with("dilatancy_angle: 40"));
    let steep = DruckerPragerSpec { dilatancy_angle: -30.0, poissons_ratio: 0.45, ..base() };
    assert!(field(steep).starts_with("dilatancy_angle: -30"));
    assert!(
        field(DruckerPragerSpec { youngs_modulus: f64::NAN, ..base() }).starts_with("youngs_modulus: NaN")
    );
}
