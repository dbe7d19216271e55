//! Laws that wrap other laws (sheet: constitutive §2.17, §3.11).

use colluvium_constitutive::laws::mohr_coulomb::Pyramid;
use colluvium_constitutive::laws::{
    DruckerPragerSpec, EigenstrainSpec, LinearElasticSpec, Matching, MohrCoulombSpec, ReductionScope,
    SaturationSoftenedSpec, Softening, StrainMeasure, StrengthReducedSpec, StrengthReduction, UndrainedSpec,
};
use colluvium_constitutive::{
    InitialCondition, Mat3, Material, MaterialSpec, Motion, PoreFluidState, States, SymTensor,
};

fn elastic() -> MaterialSpec {
    MaterialSpec::LinearElastic(LinearElasticSpec {
        density: 2000.0,
        youngs_modulus: 20e6,
        poissons_ratio: 0.3,
        strain_measure: StrainMeasure::Rate,
    })
}

fn mohr_coulomb() -> MohrCoulombSpec {
    crate::reference_materials::mohr_coulomb(1e3, 10.0)
}

fn drucker_prager() -> DruckerPragerSpec {
    crate::reference_materials::drucker_prager(1e3, Matching::Compression, 10.0)
}

fn start(law: &dyn Material, stress: SymTensor) -> (SymTensor, States) {
    let (stresses, states) = law.initial(&[InitialCondition { stress, density: 2000.0 }]).unwrap();
    (stresses[0], states)
}

fn step(law: &dyn Material, point: &mut (SymTensor, States), strain: SymTensor, saturation: f64) {
    let a = strain.to_matrix();
    let mut motion = Motion::from_velocity_gradient(&a, 1.0, 2000.0, 0.1).unwrap();
    motion.pore = PoreFluidState { pressure: 0.0, saturation };
    let mut stress = [point.0];
    law.update(&[motion], &mut stress, &mut point.1.blocks_mut()[0]).unwrap();
    point.0 = stress[0];
}

#[test]
fn pore_fluid_carries_the_undrained_load_by_its_share_of_stiffness() {
    // §5.3: Δp_w/Δp = (K_f/n) / (K + K_f/n).
    let spec = UndrainedSpec {
        fluid_bulk_modulus: 2.15e9,
        porosity: 0.4,
        initial_pore_pressure: 20e3,
        cavitation_strength: None,
        skeleton: Box::new(elastic()),
    };
    let law = MaterialSpec::Undrained(spec).build().unwrap();
    let mut point = start(&*law, SymTensor::isotropic(-50e3));
    step(&*law, &mut point, SymTensor::isotropic(-1e-6), 0.0);
    let mut water = [0.0];
    assert_eq!(law.output_names(), ["pore_pressure"]);
    law.outputs(&[point.0], &point.1.blocks()[0], &mut water);
    let (k, fluid) = (20e6 / 1.2, 2.15e9 / 0.4);
    let share = (water[0] - 20e3) / (point.0.pressure() - 50e3);
    assert!((share - fluid / (k + fluid)).abs() < 1e-9, "{share}");
    let mut modulus = [0.0];
    law.wave_moduli(&[point.0], &point.1.blocks()[0], &mut modulus);
    assert!((modulus[0] / (26_923_076.92 + fluid) - 1.0).abs() < 1e-9);
}

#[test]
fn pore_fluid_tension_is_limited_to_the_cavitation_strength() {
    let spec = UndrainedSpec {
        fluid_bulk_modulus: 2e9,
        porosity: 0.5,
        initial_pore_pressure: 0.0,
        cavitation_strength: Some(50e3),
        skeleton: Box::new(elastic()),
    };
    let law = MaterialSpec::Undrained(spec).build().unwrap();
    let mut point = start(&*law, SymTensor::ZERO);
    step(&*law, &mut point, SymTensor::isotropic(1e-3), 0.0);
    let skeleton = 3e-3 * 20e6 / 1.2;
    assert!((point.0[0] - (50e3 + skeleton)).abs() < 1e-6, "{:?}", point.0);
}

