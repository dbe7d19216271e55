//! Reference values of the flow laws (sheet: constitutive §2.8–2.10, §3.7.9, §7), computed there with
//! independent scripts, and properties beyond the contract.

use colluvium_constitutive::laws::bingham::{Capped, YieldStress};
use colluvium_constitutive::laws::granular_flow::{
    BagnoldRegime, FlowRegime, bagnold_number, inertial_number, krieger_dougherty, linear_concentration,
    savage_number, solid_fraction,
};
use colluvium_constitutive::laws::mu_i::RegularisedMuI;
use colluvium_constitutive::laws::viscous_flow::{EffectiveViscosity, FlowCurve, Viscoplastic};
use colluvium_constitutive::laws::{
    Barotropic, BinghamSpec, CfdSoilSpec, EquationOfState, FluidState, FrictionalFluidSpec, MuIForm, MuISpec,
    NewtonianFluidSpec, ShearNorm, YieldForm,
};
use colluvium_constitutive::{
    Corotational, InitialCondition, Law, Mat3, MaterialError, MaterialSpec, Motion, Point, PointLaw,
    SmallStrain, StressUpdate, SymTensor,
};
use colluvium_testkit::assert_digits;

use crate::bad_input::assert_field;

/// Parameter set of §2.9.
fn sand() -> MuISpec {
    MuISpec {
        density: 1500.0,
        bulk_modulus: 2e6,
        shear_modulus: Some(1e6),
        grain_density: 2450.0,
        grain_diameter: 0.53e-3,
        static_friction: 0.38,
        limit_friction: 0.64,
        reference_inertial_number: 0.279,
        form: MuIForm::default(),
    }
}

fn mud() -> BinghamSpec {
    BinghamSpec {
        density: 1000.0,
        bulk_modulus: 1e6,
        shear_modulus: Some(1e6),
        yield_stress: 20.0,
        viscosity: 50.0,
        cavitation_strength: 0.0,
        equation_of_state: EquationOfState::Linear,
        form: YieldForm::default(),
    }
}

fn debris() -> FrictionalFluidSpec {
    FrictionalFluidSpec {
        density: 2000.0,
        bulk_modulus: 1e7,
        shear_modulus: None,
        friction_angle: 30.0,
        cohesion: 0.0,
        viscosity: 0.0,
        cavitation_strength: 0.0,
        equation_of_state: EquationOfState::Linear,
        form: YieldForm::default(),
    }
}

fn soil(cohesion: f64, norm: ShearNorm) -> CfdSoilSpec {
    CfdSoilSpec {
        density: 2000.0,
        youngs_modulus: 20e6,
        poissons_ratio: 0.3,
        friction_angle: 30.0,
        cohesion,
        norm,
    }
}

fn still(dt: f64, density: f64) -> Motion {
    Motion { dt, ..Motion::from_deformation(&Mat3::IDENTITY, dt, density, 1.0).unwrap() }
}

/// Return of a trial in simple shear at `pressure`: a step without strain, with the
/// density of that pressure.
fn returned<R: FlowCurve>(law: &Viscoplastic<R>, trial: f64, pressure: f64, dt: f64) -> Point<FluidState> {
    let density = 1000.0 * law.pressure.ratio_of(pressure);
    let state = FluidState { rest_density: 1000.0, density, shear_rate: 0.0 };
    let stress = SymTensor([-pressure, -pressure, -pressure, trial, 0.0, 0.0]);
    law.update(&SymTensor::ZERO, &still(dt, density), &Point { stress, state }).unwrap()
}

