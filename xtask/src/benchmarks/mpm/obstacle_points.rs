//! Obstacles that act on points: a block on a plane of every form, and a disk in a bowl (sheet: mpm A-14).

use colluvium::case::description::{ObstacleShape, ObstacleWall};
use colluvium::case::{Case, RunReport};
use colluvium::plots::{LineChart, PointCloud, Series, Style};

use super::inclined_block::ANGLE;
use crate::analysis::{max_or_nan, regression_slope};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, measure_series, run_mpm, set_mpm_option};

/// Benchmark of obstacles that act on points: a block on planes, and a disk in a bowl.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/obstacle-points",
    title: "Obstacles that act on points: block on planes, disk in a bowl",
    source: "sheet: mpm A-14, closed form; energy",
    short_seconds: Some(35),
    full_seconds: 100,
    run: benchmark,
};

/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 9.81;
/// Time at which the block has settled (s).
const SETTLING_TIME: f64 = 1.0;

/// Checks the acceleration of a block on planes of every form, and a disk in a bowl.
fn benchmark(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let angles: &[f64] = if quick { &[10.0, 40.0] } else { &[10.0, 20.0, 30.0, 40.0] };
    for &angle in angles {
        for share in [0.0, 0.3, 0.6, 1.2] {
            judge(&mut outcome, "half-space in the plane", &in_plane(angle, share, None)?, angle, share)?;
        }
    }
    let tangent = ANGLE.to_radians().tan();
    let at = |x: f64| [x, 2.5 - x * tangent];
    let polygon = ObstacleShape::Polygon { vertices: vec![at(-1.0), at(6.0), [6.0, -3.0], [-1.0, -3.0]] };
    let file = |name: &str| {
        let path = crate::root().join("validation/mpm/inclined-block-space").join(name);
        path.to_string_lossy().into_owned()
    };
    let raster = ObstacleShape::Raster { file: file("plane.asc"), spacing: None };
    let wedge = ObstacleShape::Mesh { file: file("wedge.stl") };
    let shares: &[f64] = if quick { &[0.3] } else { &[0.0, 0.3, 0.6, 1.2] };
    for &share in shares {
        judge(&mut outcome, "polygon", &in_plane(ANGLE, share, Some(polygon.clone()))?, ANGLE, share)?;
        for (name, form) in
            [("half-space", None), ("raster", Some(raster.clone())), ("closed wedge", Some(wedge.clone()))]
        {
            judge(&mut outcome, name, &in_space(share, form)?, ANGLE, share)?;
        }
    }
    bowl(&mut outcome)?;
    Ok(outcome)
}

/// Sets the friction coefficient and, where given, another shape of the obstacle. The block settles under gravity with damping before the
/// undamped observation: with gravity applied in 0.2 s its rear edge lifts at 40°, and it hops down a plane on which it could rest.
fn friction(case: &mut Case, coefficient: f64, form: Option<ObstacleShape>) {
    let settling = &mut case.stages[0];
    (settling.duration, settling.damping) = (SETTLING_TIME, 0.7);
    let obstacle = &mut case.obstacles[0];
    obstacle.wall = ObstacleWall::Frictional { friction_coefficient: coefficient, adhesion: 0.0 };
    if let Some(form) = form {
        obstacle.shape = form;
    }
}

/// Case of the block in the plane. The plane falls by 30 degrees against the grid, and by `angle` against gravity.
fn in_plane(angle: f64, share: f64, form: Option<ObstacleShape>) -> Result<Case, String> {
    let mut case = load_case("mpm/inclined-block")?;
    set_mpm_option(&mut case, "obstacles", "points");
    let tilt = (ANGLE - angle).to_radians();
    case.gravity = vec![-GRAVITY * tilt.sin(), -GRAVITY * tilt.cos()];
    friction(&mut case, share * angle.to_radians().tan(), form);
    Ok(case)
}

/// Case of the block in space.
fn in_space(share: f64, form: Option<ObstacleShape>) -> Result<Case, String> {
    let mut case = load_case("mpm/inclined-block-space")?;
    friction(&mut case, share * ANGLE.to_radians().tan(), form);
    Ok(case)
}

/// Velocity of the centre of mass along the plane since the block has settled (m/s).
fn speeds(report: &RunReport, up: &str) -> Vec<(f64, f64)> {
    let (sine, cosine) = ANGLE.to_radians().sin_cos();
    let [x, z, mass] = ["momentum.x", up, "mass"].map(|name| measure_series(report, name));
    let all = x.iter().zip(&z).zip(&mass);
    let speeds = all.map(|((x, z), mass)| (x.0, (cosine * x.1 - sine * z.1) / mass.1));
    speeds.filter(|(time, _)| *time >= SETTLING_TIME - 1e-9).collect()
}

