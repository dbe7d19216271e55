//! Step wave in a bar (sheet: mpm A-08).

use colluvium::case::Snapshot;
use colluvium::plots::{LineChart, Series, Style};

use crate::analysis::MaxOrNan;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, run_mpm, stresses, vectors};

/// Benchmark of a step wave in a bar and of its reflection.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/step-wave",
    title: "Step wave in a bar and its reflection",
    source: "sheet: mpm A-08, closed form",
    short_seconds: Some(1),
    full_seconds: 1,
    run: benchmark,
};

/// Pressure on the end of the bar (Pa).
const PRESSURE: f64 = 0.1;
/// Impedance ρc (Pa s/m).
const IMPEDANCE: f64 = 10.0;
/// Wave speed (m/s).
const SPEED: f64 = 10.0;
/// Length of the bar (m).
const LENGTH: f64 = 25.0;
/// Cell size (m).
const CELL: f64 = 0.25;

/// Mean of `values` at the points between two positions.
fn mean(snapshot: &Snapshot, (low, high): (f64, f64), values: &[f64]) -> f64 {
    let inside = snapshot.positions.iter().zip(values).filter(|(x, _)| (low..high).contains(&x[0]));
    let (sum, count) = inside.fold((0.0, 0.0), |(sum, count), (_, value)| (sum + value, count + 1.0));
    sum / count
}

/// Axial stresses of the points (Pa).
fn axial(snapshot: &Snapshot) -> Vec<f64> {
    stresses(snapshot).iter().map(|s| s[0]).collect()
}

/// Checks stress and velocity behind a step wave and behind its reflection.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let report = run_mpm(&load_case("mpm/step-wave")?)?;
    let at = |time: f64| {
        let near = |frame: &&Snapshot| (frame.time - time).abs() < 0.005;
        report.frames.iter().find(near).ok_or(format!("no frame at {time} s"))
    };
    let mut chart = LineChart::new("Stress along the bar", "x (m)", "stress over pressure");
    // The front has reached 5 m, and after reflection 15 m.
    for (time, region, stress, speed) in
        [(2.0, (8.0, 22.0), -PRESSURE, -PRESSURE / IMPEDANCE), (4.0, (2.0, 12.0), -2.0 * PRESSURE, 0.0)]
    {
        let frame = at(time)?;
        let found = axial(frame);
        let velocity: Vec<f64> = vectors(frame, "velocity").iter().map(|v| v[0]).collect();
        let name = |what: &str| format!("{what} of the plateau after {time} s over the closed form");
        let reason = "the sheet's 1 %";
        outcome.assert_close(name("stress"), 1.0, 0.01, mean(frame, region, &found) / stress, reason);
        let off = mean(frame, region, &velocity) - speed;
        let scale = PRESSURE / IMPEDANCE;
        outcome.assert_below(
            format!("velocity of the plateau after {time} s: error over σ₀/ρc"),
            "0",
            (off / scale).abs(),
            0.01,
            reason,
        );
        let points = frame.positions.iter().zip(&found).map(|(x, s)| (x[0], s / PRESSURE)).collect();
        chart.series.push(Series::new(format!("t = {time} s"), points, Style::Line));
        let front = if time < LENGTH / SPEED { LENGTH - SPEED * time } else { SPEED * time - LENGTH };
        let (before, behind) = if time < LENGTH / SPEED { (0.0, -1.0) } else { (-2.0, -1.0) };
        let exact = vec![(0.0, before), (front, before), (front, behind), (LENGTH, behind)];
        chart.series.push(Series::new(format!("closed form, {time} s"), exact, Style::Dashed));
    }
    let highest = axial(at(2.0)?).iter().map(|s| -s / PRESSURE).max_or_nan();
    outcome.assert_below(
        "overshoot behind the front after 2 s",
        "0 (prototype 0.25 to 0.27)",
        highest - 1.0,
        0.4,
        "the sheet's 40 %",
    );
    // Half height at the wall, where the reflection doubles the stress.
    let wall: Vec<(f64, f64)> = report.frames.iter().map(|frame| (frame.time, axial(frame)[0])).collect();
    let arrival = wall.windows(2).find(|pair| pair[1].1 <= -PRESSURE).map_or(f64::NAN, |pair| {
        let [(t0, s0), (t1, s1)] = [pair[0], pair[1]];
        t0 + (t1 - t0) * (-PRESSURE - s0) / (s1 - s0)
    });
    let late = 2.0 * CELL / SPEED;
    outcome.assert_within(
        "arrival at the wall (s)",
        "2.5",
        arrival,
        (2.5 - late, 2.5 + late),
        "the sheet's 2h/c",
    );
    outcome.svg("Stress after 2 s and, reflected, after 4 s.", &chart)?;
    Ok(outcome)
}
