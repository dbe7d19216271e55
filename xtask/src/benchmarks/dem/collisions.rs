//! Free flight and head-on collisions (sheet: dem §5, B1 and B2; §2.3, §2.8, §3.6).

use std::f64::consts::PI;

use colluvium::case::Solver;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use crate::analysis::{MaxOrNan, max_or_nan, regression_slope};
use crate::benchmarks::dem::case_builders::{
    disk_solver, linear_law, load, method_options, output_value, sphere_solver, step,
};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, vectors};

/// Benchmark of free flight and of head-on collisions.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/collisions",
    title: "Free flight, restitution of head-on collisions, elastic spheres, DEM",
    source: "sheet: dem §5, B1, B2; §2.3, §2.8, §3.6",
    short_seconds: Some(2),
    full_seconds: 2,
    run,
};

/// Table of the sheet: damping ratio, restitution without and with no-tension clamp, and duration of the contact over 1/ω₀ (sheet: dem
/// §2.3).
const TABLE: [(f64, f64, f64, f64, f64); 8] = [
    (0.05, 0.854_468, 0.858_758, 3.14553, 3.04536),
    (0.1, 0.729_248, 0.744_079, 3.15742, 2.95608),
    (0.2, 0.526_621, 0.571_740, 3.20637, 2.79535),
    (0.3, 0.372_326, 0.450_975, 3.29328, 2.65447),
    (0.5, 0.163_034, 0.298_436, 3.62760, 2.41840),
    (0.7, 0.045_988, 0.210_285, 4.39911, 2.22756),
    (1.0, 0.0, 0.135_335, f64::INFINITY, 2.0),
    (1.5, 0.0, 0.075_588, f64::INFINITY, 1.72164),
];

/// Checks free flight, and head-on collisions with linear and Hertzian contacts.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    check_free_flight(&mut outcome)?;
    table(&mut outcome)?;
    order(&mut outcome)?;
    check_undamped(&mut outcome)?;
    check_restitutions(&mut outcome)?;
    glass(&mut outcome)?;
    speeds(&mut outcome)?;
    Ok(outcome)
}

/// Checks that free flight is exact with steps of any size (B1).
fn check_free_flight(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut value = load("pair")?;
    value["gravity"] = json!([0, -9.81]);
    value["bodies"][0]["velocity"]["value"] = json!([1, 2]);
    value["bodies"][0]["shape"]["centre"] = json!([0, 5]);
    value["bodies"].as_array_mut().ok_or("no bodies")?.truncate(1);
    let mut solver = disk_solver(&value)?;
    let (limit, mut time) = (solver.limit().dt, 0.0);
    for share in [1.0, 0.4, 0.7].into_iter().cycle().take(3000) {
        step(&mut solver, share * limit)?;
        time += share * limit;
    }
    let x = solver.snapshot().positions[0];
    let exact = [time, 5.0 + 2.0 * time - 0.5 * 9.81 * time * time];
    let error = (0..2).map(|c| ((x[c] - exact[c]) / exact[c]).abs()).max_or_nan();
    outcome.assert_below(
        "B1, place in free flight, uneven steps: relative error",
        "0",
        error,
        1e-12,
        "B1: 1e-12",
    );
    Ok(())
}

/// Result of a collision.
struct Collision {
    restitution: f64,
    /// Number of steps with a contact force.
    touching: u32,
    /// Largest overlap (m).
    deepest: f64,
    /// Relative change of momentum.
    momentum: f64,
    /// Error of the energy balance.
    energy: f64,
}

