//! Finite-strain elasticity (sheet: constitutive §2.13): the table of Kirchhoff stresses, energies as
//! potentials, inverses.

use std::sync::Arc;

use colluvium_constitutive::{InitialCondition, Mat3, Material, MaterialSpec, Motion, SymTensor, laws};

const YOUNG: f64 = 20e6;
const SHEAR: f64 = YOUNG / 2.6;

fn hencky() -> MaterialSpec {
    MaterialSpec::LinearElastic(laws::LinearElasticSpec {
        density: 2000.0,
        youngs_modulus: YOUNG,
        poissons_ratio: 0.3,
        strain_measure: laws::StrainMeasure::Hencky,
    })
}

fn st_venant_kirchhoff() -> MaterialSpec {
    MaterialSpec::StVenantKirchhoff(laws::StVenantKirchhoffSpec {
        density: 2000.0,
        youngs_modulus: YOUNG,
        poissons_ratio: 0.3,
    })
}

fn neo_hookean(volumetric_law: laws::VolumetricLaw) -> MaterialSpec {
    MaterialSpec::NeoHookean(laws::NeoHookeanSpec {
        density: 2000.0,
        youngs_modulus: YOUNG,
        poissons_ratio: 0.3,
        volumetric_law,
    })
}

fn fixed_corotated() -> MaterialSpec {
    MaterialSpec::FixedCorotated(laws::FixedCorotatedSpec {
        density: 2000.0,
        youngs_modulus: YOUNG,
        poissons_ratio: 0.3,
    })
}

fn build(spec: &MaterialSpec) -> Arc<dyn Material> {
    spec.build().unwrap()
}

/// Cauchy stress and energy per initial volume after one step by `f` from the stress-free state.
fn after(law: &dyn Material, f: &Mat3) -> (SymTensor, f64) {
    let start = InitialCondition { stress: SymTensor::ZERO, density: 2000.0 };
    let (mut stress, mut states) = law.initial(&[start]).unwrap();
    let motion = Motion::from_deformation(f, 1.0, 2000.0 / f.determinant(), 1.0).unwrap();
    law.update(&[motion], &mut stress, &mut states.blocks_mut()[0]).unwrap();
    let mut energy = [0.0];
    assert!(law.stored_energies(&stress, &states.blocks()[0], &mut energy));
    (stress[0], energy[0] * f.determinant())
}

