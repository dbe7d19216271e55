//! Points cut by a band: fracture energy, orientation and rotation of the band, limits of its parameters.

use colluvium_constitutive::laws::{
    BandedState, CohesiveBandSpec, CohesiveDamageSpec, CohesiveState, DoubleScaleSpec, Onset,
};
use colluvium_constitutive::localisation::FiniteBand;
use colluvium_constitutive::{
    Corotational, InitialCondition, Mat3, MaterialError, Model, Motion, Point, PointLaw, SmallStrain,
    StressUpdate, SymTensor,
};
use colluvium_testkit::assert_near;

use super::{BAND, NORMAL, motion, spec, stiffness};

/// Elongation (m) at which the bar of V-23 (one point of size `size`, E = 30 GPa, ν = 0) reaches `stress` (Pa)
/// in softening, and the area under stress and crack opening (J/m²).
fn bar(size: f64, stress: f64) -> (f64, f64) {
    let law =
        Corotational(DoubleScaleSpec { size: Some(size), ..spec(BAND) }.law(BAND.law().unwrap()).unwrap());
    let start = InitialCondition { stress: SymTensor::ZERO, density: 2400.0 };
    let mut point = law.initial(&start).unwrap();
    let (mut elongation, mut found, mut area) = (0.0, f64::NAN, 0.0);
    let step = 2e-8;
    for _ in 0..25_000 {
        let new = law.update(&motion(&SymTensor::diagonal(step / size, 0.0, 0.0), 1.0), &point).unwrap();
        let (before, after) = (point.stress[0], new.stress[0]);
        if new.state.localised && before >= stress && after < stress {
            found = elongation + step * (before - stress) / (before - after);
        }
        area += 0.5 * (before + after) * (new.state.jump[0] - point.state.jump[0]);
        elongation += step;
        point = new;
    }
    (found, area)
}

#[test]
fn a_cohesive_bar_has_the_same_fracture_energy_at_any_size() {
    for (size, stress, exact) in [
        (0.01, 1.5e6, 23.604_906e-6),
        (0.01, 0.3e6, 76.852_836e-6),
        (0.05, 1.5e6, 25.604_906e-6),
        (0.05, 0.3e6, 77.252_836e-6),
    ] {
        assert_near(bar(size, stress).0, exact, 2e-11);
    }
    for size in [0.005, 0.01, 0.05, 0.2] {
        assert_near(bar(size, 1.5e6).1, 100.0, 0.1);
    }
}

#[test]
fn a_bar_beyond_the_snap_back_limit_is_refused_or_warned_about() {
    let limit = 30e9 * 100.0 / 9e12;
    assert_near(limit, 0.333, 5e-4);
    let sized = |size| DoubleScaleSpec { size: Some(size), ..spec(BAND) };
    assert!(sized(0.999 * limit).build().is_ok());
    assert!(sized(0.2).warnings().is_empty());
    let refused = sized(1.001 * limit).build().err().map(|error| error.to_string());
    assert!(refused.is_some_and(|error| error.starts_with("size: ")));
    assert!(sized(0.4).warnings()[0].text.contains("snap-back"));
    let allowed = DoubleScaleSpec { allow_snapback: true, ..sized(0.4) };
    assert!(allowed.build().is_ok());
    assert!(allowed.warnings()[0].text.starts_with("size: snap-back"));
    // The size that the method gives is known only in a step.
    let law = Corotational(spec(BAND).law(BAND.law().unwrap()).unwrap());
    let start = law.initial(&InitialCondition { stress: SymTensor::ZERO, density: 2400.0 }).unwrap();
    let strain = SymTensor::diagonal(2e-4, 0.0, 0.0);
    assert!(law.update(&motion(&strain, 0.1), &start).unwrap().state.localised);
    assert!(matches!(law.update(&motion(&strain, 0.4), &start), Err(MaterialError::Motion { .. })));
}

#[test]
fn traction_is_continuous_and_the_normal_rotates_with_the_material() {
    let band = CohesiveBandSpec { normal_stiffness: 1e14, shear_stiffness: 1e14, ..BAND };
    let law = spec(band).law(band.law().unwrap()).unwrap();
    let start =
        InitialCondition { stress: SymTensor([-1e6, -2e6, -1.5e6, 0.3e6, 0.0, 0.0]), density: 2400.0 };
    let mut point = PointLaw::initial(&law, &start).unwrap();
    let strain = SymTensor([2e-5, -6e-5, 1e-5, 3e-5, 1e-5, -1e-5]);
    for _ in 0..40 {
        point = SmallStrain::update(&law, &strain, &motion(&strain, 0.02), &point).unwrap();
    }
    assert!(point.state.localised);
    // The stress of the band is at most its strength, and exactly that while it slides.
    assert!(PointLaw::yield_value(&law, &point).unwrap().abs() <= 1e-9 * point.stress.norm());
    let objective = Corotational(law);
    let quarter = Mat3::rotation_z(std::f64::consts::FRAC_PI_2);
    let turn = Motion::from_deformation(&quarter, 1.0, 2400.0, 0.02).unwrap();
    let turned: Point<BandedState<CohesiveState>> = objective.update(&turn, &point).unwrap();
    let exact = quarter.apply(point.state.frame.0[0]);
    for (found, exact) in turned.state.frame.0[0].into_iter().zip(exact) {
        assert_near(found, exact, 1e-12);
    }
    assert!((turned.stress - point.stress.rotated(&quarter)).norm() <= 1e-9 * point.stress.norm());
}