#[test]
fn friction_and_viscosity_of_sand() {
    // p, γ̇, I, μ, η
    let table = [
        (100.0, 1.0, 0.002_623_366_2, 0.382_421_941_1, 38.242_194_11),
        (1000.0, 10.0, 0.008_295_812_2, 0.387_507_631_8, 38.750_763_18),
        (1000.0, 100.0, 0.082_958_122_0, 0.439_590_075_2, 4.395_900_752),
        (50.0, 200.0, 0.742, 0.568_952_007_8, 0.142_238_002),
    ];
    let law = sand().rheology().unwrap();
    let form = MuIForm::Capped { max_viscosity: 1e9, min_shear_rate: 1e-7 };
    let viscous = RegularisedMuI { law, form };
    for (pressure, rate, number, friction, viscosity) in table {
        let found = law.inertial_number(rate, pressure);
        // Ten decimals.
        assert!((found - number).abs() <= 0.5e-10 * (1.0 + 1e-9), "{found} for {number}");
        assert_digits(law.friction(found), friction, 10);
        let digits_of_viscosity = if viscosity < 1.0 { 9 } else { 10 };
        assert_digits(viscous.viscosity(rate, pressure), viscosity, digits_of_viscosity);
        assert_digits(law.strength(rate, pressure), friction * pressure, 9);
    }
}

#[test]
fn regularisations_agree_in_fast_flow_and_stay_finite_at_rest() {
    let law = sand().rheology().unwrap();
    let with = |form| RegularisedMuI { law, form };
    let capped = with(MuIForm::Capped { max_viscosity: 1e4, min_shear_rate: 1e-7 });
    let smoothed = with(MuIForm::Smoothed { shear_rate: 1e-3 });
    let papanastasiou = with(MuIForm::Papanastasiou { time: 100.0 });
    let exact = law.strength(50.0, 1000.0) / 50.0;
    for viscosity in [capped.viscosity(50.0, 1000.0), papanastasiou.viscosity(50.0, 1000.0)] {
        assert!((viscosity / exact - 1.0).abs() < 1e-14);
    }
    assert!((smoothed.viscosity(50.0, 1000.0) / exact - 1.0).abs() < 1e-9);
    assert_eq!(capped.viscosity(0.0, 1000.0), 1e4);
    assert!((smoothed.viscosity(0.0, 1000.0) - 380.0 / 1e-3).abs() < 1e-6);
    // Slope of the yielding part, m μ_s p, and that of μ(I) p at rest.
    let slope = 0.26 * 1000.0 * law.inertial_number(1.0, 1000.0) / 0.279;
    assert!((papanastasiou.viscosity(0.0, 1000.0) - 38_000.0 - slope).abs() < 1e-9);
    let near = papanastasiou.viscosity(1e-9, 1000.0);
    assert!((near / papanastasiou.viscosity(0.0, 1000.0) - 1.0).abs() < 1e-6);
    for law in [capped, smoothed, papanastasiou] {
        assert_eq!(law.viscosity(1.0, 0.0), 0.0);
        assert_eq!(law.viscosity(1.0, -1.0), 0.0);
    }
}

/// Default floor of the shear rate, 10⁻⁷ 1/s of the source: points at rest have the viscosity at that rate.
#[test]
fn a_viscous_form_starts_from_rest_with_the_floor_of_the_source() {
    let form: MuIForm =
        serde_json::from_value(serde_json::json!({ "kind": "capped", "max_viscosity": 1e12 })).unwrap();
    let law = RegularisedMuI { law: sand().rheology().unwrap(), form };
    let at_rest = law.viscosity(0.0, 1000.0);
    assert_digits(at_rest, law.law.strength(1e-7, 1000.0) / 1e-7, 14);
    assert!((at_rest * 1e-7 / 380.0 - 1.0).abs() < 1e-6, "{at_rest}");
    assert_eq!((law.viscosity(1e-8, 1000.0), law.viscosity(1e-7, 1000.0)), (at_rest, at_rest));
    assert!(law.viscosity(2e-7, 1000.0) < 0.51 * at_rest);
}

