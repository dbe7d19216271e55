//! Flow laws at a point and in films (sheet: constitutive V-19, V-20, V-21; §2.9–2.11, §3.7.9).

use std::sync::Arc;

use colluvium::constitutive::basal::{BasalFlow, BasalSpec, plug_ratio, plug_ratio_quadratic};
use colluvium::constitutive::{InitialCondition, Mat3, Material, MaterialSpec, Motion, States, SymTensor};
use colluvium::plots::{LineChart, Series, Style};
use serde_json::{Value, json};

use crate::analysis::MaxOrNan;
use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of this module.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "constitutive/flow",
    title: "Flow laws: a point, films, the base of depth-averaged flow",
    source: "sheet: constitutive V-19, V-20, V-21, closed forms",
    short_seconds: Some(1),
    full_seconds: 1,
    run: benchmark,
};

const MACHINE: &str = "closed form, machine precision";
const DIGITS: &str = "the sheet's digits";
const FRAME: &str = "the turning frame leaves the square of the elastic strain";
const FILM: &str = "the sheet's digits; the law is inverted for the shear rate at 41 depths";
const GRAVITY: f64 = 9.81;

fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    sand_at_a_point(&mut outcome)?;
    sand_relaxes(&mut outcome)?;
    crate::benchmarks::element::flow_cycles::cyclic_shear(&mut outcome)?;
    sand_film(&mut outcome)?;
    liquid_films(&mut outcome)?;
    rest(&mut outcome)?;
    liquid_column(&mut outcome)?;
    base(&mut outcome)?;
    Ok(outcome)
}

/// Flow law with its density, from which points are made.
pub(super) struct FlowLaw {
    law: Arc<dyn Material>,
    density: f64,
}

pub(super) struct FlowPoint {
    stress: [SymTensor; 1],
    states: States,
}

impl FlowLaw {
    fn new(value: Value) -> Result<Self, String> {
        let spec: MaterialSpec = serde_json::from_value(value).map_err(|error| error.to_string())?;
        Ok(Self { law: spec.build().map_err(|error| error.to_string())?, density: spec.density() })
    }

    pub(super) fn start(&self, stress: SymTensor) -> Result<FlowPoint, String> {
        let start = InitialCondition { stress, density: self.density };
        let (stresses, states) = self.law.initial(&[start]).map_err(|error| error.to_string())?;
        Ok(FlowPoint { stress: [stresses[0]], states })
    }

    /// Makes a step at constant density.
    pub(super) fn step(&self, walker: &mut FlowPoint, l: &Mat3, dt: f64) -> Result<(), String> {
        let motion =
            Motion::from_velocity_gradient(l, dt, self.density, 1.0).ok_or("the step is too large")?;
        let block = &mut walker.states.blocks_mut()[0];
        self.law.update(&[motion], &mut walker.stress, block).map_err(|error| error.to_string())
    }

    /// Shear stress xy (Pa).
    pub(super) fn shear(&self, walker: &FlowPoint) -> f64 {
        walker.stress[0][3]
    }

    fn wave_modulus(&self, walker: &FlowPoint) -> f64 {
        let mut modulus = [0.0];
        self.law.wave_moduli(&walker.stress, &walker.states.blocks()[0], &mut modulus);
        modulus[0]
    }

    fn output(&self, walker: &FlowPoint, name: &str) -> f64 {
        let names = self.law.output_names();
        let mut out = vec![f64::NAN; names.len()];
        self.law.outputs(&walker.stress, &walker.states.blocks()[0], &mut out);
        names.iter().position(|n| *n == name).map_or(f64::NAN, |i| out[i])
    }

    /// Shear stress of steady simple shear at `rate` and `pressure`: after a strain of many times that to
    /// yield, in small steps.
    fn steady(&self, rate: f64, pressure: f64) -> Result<f64, String> {
        let mut walker = self.start(SymTensor::isotropic(-pressure))?;
        let l = Mat3([[0.0, rate, 0.0], [0.0; 3], [0.0; 3]]);
        let mut last = f64::NAN;
        // Doubled until it is steady; the first step has a strain of 10⁻⁶.
        let dt = 1e-6 / rate;
        for _ in 0..40 {
            for _ in 0..50 {
                self.step(&mut walker, &l, dt)?;
            }
            let now = walker.stress[0].j2().sqrt();
            if (now - last).abs() <= 1e-12 * now {
                return Ok(now);
            }
            last = now;
        }
        Ok(last)
    }

