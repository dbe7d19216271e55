//! Disk and sphere on a slope, with and without rolling resistance (sheet: dem §5, B6 and B8).

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use colluvium::case::Solver;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use crate::benchmarks::dem::case_builders::{
    disk_solver, linear_law, load, method_options, sphere_solver, step,
};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, vectors};

/// Benchmark of a disk and a sphere that slide and roll on a slope.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/slope",
    title: "A disk and a sphere slide and roll on a slope, DEM",
    source: "Ke and Bray 1995; sheet: dem §5, B6",
    short_seconds: Some(1),
    full_seconds: 1,
    run,
};

/// Benchmark of rolling resistance, which stops and holds grains.
pub const ROLLING: Benchmark = Benchmark {
    id: "dem/rolling",
    title: "Resistance against rolling stops and holds grains, DEM",
    source: "sheet: dem §5, B8",
    short_seconds: Some(2),
    full_seconds: 2,
    run: rolling,
};

/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 9.81;
/// Duration of the motion (s).
const TIME: f64 = 0.2;

/// Friction angle (degrees), mean friction over weight, acceleration over gravity, rotation (rad) and displacement (m) after 0.2 s.
const TABLE: [(f64, f64, f64, f64, f64); 8] = [
    (0.0, 0.0, FRAC_1_SQRT_2, 0.0, 0.13873),
    (5.0, 0.0619, 0.6452, 0.02428, 0.12660),
    (10.0, 0.1247, 0.5824, 0.04893, 0.11427),
    (15.0, 0.1895, 0.5176, 0.07435, 0.10156),
    (18.435, 0.2357, 0.4714, 0.09249, 0.09249),
    (20.0, 0.2357, 0.4714, 0.09249, 0.09249),
    (30.0, 0.2357, 0.4714, 0.09249, 0.09249),
    (45.0, 0.2357, 0.4714, 0.09249, 0.09249),
];

/// Motion of a grain in 0.2 s.
struct RollingMotion {
    /// Rotation down the slope (rad), of disks.
    rotation: f64,
    /// Displacement down the slope (m).
    displacement: f64,
    /// Velocity down the slope (m/s).
    speed: f64,
    /// Speed of the surface by rotation (m/s).
    rim_speed: f64,
    /// Mean of the friction over the weight, of disks.
    friction: f64,
}

/// Checks sliding and rolling of a disk and a sphere on slopes against rigid-body dynamics.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut found = Vec::new();
    for (angle, friction, acceleration, turned, along) in TABLE {
        let motion = slide(f64::tan(angle * PI / 180.0), false)?;
        let reason = "B6: 1 %";
        let name = |what: &str| format!("B6, disk, friction of {angle}°: {what}");
        if turned == 0.0 {
            outcome.assert_below(
                name("rotation after 0.2 s (rad)"),
                "0",
                motion.rotation.abs(),
                1e-12,
                "no friction, no moment",
            );
        } else {
            outcome.assert_close(name("rotation after 0.2 s (rad)"), turned, 0.01, motion.rotation, reason);
        }
        outcome.assert_close(name("way in 0.2 s (m)"), along, 0.01, motion.displacement, reason);
        outcome.assert_close(
            name("velocity over time and gravity"),
            acceleration,
            0.01,
            motion.speed / TIME / GRAVITY,
            reason,
        );
        if friction > 0.0 {
            outcome.assert_close(name("mean friction over weight"), friction, 0.01, motion.friction, reason);
        }
        found.push((angle, motion.rotation));
    }
    let exact = (0..=90)
        .map(|k| 0.5 * f64::from(k))
        .map(|a| (a, exact_accelerations(f64::tan(a * PI / 180.0), 0.5).1 * 0.5 * TIME * TIME));
    let mut picture = LineChart::new(
        "Rotation of a disk on a slope of 45° after 0.2 s",
        "friction angle (°)",
        "rotation (rad)",
    );
    picture.series.push(Series::new("closed form", exact.collect(), Style::Dashed));
    picture.series.push(Series::new("DEM", found, Style::Markers));
    outcome.svg("B6: below 18.4° the disk slides and rolls, above it rolls.", &picture)?;
    for angle in [5.0, 10.0, 15.0, 20.0, 30.0] {
        let friction = f64::tan(angle * PI / 180.0);
        let motion = slide(friction, true)?;
        let (acceleration, rotation) = exact_accelerations(friction, 0.4);
        let name = |what: &str| format!("B6, sphere, friction of {angle}°: {what}");
        let reason = "B6: the 1 % of the disk";
        outcome.assert_close(
            name("way in 0.2 s (m)"),
            0.5 * acceleration * TIME * TIME,
            0.01,
            motion.displacement,
            reason,
        );
        outcome.assert_close(name("speed of the rim (m/s)"), rotation * TIME, 0.01, motion.rim_speed, reason);
    }
    Ok(outcome)
}