/// Collides two disks of these masses (kg). `steps` of them take the time `π/ω₀`; contact begins at the share `phase` of a step after the
/// second one.
fn collide(ratio: f64, clamp: bool, masses: [f64; 2], steps: f64, phase: f64) -> Result<Collision, String> {
    let mut value = load("pair")?;
    let radius = masses.map(|mass| 0.5 * mass.sqrt());
    let dt = PI / (1e6 / (masses[0] * masses[1] / (masses[0] + masses[1]))).sqrt() / steps;
    value["bodies"][0]["shape"] =
        json!({ "kind": "ball", "centre": [-radius[0] - (2.0 + phase) * dt, 0], "radius": radius[0] });
    value["bodies"][1]["shape"] = json!({ "kind": "ball", "centre": [radius[1], 0], "radius": radius[1] });
    let options = method_options(&mut value);
    options["pairs"][0]["normal"] = linear_law(1e6, ratio, clamp);
    options["time_step"] = json!(dt);
    let mut solver = disk_solver(&value)?;
    let (mut touching, mut deepest) = (0, 0.0f64);
    for _ in 0..(2.0 * steps) as usize + 5 {
        step(&mut solver, dt)?;
        if let Some(contact) = solver.contacts().first() {
            touching += u32::from(contact.normal != 0.0);
            deepest = deepest.max(contact.overlap);
        }
    }
    let v = vectors(&solver.snapshot(), "velocity");
    Ok(Collision {
        restitution: v[1][0] - v[0][0],
        touching,
        deepest,
        momentum: solver.totals().momentum[0] / masses[0] - 1.0,
        energy: output_value(&solver, "energy_error"),
    })
}

/// Checks all entries of the table, with two step sizes.
fn table(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut picture = LineChart::new("Restitution of a head-on collision", "damping ratio", "restitution");
    let (mut momentum, mut energy) = (0.0f64, 0.0f64);
    for clamp in [false, true] {
        let (mut exact, mut found) = (Vec::new(), Vec::new());
        let (mut coarse, mut fine, mut lasting) = (0.0f64, 0.0f64, 0.0f64);
        for (ratio, without, with, long, short) in TABLE {
            let (reference, duration) = if clamp { (with, short) } else { (without, long) };
            if !duration.is_finite() {
                continue;
            }
            for phase in [0.0, 0.3, 0.6] {
                let few = collide(ratio, clamp, [1.0, 1.0], 200.0, phase)?;
                let many = collide(ratio, clamp, [1.0, 1.0], 1000.0, phase)?;
                coarse = max_or_nan(coarse, (few.restitution - reference).abs());
                fine = max_or_nan(fine, (many.restitution - reference).abs());
                lasting = max_or_nan(lasting, (f64::from(many.touching) * PI / 1000.0 - duration).abs());
                momentum = max_or_nan(momentum, max_or_nan(few.momentum.abs(), many.momentum.abs()));
                energy = max_or_nan(energy, few.energy.abs());
                if phase == 0.0 {
                    found.push((ratio, few.restitution));
                }
            }
            exact.push((ratio, reference));
        }
        let law = if clamp { "clamped" } else { "unclamped" };
        outcome.assert_below(
            format!("B2, {law}: largest error of restitution, 200 steps"),
            "0",
            coarse,
            5e-3,
            "B2: 5e-3",
        );
        outcome.assert_below(
            format!("B2, {law}: largest error of restitution, 1000 steps"),
            "0",
            fine,
            1e-3,
            "B2: 1e-3",
        );
        let reason = "two and a half steps: one at either end, half a one by which velocities lag";
        let name = format!("B2, {law}: largest error of duration over 1/ω₀, 1000 steps");
        outcome.assert_below(name, "0", lasting, 2.5 * PI / 1000.0, reason);
        picture.series.push(Series::new(format!("{law}, closed form"), exact, Style::Dashed));
        picture.series.push(Series::new(law, found, Style::Markers));
    }
    outcome.assert_below("B2, momentum: relative change", "0", momentum, 1e-12, "B2: 1e-12");
    outcome.assert_below(
        "B2, error of the energy balance over input, 200 steps",
        "0",
        energy,
        0.01,
        "§2.14: 1 %",
    );
    outcome.svg("B2: closed forms of §2.3 and collisions with 200 steps to half a period.", &picture)
}

