//! Algorithms 1 and 2 of Bui & Nguyen 2021 for Drucker–Prager (sheet: constitutive §2.3, §3.6; kPa).

use colluvium_constitutive::laws::{
    DruckerPrager, DruckerPragerSpec, Elasticity, Matching, PlasticIntegration, PlasticStrain, Softening,
    StrainMeasure,
};
use colluvium_constitutive::{
    Corotational, InitialCondition, Mat3, Motion, Point, PointLaw, SmallStrain, StressUpdate, SymTensor,
};
use colluvium_testkit::assert_close;
use proptest::prelude::*;

use crate::reference_materials::r1;

fn spec(integration: PlasticIntegration) -> DruckerPragerSpec {
    DruckerPragerSpec {
        density: 2.0,
        youngs_modulus: 20_000.0,
        poissons_ratio: 0.3,
        friction_angle: 30.0,
        cohesion: 10.0,
        dilatancy_angle: 10.0,
        matching: Matching::Compression,
        softening: None,
        dilatancy_decay: 0.0,
        integration,
        strain_measure: StrainMeasure::Rate,
        return_initial_stress_to_yield: false,
    }
}

/// Return of a trial stress: a step without strain from it.
fn returned(law: &DruckerPrager, trial: [f64; 6], state: PlasticStrain) -> Point<PlasticStrain> {
    let still = Motion::from_deformation(&Mat3::IDENTITY, 1.0, 2.0, 1.0).unwrap();
    law.update(&SymTensor::ZERO, &still, &Point { stress: SymTensor(trial), state }).unwrap()
}

#[test]
fn both_algorithms_of_the_source_have_the_step_of_the_sheet() {
    // §3.6: from the cone result of §3.7.1.
    let law = spec(PlasticIntegration::ClosestPoint).law().unwrap();
    let start = returned(&law, [-100.0, -350.0, -120.0, 120.0, 40.0, 0.0], Default::default()).stress;
    let strain = SymTensor([1e-4, -2e-4, 0.0, 5e-5, 0.0, 0.0]);
    let kappa = 0.0;
    let near = |found: SymTensor, exact: [f64; 5]| {
        for (found, exact) in found.0.into_iter().zip(exact) {
            assert!((found - exact).abs() < 1.5e-6, "{found} for {exact}");
        }
    };
    let (explicit, multiplier) = law.explicit_step(&start, &strain, kappa);
    near(explicit, [-131.865_595, -340.836_775, -149.752_520, 98.860_012, 32.696_927]);
    assert_close(multiplier * 1e4, 1.000_236_43, 1e-8);
    let drift = law.cone_at(0.0).yield_value(explicit.j2().sqrt(), explicit.trace());
    assert!((drift - 4.513e-3).abs() < 1e-6, "{drift}");
    let (semi_implicit, multiplier) = law.semi_implicit_step(&(start + r1().stress(&strain)), kappa);
    near(semi_implicit, [-131.873_780, -340.831_929, -149.753_890, 98.860_898, 32.698_488]);
    assert_close(multiplier * 1e4, 1.004_660_92, 1e-8);
    // Drift is corrected to the cone at the same pressure.
    let mended = law.without_drift(explicit, 0.0);
    assert!(law.cone_at(0.0).yield_value(mended.j2().sqrt(), mended.trace()).abs() < 1e-10);
    assert_close(mended.trace(), explicit.trace(), 1e-14);
    // Tension cracking ends at the apex.
    assert_close(law.without_drift(SymTensor::isotropic(40.0), 0.0)[0], 17.320_508_08, 1e-9);
}

#[test]
fn one_corrector_with_the_right_sign_of_hardening_lands_on_the_softened_cone() {
    // §2.3: Bui & Nguyen's softening without dilatancy, from κ = 0.1.
    let softening = Softening {
        residual_friction_angle: 15.0,
        residual_cohesion: 0.10,
        friction_rate: 3.0,
        cohesion_rate: 3.0,
        hardening: false,
    };
    let soft = |integration| DruckerPragerSpec {
        youngs_modulus: 5000.0,
        friction_angle: 31.2,
        cohesion: 0.55,
        dilatancy_angle: 0.0,
        softening: Some(softening),
        ..spec(integration)
    };
    let law = soft(PlasticIntegration::SemiImplicit).law().unwrap();
    let trial = SymTensor([-2.0, -7.0, -2.5, 1.5, 0.0, 0.0]);
    let excess =
        |stress: &SymTensor, kappa: f64| law.cone_at(kappa).yield_value(stress.j2().sqrt(), stress.trace());
    let (kappa, step) = (0.1, 1e-5);
    let hardening = (excess(&trial, kappa + step) - excess(&trial, kappa - step)) / (2.0 * step);
    assert_close(hardening, 4.600_673_880, 1e-8);
    let (stress, multiplier) = law.semi_implicit_step(&trial, kappa);
    assert_close(multiplier * 1e4, 1.262_607_9, 1e-7);
    let residual = excess(&stress, kappa + multiplier / 3f64.sqrt());
    assert!((residual + 3.6e-8).abs() < 0.1e-8, "{residual}");
    // The printed sign of the hardening term leaves the stress outside.
    let shear = Elasticity::new(5000.0, 0.3).unwrap().shear_modulus;
    let printed = excess(&trial, kappa) / (shear + hardening / 3f64.sqrt());
    let stress = trial - trial.deviator() * (shear * printed / trial.j2().sqrt());
    let residual = excess(&stress, kappa + printed / 3f64.sqrt());
    assert!((residual - 6.7e-4).abs() < 0.05e-4, "{residual}");
    // Fully implicit.
    let law = soft(PlasticIntegration::ClosestPoint).law().unwrap();
    let new = returned(&law, trial.0, PlasticStrain { deviatoric: kappa });
    assert_close((new.state.deviatoric - kappa) * 3f64.sqrt() * 1e4, 1.262_607_67, 1e-8);
}

