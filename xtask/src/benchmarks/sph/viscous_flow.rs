//! Fluids: Poiseuille flow, a tank at rest, a granular flow down an incline (sheet: sph §5.3, V-21 to V-23).

use colluvium::case::Case;
use colluvium::plots::{LineChart, Series, Style};

use crate::analysis::MaxOrNan;
use crate::benchmarks::sph::waves::load;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, run_in_memory, set_method_option, stresses, vectors};

/// Benchmark of Poiseuille flow, of a liquid at rest, and of Bagnold's profile.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/flow",
    title: "Poiseuille flow, liquid at rest and Bagnold's profile, SPH",
    source: "sheet: sph §5.3, V-21, V-22, V-23",
    short_seconds: Some(4),
    full_seconds: 10,
    run,
};

/// Checks Poiseuille flow, a tank at rest and a granular flow down an incline.
fn run(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    poiseuille(&mut outcome)?;
    hydrostatic(&mut outcome)?;
    if !quick {
        bagnold(&mut outcome)?;
    }
    Ok(outcome)
}

/// Chart of a quantity over the height.
fn chart(title: &str, x_label: &str) -> LineChart {
    LineChart::new(title, x_label, "height (m)")
}

/// Points of a curve over height, from the bottom to the top.
fn curve(height: f64, value: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    (0..=60).map(|k| height * f64::from(k) / 60.0).map(|y| (value(y), y)).collect()
}

/// Closed form of the velocity of Poiseuille flow (m/s) at a height (m).
fn between_walls(y: f64) -> f64 {
    1e-3 / (2.0 * 0.15) * y * (1.0 - y)
}

/// Velocities and heights of the particles, and the largest error of the velocity over its maximum.
fn velocities(case: &Case) -> Result<(Vec<(f64, f64)>, f64), String> {
    let snapshot = run_in_memory("sph", case)?.snapshot;
    let found = snapshot.positions.iter().zip(vectors(&snapshot, "velocity"));
    let points: Vec<(f64, f64)> = found.map(|(x, v)| (v[0], x[1])).collect();
    let worst = points.iter().map(|(v, y)| (v - between_walls(*y)).abs()).max_or_nan() / between_walls(0.5);
    Ok((points, worst))
}

/// Checks the velocity profile of Poiseuille flow.
fn poiseuille(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let base = load("flow/poiseuille.json")?;
    let (points, worst) = velocities(&base)?;
    let reason = "V-21: 1 % with 40 particles, of the largest velocity";
    outcome.assert_below("V-21, largest error of the velocity over its maximum", "0", worst, 0.01, reason);
    let mut picture = chart("Poiseuille flow", "velocity (m/s)");
    picture.series.push(Series::new("closed form", curve(1.0, between_walls), Style::Dashed));
    picture.series.push(Series::new("particles", points, Style::Markers));
    let mut shifted = base.clone();
    set_method_option(&mut shifted, "sph", "shifting", 5.0);
    set_method_option(&mut shifted, "sph", "shifting_speed", "largest");
    let (points, worst) = velocities(&shifted)?;
    let name = "V-21, the same with particles shifted by the way of the fastest";
    outcome.assert_below(name, "0", worst, 0.03, "3 %: liquids with vorticity, 40 particles across");
    picture.series.push(Series::new("shifted", points, Style::Markers));
    let mut bare = base;
    set_method_option(&mut bare, "sph", "hourglass_viscosity", 0.0);
    set_method_option(&mut bare, "sph", "rough_wall", "particles");
    let (points, worst) = velocities(&bare)?;
    let reason = "not judged: velocities that alternate from layer to layer make no gradient and grow at the walls (sheet: sph §6.27)";
    let name = "V-21, the same without hourglass viscosity, walls of particles that answer pairwise";
    outcome.info(name, "0", worst, reason);
    picture.series.push(Series::new("no hourglass viscosity", points, Style::Markers));
    outcome.svg("V-21: velocities between two rough walls.", &picture)
}

/// Checks the pressure of a tank at rest.
fn hydrostatic(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let snapshot = run_in_memory("sph", &load("flow/hydrostatic.json")?)?.snapshot;
    let weight = 1000.0 * 9.81;
    let points: Vec<(f64, f64)> =
        snapshot.positions.iter().zip(stresses(&snapshot)).map(|(x, s)| (s.pressure(), x[1])).collect();
    // Farther than a support from the bed and the surface.
    let support = 2.0 * 1.2 * 0.025;
    let inside = points.iter().filter(|(_, y)| *y > support && *y < 1.0 - support);
    let worst = inside.map(|(p, y)| (p - weight * (1.0 - y)).abs() / weight).max_or_nan();
    let reason = "V-22: 1 % in the interior, of the pressure at the bed";
    outcome.assert_below("V-22, largest error of the pressure over ρgH", "0", worst, 0.01, reason);
    let all = points.iter().map(|(p, y)| (p - weight * (1.0 - y)).abs() / weight).max_or_nan();
    let reason = "not judged: V-22 judges the interior";
    outcome.info("V-22, the same with the particles at the bed and the surface", "0", all, reason);
    let mut picture = chart("Liquid at rest", "pressure (Pa)");
    picture.series.push(Series::new("ρg(H - y)", curve(1.0, |y| weight * (1.0 - y)), Style::Dashed));
    picture.series.push(Series::new("particles", points, Style::Markers));
    outcome.svg("V-22: pressure in a tank.", &picture)
}

/// Checks the velocity profile of a granular flow against Bagnold's.
fn bagnold(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let snapshot = run_in_memory("sph", &load("flow/bagnold.json")?)?.snapshot;
    let (height, angle) = (0.12f64, 24f64.to_radians());
    let inertial = 0.28 * (angle.tan() - 0.38) / (0.64 - angle.tan());
    let scale = 2.0 / 3.0 * inertial / 0.012 * (1500.0 * 9.81 * angle.cos() / 2500.0f64).sqrt();
    let exact = |y: f64| scale * (height.powf(1.5) - (height - y).max(0.0).powf(1.5));
    let found = snapshot.positions.iter().zip(vectors(&snapshot, "velocity"));
    let points: Vec<(f64, f64)> = found.map(|(x, v)| (v[0], x[1])).collect();
    let top: Vec<f64> = points.iter().filter(|(_, y)| *y > height - 0.006).map(|(v, _)| *v).collect();
    let surface = top.iter().sum::<f64>() / top.len() as f64;
    let reason = "V-23: 5 % with 30 particles over the height";
    outcome.assert_close("V-23, velocity of the surface (m/s)", exact(height), 0.05, surface, reason);
    let mut picture = chart("Granular flow down 24 degrees", "velocity (m/s)");
    picture.series.push(Series::new("Bagnold's profile", curve(height, exact), Style::Dashed));
    picture.series.push(Series::new("particles", points, Style::Markers));
    outcome.svg("V-23: velocities across the flow.", &picture)
}