    /// Shear rate of steady flow under the shear stress `shear`: zero below yield.
    fn rate(&self, shear: f64, pressure: f64) -> Result<f64, String> {
        let (mut low, mut high) = (1e-6f64, 1e5f64);
        if self.steady(low, pressure)? >= shear {
            return Ok(0.0);
        }
        while high / low > 1.0 + 1e-9 {
            let middle = (low * high).sqrt();
            *(if self.steady(middle, pressure)? < shear { &mut low } else { &mut high }) = middle;
        }
        Ok((low * high).sqrt())
    }
}

/// Law of the parameter set of §2.9.
pub(super) fn sand(form: &Value) -> Result<FlowLaw, String> {
    // A viscous form has no shear modulus.
    let shear_modulus = (form["kind"] == "elasto-viscoplastic").then_some(2e6);
    FlowLaw::new(json!({
        "model": "mu-i", "density": 1470.0, "bulk_modulus": 4e6, "shear_modulus": shear_modulus,
        "grain_density": 2450.0, "grain_diameter": 0.53e-3,
        "static_friction": 0.38, "limit_friction": 0.64, "reference_inertial_number": 0.279, "form": form
    }))
}

fn sand_at_a_point(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let viscoplastic = sand(&json!({ "kind": "elasto-viscoplastic" }))?;
    let capped = sand(&json!({ "kind": "capped", "max_viscosity": 1e9 }))?;
    // p, γ̇, I, μ, η
    let table = [
        (100.0, 1.0, 0.002_623_366_2, 0.382_421_941_1, 38.242_194_11),
        (1000.0, 10.0, 0.008_295_812_2, 0.387_507_631_8, 38.750_763_18),
        (1000.0, 100.0, 0.082_958_122_0, 0.439_590_075_2, 4.395_900_752),
        (50.0, 200.0, 0.742, 0.568_952_007_8, 0.142_238_002),
    ];
    let (mut smooth, mut plastic) = (Vec::new(), Vec::new());
    for (pressure, rate, number, friction, viscosity) in table {
        let at = format!("V-19 μ(I), {pressure} Pa, {rate} 1/s");
        let mut walker = capped.start(SymTensor::isotropic(-pressure))?;
        capped.step(&mut walker, &Mat3([[0.0, rate, 0.0], [0.0; 3], [0.0; 3]]), 1e-6)?;
        let found = walker.stress[0].j2().sqrt() / pressure;
        outcome.assert_close(
            format!("{at}: I"),
            number,
            2e-8,
            capped.output(&walker, "inertial_number"),
            DIGITS,
        );
        outcome.assert_close(format!("{at}: μ, capped form"), friction, 1e-9, found, DIGITS);
        let eta = capped.output(&walker, "effective_viscosity");
        outcome.assert_close(format!("{at}: η (Pa s)"), viscosity, 3e-9, eta, DIGITS);
        smooth.push((number, found));
        let found = viscoplastic.steady(rate, pressure)? / pressure;
        outcome.assert_close(
            format!("{at}: μ, steady elasto-viscoplastic flow"),
            friction,
            1e-6,
            found,
            FRAME,
        );
        plastic.push((number, found));
    }
    let curve = (1..=80).map(|i| 0.01 * f64::from(i));
    let exact = curve.map(|i| (i, 0.38 + 0.26 / (0.279 / i + 1.0))).collect();
    let chart = LineChart {
        title: "Friction of steady simple shear".into(),
        x_label: "inertial number".into(),
        y_label: "shear stress over pressure".into(),
        log: false,
        series: vec![
            Series::new("μ(I)", exact, Style::Line),
            Series::new("capped form", smooth, Style::Markers),
            Series::new("elasto-viscoplastic form", plastic, Style::Markers),
        ],
    };
    outcome.svg("Both forms of the law flow with the friction of their inertial number.", &chart)
}