/// Linear and angular acceleration for radius 1 m on a slope of 45°; `q` is the moment of inertia over m r².
fn exact_accelerations(friction: f64, q: f64) -> (f64, f64) {
    let down = GRAVITY * 0.5f64.sqrt();
    if friction < q / (1.0 + q) {
        (down * (1.0 - friction), friction * down / q)
    } else {
        (down / (1.0 + q), down / (1.0 + q))
    }
}

/// Runs a grain for 0.2 s on a slope with a coefficient of friction, and returns its motion.
fn slide(friction: f64, sphere: bool) -> Result<RollingMotion, String> {
    let mut value = load(if sphere { "slope-sphere" } else { "slope" })?;
    let mass = if sphere { 4.0 / 3.0 * PI * 2650.0 } else { PI * 2650.0 };
    let height = 1.0 - mass * GRAVITY * 0.5f64.sqrt() / 1e9;
    if friction > 0.0 {
        value["boundaries"][0]["wall"] = json!({ "kind": "frictional", "friction_coefficient": friction });
    }
    value["bodies"][0]["shape"]["centre"][1] = json!(height);
    let dt = TIME / 20_000.0;
    method_options(&mut value)["time_step"] = json!(dt);
    if sphere {
        return motion_after(&mut sphere_solver(&value)?, dt, mass);
    }
    motion_after(&mut disk_solver(&value)?, dt, mass)
}

/// Motion of a grain after 20,000 steps.
fn motion_after(solver: &mut impl Solver, dt: f64, mass: f64) -> Result<RollingMotion, String> {
    for _ in 0..20_000 {
        step(solver, dt)?;
    }
    let snapshot = solver.snapshot();
    let spin = snapshot.scalars("spin").map_or_else(|| vectors(&snapshot, "spin")[0][2], |spin| spin[0]);
    Ok(RollingMotion {
        rotation: snapshot.scalars("orientation").map_or(f64::NAN, |angle| -angle[0]),
        displacement: snapshot.positions[0][0],
        speed: vectors(&snapshot, "velocity")[0][0],
        rim_speed: -spin,
        friction: solver
            .reaction("floor")
            .map_or(f64::NAN, |reaction| reaction.impulse[0] / (TIME * mass * GRAVITY)),
    })
}

