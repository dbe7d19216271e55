//! How many disks a periodic cell needs (sheet: dem §5, B16).

use colluvium::plots::{Series, Style};
use serde_json::json;

use super::scene::{case, chart, load, options};
use crate::analysis::larger;
use crate::benchmarks::{Benchmark, Outcome, run_by, series};

/// The benchmark.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/representative-cell",
    title: "Biaxial tests of periodic cells of 75, 300 and 1000 disks, DEM",
    source: "Sun 2020, §2.1, Figs 1 and 2; sheet: dem §5, B16",
    quick: None,
    full: 120,
    run: |_| sizes(),
};

/// Disks of a cell.
const COUNTS: [u32; 3] = [75, 300, 1000];
/// Drawings of each.
const SEEDS: u64 = 4;
/// Durations of preparation, settling and shear (times √(m/P)), and the rate of the last.
const STAGES: [f64; 3] = [150.0, 30.0, 83.0];
const RATE: f64 = 3e-4;

/// Sine of the friction angle at the peak, and the anisotropy of the contacts before the shear.
fn test(count: u32, seed: u64) -> Result<(f64, f64), String> {
    let mut value = load("biaxial")?;
    let side = value["domain"]["max"][0].as_f64().ok_or("no domain")? * (f64::from(count) / 1600.0).sqrt();
    value["domain"]["max"] = json!([side, side]);
    value["bodies"][0]["shape"]["max"] = json!([side, side]);
    for (k, duration) in STAGES.iter().enumerate() {
        value["stages"][k]["duration"] = json!(duration);
    }
    options(&mut value)["seed"] = json!(seed);
    let report = run_by("dem", &case(&value)?)?;
    let start = STAGES[0] + STAGES[1];
    let sheared = |name: &str| {
        series(&report, name).into_iter().filter(move |(time, _)| *time > start - 0.3).map(|(_, value)| value)
    };
    let sines: Vec<f64> = sheared("cell_stress.yy")
        .zip(sheared("cell_stress.xx"))
        .map(|(down, side)| (down - side) / (down + side))
        .collect();
    // Over a window of strain of 5e-4, four rows (sheet: dem §3.11).
    let window = (5e-4 / RATE / 0.5).round() as usize + 1;
    let peak = sines.windows(window).map(|part| part.iter().sum::<f64>() / window as f64).fold(0.0, f64::max);
    let anisotropy = sheared("fabric.anisotropy").next().ok_or("no fabric")?;
    Ok((peak, anisotropy))
}

fn sizes() -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    let mut picture =
        chart("Strength of periodic cells of disks", "disks", "sine of the friction angle at the peak");
    picture.log = true;
    let (mut points, mut spreads) = (Vec::new(), Vec::new());
    for count in COUNTS {
        let found: Vec<(f64, f64)> = (1..=SEEDS).map(|seed| test(count, seed)).collect::<Result<_, _>>()?;
        let mean = found.iter().map(|own| own.0).sum::<f64>() / SEEDS as f64;
        let square = found.iter().map(|own| (own.0 - mean).powi(2)).sum::<f64>() / (SEEDS - 1) as f64;
        spreads.push(square.sqrt());
        points.extend(found.iter().map(|own| (f64::from(count), own.0)));
        let most = found.iter().map(|own| own.1).fold(0.0, larger);
        let name = format!("{count} disks: largest anisotropy of the contacts before the shear");
        if count >= 300 {
            outcome.below(name, "even", most, 0.15, "B16: below 0.15 for 300 grains and more");
        } else {
            outcome.show(
                name,
                "uneven in the source",
                most,
                "not judged: the source calls 75 grains too few",
            );
        }
        let reason = "not judged: no values in the source";
        outcome.show(format!("{count} disks: sine of the friction angle at the peak"), "", mean, reason);
    }
    let reason = "B16: it decreases with the number";
    outcome.below(
        "standard deviation of it between drawings, 1000 disks over 75",
        "below one",
        spreads[2] / spreads[0],
        1.0,
        reason,
    );
    let reason = "not judged: four drawings tell it to a half";
    outcome.show("the same, 300 disks over 75", "below one", spreads[1] / spreads[0], reason);
    picture.series.push(Series::new("four drawings of each", points, Style::Markers));
    outcome.svg("B16: fewer grains scatter more.", &picture)?;
    Ok(outcome)
}
