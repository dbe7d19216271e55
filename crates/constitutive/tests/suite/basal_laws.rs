//! Basal laws of depth-averaged flow against the reference values (sheet: constitutive §2.11; sheet: depth-sph
//! §2.6, §3.5, §5.5), closed forms, and the implicit step against its own equation.

use colluvium_constitutive::basal::{
    BasalFlow, BasalRheology, BasalSpec, BinghamBaseSpec, BinghamSolution, ChezySpec, CohesionForm,
    CoulombSpec, GranularBaseSpec, LateralConfinement, ManningSpec, SkeletonSpec, ViscousFrictionalSpec,
    VoellmySpec, plug_ratio, plug_ratio_quadratic,
};
use colluvium_constitutive::laws::MuISpec;
use colluvium_constitutive::{MaterialError, MaterialSpec, MaybeInfinite};
use colluvium_testkit::{assert_digits, assert_near};
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::bad_input::assert_field;

/// Basal law of a case file.
fn law(value: Value) -> BasalRheology {
    serde_json::from_value::<BasalSpec>(value).unwrap().build().unwrap()
}

#[test]
fn bingham_base_solves_the_cubic() {
    // a, ξ; then h, v̄, μ, τ_y, τ_b, by the quadratic (its first value is 429.723192320769 in thirty digits; the
    // sheet's last digit, 429.7231922, is one too low).
    for (a, xi) in [(1.5, 0.467_090_379_2), (3.0, 0.339_876_886_6), (0.015, 0.930_974_664_2)] {
        assert_digits(plug_ratio(a), xi, 10);
    }
    assert!((plug_ratio(1200.0) - 0.001_662_510_4).abs() <= 0.5e-10);
    let table = [
        (1.0, 1.0, 50.0, 200.0, 428.182_657_8, 429.723_192_3),
        (2.0, 5.0, 100.0, 500.0, 1_471.120_925, 1_491.615_899),
    ];
    for (depth, speed, viscosity, yield_stress, exact, quadratic) in table {
        let flow = BasalFlow { depth, speed, ..BasalFlow::default() };
        for (solution, expected) in [(BinghamSolution::Exact, exact), (BinghamSolution::Quadratic, quadratic)]
        {
            let law = BasalSpec::Bingham(BinghamBaseSpec {
                solution,
                ..BinghamBaseSpec::new(yield_stress, viscosity)
            })
            .build()
            .unwrap();
            assert_digits(law.shear_stress(&flow).unwrap(), expected, 10);
        }
    }
}

#[test]
fn the_exact_root_solves_its_equation_and_the_quadratic_stays_near() {
    let (mut least, mut largest) = (0f64, 0f64);
    for i in -320..=320 {
        let a = 10f64.powf(f64::from(i) / 80.0);
        let xi = plug_ratio(a);
        assert!((xi.powi(3) - (3.0 + a) * xi + 2.0).abs() < 1e-14 * (3.0 + a), "{a}");
        let error = xi / plug_ratio_quadratic(a) - 1.0;
        (least, largest) = (least.min(error), largest.max(error));
    }
    // -2.8 % to +4.6 % over 10⁻⁴ <= a <= 10⁴, +5.2 % as a -> 0.
    assert!((least + 0.028).abs() < 5e-4 && (largest - 0.046).abs() < 5e-4, "{least} {largest}");
    assert!((1.0 / plug_ratio_quadratic(0.0) - 1.052).abs() < 5e-4);
    // Transition from the closed form to the asymptote.
    assert!((plug_ratio(1e6) / plug_ratio(1e6 * (1.0 + 1e-12)) - 1.0).abs() < 1e-11);
}

