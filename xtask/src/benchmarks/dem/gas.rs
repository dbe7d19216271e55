//! Elastic gas: energy over many collisions, and reversibility (sheet: dem §5, B4).

use std::collections::BTreeSet;

use colluvium::case::Solver;
use colluvium::dem::DemSolver;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use crate::analysis::{MaxOrNan, max_or_nan};
use crate::benchmarks::dem::case_builders::{
    GrainData, disk_solver, grain_file, load, method_options, output_value, step,
};
use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of the energy and the reversibility of an elastic gas of disks.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/gas",
    title: "An elastic gas of 200 disks: energy and reversal, DEM",
    source: "sheet: dem §5, B4",
    short_seconds: Some(4),
    full_seconds: 40,
    run,
};

/// Number of collisions over which the energy is recorded.
const COLLISIONS: usize = 10_000;
/// Angular frequency of two grains in contact, `√(2 k)`.
const FREQUENCY: f64 = 141.421_356_237;

/// Checks that an elastic gas of disks keeps its energy, and returns to its start when the velocities are reversed.
fn run(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    check_reversibility(&mut outcome)?;
    let seeds = if quick { 1 } else { 6 };
    let mut picture = LineChart::new("Energy of an elastic gas", "time (s)", "relative change of energy");
    let mut means = Vec::new();
    for (share, bound) in [(0.1, 0.0025), (0.05, 0.0005)] {
        let mut sum = 0.0;
        for seed in 0..seeds {
            let (maximum, curve) =
                energy_change(share, seed, if quick { COLLISIONS / 10 } else { COLLISIONS })?;
            sum += maximum / seeds as f64;
            if seed == 0 {
                picture.series.push(Series::new(format!("ω₀Δt = {share}"), curve, Style::Line));
            }
        }
        let name = format!("B4, ω₀Δt = {share}: largest change of energy, mean of {seeds} seeds");
        if quick {
            outcome.info(name, "0", sum, "not judged: a tenth of the collisions, one seed");
        } else {
            outcome.assert_below(name, "0", sum, bound, "B4 as amended: 0.25 and 0.05 %, mean of six seeds");
        }
        means.push(sum);
    }
    if !quick {
        let reason = "B4 as amended: 3 to 10";
        outcome.assert_within(
            "B4, change with the step over that with half of it",
            "4",
            means[0] / means[1],
            (3.0, 10.0),
            reason,
        );
    }
    outcome.svg("B4: elastic collisions leave small errors of either sign.", &picture)?;
    Ok(outcome)
}

/// Solver of a gas, and its time step as a share of the contact duration (s).
fn gas(share: f64, seed: u64) -> Result<(DemSolver<2, 1>, f64), String> {
    let mut value = load("gas")?;
    let dt = share / FREQUENCY;
    method_options(&mut value)["seed"] = json!(seed);
    method_options(&mut value)["time_step"] = json!(dt);
    Ok((disk_solver(&value)?, dt))
}

/// Largest relative change of the energy, and its change over time.
fn energy_change(share: f64, seed: u64, collisions: usize) -> Result<(f64, Vec<(f64, f64)>), String> {
    let (mut solver, dt) = gas(share, seed)?;
    let (mut largest, mut curve, mut count, mut before) = (0.0f64, Vec::new(), 0, BTreeSet::new());
    let every = (1.0 / share) as u64;
    while count < collisions {
        step(&mut solver, dt)?;
        if solver.step_count().is_multiple_of(every) {
            // A collision lasts three times this interval.
            let now: BTreeSet<_> =
                solver.contacts().iter().map(|contact| (contact.grain, contact.second)).collect();
            // Grains are sorted from time to time: few pairs are new then.
            count += now.difference(&before).count();
            before = now;
            let change = output_value(&solver, "energy_error");
            largest = max_or_nan(largest, change.abs());
            if solver.step_count().is_multiple_of(20 * every) {
                curve.push((solver.time(), change));
            }
        }
    }
    Ok((largest, curve))
}

/// Checks that the gas returns to its start after a thousand steps with reversed velocities.
fn check_reversibility(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let (mut solver, dt) = gas(0.1, 0)?;
    let first = solver.snapshot();
    for _ in 0..999 {
        step(&mut solver, dt)?;
    }
    let behind = solver.snapshot().positions;
    step(&mut solver, dt)?;
    let middle = solver.snapshot();
    step(&mut solver, dt)?;
    let ahead = solver.snapshot().positions;
    // A start takes half a kick: the velocity at the time of the positions is the mean of those before and after.
    let length = load("gas")?["domain"]["max"][0].as_f64().ok_or("no length")?;
    let nearest = |x: f64| x - length * (x / length).round();
    let radii = middle.scalars("radius").ok_or("no radii")?.to_vec();
    let mut value = load("gas")?;
    let velocity = |i: usize, c: usize| {
        let next = nearest(ahead[i][c] - middle.positions[i][c]);
        -(next + nearest(middle.positions[i][c] - behind[i][c])) / (2.0 * dt)
    };
    let within = |x: f64| x - length * (x / length).floor();
    let grains: Vec<GrainData> = (0..radii.len())
        .map(|i| {
            let place = vec![within(middle.positions[i][0]), within(middle.positions[i][1])];
            (place, radii[i], vec![velocity(i, 0), velocity(i, 1)])
        })
        .collect();
    value["bodies"][0]["points"] = grain_file("gas", &grains)?;
    let own = method_options(&mut value);
    own["stages"] = json!({});
    own["time_step"] = json!(dt);
    let mut solver = disk_solver(&value)?;
    for _ in 0..1000 {
        step(&mut solver, dt)?;
    }
    let apart = |a: &[f64; 3], b: &[f64; 3]| (0..2).map(|c| nearest(a[c] - b[c]).abs()).fold(0.0, max_or_nan);
    let found = solver.snapshot().positions;
    let error = found.iter().zip(&first.positions).map(|(a, b)| apart(a, b)).max_or_nan();
    let moved = middle.positions.iter().zip(&first.positions).map(|(a, b)| apart(a, b)).max_or_nan();
    outcome.assert_below(
        "B4, 1000 steps there and back: largest distance from the start (m)",
        "0",
        error,
        1e-8,
        "B4: 1e-8",
    );
    outcome.info("B4, largest way there (m)", "", moved, "not judged: says that there is a way to come back");
    Ok(())
}
