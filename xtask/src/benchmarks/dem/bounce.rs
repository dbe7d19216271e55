//! Bouncing disk (sheet: dem §5, B3).

use std::f64::consts::PI;

use colluvium::case::Solver;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use crate::benchmarks::dem::case_builders::{disk_solver, load, method_options, output_value, step};
use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of a bouncing disk.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/bounce",
    title: "A bouncing disk, DEM",
    source: "sheet: dem §5, B3",
    short_seconds: Some(1),
    full_seconds: 1,
    run,
};

/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 9.81;
/// Coefficient of restitution.
const RESTITUTION: f64 = 0.5;

/// Checks the heights and times of the bounces of a disk against those of its coefficient of restitution.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut value = load("wall")?;
    value["gravity"] = json!([0, -GRAVITY]);
    value["bodies"][0]["shape"]["centre"] = json!([0, 1.5]);
    value["bodies"][0]["velocity"]["value"] = json!([0, 0]);
    // The sheet's bounds: weight over stiffness 1e-6 of the height, steps a thousandth of half a period.
    let stiffness = 1e6 * GRAVITY;
    let (dt, aloft) = (PI / f64::sqrt(stiffness) / 1000.0, PI / f64::sqrt(stiffness) / 25.0);
    let options = method_options(&mut value);
    options["pairs"][0]["normal"] =
        json!({ "law": "linear", "stiffness": stiffness, "restitution": RESTITUTION });
    options["time_step"] = json!(aloft);
    let mut solver = disk_solver(&value)?;
    // Steps are long in flight, where they are exact, and short near the floor.
    let (mut path, mut impacts, mut apexes, mut top) = (Vec::new(), Vec::new(), Vec::new(), 0.0f64);
    let (fall, mut touching, mut height) = ((2.0 / GRAVITY).sqrt(), false, 1.0);
    while solver.time() < 2.75 * fall {
        step(&mut solver, if height > 2e-3 { aloft } else { dt })?;
        height = solver.snapshot().positions[0][1] - 0.5;
        top = top.max(height);
        path.push((solver.time(), height));
        if height < 0.0 && !touching {
            impacts.push(solver.time());
            apexes.push(std::mem::take(&mut top));
        }
        touching = height < 0.0;
    }
    let reason = "B3: 1 %";
    for (n, exact) in [(1, 0.25), (2, 0.0625)] {
        let found = apexes.get(n).copied().unwrap_or(f64::NAN);
        outcome.assert_close(format!("B3, height after bounce {n} (m)"), exact, 0.01, found, reason);
    }
    for n in 1..=3usize {
        let bounces: f64 = (1..n).map(|k| RESTITUTION.powi(k as i32)).sum();
        let found = impacts.get(n - 1).copied().unwrap_or(f64::NAN);
        outcome.assert_close(
            format!("B3, time of impact {n} (s)"),
            fall * (1.0 + 2.0 * bounces),
            0.01,
            found,
            reason,
        );
    }
    outcome.assert_below(
        "B3, error of the energy balance over input",
        "0",
        output_value(&solver, "energy_error").abs(),
        0.01,
        "§2.14: 1 %",
    );
    let mut picture = LineChart::new("A bouncing disk, restitution 0.5", "time (s)", "height of the gap (m)");
    let exact =
        (0..400).map(|k| f64::from(k) * 2.75 * fall / 400.0).map(|t| (t, exact_height(t, fall))).collect();
    picture.series.push(Series::new("closed form", exact, Style::Dashed));
    let path_step = path.len() / 120;
    picture.series.push(Series::new("DEM", path.into_iter().step_by(path_step).collect(), Style::Markers));
    outcome.svg("B3: every apex is a quarter of the one before.", &picture)?;
    Ok(outcome)
}

/// Height of a bouncing point (m).
fn exact_height(time: f64, fall: f64) -> f64 {
    let (mut start, mut speed) = (fall, RESTITUTION * GRAVITY * fall);
    if time < fall {
        return 1.0 - 0.5 * GRAVITY * time * time;
    }
    while time > start + 2.0 * speed / GRAVITY {
        start += 2.0 * speed / GRAVITY;
        speed *= RESTITUTION;
    }
    let t = time - start;
    speed * t - 0.5 * GRAVITY * t * t
}