/// Checks that errors are of first order in the step, in the sheet's worst cases over the phase of the contact.
fn order(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let sheet = [(25.0, 2.7e-2), (50.0, 1.3e-2), (100.0, 6.7e-3), (200.0, 3.4e-3), (400.0, 1.7e-3)];
    let mut found = Vec::new();
    for (steps, _) in sheet {
        let mut worst = 0.0f64;
        for phase in 0..10 {
            let collision = collide(0.5, true, [1.0, 1.0], steps, 0.1 * f64::from(phase))?;
            worst = max_or_nan(worst, (collision.restitution - 0.298_436).abs());
        }
        found.push((steps, worst));
    }
    let logs: Vec<(f64, f64)> = found.iter().map(|(steps, error)| (steps.ln(), error.ln())).collect();
    let reason = "B2: first order at least; the sheet's own errors have -0.99 to -1.05, dashpots corrected for the lag of velocities -2";
    outcome.assert_below(
        "B2, order of the error in the number of steps",
        "-1",
        regression_slope(&logs),
        -0.8,
        reason,
    );
    let largest = found.iter().zip(sheet).map(|((_, error), (_, sheet))| error / sheet).max_or_nan();
    let reason = "B2: the sheet's worst errors over the phase; a fifth for phases that ten samples miss";
    outcome.assert_below("B2, largest error over the sheet's", "1", largest, 1.2, reason);
    let mut picture =
        LineChart::new("Error of restitution, clamped, ζ = 0.5", "steps to π/ω₀", "error of restitution");
    picture.log = true;
    picture.series.push(Series::new("worst of ten phases", found, Style::Line));
    picture.series.push(Series::new("sheet", sheet.to_vec(), Style::Markers));
    outcome
        .svg("B2: the dashpot's force jumps as grains meet, so that the error falls with the step.", &picture)
}

/// Checks undamped collisions, collisions of unequal masses, and a collision with a wall.
fn check_undamped(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let plain = collide(0.0, true, [1.0, 1.0], 200.0, 0.4)?;
    outcome.assert_close(
        "B2, restitution without damping, 200 steps",
        1.0,
        1e-3,
        plain.restitution,
        "B2: 1e-3",
    );
    let exact = (0.5f64 / 1e6).sqrt();
    outcome.assert_close(
        "B2, largest overlap without damping (m)",
        exact,
        1e-3,
        plain.deepest,
        "the 1e-3 of the restitution",
    );
    let unequal = collide(0.3, true, [1.0, 3.0], 1000.0, 0.2)?;
    outcome.assert_close(
        "B2, masses 1 and 3: restitution",
        0.450_975,
        1e-3 / 0.45,
        unequal.restitution,
        "B2: 1e-3",
    );
    let mut value = load("wall")?;
    method_options(&mut value)["pairs"][0]["normal"] = linear_law(1e6, 0.3, true);
    let dt = PI / 1e3 / 1000.0;
    method_options(&mut value)["time_step"] = json!(dt);
    value["bodies"][0]["shape"]["centre"] = json!([0, 0.5 + 2.2 * dt]);
    let mut solver = disk_solver(&value)?;
    for _ in 0..1100 {
        step(&mut solver, dt)?;
    }
    let rebound = vectors(&solver.snapshot(), "velocity")[0][1];
    outcome.assert_close("B2, wall: restitution", 0.450_975, 1e-3 / 0.45, rebound, "B2: 1e-3");
    Ok(())
}

/// Checks that collisions have the requested restitution, with damping ratios for the law with and without no-tension clamp.
fn check_restitutions(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    for clamp in [false, true] {
        let mut worst = 0.0f64;
        for requested in [0.95, 0.9, 0.8, 0.7, 0.5, 0.3, 0.2, 0.1] {
            let mut value = load("pair")?;
            let dt = PI / 2e6f64.sqrt() / 1000.0;
            value["bodies"][0]["shape"]["centre"] = json!([-0.5 - 2.3 * dt, 0]);
            let options = method_options(&mut value);
            options["pairs"][0]["normal"] =
                json!({ "law": "linear", "stiffness": 1e6, "restitution": requested, "clamp": clamp });
            options["time_step"] = json!(dt);
            let mut solver = disk_solver(&value)?;
            for _ in 0..1400 {
                step(&mut solver, dt)?;
            }
            let v = vectors(&solver.snapshot(), "velocity");
            worst = max_or_nan(worst, (v[1][0] - v[0][0] - requested).abs());
        }
        let law = if clamp { "clamped" } else { "unclamped" };
        let name = format!("§2.3, {law}: restitution asked for, 0.1 to 0.95: largest error");
        outcome.assert_below(name, "0", worst, 1e-3, "B2: 1e-3 with 1000 steps");
    }
    Ok(())
}