fn sand_relaxes(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    // Δt, trial, τ, γ̇ᵖ at p = 1000 Pa, G = 1 MPa.
    let table = [
        (1e-4, 600.0, 381.676_939_9, 2.183_230_601),
        (1e-4, 1000.0, 384.671_549_1, 6.153_284_509),
        (1e-5, 1000.0, 418.337_087_6, 58.166_291_24),
        (1e-3, 1000.0, 380.478_063_4, 0.619_521_936_6),
    ];
    let law = FlowLaw::new(json!({
        "model": "mu-i", "density": 1470.0, "bulk_modulus": 4e6, "shear_modulus": 1e6,
        "grain_density": 2450.0, "grain_diameter": 0.53e-3,
        "static_friction": 0.38, "limit_friction": 0.64, "reference_inertial_number": 0.279
    }))?;
    for (dt, trial, shear, rate) in table {
        let mut walker = law.start(SymTensor::isotropic(-1000.0))?;
        let half = 0.5 * trial / 1e6 / dt;
        law.step(&mut walker, &Mat3([[0.0, half, 0.0], [half, 0.0, 0.0], [0.0; 3]]), dt)?;
        let at = format!("V-19 return, Δt = {dt} s, trial {trial} Pa");
        outcome.assert_close(format!("{at}: τ (Pa)"), shear, 2e-10, walker.stress[0][3], DIGITS);
        outcome.assert_close(
            format!("{at}: γ̇ᵖ (1/s)"),
            rate,
            5e-10,
            law.output(&walker, "shear_rate"),
            DIGITS,
        );
    }
    Ok(())
}

/// Speeds over depth of a film on a slope, from the shear rates of the law under the stress of the film: pairs (height, speed), and the
/// mean speed. `weight` and `drive` are the normal and the tangential component of the unit weight.
struct FilmProfile {
    profile: Vec<(f64, f64)>,
    rates: Vec<f64>,
    mean: f64,
}

/// Intervals of the film, an even number.
const PARTS: usize = 40;

/// Profile of a film by Simpson's rule in the square root of the depth below the surface, in which profiles are smooth.
fn film(law: &FlowLaw, height: f64, weight: f64, drive: f64) -> Result<FilmProfile, String> {
    let root = |i: usize| height.sqrt() * (1.0 - i as f64 / PARTS as f64);
    let mut rates = Vec::with_capacity(PARTS + 1);
    for i in 0..=PARTS {
        let depth = root(i).powi(2);
        rates.push(if depth > 0.0 { law.rate(drive * depth, weight * depth)? } else { 0.0 });
    }
    // dz = -2 s ds
    let speed = |i: usize| rates[i] * 2.0 * root(i);
    let flux = |i: usize| rates[i] * 2.0 * root(i).powi(3);
    let width = height.sqrt() / PARTS as f64;
    let simpson = |f: &dyn Fn(usize) -> f64, i: usize| width / 3.0 * (f(i) + 4.0 * f(i + 1) + f(i + 2));
    let (mut profile, mut total, mut mean) = (vec![(0.0, 0.0)], 0.0, 0.0);
    for i in (0..PARTS).step_by(2) {
        total += simpson(&speed, i);
        mean += simpson(&flux, i) / height;
        profile.push((height - root(i + 2).powi(2), total));
    }
    Ok(FilmProfile { profile, rates, mean })
}

impl FilmProfile {
    fn surface(&self) -> f64 {
        self.profile.last().map_or(f64::NAN, |p| p.1)
    }
}

fn flipped(profile: &[(f64, f64)]) -> Vec<(f64, f64)> {
    profile.iter().map(|(z, v)| (*v, *z)).collect()
}

fn sand_film(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let law = sand(&json!({ "kind": "elasto-viscoplastic" }))?;
    let (angle, height, weight) = (26f64.to_radians(), 0.02, 0.6 * 2450.0 * GRAVITY);
    let found = film(&law, height, weight * angle.cos(), weight * angle.sin())?;
    let number = found.rates[0] * 0.53e-3 / (weight * angle.cos() * height / 2450.0).sqrt();
    outcome.assert_close("V-19 film of sand: I", 0.197_398_72, 1e-6, number, FILM);
    outcome.assert_close(
        "V-19 film of sand: speed of the surface (m/s)",
        1.615_33,
        4e-6,
        found.surface(),
        FILM,
    );
    outcome.assert_close("V-19 film of sand: mean speed (m/s)", 0.969_201, 2e-6, found.mean, FILM);
    let slope = 0.197_398_72 * (GRAVITY * 0.6 * angle.cos()).sqrt() / 0.53e-3 * 2.0 / 3.0;
    let exact = |z: f64| slope * (height.powf(1.5) - (height - z).powf(1.5));
    let curve: Vec<_> = (0..=50).map(|i| height * f64::from(i) / 50.0).map(|z| (z, exact(z))).collect();
    let chart = LineChart {
        title: "Film of sand on a slope of 26°".into(),
        x_label: "speed (m/s)".into(),
        y_label: "height (m)".into(),
        log: false,
        series: vec![
            Series::new("Bagnold profile", flipped(&curve), Style::Line),
            Series::new("integrated law", flipped(&found.profile), Style::Markers),
        ],
    };
    outcome.svg("The law, integrated over the depth, gives the profile in closed form.", &chart)
}