#[test]
fn bingham_base_has_its_limits() {
    let build = |yield_stress, viscosity| {
        BasalSpec::Bingham(BinghamBaseSpec::new(yield_stress, viscosity)).build().unwrap()
    };
    let flow = |speed| BasalFlow { depth: 1.5, speed, ..BasalFlow::default() };
    let slow = build(200.0, 50.0).shear_stress(&flow(1e-12)).unwrap();
    assert!((slow - 200.0).abs() < 1e-3, "{slow}");
    for yield_stress in [0.0, 1e-12] {
        let fluid = build(yield_stress, 50.0).shear_stress(&flow(2.0)).unwrap();
        assert!((fluid / (3.0 * 50.0 * 2.0 / 1.5) - 1.0).abs() < 1e-12, "{fluid}");
    }
    for spec in BasalSpec::examples() {
        let law = spec.build().unwrap();
        let mut last = 0.0;
        for i in -60..=40 {
            let now = law.shear_stress(&flow(10f64.powf(0.1 * f64::from(i)))).unwrap();
            assert!(now >= last, "{spec:?}: {last} to {now}");
            last = now;
        }
    }
}

#[test]
fn frictional_bases() {
    // s_b = 5000 Pa.
    let spec = ViscousFrictionalSpec::new(45.0, 0.8, 2.0);
    let law = BasalSpec::ViscousFrictional(spec).build().unwrap();
    let flow = BasalFlow {
        depth: 1.5,
        speed: 3.0,
        normal_stress: 7000.0,
        pore_pressure: 2000.0,
        ..BasalFlow::default()
    };
    assert_digits(law.shear_stress(&flow).unwrap(), 5020.0, 5);
    // m = 1: factor 3, m = 2: 25/4.
    for (exponent, factor) in [(1.0, 3.0), (2.0, 6.25)] {
        let spec = ViscousFrictionalSpec::new(0.0, 1.0, exponent);
        let law = BasalSpec::ViscousFrictional(spec).build().unwrap();
        let unit = BasalFlow { depth: 1.0, speed: 1.0, ..BasalFlow::default() };
        assert!((law.shear_stress(&unit).unwrap() - factor).abs() < 1e-12);
    }
    let unit_weight = 2000.0 * 9.81;
    let slope = 20f64.to_radians();
    let flow = BasalFlow {
        depth: 1.5,
        speed: 3.0,
        normal_stress: unit_weight * 1.5 * slope.cos(),
        pore_pressure: 0.0,
        slope: slope.tan(),
        unit_weight,
    };
    let voellmy = BasalSpec::Voellmy(VoellmySpec::new(15.0, 600.0.into())).build().unwrap();
    assert_digits(voellmy.shear_stress(&flow).unwrap(), 7704.476, 7);
    // At rest: the driving stress, up to the strength; zero on a dry bed.
    let coulomb = |angle| BasalSpec::Coulomb(CoulombSpec::new(angle)).build().unwrap();
    let rest = BasalFlow { speed: 0.0, ..flow };
    let driving = unit_weight * 1.5 * slope.sin();
    assert!((coulomb(30.0).shear_stress(&rest).unwrap() - driving).abs() < 1e-8);
    let strength = flow.normal_stress * 15f64.to_radians().tan();
    assert!((coulomb(15.0).shear_stress(&rest).unwrap() - strength).abs() < 1e-8);
    assert!((coulomb(15.0).shear_stress(&flow).unwrap() - strength).abs() < 1e-8);
    let floating = BasalFlow { pore_pressure: 1e6, ..flow };
    assert_eq!(coulomb(15.0).shear_stress(&floating).unwrap(), 0.0);
    assert_eq!(voellmy.shear_stress(&BasalFlow { depth: 0.0, ..flow }).unwrap(), 0.0);
    assert!(voellmy.shear_stress(&BasalFlow { speed: f64::NAN, ..flow }).is_err());
    assert!(voellmy.shear_stress(&BasalFlow { speed: -1.0, ..flow }).is_err());
}

