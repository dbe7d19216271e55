//! Stomakhin snow (sheet: constitutive §2.14, V-15, bad input of §7).

use colluvium_constitutive::laws::{Snow, SnowElasticity, SnowSpec, SnowState};
use colluvium_constitutive::{
    InitialCondition, Mat3, Model, Motion, Point, PointLaw, StressUpdate, SymTensor,
};
use colluvium_testkit::assert_near;

/// Published defaults of the sheet.
fn spec(elastic_law: SnowElasticity) -> SnowSpec {
    let example = SnowSpec::examples().remove(0);
    SnowSpec { youngs_modulus: 1.4e5, poissons_ratio: 0.2, density: 400.0, elastic_law, ..example }
}

fn moved(law: &Snow, f: &Mat3, old: &Point<SnowState>) -> Point<SnowState> {
    let motion = Motion::from_deformation(f, 1.0, 400.0, 1.0).unwrap();
    law.update(&motion, old).unwrap()
}

fn at_rest(plastic_volume: f64) -> Point<SnowState> {
    Point { stress: SymTensor::ZERO, state: SnowState { elastic: SymTensor::ZERO, plastic_volume } }
}

fn close_matrix(found: &Mat3, exact: [[f64; 3]; 3], tolerance: f64) {
    for (found, exact) in found.0.iter().flatten().zip(exact.iter().flatten()) {
        assert_near(*found, *exact, tolerance);
    }
}

/// Elastic trial and plastic part of the reference step.
fn reference() -> (Mat3, Mat3) {
    (
        Mat3([[1.01, 0.02, 0.0], [-0.015, 0.96, 0.01], [0.0, 0.005, 1.002]]),
        Mat3([[1.0, 0.01, 0.0], [0.0, 0.99, 0.0], [0.0, 0.0, 1.0]]),
    )
}

#[test]
fn reference_step_clamps_two_stretches_and_stiffens() {
    let (trial, plastic) = reference();
    let law = spec(SnowElasticity::FixedCorotated).law().unwrap();
    // From rest the elastic trial of a step is the step itself.
    let new = moved(&law, &trial, &at_rest(plastic.determinant()));
    let tensor = SymTensor::IDENTITY.rotated(&trial);
    let spectrum = tensor.spectrum();
    let stretches = spectrum.values.map(f64::sqrt);
    let clamped = new.state.elastic.spectrum().values.map(|b| (1.0 + b).sqrt());
    for a in 0..3 {
        assert_near(stretches[a], [1.010_297_34, 1.003_283_19, 0.958_736_73][a], 5.1e-9);
        assert_near(clamped[a], [1.0075, 1.003_283_19, 0.975][a], 5.1e-9);
    }
    // The law needs only b_E of F_E; with the directions of the trial it has the sheet's F_E.
    let cut = spectrum.compose(std::array::from_fn(|a| clamped[a] / stretches[a])).to_matrix();
    let elastic = cut * trial;
    let difference = SymTensor::IDENTITY.rotated(&elastic) - SymTensor::IDENTITY - new.state.elastic;
    assert!(difference.norm() < 1e-14);
    let exact = [
        [1.007_254_77, 0.019_189_42, -2.867e-5],
        [-0.016_041_69, 0.975_742_33, 0.007_282_14],
        [2.218e-5, 0.002_240_71, 1.002_466_72],
    ];
    close_matrix(&elastic, exact, 5.1e-9);
    let plastic = elastic.inverse().unwrap() * trial * plastic;
    let exact = [
        [1.002_704_27, 0.011_128_15, -2.467e-5],
        [0.001_112_23, 0.974_036_26, 0.002_788_54],
        [-2.467e-5, 0.002_760_41, 0.999_528_2],
    ];
    close_matrix(&plastic, exact, 5.1e-9);
    assert_near(new.state.plastic_volume, plastic.determinant(), 1e-14);
    assert_near(new.state.plastic_volume, 0.976_189_43, 5.1e-9);
    assert_near(law.hardening(new.state.plastic_volume), 1.268_843_31, 5.1e-9);
}

#[test]
fn reference_step_has_the_stress_of_either_elastic_law() {
    let (trial, plastic) = reference();
    let laws = [
        (
            SnowElasticity::FixedCorotated,
            [405.994_659, -4_182.833_577, -335.186_044, 188.307_612, 694.438_523, 3.178_973],
        ),
        (
            SnowElasticity::Hencky,
            [377.830_682, -4_333.691_282, -357.185_580, 193.112_306, 717.622_136, 1.764_092],
        ),
    ];
    for (elastic_law, exact) in laws {
        let law = spec(elastic_law).law().unwrap();
        let new = moved(&law, &trial, &at_rest(plastic.determinant()));
        let kirchhoff = new.stress * (trial.determinant() * plastic.determinant());
        for c in 0..6 {
            assert_near(kirchhoff[c], exact[c], 5.1e-7);
        }
    }
}

#[test]
fn snow_within_the_critical_stretches_has_no_plastic_flow() {
    let law = spec(SnowElasticity::FixedCorotated).law().unwrap();
    let f = Mat3([[1.004, 0.004, 0.0], [-0.002, 0.985, 0.003], [0.0, 0.001, 0.99]]);
    let there = moved(&law, &f, &at_rest(1.0));
    assert_eq!(there.state.plastic_volume, 1.0);
    let back = moved(&law, &f.inverse().unwrap(), &there);
    assert_eq!(back.state.plastic_volume, 1.0);
    assert!(back.stress.norm() < 1e-8);
}