#[test]
fn sand_relaxes_to_the_friction_of_its_plastic_rate() {
    // Δt, trial, τ, γ̇ᵖ at p = 1000 Pa, G = 1 MPa.
    let table = [
        (1e-4, 600.0, 381.676_939_9, 2.183_230_601),
        (1e-4, 1000.0, 384.671_549_1, 6.153_284_509),
        (1e-5, 1000.0, 418.337_087_6, 58.166_291_24),
        (1e-3, 1000.0, 380.478_063_4, 0.619_521_936_6),
    ];
    let law = sand().viscoplastic().unwrap();
    for (dt, trial, shear, rate) in table {
        assert_digits(law.rheology.return_shear_stress(trial, 1000.0, 1e6 * dt), shear, 10);
        let new = returned(&law, trial, 1000.0, dt);
        assert_digits(new.stress[3], shear, 10);
        assert_digits(new.state.shear_rate, rate, 10);
        let friction = law.rheology.friction(law.rheology.inertial_number(new.state.shear_rate, 1000.0));
        assert!((new.stress[3] - friction * 1000.0).abs() < 1e-9);
        assert!((new.stress.pressure() - 1000.0).abs() < 1e-8);
    }
    // Below the static yield stress it is elastic: it rests.
    assert_eq!(returned(&law, 379.9, 1000.0, 1e-4).stress[3], 379.9);
    // With equal coefficients it is perfectly plastic.
    let plastic = MuISpec { limit_friction: 0.38, ..sand() }.viscoplastic().unwrap();
    assert!((returned(&plastic, 1000.0, 1000.0, 1e-4).stress[3] - 380.0).abs() < 1e-10);
}

#[test]
fn bingham_relaxes_with_its_viscosity() {
    // ζ = GΔt/μ = 2.
    let law = mud().viscoplastic().unwrap();
    assert_digits(returned(&law, 30.0, 1000.0, 1e-4).stress[3], 23.333_333, 8);
    let plastic = BinghamSpec { viscosity: 0.0, ..mud() }.viscoplastic().unwrap();
    assert!((returned(&plastic, 30.0, 1000.0, 1e-4).stress[3] - 20.0).abs() < 1e-12);
    assert_eq!(returned(&law, 19.0, 1000.0, 1e-4).stress[3], 19.0);
}

/// Shear stress (Pa) of steady simple shear at `rate` (1/s) and `pressure` (Pa).
fn steady_shear<L: StressUpdate>(law: &L, rate: f64, pressure: f64, dt: f64, steps: usize) -> f64 {
    let start = InitialCondition { stress: SymTensor::isotropic(-pressure), density: 1500.0 };
    let mut point = law.initial(&start).unwrap();
    let l = Mat3([[0.0, rate, 0.0], [0.0; 3], [0.0; 3]]);
    let motion = Motion::from_velocity_gradient(&l, dt, 1500.0, 1.0).unwrap();
    for _ in 0..steps {
        point = law.update(&motion, &point).unwrap();
    }
    point.stress.j2().sqrt()
}

#[test]
fn steady_flow_follows_the_flow_curve() {
    // The elastic shear strain is of the order p/G = 10⁻³, its square is the error of the rotating frame.
    let law = Corotational(sand().viscoplastic().unwrap());
    for (rate, friction) in [(10.0, 0.387_507_631_8), (100.0, 0.439_590_075_2)] {
        let found = steady_shear(&law, rate, 1000.0, 1e-5, 2000) / 1000.0;
        assert!((found / friction - 1.0).abs() < 1e-6, "{found} for {friction}");
    }
    let law = Corotational(mud().viscoplastic().unwrap());
    let found = steady_shear(&law, 10.0, 1000.0, 1e-4, 200);
    assert!((found / 520.0 - 1.0).abs() < 1e-6, "{found}");
}

