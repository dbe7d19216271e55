//! Laterally confined bars: vibration and self-weight (sheet: snow-mpm V12, V13).

use colluvium::plots::{LineChart, Series, Style};
use serde_json::{Value, json};

use super::{case_with_options, run_snow_case};
use crate::analysis::MaxOrNan;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, initial_positions, measure_series, stresses, vectors};

/// Benchmark of the confined longitudinal vibration of a bar.
pub const VIBRATION: Benchmark = Benchmark {
    id: "snow-mpm/vibration",
    title: "Confined longitudinal vibration of a bar",
    source: "sheet: snow-mpm V12, closed form",
    short_seconds: Some(3),
    full_seconds: 3,
    run: vibration,
};

/// Benchmark of a column under its weight at finite strain.
pub const SELF_WEIGHT: Benchmark = Benchmark {
    id: "snow-mpm/self-weight",
    title: "Column under its weight at finite strain",
    source: "sheet: snow-mpm V13, closed form",
    short_seconds: Some(5),
    full_seconds: 5,
    run: self_weight,
};

/// Density of the bar (kg/m³).
const DENSITY: f64 = 400.0;
/// Modulus of confined compression over Young's modulus, for a Poisson's ratio of 0.3.
const CONFINED_MODULUS: f64 = 0.7 / (1.3 * 0.4);

/// Times (s) at which a series passes zero, by linear interpolation.
fn zeros(points: &[(f64, f64)]) -> Vec<f64> {
    let crossing = |pair: &[(f64, f64)]| {
        let [(t, a), (u, b)] = [pair[0], pair[1]];
        (a * b < 0.0).then(|| t + (u - t) * a / (a - b))
    };
    points.windows(2).filter_map(crossing).collect()
}

/// Period over that of the closed form, and ratio of the momentum two periods after the first peak to that peak.
fn period_and_momentum(cells: usize, options: &Value) -> Result<[f64; 2], String> {
    let mut case = case_with_options("bar", options)?;
    let period = 4.0 / (CONFINED_MODULUS * 1e6 / DENSITY).sqrt();
    let speed = 1e-4 * 2.0 * std::f64::consts::PI / period;
    crate::benchmarks::set_method_option(&mut case, "snow-mpm", "cell_size", 1.0 / cells as f64);
    case.bodies[0].velocity = serde_json::from_value(
        json!({ "kind": "sine", "amplitude": [speed], "wave_vector": [std::f64::consts::FRAC_PI_2] }),
    )
    .map_err(|error| error.to_string())?;
    case.stages[0].duration = 3.4 * period;
    case.output.measures = Some(period / 400.0);
    let momentum = measure_series(&run_snow_case(&case)?, "momentum.x");
    let zeros = zeros(&momentum);
    let [Some(first), Some(later)] = [zeros.first(), zeros.get(4)] else {
        return Err("the bar does not swing for three periods".to_owned());
    };
    let found = 0.5 * (later - first);
    let peak = |around: f64| {
        let near = momentum.iter().filter(|(t, _)| (t - around).abs() < 0.2 * found);
        near.map(|(_, p)| *p).max_or_nan()
    };
    Ok([found / period, peak(3.0 * found) / peak(found)])
}

/// Checks the period of confined longitudinal vibration.
fn vibration(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart = LineChart {
        log: true,
        ..LineChart::new("Error of the period", "cells", "period over that of the closed form, less 1")
    };
    for (shape, claims) in [("cubic", [1.0537, 1.0246, 1.0115]), ("quadratic", [1.0385, 1.0174, 1.0082])] {
        let mut errors = Vec::new();
        for (cells, claim) in [10, 20, 40].into_iter().zip(claims) {
            let options = json!({ "shape": shape, "transfer": "flip", "flip_ratio": 1 });
            let [period, _] = period_and_momentum(cells, &options)?;
            errors.push((cells as f64, period - 1.0));
            let (name, text) = (
                format!("V12 {shape}, {cells} cells: period over exact"),
                format!("{claim} (sheet's prototype)"),
            );
            if cells == 20 {
                outcome.assert_within(name, &text, period, (0.97, 1.03), "the sheet's criterion");
            } else {
                outcome.info(name, &text, period, "the sheet judges 20 cells, and the order");
            }
        }
        let name = format!("V12 {shape}: error of 20 cells over that of 40");
        let reason = "the sheet's criterion: halving with the cell; a tenth is left to the next order";
        outcome.assert_within(name, "2 (first order)", errors[1].1 / errors[2].1, (1.8, 2.4), reason);
        chart.series.push(Series::new(shape, errors, Style::Line));
    }
    for (name, claim, options) in [
        ("FLIP 1", "0.997", json!({ "transfer": "flip", "flip_ratio": 1 })),
        ("FLIP 0.99", "0.992", json!({ "transfer": "flip", "flip_ratio": 0.99 })),
        ("FLIP 0.95", "0.971", json!({ "transfer": "flip", "flip_ratio": 0.95 })),
        ("APIC", "0.991", json!({ "transfer": "apic" })),
        ("PIC", "0.661", json!({ "transfer": "flip", "flip_ratio": 0 })),
    ] {
        let [_, kept] = period_and_momentum(20, &options)?;
        let text = format!("{claim} (sheet's prototype)");
        outcome.info(
            format!("V12 {name}, 20 cells: amplitude after two periods"),
            &text,
            kept,
            "no bound in the sheet",
        );
    }
    outcome
        .svg("The fixed wall acts on the nodes on and behind it: the bar swings as a longer one.", &chart)?;
    Ok(outcome)
}