/// Checks that rolling resistance stops a grain on a level floor and holds it on a slope.
fn rolling(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let reason = "B8: 1 %";
    let mut picture = LineChart::new("A grain that rolls to rest", "time (s)", "way (m)");
    for (sphere, share, body) in [(false, 2.0 / 3.0, "disk"), (true, 5.0 / 7.0, "sphere")] {
        let deceleration = share * 0.05 * GRAVITY;
        let path = roll(0.05, 0.0, 1.0, sphere, 3.5)?;
        let (_, last) = path[path.len() - 1];
        outcome.assert_close(format!("B8, {body}: way to rest (m)"), 0.5 / deceleration, 0.01, last, reason);
        // The grain counts as at rest where 0.01 % of the displacement remain.
        let rest = path.iter().find(|(_, x)| *x > 0.9999 * last).map_or(f64::NAN, |(time, _)| *time);
        let exact = (1.0 - 0.01) / deceleration;
        outcome.assert_close(
            format!("B8, {body}: time to 99.99 % of that way (s)"),
            exact,
            0.01,
            rest,
            reason,
        );
        let stop = 1.0 / deceleration;
        let closed = |t: f64| (t, t.min(stop) - 0.5 * deceleration * t.min(stop).powi(2));
        picture.series.push(Series::new(
            format!("{body}, closed form"),
            (0..=70).map(|k| closed(0.05 * f64::from(k))).collect(),
            Style::Dashed,
        ));
        let every = path.len() / 30;
        picture.series.push(Series::new(body, path.into_iter().step_by(every).collect(), Style::Markers));
    }
    outcome.svg("B8: rolling friction of 0.05.", &picture)?;
    let slope = 0.1f64;
    let reason = "B8: stays at rest iff tan β ≤ μ_r; within 3 % of it";
    let creep = roll(1.03 * slope, slope, 0.0, false, 4.0)?;
    let stays = creep[creep.len() - 1].1;
    outcome.assert_below("B8, tan β = μ_r / 1.03: way in 4 s (m)", "stays", stays.abs(), 1e-3, reason);
    let gone = roll(0.97 * slope, slope, 0.0, false, 4.0)?;
    outcome.assert_within(
        "B8, tan β = μ_r / 0.97: way in 4 s (m)",
        "rolls",
        gone[gone.len() - 1].1,
        (0.02, 1.0),
        reason,
    );
    let half = roll(0.5 * slope, slope, 0.0, false, 4.0)?;
    // Gravity is complete after a second; from then on the grain falls freely.
    let (start, end) = (half[half.len() / 2], half[half.len() - 1]);
    let (t, acceleration) =
        (end.0 - start.0, 2.0 / 3.0 * GRAVITY * (slope - 0.5 * slope) / (1.0 + slope * slope).sqrt());
    let speed = (half[half.len() / 2 + 1].1 - half[half.len() / 2 - 1].1)
        / (half[half.len() / 2 + 1].0 - half[half.len() / 2 - 1].0);
    let found = 2.0 * (end.1 - start.1 - speed * t) / (t * t);
    outcome.assert_close("B8, tan β = 2 μ_r: acceleration (m/s²)", acceleration, 0.01, found, "B8: 1 %");
    Ok(outcome)
}

/// Path of a grain of radius 0.5 m that rolls on a rough plane with the gradient `slope`.
fn roll(resistance: f64, slope: f64, speed: f64, sphere: bool, time: f64) -> Result<Vec<(f64, f64)>, String> {
    let mut value = load(if sphere { "wall-sphere" } else { "wall" })?;
    let cosine = 1.0 / (1.0 + slope * slope).sqrt();
    let height = 0.5 - GRAVITY * cosine / 1e7;
    (value["gravity"][0], value["gravity"][1]) = (json!(GRAVITY * slope * cosine), json!(-GRAVITY * cosine));
    value["boundaries"][0]["wall"] = json!({ "kind": "rough" });
    value["bodies"][0]["shape"]["centre"][1] = json!(height);
    let velocity = &mut value["bodies"][0]["velocity"]["value"];
    (velocity[0], velocity[1]) = (json!(speed), json!(0));
    if slope > 0.0 {
        value["stages"][0]["gravity_ramp"] = json!(1);
    }
    let own = method_options(&mut value);
    own["pairs"][0]["normal"] = linear_law(1e7, 0.2, true);
    own["pairs"][0]["rolling"] = json!({ "friction": resistance, "damping_ratio": 0.3 });
    let spin = -2.0 * speed;
    own["bodies"] = json!({ "first": { "spin": if sphere { json!([0, 0, spin]) } else { json!([spin]) } } });
    if !sphere {
        return path(&mut disk_solver(&value)?, time);
    }
    path(&mut sphere_solver(&value)?, time)
}

/// Path of a grain: time (s) and position along the floor (m).
fn path(solver: &mut impl Solver, time: f64) -> Result<Vec<(f64, f64)>, String> {
    let mut path = Vec::new();
    while solver.time() < time {
        if solver.step_count().is_multiple_of(100) {
            path.push((solver.time(), solver.snapshot().positions[0][0]));
        }
        let dt = solver.limit().dt;
        step(solver, dt)?;
    }
    Ok(path)
}