#[test]
fn torn_snow_softens_and_packed_snow_stiffens_with_the_excess() {
    for (direction, bound) in [(1.0, 1.0075), (-1.0, 0.975)] {
        for elastic_law in [SnowElasticity::FixedCorotated, SnowElasticity::Hencky] {
            let law = spec(elastic_law).law().unwrap();
            let steps = 200;
            let stretch = |step: usize| (direction * 0.1 * step as f64 / steps as f64).exp();
            let first = moved(&law, &along_x(bound), &at_rest(1.0)).stress * bound;
            let mut point = at_rest(1.0);
            for step in 0..steps {
                point = moved(&law, &along_x(stretch(step + 1) / stretch(step)), &point);
                let total = stretch(step + 1);
                if direction * (total - bound) > 0.0 {
                    let volume = total / bound;
                    assert_near(point.state.plastic_volume, volume, 1e-13);
                    let exact = first[0] * (10.0 * (1.0 - volume)).exp();
                    assert_near(point.stress[0] * total, exact, 1e-12 * exact.abs());
                } else {
                    assert_eq!(point.state.plastic_volume, 1.0);
                }
            }
            let h = law.hardening(point.state.plastic_volume);
            assert!(if direction > 0.0 { h < 0.5 } else { h > 1.8 });
        }
    }
}

fn along_x(stretch: f64) -> Mat3 {
    Mat3([[stretch, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
}

#[test]
fn the_step_in_the_plane_is_that_of_the_snow_sheet() {
    // Sheet: snow-mpm W3.
    let law = spec(SnowElasticity::FixedCorotated).law().unwrap();
    let trial = Mat3([[1.02, 0.03, 0.0], [-0.01, 0.95, 0.0], [0.0, 0.0, 1.0]]);
    let new = moved(&law, &trial, &at_rest(1.0));
    assert_near(new.state.plastic_volume, 0.986_753_197_2, 5.1e-11);
    assert_near(law.hardening(new.state.plastic_volume), 1.141_642_515_2, 5.1e-11);
    let kirchhoff = new.stress * trial.determinant();
    for (component, exact) in [(0, 164.662_263), (3, 542.563_115), (1, -3_947.551_076)] {
        assert_near(kirchhoff[component], exact, 5.1e-7);
    }
    let energy = law.stored_energy(&new).unwrap() * trial.determinant();
    assert_near(energy, 52.313_179_2, 5.1e-8);
    // Sheet: snow-mpm V10: stretch beyond the clamp is plastic.
    let packed = moved(&law, &along_x(0.9), &at_rest(1.0));
    assert_near(packed.state.plastic_volume, 0.9 / 0.975, 1e-14);
    assert_near(law.hardening(packed.state.plastic_volume), (10.0 * (1.0 - 0.9 / 0.975f64)).exp(), 1e-12);
}

#[test]
fn stiffening_is_bounded() {
    let law = spec(SnowElasticity::FixedCorotated).law().unwrap();
    assert_eq!(law.hardening(0.3), law.hardening(0.6));
    assert_eq!(law.hardening(50.0), law.hardening(20.0));
    assert_near(law.hardening(0.6), 4f64.exp(), 1e-12);
}

#[test]
fn an_initial_stress_beyond_the_clamp_is_refused() {
    let law = spec(SnowElasticity::FixedCorotated).law().unwrap();
    let at = |pressure: f64| {
        law.initial(&InitialCondition { stress: SymTensor::isotropic(-pressure), density: 400.0 })
    };
    let fine = at(1e3).unwrap();
    assert!((fine.stress.pressure() - 1e3).abs() < 1e-9);
    assert!(at(20e3).unwrap_err().to_string().starts_with("initial state of snow: the stress needs"));
}

#[test]
fn parameters_out_of_range_are_named() {
    let base = || spec(SnowElasticity::FixedCorotated);
    let refused = |spec: SnowSpec| spec.law().unwrap_err().to_string();
    for (spec, message) in [
        (SnowSpec { critical_compression: 0.0, ..base() }, "critical_compression: 0"),
        (SnowSpec { critical_compression: 1.0, ..base() }, "critical_compression: 1"),
        (SnowSpec { critical_stretch: 0.0, ..base() }, "critical_stretch: 0"),
        (SnowSpec { critical_stretch: f64::NAN, ..base() }, "critical_stretch: NaN"),
        (SnowSpec { hardening_factor: -1.0, ..base() }, "hardening_factor: -1"),
        (SnowSpec { youngs_modulus: 0.0, ..base() }, "youngs_modulus: 0"),
        (SnowSpec { poissons_ratio: 0.5, ..base() }, "poissons_ratio: 0.5"),
        (SnowSpec { least_plastic_volume: 1.5, ..base() }, "least_plastic_volume: 1.5"),
        (SnowSpec { largest_plastic_volume: 0.5, ..base() }, "largest_plastic_volume: 0.5"),
    ] {
        let error = refused(spec);
        assert!(error.starts_with(message), "{error}");
    }
}
