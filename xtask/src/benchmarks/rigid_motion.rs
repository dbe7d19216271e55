//! Rigid translation and rotation without stress (MPM sheet ).

use colluvium::case::plot::{LineChart, Series, Style};

use super::{Benchmark, Outcome, case, run, series, set, stresses, vectors};

/// The benchmark.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/rigid-motion",
    title: "Rigid translation and rotation make no stress",
    source: "MPM sheet A-04; objectivity",
    run: benchmark,
};

/// Spin of the disk (rad/s), its radius (m) and density (kg/m³).
const SPIN: f64 = 1.5707963267948966;
const RADIUS: f64 = 0.3;
const DENSITY: f64 = 1000.0;

fn benchmark(_quick: bool) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    for shape in ["linear", "ugimp", "cpgimp", "quadratic", "cubic"] {
        translation(&mut outcome, shape)?;
    }
    let mut chart = LineChart {
        title: "Angular momentum of a spinning disk".into(),
        x_label: "time (s)".into(),
        y_label: "over its initial value".into(),
        ..LineChart::default()
    };
    for law in ["linear-elastic", "neo-hookean"] {
        rotation(&mut outcome, &mut chart, law)?;
    }
    outcome.svg("A disk that turns once: what is lost goes with the stretch of its points.", &chart)?;
    Ok(outcome)
}

fn translation(outcome: &mut Outcome, shape: &str) -> Result<(), String> {
    let mut case = case("mpm/rigid-motion")?;
    set(&mut case, "shape", shape);
    let velocity = serde_json::json!({ "kind": "uniform", "value": [0.5, 0.3] });
    case.bodies[0].velocity = serde_json::from_value(velocity).map_err(|error| error.to_string())?;
    case.stages[0].duration = 1.2;
    let report = run(&case)?;
    let modulus = 1e6;
    let stress = stresses(&report.snapshot).iter().map(|s| s.norm()).fold(0.0, f64::max) / modulus;
    let velocity = vectors(&report.snapshot, "velocity");
    let change = velocity.iter().map(|v| (v[0] - 0.5).hypot(v[1] - 0.3));
    let reason = "round-off over the steps of a flight through 12 cells";
    outcome.below(format!("translation, {shape}: stress over E"), "0", stress, 1e-12, reason);
    outcome.below(
        format!("translation, {shape}: change of velocity (m/s)"),
        "0",
        change.fold(0.0, f64::max),
        1e-12,
        reason,
    );
    Ok(())
}

fn rotation(outcome: &mut Outcome, chart: &mut LineChart, law: &str) -> Result<(), String> {
    let mut case = case("mpm/rigid-motion")?;
    let material = serde_json::json!({
        "model": law, "density": DENSITY, "youngs_modulus": 1e6, "poissons_ratio": 0.3
    });
    case.materials
        .insert("body".into(), serde_json::from_value(material).map_err(|error| error.to_string())?);
    let report = run(&case)?;
    let largest = report.frames.iter().flat_map(stresses).map(|s| s.norm()).fold(0.0, f64::max);
    let centrifugal = DENSITY * (SPIN * RADIUS).powi(2);
    // At rest in the turning frame the largest stress of a disk is (3 - 2ν)/(8(1 - ν)) ρω²R² (plane
    // strain) in two directions; a sudden start doubles it.
    let ratio = largest / centrifugal;
    let claim = "below 2: what the centrifugal force makes, and no more";
    outcome.below(
        format!("one turn, {law}: largest stress over ρω²R²"),
        claim,
        ratio,
        2.0,
        "twice the closed form of the spinning disk, 0.43 √2, and room for the square grid",
    );
    let momentum = series(&report, "angular_momentum.z");
    let kept = momentum.last().map_or(f64::NAN, |l| l.1) / momentum[0].1;
    outcome.within(
        format!("one turn, {law}: angular momentum at the end over the start"),
        "1",
        kept,
        (0.98, 1.005),
        "FLIP with a lumped mass loses a little angular momentum in the mapping; 2 % in a turn on 12 cells",
    );
    let share = momentum.iter().map(|(t, l)| (*t, l / momentum[0].1)).collect();
    chart.series.push(Series::new(law, share, Style::Line));
    Ok(())
}
