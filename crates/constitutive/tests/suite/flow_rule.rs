//! Strain split, flow rule, consistency and stiffness of plasticity, tested on the cone (sheet: constitutive §2.3, §2.4).

use colluvium_constitutive::driver::{ElementPath, ElementTest, LoadingPath, TestStage};
use colluvium_constitutive::laws::{
    DruckerPrager, DruckerPragerSpec, Elasticity, Matching, PlasticIntegration, PlasticStrain, Softening,
    StrainMeasure, drucker_prager::Cone,
};
use colluvium_constitutive::{Mat3, MaterialSpec, Motion, Point, SmallStrain, SymTensor};
use colluvium_testkit::{assert_close, assert_near};

/// Soil of 20 MPa, in kPa.
fn spec(matching: Matching) -> DruckerPragerSpec {
    DruckerPragerSpec {
        density: 2.0,
        youngs_modulus: 20_000.0,
        poissons_ratio: 0.3,
        friction_angle: 30.0,
        cohesion: 10.0,
        dilatancy_angle: 10.0,
        matching,
        softening: None,
        dilatancy_decay: 0.0,
        integration: PlasticIntegration::ClosestPoint,
        strain_measure: StrainMeasure::Rate,
        return_initial_stress_to_yield: false,
    }
}

const MATCHINGS: [Matching; 4] =
    [Matching::Compression, Matching::Extension, Matching::PlaneStrain, Matching::PlaneStrainAssociated];

const SOFTENING: Softening = Softening {
    residual_friction_angle: 20.0,
    residual_cohesion: 2.0,
    friction_rate: 10.0,
    cohesion_rate: 20.0,
    hardening: false,
};

fn elasticity() -> Elasticity {
    Elasticity::new(20_000.0, 0.3).unwrap()
}

/// Elastic strain `C : σ` of linear elasticity.
fn strain_of(stress: &SymTensor) -> SymTensor {
    let e = elasticity();
    stress.deviator() * (0.5 / e.shear_modulus)
        + SymTensor::isotropic(stress.trace() / (9.0 * e.bulk_modulus))
}

/// Pseudo-random numbers between -1 and 1.
fn numbers() -> impl FnMut() -> f64 {
    let mut seed = 5u64;
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        2.0 * (seed >> 11) as f64 / (1u64 << 53) as f64 - 1.0
    }
}

fn excess(cone: &Cone, stress: &SymTensor) -> f64 {
    cone.yield_value(stress.j2().sqrt(), stress.trace())
}

/// Slope of the yield function or, with the coefficient of dilatancy, of the potential.
fn slope(coefficient: f64, stress: &SymTensor) -> SymTensor {
    stress.deviator() * (0.5 / stress.j2().sqrt()) + SymTensor::isotropic(coefficient)
}

fn still() -> Motion {
    Motion::from_deformation(&Mat3::IDENTITY, 1.0, 2.0, 1.0).unwrap()
}

/// Conditions `Δε = Δε^e + Δλ ∂g/∂σ`, `Δσ = D : Δε^e`, `Δκ = h Δλ` with `h = 1/√3`, and `Δλ ≥ 0`, `f ≤ 0`, `Δλ f = 0`.
#[test]
fn strain_splits_and_flows_along_the_potential_where_the_surface_is_reached() {
    let mut number = numbers();
    for matching in MATCHINGS {
        for softening in [None, Some(SOFTENING)] {
            let law = DruckerPragerSpec { softening, ..spec(matching) }.law().unwrap();
            let (mut elastic, mut plastic) = (0, 0);
            for _ in 0..400 {
                let stress = SymTensor::isotropic(-100.0 * (1.5 + number()));
                let strain = SymTensor(std::array::from_fn(|_| 8e-3 * number()));
                let old = Point { stress, state: PlasticStrain { deviatoric: 0.02 * (1.0 + number()) } };
                let new = SmallStrain::update(&law, &strain, &still(), &old).unwrap();
                let multiplier = 3f64.sqrt() * (new.state.deviatoric - old.state.deviatoric);
                let cone = law.cone_at(new.state.deviatoric);
                let flown = strain - strain_of(&(new.stress - stress));
                if new.stress.j2().sqrt() < 1e-9 * new.stress.norm() {
                    // Apex, where the surface has no slope.
                    continue;
                }
                if multiplier == 0.0 {
                    elastic += 1;
                    assert!(flown.norm() < 1e-12 && excess(&cone, &new.stress) <= 1e-10);
                } else {
                    plastic += 1;
                    let exact = slope(cone.dilatancy, &new.stress) * multiplier;
                    assert!((flown - exact).norm() < 1e-11, "{matching:?}: {flown:?} for {exact:?}");
                    assert!(multiplier > 0.0 && excess(&cone, &new.stress).abs() < 1e-9);
                }
            }
            assert!(elastic > 20 && plastic > 80, "{matching:?}: {elastic}, {plastic}");
        }
    }
}

/// Softened soil on its surface at the plastic strain `KAPPA`.
fn on_the_surface() -> (DruckerPrager, SymTensor) {
    let law = DruckerPragerSpec {
        softening: Some(SOFTENING),
        integration: PlasticIntegration::Explicit,
        ..spec(Matching::Compression)
    }
    .law()
    .unwrap();
    let shear = SymTensor([-60.0, -260.0, -110.0, 40.0, 20.0, -10.0]);
    let (deviator, mean) = (shear.deviator(), shear.trace() / 3.0);
    let cone = law.cone_at(KAPPA);
    let strength = cone.strength - cone.friction * shear.trace();
    (law, deviator * (strength / deviator.j2().sqrt()) + SymTensor::isotropic(mean))
}