fn liquid_films(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let (angle, height, density, viscosity) = (10f64.to_radians(), 0.5, 1800.0, 50.0);
    let drive = density * GRAVITY * angle.sin();
    let weight = density * GRAVITY * angle.cos();
    let fluid = FlowLaw::new(json!({
        "model": "newtonian-fluid", "density": density, "bulk_modulus": 1e8, "viscosity": viscosity
    }))?;
    let newton = film(&fluid, height, weight, drive)?;
    let surface = drive * height * height / (2.0 * viscosity);
    outcome.assert_close(
        "V-20 Newtonian film: speed of the surface (m/s)",
        surface,
        1e-8,
        newton.surface(),
        MACHINE,
    );
    let shape = |z: f64| drive / viscosity * (height * z - 0.5 * z * z);
    let worst = newton.profile.iter().map(|(z, v)| (v - shape(*z)).abs()).max_or_nan();
    outcome.assert_below(
        "V-20 Newtonian film: worst of the profile (m/s)",
        "0",
        worst,
        1e-8 * surface,
        MACHINE,
    );

    // The plug is chosen to end at a node of the depth.
    let plug = height * 0.25;
    let yield_stress = drive * plug;
    let mut chart = LineChart {
        title: "Films of fluid on a slope of 10°".into(),
        x_label: "speed (m/s)".into(),
        y_label: "height (m)".into(),
        ..LineChart::default()
    };
    let curve: Vec<_> = (0..=50).map(|i| height * f64::from(i) / 50.0).map(|z| (z, shape(z))).collect();
    chart.series.push(Series::new("Newtonian, closed form", flipped(&curve), Style::Line));
    chart.series.push(Series::new("Newtonian, law", flipped(&newton.profile), Style::Markers));
    let fluid = FlowLaw::new(json!({
        "model": "bingham", "density": density, "bulk_modulus": 1e8, "shear_modulus": 5e7,
        "yield_stress": yield_stress, "viscosity": viscosity
    }))?;
    let found = film(&fluid, height, weight, drive)?;
    let sheared = height - plug;
    let top = drive * sheared * sheared / (2.0 * viscosity);
    let mean = top * (2.0 * height + plug) / (3.0 * height);
    outcome.assert_close("V-20 Bingham film: speed of the plug (m/s)", top, 1e-5, found.surface(), FRAME);
    outcome.assert_close("V-20 Bingham film: mean speed (m/s)", mean, 1e-5, found.mean, FRAME);
    let still = found.rates.iter().enumerate().filter(|(i, rate)| **rate > 0.0 && *i > PARTS / 2).count();
    outcome.assert_close(
        "V-20 Bingham film: depths within the plug that flow",
        0.0,
        0.0,
        still as f64,
        "rigid plug",
    );
    let shape = |z: f64| {
        let z = z.min(sheared);
        drive / viscosity * (sheared * z - 0.5 * z * z)
    };
    let curve: Vec<_> = (0..=50).map(|i| height * f64::from(i) / 50.0).map(|z| (z, shape(z))).collect();
    chart.series.push(Series::new("Bingham, closed form", flipped(&curve), Style::Dashed));
    chart.series.push(Series::new("Bingham, law", flipped(&found.profile), Style::Markers));
    outcome.svg("Film profiles from the laws: the Bingham fluid carries a plug.", &chart)?;

    // The film by the depth-averaged law.
    let law = basal(json!({ "model": "bingham", "yield_stress": yield_stress, "viscosity": viscosity }))?;
    let flow = BasalFlow { depth: height, speed: mean, ..BasalFlow::default() };
    let shear = law(&flow)?;
    outcome.assert_close(
        "V-20, V-21 Bingham film: depth-averaged τ_b (Pa)",
        drive * height,
        1e-12,
        shear,
        MACHINE,
    );
    Ok(())
}