#[test]
fn skeleton_stiffness_of_confined_columns() {
    let with = |confinement| SkeletonSpec { youngs_modulus: 20e6, poissons_ratio: 0.3, confinement };
    let bulk = with(LateralConfinement::Isotropic {}).stiffness().unwrap();
    assert_digits(bulk, 16.666_666_7e6, 9);
    // Without lateral strain: the oedometric modulus E (1 - ν)/((1 + ν)(1 - 2ν)).
    let oedometric = 20e6 * 0.7 / (1.3 * 0.4);
    assert!((with(LateralConfinement::default()).stiffness().unwrap() / oedometric - 1.0).abs() < 1e-14);
    let given = LateralConfinement::OneDimensional { k0: Some(0.5) };
    assert!((with(given).stiffness().unwrap() / bulk - 1.5).abs() < 1e-15);
    assert!((with(LateralConfinement::SourceK0 { k0: 0.5 }).stiffness().unwrap() / bulk - 2.0).abs() < 1e-15);
    assert!(
        (with(LateralConfinement::Value { alpha: 0.8 }).stiffness().unwrap() / bulk - 1.25).abs() < 1e-15
    );
    assert_field(with(LateralConfinement::Value { alpha: 0.0 }).stiffness(), "confinement.alpha");
    assert_field(with(LateralConfinement::SourceK0 { k0: 0.0 }).stiffness(), "confinement.k0");
    assert_field(with(LateralConfinement::OneDimensional { k0: Some(-0.1) }).stiffness(), "confinement.k0");
}

#[test]
fn the_table_of_bingham_is_the_printed_one() {
    let table = [
        (0.001, 1.018_481, 1.053_136),
        (0.01, 1.060_011, 1.066_082),
        (0.1, 1.206_521, 1.174_137),
        (0.5, 1.538_859, 1.511_408),
        (2.0, 2.414_214, 2.435_219),
        (10.0, 6.488_122, 6.564_429),
        (1000.0, 501.499_998, 494.060_044),
    ];
    for (a, exact, quadratic) in table {
        assert_near(1.0 / plug_ratio(a), exact, 0.6e-6);
        assert_near(1.0 / plug_ratio_quadratic(a), quadratic, 0.6e-6);
    }
    assert_near(plug_ratio(2.0), 2f64.sqrt() - 1.0, 1e-15);
    let rest = BinghamBaseSpec { solution: BinghamSolution::Quadratic, ..BinghamBaseSpec::new(1000.0, 50.0) };
    let rest = BasalSpec::Bingham(rest).build().unwrap().static_shear_strength(&BasalFlow::default());
    assert_near(rest, 1051.659, 5e-4);
}

/// V22: steady speeds of a layer of 1 m and 2000 kg/m³ on 15°.
#[test]
fn steady_flow_down_a_slope_has_the_printed_speed() {
    let slope = 15f64.to_radians();
    let unit_weight = 2000.0 * 9.81;
    let driving = unit_weight * slope.sin();
    let viscous = |exponent: f64, consistency: f64| json!({ "model": "viscous-frictional", "friction_angle": 10.0, "consistency": consistency, "exponent": exponent });
    for (spec, speed) in [
        (json!({ "model": "bingham", "yield_stress": 2000.0, "viscosity": 100.0 }), 7.443_834),
        (json!({ "model": "voellmy", "friction_angle": 10.0, "turbulence": 400.0 }), 5.949_799),
        (viscous(1.0, 500.0), 1.157_583),
        (viscous(2.0, 50.0), 2.357_202),
        (viscous(0.5, 2000.0), 0.188_437),
    ] {
        let flow = BasalFlow {
            depth: 1.0,
            speed,
            normal_stress: unit_weight * slope.cos(),
            unit_weight,
            ..BasalFlow::default()
        };
        let found = law(spec.clone()).shear_stress(&flow).unwrap();
        assert!((found / driving - 1.0).abs() < 1e-6, "{spec}: {found} for {driving}");
    }
    let quadratic = law(json!({
        "model": "bingham", "yield_stress": 2000.0, "viscosity": 100.0, "solution": "quadratic"
    }));
    let flow = BasalFlow { depth: 1.0, speed: 7.443_834, ..BasalFlow::default() };
    assert_near(quadratic.shear_stress(&flow).unwrap(), 5130.775, 5e-3);
}