/// Flow at the start continues with the stress of its rate; a stress above that of any rate is rejected.
#[test]
fn a_run_may_start_from_steady_flow() {
    fn keeps_steady_flow<R: FlowCurve>(law: Viscoplastic<R>, rate: f64, density: f64) {
        let pressure = 1000.0;
        let shear = law.rheology.strength(rate, pressure);
        let density = density * (1.0 + pressure / law.pressure.bulk_modulus);
        let stress = SymTensor([-pressure, -pressure, -pressure, shear, 0.0, 0.0]);
        let law = Corotational(law);
        let mut point = law.initial(&InitialCondition { stress, density }).unwrap();
        let l = Mat3([[0.0, rate, 0.0], [0.0; 3], [0.0; 3]]);
        let motion = Motion::from_velocity_gradient(&l, 1e-6, density, 1.0).unwrap();
        for _ in 0..10 {
            point = law.update(&motion, &point).unwrap();
        }
        assert!((point.stress[3] / shear - 1.0).abs() < 1e-3, "{} for {shear}", point.stress[3]);
    }
    keeps_steady_flow(sand().viscoplastic().unwrap(), 20.0, sand().density);
    keeps_steady_flow(mud().viscoplastic().unwrap(), 2.0, mud().density);
    let law = sand().viscoplastic().unwrap();
    let start = |shear: f64| {
        let stress = SymTensor([-1000.0, -1000.0, -1000.0, shear, 0.0, 0.0]);
        law.initial(&InitialCondition { stress, density: 1500.0 })
    };
    assert!(start(0.999 * sand().limit_friction * 1000.0).is_ok());
    let error = start(1.001 * sand().limit_friction * 1000.0).unwrap_err().to_string();
    assert!(error.contains("outside the yield surface"), "{error}");
}

#[test]
fn capped_bingham_has_both_branches() {
    let law = Capped { law: mud().rheology().unwrap(), max_viscosity: 500.0 };
    // √J2 = τ_y + μ γ̇ above the cap's rate, 20/450 1/s.
    assert!((law.viscosity(2.0, 0.0) * 2.0 - 120.0).abs() < 1e-12);
    assert_eq!(law.viscosity(0.01, 0.0), 500.0);
    assert_eq!(law.viscosity(0.0, 0.0), 500.0);
    let no_yield = BinghamSpec { yield_stress: 0.0, ..mud() }.rheology().unwrap();
    let no_yield = Capped { law: no_yield, max_viscosity: 500.0 };
    assert_eq!(no_yield.viscosity(0.0, 0.0), 50.0);
}

#[test]
fn frictional_fluid_yields_with_pressure() {
    let law = FrictionalFluidSpec { cohesion: 100.0, ..debris() }.rheology().unwrap();
    assert!((law.yield_stress(1000.0) - 500.0 - 100.0 * 30f64.to_radians().cos()).abs() < 1e-10);
    assert_eq!(debris().rheology().unwrap().yield_stress(-1.0), 0.0);
    // At rest it carries shear up to the static limit indefinitely, and no more from the start.
    let law = Corotational(debris().viscoplastic().unwrap());
    let start = |shear: f64| InitialCondition {
        stress: SymTensor([-1e3, -1e3, -1e3, shear, 0.0, 0.0]),
        density: 2000.0,
    };
    let mut point = law.initial(&start(499.0)).unwrap();
    for _ in 0..1000 {
        point = law.update(&still(1e-3, 2000.0), &point).unwrap();
    }
    assert_eq!(point.stress[3], 499.0);
    assert!(matches!(law.initial(&start(501.0)), Err(MaterialError::Initial { .. })));
}

#[test]
fn a_liquid_cavitates_at_its_threshold_density() {
    // ρ_thres = ρ₀ (1 - p_thres/K)
    let pressure = Barotropic { bulk_modulus: 2e7, tension: 1e4, equation: EquationOfState::Linear };
    let threshold = 1.0 - 1e4 / 2e7;
    assert!((pressure.pressure(threshold * (1.0 + 1e-9)).unwrap() + 1e4).abs() < 0.1);
    assert_eq!(pressure.pressure(threshold * (1.0 - 1e-9)), None);
    // Energy is continuous there, and tension continues to do work as the cavity grows.
    let (above, below) =
        (pressure.energy(threshold * (1.0 + 1e-12)), pressure.energy(threshold * (1.0 - 1e-12)));
    assert!((above - below).abs() < 1e-5);
    assert!(pressure.energy(0.9) > below);
    let law = BinghamSpec { cavitation_strength: 1e4, bulk_modulus: 2e7, ..mud() }.viscoplastic().unwrap();
    let state = FluidState { rest_density: 1000.0, density: 1000.0, shear_rate: 0.0 };
    let old = Point { stress: SymTensor([0.0, 0.0, 0.0, 10.0, 0.0, 0.0]), state };
    let open = law.update(&SymTensor::ZERO, &still(1e-3, 990.0), &old).unwrap();
    assert_eq!(open.stress, SymTensor::isotropic(1e4));
    let closed = law.update(&SymTensor::ZERO, &still(1e-3, 1001.0), &open).unwrap();
    assert!((closed.stress.pressure() - 2e4).abs() < 1e-6);
}

