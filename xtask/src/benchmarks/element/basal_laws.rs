//! Basal laws of depth-averaged flow (sheet: constitutive V-21, §2.11).

use colluvium::constitutive::basal::{BasalFlow, BasalSpec, plug_ratio, plug_ratio_quadratic};
use colluvium::plots::{LineChart, Series, Style};
use serde_json::{Value, json};

use crate::benchmarks::BenchmarkOutcome;
use crate::benchmarks::element::flow_laws::{DIGITS, GRAVITY, MACHINE};

/// Unit weight of the debris (N/m³).
const UNIT_WEIGHT: f64 = 2000.0 * GRAVITY;

/// Basal shear stress of a law as a function of the flow.
pub fn basal(value: Value) -> Result<impl Fn(&BasalFlow) -> Result<f64, String>, String> {
    let spec: BasalSpec = serde_json::from_value(value).map_err(|error| error.to_string())?;
    let law = spec.build().map_err(|error| error.to_string())?;
    Ok(move |flow: &BasalFlow| law.shear_stress(flow).map_err(|error| error.to_string()))
}

/// State of a flow of debris 1.5 m deep on a slope of 20°, at a depth-averaged speed (m/s).
fn debris(speed: f64) -> BasalFlow {
    let slope = 20f64.to_radians();
    BasalFlow {
        depth: 1.5,
        speed,
        normal_stress: UNIT_WEIGHT * 1.5 * slope.cos(),
        pore_pressure: 0.0,
        slope: slope.tan(),
        unit_weight: UNIT_WEIGHT,
    }
}

/// Checks the basal law of a Bingham fluid: the sheet's table, the plug, and the limits of rest and of no strength.
pub fn bingham(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let law = |yield_stress: f64, viscosity: f64, solution: &str| {
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
        let found = law(yield_stress, viscosity, "exact")?(&flow)?;
        outcome.assert_close(format!("{at}: τ_b (Pa)"), exact, 4e-10, found, DIGITS);
        let found = law(yield_stress, viscosity, "quadratic")?(&flow)?;
        outcome.assert_close(format!("{at}: τ_b by the quadratic (Pa)"), quadratic, 4e-10, found, DIGITS);
    }
    for (a, ratio, digits) in [(0.015, 0.930_974_664_2, 1e-10), (1200.0, 0.001_662_510_4, 4e-8)] {
        outcome.assert_close(format!("V-21 Bingham base, a = {a}: ξ"), ratio, digits, plug_ratio(a), DIGITS);
    }
    let flow = |speed: f64| BasalFlow { depth: 1.5, speed, ..BasalFlow::default() };
    let slow = law(200.0, 50.0, "exact")?(&flow(1e-12))?;
    let name = "V-21 Bingham base: τ_b → τ_y as it comes to rest (Pa)";
    outcome.assert_close(name, 200.0, 1e-5, slow, "√(a/3) remains");
    let fluid = law(1e-9, 50.0, "exact")?(&flow(2.0))?;
    let name = "V-21 Bingham base: τ_b → 3μv̄/h without strength (Pa)";
    outcome.assert_close(name, 200.0, 1e-10, fluid, MACHINE);
    Ok(())
}

/// Checks the viscous-frictional, the Voellmy and the Coulomb basal law.
pub fn friction(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let sliding = basal(json!({
        "model": "viscous-frictional", "friction_angle": 45.0, "consistency": 0.8, "exponent": 2.0
    }))?;
    let normal = BasalFlow { depth: 1.5, speed: 3.0, normal_stress: 5000.0, ..BasalFlow::default() };
    outcome.assert_close("V-21 viscous-frictional base: τ_b (Pa)", 5020.0, 1e-9, sliding(&normal)?, DIGITS);
    let voellmy = basal(json!({ "model": "voellmy", "friction_angle": 15.0, "turbulence": 600.0 }))?;
    outcome.assert_close("V-21 Voellmy base: τ_b (Pa)", 7704.476, 1e-7, voellmy(&debris(3.0))?, DIGITS);
    let coulomb = basal(json!({ "model": "coulomb", "friction_angle": 30.0 }))?;
    let driving = UNIT_WEIGHT * 1.5 * 20f64.to_radians().sin();
    let name = "V-21 Coulomb base at rest: as much as drives (Pa)";
    outcome.assert_close(name, driving, 1e-12, coulomb(&debris(0.0))?, MACHINE);
    Ok(())
}

/// Checks that the basal shear stress of no law decreases with the speed, and draws the laws.
pub fn monotone(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let speeds = || (0..=100).map(|i| 10f64.powf(-2.0 + 0.04 * f64::from(i)));
    let mut chart = LineChart::new(
        "Basal shear stress, h = 1.5 m, slope 20°",
        "depth-averaged speed (m/s)",
        "basal shear stress (Pa)",
    );
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
    outcome.svg("Basal laws over speed.", &chart)
}

/// Checks the error of the quadratic approximation of the basal law of a Bingham fluid.
pub fn quadratic(outcome: &mut BenchmarkOutcome) {
    let errors = |a: f64| 100.0 * (plug_ratio(a) / plug_ratio_quadratic(a) - 1.0);
    let range = (-320..=320).map(|i| 10f64.powf(f64::from(i) / 80.0)).map(errors);
    let (smallest, maximum) = range.fold((0f64, 0f64), |(low, high), e| (low.min(e), high.max(e)));
    let rows = [
        ("V-21 quadratic: least error of τ_b (%)", -2.8, smallest),
        ("V-21 quadratic: largest error of τ_b (%)", 4.6, maximum),
    ];
    outcome.assert_all_close(rows, 0.02, "the sheet's two digits");
}
