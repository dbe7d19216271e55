//! Crystals of equal grains: elasticity and strength (sheet: dem §5, B10).

use colluvium::case::RunReport;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::{Value, json};

use crate::analysis::{MaxOrNan, max_or_nan};
use crate::benchmarks::dem::case_builders::{GrainData, grain_file, load, method_options, parse_case};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, measure_series, run_in_memory};

/// Benchmark of the elastic moduli of crystals of equal grains.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/crystal",
    title: "Elastic moduli of crystals of disks and spheres, DEM",
    source: "sheet: dem §5, B10; §0, 3D crystal",
    short_seconds: Some(1),
    full_seconds: 1,
    run,
};

/// Benchmark of the strength of a hexagonal crystal of disks.
pub const STRENGTH: Benchmark = Benchmark {
    id: "dem/crystal-strength",
    title: "Strength of a hexagonal crystal of disks, DEM",
    source: "Rowe 1962; sheet: dem §5, B10",
    short_seconds: Some(5),
    full_seconds: 20,
    run: strength,
};

/// Distance of neighbouring grains over their diameter.
const PITCH: f64 = 1.0 - 1e-5;
/// Strain of the crystal in each measurement of a modulus.
const STRAIN: f64 = 1e-6;
/// Contact stiffness of the compressed crystal (N/m).
const STIFFNESS: f64 = 1e4;
/// Pressure of the compressed crystal (Pa).
const PRESSURE: f64 = 1.0;

/// Places the grains of a crystal in a periodic cell of these widths.
fn fill(value: &mut Value, name: &str, places: &[Vec<f64>], widths: &[f64]) -> Result<(), String> {
    let still = vec![0.0; widths.len()];
    let grains: Vec<GrainData> = places.iter().map(|place| (place.clone(), 0.5, still.clone())).collect();
    value["bodies"][0]["points"] = grain_file(name, &grains)?;
    value["bodies"][0]["shape"] = json!({ "kind": "box", "min": still, "max": widths });
    value["domain"]["min"] = json!(still);
    value["domain"]["max"] = json!(widths);
    Ok(())
}

/// Positions of the grains of a hexagonal crystal with rows along x, and the widths of its cell.
fn hexagonal(columns: usize, rows: usize, pitch: f64) -> (Vec<Vec<f64>>, Vec<f64>) {
    let height = 0.75f64.sqrt() * pitch;
    let place = |k: usize| {
        let (column, row) = (k % columns, k / columns);
        vec![pitch * (column as f64 + 0.25 + 0.5 * (row % 2) as f64), height * (row as f64 + 0.5)]
    };
    ((0..columns * rows).map(place).collect(), vec![pitch * columns as f64, height * rows as f64])
}

/// Positions of the grains of a face-centred cubic crystal with cubes along the axes, and the widths of its cell.
fn face_centred(cubes: usize, pitch: f64) -> (Vec<Vec<f64>>, Vec<f64>) {
    let edge = 2f64.sqrt() * pitch;
    let within = [[0.25, 0.25, 0.25], [0.75, 0.75, 0.25], [0.75, 0.25, 0.75], [0.25, 0.75, 0.75]];
    let mut places = Vec::new();
    for k in 0..cubes.pow(3) {
        let cube = [k % cubes, k / cubes % cubes, k / (cubes * cubes)];
        places.extend(within.map(|at| (0..3).map(|c| edge * (cube[c] as f64 + at[c])).collect::<Vec<f64>>()));
    }
    (places, vec![edge * cubes as f64; 3])
}

/// Checks the elastic moduli of a hexagonal and of a face-centred crystal against those of lattice theory.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let (kn, kt) = (1.0, 0.5);
    let root = 3f64.sqrt() / 4.0;
    let flat = load("crystal")?;
    let mut disks = flat.clone();
    let (places, widths) = hexagonal(10, 10, PITCH);
    fill(&mut disks, "hexagonal", &places, &widths)?;
    let claims = [root * (3.0 * kn + kt), root * (kn - kt), root * (kn + kt)];
    moduli(&mut outcome, "hexagonal disks", &disks, 2, claims)?;
    let mut spheres = load("crystal-spheres")?;
    let (places, widths) = face_centred(4, PITCH);
    fill(&mut spheres, "face-centred", &places, &widths)?;
    let root = 2f64.sqrt();
    let claims = [root * (kn + kt), (kn - kt) / root, (kn + kt) / root];
    moduli(&mut outcome, "face-centred spheres", &spheres, 3, claims)?;
    Ok(outcome)
}

