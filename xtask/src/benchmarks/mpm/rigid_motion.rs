//! Rigid translation and rotation without stress (sheet: mpm A-04). Rotation with stress is in `kinematics`.

use colluvium::plots::{LineChart, Series, Style};

use colluvium::constitutive::SymTensor;

use crate::analysis::MaxOrNan;
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, load_case, measure_series, run_mpm, set_mpm_option, stresses, vectors,
};

/// Benchmark of rigid translation and rotation without stress.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/rigid-motion",
    title: "Rigid translation and rotation make no stress",
    source: "sheet: mpm A-04 (translation); objectivity",
    short_seconds: Some(15),
    full_seconds: 15,
    run: benchmark,
};

/// Spin of the disk (rad/s).
const SPIN: f64 = std::f64::consts::FRAC_PI_2;
/// Radius of the disk (m).
const RADIUS: f64 = 0.3;
/// Density of the disk (kg/m³).
const DENSITY: f64 = 1000.0;

/// Young's modulus (Pa); Poisson's ratio is 0.3.
const YOUNG: f64 = 1e6;

/// Checks translation and rotation of unstressed bodies.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    for shape in ["linear", "ugimp", "cpgimp", "quadratic", "cubic", "cpdi", "cpdi2", "dual-domain"] {
        translation(&mut outcome, shape)?;
    }
    let mut chart =
        LineChart::new("Angular momentum of a spinning disk", "time (s)", "over its initial value");
    for law in ["linear-elastic", "neo-hookean"] {
        let coarse = rotation(&mut outcome, &mut chart, law, 0.05)?;
        let fine = rotation(&mut outcome, &mut chart, law, 0.025)?;
        let reason = "the error comes from the mapping and is of second order: 4, with room for 3";
        let claim = "about 4 (second order)";
        let name = format!("one turn, {law}: loss of angular momentum, coarse over fine");
        outcome.assert_within(name, claim, coarse / fine, (3.0, f64::INFINITY), reason);
    }
    outcome.svg(
        "A disk that turns once on two grids: what the mapping loses falls with the cell size.",
        &chart,
    )?;
    Ok(outcome)
}

/// Checks that a translated body keeps its velocity and has no stress.
fn translation(outcome: &mut BenchmarkOutcome, shape: &str) -> Result<(), String> {
    let mut case = load_case("mpm/rigid-motion")?;
    set_mpm_option(&mut case, "shape", shape);
    let velocity = serde_json::json!({ "kind": "uniform", "value": [0.5, 0.3] });
    case.bodies[0].velocity = serde_json::from_value(velocity).map_err(|error| error.to_string())?;
    case.stages[0].duration = 1.2;
    let report = run_mpm(&case)?;
    let stress = stresses(&report.snapshot).iter().map(SymTensor::norm).max_or_nan() / YOUNG;
    let velocity = vectors(&report.snapshot, "velocity");
    let change = velocity.iter().map(|v| (v[0] - 0.5).hypot(v[1] - 0.3));
    let reason = "round-off over the steps of a flight through 12 cells";
    outcome.assert_below(format!("translation, {shape}: stress over E"), "0", stress, 1e-12, reason);
    outcome.assert_below(
        format!("translation, {shape}: change of velocity (m/s)"),
        "0",
        change.max_or_nan(),
        1e-12,
        reason,
    );
    Ok(())
}

/// Checks one turn of a disk on cells of edge `cell` (m), and returns the lost share of the angular momentum.
fn rotation(
    outcome: &mut BenchmarkOutcome,
    chart: &mut LineChart,
    law: &str,
    cell: f64,
) -> Result<f64, String> {
    let mut case = load_case("mpm/rigid-motion")?;
    let material = serde_json::json!({
        "model": law, "density": DENSITY, "youngs_modulus": YOUNG, "poissons_ratio": 0.3
    });
    case.materials
        .insert("body".into(), serde_json::from_value(material).map_err(|error| error.to_string())?);
    set_mpm_option(&mut case, "cell_size", cell);
    set_mpm_option(&mut case, "stress_update", "usl");
    let report = run_mpm(&case)?;
    let largest = report.frames.iter().flat_map(stresses).map(|s| s.norm()).max_or_nan();
    // Physical part: a spinning disk in plane strain carries 0.43 ρω²R² in two directions, twice that after a sudden start. Part of the
    // mapping: a node at a corner of the surface has the velocity of points half a cell inside along both axes, an error of ω h/√2, against
    // the impedance ρ c.
    let centrifugal = 2.0 * 0.43 * 2f64.sqrt() * DENSITY * (SPIN * RADIUS).powi(2);
    let wave = (YOUNG * 0.7 / (1.3 * 0.4) / DENSITY).sqrt();
    let mapping = DENSITY * wave * SPIN * cell / 2f64.sqrt();
    let reason = "derived: twice the stress of the spinning disk, and the impedance ρ c times the velocity error \
                  ω h/√2 of the lumped mass at a corner of the surface";
    let name = format!("one turn, {law}, cells of {cell} m: largest stress (Pa)");
    let claim = "none from the rotation itself";
    outcome.assert_below(name, claim, largest, centrifugal + mapping, reason);
    let momentum = measure_series(&report, "angular_momentum.z");
    let kept = momentum.last().map_or(f64::NAN, |l| l.1) / momentum[0].1;
    let share = momentum.iter().map(|(t, l)| (*t, l / momentum[0].1)).collect();
    chart.series.push(Series::new(format!("{law}, cells of {cell} m"), share, Style::Line));
    Ok(1.0 - kept)
}