#[test]
fn a_band_follows_the_critical_plane_or_the_largest_principal_stress() {
    // Shear failure under pressure: the angle of the band at which y is largest on the circle of Mohr.
    let band = CohesiveBandSpec { normal_stiffness: 1e14, shear_stiffness: 1e14, ..BAND };
    let law = spec(band).law(band.law().unwrap()).unwrap();
    let start = InitialCondition { stress: SymTensor::isotropic(-5e6), density: 2400.0 };
    let compress = SymTensor([0.0, -1e-5, 0.0, 0.0, 0.0, 0.0]);
    let slant = SymTensor([0.0, -1e-5, 0.0, 1e-9, 0.0, 0.0]);
    let localised = |strain: &SymTensor| {
        let mut point = PointLaw::initial(&law, &start).unwrap();
        for _ in 0..1000 {
            point = SmallStrain::update(&law, strain, &motion(strain, 0.02), &point).unwrap();
            if point.state.localised {
                break;
            }
        }
        point
    };
    for strain in [compress, slant] {
        let point = localised(&strain);
        let y = point.state.frame.0[0][1];
        let (mean, radius) = (0.5 * (-5e6 + point.stress[1]), 0.5 * (-5e6 - point.stress[1]));
        let cosine = 0.6 * (4.5e6 - 0.6 * mean) / (radius * 1.36);
        assert_near(1.0 - 2.0 * y * y, cosine, 2e-3);
    }
    let rankine = DoubleScaleSpec { onset: Onset::Rankine, ..spec(band) }.law(band.law().unwrap()).unwrap();
    let mut point = PointLaw::initial(&rankine, &start).unwrap();
    let strain = SymTensor([0.0, 0.0, 2e-5, 0.0, 0.0, 0.0]);
    while !point.state.localised {
        assert!(point.stress[2] <= 3e6);
        point = SmallStrain::update(&rankine, &strain, &motion(&strain, 0.02), &point).unwrap();
    }
    assert_near(point.state.frame.0[0][2].abs(), 1.0, 1e-12);
}

#[test]
fn a_broken_band_may_be_reset() {
    let band = CohesiveBandSpec { normal_stiffness: 1e14, shear_stiffness: 1e14, ..BAND };
    let forgetful = DoubleScaleSpec { intact_reset: true, ..spec(band) };
    let law = forgetful.law(band.law().unwrap()).unwrap();
    let mut point =
        PointLaw::initial(&law, &InitialCondition { stress: SymTensor::ZERO, density: 2400.0 }).unwrap();
    let strain = SymTensor::diagonal(1e-4, 0.0, 0.0);
    let mut history = vec![false];
    for _ in 0..600 {
        point = SmallStrain::update(&law, &strain, &motion(&strain, 0.01), &point).unwrap();
        history.push(point.state.localised);
    }
    let insertions = history.windows(2).filter(|pair| !pair[0] && pair[1]).count();
    assert!(insertions >= 2, "cracks {insertions} times");
    assert!(point.stress[0] <= 3e6);
}

#[test]
fn bad_input_is_refused_by_name() {
    let field = |band: CohesiveBandSpec| match spec(band).build() {
        Err(MaterialError::Parameter { field, .. }) => field,
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("accepted {band:?}"),
    };
    assert_eq!(field(CohesiveBandSpec { tensile_strength: 0.0, ..BAND }), "band.tensile_strength");
    assert_eq!(field(CohesiveBandSpec { cohesion: -1.0, ..BAND }), "band.cohesion");
    assert_eq!(field(CohesiveBandSpec { cohesion: 1.8e6, ..BAND }), "band.cohesion");
    assert_eq!(field(CohesiveBandSpec { opening_energy: 0.0, ..BAND }), "band.opening_energy");
    assert_eq!(field(CohesiveBandSpec { sliding_energy: f64::NAN, ..BAND }), "band.sliding_energy");
    assert_eq!(field(CohesiveBandSpec { friction_coefficient: 0.0, ..BAND }), "band.friction_coefficient");
    assert_eq!(field(CohesiveBandSpec { dilatancy_coefficient: 0.7, ..BAND }), "band.dilatancy_coefficient");
    assert_eq!(field(CohesiveBandSpec { normal_stiffness: 8e10, ..BAND }), "band.normal_stiffness");
    assert_eq!(field(CohesiveBandSpec { shear_stiffness: 0.0, ..BAND }), "band.shear_stiffness");
    let damage = CohesiveDamageSpec { tensile_strength: 3e6, fracture_energy: 100.0, stiffness: 1e13 };
    for (bad, name) in [
        (CohesiveDamageSpec { stiffness: 1e11, ..damage }, "band.stiffness"),
        (CohesiveDamageSpec { fracture_energy: 0.0, ..damage }, "band.fracture_energy"),
        (CohesiveDamageSpec { tensile_strength: -1.0, ..damage }, "band.tensile_strength"),
    ] {
        assert!(matches!(bad.law(), Err(MaterialError::Parameter { field, .. }) if field == name), "{name}");
    }
    let size = DoubleScaleSpec { size: Some(0.0), ..spec(BAND) };
    assert!(matches!(size.build(), Err(MaterialError::Parameter { field, .. }) if field == "size"));
    let (outside, inside) = (stiffness(30e9, 0.2), stiffness(0.3e9, 0.3));
    for (thickness, normal, name) in
        [(0.0, NORMAL, "thickness"), (0.03, NORMAL, "thickness"), (1e-3, [1.0, 1.0, 0.0], "normal")]
    {
        let refused = FiniteBand::new(thickness, 0.02, normal, outside, inside);
        assert!(matches!(refused, Err(MaterialError::Parameter { field, .. }) if field == name), "{name}");
    }
    let strong = InitialCondition { stress: SymTensor::isotropic(4e6), density: 2400.0 };
    let law = spec(BAND).build().unwrap();
    assert!(colluvium_constitutive::Material::initial(law.as_ref(), &[strong]).is_err());
}