#[test]
fn sand_without_pressure_has_no_stress_and_remembers_the_gap() {
    let forms = [
        MuIForm::ElastoViscoplastic {},
        MuIForm::Capped { max_viscosity: 1e3, min_shear_rate: 1e-7 },
        MuIForm::Smoothed { shear_rate: 1e-3 },
        MuIForm::Papanastasiou { time: 10.0 },
    ];
    for form in forms {
        let law = MaterialSpec::MuI(MuISpec { form, shear_modulus: None, ..sand() }).build().unwrap();
        let start = InitialCondition { stress: SymTensor::isotropic(-1e3), density: 1500.0 };
        let (mut stress, mut states) = law.initial(&[start]).unwrap();
        let mut step = |stretch: f64, density: f64| {
            let l = Mat3([[stretch, 1.0, 0.0], [0.0; 3], [0.0; 3]]);
            let mut motion = Motion::from_velocity_gradient(&l, 1e-2, density, 1.0).unwrap();
            motion.density = density;
            law.update(&[motion], &mut stress, &mut states.blocks_mut()[0]).unwrap();
            stress[0]
        };
        assert_eq!(step(1.0, 1485.0), SymTensor::ZERO);
        // Denser again, but not yet closed.
        assert_eq!(step(-0.5, 1490.0), SymTensor::ZERO);
        assert!(step(-1.0, 1500.0).pressure() > 0.0);
    }
}

#[test]
fn cfd_soil_is_scaled_back_to_its_strength() {
    // c + p tan φ at p = 50 kPa.
    let strength = 10e3 + 50e3 * 30f64.to_radians().tan();
    let law = soil(10e3, ShearNorm::SqrtJ2).law().unwrap();
    assert!((returned(&law, 60e3, 50e3, 1.0).stress[3] - strength).abs() < 1e-8);
    let law = soil(10e3, ShearNorm::VonMisesQ).law().unwrap();
    let new = returned(&law, 60e3, 50e3, 1.0);
    assert!((new.stress.q() - strength).abs() < 1e-8);
    // Without cohesion there is no tension, with it up to the apex c cot φ = 17.32 kPa.
    for (cohesion, tension) in [(0.0, 0.0), (10e3, 17_320.508_075_688_77)] {
        let law = soil(cohesion, ShearNorm::SqrtJ2).law().unwrap();
        let state = FluidState { rest_density: 2000.0, density: 2000.0, shear_rate: 0.0 };
        let old = Point { stress: SymTensor::ZERO, state };
        let open = law.update(&SymTensor::isotropic(0.01), &still(1.0, 1940.0), &old).unwrap();
        assert!((open.stress - SymTensor::isotropic(tension)).norm() < 1e-9);
    }
}

#[test]
fn numbers_and_regimes_of_granular_flow() {
    let concentration = linear_concentration(0.55, 0.74);
    assert_digits(concentration, 9.618_377_394, 10);
    let bagnold = bagnold_number(50.0, 1.3e-3, 2650.0, concentration, 1e-3);
    assert_digits(bagnold, 694.47, 5);
    assert_eq!(BagnoldRegime::at_bagnold_number(bagnold), BagnoldRegime::GrainInertia);
    assert_eq!(BagnoldRegime::at_bagnold_number(39.0), BagnoldRegime::MacroViscous);
    assert_eq!(BagnoldRegime::at_bagnold_number(100.0), BagnoldRegime::Transitional);
    let number = inertial_number(10.0, 0.53e-3, 1000.0, 2450.0);
    assert!((savage_number(10.0, 0.53e-3, 1000.0, 2450.0).sqrt() / number - 1.0).abs() < 1e-14);
    assert_eq!(
        [5e-4, 5e-3, 0.5].map(FlowRegime::at_inertial_number),
        [FlowRegime::QuasiStatic, FlowRegime::Dense, FlowRegime::Collisional]
    );
    assert_eq!(krieger_dougherty(0.0, 0.64, 1.0, 1.6), 1.0);
    assert!((krieger_dougherty(0.32, 0.64, 2.0, 2.0) - 8.0).abs() < 1e-12);
    assert_eq!(krieger_dougherty(0.7, 0.64, 1.0, 1.6), f64::INFINITY);
    assert!((solid_fraction(0.1, 0.6, 0.4) - 0.58).abs() < 1e-15);
}