#[test]
fn explicit_steps_converge_to_the_return() {
    let end = |integration: PlasticIntegration, steps: usize| {
        let law = Corotational(spec(integration).law().unwrap());
        let a = Mat3([[0.01, 0.004, 0.0], [0.0, -0.02, 0.002], [0.0, 0.0, 0.004]]) * (1.0 / steps as f64);
        let motion = Motion::from_velocity_gradient(&a, 1.0, 2.0, 1.0).unwrap();
        let start = Point { stress: SymTensor::isotropic(-100.0), state: Default::default() };
        (0..steps).fold(start, |p, _| StressUpdate::update(&law, &motion, &p).unwrap()).stress
    };
    let exact = end(PlasticIntegration::ClosestPoint, 4000);
    let error = |steps: usize| (end(PlasticIntegration::Explicit, steps) - exact).norm() / exact.norm();
    let (coarse, fine) = (error(100), error(400));
    assert!(fine < 0.3 * coarse && fine < 1e-3, "{coarse} to {fine}");
}

fn law(integration: PlasticIntegration) -> Corotational<DruckerPrager> {
    Corotational(spec(integration).law().unwrap())
}

/// Confined shear of up to 5 % a step: compression in one direction, shear in all.
fn gradients() -> impl Strategy<Value = Vec<Mat3>> {
    let gradient = (0.0..0.02f64, proptest::array::uniform6(-0.02..0.02f64))
        .prop_map(|(c, [a, b, d, e, f, g])| Mat3([[-c, a, b], [d, -0.5 * c, e], [f, g, 0.0]]));
    proptest::collection::vec(gradient, 1..4)
}

fn motion(a: &Mat3) -> Motion {
    Motion::from_velocity_gradient(a, 1.0, 2.0, 1.0).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn forward_steps_away_from_the_apex_keep_the_contract(path in gradients(), angle in 0.0..6.0f64) {
        let (law, q) = (law(PlasticIntegration::Explicit), Mat3::rotation_z(angle));
        let start = |stress| InitialCondition { stress, density: 2.0 };
        let compressed = SymTensor([-300.0, -250.0, -280.0, 20.0, -10.0, 5.0]);
        let mut here = PointLaw::initial(&law, &start(compressed)).unwrap();
        let mut there = PointLaw::initial(&law, &start(compressed.rotated(&q))).unwrap();
        for a in &path {
            let step = motion(a);
            let next = law.update(&step, &here).unwrap();
            there = law.update(&motion(&(q * *a * q.transpose())), &there).unwrap();
            let handled = here.stress.norm() + 27e3 * a.sym().norm();
            let excess = PointLaw::yield_value(&law, &next).unwrap();
            prop_assert!(excess <= 1e-9 * (next.stress.pressure().abs() + 1.0), "f = {excess}");
            let turned = (there.stress - next.stress.rotated(&q)).norm();
            prop_assert!(turned <= 1e-10 * handled, "{turned} of {handled}");
            let lost = law.dissipation(&step, &here, &next).unwrap();
            prop_assert!(lost >= -1e-12 * handled * a.sym().norm(), "{lost}");
            here = next;
        }
    }
}

#[test]
fn divided_forward_steps_follow_the_return() {
    let run = |integration| {
        let law = law(integration);
        let start = InitialCondition { stress: SymTensor::isotropic(-100.0), density: 2.0 };
        let mut point = PointLaw::initial(&law, &start).unwrap();
        for _ in 0..4 {
            let a = Mat3([[0.002, 0.01, 0.0], [0.0, -0.01, 0.0], [0.0, 0.0, 0.0]]);
            point = law.update(&motion(&a), &point).unwrap();
        }
        point.stress
    };
    let (forward, returned) = (run(PlasticIntegration::Explicit), run(PlasticIntegration::ClosestPoint));
    assert!((forward - returned).norm() < 0.01 * returned.norm(), "{forward:?} and {returned:?}");
}
