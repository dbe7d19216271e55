//! Point of a weak layer under compression: the anticrack law against the classical one (sheet: snow-mpm A2, V8).

use colluvium::constitutive::{InitialCondition, Mat3, MaterialSpec, Motion, SymTensor};
use colluvium::plots::{LineChart, Series, Style};
use serde_json::{Value, json};

use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of the compression of a weak layer by the classical law and by the anticrack law.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "snow-mpm/softening",
    title: "Compression of a weak layer: classical softening and that of the anticrack",
    source: "Gaume et al. 2020, section 4.2 and Fig. 5c, d; reference values: sheet: snow-mpm A2, V8",
    short_seconds: Some(1),
    full_seconds: 1,
    run: benchmark,
};

/// Logarithmic compression of a step.
const STEP: f64 = 1e-6;

/// Row of a compression path: compression, `p`, `q` and axial stress (Pa, Kirchhoff, compression positive), and `p0` (Pa).
struct SofteningRow {
    strain: f64,
    pressure: f64,
    deviator: f64,
    axial: f64,
    strength: f64,
}

/// Weak layer of the sheet with some keys changed.
fn layer(keys: &Value) -> Value {
    let mut spec = json!({
        "model": "cohesive-cam-clay", "density": 100, "youngs_modulus": 1e6, "poissons_ratio": 0.3, "critical_state_slope": 1.2,
        "cohesion_ratio": 0.3, "compressive_strength": 3000, "hardening_factor": 0.02, "integration": "explicit"
    });
    for (key, value) in keys.as_object().into_iter().flatten() {
        spec[key] = value.clone();
    }
    spec
}

/// Path of a point in `steps` steps of uniaxial compression without lateral strain.
fn compression_path(keys: &Value, step: f64, steps: usize) -> Result<Vec<SofteningRow>, String> {
    let spec: MaterialSpec = serde_json::from_value(layer(keys)).map_err(|error| error.to_string())?;
    let law = spec.build().map_err(|error| error.to_string())?;
    let start = InitialCondition { stress: SymTensor::ZERO, density: 100.0 };
    let (mut stress, mut states) = law.initial(&[start]).map_err(|error| error.source.to_string())?;
    let f = Mat3([[1.0, 0.0, 0.0], [0.0, (-step).exp(), 0.0], [0.0, 0.0, 1.0]]);
    let motion = Motion::from_deformation(&f, 1e-3, 100.0, 1.0).ok_or("singular motion")?;
    let number = law.output_names().iter().position(|name| *name == "compressive_strength");
    let mut out = vec![0.0; law.output_names().len()];
    let mut path = Vec::with_capacity(steps);
    for number_of_step in 1..=steps {
        law.update(&[motion], &mut stress, &mut states.blocks_mut()[0])
            .map_err(|error| error.source.to_string())?;
        law.outputs(&stress, &states.blocks()[0], &mut out);
        let strain = step * number_of_step as f64;
        let kirchhoff = stress[0] * (-strain).exp();
        path.push(SofteningRow {
            strain,
            pressure: kirchhoff.pressure(),
            deviator: kirchhoff.q(),
            axial: -kirchhoff[1],
            strength: number.map_or(f64::NAN, |i| out[i]),
        });
    }
    Ok(path)
}

/// Row of a compression path at the compressive strain `strain`.
fn row_at(path: &[SofteningRow], strain: f64) -> &SofteningRow {
    let number = path.partition_point(|row| row.strain < strain - 0.5 * STEP);
    &path[number.min(path.len() - 1)]
}

/// Checks the sequence of collapse of a weak layer by the anticrack law, against classical softening.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let brittle = json!({ "hardening": { "kind": "weak-layer", "softening_factor": 50 } });
    let anticrack = compression_path(&brittle, STEP, 100_000)?;
    let classical = compression_path(&json!({}), STEP, 100_000)?;
    sequence(&mut outcome, &anticrack);
    classic(&mut outcome, &classical)?;
    for (title, label, value) in [
        ("Pressure", "p (Pa)", (|row: &SofteningRow| row.pressure) as fn(&SofteningRow) -> f64),
        ("Deviatoric stress", "q (Pa)", |row: &SofteningRow| row.deviator),
    ] {
        let curve = |path: &[SofteningRow]| {
            path[..20_000].iter().step_by(20).map(|row| (row.strain, value(row))).collect()
        };
        let chart = LineChart {
            series: vec![
                Series::new("classical", curve(&classical), Style::Line),
                Series::new("anticrack", curve(&anticrack), Style::Line),
            ],
            ..LineChart::new(title, "compression (logarithmic)", label)
        };
        outcome.svg("A2: a point under uniaxial compression without strain across.", &chart)?;
    }
    Ok(outcome)
}