#[test]
fn parameters_out_of_range_are_named() {
    let mu_i = |spec: MuISpec, field| assert_field(MaterialSpec::MuI(spec).build(), field);
    mu_i(MuISpec { density: 0.0, ..sand() }, "density");
    mu_i(MuISpec { bulk_modulus: -1.0, ..sand() }, "bulk_modulus");
    mu_i(MuISpec { shear_modulus: Some(0.0), ..sand() }, "shear_modulus");
    mu_i(MuISpec { static_friction: 0.0, ..sand() }, "static_friction");
    mu_i(MuISpec { static_friction: 2.0, limit_friction: 2.0, ..sand() }, "static_friction");
    mu_i(MuISpec { limit_friction: 0.3, ..sand() }, "limit_friction");
    mu_i(MuISpec { limit_friction: 2.0, ..sand() }, "limit_friction");
    mu_i(MuISpec { reference_inertial_number: 0.0, ..sand() }, "reference_inertial_number");
    mu_i(MuISpec { grain_diameter: f64::NAN, ..sand() }, "grain_diameter");
    mu_i(MuISpec { grain_density: f64::INFINITY, ..sand() }, "grain_density");
    let capped = MuIForm::Capped { max_viscosity: 0.0, min_shear_rate: 1e-7 };
    mu_i(MuISpec { form: capped, ..sand() }, "form.max_viscosity");
    let capped = MuIForm::Capped { max_viscosity: 1.0, min_shear_rate: 0.0 };
    mu_i(MuISpec { form: capped, ..sand() }, "form.min_shear_rate");
    mu_i(MuISpec { form: MuIForm::Smoothed { shear_rate: 0.0 }, ..sand() }, "form.shear_rate");
    mu_i(MuISpec { form: MuIForm::Papanastasiou { time: -1.0 }, ..sand() }, "form.time");

    let bingham = |spec: BinghamSpec, field| assert_field(MaterialSpec::Bingham(spec).build(), field);
    bingham(BinghamSpec { yield_stress: -1.0, ..mud() }, "yield_stress");
    bingham(BinghamSpec { viscosity: -1.0, ..mud() }, "viscosity");
    bingham(BinghamSpec { bulk_modulus: 0.0, ..mud() }, "bulk_modulus");
    bingham(BinghamSpec { shear_modulus: Some(f64::NAN), ..mud() }, "shear_modulus");
    bingham(BinghamSpec { cavitation_strength: -1.0, ..mud() }, "cavitation_strength");
    bingham(BinghamSpec { form: YieldForm::Capped { max_viscosity: 49.0 }, ..mud() }, "form.max_viscosity");

    let fluid =
        |spec: FrictionalFluidSpec, field| assert_field(MaterialSpec::FrictionalFluid(spec).build(), field);
    fluid(FrictionalFluidSpec { friction_angle: 90.0, ..debris() }, "friction_angle");
    fluid(FrictionalFluidSpec { friction_angle: -1.0, ..debris() }, "friction_angle");
    fluid(FrictionalFluidSpec { cohesion: -1.0, ..debris() }, "cohesion");
    fluid(FrictionalFluidSpec { density: -1.0, ..debris() }, "density");

    let cfd = |spec: CfdSoilSpec, field| assert_field(MaterialSpec::CfdSoil(spec).build(), field);
    cfd(CfdSoilSpec { youngs_modulus: 0.0, ..soil(0.0, ShearNorm::SqrtJ2) }, "youngs_modulus");
    cfd(CfdSoilSpec { poissons_ratio: 0.5, ..soil(0.0, ShearNorm::SqrtJ2) }, "poissons_ratio");
    cfd(CfdSoilSpec { friction_angle: 90.0, ..soil(0.0, ShearNorm::SqrtJ2) }, "friction_angle");
    cfd(CfdSoilSpec { friction_angle: 0.0, ..soil(0.0, ShearNorm::SqrtJ2) }, "cohesion");
    cfd(soil(-1.0, ShearNorm::SqrtJ2), "cohesion");

    let water = NewtonianFluidSpec {
        density: 1000.0,
        bulk_modulus: 2.15e9,
        viscosity: -1.0,
        cavitation_strength: 0.0,
        equation_of_state: EquationOfState::Linear,
    };
    assert_field(MaterialSpec::NewtonianFluid(water).build(), "viscosity");
}