#[test]
fn undrained_triaxial_strength_follows_the_effective_stress() {
    // V-09: q_f = 6 (p₀ sin φ + c cos φ)/(3 - sin φ) at ψ = 0, p' constant; isochoric in all but a stiff fluid.
    let skeleton = MaterialSpec::MohrCoulomb(MohrCoulombSpec { dilatancy_angle: 0.0, ..mohr_coulomb() });
    let spec = UndrainedSpec {
        fluid_bulk_modulus: 2e9,
        porosity: 0.4,
        initial_pore_pressure: 0.0,
        cavitation_strength: None,
        skeleton: Box::new(skeleton),
    };
    let law = MaterialSpec::Undrained(spec).build().unwrap();
    let mut point = start(&*law, SymTensor::isotropic(-100e3));
    for _ in 0..200 {
        step(&*law, &mut point, SymTensor::diagonal(0.5e-4, -1e-4, 0.5e-4), 0.0);
    }
    assert!((point.0.q() / 140_784.610 - 1.0).abs() < 1e-6, "{}", point.0.q());
}

#[test]
fn free_shrinkage_is_stress_free_and_restrained_shrinkage_causes_tension() {
    let spec = EigenstrainSpec { volumetric_strain: -0.03, duration: 10.0, material: Box::new(elastic()) };
    let law = MaterialSpec::Eigenstrain(spec).build().unwrap();
    let (mut free, mut held) = (start(&*law, SymTensor::ZERO), start(&*law, SymTensor::ZERO));
    for _ in 0..20 {
        // Half of the steps lie after the end of the shrinkage: no further change there.
        let shrinks = held.0[0] < 0.03 * 20e6 / 1.2 - 1e-6;
        step(&*law, &mut free, SymTensor::isotropic(if shrinks { -0.001 } else { 0.0 }), 0.0);
        step(&*law, &mut held, SymTensor::ZERO, 0.0);
    }
    assert!(free.0.norm() < 1e-6, "{:?}", free.0);
    let tension = 0.03 * 20e6 / 1.2;
    assert!((held.0 - SymTensor::isotropic(tension)).norm() < 1e-6, "{:?} for {tension}", held.0);
}

#[test]
fn a_stress_on_the_surface_of_the_factor_of_safety_lies_on_the_reduced_surface() {
    // V-27. Stress of a slope with the factor 1.4: on the surface of strengths divided by it.
    let factor = 1.4;
    let reduction = StrengthReduction::by_factor(factor);
    for spec in [MaterialSpec::MohrCoulomb(mohr_coulomb()), MaterialSpec::DruckerPrager(drucker_prager())] {
        let law = spec.strength_reduced(&reduction).unwrap().build().unwrap();
        let (c, tan) = (10e3 / factor, 30f64.to_radians().tan() / factor);
        let sin = tan / (1.0 + tan * tan).sqrt();
        let cos = 1.0 / (1.0 + tan * tan).sqrt();
        // Triaxial compression, where both criteria agree.
        let (lateral, ratio) = (-50e3, (1.0 + sin) / (1.0 - sin));
        let axial = lateral * ratio - 2.0 * c * cos / (1.0 - sin);
        let stress = SymTensor::diagonal(lateral, axial, lateral);
        let (stress, states) = start(&*law, stress);
        let mut value = [0.0];
        law.yield_values(&[stress], &states.blocks()[0], &mut value);
        assert!(value[0].abs() < 1e-6 * axial.abs(), "{}: {}", spec.name(), value[0]);
    }
}

#[test]
fn peak_strength_reduction_keeps_the_residual_strength_and_is_refused_below_it() {
    let softening = Softening::of_cohesion(1.5e3, 5.0);
    // Bui & Nguyen 4.3: 25 kPa / 1.65 = 15.15 kPa, residual 1.5 kPa unchanged.
    let clay = DruckerPragerSpec {
        friction_angle: 0.0,
        dilatancy_angle: 0.0,
        cohesion: 25e3,
        softening: Some(softening),
        ..drucker_prager()
    };
    let peak =
        |factor| StrengthReduction { scope: ReductionScope::Peak, ..StrengthReduction::by_factor(factor) };
    let reduced = MaterialSpec::DruckerPrager(clay.clone()).strength_reduced(&peak(1.65)).unwrap();
    let MaterialSpec::DruckerPrager(reduced) = reduced else { panic!("the model stays") };
    assert!((reduced.cohesion - 15_151.515).abs() < 1e-2);
    assert_eq!(reduced.softening, Some(softening));
    let error = MaterialSpec::DruckerPrager(clay).strength_reduced(&peak(20.0)).unwrap_err().to_string();
    assert!(error.starts_with("softening.residual_cohesion: 1500"), "{error}");
    let refused = elastic().strength_reduced(&StrengthReduction::by_factor(1.2)).unwrap_err().to_string();
    assert!(refused.contains("no strength to reduce"), "{refused}");
    let wrapped = StrengthReducedSpec {
        factor: 0.0,
        scope: ReductionScope::Both,
        keep_dilatancy: false,
        material: Box::new(MaterialSpec::MohrCoulomb(mohr_coulomb())),
    };
    let error = MaterialSpec::StrengthReduced(wrapped).build().err().expect("refused").to_string();
    assert!(error.starts_with("factor: 0"), "{error}");
}

