//! Flow laws at a point and in films (sheet: constitutive V-19, V-20, V-21; §2.9–2.11, §3.7.9).

use std::sync::Arc;

use colluvium::constitutive::basal::BasalFlow;
use colluvium::constitutive::{InitialCondition, Mat3, Material, MaterialSpec, Motion, States, SymTensor};
use colluvium::plots::{LineChart, Series, Style};
use serde_json::{Value, json};

use crate::analysis::MaxOrNan;
use crate::benchmarks::element::basal_laws::{self, basal};
use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of flow laws at a point, in films, and as basal laws of depth-averaged flow.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "constitutive/flow",
    title: "Flow laws: a point, films, the base of depth-averaged flow",
    source: "sheet: constitutive V-19, V-20, V-21, closed forms",
    short_seconds: Some(1),
    full_seconds: 1,
    run: benchmark,
};

/// Reason of the tolerance of a closed form.
pub(super) const MACHINE: &str = "closed form, machine precision";
/// Reason of the tolerance of values printed in the sheet.
pub(super) const DIGITS: &str = "the sheet's digits";
/// Reason of a tolerance of 10⁻⁵: error of the co-rotational frame.
const FRAME: &str = "the turning frame leaves the square of the elastic strain";
/// Reason of the tolerance of values of films of sand.
const FILM: &str = "the sheet's digits; the law is inverted for the shear rate at 41 depths";
/// Acceleration of gravity (m/s²).
pub(super) const GRAVITY: f64 = 9.81;

/// Checks flow laws at a point, in films down an incline, in a column at rest and as basal laws.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    sand_at_a_point(&mut outcome)?;
    sand_relaxes(&mut outcome)?;
    crate::benchmarks::element::flow_cycles::cyclic_shear(&mut outcome)?;
    sand_film(&mut outcome)?;
    liquid_films(&mut outcome)?;
    check_rest(&mut outcome)?;
    liquid_column(&mut outcome)?;
    basal_laws::bingham(&mut outcome)?;
    basal_laws::friction(&mut outcome)?;
    basal_laws::monotone(&mut outcome)?;
    basal_laws::quadratic(&mut outcome);
    Ok(outcome)
}

/// Flow law with its density, which updates the stress of points.
pub(super) struct FlowLaw {
    law: Arc<dyn Material>,
    density: f64,
}

/// Stress and state of a material point.
pub(super) struct FlowPoint {
    stress: [SymTensor; 1],
    states: States,
}

impl FlowLaw {
    /// Law from its keys, with its density.
    fn new(value: Value) -> Result<Self, String> {
        let spec: MaterialSpec = serde_json::from_value(value).map_err(|error| error.to_string())?;
        Ok(Self { law: spec.build().map_err(|error| error.to_string())?, density: spec.density() })
    }

    /// Point with an initial stress.
    pub(super) fn start(&self, stress: SymTensor) -> Result<FlowPoint, String> {
        let start = InitialCondition { stress, density: self.density };
        let (stresses, states) = self.law.initial(&[start]).map_err(|error| error.to_string())?;
        Ok(FlowPoint { stress: [stresses[0]], states })
    }

    /// Updates a point by a step at constant density.
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

    /// P-wave modulus of a point (Pa).
    fn wave_modulus(&self, walker: &FlowPoint) -> f64 {
        let mut modulus = [0.0];
        self.law.wave_moduli(&walker.stress, &walker.states.blocks()[0], &mut modulus);
        modulus[0]
    }

    /// Output scalar of a point.
    fn output(&self, walker: &FlowPoint, name: &str) -> f64 {
        let names = self.law.output_names();
        let mut out = vec![f64::NAN; names.len()];
        self.law.outputs(&walker.stress, &walker.states.blocks()[0], &mut out);
        names.iter().position(|n| *n == name).map_or(f64::NAN, |i| out[i])
    }

    /// Shear stress of steady simple shear at a rate and a pressure, after a strain of many times that at yield.
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