#[test]
fn steps_that_cannot_be_are_refused() {
    let law = mud().viscoplastic().unwrap();
    let state = FluidState { rest_density: 1000.0, density: 1000.0, shear_rate: 0.0 };
    let old = Point { stress: SymTensor::ZERO, state };
    for (dt, density) in [(1e-3, 499.0), (1e-3, 2001.0), (0.0, 1000.0), (1e-3, f64::NAN)] {
        assert!(law.update(&SymTensor::ZERO, &still(dt, density), &old).is_err(), "{dt} {density}");
    }
    assert!(law.update(&SymTensor([1e300; 6]), &still(1e-3, 1000.0), &old).is_err());
}

#[test]
fn tangents_of_yielding_fluids_are_slopes() {
    let coarse = MuISpec { grain_diameter: 0.2, ..sand() };
    slopes_match(&Corotational(coarse.viscoplastic().unwrap()));
    slopes_match(&Corotational(sand().viscoplastic().unwrap()));
    slopes_match(&Corotational(MuISpec { limit_friction: 0.38, ..sand() }.viscoplastic().unwrap()));
    slopes_match(&Corotational(mud().viscoplastic().unwrap()));
    slopes_match(&Corotational(
        BinghamSpec { equation_of_state: EquationOfState::Tait, ..mud() }.viscoplastic().unwrap(),
    ));
    slopes_match(&Corotational(FrictionalFluidSpec { viscosity: 300.0, ..debris() }.viscoplastic().unwrap()));
}

/// Tangent against central differences, for a step that flows and one that does not.
fn slopes_match<L: SmallStrain<State = FluidState>>(law: &Corotational<L>) {
    let start = InitialCondition { stress: SymTensor::isotropic(-5e3), density: 1500.0 };
    let old = law.initial(&start).unwrap();
    let direction = SymTensor([1.0, -1.5, 0.2, 0.8, -0.3, 0.5]);
    for size in [1e-8, 3e-3] {
        let stress = |extra: &SymTensor| {
            let gradient = (direction * size + *extra).to_matrix();
            let mut motion = Motion::from_velocity_gradient(&(gradient * 1e3), 1e-3, 1500.0, 1.0).unwrap();
            motion.density = 1500.0 / motion.deformation.determinant();
            (law.update(&motion, &old).unwrap(), motion)
        };
        let (new, motion) = stress(&SymTensor::ZERO);
        assert_eq!(new.state.shear_rate > 0.0, size > 1e-4);
        let tangent = law.tangent(&motion, &old).unwrap();
        let modulus = law.wave_modulus(&new);
        for column in 0..6 {
            let step = 1e-9 + 1e-4 * size;
            let mut unit = SymTensor::ZERO;
            // Engineering shear.
            unit[column] = if column < 3 { step } else { 0.5 * step };
            let slope = (stress(&unit).0.stress - stress(&(-unit)).0.stress) * (0.5 / step);
            for row in 0..6 {
                let error = (tangent.0[row][column] - slope[row]).abs();
                assert!(error <= 1e-6 * modulus, "{} [{row}][{column}] at {size}: {error}", law.name());
            }
        }
    }
}