/// Checks an elastic impact of glass spheres (§3.6).
fn glass(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut value = load("spheres")?;
    let (deepest, force, duration) = (1.00358e-5, 81.5202, 2.9538e-5);
    let dt = duration / 1000.0;
    method_options(&mut value)["time_step"] = json!(dt);
    value["bodies"][0]["shape"]["centre"] = json!([-0.005 - 2.5 * dt, 0, 0]);
    let mut solver = sphere_solver(&value)?;
    let (mut touching, mut maximum, mut curve) = (0, (0.0f64, 0.0f64), Vec::new());
    for _ in 0..1100 {
        step(&mut solver, dt)?;
        if let Some(contact) = solver.contacts().first() {
            touching += u32::from(contact.overlap > 0.0);
            maximum = (maximum.0.max(contact.overlap), maximum.1.max(contact.normal));
            curve.push((contact.overlap * 1e6, contact.normal));
        }
    }
    let reason = "the 1e-3 of B2's undamped collision; closed form of §2.8";
    outcome.assert_close("§3.6, glass spheres: largest overlap (m)", deepest, 1e-3, maximum.0, reason);
    outcome.assert_close(
        "§3.6, glass spheres: largest force (N)",
        force,
        1.5e-3,
        maximum.1,
        "that of the overlap, to the power 3/2",
    );
    outcome.assert_close(
        "§3.6, glass spheres: duration (s)",
        duration,
        2e-3,
        f64::from(touching) * dt,
        "two of 1000 steps",
    );
    let v = vectors(&solver.snapshot(), "velocity");
    outcome.assert_close(
        "§3.6, glass spheres: restitution without damping",
        1.0,
        1e-3,
        v[1][0] - v[0][0],
        "B2: 1e-3",
    );
    let stiffness = 81.5202 / 1.00358e-5f64.powf(1.5);
    let exact =
        (0..=100).map(|k| 1.00358e-7 * f64::from(k)).map(|d| (d * 1e6, stiffness * d.powf(1.5))).collect();
    let mut picture = LineChart::new("Impact of glass spheres at 1 m/s", "overlap (µm)", "force (N)");
    picture.series.push(Series::new("Hertz", exact, Style::Dashed));
    picture.series.push(Series::new(
        "along the impact",
        curve.into_iter().step_by(25).collect(),
        Style::Markers,
    ));
    outcome.svg("§3.6: force over overlap.", &picture)
}

/// Checks that the restitution of the Hertz law does not depend on the speed, and that the no-tension clamp increases it (§2.8).
fn speeds(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    for (clamp, pairs) in [
        (false, [(0.3, 0.3), (0.5, 0.5), (0.7, 0.7), (0.9, 0.9)]),
        (true, [(0.3, 0.3971), (0.5, 0.5503), (0.7, 0.7182), (0.9, 0.9020)]),
    ] {
        let mut worst = 0.0f64;
        for (requested, reference) in pairs {
            for speed in [0.1, 1.0, 10.0] {
                let mut value = load("spheres")?;
                // The duration of an elastic impact is proportional to the speed to the power -1/5.
                let dt = 2.9538e-5 / f64::powf(speed, 0.2) / 1000.0;
                value["bodies"][0]["shape"]["centre"] = json!([-0.005 - 2.5 * dt * speed, 0, 0]);
                value["bodies"][0]["velocity"]["value"] = json!([speed, 0, 0]);
                let options = method_options(&mut value);
                options["time_step"] = json!(dt);
                options["pairs"][0]["normal"]["restitution"] = json!(requested);
                options["pairs"][0]["normal"]["clamp"] = json!(clamp);
                let mut solver = sphere_solver(&value)?;
                for _ in 0..2500 {
                    step(&mut solver, dt)?;
                }
                let v = vectors(&solver.snapshot(), "velocity");
                worst = max_or_nan(worst, ((v[1][0] - v[0][0]) / speed - reference).abs());
            }
        }
        let law = if clamp { "clamped, the sheet's values" } else { "unclamped" };
        let name = format!("§2.8, Hertz {law}: error of restitution at 0.1, 1 and 10 m/s");
        if clamp {
            let reason = "not judged: the sheet's values are those of a dashpot chosen without the clamp; the restitution asked for is had now";
            outcome.info(name, "", worst, reason);
        } else {
            outcome.assert_below(name, "0", worst, 1e-3, "B2: 1e-3 with 1000 steps");
        }
    }
    Ok(())
}