fn shear() -> Mat3 {
    Mat3([[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
}

fn stretch() -> Mat3 {
    Mat3([[1.0, 0.0, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 1.0]])
}

fn general() -> Mat3 {
    Mat3([[1.1, 0.3, 0.0], [0.05, 0.9, -0.1], [0.0, 0.2, 1.05]])
}

#[test]
fn kirchhoff_stresses_of_the_table() {
    let laws = [hencky(), st_venant_kirchhoff(), neo_hookean(Default::default()), fixed_corotated()];
    let rows: [(Mat3, usize, [f64; 4]); 13] = [
        (shear(), 3, [0.860_817_88, 2.75, 1.0, 1.105_572_81]),
        (shear(), 0, [0.430_408_94, 4.5, 1.0, 1.316_718_43]),
        (shear(), 1, [-0.430_408_94, 1.75, 0.0, 0.211_145_62]),
        (shear(), 2, [0.0, 0.75, 0.0, 0.0]),
        (stretch(), 1, [-0.781_002_43, -0.403_2, -0.694_715_33, -0.56]),
        (stretch(), 0, [-0.334_715_33, -0.27, -0.334_715_33, -0.24]),
        (stretch(), 2, [-0.334_715_33, -0.27, -0.334_715_33, -0.24]),
        (general(), 0, [0.284_776_81, 0.757_6, 0.367_101_5, 0.414_634_41]),
        (general(), 1, [-0.190_978_98, 0.128_728_13, -0.110_398_5, -0.066_999_65]),
        (general(), 2, [0.196_975_33, 0.399_103_13, 0.209_601_5, 0.220_808_15]),
        (general(), 3, [0.321_123_16, 0.433_906_25, 0.325, 0.329_174_2]),
        (general(), 4, [0.071_062_99, 0.106_781_25, 0.075, 0.077_502_11]),
        (general(), 5, [0.039_726_07, 0.122_85, 0.06, 0.070_663_21]),
    ];
    for (f, component, exact) in rows {
        for (spec, exact) in laws.iter().zip(exact) {
            let found = after(&*build(spec), &f).0[component] * f.determinant() / SHEAR;
            assert!((found - exact).abs() < 5.1e-9, "{}, {component}: {found} for {exact}", spec.name());
        }
    }
}

#[test]
fn hencky_shear_has_a_closed_form() {
    let law = build(&hencky());
    for gamma in [0.1, 1.0, 3.0f64] {
        let stress = after(&*law, &Mat3([[1.0, gamma, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])).0;
        let exact = 4.0 * (0.5 * gamma).asinh() / (4.0 + gamma * gamma).sqrt();
        assert!((stress[3] / SHEAR - exact).abs() < 1e-14);
        assert!(((stress[0] - stress[1]) / SHEAR - gamma * exact).abs() < 1e-13);
    }
}

#[test]
fn fixed_corotated_shear_and_stretch_have_closed_forms() {
    // Sheet: snow-mpm V2; Kirchhoff stress over the shear modulus, λ/μ = 1.5.
    let law = build(&fixed_corotated());
    for (gamma, exact) in [
        (0.1, [0.100_124_766_1, 0.012_507_798_9, 0.002_495_322_2]),
        (0.5, [0.514_928_749_9, 0.317_179_374_7, 0.059_714_999_7]),
        (1.0, [1.105_572_809_0, 1.316_718_427_0, 0.211_145_618_0]),
        (2.0, [2.585_786_437_6, 5.757_359_312_9, 0.585_786_437_6]),
    ] {
        let stress = after(&*law, &Mat3([[1.0, gamma, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])).0;
        for (component, exact) in [3, 0, 1].into_iter().zip(exact) {
            assert!((stress[component] / SHEAR - exact).abs() < 1e-9, "{gamma}: {stress:?}");
        }
    }
    for stretch in [0.6, 0.9, 1.3f64] {
        let stress = after(&*law, &Mat3([[stretch, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])).0;
        let exact = (2.0 + 1.5) * (stretch - 1.0);
        assert!((stress[0] / SHEAR - exact).abs() < 1e-12, "{stretch}: {stress:?}");
    }
}

#[test]
fn a_rotation_strains_nothing() {
    // Sheet: snow-mpm V3.
    for spec in [hencky(), st_venant_kirchhoff(), fixed_corotated()] {
        let law = build(&spec);
        for turn in 0..16 {
            let (sine, cosine) = (0.125 * std::f64::consts::PI * f64::from(turn)).sin_cos();
            let f = Mat3([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]);
            assert!(after(&*law, &f).0.norm() < 1e-9 * SHEAR, "{turn}");
        }
    }
}

#[test]
fn quadratic_volumetric_law_replaces_the_logarithm() {
    let law = build(&neo_hookean(laws::VolumetricLaw::Quadratic));
    let f = general();
    let jacobian = f.determinant();
    let b = SymTensor::IDENTITY.rotated(&f);
    let exact = (b - SymTensor::IDENTITY) + SymTensor::isotropic(0.75 * (jacobian * jacobian - 1.0));
    let found = after(&*law, &f).0 * (jacobian / SHEAR);
    assert!((found - exact).norm() < 1e-14);
}

#[test]
fn stress_is_the_slope_of_the_energy() {
    let laws = [
        hencky(),
        st_venant_kirchhoff(),
        neo_hookean(laws::VolumetricLaw::Logarithmic),
        neo_hookean(laws::VolumetricLaw::Quadratic),
        fixed_corotated(),
    ];
    let direction = Mat3([[0.3, -0.2, 0.5], [0.1, 0.7, -0.4], [0.6, 0.2, -0.5]]);
    for spec in laws {
        let law = build(&spec);
        let f = general();
        let kirchhoff = after(&*law, &f).0 * f.determinant();
        let h = 1e-5;
        let moved = |h: f64| after(&*law, &((Mat3::IDENTITY + direction * h) * f)).1;
        let slope = (moved(h) - moved(-h)) / (2.0 * h);
        let power = kirchhoff.dot(&direction.sym());
        assert!((slope - power).abs() < 1e-8 * SHEAR, "{}: {slope} for {power}", spec.name());
    }
}

#[test]
fn initial_stress_is_carried_by_a_deformation() {
    let stress = SymTensor([-60e3, -50e3, -45e3, 3e3, -2e3, 1e3]);
    for scale in [1.0, -3.0, 20.0] {
        for spec in [st_venant_kirchhoff(), neo_hookean(laws::VolumetricLaw::Quadratic), fixed_corotated()] {
            let start = InitialCondition { stress: stress * scale, density: 2000.0 };
            let found = build(&spec).initial(&[start]).unwrap().0[0];
            let error = (found - start.stress).norm();
            assert!(error <= 1e-12 * start.stress.norm(), "{}: {error}", spec.name());
        }
    }
    let crushing = InitialCondition { stress: SymTensor::isotropic(-5e9), density: 2000.0 };
    let refused = build(&st_venant_kirchhoff()).initial(&[crushing]).unwrap_err().to_string();
    assert!(
        refused.contains("st-venant-kirchhoff") && refused.contains("no moderate deformation"),
        "{refused}"
    );
}

#[test]
fn elastic_constants_out_of_range_are_named() {
    for (model, field, value) in [
        ("st-venant-kirchhoff", "youngs_modulus", -1.0),
        ("st-venant-kirchhoff", "poissons_ratio", 0.5),
        ("fixed-corotated", "youngs_modulus", 0.0),
        ("fixed-corotated", "poissons_ratio", -1.0),
    ] {
        let young = if field == "youngs_modulus" { value } else { YOUNG };
        let poisson = if field == "poissons_ratio" { value } else { 0.3 };
        let spec = if model == "fixed-corotated" {
            MaterialSpec::FixedCorotated(laws::FixedCorotatedSpec {
                density: 2000.0,
                youngs_modulus: young,
                poissons_ratio: poisson,
            })
        } else {
            MaterialSpec::StVenantKirchhoff(laws::StVenantKirchhoffSpec {
                density: 2000.0,
                youngs_modulus: young,
                poissons_ratio: poisson,
            })
        };
        let error = spec.build().err().expect("out of range").to_string();
        assert!(error.starts_with(&format!("{field}: {value}")), "{error}");
    }
}