    /// Shear rate of steady flow under a shear stress; zero below yield.
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

/// Law of the sand of §2.9 in one of its forms.
pub(super) fn sand(form: &Value) -> Result<FlowLaw, String> {
    // A viscous form has no shear modulus.
    let shear_modulus = (form["kind"] == "elasto-viscoplastic").then_some(2e6);
    FlowLaw::new(json!({
        "model": "mu-i", "density": 1470.0, "bulk_modulus": 4e6, "shear_modulus": shear_modulus,
        "grain_density": 2450.0, "grain_diameter": 0.53e-3,
        "static_friction": 0.38, "limit_friction": 0.64, "reference_inertial_number": 0.279, "form": form
    }))
}

/// Checks friction coefficient and viscosity of the μ(I) law at a point in steady shear.
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
        series: vec![
            Series::new("μ(I)", exact, Style::Line),
            Series::new("capped form", smooth, Style::Markers),
            Series::new("elasto-viscoplastic form", plastic, Style::Markers),
        ],
        ..LineChart::new("Friction of steady simple shear", "inertial number", "shear stress over pressure")
    };
    outcome.svg("Both forms of the law flow with the friction of their inertial number.", &chart)
}

/// Checks the relaxation of the shear stress in one step of the μ(I) law.
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

/// Steady profile of a film on a slope, from the shear rates of a law: pairs of height (m) and velocity (m/s), and the mean velocity.
struct FilmProfile {
    profile: Vec<(f64, f64)>,
    rates: Vec<f64>,
    mean: f64,
}

/// Number of intervals over the depth of a film, an even number.
const FILM_INTERVALS: usize = 40;

/// Profile of a film of material that flows down an incline. Shear rates are integrated by Simpson's rule in the square root of the depth
/// below the surface, in which profiles are smooth.
fn film(law: &FlowLaw, height: f64, weight: f64, drive: f64) -> Result<FilmProfile, String> {
    let root = |i: usize| height.sqrt() * (1.0 - i as f64 / FILM_INTERVALS as f64);
    let mut rates = Vec::with_capacity(FILM_INTERVALS + 1);
    for i in 0..=FILM_INTERVALS {
        let depth = root(i).powi(2);
        rates.push(if depth > 0.0 { law.rate(drive * depth, weight * depth)? } else { 0.0 });
    }
    // dz = -2 s ds
    let speed = |i: usize| rates[i] * 2.0 * root(i);
    let flux = |i: usize| rates[i] * 2.0 * root(i).powi(3);
    let width = height.sqrt() / FILM_INTERVALS as f64;
    let simpson = |f: &dyn Fn(usize) -> f64, i: usize| width / 3.0 * (f(i) + 4.0 * f(i + 1) + f(i + 2));
    let (mut profile, mut total, mut mean) = (vec![(0.0, 0.0)], 0.0, 0.0);
    for i in (0..FILM_INTERVALS).step_by(2) {
        total += simpson(&speed, i);
        mean += simpson(&flux, i) / height;
        profile.push((height - root(i + 2).powi(2), total));
    }
    Ok(FilmProfile { profile, rates, mean })
}

impl FilmProfile {
    /// Velocity of the surface (m/s).
    fn surface(&self) -> f64 {
        self.profile.last().map_or(f64::NAN, |p| p.1)
    }
}

/// Profile with velocity and height exchanged, for charts.
fn flipped(profile: &[(f64, f64)]) -> Vec<(f64, f64)> {
    profile.iter().map(|(z, v)| (*v, *z)).collect()
}

/// Checks the velocity of a film of sand on an incline.
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
        series: vec![
            Series::new("Bagnold profile", flipped(&curve), Style::Line),
            Series::new("integrated law", flipped(&found.profile), Style::Markers),
        ],
        ..LineChart::new("Film of sand on a slope of 26°", "speed (m/s)", "height (m)")
    };
    outcome.svg("The law, integrated over the depth, gives the profile in closed form.", &chart)
}

/// Film of a fluid on a slope of 10°, with the components of its unit weight along the slope and normal to it.
struct LiquidFilm {
    height: f64,        // h (m)
    density: f64,       // ρ (kg/m³)
    viscosity: f64,     // μ (Pa s)
    driving_force: f64, // ρ g sin θ (N/m³)
    weight: f64,        // ρ g cos θ (N/m³)
}

impl LiquidFilm {
    /// Film of mud on an incline of 10°.
    fn new() -> Self {
        let (angle, height, density, viscosity) = (10f64.to_radians(), 0.5, 1800.0, 50.0);
        let driving_force = density * GRAVITY * angle.sin();
        let weight = density * GRAVITY * angle.cos();
        Self { height, density, viscosity, driving_force, weight }
    }

    /// Profile of the film with a law.
    fn of_law(&self, law: Value) -> Result<FilmProfile, String> {
        film(&FlowLaw::new(law)?, self.height, self.weight, self.driving_force)
    }