/// Checks the acceleration of a block that slides, or that a block with more friction stays at rest. `share` is the friction coefficient
/// over the tangent of the slope angle.
fn judge(
    outcome: &mut BenchmarkOutcome,
    form: &str,
    case: &Case,
    angle: f64,
    share: f64,
) -> Result<(), String> {
    let report = run_mpm(case)?;
    let name = format!("{form}, {angle}°, μ = {share} tan θ");
    let found = speeds(&report, if case.gravity.len() == 3 { "momentum.z" } else { "momentum.y" });
    if share > 1.0 {
        let displacement: f64 = found.windows(2).map(|p| 0.5 * (p[0].1 + p[1].1) * (p[1].0 - p[0].0)).sum();
        outcome.assert_below(
            format!("{name}: drift in 1 s over the length of the block"),
            "at rest",
            displacement.abs(),
            1e-3,
            "a thousandth of its length",
        );
        return Ok(());
    }
    let along = GRAVITY * angle.to_radians().sin();
    let exact = along * (1.0 - share);
    outcome.assert_within(
        format!("{name}: error of the acceleration over g sin θ"),
        &format!("g (sin θ - μ cos θ) = {exact:.4} m/s²"),
        (regression_slope(&found) - exact) / along,
        (-0.01, 0.01),
        "1 % of g sin θ; a cell is a twentieth of the length, in space a tenth",
    );
    Ok(())
}

/// Checks that a disk comes to rest in a bowl.
fn bowl(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let case = load_case("mpm/bowl")?;
    let report = run_mpm(&case)?;
    let standing = case.placed_obstacles::<2>().map_err(|error| error.to_string())?;
    let places = report.frames.iter().flat_map(|frame| &frame.positions);
    let depth = |x: &[f64; 3]| {
        let gap = standing[0].surface.gap(&[x[0], x[1]], f64::INFINITY);
        gap.map_or(0.0, |gap| -gap.distance)
    };
    outcome.assert_below(
        "bowl: largest depth of a point's centre under the surface (m)",
        "none",
        places.map(depth).fold(f64::NEG_INFINITY, max_or_nan),
        0.0,
        "none may be under it",
    );
    energies(outcome, &report)?;
    if let Some(cloud) = PointCloud::from_snapshot(&report.snapshot, "displacement", [0, 1]) {
        outcome.png("The disk at rest.", &cloud)?;
    }
    Ok(())
}

/// Checks the energy balance of the disk.
fn energies(outcome: &mut BenchmarkOutcome, report: &RunReport) -> Result<(), String> {
    let parts = [
        "kinetic_energy",
        "elastic_energy",
        "potential_energy",
        "obstacles.stored",
        "obstacles.friction",
        "obstacles.stopped",
    ];
    let parts = parts.map(|name| measure_series(report, name));
    let energy: Vec<(f64, f64)> =
        (0..parts[0].len()).map(|k| (parts[0][k].0, parts.iter().map(|part| part[k].1).sum())).collect();
    let fallen = parts[2].iter().map(|(_, e)| parts[2][0].1 - e).fold(0.0, max_or_nan);
    let mut smallest = f64::INFINITY;
    let mut rise = 0f64;
    for (_, energy) in &energy {
        smallest = smallest.min(*energy);
        rise = rise.max(energy - smallest);
    }
    outcome.assert_below(
        "bowl: largest rise of the total energy over the work of gravity",
        "none",
        rise / fallen,
        1e-3,
        "0.1 %: what springs and steps exchange",
    );
    outcome.assert_below(
        "bowl: kinetic energy at the end over the work of gravity",
        "at rest",
        report.end.kinetic / fallen,
        1e-4,
        "a hundredth of the largest velocity",
    );
    let mut chart = LineChart::new("Disk in a bowl", "time (s)", "energy over the work of gravity");
    for (name, part) in ["kinetic", "elastic", "potential", "springs", "friction"].into_iter().zip(&parts) {
        let base = if name == "potential" { part[0].1 } else { 0.0 };
        let line = part.iter().map(|(t, e)| (*t, (e - base) / fallen)).collect();
        chart.series.push(Series::new(name, line, Style::Line));
    }
    let line = energy.iter().map(|(t, e)| (*t, (e - energy[0].1) / fallen)).collect();
    chart.series.push(Series::new("total", line, Style::Dashed));
    outcome.svg("Energies of the disk.", &chart)?;
    Ok(())
}