#[test]
fn cohesion_and_pore_pressure_enter_the_strength() {
    let flow = BasalFlow { depth: 1.0, speed: 1.0, normal_stress: 2000.0, ..BasalFlow::default() };
    let tan = 20f64.to_radians().tan();
    let coulomb = CoulombSpec { cohesion: 300.0, pore_pressure_ratio: 0.5, ..CoulombSpec::new(20.0) };
    assert_near(
        BasalSpec::Coulomb(coulomb).build().unwrap().moving_shear_stress(&flow),
        1000.0 * tan + 300.0,
        1e-10,
    );
    // Both water pressures count; the strength is never that of tension.
    let wet = BasalFlow { pore_pressure: 900.0, ..flow };
    let ratio = json!({ "model": "coulomb", "friction_angle": 20.0, "pore_pressure_ratio": 0.5 });
    assert_near(law(ratio.clone()).moving_shear_stress(&wet), 100.0 * tan, 1e-10);
    assert_eq!(law(ratio).moving_shear_stress(&BasalFlow { pore_pressure: 1100.0, ..flow }), 0.0);
    // tan φ = 0.2, c = 500 Pa under 1000 Pa: 200 + 0.8 · 500 (1 - e⁻²).
    let angle = 0.2f64.atan().to_degrees();
    let spec = json!({
        "model": "voellmy", "friction_angle": angle, "turbulence": "none", "cohesion": 500.0, "cohesion_form": "ramms"
    });
    let ramms = law(spec);
    let under = |normal_stress| BasalFlow { normal_stress, ..flow };
    assert_near(ramms.moving_shear_stress(&under(1000.0)), 545.865_886_705, 1e-8);
    assert_eq!(ramms.moving_shear_stress(&under(0.0)), 0.0);
    assert_near(ramms.moving_shear_stress(&under(1e-3)) / 1e-3, 1.0, 1e-6);
    assert_near(ramms.moving_shear_stress(&under(1e6)), 200_400.0, 1e-6);
    // Where friction vanishes, cohesion does not.
    let smooth = law(json!({ "model": "coulomb", "friction_angle": 20.0, "cohesion": 300.0 }));
    assert_near(smooth.with_max_friction(0.1).moving_shear_stress(&flow), 500.0, 1e-10);
    assert_near(
        smooth.with_max_friction(0.5).moving_shear_stress(&flow),
        smooth.moving_shear_stress(&flow),
        0.0,
    );
}

#[test]
fn turbulence_by_manning_and_chezy() {
    let flow = BasalFlow { depth: 8.0, speed: 3.0, unit_weight: 9810.0, ..BasalFlow::default() };
    let manning = BasalSpec::Manning(ManningSpec::new(0.0, 0.05)).build().unwrap();
    assert_near(manning.moving_shear_stress(&flow), 9810.0 * 0.0025 * 9.0 / 2.0, 1e-10);
    let chezy = BasalSpec::Chezy(ChezySpec::new(0.0, 20.0)).build().unwrap();
    let voellmy = BasalSpec::Voellmy(VoellmySpec::new(0.0, 400.0.into())).build().unwrap();
    assert_eq!(chezy.moving_shear_stress(&flow), voellmy.moving_shear_stress(&flow));
    let none = BasalSpec::Voellmy(VoellmySpec::new(0.0, MaybeInfinite::INFINITE)).build().unwrap();
    assert_eq!(none.moving_shear_stress(&flow), 0.0);
}