/// Checks the sequence of the anticrack: elastic loading, failure, softening, collapse and jamming.
fn sequence(outcome: &mut BenchmarkOutcome, path: &[SofteningRow]) {
    let yields = path.iter().position(|row| row.strength < 3000.0 - 1e-6).unwrap_or(0);
    let collapses = path.iter().position(|row| row.strength == 0.0).unwrap_or(path.len() - 1);
    let reason = "the sheet's tolerance with steps of 1e-6; first order in the step";
    outcome.assert_close("A2 failure: compression", 0.002_201_612_1, 1e-3, path[yields].strain, reason);
    let peak = path[..=collapses].iter().map(|row| row.axial).fold(0.0, f64::max);
    outcome.assert_close("A2 failure: largest axial stress (Pa)", 2970.95, 5e-3, peak, reason);
    for (strain, exact) in
        [(0.0025, [1941.526, 1519.592]), (0.003, [1941.147, 1096.842]), (0.0035, [1291.412, 357.461])]
    {
        let row = row_at(path, strain);
        let reason = "the sheet's tolerance on the softening branch, 5 %";
        outcome.assert_close(
            format!("A2 softening: p at {strain} (Pa)"),
            exact[0],
            0.05,
            row.pressure,
            reason,
        );
        outcome.assert_close(
            format!("A2 softening: q at {strain} (Pa)"),
            exact[1],
            0.05,
            row.deviator,
            reason,
        );
    }
    let both = path[yields..collapses].windows(2).filter(|pair| pair[1].deviator > pair[0].deviator).count();
    let share = both as f64 / (collapses - yields).max(1) as f64;
    let reason = "the source: p and q fall together; p follows within the first steps";
    outcome.assert_below("A2 softening: share of steps in which q grows", "0", share, 1e-3, reason);
    outcome.assert_close("A2 collapse: compression", 0.0036, 0.02, path[collapses].strain, reason);
    let area: f64 = path[..=collapses].iter().map(|row| row.axial * STEP).sum();
    outcome.assert_close("A2 collapse: work to it (J/m³)", 6.809, 0.02, area, "the sheet's tolerance");
    let after = path[collapses..].iter().find(|row| row.strain > path[collapses].strain + 1e-5);
    let left = after.map_or(f64::NAN, |row| row.axial / peak);
    outcome.assert_below(
        "A2 collapse: axial stress left over the largest",
        "0.01",
        left,
        0.01,
        "no strength is left",
    );
    for (strain, exact) in [(0.01, 118.9), (0.02, 305.7), (0.05, 865.9), (0.1, 1799.5)] {
        let name = format!("A2 jamming: axial stress at {strain} (Pa)");
        outcome.assert_close(name, exact, 0.02, row_at(path, strain).axial, "the sheet's tolerance");
    }
}

/// Checks the classical law: after yield the pressure grows, and the deviator first falls and then grows.
fn classic(outcome: &mut BenchmarkOutcome, path: &[SofteningRow]) -> Result<(), String> {
    let reason = "values of the sheet's own integration; first order in the step";
    for (strain, exact) in [(0.003, 3191.8), (0.005, 3375.8), (0.02, 3664.5), (0.1, 5130.0)] {
        let name = format!("A2 classical: axial stress at {strain} (Pa)");
        outcome.assert_close(name, exact, 5e-3, row_at(path, strain).axial, reason);
    }
    let largest = path.iter().take(5000).map(|row| row.deviator).fold(0.0, f64::max);
    outcome.assert_close("A2 classical: largest q before it falls (Pa)", 1693.0, 5e-3, largest, reason);
    outcome.assert_close("A2 classical: q at 0.01 (Pa)", 1041.0, 5e-3, row_at(path, 0.01).deviator, reason);
    let falls = path.windows(2).filter(|pair| pair[1].pressure < pair[0].pressure).count();
    outcome.assert_within(
        "A2 classical: steps in which p falls",
        "0",
        falls as f64,
        (0.0, 0.0),
        "the source: p grows monotonically",
    );
    let stiff = compression_path(&json!({ "hardening_factor": 1 }), 1e-5, 5000)?;
    for (strain, exact) in [(0.01, 6857.0), (0.05, 26_971.0)] {
        let name = format!("A2 classical, ξ = 1: axial stress at {strain} (Pa)");
        let number = (strain / 1e-5_f64).round() as usize - 1;
        outcome.assert_close(name, exact, 5e-3, stiff[number].axial, reason);
    }
    Ok(())
}
