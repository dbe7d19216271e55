//! Block on an obstacle: a plane that is not parallel to an axis (sheet: mpm A-14).

use colluvium::case::description::{ObstacleShape, ObstacleWall};
use colluvium::case::{Case, RunReport};
use colluvium::plots::{LineChart, Series, Style};

use crate::analysis::{MaxOrNan, regression_slope};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, measure_series, run_mpm, set_mpm_option};

/// Benchmark of a block on an inclined obstacle.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/inclined-block",
    title: "Block on an inclined plane as an obstacle",
    source: "sheet: mpm A-14, closed form",
    short_seconds: Some(20),
    full_seconds: 20,
    run: benchmark,
};

/// Angle of the plane (degrees).
pub const ANGLE: f64 = 30.0;
/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 9.81;
/// Time at which the gravity ramp ends (s).
pub const GRAVITY_END: f64 = 0.2;

/// Checks the acceleration of a block on an inclined obstacle with several shape functions and forms of the plane.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart = LineChart::new("Velocity along the plane, 30°", "time (s)", "velocity (m/s)");
    let tangent = ANGLE.to_radians().tan();
    for shape in ["linear", "ugimp", "quadratic"] {
        for share in [0.0, 0.3, 0.6] {
            let report = run_mpm(&block(shape, share * tangent, None)?)?;
            let name = format!("{shape}, μ = {share} tan θ");
            judge(&mut outcome, &name, &report, share);
            if shape == "quadratic" {
                chart.series.push(Series::new(format!("{share} tan θ"), speed_series(&report), Style::Line));
                let exact = gravity_along_plane() * (1.0 - share);
                let line = [(GRAVITY_END, exact * 0.5 * GRAVITY_END), (1.2, exact * 1.1)];
                chart.series.push(Series::new("closed form", line.to_vec(), Style::Dashed));
            }
        }
        let report = run_mpm(&block(shape, 1.2 * tangent, None)?)?;
        let drift = travelled_distance(&report);
        outcome.assert_below(
            format!("{shape}, μ = 1.2 tan θ: drift in 1 s over the length of the block"),
            "at rest",
            drift.abs(),
            1e-3,
            "a thousandth of its length",
        );
    }
    forms(&mut outcome)?;
    outcome.svg("Quadratic splines: velocity of the centre of mass along the plane.", &chart)?;
    Ok(outcome)
}

/// Checks that the plane has the same effect as a half-space, a ground line and a polygon.
fn forms(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let tangent = ANGLE.to_radians().tan();
    let at = |x: f64| [x, 2.5 - x * tangent];
    let forms = [
        ObstacleShape::GroundLine { points: vec![at(-1.0), at(6.0)], file: None },
        ObstacleShape::Polygon { vertices: vec![at(-1.0), at(6.0), [6.0, -3.0], [-1.0, -3.0]] },
    ];
    let plane = speed_series(&run_mpm(&block("quadratic", 0.3 * tangent, None)?)?);
    for (name, form) in ["ground line", "polygon"].into_iter().zip(forms) {
        let other = speed_series(&run_mpm(&block("quadratic", 0.3 * tangent, Some(form))?)?);
        let apart = plane.iter().zip(&other).map(|(a, b)| (a.1 - b.1).abs()).max_or_nan();
        outcome.assert_below(
            format!("{name} against half-space: largest difference of velocity (m/s)"),
            "the same plane",
            apart,
            1e-6,
            "round-off that grows",
        );
    }
    Ok(())
}

/// Component of gravity along the plane (m/s²).
pub fn gravity_along_plane() -> f64 {
    GRAVITY * ANGLE.to_radians().sin()
}

/// Case of a block with shape functions, a friction coefficient and, where given, another shape of the obstacle.
fn block(shape: &str, friction: f64, form: Option<ObstacleShape>) -> Result<Case, String> {
    let mut case = load_case("mpm/inclined-block")?;
    set_mpm_option(&mut case, "shape", shape);
    let obstacle = &mut case.obstacles[0];
    obstacle.wall = ObstacleWall::Frictional { friction_coefficient: friction, adhesion: 0.0 };
    if let Some(form) = form {
        obstacle.shape = form;
    }
    Ok(case)
}

/// Velocity of the centre of mass along the plane (m/s).
pub fn speed_series(report: &RunReport) -> Vec<(f64, f64)> {
    let (sine, cosine) = ANGLE.to_radians().sin_cos();
    let [x, y, mass] = ["momentum.x", "momentum.y", "mass"].map(|name| measure_series(report, name));
    let speed = |k: usize| (x[k].0, (cosine * x[k].1 - sine * y[k].1) / mass[k].1);
    (0..x.len().min(y.len()).min(mass.len())).map(speed).collect()
}

/// Displacement along the plane since gravity is complete (m), by the trapezoidal rule.
pub fn travelled_distance(report: &RunReport) -> f64 {
    let speeds = speeds_after_loading(report);
    speeds.windows(2).map(|pair| 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0)).sum()
}

/// Velocities along the plane since gravity is complete (m/s).
pub fn speeds_after_loading(report: &RunReport) -> Vec<(f64, f64)> {
    speed_series(report).into_iter().filter(|(time, _)| *time >= GRAVITY_END - 1e-9).collect()
}

/// Checks the acceleration of the block; `share` is the friction coefficient over the tangent of the slope angle.
fn judge(outcome: &mut BenchmarkOutcome, name: &str, report: &RunReport, share: f64) {
    let exact = gravity_along_plane() * (1.0 - share);
    let found = regression_slope(&speeds_after_loading(report));
    outcome.assert_within(
        format!("{name}: error of the acceleration over g sin θ"),
        &format!("g (sin θ - μ cos θ) = {exact:.4} m/s²"),
        (found - exact) / gravity_along_plane(),
        (-0.01, 0.01),
        "one cell is a twentieth of the length",
    );
}