    /// Curve of a velocity (m/s) over height (m) in closed form, at 51 heights.
    fn curve(&self, speed: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let heights = (0..=50).map(|i| self.height * f64::from(i) / 50.0);
        flipped(&heights.map(|z| (z, speed(z))).collect::<Vec<_>>())
    }
}

/// Checks the films of a Newtonian and of a Bingham fluid.
fn liquid_films(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut chart = LineChart::new("Films of fluid on a slope of 10°", "speed (m/s)", "height (m)");
    newtonian_film(outcome, &mut chart)?;
    bingham_film(outcome, &mut chart)
}

/// Checks the velocity profile of a Newtonian film on an incline.
fn newtonian_film(outcome: &mut BenchmarkOutcome, chart: &mut LineChart) -> Result<(), String> {
    let liquid = LiquidFilm::new();
    let LiquidFilm { height, density, viscosity, driving_force, .. } = liquid;
    let found = liquid.of_law(json!({
        "model": "newtonian-fluid", "density": density, "bulk_modulus": 1e8, "viscosity": viscosity
    }))?;
    let surface = driving_force * height * height / (2.0 * viscosity);
    let name = "V-20 Newtonian film: speed of the surface (m/s)";
    outcome.assert_close(name, surface, 1e-8, found.surface(), MACHINE);
    let shape = |z: f64| driving_force / viscosity * (height * z - 0.5 * z * z);
    let worst = found.profile.iter().map(|(z, v)| (v - shape(*z)).abs()).max_or_nan();
    let name = "V-20 Newtonian film: worst of the profile (m/s)";
    outcome.assert_below(name, "0", worst, 1e-8 * surface, MACHINE);
    chart.series.push(Series::new("Newtonian, closed form", liquid.curve(shape), Style::Line));
    chart.series.push(Series::new("Newtonian, law", flipped(&found.profile), Style::Markers));
    Ok(())
}

/// Checks the velocity profile of a Bingham film on an incline, and its plug.
fn bingham_film(outcome: &mut BenchmarkOutcome, chart: &mut LineChart) -> Result<(), String> {
    let liquid = LiquidFilm::new();
    let LiquidFilm { height, density, viscosity, driving_force, .. } = liquid;
    // The plug is chosen to end at a node of the depth.
    let plug = height * 0.25;
    let yield_stress = driving_force * plug;
    let found = liquid.of_law(json!({
        "model": "bingham", "density": density, "bulk_modulus": 1e8, "shear_modulus": 5e7,
        "yield_stress": yield_stress, "viscosity": viscosity
    }))?;
    let sheared = height - plug;
    let top = driving_force * sheared * sheared / (2.0 * viscosity);
    let mean = top * (2.0 * height + plug) / (3.0 * height);
    outcome.assert_close("V-20 Bingham film: speed of the plug (m/s)", top, 1e-5, found.surface(), FRAME);
    outcome.assert_close("V-20 Bingham film: mean speed (m/s)", mean, 1e-5, found.mean, FRAME);
    let still =
        found.rates.iter().enumerate().filter(|(i, rate)| **rate > 0.0 && *i > FILM_INTERVALS / 2).count();
    let name = "V-20 Bingham film: depths within the plug that flow";
    outcome.assert_close(name, 0.0, 0.0, still as f64, "rigid plug");
    let shape = |z: f64| {
        let z = z.min(sheared);
        driving_force / viscosity * (sheared * z - 0.5 * z * z)
    };
    chart.series.push(Series::new("Bingham, closed form", liquid.curve(shape), Style::Dashed));
    chart.series.push(Series::new("Bingham, law", flipped(&found.profile), Style::Markers));
    outcome.svg("Film profiles from the laws: the Bingham fluid carries a plug.", &*chart)?;
    // The film by the depth-averaged law.
    let law = basal(json!({ "model": "bingham", "yield_stress": yield_stress, "viscosity": viscosity }))?;
    let flow = BasalFlow { depth: height, speed: mean, ..BasalFlow::default() };
    let name = "V-20, V-21 Bingham film: depth-averaged τ_b (Pa)";
    outcome.assert_close(name, driving_force * height, 1e-12, law(&flow)?, MACHINE);
    Ok(())
}

/// Checks whether fluids with friction come to rest.
fn check_rest(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
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

/// Checks that a column of liquid at rest has the hydrostatic pressure of its equation of state.
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