#[test]
fn dilatancy_follows_the_reduced_friction_unless_kept() {
    let associated = MaterialSpec::MohrCoulomb(MohrCoulombSpec { dilatancy_angle: 30.0, ..mohr_coulomb() });
    let MaterialSpec::MohrCoulomb(spec) =
        associated.strength_reduced(&StrengthReduction::by_factor(2.0)).unwrap()
    else {
        panic!("the model stays")
    };
    assert_eq!(spec.dilatancy_angle, spec.friction_angle);
    assert!((spec.friction_angle.to_radians().tan() - 30f64.to_radians().tan() / 2.0).abs() < 1e-12);
    let keep = StrengthReduction { keep_dilatancy: true, ..StrengthReduction::by_factor(2.0) };
    assert!(associated.strength_reduced(&keep).unwrap_err().to_string().starts_with("dilatancy_angle: 30"));
}

#[test]
fn cohesion_decreases_linearly_with_saturation() {
    let spec = SaturationSoftenedSpec {
        saturated_cohesion: 2e3,
        material: Box::new(MaterialSpec::MohrCoulomb(MohrCoulombSpec {
            friction_angle: 0.0,
            dilatancy_angle: 0.0,
            ..mohr_coulomb()
        })),
    };
    let law = MaterialSpec::SaturationSoftened(spec).build().unwrap();
    // Pure shear of a frictionless soil carries its cohesion, c = 2 + 8 (1 - S) kPa.
    for (saturation, cohesion) in [(0.0, 10e3), (0.25, 8e3), (1.0, 2e3)] {
        let mut point = start(&*law, SymTensor::ZERO);
        step(&*law, &mut point, SymTensor([0.0, 0.0, 0.0, 0.01, 0.0, 0.0]), saturation);
        assert!((point.0[3] - cohesion).abs() < 1e-6, "{} for {cohesion}", point.0[3]);
    }
}

#[test]
fn wrappers_nest_save_and_reorder() {
    let undrained = UndrainedSpec {
        fluid_bulk_modulus: 2e8,
        porosity: 0.4,
        initial_pore_pressure: 0.0,
        cavitation_strength: None,
        skeleton: Box::new(MaterialSpec::MohrCoulomb(mohr_coulomb())),
    };
    let nested = EigenstrainSpec {
        volumetric_strain: -0.01,
        duration: 1.0,
        material: Box::new(MaterialSpec::Undrained(undrained)),
    };
    let spec = MaterialSpec::Eigenstrain(nested);
    let text = serde_json::to_string(&spec).unwrap();
    let law = serde_json::from_str::<MaterialSpec>(&text).unwrap().build().unwrap();
    let conditions: Vec<_> = (0..130)
        .map(|i| InitialCondition { stress: SymTensor::isotropic(-1e4 - f64::from(i)), density: 2000.0 })
        .collect();
    let (mut stresses, mut states) = law.initial(&conditions).unwrap();
    let motion = Motion::from_velocity_gradient(&(Mat3::IDENTITY * -1e-4), 0.1, 2000.0, 0.1).unwrap();
    for (block, part) in states.blocks_mut().iter_mut().zip(stresses.chunks_mut(64)) {
        law.update(&vec![motion; part.len()], part, block).unwrap();
    }
    let bytes = law.save(&states);
    let order: Vec<u32> = (0..130).rev().collect();
    let back = law.load(&law.save(&states.permuted(&order))).unwrap().permuted(&order);
    assert_eq!(law.save(&back), bytes);
    assert_eq!(law.output_names(), ["plastic_strain", "pore_pressure"]);
    let mut rows = vec![0.0; 2 * 64];
    law.outputs(&stresses[..64], &states.blocks()[0], &mut rows);
    // Shrinkage of 1e-3 against a compression of 3e-5 leaves the skeleton and its water in tension.
    let tension = -5e8 * (1e-3 - 3e-5);
    assert!(rows.chunks(2).all(|row| (row[1] / tension - 1.0).abs() < 1e-9), "{rows:?}");
}