/// Checks whether fluids with friction come to rest.
fn rest(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let fluid = |form: &Value| {
        FlowLaw::new(json!({
            "model": "frictional-fluid", "density": 1800.0, "bulk_modulus": 1e7, "friction_angle": 30.0,
            "viscosity": 20.0, "form": form
        }))
    };
    let shear = Mat3([[0.0, 0.5, 0.0], [0.5, 0.0, 0.0], [0.0; 3]]);
    let after_rest = |law: &FlowLaw| -> Result<f64, String> {
        let mut walker = law.start(SymTensor::isotropic(-1000.0))?;
        for step in 0..200 {
            law.step(&mut walker, &if step < 100 { shear } else { Mat3::ZERO }, 1e-3)?;
        }
        Ok(walker.stress[0][3] / 1000.0)
    };
    let name = "V-20 frictional fluid at rest after flow: tangent of the steepest slope";
    let yielding = after_rest(&fluid(&json!({ "kind": "viscoplastic" }))?)?;
    outcome.assert_close(name, 0.5, 1e-9, yielding, "sin φ of the static yield stress");
    let name = "V-20 the same with a capped viscosity: it rests on no slope";
    let creeping = after_rest(&fluid(&json!({ "kind": "capped", "max_viscosity": 1e4 }))?)?;
    outcome.assert_close(name, 0.0, 1e-12, creeping, "no shear stress without a shear rate");
    Ok(())
}

fn liquid_column(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let (density, modulus) = (1000.0, 2.15e9);
    let water =
        FlowLaw::new(json!({ "model": "newtonian-fluid", "density": density, "bulk_modulus": modulus }))?;
    let mut walker = water.start(SymTensor::ZERO)?;
    outcome.assert_close(
        "V-20 water: speed of sound (m/s)",
        1466.29,
        4e-6,
        (water.wave_modulus(&walker) / density).sqrt(),
        DIGITS,
    );
    // Down the column in equal steps of density; the depth follows from the weight.
    let (mut depth, mut pressure) = (0.0, 0.0);
    let step = 1e-5 * density;
    for i in 1..=1000 {
        let now = density + step * f64::from(i);
        let mut motion = Motion::from_velocity_gradient(&Mat3::ZERO, 1e-3, now, 1.0).ok_or("singular")?;
        motion.density = now;
        let block = &mut walker.states.blocks_mut()[0];
        water.law.update(&[motion], &mut walker.stress, block).map_err(|error| error.to_string())?;
        let next = walker.stress[0].pressure();
        depth += (next - pressure) / ((now - 0.5 * step) * GRAVITY);
        pressure = next;
    }
    let exact = density * (modulus / density) * ((depth * GRAVITY * density / modulus).exp() - 1.0);
    let name = "V-20 water column: pressure at the depth where it is 1 % denser (Pa)";
    outcome.assert_close(name, exact, 1e-8, pressure, "closed form; 1000 steps of second order");
    Ok(())
}

/// A basal law of a case as a function of the flow.
fn basal(value: Value) -> Result<impl Fn(&BasalFlow) -> Result<f64, String>, String> {
    let spec: BasalSpec = serde_json::from_value(value).map_err(|error| error.to_string())?;
    let law = spec.build().map_err(|error| error.to_string())?;
    Ok(move |flow: &BasalFlow| law.shear_stress(flow).map_err(|error| error.to_string()))
}