/// Checks the moduli C₁₁, C₁₂ and C₄₄, measured by strains along x and y and by a shear.
fn moduli(
    outcome: &mut BenchmarkOutcome,
    name: &str,
    value: &Value,
    dimension: usize,
    claims: [f64; 3],
) -> Result<(), String> {
    let reason = "B10: 0.1 %";
    let stiffness = |key: &str| -> Result<RunReport, String> {
        let mut value = value.clone();
        method_options(&mut value)["stages"]["strain"]["cell"] = json!({ key: { "rate": STRAIN } });
        run_in_memory("dem", &parse_case(&value)?)
    };
    let (along, across, shear) = (stiffness("xx")?, stiffness("yy")?, stiffness("xy")?);
    let modulus = |report: &RunReport, entry: &str| {
        let stress = measure_series(report, &format!("cell_stress.{entry}"));
        // The row at the start has no forces yet.
        (stress[stress.len() - 1].1 - stress[1].1) / STRAIN
    };
    let [c11, c12, c44] = claims;
    outcome.assert_close(
        format!("B10, {name}: C₁₁ (N/m over d^(D-2))"),
        c11,
        1e-3,
        modulus(&along, "xx"),
        reason,
    );
    outcome.assert_close(format!("B10, {name}: C₂₂"), c11, 1e-3, modulus(&across, "yy"), reason);
    outcome.assert_close(format!("B10, {name}: C₁₂"), c12, 1e-3, modulus(&along, "yy"), reason);
    outcome.assert_close(format!("B10, {name}: C₂₁"), c12, 1e-3, modulus(&across, "xx"), reason);
    outcome.assert_close(format!("B10, {name}: shear"), c44, 1e-3, modulus(&shear, "xy"), reason);
    let mixed = max_or_nan(modulus(&shear, "xx").abs(), modulus(&along, "xy").abs());
    outcome.assert_below(
        format!("B10, {name}: shear with stretch"),
        "0",
        mixed,
        1e-3,
        "B10: 0.1 % of the stiffness, 1 N/m",
    );
    if dimension == 3 {
        let rest = [modulus(&along, "zz") - c12, modulus(&shear, "yz"), modulus(&shear, "xz")];
        let worst = rest.iter().map(|value| value.abs()).max_or_nan();
        outcome.assert_below(
            format!("B10, {name}: C₁₃ less C₁₂, other shears"),
            "0",
            worst,
            1e-3,
            "B10: 0.1 % of the stiffness",
        );
    }
    Ok(())
}

/// Checks the strength of a crystal of horizontal rows that is compressed from above: `tan 60° tan(60° + φ)`.
fn strength(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut picture =
        LineChart::new("A hexagonal crystal is compressed", "vertical strain", "ratio of stresses");
    let all = [(0.0, 3.0), (0.1, 3.838), (0.2, 5.120), (0.3, 7.327), (0.4, 12.02)];
    for &(friction, exact) in if quick { &all[1..3] } else { &all[..] } {
        let report = compress(friction)?;
        let (vertical, lateral) =
            (measure_series(&report, "cell_stress.yy"), measure_series(&report, "cell_stress.xx"));
        let height = measure_series(&report, "cell.y");
        let curve: Vec<(f64, f64)> = (1..vertical.len())
            .map(|k| (-(height[k].1 / height[0].1).ln(), vertical[k].1 / lateral[k].1))
            .collect();
        let peak = curve.iter().map(|(_, ratio)| *ratio).max_or_nan();
        outcome.assert_close(
            format!("B10, friction {friction}: ratio of stresses at the peak"),
            exact,
            0.03,
            peak,
            "B10: 3 %",
        );
        picture.series.push(Series::new(format!("friction {friction}"), curve, Style::Line));
        let largest = height.last().map_or(0.0, |last| -(last.1 / height[0].1).ln());
        picture.series.push(Series::new("", vec![(0.0, exact), (largest, exact)], Style::Dashed));
    }
    outcome.svg("B10: broken lines are tan 60° tan(60° + φ).", &picture)?;
    Ok(outcome)
}

/// Runs the compression of a hexagonal crystal with a friction coefficient of its contacts.
fn compress(friction: f64) -> Result<RunReport, String> {
    let mut value = load("crystal-strength")?;
    // Contact forces f of an isotropic state have the pressure √3 f / d.
    let pitch = 1.0 - PRESSURE / (3f64.sqrt() * STIFFNESS);
    let (places, widths) = hexagonal(8, 8, pitch);
    fill(&mut value, "strength", &places, &widths)?;
    method_options(&mut value)["pairs"][0]["friction"]["coefficient"] = json!(friction);
    run_in_memory("dem", &parse_case(&value)?)
}