const KAPPA: f64 = 0.03;

/// Eq. (2.4): the forward step uses `D^ep = D - (D : ∂g)(∂f : D) / (∂f : D : ∂g - ∂_κ f h)` of the softening cone, and remains
/// on the surface to the first order of the step.
#[test]
fn the_forward_step_uses_the_continuum_stiffness_and_is_consistent() {
    let (law, stress) = on_the_surface();
    let elastic = elasticity();
    let cone = law.cone_at(KAPPA);
    assert_near(excess(&cone, &stress), 0.0, 1e-10);
    let step = 1e-5;
    let hardening = (excess(&law.cone_at(KAPPA + step), &stress)
        - excess(&law.cone_at(KAPPA - step), &stress))
        / (2.0 * step)
        / 3f64.sqrt();
    assert!(hardening > 0.0, "it softens");
    let (f, g) = (slope(cone.friction, &stress), slope(cone.dilatancy, &stress));
    let (elastic_normal, flow) = (elastic.stress(&f), elastic.stress(&g));
    let below = f.dot(&flow) - hardening;
    let strain = SymTensor([1e-4, -3e-4, 5e-5, 8e-5, -2e-5, 4e-5]);
    let drift = |share: f64| {
        let strain = strain * share;
        let (new, multiplier) = law.explicit_step(&stress, &strain, KAPPA);
        assert_close(multiplier, elastic_normal.dot(&strain) / below, 1e-7);
        let exact = stress + elastic.stress(&strain) - flow * (elastic_normal.dot(&strain) / below);
        assert!((new - exact).norm() < 1e-7 * (exact - stress).norm(), "{new:?} for {exact:?}");
        excess(&law.cone_at(KAPPA + multiplier / 3f64.sqrt()), &new)
    };
    let (whole, half) = (drift(1.0), drift(0.5));
    assert!((whole / half / 4.0 - 1.0).abs() < 0.02, "{whole}, {half}");
}

#[test]
fn softening_to_a_share_is_softening_to_a_residual_cohesion() {
    // c₀ (1 - a (1 - e^(-bκ))), AL1 59, has the residual cohesion c₀ (1 - a) and the rate b.
    let (start, share, rate) = (25.0, 0.94, 5.0);
    let law = DruckerPragerSpec {
        friction_angle: 0.0,
        dilatancy_angle: 0.0,
        cohesion: start,
        softening: Some(Softening::of_cohesion(start * (1.0 - share), rate)),
        ..spec(Matching::PlaneStrain)
    }
    .law()
    .unwrap();
    for kappa in [0.0, 0.01, 0.2, 1.5] {
        let exact = start - start * share * (1.0 - f64::exp(-rate * kappa));
        assert_close(law.cone_at(kappa).strength, exact, 1e-13);
    }
}

fn triaxial(material: DruckerPragerSpec, steps: usize) -> ElementPath {
    let stages = vec![TestStage {
        path: LoadingPath::TriaxialDrained { axial_compression: 0.15 },
        steps,
        duration: 1.0,
    }];
    let test = ElementTest {
        title: String::new(),
        material: MaterialSpec::DruckerPrager(material),
        initial_stress: [-100.0, -100.0, -100.0, 0.0, 0.0, 0.0],
        stages,
    };
    test.run().unwrap()
}

/// Decay `ψ = ψ₀ e^(-sκ)`: at constant stress the volume grows by `3√3 α_ψ(ψ) dκ`, so that dilation ends.
#[test]
fn dilation_decays_with_the_deviatoric_plastic_strain() {
    let (angle, decay) = (12f64.to_radians(), 40.0);
    let material =
        DruckerPragerSpec { dilatancy_angle: 12.0, dilatancy_decay: decay, ..spec(Matching::Compression) };
    let law = material.law().unwrap();
    for kappa in [0.0, 0.01, 0.1] {
        let cone =
            Cone::new(Matching::Compression, 30f64.to_radians(), 10.0, angle * f64::exp(-decay * kappa));
        assert_close(law.cone_at(kappa).dilatancy, cone.dilatancy, 1e-13);
    }
    let path = triaxial(material, 3000);
    let kappa = path.column("plastic_strain").unwrap();
    let [xx, yy, zz] = ["strain_xx", "strain_yy", "strain_zz"].map(|name| path.column(name).unwrap());
    let volume = |row: usize| xx[row] + yy[row] + zz[row];
    let first = kappa.iter().position(|k| *k > 1e-4).unwrap();
    let last = kappa.len() - 1;
    assert!(kappa[last] > 0.1);
    let grown = |k: f64| {
        let psi = angle * (-decay * k).exp();
        3.0 * 3f64.sqrt() * 2.0 * psi.sin() / (3f64.sqrt() * (3.0 - psi.sin()))
    };
    // Simpson's rule.
    let parts = 2000;
    let width = (kappa[last] - kappa[first]) / f64::from(parts);
    let at = |i: u32| grown(kappa[first] + width * f64::from(i));
    let sum: f64 = (0..parts / 2).map(|i| at(2 * i) + 4.0 * at(2 * i + 1) + at(2 * i + 2)).sum();
    let exact = sum * width / 3.0;
    let found = volume(last) - volume(first);
    // The return uses the dilatancy at the end of each step.
    assert!((found / exact - 1.0).abs() < 2e-3, "{found} for {exact}");
    let middle = kappa.iter().position(|k| *k > 0.5 * kappa[last]).unwrap();
    assert!(volume(last) - volume(middle) < 0.2 * found, "it goes on dilating");
}