fn base(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let bingham = |yield_stress: f64, viscosity: f64, solution: &str| {
        basal(json!({
            "model": "bingham", "yield_stress": yield_stress, "viscosity": viscosity, "solution": solution
        }))
    };
    // The last digit of the first quadratic value in the sheet is one too low.
    let table = [
        (1.0, 1.0, 50.0, 200.0, 428.182_657_8, 429.723_192_3),
        (2.0, 5.0, 100.0, 500.0, 1_471.120_925, 1_491.615_899),
    ];
    for (depth, speed, viscosity, yield_stress, exact, quadratic) in table {
        let flow = BasalFlow { depth, speed, ..BasalFlow::default() };
        let at = format!("V-21 Bingham base, τ_y = {yield_stress} Pa");
        let found = bingham(yield_stress, viscosity, "exact")?(&flow)?;
        outcome.assert_close(format!("{at}: τ_b (Pa)"), exact, 4e-10, found, DIGITS);
        let found = bingham(yield_stress, viscosity, "quadratic")?(&flow)?;
        outcome.assert_close(format!("{at}: τ_b by the quadratic (Pa)"), quadratic, 4e-10, found, DIGITS);
    }
    for (a, ratio, digits) in [(0.015, 0.930_974_664_2, 1e-10), (1200.0, 0.001_662_510_4, 4e-8)] {
        outcome.assert_close(format!("V-21 Bingham base, a = {a}: ξ"), ratio, digits, plug_ratio(a), DIGITS);
    }
    let flow = |speed: f64| BasalFlow { depth: 1.5, speed, ..BasalFlow::default() };
    let slow = bingham(200.0, 50.0, "exact")?(&flow(1e-12))?;
    outcome.assert_close(
        "V-21 Bingham base: τ_b → τ_y as it comes to rest (Pa)",
        200.0,
        1e-5,
        slow,
        "√(a/3) remains",
    );
    let fluid = bingham(1e-9, 50.0, "exact")?(&flow(2.0))?;
    outcome.assert_close(
        "V-21 Bingham base: τ_b → 3μv̄/h without strength (Pa)",
        200.0,
        1e-10,
        fluid,
        MACHINE,
    );
    let sliding = basal(json!({
        "model": "viscous-frictional", "friction_angle": 45.0, "consistency": 0.8, "exponent": 2.0
    }))?;
    let normal = BasalFlow { depth: 1.5, speed: 3.0, normal_stress: 5000.0, ..BasalFlow::default() };
    outcome.assert_close("V-21 viscous-frictional base: τ_b (Pa)", 5020.0, 1e-9, sliding(&normal)?, DIGITS);
    let unit_weight = 2000.0 * GRAVITY;
    let slope = 20f64.to_radians();
    let debris = |speed: f64| BasalFlow {
        depth: 1.5,
        speed,
        normal_stress: unit_weight * 1.5 * slope.cos(),
        pore_pressure: 0.0,
        slope: slope.tan(),
        unit_weight,
    };
    let voellmy = basal(json!({ "model": "voellmy", "friction_angle": 15.0, "turbulence": 600.0 }))?;
    outcome.assert_close("V-21 Voellmy base: τ_b (Pa)", 7704.476, 1e-7, voellmy(&debris(3.0))?, DIGITS);
    let coulomb = basal(json!({ "model": "coulomb", "friction_angle": 30.0 }))?;
    let driving = unit_weight * 1.5 * slope.sin();
    outcome.assert_close(
        "V-21 Coulomb base at rest: as much as drives (Pa)",
        driving,
        1e-12,
        coulomb(&debris(0.0))?,
        MACHINE,
    );

    let speeds = || (0..=100).map(|i| 10f64.powf(-2.0 + 0.04 * f64::from(i)));
    let mut chart = LineChart {
        title: "Basal shear stress, h = 1.5 m, slope 20°".into(),
        x_label: "depth-averaged speed (m/s)".into(),
        y_label: "basal shear stress (Pa)".into(),
        ..LineChart::default()
    };
    for spec in BasalSpec::examples() {
        let law = spec.build().map_err(|error| error.to_string())?;
        let mut curve = Vec::new();
        for speed in speeds() {
            curve.push((speed, law.shear_stress(&debris(speed)).map_err(|error| error.to_string())?));
        }
        let falls = curve.windows(2).filter(|pair| pair[1].1 < pair[0].1).count();
        let name = format!("V-21 {} base: speeds at which τ_b falls", law.name);
        outcome.assert_close(name, 0.0, 0.0, falls as f64, "monotone");
        if !chart.series.iter().any(|series| series.label == law.name) {
            let slow = curve.into_iter().filter(|(speed, _)| *speed < 20.0).collect();
            chart.series.push(Series::new(law.name, slow, Style::Line));
        }
    }
    outcome.svg("Basal laws over speed.", &chart)?;
    let errors = |a: f64| 100.0 * (plug_ratio(a) / plug_ratio_quadratic(a) - 1.0);
    let range = (-320..=320).map(|i| 10f64.powf(f64::from(i) / 80.0)).map(errors);
    let (least, most) = range.fold((0f64, 0f64), |(low, high), e| (low.min(e), high.max(e)));
    outcome.assert_close(
        "V-21 quadratic: least error of τ_b (%)",
        -2.8,
        0.02,
        least,
        "the sheet's two digits",
    );
    outcome.assert_close(
        "V-21 quadratic: largest error of τ_b (%)",
        4.6,
        0.02,
        most,
        "the sheet's two digits",
    );
    Ok(())
}