#[test]
fn strength_above_the_peak_requires_the_hardening_option() {
    let softening = |hardening| Softening {
        residual_friction_angle: 35.0,
        residual_cohesion: 20e3,
        friction_rate: 50.0,
        cohesion_rate: 50.0,
        hardening,
    };
    let with = |hardening| MohrCoulombSpec { softening: Some(softening(hardening)), ..mohr_coulomb() };
    let refused = with(false).law().unwrap_err().to_string();
    assert!(refused.starts_with("softening.residual_friction_angle: 35"), "{refused}");
    let law = with(true).law().unwrap();
    // From the peak of 30° and 10 kPa half of the softening at κ = ln 2 / 50.
    let half = law.pyramid_at(2f64.ln() / 50.0);
    let expected = Pyramid::new(32.5f64.to_radians(), 15e3, mohr_coulomb().dilatancy_angle.to_radians());
    assert!((half.friction - expected.friction).abs() < 1e-12 * expected.friction);
    assert!((half.strength - expected.strength).abs() < 1e-9 * expected.strength);
}

/// Mohr–Coulomb material with `depth` nested reductions, each of another scope than the last.
fn reduced(depth: usize) -> MaterialSpec {
    (0..depth).fold(MaterialSpec::MohrCoulomb(mohr_coulomb()), |material, level| {
        MaterialSpec::StrengthReduced(StrengthReducedSpec {
            factor: 1.05,
            scope: if level % 2 == 0 { ReductionScope::Both } else { ReductionScope::Peak },
            keep_dilatancy: false,
            material: Box::new(material),
        })
    })
}

#[test]
fn nested_strength_reductions_multiply_up_to_a_nesting_limit() {
    let compression = SymTensor::isotropic(-100e3);
    let strength = |material: &MaterialSpec| {
        let law = material.build().unwrap();
        let mut point = start(&*law, compression);
        for _ in 0..400 {
            step(&*law, &mut point, SymTensor::diagonal(0.5e-4, -1e-4, 0.5e-4), 0.0);
        }
        point.0.q()
    };
    let once = MaterialSpec::MohrCoulomb(mohr_coulomb())
        .strength_reduced(&StrengthReduction::by_factor(1.05f64.powi(6)))
        .unwrap();
    let (nested, direct) = (strength(&reduced(6)), strength(&once));
    assert!((nested / direct - 1.0).abs() < 1e-9, "{nested} for {direct}");
    for depth in [8, 22, 50] {
        let error = reduced(depth).build().err().expect("refused").to_string();
        assert!(error.contains("more than 8 materials are nested"), "{depth}: {error}");
    }
}

#[test]
fn invalid_parameters_of_wrapped_laws_are_refused_in_every_wrapper() {
    let wrong =
        || Box::new(MaterialSpec::MohrCoulomb(MohrCoulombSpec { density: -2000.0, ..mohr_coulomb() }));
    let shrunk = |material| {
        MaterialSpec::Eigenstrain(EigenstrainSpec { volumetric_strain: 0.0, duration: 1.0, material })
    };
    let around = [
        MaterialSpec::SaturationSoftened(SaturationSoftenedSpec {
            saturated_cohesion: 1e3,
            material: wrong(),
        }),
        MaterialSpec::StrengthReduced(StrengthReducedSpec {
            factor: 1.2,
            scope: ReductionScope::Both,
            keep_dilatancy: false,
            material: wrong(),
        }),
        shrunk(wrong()),
        shrunk(Box::new(shrunk(wrong()))),
        MaterialSpec::Undrained(UndrainedSpec {
            fluid_bulk_modulus: 1e9,
            porosity: 0.4,
            initial_pore_pressure: 0.0,
            cavitation_strength: None,
            skeleton: wrong(),
        }),
    ];
    for material in around {
        let error = material.build().err().expect("refused").to_string();
        assert!(error.contains("density: -2000 must be positive"), "{}: {error}", material.name());
    }
}