/// Mean of Bagnold's profile, by Simpson's rule, under the friction of its inertial number.
#[test]
fn granular_base_belongs_to_bagnolds_profile() {
    let (inertial, diameter, grain_density, depth, stress) = (0.2, 0.02, 2500.0, 1.5f64, 18_000.0f64);
    let rate = |below: f64| inertial * (stress * below / depth / grain_density).sqrt() / diameter;
    let count = 20_000;
    // Mean speed = ∫ γ̇(s) s ds / h over the depth s below the surface, in s = h x² so that the root is smooth.
    let integrand = |x: f64| rate(depth * x * x) * depth * x * x * 2.0 * depth * x / depth;
    let weight = |i: usize| if i == 0 || i == count { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
    let sum: f64 = (0..=count).map(|i| weight(i) * integrand(i as f64 / count as f64)).sum();
    let speed = sum / (3.0 * count as f64);
    let spec = GranularBaseSpec::new(0.38, 0.64, 0.279, diameter, grain_density);
    let law = BasalSpec::Granular(spec).build().unwrap();
    let flow = BasalFlow { depth, speed, normal_stress: stress, ..BasalFlow::default() };
    let friction = 0.38 + 0.26 / (0.279 / inertial + 1.0);
    assert!((law.moving_shear_stress(&flow) / (friction * stress) - 1.0).abs() < 1e-9);
    assert_eq!(law.moving_shear_stress(&BasalFlow { normal_stress: 0.0, ..flow }), 0.0);
}

#[test]
fn a_bed_without_a_law_has_no_strength() {
    let flow =
        BasalFlow { depth: 1.0, speed: 2.0, normal_stress: 1e4, unit_weight: 1e4, ..BasalFlow::default() };
    for spec in [
        json!({ "model": "none" }),
        json!({ "model": "bingham", "yield_stress": 0.0, "viscosity": 0.0 }),
        json!({ "model": "voellmy", "friction_angle": 0.0, "turbulence": "none" }),
    ] {
        let law = law(spec);
        assert_eq!(
            (
                law.moving_shear_stress(&flow),
                law.static_shear_strength(&flow),
                law.speed_after_step(&flow, 1e-3)
            ),
            (0.0, 0.0, 2.0)
        );
    }
    let plastic = law(json!({ "model": "bingham", "yield_stress": 500.0, "viscosity": 0.0 }));
    assert_near(plastic.moving_shear_stress(&flow), 500.0, 0.0);
    assert_near(plastic.speed_after_step(&flow, 1e-3), 1.5, 1e-15);
}

proptest! {
    /// Implicit step of any law: the new speed solves its equation, and the flow stops exactly where its strength can
    /// stop it.
    #[test]
    fn the_implicit_step_solves_its_equation(
        which in 0..BasalSpec::examples().len(),
        depth in 0.01..20.0f64,
        speed in -6.0..1.5f64,
        stress in 0.0..1e5f64,
        impulse in -8.0..0.0f64,
    ) {
        let law = BasalSpec::examples()[which].build().unwrap();
        let (speed, impulse) = (10f64.powf(speed), 10f64.powf(impulse));
        let flow = BasalFlow { depth, speed, normal_stress: stress, unit_weight: 2e4, ..BasalFlow::default() };
        let next = law.speed_after_step(&flow, impulse);
        let held = speed - impulse * law.static_shear_strength(&flow);
        if held <= 0.0 {
            prop_assert_eq!(next, 0.0);
        } else {
            prop_assert!((0.0..=speed).contains(&next));
            let residual = |v: f64| v - speed + impulse * law.moving_shear_stress(&BasalFlow { speed: v, ..flow });
            // The root lies within round-off of the result. A shear stress with an infinite slope at rest makes
            // the residual itself a poor measure.
            let reach = 1e-12 * next + 1e-14 * speed;
            prop_assert!(residual(next + reach) >= -1e-12 * speed, "{} {}", next, residual(next));
            prop_assert!(next <= reach || residual(next - reach) <= 1e-12 * speed, "{} {}", next, residual(next));
        }
        // Strength and drag in sequence are equivalent for laws in which they are a sum.
        if law.is_additive() && held > 0.0 {
            prop_assert_eq!(law.speed_after_drag(&BasalFlow { speed: held, ..flow }, impulse), next);
        }
    }
}

/// Basal law of a material of the other methods.
fn basal_of(material: Value) -> Result<BasalRheology, MaterialError> {
    serde_json::from_value::<MaterialSpec>(material).unwrap().basal()
}

/// Material with the keys `own` besides density and elastic constants.
fn elastic_with(own: &Value) -> Value {
    let mut all = json!({ "density": 2000.0, "youngs_modulus": 20e6, "poissons_ratio": 0.3 });
    all.as_object_mut().unwrap().extend(own.as_object().unwrap().clone());
    all
}

#[test]
fn materials_of_the_other_methods_have_their_basal_law() {
    let flow = BasalFlow { depth: 2.0, speed: 1.0, normal_stress: 1e4, ..BasalFlow::default() };
    let tan = 30f64.to_radians().tan();
    let soil = elastic_with(&json!({ "model": "mohr-coulomb", "friction_angle": 30.0, "cohesion": 500.0 }));
    let dp = elastic_with(&json!({ "model": "drucker-prager", "friction_angle": 30.0, "cohesion": 500.0 }));
    for soil in [&soil, &dp] {
        assert_near(basal_of(soil.clone()).unwrap().moving_shear_stress(&flow), 1e4 * tan + 500.0, 1e-9);
    }
    let reduced = basal_of(json!({ "model": "strength-reduced", "factor": 2.0, "material": soil })).unwrap();
    assert_near(reduced.moving_shear_stress(&flow), 0.5 * (1e4 * tan + 500.0), 1e-9);
    let clay = basal_of(elastic_with(&json!({ "model": "von-mises", "cohesion": 700.0 }))).unwrap();
    assert_near(clay.moving_shear_stress(&flow), 700.0, 0.0);
    let clay = basal_of(elastic_with(&json!({ "model": "tresca", "undrained_strength": 700.0 }))).unwrap();
    assert_near(clay.moving_shear_stress(&flow), 700.0, 0.0);
    let liquid = json!({ "density": 1000.0, "bulk_modulus": 1e7, "viscosity": 50.0 });
    let fluid = |own: Value| {
        let mut all = liquid.as_object().unwrap().clone();
        all.extend(own.as_object().unwrap().clone());
        basal_of(Value::Object(all)).unwrap().moving_shear_stress(&flow)
    };
    assert_near(fluid(json!({ "model": "newtonian-fluid" })), 3.0 * 50.0 / 2.0, 1e-10);
    let mud = BasalSpec::Bingham(BinghamBaseSpec::new(200.0, 50.0)).build().unwrap();
    assert_near(
        fluid(json!({ "model": "bingham", "yield_stress": 200.0 })),
        mud.moving_shear_stress(&flow),
        0.0,
    );
    let debris = fluid(json!({ "model": "frictional-fluid", "friction_angle": 30.0, "cohesion": 100.0 }));
    let strength = 0.5 * 1e4 + 100.0 * 30f64.to_radians().cos();
    let same = BasalSpec::Bingham(BinghamBaseSpec::new(strength, 50.0)).build().unwrap();
    assert_near(debris, same.moving_shear_stress(&flow), 1e-8);
    let sand = MaterialSpec::examples().into_iter().find_map(|spec| match spec {
        MaterialSpec::MuI(spec) => Some(spec),
        _ => None,
    });
    let MuISpec { static_friction, .. } = sand.clone().unwrap();
    assert_near(
        MaterialSpec::MuI(sand.unwrap()).basal().unwrap().static_shear_strength(&flow),
        static_friction * 1e4,
        1e-9,
    );
}

#[test]
fn materials_without_a_basal_law_are_refused_by_name() {
    let soil = elastic_with(&json!({ "model": "mohr-coulomb", "friction_angle": 30.0, "cohesion": 500.0 }));
    let softening = json!({ "residual_friction_angle": 20.0, "friction_rate": 1.0 });
    let mut softens = soil;
    softens["softening"] = softening;
    softens["softening"]["residual_cohesion"] = json!(100.0);
    softens["softening"]["cohesion_rate"] = json!(1.0);
    for (spec, field) in
        [(softens, "softening: "), (elastic_with(&json!({ "model": "linear-elastic" })), "model: ")]
    {
        let error = basal_of(spec).unwrap_err().to_string();
        assert!(error.starts_with(field) && error.contains("basal law of its own"), "{error}");
    }
    let wrong = elastic_with(&json!({ "model": "mohr-coulomb", "friction_angle": 95.0 }));
    assert!(basal_of(wrong).unwrap_err().to_string().starts_with("friction_angle: 95"));
}

#[test]
fn parameters_out_of_range_are_named() {
    for (spec, field) in [
        (json!({ "model": "bingham", "yield_stress": -1.0, "viscosity": 50.0 }), "yield_stress: -1"),
        (json!({ "model": "bingham", "yield_stress": 1.0, "viscosity": -1.0 }), "viscosity: -1"),
        (
            json!({ "model": "bingham", "yield_stress": 1.0, "viscosity": 1.0, "friction_angle": 90.0 }),
            "friction_angle: 90",
        ),
        (
            json!({ "model": "viscous-frictional", "friction_angle": 90.0, "consistency": 0.8, "exponent": 2.0 }),
            "friction_angle: 90",
        ),
        (
            json!({ "model": "viscous-frictional", "friction_angle": 9.0, "consistency": -0.8, "exponent": 2.0 }),
            "consistency: -0.8",
        ),
        (
            json!({ "model": "viscous-frictional", "friction_angle": 9.0, "consistency": 0.8, "exponent": 0.0 }),
            "exponent: 0",
        ),
        (json!({ "model": "voellmy", "friction_angle": 15.0, "turbulence": 0.0 }), "turbulence: 0"),
        (json!({ "model": "coulomb", "friction_angle": -1.0 }), "friction_angle: -1"),
        (json!({ "model": "coulomb", "friction_angle": 9.0, "cohesion": -1.0 }), "cohesion: -1"),
        (
            json!({ "model": "coulomb", "friction_angle": 9.0, "pore_pressure_ratio": 1.5 }),
            "pore_pressure_ratio: 1.5",
        ),
        (json!({ "model": "coulomb", "friction_angle": 46.0, "cohesion_form": "ramms" }), "cohesion_form: "),
        (json!({ "model": "manning", "friction_angle": 9.0, "roughness": -1.0 }), "roughness: -1"),
        (json!({ "model": "chezy", "friction_angle": 9.0, "coefficient": 0.0 }), "coefficient: 0"),
        (
            json!({
                "model": "mu-i", "static_friction": 0.4, "limit_friction": 0.3, "reference_inertial_number": 0.3,
                "grain_diameter": 0.01, "grain_density": 2500.0
            }),
            "limit_friction: 0.3",
        ),
    ] {
        let error = serde_json::from_value::<BasalSpec>(spec).unwrap().build().unwrap_err().to_string();
        assert!(error.starts_with(field), "{error}");
    }
    for (spec, words) in [
        (json!({ "model": "voellmy", "friction_angle": 15.0, "turbulence": "many" }), "a number or \"none\""),
        (
            json!({ "model": "voellmy", "friction_angle": 15.0, "turbulence": 1.0, "xi": 2.0 }),
            "unknown field `xi`",
        ),
        (json!({ "model": "none", "friction_angle": 15.0 }), "unknown field `friction_angle`"),
    ] {
        let error = serde_json::from_value::<BasalSpec>(spec).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    let steep = BasalSpec::Coulomb(CoulombSpec::new(60.0)).warnings();
    assert!(steep[0].text.starts_with("friction_angle: 60"), "{steep:?}");
    assert_eq!(CohesionForm::default(), CohesionForm::Constant);
}
