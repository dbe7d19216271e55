//! Local solve of a banded point: Newton's method on the jump, surroundings that yield, steps without solution.

use colluvium_constitutive::laws::{
    CohesiveBandSpec, DoubleScaleSpec, LocalSolve, Matching, Onset, OutsideStrength,
};
use colluvium_constitutive::{InitialCondition, Mat3, MaterialError, MaterialSpec, Model, Motion, SymTensor};

use super::{BAND, spec};

#[test]
fn newton_on_the_jump_ends_where_the_return_does() {
    let band = CohesiveBandSpec { normal_stiffness: 1e14, shear_stiffness: 1e14, ..BAND };
    let run = |local_solve| {
        let spec = DoubleScaleSpec { local_solve, size: Some(0.01), poissons_ratio: 0.2, ..spec(band) };
        let law = spec.build().unwrap();
        let start = InitialCondition { stress: SymTensor::ZERO, density: 2400.0 };
        let (mut stresses, mut states) = law.initial(&[start]).unwrap();
        let stretch = |x: f64, xy: f64| Mat3([[x, xy, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]);
        // Through the peak, down the softening branch, back, and on.
        let path = [(2e-5, 1e-5), (2e-5, 1e-5), (-1e-5, 5e-6), (4e-5, -2e-5)];
        let steps = path.iter().flat_map(|(x, xy)| (0..40).map(move |_| stretch(*x, *xy)));
        steps
            .map(|l| {
                let motion = Motion::from_velocity_gradient(&l, 1.0, 2400.0, 0.01).unwrap();
                law.update(&[motion], &mut stresses, &mut states.blocks_mut()[0]).unwrap();
                stresses[0]
            })
            .collect::<Vec<_>>()
    };
    let (newton, returned) = (run(Some(LocalSolve::Newton)), run(Some(LocalSolve::Return)));
    for (a, b) in newton.iter().zip(&returned) {
        assert!((*a - *b).norm() <= 1e-9 * 3e6, "{a:?} and {b:?}");
    }
}

/// Onset by loss of ellipticity around a Drucker–Prager material in pure shear: with the critical hardening of
/// Rudnicki & Rice (1975), `h/G = (1+ν)/(9(1-ν)) (β-μ)² - (1+ν)/2 (N + (β+μ)/3)²`, positive without
/// dilatancy and negative for associated flow, perfect plasticity localises in the one and not in the other.
#[test]
fn ellipticity_is_lost_at_the_hardening_of_rudnicki_and_rice() {
    let shear = |dilatancy_angle: f64| {
        let outside = OutsideStrength {
            friction_angle: 30.0,
            cohesion: 10e3,
            dilatancy_angle,
            matching: Matching::Compression,
            softening: None,
        };
        let energies = CohesiveBandSpec { opening_energy: 1e5, sliding_energy: 4e5, ..BAND };
        let band = CohesiveBandSpec { cohesion: 1e6, tensile_strength: 5e5, ..energies };
        let spec = DoubleScaleSpec {
            youngs_modulus: 20e6,
            poissons_ratio: 0.3,
            outside: Some(outside),
            onset: Onset::Ellipticity,
            ..spec(band)
        };
        let law = spec.build().unwrap();
        let start = InitialCondition { stress: SymTensor::isotropic(-100e3), density: 2400.0 };
        let (mut stresses, mut states) = law.initial(&[start]).unwrap();
        let l = SymTensor([0.0, 0.0, 0.0, 5e-5, 0.0, 0.0]).to_matrix();
        let motion = Motion::from_velocity_gradient(&l, 1.0, 2400.0, 0.01).unwrap();
        let mut onset = None;
        for step in 0..150 {
            law.update(&[motion], &mut stresses, &mut states.blocks_mut()[0]).unwrap();
            let mut out = [0.0; 4];
            law.outputs(&stresses, &states.blocks()[0], &mut out);
            if out[0] == 1.0 && onset.is_none() {
                onset = Some((step, stresses[0].j2().sqrt()));
            }
        }
        onset
    };
    let (mu, nu) = (3.0 * 0.230_940_11, 0.3);
    let critical = |beta: f64| {
        (1.0 + nu) / (9.0 * (1.0 - nu)) * (beta - mu).powi(2)
            - (1.0 + nu) / 2.0 * ((beta + mu) / 3.0f64).powi(2)
    };
    assert!(critical(0.0) > 0.0 && critical(mu) < 0.0);
    // √J2 = k - α I1 at yield, reached in steps of G γ = 769 Pa.
    let (step, root_j2) = shear(0.0).expect("localises");
    let strength = 12e3 + 0.230_940_11 * 300e3;
    assert!((root_j2 - strength).abs() < 1.0, "{root_j2} for {strength}");
    assert_eq!(step, (strength / (20e6 / 2.6 * 1e-4)) as usize);
    assert_eq!(shear(30.0), None);
    let elastic = DoubleScaleSpec { onset: Onset::Ellipticity, ..spec(BAND) }.build().err().unwrap();
    assert!(elastic.to_string().starts_with("onset: ellipticity needs a strength outside"), "{elastic}");
}

/// Unconverged local solve, returned as an element test that fails at the same step.
#[test]
fn an_unconverged_step_is_repeated_in_the_driver() {
    let outside = OutsideStrength {
        friction_angle: 30.0,
        cohesion: 15e3,
        dilatancy_angle: 10.0,
        matching: Matching::Compression,
        softening: None,
    };
    let band = CohesiveBandSpec {
        cohesion: 20e3,
        tensile_strength: 10e3,
        friction_coefficient: 0.6,
        dilatancy_coefficient: 0.2,
        opening_energy: 10.0,
        sliding_energy: 40.0,
        normal_stiffness: 5e9,
        shear_stiffness: 2e9,
    };
    let spec = DoubleScaleSpec {
        youngs_modulus: 20e6,
        poissons_ratio: 0.3,
        outside: Some(outside),
        size: Some(0.1),
        ..spec(band)
    };
    let law = spec.build().unwrap();
    // Of many long steps from one stress some have no solution.
    let start = InitialCondition { stress: SymTensor::isotropic(-1e3), density: 2400.0 };
    let mut seed = 3u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        0.2 * ((seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5)
    };
    let failed = (0..20_000).find_map(|_| {
        let gradient = Mat3(std::array::from_fn(|_| std::array::from_fn(|_| random())));
        let motion = Motion::from_velocity_gradient(&(gradient * 100.0), 0.01, 2400.0, 0.1)?;
        let (mut stresses, mut states) = law.initial(&[start]).unwrap();
        let error = law.update(&[motion], &mut stresses, &mut states.blocks_mut()[0]).err()?;
        Some((motion, error.source))
    });
    let Some((motion, MaterialError::UnconvergedStep(unsolved))) = failed else { panic!("{failed:?}") };
    assert_eq!(
        (unsolved.stress, unsolved.gradient, unsolved.dt),
        (start.stress, motion.velocity_gradient_dt, motion.dt)
    );
    let text = unsolved.to_string();
    assert!(
        text.starts_with("double-scale: the stress update did not converge (jump), from the stress"),
        "{text}"
    );
    let again = unsolved.element_test(MaterialSpec::DoubleScale(spec)).run();
    assert!(again.unwrap_err().to_string().contains("did not converge (jump)"));
}