/// Settlement over the height, and the largest errors of the stress beyond two and beyond three cells from the wall, over the stress at the
/// base.
fn settlement_and_errors(cell: f64, shape: &str) -> Result<[f64; 3], String> {
    let case = case_with_options("bar-weight", &json!({ "shape": shape, "cell_size": cell }))?;
    let snapshot = run_snow_case(&case)?.snapshot;
    let start = initial_positions(&snapshot);
    let moved = vectors(&snapshot, "displacement");
    let top = start.iter().zip(&moved).max_by(|a, b| a.0[0].total_cmp(&b.0[0]));
    let settlement = top.map_or(f64::NAN, |(_, u)| -u[0]);
    let weight = DENSITY * 100.0;
    let off = |(x, s): (&[f64; 2], &colluvium::constitutive::SymTensor)| (s[0] / weight + 1.0 - x[0]).abs();
    let found = stresses(&snapshot);
    let beyond = |cells: f64| {
        let away = start.iter().zip(&found).filter(|(x, _)| x[0] > cells * cell);
        away.map(off).max_or_nan()
    };
    Ok([settlement, beyond(2.0), beyond(3.0)])
}

/// Checks settlement and stress of a column under its weight at finite strain.
fn self_weight(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let exact = 0.045_180_7;
    // Settlements of the sheet's prototype, and stress errors beyond two and three cells in its one-dimensional program.
    let prototypes = [
        ("cubic", [0.046996, 0.046090, 0.045642], [[0.0404, 0.0396, 0.0400], [0.0170, 0.0174, 0.0176]]),
        ("quadratic", [0.046394, 0.045793, 0.045489], [[0.0355, 0.0380, 0.0388], [0.0104, 0.0278, 0.0242]]),
    ];
    for (shape, settlements, stresses) in prototypes {
        let mut errors = Vec::new();
        for (k, cells) in [20.0, 40.0, 80.0].into_iter().enumerate() {
            let [settlement, off @ ..] = settlement_and_errors(1.0 / cells, shape)?;
            errors.push(settlement / exact - 1.0);
            let text = format!("{exact}; {} (sheet's prototype)", settlements[k]);
            let name = format!("V13 {shape}, {cells} cells: settlement over height");
            if cells == 40.0 {
                let reason = "the sheet's criterion: 2.5 %";
                outcome.assert_within(name, &text, settlement, (0.975 * exact, 1.025 * exact), reason);
            } else {
                outcome.info(name, &text, settlement, "the sheet judges 40 cells, and the order");
            }
            for ((far, off), claims) in ["two", "three"].into_iter().zip(off).zip(stresses) {
                let name = format!(
                    "V13 {shape}, {cells} cells: largest error of stress beyond {far} cells over that at the base"
                );
                let (claim, band) = (claims[k], (claims[k] - 0.001, claims[k] + 0.001));
                let reason =
                    "the sheet's reference, as corrected, by a program of one dimension: 0.1 % of the base";
                outcome.assert_within(name, &claim.to_string(), off, band, reason);
            }
        }
        let name = format!("V13 {shape}: error of 40 cells over that of 80");
        let reason = "the sheet's criterion: halving with the cell; a tenth is left to the next order";
        outcome.assert_within(name, "2 (first order)", errors[1] / errors[2], (1.8, 2.4), reason);
    }
    Ok(outcome)
}
