//! Block on an inclined plane (sheet: mpm A-14; sheet: sph §2.13), an obstacle, by all methods.

use colluvium::case::description::{ObstacleShape, ObstacleWall};
use colluvium::case::{Case, RunReport};
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use super::MethodComparison;
use crate::analysis::{MaxOrNan, regression_slope};
use crate::benchmarks::mpm::inclined_block::{
    ANGLE, GRAVITY_END, gravity_along_plane, speed_series, speeds_after_loading, travelled_distance,
};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, run_in_memory, set_method_option};

/// Benchmark of a block on an inclined obstacle, computed by all methods.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "compare/inclined-block",
    title: "Block on an inclined plane as an obstacle: MPM, SPH, DEM, snow MPM and depth-integrated flow",
    source: "closed form",
    short_seconds: Some(25),
    full_seconds: 60,
    run: benchmark,
};

/// Methods and their allowed errors of the acceleration over g sin θ.
const METHODS: [(&str, f64, &str); 4] = [
    ("mpm", 0.01, "1 % of g sin θ"),
    ("sph", 0.03, "3 % of g sin θ"),
    ("snow-mpm", 0.01, "1 % of g sin θ, as mpm"),
    ("dem", 0.01, "1 % of g sin θ: bonded disks that slide on their contacts"),
];

/// Checks the acceleration of a block on an inclined obstacle against that of a rigid block with Coulomb friction.
fn benchmark(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let tangent = ANGLE.to_radians().tan();
    let mut picture =
        LineChart::new("Velocity along a plane of 30°, friction of 0.3 tan θ", "time (s)", "velocity (m/s)");
    let mut together = MethodComparison::default();
    for (method, band, reason) in METHODS {
        // The rest of MPM is in mpm/inclined-block.
        let few = quick && method != "sph";
        for share in if few { &[0.3][..] } else { &[0.0, 0.3, 0.6] }.iter().copied() {
            let report = run_in_memory(method, &block(share * tangent, None)?)?;
            let exact = gravity_along_plane() * (1.0 - share);
            outcome.assert_within(
                format!("{method}, μ = {share} tan θ: error of the acceleration over g sin θ"),
                &format!("g (sin θ - μ cos θ) = {exact:.4} m/s²"),
                (regression_slope(&speeds_after_loading(&report)) - exact) / gravity_along_plane(),
                (-band, band),
                reason,
            );
            if share == 0.3 {
                if ["mpm", "sph"].contains(&method) {
                    forms(&mut outcome, method, &report)?;
                }
                picture.series.push(Series::new(method, speed_series(&report), Style::Line));
                together.add_run(method, &report);
            }
        }
        if few {
            continue;
        }
        let report = run_in_memory(method, &block(1.2 * tangent, None)?)?;
        outcome.assert_below(
            format!("{method}, μ = 1.2 tan θ: drift in 1 s over the length of the block"),
            "at rest",
            travelled_distance(&report).abs(),
            1e-3,
            "a thousandth of its length",
        );
    }
    flow(&mut outcome, &mut together)?;
    let exact = 0.7 * gravity_along_plane();
    let line = vec![(GRAVITY_END, 0.5 * GRAVITY_END * exact), (1.2, 1.1 * exact)];
    picture.series.push(Series::new("closed form", line, Style::Dashed));
    outcome.svg("Velocity of the centre of mass, μ = 0.3 tan θ.", &picture)?;
    together.write_sections(&mut outcome, &block(0.3 * tangent, None)?, "compare/inclined-block")?;
    Ok(outcome)
}

/// Checks the block computed as depth-integrated flow.
fn flow(outcome: &mut BenchmarkOutcome, together: &mut MethodComparison) -> Result<(), String> {
    let friction = 0.3 * ANGLE.to_radians().tan();
    let mut case = block(friction, None)?;
    let basal = json!({ "model": "coulomb", "friction_angle": friction.atan().to_degrees() });
    set_method_option(&mut case, "depth-sph", "basal", basal);
    let report = run_in_memory("depth-sph", &case)?;
    outcome.info(
        "depth-sph, μ = 0.3 tan θ: error of the acceleration over g sin θ",
        &format!("g (sin θ - μ cos θ) = {:.4} m/s²", 0.7 * gravity_along_plane()),
        (regression_slope(&speeds_after_loading(&report)) - 0.7 * gravity_along_plane()) / gravity_along_plane(),
        "not judged: a block half as high as long is outside of shallow flow, and without strength it slumps over twice its length",
    );
    together.add_run("depth-sph", &report);
    Ok(())
}

/// Checks that the plane has the same effect as a ground line and as a polygon.
fn forms(outcome: &mut BenchmarkOutcome, method: &str, plane: &RunReport) -> Result<(), String> {
    let tangent = ANGLE.to_radians().tan();
    let at = |x: f64| [x, 2.5 - x * tangent];
    for (name, form) in [
        ("ground line", ObstacleShape::GroundLine { points: vec![at(-1.0), at(6.0)], file: None }),
        ("polygon", ObstacleShape::Polygon { vertices: vec![at(-1.0), at(6.0), [6.0, -3.0], [-1.0, -3.0]] }),
    ] {
        let other = speed_series(&run_in_memory(method, &block(0.3 * tangent, Some(form))?)?);
        let apart = speed_series(plane).iter().zip(&other).map(|(a, b)| (a.1 - b.1).abs()).max_or_nan();
        outcome.assert_below(
            format!("{method}, {name} against half-space: largest difference of velocity (m/s)"),
            "the same plane",
            apart,
            1e-6,
            "round-off that grows",
        );
    }
    Ok(())
}

/// Case of a block on an obstacle with a friction coefficient and, where given, another shape.
fn block(friction: f64, form: Option<ObstacleShape>) -> Result<Case, String> {
    let mut case = load_case("compare/inclined-block")?;
    let obstacle = &mut case.obstacles[0];
    obstacle.wall = ObstacleWall::Frictional { friction_coefficient: friction, adhesion: 0.0 };
    if let Some(form) = form {
        obstacle.shape = form;
    }
    Ok(case)
}
